//! Which jumps of a recorded body are impacts, and when they happened.
//!
//! A frame counts where its jump exceeds what noise, the threshold of sound and a steady support explain; all
//! but the first grow with the length of a frame:
//!
//! ```text
//! s > 0.2 v_min + 0.3 g h + 1.2 min(q, 1.5 g h) + 5 n        q: lower quartile of the jumps around
//! ```
//!
//! where n is the noise of the jump on one axis ([`pose_noise`](super)).
//!
//! An impact between two frames shares its jump J between them, Δₖ = (1 − f) J and Δₖ₊₁ = f J, where f is the
//! part of the frame that had passed: this is the instant in which the flights before and after meet. Jumps
//! of two frames are one impact where they have one direction; f follows from their projections on J.
//!
//! A support that holds the body before the impact (a hand) or after it (a table) pushes for a part of both
//! frames, and what it gives is no impact. With its pushes B and A in a whole frame,
//!
//! ```text
//! Δₖ   = (1 − f) J + (1 − (1 − f)²/2) B + (1 − f)²/2 A
//! Δₖ₊₁ = f J       + f²/2 B             + (1 − f²/2) A
//! ```
//!
//! A body that is at rest in its first frame and hits before the second has no frame before it: Δ₀ is its
//! jump at a release ([`Kinematics::release`]), and B = 0. Steady forces look alike there, and whether it has
//! fallen is asked where the surfaces are known (`impacts/releases.rs`). Where they say f as well, Δ₀ alone
//! says J of a body that hits again before the third frame.
//!
//! Impacts in frames that follow each other share a jump, and are told apart by their directions:
//!
//! ```text
//! two:    Δ₂ = α Δ₁ + β Δ₃                  J = (1 + α) Δ₁, (1 + β) Δ₃
//! three:  Δ₃ = β Δ₄ + γ Δ₂ − γ α Δ₁         and (1 + γ)(Δ₂ − α Δ₁) between them        α, β, γ ≥ 0
//! ```

use std::ops::Range;

use clangor_core::body::BodyId;
use glam::{DMat3, DVec3};

use super::kinematics::{Jump, Kinematics, Start, go_over};
use super::steady_pushes::{LEAST_PUSH, STEADY, is_of_pushes, lasts, leaves_steady_push};

/// Frames on both sides that show whether a jump is steady.
const NEIGHBOURS: usize = 5;
/// Frames in a row that have the force of lasting contact, and the longest time of these frames \[s\].
const ROW: usize = 5;
const LASTING: f64 = 0.01;
/// Frames in a row whose push is the weight, from which something holds the body.
const CARRIED: usize = 4;
/// Mean speed in the first frame, over that of free fall, from which a body is not supported there.
const MOVES: f64 = 0.05;
/// Deviations of the noise on one axis that no jump of noise has: one in 60 000 has more.
pub(super) const CLEAR_OF_NOISE: f64 = 5.0;
/// Cosine between two jumps from which they are one.
const SAME_DIRECTION: f64 = 0.9;
/// Unexplained share of the energy of a jump up to which it is shared by two impacts.
const UNEXPLAINED: f64 = 0.05;
/// Weight of the rotation where directions of jumps are compared.
const TURNING_WEIGHT: f64 = 0.05;
/// Determinant of a matrix of products over that of its diagonal from which directions differ.
const SINGULAR: f64 = 1e-9;
/// Least share from which a whole jump is computed, and largest difference of the other share from it, over
/// the jump, of a body that stays where it lands.
const LEAST_SHARE: f64 = 0.03;
const AGREES: f64 = 0.02;
/// Largest ratio of the two shares of an impact.
const LARGEST_RATIO: f64 = 30.0;
/// The same for a jump that is small against its neighbour, whose direction is uncertain.
const SMALL_SAME_DIRECTION: f64 = 0.5;

/// Largest jump of a frame beside an impact, and largest rest of the shares of its own frames, over that of
/// the impact, at which it is clean.
const QUIET: f64 = 0.07;

/// Steps to the part of a frame at which an impact of a supported body happens, and the change at which they
/// end.
const PART_STEPS: usize = 40;
const PART_CHANGE: f64 = 1e-9;

/// An impact seen by one body.
#[derive(Clone, Copy, Debug)]
pub(super) struct JumpWindow {
    pub(super) body: BodyId,
    /// First frame with a share.
    pub(super) first: usize,
    /// Last frame with a share: the same or the next.
    pub(super) last: usize,
    /// Instant \[s\].
    pub(super) time: f64,
    /// Length of the frame around it \[s\].
    pub(super) span: f64,
    /// Jump of the velocity [m/s].
    pub(super) velocity: DVec3,
    /// Jump of the angular momentum [kg m²/s].
    pub(super) angular_momentum: DVec3,
    /// Whether its frames have nothing but this impact, so that the jump is exact.
    pub(super) is_clean: bool,
}

/// The impacts of a body, in order of time; `v_min` is the threshold of sound, `noise` the deviation of Δv on
/// one axis that is noise [m/s].
pub(super) fn jump_windows(
    body: BodyId,
    kinematics: &Kinematics<'_>,
    (v_min, noise): (f64, f64),
) -> Vec<JumpWindow> {
    let clear = 0.2 * v_min + CLEAR_OF_NOISE * noise;
    let run = Run { body, kinematics, hits: hits(kinematics, clear) };
    let mut windows: Vec<JumpWindow> = run.of_release(clear).into_iter().collect();
    let mut k = 1 + windows.len();
    while k + 1 < kinematics.frames.len() {
        if !run.is_hit(k) {
            k += 1;
            continue;
        }
        let before = windows.last().map_or(0, |window| window.last);
        // Longer runs are taken apart like those of four.
        let length = (k..k + 4).take_while(|frame| run.is_hit(*frame)).count();
        let (found, frames) = run.first_impacts(k, length, before);
        windows.extend(found);
        k += frames;
    }
    for window in &mut windows {
        window.is_clean = run.is_clean(window);
    }
    windows
}

/// A body and which of its frames count.
struct Run<'a> {
    body: BodyId,
    kinematics: &'a Kinematics<'a>,
    hits: Vec<bool>,
}

impl Run<'_> {
    fn is_hit(&self, k: usize) -> bool {
        self.hits.get(k).copied().unwrap_or(false)
    }

    /// The impact in the first frame of a body that is released at rest there: its two shares have one
    /// direction. A support in the frames after it does not hide it, as a supported body does not move.
    fn of_release(&self, clear: f64) -> Option<JumpWindow> {
        let kinematics = self.kinematics;
        if kinematics.start == Start::Carried {
            return None;
        }
        let (first, second) = (kinematics.release, *kinematics.left.get(1)?);
        let dot = |a: &Jump, b: &Jump| product(kinematics, 0, a, b);
        let squares = dot(&first, &first) * dot(&second, &second);
        let gravity = kinematics.inertia.gravity.length();
        let starts = kinematics.intervals[0].velocity.length() > MOVES * gravity * first.span;
        let is_hit =
            self.is_hit(1) || starts && second.size > unsupported_threshold(clear, gravity * second.span);
        if !is_hit || dot(&first, &second) <= SAME_DIRECTION * squares.sqrt() {
            return None;
        }
        let shares = [first, second];
        let support = Support { before: Jump::default(), after: Support::held(kinematics, 2, 3) };
        Some(match kinematics.start {
            Start::Falls(part) => self.landing(part, &shares, &support),
            // What rests solves the shares too, with f = 0 and J = 0: the search begins at the other end.
            _ => self.split((0, 1), shares, &support, 1.0),
        })
    }

    /// The impact of a fall that ends after a known part of the first frame.
    fn landing(&self, part: f64, shares: &[Jump; 2], support: &Support) -> JumpWindow {
        let part = part.clamp(0.0, 1.0);
        let early = 1.0 - part;
        if early < LEAST_SHARE {
            return self.shared(0, sum(&shares[0], &shares[1]), part);
        }
        let square = |jump: &Jump| product(self.kinematics, 0, jump, jump);
        let pushes = support.pushes(part);
        let left = [0, 1].map(|k| sum(&shares[k], &scaled(&pushes[k], -1.0)));
        let rests = scaled(&left[0], early.recip());
        let rest = sum(&left[1], &scaled(&rests, -part));
        // What does not stay where it lands flies, and may hit again before the third frame.
        let stays = square(&rest) < AGREES * AGREES * square(&rests);
        self.shared(0, if stays { rests } else { scaled(&shares[0], early.recip()) }, part)
    }

    /// The first impacts of a run of frames that count, and how many of its frames they take; `before` is the
    /// last frame of the impact before.
    fn first_impacts(&self, k: usize, length: usize, before: usize) -> (Vec<JumpWindow>, usize) {
        let is_one = |k: usize| self.cosine_of_shares(k) > SAME_DIRECTION;
        match length {
            0 | 1 => {}
            _ if is_one(k) => return (vec![self.window(k, k + 1)], 2),
            2 => {}
            3 => {
                if let Some(found) = self.two_impacts(k) {
                    return (found.into(), 3);
                }
            }
            _ => {
                if let Some(found) = self.three_impacts(k) {
                    return (found.into(), 4);
                }
                if let Some(found) = self.two_impacts(k) {
                    return (found.into(), 3);
                }
            }
        }
        (vec![self.single(k, before)], 1)
    }

    /// Cosine between the jumps of a frame and the next, as they are or beyond what holds the body there,
    /// whichever is larger.
    fn cosine_of_shares(&self, k: usize) -> f64 {
        let kinematics = self.kinematics;
        let whole = cosine(kinematics, k, k + 1);
        let (Some(early), Some(late)) = (kinematics.left.get(k), kinematics.left.get(k + 1)) else {
            return whole;
        };
        let pushes = Support::around(kinematics, k, k + 1).pushes(0.5);
        let [a, b] =
            [(early, &pushes[0]), (late, &pushes[1])].map(|(jump, push)| sum(jump, &scaled(push, -1.0)));
        let dot = |a: &Jump, b: &Jump| product(kinematics, k, a, b);
        let squares = dot(&a, &a) * dot(&b, &b);
        if squares > 0.0 { whole.max(dot(&a, &b) / squares.sqrt()) } else { whole }
    }

    /// An impact near one frame, with the share below the threshold that a neighbour may have.
    fn single(&self, k: usize, before: usize) -> JumpWindow {
        let share = |other: usize| {
            let is_free = other > before && other > 0 && other + 1 < self.kinematics.frames.len();
            let joins =
                is_free && !self.is_hit(other) && cosine(self.kinematics, k, other) > SMALL_SAME_DIRECTION;
            if joins { self.kinematics.left[other].size } else { 0.0 }
        };
        let (earlier, later) = (share(k - 1), share(k + 1));
        match (earlier, later) {
            _ if later > earlier => self.window(k, k + 1),
            _ if earlier > 0.0 => self.window(k - 1, k),
            _ => self.window(k, k),
        }
    }

    /// Two impacts in the two intervals between three frames.
    fn two_impacts(&self, k: usize) -> Option<[JumpWindow; 2]> {
        let [first, middle, last] = [k, k + 1, k + 2].map(|k| self.kinematics.left[k]);
        let [alpha, beta] = self.combination(k, &middle, [&first, &last])?;
        Some([
            self.shared(k, scaled(&first, 1.0 + alpha), alpha / (1.0 + alpha)),
            self.shared(k + 1, scaled(&last, 1.0 + beta), 1.0 / (1.0 + beta)),
        ])
    }

    /// Three impacts in the three intervals between four frames.
    fn three_impacts(&self, k: usize) -> Option<[JumpWindow; 3]> {
        let [one, two, three, four] = [k, k + 1, k + 2, k + 3].map(|k| self.kinematics.left[k]);
        let [beta, gamma, delta] = self.combination(k, &three, [&four, &two, &scaled(&one, -1.0)])?;
        let alpha = if gamma > 0.0 { delta / gamma } else { return None };
        let rest = sum(&two, &scaled(&one, -alpha));
        Some([
            self.shared(k, scaled(&one, 1.0 + alpha), alpha / (1.0 + alpha)),
            self.shared(k + 1, scaled(&rest, 1.0 + gamma), gamma / (1.0 + gamma)),
            self.shared(k + 2, scaled(&four, 1.0 + beta), 1.0 / (1.0 + beta)),
        ])
    }

    /// Factors of `parts` that sum to `whole`, by least squares; `None` if one is negative, too large for a
    /// share, or the rest too large.
    fn combination<const N: usize>(&self, k: usize, whole: &Jump, parts: [&Jump; N]) -> Option<[f64; N]> {
        let dot = |a: &Jump, b: &Jump| product(self.kinematics, k + 1, a, b);
        // Two factors are the first two of three.
        let (mut matrix, mut right) = (DMat3::IDENTITY, DVec3::ZERO);
        for (i, one) in parts.into_iter().enumerate() {
            right[i] = dot(one, whole);
            for (j, other) in parts.into_iter().enumerate() {
                matrix.col_mut(j)[i] = dot(one, other);
            }
        }
        let scale: f64 = (0..3).map(|i| matrix.col(i)[i]).product();
        if matrix.determinant() <= SINGULAR * scale {
            return None;
        }
        let solution = matrix.inverse() * right;
        let factors: [f64; N] = std::array::from_fn(|i| solution[i]);
        let made = parts
            .iter()
            .zip(factors)
            .fold(Jump::default(), |all, (part, factor)| sum(&all, &scaled(part, factor)));
        let rest = sum(whole, &scaled(&made, -1.0));
        let is_share = factors.iter().all(|factor| (0.0..LARGEST_RATIO).contains(factor));
        (is_share && dot(&rest, &rest) < UNEXPLAINED * dot(whole, whole)).then_some(factors)
    }

    /// An impact in the interval after frame `k`, after a part of it.
    fn shared(&self, k: usize, jump: Jump, part: f64) -> JumpWindow {
        let span = self.kinematics.intervals[k].length;
        JumpWindow {
            body: self.body,
            first: k,
            last: k + 1,
            time: self.kinematics.frames[k].time + span * part,
            span,
            velocity: jump.velocity,
            angular_momentum: jump.angular_momentum,
            is_clean: false,
        }
    }

    /// Whether the frames around an impact are quiet, and both of its own have the shares of one jump.
    fn is_clean(&self, window: &JumpWindow) -> bool {
        let JumpWindow { first, last, velocity, angular_momentum, .. } = *window;
        let (kinematics, left) = (self.kinematics, &self.kinematics.left);
        let whole = Jump { velocity, angular_momentum, ..Jump::default() };
        let square = |jump: &Jump| product(kinematics, first, jump, jump);
        let most = QUIET * QUIET * square(&whole);
        let is_quiet =
            |k: usize| left.get(k).is_none_or(|jump| square(jump) <= most) || kinematics.is_held(k);
        if first > 0 && !is_quiet(first - 1) || !is_quiet(last + 1) {
            return false;
        }
        let part = (window.time - kinematics.frames[first].time) / window.span;
        let rest = |k: usize, share: f64| square(&sum(&left[k], &scaled(&whole, -share)));
        last == first || first > 0 && rest(first, 1.0 - part) + rest(last, part) <= most
    }

    /// An impact with shares at one frame or two, without what a support gives there.
    fn window(&self, first: usize, last: usize) -> JumpWindow {
        let kinematics = self.kinematics;
        let late = if last > first { kinematics.left[last] } else { Jump::default() };
        let support = Support::around(kinematics, first, last);
        self.split((first, last), [kinematics.left[first], late], &support, 0.0)
    }

    /// The same of these shares; `part` of the frame is where its instant is sought first.
    fn split(
        &self,
        (first, last): (usize, usize),
        [early, late]: [Jump; 2],
        support: &Support,
        mut part: f64,
    ) -> JumpWindow {
        let whole = sum(&early, &late);
        let dot = |a: &Jump, b: &Jump| product(self.kinematics, first, a, b);
        let mut jump = whole;
        for _ in 0..PART_STEPS {
            let pushes = support.pushes(part);
            let given = if last > first { sum(&pushes[0], &pushes[1]) } else { pushes[0] };
            jump = sum(&whole, &scaled(&given, -1.0));
            let size = dot(&jump, &jump);
            if last == first || size <= 0.0 {
                break;
            }
            let next = (dot(&sum(&late, &scaled(&pushes[1], -1.0)), &jump) / size).clamp(0.0, 1.0);
            let change = (next - part).abs();
            part = next;
            if change < PART_CHANGE || support.is_none() {
                break;
            }
        }
        JumpWindow { last, ..self.shared(first, jump, part) }
    }
}

/// What holds a body before and after an impact: its pushes in a whole frame.
struct Support {
    before: Jump,
    after: Jump,
}

impl Support {
    fn around(kinematics: &Kinematics<'_>, first: usize, last: usize) -> Self {
        let held = |k: usize, beyond: usize| Support::held(kinematics, k, beyond);
        Support { before: held(first - 1, first.saturating_sub(2)), after: held(last + 1, last + 2) }
    }

    /// The push at a frame if it is the weight there and at the one beyond, or another one that lasts; in
    /// noise, the weight.
    fn held(kinematics: &Kinematics<'_>, k: usize, beyond: usize) -> Jump {
        let (push, weight) =
            (kinematics.jumps[k].velocity, -kinematics.inertia.gravity * kinematics.jumps[k].span);
        if !(kinematics.is_held_in_noise(k) && kinematics.is_held_in_noise(beyond)) {
            let lasts = lasts(kinematics, k, beyond);
            return Jump { velocity: if lasts { push } else { DVec3::ZERO }, ..Jump::default() };
        }
        let is_clear = kinematics.noisy_jump() < STEADY * weight.length();
        Jump { velocity: if is_clear { push } else { weight }, ..Jump::default() }
    }

    fn is_none(&self) -> bool {
        self.before.velocity == DVec3::ZERO && self.after.velocity == DVec3::ZERO
    }

    /// Its part of the jumps of both frames, around an impact after this part of the frame between them.
    fn pushes(&self, part: f64) -> [Jump; 2] {
        let (early, late) = (0.5 * (1.0 - part).powi(2), 0.5 * part.powi(2));
        [(1.0 - early, early), (late, 1.0 - late)]
            .map(|(before, after)| sum(&scaled(&self.before, before), &scaled(&self.after, after)))
    }
}

fn scaled(jump: &Jump, factor: f64) -> Jump {
    let (velocity, angular_momentum) = (jump.velocity * factor, jump.angular_momentum * factor);
    Jump { velocity, angular_momentum, ..*jump }
}

fn sum(a: &Jump, b: &Jump) -> Jump {
    Jump {
        velocity: a.velocity + b.velocity,
        angular_momentum: a.angular_momentum + b.angular_momentum,
        ..*a
    }
}

/// Which frames count. What a jump has over the first two terms exceeds 1.2 q where more than a quarter of
/// the jumps around are smaller than a 1.2th of it, which needs no sorting.
fn hits(kinematics: &Kinematics<'_>, clear: f64) -> Vec<bool> {
    let (jumps, g) = (&kinematics.left, kinematics.inertia.gravity.length());
    let sizes: Vec<f64> = jumps.iter().map(|jump| jump.size).collect();
    let is_hit = |k: usize| {
        let fall = g * jumps[k].span;
        let excess = (jumps[k].size - unsupported_threshold(clear, fall)) / 1.2;
        if excess <= 0.0 || excess > 1.5 * fall {
            return excess > 0.0;
        }
        let low = k.saturating_sub(NEIGHBOURS).max(1);
        let high = (k + NEIGHBOURS + 1).min(jumps.len().saturating_sub(1));
        let around = sizes.get(low..high).unwrap_or_default();
        let stands_out = || around.iter().filter(|size| **size < excess).count() > around.len() / 4;
        around.is_empty()
            || stands_out()
            || leaves_steady_push(jumps, k, (unsupported_threshold(clear, fall), fall))
    };
    // What rests or is carried for so many frames is no impact, where it has just begun.
    let is_carried =
        |k: usize| (k..k + CARRIED).all(|frame| frame + 1 >= jumps.len() || kinematics.is_held(frame));
    let is_none = |k: usize| is_carried(k) || is_lasting(jumps, k, g) || is_of_pushes(jumps, k, g);
    (0..jumps.len()).map(|k| is_hit(k) && !is_none(k)).collect()
}

/// Whether a jump is within a row of five that go over into each other, within 10 ms: a force that lasts, as
/// under a body that rolls or spins. An impact at this rate is over within two frames, before which and after
/// which the body flies or has its weight alone.
fn is_lasting(jumps: &[Jump], k: usize, gravity: f64) -> bool {
    let is_short = |row: Range<usize>| jumps[row].iter().map(|jump| jump.span).sum::<f64>() <= LASTING;
    lasting_rows(jumps, k, gravity).any(is_short)
}

/// The rows of frames around a frame whose pushes go over into each other.
pub(super) fn lasting_rows(jumps: &[Jump], k: usize, gravity: f64) -> impl Iterator<Item = Range<usize>> {
    let goes_over = |pair: &[Jump]| go_over(pair[0].velocity, pair[1].velocity);
    let pushes = move |jump: &Jump| jump.velocity.length() > LEAST_PUSH * gravity * jump.span;
    let is_row = move |row: &Range<usize>| {
        let around = jumps.get(row.clone()).unwrap_or_default();
        !around.is_empty() && around.iter().all(pushes) && around.windows(2).all(goes_over)
    };
    (k.saturating_sub(ROW - 2)..k).map(|first| first..first + ROW).filter(is_row)
}

/// Jump from which a frame counts where nothing supports the body [m/s]; `clear` is what sound and noise
/// demand, `fall` is g h [m/s].
fn unsupported_threshold(clear: f64, fall: f64) -> f64 {
    clear + 0.3 * fall
}

/// Product of two jumps [m²/s²]. Velocities have the direction of the impulse; the rotation in a frame with
/// an impact is exact only for small angles, and tells apart what velocities cannot.
fn product(kinematics: &Kinematics<'_>, at: usize, a: &Jump, b: &Jump) -> f64 {
    let inverse = kinematics.inertia.inverse_at(kinematics.frames[at].pose.orientation);
    let turning = a.angular_momentum.dot(inverse * b.angular_momentum) / kinematics.inertia.mass;
    a.velocity.dot(b.velocity) + TURNING_WEIGHT * turning
}

fn cosine(kinematics: &Kinematics<'_>, k: usize, other: usize) -> f64 {
    let (Some(a), Some(b)) = (kinematics.left.get(k), kinematics.left.get(other)) else { return 0.0 };
    let square = product(kinematics, k, a, a) * product(kinematics, k, b, b);
    if square > 0.0 { product(kinematics, k, a, b) / square.sqrt() } else { 0.0 }
}
