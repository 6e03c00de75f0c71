//! The body in the cells of each size, and the elements that its parts are.

use std::iter;

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;

use super::WrongCell;
use super::basis::Basis;
use super::grid::CellGrid;
use super::parts::Parts;
use super::refinement::Refinement;

/// The body in all cells of one size.
#[derive(Clone, Debug)]
pub(super) struct Level {
    pub(super) grid: CellGrid,
    pub(super) body: Parts,
    /// Parts of all larger cells.
    pub(super) first: usize,
    /// Ties of all larger cells.
    pub(super) first_tie: usize,
}

/// All levels of a grid, from the largest cells to the smallest.
pub(super) fn levels(
    surface: &TriMesh,
    grid: CellGrid,
    refinement: &Refinement,
    basis: &Basis,
    wall: f64,
) -> Result<Vec<Level>, WrongCell> {
    let grids = iter::successors(Some(grid), |grid| Some(grid.halved()));
    let (mut first, mut first_tie) = (0, 0);
    let mut levels = Vec::new();
    for (level, grid) in grids.take(refinement.levels()).enumerate() {
        let body = Parts::new(surface, &grid, basis, wall, |place| refinement.keeps(level, place))?;
        let (parts, ties) = (body.parts.len(), body.ties.len());
        levels.push(Level { grid, body, first, first_tie });
        (first, first_tie) = (first + parts, first_tie + ties);
    }
    Ok(levels)
}

/// The nodes that the displacement of a part depends on.
#[derive(Clone, Debug)]
pub(super) struct Element {
    /// Those of the system.
    pub(super) nodes: Vec<u32>,
    /// Of each node of the cell: places in `nodes`, and weights. Where none hangs, they are `nodes`
    /// themselves.
    pub(super) hanging: Option<Vec<Vec<(usize, f64)>>>,
}

impl AsRef<[u32]> for Element {
    fn as_ref(&self) -> &[u32] {
        &self.nodes
    }
}

impl Element {
    /// Places in `nodes` and weights of a node of the cell.
    pub(super) fn terms(&self, k: usize) -> impl Iterator<Item = (usize, f64)> {
        let own = self.hanging.is_none().then_some((k, 1.0));
        let others = self.hanging.iter().flat_map(move |hanging| hanging[k].iter().copied());
        own.into_iter().chain(others)
    }

    /// The node of the system that a node of the cell is; none if it hangs.
    pub(super) fn node(&self, k: usize) -> Option<u32> {
        match &self.hanging {
            None => Some(self.nodes[k]),
            Some(hanging) => match hanging[k][..] {
                [(place, 1.0)] => Some(self.nodes[place]),
                _ => None,
            },
        }
    }

    /// Weights of `nodes` for weights of the nodes of the cell.
    pub(super) fn gathered(&self, weights: Vec<f64>) -> Vec<f64> {
        let Some(hanging) = &self.hanging else { return weights };
        let mut gathered = vec![0.0; self.nodes.len()];
        for (terms, weight) in hanging.iter().zip(weights) {
            terms.iter().for_each(|(place, part)| gathered[*place] += part * weight);
        }
        gathered
    }

    /// Displacements of the nodes of the cell.
    pub(super) fn motion(&self, shape: &[DVec3]) -> Vec<DVec3> {
        let at = |place: usize| shape[self.nodes[place] as usize];
        match &self.hanging {
            None => (0..self.nodes.len()).map(at).collect(),
            Some(hanging) => {
                let sum = |terms: &Vec<(usize, f64)>| terms.iter().map(|(place, w)| at(*place) * *w).sum();
                hanging.iter().map(sum).collect()
            }
        }
    }
}
