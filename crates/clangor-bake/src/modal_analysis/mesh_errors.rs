//! Errors of frequencies due to the mesh, from their change since a coarser mesh (Richardson).
//!
//! ```text
//! everywhere finer        e = c q/(1 − q),    c = |f_coarse/f − 1|,    q: share of the error that is left,
//!                         of all modes, or of each where a higher order gains less at some places;
//!                         q ≥ 2/3 where c is larger than the error that was expected
//! in some places finer    e = max(c q/(1 − q), q e_coarse/2), with q of each mode;
//!                         max(c, q e_coarse) where q is close to 1
//! ```
//!
//! The share of a mode is an estimate, so that a small change alone does not show a small error.

use super::COARSE_MARGIN;

/// Share of an error above which the change of a frequency does not show it.
const LITTLE_CHANGED: f64 = 0.85;
/// Least share of an error that is left where a change is larger than the error that was expected: that of
/// an error ∝ edge, in edges of two thirds.
const SLOWEST: f64 = 2.0 / 3.0;

/// Estimated relative error of each frequency, from the errors `before`, if they are known, and the share of
/// them that is left: `alike`, or of each mode where the mesh is finer in some places.
pub(super) fn mesh_errors(
    coarse: &[f64],
    fine: &[f64],
    (before, alike): (&[f64], f64),
    share: impl Fn(usize) -> Option<f64>,
) -> Vec<f64> {
    let pairs = coarse.iter().zip(fine).enumerate();
    let by_change = |change: f64, q: f64| change * q / (1.0 - q);
    let mut errors: Vec<f64> = pairs
        .map(|(mode, (c, f))| {
            let change = (c / f - 1.0).abs();
            match (share(mode), before.get(mode)) {
                (Some(q), Some(error)) if q > LITTLE_CHANGED => change.max(q * error),
                (Some(q), Some(error)) => by_change(change, q).max(0.5 * q * error),
                (Some(q), None) => by_change(change, q),
                (None, Some(error)) if change > *error => by_change(change, alike.max(SLOWEST)),
                (None, _) => by_change(change, alike),
            }
        })
        .collect();
    // A mode that the coarser mesh moved beyond the band takes the largest error of the others.
    let beyond = by_change(COARSE_MARGIN - 1.0, alike);
    let worst = errors.iter().copied().reduce(f64::max).unwrap_or(beyond);
    errors.resize(fine.len(), worst);
    errors
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_follow_the_change_but_not_below_what_is_known() {
        let (coarse, fine) = ([1.03, 2.02, 3.003, 4.0], [1.0, 2.0, 3.0, 4.0, 5.0]);
        let alike = mesh_errors(&coarse, &fine, (&[], 0.25), |_| None);
        let expected = [0.01, 0.01 / 3.0, 0.001 / 3.0, 0.0, 0.01];
        assert!(alike.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{alike:?}");
        // A higher order, which gains little for the first mode.
        let order = mesh_errors(&coarse, &fine, (&[], 0.25), |m| (m == 0).then_some(0.75));
        let expected = [0.09, 0.01 / 3.0, 0.001 / 3.0, 0.0, 0.09];
        assert!(order.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{order:?}");
        // A change that is larger than the error before.
        let refuted = mesh_errors(&coarse[..2], &fine[..2], (&[0.02, 0.02], 0.25), |_| None);
        assert!((refuted[0] - 0.06).abs() < 1e-12 && (refuted[1] - 0.01 / 3.0).abs() < 1e-12, "{refuted:?}");
        // Half of the remainder halved; hardly any; a change that is smaller than the share says.
        let shares = [0.5, 0.95, 0.5, 0.95];
        let local =
            mesh_errors(&coarse, &fine, (&[0.04, 0.005, 0.02, 0.008], 1.0), |m| shares.get(m).copied());
        let expected = [0.03, 0.01, 0.005, 0.0076, 0.03];
        assert!(local.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{local:?}");
    }
}
