//! Balls on rods and springs, whose motion has no closed form, over one time segment after another.
//!
//! A hung ball is a spherical pendulum: a = f + Σ λᵢ dᵢ with dᵢ the unit vectors from the anchors and dᵢ·a =
//! −v²/Lᵢ. Rods are rigid: they push as well as pull, and a fast ball turns over the top. Two rods hold a
//! ball to a circle about the line through their anchors, well determined even when the rods are nearly in
//! line (`track`). A spring pulls with k (ℓ − ℓ₀) + c ℓ̇ along itself. Balls that springs join are
//! integrated together, as an island.
//!
//! Over a segment of h seconds the accelerations are interpolated at [`NODES`] Chebyshev points and
//! integrated twice in closed form ([`Arc`]); the accelerations at the new positions give the next iterate,
//! until convergence (Picard–Chebyshev iteration: collocation of order [`NODES`]). The iteration contracts
//! where the forces change little over a segment. It is refused, and the segment halved, when an iterate is
//! not finite, when iterates grow, or when the last coefficients are not negligible. The length of the first
//! segment, and of the first after each impact, follows from the rates at which the forces change.

use clangor_core::body::BodyId;
use glam::DVec3;

use super::arc::{Arc, NODES, TABLE};
use super::track::Track;
use crate::spheres::spring_pace;

/// Last coefficients of the acceleration that are negligible, relative to the largest acceleration.
const TAIL: f64 = 1e-13;
/// Iterations in which a segment must converge.
const MAX_ITERATIONS: usize = 40;
/// Iterations after which changes that still grow show a segment to be too long.
const GROWING: usize = 8;
/// Operations whose rounding errors add up in an acceleration.
const ROUNDINGS: f64 = 8.0;
/// Longest and shortest segment \[s\]. The shortest is accepted if it is finite: it contains a jump of the
/// force, as of a spring whose length passes through zero.
const LONGEST: f64 = 0.5;
const SHORTEST: f64 = 1e-11;
/// A segment shorter than this is brief \[s\]. Approaching and leaving a jump takes some dozens of them; an
/// island that moves on in brief segments only changes too fast to be followed.
const BRIEF: f64 = 1e-8;
/// Most brief segments in succession.
const MOST_BRIEF: u32 = 1000;

/// A spring of an island.
#[derive(Clone, Debug)]
pub(super) struct Spring {
    /// Ball of the island at one end.
    pub(super) ball: usize,
    /// Ball at the other end, or a fixed point.
    pub(super) to: Far,
    /// The body at the other end, or the world.
    pub(super) far_body: BodyId,
    /// Length without force \[m\].
    pub(super) rest_length: f64,
    /// Stiffness \[N/m\].
    pub(super) stiffness: f64,
    /// Damping \[N s/m\].
    pub(super) damping: f64,
}

/// The far end of a spring.
#[derive(Clone, Copy, Debug)]
pub(super) enum Far {
    /// Ball of the same island.
    Ball(usize),
    /// A point \[m\].
    Point(DVec3),
}

/// A rod from a fixed point to a ball's centre.
#[derive(Clone, Debug)]
pub(super) struct Rod {
    /// Ball of the island.
    pub(super) ball: usize,
    /// Fixed end \[m\].
    pub(super) anchor: DVec3,
}

/// Balls that are integrated together.
#[derive(Clone, Debug)]
pub(super) struct Island {
    /// The balls.
    pub(super) balls: Vec<usize>,
    /// Their masses \[kg\].
    pub(super) masses: Vec<f64>,
    /// Springs on them.
    pub(super) springs: Vec<Spring>,
    /// Rods on them; at most two on each.
    pub(super) rods: Vec<Rod>,
    /// Where the rods leave their balls; one for each ball with rods.
    pub(super) tracks: Vec<Track>,
    /// Gravity \[m/s²\].
    pub(super) gravity: DVec3,
    /// The present segment of each ball.
    pub(super) arcs: Vec<Arc>,
    start: f64,
    span: f64,
    /// Length of the next segment to try \[s\]; NaN where it is to be estimated.
    pace: f64,
    /// Brief segments in succession.
    brief: u32,
}

/// The motion of an island cannot be followed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lost;

/// What became of a segment.
enum Outcome {
    /// Exact to rounding, after so many iterations.
    Resolved { rounds: usize },
    /// Finite, but not resolved.
    Finite,
    /// Not finite.
    Refused,
}

/// Unit vector and length of a spring, and its tension \[N\].
fn tension(spring: &Spring, x: &[DVec3], v: &[DVec3]) -> (DVec3, f64) {
    let (far, far_velocity) = match spring.to {
        Far::Ball(ball) => (x[ball], v[ball]),
        Far::Point(point) => (point, DVec3::ZERO),
    };
    let offset = far - x[spring.ball];
    let length = offset.length();
    let along = offset.normalize_or_zero();
    let stretching = (far_velocity - v[spring.ball]).dot(along);
    (along, spring.stiffness * (length - spring.rest_length) + spring.damping * stretching)
}

impl Island {
    /// An island without a segment; [`Island::launch`] starts its motion.
    pub(super) fn new(balls: Vec<usize>, masses: Vec<f64>, gravity: DVec3) -> Self {
        let arcs = balls.iter().map(|_| Arc::uniform(0.0, 1.0, DVec3::ZERO, DVec3::ZERO)).collect();
        let (springs, rods) = (Vec::new(), Vec::new());
        let (start, span, pace, brief) = (0.0, 0.0, f64::NAN, 0);
        let tracks = Vec::new();
        Island { balls, masses, springs, rods, tracks, gravity, arcs, start, span, pace, brief }
    }

    /// When the present segment ends \[s\].
    pub(super) fn end(&self) -> f64 {
        self.start + self.span
    }

    /// Orthonormal directions in which rods hold a ball at `position`; zero where there is none.
    pub(super) fn held(&self, ball: usize, position: DVec3) -> [DVec3; 2] {
        let track = self.tracks.iter().find(|t| t.ball == ball);
        track.map_or([DVec3::ZERO; 2], |track| [track.outwards(position), track.axis])
    }

    /// Forgets the length of the last segment: an impact may have changed the rates of the motion.
    pub(super) fn forget_pace(&mut self) {
        self.pace = f64::NAN;
    }

    /// Starts a segment at `time` from the states of the balls, after projecting them onto their rods.
    ///
    /// # Errors
    /// [`Lost`] if the motion from these states is not finite, or took [`MOST_BRIEF`] brief segments in
    /// succession. The balls then stay where they are.
    pub(super) fn launch(&mut self, time: f64, x: &mut [DVec3], v: &mut [DVec3]) -> Result<(), Lost> {
        self.restore(x, v);
        if self.pace.is_nan() {
            self.pace = (0.5 / self.fastest(v)).clamp(SHORTEST, LONGEST);
        }
        loop {
            let (arcs, outcome) = self.collocate(time, self.pace, x, v);
            let shortest = self.pace <= SHORTEST;
            let accepted =
                matches!(outcome, Outcome::Resolved { .. }) || shortest && matches!(outcome, Outcome::Finite);
            if accepted && self.brief < MOST_BRIEF {
                self.hold(time, arcs);
                self.brief = if self.pace < BRIEF { self.brief + 1 } else { 0 };
                if matches!(outcome, Outcome::Resolved { rounds } if rounds < 14) {
                    self.pace = (1.5 * self.pace).min(LONGEST);
                }
                return Ok(());
            }
            if accepted || shortest {
                self.hold(time, x.iter().map(|x| Arc::uniform(time, 1.0, *x, DVec3::ZERO)).collect());
                return Err(Lost);
            }
            self.pace = (0.5 * self.pace).max(SHORTEST);
        }
    }

    /// Makes arcs from `time` on the present segment.
    fn hold(&mut self, time: f64, arcs: Vec<Arc>) {
        (self.start, self.span, self.arcs) = (time, self.pace, arcs);
    }

    /// The fastest rate of change of the force of a spring \[rad/s\].
    pub(super) fn spring_rate(&self) -> f64 {
        let mut rate = 0.0_f64;
        for spring in &self.springs {
            let mass = match spring.to {
                Far::Ball(other) => self.masses[spring.ball].min(self.masses[other]),
                Far::Point(_) => self.masses[spring.ball],
            };
            rate = rate.max(spring_pace::rate(spring.stiffness, spring.damping, mass));
        }
        rate
    }

    /// An upper estimate of the rates of change \[1/s\].
    fn fastest(&self, v: &[DVec3]) -> f64 {
        let mut rate = self.spring_rate().max(1e-3);
        for track in &self.tracks {
            let swing = (self.gravity.length() / track.radius).sqrt();
            rate = rate.max(swing + v[track.ball].length() / track.radius);
        }
        rate
    }

    /// Removes rounding errors from the lengths of the rods: projects positions and velocities.
    fn restore(&self, x: &mut [DVec3], v: &mut [DVec3]) {
        for track in &self.tracks {
            let (x, v) = (&mut x[track.ball], &mut v[track.ball]);
            let outwards = track.outwards(*x);
            let off = *x - track.centre - outwards * track.radius;
            if off.length() > f64::EPSILON * track.radius {
                *x -= off;
            }
            *v -= track.axis * track.axis.dot(*v);
            *v -= outwards * outwards.dot(*v);
        }
    }

    /// An upper estimate of the rounding error of the accelerations \[m/s²\]: of forces that rods take up,
    /// and of lengths and directions as differences of positions.
    fn rounding(&self, x: &[DVec3], v: &[DVec3]) -> f64 {
        let mut forces = vec![self.gravity.length(); x.len()];
        for spring in &self.springs {
            let mut add = |ball: usize, size: f64| {
                let force =
                    spring.stiffness * (size + spring.rest_length) + spring.damping * v[ball].length();
                forces[ball] += force / self.masses[ball];
            };
            match spring.to {
                Far::Ball(other) => {
                    let size = x[spring.ball].length() + x[other].length();
                    add(spring.ball, size);
                    add(other, size);
                }
                Far::Point(point) => add(spring.ball, x[spring.ball].length() + point.length()),
            }
        }
        for track in &self.tracks {
            let ball = track.ball;
            let centripetal = v[ball].length_squared() / track.radius;
            forces[ball] = (forces[ball] + centripetal) * (1.0 + x[ball].length() / track.radius);
        }
        ROUNDINGS * f64::EPSILON * forces.iter().copied().fold(0.0, f64::max)
    }

    /// Computes one segment from the states at its start.
    fn collocate(&self, time: f64, span: f64, x: &[DVec3], v: &[DVec3]) -> (Vec<Arc>, Outcome) {
        // Initial guess: uniform motion.
        let half = 0.5 * span;
        let mut arcs: Vec<Arc> = x.iter().zip(v).map(|(x, v)| Arc::uniform(time, half, *x, *v)).collect();
        let (mut last_change, rounding) = (f64::INFINITY, self.rounding(x, v));
        for round in 1..=MAX_ITERATIONS {
            // Accelerations at the nodes of the present iterate.
            let at_nodes: [Vec<DVec3>; NODES] = std::array::from_fn(|node| {
                let (xs, vs): (Vec<_>, Vec<_>) = arcs.iter().map(|arc| arc.at_node(node)).unzip();
                self.accelerations(&xs, &vs)
            });
            // The next iterate.
            let (mut change, mut size) = (0.0_f64, self.gravity.length());
            for (ball, arc) in arcs.iter_mut().enumerate() {
                let values = std::array::from_fn(|node| at_nodes[node][ball]);
                let Some(refined) = arc.refine(&values, x[ball], v[ball]) else {
                    return (arcs, Outcome::Refused);
                };
                (change, size) = (change.max(refined.0), size.max(refined.1));
            }
            // Rounding keeps changing the last digits: the iteration ends when it no longer contracts.
            let near = change <= rounding.max(1e-13 * size);
            if change <= 1e-15 * size || near && change >= 0.5 * last_change {
                let outcome = self.judge(&arcs, round, rounding);
                return (arcs, outcome);
            }
            if round > GROWING && change > last_change {
                break;
            }
            last_change = change;
        }
        let outcome = if arcs.iter().all(Arc::is_finite) { Outcome::Finite } else { Outcome::Refused };
        (arcs, outcome)
    }

    /// Whether arcs to which the iteration has converged are exact to rounding: their last coefficients are
    /// negligible.
    fn judge(&self, arcs: &[Arc], rounds: usize, rounding: f64) -> Outcome {
        if !arcs.iter().all(Arc::is_finite) {
            return Outcome::Refused;
        }
        let negligible = |arc: &Arc| rounding.max(TAIL * (arc.bound() + self.gravity.length()));
        let exact = arcs.iter().all(|arc| arc.tail() <= negligible(arc));
        if exact { Outcome::Resolved { rounds } } else { Outcome::Finite }
    }

    fn accelerations(&self, x: &[DVec3], v: &[DVec3]) -> Vec<DVec3> {
        let mut a = self.driven(x, v);
        for track in &self.tracks {
            let ball = track.ball;
            a[ball] = track.guided(a[ball], x[ball], v[ball]);
        }
        a
    }

    /// Accelerations due to gravity and springs.
    fn driven(&self, x: &[DVec3], v: &[DVec3]) -> Vec<DVec3> {
        let mut a = vec![self.gravity; self.balls.len()];
        for spring in &self.springs {
            let (along, force) = tension(spring, x, v);
            a[spring.ball] += along * (force / self.masses[spring.ball]);
            if let Far::Ball(other) = spring.to {
                a[other] -= along * (force / self.masses[other]);
            }
        }
        a
    }

    /// Forces of the rods on their balls \[N\]. Those of two rods on one ball add up to what keeps it on its
    /// circle.
    fn rod_forces(&self, x: &[DVec3], v: &[DVec3]) -> Vec<DVec3> {
        let (driven, whole) = (self.driven(x, v), self.accelerations(x, v));
        let along = |rod: &Rod| (x[rod.ball] - rod.anchor).normalize_or_zero();
        let force = |(index, rod): (usize, &Rod)| {
            let reaction = (whole[rod.ball] - driven[rod.ball]) * self.masses[rod.ball];
            let is_partner = |(other, r): &(usize, &Rod)| *other != index && r.ball == rod.ball;
            let Some((other, second)) = self.rods.iter().enumerate().find(is_partner) else {
                return reaction;
            };
            let first = |d: DVec3, e: DVec3| {
                let across = d - e * e.dot(d);
                d * (across.dot(reaction) / across.length_squared())
            };
            let (d, e) = (along(rod), along(second));
            if index < other { first(d, e) } else { reaction - first(e, d) }
        };
        self.rods.iter().enumerate().map(force).collect()
    }

    /// Impulses of the springs on their first balls and of the rods on their balls between two times of the
    /// segment \[N s\].
    pub(super) fn impulses(&self, from: f64, to: f64) -> (Vec<DVec3>, Vec<DVec3>) {
        let table = &*TABLE;
        let mut by_springs = vec![DVec3::ZERO; self.springs.len()];
        let mut by_rods = vec![DVec3::ZERO; self.rods.len()];
        for (cosines, weight) in table.cosines.iter().zip(table.weights) {
            let time = from + (to - from) * 0.5 * (1.0 + cosines[1]);
            let (x, v): (Vec<_>, Vec<_>) = self.arcs.iter().map(|arc| arc.at(time)).unzip();
            let share = 0.5 * weight * (to - from);
            for (sum, spring) in by_springs.iter_mut().zip(&self.springs) {
                let (along, force) = tension(spring, &x, &v);
                *sum += along * (force * share);
            }
            for (sum, force) in by_rods.iter_mut().zip(self.rod_forces(&x, &v)) {
                *sum += force * share;
            }
        }
        (by_springs, by_rods)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_oscillator_keeps_its_phase() {
        let mut island = Island::new(vec![0], vec![0.5], DVec3::ZERO);
        island.springs.push(Spring {
            ball: 0,
            to: Far::Point(DVec3::ZERO),
            far_body: BodyId::WORLD,
            rest_length: 0.0,
            stiffness: 200.0,
            damping: 0.0,
        });
        let (mut x, mut v) = ([DVec3::X], [DVec3::Y]);
        let mut time = 0.0;
        while time < 10.0 {
            island.launch(time, &mut x, &mut v).unwrap();
            time = island.end();
            (x[0], v[0]) = island.arcs[0].at(time);
        }
        let phase = 20.0 * time;
        let exact = DVec3::new(phase.cos(), phase.sin() / 20.0, 0.0);
        // Residual seen: 3e-14 after 32 periods.
        assert!((x[0] - exact).length() < 1e-12, "{:e}", (x[0] - exact).length());
    }
}
