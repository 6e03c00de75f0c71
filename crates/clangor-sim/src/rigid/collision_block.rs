//! A block of simultaneous impacts: which points take part, and their impulses.
//!
//! Only the points that approach are solved together: `u⁺ ≥ −e u⁻` with `λ ≥ 0` and a round friction cone
//! (generalized reflections, \[REFL\] §4), by projected Gauss-Seidel. Joints of the bodies react to every
//! impulse (`reactions`), and the whole linkage takes part.

use clangor_core::pose::Pose;
use clangor_core::timeline::ContactKind;
use glam::DVec3;

use super::collision_scene::Scene;
use super::impact_threshold::rest_speed;
use super::linkage::Linkages;
use super::mover::Mover;
use super::reactions::{JointImpulse, Reactions};
use super::state::Instant;
use super::step_log::{ContactImpulse, Impulse};

/// Points of a pair that touch within this time belong to the impact \[s\].
pub(super) const TOGETHER: f64 = 1e-7;
/// Points of a pair within this distance belong to the impact \[m\].
pub(super) const TOUCHING: f64 = 1e-9;
/// Impacts of one pair in one step, or rounds of one block, after which restitution is dropped.
pub(super) const ELASTIC_HITS: u32 = 12;
/// Gauss-Seidel sweeps at most.
const MAX_SWEEPS: u32 = 400;
/// Points among which a linkage divides an impulse alike at most; more would converge slowly.
const MOST_SHARES: f64 = 8.0;
/// Part of the energy of an approach that reactions of springs may add.
const GAINED: f64 = 1e-3;
/// Velocity correction, relative to the approach, that ends the sweeps.
const CONVERGED: f64 = 1e-14;
/// The same after the last sweep, from which the impulses of a linkage contradict each other.
const CONTRADICTED: f64 = 1e-3;

/// A body in a block.
pub(super) struct Actor {
    pub(super) body: usize,
    pub(super) now: Instant,
}

/// A point in a block.
pub(super) struct BlockPoint {
    pub(super) pair: usize,
    pub(super) a: usize,
    pub(super) b: usize,
    pub(super) normal: DVec3,
    pub(super) point: DVec3,
    pub(super) gap: f64,
    pub(super) arm_a: DVec3,
    pub(super) arm_b: DVec3,
    pub(super) inverse_mass: f64,
    pub(super) friction: f64,
    pub(super) target: f64,
    pub(super) before: DVec3,
    pub(super) impulse_n: f64,
    pub(super) impulse_t: DVec3,
}

impl Actor {
    pub(super) fn pose(&self) -> Pose {
        Pose { position: self.now.position, orientation: self.now.orientation }
    }
}

impl BlockPoint {
    /// A point of a pair between two actors, without impulse.
    pub(super) fn at(
        pair: usize,
        (a, b): (usize, usize),
        (normal, point): (DVec3, DVec3),
        actors: &[Actor],
    ) -> Self {
        let (now_a, now_b) = (&actors[a].now, &actors[b].now);
        let (arm_a, arm_b) = (point - now_a.position, point - now_b.position);
        BlockPoint {
            pair,
            a,
            b,
            normal,
            point,
            gap: 0.0,
            arm_a,
            arm_b,
            inverse_mass: now_a.mover().inverse_mass_at(arm_a, normal)
                + now_b.mover().inverse_mass_at(arm_b, normal),
            friction: 0.0,
            target: 0.0,
            before: now_a.velocity_at(arm_a) - now_b.velocity_at(arm_b),
            impulse_n: 0.0,
            impulse_t: DVec3::ZERO,
        }
    }

    /// Its bodies and their arms \[m\].
    fn ends(&self) -> [(usize, DVec3); 2] {
        [(self.a, self.arm_a), (self.b, self.arm_b)]
    }

    /// Solves this point with all others held fixed. Returns the largest change of velocity \[m/s\].
    ///
    /// A point of a linkage takes `share` of what is missing: joints make several points block one motion,
    /// and these divide the impulse alike.
    fn relax(&mut self, moving: &mut [Mover], reactions: &mut Reactions, share: f64) -> f64 {
        let linked = reactions.holds(self.a) || reactions.holds(self.b);
        let share = if linked { share } else { 1.0 };
        let ends = self.ends();
        let relative = |m: &[Mover]| m[self.a].velocity_at(self.arm_a) - m[self.b].velocity_at(self.arm_b);
        let push = |moving: &mut [Mover], reactions: &mut Reactions, impulse: DVec3| {
            let (on_a, on_b) = (self.arm_a.cross(impulse), self.arm_b.cross(-impulse));
            moving[self.a].push(impulse, on_a);
            moving[self.b].push(-impulse, on_b);
            if linked {
                reactions.react(moving, &[(self.a, impulse, on_a), (self.b, -impulse, on_b)]);
            }
        };
        // Normal impulse.
        let speed = relative(moving).dot(self.normal);
        let change = (share * (self.target - speed) / self.inverse_mass).max(-self.impulse_n);
        push(moving, reactions, self.normal * change);
        let changed = (change * self.inverse_mass).abs();
        let impulse_n = self.impulse_n + change;
        // Friction, projected onto the cone.
        let slip = relative(moving).reject_from_normalized(self.normal);
        let Some(direction) = slip.try_normalize().filter(|_| self.friction > 0.0) else {
            self.impulse_n = impulse_n;
            return changed;
        };
        let inverse_mass = if linked {
            reactions.response(moving, ends, direction).dot(direction)
        } else {
            moving[self.a].inverse_mass_at(self.arm_a, direction)
                + moving[self.b].inverse_mass_at(self.arm_b, direction)
        };
        let limit = self.friction * impulse_n;
        let wanted = (self.impulse_t - share * slip / inverse_mass).clamp_length_max(limit);
        let change = wanted - self.impulse_t;
        push(moving, reactions, change);
        (self.impulse_n, self.impulse_t) = (impulse_n, wanted);
        changed.max(change.length() * inverse_mass)
    }
}

/// The bodies and points of a block.
#[derive(Default)]
pub(super) struct Block {
    pub(super) actors: Vec<Actor>,
    /// Whether bodies vibrate by impacts that nothing solves: restitution is that of whole bodies.
    pub(super) vibrates: bool,
    points: Vec<BlockPoint>,
    reactions: Reactions,
}

impl Block {
    /// Adds the bodies that joints hold to the actors, and sets up their joints.
    pub(super) fn join(&mut self, scene: &Scene<'_>, t: f64) {
        let linkages = scene.linkages;
        let mut joined: Vec<usize> = self.actors.iter().filter_map(|actor| linkages.of(actor.body)).collect();
        joined.sort_unstable();
        joined.dedup();
        for body in joined.iter().flat_map(|&linkage| linkages.ends_of(linkage)) {
            self.add_actor(scene, body, t);
        }
        let movers: Vec<Mover> = self.actors.iter().map(|actor| actor.now.mover()).collect();
        let place = |body: usize| {
            let index = self.actors.iter().position(|actor| actor.body == body).unwrap_or(0);
            (self.actors[index].pose(), index)
        };
        let chosen = (joined.into_iter(), &[][..]);
        self.reactions.set_up(linkages, chosen, &place, (&movers, scene.step.length));
    }

    /// Adds a body at time `t` of the step, unless it takes part already.
    pub(super) fn add_actor(&mut self, scene: &Scene<'_>, body: usize, t: f64) {
        if !self.actors.iter().any(|actor| actor.body == body) {
            let state = &scene.bodies[body];
            let now = state.at(scene.step.time, scene.step.length, t, state.gravity(scene.step.gravity));
            self.actors.push(Actor { body, now });
        }
    }

    /// Whether joints hold an actor.
    pub(super) fn is_linked(&self) -> bool {
        !self.reactions.is_empty()
    }

    /// Replaces the points by some whose impulses are known.
    pub(super) fn replace_points(&mut self, points: Vec<BlockPoint>) {
        self.points = points;
    }

    /// Whether no point approaches.
    pub(super) fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Collects the approaching points of the group.
    pub(super) fn assemble(&mut self, scene: &Scene<'_>, group: &[usize], round: u32) {
        self.points.clear();
        let movers: Vec<Mover> = self.actors.iter().map(|actor| actor.now.mover()).collect();
        for &index in group {
            let pair = &scene.pairs[index];
            let find = |body: u32| self.actors.iter().position(|actor| actor.body == body as usize);
            let (Some(a), Some(b)) = (find(pair.key.a), find(pair.key.b)) else { continue };
            let normal = pair.exact.normal;
            let rest = rest_speed(&pair.coefficients.restitution, &scene.step);
            let whole = scene.compliance.as_ref().filter(|_| self.vibrates);
            let law = whole.map_or(pair.coefficients.restitution, |c| c.whole_restitution(pair));
            for point in &pair.exact.points {
                let middle = (point.on_a + point.on_b) * 0.5;
                let known = BlockPoint::at(index, (a, b), (normal, middle), &self.actors);
                let approach = -known.before.dot(normal);
                if approach <= rest || point.gap > TOUCHING + TOGETHER * approach {
                    continue;
                }
                let spent = pair.hits >= ELASTIC_HITS || round >= ELASTIC_HITS;
                let ramp = ((approach - rest) / rest).clamp(0.0, 1.0);
                let restitution = if spent { 0.0 } else { law.at(approach) * ramp };
                let mut inverse_mass = known.inverse_mass;
                if self.reactions.holds(a) || self.reactions.holds(b) {
                    inverse_mass = self.reactions.response(&movers, known.ends(), normal).dot(normal);
                    // Joints hold the point: nothing can turn it back.
                    if self.reactions.hold_point(&movers, [a, b], inverse_mass) {
                        continue;
                    }
                }
                self.points.push(BlockPoint {
                    gap: point.gap,
                    friction: pair.coefficients.friction,
                    target: restitution * approach,
                    inverse_mass,
                    ..known
                });
            }
        }
    }

    /// Computes the impulses of the points by projected Gauss-Seidel; [`Self::apply_and_log`] then applies
    /// them to the actors. Returns whether reactions of springs have added energy.
    ///
    /// Where joints make approach and slip one motion, restitution and friction may contradict each other:
    /// then no impulse satisfies both, and the points are solved without friction.
    pub(super) fn solve(&mut self, linkages: &Linkages) -> bool {
        let before: Vec<Mover> = self.actors.iter().map(|actor| actor.now.mover()).collect();
        let (mut moving, change) = self.sweep(&before);
        if self.is_linked() && (change > CONTRADICTED || self.work(&before, &moving) > 0.0) {
            for point in &mut self.points {
                (point.friction, point.impulse_n, point.impulse_t) = (0.0, 0.0, DVec3::ZERO);
            }
            moving = self.sweep(&before).0;
        }
        let works = self.reactions.works(&before, &moving);
        let added: f64 = works.filter(|of| linkages.has_springs(of.0)).map(|of| of.1).sum();
        let met: f64 = self.points.iter().map(|p| 0.5 * p.impulse_n * p.before.length()).sum();
        added > GAINED * met
    }

    /// Projected Gauss-Seidel over all points. Returns the bodies after it, and the change of velocity in the
    /// last sweep, relative to the approach.
    fn sweep(&mut self, before: &[Mover]) -> (Vec<Mover>, f64) {
        let mut moving = before.to_vec();
        let scale = self.points.iter().map(|p| p.before.length()).fold(0.0, f64::max);
        self.reactions.restart();
        let share = 1.0 / (self.points.len() as f64).clamp(1.0, MOST_SHARES);
        let mut largest = 0.0_f64;
        for _ in 0..MAX_SWEEPS {
            largest = 0.0;
            for point in &mut self.points {
                largest = largest.max(point.relax(&mut moving, &mut self.reactions, share));
            }
            largest = largest.max(self.reactions.pull_taut(&mut moving));
            if largest <= CONVERGED * scale {
                break;
            }
        }
        (moving, largest / scale)
    }

    /// Work of the impulses of all points \[J\].
    fn work(&self, before: &[Mover], after: &[Mover]) -> f64 {
        let work = |point: &BlockPoint| {
            let relative = |movers: &[Mover]| {
                movers[point.a].velocity_at(point.arm_a) - movers[point.b].velocity_at(point.arm_b)
            };
            let impulse = point.normal * point.impulse_n + point.impulse_t;
            0.5 * impulse.dot(relative(before) + relative(after))
        };
        self.points.iter().map(work).sum()
    }

    /// Solves the points again for springs that do not react: what a spring does in the time of an impact.
    pub(super) fn solve_without_springs(&mut self, scene: &Scene<'_>, group: &[usize], round: u32) {
        let movers: Vec<Mover> = self.actors.iter().map(|actor| actor.now.mover()).collect();
        self.reactions.release_springs(&movers);
        self.assemble(scene, group, round);
        self.solve(scene.linkages);
    }

    /// Applies the summed impulses to the actors, so that the balance of momentum is exact, and logs them.
    pub(super) fn apply_and_log(&mut self, scene: &mut Scene<'_>, time: f64, solved: bool) {
        let before: Vec<Mover> = self.actors.iter().map(|actor| actor.now.mover()).collect();
        let block = &mut self.points;
        block.retain(|p| p.impulse_n > 0.0);
        block.sort_by_key(|p| (scene.pairs[p.pair].key.a, scene.pairs[p.pair].key.b));
        let pushed: Vec<_> = block.iter().map(|p| (p.ends(), p.normal)).collect();
        let masses = self.reactions.effective_masses(&before, &pushed);
        let mut k = 0;
        while k < block.len() {
            let key = scene.pairs[block[k].pair].key;
            scene.log.begin(ContactKind::Impact);
            if solved {
                scene.log.mark_solved();
            }
            for actor in [block[k].a, block[k].b].map(|i| &self.actors[i]) {
                if scene.bodies[actor.body].is_moving() {
                    scene.log.pose(time, actor.body, &actor.now);
                }
            }
            while let Some(p) = block.get(k).filter(|p| {
                let other = scene.pairs[p.pair].key;
                (other.a, other.b) == (key.a, key.b)
            }) {
                let impulse = ContactImpulse {
                    point: p.point,
                    normal: p.normal,
                    depth: -p.gap,
                    impulse_n: p.impulse_n,
                    impulse_t: p.impulse_t,
                    couple: DVec3::ZERO,
                    velocity: p.before,
                    effective_mass: masses[k],
                };
                let (a, b) = ((key.a, p.arm_a), (key.b, p.arm_b));
                scene.log.impulse(Impulse::between(a, b, ContactKind::Impact, time, impulse));
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
        for JointImpulse { ends, arms, impulse, couple, .. } in self.reactions.totals() {
            for ((actor, arm), sign) in ends.into_iter().zip(arms).zip([1.0, -1.0]) {
                if let Some(actor) = actor {
                    let now = &mut self.actors[actor].now;
                    now.velocity += impulse * (sign * now.inverse_mass);
                    now.momentum += (arm.cross(impulse) + couple) * sign;
                }
            }
        }
        if scene.log.skips_slower().is_none() {
            self.reactions.log(scene.linkages, time, scene.log);
        }
        for actor in &mut self.actors {
            if scene.bodies[actor.body].is_awake() {
                actor.now.angular_velocity = actor.now.inverse_inertia * actor.now.momentum;
            }
        }
        let after: Vec<Mover> = self.actors.iter().map(|actor| actor.now.mover()).collect();
        for (linkage, work) in self.reactions.works(&before, &after) {
            scene.balance.add_impact(linkage, work);
        }
        self.reactions.restart();
    }
}
