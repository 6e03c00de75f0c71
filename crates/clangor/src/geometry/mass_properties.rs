//! Mass, centre of mass and inertia of a solid bounded by a closed surface.

use glam::{DMat3, DVec3};

/// Mass properties of a solid of unit density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// Volume [m³].
    pub volume: f64,
    /// Centre of mass [m].
    pub centre_of_mass: DVec3,
    /// Inertia tensor about the centre of mass, per unit density [m⁵].
    pub inertia: DMat3,
}
