//! The regular grid of cells and its time step: indices of cells, Courant number, and the dispersion that
//! ties wavenumbers to frequencies.
//!
//! ```text
//! sin(ωΔt/2) = λ sin(kh/2),    λ = c Δt/h
//! ```
//!
//! It holds for plane waves of any direction up to (kh)⁶ with the Laplacian of [`super::grid`].

use num_complex::Complex64;

/// λ = c Δt/h. Below 1/√3, so that cells near a body have volume to spare.
pub(super) const COURANT: f64 = 0.5;

/// λ², the factor of the Laplacian in a time step.
pub(super) const SQUARE: f32 = (COURANT * COURANT) as f32;

/// Initial pressure of all cells, and that of the rim at all times. It keeps decaying remainders out of the
/// subnormal numbers, which are slow.
pub(super) const GROUND: f32 = 1e-20;

/// Cells of images beyond a mirror plane: as many as the recorder reaches.
pub(super) const GHOSTS: usize = 3;

/// The cells of a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Lattice {
    /// Cells along each axis.
    pub(super) size: [usize; 3],
    /// Axes at whose lower end is a mirror plane, with [images](super::mirrors) beyond it, and no absorbing
    /// layer.
    pub(super) mirrored: [bool; 3],
}

impl Lattice {
    /// Number of cells.
    pub(super) fn cells(&self) -> usize {
        self.size.iter().product()
    }

    /// Difference of the indices of neighbours along each axis.
    pub(super) fn strides(&self) -> [usize; 3] {
        [1, self.size[0], self.size[0] * self.size[1]]
    }

    /// Index of a cell, x fastest.
    pub(super) fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.size[1] + j) * self.size[0] + i
    }
}

/// ωΔt of a plane wave with kh = `wavenumber`.
pub(super) fn phase_per_step(wavenumber: Complex64) -> Complex64 {
    2.0 * (COURANT * (0.5 * wavenumber).sin()).asin()
}

/// kh of a plane wave with ωΔt = `phase`.
pub(super) fn wavenumber_of(phase: Complex64) -> Complex64 {
    2.0 * ((0.5 * phase).sin() / COURANT).asin()
}
