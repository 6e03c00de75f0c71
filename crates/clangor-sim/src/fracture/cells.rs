//! Tetrahedra of several regions that together fill a body: a mesh after cutting.
//!
//! A wall between two regions is a set of faces that a tetrahedron of one shares with a tetrahedron of the
//! other, so that pieces made of the regions fit without gaps and their volumes sum to that of the body.

use std::collections::{BTreeSet, HashMap};

use clangor_core::glam::DVec3;

use super::piece::Piece;
use super::tetrahedron::{shape, six_volumes};
use super::tetrahedron_parts::{PointMask, distinct, face_polygon, tetrahedra, triangles};

/// A tetrahedron.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Cell {
    pub(super) corners: [u32; 4],
    /// Its region.
    pub(super) region: u32,
    /// The element of the unbroken body that contains it.
    pub(super) element: u32,
}

/// A triangle of the body's surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct OuterFace {
    pub(super) corners: [u32; 3],
    /// Whether an earlier crack created it.
    pub(super) inside: bool,
}

/// Cells that share whole faces, and the surface of their union.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells {
    pub(super) points: Vec<DVec3>,
    pub(super) cells: Vec<Cell>,
    pub(super) outer: Vec<OuterFace>,
}

impl Cells {
    /// A whole body as one region.
    pub(super) fn of(piece: &Piece) -> Self {
        let mesh = &piece.mesh;
        let cell = |(element, nodes): (usize, &[u32; 10])| Cell {
            corners: [nodes[0], nodes[1], nodes[2], nodes[3]],
            region: 0,
            element: element as u32,
        };
        let outer = piece.faces.iter().zip(&piece.inside);
        Cells {
            points: mesh.nodes[..mesh.corners].to_vec(),
            cells: mesh.elements.iter().enumerate().map(cell).collect(),
            outer: outer.map(|(corners, inside)| OuterFace { corners: *corners, inside: *inside }).collect(),
        }
    }

    pub(super) fn places(&self, corners: [u32; 4]) -> [DVec3; 4] {
        corners.map(|n| self.points[n as usize])
    }

    /// Cuts every cell whose corners have several labels. The region of a part is given by the region of its
    /// cell and its label.
    ///
    /// `cut` returns the point at which the edge between two corners of different labels is cut; points other
    /// than its middle are valid for two labels only.
    pub(super) fn divide(&self, label: &[u32], cut: impl Fn(u32, u32) -> DVec3) -> Self {
        let mut divided = Cells { points: self.points.clone(), ..Cells::default() };
        let mut numbers: HashMap<[u32; 4], u32> = HashMap::new();
        let mut regions: HashMap<(u32, u32), u32> = HashMap::new();
        // Divide the cells.
        for cell in &self.cells {
            let labels = cell.corners.map(|n| label[n as usize]);
            let number = |divided: &mut Cells, numbers: &mut HashMap<_, _>, mask: PointMask| {
                divided.number(numbers, &cell.corners, mask, &cut)
            };
            let numbered: [u32; 16] = std::array::from_fn(|mask| {
                let mask = mask as PointMask;
                if is_needed(mask, labels) { number(&mut divided, &mut numbers, mask) } else { 0 }
            });
            for own in distinct(labels) {
                let next = regions.len() as u32;
                let region = *regions.entry((cell.region, own)).or_insert(next);
                if labels == [own; 4] {
                    divided.cells.push(Cell { region, ..*cell });
                    continue;
                }
                for corners in tetrahedra(labels, own, |mask| numbered[usize::from(mask)]) {
                    let upright = six_volumes(divided.places(corners)) > 0.0;
                    let [a, b, c, d] = corners;
                    let corners = if upright { corners } else { [a, c, b, d] };
                    divided.cells.push(Cell { corners, region, element: cell.element });
                }
            }
        }
        // Divide the outer surface in the same way.
        for face in &self.outer {
            // A face is treated as a tetrahedron whose fourth corner equals the first.
            let [a, b, c] = face.corners;
            let corners = [a, b, c, a];
            let labels = corners.map(|n| label[n as usize]);
            for own in distinct(labels) {
                let polygon = face_polygon([0, 1, 2], labels, own);
                let number = |mask: PointMask| numbers[&sorted_key(&corners, mask)];
                let parts = triangles(&polygon, |mask| {
                    if mask.count_ones() == 1 {
                        corners[mask.trailing_zeros() as usize]
                    } else {
                        number(mask)
                    }
                });
                divided
                    .outer
                    .extend(parts.into_iter().map(|corners| OuterFace { corners, inside: face.inside }));
            }
        }
        divided
    }

    /// The worst shape of a cell.
    pub(super) fn worst_shape(&self) -> f64 {
        self.cells.iter().map(|c| shape(self.places(c.corners))).fold(f64::INFINITY, f64::min)
    }

    /// The number of a point of a cell; a new point is added.
    fn number(
        &mut self,
        numbers: &mut HashMap<[u32; 4], u32>,
        corners: &[u32; 4],
        mask: PointMask,
        cut: &impl Fn(u32, u32) -> DVec3,
    ) -> u32 {
        if mask.count_ones() == 1 {
            return corners[mask.trailing_zeros() as usize];
        }
        let key = sorted_key(corners, mask);
        let points = &mut self.points;
        *numbers.entry(key).or_insert_with(|| {
            let own = &key[..mask.count_ones() as usize];
            let place = match *own {
                [a, b] => cut(a, b),
                _ => own.iter().map(|n| points[*n as usize]).sum::<DVec3>() / own.len() as f64,
            };
            points.push(place);
            points.len() as u32 - 1
        })
    }

    /// Gives every face-connected part of a region its own region number, in the order of the cells. Returns
    /// the number of regions.
    pub(super) fn separate(&mut self) -> usize {
        let walls = self.shared_faces();
        let mut root: Vec<u32> = (0..self.cells.len() as u32).collect();
        fn find(root: &mut [u32], mut n: u32) -> u32 {
            while root[n as usize] != n {
                root[n as usize] = root[root[n as usize] as usize];
                n = root[n as usize];
            }
            n
        }
        for [a, b] in walls.iter().map(|w| w.cells) {
            if self.cells[a as usize].region == self.cells[b as usize].region {
                let (a, b) = (find(&mut root, a), find(&mut root, b));
                root[a.max(b) as usize] = a.min(b);
            }
        }
        // A root is the lowest of its cells and therefore comes first.
        let mut count = 0;
        for k in 0..self.cells.len() {
            let first = find(&mut root, k as u32) as usize;
            self.cells[k].region = if first == k {
                count += 1;
                count - 1
            } else {
                self.cells[first].region
            };
        }
        count as usize
    }

    /// Merges every region that is enclosed by a single other region into that region: a body in the hollow
    /// of another could not get out, and the convex parts of the outer body would fill the hollow. Regions
    /// are numbered as by [`separate`](Self::separate), `count` of them. Returns the remaining number of
    /// regions.
    pub(super) fn absorb_enclosed(&mut self, count: usize) -> usize {
        // The last index is the outside of the body.
        let outside = count;
        let mut beside = vec![BTreeSet::new(); count + 1];
        let sides = self.sides();
        for same in sides.chunk_by(|a, b| a.0 == b.0) {
            let region = |side: &([u32; 3], u32)| self.cells[side.1 as usize].region as usize;
            let (a, b) = (region(&same[0]), same.get(1).map_or(outside, region));
            if a != b {
                beside[a].insert(b);
                beside[b].insert(a);
            }
        }
        if beside[outside].len() == count {
            return count;
        }
        let mut host: Vec<usize> = (0..count).collect();
        for wall in 0..count {
            let mut reached = vec![false; count + 1];
            (reached[wall], reached[outside]) = (true, true);
            let mut next = vec![outside];
            while let Some(at) = next.pop() {
                for other in &beside[at] {
                    if !std::mem::replace(&mut reached[*other], true) {
                        next.push(*other);
                    }
                }
            }
            (0..count).filter(|k| !reached[*k]).for_each(|k| host[k] = wall);
        }
        for cell in &mut self.cells {
            let mut own = cell.region as usize;
            while host[own] != own {
                own = host[own];
            }
            cell.region = own as u32;
        }
        self.separate()
    }

    /// The faces of all cells by their ascending corners, each with its cell.
    fn sides(&self) -> Vec<([u32; 3], u32)> {
        let mut sides: Vec<([u32; 3], u32)> = Vec::with_capacity(4 * self.cells.len());
        for (k, cell) in self.cells.iter().enumerate() {
            for face in clangor_bake::mesh::tetrahedra::FACES {
                let mut corners = face.map(|i| cell.corners[i]);
                corners.sort_unstable();
                sides.push((corners, k as u32));
            }
        }
        sides.sort_unstable();
        sides
    }

    /// Faces between two cells, in the order of their corners.
    pub(super) fn shared_faces(&self) -> Vec<SharedFace> {
        let sides = self.sides();
        let pairs = sides.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 2);
        pairs.map(|same| SharedFace { corners: same[0].0, cells: [same[0].1, same[1].1] }).collect()
    }
}

/// A face between two cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SharedFace {
    /// In ascending order.
    pub(super) corners: [u32; 3],
    pub(super) cells: [u32; 2],
}

/// Whether a division needs this point: a corner, or a point at which as many regions meet as it has corners.
fn is_needed(mask: PointMask, labels: [u32; 4]) -> bool {
    let own = (0..4).filter(|k| mask >> k & 1 == 1);
    own.clone().all(|k| own.clone().all(|j| j == k || labels[j] != labels[k])) && mask != 0
}

/// The corners of a point in ascending order, padded with `u32::MAX`.
fn sorted_key(corners: &[u32; 4], mask: PointMask) -> [u32; 4] {
    let mut key: [u32; 4] = std::array::from_fn(|k| if mask >> k & 1 == 1 { corners[k] } else { u32::MAX });
    key.sort_unstable();
    key
}
