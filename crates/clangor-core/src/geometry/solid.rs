//! Whether a triangle mesh bounds a solid, and if not, what is wrong and where.
//!
//! Mass properties, sound and collision all assume a closed surface that separates inside from outside. A
//! mesh may have several components: they move as one rigid body. One inside another must be a cavity, wound
//! inwards, so that no volume counts twice.

use glam::DVec3;

use super::mass_properties::MassProperties;
use super::self_intersection::first_self_intersection;
use super::surface_tree::SurfaceTree;
use super::topology::Topology;
use super::tri_mesh::TriMesh;

/// What is wrong with a mesh. Positions are in the frame of the mesh \[m\].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// Nothing to bound a solid.
    #[error("the mesh has no triangles")]
    Empty,
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names vertex {index}, but there are {vertices} vertices")]
    IndexOutOfRange {
        /// The triangle.
        triangle: usize,
        /// The index.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A coordinate is infinite or not a number.
    #[error("vertex {vertex} is not finite")]
    NotFinite {
        /// The vertex.
        vertex: usize,
    },
    /// A triangle has no area: corners coincide or lie on a line.
    #[error(
        "{count} triangles have no area, the first is triangle {triangle} near {position}; weld or remesh"
    )]
    Degenerate {
        /// How many.
        count: usize,
        /// The first of them.
        triangle: usize,
        /// Where it is.
        position: DVec3,
    },
    /// Vertices coincide.
    #[error("{count} vertices coincide with another, the first at {position}; weld the mesh")]
    Duplicate {
        /// How many vertices could go.
        count: usize,
        /// Where the first is.
        position: DVec3,
    },
    /// Edges with a triangle on one side only.
    #[error(
        "the surface is open: {edges} boundary edges, one near {position}; close the holes, weld the mesh, or \
         give the shell a thickness"
    )]
    Open {
        /// How many edges.
        edges: usize,
        /// Middle of the first.
        position: DVec3,
    },
    /// Edges with more than two triangles.
    #[error("{edges} edges have more than two triangles, one near {position}")]
    NonManifold {
        /// How many edges.
        edges: usize,
        /// Middle of the first.
        position: DVec3,
    },
    /// Neighbouring triangles wind in opposite senses.
    #[error("triangles wind inconsistently across {edges} edges, one near {position}; recompute the normals")]
    Winding {
        /// How many edges.
        edges: usize,
        /// Middle of the first.
        position: DVec3,
    },
    /// The surface faces inwards.
    #[error("the surface near {position} faces inwards (volume {volume:.3e} m³); flip the triangles")]
    Inverted {
        /// Signed volume \[m³\].
        volume: f64,
        /// Where.
        position: DVec3,
    },
    /// The surface encloses nothing.
    #[error("the mesh encloses no volume ({volume:.3e} m³)")]
    NoVolume {
        /// Signed volume \[m³\].
        volume: f64,
    },
    /// A component lies inside another and is no cavity.
    #[error("a component near {position} lies inside another, so that its volume would count twice")]
    Nested {
        /// A vertex of the inner component.
        position: DVec3,
    },
    /// Two triangles cross.
    #[error("the surface crosses itself: triangles {first} and {second}, near {position}")]
    SelfIntersection {
        /// One triangle.
        first: usize,
        /// The other.
        second: usize,
        /// Where.
        position: DVec3,
    },
}

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

/// Checks that indices are in range and coordinates finite.
pub(super) fn check_numbers(mesh: &TriMesh) -> Result<(), MeshError> {
    if mesh.triangles.is_empty() {
        return Err(MeshError::Empty);
    }
    let vertices = mesh.vertices.len();
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        if let Some(index) = corners.iter().copied().find(|i| *i as usize >= vertices) {
            return Err(MeshError::IndexOutOfRange { triangle, index, vertices });
        }
    }
    match mesh.vertices.iter().position(|v| !v.is_finite()) {
        Some(vertex) => Err(MeshError::NotFinite { vertex }),
        None => Ok(()),
    }
}

/// Checks that a mesh bounds a solid.
///
/// # Errors
/// The first [`MeshError`] found: numbers, then triangles without area, then coincident vertices (before open
/// edges, because welding is the remedy for both), then edges, then the orientation and volume of a single
/// component, then crossings, then the orientation of several components.
pub fn check_solid(mesh: &TriMesh) -> Result<SolidReport, MeshError> {
    check_numbers(mesh)?;
    check_triangles(mesh)?;
    check_duplicates(mesh)?;
    let topology = Topology::try_new(mesh)?;
    let (components, piece) = topology.components();
    // A single inverted surface is told apart from a crossing one before its triangles are compared.
    let single = if components == 1 { Some(MassProperties::of(mesh)?) } else { None };
    let tree = SurfaceTree::new(mesh);
    if let Some(crossing) = first_self_intersection(mesh, &topology, &tree) {
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

/// Refuses triangles whose height is below 1e-10 of their longest edge: their normal is rounding noise.
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

/// Refuses vertices in use that have exactly equal coordinates.
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
    let mut parts = vec![TriMesh::default(); components];
    for (t, k) in piece.iter().enumerate() {
        let part = &mut parts[*k as usize];
        let start = part.vertices.len() as u32;
        part.vertices.extend(mesh.corners(t));
        part.triangles.push([start, start + 1, start + 2]);
    }
    let volumes: Vec<f64> = parts.iter().map(|p| winding_volume(p, p.vertices[0])).collect();
    let bounds: Vec<_> = parts.iter().map(TriMesh::bounds).collect();
    for (k, part) in parts.iter().enumerate() {
        let position = part.vertices[0];
        let inside = |other: usize| {
            let (low, high) = bounds[other];
            other != k
                && position.cmpge(low).all()
                && position.cmple(high).all()
                && winding_number(&parts[other], position).abs() > 0.5
        };
        let depth = (0..components).filter(|other| inside(*other)).count();
        let cavity = depth % 2 == 1;
        match (cavity, volumes[k] < 0.0) {
            (false, true) => return Err(MeshError::Inverted { volume: volumes[k], position }),
            (true, false) => return Err(MeshError::Nested { position }),
            _ => {}
        }
    }
    Ok(())
}

/// Signed volume [m³] from tetrahedra to `reference`.
fn winding_volume(mesh: &TriMesh, reference: DVec3) -> f64 {
    let tetrahedron = |t| {
        let [a, b, c] = mesh.corners(t).map(|v| v - reference);
        a.dot(b.cross(c)) / 6.0
    };
    (0..mesh.triangles.len()).map(tetrahedron).sum()
}

/// How often a closed surface winds around a point: the sum of the solid angles over 4π.
///
/// Source: Van Oosterom and Strackee (1983), "The Solid Angle of a Plane Triangle".
fn winding_number(mesh: &TriMesh, point: DVec3) -> f64 {
    let half_angle = |t| {
        let [a, b, c] = mesh.corners(t).map(|v| v - point);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        a.dot(b.cross(c)).atan2(below)
    };
    (0..mesh.triangles.len()).map(half_angle).sum::<f64>() / (2.0 * std::f64::consts::PI)
}
