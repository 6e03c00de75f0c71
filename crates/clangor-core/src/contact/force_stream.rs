//! Contact forces too weak to be impacts (rolling, sliding, impacts slower than v_min) as one impulse per
//! time step.
//!
//! They excite modes only: a rolling body makes no click. The dynamics compute them once per time step of
//! length h, so they are valid forces only below 1/(2h). The modal voice limits their band to that frequency.
//!
//! The static load on a body is no sound. The mean force over 50 ms is subtracted from the impulses J of each
//! pair, each of which acts for one step,
//!
//! ```text
//! J'(t) = J(t) − h F̄(t),   F̄(t) = (1/50 ms) Σ J over −25 ms ≤ t' − t < 25 ms
//! ```
//!
//! in equal parts at all contact points of the step. Steps without contact are skipped. Contacts of bodies
//! almost at rest are silent, because forces at rest are artefacts of the solver.

use std::collections::BTreeMap;

use glam::DVec3;

use super::pulses::whole_impacts;
use super::row_checks::check_row;
use super::{ContactError, PoseHistory};
use crate::body::{Body, BodyId};
use crate::timeline::{ContactKind, ContactRow};

/// Time over which forces are averaged \[s\].
const MEAN_TIME: f64 = 0.05;
/// Time before and after an instant over which the motion of a body is measured \[s\].
const WATCH_TIME: f64 = 0.005;

/// Settings that select the contacts of a stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StreamSettings {
    /// Approach speed from which on a contact is an impact [m/s]; the same as in
    /// [`ContactSettings`](super::ContactSettings).
    pub v_min: f64,
    /// Time step h of the dynamics \[s\].
    pub time_step: f64,
    /// Surface speed of a pair below which it counts as at rest and only adds damping [m/s].
    pub rest_speed: f64,
}

/// Contact forces on one body within a time step.
#[derive(Clone, Debug, PartialEq)]
pub struct StreamedForce {
    /// Time of the step \[s\].
    pub time: f64,
    /// The body.
    pub body: BodyId,
    /// Contact points.
    pub points: Vec<StreamPoint>,
}

/// One point of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StreamPoint {
    /// Place [m, frame of the body].
    pub place: DVec3,
    /// Impulse J' [N s, frame of the body]; 0 at rest.
    pub impulse: DVec3,
    /// Unit normal, frame of the body.
    pub normal: DVec3,
}

/// Forces on all bodies that contacts can move, in order of time.
///
/// # Errors
/// Unknown bodies, numbers that are not finite.
pub fn force_stream(
    bodies: &[Body],
    rows: &[ContactRow],
    poses: &PoseHistory,
    settings: &StreamSettings,
) -> Result<Vec<StreamedForce>, ContactError> {
    rows.iter().try_for_each(|row| check_row(bodies, row))?;
    // Rows of weak contacts, by pair of bodies.
    let mut pairs: BTreeMap<(BodyId, BodyId), Vec<ContactRow>> = BTreeMap::new();
    let gentle = rows.iter().filter(|row| row.kind == ContactKind::Contact && row.impact_id == 0).copied();
    for row in gentle.chain(slow_impacts(rows, settings.v_min)) {
        pairs.entry((row.body_a, row.body_b)).or_default().push(row);
    }
    // Steps of the same time have the same bits.
    let mut forces: BTreeMap<(u64, BodyId), StreamedForce> = BTreeMap::new();
    for mut rows in pairs.into_values() {
        rows.sort_by(|a, b| a.time.total_cmp(&b.time));
        let steps: Vec<&[ContactRow]> = rows.chunk_by(|a, b| a.time == b.time).collect();
        // Impulses of each step without the mean force; 0 for bodies at rest.
        for (step, mean) in steps.iter().zip(means(&steps, settings.time_step)) {
            let time = step[0].time;
            let share = mean * settings.time_step / step.len() as f64;
            let ids = [step[0].body_a, step[0].body_b];
            let moves = ids.iter().any(|id| speed(bodies, poses, *id, time) >= settings.rest_speed);
            for (id, sign) in ids.into_iter().zip([1.0, -1.0]) {
                if id == BodyId::WORLD || bodies[id.index()].surface.is_plane() {
                    continue;
                }
                // Contact points in the frame of the body.
                let pose = poses.at(id, time);
                let to_body = pose.orientation.inverse();
                let point = |row: &ContactRow| StreamPoint {
                    place: pose.body_from_world(row.point),
                    impulse: if moves { to_body * ((row.impulse() - share) * sign) } else { DVec3::ZERO },
                    normal: to_body * row.normal,
                };
                forces
                    .entry((order(time), id))
                    .or_insert_with(|| StreamedForce { time, body: id, points: Vec::new() })
                    .points
                    .extend(step.iter().map(point));
            }
        }
    }
    Ok(forces.into_values().collect())
}

/// The rows of contacts that are not impacts.
fn slow_impacts(rows: &[ContactRow], v_min: f64) -> Vec<ContactRow> {
    let speed = |impact: &[ContactRow]| {
        let time = impact.iter().map(|row| row.time).fold(f64::INFINITY, f64::min);
        let first = impact.iter().filter(|row| row.time == time);
        first.map(ContactRow::approach_speed).fold(0.0, f64::max)
    };
    whole_impacts(rows).into_iter().filter(|impact| speed(impact) < v_min).flatten().collect()
}

/// Share of a step by which the time of the mean is shifted, so that rounding does not decide which of the
/// steps at its two ends belong to it: a steady load would flicker.
const CLEAR_OF_STEPS: f64 = 1e-3;

/// F̄ [N] at each step.
fn means(steps: &[&[ContactRow]], time_step: f64) -> Vec<DVec3> {
    let clear = CLEAR_OF_STEPS * time_step;
    let impulse = |step: &[ContactRow]| step.iter().map(ContactRow::impulse).sum::<DVec3>();
    let (mut from, mut to) = (0, 0);
    let mut means = Vec::with_capacity(steps.len());
    for step in steps {
        let time = step[0].time;
        while steps[from][0].time < time - 0.5 * MEAN_TIME - clear {
            from += 1;
        }
        while to < steps.len() && steps[to][0].time < time + 0.5 * MEAN_TIME - clear {
            to += 1;
        }
        // Summed anew for each step: a running sum would keep the rounding of past forces.
        means.push(steps[from..to].iter().map(|step| impulse(step)).sum::<DVec3>() / MEAN_TIME);
    }
    means
}

/// Upper bound of the surface speed of a body [m/s], by differences of its pose around the time.
fn speed(bodies: &[Body], poses: &PoseHistory, id: BodyId, time: f64) -> f64 {
    if id == BodyId::WORLD {
        return 0.0;
    }
    let [before, after] = [-WATCH_TIME, WATCH_TIME].map(|step| poses.at(id, time + step));
    let angle = before.orientation.angle_between(after.orientation);
    let reach = bodies[id.index()].surface.bounding_radius();
    let turned = if reach.is_finite() { angle * reach } else { 0.0 };
    ((after.position - before.position).length() + turned) / (2.0 * WATCH_TIME)
}

/// Bits of a time, in ascending order of times.
fn order(time: f64) -> u64 {
    let bits = time.to_bits();
    if time.is_sign_negative() { !bits } else { bits | (1 << 63) }
}
