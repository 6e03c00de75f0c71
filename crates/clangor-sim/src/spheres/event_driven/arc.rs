//! The motion of a ball over a time segment as Chebyshev series in time.
//!
//! The acceleration at [`NODES`] Chebyshev points gives the coefficients of its interpolating polynomial; two
//! integrations in closed form give velocity and position. The series is dense output for the search of
//! events, exact to rounding, and the sum of the norms of its coefficients bounds the acceleration. It does
//! not know the forces (`island`).

use std::f64::consts::PI;
use std::sync::LazyLock;

use glam::DVec3;

/// Collocation points of a segment.
pub(super) const NODES: usize = 20;

/// Position, velocity and acceleration of a ball over a segment: Chebyshev coefficients.
#[derive(Clone, Debug)]
pub(super) struct Arc {
    start: f64,
    half: f64,
    position: [DVec3; NODES + 2],
    velocity: [DVec3; NODES + 1],
    acceleration: [DVec3; NODES],
}

/// Chebyshev polynomials and quadrature at the points θⱼ = π (j + ½)/n.
pub(super) struct Table {
    /// cos(k θⱼ).
    pub(super) cosines: [[f64; NODES + 2]; NODES],
    /// Weights of Fejér's first rule on [−1, 1].
    pub(super) weights: [f64; NODES],
}

/// The table of [`NODES`] points.
pub(super) static TABLE: LazyLock<Table> = LazyLock::new(|| {
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
    /// Uniform motion over `2·half` seconds from a position and velocity at the time `start`.
    pub(super) fn uniform(start: f64, half: f64, position: DVec3, velocity: DVec3) -> Self {
        let mut arc = Arc {
            start,
            half,
            position: [DVec3::ZERO; NODES + 2],
            velocity: [DVec3::ZERO; NODES + 1],
            acceleration: [DVec3::ZERO; NODES],
        };
        arc.position[..2].copy_from_slice(&[position + velocity * half, velocity * half]);
        arc.velocity[0] = velocity;
        arc
    }

    /// Position and velocity at a point of the table.
    pub(super) fn at_node(&self, node: usize) -> (DVec3, DVec3) {
        let cosines = &TABLE.cosines[node];
        let sum = |c: &[DVec3]| c.iter().zip(cosines).map(|(c, t)| *c * *t).sum::<DVec3>();
        (sum(&self.position), sum(&self.velocity))
    }

    /// Replaces the acceleration by the polynomial through its values at the points of the table, and
    /// integrates it from a position and velocity at the start. Returns the largest change of a coefficient
    /// of the acceleration and the largest coefficient \[m/s²\]; `None` if a coefficient is not finite.
    pub(super) fn refine(
        &mut self,
        values: &[DVec3; NODES],
        position: DVec3,
        velocity: DVec3,
    ) -> Option<(f64, f64)> {
        let (mut change, mut size) = (0.0_f64, 0.0_f64);
        for (k, held) in self.acceleration.iter_mut().enumerate() {
            let sum: DVec3 = values.iter().zip(&TABLE.cosines).map(|(a, t)| *a * t[k]).sum();
            let next = sum * (if k == 0 { 1.0 } else { 2.0 } / NODES as f64);
            // A maximum passes over NaN.
            if !next.is_finite() {
                return None;
            }
            change = change.max((next - *held).length());
            size = size.max(next.length());
            *held = next;
        }
        integrate(&self.acceleration, self.half, velocity, &mut self.velocity);
        integrate(&self.velocity, self.half, position, &mut self.position);
        (change.is_finite() && size.is_finite()).then_some((change, size))
    }

    /// The largest of the last two coefficients of the acceleration \[m/s²\]; one of them may vanish by
    /// symmetry.
    pub(super) fn tail(&self) -> f64 {
        self.acceleration[NODES - 2..].iter().map(|c| c.length()).fold(0.0, f64::max)
    }

    /// Whether position and velocity are finite in the whole segment.
    pub(super) fn is_finite(&self) -> bool {
        self.position.iter().chain(&self.velocity).all(|c| c.is_finite())
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
}
