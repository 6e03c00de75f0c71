//! The force of one impact over time, and its action on each of the two bodies.

use glam::DVec3;

use super::contact_side::ContactSide;
use super::force_shape::ForceShape;
use super::hertz::HertzRange;
use super::impact::ContactPoint;
use crate::body::BodyId;
use crate::pose::Pose;

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
    /// Shape of the force over time.
    pub shape: ForceShape,
    /// Approach speed V along the normal [m/s].
    pub speed: f64,
    /// Effective mass m \[kg\].
    pub effective_mass: f64,
    /// Geometric mean R_e of the principal relative radii \[m\]; infinite for the release of a crack.
    pub radius: f64,
    /// Whether Hertz's theory covers the contact.
    pub range: HertzRange,
    /// Mean point [m, world].
    pub point: DVec3,
    /// Mean unit normal, from B to A.
    pub normal: DVec3,
    /// Velocity of A relative to B where they approach fastest, before all impacts of that instant [m/s];
    /// `None` without poses of that instant in the timeline. In a touching chain only the first contact has
    /// an approach speed then.
    pub velocity_before: Option<DVec3>,
    /// A and B.
    pub pair: [BodyId; 2],
    /// Action on A and B; `None` for a body that contacts neither move nor set into vibration.
    pub bodies: [Option<BodyPulse>; 2],
    /// Contact points: place [m, world] and impulse on A [N s].
    pub points: Vec<(DVec3, DVec3)>,
    /// Energy that these impulses would give to the modes of both bodies, over that of the approach
    /// ([`modal_energy`](super::modal_energy)); 0 for bodies without modes.
    pub modal_energy_ratio: f64,
}

/// Restitution above which a contact is taken to lose as much as at it: two solid bodies lose a little even
/// where a scene says that they do not.
const MOST_ELASTIC: f64 = 0.95;

impl ImpactPulse {
    /// Places \[m\] and impulses [N s] of the forces on the modes of a body, in its frame, once for each side
    /// of the impact that it is.
    pub fn modal_impulses_on(&self, body: BodyId) -> impl Iterator<Item = Vec<(DVec3, DVec3)>> {
        let sides = self.bodies.iter().zip([1.0, -1.0]);
        sides.filter_map(move |(share, sign)| {
            let share = share.filter(|share| share.body == body)?;
            let mut points = share.local(&self.points, sign);
            points.iter_mut().for_each(|(_, impulse)| *impulse *= share.modal_gain);
            Some(points)
        })
    }

    /// Energy of the approach ½ m V² \[J\], of which modes get no more; for the release of a crack, the
    /// energy that its impulse and couple alone would give to pieces at rest.
    pub fn approach_energy(&self) -> f64 {
        0.5 * self.effective_mass * self.speed * self.speed
    }

    /// Energy that the motion of rigid bodies loses \[J\]: j_n V − j_n²/(2 m) = ½ j_n V (1 − e) of an impact,
    /// [`approach_energy`](Self::approach_energy) of a crack.
    pub fn energy_lost(&self) -> f64 {
        if self.is_crack() {
            return self.approach_energy();
        }
        let impulse = self.points.iter().map(|(_, j)| *j).sum::<DVec3>().dot(self.normal).abs();
        let restitution = impulse / (self.effective_mass * self.speed) - 1.0;
        0.5 * impulse * self.speed * (1.0 - restitution.min(MOST_ELASTIC))
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
    /// Factor g of the forces on its modes, at most 1.
    pub modal_gain: f64,
}

impl BodyPulse {
    /// Whether the body moves as a whole: not where it is held and only vibrates.
    pub fn moves(&self) -> bool {
        self.velocity_change != DVec3::ZERO || self.angular_velocity_change != DVec3::ZERO
    }

    /// The share of the body on one side, which is A for a `sign` of 1 and B for −1, in an impact of a
    /// `duration` \[s\].
    pub(super) fn new(side: &ContactSide, points: &[ContactPoint], sign: f64, duration: f64) -> Self {
        let impulse: DVec3 = points.iter().map(|point| sign * point.impulse).sum();
        let turn = |point: &ContactPoint| {
            sign * ((point.place - side.pose.position).cross(point.impulse) + point.couple)
        };
        let angular_impulse = points.iter().map(turn).sum();
        BodyPulse {
            body: side.body,
            pose: side.pose,
            impulse,
            velocity_change: impulse * side.inverse_mass,
            angular_impulse,
            angular_velocity_change: side.angular_velocity_change(angular_impulse),
            transit_ratio: duration * side.rayleigh_speed / (2.0 * side.bounding_radius),
            modal_gain: 1.0,
        }
    }

    /// Contact points of the impact in the frame of the body: places \[m\] and impulses on it [N s]. The body
    /// is A for a `sign` of 1 and B for −1.
    pub(super) fn local(&self, points: &[(DVec3, DVec3)], sign: f64) -> Vec<(DVec3, DVec3)> {
        let to_body = self.pose.orientation.inverse();
        let local = |(x, j): &(DVec3, DVec3)| (self.pose.body_from_world(*x), to_body * *j * sign);
        points.iter().map(local).collect()
    }
}
