//! Signals in time from spectra, and spectra from a field.

use clangor_core::math::radial::outgoing;
use clangor_core::math::spherical_harmonics::{index, solid_harmonics};
use clangor_core::reference::pan_representation::pulse;
use clangor_core::sound_model::acceleration::field::{AccelerationField, RIGID_DOFS};
use clangor_fourier::Planner;
use glam::DVec3;
use num_complex::Complex64;

use super::PanOptions;

/// κ = 2πm/(T Δt), m = 0 … T/2.
pub(super) fn wavenumbers(step: f64, length: usize) -> Vec<f64> {
    let spacing = std::f64::consts::TAU / (length as f64 * step);
    (0..=length / 2).map(|m| m as f64 * spacing).collect()
}

/// The spectrum of ψ at the wavenumbers of the options.
pub(super) fn pulse_spectrum(options: &PanOptions) -> Vec<f64> {
    options.wavenumbers().iter().map(|k| pulse::pulse_spectrum(*k, options.pulse)).collect()
}

/// ∫_0^τ sin(πt/τ) e^{−iκt} dt: a contact in \[PAN\] eq. (6), for exact references.
pub fn half_sine_spectrum(wavenumber: f64, duration: f64) -> Complex64 {
    let x = 0.5 * wavenumber * duration;
    let below = 1.0 - (2.0 * x / std::f64::consts::PI).powi(2);
    // The limit of cos x/(1 − (2x/π)²) at x = π/2, where both vanish, is π/4.
    let centred = if below.abs() < 1e-7 { std::f64::consts::FRAC_PI_4 } else { x.cos() / below };
    2.0 * duration / std::f64::consts::PI * centred * Complex64::new(x.cos(), -x.sin())
}

/// Samples at `start` + ℓΔt of the signal with spectrum `field` · `factor` at the wavenumbers 2πm/(T Δt), m =
/// 0 … T/2.
pub fn synthesize(field: &[Complex64], factor: &[f64], step: f64, start: f64) -> Vec<f64> {
    let length = 2 * (field.len() - 1);
    let mut planner = Planner::new();
    let plan = planner.inverse(length);
    let scale = 1.0 / (length as f64 * step);
    let mut spectrum: Vec<Complex64> = field
        .iter()
        .zip(factor)
        .zip(wavenumbers(step, length))
        .map(|((f, g), k)| f * Complex64::from_polar(g * scale, k * start))
        .collect();
    // The mean and the alternating part of a real signal are real.
    spectrum[0].im = 0.0;
    spectrum[length / 2].im = 0.0;
    let mut samples = plan.make_output_vec();
    plan.process(&mut spectrum, &mut samples).expect("buffers of the plan's own lengths");
    samples
}

/// A field at many wavenumbers: the interpolation in frequency as a matrix, shared by all points.
pub struct FieldSampler<'a> {
    field: &'a AccelerationField,
    /// For each wavenumber and node, the factors of its value and of the conjugate of its value.
    weights: Vec<[Complex64; 2]>,
    wavenumbers: usize,
}

impl<'a> FieldSampler<'a> {
    /// For these wavenumbers κ. Fades out from 90 % of the field's band on, and is zero above the band.
    pub fn new(field: &'a AccelerationField, wavenumbers: &[f64]) -> Self {
        let count = field.nodes.len();
        let mut weights = Vec::with_capacity(wavenumbers.len() * count);
        for &k in wavenumbers {
            let fade = (10.0 * (1.0 - k / field.max_wavenumber)).clamp(0.0, 1.0);
            let gain = (std::f64::consts::FRAC_PI_2 * fade).sin().powi(2);
            let s = Complex64::new(0.0, k);
            let at = field.nodes.iter().position(|n| (s - n.s).norm() < 1e-14 * (1.0 + s.norm()));
            let parts: Vec<[Complex64; 2]> = field
                .nodes
                .iter()
                .map(|n| [n.weight / (s - n.s), n.weight.conj() / (s - n.s.conj())])
                .collect();
            let total: Complex64 = parts.iter().flatten().sum();
            weights.extend(parts.into_iter().enumerate().map(|(j, part)| match at {
                _ if gain == 0.0 => [Complex64::ZERO; 2],
                Some(node) if node == j => [Complex64::new(gain, 0.0), Complex64::ZERO],
                Some(_) => [Complex64::ZERO; 2],
                None => part.map(|p| gain * p / total),
            }));
        }
        FieldSampler { field, weights, wavenumbers: wavenumbers.len() }
    }

    /// p e^{iκ|x|}/(ρR) of z = e_1 … e_6 at `x` \[R\].
    pub fn spectra(&self, x: DVec3) -> [Vec<Complex64>; RIGID_DOFS] {
        let field = self.field;
        let count = field.nodes.len();
        let order = field.order();
        let distance = x.length();
        // Angular and radial factors at the point.
        let mut harmonics = Vec::new();
        solid_harmonics(x / distance, order, &mut harmonics);
        let mut factors = Vec::new();
        let mut radial = Vec::with_capacity(count * (order + 1));
        for node in &field.nodes {
            outgoing(node.s, distance, order, &mut factors);
            // The monopole's factor s², which the coefficient excludes.
            factors[0] *= node.s * node.s;
            radial.extend_from_slice(&factors);
        }
        // Sum of the terms at each node of the interpolation.
        let mut values = vec![Complex64::ZERO; RIGID_DOFS * count];
        for (row, term) in field.terms.iter().enumerate() {
            let n = usize::from(term.n);
            let y = harmonics[index(n, isize::from(term.m))];
            let target = &mut values[usize::from(term.degree) * count..][..count];
            for (j, value) in target.iter_mut().enumerate() {
                let at = row * count + j;
                let q = Complex64::new(f64::from(field.real[at]), f64::from(field.imaginary[at]));
                *value += y * q * radial[j * (order + 1) + n];
            }
        }
        // Interpolation to the wavenumbers.
        std::array::from_fn(|degree| {
            let values = &values[degree * count..][..count];
            (0..self.wavenumbers)
                .map(|m| {
                    self.weights[m * count..][..count]
                        .iter()
                        .zip(values)
                        .map(|([a, b], v)| a * v + b * v.conj())
                        .sum()
                })
                .collect()
        })
    }
}
