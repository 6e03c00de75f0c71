//! Sound of a thin endless plate under a force at a point, with the same medium on both sides.
//!
//! ```text
//! p/F = ∓ ρ k/(2π m″) I(kR, θ)         − on the side that is pressed, + on the other
//! far away, below coincidence   |p| = ρ |F|/(2π m″ R)   P = ρ F²/(2π c m″²) a side (F r.m.s.)
//! far away, at any frequency    p = ∓ ρ F/(2π m″ R) e^{−ikR} f(cos θ)
//! ```
//!
//! with I and f of `plate_waves`. A listener close to grazing hears what the load of
//! the fluid leaves: f falls to 0 within an angle of 2ρc/(ω m″). The plate loses energy by radiation, which
//! f contains, and by the loss factor of its material.
//!
//! Not covered: moments and forces along the plate; shear and rotary inertia (a bending wave shorter than six
//! thicknesses is too fast); the far side hears the same as the near one, without waves through the
//! thickness.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex64;

use super::half_space::GroundError;
use super::plate_waves::{PlateAt, Rule, plate_waves};
use crate::material::{Damping, Material, ThinPlate};
use crate::medium::Medium;
use crate::synthesis::spectrum::{ArrivingForce, Grid, Spectrum};

/// The plate moves as one against the fluid and slows down in m″/2ρc; its sound is followed for so many of
/// these times, and at most for so many seconds.
const SLOWINGS: f64 = 6.0;
const LONGEST_SLOWING: f64 = 0.25;
/// Lowest frequency of a bending wave that is waited for [rad/s].
const SLOWEST: f64 = TAU * 30.0;
/// Fall of a bending wave over the height of the listener beyond which it is not waited for: e^−7.
const FALL: f64 = 7.0;
/// Bins below which every one is computed.
const LOW_BINS: usize = 64;
/// Phase between two bins that are computed, and most bins between them: four points interpolate to 2e-4.
const PHASE: f64 = 0.3;
const WIDEST: usize = 16;

/// Transfers of a plate, from the force at a point to the pressure at any place.
#[derive(Clone, Debug)]
pub struct PlateSource {
    /// The plate.
    pub plate: ThinPlate,
    /// Thickness \[m\].
    pub thickness: f64,
    /// The medium on both sides.
    pub medium: Medium,
    damping: Damping,
    rule: Rule,
}

impl PartialEq for PlateSource {
    fn eq(&self, other: &Self) -> bool {
        (self.plate, self.thickness, self.medium) == (other.plate, other.thickness, other.medium)
            && self.damping == other.damping
    }
}

impl PlateSource {
    /// A plate of a material and a thickness \[m\] in a medium.
    ///
    /// # Errors
    /// [`GroundError`] for numbers that no plate or medium has.
    pub fn try_new(material: &Material, thickness: f64, medium: &Medium) -> Result<Self, GroundError> {
        let refused =
            |what, value| Err(GroundError::Material { material: material.name.clone(), what, value });
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let Material { density, youngs_modulus, poisson_ratio, .. } = *material;
        for (what, value) in
            [("density", density), ("Young's modulus", youngs_modulus), ("thickness", thickness)]
        {
            if !positive(value) {
                return refused(what, value);
            }
        }
        if !(poisson_ratio > -1.0 && poisson_ratio < 0.5) {
            return refused("Poisson's ratio", poisson_ratio);
        }
        if !(positive(medium.density) && positive(medium.sound_speed)) {
            return Err(GroundError::Medium { value: medium.sound_speed, density: medium.density });
        }
        let plate = ThinPlate::new(material, thickness);
        let damping = material.damping.clone();
        Ok(PlateSource { plate, thickness, medium: *medium, damping, rule: Rule::new() })
    }

    /// Pressure over force [Pa/N] at angular frequencies [rad/s], for a listener at `place` \[m\] from the
    /// point that is pressed, y out of the pressed face. It includes the delay. Zero within the plate and at
    /// ω ≤ 0.
    pub fn transfer(&self, place: DVec3, frequencies: &[f64]) -> Vec<Complex64> {
        let Some(heard) = self.heard(place) else { return vec![Complex64::ZERO; frequencies.len()] };
        frequencies.iter().map(|omega| self.at(&heard, *omega)).collect()
    }

    /// What p/F of a place at the distance R and the angle `cosine` = cos θ from the normal tends to, times
    /// R e^{ikR} [Pa m/N]: stationary phase.
    pub fn far_field(&self, cosine: f64, omega: f64) -> Complex64 {
        let scale = -self.medium.density / (TAU * self.plate.mass_per_area);
        scale * self.plate_at(omega).response(Complex64::new(cosine, 0.0))
    }

    /// Whether a place is within the plate.
    pub fn contains(&self, place: DVec3) -> bool {
        place.y < 0.0 && place.y > -self.thickness
    }

    fn heard(&self, place: DVec3) -> Option<Heard> {
        let side = if place.y >= 0.0 { 1.0 } else { -1.0 };
        let height = if side > 0.0 { place.y } else { -place.y - self.thickness };
        let across = place.x.hypot(place.z);
        let distance = height.hypot(across);
        let outside = height >= 0.0 && distance > 0.0 && distance.is_finite();
        outside.then(|| Heard { side, cos: height / distance, sin: across / distance, distance })
    }

    fn plate_at(&self, omega: f64) -> PlateAt {
        let Medium { density, sound_speed } = self.medium;
        let ratio = omega / self.plate.coincidence(sound_speed);
        let loss = 2.0 * self.damping.damping_ratio(omega / TAU);
        PlateAt {
            square: ratio * ratio * Complex64::new(1.0, loss),
            load: 2.0 * density * sound_speed / (omega * self.plate.mass_per_area),
        }
    }

    fn at(&self, heard: &Heard, omega: f64) -> Complex64 {
        if omega <= 0.0 {
            return Complex64::ZERO;
        }
        let wavenumber = omega / self.medium.sound_speed;
        let scale = -heard.side * self.medium.density * wavenumber / (TAU * self.plate.mass_per_area);
        let poles = self.plate_at(omega).poles();
        scale * plate_waves(&poles, &self.rule, wavenumber * heard.distance, (heard.cos, heard.sin))
    }

    /// First and last time after the force \[s\] at which a listener at `place` \[m\] receives pressure. A
    /// bending wave above coincidence is faster than sound.
    pub(crate) fn heard_between(&self, place: DVec3) -> (f64, f64) {
        let Some(heard) = self.heard(place) else { return (0.0, 0.0) };
        let Medium { density, sound_speed } = self.medium;
        let speed = self.plate.bending_speed(SLOWEST);
        let near = heard.cos * heard.distance * SLOWEST / speed < FALL;
        let bending = if near { heard.sin * heard.distance / (2.0 * speed) } else { 0.0 };
        let slowing = self.plate.mass_per_area / (2.0 * density * sound_speed);
        let after = (SLOWINGS * slowing).min(LONGEST_SLOWING);
        (0.0, (heard.distance / sound_speed).max(bending) + after)
    }
}

/// A listener of a plate.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Heard {
    /// 1 on the pressed side, −1 on the other.
    side: f64,
    cos: f64,
    sin: f64,
    /// \[m\], from the face on that side.
    distance: f64,
}

/// A plate under an impact at one point, received at another.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlateTransfer {
    /// The plate.
    pub(crate) source: Arc<PlateSource>,
    /// Impulse into it [N s].
    pub(crate) impulse: f64,
    /// The listener \[m\] from the point of impact, y up.
    pub(crate) place: DVec3,
}

impl PlateTransfer {
    /// Adds an impact; the middle of the `arriving` force is its time at the plate, before any delay.
    ///
    /// p/F e^{iωR/c} is interpolated between some of the bins, by the cubic through four of them.
    pub(crate) fn add(&self, spectrum: &mut Spectrum, grid: &Grid, arriving: &ArrivingForce<'_>) {
        let Some(heard) = self.source.heard(self.place) else { return };
        let delay = heard.distance / self.source.medium.sound_speed;
        let step = TAU * grid.spacing_hz;
        let stride = ((PHASE / (step * delay).max(1e-9)) as usize).clamp(1, WIDEST);
        let count = grid.omega.len();
        let at = |bin: usize| {
            let omega = step * bin as f64;
            self.source.at(&heard, omega) * Complex64::cis(omega * delay)
        };
        let low = LOW_BINS.min(count);
        let mut values: Vec<Complex64> = (0..low).map(at).collect();
        if count > low {
            let nodes: Vec<Complex64> =
                (0..(count - low) / stride + 4).map(|node| at(low + node * stride - stride)).collect();
            values.extend((0..count - low).map(|bin| {
                let (node, part) = (bin / stride, (bin % stride) as f64 / stride as f64);
                cubic([nodes[node], nodes[node + 1], nodes[node + 2], nodes[node + 3]], part)
            }));
        }
        for (bin, value) in values.iter().enumerate() {
            let omega = grid.omega[bin];
            let (re, im) = arriving.at(bin, omega);
            let turned = Complex64::cis(-omega * (delay + arriving.middle));
            let pressure = self.impulse * Complex64::new(re, im) * turned * value;
            spectrum.re[bin] += pressure.re;
            spectrum.im[bin] += pressure.im;
        }
    }
}

/// The cubic through values at −1, 0, 1, 2, between 0 and 1.
fn cubic(values: [Complex64; 4], t: f64) -> Complex64 {
    let weights = [
        -t * (t - 1.0) * (t - 2.0) / 6.0,
        (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
        -(t + 1.0) * t * (t - 2.0) / 2.0,
        (t + 1.0) * t * (t - 1.0) / 6.0,
    ];
    values.iter().zip(weights).map(|(value, weight)| value * weight).sum()
}
