//! Restitution of a body that hits an endless plate, with the loss of the contact itself.
//!
//! ```text
//! s̈ = −F − λ Ḟ     F = max(0, s^{3/2} + x √s ṡ)
//! ```
//!
//! in the units of Hertz's contact: s is the indentation, λ Zener's parameter of the plate, x the damping of
//! the contact ([`viscoelastic_rate`](super::pair_restitution::viscoelastic_rate)). With u = ṡ + λF, the
//! velocity of the body, this is u̇ = −F, and the restitution is −u when the force ends. Without x it is
//! \[Zener1941\]; without λ, \[KuwabaraKono1987\]. Integrated by the classical Runge–Kutta method, to
//! 2e-6 of a thousand times as many steps.
//!
//! For solvers that have the restitution of a pair only. The solve of a contact has the same plate as a
//! mobility in series.

/// Step in units of T₀: a contact without loss lasts 3.2.
const STEP: f64 = 0.02;
/// Steps after which a body counts as stopped.
const MOST_STEPS: usize = 20_000;

/// Force on a body of velocity u at an indentation s.
fn force(s: f64, u: f64, lambda: f64, rate: f64) -> f64 {
    let root = s.max(0.0).sqrt();
    ((root * s.max(0.0) + rate * root * u) / (1.0 + rate * lambda * root)).max(0.0)
}

/// e for Zener's λ and the damping x of the contact.
pub fn plate_restitution(lambda: f64, rate: f64) -> f64 {
    let slope = |[s, u]: [f64; 2]| {
        let f = force(s, u, lambda, rate);
        [u - lambda * f, -f]
    };
    // The indentation follows the velocity at a rate of 3/2 λ^{2/3}.
    let h = STEP.min(0.5 * lambda.powf(-2.0 / 3.0));
    // The series s = t at first, where √s has no Taylor series: F = t^{3/2} + x√t, u = 1 − ∫F.
    let t = 0.5 * h;
    let u = 1.0 - 0.4 * t.powf(2.5) - rate * t.powf(1.5) / 1.5;
    let mut state = [t - lambda * (0.4 * t.powf(2.5) + rate * t.powf(1.5) / 1.5), u];
    for _ in 0..MOST_STEPS {
        let add = |k: [f64; 2], part: f64| [state[0] + part * k[0], state[1] + part * k[1]];
        let k1 = slope(state);
        let k2 = slope(add(k1, 0.5 * h));
        let k3 = slope(add(k2, 0.5 * h));
        let k4 = slope(add(k3, h));
        let next: [f64; 2] =
            std::array::from_fn(|i| state[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
        if next[1] <= 0.0 && force(next[0], next[1], lambda, rate) == 0.0 {
            return (-next[1]).clamp(0.0, 1.0);
        }
        state = next;
    }
    (-state[1]).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::super::pair_restitution::{viscoelastic_rate, viscoelastic_restitution};
    use super::*;

    /// The same by many small steps.
    fn fine(lambda: f64, rate: f64) -> f64 {
        let h = 2e-5;
        let (mut s, mut u) = (0.0_f64, 1.0_f64);
        for _ in 0..20_000_000 {
            let f = force(s, u, lambda, rate);
            let middle = (s + 0.5 * h * (u - lambda * f), u - 0.5 * h * f);
            let f = force(middle.0, middle.1, lambda, rate);
            (s, u) = (s + h * (middle.1 - lambda * f), u - h * f);
            if u <= 0.0 && force(s, u, lambda, rate) == 0.0 {
                return -u;
            }
        }
        -u
    }

    #[test]
    fn the_restitution_is_that_of_small_steps() {
        for (lambda, rate) in [(0.0, 0.3), (0.02, 0.0), (0.1, 0.0), (0.5, 0.1), (1.0, 0.0), (3.0, 0.4)] {
            let error = plate_restitution(lambda, rate) - fine(lambda, rate);
            // Residual seen: 2e-6.
            assert!(error.abs() < 1e-4, "λ {lambda} x {rate}: {error:e}");
        }
    }

    #[test]
    fn a_plate_that_hardly_resists_stops_the_body() {
        let mut last = plate_restitution(1.0, 0.0);
        for lambda in [3.0, 10.0, 100.0, 1e4, 1e8] {
            let e = plate_restitution(lambda, 0.0);
            assert!((0.0..=last).contains(&e), "λ {lambda}: {e}");
            last = e;
        }
        assert!(last < 1e-9, "{last}");
    }

    #[test]
    fn without_a_plate_it_is_that_of_the_contact() {
        for e in [0.2, 0.5, 0.9, 0.99] {
            let found = plate_restitution(0.0, viscoelastic_rate(e));
            // Residual seen: 1.3e-5.
            assert!((found - e).abs() < 1e-4, "{found} for {e}");
            assert!((viscoelastic_restitution(viscoelastic_rate(e)) - e).abs() < 1e-4);
        }
    }
}
