//! Complete elliptic integrals by the arithmetic-geometric mean.
//!
//! ```text
//! K = ∫ dφ/Δ     B = ∫ cos²φ dφ/Δ     D = ∫ sin²φ dφ/Δ     Δ² = 1 − m sin²φ, φ from 0 to π/2
//! ```
//!
//! K = B + D, and E = B + (1 − m) D is the integral of the second kind. Source: Abramowitz and Stegun,
//! section 17.6; D is summed without the difference K − E, so that m = 0 is no special case.

/// The three integrals at one modulus.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CompleteIntegrals {
    /// K, of the first kind.
    pub(crate) first: f64,
    /// B = (E − (1 − m) K)/m.
    pub(crate) cosine: f64,
    /// D = (K − E)/m.
    pub(crate) sine: f64,
}

/// Steps of the mean; the number of correct digits doubles in each.
const MOST_STEPS: usize = 40;

impl CompleteIntegrals {
    /// At the complementary modulus k' = √(1 − m), from above 0 to 1.
    pub(crate) fn at_complement(complement: f64) -> Self {
        let (mut a, mut b) = (1.0, complement);
        // (K − E)/(m K) = ½ + Σ 2ⁿ⁻¹ cₙ²/m over the half differences cₙ of step n.
        let (mut half_difference, mut weight, mut sum) = (0.5 * (a - b), 1.0, 0.5);
        let mut share = (1.0 - complement) / (4.0 * (1.0 + complement));
        for _ in 0..MOST_STEPS {
            (a, b) = (0.5 * (a + b), (a * b).sqrt());
            sum += weight * share;
            if half_difference <= 1e-8 * a {
                break;
            }
            // The next half difference is c²/(4 a) with the next a.
            let next = 0.5 * (a + b);
            share *= (half_difference / (4.0 * next)).powi(2);
            half_difference *= half_difference / (4.0 * next);
            weight *= 2.0;
        }
        let first = std::f64::consts::FRAC_PI_2 / a;
        CompleteIntegrals { first, cosine: first * (1.0 - sum), sine: first * sum }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrals_are_those_of_a_quadrature() {
        // The trapezoidal rule converges exponentially for these periodic integrands.
        for complement in [1.0, 0.999_999, 0.9, 0.5, 0.1, 0.01_f64] {
            let nodes = 4096;
            let mut sums = [0.0; 2];
            for k in 0..nodes {
                let (sin, cos) = ((f64::from(k) + 0.5) / f64::from(nodes) * std::f64::consts::PI).sin_cos();
                let root = (cos * cos + complement * complement * sin * sin).sqrt();
                sums[0] += cos * cos / root;
                sums[1] += sin * sin / root;
            }
            let [b, d] = sums.map(|sum| sum * std::f64::consts::FRAC_PI_2 / f64::from(nodes));
            let found = CompleteIntegrals::at_complement(complement);
            let errors =
                [found.cosine / b - 1.0, found.sine / d - 1.0, found.first / (b + d) - 1.0].map(f64::abs);
            // Seen: 1e-15 at most, of the quadrature.
            assert!(errors.iter().all(|error| *error < 1e-13), "{complement}: {errors:?}");
        }
    }
}
