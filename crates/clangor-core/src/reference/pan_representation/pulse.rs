//! The pulse ψ from which the published representation builds accelerations, and its spectrum.
//!
//! A cubic filter of the family of Mitchell and Netravali, with B = 2/3 and C = 1/6 (\[PAN\] eq. (17),
//! \[PROXY\] eq. (6)):
//!
//! ```text
//!              ⎧ −15y³ + 18y² + 9y + 2       |t| ≤ h
//! ψ(t; h) = 1/18 ⎨ 5(1 + y)³ − 3(1 + y)²     h ≤ |t| ≤ 2h      y = 1 − |t|/h
//!              ⎩ 0                           otherwise
//! ```
//!
//! Differs: both papers print y = 1 − |t|; only with |t|/h is ψ continuous for h ≠ 1.
//!
//! Shifted by multiples of h the pulses sum to 1, but ψ(0) = 14/18 and ψ(±h) = 2/18: the sum of pulses does
//! not go through the samples, it smooths them.
//!
//! ψ is a piecewise cubic, so its spectrum is the sum over its knots of the jumps of its second and third
//! derivative, which comes to
//!
//! ```text
//! ∫ ψ(t; h) e^{−iωt} dt = h sinc³u (5 sinc u − 2 cos u)/3,    u = ωh/2,  sinc u = sin u / u
//! ```
//!
//! It has a threefold zero at every multiple of 1/h but 0, and is below 1.2 % of its peak above 0.8/h.

/// ψ(t; h).
pub fn pulse(time: f64, h: f64) -> f64 {
    let x = (time / h).abs();
    let y = 1.0 - x;
    if x <= 1.0 {
        (((-15.0 * y + 18.0) * y + 9.0) * y + 2.0) / 18.0
    } else if x <= 2.0 {
        (1.0 + y).powi(2) * (5.0 * (1.0 + y) - 3.0) / 18.0
    } else {
        0.0
    }
}

/// ∫ ψ(t; h) e^{−iωt} dt, which is real.
pub fn pulse_spectrum(omega: f64, h: f64) -> f64 {
    let u = 0.5 * omega * h;
    let sinc = if u.abs() < 1e-4 { 1.0 - u * u / 6.0 } else { u.sin() / u };
    h * sinc.powi(3) * (5.0 * sinc - 2.0 * u.cos()) / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pulses_are_smooth_and_sum_to_one() {
        let h = 0.37;
        for i in 0..50 {
            let t = -h + 0.02 * h * f64::from(i);
            let sum: f64 = (-4..=4).map(|k| pulse(t - f64::from(k) * h, h)).sum();
            // Residual seen: 4e-16.
            assert!((sum - 1.0).abs() < 1e-14, "{t} {sum}");
        }
        for knot in [h, 2.0 * h] {
            let e = 1e-6 * h;
            assert!((pulse(knot + e, h) - pulse(knot - e, h)).abs() < 2e-6);
            let slope = |t: f64| (pulse(t + e, h) - pulse(t - e, h)) / (2.0 * e) * h;
            // Residual seen: 8e-6: continuous first derivative, to the step of the difference.
            assert!((slope(knot + 2.0 * e) - slope(knot - 2.0 * e)).abs() < 3e-5, "{knot}");
        }
        assert!((pulse(0.0, h) * 18.0 - 14.0).abs() < 1e-13 && (pulse(h, h) * 18.0 - 2.0).abs() < 1e-13);
    }

    #[test]
    fn spectrum_is_the_integral_of_the_pulse() {
        let h = 0.8;
        for omega in [0.0, 1e-5, 0.3, 2.0, 7.0, std::f64::consts::TAU / h, 19.0] {
            let n = 40_000;
            let step = 4.0 * h / f64::from(n);
            let sum: f64 = (0..n)
                .map(|i| {
                    let t = -2.0 * h + (f64::from(i) + 0.5) * step;
                    step * pulse(t, h) * (omega * t).cos()
                })
                .sum();
            // Residual seen: 2e-10, of the midpoint rule.
            assert!((sum - pulse_spectrum(omega, h)).abs() < 2e-9, "{omega}: {sum}");
        }
    }
}
