//! The sphere or circle to which massless rods hold a ball's centre.
//!
//! One rod leaves a sphere about its anchor. Two leave a circle about the line through their anchors: its
//! plane, centre and radius stay well determined when the rods are nearly in line, where the forces along
//! them are not.

use glam::DVec3;

/// Where the rods of a ball leave it: on a sphere about an anchor, or on a circle about the line through two.
#[derive(Clone, Copy, Debug)]
pub(super) struct Track {
    /// Ball of the island.
    pub(super) ball: usize,
    /// Centre \[m\].
    pub(super) centre: DVec3,
    /// Unit normal of the circle's plane; zero for a sphere.
    pub(super) axis: DVec3,
    /// Radius \[m\].
    pub(super) radius: f64,
}

impl Track {
    /// Unit vector from the centre to a position, in the plane of a circle.
    pub(super) fn outwards(&self, position: DVec3) -> DVec3 {
        let offset = position - self.centre;
        (offset - self.axis * self.axis.dot(offset)).normalize_or_zero()
    }

    /// The acceleration that the rods leave of one due to everything else.
    pub(super) fn guided(&self, driven: DVec3, position: DVec3, velocity: DVec3) -> DVec3 {
        let outwards = self.outwards(position);
        let across = driven - self.axis * self.axis.dot(driven);
        // With the radius itself, so that rounding does not accumulate.
        across - outwards * (velocity.length_squared() / self.radius + outwards.dot(across))
    }
}
