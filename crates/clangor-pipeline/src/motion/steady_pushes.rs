//! Pushes that last beside an impact or instead of one: a hand that slows a body down, drags it along or sets
//! it down, and friction.
//!
//! ```text
//! even before frame k:    p₁ − p₂ = p₂ − p₃        p = Δv/h beyond gravity, of the frames before
//! no impact at k:         p_k = p₁ + (p₁ − p₂), or p_k between that and the steady push after it
//! ```
//!
//! within [`STEADY`] of gravity, and the same backwards in time for the second. Where a push begins or ends,
//! its change falls into two frames.

use glam::DVec3;

use super::kinematics::{Jump, Kinematics};

/// Least push of a lasting contact, over the weight.
pub(super) const LEAST_PUSH: f64 = 0.3;
/// Difference of pushes that are the same, over g h.
pub(super) const STEADY: f64 = 0.15;
/// Largest change of an even push from frame to frame, over the push.
const MOST_SLOPE: f64 = 0.5;
/// How far an even push goes on beyond its last frame, in frames: to the end of those that a change shares.
const ONWARDS: f64 = 1.5;

/// Whether the push at a frame is the same at the one beyond.
pub(super) fn lasts(kinematics: &Kinematics<'_>, k: usize, beyond: usize) -> bool {
    let push = |k: usize| kinematics.jumps.get(k).map(|jump| jump.velocity / jump.span);
    let (Some(one), Some(other)) = (push(k), push(beyond)) else { return false };
    let g = kinematics.inertia.gravity.length();
    one.length() > LEAST_PUSH * g && one.distance(other) < STEADY * g
}

/// Whether a jump goes on with an even push before it, or lies between an even push on one side and a steady
/// one on the other.
pub(super) fn is_of_pushes(jumps: &[Jump], k: usize, gravity: f64) -> bool {
    let Some(own) = push(jumps, k) else { return false };
    let (small, least) = (STEADY * gravity, LEAST_PUSH * gravity);
    // Frames `step` apart, the nearest ones left out.
    let beside = |step: isize, left_out: usize, count: usize| {
        let place = |n: usize| k.checked_add_signed(step * (left_out + n) as isize);
        (1..=count).map(|n| push(jumps, place(n)?)).collect::<Option<Vec<DVec3>>>()
    };
    // The nearest push on one side, and how it changes from frame to frame.
    let even = |step: isize, left_out: usize| {
        let near = beside(step, left_out, 3)?;
        let (one, slope) = (near[0], near[0] - near[1]);
        let is_even = slope.length() < MOST_SLOPE * one.length() && slope.distance(near[1] - near[2]) < small;
        (is_even && one.length() > least).then_some((one, slope))
    };
    let goes_on = even(-1, 0).is_some_and(|(one, slope)| own.distance(one + slope) < small);
    let is_between = |(step, [left_out, beyond]): (isize, [usize; 2])| {
        let (Some((one, slope)), Some(other)) = (even(step, left_out), beside(-step, beyond, 2)) else {
            return false;
        };
        // A body that lands from a flight is hit, however softly.
        let is_steady = other[0].distance(other[1]) < small && (step < 0 || other[0].length() > least);
        let is_on_way = rest_beyond(own, (one + ONWARDS * slope, other[0])).length() < small;
        is_steady && (is_on_way || own.distance(one + slope) < small)
    };
    let left_out = [[0, 0], [1, 0], [0, 1]];
    goes_on || [-1, 1].into_iter().any(|step| left_out.into_iter().any(|out| is_between((step, out))))
}

/// Whether a jump differs from pushes that last before it and after it, and from those that lead from the one
/// to the other: that of the stop of a door which a hinge or a hand carries, or of a box which slides on, at
/// few frames a second is no larger than they are. The smaller share of an impact is left out; `least` is the
/// difference that counts, `fall` is g h [m/s].
pub(super) fn leaves_steady_push(jumps: &[Jump], k: usize, (least, fall): (f64, f64)) -> bool {
    let push = |frame: usize| jumps.get(frame).map(|jump| jump.velocity);
    let most = STEADY * fall;
    // Most jumps are like both before, one of which is near the mean of steady ones.
    let is_like = |frame: Option<usize>| {
        let others = frame.and_then(push).zip(push(k));
        others.is_some_and(|(other, own)| own.distance_squared(other) < (least - most).max(0.0).powi(2))
    };
    if [1, 2].into_iter().all(|n| is_like(k.checked_sub(n))) {
        return false;
    }
    // The mean of two frames beyond `left_out` on one side where they are alike.
    let steady = |step: isize, left_out: isize| {
        let frames = [1, 2].map(|n| k.checked_add_signed(step * (left_out + n)).and_then(push));
        let [Some(near), Some(far)] = frames else { return None };
        (near.distance(far) < 2.0 * most).then(|| 0.5 * (near + far))
    };
    [(0, 0), (0, 1), (1, 0)].into_iter().any(|(before, after)| {
        let (Some(own), Some(one), Some(other)) = (push(k), steady(-1, before), steady(1, after)) else {
            return false;
        };
        let rest = rest_beyond(own, (one, other));
        let twin = if before > 0 { k - 1 } else { k + after as usize };
        let is_larger = push(twin)
            .map(|share| rest_beyond(share, (one, other)))
            .is_some_and(|share| share.dot(rest) > 0.0 && share.length_squared() <= rest.length_squared());
        rest.length() > least && is_larger
    })
}

/// What is left of a push beyond the nearest one between two.
fn rest_beyond(own: DVec3, (one, other): (DVec3, DVec3)) -> DVec3 {
    let way = other - one;
    let part = (own - one).dot(way) / way.length_squared().max(f64::MIN_POSITIVE);
    own - (one + way * part.clamp(0.0, 1.0))
}

/// Acceleration beyond gravity at a frame that is neither the first nor the last [m/s²].
fn push(jumps: &[Jump], k: usize) -> Option<DVec3> {
    let is_within = (1..jumps.len().saturating_sub(1)).contains(&k);
    is_within.then(|| jumps[k].velocity / jumps[k].span)
}

#[cfg(test)]
mod tests {
    use super::*;

    const G: f64 = 9.81;

    /// Jumps of frames of 1/60 s by pushes along y in units of gravity.
    fn jumps(pushes: &[f64]) -> Vec<Jump> {
        let jump =
            |p: &f64| Jump { velocity: DVec3::Y * (p * G / 60.0), span: 1.0 / 60.0, ..Jump::default() };
        pushes.iter().map(jump).collect()
    }

    fn of_pushes(pushes: &[f64]) -> Vec<usize> {
        let jumps = jumps(pushes);
        (0..jumps.len()).filter(|k| is_of_pushes(&jumps, *k, G)).collect()
    }

    #[test]
    fn a_hand_that_sets_down_slowly_makes_no_impact() {
        // Slowed down more and more, to rest within the eighth frame.
        let slowed = of_pushes(&[1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.3, 1.0, 1.0, 1.0, 1.0]);
        assert_eq!(slowed[..5], [3, 4, 5, 6, 7]);
        // With a speed left that the floor stops.
        assert!(!of_pushes(&[1.0, 1.4, 1.4, 1.4, 1.4, 3.0, 1.0, 1.0, 1.0]).contains(&5));
        // A hand begins to pull, more and more, at what rests.
        assert!(of_pushes(&[1.0, 1.0, 1.0, 1.2, 1.5, 1.8, 2.1, 2.4]).contains(&3));
        // A soft landing from a flight.
        assert!(!of_pushes(&[0.0, 0.0, 0.0, 0.6, 1.0, 1.0, 1.0, 1.0]).contains(&3));
        // A bounce in flight, in one frame or two.
        assert!(of_pushes(&[0.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0]).is_empty());
        assert!(of_pushes(&[0.0, 0.0, 0.0, 0.0, 3.0, 2.0, 0.0, 0.0, 0.0]).is_empty());
    }
}
