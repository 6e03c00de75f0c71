//! Meshes of flat plates: the outline in triangles, each divided in four, and these in prisms across the
//! plate.
//!
//! The tetrahedra of the prisms give the nodes and the surface; four prisms together are one element of
//! [`prisms`](crate::fem::prisms) on the same nodes.

use std::collections::BTreeMap;

use glam::DVec3;

use super::axisymmetric::triangulation::fill;
use super::plate_sizes::PlateSizes;
use crate::fem::prisms::{Prisms, lattice};
use crate::geometry_class::flat_plate::FlatPlate;
use crate::mesh::tetrahedra::{EDGES, TetMesh, TetMeshError};

/// A mesh of a plate, `layers` cells thick, with triangles of these sizes in the plane.
///
/// # Errors
/// [`TetMeshError::Empty`] for an outline that crosses itself.
pub(super) fn plate_mesh(
    plate: &FlatPlate,
    sizes: &PlateSizes,
    layers: usize,
) -> Result<(TetMesh, Prisms), TetMeshError> {
    let outline = sizes.divided(&plate.outline);
    let triangulation = fill(&outline, &|p| sizes.at(p)).ok_or(TetMeshError::Empty)?;
    let mut points = triangulation.points;
    // Middles of sides.
    let mut middles: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    let whole = triangulation.triangles;
    let mut middle = |a: u32, b: u32| {
        *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            points.push(0.5 * (points[a as usize] + points[b as usize]));
            points.len() as u32 - 1
        })
    };
    // Corners of each triangle and the middles of its sides, by their place in the lattice.
    let places: Vec<BTreeMap<[usize; 3], u32>> = whole
        .iter()
        .map(|&[a, b, c]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            let corners = [([4, 0, 0], a), ([0, 4, 0], b), ([0, 0, 4], c)];
            corners.into_iter().chain([([2, 2, 0], ab), ([0, 2, 2], bc), ([2, 0, 2], ca)]).collect()
        })
        .collect();
    // Three tetrahedra in each prism, along the order of its corners' numbers, so that neighbours match.
    let count = points.len() as u32;
    let mut tetrahedra = Vec::new();
    for place in &places {
        let at = |index: [usize; 3]| place[&index];
        let [ab, bc, ca] = [at([2, 2, 0]), at([0, 2, 2]), at([2, 0, 2])];
        let [a, b, c] = [at([4, 0, 0]), at([0, 4, 0]), at([0, 0, 4])];
        for mut part in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            part.sort_unstable();
            for layer in 0..layers as u32 {
                let [low, high] = [layer, layer + 1].map(|l| part.map(|v| v + l * count));
                tetrahedra.push([low[0], low[1], low[2], high[2]]);
                tetrahedra.push([low[0], low[1], high[1], high[2]]);
                tetrahedra.push([low[0], high[0], high[1], high[2]]);
            }
        }
    }
    let level = |l: usize| plate.height + plate.thickness * (l as f64 / layers as f64 - 0.5);
    let solid = (0..=layers).flat_map(|l| points.iter().map(move |p| (*p, l)));
    let solid = solid.map(|(p, l)| plate.frame * DVec3::new(p.x, p.y, level(l))).collect();
    let mesh = TetMesh::straight(solid, &tetrahedra)?;
    let elements = elements(&mesh, &places, layers, count);
    let corners = whole.iter().map(|t| t.map(|v| points[v as usize])).collect();
    let prisms = Prisms { corners, elements, layers, thickness: plate.thickness, frame: plate.frame };
    Ok((mesh, prisms))
}

/// The nodes of each element.
fn elements(
    mesh: &TetMesh,
    places: &[BTreeMap<[usize; 3], u32>],
    layers: usize,
    count: u32,
) -> Vec<Vec<u32>> {
    let mut between: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for element in &mesh.elements {
        for (k, [i, j]) in EDGES.into_iter().enumerate() {
            let (a, b) = (element[i], element[j]);
            between.insert([a.min(b), a.max(b)], element[4 + k]);
        }
    }
    let node = |place: &BTreeMap<[usize; 3], u32>, index: [usize; 3], half_level: usize| -> u32 {
        let level = |v: u32, l: usize| v + l as u32 * count;
        let (low, high) = (half_level / 2, half_level.div_ceil(2));
        if let Some(v) = place.get(&index) {
            return if low == high { level(*v, low) } else { between[&[level(*v, low), level(*v, high)]] };
        }
        // Between the two corners that differ in the odd coordinates.
        let odd: Vec<usize> = (0..3).filter(|a| index[*a] % 2 == 1).collect();
        let end = |up: usize, down: usize| {
            let mut at = index;
            at[up] += 1;
            at[down] -= 1;
            place[&at]
        };
        let (a, b) = (end(odd[0], odd[1]), end(odd[1], odd[0]));
        // The diagonal of a wall rises towards the corner of the higher number.
        between[&[level(a.min(b), low), level(a.max(b), high)]]
    };
    let nodes = |place: &BTreeMap<[usize; 3], u32>| {
        (0..=2 * layers).flat_map(|half| lattice().map(|index| node(place, index, half))).collect()
    };
    places.iter().map(nodes).collect()
}
