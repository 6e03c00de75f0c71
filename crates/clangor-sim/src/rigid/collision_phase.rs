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

use super::collision_block::{Actor, Block, ELASTIC_HITS};
use super::collision_scene::Scene;
use super::prediction::{Candidate, Predictions};
use super::sleep;

/// Impacts closer than this in time are solved together \[s\].
const TIE: f64 = 1e-10;
/// Rounds of reflections in one block; the last ones are without restitution.
const MAX_ROUNDS: u32 = 2 * ELASTIC_HITS;
/// Pairs in a block.
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

    /// Collects the pairs that collide at the same instant as `first`.
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
        // The order of the list, not of discovery, decides the order of the solution.
        self.group.sort_unstable();
    }

    /// Solves the block of pairs in `group` at time `t` of the step.
    fn resolve(&mut self, scene: &mut Scene<'_>, t: f64) {
        let step = scene.step;
        self.wake(scene);
        self.block.actors.clear();
        for &index in &self.group {
            let key = scene.pairs[index].key;
            for body in [key.a as usize, key.b as usize] {
                if !self.block.actors.iter().any(|actor| actor.body == body) {
                    let state = &scene.bodies[body];
                    let now = state.at(step.time, step.length, t, state.gravity(step.gravity));
                    self.block.actors.push(Actor { body, now });
                }
            }
        }
        for round in 0..MAX_ROUNDS {
            self.block.assemble(scene, &self.group, round);
            if self.block.is_empty() {
                break;
            }
            self.block.solve();
            self.block.apply_and_log(scene, step.time + t);
        }
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
}
