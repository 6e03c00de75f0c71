//! Stiffness and mass of a body of any form on a grid of cubes that are larger than its walls (finite cell
//! method).
//!
//! ```text
//! u = Σ U_n N_n,    N_n(x, y, z) = l_i(x) l_j(y) l_k(z),    l of order p on Gauss–Lobatto points
//! K = Σ_cells [ ∫_{body ∩ cell} ε(N)ᵀ C ε(N) dV + α ∫_{cell} ε(N)ᵀ C ε(N) dV ]
//! M = Σ_cells ∫_{body ∩ cell} ρ N N dV
//! ```
//!
//! The grid does not follow the surface: no volume mesh is made, and triangles may be of any size and
//! quality. Displacements are continuous across cells. The integrals over the body inside a cell are exact
//! (see `moments`). The second term, in cut cells only, moves functions that hardly touch the body to
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
use moments::cell_moments;

/// α: stiffness of the part of a cut cell outside the body, relative to that of the body.
///
/// Larger values stiffen thin walls (1e-6: 1 % at a wall of a twentieth of a cell), smaller ones lose digits.
const OUTSIDE: f64 = 1e-10;
/// Filled part of a cell below which the cell is dropped.
const DROPPED: f64 = 1e-10;
/// Rounding of the filled part of a cell.
const FILLED: f64 = 1e-6;

/// Nodes of a cell that it does not share, at order 4.
const NODES_PER_CELL: f64 = 64.0;
/// Cells of a thin wall per square of their edge on its two faces.
const CELLS_PER_FACE: f64 = 0.6;

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
    "near {place} m the surface encloses {filled:.3} of a cell of {edge:.3e} m, which is not between 0 and \
     1: it crosses itself there, or triangles face inwards"
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

/// Cells and nodes of a body before they are made, from its area \[m²\], volume \[m³\] and the edge of the
/// cells \[m\].
pub(crate) fn expected(area: f64, volume: f64, edge: f64) -> [f64; 2] {
    let cells = CELLS_PER_FACE * area / (edge * edge) + volume / edge.powi(3);
    [cells, NODES_PER_CELL * cells]
}

impl FiniteCells {
    /// The cells of a grid that contain a part of the body.
    ///
    /// # Errors
    /// [`WrongCell`].
    pub(crate) fn new(surface: &TriMesh, grid: CellGrid, order: Order) -> Result<Self, WrongCell> {
        let basis = Basis::new(order.degree());
        let volume = grid.edge.powi(3);
        let mut cells = Vec::new();
        let mut filled = Vec::new();
        let mut weights = Vec::new();
        for cell in cell_moments(surface, &grid, &basis) {
            let part = cell.filled();
            if !(-FILLED..=1.0 + FILLED).contains(&part) {
                return Err(WrongCell { place: grid.middle(cell.place), filled: part, edge: grid.edge });
            }
            if part > DROPPED {
                cells.push(cell.place);
                filled.push(part);
                weights.push(cell.weights(&basis).iter().map(|w| w * volume).collect());
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

#[cfg(test)]
mod tests {
    use clangor_core::geometry::mass_properties::MassProperties;
    use clangor_core::material::presets::GLASS;
    use clangor_core::shape::Shape;

    use super::*;

    /// Quadratic displacements are in the space, so that their energies are exact: compared with integrals
    /// over a box in closed form.
    #[test]
    fn volume_mass_and_energy_are_those_of_the_body() {
        let constants = ElasticConstants::of(&GLASS.material()).expect("glass");
        for (name, edge) in [("box:0.1x0.06x0.004", 0.013), ("torus:0.03x0.004@0.001", 0.011)] {
            let mesh = Shape::parse(name).expect("a shape").mesh();
            let exact = MassProperties::of(&mesh).expect("a solid");
            for order in [Order::Third, Order::Fourth] {
                let cells = FiniteCells::new(&mesh, CellGrid::around(&mesh, edge), order).expect("cells");
                let system = cells.system(&constants);
                let energy = |motion: &dyn Fn(DVec3) -> DVec3| {
                    let u: Vec<f64> = cells.nodes.iter().flat_map(|x| motion(*x).to_array()).collect();
                    let (mut stiff, mut heavy) = (vec![0.0; u.len()], vec![0.0; u.len()]);
                    system.multiply_stiffness(&u, 1, &mut stiff);
                    system.multiply_mass(&u, 1, &mut heavy);
                    let with = |y: &[f64]| u.iter().zip(y).map(|(a, b)| a * b).sum::<f64>();
                    [with(&stiff), with(&heavy)]
                };
                let density = constants.density;
                let mass = density * exact.volume;
                let [stretched, _] = energy(&|x| DVec3::new(x.x, 0.0, 0.0));
                let modulus = constants.lame_lambda + 2.0 * constants.shear_modulus;
                // Residuals seen: 1e-13; the part of cut cells outside adds 1e-9.
                let [rigid, moving] = energy(&|_| DVec3::X);
                assert!((moving / mass - 1.0).abs() < 1e-12, "{name} {order:?} {moving} {mass}");
                assert!((stretched / (modulus * exact.volume) - 1.0).abs() < 1e-7, "{name} {order:?}");
                assert!(rigid.abs() < 1e-10 * stretched, "{name} {order:?} {rigid:e}");
                // ∫ ρ (ω × x)² is the moment of inertia.
                let [_, turning] = energy(&|x| DVec3::Z.cross(x));
                let arm = exact.centre_of_mass.with_z(0.0).length_squared();
                let inertia = density * (exact.inertia.z_axis.z + arm * exact.volume);
                assert!((turning / inertia - 1.0).abs() < 1e-11, "{name} {order:?} {turning} {inertia}");
            }
        }
    }

    #[test]
    fn displacements_are_found_again_at_any_point() {
        let mesh = Shape::parse("box:0.1x0.06x0.004").expect("a shape").mesh();
        let cells = FiniteCells::new(&mesh, CellGrid::around(&mesh, 0.013), Order::Fourth).expect("cells");
        for point in [DVec3::ZERO, DVec3::new(0.05, -0.03, 0.002), DVec3::new(0.051, 0.0, 0.0)] {
            let (nodes, weights) = cells.interpolation(point);
            let found: DVec3 = nodes.iter().zip(&weights).map(|(n, w)| cells.nodes[*n as usize] * *w).sum();
            assert!(found.distance(point) < 1e-15, "{point} {found}");
        }
    }
}
