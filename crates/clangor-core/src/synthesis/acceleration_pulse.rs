//! Acceleration pulse: the change of a body's velocities in an impact.

use glam::{DQuat, DVec3};

use super::source::SoundSource;
use super::synthesis_error::SynthesisError;
use crate::body::BodyId;
use crate::contact::impact_pulse::BodyPulse;
use crate::contact::{ForceShape, ImpactPulse};

/// A body whose velocities change over `duration`.
#[derive(Clone, Debug, PartialEq)]
pub struct AccelerationPulse {
    /// The body; energies are summed by body.
    pub body: BodyId,
    /// Onset of the force \[s\].
    pub time: f64,
    /// Duration τ of the force \[s\].
    pub duration: f64,
    /// Shape of the force over time.
    pub shape: ForceShape,
    /// Centre of mass at the onset \[m\], world.
    pub centre: DVec3,
    /// Rotation from the axes of the body to the world at the onset.
    pub orientation: DQuat,
    /// Σj/M [m/s], world.
    pub velocity_change: DVec3,
    /// Change of the angular velocity [rad/s], world.
    pub angular_velocity_change: DVec3,
    /// The source that radiates.
    pub source: SoundSource,
}

impl AccelerationPulse {
    /// Rejects numbers that would put NaN or infinity into the sound.
    pub(super) fn check(&self) -> Result<(), SynthesisError> {
        let bad =
            |what, value| Err(SynthesisError::BadPulse { what, value, body: self.body, time: self.time });
        let positive = |x: f64| x > 0.0 && x.is_finite();
        if !self.time.is_finite() {
            return bad("the time", self.time);
        }
        if !positive(self.duration) {
            return bad("the duration", self.duration);
        }
        match &self.source {
            SoundSource::Ground { impulse, .. } if !positive(*impulse) => {
                return bad("the impulse", *impulse);
            }
            SoundSource::Ground { .. } => {}
            source if !positive(source.radius()) => return bad("the radius", source.radius()),
            _ => {}
        }
        let vectors = [self.centre, self.velocity_change, self.angular_velocity_change];
        if let Some(value) = vectors.into_iter().flat_map(|v| v.to_array()).find(|x| !x.is_finite()) {
            return bad("a coordinate", value);
        }
        let frames = match &self.source {
            SoundSource::Sphere { .. } | SoundSource::Reference(_) | SoundSource::Ground { .. } => {
                [self.orientation; 2]
            }
            SoundSource::Field(source) => [self.orientation, source.body_from_field],
        };
        // Written so that NaN is rejected too.
        let turns = |q: &DQuat| (q.length_squared() - 1.0).abs() < 1e-6;
        match frames.iter().find(|q| !turns(q)) {
            Some(q) => bad("the length of a rotation", q.length()),
            None => Ok(()),
        }
    }
}

/// The acceleration pulses of an impact: one for each body that it moves and that has a source. `sources`
/// holds one entry per body.
pub fn clicks_of(pulse: &ImpactPulse, sources: &[SoundSource]) -> impl Iterator<Item = AccelerationPulse> {
    let ImpactPulse { onset, duration, ref shape, .. } = *pulse;
    let shares = pulse.bodies.into_iter().flatten().filter(BodyPulse::moves);
    shares.filter_map(move |share| {
        let source = sources.get(share.body.index())?.clone();
        Some(AccelerationPulse {
            body: share.body,
            time: onset,
            duration,
            shape: shape.clone(),
            centre: share.pose.position,
            orientation: share.pose.orientation,
            velocity_change: share.velocity_change,
            angular_velocity_change: share.angular_velocity_change,
            source,
        })
    })
}
