//! The transfer of a mode whose power is known and whose phases are not: a random field.
//!
//! A wave that is faster than sound, μ = k_s/k < 1, leaves the surface at sin θ = μ from the normal; a slower
//! one is heard from edges, in all directions alike. The mean intensity is that of all faces,
//!
//! ```text
//! I(d) = Σ_faces A g(n·d)    g = e^{−(sin θ − μ)²/2w²} for n·d > 0, of mean 1    w = max(0.1, 1/(k √A))
//! ```
//!
//! and the field that of independent complex normal numbers z_q √I(d_q) in directions d_q, of the orders up
//! to n̄; scaled, so that the power is exact:
//!
//! ```text
//! c_nm = s γ_n^{−1/2} Σ_q z_q √I(d_q) Y_nm(d_q)     γ_n = κ^{2n}/|θ_n(iκ)|²     n̄ = min(⌈κ⌉, 12)
//! ```
//!
//! Real fields have orders up to kR. A lower order makes lobes wider, 15° at least, and leaves their
//! statistics: in one direction the intensity of a mode is distributed exponentially about its mean. Faces do
//! not obstruct each other.

use clangor_core::math::radial::reverse_bessel;
use clangor_core::math::random::SplitMix;
use clangor_core::math::spherical_harmonics::solid_harmonics;
use clangor_core::sound_model::modal::model::ModalTransfer;
use clangor_core::sound_model::modal::surface::ModalSurface;
use glam::DVec3;
use num_complex::Complex64;

use super::random_numbers::normal_pair;

/// Highest order.
const HIGHEST_ORDER: usize = 12;
/// Directions d_q, and faces that stand for the surface.
const DIRECTIONS: usize = 500;
const FACES: usize = 400;
/// Least w.
const NARROWEST: f64 = 0.1;

/// Directions in which a surface may be heard.
pub(super) struct HeardDirections {
    directions: Vec<DVec3>,
    /// Y_nm of each.
    harmonics: Vec<Vec<f64>>,
    /// Normals of equal areas.
    normals: Vec<DVec3>,
    /// √A of the surface \[m\].
    size: f64,
}

impl HeardDirections {
    pub(super) fn new(surface: &ModalSurface) -> Self {
        let mesh = surface.quarters();
        let vectors: Vec<DVec3> = (0..mesh.triangles.len()).map(|t| mesh.area_vector(t)).collect();
        let total: f64 = vectors.iter().map(|v| v.length()).sum();
        // The middles of equal areas, in the order of the triangles.
        let (mut normals, mut sum) = (Vec::with_capacity(FACES), 0.0);
        for vector in &vectors {
            sum += vector.length() / total * FACES as f64;
            while (normals.len() as f64) + 0.5 < sum {
                normals.push(vector.normalize_or_zero());
            }
        }
        let directions: Vec<DVec3> = (0..DIRECTIONS).map(even_direction).collect();
        let harmonics = directions.iter().map(|direction| {
            let mut values = Vec::new();
            solid_harmonics(*direction, HIGHEST_ORDER, &mut values);
            values
        });
        HeardDirections { harmonics: harmonics.collect(), directions, normals, size: mesh.area().sqrt() }
    }

    /// √I in every direction, for waves of μ = `slowness` and k = `wavenumber` [1/m].
    pub(super) fn amplitudes(&self, slowness: f64, wavenumber: f64) -> Vec<f64> {
        if slowness >= 1.0 || self.normals.is_empty() {
            return vec![1.0; self.directions.len()];
        }
        let width = (wavenumber * self.size).recip().max(NARROWEST);
        let part = |cosine: f64| {
            let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
            if cosine > 0.0 { (-0.5 * ((sine - slowness) / width).powi(2)).exp() } else { 0.0 }
        };
        let intensity = |direction: &DVec3| self.normals.iter().map(|n| part(n.dot(*direction))).sum::<f64>();
        self.directions.iter().map(|direction| intensity(direction).sqrt()).collect()
    }

    /// A transfer of κ = `wavenumber` with `power`, in the unit of [`ModalTransfer::power`], and √I =
    /// `amplitudes`.
    pub(super) fn transfer(
        &self,
        wavenumber: f64,
        power: f64,
        amplitudes: &[f64],
        random: &mut SplitMix,
    ) -> ModalTransfer {
        let order = (wavenumber.ceil() as usize).clamp(1, HIGHEST_ORDER);
        let mut coefficients = vec![Complex64::ZERO; (order + 1).pow(2)];
        for (amplitude, harmonics) in amplitudes.iter().zip(&self.harmonics) {
            let [re, im] = normal_pair(random);
            let sent = Complex64::new(re, im) * amplitude;
            coefficients.iter_mut().zip(harmonics).for_each(|(c, y)| *c += sent * y);
        }
        let mut polynomials = Vec::new();
        reverse_bessel(Complex64::new(0.0, wavenumber), order, &mut polynomials);
        for (n, polynomial) in polynomials.iter().enumerate() {
            let near = polynomial.norm() / wavenumber.powi(n as i32);
            coefficients[n * n..(n + 1) * (n + 1)].iter_mut().for_each(|c| *c *= near);
        }
        let mut transfer = ModalTransfer { order, coefficients };
        let scale = (power / transfer.power(wavenumber)).sqrt();
        transfer.coefficients.iter_mut().for_each(|c| *c *= scale);
        transfer
    }
}

/// The q-th of [`DIRECTIONS`] points on a spiral, each for the same solid angle.
fn even_direction(q: usize) -> DVec3 {
    let z = 1.0 - (2 * q + 1) as f64 / DIRECTIONS as f64;
    let turn = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt()) * q as f64;
    let across = (1.0 - z * z).sqrt();
    DVec3::new(across * turn.cos(), across * turn.sin(), z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_power_is_exact_and_slow_waves_are_heard_all_around() {
        let mut random = SplitMix::new(1);
        let heard = HeardDirections::new(&ModalSurface::default());
        for wavenumber in [0.3, 3.0, 200.0] {
            let amplitudes = heard.amplitudes(2.0, 1.0);
            let mut sums = [0.0; 3];
            for _ in 0..400 {
                let transfer = heard.transfer(wavenumber, 2.5, &amplitudes, &mut random);
                // Residual seen: 1e-15.
                assert!((transfer.power(wavenumber) / 2.5 - 1.0).abs() < 1e-12);
                for (sum, axis) in sums.iter_mut().zip(DVec3::AXES) {
                    *sum += (1e3 * transfer.undelayed(1e3 * axis, wavenumber)).norm_sqr() / 400.0;
                }
            }
            // 4π·½|p|² is the power; 400 modes of exponential intensity scatter by 5 %.
            for sum in sums {
                assert!((std::f64::consts::TAU * sum / 2.5 - 1.0).abs() < 0.2, "{wavenumber}: {sums:?}");
            }
        }
    }
}
