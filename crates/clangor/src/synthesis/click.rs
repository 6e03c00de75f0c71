//! One body's jump in velocity, as far as sound is concerned.

use glam::DVec3;

use super::SynthesisError;
use crate::body::{Body, BodyId};
use crate::contact::{ForceProfile, ImpactPulse};

/// A sphere at `centre` that gains `velocity_change` over `duration`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Click {
    /// Which body; energies are summed by it.
    pub body: BodyId,
    /// Onset of the force \[s\].
    pub time: f64,
    /// Duration τ of the force \[s\].
    pub duration: f64,
    /// How the force runs over that time.
    pub profile: ForceProfile,
    /// Centre of the sphere at the onset \[m\], world.
    pub centre: DVec3,
    /// Radius of the sphere \[m\].
    pub radius: f64,
    /// Σj/M [m/s], world.
    pub velocity_change: DVec3,
}

impl Click {
    /// Refuses numbers that would put NaN or infinity into the sound.
    pub(super) fn check(&self) -> Result<(), SynthesisError> {
        let bad =
            |what, value| Err(SynthesisError::BadClick { what, value, body: self.body, time: self.time });
        let positive = |x: f64| x > 0.0 && x.is_finite();
        if !self.time.is_finite() {
            return bad("the time", self.time);
        }
        if !positive(self.duration) {
            return bad("the duration", self.duration);
        }
        if !positive(self.radius) {
            return bad("the radius", self.radius);
        }
        let numbers = self.centre.to_array().into_iter().chain(self.velocity_change.to_array());
        match numbers.into_iter().find(|x| !x.is_finite()) {
            Some(value) => bad("a coordinate", value),
            None => Ok(()),
        }
    }
}

/// The clicks of an impact: one for each body that it moves.
pub fn clicks_of(pulse: &ImpactPulse, bodies: &[Body]) -> impl Iterator<Item = Click> {
    let ImpactPulse { onset, duration, profile, .. } = *pulse;
    let shares = pulse.bodies.into_iter().flatten();
    shares.filter_map(move |share| {
        let body = bodies.get(share.body.index())?;
        Some(Click {
            body: share.body,
            time: onset,
            duration,
            profile,
            centre: share.pose.position,
            radius: body.surface.equal_volume_radius(),
            velocity_change: share.velocity_change,
        })
    })
}
