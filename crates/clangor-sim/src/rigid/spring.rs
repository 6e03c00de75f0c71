//! Linear springs between points of bodies that a step follows, as explicit forces at its middle; others are
//! solved implicitly (`stiff_spring`).
//!
//! `F = −(k (l − l₀) + c l̇) e` along the unit vector e from the far end. With the positions of the middle
//! this is the leapfrog rule, stable while `Δt √(k/m) < 2`, m the effective mass at the ends; it is used
//! up to 1.
//!
//! Between two middles it keeps `½ m v² + ½ k e e⁺` of a linear oscillator with the extension e exactly. For
//! a spring that turns, or whose length passes through zero, or whose ends are at bodies that spin, the
//! impulses λ at the rates s add `λ (s⁻ + s⁺) / 2 + ½ k (e e⁺ − e⁻ e)` to that energy. The sum since the last
//! loss stays below [`SHARE`] of the energy: where an impulse would add more, one that adds less takes its
//! place (`Spring::chosen`), still along the spring.

use clangor_core::body::{BodyId, Link, LinkEnd};
use clangor_core::pose::Pose;
use clangor_core::timeline::{ContactKind, ContactRow};
use glam::DVec3;

use super::mover::Mover;
use super::pair::Step;
use super::state::BodyState;
use super::step_log::{Impulse, StepLog};

/// Part of the energy of a spring and of its ends that its steps may add to it before they take some.
const SHARE: f64 = 1e-3;

/// Bisections for an impulse.
const ROUNDS: u32 = 6;

/// A spring of the world.
pub(super) struct Spring {
    body: usize,
    at: DVec3,
    to: LinkEnd,
    rest_length: f64,
    stiffness: f64,
    damping: f64,
    ledger: Ledger,
}

/// The energy that a spring adds to its bodies.
#[derive(Clone, Copy, Default)]
struct Ledger {
    /// Extension at the last middle \[m\].
    extension: Option<f64>,
    /// Energy between the last middle and the one before, `½ k e⁻ e` \[J\].
    stored: f64,
    /// Work of the last impulse \[J\].
    work: f64,
    /// Sum of the gains since the last loss \[J\].
    excess: f64,
}

/// A spring at the middle of a step.
pub(super) struct Placed {
    near: DVec3,
    along: DVec3,
    arms: [DVec3; 2],
    extension: f64,
    /// Velocity of the extension before anything acts \[m/s\].
    rate: f64,
    impulse: f64,
}

impl Spring {
    /// The spring of a link, if it is one; `Err` has the body of one with a coefficient that is negative or
    /// not finite.
    pub(super) fn of_link(link: &Link) -> Result<Option<Self>, BodyId> {
        let &Link::Spring { body, at, to, rest_length, stiffness, damping } = link else { return Ok(None) };
        if ![rest_length, stiffness, damping].iter().all(|x| *x >= 0.0 && x.is_finite()) {
            return Err(body);
        }
        let (body, ledger) = (body.index(), Ledger::default());
        Ok(Some(Spring { body, at, to, rest_length, stiffness, damping, ledger }))
    }

    /// Indices of the bodies at its ends.
    pub(super) fn ends(&self) -> impl Iterator<Item = usize> {
        [Some(self.body), self.to.body().map(BodyId::index)].into_iter().flatten()
    }

    /// Its two ends at these poses: points, and arms.
    fn points(&self, pose: impl Fn(usize) -> Pose) -> [(DVec3, DVec3); 2] {
        let place = |body: usize, at: DVec3| {
            let pose = pose(body);
            let arm = pose.orientation * at;
            (pose.position + arm, arm)
        };
        let far = match self.to {
            LinkEnd::Point(point) => (point, DVec3::ZERO),
            LinkEnd::Body { body, at } => place(body.index(), at),
        };
        [place(self.body, self.at), far]
    }

    /// Velocity of the near end relative to the far one.
    fn velocity(&self, arms: [DVec3; 2], mover: impl Fn(usize) -> Mover) -> DVec3 {
        let far = self.to.body().map_or(DVec3::ZERO, |body| mover(body.index()).velocity_at(arms[1]));
        mover(self.body).velocity_at(arms[0]) - far
    }

    /// Places it at the middle of a step, before anything acts there; `None` where it has no direction.
    pub(super) fn place(&mut self, bodies: &[BodyState]) -> Option<Placed> {
        let [near, far] = self.points(|body| bodies[body].middle_pose());
        let between = near.0 - far.0;
        let extension = between.length() - self.rest_length;
        let Ledger { extension: last, stored, work, excess } = self.ledger;
        let started = || {
            let [near, far] = self.points(|body| bodies[body].start_pose());
            let start = near.0.distance(far.0) - self.rest_length;
            // As if it had moved alike before the start.
            (2.0 * start - extension) * extension * 0.5 * self.stiffness
        };
        let now = last.map_or_else(started, |last| 0.5 * self.stiffness * last * extension);
        let gain = if last.is_some() { work + now - stored } else { 0.0 };
        let excess = (excess + gain).max(0.0);
        self.ledger = Ledger { extension: Some(extension), stored: now, work: 0.0, excess };
        let arms = [near.1, far.1];
        let along = between.try_normalize()?;
        let rate = self.velocity(arms, |body| bodies[body].mover()).dot(along);
        Some(Placed { near: near.0, along, arms, extension, rate, impulse: 0.0 })
    }

    /// Applies and logs the impulse of one step.
    pub(super) fn pull(&self, placed: &mut Placed, bodies: &mut [BodyState], step: &Step, log: &mut StepLog) {
        let Placed { near, along, arms, .. } = *placed;
        let velocity = self.velocity(arms, |body| bodies[body].mover());
        placed.impulse = self.chosen(placed, velocity, bodies, step);
        let row = ContactRow {
            time: step.time + 0.5 * step.length,
            body_a: BodyId(self.body as u32),
            body_b: self.to.body().unwrap_or(BodyId::WORLD),
            kind: ContactKind::Constraint,
            point: near,
            normal: along,
            impulse_n: placed.impulse,
            impulse_t: DVec3::ZERO,
            couple: DVec3::ZERO,
            velocity,
            depth: 0.0,
            impact_id: 0,
            effective_mass: None,
        };
        let impulse = row.impulse();
        for (end, (impulse, arm)) in self.ends().zip([(impulse, arms[0]), (-impulse, arms[1])]) {
            bodies[end].push_for_step(impulse, arm.cross(impulse));
        }
        if log.skips_slower().is_none() {
            log.begin(ContactKind::Constraint);
            log.impulse(Impulse { row, arm_a: arms[0], arm_b: arms[1] });
            log.end();
        }
    }

    /// The impulse of one step: that of its force, unless it adds too much energy. Then the nearest one that
    /// does not, towards that of backward Euler's rule, or none, or the one that stops the ends along the
    /// spring; or the one of these that adds least.
    fn chosen(&self, placed: &Placed, velocity: DVec3, bodies: &[BodyState], step: &Step) -> f64 {
        let rate = velocity.dot(placed.along);
        let force = -(self.stiffness * placed.extension + self.damping * rate);
        let mobility = self.mobility(placed, bodies);
        let explicit = force * step.length;
        if mobility <= 0.0 {
            return explicit;
        }
        let energy = 0.5 * velocity.length_squared() / mobility
            + 0.5 * self.stiffness * placed.extension * placed.extension;
        let allowed = SHARE * energy - self.ledger.excess;
        let gain = |impulse: f64| self.gain(placed, (impulse, rate + mobility * impulse), bodies, step);
        let (mut best, mut least) = (explicit, gain(explicit));
        if least <= allowed {
            return explicit;
        }
        let softness = (self.stiffness * step.length + self.damping) * step.length;
        let implicit = -(self.stiffness * placed.extension * step.length + softness * rate)
            / (1.0 + mobility * softness);
        for target in [implicit, 0.0, -rate / mobility] {
            let lowest = gain(target);
            if lowest < least {
                (best, least) = (target, lowest);
            }
            if least <= allowed {
                let (mut near, mut far) = (0.0, 1.0);
                for _ in 0..ROUNDS {
                    let part = 0.5 * (near + far);
                    let kept = gain(explicit + part * (target - explicit)) <= allowed;
                    (near, far) = if kept { (near, part) } else { (part, far) };
                }
                return explicit + far * (target - explicit);
            }
        }
        best
    }

    /// Inverse effective mass along it \[1/kg\].
    fn mobility(&self, placed: &Placed, bodies: &[BodyState]) -> f64 {
        let of = |(end, arm): (usize, DVec3)| bodies[end].mover().inverse_mass_at(arm, placed.along);
        self.ends().zip(placed.arms).map(of).sum()
    }

    /// What an impulse, after which it grows at `rate`, would add to the energy, if nothing else acted.
    fn gain(&self, placed: &Placed, (impulse, rate): (f64, f64), bodies: &[BodyState], step: &Step) -> f64 {
        let pushed = |body: usize| {
            let mut mover = bodies[body].mover();
            for ((end, arm), sign) in self.ends().zip(placed.arms).zip([1.0, -1.0]) {
                if end == body {
                    let push = placed.along * (sign * impulse);
                    mover.push(push, arm.cross(push));
                }
            }
            mover
        };
        let [near, far] = self.points(|body| bodies[body].next_middle(&pushed(body), step.time, step.length));
        let next = near.0.distance(far.0) - self.rest_length;
        let stored = 0.5 * self.stiffness * placed.extension * next;
        0.5 * impulse * (placed.rate + rate) + stored - self.ledger.stored
    }

    /// Energy at the end of a step \[J\], where `next` gives the poses at the middle of the next one.
    pub(super) fn stored(&self, next: impl Fn(usize) -> Pose) -> f64 {
        let [near, far] = self.points(next);
        let extension = near.0.distance(far.0) - self.rest_length;
        0.5 * self.stiffness * extension * self.ledger.extension.unwrap_or(extension)
    }

    /// Ends the step of a spring that was placed.
    pub(super) fn end(&mut self, placed: &Placed, bodies: &[BodyState]) {
        let rate = self.velocity(placed.arms, |body| bodies[body].mover()).dot(placed.along);
        self.ledger.work = 0.5 * placed.impulse * (placed.rate + rate);
    }
}
