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
//! It finds no walls whose edges lie on a face without sharing its edges.
//!
//! Source: Attene (2016), "As-exact-as-possible repair of unprintable STL files", the outer
//! hull. `Differs`: cells by their volume, not by growth from an outermost triangle, so that walls go and all
//! else remains.

use std::collections::HashMap;
use std::f64::consts::TAU;

use super::super::solid::check_solid;
use super::super::tri_mesh::TriMesh;
use super::edges::{Side, Sides, angles};
use super::{Fault, Repair};
use crate::math::disjoint_sets::DisjointSets;

/// Least volume of a bounded cell over the cube of the diagonal, above rounding.
const LEAST_VOLUME: f64 = 1e-12;
/// Least angle between triangles at an edge \[rad\]; those that lie on each other have no order.
const SAME_ANGLE: f64 = 1e-6;

/// Removes the faces between parts that share their corners, if one solid is left: both parts have one there.
pub(super) fn remove_common_faces(work: &mut Repair) {
    let triangles = &work.mesh.triangles;
    let sorted = |t: &[u32; 3]| {
        let mut key = *t;
        key.sort_unstable();
        key
    };
    let is_even = |[a, b, c]: &[u32; 3]| (a < b) as u8 + (b < c) as u8 + (c < a) as u8 == 2;
    let mut same: HashMap<[u32; 3], Vec<usize>> = HashMap::new();
    triangles.iter().enumerate().for_each(|(t, corners)| same.entry(sorted(corners)).or_default().push(t));
    let mut marked = vec![false; triangles.len()];
    for pair in same.values() {
        if let [one, other] = pair[..]
            && is_even(&triangles[one]) != is_even(&triangles[other])
        {
            (marked[one], marked[other]) = (true, true);
        }
    }
    // At the border of a sheet with two sides only these meet.
    let sides = Sides::new(&work.mesh);
    let is_sheet = |edge: &[Side]| edge.len() == 2 && edge.iter().any(|side| marked[side.triangle as usize]);
    if !marked.contains(&true) || sides.edges().any(is_sheet) {
        return;
    }
    let mut left = work.mesh.clone();
    let mut marks = marked.iter();
    left.triangles.retain(|_| !marks.next().copied().unwrap_or(false));
    if check_solid(&left.weld(0.0)).is_ok_and(|report| report.components == 1) {
        work.remove(&marked, Fault::InnerWall);
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
    let solid: Vec<bool> = (0..2 * count)
        .map(|side| {
            let cell = cells.root(side);
            volumes[cell] > LEAST_VOLUME && !is_cavity[cell]
        })
        .collect();
    let marked: Vec<bool> = (0..count).map(|t| solid[2 * t] && solid[2 * t + 1]).collect();
    work.remove(&marked, Fault::InnerWall);
}

/// The cell at larger angles than a side.
fn above(side: &Side) -> usize {
    2 * side.triangle as usize + usize::from(!side.ascending)
}

/// The cell at smaller angles than a side.
fn below(side: &Side) -> usize {
    2 * side.triangle as usize + usize::from(side.ascending)
}

/// The sides at an edge by their angle; `None` if three or more have no order.
fn in_order(mesh: &TriMesh, edge: &[Side]) -> Option<Vec<Side>> {
    if edge.len() <= 2 {
        return Some(edge.to_vec());
    }
    let angles = angles(mesh, edge);
    let mut around: Vec<(f64, Side)> = angles.into_iter().zip(edge.iter().copied()).collect();
    around.sort_by(|a, b| a.0.total_cmp(&b.0));
    let ends = around.iter().map(|(angle, _)| *angle).chain([around[0].0 + TAU]);
    let steps = around.iter().zip(ends.skip(1)).map(|((angle, _), next)| next - angle);
    steps.fold(f64::MAX, f64::min).ge(&SAME_ANGLE).then(|| around.into_iter().map(|(_, side)| side).collect())
}
