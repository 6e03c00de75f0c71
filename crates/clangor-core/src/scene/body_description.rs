//! Bodies, planes and links of a scene, before any mesh is read.

use glam::{DMat3, DVec3};

use super::breaking::Breaking;
use super::diagnostic::Place;
use super::support_description::SupportDescription;
use crate::body::{Body, Motion};
use crate::material::Material;
use crate::pose::Pose;
use crate::sound_model::rule::AccelerationRule;
use crate::sound_model::rule::ModalRule;

/// One `[[body]]`: one body, or many copies.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyDescription {
    /// Name; copies are called `name-1`, `name-2`, ….
    pub name: String,
    /// Shape or mesh file.
    pub geometry: Geometry,
    /// Range of the scale factor on all lengths: least and greatest. Copies draw it uniformly between the
    /// two.
    pub scale: [f64; 2],
    /// Material.
    pub material: Material,
    /// Mass, centre of mass and inertia where they are not those of the homogeneous solid.
    pub given_mass: GivenMass,
    /// Pose at t = 0; for copies, the orientation only. `placed_by` names the point of the body at
    /// `position`.
    pub pose: Pose,
    /// Point of the body at `pose.position`.
    pub placed_by: PlacedBy,
    /// Velocity of the centre of mass \[m/s\].
    pub velocity: DVec3,
    /// Angular velocity \[rad/s\], world frame.
    pub angular_velocity: DVec3,
    /// Cause of its motion.
    pub motion: Motion,
    /// Lower bound of the local contact radius \[m\]; `None`:
    /// [`EDGE_RADIUS_RATIO`](crate::body::EDGE_RADIUS_RATIO) of its bounding radius.
    pub edge_radius: Option<f64>,
    /// Largest distance of the convex parts that collide from the surface of a mesh file, over its bounding
    /// radius; `None`: those of a fixed resolution.
    pub collision_error: Option<f64>,
    /// Acceleration model; `None`: that of the `[render]` section.
    pub sound: Option<AccelerationRule>,
    /// Modal model: its own modes, those of a proxy, or none.
    pub ringing: ModalRule,
    /// Fracture settings; `None` for a body that does not break.
    pub breaking: Option<Breaking>,
    /// What holds it; nothing for a body that lies free, or is fixed as a whole.
    pub supports: Vec<SupportDescription>,
    /// Number and places of the copies.
    pub copies: Copies,
    /// Place of the body in the text.
    pub place: Place,
    /// Place of its shape or mesh in the text.
    pub geometry_place: Place,
}

/// Mass properties that a body is given. What is missing is that of the homogeneous solid of its surface and
/// material; its inertia grows with a given mass.
///
/// The motion and the forces of impacts follow from them. The vibration is that of the homogeneous solid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GivenMass {
    /// \[kg\]
    pub mass: Option<f64>,
    /// Centre of mass \[m\], scaled, in the frame of the shape or file.
    pub centre_of_mass: Option<DVec3>,
    /// Inertia about the centre of mass \[kg m²\], in the axes of the shape or file.
    pub inertia: Option<DMat3>,
}

impl GivenMass {
    /// Gives a body about its centre of mass this mass and inertia.
    pub fn apply_to(&self, body: &mut Body) {
        if let Some(mass) = self.mass {
            body.inertia *= mass / body.mass;
            body.mass = mass;
        }
        body.inertia = self.inertia.unwrap_or(body.inertia);
    }
}

/// Point of a body to which its position refers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlacedBy {
    /// Its centre of mass.
    CentreOfMass,
    /// The origin of its shape or mesh file.
    Origin,
}

impl BodyDescription {
    /// One free body at rest, with its centre of mass at the origin.
    pub fn new(name: impl Into<String>, material: Material, geometry: Geometry) -> Self {
        BodyDescription {
            name: name.into(),
            geometry,
            scale: [1.0, 1.0],
            material,
            given_mass: GivenMass::default(),
            pose: Pose::IDENTITY,
            placed_by: PlacedBy::CentreOfMass,
            velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
            motion: Motion::Free,
            edge_radius: None,
            collision_error: None,
            sound: None,
            ringing: ModalRule::default(),
            breaking: None,
            supports: Vec::new(),
            copies: Copies::One,
            place: Place::default(),
            geometry_place: Place::default(),
        }
    }

    /// As [`new`](Self::new), of a shape of the library such as `sphere:0.01`, sizes in metres.
    pub fn shape(name: impl Into<String>, material: Material, shape: impl Into<String>) -> Self {
        BodyDescription::new(name, material, Geometry::Shape(shape.into()))
    }

    /// As [`new`](Self::new), of a mesh file whose path is relative to the scene file.
    pub fn mesh(name: impl Into<String>, material: Material, path: impl Into<String>) -> Self {
        BodyDescription::new(name, material, Geometry::File(path.into()))
    }

    /// The same body at another pose; a point \[m\] is the pose there with the axes of the world.
    #[must_use]
    pub fn at(self, pose: impl Into<Pose>) -> Self {
        BodyDescription { pose: pose.into(), ..self }
    }

    /// The same body with another velocity of its centre of mass \[m/s\].
    #[must_use]
    pub fn with_velocity(self, velocity: DVec3) -> Self {
        BodyDescription { velocity, ..self }
    }

    /// The same body with another angular velocity \[rad/s\], world frame.
    #[must_use]
    pub fn with_angular_velocity(self, angular_velocity: DVec3) -> Self {
        BodyDescription { angular_velocity, ..self }
    }

    /// The same body with another cause of motion.
    #[must_use]
    pub fn with_motion(self, motion: Motion) -> Self {
        BodyDescription { motion, ..self }
    }

    /// The same body, several times or at another place.
    #[must_use]
    pub fn with_copies(self, copies: Copies) -> Self {
        BodyDescription { copies, ..self }
    }

    /// Number of bodies.
    pub fn count(&self) -> usize {
        match &self.copies {
            Copies::One => 1,
            Copies::At(positions) => positions.len(),
            Copies::Random(placement) => placement.count,
        }
    }

    /// Name of a copy, counted from 0.
    pub fn copy_name(&self, copy: usize) -> String {
        match self.copies {
            Copies::One => self.name.clone(),
            _ => format!("{}-{}", self.name, copy + 1),
        }
    }

    /// The geometry of a copy, counted from 0, at a scale.
    pub fn reference(&self, copy: usize, scale: f64) -> GeometryReference {
        let geometry = match &self.geometry {
            Geometry::Shape(text) => Geometry::Shape(text.replace(COPY_NUMBER, &(copy + 1).to_string())),
            file => file.clone(),
        };
        GeometryReference { geometry, scale, centre_of_mass: self.given_mass.centre_of_mass }
    }
}

/// Placeholder in a shape for the number of the copy, from 1: `rock:{n}x0.02` gives every copy another seed.
pub const COPY_NUMBER: &str = "{n}";

/// Source of the surface of a body.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Geometry {
    /// Text of the shape library, such as `coin:0.01213x0.00175@0.0005`.
    Shape(String),
    /// Path of a mesh file, relative to the scene file.
    File(String),
}

/// Geometry of one body, as the loader gets it.
#[derive(Clone, Debug, PartialEq)]
pub struct GeometryReference {
    /// Shape or file.
    pub geometry: Geometry,
    /// Factor on all lengths.
    pub scale: f64,
    /// Centre of mass \[m\], scaled, in the frame of the shape or file; `None`: that of the homogeneous
    /// solid.
    pub centre_of_mass: Option<DVec3>,
}

/// A geometry, and the bits of its scale and centre of mass.
pub(super) type GeometryKey = (Geometry, u64, Option<[u64; 3]>);

impl GeometryReference {
    /// Key that distinguishes geometries.
    pub(super) fn key(&self) -> GeometryKey {
        let centre = self.centre_of_mass.map(|centre| centre.to_array().map(f64::to_bits));
        (self.geometry.clone(), self.scale.to_bits(), centre)
    }
}

impl std::fmt::Display for GeometryReference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (Geometry::Shape(text) | Geometry::File(text)) = &self.geometry;
        write!(f, "{text}")?;
        if self.scale != 1.0 {
            write!(f, " (scale {})", self.scale)?;
        }
        match self.centre_of_mass {
            Some(DVec3 { x, y, z }) => write!(f, " (centre of mass {x}, {y}, {z})"),
            None => Ok(()),
        }
    }
}

/// Number and places of the bodies of a `[[body]]`.
#[derive(Clone, Debug, PartialEq)]
pub enum Copies {
    /// One, at the pose of the description.
    One,
    /// One at each of these centres of mass \[m\].
    At(Vec<DVec3>),
    /// Scattered at random without touching.
    Random(RandomPlacement),
}

/// Copies scattered at random.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomPlacement {
    /// Number of copies.
    pub count: usize,
    /// Corners of the box that holds the centres of mass \[m\].
    pub region: [DVec3; 2],
    /// Seed of the positions, orientations, spins and scales; `None`: the simulation's.
    pub seed: Option<u64>,
    /// Whether every copy has a random orientation, uniform over all rotations.
    pub random_orientation: bool,
    /// Largest random angular velocity \[rad/s\], uniform in the ball of this radius and added to the body's.
    pub max_spin: f64,
    /// Place of the placement in the text.
    pub place: Place,
}

/// A `[[plane]]`: fixed, solid on the side opposite to its normal. Whether it reflects sound is part of the
/// [`Acoustics`](crate::acoustics::Acoustics) of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneDescription {
    /// Name.
    pub name: String,
    /// A point of the plane \[m\].
    pub point: DVec3,
    /// Unit normal, out of the solid.
    pub normal: DVec3,
    /// Material.
    pub material: Material,
    /// Thickness \[m\] of an endless plate, with the plane as its upper face; `None` for a half-space.
    pub thickness: Option<f64>,
    /// Whether it is a wall, behind which a listener may be. For bodies there is no difference.
    pub thin: bool,
    /// Place of the plane in the text.
    pub place: Place,
}

impl PlaneDescription {
    /// A plane through `point` \[m\] with the outward unit `normal`.
    pub fn new(name: impl Into<String>, material: Material, point: DVec3, normal: DVec3) -> Self {
        PlaneDescription {
            name: name.into(),
            point,
            normal,
            material,
            thickness: None,
            thin: false,
            place: Place::default(),
        }
    }
}
