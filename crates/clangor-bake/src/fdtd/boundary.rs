//! The update of the cells next to the body: a sparse row each.
//!
//! In units of cells the wave equation, integrated over the open part of a cell, is
//!
//! ```text
//! V p'' = Σ_faces A (p_neighbour − p) + 1/6 Σ_edges (p − p_a − p_b + p_ab) + Σ_i z_i ∫ g_i dS
//! ```
//!
//! The second sum is over the edges whose four faces are all open, with the three other cells around the
//! edge: it makes the Laplacian isotropic to fourth order in the free field, and vanishes towards the body.
//! Both sums are symmetric, so that energy is conserved. Each term is taken from one cell and given to
//! another, so that volume is conserved. By the bound of Gershgorin the leapfrog is stable where V ≥ λ² ΣA/2.
//! A smaller cell borrows volume from its neighbours, which moves compressibility by a cell and creates none:
//! an error of second order. Simply enlarging the cell would cause an error of first order.
//!
//! A cell with both sides of a thin wall would connect the air in front of it with the air behind. Such a
//! cell is closed, and its faces become the wall: tight however thin the wall, and of first order in its
//! thickness. There are none where walls are thicker than √3 cells.

use std::collections::BTreeMap;

use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;

use super::cut_cells::{CutCells, Pieces};
use super::lattice::{COURANT, GHOSTS, Lattice};
use crate::radiation::rigid_motions;

/// Least volume of a cell per open face, with a small margin.
const LEAST_VOLUME: f64 = 0.51 * COURANT * COURANT;
/// Weight of an edge.
const EDGE: f64 = 1.0 / 6.0;

/// Cosine of the angle beyond which two sides face away from each other.
const OPPOSITE: f64 = -0.5;
/// Area of the lesser side that is neglected.
const SLIVER: f64 = 1e-4;

/// Representation of a body on the grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Boundary {
    /// Cells and faces are cut where the surface cuts them: second order.
    #[default]
    CutCells,
    /// A cell belongs wholly to the body or to the air: first order, an error of a few per cent at any
    /// frequency. As published, for comparison.
    Staircase,
}

/// Sparse rows: p_new = 2p − p_old + Σ_j w_j (p_j − p) + a · drive + a'' · bend.
#[derive(Clone, Debug, Default)]
pub(super) struct Rows {
    /// Cell of each row.
    pub(super) cells: Vec<u32>,
    /// End of the row's links.
    pub(super) ends: Vec<u32>,
    /// The other cells.
    pub(super) neighbours: Vec<u32>,
    /// λ² w/V.
    pub(super) weights: Vec<f32>,
    /// λ² ∫ g_i dS / V.
    pub(super) drive: Vec<[f32; RIGID_DOFS]>,
    /// λ² ∫ (x·n) g_i dV / V, x from the middle of the cell.
    pub(super) bend: Vec<[f32; RIGID_DOFS]>,
    /// λ²/V.
    pub(super) scale: Vec<f32>,
    /// Cells of the body that touch the air.
    pub(super) solid: Vec<u32>,
}

impl Pieces {
    /// V d·n: volume of the open part times the distance of its centroid from the middle of the cell, along
    /// the normal, over the area of the surface.
    fn lever(&self) -> f64 {
        let normal = DVec3::from_slice(&self.flux[..3]);
        // Opposite sides have no common normal.
        if normal.length() < 0.5 * self.area || self.area == 0.0 {
            return 0.0;
        }
        self.moment.dot(normal) / normal.length_squared()
    }

    /// Whether two sides that face away from each other, as those of a thin wall do, are in the cell.
    fn has_both_sides(&self) -> bool {
        let largest = self
            .areas
            .iter()
            .copied()
            .fold(DVec3::ZERO, |a, b| if b.length_squared() > a.length_squared() { b } else { a });
        let opposite =
            self.areas.iter().filter(|a| a.dot(largest) < OPPOSITE * a.length() * largest.length());
        opposite.map(|a| a.length()).sum::<f64>() > SLIVER
    }
}

impl CutCells {
    /// Makes each cell wholly solid or open, by its larger part.
    pub(super) fn coarsen(&mut self, centre: DVec3) {
        self.volume.iter_mut().for_each(|v| *v = if *v < 0.5 { 0.0 } else { 1.0 });
        self.pieces.clear();
        let strides = self.strides();
        let low = DVec3::from_array(self.low.map(|l| l as f64));
        for index in 0..self.volume.len() - strides[2] {
            let at = self.place(index);
            for (axis, stride) in strides.into_iter().enumerate() {
                let (here, there) = (self.volume[index], self.volume[index + stride]);
                self.open[axis][index] = here * there;
                if here == there {
                    continue;
                }
                let unit = DVec3::AXES[axis];
                let middle = low + DVec3::from_array(at.map(|x| x as f64 + 0.5)) + 0.5 * unit - centre;
                // From the body into the air.
                let (cell, normal) = if here == 0.0 { (index + stride, unit) } else { (index, -unit) };
                let pieces = self.pieces.entry(cell).or_default();
                for (sum, g) in pieces.flux.iter_mut().zip(rigid_motions(middle, normal)) {
                    *sum += g;
                }
            }
        }
    }

    /// Closes the cells that contain both sides of a wall, so that no sound passes through; returns their
    /// number.
    pub(super) fn close_walls(&mut self, centre: DVec3) -> usize {
        let strides = self.strides();
        let walls: Vec<usize> =
            self.pieces.iter().filter(|(_, p)| p.has_both_sides()).map(|(index, _)| *index).collect();
        let low = DVec3::from_array(self.low.map(|l| l as f64));
        // Every open face of the cell becomes surface of its neighbour.
        for index in &walls {
            let at = low + DVec3::from_array(self.place(*index).map(|x| x as f64 + 0.5)) - centre;
            for (axis, stride) in strides.into_iter().enumerate() {
                for (face, neighbour, normal) in [
                    (*index, index + stride, DVec3::AXES[axis]),
                    (index - stride, index - stride, -DVec3::AXES[axis]),
                ] {
                    let area = std::mem::take(&mut self.open[axis][face]);
                    if area == 0.0 {
                        continue;
                    }
                    // The formerly open area is now surface of the neighbour.
                    let pieces = self.pieces.entry(neighbour).or_default();
                    for (sum, g) in
                        pieces.flux.iter_mut().zip(rigid_motions(at + 0.5 * normal, area * normal))
                    {
                        *sum += g;
                    }
                    pieces.area += area;
                }
            }
            self.volume[*index] = 0.0;
        }
        // Between two adjacent wall cells the flux has no receiver: drop it.
        for index in &walls {
            self.pieces.remove(index);
        }
        walls.len()
    }

    /// Area of the open faces of a cell inside the rim of the box.
    fn open_area(&self, index: usize) -> f64 {
        let strides = self.strides();
        (0..3).map(|a| self.open[a][index] + self.open[a][index - strides[a]]).sum()
    }

    /// Raises every cell to the stable volume, borrowing from its neighbours as far as they exceed theirs.
    fn lend(&mut self) {
        let strides = self.strides();
        let rim = strides[2] + strides[1] + strides[0];
        for index in rim..self.volume.len() - rim {
            let least = LEAST_VOLUME * self.open_area(index);
            if self.volume[index] >= least {
                continue;
            }
            // Two passes: the second distributes the remainder that a small neighbour could not lend.
            for _ in 0..2 {
                let wanted = least - self.volume[index];
                if wanted <= 0.0 {
                    break;
                }
                // Neighbours through open faces, with their spare volume.
                let offers: Vec<(usize, f64, f64)> = (0..3)
                    .flat_map(|a| {
                        [
                            (index + strides[a], self.open[a][index]),
                            (index - strides[a], self.open[a][index - strides[a]]),
                        ]
                    })
                    .filter(|(_, area)| *area > 0.0)
                    .map(|(n, area)| {
                        let spare = (self.volume[n] - LEAST_VOLUME * self.open_area(n)).max(0.0);
                        (n, area, spare)
                    })
                    .collect();
                // Borrow in proportion to the open area.
                let share: f64 = offers.iter().filter(|o| o.2 > 0.0).map(|o| o.1).sum();
                for (n, area, spare) in offers {
                    if spare > 0.0 {
                        let lent = (wanted * area / share).min(spare);
                        self.volume[n] -= lent;
                        self.volume[index] += lent;
                    }
                }
            }
            // The remaining deficit is created.
            self.volume[index] = self.volume[index].max(least);
        }
    }

    /// Place of a cell in the box.
    fn place(&self, index: usize) -> [usize; 3] {
        let strides = self.strides();
        [index % self.size[0], index / strides[1] % self.size[1], index / strides[2]]
    }
}

impl Rows {
    /// The update rows of a body in a grid whose first cell is `origin` of that of the cut cells; none beyond
    /// a mirror plane.
    pub(super) fn new(mut cut: CutCells, lattice: &Lattice, origin: [usize; 3]) -> Self {
        // Borrow volume for stability.
        cut.lend();
        let strides = cut.strides();
        let steps = lattice.strides();
        let mut rows = Rows::default();
        let mut links: BTreeMap<isize, f64> = BTreeMap::new();
        for index in 0..cut.volume.len() {
            let at = cut.place(index);
            if (0..3).any(|a| at[a] == 0 || at[a] + 1 == cut.size[a]) {
                continue;
            }
            let images = |a: usize| if lattice.mirrored[a] { GHOSTS } else { 0 };
            if (0..3).any(|a| at[a] + cut.low[a] < origin[a] + images(a)) {
                continue;
            }
            let cell = lattice.index(std::array::from_fn(|a| at[a] + cut.low[a] - origin[a]));
            let area = cut.open_area(index);
            // Cells without open faces are solid.
            if area == 0.0 || cut.volume[index] == 0.0 {
                rows.solid.push(cell as u32);
                continue;
            }
            links.clear();
            // Face terms, and edge terms where all four faces around the edge are open.
            let mut edges = 0;
            for axis in 0..3 {
                let face =
                    |from: usize, up: bool| cut.open[axis][if up { from } else { from - strides[axis] }];
                for up in [true, false] {
                    let step = steps[axis] as isize * if up { 1 } else { -1 };
                    *links.entry(step).or_insert(0.0) += face(index, up);
                    for other in (0..axis).flat_map(|o| [(o, true), (o, false)]) {
                        let (side, aside) = other;
                        let beside =
                            |from: usize| if aside { from + strides[side] } else { from - strides[side] };
                        let ahead = if up { index + strides[axis] } else { index - strides[axis] };
                        let across =
                            |from: usize| cut.open[side][if aside { from } else { from - strides[side] }];
                        let open = face(index, up) == 1.0
                            && face(beside(index), up) == 1.0
                            && across(index) == 1.0
                            && across(ahead) == 1.0;
                        if open {
                            let sideways = steps[side] as isize * if aside { 1 } else { -1 };
                            *links.entry(step).or_insert(0.0) -= EDGE;
                            *links.entry(sideways).or_insert(0.0) -= EDGE;
                            *links.entry(step + sideways).or_insert(0.0) += EDGE;
                            edges += 1;
                        }
                    }
                }
            }
            let pieces = cut.pieces.get(&index).cloned().unwrap_or_default();
            // An undisturbed cell is left to the regular sweep.
            if edges == 12 && cut.volume[index] == 1.0 && pieces.area == 0.0 {
                continue;
            }
            // Row of the cell: links λ² w/V, drive, and second-order lever of the drive.
            let scale = COURANT * COURANT / cut.volume[index];
            for (step, weight) in &links {
                if *weight != 0.0 {
                    rows.neighbours.push(cell.wrapping_add_signed(*step) as u32);
                    rows.weights.push((scale * weight) as f32);
                }
            }
            rows.cells.push(cell as u32);
            rows.ends.push(rows.neighbours.len() as u32);
            rows.scale.push(scale as f32);
            rows.drive.push(pieces.flux.map(|g| (scale * g) as f32));
            let lever = pieces.lever();
            rows.bend.push(pieces.flux.map(|g| (scale * lever * g) as f32));
        }
        // Keep only solid cells that touch open ones.
        rows.keep_solid_skin(lattice);
        rows
    }

    /// Drops the solid cells that touch no open cell.
    fn keep_solid_skin(&mut self, lattice: &Lattice) {
        let [x, y, z] = lattice.strides().map(|s| s as i64);
        let solid = std::mem::take(&mut self.solid);
        let is_solid = |cell: i64| u32::try_from(cell).is_ok_and(|c| solid.binary_search(&c).is_ok());
        let inner = |cell: u32| {
            let c = i64::from(cell);
            (-1..=1).all(|dz| (-1..=1).all(|dy| (-1..=1).all(|dx| is_solid(c + dx * x + dy * y + dz * z))))
        };
        self.solid = solid.iter().copied().filter(|c| !inner(*c)).collect();
    }
}
