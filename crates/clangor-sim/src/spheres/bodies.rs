//! Spheres and planes of a [`World`]: which bodies the sphere solvers accept.

use clangor_core::body::{Body, BodyId, Motion, Surface, World};
use clangor_core::contact::ContactSide;
use clangor_core::contact::hertz::HertzContact;
use clangor_core::material::PairCoefficients;
use clangor_core::material::thin_plate::inelasticity;
use glam::DVec3;

use super::pair_coefficients::PairTable;
use crate::SimulationError;

/// An overlap up to this fraction of the smaller radius is a rounding error of the scene's numbers.
const TOLERATED_OVERLAP: f64 = 1e-4;

/// A fixed half-space.
#[derive(Clone, Debug)]
pub(super) struct Plane {
    /// Index in the world's bodies.
    pub(super) body: u32,
    /// Outward unit normal n.
    pub(super) normal: DVec3,
    /// n·x of its surface \[m\].
    pub(super) offset: f64,
    /// Its material class.
    pub(super) material: u32,
    /// Contact compliance [1/Pa].
    pub(super) compliance: f64,
    /// Mobility of an endless plate [m/(N s)]; 0 for a half-space.
    pub(super) mobility: f64,
}

impl Plane {
    /// The coefficients of a ball of this radius \[m\], inverse mass [1/kg] and compliance [1/Pa] on it.
    pub(super) fn met_by(
        &self,
        coefficients: PairCoefficients,
        (radius, inverse_mass, compliance): (f64, f64, f64),
    ) -> PairCoefficients {
        if self.mobility == 0.0 {
            return coefficients;
        }
        let relative_radii = [radius; 2];
        let compliance = compliance + self.compliance;
        let contact = HertzContact { inverse_mass, relative_radii, compliance, speed: 1.0 };
        let lost = inelasticity(self.mobility, inverse_mass, contact.stiffness());
        PairCoefficients { restitution: coefficients.restitution.on_plate(lost), ..coefficients }
    }
}

/// A ball of a world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sphere {
    /// Index in the world's bodies.
    pub(super) body: usize,
    /// Radius \[m\].
    pub(super) radius: f64,
}

/// The bodies of a world by kind.
pub(super) struct Bodies {
    /// Balls, in the order of the world.
    pub(super) spheres: Vec<Sphere>,
    /// Planes, in the order of the world.
    pub(super) planes: Vec<Plane>,
    /// Coefficients of the pairs of material classes.
    pub(super) pairs: PairTable,
    /// Material class of each body of the world.
    pub(super) classes: Vec<u32>,
}

impl Bodies {
    /// Sorts the living bodies of a world into balls and planes.
    ///
    /// # Errors
    /// [`SimulationError::NotASphere`] for a body that the sphere solvers cannot move;
    /// [`SimulationError::Diverged`] for a state that is not finite.
    pub(super) fn from_world(world: &World) -> Result<Self, SimulationError> {
        let (pairs, classes) = PairTable::new(world);
        let (mut spheres, mut planes) = (Vec::new(), Vec::new());
        for (index, body) in world.bodies.iter().enumerate().filter(|(_, body)| body.life.holds(0.0)) {
            let finite = body.pose.position.is_finite()
                && body.pose.orientation.is_finite()
                && body.velocity.is_finite()
                && body.angular_velocity.is_finite();
            if !finite {
                return Err(SimulationError::Diverged { body: body.name.clone(), time: 0.0 });
            }
            check_kind(body)?;
            match *body.surface {
                Surface::Sphere { radius } => spheres.push(Sphere { body: index, radius }),
                _ => {
                    let normal = body.pose.orientation.normalize() * DVec3::Y;
                    let offset = normal.dot(body.pose.position);
                    let compliance = body.material.contact_compliance();
                    let material = classes[index];
                    let mobility = ContactSide::of_body(BodyId(index as u32), body, body.pose).plate_mobility;
                    let body = index as u32;
                    planes.push(Plane { body, normal, offset, material, compliance, mobility });
                }
            }
        }
        Ok(Bodies { spheres, planes, pairs, classes })
    }
}

/// Rejects all but fixed half-spaces, and spheres that are fixed or free.
fn check_kind(body: &Body) -> Result<(), SimulationError> {
    let refuse = |reason| Err(SimulationError::NotASphere { body: body.name.clone(), reason });
    let positive = |x: f64| x > 0.0 && x.is_finite();
    match (&*body.surface, &body.motion) {
        (Surface::Mesh(_), _) => refuse("it is neither a sphere nor a plane"),
        (_, Motion::Keyframed(track)) if !track.is_fixed() => {
            refuse("it moves by keyframes, which the exact solver does not follow")
        }
        (_, Motion::Guided(_)) => refuse("it is led by keyframes, which the exact solver does not follow"),
        (Surface::HalfSpace | Surface::Plate { .. }, Motion::Free) => refuse("a plane cannot be free"),
        (Surface::Sphere { radius }, _) if !positive(*radius) => {
            refuse("its radius is not a positive number")
        }
        (Surface::Sphere { .. }, Motion::Free)
            if !(positive(body.mass) && positive(body.inertia.x_axis.x)) =>
        {
            refuse("its mass or inertia is not a positive number")
        }
        _ => Ok(()),
    }
}

/// Rejects an overlap of two bodies `a` and `b` beyond rounding; `depth` is the overlap and `smaller` the
/// smaller radius \[m\].
pub(super) fn check_overlap(
    world: &World,
    a: u32,
    b: u32,
    depth: f64,
    smaller: f64,
) -> Result<(), SimulationError> {
    if depth <= TOLERATED_OVERLAP * smaller {
        return Ok(());
    }
    let name = |body: u32| world.bodies[body as usize].name.clone();
    Err(SimulationError::StartOverlap { a: name(a.min(b)), b: name(a.max(b)), depth, time: 0.0 })
}
