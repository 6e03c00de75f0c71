//! A ball that hits a single body, and the forces of that impact.
//!
//! A free ball moves along the normal of the surface and meets the body without friction. The impulse is
//! (1 + e) m V with the restitution e of the pair of materials ([`PairCoefficients`]);
//! [`contact_forces`](fn@contact_forces) gives its duration and what acts on the motion and the modes of the
//! body. The strike of a body, the page and any other program that lets somebody hit an object use it.

use glam::DVec3;

use super::modal::ModalSource;
use super::strike_error::StrikeError;
use crate::body::{Body, BodyId, Surface};
use crate::contact::{
    ContactSide, ForceSettings, Impact, ImpactPulse, ImpactSolver, Spread, Touch, contact_forces, touching,
};
use crate::material::{Material, PairCoefficients};
use crate::pose::Pose;

/// Largest distance of the struck point from the surface, over the bounding radius.
pub const POINT_TOLERANCE: f64 = 0.02;

/// Cosine of the angle of a given normal to that of the surface below which it points into the body; normals
/// at edges have some freedom.
const INWARD: f64 = -0.1;

/// Body A of the impact, the one that is struck.
pub const STRUCK: BodyId = BodyId(0);
/// Body B, the striker.
pub const STRIKER: BodyId = BodyId(1);

/// A ball that hits a body: see the module.
#[derive(Clone, Debug, PartialEq)]
pub struct Striker {
    /// Its material.
    pub material: Material,
    /// Its radius \[m\].
    pub radius: f64,
    /// Its speed along the normal, relative to the body [m/s].
    pub speed: f64,
    /// Outward normal of the body at the point, world; by default that of its surface.
    pub normal: Option<DVec3>,
    /// Whether its own acceleration noise is part of the sound.
    pub heard: bool,
}

impl Striker {
    /// A ball of a material, a radius \[m\] and a speed [m/s], which is heard.
    pub fn new(material: Material, radius: f64, speed: f64) -> Self {
        Striker { material, radius, speed, normal: None, heard: true }
    }

    /// The forces on a `body` at its pose, hit at a `point` [m, world] at time 0. The body is [`STRUCK`], the
    /// ball [`STRIKER`]. The `modes` of the body bound the forces on them.
    ///
    /// # Errors
    /// [`StrikeError`].
    pub fn forces_on(
        &self,
        body: &Body,
        modes: Option<&ModalSource>,
        point: DVec3,
        settings: &ForceSettings,
    ) -> Result<Vec<ImpactPulse>, StrikeError> {
        let struck = struck_side(body, point)?;
        for (what, value) in [("the radius", self.radius), ("the speed", self.speed)] {
            if !positive(value) {
                return Err(StrikeError::Striker { what, value });
            }
        }
        let outward = self.outward(body, point)?;
        // The ball touches the body at the point.
        let ball = Body::sphere("striker", self.material.clone(), self.radius);
        let pose = Pose::at(point + self.radius * outward);
        let side = ContactSide::of_body(STRIKER, &ball, pose);
        let touch = Touch {
            surfaces: [Some(&*body.surface), Some(&*ball.surface)],
            normal: outward,
            place: point,
            speed: self.speed,
            spread: Spread::single(self.radius.min(struck.bounding_radius)),
        };
        let sides = touching([struck, side], &touch);
        let restitution = PairCoefficients::of(&body.material, &self.material).restitution.at(self.speed);
        let impact = Impact::with_restitution(sides, point, -outward, self.speed, restitution);
        let modes_of = |id: BodyId, points: &[(DVec3, DVec3)]| {
            modes.filter(|_| id == STRUCK).map(|modes| modes.at_contact(points))
        };
        Ok(contact_forces(&impact, &modes_of, settings, &mut ImpactSolver::default())?)
    }
}

impl Striker {
    /// The direction from which the ball comes: the given normal, or that of the surface.
    fn outward(&self, body: &Body, point: DVec3) -> Result<DVec3, StrikeError> {
        let local = body.surface.normal_at(body.pose.body_from_world(point));
        let of_surface = local.map(|normal| body.pose.orientation * normal);
        let Some(normal) = self.normal else { return of_surface.ok_or(StrikeError::NoNormal { point }) };
        if !normal.is_finite() {
            return Err(StrikeError::NotFinite { what: "the normal" });
        }
        let given = normal.try_normalize().ok_or(StrikeError::ZeroNormal)?;
        match of_surface.filter(|outward| outward.dot(given) < INWARD) {
            Some(outward) => Err(StrikeError::InwardNormal { normal, outward }),
            None => Ok(given),
        }
    }
}

/// A body that is struck at a point [m, world], still flat there.
///
/// # Errors
/// A body without mass or volume, a point off its surface.
pub(super) fn struck_side(body: &Body, point: DVec3) -> Result<ContactSide, StrikeError> {
    let radius = body.surface.equal_volume_radius();
    if !positive(body.mass) || !positive(radius) {
        return Err(StrikeError::Immovable { mass: body.mass, radius });
    }
    if !point.is_finite() {
        return Err(StrikeError::NotFinite { what: "the point" });
    }
    let bounding = body.surface.bounding_radius();
    let local = body.pose.body_from_world(point);
    let distance = match &*body.surface {
        Surface::Sphere { radius } => (local.length() - radius).abs(),
        Surface::HalfSpace | Surface::Plate { .. } => local.y.abs(),
        Surface::Mesh(mesh) => mesh.signed_distance(local).abs(),
    };
    if distance > POINT_TOLERANCE * bounding {
        return Err(StrikeError::OffSurface { point, distance, bounding });
    }
    Ok(ContactSide::of_body(STRUCK, body, body.pose))
}

pub(super) fn positive(x: f64) -> bool {
    x > 0.0 && x.is_finite()
}
