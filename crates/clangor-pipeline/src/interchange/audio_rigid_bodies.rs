//! The glTF extension `KHR_audio_rigid_bodies`: modes, materials and masses of bodies beside their meshes.
//!
//! A public draft by Karl Hiner (<https://github.com/khiner/MeshEditor>, folder `glTF_PhysicalAudio`),
//! written and read after its text. It keeps of a mode what is heard and how fast it dies, we keep ω of the
//! body without losses:
//!
//! ```text
//! envelope e^{−d t},  d = ξ ω,  2π f = √(ω² − d²)
//! ```
//!
//! Shapes are ours, mass-normalised, at points of the surface with a triangulation. What the extension has no
//! place for stays in our own files: transfers, losses of other frequencies than those of the modes,
//! estimates of error. Its surfaces of rolling and scraping contacts are not read. docs/format/exchange.md
//! says what becomes of what.

mod fault;
mod importance;
mod json;
mod playing;
mod read;
mod write;

use std::f64::consts::TAU;

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::material::{Damping, Material};
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel};
use clangor_core::sound_model::modal::surface::ModalSurface;
use glam::{DMat3, DVec3};

pub use fault::{AudioFault, AudioFileError, AudioPlace};
pub use playing::{AudioUseError, Played, choose_body};
pub use read::read_audio_bodies;
pub use write::{AudioWriteError, write_audio_body};

/// Name of the extension.
pub const EXTENSION: &str = "KHR_audio_rigid_bodies";
/// Its name in older drafts, with other properties.
const OLDER_NAME: &str = "KHR_audio_modal";

/// A body of a file, in the frame of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct AudioBody {
    /// Name of its node.
    pub name: String,
    /// Its surface \[m\].
    pub mesh: TriMesh,
    /// What it is made of.
    pub material: AudioMaterial,
    /// Mass and inertia, if they are told.
    pub mass: Option<BodyMass>,
    /// How it rings, if that is told.
    pub ringing: Option<Ringing>,
    /// Factor that the file asks for on the body's sound.
    pub gain: f64,
    /// What a user should know of how it was read.
    pub remarks: Vec<String>,
}

/// An acoustic material; the extension lets each number be absent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AudioMaterial {
    /// Name.
    pub name: Option<String>,
    /// Density ρ \[kg/m³\].
    pub density: Option<f64>,
    /// Young's modulus E \[Pa\].
    pub youngs_modulus: Option<f64>,
    /// Poisson's ratio ν \[-\].
    pub poisson_ratio: Option<f64>,
    /// Damping α of the mass [1/s]: d = (α + β ω²)/2.
    pub alpha: Option<f64>,
    /// Damping β of the stiffness \[s\].
    pub beta: Option<f64>,
}

/// Mass properties of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyMass {
    /// Mass \[kg\].
    pub mass: f64,
    /// Centre of mass \[m\].
    pub centre_of_mass: DVec3,
    /// Inertia about it \[kg m²\]; zero where it is not told.
    pub inertia: DMat3,
}

/// How a body rings.
#[derive(Clone, Debug, PartialEq)]
pub struct Ringing {
    /// Where shapes are given \[m\].
    pub surface: ModalSurface,
    /// The modes, by frequency.
    pub modes: Vec<RingingMode>,
    /// There are no other modes below this \[Hz\]; `None` if nothing says so.
    pub max_frequency: Option<f64>,
}

/// A mode with its decay.
#[derive(Clone, Debug, PartialEq)]
pub struct RingingMode {
    /// ω/2π without damping \[Hz\].
    pub frequency: f64,
    /// d, by which the amplitude decays [1/s].
    pub decay_rate: f64,
    /// U at the nodes of the surface [kg^−½].
    pub shape: Vec<DVec3>,
}

impl BodyMass {
    /// Those of a solid of this density [kg/m³].
    pub fn of_solid(mass: &MassProperties, density: f64) -> Self {
        BodyMass {
            mass: density * mass.volume,
            centre_of_mass: mass.centre_of_mass,
            inertia: mass.inertia * density,
        }
    }
}

impl Ringing {
    /// Makes it that of the body `factor` times as large, without moving the surface: ω/γ, U γ^(−3/2), and d
    /// from ω where the material says how.
    fn resize(&mut self, factor: f64, material: &AudioMaterial) {
        for mode in &mut self.modes {
            mode.frequency /= factor;
            mode.shape.iter_mut().for_each(|u| *u *= factor.powf(-1.5));
            if material.alpha.or(material.beta).is_some() {
                let stiffness = material.beta.unwrap_or(0.0) * (TAU * mode.frequency).powi(2);
                mode.decay_rate = 0.5 * (material.alpha.unwrap_or(0.0) + stiffness);
            }
        }
        self.max_frequency = self.max_frequency.map(|f| f / factor);
    }

    /// That of a model with this damping, in the model's own frame; without synthetic modes, which do not
    /// radiate by their shapes.
    pub fn of_model(model: &ModalModel, damping: &Damping) -> Self {
        let mode = |mode: &ModalMode| RingingMode {
            frequency: mode.frequency,
            decay_rate: damping.damping_ratio(mode.frequency) * TAU * mode.frequency
                + 0.5 * mode.support_damping,
            shape: mode.shape.clone(),
        };
        Ringing {
            surface: model.surface.clone(),
            modes: model.known_modes().iter().map(mode).collect(),
            max_frequency: Some(model.statistical_above.unwrap_or(model.max_frequency)),
        }
    }
}

impl AudioMaterial {
    /// What the extension can say of a material: damping if it is Rayleigh's without more.
    pub fn of(material: &Material) -> Self {
        let (alpha, beta) = match material.damping {
            Damping::Rayleigh { alpha, beta, g: 0.0 } => (Some(alpha), Some(beta)),
            _ => (None, None),
        };
        AudioMaterial {
            name: Some(material.name.clone()),
            density: Some(material.density),
            youngs_modulus: Some(material.youngs_modulus),
            poisson_ratio: Some(material.poisson_ratio),
            alpha,
            beta,
        }
    }
}
