//! Balls that press on several others at once: the pairs that the push of an impact reaches.
//!
//! A ball that is hit moves by about V τ while the contact lasts. Other balls and fixed bodies no farther
//! away than that, and those that they reach in turn, feel the push before it ends: a rack breaks, a row
//! passes the push on. Their contacts are solved with those of the impact.
//!
//! The normals are those of the first instant. Bodies of other shapes are met afterwards, by reflections.

use super::collision_block::{Actor, Block};
use super::collision_scene::Scene;
use super::shape::PartShape;

/// Most pairs of a block: beyond, balls follow the law of rigid bodies.
const MOST_PAIRS: usize = 64;

impl Scene<'_> {
    /// Whether a body is a ball that moves freely and is awake.
    pub(super) fn is_free_ball(&self, body: usize) -> bool {
        let state = &self.bodies[body];
        let parts = &self.shapes[state.shape].parts;
        state.is_awake() && matches!(parts.as_slice(), [part] if matches!(part.shape, PartShape::Ball { .. }))
    }
}

impl Block {
    /// Adds the pairs of balls, with each other and with bodies that are not free, whose gaps at the time `t`
    /// of the step are within `reach` \[m\], from those of the block outwards, and their bodies. Says
    /// whether more than one pair is in the block; adds none where they are too many, or a joint holds one.
    pub(super) fn add_pressed_balls(
        &mut self,
        scene: &mut Scene<'_>,
        group: &mut Vec<usize>,
        (reach, t): (f64, f64),
    ) -> bool {
        let (own, bodies) = (group.len(), self.actors.len());
        let mut next = 0;
        while let Some(body) = self.actors.get(next).map(|actor| actor.body) {
            next += 1;
            let neighbours = if scene.is_free_ball(body) { scene.neighbours.of(body) } else { &[] };
            for &index in neighbours {
                let index = index as usize;
                let [a, b] = scene.pairs[index].ends();
                let other = if a == body { b } else { a };
                let is_linked = scene.linkages.of(other).is_some();
                let takes_part = scene.is_free_ball(other) || !scene.bodies[other].is_free();
                if !takes_part || group.contains(&index) {
                    continue;
                }
                let pair = &mut scene.pairs[index];
                pair.find_within(scene.bodies, scene.shapes, &scene.step, (t, reach), scene.scratch);
                if pair.exact.points.iter().all(|point| point.gap > reach) {
                    continue;
                }
                group.push(index);
                // The solve does not know the reactions of joints.
                if is_linked || group.len() > MOST_PAIRS {
                    group.truncate(own);
                    self.actors.truncate(bodies);
                    return false;
                }
                if !self.actors.iter().any(|actor| actor.body == other) {
                    let state = &scene.bodies[other];
                    let gravity = state.gravity(scene.step.gravity);
                    let now = state.at(scene.step.time, scene.step.length, t, gravity);
                    self.actors.push(Actor { body: other, now });
                }
            }
        }
        group.len() > 1
    }
}
