//! A run as the live engine plays it: what strikes which body when, and where the bodies are meanwhile.
//!
//! The same forces as [`render`](crate::render::render) takes, in the same order. Differs: heard are clicks and the ringing of blows.
//! Left out are rolling, the ground, the vibration that a piece takes over from what it was part of, and the limit of the
//! energy of modes.

pub mod feed;

use std::collections::BTreeMap;
use std::sync::Arc;

use clangor::body::{Body, BodyId, Life};
use clangor::contact::{ContactError, ContactSettings, PoseHistory};
use clangor::glam::DVec3;
use clangor::pose::Pose;
use clangor::realtime::{Blow, EngineSettings, SoundingObject, Struck};
use clangor::synthesis::SoundSource;
use clangor::synthesis::modal::ModalSource;
use clangor::timeline::Timeline;

use crate::render::{Forces, forces};

/// See the module.
pub struct LiveScore {
    /// The bodies in the slots of the engine.
    pub objects: Vec<BodyId>,
    /// What happens, in order of time, each with the body that is struck.
    pub blows: Vec<(BodyId, Blow)>,
    poses: PoseHistory,
    /// Those of `objects` that ring, by slot.
    ringing: Vec<(usize, BodyId)>,
}

/// Where a body is, and how it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moving {
    /// Where.
    pub pose: Pose,
    /// Velocity [m/s].
    pub velocity: DVec3,
    /// Angular velocity [rad/s], world.
    pub angular_velocity: DVec3,
}

/// Over which velocities are taken from poses \[s\].
const STEP: f64 = 1e-3;

impl LiveScore {
    /// The score of a timeline whose bodies sound as `sources` say and ring as `ringing` says. A slot is for each body that is struck and
    /// is more than a sphere that clicks.
    ///
    /// # Errors
    /// [`ContactError`] for a timeline that contradicts itself.
    pub fn new(
        bodies: &[Body],
        sources: &[SoundSource],
        ringing: &BTreeMap<BodyId, Arc<ModalSource>>,
        timeline: &Timeline,
        settings: &ContactSettings,
    ) -> Result<Self, ContactError> {
        let Forces { poses, pulses, .. } = forces(bodies, timeline, settings)?;
        let mut slots: BTreeMap<BodyId, usize> = BTreeMap::new();
        let mut objects = Vec::new();
        let mut blows = Vec::new();
        for pulse in &pulses {
            for (share, sign) in pulse.bodies.iter().zip([1.0, -1.0]) {
                let Some(share) = share else { continue };
                let id = share.body;
                let struck = match sources.get(id.index()) {
                    None => continue,
                    Some(SoundSource::Sphere { radius }) if !ringing.contains_key(&id) => {
                        Struck::Sphere { radius: *radius }
                    }
                    Some(_) => Struck::Object {
                        slot: *slots.entry(id).or_insert_with(|| {
                            objects.push(id);
                            objects.len() - 1
                        }),
                    },
                };
                // The body moves as a whole by all points together, and vibrates by each.
                let whole = Blow {
                    struck,
                    time: pulse.onset,
                    duration: pulse.duration,
                    pose: share.pose,
                    velocity_change: share.velocity_change,
                    angular_velocity_change: share.angular_velocity_change,
                    point: pulse.point,
                    impulse: DVec3::ZERO,
                };
                let points = if matches!(struck, Struck::Object { .. }) { &pulse.points[..] } else { &[] };
                let vibrates = |(at, (point, impulse)): (usize, &(DVec3, DVec3))| {
                    let still =
                        Blow { velocity_change: DVec3::ZERO, angular_velocity_change: DVec3::ZERO, ..whole };
                    let blow = if at == 0 { whole } else { still };
                    (id, Blow { point: *point, impulse: sign * *impulse, ..blow })
                };
                match points {
                    [] => blows.push((id, whole)),
                    points => blows.extend(points.iter().enumerate().map(vibrates)),
                }
            }
        }
        blows.sort_by(|(_, a), (_, b)| a.time.total_cmp(&b.time));
        let ringing =
            objects.iter().copied().enumerate().filter(|(_, id)| ringing.contains_key(id)).collect();
        Ok(LiveScore { objects, blows, poses, ringing })
    }

    /// What to put into the slots, in their order.
    pub fn sounding_objects<'a>(
        &'a self,
        sources: &'a [SoundSource],
        ringing: &'a BTreeMap<BodyId, Arc<ModalSource>>,
        settings: &'a EngineSettings,
    ) -> impl Iterator<Item = SoundingObject> + 'a {
        self.objects.iter().map(move |id| {
            let click = sources.get(id.index()).cloned();
            SoundingObject::new(click, ringing.get(id).cloned(), settings)
        })
    }

    /// When a body exists.
    pub fn life(&self, body: BodyId) -> Life {
        self.poses.life(body)
    }

    /// Where a body is at a time \[s\], and how it moves.
    pub fn moving(&self, body: BodyId, time: f64) -> Moving {
        let (pose, next) = (self.poses.at(body, time), self.poses.at(body, time + STEP));
        let turned = (next.orientation * pose.orientation.inverse()).normalize();
        // The shorter way around.
        let turned = if turned.w < 0.0 { -turned } else { turned };
        Moving {
            pose,
            velocity: (next.position - pose.position) / STEP,
            angular_velocity: turned.to_scaled_axis() / STEP,
        }
    }

    /// Greatest distance of a blow from any of these places \[m\].
    pub fn extent(&self, places: &[DVec3]) -> f64 {
        let farthest = |place: &DVec3| {
            self.blows.iter().map(|(_, blow)| blow.pose.position.distance(*place)).fold(0.0, f64::max)
        };
        places.iter().map(farthest).fold(0.0, f64::max)
    }
}
