//! Interpolation from Gauss–Legendre nodes on [0, 1].

use crate::quadrature::gauss_legendre;

/// Nodes, weights and the barycentric weights of the polynomial through them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Nodes {
    /// Nodes, ascending.
    pub(super) at: Vec<f64>,
    /// Weights of the quadrature.
    pub(super) weight: Vec<f64>,
    barycentric: Vec<f64>,
}

impl Nodes {
    /// The n-point rule.
    pub(super) fn new(n: usize) -> Self {
        let (at, weight): (Vec<f64>, Vec<f64>) = gauss_legendre(n).into_iter().unzip();
        // (−1)^j √((1−x²)w) is the barycentric weight at Legendre nodes, up to a common factor.
        let barycentric = (0..n)
            .map(|j| (at[j] * (1.0 - at[j]) * weight[j]).sqrt() * if j % 2 == 0 { 1.0 } else { -1.0 })
            .collect();
        Nodes { at, weight, barycentric }
    }

    /// Values at t of the Lagrange polynomials.
    #[inline(always)]
    pub(super) fn basis(&self, t: f64, values: &mut [f64]) {
        let mut sum = 0.0;
        for ((value, x), w) in values.iter_mut().zip(&self.at).zip(&self.barycentric) {
            let gap = t - x;
            // At a node the quotient is 1 to rounding whatever this tiny number is.
            *value = w / if gap.abs() < 1e-14 { 1e-14 } else { gap };
            sum += *value;
        }
        let scale = 1.0 / sum;
        values.iter_mut().for_each(|value| *value *= scale);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_come_back() {
        let nodes = Nodes::new(7);
        let f = |t: f64| 1.0 - 3.0 * t + 2.0 * t.powi(6);
        let mut basis = [0.0; 7];
        for t in [0.0, 0.3, nodes.at[2], 1.0, 1.1] {
            nodes.basis(t, &mut basis);
            let value: f64 = basis.iter().zip(&nodes.at).map(|(b, x)| b * f(*x)).sum();
            // Residual seen: 2e-15.
            assert!((value - f(t)).abs() < 1e-12, "{t} {value}");
        }
    }
}
