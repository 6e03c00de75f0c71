//! The elliptical contact of two elastic surfaces by Hertz: size, pressure and stiffness.
//!
//! With the principal relative radii R' ≥ R'', R_e = √(R'R''), and the complete elliptic integrals K, B, D of
//! the eccentricity e of the contact ellipse with the semi-axes a ≥ b:
//!
//! ```text
//! R'/R'' = B/D (a/b)²          √(ab) = (3 P R_e/(4 E*))^{1/3} F₁          F₁³ = 4/π √(b/a) √(B D)
//! P = 4/3 E* √R_e F₂^{−3/2} d^{3/2}                 F₂^{3/2} = √2/π √(b/a) K^{3/2} (B D)^{−1/4}
//! ```
//!
//! a lies along R'. Source: Johnson (1985), section 4.2(c), eqs. (4.25) to (4.30) with B = (E − (b/a)² K)/e²
//! and D = (K − E)/e², which have no difference to cancel at the circle. F₁ and F₂ are 1 there. A long
//! ellipse is as far as Hertz goes: the approach of a true line contact depends on the bodies as wholes.

use std::f64::consts::PI;

use crate::math::elliptic::CompleteIntegrals;

/// The form of a contact ellipse, which depends on R'/R'' alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HertzEllipse {
    /// b/a, at most 1.
    pub axis_ratio: f64,
    /// F₁, the mean radius over that of a circular contact of equal R_e.
    pub size_factor: f64,
    /// F₂, the approach over that of a circular contact of equal R_e and load.
    pub approach_factor: f64,
}

/// Steps of the search for the axes, which takes 3 to 6.
const MOST_STEPS: usize = 30;
/// ln(R'/R'') below which the ellipse is a circle to rounding: F₂ differs from 1 by its square.
const CIRCLE: f64 = 1e-8;

impl HertzEllipse {
    /// Of principal relative radii R' and R'' in any order: only their ratio counts. NaN for radii that are
    /// not positive and finite.
    pub fn of_radii(radii: [f64; 2]) -> Self {
        let logarithm = (radii[0] / radii[1]).ln().abs();
        if !logarithm.is_finite() {
            return HertzEllipse { axis_ratio: f64::NAN, size_factor: f64::NAN, approach_factor: f64::NAN };
        }
        let axis_ratio = (-axis_logarithm(logarithm)).exp();
        let integrals = CompleteIntegrals::at_complement(axis_ratio);
        let product = integrals.cosine * integrals.sine;
        let stretched = axis_ratio.sqrt();
        let cubed = 4.0 / PI * stretched * product.sqrt();
        let approach = (2.0_f64.sqrt() / PI * stretched).powi(2) * integrals.first.powi(3) / product.sqrt();
        HertzEllipse { axis_ratio, size_factor: cubed.cbrt(), approach_factor: approach.cbrt() }
    }

    /// Semi-axes a ≥ b \[m\] of the contact under a `load` P \[N\] of surfaces with the principal relative
    /// `radii` \[m\] and the combined `compliance` 1/E* [1/Pa].
    pub fn semi_axes(&self, load: f64, radii: [f64; 2], compliance: f64) -> [f64; 2] {
        let mean_radius = (radii[0] * radii[1]).sqrt();
        let size = (0.75 * load * mean_radius * compliance).cbrt() * self.size_factor;
        [size / self.axis_ratio.sqrt(), size * self.axis_ratio.sqrt()]
    }
}

/// Pressure in the middle of a contact ellipse \[Pa\], 3 P/(2π a b).
pub fn peak_pressure(load: f64, semi_axes: [f64; 2]) -> f64 {
    1.5 * load / (PI * semi_axes[0] * semi_axes[1])
}

/// x = ln(a/b) with ln(R'/R'') = 2 x + ln(B/D), by the secant method within a bracket.
fn axis_logarithm(radii_logarithm: f64) -> f64 {
    // The slope of the right side is 3/2 at the circle and grows to 2.
    let (mut low, mut high) = (0.5 * radii_logarithm, 2.0 / 3.0 * radii_logarithm);
    if radii_logarithm < CIRCLE {
        return high;
    }
    let excess = |x: f64| {
        let integrals = CompleteIntegrals::at_complement((-x).exp());
        2.0 * x + (integrals.cosine / integrals.sine).ln() - radii_logarithm
    };
    let (mut last, mut last_excess) = (low, excess(low));
    let (mut x, mut value) = (high, excess(high));
    for _ in 0..MOST_STEPS {
        if value > 0.0 {
            high = high.min(x);
        } else {
            low = low.max(x);
        }
        let secant = x - value * (x - last) / (value - last_excess);
        let next = if secant >= low && secant <= high { secant } else { 0.5 * (low + high) };
        (last, last_excess) = (x, value);
        (x, value) = (next, excess(next));
        if (x - last).abs() < 1e-9 * radii_logarithm || value == last_excess {
            break;
        }
    }
    x
}
