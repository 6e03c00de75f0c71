//! Walls inside of a body, at whose edges three triangles or more meet: the faces between parts that were
//! joined, or the floors of a building.
//!
//! Around each edge, triangles follow by their angle, and the space between two of them is in front of or
//! behind both. So the surface divides space into cells:
//!
//! ```text
//! V(cell) = Σ behind v_t − Σ in front v_t,    v_t = a·(b × c)/6
//! ```
//!
//! is the volume of a cell that is bounded, and negative outside. A bounded cell that all its triangles face
//! is a cavity; others are solid. A triangle with solid on both sides is a wall inside of the body.
//!
//! Two triangles at the same angle that face away from each other have a cell without volume between them:
//! two parts touch there, or a sheet has two sides. They go where both are in the same cell, or in solids.
//!
//! It finds no walls whose edges lie on a face without sharing its edges.
//!
//! Source: Attene (2016), "As-exact-as-possible repair of unprintable STL files", the outer
//! hull. `Differs`: cells by their volume, not by growth from an outermost triangle, so that walls go and all
//! else remains.

use std::f64::consts::TAU;

use super::super::tri_mesh::TriMesh;
use super::edges::{Side, Sides, angles};
use super::{Fault, Repair};
use crate::math::disjoint_sets::DisjointSets;

/// Least volume of a bounded cell over the cube of the diagonal, above rounding.
const LEAST_VOLUME: f64 = 1e-12;
/// Least angle between triangles at an edge that do not lie on each other \[rad\].
const SAME_ANGLE: f64 = 1e-6;

/// Removes the faces between closed parts, which may divide them into other triangles each.
pub(super) fn remove_faces_between_parts(work: &mut Repair) {
    let is_even = |edge: &[Side]| 2 * edge.iter().filter(|side| side.ascending).count() == edge.len();
    if Sides::new(&work.mesh).edges().all(is_even) {
        remove_inner_walls(work);
    }
}

/// Removes walls with solid on both sides.
pub(super) fn remove_inner_walls(work: &mut Repair) {
    let mesh = &work.mesh;
    let sides = Sides::new(mesh);
    if !sides.edges().any(|edge| edge.len() > 2) {
        return;
    }
    // In front of each triangle, and behind it.
    let count = mesh.triangles.len();
    let mut cells = DisjointSets::new(2 * count);
    for edge in sides.edges() {
        let Some(around) = in_order(mesh, edge) else { return };
        let next = around.iter().cycle().skip(1);
        around.iter().zip(next).for_each(|(side, next)| cells.join(above(side), below(next)));
    }
    let mut volumes = vec![0.0; 2 * count];
    let mut is_cavity = vec![true; 2 * count];
    let (low, high) = mesh.bounds();
    for t in 0..count {
        let [a, b, c] = mesh.corners(t).map(|x| (x - 0.5 * (low + high)) / work.diagonal);
        let volume = a.dot(b.cross(c)) / 6.0;
        volumes[cells.root(2 * t)] -= volume;
        let behind = cells.root(2 * t + 1);
        volumes[behind] += volume;
        is_cavity[behind] = false;
    }
    let roots: Vec<usize> = (0..2 * count).map(|side| cells.root(side)).collect();
    let is_solid = |side: usize| volumes[roots[side]] > LEAST_VOLUME && !is_cavity[roots[side]];
    // Cells without volume that have the same on all sides.
    let mut is_flat: Vec<bool> = (0..2 * count).map(|k| volumes[k].abs() <= LEAST_VOLUME).collect();
    let mut around: Vec<Option<usize>> = vec![None; 2 * count];
    for t in 0..count {
        let (front, behind) = (roots[2 * t], roots[2 * t + 1]);
        is_flat[front] = false;
        let first = *around[behind].get_or_insert(2 * t);
        is_flat[behind] &= roots[first] == front || is_solid(first) && is_solid(2 * t);
    }
    let is_wall = |t: usize| is_solid(2 * t) && is_solid(2 * t + 1) || is_flat[roots[2 * t + 1]];
    let marked: Vec<bool> = (0..count).map(is_wall).collect();
    if marked.contains(&false) {
        work.remove(&marked, Fault::InnerWall);
    }
}

/// The cell at larger angles than a side.
fn above(side: &Side) -> usize {
    2 * side.triangle as usize + usize::from(!side.ascending)
}

/// The cell at smaller angles than a side.
fn below(side: &Side) -> usize {
    2 * side.triangle as usize + usize::from(side.ascending)
}

/// The sides at an edge by their angle. Of two that lie on each other, those that face away from each other
/// are both in front; `None` if others have no order.
fn in_order(mesh: &TriMesh, edge: &[Side]) -> Option<Vec<Side>> {
    if edge.len() <= 2 {
        return Some(edge.to_vec());
    }
    // Those just before a full turn lie on the first.
    let angles = angles(mesh, edge).into_iter();
    let angles = angles.map(|angle| if angle > TAU - SAME_ANGLE { angle - TAU } else { angle });
    let mut around: Vec<(f64, Side)> = angles.zip(edge.iter().copied()).collect();
    around.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut lying = around.chunk_by_mut(|a, b| b.0 - a.0 < SAME_ANGLE);
    let are_ordered = lying.all(|sides| match sides {
        [_] => true,
        [a, b] if a.1.ascending != b.1.ascending => {
            sides.sort_by_key(|(_, side)| side.ascending);
            true
        }
        _ => false,
    });
    are_ordered.then(|| around.into_iter().map(|(_, side)| side).collect())
}
