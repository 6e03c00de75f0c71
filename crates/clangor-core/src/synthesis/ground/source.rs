//! Pressure of an elastic half-space below a medium under a point force, at any place and frequency.

use std::f64::consts::TAU;

use glam::DVec3;
use num_complex::Complex64;

use super::direction::{Direction, Octaves};
use super::directions::Directions;
use super::half_space::{GroundError, HalfSpace};
use super::poles::{Branch, Pole, poles};
use crate::material::Material;
use crate::medium::Medium;

/// Time for which the response is followed after all waves have passed, over R/c. The rest falls as t⁻³.
const AFTERWARDS: f64 = 1.5;

/// Transfers of a solid under a medium, from the force at a point to the pressure at any place.
#[derive(Clone, Debug)]
pub struct GroundSource {
    /// The solid.
    pub solid: HalfSpace,
    /// The medium above it.
    pub medium: Medium,
    poles: Vec<Pole>,
    /// Derived from the fields above, and cached.
    directions: Directions,
}

impl PartialEq for GroundSource {
    fn eq(&self, other: &Self) -> bool {
        (self.solid, self.medium) == (other.solid, other.medium)
    }
}

impl GroundSource {
    /// The half-space of a material under a medium.
    ///
    /// # Errors
    /// [`GroundError`] for numbers that no solid or medium has.
    pub fn try_new(material: &Material, medium: &Medium) -> Result<Self, GroundError> {
        let Medium { density, sound_speed } = *medium;
        if !(density > 0.0 && density.is_finite() && sound_speed > 0.0 && sound_speed.is_finite()) {
            return Err(GroundError::Medium { value: sound_speed, density });
        }
        let solid = HalfSpace::try_new(material, sound_speed)?;
        Ok(GroundSource { solid, medium: *medium, poles: poles(&solid), directions: Directions::new() })
    }

    /// Pressure over force [Pa/N] at angular frequencies [rad/s], for a listener at `place` \[m\] from the
    /// point that is pressed, y up. It includes the delay. Zero below the surface and at ω ≤ 0.
    pub fn transfer(&self, place: DVec3, frequencies: &[f64]) -> Vec<Complex64> {
        let heard = ReceiverDirection::at(self, place);
        let positive = || frequencies.iter().copied().filter(|w| *w > 0.0);
        let (least, greatest) = (positive().fold(f64::INFINITY, f64::min), positive().fold(0.0, f64::max));
        let Some(heard) = heard.filter(|_| greatest > 0.0) else {
            return vec![Complex64::ZERO; frequencies.len()];
        };
        let direction = heard.direction(self, least, greatest);
        let at = |w: &f64| match *w > 0.0 {
            true => direction.at(w * heard.delay) * (self.scale() * w * w),
            false => Complex64::ZERO,
        };
        frequencies.iter().map(at).collect()
    }

    /// (c/c_R)², m², n², and that of the wave that leaks, if there is one.
    fn squares(&self) -> [Complex64; 4] {
        let of = |branch| {
            self.poles.iter().find(|pole| pole.branch == branch).map_or(Complex64::ZERO, |p| p.square)
        };
        let [pressure, shear] = [self.solid.pressure_square, self.solid.shear_square].map(Complex64::from);
        [of(Branch::Rayleigh), pressure, shear, of(Branch::Leaking)]
    }

    /// ρ/(2πμ) [s²/m⁴]: p/F over ω² I.
    pub(super) fn scale(&self) -> f64 {
        self.medium.density / (TAU * self.solid.shear_modulus)
    }

    /// First and last time after the force \[s\] at which a listener at `place` \[m\] receives pressure.
    pub(crate) fn heard_between(&self, place: DVec3) -> (f64, f64) {
        let Some(heard) = ReceiverDirection::at(self, place) else { return (0.0, 0.0) };
        let ReceiverDirection { cos, sin, delay } = heard;
        let slowest = self.medium.sound_speed / self.solid.rayleigh_speed();
        // A wave along the ground that is faster than sound arrives before the one from the contact.
        let fastest = self.solid.pressure_square.sqrt();
        let first = if fastest < sin { (1.0 - fastest * fastest).sqrt() * cos + fastest * sin } else { 1.0 };
        // A slower one arrives later, with a delay that grows with the height of the listener.
        let last = if slowest > 1.0 { (slowest * (sin + cos)).max(1.0) } else { 1.0 };
        (first * delay, (last + AFTERWARDS) * delay)
    }
}

/// Direction and delay of a receiver, from the pressed point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ReceiverDirection {
    pub(super) cos: f64,
    pub(super) sin: f64,
    /// R/c \[s\].
    pub(super) delay: f64,
}

impl ReceiverDirection {
    /// `place` \[m\] with y up; `None` on the surface and below.
    pub(super) fn at(source: &GroundSource, place: DVec3) -> Option<Self> {
        let distance = place.length();
        let across = place.x.hypot(place.z);
        let above = place.y > 0.0 && distance.is_finite();
        let delay = distance / source.medium.sound_speed;
        above.then(|| ReceiverDirection { cos: place.y / distance, sin: across / distance, delay })
    }

    /// The waves between two angular frequencies [rad/s].
    pub(super) fn direction(&self, source: &GroundSource, least: f64, greatest: f64) -> Direction {
        let nodes = Octaves::spanning(least * self.delay, greatest * self.delay);
        Direction::new(&source.poles, (self.cos, self.sin), source.squares(), nodes)
    }

    /// The same, from the stored directions where these reach.
    pub(super) fn kept_direction(&self, source: &GroundSource, least: f64, greatest: f64) -> Direction {
        let GroundSource { poles, directions, .. } = source;
        directions
            .towards(poles, (self.cos, self.sin), source.squares(), greatest * self.delay)
            .unwrap_or_else(|| self.direction(source, least, greatest))
    }
}
