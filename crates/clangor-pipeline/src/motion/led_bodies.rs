//! Bodies that a hand or a joint leads, which nothing that they touch could push as they are pushed.
//!
//! ```text
//! p = Δv/h beyond gravity, in three frames in a row that go over into each other
//! given by contacts:    min |p − Σ j|² < ¼ |p|²        j·n ≥ 0,  |j_t| ≤ μ j·n
//! ```
//!
//! An impact pushes for two frames, so that three in a row are a force that lasts. It is sought before an
//! instant and after it: a hand that lets go there, and one that sets a body down, lead it on one side only.
//! Where frames end, the other side decides. A body that lies on something which the recording does not have
//! passes for led, and rightly: something gives what is missing. In noise the mean of the frames is the push,
//! if they differ by noise alone.
//!
//! Not without gravity, where a hand that moves evenly leaves no sign.

use glam::DVec3;

use super::impulse_fit::FitContact;
use super::kinematics::{Kinematics, go_over};

/// Frames in a row of one push, and frames beside an instant in which they are sought.
const ROW: usize = 3;
const REACH: usize = 5;
/// Least push, over gravity.
const LEAST: f64 = 0.3;
/// Share of a push, squared, from which contacts do not give it, and most sweeps over them.
const MISSING: f64 = 0.25;
const SWEEPS: usize = 50;

/// What pushes a body on one side of an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Side {
    /// No frames.
    Unknown,
    /// No steady push.
    Free,
    /// Acceleration beyond gravity [m/s²].
    Pushed(DVec3),
}

/// What pushes a body before an instant and after it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pushes {
    before: Side,
    after: Side,
}

/// A direction in which a contact pushes a body, with its friction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    pub(super) normal: DVec3,
    pub(super) friction: f64,
}

impl Reach {
    /// In which a contact pushes one of its bodies, by its place in their list.
    pub(super) fn of(contact: &FitContact, place: usize) -> Self {
        let sign = if contact.bodies[0] == place { 1.0 } else { -1.0 };
        Reach { normal: contact.normal * sign, friction: contact.friction }
    }
}

impl Pushes {
    /// Those around the frames `first` to `last`, which are left out.
    pub(super) fn around(kinematics: &Kinematics<'_>, first: usize, last: usize) -> Self {
        let end = kinematics.frames.len().saturating_sub(1);
        let before: Vec<usize> = (first.saturating_sub(REACH).max(1)..first.min(end)).rev().collect();
        let after: Vec<usize> = (last + 1..(last + 1 + REACH).min(end)).collect();
        Pushes { before: side(kinematics, &before), after: side(kinematics, &after) }
    }

    /// Whether something else than contacts pushes on both sides: those before the instant, and after it.
    pub(super) fn are_led(&self, before: &[Reach], after: &[Reach]) -> bool {
        let is_led = |side: Side, reaches: &[Reach]| match side {
            Side::Unknown => None,
            Side::Free => Some(false),
            Side::Pushed(push) => Some(!is_given(push, reaches)),
        };
        let known = [is_led(self.before, before), is_led(self.after, after)];
        known.contains(&Some(true)) && !known.contains(&Some(false))
    }

    /// Whether a steady push is known on one side, and none is missing on the other.
    pub(super) fn are_steady(&self) -> bool {
        let pushes = |side: Side| matches!(side, Side::Pushed(_));
        let is_free = [self.before, self.after].contains(&Side::Free);
        !is_free && (pushes(self.before) || pushes(self.after))
    }

    /// The mean of both sides [m/s²].
    pub(super) fn mean(&self) -> DVec3 {
        let known = |side: Side| if let Side::Pushed(push) = side { Some(push) } else { None };
        match (known(self.before), known(self.after)) {
            (Some(before), Some(after)) => 0.5 * (before + after),
            (one, other) => one.or(other).unwrap_or(DVec3::ZERO),
        }
    }
}

/// The push of the nearest frames in a row that go over into each other.
fn side(kinematics: &Kinematics<'_>, near: &[usize]) -> Side {
    if near.len() < ROW {
        return Side::Unknown;
    }
    let least = LEAST * kinematics.inertia.gravity.length();
    let pushes: Vec<DVec3> =
        near.iter().map(|k| kinematics.jumps[*k].velocity / kinematics.jumps[*k].span).collect();
    let goes_over = |pair: &[DVec3]| go_over(pair[0], pair[1]);
    let is_row = |row: &&[DVec3]| {
        least > 0.0 && row.iter().all(|push| push.length() > least) && row.windows(2).all(goes_over)
    };
    // In noise that hides what goes over into what, a push that is steady but for the noise.
    let (mean, noise) = (pushes.iter().sum::<DVec3>() / near.len() as f64, kinematics.noisy_jump());
    let spans = near.iter().map(|k| kinematics.jumps[*k].span);
    let is_noise = |(push, span): (&DVec3, f64)| push.distance(mean) * span < noise;
    if least > 0.0 && mean.length() > least && pushes.iter().zip(spans).all(is_noise) {
        return Side::Pushed(mean);
    }
    let row = pushes.windows(ROW).find(is_row);
    row.map_or(Side::Free, |row| Side::Pushed(row.iter().sum::<DVec3>() / ROW as f64))
}

/// Whether contacts can give a push, but for a share of it.
pub(super) fn is_given(push: DVec3, reaches: &[Reach]) -> bool {
    let (mut left, mut own) = (push, vec![DVec3::ZERO; reaches.len()]);
    for _ in 0..SWEEPS {
        for (own, reach) in own.iter_mut().zip(reaches) {
            let next = nearest_in_cone(*own + left, *reach);
            left -= next - *own;
            *own = next;
        }
        if left.length_squared() < MISSING * push.length_squared() {
            return true;
        }
    }
    false
}

/// The point of a friction cone that is nearest to a vector.
fn nearest_in_cone(vector: DVec3, Reach { normal, friction }: Reach) -> DVec3 {
    let along = vector.dot(normal);
    let tangent = vector - normal * along;
    let across = tangent.length();
    if across <= friction * along {
        return vector;
    }
    let edge = (along + friction * across) / (1.0 + friction * friction);
    if edge <= 0.0 { DVec3::ZERO } else { normal * edge + tangent * (friction * edge / across) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_floor_gives_a_weight_and_a_ball_on_top_does_not() {
        let reach = |normal: DVec3| Reach { normal, friction: 0.4 };
        assert!(is_given(DVec3::Y, &[reach(DVec3::NEG_Y), reach(DVec3::Y)]));
        assert!(!is_given(DVec3::Y, &[reach(DVec3::NEG_Y)]));
        assert!(!is_given(DVec3::Y, &[]));
        // A wall alone holds nothing, two jaws do by friction, and both sides of a notch.
        assert!(!is_given(DVec3::Y, &[reach(DVec3::X)]));
        assert!(is_given(DVec3::Y, &[reach(DVec3::X), reach(DVec3::NEG_X)]));
        let sides = [1.0, -1.0].map(|x| reach(DVec3::new(x, 0.3, 0.0).normalize()));
        assert!(is_given(DVec3::Y, &sides));
    }
}
