//! Impacts within a step, at the instants at which balls meet on their paths.
//!
//! Meetings are found in closed form or by the search of [`approach`](super::super::approach), and resolved
//! by [`impact`](super::super::impact) in the order of time, two bodies each; the balls of an impact are then
//! predicted anew. An approach slower than g h is left to the next step, where the two are in lasting
//! contact; until then they overlap by at most 2 g h².
//!
//! A ball that has been hit [`MOST_HITS`] times waits in place for the next step, and so does a ball that
//! runs into it without an impact. This adds no energy and no overlap, but waiting balls lose time. The log
//! contains the impulses that hold them meanwhile.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use clangor_core::timeline::{ContactKind, ContactRow, PoseRow};
use glam::DVec3;

use super::{Ball, PLANE, Stepped};
use crate::SimulationError;
use crate::record::Recorder;
use crate::spheres::approach::{Approach, fall, meet, meet_uniform};
use crate::spheres::impact::{self, ImpulsePair, Member, Slow, Touch};

/// Impacts of a ball in one step after which it waits.
const MOST_HITS: u32 = 24;

/// A predicted meeting, ordered by time.
#[derive(Clone, Copy, Debug)]
struct Meeting {
    time: f64,
    pair: u32,
    /// Sum of the generations of the balls for which the prediction holds.
    generation: u32,
}

impl PartialEq for Meeting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Meeting {}

impl PartialOrd for Meeting {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Meeting {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.time.total_cmp(&other.time).then(self.pair.cmp(&other.pair))
    }
}

/// Buffers.
#[derive(Default)]
pub(super) struct Flight {
    meetings: BinaryHeap<Reverse<Meeting>>,
    impulse_pairs: Vec<ImpulsePair>,
}

impl Stepped {
    /// Resolves all impacts of a step. Returns their number.
    pub(super) fn resolve_impacts(&mut self, recorder: &mut Recorder<'_>) -> Result<u64, SimulationError> {
        self.flight.meetings.clear();
        for pair in 0..self.neighbours.pairs.len() {
            self.predict(pair, 0.0);
        }
        let mut impacts = 0;
        while let Some(Reverse(Meeting { time, pair, generation })) = self.flight.meetings.pop() {
            if generation == self.generation(pair as usize) {
                self.collide(pair as usize, time, recorder)?;
                impacts += 1;
            }
        }
        Ok(impacts)
    }

    fn generation(&self, pair: usize) -> u32 {
        let pair = &self.neighbours.pairs[pair];
        let of = |ball: u32| self.balls.get(ball as usize).map_or(0, |ball| ball.generation);
        of(pair.a).wrapping_add(of(pair.b))
    }

    /// Predicts the meeting of a pair in the rest of the step after `now`.
    fn predict(&mut self, index: usize, now: f64) {
        let pair = &self.neighbours.pairs[index];
        let a = &self.balls[pair.a as usize];
        let left = self.step - now;
        let slowest = self.impact_speed();
        let state = |ball: &Ball| {
            let (position, velocity) = ball.at(now);
            if ball.waits || !ball.moves() {
                (position, DVec3::ZERO, DVec3::ZERO)
            } else {
                (position, velocity, ball.acceleration)
            }
        };
        let (position, velocity, acceleration) = state(a);
        let met = if pair.b & PLANE == 0 {
            let b = &self.balls[pair.b as usize];
            if !a.moves() && !b.moves() {
                return;
            }
            let (other, other_velocity, other_acceleration) = state(b);
            let (d, w, pull) =
                (position - other, velocity - other_velocity, acceleration - other_acceleration);
            let reach = a.radius + b.radius;
            let way = (w.length() + 0.5 * pull.length() * left) * left;
            if d.length_squared() > (reach + way) * (reach + way) {
                return;
            }
            let distance = d.length();
            // In uniform relative motion the approach speed only decreases.
            if -d.dot(w) + pull.length() * left * distance < slowest * distance {
                return;
            }
            if pull == DVec3::ZERO {
                meet_uniform(d, w, reach).map(|s| (s, -(d + w * s).normalize_or_zero().dot(w)))
            } else if distance <= reach {
                Some((0.0, -d.dot(w) / distance))
            } else {
                let rate = |s: f64| {
                    let (d, w) = (d + (w + pull * (0.5 * s)) * s, w + pull * s);
                    (d.length() - reach, d.dot(w) / d.length())
                };
                match meet(rate, pull.length(), left) {
                    Approach::At(s) => Some((s, -rate(s).1)),
                    Approach::Never | Approach::Unclear(_) => None,
                }
            }
        } else {
            let plane = &self.planes[(pair.b & !PLANE) as usize];
            if !a.moves() {
                return;
            }
            let gap = plane.normal.dot(position) - plane.offset - a.radius;
            let (v, pull) = (plane.normal.dot(velocity), plane.normal.dot(acceleration));
            if gap <= 0.0 { Some((0.0, -v)) } else { fall(gap, v, pull).map(|s| (s, -(v + pull * s))) }
        };
        if let Some((s, approach)) = met
            && s <= left
            && approach >= slowest
        {
            let meeting = Meeting { time: now + s, pair: index as u32, generation: self.generation(index) };
            self.flight.meetings.push(Reverse(meeting));
        }
    }

    /// Resolves the impact of a pair at a time into the step.
    fn collide(
        &mut self,
        index: usize,
        time: f64,
        recorder: &mut Recorder<'_>,
    ) -> Result<(), SimulationError> {
        let pair = &self.neighbours.pairs[index];
        let (a, b) = (pair.a as usize, pair.b);
        let ends = [Some(a), (b & PLANE == 0).then_some(b as usize)];
        for ball in ends.into_iter().flatten() {
            self.balls[ball].bring_forward(time);
        }
        // Impulse of the pair.
        let (normal, depth) = self.normal(a, b);
        let (members, impulse) = self.reflect(index, ends, normal);
        let Some(ImpulsePair { normal: impulse_n, tangential: impulse_t, velocity, .. }) = impulse else {
            // One of the balls waits and they part: the ball that ran into it waits too.
            for ball in ends.into_iter().flatten() {
                self.halt(ball, time);
            }
            return Ok(());
        };
        // Log the impact with the states before it.
        let at = self.now + time;
        let row = ContactRow {
            time: at,
            body_a: self.body_of(a as u32),
            body_b: self.body_of(b),
            kind: ContactKind::Impact,
            point: self.balls[a].position - normal * self.balls[a].radius,
            normal,
            impulse_n,
            impulse_t,
            couple: DVec3::ZERO,
            velocity,
            depth,
            impact_id: 0,
            effective_mass: None,
        };
        let moving = ends.map(|ball| ball.filter(|ball| self.balls[*ball].free));
        let poses: Vec<PoseRow> = moving.into_iter().flatten().map(|ball| self.pose_row(ball, at)).collect();
        recorder.impact(&[row], &poses)?;
        // Apply the new velocities and predict anew.
        for (ball, member) in moving.into_iter().zip(&members) {
            if let Some(ball) = ball {
                self.redirect(ball, member, time);
            }
        }
        for ball in moving.into_iter().flatten() {
            self.predict_all(ball, time);
        }
        Ok(())
    }

    /// Velocities of the two bodies of a pair after their impact, and its impulse; `None` if they do not
    /// approach. `ends` are their balls, `normal` points from B to A.
    fn reflect(
        &mut self,
        pair: usize,
        ends: [Option<usize>; 2],
        normal: DVec3,
    ) -> ([Member; 2], Option<ImpulsePair>) {
        let mut members = ends.map(|ball| match ball {
            Some(ball) => {
                let Ball { velocity, omega, inverse_mass, inverse_inertia, .. } = self.balls[ball];
                Member { velocity, omega, inverse_mass, inverse_inertia, ..Member::IMMOVABLE }
            }
            None => Member::IMMOVABLE,
        });
        let [radius_a, radius_b] = ends.map(|ball| ball.map_or(0.0, |ball| self.balls[ball].radius));
        let touch = Touch {
            a: 0,
            b: 1,
            normal,
            arm_a: normal * -radius_a,
            arm_b: normal * radius_b,
            coefficients: self.neighbours.pairs[pair].coefficients,
            slow: 0.0,
            when_slow: Slow::Stay,
            lift: 0.0,
        };
        let impulse_pairs = &mut self.flight.impulse_pairs;
        impulse_pairs.clear();
        impact::reflect(&mut members, &[touch], 0.0, impulse_pairs);
        (members, impulse_pairs.first().copied())
    }

    /// Gives a ball its velocities after an impact at a time into the step.
    fn redirect(&mut self, ball: usize, after: &Member, time: f64) {
        self.wake(ball);
        let record = &mut self.balls[ball];
        record.since = time;
        (record.velocity, record.omega) = (after.velocity, after.omega);
        record.generation = record.generation.wrapping_add(1);
        record.hits += 1;
        if record.hits >= MOST_HITS {
            self.halt(ball, time);
        } else if !record.stays(self.step - time, self.gravity.length()) {
            self.search_neighbours(ball);
        }
    }

    /// Holds a ball in place until the next step.
    fn halt(&mut self, ball: usize, time: f64) {
        let record = &mut self.balls[ball];
        if record.moves() && !record.waits {
            record.waits = true;
            record.generation = record.generation.wrapping_add(1);
            self.predict_all(ball, time);
        }
    }

    fn predict_all(&mut self, ball: usize, time: f64) {
        for at in 0..self.neighbours.of(ball).len() {
            let pair = self.neighbours.of(ball)[at] as usize;
            self.predict(pair, time);
        }
    }

    /// Unit normal from B to A, and the overlap \[m\].
    pub(super) fn normal(&self, a: usize, b: u32) -> (DVec3, f64) {
        let one = &self.balls[a];
        if b & PLANE == 0 {
            let two = &self.balls[b as usize];
            let offset = one.position - two.position;
            (offset.normalize_or(DVec3::Y), one.radius + two.radius - offset.length())
        } else {
            let plane = &self.planes[(b & !PLANE) as usize];
            (plane.normal, one.radius + plane.offset - plane.normal.dot(one.position))
        }
    }
}
