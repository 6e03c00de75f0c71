//! One of the two bodies at a contact: how it gives way as a rigid body, and how its surface is curved there.
//!
//! ```text
//! 1/mᵢ = 1/Mᵢ + (r × n)ᵀ Iᵢ⁻¹ (r × n)       effective mass along the normal n, [PAN] eq. (9)
//! ```
//!
//! r is the contact point from the centre of mass. A body that contacts cannot move has 1/Mᵢ = 0 and I⁻¹ = 0.
//! Joints make a link heavier than it is alone: where the effective mass m of the pair is given, both sides
//! have 1/Mᵢ and Iᵢ⁻¹ times one factor, 1/m over Σ 1/mᵢ, in all that makes the force of the impact. Along n
//! at the point this is exact. Across n and at other points it is an approximation.
//! A side is plain data, so that a contact of any origin can be described by it: of a timeline, of a strike,
//! of the physics of a game.

use glam::{DMat3, DVec3};

use super::compliant::half_space_radiation;
use crate::body::{Body, BodyId, Surface};
use crate::material::{Material, ThinPlate};
use crate::pose::Pose;

/// A body at a contact: see the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactSide {
    /// The body.
    pub body: BodyId,
    /// Its pose at the contact.
    pub pose: Pose,
    /// 1/M [1/kg]; 0 if contacts cannot move it.
    pub inverse_mass: f64,
    /// I⁻¹ about the centre of mass [1/(kg m²)], in the axes of the body.
    pub inverse_inertia: DMat3,
    /// Factor on both while the force of an impact acts: 1 for a body alone, below 1 for one on joints.
    pub joint_factor: f64,
    /// (1 − ν²)/E of its material [1/Pa]; 0 if it is rigid.
    pub compliance: f64,
    /// Speed of Rayleigh waves in its material [m/s].
    pub rayleigh_speed: f64,
    /// Curvature tensor of its surface at the contact, in the tangent plane and in the axes of the world
    /// [1/m]: 0 for a plane, negative where hollow.
    pub curvature: DMat3,
    /// Lower bound of both principal radii of that curvature \[m\]; 0 for none.
    pub edge_radius: f64,
    /// Bounding radius \[m\]; infinite for a half-space.
    pub bounding_radius: f64,
    /// Lower bound of the relative curvature [1/m] of a contact with this side: 1/bounding radius until
    /// [`touching`](super::touching::touching) knows the scale of the contact.
    pub least_curvature: f64,
    /// κ of the waves that it takes away as a half-space [s m/N]; 0 for other bodies
    /// ([`half_space_radiation`]).
    pub radiation: f64,
    /// Y of an endless plate at the driven point [m/(N s)]; 0 for other bodies
    /// ([`ThinPlate`]).
    pub plate_mobility: f64,
}

impl ContactSide {
    /// Rigid, flat, immovable surroundings.
    pub const SURROUNDINGS: ContactSide = ContactSide {
        body: BodyId::WORLD,
        pose: Pose::IDENTITY,
        inverse_mass: 0.0,
        inverse_inertia: DMat3::ZERO,
        joint_factor: 1.0,
        compliance: 0.0,
        rayleigh_speed: f64::INFINITY,
        curvature: DMat3::ZERO,
        edge_radius: 0.0,
        bounding_radius: f64::INFINITY,
        least_curvature: 0.0,
        radiation: 0.0,
        plate_mobility: 0.0,
    };

    /// A body at a pose, with a surface that is flat at the contact until [`touched_at`](Self::touched_at)
    /// says otherwise.
    pub fn of_body(id: BodyId, body: &Body, pose: Pose) -> Self {
        let inverse_mass = inverse_mass(body);
        ContactSide {
            body: id,
            pose,
            inverse_mass,
            inverse_inertia: if inverse_mass > 0.0 { body.inertia.inverse() } else { DMat3::ZERO },
            joint_factor: 1.0,
            compliance: body.material.contact_compliance(),
            rayleigh_speed: rayleigh_speed(&body.material),
            curvature: DMat3::ZERO,
            edge_radius: body.edge_radius,
            bounding_radius: body.surface.bounding_radius(),
            least_curvature: body.surface.bounding_radius().recip(),
            radiation: match *body.surface {
                Surface::HalfSpace => {
                    let Material { youngs_modulus, poisson_ratio, density, .. } = body.material;
                    half_space_radiation(youngs_modulus, poisson_ratio, density)
                }
                Surface::Sphere { .. } | Surface::Plate { .. } | Surface::Mesh(_) => 0.0,
            },
            plate_mobility: match *body.surface {
                Surface::Plate { thickness } => ThinPlate::new(&body.material, thickness).point_mobility(),
                Surface::Sphere { .. } | Surface::HalfSpace | Surface::Mesh(_) => 0.0,
            },
        }
    }

    /// The same side, if contacts cannot move it.
    #[must_use]
    pub fn immovable(self) -> Self {
        ContactSide { inverse_mass: 0.0, inverse_inertia: DMat3::ZERO, ..self }
    }

    /// Whether contacts move it.
    pub fn is_movable(&self) -> bool {
        self.inverse_mass > 0.0
    }

    /// 1/M [1/kg] and I⁻¹ [1/(kg m²), axes of the body] with which it answers the force of an impact: its own
    /// ones times the factor of its joints.
    pub fn answer(&self) -> (f64, DMat3) {
        (self.inverse_mass * self.joint_factor, self.inverse_inertia * self.joint_factor)
    }

    /// 1/mᵢ [1/kg] at a `point` [m, world] along the unit `normal` \[world\]: \[PAN\] eq. (9), with the
    /// factor of joints; 0 if contacts cannot move it.
    pub fn inverse_effective_mass(&self, point: DVec3, normal: DVec3) -> f64 {
        if !self.is_movable() {
            return 0.0;
        }
        let to_body = self.pose.orientation.inverse();
        let lever = self.pose.body_from_world(point).cross(to_body * normal);
        let (inverse_mass, inverse_inertia) = self.answer();
        inverse_mass + lever.dot(inverse_inertia * lever)
    }

    /// I⁻¹ L [rad/s, world]: change of the angular velocity by an angular impulse L about the centre of mass
    /// [N m s, world].
    pub fn angular_velocity_change(&self, angular_impulse: DVec3) -> DVec3 {
        let pose = &self.pose;
        pose.orientation * (self.inverse_inertia * (pose.orientation.inverse() * angular_impulse))
    }
}

/// 1/M [1/kg]; 0 for a body that contacts cannot move: fixed, keyframed, or a half-space.
pub fn inverse_mass(body: &Body) -> f64 {
    let movable = body.motion.is_movable() && !body.surface.is_plane();
    if movable { 1.0 / body.mass } else { 0.0 }
}

/// 1/m [1/kg] of two bodies against each other at a `point` [m, world] along the unit `normal` \[world\].
pub(super) fn inverse_effective_mass(sides: &[ContactSide; 2], point: DVec3, normal: DVec3) -> f64 {
    sides.iter().map(|side| side.inverse_effective_mass(point, normal)).sum()
}

/// Speed of Rayleigh waves [m/s], Viktorov's approximation c_s (0.87 + 1.12 ν)/(1 + ν), good to 0.5 %.
pub fn rayleigh_speed(material: &Material) -> f64 {
    let nu = material.poisson_ratio;
    let shear = (0.5 * material.youngs_modulus / (material.density * (1.0 + nu))).sqrt();
    shear * (0.87 + 1.12 * nu) / (1.0 + nu)
}
