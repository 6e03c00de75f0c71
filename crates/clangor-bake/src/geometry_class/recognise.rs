//! The class of a mesh: an ellipsoid, a box, a box with rounded edges, a body of revolution, or none of
//! these.
//!
//! The solvers are cheaper and sharper on exact forms. The form is read off the mesh and not off the scene,
//! so that a shape, a mesh file and a timeline's copy of either have the same model. What counts as the same
//! body is decided by [`agreement`](super::agreement) alone.
//!
//! A mesh of no exact form may still be a body of revolution but for its facets and the roughness of its
//! triangles; it then has the section that [`detect_axisymmetry`](super::detect_axisymmetry) fits to it. The
//! axis may have any direction; y is tried first. Boxes and ellipsoids lie along x, y and z.

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::principal_axes::principal_axes;
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;

use super::agreement::MEASURES;
use super::bake_geometry::{BakeGeometry, rotation_to};
use super::detect_axisymmetry::fitted_meridian;
use super::exact_forms::{revolution_form, symmetric_form};

/// Grid to which the components of an axis are rounded: mass properties have noise below it.
const AXIS_GRID: f64 = 1e-7;
/// Distance of the centre of mass from the origin, over the bounding radius, that facets do not explain.
const OFF_CENTRE: f64 = 2e-3;

impl BakeGeometry {
    /// The class of a mesh about its centre of mass. A mesh about another point is none of the classes: the
    /// solvers of their forms turn them about their own centre.
    pub fn of_mesh(mesh: &TriMesh) -> Self {
        if is_off_centre(mesh) {
            return BakeGeometry::Mesh(mesh.clone());
        }
        let fitted =
            |mesh: &TriMesh| fitted_meridian(mesh).map(|fit| BakeGeometry::axisymmetric(fit.meridian));
        symmetric_form(mesh)
            .or_else(|| revolution_form(mesh))
            .or_else(|| fitted(mesh))
            .or_else(|| about_other_axes(mesh, &revolution_form))
            .or_else(|| about_other_axes(mesh, &fitted))
            .unwrap_or_else(|| BakeGeometry::Mesh(mesh.clone()))
    }

    /// The exact form that a mesh about its centre of mass samples; `None` for meshes whose section would
    /// have to be fitted, and for all others.
    pub fn exact_form(mesh: &TriMesh) -> Option<Self> {
        if is_off_centre(mesh) {
            return None;
        }
        symmetric_form(mesh)
            .or_else(|| revolution_form(mesh))
            .or_else(|| about_other_axes(mesh, &revolution_form))
    }
}

/// Whether the origin is not the centre of mass of the homogeneous solid, but for facets.
fn is_off_centre(mesh: &TriMesh) -> bool {
    let away = MassProperties::of(mesh).map_or(0.0, |mass| mass.centre_of_mass.length());
    away > OFF_CENTRE * mesh.bounding_radius(DVec3::ZERO)
}

/// What `find` finds about y, in copies of the mesh whose possible axis of revolution has been turned there.
fn about_other_axes(mesh: &TriMesh, find: &dyn Fn(&TriMesh) -> Option<BakeGeometry>) -> Option<BakeGeometry> {
    candidate_axes(mesh).into_iter().find_map(|axis| {
        let back = rotation_to(axis).inverse();
        let vertices = mesh.vertices.iter().map(|v| back * *v).collect();
        match find(&TriMesh { vertices, triangles: mesh.triangles.clone() })? {
            BakeGeometry::Axisymmetric { meridian, .. } => {
                Some(BakeGeometry::Axisymmetric { meridian, axis })
            }
            _ => None,
        }
    })
}

/// Axes other than y, in both directions, about which both other principal moments are equal.
fn candidate_axes(mesh: &TriMesh) -> Vec<DVec3> {
    let Ok(mass) = MassProperties::of(mesh) else { return Vec::new() };
    let (moments, axes) = principal_axes(mass.inertia);
    let equal = |i: usize, j: usize| (moments[i] - moments[j]).abs() <= MEASURES * moments[2];
    let rounded = |axis: DVec3| ((axis / AXIS_GRID).round() * AXIS_GRID).normalize();
    match (equal(0, 1), equal(1, 2)) {
        // No distinct axis: a cylinder as high as √3 radii.
        (true, true) => vec![DVec3::X, DVec3::Z],
        (true, false) => vec![rounded(axes.z_axis)],
        (false, true) => vec![rounded(axes.x_axis)],
        (false, false) => Vec::new(),
    }
    .into_iter()
    .flat_map(|axis| [axis, -axis])
    .filter(|axis| axis.dot(DVec3::Y) < 1.0 - AXIS_GRID)
    .collect()
}
