//! Whether a body that is at rest in its first frame is released there, or carried.
//!
//! A recording does not say how a body came to its first frame. One that is released at rest, falls and hits
//! before the second frame has two shares of one jump ([`jump_windows`](super::super)), but so has one that a
//! steady force F moves from rest, as a hand, a table or a hinge does. With the length h of a frame,
//!
//! ```text
//! Δ₀ = F h / 2m    Δ₁ = F h / m      as of an impact J = 3/2 F h after f = 2/3 of the frame
//! ```
//!
//! A fall differs from it in what it needs, in which n is the normal of the surface and t the instant:
//!
//! ```text
//! way           d₀ ≈ −½ g·n t²                  d₀: the gap at the first frame; 0 of what lies on a surface
//! restitution   Σ J u⁺ ≤ −e Σ J u⁻, e ≤ 1       u: normal velocities; a force F that keeps the body on a
//!                                               surface needs e = (3/2 − 2/3) / (2/3) = 5/4
//! ```
//!
//! or by how little it is above a surface, and how far it has dropped at the second frame (`part_of_drop`),
//! which says the instant as well. What does not fall is carried: it has no impact there, and no acceleration
//! of gravity before the second frame.
//!
//! Limits: of a body that stands on another one that falls with it, the gap to what stops both is not known.
//! If it bounces in its second frame and again before the third, which shares Δ₁ between both impacts, it is
//! taken to be carried.

use clangor_core::body::BodyId;
use glam::DVec3;

use super::reach::WIDEST;
use super::{Event, FitContact, Scene, Search};
use crate::motion::kinematics::Start;
use crate::motion::recording::RecordedBody;
use crate::motion::touching::touches;

/// Difference of the gap at the first frame from the way of the fall, over that way: half way to a gap of 0.
const OFF_WAY: f64 = 0.5;
/// The same that is rounding in 32-bit files \[m\].
const ROUNDING: f64 = 2e-5;
/// Least drop at the second frame of what bounces within the first, over the gap: that of a restitution of
/// 0.95.
const LEAST_DROP: f64 = 0.1;
/// Largest restitution with which an impact of a fall is believed: half way from 1 to that of a steady force.
const RESTITUTION: f64 = 1.125;

impl Scene<'_> {
    /// Notes how the bodies begin that seem to hit something before their second frames.
    pub(super) fn find_how_bodies_start(&mut self, recorded: &[RecordedBody], v_min: f64, noise: &[f64]) {
        let windows = self.windows_in_order(recorded, v_min, noise);
        let done = vec![false; windows.len()];
        let falls = |index: usize| {
            let event = self.event(&windows, index, &done, Search::All);
            event.is_some_and(|(event, _)| event.ends_a_fall(self))
        };
        let start = |index: usize| match self.part_of_drop(windows[index].body) {
            Some(part) => Start::Falls(part),
            None if falls(index) => Start::Unknown,
            None => Start::Carried,
        };
        let starts: Vec<usize> = (0..windows.len()).filter(|index| windows[*index].first == 0).collect();
        let found: Vec<Start> = starts.iter().map(|index| start(*index)).collect();
        for (index, start) in starts.into_iter().zip(found) {
            if let Some(kinematics) = &mut self.kinematics[windows[index].body.index()] {
                kinematics.start = start;
            }
        }
    }

    /// After which part of its first frame a body lands that is so little above a surface that it falls there
    /// within it, and at the second frame is lower by a part of that gap: it may have bounced by then.
    fn part_of_drop(&self, body: BodyId) -> Option<f64> {
        let kinematics = self.kinematics[body.index()].as_ref()?;
        let [start, end] = [0, 1].map(|frame| kinematics.frames[frame]);
        let one = self.placed(body, start.pose);
        let (way, length) = (end.pose.position - start.pose.position, end.time - start.time);
        let others = self.neighbours.of_body(body.index()).filter(|id| !self.move_as_one(body, *id));
        let others = others.filter_map(|id| self.member(id, None, start.time));
        let fall = 0.5 * kinematics.inertia.gravity * length * length;
        let parts = others.filter_map(|other| {
            let other = self.placed(other.body, other.state.pose);
            let size = one.sampled.radius.min(other.sampled.radius);
            let near = touches(one, other, (fall.length() + ROUNDING).min(WIDEST * size));
            // Where they meet first; what is farther from an edge is beside it.
            let first = near.into_iter().min_by(|a, b| a.gap.total_cmp(&b.gap))?;
            let (fall, drop) = (-fall.dot(first.normal), -way.dot(first.normal));
            let lands = (ROUNDING..fall).contains(&first.gap)
                && (LEAST_DROP * first.gap..first.gap + ROUNDING).contains(&drop);
            lands.then(|| (first.gap / fall).sqrt())
        });
        parts.min_by(f64::total_cmp)
    }
}

impl Event {
    /// Whether the body that began it can have fallen from rest in its first frame.
    fn ends_a_fall(&self, scene: &Scene<'_>) -> bool {
        let Some(start) = scene.kinematics[self.members[0].body.index()].as_ref() else { return false };
        let fall = start.released(self.time).pose.position - start.frames[0].pose.position;
        let changes: Vec<(DVec3, DVec3)> =
            (0..self.members.len()).map(|place| self.change_of(place)).collect();
        let (mut approach, mut separation) = (0.0, 0.0);
        for ((FitContact { bodies, point, normal, .. }, touch), impulse) in
            self.points.iter().zip(&self.impulses)
        {
            let push = impulse.dot(*normal);
            if push <= 0.0 {
                continue;
            }
            let way = fall.dot(*normal).abs();
            if bodies.contains(&0) && touch.gap.abs() > OFF_WAY * way + ROUNDING {
                return false;
            }
            let [a, b] = bodies.map(|place| {
                let (before, after) = (&self.members[place].state, changes[place]);
                let arm = *point - self.members[place].fit.centre;
                [before.velocity_at(*point), after.0 + after.1.cross(arm)].map(|v| v.dot(*normal))
            });
            approach -= push * (a[0] - b[0]);
            separation += push * (a[0] - b[0] + a[1] - b[1]);
        }
        approach > 0.0 && separation <= RESTITUTION * approach
    }
}
