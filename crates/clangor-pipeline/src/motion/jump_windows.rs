//! Which jumps of a recorded body are impacts, and when they happened.
//!
//! A frame counts where its jump exceeds what noise, the threshold of sound and a steady support explain; all
//! but the first grow with the length of a frame:
//!
//! ```text
//! s > 0.2 v_min + 0.3 g h + 1.2 min(q, 1.5 g h)        q: lower quartile of the jumps around
//! ```
//!
//! An impact between two frames shares its jump J between them, Δₖ = (1 − f) J and Δₖ₊₁ = f J, where f is the
//! part of the frame that had passed: this is the instant in which the flights before and after meet. Jumps of
//! two frames are one impact where they have one direction; f follows from their projections on J.

use clangor_core::body::BodyId;
use glam::DVec3;

use super::kinematics::{Jump, Kinematics};

/// Frames on both sides from which a steady jump is told.
const NEIGHBOURS: usize = 5;
/// Cosine between two jumps from which they are one.
const SAME_DIRECTION: f64 = 0.9;
/// The same for a jump that is small against its neighbour, whose direction is uncertain.
const SMALL_SAME_DIRECTION: f64 = 0.5;

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
}

/// The impacts of a body, in order of time.
pub(super) fn jump_windows(body: BodyId, kinematics: &Kinematics<'_>, v_min: f64) -> Vec<JumpWindow> {
    let thresholds = thresholds(kinematics, v_min);
    let is_hit = |k: usize| kinematics.jumps.get(k).is_some_and(|jump| jump.size > thresholds[k]);
    let mut windows: Vec<JumpWindow> = Vec::new();
    let mut k = 1;
    while k + 1 < kinematics.frames.len() {
        if !is_hit(k) {
            k += 1;
            continue;
        }
        let before = windows.last().map_or(0, |window| window.last);
        // A share below the threshold lies before the frame only if that frame belongs to no other impact.
        let joins = |other: usize| {
            let cosine = cosine(kinematics, k, other);
            let limit = if is_hit(other) { SAME_DIRECTION } else { SMALL_SAME_DIRECTION };
            other > before && other + 1 < kinematics.frames.len() && cosine > limit
        };
        let later = joins(k + 1);
        let earlier = k > 1 && !is_hit(k - 1) && joins(k - 1);
        let share = |other: usize| kinematics.jumps[other].size;
        let (first, last) = match (earlier, later) {
            (true, true) if share(k - 1) > share(k + 1) && !is_hit(k + 1) => (k - 1, k),
            (_, true) => (k, k + 1),
            (true, false) => (k - 1, k),
            (false, false) => (k, k),
        };
        windows.push(window(body, kinematics, first, last));
        k = last + 1;
    }
    windows
}

fn thresholds(kinematics: &Kinematics<'_>, v_min: f64) -> Vec<f64> {
    let (jumps, g) = (&kinematics.jumps, kinematics.inertia.gravity.length());
    (0..jumps.len())
        .map(|k| {
            let fall = g * jumps[k].span;
            let low = k.saturating_sub(NEIGHBOURS).max(1);
            let high = (k + NEIGHBOURS + 1).min(jumps.len().saturating_sub(1));
            let mut around: Vec<f64> =
                jumps.get(low..high).unwrap_or_default().iter().map(|j| j.size).collect();
            around.sort_by(f64::total_cmp);
            let quartile = around.get(around.len() / 4).copied().unwrap_or(0.0);
            0.2 * v_min + 0.3 * fall + 1.2 * quartile.min(1.5 * fall)
        })
        .collect()
}

/// Product of two jumps in the metric of energy per mass [m²/s²].
fn product(kinematics: &Kinematics<'_>, at: usize, a: &Jump, b: &Jump) -> f64 {
    let inverse = kinematics.inertia.inverse_at(kinematics.frames[at].pose.orientation);
    a.velocity.dot(b.velocity)
        + a.angular_momentum.dot(inverse * b.angular_momentum) / kinematics.inertia.mass
}

fn cosine(kinematics: &Kinematics<'_>, k: usize, other: usize) -> f64 {
    let (Some(a), Some(b)) = (kinematics.jumps.get(k), kinematics.jumps.get(other)) else { return 0.0 };
    let size = a.size * b.size;
    if size > 0.0 { product(kinematics, k, a, b) / size } else { 0.0 }
}

fn window(body: BodyId, kinematics: &Kinematics<'_>, first: usize, last: usize) -> JumpWindow {
    let jumps = &kinematics.jumps;
    let (mut sum, span) = (jumps[first], kinematics.intervals[first].length);
    let mut time = kinematics.frames[first].time;
    if last > first {
        let late = jumps[last];
        sum.velocity += late.velocity;
        sum.angular_momentum += late.angular_momentum;
        let whole = product(kinematics, first, &sum, &sum);
        let part = if whole > 0.0 { product(kinematics, first, &late, &sum) / whole } else { 0.0 };
        time += span * part.clamp(0.0, 1.0);
    }
    let Jump { velocity, angular_momentum, .. } = sum;
    JumpWindow { body, first, last, time, span, velocity, angular_momentum }
}
