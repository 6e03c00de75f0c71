//! Resting, sliding and rolling contact: one non-restitutive solve per step, after gravity.
//!
//! Unknowns are impulses λ on A with `λ_n ≥ 0`, `|λ_t| ≤ μ λ_n`, and a couple of rolling and spinning loss
//! `|c| ≤ ρ λ_n`. The normal velocity after the solve must not close the gap within the step; tangential and
//! relative angular velocities are driven to zero as far as the bounds allow. Solved by projected
//! Gauss-Seidel, warm-started with the impulses of the step before, pairs ordered bottom-up, sweep direction
//! alternating (`contact_row`). An overlap is pushed out far below the audible speed.
//!
//! Joints are closed before the contacts are set up, react to every impulse of the sweeps, and are closed
//! again after them (`reactions`). Grips take part in the sweeps (`grip`).
//!
//! Not included: shock propagation (\[GUE\] §8), which holds the lower body fixed and so violates the balance
//! of momentum; warm start and order replace it.

use clangor_core::timeline::ContactKind;
use glam::DVec3;

use super::contact_row::{PairContext, Row};
use super::grip::Grip;
use super::linkage::Linkages;
use super::mover::Mover;
use super::pair::{Pair, Step};
use super::reactions::{JointImpulse, Reactions};
use super::spring_balance::{Flight, SpringBalance};
use super::state::{BodyState, Instant};
use super::step_log::{ContactImpulse, Impulse, StepLog};

/// Sweeps end when no velocity changes by more than this fraction of g Δt.
const TOLERANCE: f64 = 0.02;
/// Least value of g in the tolerance, for worlds without gravity \[m/s²\].
const LEAST_GRAVITY: f64 = 1.0;
const MIN_SWEEPS: u32 = 4;
const MAX_SWEEPS: u32 = 30;

/// Buffers of the phase.
#[derive(Default)]
pub(super) struct ContactPhase {
    movers: Vec<Mover>,
    rows: Vec<Row>,
    order: Vec<usize>,
    reactions: Reactions,
    grips: Vec<Grip>,
    /// Energy that links add to bodies and take from them.
    pub(super) balance: SpringBalance,
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

    /// Solves the contacts and joints of the step and updates velocities and momenta. Returns the number of
    /// sweeps; `Err` has a joint that cannot be closed, and by how much it is open \[m, or rad\].
    pub(super) fn run(
        &mut self,
        bodies: &mut [BodyState],
        pairs: &mut [Pair],
        linkages: &Linkages,
        step: &Step,
        log: &mut StepLog,
    ) -> Result<u32, (usize, f64)> {
        self.assemble_bodies(bodies, linkages, step);
        let flight = Flight { linkages, bodies, step };
        self.close_joints(&flight, &[])?;
        self.reactions.brake(linkages, &mut self.movers, step.length);
        if self.reactions.has_brakes() {
            self.close_joints(&flight, &[])?;
        }
        self.note_pushes(bodies, linkages);
        self.let_pushed_ropes_go(pairs);
        self.assemble_rows(bodies, pairs, step);
        let flight = Flight { linkages, bodies, step };
        let sweeps = if self.rows.is_empty() && self.grips.is_empty() { 0 } else { self.sweep(step) };
        if sweeps > 0 {
            let swept = self.movers.clone();
            self.close_joints(&flight, &swept)?;
        }
        self.balance.end();
        self.log(bodies, pairs, step, log);
        if log.skips_slower().is_none() {
            self.reactions.log(linkages, step.time + 0.5 * step.length, log);
            self.grips.iter().for_each(|grip| grip.log(bodies, step, log));
        }
        self.apply(bodies, pairs);
        self.balance.apply(bodies, step, log);
        Ok(sweeps)
    }

    /// Projected Gauss-Seidel sweeps in alternating direction, from the impulses of the last step.
    fn sweep(&mut self, step: &Step) -> u32 {
        for row in &self.rows {
            let impulse = row.normal * row.impulse[0]
                + row.tangents[0] * row.impulse[1]
                + row.tangents[1] * row.impulse[2];
            let kicks = row.kicks(impulse, DVec3::ZERO);
            kicks.iter().for_each(|(body, linear, angular)| self.movers[*body].push(*linear, *angular));
            if row.linked {
                self.reactions.react(&mut self.movers, &kicks);
            }
        }
        let tolerance = TOLERANCE * step.gravity.length().max(LEAST_GRAVITY) * step.length;
        let mut sweeps = 0;
        while sweeps < MAX_SWEEPS {
            let mut largest = 0.0_f64;
            // Hands and ropes first: contacts have the last word.
            for grip in &mut self.grips {
                let (kick, change) = grip.relax(&mut self.movers);
                largest = largest.max(change);
                self.reactions.react(&mut self.movers, &[kick]);
            }
            largest = largest.max(self.reactions.pull_back(&mut self.movers));
            let ContactPhase { movers, rows, reactions, .. } = self;
            let mut relax = |row: &mut Row| {
                let (impulse, couple) = (row.total(), row.couple);
                largest = largest.max(row.relax(movers));
                if row.linked {
                    reactions.react(movers, &row.kicks(row.total() - impulse, row.couple - couple));
                }
            };
            if sweeps % 2 == 0 {
                rows.iter_mut().for_each(&mut relax);
            } else {
                rows.iter_mut().rev().for_each(&mut relax);
            }
            sweeps += 1;
            if largest < tolerance && sweeps >= MIN_SWEEPS {
                break;
            }
        }
        sweeps
    }

    /// Sets up the bodies, their joints and their grips.
    fn assemble_bodies(&mut self, bodies: &[BodyState], linkages: &Linkages, step: &Step) {
        self.movers.clear();
        self.movers.extend(bodies.iter().map(BodyState::mover));
        let place = |body: usize| (bodies[body].middle_pose(), body);
        let tensions = self.reactions.tensions();
        let all = (0..linkages.count(), &tensions[..]);
        self.reactions.set_up(linkages, all, &place, (&self.movers, step.length));
        self.reactions.begin_with(&mut self.movers, &tensions);
        let last = std::mem::take(&mut self.grips);
        self.grips.extend(bodies.iter().enumerate().filter_map(|(i, body)| Grip::of(i, body, step)));
        for grip in &mut self.grips {
            let kick = grip.begin_with(&last, &mut self.movers);
            self.reactions.react(&mut self.movers, &kick);
        }
    }

    /// Closes all joints; `swept` has the bodies after the sweeps of contacts.
    fn close_joints(&mut self, flight: &Flight<'_>, swept: &[Mover]) -> Result<(), (usize, f64)> {
        let ContactPhase { movers, reactions, balance, rows, .. } = self;
        let linkages = flight.linkages;
        (0..linkages.count()).try_for_each(|linkage| {
            let holds = |row: &&Row| [row.a, row.b].iter().any(|&body| linkages.of(body) == Some(linkage));
            let pressed = |movers: &[Mover]| -> f64 {
                let rows = rows.iter().filter(|_| !swept.is_empty()).filter(holds);
                rows.map(|row| row.half_work(movers) - row.half_work(swept)).sum()
            };
            balance.close(linkage, reactions, movers, (flight, &pressed))
        })
    }

    /// Of bodies on joints: what the forces of the step and the joints changed of the velocities.
    fn note_pushes(&self, bodies: &mut [BodyState], linkages: &Linkages) {
        for (index, body) in bodies.iter_mut().enumerate().filter(|(index, _)| linkages.of(*index).is_some())
        {
            let mover = &self.movers[index];
            body.pushed = [mover.velocity - body.unforced[0], mover.spin - body.unforced[1]];
        }
    }

    /// Lets ropes go that a contact may push: as a rod such a rope would take a part of the impulse, which is
    /// taken back after the sweeps and would leave too much at the contact.
    fn let_pushed_ropes_go(&mut self, pairs: &[Pair]) {
        if !self.reactions.has_pulling_ropes() {
            return;
        }
        for pair in pairs.iter().filter(|pair| pair.live) {
            let (a, b) = (pair.key.a as usize, pair.key.b as usize);
            if self.reactions.holds(a) || self.reactions.holds(b) {
                for point in &pair.points {
                    let ends = [(a, point.arm_a), (b, point.arm_b)];
                    self.reactions.let_pushed_ropes_go(&self.movers, ends, pair.normal);
                }
            }
        }
    }

    /// Sets up one row for each point that may bear in this step.
    fn assemble_rows(&mut self, bodies: &[BodyState], pairs: &mut [Pair], step: &Step) {
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
            let movers = (&self.movers[..], &self.reactions);
            let context = PairContext::new(index, pair, (body_a, body_b), movers, step);
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
            let impulse = ContactImpulse {
                point,
                normal: row.normal,
                depth: -row.gap,
                impulse_n: row.impulse[0],
                impulse_t: row.tangential(),
                couple: row.couple,
                velocity: row.before,
                effective_mass: Some(row.mass[0]).filter(|mass| row.linked && *mass > 0.0),
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
            let (impulse, tangential) = (row.total(), row.tangential());
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
        for JointImpulse { ends, arms, impulse, couple, .. } in self.reactions.totals() {
            for ((body, arm), sign) in ends.into_iter().zip(arms).zip([1.0, -1.0]) {
                if let Some(body) = body {
                    bodies[body].kick(impulse * sign, (arm.cross(impulse) + couple) * sign);
                }
            }
        }
        self.grips.iter().for_each(|grip| grip.apply(bodies));
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
