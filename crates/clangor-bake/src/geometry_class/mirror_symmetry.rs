//! Planes through the centre of mass that map a solid onto itself.
//!
//! A mirror plane of a solid is one of its inertia tensor, so that the principal axes are the candidates
//! where the moments differ. Equal moments leave a plane or a sphere of directions. There the extrema of the
//! quartic form Q(d) = ∫ (d·x)⁴ dS and the phases of the moments ∫ (x + iy)^m dS about the distinct axis are
//! candidates too. The coordinate axes are always candidates. A candidate is accepted if the mirrored
//! surface lies on the surface, or is off by noise alone: its vertices, and points spread over its faces. A
//! hole whose corners lie on the image of the surface has faces that do not.
//!
//! A scan has noise, and triangles that cut off its edges. Half of it and its image stand for the body, so
//! that the surface moves by half of the distances δ. To first order the change of a field is ∫ δ w dS with
//! a kernel w that is as smooth as waves and walls: of distances without a mean, what is left in a patch of
//! n independent ones is δ/√n. Their mean in patches is bounded, therefore, and the distances themselves
//! more loosely.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::principal_axes::principal_axes;
use clangor_core::geometry::surface_tree::{NearestPoint, SurfaceTree};
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::{DMat3, DVec3};
use num_complex::Complex64;

use crate::quadrature::parts_of_triangle;

/// Largest number of mirrored vertices, and of triangles of the quartic form.
const SAMPLES: usize = 3000;
/// Parts of the surface, each with a point of its own; of smaller faces at most as many.
const PARTS: usize = 20_000;
/// Most points along the edge of a face.
const MOST_ALONG: f64 = 100.0;
/// Relative difference below which moments count as equal.
const EQUAL: f64 = 2e-3;
/// Largest residual of a noisy surface, over what the means in patches may be.
pub const NOISE: f64 = 20.0;
/// The root of the mean square of all residuals, over the same.
const ROUGH: f64 = 4.0;
/// The largest residual between the vertices of a curved surface, over that of the vertices.
const BETWEEN: f64 = 4.0;
/// Edge of a patch in bounding radii.
const PATCH: f64 = 0.25;
/// Highest order of mirror symmetry about an axis.
const HIGHEST_FOLD: i32 = 8;

/// A plane of symmetry through the centre of mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorPlane {
    /// Unit normal.
    pub normal: DVec3,
    /// Largest distance of a mirrored point from the surface \[m\].
    pub residual: f64,
}

/// Up to three orthogonal planes of symmetry of a closed surface, the best first; residuals are at most
/// `tolerance` \[m\] at vertices, and four times as much between them.
///
/// Normals along coordinate axes are exact. A surface that encloses no solid has none.
pub fn mirror_planes(mesh: &TriMesh, tolerance: f64) -> Vec<MirrorPlane> {
    mirror_planes_within(mesh, &Within { largest: tolerance, mean: 0.0, deepest: 0.0 })
}

/// The same for a surface with noise: residuals are at most `tolerance` \[m\]; or their means in patches are
/// at most `mean` in the root of the mean square, they themselves four times as much, and the largest is
/// [`NOISE`] times as much.
///
/// With k times `mean` ≤ 2ε the phase of the sound of a patch changes by less than ε.
pub fn mirror_planes_in_mean(mesh: &TriMesh, tolerance: f64, mean: f64) -> Vec<MirrorPlane> {
    mirror_planes_within(mesh, &Within { largest: tolerance, mean, deepest: NOISE * mean })
}

/// The same for walls: all residuals are at most `tolerance` \[m\]; or their means in patches, they
/// themselves four times as much, and the largest is at most `deepest` \[m\].
pub fn mirror_planes_of_walls(mesh: &TriMesh, tolerance: f64, deepest: f64) -> Vec<MirrorPlane> {
    mirror_planes_within(mesh, &Within { largest: tolerance, mean: tolerance, deepest })
}

/// What residuals may be \[m\].
struct Within {
    /// Those of vertices without noise.
    largest: f64,
    /// Root of the mean square of their means in patches.
    mean: f64,
    /// The largest of noise.
    deepest: f64,
}

fn mirror_planes_within(mesh: &TriMesh, within: &Within) -> Vec<MirrorPlane> {
    let Ok(mass) = MassProperties::of(mesh) else { return Vec::new() };
    let centred = mesh.relative_to(mass.centre_of_mass);
    let tree = SurfaceTree::new(&centred);
    let mut tried: Vec<DVec3> = Vec::new();
    let mut found: Vec<MirrorPlane> = Vec::new();
    // Test each candidate normal.
    for normal in candidates(&centred, mass.inertia) {
        // Duplicate directions: keep the first, which has the rounder components.
        if tried.iter().any(|d| d.cross(normal).length() < 1e-6) {
            continue;
        }
        tried.push(normal);
        if let Some(residual) = residual(&centred, &tree, normal, within) {
            found.push(MirrorPlane { normal, residual });
        }
        // A fourth one is not worth its time.
        if largest_set(&found).len() == 3 {
            break;
        }
    }
    // Residuals at rounding level count as equal; the order of the candidates decides.
    let rounding = 1e-9 * centred.bounding_radius(DVec3::ZERO);
    found.sort_by(|a, b| a.residual.max(rounding).total_cmp(&b.residual.max(rounding)));
    orthogonal(largest_set(&found))
}

/// Most orthogonal planes, starting from the best plane that has partners.
fn largest_set(found: &[MirrorPlane]) -> Vec<MirrorPlane> {
    let mut best: Vec<MirrorPlane> = Vec::new();
    for first in found {
        let mut set = vec![*first];
        for next in found {
            if set.iter().all(|p| p.normal.dot(next.normal).abs() < 1e-3) {
                set.push(*next);
            }
        }
        if set.len() > best.len() {
            best = set;
        }
    }
    best
}

/// Makes nearly orthogonal normals exactly so.
fn orthogonal(planes: Vec<MirrorPlane>) -> Vec<MirrorPlane> {
    let mut result: Vec<MirrorPlane> = Vec::new();
    for plane in planes {
        let normal = result.iter().fold(plane.normal, |n, p| n - n.dot(p.normal) * p.normal).normalize();
        result.push(MirrorPlane { normal, ..plane });
    }
    result
}

/// Largest distance of a mirrored point from the surface, if the distances are small enough.
fn residual(mesh: &TriMesh, tree: &SurfaceTree, normal: DVec3, within: &Within) -> Option<f64> {
    let between = BETWEEN * within.largest;
    let reach = between.max(within.deepest).next_up();
    let patch = PATCH * mesh.bounding_radius(DVec3::ZERO);
    let image = |point: DVec3| point - 2.0 * point.dot(normal) * normal;
    let place = |image: DVec3| (image / patch).floor().as_i64vec3().to_array();
    let signed = |image: DVec3, nearest: &NearestPoint| {
        let outward = (image - nearest.position).dot(mesh.area_vector(nearest.triangle));
        nearest.distance.copysign(outward)
    };
    let (mut distances, mut largest) = (Distances::default(), 0.0_f64);
    // A coarse sample of the vertices first, which rejects most candidates.
    let step = mesh.vertices.len().div_ceil(SAMPLES).max(1);
    for stride in [61 * step, step] {
        distances = Distances::default();
        for vertex in mesh.vertices.iter().step_by(stride) {
            let image = image(*vertex);
            let nearest = tree.nearest_where(mesh, image, reach, |_| true)?;
            largest = largest.max(nearest.distance);
            distances.add(signed(image, &nearest), place(image));
        }
    }
    let exact = largest <= within.largest.next_up();
    // Points of the faces; they lie inside of a curved surface where the vertices lie on it.
    let area = |t: usize| 0.5 * mesh.area_vector(t).length();
    let part = (0..mesh.triangles.len()).map(area).sum::<f64>() / PARTS as f64;
    let stride = mesh.triangles.len().div_ceil(PARTS);
    for t in 0..mesh.triangles.len() {
        let along = (area(t) / part).sqrt().ceil().clamp(1.0, MOST_ALONG) as usize;
        if along == 1 && !t.is_multiple_of(stride) {
            continue;
        }
        let [a, b, c] = mesh.corners(t);
        for [u, v] in parts_of_triangle(along) {
            let image = image(a + u * (b - a) + v * (c - a));
            let nearest = tree.nearest_where(mesh, image, reach, |_| true)?;
            distances.add(signed(image, &nearest), place(image));
            largest = largest.max(nearest.distance);
        }
    }
    if exact && largest <= between.next_up() {
        return Some(largest);
    }
    let is_noise = distances.mean() <= ROUGH * within.mean && distances.mean_of_patches() <= within.mean;
    is_noise.then_some(largest)
}

/// Signed distances from a surface \[m\].
#[derive(Default)]
struct Distances {
    squares: f64,
    number: f64,
    /// Sum and number in each cell of space.
    patches: BTreeMap<[i64; 3], (f64, f64)>,
}

impl Distances {
    fn add(&mut self, distance: f64, cell: [i64; 3]) {
        self.squares += distance * distance;
        self.number += 1.0;
        let patch = self.patches.entry(cell).or_default();
        patch.0 += distance;
        patch.1 += 1.0;
    }

    /// Root of the mean square.
    fn mean(&self) -> f64 {
        (self.squares / self.number.max(1.0)).sqrt()
    }

    /// The same of the means in patches.
    fn mean_of_patches(&self) -> f64 {
        let squares: f64 = self.patches.values().map(|(sum, number)| sum * sum / number).sum();
        (squares / self.number.max(1.0)).sqrt()
    }
}

/// Directions that may be normals of mirror planes.
fn candidates(mesh: &TriMesh, inertia: DMat3) -> Vec<DVec3> {
    let (moments, axes) = principal_axes(inertia);
    let axes = [axes.x_axis, axes.y_axis, axes.z_axis];
    let mut directions = DVec3::AXES.to_vec();
    directions.extend(axes);
    let equal = |i: usize, j: usize| (moments[i] - moments[j]).abs() < EQUAL * moments[2];
    match (equal(0, 1), equal(1, 2)) {
        (false, false) => {}
        (true, true) => {
            let quartic = quartic_extrema(mesh);
            for axis in &quartic {
                directions.extend(around(mesh, *axis));
            }
            directions.extend(quartic);
        }
        (true, false) => directions.extend(around(mesh, axes[2])),
        (false, true) => directions.extend(around(mesh, axes[0])),
    }
    directions
}

/// Normals of possible mirror planes that contain `axis`.
fn around(mesh: &TriMesh, axis: DVec3) -> Vec<DVec3> {
    let (u, v) = axis.any_orthonormal_pair();
    let weighted = |t: usize| {
        let x = mesh.centroid(t);
        (mesh.area_vector(t).length(), Complex64::new(x.dot(u), x.dot(v)))
    };
    let points: Vec<(f64, Complex64)> = (0..mesh.triangles.len()).map(weighted).collect();
    let mut normals = Vec::new();
    for m in 1..=HIGHEST_FOLD {
        let moment: Complex64 = points.iter().map(|(a, z)| a * z.powi(m)).sum();
        let most: f64 = points.iter().map(|(a, z)| a * z.norm().powi(m)).sum();
        // A vanishing moment has no phase.
        if moment.norm() < 1e-6 * most {
            continue;
        }
        for k in 0..m {
            let plane = (moment.arg() + PI * f64::from(k)) / f64::from(m);
            let normal = Complex64::from_polar(1.0, plane + 0.5 * PI);
            normals.push(normal.re * u + normal.im * v);
        }
    }
    normals
}

/// Directions d that maximise or minimise ∫ (d·x)⁴ dS.
fn quartic_extrema(mesh: &TriMesh) -> Vec<DVec3> {
    let step = mesh.triangles.len().div_ceil(SAMPLES).max(1);
    let points: Vec<(f64, DVec3)> = (0..mesh.triangles.len())
        .step_by(step)
        .map(|t| (mesh.area_vector(t).length(), mesh.centroid(t)))
        .collect();
    let gradient = |d: DVec3| points.iter().map(|(a, x)| a * d.dot(*x).powi(3) * *x).sum::<DVec3>();
    let scale: f64 = points.iter().map(|(a, x)| a * x.length_squared().powi(2)).sum();
    let starts =
        [DVec3::ONE, DVec3::new(1.0, 0.3, -0.2), DVec3::new(-0.2, 1.0, 0.4), DVec3::new(0.1, -0.3, 1.0)];
    let mut extrema = Vec::new();
    // Ascent by the power method; with a dominating shift, descent.
    for sign in [1.0, -1.0] {
        for start in starts {
            let mut d = start.normalize();
            for _ in 0..200 {
                d = (sign * gradient(d) + scale * d).normalize_or(DVec3::X);
            }
            extrema.push(d);
        }
    }
    extrema
}
