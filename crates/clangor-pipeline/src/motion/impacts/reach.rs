//! Which surfaces are so near to each other around an instant that they may touch.
//!
//! Frames leave the instant of an impact uncertain, and with it how far apart the surfaces are by then. What
//! an impact sets in motion comes farther than its frames show: in a row of balls with small gaps, each hits
//! the next one within the frame, and is at rest again by its end.

use clangor_core::body::BodyId;
use clangor_core::pose::Pose;

use super::{Member, Scene};
use crate::motion::touch::Touch;
use crate::motion::touching::{Placed, may_touch, touches};

/// Gaps that count as touching: a share of the smaller body, a share of the way in a frame, and the digits of
/// 32-bit files \[m\].
pub(super) const TOUCHING: (f64, f64, f64) = (0.003, 0.03, 2e-5);
/// Largest gap of all, as a share of the smaller body.
pub(super) const WIDEST: f64 = 0.3;

/// What says how far apart the surfaces of an event may be.
pub(super) struct Nearness {
    /// Length of a frame \[s\].
    pub(super) span: f64,
    /// Factor on the least gap.
    pub(super) factor: f64,
    /// Speed that the body may have within the frame beyond what its frames show [m/s].
    pub(super) impact: f64,
}

impl Scene<'_> {
    /// Whether a body comes near a member around an instant: a cheap test of balls around its way.
    pub(super) fn may_meet(&self, one: &Member, other: BodyId, time: f64) -> bool {
        let Some((centre, way)) = self.kinematics[other.index()].as_ref().and_then(|k| k.way_around(time))
        else {
            return true;
        };
        let [a, b] = [one.body, other].map(|id| self.surfaces[id.index()].radius);
        one.state.pose.position.distance(centre) < a + b + WIDEST * a.min(b) + way
    }

    pub(super) fn placed(&self, body: BodyId, pose: Pose) -> Placed<'_> {
        Placed { sampled: &self.surfaces[body.index()], pose }
    }

    /// The points at which two bodies touch, or may touch at a slightly wrong instant.
    pub(super) fn touches(&self, a: &Member, b: &Member, nearness: &Nearness) -> Vec<Touch> {
        let [one, two] = [a, b].map(|member| self.placed(member.body, member.state.pose));
        let size = one.sampled.radius.min(two.sampled.radius);
        let (share, way, least) = TOUCHING;
        if !may_touch(one, two, WIDEST * size) {
            return Vec::new();
        }
        let spin = |member: &Member| {
            let radius = self.surfaces[member.body.index()].radius;
            if radius.is_finite() { member.state.angular_velocity.length() * radius } else { 0.0 }
        };
        let speed = (a.state.velocity - b.state.velocity).length() + spin(a).max(spin(b));
        let within =
            nearness.factor * (share * size + way * speed.max(nearness.impact) * nearness.span + least);
        touches(one, two, within.min(WIDEST * size))
    }
}
