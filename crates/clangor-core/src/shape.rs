//! Named shapes: what a scene writes as `coin:0.01213x0.00175@0.0005` instead of a mesh file.
//!
//! A [`Shape`] makes a watertight mesh at a chosen edge length and the convex parts that stand for it in
//! collisions, both in one frame: metres, axis of revolution y, the middle at the origin unless its form says
//! otherwise. [`text`] has the grammar and the sizes of bare names.

mod axisymmetric;
mod cuboid;
mod key;
mod mug;
mod planar;
mod rock;
mod sphere;
pub mod text;
mod vessel;

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use crate::body::{MeshSurface, Surface};
use crate::geometry::convex::ConvexPart;
use crate::geometry::mass_properties::MassProperties;
use crate::geometry::meridian::Meridian;
use crate::geometry::refine::refine_to_edge;
use crate::geometry::solid::MeshError;
use crate::geometry::tri_mesh::TriMesh;

pub use text::ShapeError;

/// Sectors into which a ring is cut for collisions.
const RING_SECTORS: usize = 24;

/// A shape with its sizes \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// A sphere.
    Sphere {
        /// Radius.
        radius: f64,
    },
    /// An ellipsoid.
    Ellipsoid {
        /// Semi-axes along x, y, z.
        semi_axes: DVec3,
    },
    /// A box.
    Box {
        /// Full edges along x, y, z.
        edges: DVec3,
    },
    /// A cube with rounded edges and corners.
    Die {
        /// Full edge.
        size: f64,
        /// Radius of the rounding; 0 for a sharp cube.
        round: f64,
    },
    /// A circular cylinder about y.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Full height.
        height: f64,
    },
    /// A torus about y.
    Torus {
        /// Radius of the circle that the tube follows.
        major: f64,
        /// Radius of the tube.
        minor: f64,
    },
    /// A convex stone; its centre of mass is the origin.
    Rock {
        /// Which stone.
        seed: u64,
        /// Radius of the ball of equal volume.
        radius: f64,
    },
    /// A regular prism about y.
    Prism {
        /// Number of sides.
        sides: u32,
        /// Radius of the circle through the corners.
        radius: f64,
        /// Full height.
        height: f64,
    },
    /// A flat convex splinter in the plane of x and z.
    Shard {
        /// Which splinter.
        seed: u64,
        /// Longer axis of the ellipse through its corners; the thickness is 8 % of it.
        size: f64,
    },
    /// A bowl, 148 mm wide, on the plane y = 0.
    Bowl,
    /// A plate, 260 mm wide, on the plane y = 0.
    Plate,
    /// A mug with a handle towards +x, 98 mm high, on the plane y = 0.
    Mug,
    /// A wineglass, 142 mm high, on the plane y = 0.
    Wineglass,
    /// A hollow sphere with a hole in its top, 110 mm wide, on the plane y = 0.
    Moneybox,
    /// A key in the plane of x and z, 53 mm long; the hole is about y at the origin.
    Key,
}

/// A shape and the edge length of its mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    form: Form,
    edge: f64,
    /// The hull of a rock.
    hull: Option<TriMesh>,
}

impl Shape {
    /// Reads a shape, such as `box:0.1x0.2x0.05`; see [`text`].
    ///
    /// # Errors
    /// [`ShapeError`] says what was expected, with an example.
    pub fn parse(text: &str) -> Result<Self, ShapeError> {
        text::parse(text)
    }

    /// A shape of a form; without an `edge` \[m\] the mesh has the form's own.
    ///
    /// # Errors
    /// [`ShapeError`] for sizes that are not finite, not positive or do not fit together, an edge longer than
    /// the shape, or one so short that the mesh would exceed [`text::MOST_TRIANGLES`].
    pub fn try_new(form: Form, edge: Option<f64>) -> Result<Self, ShapeError> {
        text::check_form(&form)?;
        let hull = match form {
            Form::Rock { seed, radius } => Some(rock::rock_hull(seed, radius)?),
            _ => None,
        };
        let shape = Shape { form, edge: default_edge(&form), hull };
        match edge {
            Some(edge) => shape.with_edge(edge),
            None => Ok(shape),
        }
    }

    /// The same shape with another edge length \[m\].
    ///
    /// # Errors
    /// [`ShapeError::Edge`] as in [`try_new`](Self::try_new).
    pub fn with_edge(mut self, edge: f64) -> Result<Self, ShapeError> {
        text::check_edge(&self, edge)?;
        self.edge = edge;
        Ok(self)
    }

    /// What the shape is.
    pub fn form(&self) -> &Form {
        &self.form
    }

    /// Edge length of the mesh \[m\]: edges are about this long or, where the shape demands it, shorter.
    pub fn edge(&self) -> f64 {
        self.edge
    }

    /// Radius \[m\] if the shape is a sphere, which dynamics and sound treat exactly.
    pub fn sphere_radius(&self) -> Option<f64> {
        match self.form {
            Form::Sphere { radius } => Some(radius),
            _ => None,
        }
    }

    /// The surface as a mesh.
    pub fn mesh(&self) -> TriMesh {
        let edge = self.edge;
        match self.form {
            Form::Sphere { radius } => sphere::ellipsoid_mesh(DVec3::splat(radius), edge),
            Form::Ellipsoid { semi_axes } => sphere::ellipsoid_mesh(semi_axes, edge),
            Form::Box { edges } => cuboid::box_mesh(edges, edge),
            Form::Die { size, round: 0.0 } => cuboid::box_mesh(DVec3::splat(size), edge),
            Form::Die { size, round } => cuboid::die_mesh(size, round, edge),
            Form::Cylinder { radius, height } => axisymmetric::cylinder_profile(radius, height, edge).turn(),
            Form::Torus { major, minor } => axisymmetric::torus_profile(major, minor, edge).turn(),
            Form::Prism { sides, radius, height } => {
                planar::thicken(&planar::polygon_mesh(&planar::regular(sides, radius), edge), height, edge)
            }
            Form::Shard { seed, size } => {
                let flat = planar::polygon_mesh(&planar::shard_outline(seed, size), edge);
                planar::thicken(&flat, planar::SHARD_THICKNESS * size, edge)
            }
            Form::Bowl => vessel::bowl_profile(edge).turn(),
            Form::Plate => vessel::plate_profile(edge).turn(),
            Form::Mug => mug::mug_mesh(edge),
            Form::Wineglass => vessel::wineglass_profile(edge).turn(),
            Form::Moneybox => vessel::moneybox_profile(edge).turn(),
            Form::Key => key::key_mesh(edge),
            Form::Rock { .. } => refine_to_edge(self.hull.as_ref().unwrap_or(&TriMesh::default()), edge),
        }
    }

    /// The exact section, in the frame of the mesh, if the shape is a body of revolution about y.
    pub fn meridian(&self) -> Option<Meridian> {
        let edge = self.edge;
        match self.form {
            Form::Sphere { radius } => Meridian::spheroid(radius, radius).ok(),
            Form::Ellipsoid { semi_axes } if semi_axes.x == semi_axes.z => {
                Meridian::spheroid(semi_axes.x, semi_axes.y).ok()
            }
            Form::Cylinder { radius, height } => {
                axisymmetric::cylinder_profile(radius, height, edge).meridian()
            }
            Form::Torus { major, minor } => axisymmetric::torus_profile(major, minor, edge).meridian(),
            Form::Bowl => vessel::bowl_profile(edge).meridian(),
            Form::Plate => vessel::plate_profile(edge).meridian(),
            Form::Wineglass => vessel::wineglass_profile(edge).meridian(),
            Form::Moneybox => vessel::moneybox_profile(edge).meridian(),
            _ => None,
        }
    }

    /// The convex parts whose union collides, in the frame of the mesh.
    ///
    /// Spheres, boxes, sharp dice, cylinders, rocks, prisms and shards are exact. The surface of the others
    /// is off by at most, measured by `tests/property/shape_meshes.rs`: ellipsoid 0.9 % of the largest
    /// semi-axis; die 3.4 % of its rounding; torus 0.8 % of its outer radius; bowl 1.1 mm, plate 0.4 mm, mug
    /// 0.6 mm, wineglass 1 mm, moneybox 1 mm, key ring and key 0.1 mm.
    pub fn parts(&self) -> Vec<ConvexPart> {
        match self.form {
            Form::Sphere { radius } => vec![ConvexPart::Ball { centre: DVec3::ZERO, radius }],
            Form::Ellipsoid { semi_axes } => {
                vec![ConvexPart::Hull(sphere::ellipsoid_hull(semi_axes))]
            }
            Form::Box { edges } => vec![ConvexPart::Hull(cuboid::box_corners(edges))],
            Form::Die { size, round: 0.0 } => vec![ConvexPart::Hull(cuboid::box_corners(DVec3::splat(size)))],
            Form::Die { size, round } => vec![ConvexPart::Hull(cuboid::die_hull(size, round))],
            Form::Cylinder { radius, height } => vec![ConvexPart::Cylinder {
                centre: DVec3::ZERO,
                axis: DVec3::Y,
                radius,
                half_height: 0.5 * height,
            }],
            Form::Torus { major, minor } => axisymmetric::torus_parts(major, minor, RING_SECTORS),
            Form::Prism { sides, radius, height } => {
                vec![planar::slab(&planar::regular(sides, radius), height)]
            }
            Form::Shard { seed, size } => {
                vec![planar::slab(&planar::shard_outline(seed, size), planar::SHARD_THICKNESS * size)]
            }
            Form::Bowl => vessel::bowl_parts(),
            Form::Plate => vessel::plate_parts(),
            Form::Mug => mug::mug_parts(),
            Form::Wineglass => vessel::wineglass_parts(),
            Form::Moneybox => vessel::moneybox_parts(),
            Form::Key => key::key_parts(),
            Form::Rock { .. } => {
                self.hull.iter().map(|hull| ConvexPart::Hull(hull.vertices.clone())).collect()
            }
        }
    }

    /// Mass properties in closed form, where there is one; the centre of mass is the origin.
    fn exact_mass(&self) -> Option<MassProperties> {
        let (volume, moments) = match self.form {
            Form::Sphere { radius } => (4.0 / 3.0 * PI * radius.powi(3), DVec3::splat(0.4 * radius * radius)),
            Form::Ellipsoid { semi_axes } => {
                let squares = semi_axes * semi_axes;
                let moments = (DVec3::splat(squares.element_sum()) - squares) / 5.0;
                (4.0 / 3.0 * PI * semi_axes.element_product(), moments)
            }
            Form::Box { edges } => {
                let squares = edges * edges;
                (edges.element_product(), (DVec3::splat(squares.element_sum()) - squares) / 12.0)
            }
            Form::Cylinder { radius, height } => {
                let across = 0.25 * radius * radius + height * height / 12.0;
                (PI * radius * radius * height, DVec3::new(across, 0.5 * radius * radius, across))
            }
            Form::Torus { major, minor } => {
                let across = 0.5 * major * major + 0.625 * minor * minor;
                let about = major * major + 0.75 * minor * minor;
                (2.0 * PI * PI * major * minor * minor, DVec3::new(across, about, across))
            }
            _ => return None,
        };
        let inertia = DMat3::from_diagonal(moments * volume);
        Some(MassProperties { volume, centre_of_mass: DVec3::ZERO, inertia })
    }

    /// The surface about the centre of mass, and the mass properties in the frame of [`mesh`](Self::mesh):
    /// those of the mesh, or exact where a closed form is known (sphere, ellipsoid, box, cylinder, torus).
    ///
    /// # Errors
    /// [`MeshError`] if the mesh does not bound a solid.
    pub fn surface(&self) -> Result<(Surface, MassProperties), MeshError> {
        let exact = self.exact_mass();
        if let (Form::Sphere { radius }, Some(mass)) = (self.form, exact) {
            return Ok((Surface::Sphere { radius }, mass));
        }
        let (surface, mass) = MeshSurface::try_new(self.mesh(), self.parts())?;
        Ok((Surface::Mesh(surface), exact.unwrap_or(mass)))
    }
}

/// Edge length \[m\] that gives a few thousand triangles; a thousand for rocks, which come by the hundred.
fn default_edge(form: &Form) -> f64 {
    match *form {
        Form::Sphere { radius } => radius / 12.0,
        Form::Ellipsoid { semi_axes } => semi_axes.max_element() / 16.0,
        Form::Box { edges } => edges.max_element() / 16.0,
        Form::Die { size, .. } => size / 16.0,
        Form::Cylinder { radius, height } => (radius / 24.0).max(height / 100.0),
        Form::Torus { minor, major } => (0.25 * minor).max(major / 60.0),
        Form::Rock { radius, .. } => radius / 4.0,
        Form::Prism { radius, height, .. } => (radius / 12.0).max(height / 40.0),
        Form::Shard { size, .. } => size / 24.0,
        Form::Bowl | Form::Mug | Form::Moneybox => 0.0035,
        Form::Plate => 0.005,
        Form::Wineglass => 0.0025,
        Form::Key => 0.0006,
    }
}
