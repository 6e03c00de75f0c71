//! A body as impulses change it: its velocities, and how it resists.

use glam::{DMat3, DVec3};

/// An impulse at the centre of mass of a mover, and an angular impulse.
pub(super) type Kick = (usize, DVec3, DVec3);

/// Velocities and inertia of a body at one pose.
#[derive(Clone, Copy)]
pub(super) struct Mover {
    pub(super) velocity: DVec3,
    pub(super) spin: DVec3,
    pub(super) inverse_mass: f64,
    pub(super) inverse_inertia: DMat3,
}

impl Mover {
    /// Applies an impulse at the centre of mass, and an angular impulse.
    pub(super) fn push(&mut self, impulse: DVec3, angular: DVec3) {
        self.velocity += impulse * self.inverse_mass;
        self.spin += self.inverse_inertia * angular;
    }

    /// Velocity of the material point at `arm` from the centre of mass.
    pub(super) fn velocity_at(&self, arm: DVec3) -> DVec3 {
        self.velocity + self.spin.cross(arm)
    }

    /// Inverse effective mass along `direction` at `arm` \[1/kg\].
    pub(super) fn inverse_mass_at(&self, arm: DVec3, direction: DVec3) -> f64 {
        let lever = arm.cross(direction);
        self.inverse_mass + lever.dot(self.inverse_inertia * lever)
    }

    /// Mass \[kg\], of a body that forces move.
    pub(super) fn mass(&self) -> f64 {
        self.inverse_mass.recip()
    }

    /// Inertia about the centre of mass, of a body that forces move.
    pub(super) fn inertia(&self) -> DMat3 {
        self.inverse_inertia.inverse()
    }

    /// The same body at rest.
    pub(super) fn still(&self) -> Self {
        Mover { velocity: DVec3::ZERO, spin: DVec3::ZERO, ..*self }
    }
}
