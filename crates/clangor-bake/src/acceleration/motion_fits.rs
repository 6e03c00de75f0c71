//! Rational fits of each motion by itself, and samples of all from them between the frequencies solved.
//!
//! A motion excites some of the resonances of the air in and around a body: one along the axis of a mug those
//! without a node around it, one across those with one. A fit of all motions together needs as many nodes as
//! there are resonances in all; fits of one motion each need as many as that motion excites, about half. They
//! share the frequencies solved, so that these may be fewer by as much.
//!
//! ```text
//! p_d(s) = N_d(s)/D_d(s),    D_d(s) = Σ_j [ w_dj/(s − s_j) + conj(w_dj)/(s − conj s_j) ]
//! ```
//!
//! Multipoles and surface pressures have the same denominators as the fitted functions. A model has one set
//! of nodes for all motions: it is fitted to samples that these fits make, as many as that takes.

use clangor_core::sound_model::acceleration::field::{Node, RIGID_DOFS};
use num_complex::Complex64;

use crate::fitting::rational::{
    FunctionSample, NestedFits, RationalFit, error_at, fit_from, poles, predict, residues,
};
use crate::radiation::RadiationSample;

/// Samples made for each node of the densest motion.
const PER_NODE: usize = 5;
/// Nodes of an earlier fit, the last ones, that a fit to more samples chooses again.
const CHOSEN_AGAIN: usize = 4;

/// The fit of each motion, and the functions that it was fitted to.
pub(super) struct MotionFits {
    functions: Vec<Vec<FunctionSample>>,
    fits: Vec<NestedFits>,
}

impl MotionFits {
    /// Fits each motion with the fewest nodes that reach `tolerance`, from most of the nodes `before` on, of
    /// fits to the first of these functions.
    pub(super) fn new(functions: &[FunctionSample], tolerance: f64, before: Option<&MotionFits>) -> Self {
        let of = |d: usize| functions.iter().map(|f| of_motion(f, d)).collect::<Vec<_>>();
        let functions: Vec<Vec<FunctionSample>> = (0..RIGID_DOFS).map(of).collect();
        let from = |d: usize| before.map_or(&[][..], |before| kept_nodes(&before.fits[d]));
        let fit = |d: usize| fit_from(&functions[d], from(d), tolerance, functions[d].len());
        let fits = (0..RIGID_DOFS).map(fit).collect();
        MotionFits { functions, fits }
    }

    /// The largest error of any motion at a sample that was not fitted.
    pub(super) fn error_at(&self, at: &FunctionSample) -> f64 {
        let of_motion = |d: usize| {
            let fit = &self.fits[d].best;
            error_at(&self.functions[d], &fit.support, &fit.nodes, &of_motion(at, d))
        };
        (0..RIGID_DOFS).map(of_motion).fold(0.0, f64::max)
    }

    /// The largest difference of the fit of any motion at `s` from the best with fewer nodes.
    pub(super) fn doubt(&self, s: Complex64) -> f64 {
        (0..RIGID_DOFS).map(|d| doubt(&self.functions[d], &self.fits[d], s)).fold(0.0, f64::max)
    }

    /// Multipoles at evenly spaced κ, from the solved `samples` that were fitted, in their order, on a body
    /// of this radius \[m\]; those solved come first.
    pub(super) fn resampled(&self, samples: &[RadiationSample], radius: f64) -> Vec<RadiationSample> {
        let nodes = self.fits.iter().map(|fit| fit.best.nodes.len()).max().unwrap_or(0);
        let kappas: Vec<f64> = samples.iter().map(|s| s.wavenumber.re * radius).collect();
        let highest = kappas.iter().copied().fold(0.0, f64::max);
        let step = highest / (PER_NODE * nodes.max(1)) as f64;
        let mut all = samples.to_vec();
        for i in 0..PER_NODE * nodes {
            let kappa = (i as f64 + 0.5) * step;
            // Next to a sample there is nothing new.
            if kappas.iter().all(|at| (at - kappa).abs() > 0.2 * step) {
                all.push(self.sample_at(kappa, samples, radius));
            }
        }
        all
    }

    /// Multipoles at κ, from the solved `samples` as [`resampled`](Self::resampled) has them.
    pub(super) fn sample_at(&self, kappa: f64, samples: &[RadiationSample], radius: f64) -> RadiationSample {
        let distance = |sample: &RadiationSample| (sample.wavenumber.re * radius - kappa).abs();
        let nearest = samples.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        // As far off the real axis as the nearest solution.
        let off = nearest.map_or(0.0, |sample| sample.wavenumber.im);
        let count = nearest.map_or(0, |sample| sample.coefficients[0].len());
        let wavenumber = Complex64::new(kappa / radius, off);
        let coefficients = std::array::from_fn(|d| {
            let shares = self.shares(d, Complex64::I * wavenumber * radius);
            (0..count).map(|c| shares.sum(|i| samples[i].coefficients[d][c])).collect()
        });
        RadiationSample { wavenumber, coefficients, surface_pressure: Vec::new() }
    }

    /// Adds the surface pressures to a sample that lacks them.
    ///
    /// The surface answers after delays of 0 to 2R/c; those of the fitted functions are −R/c to R/c.
    pub(super) fn add_surface(&self, sample: &mut RadiationSample, solved: &[RadiationSample], radius: f64) {
        let points = solved.first().map_or(0, |sample| sample.surface_pressure.len());
        if sample.surface_pressure.len() == points {
            return;
        }
        let place = |wavenumber: Complex64| Complex64::I * wavenumber * radius;
        let s = place(sample.wavenumber);
        let advances: Vec<Complex64> = solved.iter().map(|at| (place(at.wavenumber) - s).exp()).collect();
        let mirrored: Vec<Complex64> =
            solved.iter().map(|at| (place(at.wavenumber).conj() - s).exp()).collect();
        let shares: [Shares; RIGID_DOFS] = std::array::from_fn(|d| {
            let mut shares = self.shares(d, s);
            for (i, [own, conjugate]) in &mut shares.0 {
                *own *= advances[*i];
                *conjugate *= mirrored[*i];
            }
            shares
        });
        let at = |v: usize| std::array::from_fn(|d| shares[d].sum(|i| solved[i].surface_pressure[v][d]));
        sample.surface_pressure = (0..points).map(at).collect();
    }

    /// Shares of the samples in the fit of a motion at `s`.
    fn shares(&self, motion: usize, s: Complex64) -> Shares {
        let RationalFit { support, nodes, .. } = &self.fits[motion].best;
        let parts = |node: &Node| [node.weight / (s - node.s), node.weight.conj() / (s - node.s.conj())];
        let mut shares: Vec<(usize, [Complex64; 2])> =
            support.iter().copied().zip(nodes.iter().map(parts)).collect();
        let below: Complex64 = shares.iter().flat_map(|(_, share)| share).sum();
        shares.iter_mut().flat_map(|(_, share)| share).for_each(|share| *share /= below);
        Shares(shares)
    }
}

/// The nodes with which a fit to more samples starts.
pub(super) fn kept_nodes(fits: &NestedFits) -> &[usize] {
    let support = &fits.best.support;
    &support[..support.len().saturating_sub(CHOSEN_AGAIN)]
}

/// Shares of samples in a value between them: of each sample's value, and of its conjugate.
struct Shares(Vec<(usize, [Complex64; 2])>);

impl Shares {
    fn sum(&self, value: impl Fn(usize) -> Complex64) -> Complex64 {
        let part = |(i, [own, mirrored]): &(usize, [Complex64; 2])| {
            let value = value(*i);
            own * value + mirrored * value.conj()
        };
        self.0.iter().map(part).sum()
    }
}

/// Difference at `s` of a fit from the best with fewer nodes.
pub(super) fn doubt(functions: &[FunctionSample], fits: &NestedFits, s: Complex64) -> f64 {
    let NestedFits { best, fewer } = fits;
    let values = predict(functions, &best.support, &best.nodes, s);
    let near = functions
        .iter()
        .min_by(|a, b| (a.s - s).norm().total_cmp(&(b.s - s).norm()))
        .map_or_else(Vec::new, |f| f.weights.clone());
    let at = FunctionSample { s, values, weights: near, group: functions[0].group };
    error_at(functions, &fewer.support, &fewer.nodes, &at)
}

/// Im s of the poles of a fit that change its values by more than `least` where no sample is near: narrow
/// resonances, or none at all.
pub(super) fn peaks_between(functions: &[FunctionSample], fit: &RationalFit, least: f64) -> Vec<f64> {
    let is_between = |pole: &Complex64| {
        let distance = |f: &FunctionSample| (f.s - Complex64::new(f.s.re, pole.im)).norm();
        let near = functions.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        near.is_some_and(|near| {
            let (away, width) = (distance(near), (pole.re - near.s.re).abs());
            // A sample within the half width has seen it.
            let sizes =
                || residues(functions, &fit.support, &fit.nodes, *pole).into_iter().zip(&near.weights);
            away > width && sizes().map(|(r, w)| r * w).fold(0.0, f64::max) > least * width
        })
    };
    let range = functions.iter().fold([f64::INFINITY, 0.0_f64], |[a, b], f| [a.min(f.s.im), b.max(f.s.im)]);
    let within = |pole: &Complex64| range[0] < pole.im && pole.im < range[1];
    poles(&fit.nodes).into_iter().filter(within).filter(is_between).map(|pole| pole.im).collect()
}

/// The functions of one motion: of each sphere its share.
fn of_motion(functions: &FunctionSample, motion: usize) -> FunctionSample {
    let group = functions.group;
    let own = |k: &usize| k / group % RIGID_DOFS == motion;
    let chosen: Vec<usize> = (0..functions.values.len()).filter(own).collect();
    FunctionSample {
        s: functions.s,
        values: chosen.iter().map(|k| functions.values[*k]).collect(),
        weights: chosen.iter().map(|k| functions.weights[*k]).collect(),
        group,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fitting::rational::fit_nested;

    #[test]
    fn a_narrow_resonance_between_samples_is_a_peak_until_one_lies_on_it() {
        let pole = Complex64::new(-0.002, 1.07);
        let sample = |kappa: f64| {
            let s = Complex64::new(0.0, kappa);
            let value = |a: Complex64| a / (s - pole) + a.conj() / (s - pole.conj()) + 1.0 / (s + 1.0);
            let values = [Complex64::ONE, Complex64::I].map(value).to_vec();
            FunctionSample { s, values, weights: vec![1.0; 2], group: 1 }
        };
        let mut samples: Vec<FunctionSample> = (0..8).map(|k| sample(0.1 + 0.3 * f64::from(k))).collect();
        let peaks = |samples: &[FunctionSample]| {
            peaks_between(samples, &fit_nested(samples, 1e-9, samples.len()).best, 0.01)
        };
        let found = peaks(&samples);
        assert!(found.len() == 1 && (found[0] - pole.im).abs() < 1e-6, "{found:?}");
        samples.push(sample(1.071));
        assert!(peaks(&samples).is_empty());
    }
}
