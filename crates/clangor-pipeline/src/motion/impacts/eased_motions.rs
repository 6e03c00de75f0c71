//! Bodies that a hand or a curve between keys starts or stops softly near a surface.
//!
//! With few frames a second, the soft stop of a cup that is set down is as sudden as an impact. But an impact
//! changes the motion of two frames, and a soft stop or start that of three or more:
//!
//! ```text
//! Dₖ·J/|J| ≥ |J|/10  in three frames in a row        D: change of the velocity of a frame
//! ```
//!
//! with J their sum over the frames of the jump. Impacts that follow each other do so too. What tells them
//! apart is who moves the body beside these frames: one in free flight, or on what it touches, is moved by
//! nobody; what no contact gives, a hand does.

use clangor_core::body::BodyId;
use glam::DVec3;

use super::Scene;
use super::reach::{TOUCHING, WIDEST};
use crate::motion::jump_windows::JumpWindow;
use crate::motion::kinematics::Kinematics;
use crate::motion::led_bodies::{Reach, is_given};
use crate::motion::touch::Touch;
use crate::motion::touching::touches;

/// Least part of a jump that a frame beside it goes on with, and frames from which it is no impact.
const GOES_ON: f64 = 0.1;
const FRAMES: usize = 3;
/// Frames on one side of them in which a hand moves the body, and its least push, over gravity.
const BESIDE: usize = 3;
const PUSHES: f64 = 0.3;
/// Factor on the gaps that count as touching, in poses between which a body rolls.
const WIDER: f64 = 4.0;
/// Shortest frame in which a soft stop is as sudden as an impact \[s\]: 100 Hz.
const SHORTEST: f64 = 0.01;

impl Scene<'_> {
    /// Whether a jump is that of a body which a hand starts or stops.
    pub(super) fn is_eased(&self, window: &JumpWindow) -> bool {
        let Some(kinematics) = &self.kinematics[window.body.index()] else { return false };
        if window.span < SHORTEST {
            return false;
        }
        let change =
            |k: usize| kinematics.jumps[k].velocity + kinematics.inertia.gravity * kinematics.jumps[k].span;
        let whole: DVec3 = (window.first.max(1)..=window.last).map(change).sum();
        let goes_on = |k: &usize| change(*k).dot(whole) >= GOES_ON * whole.length_squared();
        let end = kinematics.frames.len() - 1;
        let before = (1..window.first).rev().take_while(goes_on).count();
        let after = (window.last + 1..end).take_while(goes_on).count();
        if window.last + 1 - window.first + before + after < FRAMES {
            return false;
        }
        let (first, last) = (window.first - before, window.last + after);
        let is_led = |frames: Vec<usize>| {
            frames.len() == BESIDE
                && frames.into_iter().all(|k| self.is_moved_by_hand(window.body, kinematics, k))
        };
        is_led((1..first).rev().take(BESIDE).collect()) || is_led((last + 1..end).take(BESIDE).collect())
    }

    /// Whether something else than gravity and what a body touches moves it at a frame.
    fn is_moved_by_hand(&self, body: BodyId, kinematics: &Kinematics<'_>, k: usize) -> bool {
        let (jump, frame) = (&kinematics.jumps[k], &kinematics.frames[k]);
        let push = jump.velocity / jump.span;
        if push.length() <= PUSHES * kinematics.inertia.gravity.length() {
            return false;
        }
        let one = self.placed(body, frame.pose);
        let mut reaches = Vec::new();
        for other in self.neighbours.of_body(body.index()).filter(|id| !self.move_as_one(body, *id)) {
            let Some(pose) = self.pose_at(other, frame.time) else { continue };
            let two = self.placed(other, pose);
            let size = one.sampled.radius.min(two.sampled.radius);
            let way = TOUCHING.1 * kinematics.intervals[k].velocity.length() * jump.span;
            let within = (WIDER * (TOUCHING.0 * size + way + TOUCHING.2)).min(WIDEST * size);
            let friction = self.friction(body, other);
            let reach = |touch: Touch| Reach { normal: touch.normal, friction };
            reaches.extend(touches(one, two, within).into_iter().map(reach));
        }
        !is_given(push, &reaches)
    }
}
