//! How good baked models must be.

use clangor_bake::modal::ModalBakeOptions;
use clangor_core::medium::Medium;

/// Effort for the sound models of bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// Fields that are in the cache, ellipsoids and spheres; coarse modes.
    Draft,
    /// Errors of about 1 %.
    #[default]
    Normal,
    /// Errors of about 0.2 %.
    High,
}

impl Quality {
    /// Error of the fields, relative to the loudest motion of the body \[-\].
    pub fn accuracy(self) -> f64 {
        if self == Quality::High { 0.002 } else { 0.01 }
    }

    /// Whether fields missing from the cache are baked.
    pub fn bakes_fields(self) -> bool {
        self != Quality::Draft
    }

    /// How modes are baked that radiate into `medium`, up to the end of the band \[Hz\].
    pub fn modal_options(self, medium: Medium, band: f64) -> ModalBakeOptions {
        let normal = ModalBakeOptions::new(medium);
        let max_frequency = normal.max_frequency.min(band);
        let (mesh_error, accuracy) = match self {
            Quality::Draft => (0.03, 0.05),
            Quality::Normal => (normal.mesh_error, normal.accuracy),
            Quality::High => (0.005, 0.002),
        };
        ModalBakeOptions { max_frequency, mesh_error, accuracy, ..normal }
    }
}
