//! The bodies of a scene for dynamics and sound: pose, mass, surface and material.
//!
//! A [`World`] is the input of `clangor-sim`: a scene with its files read, its copies placed and its shapes
//! converted to surfaces.

pub mod link;
mod mesh_surface;
pub mod support;

use std::sync::Arc;

use glam::{DMat3, DQuat, DVec3};

use crate::geometry::hull::extreme_hull;
use crate::geometry::mass_properties::MassProperties;
use crate::geometry::principal_curvature::Curvature;
use crate::geometry::sharp_place::SharpPlace;
pub use crate::geometry::solid::MeshError;
use crate::material::Material;
use crate::pose::{Pose, Track};
pub use link::{JointKind, Link, LinkEnd};
pub use mesh_surface::MeshSurface;
use support::Support;

/// Index of a body in [`World::bodies`]; bodies that are born later follow, in the order of their births.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BodyId(pub u32);

impl BodyId {
    /// The immovable surroundings, where a contact has no second body.
    pub const WORLD: BodyId = BodyId(u32::MAX);

    /// Position in [`World::bodies`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// The surface of a body, in the body frame (origin at the centre of mass).
#[allow(clippy::large_enum_variant, reason = "a surface lies behind an Arc, once per body")]
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// A sphere about the centre of mass.
    Sphere {
        /// Radius \[m\].
        radius: f64,
    },
    /// A half-space, solid where `normal · (x − position) < 0`. Always fixed; the body frame's y axis is the
    /// normal.
    HalfSpace,
    /// The upper face of an endless plate: for motion a half-space, but it gives way and radiates as a plate.
    Plate {
        /// Thickness \[m\].
        thickness: f64,
    },
    /// Any other closed surface.
    Mesh(MeshSurface),
}

impl Surface {
    /// The same surface with all lengths multiplied by `factor`.
    pub fn scaled(self, factor: f64) -> Self {
        match self {
            Surface::Sphere { radius } => Surface::Sphere { radius: radius * factor },
            Surface::HalfSpace => Surface::HalfSpace,
            Surface::Plate { thickness } => Surface::Plate { thickness: thickness * factor },
            Surface::Mesh(surface) => Surface::Mesh(surface.scaled(factor)),
        }
    }

    /// Whether it is flat and endless: a half-space, or the upper face of a plate.
    pub fn is_plane(&self) -> bool {
        matches!(self, Surface::HalfSpace | Surface::Plate { .. })
    }

    /// Radius of the smallest ball about the centre of mass that holds the body \[m\]; infinite for a
    /// half-space.
    pub fn bounding_radius(&self) -> f64 {
        match self {
            Surface::Sphere { radius } => *radius,
            Surface::HalfSpace | Surface::Plate { .. } => f64::INFINITY,
            Surface::Mesh(surface) => surface.mesh.bounding_radius(DVec3::ZERO),
        }
    }

    /// Outward unit normal at the point of the surface nearest to `point_body` \[m, body frame\]; `None` at
    /// the centre of a sphere and for an open surface.
    pub fn normal_at(&self, point_body: DVec3) -> Option<DVec3> {
        match self {
            Surface::Sphere { .. } => point_body.try_normalize(),
            Surface::HalfSpace | Surface::Plate { .. } => Some(DVec3::Y),
            Surface::Mesh(surface) => surface.normal_at(point_body),
        }
    }

    /// Principal curvatures at the point of the surface nearest to `point_body` \[m, body frame\].
    pub fn curvature_at(&self, point_body: DVec3) -> Curvature {
        match self {
            Surface::Sphere { radius } => Curvature::isotropic(radius.recip()),
            Surface::HalfSpace | Surface::Plate { .. } => Curvature::FLAT,
            Surface::Mesh(surface) => surface.curvature_at(point_body),
        }
    }

    /// The crease or corner within `tolerance` \[m\] of the point of the surface nearest to `point_body`
    /// \[m, body frame\].
    pub fn sharp_place_at(&self, point_body: DVec3, tolerance: f64) -> Option<SharpPlace> {
        match self {
            Surface::Sphere { .. } | Surface::HalfSpace | Surface::Plate { .. } => None,
            Surface::Mesh(surface) => surface.sharp_place_at(point_body, tolerance),
        }
    }

    /// Volume over the volume of the convex hull of the points that lie farthest in a hundred directions:
    /// about 1 for convex bodies, and up to 1.08 where the surface is curved.
    pub fn hull_filling(&self) -> f64 {
        match self {
            Surface::Sphere { .. } | Surface::HalfSpace | Surface::Plate { .. } => 1.0,
            Surface::Mesh(surface) => {
                let hull = extreme_hull(&surface.mesh, 100).and_then(|hull| MassProperties::of(&hull));
                // A degenerate hull has no volume: the ratio is zero.
                hull.map_or(0.0, |hull| surface.volume / hull.volume)
            }
        }
    }

    /// Radius of the sphere of equal volume \[m\]; infinite for a half-space.
    pub fn equal_volume_radius(&self) -> f64 {
        match self {
            Surface::Sphere { radius } => *radius,
            Surface::HalfSpace | Surface::Plate { .. } => f64::INFINITY,
            Surface::Mesh(surface) => (0.75 * surface.volume / std::f64::consts::PI).cbrt(),
        }
    }
}

/// Cause of a body's motion.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// Gravity, contacts and links.
    Free,
    /// No motion.
    Fixed,
    /// A prescribed track; contacts do not move it.
    Keyframed(Track),
    /// A track until it is let go, or under a limited force.
    Guided(Guide),
}

/// A hand that leads a body along a track, and may let it go.
#[derive(Clone, Debug, PartialEq)]
pub struct Guide {
    /// Where it leads the body.
    pub track: Track,
    /// Largest force \[N\] against whatever keeps the body from the track, beyond what its mass and weight
    /// take. `None`: any force, so that contacts do not move the body, as with
    /// [`Keyframed`](Motion::Keyframed).
    pub press: Option<f64>,
    /// When it lets go \[s\], with the velocity of the track; the body is free afterwards. `None`: never.
    pub let_go: Option<f64>,
}

impl Motion {
    /// Whether forces move the body, at least at times.
    pub fn is_movable(&self) -> bool {
        match self {
            Motion::Free | Motion::Guided(_) => true,
            Motion::Fixed | Motion::Keyframed(_) => false,
        }
    }

    /// Whether forces move the body at a time \[s\].
    pub fn is_movable_at(&self, time: f64) -> bool {
        match self {
            Motion::Guided(Guide { press: None, let_go, .. }) => let_go.is_some_and(|let_go| time >= let_go),
            motion => motion.is_movable(),
        }
    }

    /// The track on which the body is led, if it is.
    pub fn track(&self) -> Option<&Track> {
        match self {
            Motion::Free | Motion::Fixed => None,
            Motion::Keyframed(track) | Motion::Guided(Guide { track, .. }) => Some(track),
        }
    }
}

/// Span of existence of a body. A body that breaks dies, and its pieces are born at the same instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Life {
    /// First instant \[s\]; 0 for a body present from the beginning.
    pub birth: f64,
    /// Last instant \[s\]; infinite for a body that does not break.
    pub death: f64,
    /// The body of which it is a piece; `None` for a body of the scene.
    pub parent: Option<BodyId>,
}

/// Tolerance between the time of a birth and those of events at that instant \[s\].
const ROUNDING: f64 = 1e-9;

impl Life {
    /// From the beginning and without end.
    pub const LASTING: Life = Life { birth: 0.0, death: f64::INFINITY, parent: None };

    /// Of a piece of `parent`, from `birth` \[s\] on.
    pub fn of_piece(parent: BodyId, birth: f64) -> Self {
        Life { birth, parent: Some(parent), ..Life::LASTING }
    }

    /// Whether the body exists at a time \[s\], up to rounding; both ends are included.
    pub fn holds(&self, time: f64) -> bool {
        (self.birth <= 0.0 || time >= self.birth - ROUNDING) && time <= self.death + ROUNDING
    }
}

impl Default for Life {
    fn default() -> Self {
        Life::LASTING
    }
}

/// A body at the beginning of its existence.
///
/// ```
/// use clangor_core::body::Body;
/// use clangor_core::glam::DVec3;
/// use clangor_core::material::presets;
///
/// let resting = Body::sphere("resting", presets::STEEL.material(), 0.01);
/// let flying = Body::sphere("flying", presets::STEEL.material(), 0.01)
///     .at(DVec3::X * 0.1)
///     .with_velocity(DVec3::X * -1.0);
/// assert_eq!(resting.mass, flying.mass);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Name, unique in the world.
    pub name: String,
    /// Material.
    pub material: Material,
    /// Surface; shared by the copies of a body.
    pub surface: Arc<Surface>,
    /// Mass \[kg\]; infinite for a half-space.
    pub mass: f64,
    /// Inertia about the centre of mass in the body frame \[kg m²\].
    pub inertia: DMat3,
    /// Pose at birth.
    pub pose: Pose,
    /// Velocity of the centre of mass at birth \[m/s\].
    pub velocity: DVec3,
    /// Angular velocity at birth \[rad/s\], world frame.
    pub angular_velocity: DVec3,
    /// Cause of its motion.
    pub motion: Motion,
    /// Lower bound of the local contact radius \[m\], for edges and vertices, where mesh curvature is
    /// meaningless.
    pub edge_radius: f64,
    /// Span of its existence.
    pub life: Life,
    /// What holds it; empty for a body that nothing holds.
    pub supports: Vec<Support>,
}

/// Largest relative difference of mass and inertia that is due to the facets of a mesh: the tetrahedra of a
/// body that breaks leave some percent of a round body out.
const OF_FACETS: f64 = 0.05;
/// Distance of the centre of mass of a body from that of its form, over the bounding radius, that counts as
/// none.
pub const OFF_CENTRE: f64 = 0.02;

/// Default edge radius as a fraction of the bounding radius.
pub const EDGE_RADIUS_RATIO: f64 = 0.02;

impl Body {
    /// A free body at rest, with its centre of mass at the origin and the axes of the world.
    ///
    /// `mass` \[kg\] and `inertia` \[kg m²\], about the centre of mass in the body frame, are taken as they
    /// are.
    /// The edge radius is [`EDGE_RADIUS_RATIO`] of the bounding radius.
    pub fn new(
        name: impl Into<String>,
        material: Material,
        surface: impl Into<Arc<Surface>>,
        mass: f64,
        inertia: DMat3,
    ) -> Self {
        let surface = surface.into();
        Body {
            name: name.into(),
            material,
            edge_radius: EDGE_RADIUS_RATIO * surface.bounding_radius(),
            surface,
            mass,
            inertia,
            pose: Pose::IDENTITY,
            velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
            motion: Motion::Free,
            life: Life::LASTING,
            supports: Vec::new(),
        }
    }

    /// A free, homogeneous solid at rest; `unit_density` are the mass properties of its surface at a density
    /// of 1 kg/m³.
    pub fn solid(
        name: impl Into<String>,
        material: Material,
        surface: impl Into<Arc<Surface>>,
        unit_density: &MassProperties,
    ) -> Self {
        let mass = material.density * unit_density.volume;
        let inertia = unit_density.inertia * material.density;
        Body::new(name, material, surface, mass, inertia)
    }

    /// Mass properties at unit density of the homogeneous solid within its surface, in the frame of the body.
    ///
    /// What vibrates and what radiates depends on them; the motion depends on [`mass`](Self::mass) and
    /// [`inertia`](Self::inertia).
    pub fn homogeneous(&self) -> MassProperties {
        self.form_of_uneven().unwrap_or_else(|| self.at_unit_density())
    }

    /// The same if the body is not that solid, because its mass, centre of mass or inertia were given.
    pub fn form_of_uneven(&self) -> Option<MassProperties> {
        let own = self.at_unit_density();
        let form = match &*self.surface {
            Surface::Sphere { radius } => MassProperties::of_sphere(*radius),
            Surface::HalfSpace | Surface::Plate { .. } => return None,
            Surface::Mesh(surface) => surface.solid()?,
        };
        let size = form.inertia.to_cols_array().into_iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let is_same = (own.volume - form.volume).abs() <= OF_FACETS * form.volume
            && own.inertia.abs_diff_eq(form.inertia, OF_FACETS * size)
            && form.centre_of_mass.length() <= OFF_CENTRE * self.surface.bounding_radius();
        (!is_same).then_some(form)
    }

    fn at_unit_density(&self) -> MassProperties {
        let density = self.material.density;
        let volume = self.mass / density;
        MassProperties { volume, centre_of_mass: DVec3::ZERO, inertia: self.inertia * density.recip() }
    }

    /// A free, solid sphere of a `radius` \[m\], at rest at the origin.
    pub fn sphere(name: impl Into<String>, material: Material, radius: f64) -> Self {
        Body::solid(name, material, Surface::Sphere { radius }, &MassProperties::of_sphere(radius))
    }

    /// A fixed half-space through `point` \[m\] with the outward unit `normal`; mass and inertia are
    /// infinite.
    pub fn plane(name: impl Into<String>, material: Material, point: DVec3, normal: DVec3) -> Self {
        Body {
            name: name.into(),
            material,
            surface: Arc::new(Surface::HalfSpace),
            mass: f64::INFINITY,
            inertia: DMat3::from_diagonal(DVec3::INFINITY),
            pose: Pose { position: point, orientation: DQuat::from_rotation_arc(DVec3::Y, normal) },
            velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
            motion: Motion::Fixed,
            edge_radius: 0.0,
            life: Life::LASTING,
            supports: Vec::new(),
        }
    }

    /// A fixed endless plate of a `thickness` \[m\] whose upper face goes through `point` \[m\]; `normal` is
    /// the unit normal of that face.
    pub fn plate(
        name: impl Into<String>,
        material: Material,
        (point, normal): (DVec3, DVec3),
        thickness: f64,
    ) -> Self {
        let surface = Arc::new(Surface::Plate { thickness });
        Body { surface, ..Body::plane(name, material, point, normal) }
    }

    /// The same body at another pose; a point \[m\] is the pose there with the axes of the world.
    #[must_use]
    pub fn at(self, pose: impl Into<Pose>) -> Self {
        Body { pose: pose.into(), ..self }
    }

    /// The same body with another velocity of its centre of mass \[m/s\].
    #[must_use]
    pub fn with_velocity(self, velocity: DVec3) -> Self {
        Body { velocity, ..self }
    }

    /// The same body with another angular velocity \[rad/s\], world frame.
    #[must_use]
    pub fn with_angular_velocity(self, angular_velocity: DVec3) -> Self {
        Body { angular_velocity, ..self }
    }

    /// The same body with another cause of motion.
    #[must_use]
    pub fn with_motion(self, motion: Motion) -> Self {
        Body { motion, ..self }
    }

    /// The same body with another edge radius \[m\].
    #[must_use]
    pub fn with_edge_radius(self, edge_radius: f64) -> Self {
        Body { edge_radius, ..self }
    }

    /// The same body with other supports.
    #[must_use]
    pub fn with_supports(self, supports: Vec<Support>) -> Self {
        Body { supports, ..self }
    }

    /// The same body with another span of existence.
    #[must_use]
    pub fn with_life(self, life: Life) -> Self {
        Body { life, ..self }
    }
}

/// The dynamic system at t = 0: bodies, links and gravity.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    /// The bodies; a [`BodyId`] is an index into them.
    pub bodies: Vec<Body>,
    /// Springs and suspended spheres.
    pub links: Vec<Link>,
    /// Gravity \[m/s²\].
    pub gravity: DVec3,
}

impl World {
    /// The first body of a name.
    pub fn body_named(&self, name: &str) -> Option<BodyId> {
        self.bodies.iter().position(|body| body.name == name).map(|index| BodyId(index as u32))
    }
}
