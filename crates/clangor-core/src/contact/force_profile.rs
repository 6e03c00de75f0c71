//! Time profile of the contact force of a collision.
//!
//! Each profile is a force per unit of impulse: its integral over time is 1. Multiplied by j/M it is the
//! acceleration of the centre of mass (\[PAN\] eqs. 10 and 11). Spectra use e^{+iωt}: Ŝ(ω) = ∫ S(t) e^{−iωt}
//! dt, so Ŝ(0) = 1.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::hertz_pulse;

/// Shape of the contact force over the duration τ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ForceProfile {
    /// Hertz's own pulse ([`hertz_pulse`]).
    #[default]
    Hertz,
    /// \[PAN\] eq. (6): (π/2τ) sin(πt/τ) for 0 ≤ t ≤ τ.
    HalfSine,
    /// \[HW\] eq. (9): exp(−6 (t − τ/2)²/τ²), divided by its own area.
    ///
    /// Differs: \[HW\] scales by the area of the half-sine, which is 13.7 % too much impulse.
    Gaussian,
}

impl ForceProfile {
    /// S(t) [1/s] at `time` after the onset \[s\], for a duration τ \[s\].
    pub fn value(self, time: f64, duration: f64) -> f64 {
        match self {
            ForceProfile::Hertz => hertz_pulse::value(time / duration) / duration,
            ForceProfile::HalfSine if (0.0..=duration).contains(&time) => {
                0.5 * PI / duration * (PI * time / duration).sin()
            }
            ForceProfile::HalfSine => 0.0,
            ForceProfile::Gaussian => {
                let x = time / duration - 0.5;
                (6.0 / PI).sqrt() / duration * (-6.0 * x * x).exp()
            }
        }
    }

    /// Ŝ(ω) e^{iωτ/2}: the spectrum seen from the middle of the collision, where it is real.
    ///
    /// Half-sine: cos x / (1 − (2x/π)²) with x = ωτ/2. At x = π/2 both parts vanish and the value is π/4;
    /// there cos x = −sin δ and 1 − (2x/π)² = −(4/π²) δ (π + δ), δ = x − π/2.
    pub fn centred_spectrum(self, omega: f64, duration: f64) -> f64 {
        let x = 0.5 * omega.abs() * duration;
        match self {
            ForceProfile::Hertz => hertz_pulse::centred_spectrum(x),
            ForceProfile::HalfSine => {
                let delta = x - 0.5 * PI;
                if delta.abs() < 1e-3 {
                    let d2 = delta * delta;
                    let sine_over_delta = 1.0 - d2 / 6.0 * (1.0 - d2 / 20.0);
                    return 0.25 * PI * PI * sine_over_delta / (PI + delta);
                }
                x.cos() / (1.0 - (2.0 * x / PI).powi(2))
            }
            ForceProfile::Gaussian => (-x * x / 6.0).exp(),
        }
    }

    /// Real and imaginary part of Ŝ(ω) [-] at `omega` [rad/s], for a duration τ \[s\].
    pub fn spectrum(self, omega: f64, duration: f64) -> (f64, f64) {
        let amplitude = self.centred_spectrum(omega, duration);
        let (sin, cos) = (-0.5 * omega * duration).sin_cos();
        (amplitude * cos, amplitude * sin)
    }

    /// ∫ S(t) e^{−λt} dt from the onset, for a duration τ \[s\]: the response of a resonator of pole λ,
    /// referred to the onset.
    ///
    /// Half-sine: (1 + e^{−λτ}) / (2 (1 + (λτ/π)²)). The tails of the Gaussian reach before the onset.
    pub fn at_pole(self, pole: Complex64, duration: f64) -> Complex64 {
        let x = pole * duration;
        match self {
            ForceProfile::Hertz => hertz_pulse::at_pole(x),
            ForceProfile::HalfSine => {
                let below = 1.0 + (x / PI).powi(2);
                if below.norm() < 1e-6 {
                    // λτ = ±iπ: numerator and denominator vanish together, and their slopes decide.
                    return -(-x).exp() * PI.powi(2) / (4.0 * x);
                }
                (1.0 + (-x).exp()) / (2.0 * below)
            }
            ForceProfile::Gaussian => (x * x / 24.0 - 0.5 * x).exp(),
        }
    }

    /// Times after the onset \[s\] between which the force acts; the Gaussian is below 1e-11 of its peak
    /// outside.
    pub fn extent(self, duration: f64) -> (f64, f64) {
        match self {
            ForceProfile::Hertz | ForceProfile::HalfSine => (0.0, duration),
            ForceProfile::Gaussian => (-1.56 * duration, 2.56 * duration),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ S(t) e^{−iωt} dt by the midpoint rule.
    fn integrated_spectrum(profile: ForceProfile, omega: f64, duration: f64) -> (f64, f64) {
        let (from, to) = profile.extent(duration);
        let n = 20_000;
        let h = (to - from) / n as f64;
        (0..n).fold((0.0, 0.0), |(re, im), i| {
            let t = from + (i as f64 + 0.5) * h;
            let s = profile.value(t, duration) * h;
            (re + s * (omega * t).cos(), im - s * (omega * t).sin())
        })
    }

    #[test]
    fn spectrum_is_the_integral_of_the_profile_also_where_its_formula_is_singular() {
        let tau = 50e-6;
        let singular = PI / tau;
        for profile in [ForceProfile::Hertz, ForceProfile::HalfSine, ForceProfile::Gaussian] {
            for omega in
                [0.0, 1e3, 4e4, singular * (1.0 - 1e-9), singular, singular * 1.0005, singular * 1.001, 3e5]
            {
                let exact = profile.spectrum(omega, tau);
                let sum = integrated_spectrum(profile, omega, tau);
                let error = f64::hypot(exact.0 - sum.0, exact.1 - sum.1);
                // Residual seen: 3e-9, the error of the midpoint rule where the half-sine has corners.
                assert!(error < 1e-8, "{profile:?} at {omega}: {exact:?} against {sum:?}");
            }
            assert!((profile.spectrum(0.0, tau).0 - 1.0).abs() < 1e-15, "{profile:?} is not of unit area");
        }
    }
}
