//! Linear elasticity of a homogeneous isotropic body: stiffness and mass of a mesh of quadratic tetrahedra.
//!
//! ```text
//! K u = ω² M u,    uᵀK u = ∫ λ (div u)² + 2 μ |ε(u)|² dV,    uᵀM u = ∫ ρ |u|² dV
//! ε(u) = ½ (∇u + ∇uᵀ),    λ = E ν / ((1 + ν)(1 − 2ν)),    μ = E / (2 (1 + ν))
//! ```
//!
//! The body is free, so K has six rigid motions of zero energy. The mass is consistent: it uses the shape
//! functions of the stiffness. Frequencies then converge from above as h⁴.
//!
//! Linear tetrahedra are deliberately absent: a thin plate needs a thousand times as many of them.

pub mod across_walls;
pub mod bricks;
pub mod element;
pub(crate) mod elimination;
pub mod finite_cells;
pub mod lamb_sphere;
pub(crate) mod ordering;
pub(crate) mod out_of_memory;
pub(crate) mod prisms;
mod products;
mod rigid_motions;
pub mod supports;
mod system;
mod vertex_cover;

use clangor_core::material::Material;

pub use system::ElasticSystem;
pub(crate) use system::Elements;

/// Elastic constants of a homogeneous isotropic material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElasticConstants {
    /// λ \[Pa\].
    pub lame_lambda: f64,
    /// Shear modulus μ \[Pa\].
    pub shear_modulus: f64,
    /// ρ \[kg/m³\].
    pub density: f64,
}

/// Material constants outside the physical range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ElasticError {
    /// Density out of range.
    #[error("the density is {0} kg/m³, but must be positive")]
    Density(f64),
    /// Stiffness out of range.
    #[error("Young's modulus is {0} Pa, but must be positive")]
    Stiffness(f64),
    /// Poisson's ratio out of range.
    #[error("Poisson's ratio is {0}, but must lie between -1 and 0.5, both excluded")]
    PoissonRatio(f64),
}

impl ElasticConstants {
    /// The constants of a material.
    ///
    /// # Errors
    /// [`ElasticError`] for values outside the physical range.
    pub fn of(material: &Material) -> Result<Self, ElasticError> {
        let Material { density, youngs_modulus: e, poisson_ratio: nu, .. } = *material;
        if !(density > 0.0 && density.is_finite()) {
            return Err(ElasticError::Density(density));
        }
        if !(e > 0.0 && e.is_finite()) {
            return Err(ElasticError::Stiffness(e));
        }
        if !(nu > -1.0 && nu < 0.5) {
            return Err(ElasticError::PoissonRatio(nu));
        }
        Ok(ElasticConstants {
            lame_lambda: e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
            shear_modulus: e / (2.0 * (1.0 + nu)),
            density,
        })
    }

    /// E \[Pa\].
    pub(crate) fn youngs_modulus(&self) -> f64 {
        let ElasticConstants { lame_lambda: lambda, shear_modulus: mu, .. } = *self;
        mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu)
    }
}
