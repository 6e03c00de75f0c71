//! What lasting contact does to a recorded body at each frame: its change of motion beyond gravity and
//! impacts.
//!
//! ```text
//! Δv′ₖ = vₖ − vₖ₋₁ − g h − Σ J sₖ / m        ΔL′ₖ = Lₖ − Lₖ₋₁ − Σ (r × J) sₖ
//! an impact J at a part f of the frame from k to k + 1:   sₖ = 1 − f,  sₖ₊₁ = f
//! ```
//!
//! With this, the impulses of impacts and of lasting contact sum to the change of momentum beyond gravity.
//! What an impact leaves in its two frames is shared evenly by them, and by the frames beside them if it
//! still opposes the impact: the instant is then known to a frame only.
//!
//! - **Rest.** A body none of whose surface moves farther than 25 µm within 25 ms, which is 1 mm/s, or eight
//!   deviations of the noise of its positions, rests: it has −g h and no ΔL, and no noise of its poses is
//!   left.
//! - **Noise.** Noise s of Δv is reduced to 1 % of g h where it exceeds that: Δv′ and ΔL′ become means over
//!   triangles of a half-width of m = √(s / 0.01 g h) frames, as if the poses came every m frames. Then
//!   forces that change within 2 m frames are not told from noise, and not heard.

use glam::DVec3;

use super::kinematics::{Jump, Kinematics};

/// Surface speed below which a body rests [m/s], as in the renderer of force streams.
const REST_SPEED: f64 = 1e-3;
/// Time before and after a frame in which it does \[s\]: half of the time of which renderers take the mean.
const REST_TIME: f64 = 0.025;
/// Deviations of the noise of positions that are no motion.
const NOISE_REACH: f64 = 8.0;
/// Noise that is left, over g h.
const QUIET: f64 = 0.01;
/// A remainder that opposes its impact by more than this, over g h, is shared with more frames.
const OPPOSED: f64 = 0.1;

/// Change of motion at a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct LastingJump {
    /// Δv′ [m/s].
    pub(super) velocity: DVec3,
    /// ΔL′ [kg m²/s].
    pub(super) angular_momentum: DVec3,
    /// Time in which it happens \[s\].
    pub(super) span: f64,
    /// Whether it is that of a body at rest.
    pub(super) is_rest: bool,
}

/// What an impact gives to a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Push {
    /// \[s\].
    pub(super) time: f64,
    /// [N s].
    pub(super) impulse: DVec3,
    /// About the centre of mass [N m s].
    pub(super) moment: DVec3,
}

/// A recorded body as its lasting contacts need it.
#[derive(Clone, Copy)]
pub(super) struct RecordedMotion<'a> {
    pub(super) kinematics: &'a Kinematics<'a>,
    /// Bounding radius \[m\].
    pub(super) reach: f64,
    /// Deviation of Δv on one axis that is noise [m/s].
    pub(super) noise: f64,
}

/// The change at each frame; none at the first and the last.
pub(super) fn lasting_jumps(motion: RecordedMotion<'_>, pushes: &[Push]) -> Vec<LastingJump> {
    let kinematics = motion.kinematics;
    let last = kinematics.frames.len().saturating_sub(1);
    let mut jumps = vec![LastingJump::default(); last + 1];
    for (k, jump) in jumps.iter_mut().enumerate().take(last).skip(1) {
        let Jump { velocity, angular_momentum, span, .. } = kinematics.jumps[k];
        *jump = LastingJump { velocity, angular_momentum, span, is_rest: false };
    }
    let is_hit = without_impacts(&mut jumps, kinematics, pushes);
    let gravity = kinematics.inertia.gravity;
    for k in (1..last).filter(|k| !is_hit[*k]) {
        if rests(motion, k) {
            let velocity = -gravity * jumps[k].span;
            jumps[k] = LastingJump { velocity, angular_momentum: DVec3::ZERO, is_rest: true, ..jumps[k] };
        }
    }
    let half_width = jumps.get(1).map_or(1, |jump| half_width(motion.noise, gravity.length(), jump.span));
    if half_width > 1 { smoothed(&jumps, half_width) } else { jumps }
}

/// Takes the shares of impacts away. Returns which frames had one.
fn without_impacts(jumps: &mut [LastingJump], kinematics: &Kinematics<'_>, pushes: &[Push]) -> Vec<bool> {
    let last = jumps.len().saturating_sub(1);
    let mut taken = vec![DVec3::ZERO; jumps.len()];
    let mut is_hit = vec![false; jumps.len()];
    for push in pushes.iter().filter(|push| kinematics.is_recorded_at(push.time)) {
        let Some(index) = kinematics.interval_at(push.time) else { continue };
        let part = (push.time - kinematics.frames[index].time) / kinematics.intervals[index].length;
        let part = part.clamp(0.0, 1.0);
        for (k, share) in [(index, 1.0 - part), (index + 1, part)] {
            // The first frame and the last have no change that is known.
            if share > 0.0 && k > 0 && k < last {
                jumps[k].velocity -= push.impulse * (share / kinematics.inertia.mass);
                jumps[k].angular_momentum -= push.moment * share;
                taken[k] += push.impulse * share;
                is_hit[k] = true;
            }
        }
    }
    let fall = kinematics.inertia.gravity.length();
    let mut from = 1;
    while let Some(first) = (from..last).find(|k| is_hit[*k]) {
        let end = (first..last).find(|k| !is_hit[*k]).unwrap_or(last);
        let along = taken[first..end].iter().sum::<DVec3>().normalize_or_zero();
        for wider in 0..3 {
            let (low, high) = (first.saturating_sub(wider).max(1), (end + wider).min(last));
            if share_evenly(&mut jumps[low..high]).dot(along) >= -OPPOSED * fall {
                break;
            }
        }
        from = end;
    }
    is_hit
}

/// Gives each of these frames the same change in the same time. Returns the acceleration [m/s²].
fn share_evenly(jumps: &mut [LastingJump]) -> DVec3 {
    let span: f64 = jumps.iter().map(|jump| jump.span).sum();
    if span <= 0.0 {
        return DVec3::ZERO;
    }
    let acceleration = jumps.iter().map(|jump| jump.velocity).sum::<DVec3>() / span;
    let torque = jumps.iter().map(|jump| jump.angular_momentum).sum::<DVec3>() / span;
    for jump in jumps {
        jump.velocity = acceleration * jump.span;
        jump.angular_momentum = torque * jump.span;
    }
    acceleration
}

/// Whether the surface of a body stays where it is around a frame.
fn rests(RecordedMotion { kinematics, reach, noise }: RecordedMotion<'_>, k: usize) -> bool {
    let frames = kinematics.frames;
    let here = frames[k];
    // Δv has √6 σ/h.
    let deviation = noise * kinematics.jumps[k].span / 6.0_f64.sqrt();
    let stays = |other: usize| {
        let (time, pose) = (frames[other].time, frames[other].pose);
        let (from, to) = (here.pose.orientation, pose.orientation);
        // Of a small rotation, the angle is twice the distance of the quaternions.
        let angle = 2.0 * (from - to).length().min((from + to).length());
        let way = here.pose.position.distance(pose.position) + angle * reach;
        way < REST_SPEED * REST_TIME.max((time - here.time).abs()) + NOISE_REACH * deviation
    };
    let low = frames[..k].partition_point(|frame| frame.time < here.time - REST_TIME).min(k - 1);
    let high = k + frames[k..].partition_point(|frame| frame.time <= here.time + REST_TIME);
    let high = high.max(k + 2).min(frames.len());
    // What moves has moved farthest at the ends.
    (low..k).all(stays) && (k + 1..high).rev().all(stays)
}

/// Half-width of the triangle over which changes are averaged, in frames of this length \[s\].
fn half_width(noise: f64, gravity: f64, length: f64) -> usize {
    let (heard, longest) = (QUIET * gravity * length, 2.0 * REST_TIME / length);
    if noise <= heard || heard <= 0.0 {
        return 1;
    }
    (noise / heard).sqrt().ceil().min(longest.floor()).max(1.0) as usize
}

/// Spreads the change of each frame over those within a half-width that do not rest, so that sums stay.
fn smoothed(jumps: &[LastingJump], half_width: usize) -> Vec<LastingJump> {
    let still = |jump: &LastingJump| jump.is_rest || jump.span == 0.0;
    let clear = |jump: &LastingJump| match still(jump) {
        true => *jump,
        false => LastingJump { velocity: DVec3::ZERO, angular_momentum: DVec3::ZERO, ..*jump },
    };
    let mut spread: Vec<LastingJump> = jumps.iter().map(clear).collect();
    for (k, jump) in jumps.iter().enumerate().filter(|(_, jump)| !still(jump)) {
        let near = k.saturating_sub(half_width - 1)..(k + half_width).min(jumps.len());
        let weight = |other: usize| (half_width - k.abs_diff(other)) as f64;
        let near = || near.clone().filter(|other| !still(&jumps[*other]));
        let whole: f64 = near().map(weight).sum();
        for other in near() {
            spread[other].velocity += jump.velocity * (weight(other) / whole);
            spread[other].angular_momentum += jump.angular_momentum * (weight(other) / whole);
        }
    }
    spread
}
