//! The force of what is left of an impulse after the contact of a body that gives way.
//!
//! The motion of a timeline stops a thin body at once. The force of its contact is less than that needs: the
//! body gives way, and its bending waves bring the rest of the momentum back while the contact lasts. How is
//! not known; the rest is taken to act slowly, and with no greater force F than the contact had:
//!
//! ```text
//! f(t) = j/T (1 − cos 2πt/T),    T = 2 j/F, at least the time of the contact, at most 50 ms
//! ```
//!
//! It moves the body as a whole. Its modes have their share from the contact.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::force_history::ForceHistory;

/// Longest time \[s\].
const LONGEST: f64 = 0.05;
/// Steps in which the force is given.
const STEPS: usize = 256;

/// The shape of the force of an impulse [N s] beside a contact of which the `greatest` force \[N\] and the
/// `time` \[s\] are known, and its end \[s\]; `None` without an impulse. It holds frequencies up to a `band`
/// \[Hz\].
pub(super) fn slow_rest(
    impulse: f64,
    (greatest, time): (f64, f64),
    band: f64,
) -> Option<(Arc<ForceHistory>, f64)> {
    if !(impulse > 0.0 && greatest > 0.0) {
        return None;
    }
    let end = (2.0 * impulse / greatest).min(LONGEST).max(time);
    let force = |n: usize| 1.0 - (TAU * (n as f64 + 0.5) / STEPS as f64).cos();
    let forces: Vec<f64> = (0..STEPS).map(force).collect();
    let (history, _) = ForceHistory::of_steps(&forces, end / STEPS as f64, band)?;
    Some((Arc::new(history), end))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rest_has_no_greater_force_where_it_may_last() {
        // 1 mN s beside 2 N: 1 ms, or the 3 ms of the contact; 1 N s: 50 ms.
        for (impulse, time, expected) in [(1e-3, 1e-4, 1e-3), (1e-3, 3e-3, 3e-3), (1.0, 1e-4, 0.05)] {
            let (history, end) = slow_rest(impulse, (2.0, time), 24e3).expect("an impulse");
            assert!((end - expected).abs() < 1e-15, "{end}");
            let values = history.values();
            let area: f64 = values.iter().sum::<f64>() * history.step();
            let greatest = values.iter().copied().fold(0.0, f64::max);
            // Residuals seen: 6e-12 and 2.3e-5.
            assert!((area - 1.0).abs() < 1e-6, "{area}");
            assert!((greatest * end / 2.0 - 1.0).abs() < 1e-3, "{greatest}");
        }
        assert!(slow_rest(0.0, (2.0, 1e-4), 24e3).is_none() && slow_rest(1.0, (0.0, 1e-4), 24e3).is_none());
    }
}
