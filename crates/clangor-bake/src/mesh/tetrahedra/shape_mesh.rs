//! The volume mesh of a named shape: a structured grid where one exists, otherwise isosurface stuffing.

use clangor_core::shape::{Form, Shape};
use glam::DVec3;

use super::{TetMesh, ball, block, cylinder};
use crate::mesh::tetrahedra::isosurface_stuffing::{StuffingError, stuff};

/// A mesh with elements of about `edge` \[m\], shorter where the shape requires it, in the frame of the
/// shape's surface mesh.
///
/// # Errors
/// [`StuffingError`] for an edge that is not positive, or a surface that cannot be filled.
pub fn shape_mesh(shape: &Shape, edge: f64) -> Result<TetMesh, StuffingError> {
    if !(edge > 0.0 && edge.is_finite()) {
        return Err(StuffingError::Edge(edge));
    }
    let count = |length: f64| (length / edge).ceil().max(1.0) as usize;
    let even = |length: f64| 2 * count(0.5 * length);
    let mesh = match *shape.form() {
        Form::Sphere { radius } => ball::ellipsoid(DVec3::splat(radius), count(radius)),
        Form::Ellipsoid { semi_axes } => ball::ellipsoid(semi_axes, count(semi_axes.max_element())),
        Form::Box { edges } => block::block(edges, edges.to_array().map(count)),
        Form::Die { size, round: 0.0 } => block::block(DVec3::splat(size), [count(size); 3]),
        Form::Cylinder { radius, height } => {
            cylinder::cylinder(radius, height, even(2.0 * radius), count(height))
        }
        Form::Torus { major, minor } => {
            let around = count(std::f64::consts::TAU * (major + minor)).max(8);
            cylinder::torus(major, minor, even(2.0 * minor), around)
        }
        _ => {
            let surface = shape.clone().with_edge(edge.min(shape.edge())).unwrap_or_else(|_| shape.clone());
            return Ok(stuff(&surface.mesh(), edge)?.0);
        }
    };
    Ok(mesh?)
}
