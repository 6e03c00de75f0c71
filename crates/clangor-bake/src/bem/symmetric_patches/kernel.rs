//! The two boundary kernels at several wavenumbers, eight source points at a time.
//!
//! With d = y − x, r = |d|, s = ik and G = e^{−sr}/(4πr),
//!
//! ```text
//! ∂G/∂n_y dA = −(s + 1/r) G (d·n dA)/r      double layer, wanted at each point
//! Σ G g_i dA                                 single layer of the six motions, wanted as a sum
//! ```
//!
//! Plain loops over arrays of fixed length: called inside `pulp::Arch::dispatch`, they become vector
//! instructions.

#![allow(
    clippy::needless_range_loop,
    reason = "loops over lanes, several arrays at one index, that become vector instructions"
)]

use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;
use num_complex::Complex64;

/// Points that go through the kernels at once.
pub(super) const LANES: usize = 8;

type Lane = [f64; LANES];

/// Source points, in blocks of [`LANES`].
#[derive(Clone, Debug, Default)]
pub(super) struct Sources {
    blocks: Vec<Block>,
    count: usize,
}

/// Positions and normals times area. Unused places have no area.
#[derive(Clone, Copy, Debug)]
struct Block {
    position: [Lane; 3],
    area: [Lane; 3],
}

/// A position far from every body, so that 1/r stays finite.
const NOWHERE: Block = Block { position: [[1e3; LANES]; 3], area: [[0.0; LANES]; 3] };

impl Sources {
    /// Removes all points.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.blocks.clear();
        self.count = 0;
    }

    /// Adds a point: position, normal times area.
    #[inline(always)]
    pub(super) fn push(&mut self, position: DVec3, area: DVec3) {
        let lane = self.count % LANES;
        if lane == 0 {
            self.blocks.push(NOWHERE);
        }
        self.count += 1;
        if let Some(block) = self.blocks.last_mut() {
            for (axis, (x, n)) in position.to_array().into_iter().zip(area.to_array()).enumerate() {
                block.position[axis][lane] = x;
                block.area[axis][lane] = n;
            }
        }
    }
}

/// s at the wavenumbers of a pass, [1/m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wavenumbers<const F: usize> {
    /// Re s = −Im k.
    pub(super) growth: [f64; F],
    /// Im s = Re k.
    pub(super) wave: [f64; F],
}

/// Double layer at a point: real parts at the wavenumbers, then imaginary parts.
pub(super) type Values<const F: usize> = [[f64; F]; 2];

/// Sums of the single layer over points, kept apart by lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct SingleLayer<const F: usize> {
    sums: [[[Lane; RIGID_DOFS]; 2]; F],
}

impl<const F: usize> SingleLayer<F> {
    pub(super) const ZERO: Self = SingleLayer { sums: [[[[0.0; LANES]; RIGID_DOFS]; 2]; F] };

    /// The sum of a motion at wavenumber `f`.
    #[inline(always)]
    pub(super) fn sum(&self, f: usize, degree: usize) -> Complex64 {
        let total = |lane: &Lane| lane.iter().sum::<f64>();
        Complex64::new(total(&self.sums[f][0][degree]), total(&self.sums[f][1][degree]))
    }
}

/// The double layer at all points seen from `target`, and the single layer added to `single`. `double` is
/// filled up to a multiple of [`LANES`].
#[inline(always)]
pub(super) fn layers<const F: usize>(
    target: DVec3,
    sources: &Sources,
    wavenumbers: &Wavenumbers<F>,
    double: &mut Vec<Values<F>>,
    single: &mut SingleLayer<F>,
) {
    double.clear();
    for block in &sources.blocks {
        let start = double.len();
        double.resize(start + LANES, [[0.0; F]; 2]);
        layers_of_block(target, block, wavenumbers, &mut double[start..start + LANES], single);
    }
}

#[inline(always)]
fn layers_of_block<const F: usize>(
    target: DVec3,
    block: &Block,
    wavenumbers: &Wavenumbers<F>,
    double: &mut [Values<F>],
    single: &mut SingleLayer<F>,
) {
    let [x, y, z] = &block.position;
    let [nx, ny, nz] = &block.area;
    let (mut distance, mut inverse) = ([0.0; LANES], [0.0; LANES]);
    let (mut static_single, mut slope) = ([0.0; LANES], [0.0; LANES]);
    let mut motions = [[0.0; LANES]; RIGID_DOFS];
    // Distances, static kernel, normal slope and boundary values of the six motions.
    for l in 0..LANES {
        let (dx, dy, dz) = (x[l] - target.x, y[l] - target.y, z[l] - target.z);
        distance[l] = dx.mul_add(dx, dy.mul_add(dy, dz * dz)).sqrt();
        inverse[l] = 1.0 / distance[l];
        static_single[l] = inverse[l] * (0.25 / std::f64::consts::PI);
        slope[l] = -dx.mul_add(nx[l], dy.mul_add(ny[l], dz * nz[l])) * inverse[l];
        motions[0][l] = nx[l];
        motions[1][l] = ny[l];
        motions[2][l] = nz[l];
        motions[3][l] = y[l].mul_add(nz[l], -(z[l] * ny[l]));
        motions[4][l] = z[l].mul_add(nx[l], -(x[l] * nz[l]));
        motions[5][l] = x[l].mul_add(ny[l], -(y[l] * nx[l]));
    }
    // Kernels at each wavenumber.
    for f in 0..F {
        let (s_re, s_im) = (wavenumbers.growth[f], wavenumbers.wave[f]);
        let (mut g_re, mut g_im) = ([0.0; LANES], [0.0; LANES]);
        let (mut d_re, mut d_im) = ([0.0; LANES], [0.0; LANES]);
        // Single layer G = e^{−sr}/(4πr), and double layer −(s + 1/r) G (d·n)/r.
        for l in 0..LANES {
            let (cos, sin) = cos_sin(s_im * distance[l]);
            let size = static_single[l] * decay(s_re * distance[l]);
            g_re[l] = size * cos;
            g_im[l] = -size * sin;
            let (a, b) = ((s_re + inverse[l]) * slope[l], s_im * slope[l]);
            d_re[l] = a.mul_add(g_re[l], -(b * g_im[l]));
            d_im[l] = a.mul_add(g_im[l], b * g_re[l]);
        }
        // Sums of the single layer with the six motions.
        for (degree, motion) in motions.iter().enumerate() {
            for l in 0..LANES {
                single.sums[f][0][degree][l] = g_re[l].mul_add(motion[l], single.sums[f][0][degree][l]);
                single.sums[f][1][degree][l] = g_im[l].mul_add(motion[l], single.sums[f][1][degree][l]);
            }
        }
        // Double layer at each point.
        for l in 0..LANES {
            double[l][0][f] = d_re[l];
            double[l][1][f] = d_im[l];
        }
    }
}

/// cos x and sin x for |x| < 1e6, to 1e-13: Taylor's series of a quarter of the reduced angle, doubled twice.
#[inline(always)]
fn cos_sin(x: f64) -> (f64, f64) {
    use std::f64::consts::TAU;
    // Adding and subtracting 1.5·2⁵² rounds to the nearest integer.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    let turns = x.mul_add(1.0 / TAU, ROUND) - ROUND;
    let a = 0.25 * turns.mul_add(-TAU, x);
    let q = a * a;
    let sin =
        a * series(q, [-1.0 / 39_916_800.0, 1.0 / 362_880.0, -1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0, 1.0]);
    // 1 − cos of the quarter angle, which loses no digits when doubled.
    let versine = -q
        * series(
            q,
            [1.0 / 479_001_600.0, -1.0 / 3_628_800.0, 1.0 / 40_320.0, -1.0 / 720.0, 1.0 / 24.0, -0.5],
        );
    let cos = 1.0 - versine;
    let (cos, sin) = ((-2.0 * sin).mul_add(sin, 1.0), 2.0 * sin * cos);
    ((-2.0 * sin).mul_add(sin, 1.0), 2.0 * sin * cos)
}

/// e^{−x} for 0 ≤ x ≤ 1, to 1e-12: Taylor's series about 1/2.
#[inline(always)]
fn decay(x: f64) -> f64 {
    const MIDDLE: f64 = 0.606_530_659_712_633_4;
    let t = 0.5 - x;
    MIDDLE
        * series(
            t,
            [
                1.0 / 362_880.0,
                1.0 / 40_320.0,
                1.0 / 5040.0,
                1.0 / 720.0,
                1.0 / 120.0,
                1.0 / 24.0,
                1.0 / 6.0,
                0.5,
                1.0,
                1.0,
            ],
        )
}

/// Horner's rule, highest power first.
#[inline(always)]
fn series<const N: usize>(x: f64, coefficients: [f64; N]) -> f64 {
    let mut sum = 0.0;
    for c in coefficients {
        sum = x.mul_add(sum, c);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elementary_functions() {
        for k in 0..4000 {
            let x = 0.05 * f64::from(k) - 100.0;
            let (cos, sin) = cos_sin(x);
            // Residual seen: 3e-13.
            assert!((cos - x.cos()).abs() < 1e-10 && (sin - x.sin()).abs() < 1e-10, "{x} {cos} {sin}");
            let x = f64::from(k) / 4000.0;
            // Residual seen: 2e-10 at the ends.
            assert!((decay(x) / (-x).exp() - 1.0).abs() < 1e-9, "{x}");
        }
    }

    #[test]
    fn layers_are_the_kernels() {
        let (x, y, n) = (DVec3::new(0.1, -0.4, 0.2), DVec3::new(0.8, 0.3, -0.5), DVec3::new(0.2, 0.5, -0.1));
        let s = [Complex64::new(0.2, 3.0), Complex64::new(0.01, 0.1)];
        let wavenumbers = Wavenumbers { growth: s.map(|s| s.re), wave: s.map(|s| s.im) };
        let mut sources = Sources::default();
        sources.push(y, n);
        let (mut double, mut single) = (Vec::new(), SingleLayer::ZERO);
        layers(x, &sources, &wavenumbers, &mut double, &mut single);
        for f in 0..2 {
            let r = y.distance(x);
            let green = (-s[f] * r).exp() / (4.0 * std::f64::consts::PI * r);
            let slope = -(s[f] + 1.0 / r) * green * ((y - x).dot(n) / r);
            // Residual seen: 4e-13.
            assert!((Complex64::new(double[0][0][f], double[0][1][f]) - slope).norm() < 1e-10);
            for (degree, motion) in crate::radiation::rigid_motions(y, n).into_iter().enumerate() {
                assert!((single.sum(f, degree) - green * motion).norm() < 1e-10);
            }
        }
    }
}
