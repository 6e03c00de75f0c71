//! Phases of motion between events: bringing states forward, and starting the next phase.

use glam::DVec3;

use super::ball::MotionPhase;
use super::engine::Engine;
use super::support::{self, End, Ground};
use crate::spheres::tolerances::TOUCH;

impl Engine {
    /// Makes the present state of a ball its new reference state.
    pub(super) fn bring_forward(&mut self, ball: usize) {
        self.accumulate(ball);
        let island_place = self.island_place(ball);
        let record = &mut self.balls[ball];
        if record.time == self.now {
            return;
        }
        let spin = &mut self.spins[ball];
        let (position, velocity) = match island_place {
            Some((island, place)) => self.islands[island].arcs[place].at(self.now),
            None => record.at(self.now),
        };
        (spin.orientation, spin.omega) = spin.after(self.now - record.time);
        (record.position, record.velocity, record.time) = (position, velocity, self.now);
    }

    /// Makes the present states of the balls of an island their new reference states.
    pub(super) fn bring_island_forward(&mut self, island: usize) {
        self.accumulate_links(island);
        for place in 0..self.islands[island].balls.len() {
            self.bring_forward(self.islands[island].balls[place]);
        }
    }

    /// Starts a new segment of the arcs of an island, whose balls have been brought forward. If its motion
    /// cannot be followed, the run ends before the next event.
    pub(super) fn launch(&mut self, island: usize) {
        let Engine { islands, balls, spins, next, now, lost, traits, .. } = self;
        let island = &mut islands[island];
        let (mut x, mut v): (Vec<_>, Vec<_>) =
            island.balls.iter().map(|&ball| (balls[ball].position, balls[ball].velocity)).unzip();
        if island.launch(*now, &mut x, &mut v).is_err() {
            *lost = island.balls.first().map(|&ball| traits[ball].body);
        }
        for (place, &ball) in island.balls.iter().enumerate() {
            let record = &mut balls[ball];
            (record.position, record.velocity) = (x[place], v[place]);
            record.motion_phase = MotionPhase::Arc;
            record.generation = record.generation.wrapping_add(1);
            spins[ball].alpha = DVec3::ZERO;
            next[ball].phase_end = island.end();
        }
    }

    /// Predicts the next events of all balls of an island.
    pub(super) fn predict_island(&mut self, island: usize) {
        for place in 0..self.islands[island].balls.len() {
            self.predict(self.islands[island].balls[place]);
        }
    }

    /// Starts a new phase of motion at the present time, from an updated reference state.
    pub(super) fn start_phase(&mut self, ball: usize, ended: Option<(Ground, End)>) {
        let (record, spin, traits) = (&mut self.balls[ball], &mut self.spins[ball], &self.traits[ball]);
        let mut state = support::State {
            radius: record.radius,
            mass: traits.mass,
            inertia: 1.0 / traits.inverse_inertia,
            velocity: record.velocity,
            omega: spin.omega,
            gravity: self.gravity,
        };
        if let Some((ground, end)) = ended {
            support::finish(&mut state, &ground, end);
        }
        let mut grounds = Vec::new();
        for (index, plane) in self.planes.iter().enumerate() {
            let gap = plane.normal.dot(record.position) - plane.offset - record.radius;
            if gap <= TOUCH && support::in_touch(plane.normal.dot(record.velocity)) {
                let pair = self.pairs.of(traits.material, plane.material);
                grounds.push(Ground {
                    plane: index,
                    normal: plane.normal,
                    friction: pair.friction,
                    rolling_loss: pair.rolling_loss,
                });
            }
        }
        let phase = support::phase(&mut state, &grounds);
        let removed = state.velocity - record.velocity;
        (record.velocity, spin.omega) = (state.velocity, state.omega);
        (record.acceleration, spin.alpha) = (phase.acceleration, phase.alpha);
        record.generation = record.generation.wrapping_add(1);
        self.next[ball].phase_end = self.now + phase.duration;
        let (flew, flies) = (record.motion_phase == MotionPhase::Ballistic, phase.reactions.is_empty());
        record.motion_phase = if flies { MotionPhase::Ballistic } else { MotionPhase::Steady };
        if let Some(reaction) = phase.reactions.first() {
            let Ground { plane, normal, .. } = reaction.ground;
            self.accumulate_removed(ball, plane, removed.dot(normal) * state.mass);
        }
        if !(flew && flies) {
            self.phases[ball] = (!flies).then(|| Box::new(phase));
        }
    }
}
