//! Coulomb friction of one contact over one step.
//!
//! ```text
//! stick: 2A T = −s    if |T| ≤ μF      slip: (2A + ηI) T = −s,  |T| = μF      loss Tᵀ(A + ηI)T ≥ 0
//! ```
//!
//! s is the slip over the step without friction of this contact \[m\], A its tangential mobility over the
//! step, modes included [m/N]; the slip with friction is s + AT. Without the factor 2 the surfaces would
//! stick in the mean of a step, and rigid bodies would leave it with their slip reversed: a force that
//! alternates from step to step. With it their slip has stopped at its end. Both oppose the slip of the step
//! itself and take energy. A steady force makes a contact that sticks creep by AT in each step, which
//! vanishes with h. 1/|T| is concave in η, so that Newton's method rises to the root from η = 0.

/// Friction forces \[N\] along both tangents, and η [m/N].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Friction {
    pub(super) force: [f64; 2],
    pub(super) slip_rate: f64,
}

/// 2A by its values, the greatest first, and the angle of its first axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct TangentMobility {
    values: [f64; 2],
    sine: f64,
    cosine: f64,
}

impl TangentMobility {
    /// From A₁₁, A₁₂, A₂₂ [m/N].
    pub(super) fn new([a, b, c]: [f64; 3]) -> Self {
        let (sum, spread) = (a + c, (a - c).hypot(2.0 * b));
        let greatest = sum + spread;
        let least = if sum > 0.0 { (4.0 * (a * c - b * b) / greatest).max(0.0) } else { 0.0 };
        let (sine, cosine) = (0.5 * (2.0 * b).atan2(a - c)).sin_cos();
        // In a direction that cannot move there is no slip either.
        TangentMobility { values: [greatest, least.max(1e-14 * greatest)], sine, cosine }
    }

    /// Friction with the slip s \[m\] and at most μF \[N\].
    pub(super) fn friction(&self, slip: [f64; 2], most: f64) -> Friction {
        let &TangentMobility { values, sine, cosine } = self;
        if most <= 0.0 || values[0] <= 0.0 {
            // A contact that cannot move along itself has nothing to hold.
            return Friction::default();
        }
        let along = [cosine * slip[0] + sine * slip[1], cosine * slip[1] - sine * slip[0]];
        let forces = |eta: f64| [-along[0] / (values[0] + eta), -along[1] / (values[1] + eta)];
        let mut eta = 0.0;
        let mut force = forces(eta);
        for _ in 0..60 {
            let size = (force[0] * force[0] + force[1] * force[1]).sqrt();
            if size <= most * (1.0 + 1e-15) {
                break;
            }
            // d|T|²/dη = −2 Σ T²/(value + η).
            let slope = force[0] * force[0] / (values[0] + eta) + force[1] * force[1] / (values[1] + eta);
            let rise = (size / most - 1.0) * size * size / slope;
            if eta + rise == eta {
                break;
            }
            eta += rise;
            force = forces(eta);
        }
        Friction {
            force: [cosine * force[0] - sine * force[1], sine * force[0] + cosine * force[1]],
            slip_rate: eta,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_sticks_or_slips_with_the_force_of_coulomb() {
        let mobility = [2.0, 0.7, 1.0];
        for turn in 0..24 {
            let (sine, cosine) = (0.26 * f64::from(turn)).sin_cos();
            for most in [0.01, 0.4, 100.0] {
                let slip = [cosine, sine];
                let Friction { force: [t, u], slip_rate } =
                    TangentMobility::new(mobility).friction(slip, most);
                let left = [
                    slip[0] + (2.0 * mobility[0] + slip_rate) * t + 2.0 * mobility[1] * u,
                    slip[1] + 2.0 * mobility[1] * t + (2.0 * mobility[2] + slip_rate) * u,
                ];
                // Residual seen: 4e-16 of the slip, 2e-16 of the force.
                assert!(left[0].hypot(left[1]) < 1e-14, "{left:?}");
                let size = t.hypot(u);
                assert!(slip_rate >= 0.0 && size <= most * (1.0 + 1e-14));
                assert!(slip_rate == 0.0 || (size / most - 1.0).abs() < 1e-14);
            }
        }
        assert_eq!(TangentMobility::new([0.0; 3]).friction([1.0, 0.0], 1.0), Friction::default());
    }
}
