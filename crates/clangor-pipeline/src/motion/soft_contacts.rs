//! Impacts of engines whose contacts give way: a push over many frames instead of a jump in one.
//!
//! ```text
//! p (push on the body in a frame)        │█                  p = Δv of a frame beyond free flight
//!   │   ▂█▇▆▅▄▃▂▂▁▁ weight         ─►    │█▁▁▁▁▁▁▁▁▁▁        J = Σ p − w T
//!   └──────────────────────► frames      └──────────────     w = max(0, −g·d) along d
//! ```
//!
//! A contact with the stiffness of its materials lasts less than a millisecond. One of an engine with soft
//! contacts lasts 10 to 60 ms, in which the bodies overlap by centimetres. The impulse is the same but for
//! that of the weight in this time, and for what pushes the overlap out again. It is taken as one jump at the
//! frame at which the push begins, and the weight as the push of the rest of it. Positions that a filter has
//! smoothed look the same, but turn before they reach a surface, and touch nothing there.
//!
//! Such a push begins from next to nothing, has one direction and one maximum of several weights, and ends
//! soon. A hand pushes for longer, and what rolls or spins is pushed before and after. In few frames, several
//! hits of a stiff engine look the same: below 200 Hz, most soft contacts are not told from them.
//!
//! Seen: pushes of 18 to 60 ms (default contacts of MuJoCo, ball of steel at 3.1 m/s), of 20 ms with a
//! rebound (`solref` of 4 ms and a damping ratio of 0.3).

use std::ops::Range;

use clangor_core::body::BodyId;
use glam::DVec3;

/// Least maximum of a push, over the weight.
const LEAST_PEAK: f64 = 3.0;
/// Share of the maximum below which a push is next to nothing, and below which it is over.
const NEXT_TO_NOTHING: f64 = 0.15;
const OVER: f64 = 0.05;
/// The push that is over the weight by this factor is not over.
const ABOVE_WEIGHT: f64 = 1.2;
/// Fewest frames with more than next to nothing, and the longest time of the whole push \[s\]. Hits of a
/// tumbling box at 240 Hz looked like a push of five.
const FEWEST: usize = 6;
const LONGEST: f64 = 0.06;
/// Largest ratio of two frames that follow each other, and least cosine between them and the maximum.
const ALIKE_SIZE: f64 = 3.0;
const ALIKE_DIRECTION: f64 = 0.8;
/// Growth after the maximum that is none.
const LEVEL: f64 = 1.1;
/// Least jump of the whole push [m/s].
const LEAST_JUMP: f64 = 0.15;

/// A push over several frames that is taken as one impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftPush {
    /// What is pushed.
    pub body: BodyId,
    /// Where it begins \[s\].
    pub time: f64,
    /// \[s\]
    pub length: f64,
}

/// Change of the motion of a body at a frame beyond that of free flight.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FrameChange {
    /// Δv [m/s].
    pub(super) velocity: DVec3,
    /// ΔL [kg m²/s].
    pub(super) angular_momentum: DVec3,
    /// Mean length of the frames before and after \[s\].
    pub(super) span: f64,
}

/// The frames of soft pushes among the changes of a body under gravity [m/s²], in order.
pub(super) fn soft_pushes(jumps: &[FrameChange], gravity: DVec3) -> Vec<Range<usize>> {
    let g = gravity.length();
    let (mut found, mut k) = (Vec::new(), 2);
    while k + 1 < jumps.len() {
        let is_strong = jumps[k].velocity.length_squared() > (LEAST_PEAK * g * jumps[k].span).powi(2);
        match is_strong.then(|| soft_push(jumps, k, gravity)).flatten() {
            Some(push) => {
                k = push.end.max(k + 1);
                found.push(push);
            }
            None => k += 1,
        }
    }
    found
}

/// The soft push of which frame `k` is the first strong one.
fn soft_push(jumps: &[FrameChange], k: usize, gravity: DVec3) -> Option<Range<usize>> {
    let size = |k: usize| jumps.get(k).map_or(0.0, |jump| jump.velocity.length());
    // What lasts is left at once, or a steady push would be gone through again from each of its frames.
    let mut time = jumps[k].span;
    let mut lasts = |k: usize| {
        time += jumps[k].span;
        time > LONGEST
    };
    // The maximum follows within a few frames.
    let mut top = k;
    while top + 1 < jumps.len() && size(top + 1) > size(top) && size(top + 1) < ALIKE_SIZE * size(top) {
        top += 1;
        if lasts(top) {
            return None;
        }
    }
    let (peak, direction) = (size(top), jumps[top].velocity.normalize_or_zero());
    let weight = (-gravity.dot(direction)).max(0.0);
    let is_along = |k: usize| jumps[k].velocity.dot(direction) > ALIKE_DIRECTION * size(k);
    let pushes = |k: usize| size(k) > OVER * peak && is_along(k);
    // On both sides of it, the push falls to nothing or to the weight.
    let mut first = top;
    while first > 2 && pushes(first - 1) && size(first - 1) < LEVEL * size(first) {
        first -= 1;
        if first < k && lasts(first) {
            return None;
        }
    }
    let mut end = top + 1;
    let falls_on = |k: usize| {
        let is_above = size(k) > ABOVE_WEIGHT * weight * jumps[k].span;
        pushes(k) && is_above && size(k) < LEVEL * size(k - 1)
    };
    while end + 1 < jumps.len() && falls_on(end) {
        if lasts(end) {
            return None;
        }
        end += 1;
    }
    let is_quiet = |k: usize| size(k) <= (NEXT_TO_NOTHING * peak).max(ABOVE_WEIGHT * weight * jumps[k].span);
    if !(is_quiet(first - 1) && is_quiet(first - 2) && (end..(end + 2).min(jumps.len())).all(is_quiet)) {
        return None;
    }
    let core = |k: &usize| size(*k) > NEXT_TO_NOTHING * peak;
    let of_core: Vec<usize> = (first..end).filter(core).collect();
    let is_smooth = of_core.windows(2).all(|pair| {
        let (one, two) = (size(pair[0]), size(pair[1]));
        // The first frame may hold only the beginning of the push.
        pair[1] == pair[0] + 1 && (pair[0] == of_core[0] || one.max(two) < ALIKE_SIZE * one.min(two))
    });
    let time: f64 = jumps[first..end].iter().map(|jump| jump.span).sum();
    let jump: DVec3 = jumps[first..end].iter().map(|jump| jump.velocity).sum();
    let whole = jump.length() - weight * time;
    let is_soft = of_core.len() >= FEWEST && is_smooth && time <= LONGEST && whole > LEAST_JUMP;
    is_soft.then_some(first..end)
}

/// Makes a soft push one change at its first frame, with the weight in the rest.
pub(super) fn gather(jumps: &mut [FrameChange], push: Range<usize>, gravity: DVec3) {
    let own = &mut jumps[push];
    let whole: DVec3 = own.iter().map(|change| change.velocity).sum();
    let turning: DVec3 = own.iter().map(|change| change.angular_momentum).sum();
    let direction = whole.normalize_or_zero();
    let weight = direction * (-gravity.dot(direction)).max(0.0);
    let Some((first, rest)) = own.split_first_mut() else { return };
    (first.velocity, first.angular_momentum) = (whole, turning);
    for change in rest {
        *change = FrameChange { velocity: weight * change.span, angular_momentum: DVec3::ZERO, ..*change };
        first.velocity -= change.velocity;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const G: DVec3 = DVec3::new(0.0, -9.81, 0.0);

    /// Jumps along y in frames of a millisecond.
    fn jumps(pushes: impl IntoIterator<Item = f64>) -> Vec<FrameChange> {
        let jump = |p: f64| FrameChange { velocity: DVec3::Y * p, span: 1e-3, ..FrameChange::default() };
        pushes.into_iter().map(jump).collect()
    }

    fn with_rest(before: f64, push: impl Iterator<Item = f64>, after: f64) -> Vec<FrameChange> {
        jumps(std::iter::repeat_n(before, 10).chain(push).chain(std::iter::repeat_n(after, 30)))
    }

    #[test]
    fn a_push_that_begins_from_nothing_and_ends_soon_is_one_impact() {
        let decay = || (0..60).map(|k| 0.0098 + 0.35 * (-f64::from(k) / 10.0).exp());
        let found = soft_pushes(&with_rest(0.0, decay(), 0.0098), G);
        assert_eq!(found.len(), 1);
        let push = found[0].clone();
        assert!(push.start == 10 && push.len() > 20);
        let all = with_rest(0.0, decay(), 0.0098);
        let mut one = all.clone();
        gather(&mut one, push.clone(), G);
        let sum: f64 = one[push.clone()].iter().map(|change| change.velocity.y).sum();
        let whole: f64 = all[push.clone()].iter().map(|change| change.velocity.y).sum();
        assert!((sum - whole).abs() < 1e-12);
        // The decay has 0.35 / (1 − e^−0.1) = 3.678 without the weight, but for its end. Seen: 0.02.
        let first = one[push.start].velocity.y;
        assert!((first / 3.678 - 1.0).abs() < 0.06, "{first}");
        assert!((one[push.start + 1].velocity.y - 9.81e-3).abs() < 1e-12);
    }

    #[test]
    fn jumps_hands_and_what_rolls_are_none() {
        // An impact shared by two frames, and one after the other.
        assert!(soft_pushes(&with_rest(0.0, [2.0, 1.0].into_iter(), 0.0098), G).is_empty());
        assert!(soft_pushes(&with_rest(0.0, [2.0, 0.1, 1.5, 0.2, 1.0].into_iter(), 0.0098), G).is_empty());
        // A throw of 100 ms.
        let throw = (0..100).map(|k| 0.06 * (f64::from(k) * 0.0314).sin());
        assert!(soft_pushes(&with_rest(0.0098, throw, 0.0), G).is_empty());
        // A steady push without gravity, however long.
        let steady = std::iter::repeat_n(0.1, 20_000);
        assert!(soft_pushes(&with_rest(0.0, steady, 0.1), DVec3::ZERO).is_empty());
        // The bottom of a bowl, from walls that push as well.
        let bowl = (0..40).map(|k| 0.01 + 0.03 * (f64::from(k) * 0.0785).sin());
        assert!(soft_pushes(&with_rest(0.012, bowl, 0.012), G).is_empty());
    }
}
