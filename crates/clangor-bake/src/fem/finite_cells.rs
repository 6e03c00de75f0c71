//! Stiffness and mass of a body of any form on a grid of cubes that are larger than its walls (finite cell
//! method).
//!
//! ```text
//! u = Σ U_n N_n,    N_n(x, y, z) = l_i(x) l_j(y) l_k(z),    l of order p on Gauss–Lobatto points
//! K = Σ_cells [ ∫_{body ∩ cell} ε(N)ᵀ C ε(N) dV + α ∫_{cell} ε(N)ᵀ C ε(N) dV ],    M = Σ_cells ∫_{body ∩ cell} ρ N N dV
//! ```
//!
//! The grid does not follow the surface: no volume mesh is made, and triangles may be of any size and
//! quality. Displacements are continuous across cells. The integrals over the body inside a cell are exact
//! (see [`moments`]). The second term, in cut cells only, moves functions that hardly touch the body to
//! frequencies far above the band; it has no mass and leaves rigid motions free of energy. The space is that
//! of the full grid, so that frequencies converge from above, and fall with p on the same grid.
//!
//! One polynomial in a cell cannot follow two walls that meet at a concave crease, nor two walls with a gap
//! between them: both are too stiff until cells are as small as the wall.
//!
//! Source: Parvizian, Düster, Rank (2007), "Finite cell method", Computational Mechanics 41;
//! Düster, Parvizian, Yang, Rank (2008), "The finite cell method for three-dimensional problems of solid
//! mechanics", CMAME 197. `Differs`: the integrals are exact, where these divide cells by octrees.

mod basis;
mod grid;
mod matrices;
mod moments;

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;

use super::rigid_motions::rigid_motions;
use super::{ElasticConstants, ElasticSystem, Elements};
use basis::Basis;
pub(crate) use grid::CellGrid;
use matrices::CellMatrices;
use moments::CellIntegrals;

/// α: stiffness of the part of a cut cell outside the body, relative to that of the body.
///
/// Larger values stiffen thin walls (1e-6: 1 % at a wall of a twentieth of a cell), smaller ones lose digits.
const OUTSIDE: f64 = 1e-10;
/// Filled part of a cell below which the cell is dropped.
const DROPPED: f64 = 1e-10;
/// Rounding of the filled part of a cell.
const FILLED: f64 = 1e-6;

/// Order p of the displacements along each axis of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Order {
    /// p = 3.
    Third,
    /// p = 4.
    Fourth,
}

impl Order {
    fn degree(self) -> usize {
        match self {
            Order::Third => 3,
            Order::Fourth => 4,
        }
    }
}

/// A cell that is filled wrongly: the surface crosses itself there, or some triangles face inwards.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "near {place} m the surface encloses {filled:.3} of a cell of {edge:.3e} m, which is not between 0 and 1: \
     it crosses itself there, or triangles face inwards"
)]
pub struct WrongCell {
    /// Middle of the cell \[m\].
    pub place: DVec3,
    /// Enclosed volume in that of the cell.
    pub filled: f64,
    /// Edge of the cell \[m\].
    pub edge: f64,
}

/// A body in the cells of a grid.
#[derive(Clone, Debug)]
pub(crate) struct FiniteCells {
    grid: CellGrid,
    basis: Basis,
    /// Places of the cells in the grid.
    cells: Vec<[usize; 3]>,
    /// Filled part of each cell.
    filled: Vec<f64>,
    /// Weights of the quadrature of each cell, on the Gauss points of the cube \[m³\].
    weights: Vec<Vec<f64>>,
    /// Nodes of each cell.
    elements: Vec<Vec<u32>>,
    /// Node positions \[m\].
    nodes: Vec<DVec3>,
}

impl FiniteCells {
    /// The cells of a grid that contain a part of the body.
    ///
    /// # Errors
    /// [`WrongCell`].
    pub(crate) fn new(surface: &TriMesh, grid: CellGrid, order: Order) -> Result<Self, WrongCell> {
        let basis = Basis::new(order.degree());
        let integrals = CellIntegrals::new(surface, &grid, &basis);
        let volume = grid.edge.powi(3);
        let mut cells = Vec::new();
        let mut filled = Vec::new();
        let mut weights = Vec::new();
        for place in grid.places() {
            let part = integrals.filled(place);
            if !(-FILLED..=1.0 + FILLED).contains(&part) {
                return Err(WrongCell { place: grid.middle(place), filled: part, edge: grid.edge });
            }
            if part > DROPPED {
                cells.push(place);
                filled.push(part);
                weights.push(integrals.weights(place, &basis).iter().map(|w| w * volume).collect());
            }
        }
        let (elements, nodes) = numbered(&grid, &basis, &cells);
        Ok(FiniteCells { grid, basis, cells, filled, weights, elements, nodes })
    }

    /// Number of nodes.
    pub(crate) fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// Stiffness and mass.
    pub(crate) fn system(&self, constants: &ElasticConstants) -> ElasticSystem {
        let elements = Elements {
            nodes: self.nodes.clone(),
            elements: &self.elements,
            rigid: rigid_motions(&self.nodes).into(),
        };
        let whole = CellMatrices::new(&self.basis, self.grid.edge, &self.whole_weights());
        ElasticSystem::assemble(elements, |e| {
            let own = CellMatrices::new(&self.basis, self.grid.edge, &self.weights[e]);
            let outside = if self.filled[e] < 1.0 - FILLED { OUTSIDE } else { 0.0 };
            let whole = &whole;
            move |i: usize, j: usize| {
                let block = own.stiffness(i, j, constants) + whole.stiffness(i, j, constants) * outside;
                (block, constants.density * own.mass(i, j))
            }
        })
    }

    /// Weights of a cell that is wholly inside.
    fn whole_weights(&self) -> Vec<f64> {
        let axis = self.basis.points();
        let volume = self.grid.edge.powi(3);
        let along = |k: usize| axis[k].1;
        let count = axis.len();
        (0..count.pow(3))
            .map(|k| volume * along(k / (count * count)) * along(k / count % count) * along(k % count))
            .collect()
    }

    /// Nodes and their weights at a point of the body; beside it, in the nearest cell.
    pub(crate) fn interpolation(&self, at: DVec3) -> (&[u32], Vec<f64>) {
        let scaled = (at - self.grid.origin) / self.grid.edge;
        let distance = |place: &[usize; 3]| {
            let low = DVec3::from_array(place.map(|n| n as f64));
            (scaled.clamp(low, low + 1.0) - scaled).length_squared()
        };
        let cell = self.grid.place(scaled).and_then(|place| self.cells.binary_search(&place).ok());
        let cell = cell.unwrap_or_else(|| {
            let nearest = |best: usize, k: usize| {
                if distance(&self.cells[k]) < distance(&self.cells[best]) { k } else { best }
            };
            (1..self.cells.len()).fold(0, nearest)
        });
        let inside = scaled - DVec3::from_array(self.cells[cell].map(|n| n as f64));
        let [x, y, z] = inside.to_array().map(|x| self.basis.values(x));
        let weights = x
            .iter()
            .flat_map(|x| y.iter().flat_map(|y| z.iter().map(move |z| x * y * z)).collect::<Vec<_>>());
        (&self.elements[cell], weights.collect())
    }
}

/// Nodes of each cell and their positions \[m\], in the order of the grid.
fn numbered(grid: &CellGrid, basis: &Basis, cells: &[[usize; 3]]) -> (Vec<Vec<u32>>, Vec<DVec3>) {
    let degree = basis.degree();
    let local = degree + 1;
    let lattice = |place: &[usize; 3], k: usize| {
        let at = [k / (local * local), k / local % local, k % local];
        [0, 1, 2].map(|a| place[a] * degree + at[a])
    };
    let mut all: Vec<[usize; 3]> =
        cells.iter().flat_map(|place| (0..local.pow(3)).map(move |k| lattice(place, k))).collect();
    all.sort_unstable();
    all.dedup();
    let number = |at: [usize; 3]| all.partition_point(|other| *other < at) as u32;
    let elements =
        cells.iter().map(|place| (0..local.pow(3)).map(|k| number(lattice(place, k))).collect()).collect();
    let along = |n: usize| (n / degree) as f64 + basis.lobatto()[n % degree];
    let nodes = all.iter().map(|at| grid.origin + grid.edge * DVec3::from_array(at.map(along))).collect();
    (elements, nodes)
}
