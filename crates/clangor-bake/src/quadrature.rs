//! Rules of integration: Gauss and Legendre's on a line, Radon's on a triangle.

use std::f64::consts::PI;

/// Seven points of a triangle in barycentric coordinates, and weights, which sum to 1: exact for polynomials
/// of degree 5. Source: Radon (1948), "Zur mechanischen Kubatur".
pub(crate) const TRIANGLE_FIFTH_DEGREE: [([f64; 3], f64); 7] = {
    const A: f64 = 0.470_142_064_105_115_1;
    const B: f64 = 0.101_286_507_323_456_34;
    const WA: f64 = 0.132_394_152_788_506_2;
    const WB: f64 = 0.125_939_180_544_827_15;
    const A1: f64 = 1.0 - 2.0 * A;
    const B1: f64 = 1.0 - 2.0 * B;
    const THIRD: f64 = 1.0 / 3.0;
    [
        ([THIRD, THIRD, THIRD], 0.225),
        ([A1, A, A], WA),
        ([A, A1, A], WA),
        ([A, A, A1], WA),
        ([B1, B, B], WB),
        ([B, B1, B], WB),
        ([B, B, B1], WB),
    ]
};

/// Nodes and weights of the n-point Gauss–Legendre rule on [0, 1], ascending: exact for polynomials of degree
/// 2n − 1.
///
/// Newton's method on the Legendre polynomial from Tricomi's guess.
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let mut rule = vec![(0.0, 0.0); n];
    for i in 0..n {
        let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..100 {
            let (mut before, mut here) = (0.0, 1.0);
            for j in 0..n {
                let j = j as f64;
                (before, here) = (here, ((2.0 * j + 1.0) * x * here - j * before) / (j + 1.0));
            }
            slope = n as f64 * (x * here - before) / (x * x - 1.0);
            let step = here / slope;
            x -= step;
            if step.abs() < 1e-16 {
                break;
            }
        }
        rule[n - 1 - i] = (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope));
    }
    rule
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_integrate_their_polynomials() {
        for n in 1..=30 {
            let rule = gauss_legendre(n);
            for power in 0..2 * n {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(power as i32)).sum();
                // Residual seen: 4e-15.
                assert!((sum * (power + 1) as f64 - 1.0).abs() < 1e-12, "{n} {power} {sum}");
            }
        }
    }
}
