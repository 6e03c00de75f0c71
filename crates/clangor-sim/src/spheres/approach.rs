//! Times at which two surfaces first meet: roots of the gap over time.
//!
//! * Two balls under the same acceleration move uniformly relative to each other; |d + w s| = R is quadratic.
//!   The discriminant is computed as R²w² − |d × w|², without cancellation for a grazing pass, and the root
//!   as c/(−b + √disc), without cancellation near contact.
//! * A ball under constant acceleration meets a plane at a root of gap + v s + a s²/2.
//! * Everything else (rolling against flying, swinging arcs): gap(s) = |d(s)| − R has gap″ ≥ −A with A the
//!   largest relative acceleration, because the distance of two uniformly moving points is convex. So gap +
//!   gap′ s − A s²/2 is a lower bound whose root never lies beyond the first contact. Advancing from root to
//!   root is a Newton iteration that cannot step over a contact. No quartic has to be solved.
//!
//! A contact that separates more slowly than A·[`CONTACT_TIME`]/2 is lasting: the next search starts
//! [`CONTACT_TIME`] later.

use glam::DVec3;

use super::tolerances::{CONTACT_TIME, QUIET_ACCELERATION, QUIET_SPEED, TOUCH};

/// Most steps of a search; it is then resumed at the time reached.
const MAX_STEPS: usize = 100;

/// The outcome of a search over an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Approach {
    /// No contact.
    Never,
    /// Contact after this time \[s\].
    At(f64),
    /// No contact up to this time \[s\]; the search must be resumed there.
    Unclear(f64),
}

/// Time \[s\] to the contact of two balls in uniform relative motion: offset `d`, relative velocity `w`, R =
/// `reach`.
#[inline]
pub(super) fn meet_uniform(d: DVec3, w: DVec3, reach: f64) -> Option<f64> {
    let b = d.dot(w);
    if b >= 0.0 {
        return None;
    }
    let c = d.length_squared() - reach * reach;
    if c <= 0.0 {
        return (b < -QUIET_SPEED * reach).then_some(0.0);
    }
    let discriminant = reach * reach * w.length_squared() - d.cross(w).length_squared();
    if discriminant <= 0.0 || c <= 2.0 * TOUCH * reach && b > -QUIET_SPEED * reach {
        return None;
    }
    Some(c / (discriminant.sqrt() - b))
}

/// Time \[s\] to the next contact with a plane at distance `gap`, under constant normal velocity and
/// acceleration.
#[inline]
pub(super) fn meet_plane(gap: f64, v: f64, a: f64) -> Option<f64> {
    if gap <= TOUCH && v.abs() <= QUIET_SPEED {
        // Touching and not separating: a lasting contact if something presses.
        return (a < -QUIET_ACCELERATION).then_some(CONTACT_TIME);
    }
    // A tolerated overlap is not corrected: the ball returns to its initial depth.
    fall(gap.max(0.0), v, a)
}

/// Smallest s ≥ 0 at which gap + v s + a s²/2 = 0 is reached from above, for gap ≥ 0.
#[inline]
pub(super) fn fall(gap: f64, v: f64, a: f64) -> Option<f64> {
    let discriminant = v * v - 2.0 * a * gap;
    if a < 0.0 {
        let root = discriminant.sqrt();
        return Some(if v < 0.0 { 2.0 * gap / (root - v) } else { (v + root) / -a });
    }
    (v < 0.0 && discriminant > 0.0).then(|| 2.0 * gap / (discriminant.sqrt() - v))
}

/// First contact in [0, horizon] of a gap given with its rate, where gap″ ≥ −`bound` \[m/s²\].
pub(super) fn meet(mut gap_at: impl FnMut(f64) -> (f64, f64), bound: f64, horizon: f64) -> Approach {
    let mut s = 0.0;
    for _ in 0..MAX_STEPS {
        let (gap, rate) = gap_at(s);
        // Root of the lower bound, never beyond the first contact.
        let step = 2.0 * gap.max(0.0) / ((rate * rate + 2.0 * bound * gap.max(0.0)).sqrt() - rate);
        if gap <= TOUCH {
            // A residual approach in a lasting contact is not an impact.
            if rate < -QUIET_SPEED.max(0.5 * bound * CONTACT_TIME) || s > 0.0 && rate < -QUIET_SPEED {
                return Approach::At(s + step);
            }
            if bound <= QUIET_ACCELERATION && rate <= QUIET_SPEED {
                return Approach::Never;
            }
            s += (2.0 * rate.max(0.0) / bound).max(CONTACT_TIME);
        } else {
            s += step;
        }
        if s.is_nan() || s > horizon {
            return Approach::Never;
        }
    }
    Approach::Unclear(s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_head_on_meeting_takes_distance_over_speed() {
        let time = meet_uniform(DVec3::X * 3.0, DVec3::X * -2.0, 1.0).unwrap();
        assert!((time - 1.0).abs() < 1e-15);
        assert!(meet_uniform(DVec3::X * 3.0, DVec3::X * 2.0, 1.0).is_none());
        assert!(meet_uniform(DVec3::new(3.0, 1.0 + 1e-12, 0.0), DVec3::X * -2.0, 1.0).is_none());
        assert!(meet_uniform(DVec3::new(3.0, 1.0 - 1e-12, 0.0), DVec3::X * -2.0, 1.0).is_some());
    }

    #[test]
    fn the_search_agrees_with_the_quadratic() {
        let (d, w) = (DVec3::new(3.0, 0.7, 0.1), DVec3::new(-2.0, 0.05, 0.0));
        let gap_at = |s: f64| {
            let at = d + w * s;
            (at.length() - 1.0, at.dot(w) / at.length())
        };
        let exact = meet_uniform(d, w, 1.0).unwrap();
        for bound in [0.0, 0.5, 20.0] {
            let Approach::At(s) = meet(gap_at, bound, 10.0) else { panic!("missed") };
            // Residual seen: 3e-13.
            assert!((s - exact).abs() < 1e-11, "{s} {exact}");
        }
        assert_eq!(meet(gap_at, 20.0, 0.9 * exact), Approach::Never);
    }

    #[test]
    fn a_thrown_ball_returns_after_twice_the_rise() {
        assert_eq!(fall(0.0, 2.0, -10.0), Some(0.4));
        assert_eq!(fall(1.0, 0.0, -2.0), Some(1.0));
        assert_eq!(fall(1.0, -1.0, 0.6), None);
        assert_eq!(meet_plane(0.0, 0.0, -9.81), Some(CONTACT_TIME));
        assert_eq!(meet_plane(0.0, -1e-17, 0.0), None);
    }
}
