//! Whether a triangle mesh bounds a solid, and if not, what is wrong and where.
//!
//! Mass properties, sound and collision all assume a closed surface that separates inside from outside. A
//! mesh may have several components: they move as one rigid body. One inside another must be a cavity, wound
//! inwards, so that no volume counts twice.

use super::components::{Component, components_of};
use super::mass_properties::MassProperties;
pub use super::mesh_error::MeshError;
use super::mesh_error::check_numbers;
use super::self_intersection::first_self_intersection;
use super::surface_tree::SurfaceTree;
use super::topology::Topology;
use super::tri_mesh::TriMesh;

/// What [`check_solid`] found out about a good mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidReport {
    /// Mass properties of the solid.
    pub mass: MassProperties,
    /// Number of connected components, cavities included.
    pub components: usize,
    /// Area \[m²\].
    pub area: f64,
}

/// Checks that a mesh bounds a solid.
///
/// # Errors
/// The first [`MeshError`] found: numbers, then triangles without area, then coincident vertices (before open
/// edges, because welding is the remedy for both), then edges, then the orientation and volume of a single
/// component, then crossings, then the orientation of several components.
pub fn check_solid(mesh: &TriMesh) -> Result<SolidReport, MeshError> {
    check(mesh, true)
}

/// As [`check_solid`] for a mesh that is known not to cross itself, which takes most of the time to find out.
pub(super) fn check_uncrossed(mesh: &TriMesh) -> Result<SolidReport, MeshError> {
    check(mesh, false)
}

fn check(mesh: &TriMesh, may_cross: bool) -> Result<SolidReport, MeshError> {
    check_numbers(mesh)?;
    check_triangles(mesh)?;
    check_duplicates(mesh)?;
    let topology = Topology::try_new(mesh)?;
    let (components, piece) = topology.components();
    // A single inverted surface is distinguished from a crossing one before its triangles are compared.
    let single = if components == 1 { Some(MassProperties::of(mesh)?) } else { None };
    if may_cross && let Some(crossing) = first_self_intersection(mesh, &topology, &SurfaceTree::new(mesh)) {
        return Err(crossing);
    }
    let mass = match single {
        Some(mass) => mass,
        None => {
            check_nesting(mesh, components, &piece)?;
            MassProperties::of(mesh)?
        }
    };
    Ok(SolidReport { mass, components, area: mesh.area() })
}

/// Rejects triangles whose height is below 1e-10 of their longest edge: their normal is rounding noise.
fn check_triangles(mesh: &TriMesh) -> Result<(), MeshError> {
    let flat = |t: &usize| {
        let [a, b, c] = mesh.corners(*t);
        let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
        2.0 * mesh.area_vector(*t).length() <= 1e-10 * longest
    };
    let mut bad = (0..mesh.triangles.len()).filter(flat);
    match bad.next() {
        Some(triangle) => {
            let position = mesh.centroid(triangle);
            Err(MeshError::Degenerate { count: 1 + bad.count(), triangle, position })
        }
        None => Ok(()),
    }
}

/// Rejects vertices in use that have exactly equal coordinates.
fn check_duplicates(mesh: &TriMesh) -> Result<(), MeshError> {
    let mut used = vec![false; mesh.vertices.len()];
    mesh.triangles.iter().flatten().for_each(|i| used[*i as usize] = true);
    let mut order: Vec<usize> = (0..used.len()).filter(|i| used[*i]).collect();
    let key = |i: usize| mesh.vertices[i].to_array().map(|x| x + 0.0);
    let compare = |i: &usize, j: &usize| {
        let (a, b) = (key(*i), key(*j));
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2])).then(i.cmp(j))
    };
    order.sort_unstable_by(compare);
    let twins = || order.windows(2).filter(|w| mesh.vertices[w[0]] == mesh.vertices[w[1]]);
    match twins().next() {
        Some(pair) => Err(MeshError::Duplicate { count: twins().count(), position: mesh.vertices[pair[0]] }),
        None => Ok(()),
    }
}

/// Components at even depth must face outwards, components at odd depth (cavities) inwards.
fn check_nesting(mesh: &TriMesh, components: usize, piece: &[u32]) -> Result<(), MeshError> {
    for Component { part, volume, depth } in components_of(mesh, components, piece) {
        let position = part.vertices[0];
        let cavity = depth % 2 == 1;
        match (cavity, volume < 0.0) {
            (false, true) => return Err(MeshError::Inverted { volume, position }),
            (true, false) => return Err(MeshError::Nested { position }),
            _ => {}
        }
    }
    Ok(())
}
