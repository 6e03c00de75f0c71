//! The events of a replay: impacts, poses and ends of the bodies in the slots of the real-time engine.

use std::collections::BTreeMap;
use std::sync::Arc;

use clangor_core::body::BodyId;
use clangor_core::contact::{BodyPulse, ImpactPulse};
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::pose::Pose;
use clangor_core::realtime::event_row::{ROW, encode};
use clangor_core::realtime::{Event, ImpactEvent, ImpactTarget};
use clangor_core::synthesis::modal::ModalSource;

use super::Replay;
use super::sounds::{Slot, Sounds};
use crate::stages::event_schedule::Moving;
use crate::stages::render::{Forces, impacts_on};

/// Largest distance of a modal body from the position extrapolated from its last pose event \[m\].
const LARGEST_STEP: f64 = 2e-4;
/// Largest angle from the extrapolated orientation \[rad\].
const LARGEST_TURN: f64 = 5e-3;
/// Interval of the comparison with the extrapolated pose \[s\].
const LOOK_EVERY: f64 = 1.0 / 480.0;

/// An event with its time \[s\] and body.
struct TimedEvent {
    time: f64,
    body: BodyId,
    event: Event,
}

/// The share of a body in an impact, and whether it changes the velocity of the body.
struct Moved<'a> {
    share: &'a BodyPulse,
    velocity: bool,
}

/// A load at a point of the surface.
struct PointLoad {
    point: DVec3,
    impulse: DVec3,
}

/// The rows of all events, in order of time.
pub(super) fn event_rows(sounds: &Sounds, replay: &Replay<'_>, forces: &Forces) -> Vec<[f64; ROW]> {
    let mut events = Vec::new();
    for id in sounds.rings.keys() {
        add_poses(sounds, *id, replay, forces, &mut events);
    }
    add_impacts(sounds, replay, forces, &mut events);
    for (id, (slot, _)) in &sounds.rings {
        let time = replay.bodies[id.index()].life.death;
        if time.is_finite() {
            events.push(TimedEvent { time, body: *id, event: Event::End { slot: *slot, time } });
        }
    }
    // The sort is stable: poses stay before the impacts of their time.
    events.sort_by(|a, b| a.time.total_cmp(&b.time));
    events.iter().filter_map(|timed| encode(&timed.event, timed.body.0)).collect()
}

/// Adds the impacts: on each body one for its acceleration noise, and one per point of contact for its modes.
fn add_impacts(sounds: &Sounds, replay: &Replay<'_>, forces: &Forces, events: &mut Vec<TimedEvent>) {
    // For each modal body, the impacts on it in order, with the durations that its modes feel.
    let felt = |(id, source): (&BodyId, &Arc<ModalSource>)| {
        (*id, impacts_on(*id, source, &forces.pulses, replay.limit_energy).0.into_iter())
    };
    let mut felt: BTreeMap<BodyId, _> = replay.ringing.iter().map(felt).collect();
    for pulse in &forces.pulses {
        for (share, sign) in pulse.bodies.iter().zip([1.0, -1.0]) {
            let Some(share) = share else { continue };
            if let Some(target) = sounds.clicks.get(&share.body) {
                let rotation = match target {
                    ImpactTarget::Sphere { .. } => DQuat::IDENTITY,
                    ImpactTarget::Object { slot } => sounds.slots[*slot].rotation,
                };
                let whole = Moved { share, velocity: true };
                let load = PointLoad { point: pulse.point, impulse: DVec3::ZERO };
                events.push(impact(*target, rotation, pulse, &whole, load));
            }
            let Some((slot, places)) = sounds.rings.get(&share.body) else { continue };
            let Some(felt) = felt.get_mut(&share.body).and_then(Iterator::next) else { continue };
            let still = Moved { share, velocity: false };
            for (point, impulse) in &pulse.points {
                let Some(at) = places.of(share.pose.body_from_world(*point)) else { continue };
                let place = share.pose.world_from_body(places.places[at]);
                let rotation = sounds.slots[*slot].rotation;
                let load = PointLoad { point: place, impulse: sign * *impulse };
                events.push(impact(ImpactTarget::Object { slot: *slot }, rotation, &felt, &still, load));
            }
        }
    }
}

/// Adds the poses of a modal body: at every impact, and whenever its pose deviates from the one extrapolated
/// from the last event; from the first impact until the vibration has decayed.
fn add_poses(
    sounds: &Sounds,
    id: BodyId,
    replay: &Replay<'_>,
    forces: &Forces,
    events: &mut Vec<TimedEvent>,
) {
    let Some((slot, _)) = sounds.rings.get(&id) else { return };
    let Slot { rotation, t60, .. } = &sounds.slots[*slot];
    let strikes = |pulse: &&ImpactPulse| pulse.bodies.iter().flatten().any(|share| share.body == id);
    let mut impacts = forces.pulses.iter().filter(strikes).map(|pulse| pulse.onset).peekable();
    let Some(first) = impacts.peek().copied() else { return };
    let last = forces.pulses.iter().filter(strikes).map(|pulse| pulse.onset).fold(first, f64::max);
    let longest = t60.iter().map(|row| row[1]).fold(0.0, f64::max);
    let end = replay.bodies[id.index()].life.death.min(replay.duration).min(last + longest);
    let mut reported: Option<(f64, Moving)> = None;
    let mut time = first;
    while time <= end {
        let impact = impacts.next_if(|impact| *impact <= time);
        let at = impact.unwrap_or(time);
        let pose = forces.poses.at(id, at);
        let off = reported.is_none_or(|(since, moving)| {
            let expected = moving.after(at - since);
            expected.position.distance(pose.position) > LARGEST_STEP
                || expected.orientation.angle_between(pose.orientation) > LARGEST_TURN
        });
        if impact.is_some() || off {
            let moving = Moving::of(&forces.poses, id, at);
            let event = Event::Pose {
                slot: *slot,
                time: at,
                pose: turned(moving.pose, *rotation),
                velocity: moving.velocity,
                angular_velocity: moving.angular_velocity,
            };
            events.push(TimedEvent { time: at, body: id, event });
            reported = Some((at, moving));
        }
        if impact.is_none() {
            time += LOOK_EVERY;
        }
    }
}

/// The pose of a sound model whose frame has this rotation in the frame of the body.
fn turned(pose: Pose, rotation: DQuat) -> Pose {
    Pose { position: pose.position, orientation: (pose.orientation * rotation).normalize() }
}

/// An impact on a sphere or on the object in a slot.
fn impact(
    target: ImpactTarget,
    rotation: DQuat,
    pulse: &ImpactPulse,
    moved: &Moved<'_>,
    load: PointLoad,
) -> TimedEvent {
    let Moved { share, velocity } = *moved;
    let [velocity_change, angular_velocity_change] = [share.velocity_change, share.angular_velocity_change]
        .map(|v| if velocity { v } else { DVec3::ZERO });
    let event = ImpactEvent {
        target,
        time: pulse.onset,
        duration: pulse.duration,
        pose: turned(share.pose, rotation),
        velocity_change,
        angular_velocity_change,
        point: load.point,
        impulse: load.impulse,
    };
    TimedEvent { time: pulse.onset, body: share.body, event: Event::Impact(event) }
}
