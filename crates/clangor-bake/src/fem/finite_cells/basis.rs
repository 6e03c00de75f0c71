//! Polynomials of one axis of a cell: Lagrange on Gauss–Lobatto points for displacements, Legendre for
//! moments, and the Gauss points that carry the integrals.
//!
//! Coordinates run from 0 to 1 along the edge of a cell.

use glam::DVec3;

use crate::quadrature::gauss_legendre;

/// The polynomials of one axis.
#[derive(Clone, Debug)]
pub(super) struct Basis {
    /// Gauss–Lobatto points in [0, 1].
    lobatto: Vec<f64>,
    /// Gauss points and weights in [0, 1], enough for all products of two displacements.
    points: Vec<(f64, f64)>,
    /// Value and slope of each displacement at each Gauss point, by point (p + 1) + displacement.
    table: Vec<(f64, f64)>,
}

impl Basis {
    pub(super) fn new(degree: usize) -> Self {
        Self::of_nodes(gauss_lobatto(degree))
    }

    /// The polynomials through some nodes in [0, 1].
    pub(super) fn of_nodes(lobatto: Vec<f64>) -> Self {
        let degree = lobatto.len() - 1;
        let points = gauss_legendre(2 * degree + 1);
        let mut basis = Basis { lobatto, points, table: Vec::new() };
        basis.table = basis
            .points
            .iter()
            .flat_map(|(x, _)| (0..=degree).map(|i| basis.lagrange(i, *x)).collect::<Vec<_>>())
            .collect();
        basis
    }

    /// p.
    pub(super) fn degree(&self) -> usize {
        self.lobatto.len() - 1
    }

    /// Gauss–Lobatto points in [0, 1], ascending.
    pub(super) fn lobatto(&self) -> &[f64] {
        &self.lobatto
    }

    /// Gauss points and weights in [0, 1].
    pub(super) fn points(&self) -> &[(f64, f64)] {
        &self.points
    }

    /// Value and slope of displacement i at Gauss point q.
    pub(super) fn at(&self, q: usize, i: usize) -> (f64, f64) {
        self.table[q * self.lobatto.len() + i]
    }

    /// Values of all displacements at x.
    pub(super) fn values(&self, x: f64) -> Vec<f64> {
        (0..self.lobatto.len()).map(|i| self.lagrange(i, x).0).collect()
    }

    /// The place of a node of a cell, in units of cells.
    pub(super) fn node(&self, k: usize) -> DVec3 {
        let local = self.lobatto.len();
        DVec3::from_array([k / (local * local), k / local % local, k % local].map(|n| self.lobatto[n]))
    }

    /// The nodes of a cell on its lower face across an axis, or on its upper one.
    pub(super) fn on_face(&self, axis: usize, upper: bool) -> impl Iterator<Item = usize> + use<> {
        let local = self.lobatto.len();
        let step = [local * local, local, 1][axis];
        let place = if upper { local - 1 } else { 0 };
        (0..local.pow(3)).filter(move |k| k / step % local == place)
    }

    /// Values of the displacements of all nodes of a cell at a point of it.
    pub(super) fn at_point(&self, at: DVec3) -> Vec<f64> {
        let [x, y, z] = at.to_array().map(|x| self.values(x));
        let plane = |x: f64| y.iter().flat_map(|y| z.iter().map(move |z| x * y * z)).collect::<Vec<_>>();
        x.iter().flat_map(|x| plane(*x)).collect()
    }

    fn lagrange(&self, i: usize, x: f64) -> (f64, f64) {
        let (mut value, mut slope) = (1.0, 0.0);
        for (k, other) in self.lobatto.iter().enumerate() {
            if k != i {
                let scale = 1.0 / (self.lobatto[i] - other);
                slope = (slope * (x - other) + value) * scale;
                value *= (x - other) * scale;
            }
        }
        (value, slope)
    }

    /// Weight of Gauss point a for Legendre moment k: l_a = Σ_k T_ak P_k(2x − 1), by a n + k.
    pub(super) fn legendre_to_points(&self) -> Vec<f64> {
        let n = self.points.len();
        let mut table = vec![0.0; n * n];
        for (a, (x, weight)) in self.points.iter().enumerate() {
            for (k, value) in legendre(2.0 * x - 1.0, n).into_iter().enumerate() {
                table[a * n + k] = (2 * k + 1) as f64 * weight * value;
            }
        }
        table
    }
}

/// P_0 … P_{count−1} at y in [−1, 1].
fn legendre(y: f64, count: usize) -> Vec<f64> {
    let mut all = vec![1.0, y];
    for k in 1..count.max(2) - 1 {
        let k_ = k as f64;
        all.push(((2.0 * k_ + 1.0) * y * all[k] - k_ * all[k - 1]) / (k_ + 1.0));
    }
    all.truncate(count);
    all
}

/// The ends and the zeros of P_p', in [0, 1].
pub(super) fn gauss_lobatto(degree: usize) -> Vec<f64> {
    let mut points: Vec<f64> =
        (0..=degree).map(|k| -(std::f64::consts::PI * k as f64 / degree as f64).cos()).collect();
    for y in &mut points[1..degree] {
        // Newton's method on P_p', by the equation of Legendre for its slope.
        for _ in 0..60 {
            let values = legendre(*y, degree + 1);
            let p = degree as f64;
            let slope = p * (*y * values[degree] - values[degree - 1]) / (*y * *y - 1.0);
            let second = (2.0 * *y * slope - p * (p + 1.0) * values[degree]) / (1.0 - *y * *y);
            *y -= slope / second;
        }
    }
    points.iter().map(|y| 0.5 * (1.0 + y)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lobatto_points_are_those_of_the_tables() {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-15;
        let third = gauss_lobatto(3);
        assert!(near(third[1], 0.5 - 0.5 / 5.0_f64.sqrt()), "{third:?}");
        let fourth = gauss_lobatto(4);
        assert!(near(fourth[1], 0.5 - 0.5 * (3.0_f64 / 7.0).sqrt()) && near(fourth[2], 0.5), "{fourth:?}");
    }
}
