//! Errors in a triangle mesh that should bound a solid, and the check of its numbers.
//!
//! The check of the whole surface is [`check_solid`](super::solid::check_solid).

use glam::DVec3;

use super::tri_mesh::TriMesh;

/// Error in a mesh. Positions are in the frame of the mesh \[m\].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// An empty mesh.
    #[error("the mesh has no triangles")]
    Empty,
    /// A triangle refers to a missing vertex.
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
        "{count} triangles have no area, the first is triangle {triangle} near {position:.5}; weld or remesh"
    )]
    Degenerate {
        /// Number of such triangles.
        count: usize,
        /// The first of them.
        triangle: usize,
        /// Place of the first.
        position: DVec3,
    },
    /// Vertices coincide.
    #[error("{count} vertices coincide with another, the first at {position:.5}; weld the mesh")]
    Duplicate {
        /// Number of redundant vertices.
        count: usize,
        /// Place of the first.
        position: DVec3,
    },
    /// Edges with a triangle on one side only.
    #[error(
        "the surface is open: {edges} boundary edges, one near {position:.5}; close the holes, weld the \
         mesh, or give the shell a thickness"
    )]
    Open {
        /// Number of edges.
        edges: usize,
        /// Middle of the first.
        position: DVec3,
    },
    /// Edges with more than two triangles.
    #[error(
        "{} more than two triangles, one near {position:.5}; remove faces inside of the body, or separate \
         the parts that touch there",
        if *edges == 1 { "1 edge has".into() } else { format!("{edges} edges have") }
    )]
    NonManifold {
        /// Number of edges.
        edges: usize,
        /// Middle of the first.
        position: DVec3,
    },
    /// Neighbouring triangles wind in opposite senses.
    #[error(
        "triangles wind inconsistently across {edges} edges, one near {position:.5}; recompute the normals"
    )]
    Winding {
        /// Number of edges.
        edges: usize,
        /// Middle of the first.
        position: DVec3,
    },
    /// The surface faces inwards.
    #[error("the surface near {position:.5} faces inwards (volume {volume:.3e} m³); flip the triangles")]
    Inverted {
        /// Signed volume \[m³\].
        volume: f64,
        /// Place.
        position: DVec3,
    },
    /// The surface encloses nothing.
    #[error("the mesh encloses no volume ({volume:.3e} m³)")]
    NoVolume {
        /// Signed volume \[m³\].
        volume: f64,
    },
    /// A component lies inside another, but is not a cavity.
    #[error(
        "a component near {position:.5} lies inside another, so that its volume would count twice; flip its \
        triangles if it is a cavity, or remove it"
    )]
    Nested {
        /// A vertex of the inner component.
        position: DVec3,
    },
    /// A hole too large to be closed without guessing.
    #[error(
        "the surface is open: {}, one near {position:.5} with a border of {:.0} % of the diagonal; close \
        what should be closed, and give a sheet a thickness (in Blender: Solidify, and Apply Modifiers in \
        the export)",
        match holes { 1 => "1 hole".into(), n => format!("{n} holes") }, 100.0 * share
    )]
    Hole {
        /// Number of holes.
        holes: usize,
        /// Length of the largest border over the diagonal of the mesh.
        share: f64,
        /// A vertex on it.
        position: DVec3,
    },
    /// A sheet whose two sides are the same triangles.
    #[error(
        "the mesh is a sheet without thickness: both of its sides lie on each other, as near {position:.5}; \
        give it a thickness (in Blender: Solidify, and Apply Modifiers in the export)"
    )]
    Sheet {
        /// Middle of a triangle.
        position: DVec3,
    },
    /// A surface with one side, such as a Möbius strip or a Klein bottle.
    #[error("the surface has no inside: its triangles cannot all face outwards near {position:.5}")]
    OneSided {
        /// A triangle whose neighbours disagree.
        position: DVec3,
    },
    /// Solids apart from each other.
    #[error(
        "the mesh has {shells} separate shells, the largest near {:.5}, the next, with {share:.3} of \
        its volume, near {:.5}; a body is one solid: unite them, or give each a body of its own",
        centres[0], centres[1]
    )]
    Shells {
        /// Number of solids.
        shells: usize,
        /// Centres of the largest and the next \[m\].
        centres: Box<[DVec3; 2]>,
        /// Volume of the next over that of the largest.
        share: f64,
    },
    /// Shells that cross.
    #[error(
        "two shells cross near {position:.5}, so that volume would count twice; unite them (in Blender: \
        Boolean, Union), or give each a body of its own"
    )]
    CrossingShells {
        /// Place.
        position: DVec3,
    },
    /// Two triangles cross.
    #[error(
        "the surface crosses itself: triangles {first} and {second}, near {position:.5}; separate them \
         there, or remesh the body (in Blender: Remesh, Voxel)"
    )]
    SelfIntersection {
        /// One triangle.
        first: usize,
        /// The other.
        second: usize,
        /// Place.
        position: DVec3,
    },
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
