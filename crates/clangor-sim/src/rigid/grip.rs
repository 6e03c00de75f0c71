//! Grips: hands that lead bodies along tracks with a limited force.
//!
//! In each step a grip drives a body with an impulse λ and an angular impulse Λ toward the velocities that
//! bring it onto its track X(t) at the middle of the next step:
//!
//! `v = (X(t + Δt) − X(t)) / Δt + e`, `|e| ≤ |d| / Δt` and `|e| ≤ √(2 a |d|)`
//!
//! for a lag d from the track, with a = P/m: it catches up as fast as the force P can still brake. What mass,
//! weight and the motion of the track take is free; beyond that `|λ| ≤ P Δt`, and `|Λ| ≤ P R Δt` with the
//! bounding radius R. A body that something keeps from its track is therefore pressed against it by P.
//!
//! Impacts are too short for a hand to matter: a gripped body bounces with its own mass.

use clangor_core::body::BodyId;
use clangor_core::pose::Pose;
use clangor_core::timeline::{ContactKind, ContactRow};
use glam::{DMat3, DVec3};

use super::mover::Mover;
use super::pair::Step;
use super::reactions::Kick;
use super::state::BodyState;
use super::step_log::{Impulse, StepLog};

/// Part of the braking speed that is used, so that the last steps do not overshoot.
const CAUTION: f64 = 0.7;

/// A grip in one step.
pub(super) struct Grip {
    body: usize,
    mass: f64,
    inertia: DMat3,
    /// Velocities to reach.
    goal: [DVec3; 2],
    /// Impulses that mass, weight and the track take.
    free: [DVec3; 2],
    /// Largest deviation from them \[N s, N m s\].
    most: [f64; 2],
    impulse: [DVec3; 2],
}

impl Grip {
    /// The grip on a body that is held; `before` is its mover at the middle of the step.
    pub(super) fn of(body: usize, state: &BodyState, step: &Step) -> Option<Self> {
        let (track, press) = state.grip()?;
        let (mass, radius) = (state.mass, state.radius);
        let middle = step.time + 0.5 * step.length;
        let inertia = state.world_inverse_inertia.inverse();
        let [last, now, next] =
            [middle - step.length, middle, middle + step.length].map(|time| track.sample(time).0);
        let lag = (now.position - state.mid_position, state.middle_pose().rotation_to(&now));
        let (led, turned) = (rates(&now, &next, step.length), rates(&last, &now, step.length));
        let catch_up = |lag: DVec3, acceleration: f64| {
            let braking = CAUTION * (2.0 * acceleration * lag.length()).sqrt();
            (lag / step.length).clamp_length_max(braking)
        };
        let couple = press * radius;
        let slowest = (0..3).map(|k| inertia.col(k).length()).fold(0.0, f64::max);
        let goal = [led[0] + catch_up(lag.0, press / mass), led[1] + catch_up(lag.1, couple / slowest)];
        let free =
            [mass * (led[0] - turned[0]) - mass * step.gravity * step.length, inertia * (led[1] - turned[1])];
        let most = [press * step.length, couple * step.length];
        Some(Grip { body, mass, inertia, goal, free, most, impulse: [DVec3::ZERO; 2] })
    }

    /// Drives the mover, and returns what it changed and the largest change of velocity \[m/s\].
    pub(super) fn relax(&mut self, movers: &mut [Mover]) -> (Kick, f64) {
        let mover = &mut movers[self.body];
        let wanted = [
            self.impulse[0] + self.mass * (self.goal[0] - mover.velocity),
            self.impulse[1] + self.inertia * (self.goal[1] - mover.spin),
        ];
        let mut change = [DVec3::ZERO; 2];
        for k in 0..2 {
            let bounded = self.free[k] + (wanted[k] - self.free[k]).clamp_length_max(self.most[k]);
            change[k] = bounded - self.impulse[k];
            self.impulse[k] = bounded;
        }
        mover.push(change[0], change[1]);
        ((self.body, change[0], change[1]), change[0].length() / self.mass)
    }

    /// Adds the impulse to the body.
    pub(super) fn apply(&self, bodies: &mut [BodyState]) {
        bodies[self.body].kick(self.impulse[0], self.impulse[1]);
    }

    pub(super) fn log(&self, bodies: &[BodyState], step: &Step, log: &mut StepLog) {
        let state = &bodies[self.body];
        let row = ContactRow {
            time: step.time + 0.5 * step.length,
            body_a: BodyId(self.body as u32),
            body_b: BodyId::WORLD,
            kind: ContactKind::Constraint,
            point: state.mid_position,
            normal: self.impulse[0].normalize_or_zero(),
            impulse_n: self.impulse[0].length(),
            impulse_t: DVec3::ZERO,
            couple: self.impulse[1],
            velocity: state.velocity,
            depth: 0.0,
            impact_id: 0,
        };
        log.begin(ContactKind::Constraint);
        log.impulse(Impulse { row, arm_a: DVec3::ZERO, arm_b: DVec3::ZERO });
        log.end();
    }
}

/// Mean velocity and angular velocity between two poses.
fn rates(from: &Pose, to: &Pose, duration: f64) -> [DVec3; 2] {
    [(to.position - from.position) / duration, from.rotation_to(to) / duration]
}
