//! Stiffness of a contact and duration of a collision by Hertz's theory of elastic contact.
//!
//! ```text
//! F = k d^{3/2}     k = 4/3 E* √R_e F₂^{−3/2}     R_e = √(R'R'')     1/E* = Σ (1 − νᵢ²)/Eᵢ
//! τ = 2.9432751843 d_m/V     d_m = (5 m V²/(4 k))^{2/5}     1/m = 1/m₁ + 1/m₂
//! ```
//!
//! d is the approach of the bodies, R' and R'' the principal radii of the gap between them
//! ([`relative_curvature`](super::relative_curvature)), F₂ the factor of the contact's ellipse
//! ([`hertz_ellipse`](super::hertz_ellipse)). Source: Johnson (1985), sections 4.2 and 11.4. τ follows from
//! m d̈ = −k d^{3/2}: the factor is (4/5) B(2/5, 1/2), with Euler's beta function. \[PAN\] eqs. (7) and (8)
//! have the special case of a circle, τ = 2.8683 (m²/(R E*² V))^{1/5}, with the factor rounded to 2.87, and
//! take the mean curvature for both R' and R'': k is then too small by 1.16, 1.95, 3.2 at R'/R'' = 4, 25,
//! 100.
//!
//! Not covered: plastic deformation, adhesion, and the flat punch. [`HertzRange`] says where a contact leaves
//! the theory.

use super::contact_side::ContactSide;
use super::hertz_ellipse::HertzEllipse;
use super::hertz_pulse::DURATION_OVER_APPROACH_TIME;
use crate::material::thin_plate::inelasticity;

/// Input of Hertz's formulas for one collision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HertzContact {
    /// Combined inverse effective mass 1/m [1/kg].
    pub inverse_mass: f64,
    /// Principal relative radii R' and R'' \[m\] in any order; both the radius for a ball on a plane.
    pub relative_radii: [f64; 2],
    /// Combined compliance 1/E* [1/Pa].
    pub compliance: f64,
    /// Approach speed V along the normal [m/s].
    pub speed: f64,
}

/// Largest approach over the smaller relative radius for which half-spaces stand for the bodies.
const MOST_APPROACH: f64 = 0.2;

impl HertzContact {
    /// Stiffness k [N/m^{3/2}]; 0, infinite or NaN unless radii and compliance are positive and finite.
    pub fn stiffness(&self) -> f64 {
        let [first, second] = self.relative_radii;
        let factor = HertzEllipse::of_radii(self.relative_radii).approach_factor;
        4.0 / 3.0 * (first * second).sqrt().sqrt() / (self.compliance * factor * factor.sqrt())
    }

    /// Share of the energy of the approach that endless plates behind the contact take away, where it is
    /// small: 2 × 1.72 λ, the first order of \[Zener1941\].
    pub fn plate_share(&self, sides: &[ContactSide; 2]) -> f64 {
        let mobility: f64 = sides.iter().map(|side| side.plate_mobility).sum();
        if mobility == 0.0 {
            return 0.0;
        }
        3.44 * inelasticity(mobility, self.inverse_mass, self.stiffness()) * self.speed.powf(0.2)
    }

    /// Largest approach d_m \[m\]. All numbers must be positive and finite.
    pub fn largest_approach(&self) -> f64 {
        (1.25 * self.speed * self.speed / (self.inverse_mass * self.stiffness())).powf(0.4)
    }

    /// Duration τ \[s\]. All numbers must be positive and finite.
    pub fn duration(&self) -> f64 {
        DURATION_OVER_APPROACH_TIME * self.largest_approach() / self.speed
    }

    /// Whether the approach exceeds 0.2 of the smaller relative radius, where the theory of small contacts
    /// ends.
    pub fn is_deep(&self) -> bool {
        let [first, second] = self.relative_radii;
        self.largest_approach() > MOST_APPROACH * first.min(second)
    }
}

/// Whether Hertz's theory covers a contact, and if not, why. Its formulas are used with bounds all the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum HertzRange {
    /// A small ellipse.
    #[default]
    Within,
    /// The surfaces are so nearly parallel in one direction, as a cylinder on a plane, that the larger
    /// relative radius is bounded by the size of the smaller body.
    Line,
    /// They are so in both directions, as flat on flat or a ball in a close-fitting bowl: both radii are
    /// bounded.
    Conforming,
    /// They overlap next to the contact in one direction, as a ball in a narrow groove: the larger radius is
    /// bounded.
    Saddle,
    /// The approach exceeds 0.2 of the smaller relative radius ([`HertzContact::is_deep`]).
    Deep,
}
