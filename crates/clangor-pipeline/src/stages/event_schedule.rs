//! A run as the live engine plays it: what strikes which body when, and where the bodies are meanwhile.
//!
//! The same forces as [`render`](crate::stages::render::render) takes, in the same order. Differs: heard are
//! clicks and the ringing of impacts. Left out are rolling, the ground, and the vibration that a piece takes
//! over from what it was part of.

pub mod event_feeder;
pub mod scheduled_engine;

use std::collections::BTreeMap;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Life};
use clangor_core::contact::{ContactError, PoseHistory};
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::pose::Pose;
use clangor_core::realtime::{
    Budget, Controller, Engine, EngineSettings, ImpactEvent, ImpactTarget, SoundingObject, engine,
};
use clangor_core::synthesis::SoundModel;
use clangor_core::synthesis::modal::ModalSource;
use clangor_core::synthesis::{Listener, SampleRate, SoundSource, SynthesisError};
use clangor_core::timeline::Timeline;

use crate::stages::render::{Forces, RenderOptions, forces};

/// See the module.
pub struct EventSchedule {
    /// The bodies in the slots of the engine.
    pub objects: Vec<BodyId>,
    /// What happens, in order of time, each with the body that is struck.
    pub impacts: Vec<(BodyId, ImpactEvent)>,
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

impl Moving {
    /// A body at a time \[s\]; at an impact, how it moves after it.
    pub(crate) fn of(poses: &PoseHistory, body: BodyId, time: f64) -> Self {
        let (pose, next) = (poses.at(body, time), poses.at(body, time + STEP));
        let turned = (next.orientation * pose.orientation.inverse()).normalize();
        // The shorter way around.
        let turned = if turned.w < 0.0 { -turned } else { turned };
        Moving {
            pose,
            velocity: (next.position - pose.position) / STEP,
            angular_velocity: turned.to_scaled_axis() / STEP,
        }
    }

    /// Where it would be so much later \[s\] if it went on like this.
    pub(crate) fn after(&self, time: f64) -> Pose {
        Pose {
            position: self.pose.position + time * self.velocity,
            orientation: DQuat::from_scaled_axis(time * self.angular_velocity) * self.pose.orientation,
        }
    }
}

/// Over which velocities are taken from poses \[s\].
const STEP: f64 = 1e-3;

impl EventSchedule {
    /// The schedule of a timeline whose bodies have `models` and the modal sources `ringing`. Each struck
    /// body that is more than a sphere that clicks has a slot.
    ///
    /// # Errors
    /// [`ContactError`] for a timeline that contradicts itself.
    pub fn new(
        bodies: &[Body],
        models: &[SoundModel],
        ringing: &BTreeMap<BodyId, Arc<ModalSource>>,
        timeline: &Timeline,
        options: &RenderOptions,
    ) -> Result<Self, ContactError> {
        let Forces { poses, pulses, .. } = forces(bodies, ringing, timeline, &options.contact)?;
        let mut slots: BTreeMap<BodyId, usize> = BTreeMap::new();
        let mut objects = Vec::new();
        let mut impacts = Vec::new();
        for pulse in &pulses {
            for (side, share) in pulse.bodies.iter().enumerate() {
                let Some(id) = share.map(|share| share.body) else { continue };
                let target = match models.get(id.index()).map(|model| &model.acceleration.source) {
                    None => continue,
                    Some(SoundSource::Sphere { radius }) if !ringing.contains_key(&id) => {
                        ImpactTarget::Sphere { radius: *radius }
                    }
                    Some(_) => ImpactTarget::Object {
                        slot: *slots.entry(id).or_insert_with(|| {
                            objects.push(id);
                            objects.len() - 1
                        }),
                    },
                };
                // A body without modes needs only the change of its velocities.
                let most = if ringing.contains_key(&id) { usize::MAX } else { 1 };
                let events = ImpactEvent::of_side(target, pulse, side).take(most);
                impacts.extend(events.map(|event| (id, event)));
            }
        }
        impacts.sort_by(|(_, a), (_, b)| a.time.total_cmp(&b.time));
        let ringing =
            objects.iter().copied().enumerate().filter(|(_, id)| ringing.contains_key(id)).collect();
        Ok(EventSchedule { objects, impacts, poses, ringing })
    }

    /// When a body exists.
    pub fn life(&self, body: BodyId) -> Life {
        self.poses.life(body)
    }

    /// Where a body is at a time \[s\], and how it moves.
    pub fn moving(&self, body: BodyId, time: f64) -> Moving {
        Moving::of(&self.poses, body, time)
    }

    /// An engine as these options ask for, for a listener who hears everything, however far.
    pub fn engine_settings(
        &self,
        options: &RenderOptions,
        listener: &Listener,
        sample_rate: SampleRate,
    ) -> EngineSettings {
        let usual = EngineSettings::default();
        let distance = |(_, impact): &(BodyId, ImpactEvent)| {
            (0..listener.receivers.len())
                .map(|receiver| {
                    listener.receiver_position(receiver, impact.time).distance(impact.pose.position)
                })
                .fold(0.0, f64::max)
        };
        EngineSettings {
            sample_rate,
            acoustics: options.synthesis.acoustics,
            profile: options.contact.forces.profile,
            receivers: listener.receivers.len(),
            reach: usual.reach.max(1.5 * self.impacts.iter().map(distance).fold(0.0, f64::max)),
            objects: self.objects.len(),
            // A body that settles hits with all its contact points at once, each with its own force. The
            // engine has a core to itself here.
            budget: Budget { impacts: 64, ..usual.budget },
            ..usual
        }
    }

    /// An engine with everything in its slots.
    ///
    /// # Errors
    /// [`SynthesisError`] for settings that cannot be.
    pub fn engine(
        &self,
        models: &[SoundModel],
        ringing: &BTreeMap<BodyId, Arc<ModalSource>>,
        settings: &EngineSettings,
    ) -> Result<(Controller, Engine), SynthesisError> {
        let (mut controller, mut engine) = engine(settings)?;
        for (slot, id) in self.objects.iter().enumerate() {
            let click = models.get(id.index()).map(|model| model.acceleration.source.clone());
            let object = SoundingObject::new(click, ringing.get(id).cloned(), settings);
            // There is room: every block takes what there is.
            let _ = controller.put(slot, Some(object));
            if slot % 1024 == 0 {
                engine.render(1);
            }
        }
        engine.render(1);
        Ok((controller, engine))
    }
}
