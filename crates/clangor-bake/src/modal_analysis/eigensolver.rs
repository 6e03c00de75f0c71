//! Modes of a free body: the complete spectrum up to a frequency (Sturm count).
//!
//! ```text
//! K u = ω² M u,    uᵀM u = 1
//! ```
//!
//! The spectrum is cut into slices. At the ends of each, the factorisation of K − ω² M counts the modes below
//! (see `factor`). Between them, Lanczos iteration finds as many modes as counted (see `lanczos`), or fails.
//! The last count is at the upper limit, so the result is complete or an error.

mod factor;
mod lanczos;
mod lowest;
mod slices;

use std::f64::consts::TAU;

use glam::DVec3;

use crate::cost::work_limit::TooMuchWork;
use crate::fem::out_of_memory::OutOfMemory;
pub(crate) use lanczos::eigenvectors as symmetric_eigenvectors;
pub use lowest::lowest_frequency;
pub use slices::solve;
pub(super) use slices::solve_in;

/// A mode of a free body.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// Displacement of each node, with uᵀM u = 1 [kg^−½].
    pub shape: Vec<DVec3>,
}

/// All modes of a body up to a frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct Modes {
    /// The modes, by frequency.
    pub modes: Vec<Mode>,
    /// Upper limit of the search \[Hz\].
    pub max_frequency: f64,
    /// Largest ‖K u − ω² M u‖ / ‖ω² M u‖.
    pub residual: f64,
    /// Sturm counts: frequency \[Hz\] and number of modes below, without rigid motions.
    pub counts: Vec<(f64, usize)>,
    /// Number of solves of the iteration.
    pub solves: usize,
}

/// Reasons why modes cannot be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModalError {
    /// Invalid frequency limit.
    #[error("the highest frequency is {0} Hz, but must be positive")]
    Frequency(f64),
    /// The iteration found fewer modes than counted.
    #[error("only {found} of {expected} modes were found about {frequency:.1} Hz; nothing is returned")]
    Incomplete {
        /// How many converged.
        found: usize,
        /// Number of modes counted.
        expected: usize,
        /// Frequency of the count \[Hz\].
        frequency: f64,
    },
    /// The modes are not accurate enough.
    #[error(
        "the residual of a mode is {residual:.1e}: the limit is too far above the lowest mode, or elements \
         are too distorted"
    )]
    Inaccurate {
        /// ‖K u − ω² M u‖ / ‖ω² M u‖.
        residual: f64,
    },
    /// No modes in the band.
    #[error(
        "no audible modes: the first is at about {:.1} kHz, above the limit of {:.2} kHz",
        first * 1e-3,
        limit * 1e-3
    )]
    Silent {
        /// The lowest mode \[Hz\].
        first: f64,
        /// The limit \[Hz\].
        limit: f64,
    },
    /// The shift coincides with an eigenvalue.
    #[error(
        "the factorisation at {:.6e} 1/s² is singular: the elements are too distorted, or the mesh has \
         loose parts",
        shift
    )]
    Singular {
        /// σ [1/s²].
        shift: f64,
    },
    /// The number of rigid motions is not six.
    #[error("the mesh falls into parts that do not hang together")]
    LooseParts,
    /// More work than allowed.
    #[error(transparent)]
    TooLong(#[from] TooMuchWork),
    /// No memory for the factors.
    #[error("not enough memory for the factors of {unknowns} unknowns")]
    Memory {
        /// Number of unknowns.
        unknowns: usize,
    },
}

impl From<OutOfMemory> for ModalError {
    fn from(OutOfMemory { unknowns }: OutOfMemory) -> Self {
        ModalError::Memory { unknowns }
    }
}

/// √(ω²) / 2π.
fn frequency(square: f64) -> f64 {
    square.max(0.0).sqrt() / TAU
}

/// Uniform in [−½, ½). Source: SplitMix64, Steele, Lea, Flood (2014), "Fast splittable pseudorandom number
/// generators".
fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *seed;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
}
