//! Impulses of contact lists against the recorded motion of the bodies: what a list gives to a body is the
//! jump of its momentum.
//!
//! ```text
//! Σ J = m (v₊ − v₋ − g Δt)        v₋, v₊: mean velocities of the intervals before it and after it
//! ```
//!
//! Looked at are free bodies without links and supports whose impacts lie in one interval, with none in those
//! beside it, where nothing lasts; and not those of soft contacts, which push for longer. A unit or a mass
//! that is wrong shows in the ratio. Not a check of the share that each of several points has.

use clangor_core::body::{BodyId, Motion, World};
use clangor_core::timeline::{ContactKind, ContactRow};
use glam::DVec3;

use super::recording::{Frame, RecordedBody};

/// Largest difference of the two, as a share of the larger.
const DIFFERENT: f64 = 0.5;

/// Part of the jump beyond the weight that shows that a push goes on.
const GOES_ON: f64 = 0.1;

/// Impacts of one body whose impulses are not those of its motion.
#[derive(Clone, Copy, Debug, Default)]
struct Doubt {
    count: u64,
    /// Of the worst: time \[s\], and impulses of list and motion [N s].
    worst: (f64, f64, f64),
    difference: f64,
}

/// What was found of each body of a world.
pub(crate) struct ListedImpulses {
    doubts: Vec<Doubt>,
}

impl ListedImpulses {
    /// Nothing yet.
    pub(crate) fn new(world: &World) -> Self {
        ListedImpulses { doubts: vec![Doubt::default(); world.bodies.len()] }
    }

    /// Looks at contacts in order of time, around which the frames of the bodies are known.
    pub(crate) fn look(&mut self, world: &World, contacts: &[ContactRow], recorded: &[RecordedBody]) {
        for RecordedBody { body, frames, .. } in recorded {
            let own = contacts.iter().filter(|row| [row.body_a, row.body_b].contains(body));
            let described = &world.bodies[body.index()];
            let is_linked = world.links.iter().any(|link| link.bodies().any(|end| end == *body));
            let is_free = matches!(described.motion, Motion::Free) && !is_linked;
            if !is_free || !described.supports.is_empty() || own.clone().next().is_none() {
                continue;
            }
            for impacts in in_intervals(own, frames) {
                let Some((given, moved, slack)) = compare(world, *body, frames, &impacts) else { continue };
                let difference = given.distance(moved);
                if difference <= DIFFERENT * given.length().max(moved.length()) + slack {
                    continue;
                }
                let doubt = &mut self.doubts[body.index()];
                doubt.count += 1;
                if difference > doubt.difference {
                    doubt.difference = difference;
                    doubt.worst = (impacts.rows[0].time, given.length(), moved.length());
                }
            }
        }
    }

    /// What should be known.
    pub(crate) fn notices(&self, world: &World) -> Vec<String> {
        let of_body = |(index, doubt): (usize, &Doubt)| {
            let (name, (time, given, moved)) = (&world.bodies[index].name, doubt.worst);
            let count = match doubt.count {
                1 => "an impact is not that".into(),
                count => format!("{count} impacts are not those"),
            };
            format!(
                "{name}: the impulse of {count} of its motion: at t = {time:.4} s the list gives \
                 {given:.3} N s and the poses {moved:.3} N s; the list is taken. See whether its unit and \
                 the mass are right"
            )
        };
        self.doubts.iter().enumerate().filter(|(_, doubt)| doubt.count > 0).map(of_body).collect()
    }
}

/// Contacts of a body within one interval of its frames.
struct Impacts<'a> {
    /// Index of the frame before.
    interval: usize,
    rows: Vec<&'a ContactRow>,
}

/// The contacts of a body by intervals, without those that have others in the intervals beside them.
fn in_intervals<'a>(rows: impl Iterator<Item = &'a ContactRow>, frames: &[Frame]) -> Vec<Impacts<'a>> {
    let mut all: Vec<Impacts<'a>> = Vec::new();
    for row in rows {
        let after = frames.partition_point(|frame| frame.time <= row.time);
        let Some(interval) = after.checked_sub(1) else { continue };
        match all.last_mut() {
            Some(last) if last.interval == interval => last.rows.push(row),
            _ => all.push(Impacts { interval, rows: vec![row] }),
        }
    }
    let intervals: Vec<usize> = all.iter().map(|impacts| impacts.interval).collect();
    let is_alone = |k: usize| {
        let far = |other: Option<&usize>| other.is_none_or(|other| other.abs_diff(intervals[k]) > 2);
        far(k.checked_sub(1).and_then(|before| intervals.get(before))) && far(intervals.get(k + 1))
    };
    all.into_iter().enumerate().filter(|(k, _)| is_alone(*k)).map(|(_, impacts)| impacts).collect()
}

/// Impulses on a body by the list and by its motion, and what its weight may give in that time [N s].
fn compare(
    world: &World,
    body: BodyId,
    frames: &[Frame],
    impacts: &Impacts<'_>,
) -> Option<(DVec3, DVec3, f64)> {
    if impacts.rows.iter().any(|row| row.kind != ContactKind::Impact) {
        return None;
    }
    let around = frames.get(impacts.interval.checked_sub(1)?..impacts.interval + 3)?;
    let [a, b, c, d] = around else { return None };
    let mean = |from: &Frame, to: &Frame| {
        let velocity = (to.pose.position - from.pose.position) / (to.time - from.time);
        (velocity, 0.5 * (from.time + to.time))
    };
    let ((before, start), (after, end)) = (mean(a, b), mean(c, d));
    let (mass, gravity) = (world.bodies[body.index()].mass, world.gravity);
    let moved = mass * (after - before - gravity * (end - start));
    // A push that goes on in the next interval is not over.
    if let Some(next) = frames.get(impacts.interval + 3) {
        let (later, time) = mean(d, next);
        let goes_on = mass * (later - after - gravity * (time - end)).length();
        let weight = mass * gravity.length() * (time - end);
        if goes_on > GOES_ON * moved.length() + 2.0 * weight {
            return None;
        }
    }
    let on_body = |row: &&ContactRow| {
        let impulse = row.normal * row.impulse_n + row.impulse_t;
        if row.body_a == body { impulse } else { -impulse }
    };
    let given = impacts.rows.iter().map(on_body).sum();
    Some((given, moved, mass * gravity.length() * (end - start)))
}
