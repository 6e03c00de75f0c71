//! Least squares for the signals q_k of the series Σ q_k/r^k.

use clangor_core::reference::pan_representation::pulse;
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use faer::Mat;
use num_complex::Complex64;

use super::{PanFitError, PanOptions};

/// The N × M pseudo-inverse of the matrix r_i^{−k}: \[PROXY\] eq. (14) is the same system for every
/// coefficient.
pub(super) fn pseudo_inverse(radii: &[f64], terms: usize) -> Result<Vec<Vec<f64>>, PanFitError> {
    let matrix = Mat::from_fn(radii.len(), terms, |i, k| radii[i].powi(-(k as i32 + 1)));
    let svd = matrix.thin_svd().map_err(|_| PanFitError::SingularValues)?;
    let (u, v, s) = (svd.U(), svd.V(), svd.S().column_vector());
    Ok((0..terms)
        .map(|k| (0..radii.len()).map(|i| (0..terms).map(|l| v[(k, l)] * u[(i, l)] / s[l]).sum()).collect())
        .collect())
}

/// \[PAN\] eq. (25) in the frequencies of a periodic grid.
///
/// With b_i(κ) = Σ_n ψ(nΔt − r_i; Δt) e^{−iκnΔt}, the spectrum of ψ sampled at the delay of radius i, the
/// samples at radius i of Σ_k q_k/r^k have the spectrum b_i Σ_k q̂_k r_i^{−k}.
pub(super) struct CirculantFit {
    /// For each wavenumber, the N × M truncated pseudo-inverse, by rows, including the delay of the data.
    inverses: Vec<Complex64>,
    terms: usize,
    radii: usize,
}

impl CirculantFit {
    pub(super) fn new(options: &PanOptions, radii: &[f64], truncation: f64) -> Result<Self, PanFitError> {
        let (terms, count) = (options.terms, radii.len());
        let wavenumbers = options.wavenumbers();
        let mut decompositions = Vec::with_capacity(wavenumbers.len());
        let mut largest: f64 = 0.0;
        for &wavenumber in &wavenumbers {
            let gains: Vec<Complex64> =
                radii.iter().map(|r| delayed_filter(wavenumber, *r, options.step)).collect();
            let matrix = Mat::from_fn(count, terms, |i, k| gains[i] * radii[i].powi(-(k as i32 + 1)));
            let svd = matrix.thin_svd().map_err(|_| PanFitError::SingularValues)?;
            largest = largest.max(svd.S().column_vector()[0].re);
            decompositions.push(svd);
        }
        let mut inverses = Vec::with_capacity(wavenumbers.len() * terms * count);
        for (svd, wavenumber) in decompositions.iter().zip(&wavenumbers) {
            let (u, v, s) = (svd.U(), svd.V(), svd.S().column_vector());
            for k in 0..terms {
                for i in 0..count {
                    let entry: Complex64 = (0..terms)
                        .filter(|&l| s[l].re > truncation * largest)
                        .map(|l| v[(k, l)] * u[(i, l)].conj() / s[l].re)
                        .sum();
                    inverses.push(entry * Complex64::from_polar(1.0, -wavenumber * radii[i]));
                }
            }
        }
        Ok(CirculantFit { inverses, terms, radii: count })
    }

    /// Spectra of the q_k from those of the undelayed pressures at the radii.
    pub(super) fn solve(
        &self,
        shells: &[[Vec<Complex64>; RIGID_DOFS]],
        degree: usize,
        pulse: &[f64],
    ) -> Vec<Vec<Complex64>> {
        (0..self.terms)
            .map(|k| {
                (0..pulse.len())
                    .map(|m| {
                        let row = &self.inverses[(m * self.terms + k) * self.radii..][..self.radii];
                        let sum: Complex64 =
                            row.iter().zip(shells).map(|(w, shell)| w * shell[degree][m]).sum();
                        pulse[m] * sum
                    })
                    .collect()
            })
            .collect()
    }
}

/// Spectrum b(κ) of a delay; ψ has five non-zero taps.
fn delayed_filter(wavenumber: f64, delay: f64, step: f64) -> Complex64 {
    let middle = (delay / step).round() as i64;
    (middle - 3..=middle + 3)
        .map(|n| {
            let time = n as f64 * step;
            Complex64::from_polar(pulse::pulse(time - delay, step), -wavenumber * time)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pseudo_inverse_recovers_a_series() {
        let radii = crate::reference::fit_radii(5);
        let inverse = pseudo_inverse(&radii, 2).unwrap();
        let data: Vec<f64> = radii.iter().map(|r| 0.7 / r - 1.9 / (r * r)).collect();
        let q: Vec<f64> = inverse.iter().map(|row| row.iter().zip(&data).map(|(w, d)| w * d).sum()).collect();
        // Residual seen: 4e-15.
        assert!((q[0] - 0.7).abs() < 1e-13 && (q[1] + 1.9).abs() < 1e-13, "{q:?}");
    }
}
