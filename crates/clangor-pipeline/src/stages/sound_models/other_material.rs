//! Given modes whose elastic constants are not those of the body that is to have them.

use std::fmt;

use clangor_core::material::Material;
use clangor_core::sound_model::files::modal_file::{ModalOrigin, ModalPart};

/// Relative difference of elastic constants that writing and reading may cause.
const SAME_CONSTANT: f64 = 1e-6;

/// Modes that were baked for another material than that of the body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OtherMaterial {
    /// Material of the modes.
    pub modes: String,
    /// Material of the body.
    pub body: String,
}

impl OtherMaterial {
    /// Compares Young's modulus, Poisson's ratio and density; `None` where they agree.
    pub fn find(material: &Material, modes: &ModalPart) -> Option<Self> {
        let ModalOrigin { youngs_modulus, poisson_ratio, .. } = modes.origin;
        let pairs = [
            (material.youngs_modulus, youngs_modulus),
            (material.poisson_ratio, poisson_ratio),
            (material.density, modes.model.density),
        ];
        let differ = pairs.iter().any(|(a, b)| (a - b).abs() > SAME_CONSTANT * b.abs());
        differ.then(|| OtherMaterial { modes: modes.origin.material.clone(), body: material.name.clone() })
    }
}

impl fmt::Display for OtherMaterial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the modes are those of {}, and ring so, whatever the stiffness of {}; its damping is used",
            self.modes, self.body
        )
    }
}
