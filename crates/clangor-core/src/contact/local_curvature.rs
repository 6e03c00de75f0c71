//! Mean curvature H of a body's surface at the contact point. The radius of the local sphere of \[PAN\] §3.2
//! is 1/H.

use glam::DVec3;

use crate::body::Surface;

/// Mean curvature H = (κ₁+κ₂)/2 [1/m] at `point_body` [m, body frame]; 0 on a half-space, 1/R on a sphere.
pub fn mean_curvature(surface: &Surface, point_body: DVec3) -> f64 {
    match surface {
        Surface::Sphere { radius } => 1.0 / radius,
        Surface::HalfSpace => 0.0,
        Surface::Mesh(mesh) => mesh.mean_curvature_at(point_body),
    }
}
