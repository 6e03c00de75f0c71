//! Modal model of a body: its modes, and the transfer of each.
//!
//! A mode moves the surface by u(x, t) = U(x) q(t), with ∫ ρ U² dV = 1. A force f at x drives it by Q =
//! U(x)·f:
//!
//! ```text
//! q̈ + 2 ξ ω q̇ + ω² q = Q
//! ```
//!
//! The transfer is the pressure per modal acceleration q̈ of the frequency ω of the mode. With R the bounding
//! radius about the centre of mass, x the position over R, s = ikR, k = ω/c (see `radial` for θₙ,
//! `spherical_harmonics` for Yₙₘ):
//!
//! ```text
//! p(x) = ρ R q̈ e^{−s|x|} Σ_n |x|^{−(n+1)} θₙ(s|x|)/θₙ(s) Σ_m Yₙₘ(x/|x|) cₙₘ
//! ```
//!
//! It is \[FRAC\] eq. (22) with each wave normalised to 1 on the sphere of radius R, so that nothing over- or
//! underflows. The damping of the material is not part of the model: it can change without another bake. That
//! of supports belongs to the modes: with dampers c at places x, 2ξω = uᵀC u = Σ c U(x)².

use std::f64::consts::TAU;

use glam::DVec3;
use num_complex::Complex64;

use crate::math::radial::outgoing;
use crate::math::spherical_harmonics::solid_harmonics;
use crate::medium::Medium;
use crate::sound_model::modal::surface::ModalSurface;

/// Modal model of a body that is free, or held by supports.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalModel {
    /// R, largest distance of the surface from the centre of mass \[m\].
    pub radius: f64,
    /// Medium of the transfers, which hold for it alone.
    pub medium: Medium,
    /// Density of the body [kg/m³], by which shapes are normalised.
    pub density: f64,
    /// All modes below this frequency \[Hz\] are present, or those that stand for them.
    pub max_frequency: f64,
    /// Frequency \[Hz\] above which modes are synthetic: their levels are those of the body in the mean, and
    /// their frequencies and shapes are random. `None` if all are modes of the body.
    pub statistical_above: Option<f64>,
    /// Surface on which shapes are given.
    pub surface: ModalSurface,
    /// The modes, by frequency.
    pub modes: Vec<ModalMode>,
}

impl ModalModel {
    /// The modes that are those of the body, without synthetic ones.
    pub fn known_modes(&self) -> &[ModalMode] {
        let end = self
            .statistical_above
            .map_or(self.modes.len(), |from| self.modes.partition_point(|mode| mode.frequency < from));
        &self.modes[..end]
    }

    /// The model without synthetic modes.
    #[must_use]
    pub fn without_synthetic_modes(mut self) -> Self {
        self.modes.truncate(self.known_modes().len());
        self.max_frequency = self.statistical_above.take().unwrap_or(self.max_frequency);
        self
    }
}

/// A mode and its transfer.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalMode {
    /// ω/2π without damping \[Hz\].
    pub frequency: f64,
    /// Estimate of the relative change of the frequency by a finer mesh. NaN without an estimate.
    pub mesh_error: f64,
    /// 2ξω by the dampers of supports [1/s]; 0 without.
    pub support_damping: f64,
    /// U at the nodes of the surface [kg^−½].
    pub shape: Vec<DVec3>,
    /// Pressure per modal acceleration; `None` for a model of frequencies and shapes alone.
    pub transfer: Option<ModalTransfer>,
}

impl ModalMode {
    /// ξ by the dampers of supports, to be added to that of the material.
    pub fn support_damping_ratio(&self) -> f64 {
        self.support_damping / (2.0 * TAU * self.frequency)
    }
}

/// Pressure around a body that vibrates in one mode.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalTransfer {
    /// Highest n.
    pub order: usize,
    /// cₙₘ at n² + n + m [kg^−½]; (order + 1)² of them.
    pub coefficients: Vec<Complex64>,
}

impl ModalTransfer {
    /// p e^{s|x|}/(ρ R) [kg^−½] at `x`, in units of R, for κ = kR = `wavenumber`.
    pub fn undelayed(&self, x: DVec3, wavenumber: f64) -> Complex64 {
        let distance = x.length();
        let (mut harmonics, mut waves) = (Vec::new(), Vec::new());
        solid_harmonics(x / distance, self.order, &mut harmonics);
        outgoing(Complex64::new(0.0, wavenumber), distance, self.order, &mut waves);
        (0..=self.order)
            .map(|n| {
                let own = n * n..(n + 1) * (n + 1);
                let sum: Complex64 =
                    self.coefficients[own.clone()].iter().zip(&harmonics[own]).map(|(c, y)| c * y).sum();
                sum * waves[n]
            })
            .sum()
    }

    /// Time-mean power radiated by q̈ of amplitude 1, over ρ R⁴/c [1/kg], for κ = kR = `wavenumber`: the sum
    /// of the powers of the waves.
    pub fn power(&self, wavenumber: f64) -> f64 {
        let s = Complex64::new(0.0, wavenumber);
        // |hₙ(kr)/hₙ(kR)|² → |1/θₙ(s)|² κ^{2n} / x² far away; the ratio κ/|tₙ| stays of the size of 1.
        let mut gain = 1.0;
        let mut ratio = Complex64::ONE;
        let mut sum = 0.0;
        for n in 0..=self.order {
            if n > 0 {
                ratio = if n == 1 { s + 1.0 } else { (2 * n - 1) as f64 + s * s / ratio };
                gain *= wavenumber * wavenumber / ratio.norm_sqr();
            }
            let own: f64 = self.coefficients[n * n..(n + 1) * (n + 1)].iter().map(|c| c.norm_sqr()).sum();
            sum += 0.5 * own * gain;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_is_that_of_the_far_field() {
        let coefficients: Vec<Complex64> =
            (0..16).map(|i| Complex64::new((i as f64).sin(), (1.7 * i as f64).cos())).collect();
        let transfer = ModalTransfer { order: 3, coefficients };
        let (wavenumber, far) = (1.3, 1e5);
        // |p|²/(2ρc) over a sphere, by the product rule of eight points in z and in φ: exact for order 3.
        let nodes: [(f64, f64); 4] = [
            (0.183_434_642_495_649_8, 0.362_683_783_378_362),
            (0.525_532_409_916_329, 0.313_706_645_877_887_3),
            (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
            (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
        ];
        let mut sum = 0.0;
        for (z, weight) in nodes.into_iter().flat_map(|(z, w)| [(z, w), (-z, w)]) {
            for k in 0..8 {
                let (sin, cos) = (k as f64 * std::f64::consts::FRAC_PI_4).sin_cos();
                let across = (1.0 - z * z).sqrt();
                let at = far * DVec3::new(across * cos, across * sin, z);
                let p = transfer.undelayed(at, wavenumber);
                sum += 0.5 * p.norm_sqr() * far * far * weight * std::f64::consts::FRAC_PI_4;
            }
        }
        // Residual seen: 8e-11.
        assert!((transfer.power(wavenumber) / sum - 1.0).abs() < 1e-8, "{sum}");
    }
}
