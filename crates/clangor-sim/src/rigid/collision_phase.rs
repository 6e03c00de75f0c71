//! Impacts, one after the other in the order of time inside a step, before gravity acts in it.
//!
//! For every contact point the first root t* of its gap is predicted; the earliest pair is brought to the
//! exact poses of t* (a few Newton steps on the distance of the shapes) and then solved there. Pairs within
//! [`TIE`] of each other form one block. In a block only the points that approach now are solved together,
//! `u⁺ ≥ −e u⁻` with `λ ≥ 0` and a round friction cone, and this is repeated until none approaches
//! (generalized reflections, \[REFL\] §4), so that a row of touching balls passes one impulse on and a ball
//! between two is symmetric. After each impulse the predictions of all neighbours are renewed.
//!
//! Points slower than the rest speed are left to the contact phase; restitution grows from 0 there to e at
//! twice that speed. Taking the impacts before gravity (\[GUE\] §7) keeps a resting body out of here
//! altogether.
//!
//! Differs: \[GUE\] steps all bodies to the end of the step and solves there; here every impulse has its own
//! instant and pose.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use clangor_core::timeline::ContactKind;
use glam::DVec3;

use super::broad_phase::Neighbours;
use super::pair::{Pair, PairScratch, Step};
use super::shape::Shape;
use super::sleep;
use super::state::{BodyState, Instant};
use super::step_log::{Impulse, StepLog};

/// Impacts closer than this in time are solved together \[s\].
const TIE: f64 = 1e-10;
/// A predicted time is exact when a refinement moves it by less \[s\].
const EXACT: f64 = 1e-11;
/// Refinements of one prediction at most.
const MAX_REFINEMENTS: u32 = 30;
/// Points of a pair that touch within this time belong to the impact \[s\].
const TOGETHER: f64 = 1e-7;
/// And those within this distance \[m\].
const TOUCHING: f64 = 1e-9;
/// Impacts of one pair in one step after which restitution is dropped, and after which the contact phase
/// takes over, so that a step ends.
const ELASTIC_HITS: u32 = 12;
pub(super) const MAX_HITS: u32 = 60;
/// Rounds of reflections in one block; the last ones are without restitution.
const MAX_ROUNDS: u32 = 2 * ELASTIC_HITS;
/// Gauss-Seidel sweeps of a block, and the velocity correction, relative to the approach, that ends them.
const MAX_SWEEPS: u32 = 400;
const CONVERGED: f64 = 1e-14;
/// Pairs in a block.
const MAX_GROUP: usize = 256;
/// An overlap at the middle of the step beyond this means that the bodies passed each other \[m\].
const PASSED: f64 = 1e-5;

/// Approach below which contact is resting contact \[m/s\].
const REST_SPEED: f64 = 0.02;
/// The same, where restitution is 1 and nothing ever rests.
const REST_SPEED_ELASTIC: f64 = 1e-6;
/// It is never below this many times the speed that gravity gives in a step.
const REST_STEPS: f64 = 4.0;

/// Approach speed \[m/s\] below which a pair has no impacts.
pub(super) fn rest_speed(restitution: f64, step: &Step) -> f64 {
    if restitution >= 1.0 {
        return REST_SPEED_ELASTIC;
    }
    REST_SPEED.max(REST_STEPS * step.gravity.length() * step.length)
}

/// Bound on the relative acceleration of two contact points due to rotation \[m/s²\], and a bit more.
pub(super) fn bend(a: &BodyState, b: &BodyState) -> f64 {
    let one = |body: &BodyState| body.spin_speed() * body.angular_velocity.length();
    2.0 * (one(a) + one(b))
}

/// A predicted impact.
#[derive(PartialEq)]
struct Candidate {
    time: f64,
    speed: f64,
    pair: usize,
    stamp: u32,
    exact: bool,
}

impl Eq for Candidate {}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Candidate {
    /// The earliest is the greatest; then the fastest, then the first pair.
    fn cmp(&self, other: &Self) -> Ordering {
        (other.time.total_cmp(&self.time))
            .then(self.speed.total_cmp(&other.speed))
            .then(other.pair.cmp(&self.pair))
            .then(self.stamp.cmp(&other.stamp))
            .then(self.exact.cmp(&other.exact))
    }
}

/// A body in a block.
struct Actor {
    body: usize,
    now: Instant,
}

/// A point in a block.
struct BlockPoint {
    pair: usize,
    a: usize,
    b: usize,
    normal: DVec3,
    point: DVec3,
    gap: f64,
    arm_a: DVec3,
    arm_b: DVec3,
    inverse_mass: f64,
    friction: f64,
    target: f64,
    before: DVec3,
    impulse_n: f64,
    impulse_t: DVec3,
}

/// Buffers of the phase.
#[derive(Default)]
pub(super) struct CollisionPhase {
    heap: BinaryHeap<Candidate>,
    group: Vec<usize>,
    actors: Vec<Actor>,
    block: Vec<BlockPoint>,
    touched: Vec<usize>,
}

/// What the phase works on.
pub(super) struct Scene<'a> {
    pub(super) bodies: &'a mut [BodyState],
    pub(super) pairs: &'a mut [Pair],
    pub(super) neighbours: &'a Neighbours,
    pub(super) shapes: &'a [Shape],
    pub(super) step: Step,
    pub(super) scratch: &'a mut PairScratch,
    pub(super) log: &'a mut StepLog,
}

impl CollisionPhase {
    /// Resolves every impact of the step.
    pub(super) fn run(&mut self, scene: &mut Scene<'_>) {
        self.heap.clear();
        for index in 0..scene.pairs.len() {
            if scene.pairs[index].live {
                self.predict(scene, index);
            }
        }
        while let Some(candidate) = self.heap.pop() {
            if candidate.stamp != scene.pairs[candidate.pair].stamp {
                continue;
            }
            if !candidate.exact {
                self.refine(scene, &candidate);
                continue;
            }
            self.gather(scene, &candidate);
            self.resolve(scene, candidate.time);
        }
    }

    /// Predicts the first impact of a pair, a little early where rotation bends its path.
    fn predict(&mut self, scene: &Scene<'_>, index: usize) {
        let (pair, step) = (&scene.pairs[index], &scene.step);
        if pair.hits > MAX_HITS {
            return;
        }
        let (a, b) = pair.bodies(scene.bodies);
        if !a.is_awake() && !b.is_awake() {
            return;
        }
        let start = a.last_hit.max(b.last_hit);
        let fall = (a.gravity(step.gravity) - b.gravity(step.gravity)).dot(pair.normal);
        let rest = rest_speed(pair.coefficients.restitution, step);
        let away = pair.reference.max(step.length - pair.reference);
        let bend = bend(a, b);
        let (early, faster) = (bend * away * away, bend * away);
        let mut first: Option<(f64, f64)> = None;
        for point in &pair.points {
            let speed = (a.velocity + a.angular_velocity.cross(point.arm_a)
                - b.velocity
                - b.angular_velocity.cross(point.arm_b))
            .dot(pair.normal);
            if speed > (fall * step.length).abs() + faster - rest {
                continue;
            }
            let gap = point.gap - early;
            // gap(t) = gap + speed (t − reference) + fall t²/2
            let passed = pair.stamp == 0 && gap < -PASSED;
            let at_start = gap + speed * (start - pair.reference) + 0.5 * fall * start * start;
            let time = if at_start <= 0.0 || passed {
                start
            } else {
                match first_root(0.5 * fall, speed, gap - speed * pair.reference) {
                    Some(root) => root.max(start),
                    None => continue,
                }
            };
            let approach = faster - (speed + fall * time);
            if time >= step.length || approach <= rest {
                continue;
            }
            if first.is_none_or(|(t, s)| time < t || (time == t && approach > s)) {
                first = Some((time, approach));
            }
        }
        if let Some((time, speed)) = first {
            self.heap.push(Candidate { time, speed, pair: index, stamp: pair.stamp, exact: false });
        } else if pair.rolls_on_rim {
            self.probe_end(index, pair, step);
        }
    }

    /// Looks again from the end of the step. The lowest point of a tilting cylinder runs round its rim, which
    /// no point known now foretells; but its height is concave in time, so the end tells whether there is a
    /// root, and Newton's method finds it from there.
    fn probe_end(&mut self, index: usize, pair: &Pair, step: &Step) {
        let end = Candidate { time: step.length, speed: 0.0, pair: index, stamp: pair.stamp, exact: false };
        self.heap.push(end);
    }

    /// Finds the manifold at the predicted instant and predicts again from there.
    fn refine(&mut self, scene: &mut Scene<'_>, candidate: &Candidate) {
        let step = scene.step;
        let pair = &mut scene.pairs[candidate.pair];
        pair.find_exactly(scene.bodies, scene.shapes, &step, candidate.time, scene.scratch);
        pair.refinements += 1;
        let (a, b) = pair.bodies(scene.bodies);
        let start = a.last_hit.max(b.last_hit);
        let normal = pair.exact.normal;
        let fall = (a.gravity(step.gravity) - b.gravity(step.gravity)).dot(normal);
        let rest = rest_speed(pair.coefficients.restitution, &step);
        let now_a = a.at(step.time, step.length, candidate.time, a.gravity(step.gravity));
        let now_b = b.at(step.time, step.length, candidate.time, b.gravity(step.gravity));
        let mut first: Option<(f64, f64)> = None;
        // On a rim only the lowest point, the first one, is on the curve whose root is sought.
        let relevant = if pair.rolls_on_rim { 1 } else { usize::MAX };
        for point in pair.exact.points.iter().take(relevant) {
            let middle = (point.on_a + point.on_b) * 0.5;
            let speed = (now_a.velocity_at(middle - now_a.position)
                - now_b.velocity_at(middle - now_b.position))
            .dot(normal);
            let back = start - candidate.time;
            let at_start = point.gap + speed * back + 0.5 * fall * back * back;
            let delay = if at_start <= 0.0 {
                back
            } else {
                match first_root(0.5 * fall, speed, point.gap) {
                    Some(delay) => delay.max(back),
                    None => continue,
                }
            };
            let approach = -(speed + fall * delay);
            if approach <= rest {
                continue;
            }
            if first.is_none_or(|(d, s)| delay < d || (delay == d && approach > s)) {
                first = Some((delay, approach));
            }
        }
        let Some((delay, speed)) = first else {
            if pair.rolls_on_rim && candidate.time < step.length {
                let pair = &scene.pairs[candidate.pair];
                self.probe_end(candidate.pair, pair, &step);
            }
            return;
        };
        let exact = delay.abs() <= EXACT || pair.refinements >= MAX_REFINEMENTS;
        let time = if exact { candidate.time } else { candidate.time + delay };
        if time < step.length {
            self.heap.push(Candidate { time, speed, pair: candidate.pair, stamp: pair.stamp, exact });
        }
    }

    /// Collects the pairs that collide at the same instant as `first`.
    fn gather(&mut self, scene: &mut Scene<'_>, first: &Candidate) {
        self.group.clear();
        self.group.push(first.pair);
        while let Some(next) = self.heap.peek() {
            if next.time - first.time > TIE || self.group.len() >= MAX_GROUP {
                break;
            }
            let Some(next) = self.heap.pop() else { break };
            if next.stamp != scene.pairs[next.pair].stamp || self.group.contains(&next.pair) {
                continue;
            }
            if next.exact {
                self.group.push(next.pair);
            } else {
                self.refine(scene, &next);
            }
        }
        // The order of the list, not of discovery, decides the order of the solution.
        self.group.sort_unstable();
    }

    /// Solves the block of pairs in `group` at time `t` of the step.
    fn resolve(&mut self, scene: &mut Scene<'_>, t: f64) {
        let step = scene.step;
        self.wake(scene);
        self.actors.clear();
        for &index in &self.group {
            let key = scene.pairs[index].key;
            for body in [key.a as usize, key.b as usize] {
                if !self.actors.iter().any(|actor| actor.body == body) {
                    let state = &scene.bodies[body];
                    let now = state.at(step.time, step.length, t, state.gravity(step.gravity));
                    self.actors.push(Actor { body, now });
                }
            }
        }
        for round in 0..MAX_ROUNDS {
            self.assemble(scene, round);
            if self.block.is_empty() {
                break;
            }
            self.solve();
            self.apply_and_log(scene, step.time + t);
        }
        self.touched.clear();
        for actor in &self.actors {
            let state = &mut scene.bodies[actor.body];
            if state.is_awake() {
                let gravity = state.gravity(step.gravity);
                state.redirect(step.length, t, &actor.now, gravity);
                self.touched.push(actor.body);
            }
        }
        for &index in &self.group {
            scene.pairs[index].hits += 1;
        }
        for k in 0..self.touched.len() {
            let body = self.touched[k];
            for &index in scene.neighbours.of(body) {
                let index = index as usize;
                let key = scene.pairs[index].key;
                let other = key.a as usize;
                if body == key.b as usize && self.touched.contains(&other) {
                    continue;
                }
                scene.pairs[index].after_impulse(scene.bodies, scene.shapes, &step, t, scene.scratch);
                if scene.pairs[index].live {
                    self.predict(scene, index);
                }
            }
        }
    }

    /// A sleeping body that is hit wakes with all that fell asleep with it.
    fn wake(&mut self, scene: &mut Scene<'_>) {
        for k in 0..self.group.len() {
            let key = scene.pairs[self.group[k]].key;
            for body in [key.a as usize, key.b as usize] {
                if scene.bodies[body].asleep {
                    sleep::wake(scene.bodies, body, scene.pairs, scene.neighbours, &scene.step);
                }
            }
        }
    }

    /// Puts the points that approach now into the block.
    fn assemble(&mut self, scene: &Scene<'_>, round: u32) {
        self.block.clear();
        for &index in &self.group {
            let pair = &scene.pairs[index];
            let find = |body: u32| self.actors.iter().position(|actor| actor.body == body as usize);
            let (Some(a), Some(b)) = (find(pair.key.a), find(pair.key.b)) else { continue };
            let (now_a, now_b) = (&self.actors[a].now, &self.actors[b].now);
            let normal = pair.exact.normal;
            let rest = rest_speed(pair.coefficients.restitution, &scene.step);
            for point in &pair.exact.points {
                let middle = (point.on_a + point.on_b) * 0.5;
                let (arm_a, arm_b) = (middle - now_a.position, middle - now_b.position);
                let before = now_a.velocity_at(arm_a) - now_b.velocity_at(arm_b);
                let approach = -before.dot(normal);
                if approach <= rest || point.gap > TOUCHING + TOGETHER * approach {
                    continue;
                }
                let spent = pair.hits >= ELASTIC_HITS || round >= ELASTIC_HITS;
                let ramp = ((approach - rest) / rest).clamp(0.0, 1.0);
                let restitution = if spent { 0.0 } else { pair.coefficients.restitution * ramp };
                self.block.push(BlockPoint {
                    pair: index,
                    a,
                    b,
                    normal,
                    point: middle,
                    gap: point.gap,
                    arm_a,
                    arm_b,
                    inverse_mass: now_a.inverse_mass_at(arm_a, normal) + now_b.inverse_mass_at(arm_b, normal),
                    friction: pair.coefficients.friction,
                    target: restitution * approach,
                    before,
                    impulse_n: 0.0,
                    impulse_t: DVec3::ZERO,
                });
            }
        }
    }

    /// Gauss-Seidel on the block. The actors are left as they were: [`Self::apply_and_log`] moves them.
    fn solve(&mut self) {
        let mut moving: Vec<Instant> = self.actors.iter().map(|actor| actor.now).collect();
        let scale = self.block.iter().map(|p| p.before.length()).fold(0.0, f64::max);
        for _ in 0..MAX_SWEEPS {
            let mut largest = 0.0_f64;
            for point in &mut self.block {
                let relative =
                    |m: &[Instant]| m[point.a].velocity_at(point.arm_a) - m[point.b].velocity_at(point.arm_b);
                let speed = relative(&moving).dot(point.normal);
                let change = ((point.target - speed) / point.inverse_mass).max(-point.impulse_n);
                point.impulse_n += change;
                moving[point.a].push(point.arm_a, point.normal * change);
                moving[point.b].push(point.arm_b, point.normal * -change);
                largest = largest.max((change * point.inverse_mass).abs());
                if point.friction <= 0.0 {
                    continue;
                }
                let slip = relative(&moving).reject_from_normalized(point.normal);
                let Some(direction) = slip.try_normalize() else { continue };
                let inverse_mass = moving[point.a].inverse_mass_at(point.arm_a, direction)
                    + moving[point.b].inverse_mass_at(point.arm_b, direction);
                let limit = point.friction * point.impulse_n;
                let wanted = (point.impulse_t - slip / inverse_mass).clamp_length_max(limit);
                let change = wanted - point.impulse_t;
                point.impulse_t = wanted;
                moving[point.a].push(point.arm_a, change);
                moving[point.b].push(point.arm_b, -change);
                largest = largest.max(change.length() * inverse_mass);
            }
            if largest <= CONVERGED * scale {
                break;
            }
        }
    }

    /// Gives the actors the sums of the impulses, so that the balance of momentum is exact, and logs them.
    fn apply_and_log(&mut self, scene: &mut Scene<'_>, time: f64) {
        let block = &mut self.block;
        block.retain(|p| p.impulse_n > 0.0);
        block.sort_by_key(|p| (scene.pairs[p.pair].key.a, scene.pairs[p.pair].key.b));
        let mut k = 0;
        while k < block.len() {
            let key = scene.pairs[block[k].pair].key;
            scene.log.begin(ContactKind::Impact);
            for actor in [block[k].a, block[k].b].map(|i| &self.actors[i]) {
                if scene.bodies[actor.body].is_moving() {
                    scene.log.pose(time, actor.body, &actor.now);
                }
            }
            while let Some(p) = block.get(k).filter(|p| {
                let other = scene.pairs[p.pair].key;
                (other.a, other.b) == (key.a, key.b)
            }) {
                scene.log.impulse(Impulse::between(
                    (key.a, p.arm_a),
                    (key.b, p.arm_b),
                    ContactKind::Impact,
                    time,
                    (p.point, p.normal, -p.gap),
                    (p.impulse_n, p.impulse_t, DVec3::ZERO),
                    p.before,
                ));
                k += 1;
            }
            scene.log.end();
        }
        for p in block.iter() {
            let impulse = p.normal * p.impulse_n + p.impulse_t;
            for (actor, arm, impulse) in [(p.a, p.arm_a, impulse), (p.b, p.arm_b, -impulse)] {
                let now = &mut self.actors[actor].now;
                now.velocity += impulse * now.inverse_mass;
                now.momentum += arm.cross(impulse);
            }
        }
        for actor in &mut self.actors {
            if scene.bodies[actor.body].is_awake() {
                actor.now.angular_velocity = actor.now.inverse_inertia * actor.now.momentum;
            }
        }
    }
}

/// The root of `a t² + b t + c` that a gap c > 0 closing at speed −b > 0 reaches first (the last one passed
/// if c < 0).
fn first_root(a: f64, b: f64, c: f64) -> Option<f64> {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return None;
    }
    let denominator = -b + discriminant.sqrt();
    (denominator > 0.0).then(|| 2.0 * c / denominator)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_of_a_closing_gap() {
        // A fall of 1 m at 9.81 m/s² from rest, and a gap that closes at 2 m/s.
        let root = first_root(-0.5 * 9.81, 0.0, 1.0).unwrap();
        assert!((root - (2.0_f64 / 9.81).sqrt()).abs() < 1e-15);
        assert_eq!(first_root(0.0, -2.0, 1.0), Some(0.5));
        assert_eq!(first_root(0.0, -2.0, -1.0), Some(-0.5));
        assert_eq!(first_root(0.0, 2.0, 1.0), None);
        assert_eq!(first_root(10.0, -1.0, 1.0), None);
    }
}
