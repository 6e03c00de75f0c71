//! Balls on rods and springs, whose motion has no closed form, as Chebyshev series in time.
//!
//! A hung ball is a spherical pendulum: a = f + Σ λᵢ dᵢ with dᵢ the unit vectors from the anchors and dᵢ·a =
//! −v²/Lᵢ. A spring pulls with k (ℓ − ℓ₀) + c ℓ̇ along itself. Balls that springs join are integrated
//! together, as an island.
//!
//! Over a segment of h seconds the accelerations are interpolated at [`NODES`] Chebyshev points and
//! integrated twice in closed form; the accelerations at the new positions give the next iterate, until
//! convergence (Picard–Chebyshev iteration: collocation of order [`NODES`]). The series also serves as dense
//! output for the search of events, exact to rounding, and the sum of the norms of its coefficients bounds
//! the acceleration. A segment whose last coefficients are not negligible is halved.

use std::f64::consts::PI;
use std::sync::LazyLock;

use clangor_core::body::BodyId;
use glam::DVec3;

/// Collocation points of a segment.
const NODES: usize = 20;
/// Last coefficients of the acceleration that are negligible, relative to the largest acceleration.
const TAIL: f64 = 1e-13;
/// Iterations in which a segment must converge.
const MAX_ITERATIONS: usize = 40;
/// Longest and shortest segment \[s\]. The shortest is always accepted: it contains a jump of the force.
const LONGEST: f64 = 0.5;
const SHORTEST: f64 = 1e-8;

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
    /// Length \[m\].
    pub(super) length: f64,
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
    /// Gravity \[m/s²\].
    pub(super) gravity: DVec3,
    /// The present segment of each ball.
    pub(super) arcs: Vec<Arc>,
    start: f64,
    span: f64,
    pace: f64,
}

/// Position, velocity and acceleration of a ball over a segment: Chebyshev coefficients.
#[derive(Clone, Debug)]
pub(super) struct Arc {
    start: f64,
    half: f64,
    position: [DVec3; NODES + 2],
    velocity: [DVec3; NODES + 1],
    acceleration: [DVec3; NODES],
}

/// cos(k θⱼ) at the points θⱼ = π (j + ½)/n.
struct Table {
    cosines: [[f64; NODES + 2]; NODES],
    /// Weights of Fejér's first rule on [−1, 1].
    weights: [f64; NODES],
}

static TABLE: LazyLock<Table> = LazyLock::new(|| {
    let angle = |j: usize| PI * (j as f64 + 0.5) / NODES as f64;
    let mut table = Table { cosines: [[0.0; NODES + 2]; NODES], weights: [0.0; NODES] };
    for j in 0..NODES {
        for k in 0..NODES + 2 {
            table.cosines[j][k] = (k as f64 * angle(j)).cos();
        }
        let sum: f64 =
            (1..=NODES / 2).map(|k| (2.0 * k as f64 * angle(j)).cos() / (4.0 * (k * k) as f64 - 1.0)).sum();
        table.weights[j] = 2.0 / NODES as f64 * (1.0 - 2.0 * sum);
    }
    table
});

/// Σ cₖ Tₖ(x) by Clenshaw's recurrence.
fn series(coefficients: &[DVec3], x: f64) -> DVec3 {
    let (mut next, mut after) = (DVec3::ZERO, DVec3::ZERO);
    for &c in coefficients[1..].iter().rev() {
        (next, after) = (c + next * (2.0 * x) - after, next);
    }
    coefficients[0] + next * x - after
}

/// Coefficients of the integral from −1, scaled by `half`, plus a constant.
fn integrate(from: &[DVec3], half: f64, constant: DVec3, into: &mut [DVec3]) {
    let at = |k: usize| from.get(k).copied().unwrap_or(DVec3::ZERO);
    let mut start = DVec3::ZERO;
    for (k, c) in into.iter_mut().enumerate().skip(1) {
        let below = if k == 1 { at(0) * 2.0 } else { at(k - 1) };
        *c = (below - at(k + 1)) * (half / (2.0 * k as f64));
        start += if k % 2 == 0 { *c } else { -*c };
    }
    into[0] = constant - start;
}

impl Arc {
    fn constant(position: DVec3) -> Self {
        let mut arc = Arc {
            start: 0.0,
            half: 1.0,
            position: [DVec3::ZERO; NODES + 2],
            velocity: [DVec3::ZERO; NODES + 1],
            acceleration: [DVec3::ZERO; NODES],
        };
        arc.position[0] = position;
        arc
    }

    fn phase(&self, time: f64) -> f64 {
        (time - self.start) / self.half - 1.0
    }

    /// Centre and velocity at a time of the segment.
    pub(super) fn at(&self, time: f64) -> (DVec3, DVec3) {
        let x = self.phase(time);
        (series(&self.position, x), series(&self.velocity, x))
    }

    /// Acceleration at a time of the segment \[m/s²\].
    pub(super) fn acceleration(&self, time: f64) -> DVec3 {
        series(&self.acceleration, self.phase(time))
    }

    /// No acceleration of the segment exceeds this \[m/s²\].
    pub(super) fn bound(&self) -> f64 {
        self.acceleration.iter().map(|c| c.length()).sum()
    }

    /// The same for the relative acceleration of two arcs.
    pub(super) fn relative_bound(&self, other: &Arc) -> f64 {
        if (self.start, self.half) != (other.start, other.half) {
            return self.bound() + other.bound();
        }
        self.acceleration.iter().zip(&other.acceleration).map(|(a, b)| (*a - *b).length()).sum()
    }
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
        let arcs = balls.iter().map(|_| Arc::constant(DVec3::ZERO)).collect();
        let (springs, rods) = (Vec::new(), Vec::new());
        Island { balls, masses, springs, rods, gravity, arcs, start: 0.0, span: 0.0, pace: f64::NAN }
    }

    /// When the present segment ends \[s\].
    pub(super) fn end(&self) -> f64 {
        self.start + self.span
    }

    /// An orthonormal basis of the directions in which rods hold a ball at `position`; zero where there is
    /// none.
    pub(super) fn held(&self, ball: usize, position: DVec3) -> [DVec3; 2] {
        let mut basis = [DVec3::ZERO; 2];
        let mut count = 0;
        for rod in self.rods.iter().filter(|r| r.ball == ball) {
            let d = (position - rod.anchor).normalize_or_zero();
            let rest = d - basis[0] * basis[0].dot(d);
            if count < 2 && rest.length() > 1e-6 {
                basis[count] = rest.normalize();
                count += 1;
            }
        }
        basis
    }

    /// Starts a segment at `time` from the states of the balls, after projecting them onto their rods.
    pub(super) fn launch(&mut self, time: f64, x: &mut [DVec3], v: &mut [DVec3]) {
        self.restore(x, v);
        if self.pace.is_nan() {
            self.pace = (0.5 / self.fastest(v)).min(LONGEST);
        }
        loop {
            let (converged, rounds) = self.collocate(time, self.pace, x, v);
            if converged || self.pace <= SHORTEST {
                (self.start, self.span) = (time, self.pace);
                if rounds < 14 {
                    self.pace = (1.5 * self.pace).min(LONGEST);
                }
                return;
            }
            self.pace *= 0.5;
        }
    }

    /// An upper estimate of the rates of change \[1/s\].
    fn fastest(&self, v: &[DVec3]) -> f64 {
        let mut rate = 1e-3_f64;
        for rod in &self.rods {
            let swing = (self.gravity.length() / rod.length).sqrt();
            rate = rate.max(swing + v[rod.ball].length() / rod.length);
        }
        for spring in &self.springs {
            let mass = match spring.to {
                Far::Ball(other) => self.masses[spring.ball].min(self.masses[other]),
                Far::Point(_) => self.masses[spring.ball],
            };
            rate = rate.max((2.0 * spring.stiffness / mass).sqrt() + 2.0 * spring.damping / mass);
        }
        rate
    }

    /// Removes rounding errors from the lengths of the rods: projects positions and velocities.
    fn restore(&self, x: &mut [DVec3], v: &mut [DVec3]) {
        // Twice, for balls on two rods.
        for rod in self.rods.iter().chain(&self.rods) {
            let offset = x[rod.ball] - rod.anchor;
            let error = offset.length() - rod.length;
            if error.abs() > f64::EPSILON * rod.length {
                x[rod.ball] -= offset.normalize_or_zero() * error;
            }
        }
        for ball in 0..self.balls.len() {
            for d in self.held(ball, x[ball]) {
                v[ball] -= d * d.dot(v[ball]);
            }
        }
    }

    /// Computes one segment. Returns whether it is exact to rounding, and the number of iterations.
    fn collocate(&mut self, time: f64, span: f64, x: &[DVec3], v: &[DVec3]) -> (bool, usize) {
        let table = &*TABLE;
        let (count, half) = (self.balls.len(), 0.5 * span);
        // Initial guess: uniform motion.
        let mut arcs: Vec<Arc> = (0..count)
            .map(|ball| {
                let mut arc = Arc::constant(x[ball] + v[ball] * half);
                (arc.start, arc.half) = (time, half);
                arc.position[1] = v[ball] * half;
                arc.velocity[0] = v[ball];
                arc
            })
            .collect();
        let (mut xs, mut vs) = (vec![DVec3::ZERO; count], vec![DVec3::ZERO; count]);
        let mut accelerations = vec![[DVec3::ZERO; NODES]; count];
        let (mut last_change, mut rounds) = (f64::INFINITY, 0);
        let mut converged = false;
        while rounds < MAX_ITERATIONS && !converged {
            rounds += 1;
            // Accelerations at the nodes of the present iterate.
            for (j, cosines) in table.cosines.iter().enumerate() {
                for (ball, arc) in arcs.iter().enumerate() {
                    xs[ball] = arc.position.iter().zip(cosines).map(|(c, t)| *c * *t).sum();
                    vs[ball] = arc.velocity.iter().zip(cosines).map(|(c, t)| *c * *t).sum();
                }
                for (ball, a) in self.accelerations(&xs, &vs).into_iter().enumerate() {
                    accelerations[ball][j] = a;
                }
            }
            // Chebyshev coefficients of the accelerations, integrated twice.
            let (mut change, mut size) = (0.0_f64, self.gravity.length());
            for (ball, arc) in arcs.iter_mut().enumerate() {
                for k in 0..NODES {
                    let sum: DVec3 =
                        accelerations[ball].iter().zip(&table.cosines).map(|(a, t)| *a * t[k]).sum();
                    let next = sum * (if k == 0 { 1.0 } else { 2.0 } / NODES as f64);
                    change = change.max((next - arc.acceleration[k]).length());
                    size = size.max(next.length());
                    arc.acceleration[k] = next;
                }
                let Arc { position, velocity, acceleration, .. } = arc;
                integrate(acceleration, half, v[ball], velocity);
                integrate(velocity, half, x[ball], position);
            }
            // Rounding keeps changing the last digits: the iteration ends when it no longer contracts.
            converged = change <= 1e-15 * size || change <= 1e-13 * size && change >= 0.5 * last_change;
            last_change = change;
        }
        // The segment is resolved if its last coefficients are negligible.
        let exact = arcs.iter().all(|arc| {
            let size = arc.bound() + self.gravity.length();
            arc.acceleration[NODES - 2..].iter().all(|c| c.length() <= TAIL * size)
        });
        self.arcs = arcs;
        (converged && exact, rounds)
    }

    fn accelerations(&self, x: &[DVec3], v: &[DVec3]) -> Vec<DVec3> {
        let mut a = self.driven(x, v);
        for (rod, tension) in self.rods.iter().zip(self.rod_forces(x, v, &a)) {
            a[rod.ball] += tension / self.masses[rod.ball];
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

    /// Forces of the rods on their balls \[N\], given the accelerations `driven` due to everything else.
    fn rod_forces(&self, x: &[DVec3], v: &[DVec3], driven: &[DVec3]) -> Vec<DVec3> {
        let pull = |rod: &Rod| {
            let d = (x[rod.ball] - rod.anchor).normalize_or_zero();
            // d·(f + λ d) = −v²/L, with the length itself so that rounding does not accumulate.
            let speed_squared = v[rod.ball].length_squared();
            (d, -speed_squared / rod.length - d.dot(driven[rod.ball]))
        };
        let force = |(index, rod): (usize, &Rod)| {
            let (d, wanted) = pull(rod);
            let partner =
                self.rods.iter().enumerate().find(|(other, r)| *other != index && r.ball == rod.ball);
            let multiplier = match partner {
                None => wanted,
                Some((other, second)) => {
                    let (e, also_wanted) = pull(second);
                    let c = d.dot(e);
                    let determinant = 1.0 - c * c;
                    if determinant > 1e-12 {
                        (wanted - c * also_wanted) / determinant
                    } else if index < other {
                        wanted
                    } else {
                        0.0
                    }
                }
            };
            d * (multiplier * self.masses[rod.ball])
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
            for (sum, force) in by_rods.iter_mut().zip(self.rod_forces(&x, &v, &self.driven(&x, &v))) {
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
    fn a_series_integrates_and_evaluates() {
        // a = T₂(x) = 2x² − 1 over [0, 2]: v = 2x³/3 − x + c, with v(−1) = 5.
        let a = [DVec3::ZERO, DVec3::ZERO, DVec3::X];
        let mut v = [DVec3::ZERO; 4];
        integrate(&a, 1.0, DVec3::X * 5.0, &mut v);
        for x in [-1.0, -0.3, 0.8] {
            let exact = 2.0 * x * x * x / 3.0 - x + 5.0 - (1.0 - 2.0 / 3.0);
            assert!((series(&v, x).x - exact).abs() < 1e-14);
        }
    }

    #[test]
    fn the_weights_integrate_polynomials_of_degree_n_minus_1() {
        let table = &*TABLE;
        for power in [0, 2, 10, 18] {
            let sum: f64 = table.cosines.iter().zip(table.weights).map(|(t, w)| w * t[1].powi(power)).sum();
            assert!((sum - 2.0 / f64::from(power + 1)).abs() < 1e-14);
        }
    }

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
            island.launch(time, &mut x, &mut v);
            time = island.end();
            (x[0], v[0]) = island.arcs[0].at(time);
        }
        let phase = 20.0 * time;
        let exact = DVec3::new(phase.cos(), phase.sin() / 20.0, 0.0);
        // Residual seen: 3e-14 after 32 periods.
        assert!((x[0] - exact).length() < 1e-12, "{:e}", (x[0] - exact).length());
    }
}
