//! Which nodes the parts of neighbouring cells share.
//!
//! Two parts are joined where their sections with the common face of their cells overlap: they share the
//! nodes of this face, so that displacements are continuous. Parts that touch the face in different places,
//! such as two walls with a gap between them, share none.

use std::collections::BTreeMap;

use clangor_core::math::disjoint_sets::DisjointSets;
use glam::DVec3;

use super::basis::Basis;
use super::hanging::{HangingFace, hanging_faces};
use super::levels::{Element, Level};
use super::parts::{Cell, Parts};
use super::sections::{OVERLAP, ROUNDING, moved_section, overlaps};

/// A node of a grid: its level, its place in the lattice, and the first of its copies.
type Key = (usize, [usize; 3], u32);

/// The elements of all parts, and positions of all nodes \[m\], in the order of the grids.
pub(super) fn numbered(levels: &[Level], basis: &Basis) -> (Vec<Element>, Vec<DVec3>) {
    let (mut hanging, apart) = hanging_faces(levels);
    let mut copies = Copies::of(levels, basis, &mut hanging, apart);
    let distinct = copies.distinct(levels, basis);
    let (all, count) = (copies.all, copies.nodes.count() / copies.all);
    let number = |copies: &mut Copies, part: usize, k: usize| {
        let key = copies.key(levels, basis, part, k);
        distinct.partition_point(|other| *other < key)
    };
    // What hanging nodes follow; larger cells come first, so that theirs is known.
    let mut follows: Vec<Option<Vec<(usize, f64)>>> = vec![None; distinct.len()];
    for face in &hanging {
        for k in face.nodes(basis) {
            let node = number(&mut copies, face.part, k);
            if follows[node].is_none() {
                let mut sum = BTreeMap::new();
                for (m, weight) in face.followed(k, basis) {
                    let other = number(&mut copies, face.larger, m);
                    for (term, part) in follows[other].as_deref().unwrap_or(&[(other, 1.0)]) {
                        *sum.entry(*term).or_insert(0.0) += weight * part;
                    }
                }
                follows[node] = Some(sum.into_iter().collect());
            }
        }
    }
    let free: Vec<usize> = (0..distinct.len()).filter(|node| follows[*node].is_none()).collect();
    let unknown = |node: usize| free.partition_point(|other| *other < node) as u32;
    let element = |part: usize| {
        let own: Vec<usize> = (0..all).map(|k| number(&mut copies, part, k)).collect();
        if own.iter().all(|node| follows[*node].is_none()) {
            return Element { nodes: own.into_iter().map(unknown).collect(), hanging: None };
        }
        let terms = |node: usize| follows[node].clone().unwrap_or_else(|| vec![(node, 1.0)]);
        let terms: Vec<Vec<(u32, f64)>> = own
            .into_iter()
            .map(|node| terms(node).into_iter().map(|(n, w)| (unknown(n), w)).collect())
            .collect();
        let mut nodes: Vec<u32> = terms.iter().flatten().map(|(node, _)| *node).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let place = |node: u32| nodes.partition_point(|other| *other < node);
        let hanging = terms.iter().map(|own| own.iter().map(|(n, w)| (place(*n), *w)).collect()).collect();
        Element { hanging: Some(hanging), nodes }
    };
    let elements = (0..count).map(element).collect();
    let along = |n: usize| (n / basis.degree()) as f64 + basis.lobatto()[n % basis.degree()];
    let position = |node: &usize| {
        let (level, at, _) = distinct[*node];
        let grid = &levels[level].grid;
        grid.origin + grid.edge * DVec3::from_array(at.map(along))
    };
    let positions = free.iter().map(position).collect();
    (elements, positions)
}

/// The nodes of all parts, and which of them are one.
struct Copies {
    nodes: DisjointSets,
    /// Nodes of a cell.
    all: usize,
}

impl Copies {
    fn of(levels: &[Level], basis: &Basis, hanging: &mut Vec<HangingFace>, apart: Vec<HangingFace>) -> Self {
        let degree = basis.degree();
        let local = degree + 1;
        let all = local.pow(3);
        let count: usize = levels.iter().map(|level| level.body.parts.len()).sum();
        let mut nodes = DisjointSets::new(count * all);
        let mut bodies = DisjointSets::new(count);
        let share =
            |(nodes, bodies): (&mut DisjointSets, &mut DisjointSets), pair: [usize; 2], axis: usize| {
                bodies.join(pair[0], pair[1]);
                let step = [local * local, local, 1][axis];
                for k in basis.on_face(axis, false) {
                    nodes.join(pair[0] * all + k + degree * step, pair[1] * all + k);
                }
            };
        for level in levels {
            level.body.ties.iter().for_each(|tie| {
                bodies.join(level.first + tie.parts[0], level.first + tie.parts[1]);
            });
            for (cell, above, axis) in neighbours(&level.body) {
                for pair in joined(&level.body, cell, above, axis) {
                    share((&mut nodes, &mut bodies), pair.map(|part| level.first + part), axis);
                }
            }
        }
        for face in hanging.iter() {
            bodies.join(face.part, face.larger);
            for other in &face.also {
                bodies.join(face.larger, *other);
                let axis = usize::from(face.face / 2);
                for k in basis.on_face(axis, face.face.is_multiple_of(2)) {
                    nodes.join(face.larger * all + k, other * all + k);
                }
            }
        }
        // What hangs together by less than rounding shares all nodes of the face.
        for level in levels {
            for (cell, above, axis) in neighbours(&level.body) {
                for pair in
                    cell.parts.iter().flatten().flat_map(|a| above.parts.iter().flatten().map(|b| [*a, *b]))
                {
                    let pair = pair.map(|part| level.first + part);
                    if bodies.root(pair[0]) != bodies.root(pair[1]) {
                        share((&mut nodes, &mut bodies), pair, axis);
                    }
                }
            }
        }
        for face in apart {
            if bodies.root(face.part) != bodies.root(face.larger) {
                bodies.join(face.part, face.larger);
                hanging.push(face);
            }
        }
        hanging.sort_by_key(|face| face.part);
        let mut copies = Copies { nodes, all };
        while copies.join_what_is_followed(levels, basis, hanging) {}
        copies
    }

    /// Joins nodes of larger cells that one hanging node follows, such as two that meet at a side only, and
    /// hang together by the smaller cell between them. Whether there were any.
    fn join_what_is_followed(&mut self, levels: &[Level], basis: &Basis, hanging: &[HangingFace]) -> bool {
        let mut followed: BTreeMap<usize, usize> = BTreeMap::new();
        let mut any = false;
        for (number, face) in hanging.iter().enumerate() {
            for k in face.nodes(basis) {
                let node = self.nodes.root(face.part * self.all + k);
                let first = &hanging[*followed.entry(node).or_insert(number)];
                if first.larger == face.larger {
                    continue;
                }
                // Whichever smaller cell asks, the node is at the same place of the lattice.
                let other = first.nodes(basis).find(|k| self.nodes.root(first.part * self.all + k) == node);
                let Some(other) = other else { continue };
                for (m, _) in face.followed(k, basis) {
                    let place = lattice(levels, basis, face.larger, m);
                    let same = |(n, _): &(usize, f64)| lattice(levels, basis, first.larger, *n) == place;
                    let Some((n, _)) = first.followed(other, basis).find(same) else { continue };
                    let (a, b) = (face.larger * self.all + m, first.larger * self.all + n);
                    if self.nodes.root(a) != self.nodes.root(b) {
                        self.nodes.join(a, b);
                        any = true;
                    }
                }
            }
        }
        any
    }

    fn key(&mut self, levels: &[Level], basis: &Basis, part: usize, k: usize) -> Key {
        let (level, place) = lattice(levels, basis, part, k);
        (level, place, self.nodes.root(part * self.all + k) as u32)
    }

    /// All different nodes, ascending.
    fn distinct(&mut self, levels: &[Level], basis: &Basis) -> Vec<Key> {
        let all = self.all;
        let mut keys: Vec<Key> =
            (0..self.nodes.count()).map(|n| self.key(levels, basis, n / all, n % all)).collect();
        keys.sort_unstable();
        keys.dedup();
        keys
    }
}

/// Level and place in its lattice of a node of a part.
fn lattice(levels: &[Level], basis: &Basis, part: usize, k: usize) -> (usize, [usize; 3]) {
    let level = levels.partition_point(|level| level.first <= part) - 1;
    let place = levels[level].body.parts[part - levels[level].first].place;
    let local = basis.degree() + 1;
    let at = [k / (local * local), k / local % local, k % local];
    (level, std::array::from_fn(|a| place[a] * basis.degree() + at[a]))
}

/// Whether the body goes on through the mirror plane across each axis at each of so many nodes: a part that
/// does not meet the plane is not joined to its image.
pub(super) fn on_mirrors(
    basis: &Basis,
    levels: &[Level],
    elements: &[Element],
    count: usize,
) -> Vec<[bool; 3]> {
    let mut on = vec![[false; 3]; count];
    for level in levels {
        let (grid, body) = (&level.grid, &level.body);
        for cell in &body.cells {
            for axis in (0..3).filter(|a| grid.mirrored()[*a] && cell.place[*a] == grid.images[*a]) {
                let meets = |part: &&usize| cell.lower_section(&body.parts[**part], axis) > ROUNDING;
                for part in cell.parts.iter().flatten().filter(meets) {
                    let element = &elements[level.first + *part];
                    for node in basis.on_face(axis, false).filter_map(|k| element.node(k)) {
                        on[node as usize][axis] = true;
                    }
                }
            }
        }
    }
    on
}

/// All pairs of cells of one size that share a face, the lower one first, and the axis across it.
fn neighbours(body: &Parts) -> impl Iterator<Item = (&Cell, &Cell, usize)> {
    body.cells.iter().flat_map(move |cell| {
        (0..3).filter_map(move |axis| {
            let mut place = cell.place;
            place[axis] += 1;
            body.cell(place).map(|above| (cell, above, axis))
        })
    })
}

/// The pairs of parts that are joined across the upper face of a cell along an axis.
fn joined(body: &Parts, cell: &Cell, above: &Cell, axis: usize) -> Vec<[usize; 2]> {
    let face = 2 * axis as u8;
    let (lower, upper) = (cell.distinct_parts(), above.distinct_parts());
    let section = |cell: &Cell, part: usize, face: u8| cell.section(&body.parts[part], face);
    let below: Vec<f64> = lower.iter().map(|part| section(cell, *part, face + 1)).collect();
    let over: Vec<f64> = upper.iter().map(|part| section(above, *part, face)).collect();
    // Overlap of each part below with each above.
    let overlap: Vec<Vec<f64>> = match (&cell.division, &above.division) {
        (_, None) => below.iter().map(|area| vec![*area]).collect(),
        (None, Some(_)) => vec![over.clone()],
        (Some(_), Some(division)) => {
            let within = |part: &usize| {
                let sections = &body.parts[*part].sections;
                let section = moved_section(sections, face + 1, |x| x - DVec3::AXES[axis]);
                overlaps(&section, face + 1, above, division)
            };
            lower.iter().map(within).collect()
        }
    };
    let mut pairs = Vec::new();
    for (a, row) in overlap.iter().enumerate() {
        for (b, shared) in row.iter().enumerate() {
            let most = row.iter().all(|other| other <= shared) || overlap.iter().all(|row| row[b] <= *shared);
            let enough = *shared > OVERLAP * below[a].min(over[b]);
            if *shared > ROUNDING && (most || enough) {
                pairs.push([lower[a], upper[b]]);
            }
        }
    }
    pairs
}
