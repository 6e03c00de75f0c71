//! Impacts within a step, in the order of time, before gravity acts.
//!
//! For every contact point the first root t* of its gap is predicted (`prediction`). The earliest pair is
//! moved to the exact poses of t* and solved there. Pairs within [`TIE`] of each other form one block
//! (`collision_block`), which is solved repeatedly until none of its points approaches (generalized
//! reflections, \[REFL\] §4). A row of touching balls therefore transmits a single impulse, and a ball
//! between two others is treated symmetrically. After each impulse the predictions of all neighbours are
//! renewed. Where bodies have modes, the impulses of a solve of the contacts come first (`compliant_block`).
//!
//! Points slower than the rest speed are left to the contact phase; restitution grows from 0 at that speed to
//! e at twice that speed. Because impacts precede gravity (\[GUE\] §7), a resting body has none.
//!
//! Differs: \[GUE\] moves all bodies to the end of the step and solves there; here every impulse acts at its
//! own instant and pose.

use super::collision_block::{Block, ELASTIC_HITS};
use super::collision_scene::Scene;
use super::prediction::{Candidate, Predictions};
use super::sleep;

/// Impacts closer than this in time are solved together \[s\].
const TIE: f64 = 1e-10;
/// Rounds of reflections in one block; later rounds have no restitution.
const MAX_ROUNDS: u32 = 2 * ELASTIC_HITS;
/// Largest number of pairs in a block.
const MAX_GROUP: usize = 256;
/// Buffers of the phase.
#[derive(Default)]
pub(super) struct CollisionPhase {
    predictions: Predictions,
    group: Vec<usize>,
    block: Block,
    touched: Vec<usize>,
}

impl CollisionPhase {
    /// Resolves every impact of the step.
    pub(super) fn run(&mut self, scene: &mut Scene<'_>) {
        self.predictions.clear();
        for index in 0..scene.pairs.len() {
            if scene.pairs[index].live {
                self.predictions.predict(scene, index);
            }
        }
        while let Some(candidate) = self.predictions.pop() {
            if candidate.stamp != scene.pairs[candidate.pair].stamp {
                continue;
            }
            if !candidate.exact {
                self.predictions.refine(scene, &candidate);
                continue;
            }
            self.gather(scene, &candidate);
            self.resolve(scene, candidate.time);
        }
    }

    /// Collects the pairs that collide at the instant of `first`.
    fn gather(&mut self, scene: &mut Scene<'_>, first: &Candidate) {
        self.group.clear();
        self.group.push(first.pair);
        while let Some(next) = self.predictions.peek() {
            if next.time - first.time > TIE || self.group.len() >= MAX_GROUP {
                break;
            }
            let Some(next) = self.predictions.pop() else { break };
            if next.stamp != scene.pairs[next.pair].stamp || self.group.contains(&next.pair) {
                continue;
            }
            if next.exact {
                self.group.push(next.pair);
            } else {
                self.predictions.refine(scene, &next);
            }
        }
        // Pairs are solved in the order of their list, not of their discovery.
        self.group.sort_unstable();
    }

    /// Solves the block of pairs in `group` at time `t` of the step.
    fn resolve(&mut self, scene: &mut Scene<'_>, t: f64) {
        let step = scene.step;
        self.wake(scene);
        // Bodies of the block at the instant t.
        self.block.actors.clear();
        for &index in &self.group {
            for body in scene.pairs[index].ends() {
                self.block.add_actor(scene, body, t);
            }
        }
        self.block.join(scene, t);
        // Bodies that vibrate: impulses of a solve of the contacts.
        self.block.give_way(scene, &mut self.group, t);
        // Rounds of reflections until no point approaches.
        for round in 0..MAX_ROUNDS {
            self.block.assemble(scene, &self.group, round);
            if self.block.is_empty() {
                break;
            }
            if self.block.solve(scene.linkages) {
                self.block.solve_without_springs(scene, &self.group, round);
            }
            self.block.apply_and_log(scene, step.time + t, false);
        }
        // Continue the flight of the bodies from their new velocities.
        self.touched.clear();
        for actor in &self.block.actors {
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
        // Renew the predictions of all neighbours.
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
                    self.predictions.predict(scene, index);
                }
            }
        }
    }

    /// Wakes the sleeping bodies of the group and their islands.
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
}
