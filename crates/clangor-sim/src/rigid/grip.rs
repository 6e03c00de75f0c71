//! Grips: hands that lead bodies along tracks with a limited force.
//!
//! In each step a grip drives a body with an impulse λ and an angular impulse Λ toward the velocities that
//! bring it onto its track X(t) at the middle of the next step:
//!
//! `v = (X(t + Δt) − X(t)) / Δt + e`, `|e| ≤ |d| / Δt` and `|e| ≤ 0.7 √(2 a |d|)`
//!
//! for a lag d from the track, with a = P/m: it catches up as fast as the force P can still brake. The hand
//! carries the weight of the body. On its track, `|d| ≤ P Δt²/m`, what the mass takes to follow is free too.
//! Beyond these `|λ| ≤ P Δt`, and `|Λ| ≤ P R Δt` with the bounding radius R. A body that something keeps from
//! its track is therefore pressed against it by P.
//!
//! In an impact a gripped body bounces with its own mass: a hand does little in so short a time.

use clangor_core::pose::Pose;
use glam::{DMat3, DVec3};

use super::mover::{Kick, Mover};
use super::pair::Step;
use super::state::BodyState;
use super::step_log::StepLog;

/// Part of the braking speed that is used, so that the last steps do not overshoot.
const CAUTION: f64 = 0.7;

/// Lags from the track that are none \[m, or rad\].
const ROUNDING: f64 = 1e-9;

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
        let lag = [now.position - state.mid_position, state.middle_pose().rotation_to(&now)];
        let (ahead, before) = (rates(&now, &next, step.length), rates(&last, &now, step.length));
        let couple = press * radius;
        let slowest = (0..3).map(|k| inertia.col(k).length()).fold(0.0, f64::max);
        // Accelerations that the force allows.
        let fastest = [press / mass, couple / slowest];
        let catch_up = |k: usize| {
            let braking = CAUTION * (2.0 * fastest[k] * lag[k].length()).sqrt();
            (lag[k] / step.length).clamp_length_max(braking)
        };
        let goal = [ahead[0] + catch_up(0), ahead[1] + catch_up(1)];
        let on_track = |k: usize| {
            let within = fastest[k] * step.length * step.length + ROUNDING;
            if lag[k].length() <= within { ahead[k] - before[k] } else { DVec3::ZERO }
        };
        let weight = mass * step.gravity * step.length;
        let free = [mass * on_track(0) - weight, inertia * on_track(1)];
        let most = [press * step.length, couple * step.length];
        Some(Grip { body, mass, inertia, goal, free, most, impulse: [DVec3::ZERO; 2] })
    }

    /// Begins with the impulses of the last step, as far as they are possible in this one, and returns what
    /// they change.
    pub(super) fn begin_with(&mut self, last: &[Grip], movers: &mut [Mover]) -> [Kick; 1] {
        if let Some(last) = last.iter().find(|last| last.body == self.body) {
            for k in 0..2 {
                self.impulse[k] = self.bounded(k, last.impulse[k]);
            }
        }
        let [impulse, angular] = self.impulse;
        movers[self.body].push(impulse, angular);
        [(self.body, impulse, angular)]
    }

    fn bounded(&self, k: usize, wanted: DVec3) -> DVec3 {
        self.free[k] + (wanted - self.free[k]).clamp_length_max(self.most[k])
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
            let bounded = self.bounded(k, wanted[k]);
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
        let time = step.time + 0.5 * step.length;
        let ends = [(Some(self.body), DVec3::ZERO), (None, DVec3::ZERO)];
        log.link(time, ends, (state.mid_position, state.velocity), (self.impulse[0], self.impulse[1]));
    }
}

/// Mean velocity and angular velocity between two poses.
fn rates(from: &Pose, to: &Pose, duration: f64) -> [DVec3; 2] {
    [(to.position - from.position) / duration, from.rotation_to(to) / duration]
}
