//! Impacts on the ground: one click of the ground for each point where an impact presses it.

use std::collections::BTreeMap;

use glam::DVec3;

use super::model::Ground;
use crate::body::{Body, BodyId};
use crate::contact::ImpactPulse;
use crate::synthesis::acceleration_pulse::AccelerationPulse;
use crate::synthesis::source::SoundSource;

/// Points of an impact closer than this are merged \[m\]: a third of a wavelength at 20 kHz.
const ONE_POINT: f64 = 5e-3;

/// The clicks of the grounds under an impact: one for each point of contact with a ground.
///
/// `grounds` are those among the `bodies` that radiate. Only the normal force counts.
pub fn ground_clicks(
    pulse: &ImpactPulse,
    bodies: &[Body],
    grounds: &BTreeMap<BodyId, Ground>,
) -> Vec<AccelerationPulse> {
    let mut clicks = Vec::new();
    for (side, id) in pulse.pair.into_iter().enumerate() {
        let (Some(ground), Some(body)) = (grounds.get(&id), bodies.get(id.index())) else { continue };
        let normal = body.pose.orientation * DVec3::Y;
        let into = if side == 0 { -normal } else { normal };
        // Points of one patch, their impulses into the ground [N s] and Σ impulse × place.
        let mut patches: Vec<(DVec3, f64, DVec3)> = Vec::new();
        for (point, impulse) in &pulse.points {
            let pressed = impulse.dot(into);
            if pressed <= 0.0 {
                continue;
            }
            let near = |(first, ..): &&mut (DVec3, f64, DVec3)| first.distance(*point) < ONE_POINT;
            match patches.iter_mut().find(near) {
                Some((_, sum, moment)) => {
                    *sum += pressed;
                    *moment += pressed * *point;
                }
                None => patches.push((*point, pressed, pressed * *point)),
            }
        }
        clicks.extend(patches.into_iter().map(|(_, impulse, moment)| {
            let point = moment / impulse;
            let depth = (point - body.pose.position).dot(normal);
            AccelerationPulse {
                body: id,
                time: pulse.onset,
                duration: pulse.duration,
                shape: pulse.shape.clone(),
                centre: point - depth * normal,
                orientation: body.pose.orientation,
                velocity_change: DVec3::ZERO,
                angular_velocity_change: DVec3::ZERO,
                source: SoundSource::Ground { ground: ground.clone(), impulse },
            }
        }));
    }
    clicks
}
