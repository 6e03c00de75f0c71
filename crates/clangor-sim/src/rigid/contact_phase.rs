//! Resting, sliding and rolling contact: one non-restitutive solve per step, after gravity.
//!
//! Unknowns are impulses λ on A with `λ_n ≥ 0`, `|λ_t| ≤ μ λ_n`, and a couple of rolling and spinning loss
//! `|c| ≤ ρ λ_n`. The normal velocity after the solve must not close the gap within the step; tangential and
//! relative angular velocities are driven to zero as far as the bounds allow. Solved by projected
//! Gauss-Seidel, warm-started with the impulses of the step before, pairs ordered bottom-up, sweep direction
//! alternating. An overlap beyond [`SLOP`] is pushed out at [`PUSH_SPEED`] at most, far below the audible
//! speed.
//!
//! Not included: shock propagation (\[GUE\] §8), which holds the lower body fixed and so violates the balance
//! of momentum; warm start and order replace it.

use clangor_core::timeline::ContactKind;
use glam::{DMat3, DVec3};

use super::impact_threshold::{MAX_HITS, bend, rest_speed};
use super::manifold::tangents;
use super::pair::{Pair, SLOP, Step};
use super::state::{BodyState, Instant};
use super::step_log::{ContactImpulse, Impulse, StepLog};

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
/// Sweeps end when no velocity changes by more than this fraction of g Δt.
const TOLERANCE: f64 = 0.02;
/// Least value of g in the tolerance, for worlds without gravity \[m/s²\].
const LEAST_GRAVITY: f64 = 1.0;
const MIN_SWEEPS: u32 = 4;
const MAX_SWEEPS: u32 = 30;

/// Velocities and inertia of a body during the sweeps.
#[derive(Clone, Copy)]
struct Mover {
    velocity: DVec3,
    spin: DVec3,
    inverse_mass: f64,
    inverse_inertia: DMat3,
}

impl Mover {
    fn push(&mut self, impulse: DVec3, angular: DVec3) {
        self.velocity += impulse * self.inverse_mass;
        self.spin += self.inverse_inertia * angular;
    }
}

/// One contact point in the solve.
struct Row {
    a: usize,
    b: usize,
    pair: usize,
    point: usize,
    normal: DVec3,
    tangents: [DVec3; 2],
    arm_a: DVec3,
    arm_b: DVec3,
    /// Effective mass along the normal and the tangents \[kg\].
    mass: [f64; 3],
    /// Change of the tangential velocities by a unit normal impulse \[1/kg\].
    coupling: [f64; 2],
    /// Least normal velocity after the step \[m/s\].
    target: f64,
    friction: f64,
    rolling_loss: f64,
    /// Lower bound of the moment of inertia that resists the couple \[kg m²\].
    rolling_inertia: f64,
    impulse: [f64; 3],
    couple: DVec3,
    before: DVec3,
    gap: f64,
}

/// What the rows of one pair have in common.
struct PairContext<'a> {
    index: usize,
    mover_a: &'a Mover,
    mover_b: &'a Mover,
    tangents: [DVec3; 2],
    /// Half of the step \[s\].
    half: f64,
    /// Change of the normal velocity by gravity in the step \[m/s\].
    fall: f64,
    /// Approach below which contact is resting contact \[m/s\].
    rest: f64,
    /// Distance by which rotation may bend the path of a point in half a step \[m\].
    bent: f64,
    /// Sum of the norms of the columns of both inverse inertias \[1/(kg m²)\].
    stiffest: f64,
}

impl<'a> PairContext<'a> {
    fn new(
        index: usize,
        pair: &Pair,
        (body_a, body_b): (&BodyState, &BodyState),
        movers: &'a [Mover],
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
            mover_a,
            mover_b,
            tangents: [t1, t2],
            half,
            fall,
            rest: rest_speed(&pair.coefficients.restitution, step),
            bent: bend(body_a, body_b) * half * half,
            stiffest: spin.x_axis.length() + spin.y_axis.length() + spin.z_axis.length(),
        }
    }

    /// The row of a contact point; `None`, and its carried impulse is reset, if it cannot bear in this step.
    fn row(&self, pair: &mut Pair, k: usize, step: &Step) -> Option<Row> {
        let (mover_a, mover_b, normal) = (self.mover_a, self.mover_b, pair.normal);
        let point = &mut pair.points[k];
        let before = mover_a.velocity + mover_a.spin.cross(point.arm_a)
            - mover_b.velocity
            - mover_b.spin.cross(point.arm_b);
        let speed = before.dot(normal);
        // Gap at the middle of the step.
        let gap = point.gap + (speed - self.fall) * (self.half - pair.reference);
        let parts = gap > 0.0 && speed > PARTING - 2.0 * gap / step.length && point.impulse_n == 0.0;
        // A fast approach that ends after this step is an impact of the next one.
        let arrives =
            speed < -2.0 * self.rest && gap + speed * self.half > -self.bent && pair.hits < MAX_HITS;
        if parts || arrives {
            point.impulse_n = 0.0;
            point.impulse_t = DVec3::ZERO;
            return None;
        }
        // Least normal velocity after the step.
        let target = if gap > 0.0 {
            // The rim ahead of the lowest point must not bear before the lowest point may be pushed out.
            let ahead = if pair.rolls_on_rim && k > 0 { SLOP } else { 0.0 };
            -2.0 * (gap + ahead) / step.length
        } else {
            let overlap = (-gap - SLOP).max(0.0);
            let slow = (PUSH_FRACTION * overlap / step.length).min(PUSH_SPEED);
            slow.max((FAST_PUSH_FRACTION * overlap / step.length).min(-FAST_PUSH * speed))
        };
        // The rim curves upwards from its lowest point, which would sink if it were not lifted as much.
        let target =
            if pair.rolls_on_rim && k == 0 && pair.hits == 0 { target + pair.rim_lift } else { target };
        // Effective masses and coupling.
        let point = &*point;
        let inverse_mass = |along: DVec3, across: DVec3| {
            (mover_a.inverse_mass + mover_b.inverse_mass) * along.dot(across)
                + point.arm_a.cross(along).dot(mover_a.inverse_inertia * point.arm_a.cross(across))
                + point.arm_b.cross(along).dot(mover_b.inverse_inertia * point.arm_b.cross(across))
        };
        let [t1, t2] = self.tangents;
        let rolling_loss = pair.coefficients.rolling_loss;
        Some(Row {
            a: pair.key.a as usize,
            b: pair.key.b as usize,
            pair: self.index,
            point: k,
            normal,
            tangents: [t1, t2],
            arm_a: point.arm_a,
            arm_b: point.arm_b,
            mass: [normal, t1, t2].map(|d| inverse_mass(d, d).recip()),
            coupling: [inverse_mass(normal, t1), inverse_mass(normal, t2)],
            target,
            friction: pair.coefficients.friction,
            rolling_loss,
            rolling_inertia: if rolling_loss > 0.0 { self.stiffest.recip() } else { 0.0 },
            impulse: [point.impulse_n, point.impulse_t.dot(t1), point.impulse_t.dot(t2)],
            couple: DVec3::ZERO,
            before,
            gap: point.gap,
        })
    }
}

/// Buffers of the phase.
#[derive(Default)]
pub(super) struct ContactPhase {
    movers: Vec<Mover>,
    rows: Vec<Row>,
    order: Vec<usize>,
}

impl ContactPhase {
    /// Orders the pairs bottom-up.
    pub(super) fn sort(&mut self, bodies: &[BodyState], pairs: &[Pair], gravity: DVec3) {
        let up = -gravity.normalize_or_zero();
        // Fixed bodies count as the lowest.
        let height = |i: u32| {
            let body = &bodies[i as usize];
            if body.is_free() { body.mid_position.dot(up) } else { f64::NEG_INFINITY }
        };
        let key = |i: usize| {
            let (a, b) = (height(pairs[i].key.a), height(pairs[i].key.b));
            (a.min(b), a.max(b))
        };
        self.order.clear();
        self.order.extend(0..pairs.len());
        self.order.sort_by(|&i, &j| {
            let (p, q) = (key(i), key(j));
            p.0.total_cmp(&q.0).then(p.1.total_cmp(&q.1)).then(i.cmp(&j))
        });
    }

    /// Solves the contacts of the step and updates velocities and momenta. Returns the number of sweeps.
    pub(super) fn run(
        &mut self,
        bodies: &mut [BodyState],
        pairs: &mut [Pair],
        step: &Step,
        log: &mut StepLog,
    ) -> u32 {
        self.assemble(bodies, pairs, step);
        if self.rows.is_empty() {
            return 0;
        }
        // Warm start.
        for row in &self.rows {
            let impulse = row.normal * row.impulse[0]
                + row.tangents[0] * row.impulse[1]
                + row.tangents[1] * row.impulse[2];
            self.movers[row.a].push(impulse, row.arm_a.cross(impulse));
            self.movers[row.b].push(-impulse, -row.arm_b.cross(impulse));
        }
        // Projected Gauss-Seidel sweeps in alternating direction.
        let tolerance = TOLERANCE * step.gravity.length().max(LEAST_GRAVITY) * step.length;
        let mut sweeps = 0;
        while sweeps < MAX_SWEEPS {
            let mut largest = 0.0_f64;
            if sweeps % 2 == 0 {
                for row in &mut self.rows {
                    largest = largest.max(row.relax(&mut self.movers));
                }
            } else {
                for row in self.rows.iter_mut().rev() {
                    largest = largest.max(row.relax(&mut self.movers));
                }
            }
            sweeps += 1;
            if largest < tolerance && sweeps >= MIN_SWEEPS {
                break;
            }
        }
        self.log(bodies, pairs, step, log);
        self.apply(bodies, pairs);
        sweeps
    }

    /// Sets up the bodies and one row for each point that may bear in this step.
    fn assemble(&mut self, bodies: &[BodyState], pairs: &mut [Pair], step: &Step) {
        self.movers.clear();
        self.movers.extend(bodies.iter().map(|body| Mover {
            velocity: body.velocity,
            spin: body.angular_velocity,
            inverse_mass: body.inverse_mass(),
            inverse_inertia: if body.is_awake() { body.world_inverse_inertia } else { DMat3::ZERO },
        }));
        self.rows.clear();
        for &index in &self.order {
            let pair = &mut pairs[index];
            if !pair.live {
                continue;
            }
            let (body_a, body_b) = pair.bodies(bodies);
            if !body_a.is_awake() && !body_b.is_awake() {
                continue;
            }
            let context = PairContext::new(index, pair, (body_a, body_b), &self.movers, step);
            for k in 0..pair.points.len() {
                self.rows.extend(context.row(pair, k, step));
            }
        }
    }

    /// Logs the rows of all pairs, or of the fast pairs only.
    fn log(&self, bodies: &[BodyState], pairs: &[Pair], step: &Step, log: &mut StepLog) {
        let time = step.time + 0.5 * step.length;
        let acts = |row: &Row| row.impulse[0] > 0.0 || row.couple != DVec3::ZERO;
        let wanted = |row: &Row| log.skips_slower().is_none_or(|speed| -row.before.dot(row.normal) > speed);
        let ends = |i: usize| (self.rows[i].a, self.rows[i].b);
        let mut loud: Vec<(usize, usize)> = (0..self.rows.len())
            .filter(|&i| acts(&self.rows[i]) && wanted(&self.rows[i]))
            .map(ends)
            .collect();
        if loud.is_empty() {
            return;
        }
        loud.sort_unstable();
        loud.dedup();
        let mut chosen: Vec<usize> = (0..self.rows.len())
            .filter(|&i| acts(&self.rows[i]) && loud.binary_search(&ends(i)).is_ok())
            .collect();
        chosen.sort_by_key(|&i| (ends(i), self.rows[i].pair, i));
        let mut last = None;
        for i in chosen {
            let row = &self.rows[i];
            if last != Some(ends(i)) {
                if last.is_some() {
                    log.end();
                }
                last = Some(ends(i));
                log.begin(ContactKind::Contact);
                for k in [row.a, row.b].into_iter().filter(|&k| bodies[k].is_moving()) {
                    log.pose(time, k, &middle(&bodies[k]));
                }
            }
            let point = bodies[row.a].mid_position + row.arm_a;
            let tangential = row.tangents[0] * row.impulse[1] + row.tangents[1] * row.impulse[2];
            let impulse = ContactImpulse {
                point,
                normal: row.normal,
                depth: -row.gap,
                impulse_n: row.impulse[0],
                impulse_t: tangential,
                couple: row.couple,
                velocity: row.before,
            };
            let key = pairs[row.pair].key;
            let (a, b) = ((key.a, row.arm_a), (key.b, row.arm_b));
            log.impulse(Impulse::between(a, b, ContactKind::Contact, time, impulse));
        }
        log.end();
    }

    /// Applies the summed impulses to the bodies, so that the balance of momentum is exact.
    fn apply(&self, bodies: &mut [BodyState], pairs: &mut [Pair]) {
        for row in &self.rows {
            let tangential = row.tangents[0] * row.impulse[1] + row.tangents[1] * row.impulse[2];
            let impulse = row.normal * row.impulse[0] + tangential;
            let point = &mut pairs[row.pair].points[row.point];
            point.impulse_n = row.impulse[0];
            point.impulse_t = tangential;
            for (i, arm, impulse, couple) in
                [(row.a, row.arm_a, impulse, row.couple), (row.b, row.arm_b, -impulse, -row.couple)]
            {
                let body = &mut bodies[i];
                if body.is_awake() {
                    body.velocity += impulse * body.inverse_mass();
                    body.momentum += arm.cross(impulse) + couple;
                }
            }
        }
        for body in bodies.iter_mut().filter(|b| b.is_awake()) {
            body.angular_velocity = body.world_inverse_inertia * body.momentum;
        }
    }
}

fn middle(body: &BodyState) -> Instant {
    Instant {
        position: body.mid_position,
        orientation: body.mid_orientation,
        velocity: body.velocity,
        angular_velocity: body.angular_velocity,
        momentum: body.momentum,
        inverse_mass: body.inverse_mass(),
        inverse_inertia: body.world_inverse_inertia,
    }
}

impl Row {
    /// Solves this point with all others held fixed. Returns the largest change of velocity \[m/s\].
    fn relax(&mut self, movers: &mut [Mover]) -> f64 {
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
