//! Effective mass of a body at a contact point: \[PAN\] eq. (9), 1/mᵢ = 1/Mᵢ + (r × n)ᵀ Iᵢ⁻¹ (r × n).

use glam::{DMat3, DVec3};

use crate::body::{Body, Motion, Surface};
use crate::pose::Pose;

/// 1/M [1/kg]; 0 for a body that contacts cannot move: fixed, keyframed, or a half-space.
pub fn inverse_mass(body: &Body) -> f64 {
    let movable = matches!(body.motion, Motion::Free) && !matches!(*body.surface, Surface::HalfSpace);
    if movable { 1.0 / body.mass } else { 0.0 }
}

/// 1/mᵢ [1/kg] of \[PAN\] eq. (9) for a free body.
///
/// * `inverse_mass`: 1/M [1/kg].
/// * `inertia`: inertia about the centre of mass [kg m²].
/// * `arm`: contact point from the centre of mass \[m\].
/// * `normal`: unit contact normal; all in the same axes.
pub fn inverse_effective_mass(inverse_mass: f64, inertia: DMat3, arm: DVec3, normal: DVec3) -> f64 {
    let lever = arm.cross(normal);
    inverse_mass + lever.dot(inertia.inverse() * lever)
}

/// 1/mᵢ [1/kg] of `body` at `pose`, touched at `point` \[m, world\] along the unit `normal` \[world\]; 0 for
/// a body that contacts cannot move.
pub fn body_inverse_effective_mass(body: &Body, pose: &Pose, point: DVec3, normal: DVec3) -> f64 {
    let inverse_mass = inverse_mass(body);
    if inverse_mass == 0.0 {
        return 0.0;
    }
    let to_body = pose.orientation.inverse();
    inverse_effective_mass(inverse_mass, body.inertia, pose.body_from_world(point), to_body * normal)
}

/// I⁻¹ L [rad/s, world]: change of the angular velocity of a free `body` at `pose` by an angular impulse L
/// about its centre of mass [N m s, world].
pub fn angular_velocity_change(body: &Body, pose: &Pose, angular_impulse: DVec3) -> DVec3 {
    pose.orientation * (body.inertia.inverse() * (pose.orientation.inverse() * angular_impulse))
}
