//! Steps within the limits that impulses have reached, for fits whose impulses pass loads on.
//!
//! Sweeps and projected gradients find soon which points push and which slip, but carry a load through a
//! stack of N bodies in about N² of them: each sets one impulse by its neighbours. Once the limits are known,
//! what is left is a linear problem, which conjugate gradients solve in about N steps (the two in turns:
//! Moré and Toraldo, SIAM J. Optim. 1 (1991) 93):
//!
//! ```text
//! free: any change     on the cone |j_t| = μ j_n: changes along its surface     none: no change
//! ```

use glam::DVec3;

/// Share of the limit of friction from which an impulse slips.
const SLIPS: f64 = 1.0 - 1e-9;
/// Gradient that is left, over that at the start, at which the steps end; most steps.
const SOLVED: f64 = 1e-9;
const STEPS: usize = 500;

/// Which changes of an impulse keep its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Face {
    /// None.
    Fixed,
    /// Any.
    Free,
    /// Those across this unit normal of the cone.
    Cone(DVec3),
}

impl Face {
    /// Of an impulse of a contact with this normal and friction.
    pub(super) fn of_impulse(impulse: DVec3, normal: DVec3, friction: f64) -> Self {
        let along = impulse.dot(normal);
        let tangential = impulse - normal * along;
        if along <= 0.0 {
            Face::Fixed
        } else if tangential.length() < SLIPS * friction * along {
            Face::Free
        } else {
            Face::Cone((tangential.normalize_or_zero() - normal * friction).normalize_or_zero())
        }
    }

    /// The part of a change that keeps the limits.
    pub(super) fn part(self, change: DVec3) -> DVec3 {
        match self {
            Face::Fixed => DVec3::ZERO,
            Face::Free => change,
            Face::Cone(normal) => change - normal * change.dot(normal),
        }
    }
}

/// The change of impulses within their faces that takes a gradient (the velocities that are left at them)
/// away: `apply` gives what a change makes of them, `masses` are the inverse of that for each alone.
pub(super) fn change_within(
    faces: &[Face],
    gradient: Vec<DVec3>,
    masses: impl Fn(usize, DVec3) -> DVec3,
    apply: impl Fn(&[DVec3]) -> Vec<DVec3>,
) -> Vec<DVec3> {
    let dot = |a: &[DVec3], b: &[DVec3]| -> f64 { a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum() };
    let conditioned = |left: &[DVec3]| -> Vec<DVec3> {
        let each = faces.iter().zip(left).enumerate();
        each.map(|(k, (face, left))| face.part(masses(k, face.part(*left)))).collect()
    };
    let mut left = gradient;
    let mut change = vec![DVec3::ZERO; left.len()];
    let mut ahead = conditioned(&left);
    let first = dot(&left, &ahead);
    let mut square = first;
    for _ in 0..STEPS {
        let effect = apply(&ahead);
        let curvature = dot(&ahead, &effect);
        if square <= SOLVED * SOLVED * first || curvature <= 0.0 {
            break;
        }
        let step = square / curvature;
        change.iter_mut().zip(&ahead).for_each(|(change, ahead)| *change += *ahead * step);
        left.iter_mut().zip(&effect).for_each(|(left, effect)| *left -= *effect * step);
        let next = conditioned(&left);
        let before = std::mem::replace(&mut square, dot(&left, &next));
        ahead = next.iter().zip(&ahead).map(|(next, ahead)| *next + *ahead * (square / before)).collect();
    }
    change
}

/// Shares of a change that are tried, the first that leaves less is taken.
pub(super) const SHARES: [f64; 6] = [1.0, 0.5, 0.25, 0.1, 0.03, 0.01];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_passes_through_a_chain() {
        // Forces between 100 bodies of 1 kg on a floor; each needs a change of 1 m/s.
        const N: usize = 100;
        let apply = |forces: &[DVec3]| {
            let of = |k: usize| forces.get(k).copied().unwrap_or(DVec3::ZERO);
            let below = |k: usize| if k > 0 { of(k - 1) - of(k) } else { DVec3::ZERO };
            (0..N).map(|k| of(k) - of(k + 1) - below(k)).collect::<Vec<DVec3>>()
        };
        let mut gradient = vec![DVec3::ZERO; N];
        gradient[0] = DVec3::Y;
        let forces = change_within(&[Face::Free; N], gradient, |_, left| left * 0.5, apply);
        for (k, force) in forces.iter().enumerate() {
            let due = DVec3::Y * (N - k) as f64;
            assert!(force.distance(due) < 1e-9 * N as f64, "{k}: {force}");
        }
    }

    #[test]
    fn changes_keep_what_limits_have_been_reached() {
        let slips = Face::of_impulse(DVec3::new(0.5, 1.0, 0.0), DVec3::Y, 0.5);
        let along = slips.part(DVec3::new(0.5, 1.0, 0.0));
        assert!(along.distance(DVec3::new(0.5, 1.0, 0.0)) < 1e-15, "{along}");
        assert!(slips.part(DVec3::new(1.0, -0.5, 0.0)).length() < 1.0, "{slips:?}");
        assert_eq!(Face::of_impulse(DVec3::new(0.4, 1.0, 0.0), DVec3::Y, 0.5), Face::Free);
        assert_eq!(Face::of_impulse(DVec3::ZERO, DVec3::Y, 0.5), Face::Fixed);
    }
}
