//! Mean curvature of a body's surface where it is touched: the radius of the local sphere of \[PAN\] §3.2 is 1/H.

use glam::DVec3;

use crate::body::Surface;

/// Mean curvature H = (κ₁+κ₂)/2 [1/m] at `point_body` [m, body frame]; 0 on a half-space, 1/R on a sphere.
pub fn mean_curvature(surface: &Surface, point_body: DVec3) -> f64 {
    match surface {
        Surface::Sphere { radius } => 1.0 / radius,
        Surface::HalfSpace => 0.0,
        Surface::Mesh(mesh) => {
            let distances = mesh.mesh.vertices.iter().map(|v| v.distance_squared(point_body));
            let nearest = distances.zip(&mesh.mean_curvature).min_by(|a, b| a.0.total_cmp(&b.0));
            nearest.map_or(0.0, |(_, curvature)| *curvature)
        }
    }
}
