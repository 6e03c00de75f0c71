//! The events of a replay: impacts, poses and ends of the bodies in the slots of the real-time engine.

use clangor_core::body::BodyId;
use clangor_core::contact::ImpactPulse;
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::pose::Pose;
use clangor_core::realtime::event_row::{ROW, RowEncoder};
use clangor_core::realtime::{Event, ImpactEvent, ImpactTarget};

use super::Replay;
use super::sounds::{Slot, Sounds};
use crate::stages::event_schedule::Moving;
use crate::stages::render::Forces;

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

/// The rows of all events, in order of time, those of a force history before its first impact.
pub(super) fn event_rows(sounds: &Sounds, replay: &Replay<'_>, forces: &Forces) -> Vec<[f64; ROW]> {
    let mut events = Vec::new();
    for id in sounds.rings.keys() {
        add_poses(sounds, *id, replay, forces, &mut events);
    }
    add_impacts(sounds, forces, &mut events);
    for (id, (slot, _)) in &sounds.rings {
        let time = replay.bodies[id.index()].life.death;
        if time.is_finite() {
            events.push(TimedEvent { time, body: *id, event: Event::End { slot: *slot, time } });
        }
    }
    // The sort is stable: poses stay before the impacts of their time.
    events.sort_by(|a, b| a.time.total_cmp(&b.time));
    let mut encoder = RowEncoder::default();
    events.iter().flat_map(|timed| encoder.encode(&timed.event, timed.body.0)).collect()
}

/// Adds the impacts: on each body one for its acceleration noise, and one per point of contact for its modes.
fn add_impacts(sounds: &Sounds, forces: &Forces, events: &mut Vec<TimedEvent>) {
    for pulse in &forces.pulses {
        for (side, share) in pulse.bodies.iter().enumerate() {
            let Some(share) = share else { continue };
            let events_on = |target| ImpactEvent::of_side(target, pulse, side);
            let in_frame = |rotation, event: ImpactEvent| {
                let event = event.with_pose(turned(share.pose, rotation));
                TimedEvent { time: event.time, body: share.body, event: Event::Impact(event) }
            };
            if let Some(target) = sounds.clicks.get(&share.body) {
                let rotation = match target {
                    ImpactTarget::Sphere { .. } => DQuat::IDENTITY,
                    ImpactTarget::Object { slot } => sounds.slots[*slot].rotation,
                };
                let whole =
                    events_on(*target).take(1).map(|event| event.with_impulse(pulse.point, DVec3::ZERO));
                events.extend(whole.map(|event| in_frame(rotation, event)));
            }
            let Some((slot, places)) = sounds.rings.get(&share.body) else { continue };
            let rotation = sounds.slots[*slot].rotation;
            for event in events_on(ImpactTarget::Object { slot: *slot }) {
                let Some(at) = places.of(share.pose.body_from_world(event.point)) else { continue };
                let place = share.pose.world_from_body(places.places[at]);
                let impulse = event.impulse;
                let still =
                    event.with_velocity_changes(DVec3::ZERO, DVec3::ZERO).with_impulse(place, impulse);
                events.push(in_frame(rotation, still));
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
