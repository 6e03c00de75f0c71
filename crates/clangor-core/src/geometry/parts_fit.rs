//! Accuracy of convex parts as approximation of a surface: how far their union protrudes or falls short.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::convex::ConvexPart;
use super::hull::convex_hull;
use super::refine::refine_to_edge;
use super::solid::MeshError;
use super::surface_tree::SurfaceTree;
use super::tri_mesh::TriMesh;

/// Distances between a surface and the union of its convex parts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartsFit {
    /// Largest height of the union above the surface \[m\]: contacts come early by this much.
    pub outside: f64,
    /// Largest depth of the union below the surface \[m\]: contacts come late by this much.
    pub inside: f64,
}

impl PartsFit {
    /// The larger of the two \[m\].
    pub fn worst(&self) -> f64 {
        self.outside.max(self.inside)
    }
}

/// Measures parts against the closed surface that they approximate, on samples `spacing` \[m\] apart.
///
/// The boundary of the union is sampled, and its distance to the surface taken. Vertices and centroids of the
/// surface outside all parts count with their distance to the nearest part. Both distances are exact, so the
/// result is a lower bound that converges to the true value as the samples become dense.
///
/// # Errors
/// [`MeshError`] for a part without volume or a surface that is not closed.
pub fn measure_parts(mesh: &TriMesh, parts: &[ConvexPart], spacing: f64) -> Result<PartsFit, MeshError> {
    let tree = SurfaceTree::new(mesh);
    let nudge = 1e-7 * mesh.diagonal();
    let solids = parts.iter().map(Solid::try_new).collect::<Result<Vec<_>, _>>()?;
    let mut fit = PartsFit::default();
    for (k, solid) in solids.iter().enumerate() {
        for (point, normal) in solid.surface_samples(spacing) {
            // Walls shared by two parts are inside the union.
            let beyond = point + normal * nudge;
            if solids.iter().enumerate().any(|(j, other)| j != k && other.contains(beyond, 0.1 * nudge)) {
                continue;
            }
            let distance =
                tree.signed_distance(mesh, point).ok_or(MeshError::Open { edges: 1, position: point })?;
            fit.outside = fit.outside.max(distance);
            fit.inside = fit.inside.max(-distance);
        }
    }
    let centroids = (0..mesh.triangles.len()).map(|t| mesh.centroid(t));
    for point in mesh.vertices.iter().copied().chain(centroids) {
        if !solids.iter().any(|solid| solid.contains(point, 0.0)) {
            let nearest = solids.iter().fold(f64::INFINITY, |best, s| s.distance_below(point, best));
            fit.inside = fit.inside.max(nearest);
        }
    }
    Ok(fit)
}

/// A convex part, ready for queries.
enum Solid {
    Ball { centre: DVec3, radius: f64 },
    Cylinder { centre: DVec3, axis: DVec3, radius: f64, half_height: f64 },
    Hull { mesh: TriMesh, tree: SurfaceTree, planes: Vec<(DVec3, f64)>, low: DVec3, high: DVec3 },
}

impl Solid {
    fn try_new(part: &ConvexPart) -> Result<Self, MeshError> {
        Ok(match part {
            ConvexPart::Ball { centre, radius } => Solid::Ball { centre: *centre, radius: *radius },
            ConvexPart::Cylinder { centre, axis, radius, half_height } => {
                Solid::Cylinder { centre: *centre, axis: *axis, radius: *radius, half_height: *half_height }
            }
            ConvexPart::Hull(points) => {
                let mesh = convex_hull(points)?;
                let plane = |t| {
                    let normal = mesh.area_vector(t).normalize();
                    (normal, normal.dot(mesh.corners(t)[0]))
                };
                let planes = (0..mesh.triangles.len()).map(plane).collect();
                let (low, high) = mesh.bounds();
                Solid::Hull { tree: SurfaceTree::new(&mesh), planes, low, high, mesh }
            }
        })
    }

    /// Whether a point is inside or at most `slack` \[m\] outside.
    fn contains(&self, point: DVec3, slack: f64) -> bool {
        match self {
            Solid::Hull { planes, low, high, .. } => {
                point.cmpge(*low - slack).all()
                    && point.cmple(*high + slack).all()
                    && planes.iter().all(|(normal, height)| normal.dot(point) <= *height + slack)
            }
            _ => self.distance(point) <= slack,
        }
    }

    /// Distance of a point outside \[m\].
    fn distance(&self, point: DVec3) -> f64 {
        match self {
            Solid::Ball { centre, radius } => point.distance(*centre) - radius,
            Solid::Cylinder { centre, axis, radius, half_height } => {
                let along = (point - *centre).dot(*axis);
                let above = along.abs() - half_height;
                let beside = (point - *centre - *axis * along).length() - radius;
                if above > 0.0 && beside > 0.0 { above.hypot(beside) } else { above.max(beside) }
            }
            Solid::Hull { mesh, tree, .. } => tree.nearest(mesh, point).map_or(f64::INFINITY, |n| n.distance),
        }
    }

    /// The smaller of `best` and the distance of a point outside \[m\].
    fn distance_below(&self, point: DVec3, best: f64) -> f64 {
        match self {
            Solid::Hull { low, high, .. } if point.distance(point.clamp(*low, *high)) >= best => best,
            _ => best.min(self.distance(point)),
        }
    }

    /// Points of the surface and the outward normals there, about `spacing` \[m\] apart.
    fn surface_samples(&self, spacing: f64) -> Vec<(DVec3, DVec3)> {
        match self {
            Solid::Ball { centre, radius } => {
                let count = (4.0 * PI * (radius / spacing).powi(2)).clamp(50.0, 1e4) as usize;
                spiral(count).map(|normal| (*centre + normal * *radius, normal)).collect()
            }
            Solid::Cylinder { centre, axis, radius, half_height } => {
                let side = axis.any_orthonormal_vector();
                let across = axis.cross(side);
                let around = (TAU * radius / spacing).clamp(24.0, 1e3) as usize;
                let levels = (2.0 * half_height / spacing).clamp(4.0, 1e3) as usize;
                let rings = (radius / spacing).clamp(4.0, 1e3) as usize;
                let mut samples = Vec::new();
                for k in 0..around {
                    let (sin, cos) = (TAU * k as f64 / around as f64).sin_cos();
                    let spoke = side * cos + across * sin;
                    for level in 0..=levels {
                        let height = half_height * (2.0 * level as f64 / levels as f64 - 1.0);
                        samples.push((*centre + *axis * height + spoke * *radius, spoke));
                    }
                    for ring in 0..=rings {
                        let out = *centre + spoke * (radius * ring as f64 / rings as f64);
                        samples.extend([1.0, -1.0].map(|s| (out + *axis * (s * half_height), *axis * s)));
                    }
                }
                samples
            }
            Solid::Hull { mesh, .. } => {
                let fine = refine_to_edge(mesh, spacing);
                let of_triangle = |t| {
                    let normal = fine.area_vector(t).normalize_or_zero();
                    let centroid = fine.centroid(t);
                    // Corners a little inside their face, where its normal holds.
                    let [a, b, c] = fine.corners(t).map(|v| v.lerp(centroid, 1e-3));
                    [a, b, c, centroid].map(|point| (point, normal))
                };
                (0..fine.triangles.len()).flat_map(of_triangle).collect()
            }
        }
    }
}

/// Unit vectors spread evenly: a golden spiral.
fn spiral(count: usize) -> impl Iterator<Item = DVec3> {
    let golden_angle = PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |k| {
        let y = 1.0 - (2 * k + 1) as f64 / count as f64;
        let (sin, cos) = (golden_angle * k as f64).sin_cos();
        let level = (1.0 - y * y).sqrt();
        DVec3::new(level * cos, y, level * sin)
    })
}
