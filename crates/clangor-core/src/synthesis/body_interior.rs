//! Test whether a point lies inside a body, where receivers get no pressure.

use glam::DVec3;

use crate::body::Surface;

/// Whether a point \[m\] is in a body of this bounding radius \[m\].
pub(crate) fn inside(surface: &Surface, bounding_radius: f64, point_body: DVec3) -> bool {
    match surface {
        Surface::Sphere { radius } => point_body.length() < *radius,
        Surface::HalfSpace => point_body.y < 0.0,
        Surface::Plate { thickness } => point_body.y < 0.0 && point_body.y > -thickness,
        Surface::Mesh(mesh) => point_body.length() < bounding_radius && mesh.contains(point_body),
    }
}
