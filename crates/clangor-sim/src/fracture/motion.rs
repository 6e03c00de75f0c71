//! The motion of a rigid body, and the inherited motion of its pieces.
//!
//! A piece with centre c_d of a body with velocity v of its centre c and angular velocity ω starts with the
//! motion that it had as a part of the body:
//!
//! ```text
//! v_d = v + ω × (c_d − c),    ω_d = ω
//! ```
//!
//! Momentum, angular momentum and kinetic energy of all pieces together equal those of the body.

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::glam::{DMat3, DVec3};

/// A rigid body in motion; all vectors in one frame, such as that of the body's mesh at the instant of
/// fracture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Mass \[kg\].
    pub mass: f64,
    /// Centre of mass \[m\].
    pub centre: DVec3,
    /// Inertia about the centre of mass \[kg m²\].
    pub inertia: DMat3,
    /// Velocity of the centre of mass \[m/s\].
    pub velocity: DVec3,
    /// Angular velocity \[rad/s\].
    pub angular_velocity: DVec3,
}

impl Motion {
    /// A body of uniform `density` \[kg/m³\] at rest.
    pub fn at_rest(solid: &MassProperties, density: f64) -> Self {
        Motion {
            mass: density * solid.volume,
            centre: solid.centre_of_mass,
            inertia: solid.inertia * density,
            velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
        }
    }

    /// A piece of this body, of uniform `density` \[kg/m³\], with its inherited motion.
    pub fn of_piece(&self, solid: &MassProperties, density: f64) -> Self {
        Motion {
            velocity: self.velocity_at(solid.centre_of_mass),
            angular_velocity: self.angular_velocity,
            ..Self::at_rest(solid, density)
        }
    }

    /// Velocity of a material point \[m/s\].
    pub fn velocity_at(&self, point: DVec3) -> DVec3 {
        self.velocity + self.angular_velocity.cross(point - self.centre)
    }

    /// Momentum \[N s\].
    pub fn momentum(&self) -> DVec3 {
        self.mass * self.velocity
    }

    /// Angular momentum about the origin of the frame \[N m s\].
    pub fn angular_momentum(&self) -> DVec3 {
        self.inertia * self.angular_velocity + self.centre.cross(self.momentum())
    }

    /// Kinetic energy \[J\].
    pub fn kinetic_energy(&self) -> f64 {
        let turning = self.angular_velocity.dot(self.inertia * self.angular_velocity);
        0.5 * (self.mass * self.velocity.length_squared() + turning)
    }
}
