//! The force of one impact over time, and its action on each of the two bodies.

use glam::DVec3;

use super::effective_mass::{angular_velocity_change, inverse_mass};
use super::force_profile::ForceProfile;
use crate::body::{Body, BodyId};
use crate::material::Material;
use crate::pose::Pose;
use crate::timeline::ContactRow;

/// The force of one impact over time.
#[derive(Clone, Debug, PartialEq)]
pub struct ImpactPulse {
    /// Number of the impact in the timeline; 0 for a single row.
    pub impact_id: u64,
    /// First instant in the timeline \[s\].
    pub time: f64,
    /// Onset of the force \[s\]: `time`, or later inside a chain.
    pub onset: f64,
    /// Duration τ \[s\].
    pub duration: f64,
    /// Time profile of the force.
    pub profile: ForceProfile,
    /// Approach speed V along the normal [m/s].
    pub speed: f64,
    /// Effective mass m \[kg\].
    pub effective_mass: f64,
    /// Combined radius r \[m\].
    pub radius: f64,
    /// Mean point [m, world].
    pub point: DVec3,
    /// Mean unit normal, from B to A.
    pub normal: DVec3,
    /// Velocity of A relative to B at the mean point before all impacts of that instant [m/s]; `None` without
    /// poses of that instant in the timeline. In a touching chain only the first contact has an approach
    /// speed then.
    pub velocity_before: Option<DVec3>,
    /// A and B.
    pub pair: [BodyId; 2],
    /// Action on A and B; `None` for a body that contacts cannot move.
    pub bodies: [Option<BodyPulse>; 2],
    /// Contact points: place [m, world] and impulse on A [N s].
    pub points: Vec<(DVec3, DVec3)>,
}

impl ImpactPulse {
    /// Places \[m\] and impulses [N s] in the frame of a body, once for each side of the impact that it is.
    pub fn points_on(&self, body: BodyId) -> impl Iterator<Item = Vec<(DVec3, DVec3)>> {
        let sides = self.bodies.iter().zip([1.0, -1.0]);
        sides.filter_map(move |(share, sign)| {
            let pose = share.filter(|share| share.body == body)?.pose;
            let to_body = pose.orientation.inverse();
            let local = |(x, j): &(DVec3, DVec3)| (pose.body_from_world(*x), to_body * *j * sign);
            Some(self.points.iter().map(local).collect())
        })
    }

    /// Whether it is the release of a crack, which has no contact curvature.
    pub fn is_crack(&self) -> bool {
        self.radius == f64::INFINITY
    }
}

/// One body's share of an impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyPulse {
    /// The body.
    pub body: BodyId,
    /// Its pose at the impact.
    pub pose: Pose,
    /// Σj [N s], world.
    pub impulse: DVec3,
    /// Σj/M [m/s], world.
    pub velocity_change: DVec3,
    /// Σ (x − x_com) × j + couples [N m s], world, about the centre of mass.
    pub angular_impulse: DVec3,
    /// I⁻¹ of that [rad/s], world.
    pub angular_velocity_change: DVec3,
    /// τ c_R / L: duration over the time in which a Rayleigh wave crosses the body. Below 1 the body does not
    /// move as a whole during the impact, and the click of a rigid body is an upper bound.
    pub transit_ratio: f64,
}

/// Sum of the rows of an impact for one body, which is A for a `sign` of 1 and B for −1.
pub(super) fn body_pulse(
    body: &Body,
    id: BodyId,
    pose: Pose,
    rows: &[ContactRow],
    sign: f64,
    duration: f64,
) -> BodyPulse {
    let impulse: DVec3 = rows.iter().map(|r| sign * r.impulse()).sum();
    let turn = |r: &ContactRow| sign * ((r.point - pose.position).cross(r.impulse()) + r.couple);
    let angular_impulse = rows.iter().map(turn).sum();
    BodyPulse {
        body: id,
        pose,
        impulse,
        velocity_change: impulse * inverse_mass(body),
        angular_impulse,
        angular_velocity_change: angular_velocity_change(body, &pose, angular_impulse),
        transit_ratio: duration * rayleigh_speed(&body.material) / (2.0 * body.surface.bounding_radius()),
    }
}

/// Speed of Rayleigh waves [m/s], Viktorov's approximation c_s (0.87 + 1.12 ν)/(1 + ν), good to 0.5 %.
fn rayleigh_speed(material: &Material) -> f64 {
    let nu = material.poisson_ratio;
    let shear = (0.5 * material.youngs_modulus / (material.density * (1.0 + nu))).sqrt();
    shear * (0.87 + 1.12 * nu) / (1.0 + nu)
}
