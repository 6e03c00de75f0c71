//! A solid body of tetrahedra that distinguishes crack surfaces from its original surface.

use clangor_bake::mesh::tetrahedra::{EDGES, TetMesh};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::topology::Topology;
use clangor_core::geometry::tri_mesh::TriMesh;

use super::error::FractureError;

/// An unbroken body, made by [`whole`](Self::whole), or a piece of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Tetrahedra with straight edges, in the frame of the first whole body.
    pub mesh: TetMesh,
    /// Triangles of the surface, counter-clockwise seen from outside; indices refer to corners of `mesh`.
    pub faces: Vec<[u32; 3]>,
    /// For each face whether a crack created it; the others belong to the surface of the first whole body.
    pub inside: Vec<bool>,
    /// For each element the mean edge \[m\] of its original element in the first whole body; it limits how
    /// small the elements of pieces may become.
    pub element_size: Vec<f64>,
}

impl Piece {
    /// A body without cracks; curved edges become straight.
    ///
    /// # Errors
    /// [`FractureError::Mesh`] for tetrahedra without volume, [`FractureError::Surface`] if the surface of
    /// the tetrahedra is not closed, [`FractureError::Pinched`] if it touches itself,
    /// [`FractureError::Parts`] if the tetrahedra are not connected.
    pub fn whole(mesh: &TetMesh) -> Result<Self, FractureError> {
        let tetrahedra: Vec<[u32; 4]> = mesh.elements.iter().map(|e| [e[0], e[1], e[2], e[3]]).collect();
        let mesh = TetMesh::straight(mesh.nodes.iter().take(mesh.corners).copied().collect(), &tetrahedra)?;
        let element_size = (0..mesh.elements.len())
            .map(|e| {
                let nodes = mesh.positions(e);
                EDGES.iter().map(|[i, j]| nodes[*i].distance(nodes[*j])).sum::<f64>() / 6.0
            })
            .collect();
        let faces: Vec<[u32; 3]> = mesh.surface().iter().map(|f| [f[0], f[1], f[2]]).collect();
        if mesh.parts() != 1 {
            return Err(FractureError::Parts(mesh.parts()));
        }
        let piece = Piece { inside: vec![false; faces.len()], mesh, faces, element_size };
        check_manifold(&piece.surface())?;
        Ok(piece)
    }

    /// The surface, with only its own vertices, in the order of the mesh's corners; its triangles have the
    /// order of `faces`.
    pub fn surface(&self) -> TriMesh {
        let mut number = vec![u32::MAX; self.mesh.corners];
        self.faces.iter().flatten().for_each(|n| number[*n as usize] = 0);
        let mut vertices = Vec::new();
        for (node, new) in number.iter_mut().enumerate().filter(|(_, new)| **new == 0) {
            *new = vertices.len() as u32;
            vertices.push(self.mesh.nodes[node]);
        }
        let triangles = self.faces.iter().map(|f| f.map(|n| number[n as usize])).collect();
        TriMesh { vertices, triangles }
    }

    /// Volume, centre of mass and inertia for unit density, exact for the tetrahedra.
    ///
    /// # Errors
    /// [`FractureError::Surface`] for a body without volume.
    pub fn mass_properties(&self) -> Result<MassProperties, FractureError> {
        Ok(MassProperties::of(&self.surface())?)
    }
}

/// Rejects surfaces that are not closed or not manifold: an edge needs two triangles with opposite
/// orientations, a vertex a single fan.
pub(super) fn check_manifold(surface: &TriMesh) -> Result<(), FractureError> {
    let topology = Topology::try_new(surface)?;
    let mut fans = vec![0_u32; surface.vertices.len()];
    let mut seen = vec![[false; 3]; surface.triangles.len()];
    for start in 0..surface.triangles.len() {
        for corner in 0..3 {
            if seen[start][corner] {
                continue;
            }
            let vertex = surface.triangles[start][corner];
            fans[vertex as usize] += 1;
            let (mut triangle, mut slot) = (start, corner);
            while !seen[triangle][slot] {
                seen[triangle][slot] = true;
                triangle = topology.neighbours[triangle][slot] as usize;
                slot = surface.triangles[triangle].iter().position(|v| *v == vertex).unwrap_or(0);
            }
        }
    }
    match fans.iter().position(|count| *count > 1) {
        Some(vertex) => Err(FractureError::Pinched { position: surface.vertices[vertex] }),
        None => Ok(()),
    }
}
