//! The damping of a material from the decays of its modes.
//!
//! Each law of [`Damping`] that is linear in its numbers is fitted to δ = ξω = 3 ln 10/T60, with equal weight
//! of relative errors and little of outliers (Huber), and no number negative:
//!
//! ```text
//! loss factor η:  δ = η ω/2
//! T60:            δ = 3 ln 10/T60
//! Rayleigh:       δ = (α + β ω² + g/ω²)/2
//! ```
//!
//! The laws come in the order of the Bayesian information criterion n ln s² + k ln n, with the relative
//! spread s of n decays and k numbers, so that a law with more numbers has to earn them.
//!
//! Not the damping of the material alone where supports or air take energy as well: a recording has all.

use std::f64::consts::{LN_10, TAU};

use clangor_core::material::Damping;
use faer::Mat;
use faer::linalg::solvers::SolveLstsq;

/// Relative errors above this multiple of their median count less.
const OUTLIER: f64 = 2.0;
const ITERATIONS: usize = 30;
/// Spread below which laws are equal: that of measured decays.
const LEAST_SPREAD: f64 = 0.01;

/// A law and how well it agrees.
#[derive(Clone, Debug, PartialEq)]
pub struct DampingFit {
    /// The law.
    pub damping: Damping,
    /// Root mean square of the relative errors of the decay rates, outliers left out.
    pub spread: f64,
    /// The criterion; the least is best.
    pub criterion: f64,
}

/// The decay of a mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decay {
    /// \[Hz\].
    pub frequency: f64,
    /// Time to decay by 60 dB \[s\].
    pub t60: f64,
    /// Its weight, above 0: the inverse square of its relative error, up to a factor.
    pub weight: f64,
}

/// The laws that agree with decays, the best first; none without decays.
pub fn fit_damping(decays: &[Decay]) -> Vec<DampingFit> {
    if decays.is_empty() {
        return Vec::new();
    }
    type Terms = &'static [fn(f64) -> f64];
    const MASS: fn(f64) -> f64 = |_| 0.5;
    const STIFFNESS: fn(f64) -> f64 = |omega| 0.5 * omega * omega;
    const INVERSE: fn(f64) -> f64 = |omega| 0.5 / (omega * omega);
    let eta: Terms = &[|omega| 0.5 * omega];
    let constant: Terms = &[|_| 1.0];
    let mut fits = vec![
        law(decays, eta, |c| Damping::LossFactor(c[0])),
        law(decays, constant, |c| Damping::T60(3.0 * LN_10 / c[0])),
    ];
    // Every set of Rayleigh's numbers but α alone, which is one T60: the best without a negative one.
    let rayleigh = [
        law(decays, &[STIFFNESS], |c| Damping::Rayleigh { alpha: 0.0, beta: c[0], g: 0.0 }),
        law(decays, &[INVERSE], |c| Damping::Rayleigh { alpha: 0.0, beta: 0.0, g: c[0] }),
        law(decays, &[MASS, STIFFNESS], |c| Damping::Rayleigh { alpha: c[0], beta: c[1], g: 0.0 }),
        law(decays, &[MASS, INVERSE], |c| Damping::Rayleigh { alpha: c[0], beta: 0.0, g: c[1] }),
        law(decays, &[STIFFNESS, INVERSE], |c| Damping::Rayleigh { alpha: 0.0, beta: c[0], g: c[1] }),
        law(decays, &[MASS, STIFFNESS, INVERSE], |c| Damping::Rayleigh { alpha: c[0], beta: c[1], g: c[2] }),
    ];
    let best = |fits: Vec<DampingFit>| fits.into_iter().min_by(|a, b| a.criterion.total_cmp(&b.criterion));
    fits.extend(best(rayleigh.into_iter().flatten().collect()).map(Some));
    let mut fits: Vec<DampingFit> = fits.into_iter().flatten().collect();
    fits.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
    fits
}

/// One law; `None` if a number would be negative, or there are fewer decays than numbers.
fn law(
    decays: &[Decay],
    terms: &[fn(f64) -> f64],
    damping: impl Fn(&[f64]) -> Damping,
) -> Option<DampingFit> {
    let count = terms.len();
    if decays.len() < count {
        return None;
    }
    // Each term over the measured rate: the sum is to be 1.
    let rows: Vec<Vec<f64>> = decays
        .iter()
        .map(|decay| {
            let own = decay.t60 / (3.0 * LN_10);
            terms.iter().map(|term| own * term(TAU * decay.frequency)).collect()
        })
        .collect();
    // Columns of equal size, for the equations' sake.
    let scales: Vec<f64> =
        (0..count).map(|k| rows.iter().map(|row| row[k] * row[k]).sum::<f64>().sqrt().recip()).collect();
    let mut weights: Vec<f64> = decays.iter().map(|decay| decay.weight).collect();
    let mut numbers = vec![0.0; count];
    for _ in 0..ITERATIONS {
        numbers = weighted(&rows, &scales, &weights);
        let errors: Vec<f64> = rows.iter().map(|row| (dot(row, &numbers) - 1.0).abs()).collect();
        let usual = OUTLIER * median(&errors).max(LEAST_SPREAD);
        let weigh = |(decay, e): (&Decay, &f64)| decay.weight * (usual / e).min(1.0);
        weights = decays.iter().zip(&errors).map(weigh).collect();
    }
    if numbers.iter().any(|n| *n < 0.0 || !n.is_finite()) || numbers.iter().all(|n| *n == 0.0) {
        return None;
    }
    let sum: f64 = weights.iter().sum();
    let squares = rows.iter().zip(&weights).map(|(row, w)| w * (dot(row, &numbers) - 1.0).powi(2));
    let spread = (squares.sum::<f64>() / sum).sqrt();
    let many = rows.len() as f64;
    let criterion = 2.0 * many * spread.max(LEAST_SPREAD).ln() + count as f64 * many.ln();
    Some(DampingFit { damping: damping(&numbers), spread, criterion })
}

/// The numbers of weighted least squares of Σ row·number = 1; not finite where the rows do not tell them.
fn weighted(rows: &[Vec<f64>], scales: &[f64], weights: &[f64]) -> Vec<f64> {
    let matrix = Mat::from_fn(rows.len(), scales.len(), |i, k| weights[i].sqrt() * rows[i][k] * scales[k]);
    let right = Mat::from_fn(rows.len(), 1, |i, _| weights[i].sqrt());
    let found = matrix.qr().solve_lstsq(&right);
    scales.iter().enumerate().map(|(k, scale)| found[(k, 0)] * scale).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The middle of a list that is not empty.
fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_laws_come_back_with_an_outlier() {
        let laws = [
            Damping::LossFactor(0.002),
            Damping::T60(0.8),
            Damping::Rayleigh { alpha: 5.0, beta: 1e-7, g: 0.0 },
            Damping::Rayleigh { alpha: 2.0, beta: 3e-8, g: 4e7 },
        ];
        let frequencies = [310.0, 540.0, 900.0, 1500.0, 2600.0, 4100.0, 7000.0, 9500.0, 12_000.0, 16_000.0];
        for law in laws {
            let decay = |f: &f64| Decay { frequency: *f, t60: law.t60(*f), weight: 1.0 };
            let mut decays: Vec<Decay> = frequencies.iter().map(decay).collect();
            // Half a per cent of error, and one decay of a third.
            decays.iter_mut().enumerate().for_each(|(k, d)| d.t60 *= 1.0 + 0.005 * (7.0 * k as f64).sin());
            decays[4].t60 /= 3.0;
            let best = &fit_damping(&decays)[0];
            println!("{law:?}: {best:?}");
            for f in frequencies {
                // Residual seen: 1.1 %.
                let (found, true_t60) = (best.damping.t60(f), law.t60(f));
                assert!((found / true_t60 - 1.0).abs() < 0.05, "{law:?} at {f}: {best:?}");
            }
        }
        assert!(fit_damping(&[]).is_empty());
        assert!(!fit_damping(&[Decay { frequency: 440.0, t60: 1.0, weight: 1.0 }]).is_empty());
    }
}
