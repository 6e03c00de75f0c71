//! Radial dependence of outgoing and regular spherical waves, without under- or overflow at any frequency.
//!
//! With s = iκ, κ = kR and x = r/R the outgoing wave hₙ⁽²⁾(kr), made 1 on the sphere of radius R but for its
//! phase, is
//!
//! ```text
//! hₙ⁽²⁾(kr)/hₙ⁽²⁾(kR) = e^{−s(x−1)} x^{−(n+1)} θₙ(sx)/θₙ(s)
//! θ₀ = 1,  θ₁ = s + 1,  θₙ = (2n−1) θₙ₋₁ + s² θₙ₋₂
//! ```
//!
//! θₙ is the reverse Bessel polynomial: the finite sum that makes spherical Hankel functions elementary. It
//! has no zero with Re s ≥ 0, is (2n−1)!! at s = 0, and the recurrence is stable upwards.
//!
//! The regular wave is jₙ(z) = zⁿ φₙ(z²)/(2n+1)!!, with φₙ even and 1 at 0.

use num_complex::Complex64;

/// θ₀ … θ_order at `s`.
pub fn reverse_bessel(s: Complex64, order: usize, values: &mut Vec<Complex64>) {
    values.clear();
    values.push(Complex64::ONE);
    values.push(s + 1.0);
    let square = s * s;
    for n in 2..=order {
        let next = (2 * n - 1) as f64 * values[n - 1] + square * values[n - 2];
        values.push(next);
    }
    values.truncate(order + 1);
}

/// x^{−(n+1)} θₙ(sx)/θₙ(s) for n = 0 … order: how an outgoing wave of unit size at R, without e^{−s(x−1)}, is
/// at x R.
///
/// By the ratios tₙ = θₙ/θₙ₋₁ = 2n − 1 + s²/tₙ₋₁, which stay of the size of n + |s| where θₙ itself would
/// overflow.
pub fn outgoing(s: Complex64, x: f64, order: usize, values: &mut Vec<Complex64>) {
    values.clear();
    values.push(Complex64::new(1.0 / x, 0.0));
    let (mut there, mut here) = (s * x + 1.0, s + 1.0);
    let (square_there, square_here) = (s * s * (x * x), s * s);
    for n in 1..=order {
        if n > 1 {
            let odd = (2 * n - 1) as f64;
            there = odd + square_there / there;
            here = odd + square_here / here;
        }
        values.push(values[n - 1] * there / (here * x));
    }
}

/// (2n−1)!! = 1, 1, 3, 15, 105, … as a real number.
pub fn double_factorial(n: usize) -> f64 {
    (1..=n).map(|k| (2 * k - 1) as f64).product()
}

/// jₙ(z)/zⁿ for n = 0 … order, with z² = `square`, which may be negative or complex.
///
/// Downwards by Miller's method from an order far above, scaled with the series of order 0: sin z / z.
pub fn regular(square: Complex64, order: usize, values: &mut Vec<Complex64>) {
    values.clear();
    let size = square.norm();
    if size < 1e-3 {
        // Three terms of the series: z⁶ is below 1e-9, and its factor below 1e-4.
        for n in 0..=order {
            let n = n as f64;
            let t = -0.5 * square;
            let series = 1.0 + t / (2.0 * n + 3.0) + t * t / (2.0 * (2.0 * n + 3.0) * (2.0 * n + 5.0));
            values.push(series / double_factorial(n as usize + 1));
        }
        return;
    }
    // u_n = j_n/zⁿ obeys u_{n−1} = (2n+1) u_n − z² u_{n+1}.
    let top = order + 20 + (1.5 * size.sqrt()) as usize;
    let (mut above, mut here) = (Complex64::ZERO, Complex64::ONE);
    values.resize(order + 1, Complex64::ZERO);
    for n in (0..=top).rev() {
        if n <= order {
            values[n] = here;
        }
        if n == 0 {
            break;
        }
        let below = (2 * n + 1) as f64 * here - square * above;
        (above, here) = (here, below);
        if here.norm_sqr() > 1e200 {
            let scale = 1.0 / here.norm();
            above *= scale;
            here *= scale;
            values.iter_mut().for_each(|v| *v *= scale);
        }
    }
    // Scale by whichever of order 0 and 1 is not near a zero.
    let z = square.sqrt();
    let j0 = z.sin() / z;
    let j1 = (z.sin() / z - z.cos()) / square;
    let scale = if order == 0 || (j0.norm() > (z * j1).norm()) { j0 / values[0] } else { j1 / values[1] };
    values.iter_mut().for_each(|v| *v *= scale);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reverse_bessel_gives_the_spherical_hankel_functions() {
        // h₂⁽²⁾(z) = (i/z)(1 − 3i/z − 3/z²)... e^{−iz}, up to the factor i³: compared as a ratio of two
        // distances.
        let hankel_2 = |z: f64| {
            let z = Complex64::new(z, 0.0);
            (-Complex64::I * z).exp() / z * (Complex64::ONE + 3.0 / (Complex64::I * z) - 3.0 / (z * z))
        };
        let (k, r) = (2.3, 1.7);
        let (mut near, mut far) = (vec![], vec![]);
        reverse_bessel(Complex64::new(0.0, k), 2, &mut near);
        reverse_bessel(Complex64::new(0.0, k * r), 2, &mut far);
        let ratio = Complex64::new(0.0, -k * (r - 1.0)).exp() * r.powi(-3) * far[2] / near[2];
        // Residual seen: 1e-16.
        assert!((ratio - hankel_2(k * r) / hankel_2(k)).norm() < 1e-13);
        let mut waves = vec![];
        outgoing(Complex64::new(0.0, k), r, 60, &mut waves);
        let undelayed = ratio * Complex64::new(0.0, k * (r - 1.0)).exp();
        // Residual seen: 1e-16.
        assert!((waves[2] - undelayed).norm() < 1e-14);
        outgoing(Complex64::new(0.0, 60.0), 1e5, 80, &mut waves);
        assert!(waves.iter().all(|w| w.is_finite() && w.norm() > 0.0));
    }

    #[test]
    fn regular_waves_satisfy_their_recurrence_and_start() {
        for z in [0.01, 0.5, 3.2, std::f64::consts::PI, 12.0, 40.0_f64] {
            let mut u = vec![];
            regular(Complex64::new(z * z, 0.0), 16, &mut u);
            let j = |n: usize| u[n].re * z.powi(n as i32);
            assert!((j(0) - z.sin() / z).abs() < 1e-13, "{z}");
            // Residual seen: 4e-15.
            assert!((j(1) - (z.sin() / (z * z) - z.cos() / z)).abs() < 1e-12, "{z} {}", j(1));
            let j2 = (3.0 / (z * z) - 1.0) * z.sin() / z - 3.0 * z.cos() / (z * z);
            if z > 0.1 {
                assert!((j(2) - j2).abs() < 1e-12, "{z}");
            }
        }
    }
}
