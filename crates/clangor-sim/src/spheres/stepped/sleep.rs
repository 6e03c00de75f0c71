//! Sleep: a ball that has been at rest for a while is held fixed until something moves it.
//!
//! A ball falls asleep when it has been slower than [`SLEEPY`] for [`QUIET_TIME`] in lasting contact, and
//! everything that it touches is as quiet. A sleeping ball counts as fixed in lasting contacts. It wakes at
//! an impact, when a touching ball moves faster than [`WAKING`], or when something that it touched is gone.

use clangor_core::body::BodyId;
use clangor_core::timeline::{ContactKind, ContactRow};
use glam::DVec3;

use super::{PLANE, Stepped};
use crate::SimulationError;
use crate::record::Recorder;

/// Speeds of the centre and of the surface below which a ball is quiet \[m/s\].
const SLEEPY: f64 = 3e-3;
/// Time below these speeds after which a ball falls asleep \[s\].
const QUIET_TIME: f64 = 0.3;
/// Speed at which a ball wakes what it touches \[m/s\].
const WAKING: f64 = 1.5e-2;

impl Stepped {
    /// Wakes a ball and restarts its time to fall asleep.
    pub(super) fn wake(&mut self, ball: usize) {
        let ball = &mut self.balls[ball];
        if std::mem::take(&mut ball.asleep) {
            (ball.velocity, ball.omega, ball.acceleration) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
            ball.generation = ball.generation.wrapping_add(1);
        }
        ball.quiet = 0;
    }

    /// Puts balls to sleep and wakes them at the end of a step.
    pub(super) fn fall_asleep(&mut self, recorder: &mut Recorder<'_>) -> Result<(), SimulationError> {
        for ball in self.balls.iter_mut().filter(|ball| ball.moves()) {
            let speed = ball.velocity.length_squared();
            let rim = ball.omega.length_squared() * ball.radius * ball.radius;
            let held = ball.acceleration == DVec3::ZERO && self.gravity != DVec3::ZERO;
            ball.quiet =
                if held && speed.max(rim) < SLEEPY * SLEEPY { ball.quiet.saturating_add(1) } else { 0 };
        }
        self.wake_touched();
        let patience = (QUIET_TIME / self.step) as u32;
        for ball in 0..self.balls.len() {
            if !self.balls[ball].moves() || self.balls[ball].quiet < patience {
                continue;
            }
            let restless = |at: &u32| {
                let pair = &self.neighbours.pairs[*at as usize];
                let other = if pair.a as usize == ball { pair.b } else { pair.a };
                let other = self.balls.get(other as usize);
                pair.hold.normal > 0.0
                    && other.is_some_and(|other| other.moves() && other.quiet < patience / 2)
            };
            if self.neighbours.of(ball).iter().any(restless) {
                continue;
            }
            if !recorder.ignores_slow_contacts() {
                recorder.contact(&[self.last_impulse(ball)], &[])?;
            }
            let record = &mut self.balls[ball];
            (record.velocity, record.omega, record.asleep) = (DVec3::ZERO, DVec3::ZERO, true);
        }
        Ok(())
    }

    /// Wakes the sleeping balls that a fast ball touches, and those that have lost a contact.
    fn wake_touched(&mut self) {
        let far = 2.0 * self.impact_speed() * self.step;
        for index in 0..self.neighbours.pairs.len() {
            let pair = &self.neighbours.pairs[index];
            if pair.b & PLANE != 0 {
                continue;
            }
            let (a, b) = (pair.a as usize, pair.b as usize);
            let sleeper = match (self.balls[a].asleep, self.balls[b].asleep) {
                (true, false) => a,
                (false, true) => b,
                _ => continue,
            };
            let other = a + b - sleeper;
            let gap = -self.normal(a, pair.b).1;
            let lost = pair.hold.normal > 0.0 && gap > far;
            let fast = self.balls[other].velocity.length_squared() > WAKING * WAKING;
            if lost || fast && gap < far && self.balls[other].moves() {
                self.wake(sleeper);
            }
        }
    }

    /// Momentum that a ball loses when it falls asleep.
    fn last_impulse(&self, ball: usize) -> ContactRow {
        let ball = &self.balls[ball];
        ContactRow {
            time: self.now,
            body_a: BodyId(ball.body),
            body_b: BodyId::WORLD,
            kind: ContactKind::Sleep,
            point: ball.position,
            normal: DVec3::Y,
            impulse_n: -ball.mass * ball.velocity.y,
            impulse_t: DVec3::new(ball.velocity.x, 0.0, ball.velocity.z) * -ball.mass,
            couple: ball.omega * (-1.0 / ball.inverse_inertia),
            velocity: ball.velocity,
            depth: 0.0,
            impact_id: 0,
            effective_mass: None,
        }
    }
}
