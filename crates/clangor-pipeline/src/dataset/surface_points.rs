//! Random points of a surface, even by area: a triangle with a chance by its area, and within it
//!
//! ```text
//! x = (1 − √u) a + √u (1 − v) b + √u v c        u, v even in [0, 1)
//! ```
//!
//! Source: R. Osada et al. 2002, "Shape distributions". The inside of a vessel is surface as well.

use clangor_core::body::Surface;
use clangor_core::glam::DVec3;

use super::draws::Draws;

/// The areas of the triangles of a surface, added up.
#[derive(Clone, Debug)]
pub(super) struct SurfacePoints {
    /// Area of the triangles up to each one \[m²\].
    areas: Vec<f64>,
}

impl SurfacePoints {
    pub(super) fn new(surface: &Surface) -> Self {
        let Surface::Mesh(surface) = surface else { return SurfacePoints { areas: Vec::new() } };
        let mesh = &surface.mesh;
        let areas = (0..mesh.triangles.len()).map(|triangle| mesh.area_vector(triangle).length());
        let up_to = areas.scan(0.0, |sum, area| {
            *sum += area;
            Some(*sum)
        });
        SurfacePoints { areas: up_to.collect() }
    }

    /// A point of the surface that these areas belong to \[m, frame of the body\].
    pub(super) fn draw(&self, surface: &Surface, draws: &mut Draws) -> DVec3 {
        match surface {
            Surface::Mesh(surface) => {
                let wanted = draws.share() * self.areas.last().copied().unwrap_or(0.0);
                let last = self.areas.len().saturating_sub(1);
                let triangle = self.areas.partition_point(|area| *area <= wanted).min(last);
                let [a, b, c] =
                    surface.mesh.triangles[triangle].map(|node| surface.mesh.vertices[node as usize]);
                let (root, v) = (draws.share().sqrt(), draws.share());
                a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v)
            }
            Surface::Sphere { radius } => *radius * on_sphere(draws.share(), draws.share()),
            Surface::HalfSpace | Surface::Plate { .. } => DVec3::ZERO,
        }
    }
}

/// A direction, even over the sphere for two even shares.
fn on_sphere(height: f64, turn: f64) -> DVec3 {
    let y = 2.0 * height - 1.0;
    let across = (1.0 - y * y).max(0.0).sqrt();
    let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
    DVec3::new(across * cos, y, across * sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::draws::Quantity;
    use crate::session::StruckBody;

    #[test]
    fn analytic_points_are_even_by_area() {
        const COUNT: u64 = 20_000;
        let body = StruckBody::shape("box:0.2x0.1x0.05", "steel").unwrap();
        let surface = &*body.body().surface;
        let points = SurfacePoints::new(surface);
        let draw = |i| points.draw(surface, &mut Draws::of(3, i, Quantity::Point));
        let on_top = (0..COUNT).filter(|i| draw(*i).y > 0.05 - 1e-12).count() as f64 / COUNT as f64;
        // 0.2 × 0.05 of 2 (0.02 + 0.005 + 0.01) m²; standard deviation 0.0025, residual seen 0.001.
        assert!((on_top - 0.01 / 0.07).abs() < 0.01, "{on_top}");
        let mean = (0..COUNT).map(draw).sum::<DVec3>() / COUNT as f64;
        // Standard deviation 0.0005 m, residual seen 0.0004 m.
        assert!(mean.length() < 2e-3, "{mean}");

        let ball = Surface::Sphere { radius: 0.1 };
        let points = SurfacePoints::new(&ball);
        let high = (0..COUNT).filter(|i| points.draw(&ball, &mut Draws::of(3, *i, Quantity::Point)).y > 0.05);
        // A cap of half a radius is a quarter of the sphere; residual seen 0.003.
        assert!((high.count() as f64 / COUNT as f64 - 0.25).abs() < 0.01);
    }
}
