//! Unknowns of a thin wall of one element across: its mean motion, its turning and its bulging, in place of
//! the displacements of its three levels.
//!
//! ```text
//! u(ζ) = c₁ + c₀ ζ + c₂ (1 − ζ²),    ζ = −1 … 1 across the wall
//! u(−1) = c₁ − c₀,    u(0) = c₁ + c₂,    u(1) = c₁ + c₀
//! ```
//!
//! The space is the same. With displacements as unknowns, bending is a small difference of forces E/h that
//! grow as the wall gets thin: (h/L)⁴ of them for a wave of length L, which is below the rounding errors
//! for a sheet of 1 m and 0.5 mm. With these unknowns only its shear is much stiffer, by (L/h)².

use glam::DVec3;

/// What the unknowns of a system are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknowns {
    /// Displacements at the nodes, as supports need them.
    AtNodes,
    /// Those of the module across walls of one element, displacements elsewhere.
    AcrossWalls,
}

/// Nodes across walls: lower face, middle, upper face. Their unknowns are c₀, c₁, c₂.
#[derive(Clone, Debug, Default)]
pub(crate) struct Columns(pub(crate) Vec<[u32; 3]>);

impl Columns {
    /// Displacements of all nodes from the unknowns, in place.
    pub(super) fn to_displacements(&self, motion: &mut [DVec3]) {
        for column in &self.0 {
            let [turn, mean, bulge] = column.map(|n| motion[n as usize]);
            let displaced = [mean - turn, mean + bulge, mean + turn];
            column.iter().zip(displaced).for_each(|(n, u)| motion[*n as usize] = u);
        }
    }

    /// The unknowns of displacements, in place.
    pub(super) fn take_displacements(&self, motion: &mut [DVec3]) {
        for column in &self.0 {
            let [low, middle, high] = column.map(|n| motion[n as usize]);
            let mean = 0.5 * (low + high);
            let unknowns = [0.5 * (high - low), mean, middle - mean];
            column.iter().zip(unknowns).for_each(|(n, u)| motion[*n as usize] = u);
        }
    }
}

/// Value and slope over [0, 1] of the function of unknown `i`: ζ, 1 or 1 − ζ².
pub(super) fn function(i: usize, x: f64) -> (f64, f64) {
    let zeta = 2.0 * x - 1.0;
    match i {
        0 => (zeta, 2.0),
        1 => (1.0, 0.0),
        _ => (1.0 - zeta * zeta, -4.0 * zeta),
    }
}
