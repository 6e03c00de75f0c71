//! The normal velocity of a mode, as loads on the vertices of another mesh of the same surface.
//!
//! ```text
//! wᵢ = ∫ φᵢ (U·n − δ) dS,    δ = (∫ U·n dS − V̇)/S
//! ```
//!
//! over the flat triangles of the acoustic mesh with *their* normals, φᵢ linear, U interpolated between the
//! six nodes of the nearest element face of similar orientation. V̇ is the flux of the motion through the
//! elements' own faces. A body of nearly constant volume has a net flux near zero, but interpolation leaves
//! about 10⁻³ of the flux that moves: a spurious monopole. δ removes it.

use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::sound_model::modal::surface::{ModalSurface, SurfaceLocator, node_weights};
use glam::DVec3;
use rayon::prelude::*;

/// Barycentric coordinates and weights of a rule that is exact for quartics.
const RULE: [([f64; 3], f64); 6] = {
    const A: f64 = 0.445_948_490_915_965;
    const B: f64 = 0.091_576_213_509_771;
    const V: f64 = 0.223_381_589_678_011;
    const W: f64 = 0.109_951_743_655_322;
    [
        ([1.0 - 2.0 * A, A, A], V),
        ([A, 1.0 - 2.0 * A, A], V),
        ([A, A, 1.0 - 2.0 * A], V),
        ([1.0 - 2.0 * B, B, B], W),
        ([B, 1.0 - 2.0 * B, B], W),
        ([B, B, 1.0 - 2.0 * B], W),
    ]
};

/// Largest number of parts of an acoustic triangle's edge, to follow the elements.
const MOST_PARTS: usize = 8;

/// The map from the motion of the nodes to the loads, the same for all modes.
#[derive(Clone, Debug)]
pub struct NormalVelocityProjection {
    /// First entry of each vertex, one more than vertices.
    starts: Vec<u32>,
    /// Node, and the weight of its motion [m²].
    entries: Vec<(u32, DVec3)>,
    /// ∫ φᵢ dS [m²].
    areas: Vec<f64>,
    /// ∮ Nᵢ n dS of each node of the elements' faces [m²].
    flux: Vec<DVec3>,
}

impl NormalVelocityProjection {
    /// For a mesh near the surface; `None` if either is empty.
    pub fn new(surface: &ModalSurface, mesh: &TriMesh) -> Option<Self> {
        if surface.triangles.is_empty() || mesh.triangles.is_empty() {
            return None;
        }
        let locator = SurfaceLocator::new(surface);
        let element = (2.3 * surface.quarters().area() / surface.triangles.len() as f64).sqrt();
        let places: Vec<Vec<(u32, u32, DVec3)>> = (0..mesh.triangles.len())
            .into_par_iter()
            .map(|t| loads_of_triangle(mesh, t, &locator, element))
            .collect();
        let mut starts = vec![0_u32; mesh.vertices.len() + 1];
        let mut entries: Vec<(u32, DVec3)> = Vec::new();
        for (vertex, node, area) in merged(places.concat()) {
            entries.push((node, area));
            starts[vertex as usize + 1] += 1;
        }
        for v in 1..starts.len() {
            starts[v] += starts[v - 1];
        }
        let mut areas = vec![0.0; mesh.vertices.len()];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let area = mesh.area_vector(t).length();
            corners.iter().for_each(|v| areas[*v as usize] += area / 3.0);
        }
        Some(NormalVelocityProjection { starts, entries, areas, flux: node_fluxes(surface) })
    }

    /// wᵢ of a mode with this motion of the nodes, in its unit times m².
    pub fn of(&self, shape: &[DVec3]) -> Vec<f64> {
        let flux: f64 = self.flux.iter().zip(shape).map(|(n, u)| n.dot(*u)).sum();
        let mut loads = self.interpolated(shape);
        let excess = (loads.iter().sum::<f64>() - flux) / self.areas.iter().sum::<f64>();
        loads.iter_mut().zip(&self.areas).for_each(|(load, area)| *load -= excess * area);
        loads
    }

    /// The same with δ = 0, for comparison.
    pub fn interpolated(&self, shape: &[DVec3]) -> Vec<f64> {
        let row = |range: &[u32]| -> f64 {
            let entries = &self.entries[range[0] as usize..range[1] as usize];
            entries.iter().map(|(node, n)| n.dot(shape[*node as usize])).sum()
        };
        self.starts.windows(2).map(row).collect()
    }
}

/// (vertex, node, ∫ φ_vertex N_node n dS) over one triangle.
fn loads_of_triangle(
    mesh: &TriMesh,
    triangle: usize,
    locator: &SurfaceLocator,
    element: f64,
) -> Vec<(u32, u32, DVec3)> {
    let corners = mesh.corners(triangle);
    let area = mesh.area_vector(triangle);
    let longest = (0..3).map(|k| corners[k].distance(corners[(k + 1) % 3])).fold(0.0, f64::max);
    let parts = ((longest / element).ceil() as usize).clamp(1, MOST_PARTS);
    let mut sums: Vec<(u32, u32, DVec3)> = Vec::new();
    for piece in pieces(parts) {
        for (shares, weight) in RULE {
            let shares: [f64; 3] = std::array::from_fn(|c| (0..3).map(|k| piece[k][c] * shares[k]).sum());
            let point = corners[0] * shares[0] + corners[1] * shares[1] + corners[2] * shares[2];
            let Some(place) = locator.nearest_facing(point, area) else { continue };
            let area = area * (weight / (parts * parts) as f64);
            for (vertex, share) in mesh.triangles[triangle].iter().zip(shares) {
                for (node, weight) in place.nodes.iter().zip(place.weights) {
                    sums.push((*vertex, *node, area * (share * weight)));
                }
            }
        }
    }
    merged(sums)
}

/// Merges entries of the same vertex and node.
fn merged(mut entries: Vec<(u32, u32, DVec3)>) -> Vec<(u32, u32, DVec3)> {
    // The sort is stable, so that sums have a fixed order.
    entries.sort_by_key(|(vertex, node, _)| (*vertex, *node));
    let same = entries.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
    same.map(|same| (same[0].0, same[0].1, same.iter().map(|entry| entry.2).sum())).collect()
}

/// Shares of the corners at those of the `parts`² equal pieces of a triangle.
fn pieces(parts: usize) -> Vec<[[f64; 3]; 3]> {
    let at = |i: usize, j: usize| [i, j, parts - i - j].map(|k| k as f64 / parts as f64);
    let mut pieces = Vec::with_capacity(parts * parts);
    for i in 0..parts {
        for j in 0..parts - i {
            pieces.push([at(i + 1, j), at(i, j + 1), at(i, j)]);
            if i + j + 2 <= parts {
                pieces.push([at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)]);
            }
        }
    }
    pieces
}

/// ∮ Nᵢ n dS, exact: n dS = ∂x/∂L₀ × ∂x/∂L₁ dL₀ dL₁ is of second degree, as Nᵢ is.
fn node_fluxes(surface: &ModalSurface) -> Vec<DVec3> {
    let mut flux = vec![DVec3::ZERO; surface.nodes.len()];
    for nodes in &surface.triangles {
        let x = nodes.map(|n| surface.nodes[n as usize]);
        for ([a, b, c], weight) in RULE {
            let by_a = x[0] * (4.0 * a - 1.0) + x[3] * (4.0 * b) + x[5] * (4.0 * c);
            let by_b = x[1] * (4.0 * b - 1.0) + x[3] * (4.0 * a) + x[4] * (4.0 * c);
            let by_c = x[2] * (4.0 * c - 1.0) + x[4] * (4.0 * b) + x[5] * (4.0 * a);
            let area = (by_a - by_c).cross(by_b - by_c) * (0.5 * weight);
            for (node, share) in nodes.iter().zip(node_weights([a, b, c])) {
                flux[*node as usize] += area * share;
            }
        }
    }
    flux
}
