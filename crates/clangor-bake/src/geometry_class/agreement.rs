//! Whether a mesh and an exact form are the same body.
//!
//! Vertices on a form do not suffice: those of a thin disc lie on the two large faces of the square around
//! it. A form counts if all of these hold:
//!
//! - volume, area and principal moments (of rounded boxes and of rings per unit of mass): [`MEASURES`],
//!   of an exact torus [`TORUS_MEASURES`];
//! - vertices from an exact form: [`ON_FORM`] of the bounding radius;
//! - the corners of a triangle: on one smooth face of an exact form;
//! - a triangle's centroid from the form, and a sample of the form from triangles that face as it does:
//!   [`NEAR`]
//!   of the thickness of the body behind it, and [`FARTHEST`] or [`FARTHEST_FITTED`] of the bounding radius.
//!
//! Of a fitted section, triangles of [`STRAY_AREA`] of the surface may be farther than [`NEAR`] allows: noise
//! tilts slivers, behind which the body looks thin.
//!
//! The thickness is that of the mesh along the inward normal: that of a disc behind its faces, its diameter
//! behind its rim. The section fitted to facets and roughness lies between them, so that its vertices have
//! [`FARTHEST_FITTED`] of the bounding radius.

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::principal_axes::principal_axes;
use clangor_core::geometry::surface_tree::{NearestPoint, SurfaceTree};
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;

use super::bake_geometry::BakeGeometry;
use super::form_surface::FormSurface;

/// Largest relative difference of volume, area and principal moments of form and mesh.
pub const MEASURES: f64 = 0.01;
/// The same of an exact torus: the shape library's have 16 to 26 chords around their section.
pub const TORUS_MEASURES: f64 = 0.03;
/// Largest distance of a vertex from an exact form, over the bounding radius: files keep 7 digits.
pub const ON_FORM: f64 = 2e-6;
/// Largest distance between the facets of a mesh and a form, over the local thickness.
pub const NEAR: f64 = 0.1;
/// Largest distance between a mesh and an exact form, over the bounding radius.
pub const FARTHEST: f64 = 0.01;
/// The same of a fitted form: a prism of 32 sides lies within it, one of 16 does not.
pub const FARTHEST_FITTED: f64 = 0.006;
/// Share of the surface in triangles that may be farther than [`NEAR`] allows. Seen: one to five triangles
/// of messy bowls, plates and wine glasses, 3 of 8600 at most.
pub const STRAY_AREA: f64 = 1e-3;
/// Least cosine between the normals of a sample and of the triangle near it.
const SAME_WAY: f64 = 0.5;
/// Most smooth faces of an exact form.
const MOST_FACES: usize = 64;

/// Whether a mesh samples an exact form: one whose axis of revolution, if it has one, is y.
pub(super) fn samples_exactly(mesh: &TriMesh, form: &BakeGeometry) -> bool {
    let Some(surface) = FormSurface::of(form).filter(|s| s.faces() <= MOST_FACES) else { return false };
    // The cheapest test first, which rejects nearly all other bodies.
    let radius = mesh.bounding_radius(DVec3::ZERO);
    let Some(on_faces) = faces_of_vertices(mesh, &surface, ON_FORM * radius) else { return false };
    if !measures_agree(mesh, form, tolerance_of(form)) {
        return false;
    }
    let tree = SurfaceTree::new(mesh);
    let body = Body { mesh, tree: &tree, radius, farthest: FARTHEST * radius };
    // From the mesh to the form.
    let follows = |t: usize| {
        let common = mesh.triangles[t].iter().fold(u64::MAX, |bits, v| bits & on_faces[*v as usize]);
        let centroid = mesh.centroid(t);
        let distance = (0..surface.faces())
            .filter(|face| common >> face & 1 == 1)
            .map(|face| surface.distance(face, centroid))
            .fold(f64::INFINITY, f64::min);
        distance <= ON_FORM * radius || distance <= body.tolerance(centroid, t)
    };
    // From the form to the mesh.
    (0..mesh.triangles.len()).all(follows) && body.covers(&surface)
}

/// Whether a section fitted to a mesh that is axisymmetric about y, but for its facets and roughness, is the
/// mesh's.
pub(super) fn follows_roughly(mesh: &TriMesh, tree: &SurfaceTree, form: &BakeGeometry) -> bool {
    let Some(surface) = FormSurface::of(form) else { return false };
    let radius = mesh.bounding_radius(DVec3::ZERO);
    let body = Body { mesh, tree, radius, farthest: FARTHEST_FITTED * radius };
    let distance =
        |x: DVec3| (0..surface.faces()).map(|face| surface.distance(face, x)).fold(f64::INFINITY, f64::min);
    // A vertex may belong to two sides of an edge, of different thickness; the triangles decide.
    let stray_area = || {
        (0..mesh.triangles.len()).try_fold(0.0, |area, t| {
            let off = distance(mesh.centroid(t));
            let strays = off > body.tolerance(mesh.centroid(t), t);
            let area = if strays { area + mesh.area_vector(t).length() } else { area };
            (off <= body.farthest).then_some(area)
        })
    };
    measures_agree(mesh, form, MEASURES)
        && mesh.vertices.iter().all(|v| distance(*v) <= body.farthest)
        && stray_area().is_some_and(|area| area <= STRAY_AREA * mesh.area())
        && body.covers(&surface)
}

/// For each vertex, the faces of a form that it lies on, as bits; `None` if one lies on none.
fn faces_of_vertices(mesh: &TriMesh, surface: &FormSurface, tolerance: f64) -> Option<Vec<u64>> {
    let on = |v: &DVec3| {
        let bits = (0..surface.faces())
            .filter(|face| surface.distance(*face, *v) <= tolerance)
            .fold(0_u64, |bits, face| bits | 1 << face);
        (bits != 0).then_some(bits)
    };
    mesh.vertices.iter().map(on).collect()
}

/// Largest relative difference of the measures of an exact form.
pub(super) fn tolerance_of(form: &BakeGeometry) -> f64 {
    match form {
        BakeGeometry::Axisymmetric { meridian, .. } if meridian.is_loop() => TORUS_MEASURES,
        _ => MEASURES,
    }
}

/// Whether volume, area and principal moments agree.
fn measures_agree(mesh: &TriMesh, form: &BakeGeometry, tolerance: f64) -> bool {
    let (Ok(own), Ok(other)) = (MassProperties::of(mesh), form.mass_properties()) else { return false };
    let agree = |a: f64, b: f64| (a - b).abs() <= tolerance * b;
    // Per unit of mass for a rounded box and a ring: a small rounding of few facets loses most far from the
    // middle.
    let rounded = match form {
        BakeGeometry::RoundedBox { round, .. } => *round > 0.0,
        BakeGeometry::Axisymmetric { meridian, .. } => meridian.is_loop(),
        _ => false,
    };
    let scale = if rounded { own.volume / other.volume } else { 1.0 };
    let (moments, _) = principal_axes(own.inertia);
    let (others, _) = principal_axes(other.inertia * scale);
    agree(other.volume, own.volume)
        && agree(form.area(), mesh.area())
        && (0..3).all(|k| agree(others[k], moments[k]))
        && own.centre_of_mass.distance(other.centre_of_mass) <= FARTHEST * mesh.bounding_radius(DVec3::ZERO)
}

/// Thickness of a body behind a point of a triangle \[m\].
pub(super) fn thickness(
    mesh: &TriMesh,
    tree: &SurfaceTree,
    (point, triangle): (DVec3, usize),
    radius: f64,
) -> f64 {
    let inward = -mesh.area_vector(triangle).normalize_or_zero();
    let (across, _) = inward.any_orthonormal_pair();
    // A ray may slip through between two triangles that meet exactly on it.
    let rays = [0.0, 1e-3, -1e-3].map(|tilt| (inward + tilt * across).normalize_or_zero());
    let hits = rays.into_iter().filter_map(|ray| tree.first_hit(mesh, point, ray, 1e-9 * radius));
    hits.fold(f64::INFINITY, f64::min).min(2.0 * radius)
}

/// A mesh about its centre of mass.
struct Body<'a> {
    mesh: &'a TriMesh,
    tree: &'a SurfaceTree,
    /// Bounding radius \[m\].
    radius: f64,
    /// Largest distance of the form \[m\].
    farthest: f64,
}

impl Body<'_> {
    /// Largest distance \[m\] allowed at a point of a triangle.
    fn tolerance(&self, point: DVec3, triangle: usize) -> f64 {
        let behind = thickness(self.mesh, self.tree, (point, triangle), self.radius);
        (NEAR * behind).min(self.farthest)
    }

    /// Whether all of a form lies near triangles of the mesh that face the same way.
    fn covers(&self, surface: &FormSurface) -> bool {
        let faces =
            |t: usize, normal: DVec3| self.mesh.area_vector(t).normalize_or_zero().dot(normal) >= SAME_WAY;
        surface.samples().into_iter().all(|(p, normal)| {
            let reach = self.farthest.next_up();
            let nearest = self.tree.nearest_where(self.mesh, p, reach, |t| faces(t, normal));
            nearest.is_some_and(|NearestPoint { position, triangle, distance, .. }| {
                distance <= ON_FORM * self.radius || distance <= self.tolerance(position, triangle)
            })
        })
    }
}
