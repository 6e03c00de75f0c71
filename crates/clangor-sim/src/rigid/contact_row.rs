//! One contact point in the contact phase: whether it bears in a step, its effective masses, and the solve of
//! its impulses with all other points held fixed.
//!
//! `λ_n ≥ 0` brings the normal velocity to its target; `|λ_t| ≤ μ λ_n` and the couple `|c| ≤ ρ λ_n` drive
//! slip and relative rotation to zero as far as they can. The masses of bodies with joints include the
//! reactions.

use glam::DVec3;

use super::impact_threshold::{MAX_HITS, bend, rest_speed};
use super::manifold::tangents;
use super::mover::{Kick, Mover};
use super::pair::{Pair, SLOP, Step};
use super::reactions::Reactions;
use super::state::BodyState;

/// Fraction of an overlap that is removed per step.
const PUSH_FRACTION: f64 = 0.2;
/// Largest speed of that correction \[m/s\].
const PUSH_SPEED: f64 = 5e-3;
/// The same for a contact that arrives fast by rolling or sliding: fractions of the overlap and of its
/// approach speed.
const FAST_PUSH_FRACTION: f64 = 1.0;
const FAST_PUSH: f64 = 0.2;
/// Open points that separate faster than this take no part \[m/s\].
const PARTING: f64 = 0.05;

/// One contact point in the solve.
pub(super) struct Row {
    pub(super) a: usize,
    pub(super) b: usize,
    pub(super) pair: usize,
    pub(super) point: usize,
    pub(super) normal: DVec3,
    pub(super) tangents: [DVec3; 2],
    pub(super) arm_a: DVec3,
    pub(super) arm_b: DVec3,
    /// Effective mass along the normal and the tangents \[kg\].
    pub(super) mass: [f64; 3],
    /// Change of the tangential velocities by a unit normal impulse \[1/kg\].
    pub(super) coupling: [f64; 2],
    /// Least normal velocity after the step \[m/s\].
    pub(super) target: f64,
    pub(super) friction: f64,
    pub(super) rolling_loss: f64,
    /// Lower bound of the moment of inertia that resists the couple \[kg m²\].
    pub(super) rolling_inertia: f64,
    pub(super) impulse: [f64; 3],
    pub(super) couple: DVec3,
    pub(super) before: DVec3,
    pub(super) gap: f64,
    /// Whether a body has joints.
    pub(super) linked: bool,
}

/// What the rows of one pair have in common.
pub(super) struct PairContext<'a> {
    index: usize,
    /// The bodies, without what hands do in this step.
    bodies: (&'a BodyState, &'a BodyState),
    mover_a: &'a Mover,
    mover_b: &'a Mover,
    movers: &'a [Mover],
    reactions: &'a Reactions,
    tangents: [DVec3; 2],
    /// Half of the step \[s\].
    half: f64,
    /// Change of the normal velocity by gravity in the step \[m/s\].
    fall: f64,
    /// Approach below which contact is resting contact \[m/s\].
    rest: f64,
    /// Distance by which rotation may bend the path of a point in half a step \[m\].
    bent: f64,
    /// Whether a hand leads a body with limited force.
    gripped: bool,
    /// Sum of the norms of the columns of both inverse inertias \[1/(kg m²)\].
    stiffest: f64,
}

impl<'a> PairContext<'a> {
    pub(super) fn new(
        index: usize,
        pair: &Pair,
        (body_a, body_b): (&'a BodyState, &'a BodyState),
        (movers, reactions): (&'a [Mover], &'a Reactions),
        step: &Step,
    ) -> Self {
        let (mover_a, mover_b) = (&movers[pair.key.a as usize], &movers[pair.key.b as usize]);
        let (t1, t2) = tangents(pair.normal);
        let half = 0.5 * step.length;
        let fall =
            (body_a.gravity(step.gravity) - body_b.gravity(step.gravity)).dot(pair.normal) * step.length;
        let spin = mover_a.inverse_inertia + mover_b.inverse_inertia;
        PairContext {
            index,
            bodies: (body_a, body_b),
            mover_a,
            mover_b,
            movers,
            reactions,
            tangents: [t1, t2],
            half,
            fall,
            rest: rest_speed(&pair.coefficients.restitution, step),
            bent: bend(body_a, body_b) * half * half,
            gripped: body_a.grip().is_some() || body_b.grip().is_some(),
            stiffest: spin.x_axis.length() + spin.y_axis.length() + spin.z_axis.length(),
        }
    }

    /// Effective masses and coupling of a point without joints, with its arms \[m\].
    fn free_masses(&self, [arm_a, arm_b]: [DVec3; 2], normal: DVec3) -> ([f64; 3], [f64; 2]) {
        let inverse_mass = |along: DVec3, across: DVec3| {
            (self.mover_a.inverse_mass + self.mover_b.inverse_mass) * along.dot(across)
                + arm_a.cross(along).dot(self.mover_a.inverse_inertia * arm_a.cross(across))
                + arm_b.cross(along).dot(self.mover_b.inverse_inertia * arm_b.cross(across))
        };
        let [t1, t2] = self.tangents;
        let masses = [normal, t1, t2].map(|along| inverse_mass(along, along).recip());
        (masses, [inverse_mass(normal, t1), inverse_mass(normal, t2)])
    }

    /// Effective masses and coupling with the reactions of joints; `None` where joints hold the point, and no
    /// mass along a tangent where they do.
    fn linked_masses(&self, ends: [(usize, DVec3); 2], normal: DVec3) -> Option<([f64; 3], [f64; 2])> {
        let [t1, t2] = self.tangents;
        let response = |along: DVec3| self.reactions.response(self.movers, ends, along);
        let pushed = response(normal);
        let inverse = [pushed.dot(normal), response(t1).dot(t1), response(t2).dot(t2)];
        let bodies = ends.map(|end| end.0);
        let held = inverse.map(|inverse| self.reactions.hold_point(self.movers, bodies, inverse));
        let mass = |k: usize| if held[k] { 0.0 } else { inverse[k].recip() };
        (!held[0]).then(|| ([0, 1, 2].map(mass), [pushed.dot(t1), pushed.dot(t2)]))
    }

    /// The row of a contact point; `None`, and its carried impulse is reset, if it cannot bear in this step.
    pub(super) fn row(&self, pair: &mut Pair, k: usize, step: &Step) -> Option<Row> {
        let (mover_a, mover_b, normal) = (self.mover_a, self.mover_b, pair.normal);
        let point = &mut pair.points[k];
        let before = mover_a.velocity + mover_a.spin.cross(point.arm_a)
            - mover_b.velocity
            - mover_b.spin.cross(point.arm_b);
        let speed = before.dot(normal);
        let unled = || {
            let (a, b) = (self.bodies.0.mover(), self.bodies.1.mover());
            a.velocity_at(point.arm_a) - b.velocity_at(point.arm_b)
        };
        // What the pushes of this step added is no approach.
        let pushed = self.bodies.0.pushed_at(point.arm_a) - self.bodies.1.pushed_at(point.arm_b);
        let (a, b) = (pair.key.a as usize, pair.key.b as usize);
        let linked = self.reactions.holds(a) || self.reactions.holds(b);
        let met = if self.gripped && !linked { unled() } else { before } - pushed;
        // Gap at the middle of the step.
        let gap = point.gap + (met.dot(normal) - self.fall) * (self.half - pair.reference);
        let parts = gap > 0.0 && speed > PARTING - 2.0 * gap / step.length && point.impulse_n == 0.0;
        // A fast approach that ends after this step is an impact of the next one.
        let arrives =
            speed < -2.0 * self.rest && gap + speed * self.half > -self.bent && pair.hits < MAX_HITS;
        let gripped = arrives && self.gripped;
        if parts || (arrives && !gripped) {
            point.impulse_n = 0.0;
            point.impulse_t = DVec3::ZERO;
            return None;
        }
        // Effective masses and coupling.
        let free = self.free_masses([point.arm_a, point.arm_b], normal);
        let linked_masses = || self.linked_masses([(a, point.arm_a), (b, point.arm_b)], normal);
        let Some((mass, coupling)) = (if linked { linked_masses() } else { Some(free) }) else {
            point.impulse_n = 0.0;
            point.impulse_t = DVec3::ZERO;
            return None;
        };
        // Near an axis an overlap is pushed out with no more energy than without joints.
        let push_speed = PUSH_SPEED * (free.0[0] / mass[0]).sqrt().min(1.0);
        // Least normal velocity after the step. A hand does not hasten an impact of the next one.
        let target = if gripped {
            unled().dot(normal).min(-2.0 * gap.max(0.0) / step.length)
        } else if gap > 0.0 {
            // The rim ahead of the lowest point must not bear before the lowest point may be pushed out.
            let ahead = if pair.rolls_on_rim && k > 0 { SLOP } else { 0.0 };
            -2.0 * (gap + ahead) / step.length
        } else {
            let overlap = (-gap - SLOP).max(0.0);
            let slow = (PUSH_FRACTION * overlap / step.length).min(push_speed);
            slow.max((FAST_PUSH_FRACTION * overlap / step.length).min(-FAST_PUSH * met.dot(normal)))
        };
        // The rim curves upwards from its lowest point, which would sink if it were not lifted as much.
        let target =
            if pair.rolls_on_rim && k == 0 && pair.hits == 0 { target + pair.rim_lift } else { target };
        let rolling_loss = pair.coefficients.rolling_loss;
        Some(Row {
            a,
            b,
            pair: self.index,
            point: k,
            normal,
            tangents: self.tangents,
            arm_a: point.arm_a,
            arm_b: point.arm_b,
            mass,
            coupling,
            target,
            friction: pair.coefficients.friction,
            rolling_loss,
            rolling_inertia: if rolling_loss > 0.0 { self.stiffest.recip() } else { 0.0 },
            impulse: [
                point.impulse_n,
                point.impulse_t.dot(self.tangents[0]),
                point.impulse_t.dot(self.tangents[1]),
            ],
            couple: DVec3::ZERO,
            before: met,
            gap: point.gap,
            linked,
        })
    }
}

impl Row {
    /// Impulse on A.
    pub(super) fn total(&self) -> DVec3 {
        self.normal * self.impulse[0] + self.tangential()
    }

    /// Tangential part of the impulse on A.
    pub(super) fn tangential(&self) -> DVec3 {
        self.tangents[0] * self.impulse[1] + self.tangents[1] * self.impulse[2]
    }

    /// Half the work of the impulse at these velocities \[J\].
    pub(super) fn half_work(&self, movers: &[Mover]) -> f64 {
        let (a, b) = (&movers[self.a], &movers[self.b]);
        let velocity = a.velocity_at(self.arm_a) - b.velocity_at(self.arm_b);
        0.5 * (self.total().dot(velocity) + self.couple.dot(a.spin - b.spin))
    }

    /// What an impulse and a couple on A do to both bodies.
    pub(super) fn kicks(&self, impulse: DVec3, couple: DVec3) -> [Kick; 2] {
        [
            (self.a, impulse, self.arm_a.cross(impulse) + couple),
            (self.b, -impulse, -self.arm_b.cross(impulse) - couple),
        ]
    }

    /// Solves this point with all others held fixed. Returns the largest change of velocity \[m/s\].
    pub(super) fn relax(&mut self, movers: &mut [Mover]) -> f64 {
        let (mut a, mut b) = (movers[self.a], movers[self.b]);
        let slip = a.velocity + a.spin.cross(self.arm_a) - b.velocity - b.spin.cross(self.arm_b);
        let [old_n, old_1, old_2] = self.impulse;
        // Normal impulse.
        let new_n = (old_n + (self.target - slip.dot(self.normal)) * self.mass[0]).max(0.0);
        let change_n = new_n - old_n;
        // Friction, projected onto the cone.
        let limit = self.friction * new_n;
        let mut new_1 = old_1 - (slip.dot(self.tangents[0]) + self.coupling[0] * change_n) * self.mass[1];
        let mut new_2 = old_2 - (slip.dot(self.tangents[1]) + self.coupling[1] * change_n) * self.mass[2];
        let length = (new_1 * new_1 + new_2 * new_2).sqrt();
        if length > limit {
            let scale = limit / length;
            new_1 *= scale;
            new_2 *= scale;
        }
        let (change_1, change_2) = (new_1 - old_1, new_2 - old_2);
        self.impulse = [new_n, new_1, new_2];
        let impulse = self.normal * change_n + self.tangents[0] * change_1 + self.tangents[1] * change_2;
        a.push(impulse, self.arm_a.cross(impulse));
        b.push(-impulse, -self.arm_b.cross(impulse));
        // Couple of rolling and spinning loss.
        if self.rolling_inertia > 0.0 && (new_n > 0.0 || self.couple != DVec3::ZERO) {
            let wanted = self.couple - (a.spin - b.spin) * self.rolling_inertia;
            let couple = wanted.clamp_length_max(self.rolling_loss * new_n);
            let change = couple - self.couple;
            self.couple = couple;
            a.spin += a.inverse_inertia * change;
            b.spin -= b.inverse_inertia * change;
        }
        movers[self.a] = a;
        movers[self.b] = b;
        let tangential = (change_1 * change_1 + change_2 * change_2).sqrt();
        (change_n.abs() / self.mass[0]).max(tangential / self.mass[1])
    }
}
