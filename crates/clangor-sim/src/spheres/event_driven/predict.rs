//! Predicts the next event of a ball, among planes, neighbours and the faces of its cell.

use glam::DVec3;

use super::ball::{Ball, MotionPhase};
use super::engine::{Engine, NEVER, Next, PLANE, SEARCH};
use super::grid::{NONE, NOWHERE};
use crate::spheres::approach::{Approach, fall, meet, meet_plane, meet_uniform};
use crate::spheres::tolerances::CONTACT_TIME;

/// The ball whose next event is sought, at the present time.
struct Seeker {
    ball: usize,
    position: DVec3,
    velocity: DVec3,
    radius: f64,
    acceleration: DVec3,
    motion_phase: MotionPhase,
}

impl Engine {
    /// Predicts the next event of a ball.
    pub(super) fn predict(&mut self, ball: usize) {
        if !self.traits[ball].free {
            return;
        }
        let seeker = self.seeker(ball);
        let Seeker { position, velocity, acceleration, radius, .. } = seeker;
        let mut best = Next { phase_end: self.next[ball].phase_end, ..NEVER };
        let supported = seeker.motion_phase == MotionPhase::Steady;
        // Planes.
        for (index, plane) in self.planes.iter().enumerate() {
            if supported && self.rests_on(ball, index) {
                continue;
            }
            let height = |x: DVec3| plane.normal.dot(x) - plane.offset - radius;
            let (met, partner) = match self.island_place(ball) {
                None => {
                    let (v, a) = (plane.normal.dot(velocity), plane.normal.dot(acceleration));
                    (meet_plane(height(position), v, a), PLANE | index as u32)
                }
                Some((island, place)) => {
                    let arc = &self.islands[island].arcs[place];
                    let gap_at = |s: f64| {
                        let (x, v) = arc.at(self.now + s);
                        (height(x), plane.normal.dot(v))
                    };
                    match meet(gap_at, arc.bound(), best.phase_end.min(best.contact) - self.now) {
                        Approach::Never => (None, NONE),
                        Approach::At(s) => (Some(s), PLANE | index as u32),
                        Approach::Unclear(s) => (Some(s), SEARCH),
                    }
                }
            };
            if let Some(s) = met
                && self.now + s < best.contact
            {
                best.contact = self.now + s;
                best.partner = partner;
            }
        }
        // Balls in the neighbouring cells.
        self.for_each_near(ball, |other, near| {
            self.consider(&seeker, other, near, &mut best);
        });
        self.next[ball] = best;
        self.watch_cell(&seeker);
    }

    /// Keeps the meeting with another ball if it is the earliest so far.
    #[inline]
    fn consider(&self, seeker: &Seeker, other: usize, near: &Ball, best: &mut Next) {
        // A cluster finds itself whom its balls meet.
        if near.motion_phase == MotionPhase::Pressed {
            return;
        }
        if seeker.motion_phase == MotionPhase::Ballistic && near.motion_phase == MotionPhase::Ballistic {
            // Uses only the first cache line of the other ball: whether they approach, and pass near enough.
            let s = self.now - near.time;
            let w = near.velocity + self.gravity * s;
            let d = seeker.position - near.position - (near.velocity + w) * (0.5 * s);
            let w = seeker.velocity - w;
            let widest = seeker.radius + self.broadest;
            let misses = d.cross(w).length_squared() > widest * widest * w.length_squared();
            if d.dot(w) >= 0.0 || misses {
                return;
            }
            let reach = seeker.radius + near.radius;
            if let Some(mut s) = meet_uniform(d, w, reach)
                && self.now + s < best.contact
            {
                // An unresolved approach in a pile is retried only after CONTACT_TIME.
                let just_hit = |ball: usize| self.traits[ball].last_hit == self.now;
                if s == 0.0 && just_hit(seeker.ball) && just_hit(other) && w.length() < self.slow_speed() {
                    s = CONTACT_TIME;
                }
                best.contact = self.now + s;
                best.partner = other as u32;
                best.generation = near.generation;
            }
            return;
        }
        // All other pairs: safe Newton search with a bound on the relative acceleration.
        let reach = seeker.radius + near.radius;
        let horizon = best.contact.min(best.phase_end).min(self.next[other].phase_end) - self.now;
        let between = |d: DVec3, w: DVec3| {
            let distance = d.length();
            (distance - reach, d.dot(w) / distance)
        };
        let approach = if seeker.motion_phase == MotionPhase::Arc || near.motion_phase == MotionPhase::Arc {
            let gap_at = |s: f64| {
                let ((x, v), (y, w)) =
                    (self.state(seeker.ball, self.now + s), self.state(other, self.now + s));
                between(x - y, v - w)
            };
            meet(gap_at, self.relative_bound(seeker.ball, other), horizon)
        } else {
            let (y, w) = near.at(self.now);
            let (d, w) = (seeker.position - y, seeker.velocity - w);
            let a = seeker.acceleration - near.acceleration;
            meet(|s| between(d + (w + a * (0.5 * s)) * s, w + a * s), a.length(), horizon)
        };
        let (s, partner) = match approach {
            Approach::Never => return,
            Approach::At(s) => (s, other as u32),
            Approach::Unclear(s) => (s, SEARCH),
        };
        if self.now + s < best.contact {
            best.contact = self.now + s;
            best.partner = partner;
            best.generation = near.generation;
        }
    }

    /// Bound on the relative acceleration of two balls until one of them changes its motion \[m/s²\].
    fn relative_bound(&self, one: usize, two: usize) -> f64 {
        let arc =
            |ball: usize| self.island_place(ball).map(|(island, place)| &self.islands[island].arcs[place]);
        match (arc(one), arc(two)) {
            (Some(a), Some(b)) => a.relative_bound(b),
            (Some(a), None) => a.bound() + self.balls[two].acceleration.length(),
            (None, Some(b)) => self.balls[one].acceleration.length() + b.bound(),
            (None, None) => (self.balls[one].acceleration - self.balls[two].acceleration).length(),
        }
    }

    /// Computes when a ball leaves its cell, and schedules its next event.
    fn watch_cell(&mut self, seeker: &Seeker) {
        let Seeker { ball, position, velocity, acceleration, .. } = *seeker;
        let (island_place, record) = (self.island_place(ball), &self.balls[ball]);
        let mut exit = record.exit;
        let edge = self.grid.edge();
        let mut leaves = f64::INFINITY;
        if record.bucket != NOWHERE && edge.is_finite() {
            for axis in 0..3 {
                let (x, v, a) = (position[axis], velocity[axis], acceleration[axis]);
                let low = f64::from(record.cell[axis]) * edge;
                for (side, gap, v, a) in [(0, x - low, v, a), (1, low + edge - x, -v, -a)] {
                    let reached = match island_place {
                        None => fall(gap.max(0.0), v, a),
                        Some((island, place)) => {
                            let arc = &self.islands[island].arcs[place];
                            let gap_at = |s: f64| {
                                let (x, v) = arc.at(self.now + s);
                                if side == 0 {
                                    (x[axis] - low, v[axis])
                                } else {
                                    (low + edge - x[axis], -v[axis])
                                }
                            };
                            match meet(gap_at, arc.bound(), self.next[ball].phase_end - self.now) {
                                Approach::Never => None,
                                Approach::At(s) | Approach::Unclear(s) => Some(s),
                            }
                        }
                    };
                    if let Some(s) = reached
                        && s < leaves
                    {
                        leaves = s;
                        exit = (2 * axis + side) as u8;
                    }
                }
            }
        }
        self.balls[ball].exit = exit;
        let next = &mut self.next[ball];
        next.crossing = self.now + leaves;
        self.schedule.set(ball, next.contact.min(next.crossing).min(next.phase_end));
    }

    fn seeker(&self, ball: usize) -> Seeker {
        let record = &self.balls[ball];
        let (position, velocity) = match record.motion_phase {
            MotionPhase::Arc => self.state(ball, self.now),
            _ => record.at(self.now),
        };
        let (radius, acceleration, motion_phase) = (record.radius, record.acceleration, record.motion_phase);
        Seeker { ball, position, velocity, radius, acceleration, motion_phase }
    }

    /// Moves a ball to the neighbouring cell and predicts meetings with the balls that have come near.
    pub(super) fn cross(&mut self, ball: usize) {
        let exit = self.balls[ball].exit;
        self.grid.remove(&mut self.balls, ball);
        self.balls[ball].cell[usize::from(exit / 2)] += if exit % 2 == 1 { 1 } else { -1 };
        self.grid.insert(&mut self.balls, ball);
        let cell = self.balls[ball].cell;
        let seeker = self.seeker(ball);
        let mut best = self.next[ball];
        for mut other in self.grid.ahead(cell, exit).iter() {
            while other != NONE {
                let near = &self.balls[other as usize];
                if other as usize != ball {
                    self.consider(&seeker, other as usize, near, &mut best);
                }
                other = near.next;
            }
        }
        self.next[ball] = best;
        self.watch_cell(&seeker);
    }
}
