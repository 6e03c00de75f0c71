//! The pressure field of an accelerated rigid body: six degrees of freedom, every frequency of a band, every
//! point outside.
//!
//! With R the bounding radius of the body about its centre of mass, x the position over R, s = iκ = ikR, unit
//! directions and accelerations a = (a₁, a₂, a₃) [m/s²], α = (α₁, α₂, α₃) [rad/s²] in the axes of the body,
//! the pressure is
//!
//! ```text
//! p(x) = ρ R e^{−s|x|} Σ_n g_n(s, |x|) Σ_m Y_nm(x/|x|) Σ_i z_i Q^i_nm(s),    z = (a, R α)
//! g_n(s, x) = x^{−(n+1)} θₙ(s x)/θₙ(s),   g_0 = s²/x
//! ```
//!
//! Each term is an exact outgoing wave, so the near field and the far field have the accuracy of the
//! coefficients. The coefficients Q are dimensionless and depend on the shape and s only: a body twice as
//! large has the same field at half the frequency (\[PROXY\] eq. (10)). A rigid motion displaces no net
//! volume, so the monopole is of second order in s. g_0 carries this factor, which keeps the far field
//! accurate at low frequency.
//!
//! In frequency Q is rational, in the barycentric form of Nakatsukasa, Sète and Trefethen (2018): a few nodes
//! s_j, mirrored by conj(s_j), with weights w_j, the same for all coefficients:
//!
//! ```text
//! Q(s) = Σ_j [ w_j Q_j/(s − s_j) + conj(w_j Q_j)/(s − conj s_j) ]
//!        / Σ_j [ w_j/(s − s_j) + conj(w_j)/(s − conj s_j) ]
//! ```
//!
//! Interpolation commutes with linear operations: a click interpolates the pressure at the listener without
//! e^{−s|x|}, from its values at the nodes.

use glam::DVec3;
use num_complex::Complex64;

use crate::math::radial::outgoing;
use crate::math::spherical_harmonics::solid_harmonics;

/// Degrees of freedom of a rigid body: translations along x, y, z, then rotations about them.
pub const RIGID_DOFS: usize = 6;

/// A node of the interpolation in frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// s_j = i k_j R.
    pub s: Complex64,
    /// w_j.
    pub weight: Complex64,
}

/// Indices of the coefficient of a row of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Term {
    /// n.
    pub n: u8,
    /// m, from −n to n.
    pub m: i8,
    /// i: 0–2 translation along x, y, z, 3–5 rotation about x, y, z.
    pub degree: u8,
}

/// Field of a shape; see the module.
#[derive(Clone, Debug, PartialEq)]
pub struct AccelerationField {
    /// Highest κ = kR of the field.
    pub max_wavenumber: f64,
    /// Time, in R/c, after which the sound of a sudden acceleration has fallen by 100 dB, counted from the
    /// passing of a wave from the centre of mass.
    pub ring_time: f64,
    /// Nodes in frequency.
    pub nodes: Vec<Node>,
    /// Indices of the coefficients, in ascending order; all others are zero.
    pub terms: Vec<Term>,
    /// Real parts of Q: for each term, its values at the nodes.
    pub real: Vec<f32>,
    /// Imaginary parts of Q.
    pub imaginary: Vec<f32>,
}

impl AccelerationField {
    /// Highest n of any term.
    pub fn order(&self) -> usize {
        self.terms.last().map_or(0, |t| usize::from(t.n))
    }

    /// p e^{s|x|}/(ρ R) at every node, for z = (a, R α), at `x` in units of R.
    pub fn at_nodes(&self, z: &[f64; RIGID_DOFS], x: DVec3) -> Vec<Complex64> {
        let count = self.nodes.len();
        let order = self.order();
        let distance = x.length();
        let mut harmonics = Vec::new();
        solid_harmonics(x / distance, order, &mut harmonics);
        let mut sums = vec![Complex64::ZERO; (order + 1) * count];
        for (row, term) in self.terms.iter().enumerate() {
            let n = usize::from(term.n);
            let y = harmonics[crate::math::spherical_harmonics::index(n, isize::from(term.m))];
            let factor = z[usize::from(term.degree)] * y;
            for j in 0..count {
                let at = row * count + j;
                sums[n * count + j] +=
                    factor * Complex64::new(f64::from(self.real[at]), f64::from(self.imaginary[at]));
            }
        }
        let mut radial = Vec::new();
        (0..count)
            .map(|j| {
                let s = self.nodes[j].s;
                outgoing(s, distance, order, &mut radial);
                // The monopole's factor, which is not part of the coefficient.
                radial[0] *= s * s;
                (0..=order).map(|n| radial[n] * sums[n * count + j]).sum()
            })
            .collect()
    }

    /// Interpolation to `s` of the given `values` at the nodes.
    pub fn interpolate(&self, s: Complex64, values: &[Complex64]) -> Complex64 {
        let (mut above, mut below) = (Complex64::ZERO, Complex64::ZERO);
        for (node, value) in self.nodes.iter().zip(values) {
            for (s_j, w, q) in
                [(node.s, node.weight, *value), (node.s.conj(), node.weight.conj(), value.conj())]
            {
                let gap = s - s_j;
                if gap.norm_sqr() < 1e-28 * (1.0 + s.norm_sqr()) {
                    return q;
                }
                above += w * q / gap;
                below += w / gap;
            }
        }
        above / below
    }

    /// p/ρ [m²/s² · m⁻¹·R] at `x` (in units of R) for κ = `wavenumber`: multiply by ρ R for pascals. It
    /// includes the phase e^{−iκ|x|}.
    pub fn pressure(&self, z: &[f64; RIGID_DOFS], x: DVec3, wavenumber: f64) -> Complex64 {
        let s = Complex64::new(0.0, wavenumber);
        (-s * x.length()).exp() * self.interpolate(s, &self.at_nodes(z, x))
    }
}
