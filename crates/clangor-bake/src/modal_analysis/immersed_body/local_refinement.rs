//! Which cells of a grid become smaller so that all modes meet an accuracy.
//!
//! On a grid of few nodes, those at all inner edges do: cells that are larger than the parts which meet there
//! tie these together, which neither a higher order nor the remainders show. On all others,
//!
//! ```text
//! e_m → e_m q_m,    q_m = 1 − (1 − 1/g) Σ_{c halved} η_cm / Σ_c η_cm
//! ```
//!
//! with the error e_m of mode m, its remainder η_cm in cell c (see
//! [`finite_cells`](crate::fem::finite_cells)), and the gain g of halving a cell. The cell with the largest
//! Σ e_m η_cm over the modes that are not yet accurate comes first, then the next.

use glam::DVec3;

use super::{Immersed, ImmersedBody};
use crate::fem::finite_cells::{FiniteCells, LevelPlace, Remainder};
use crate::geometry_class::inner_creases::inner_edges_of_walls;
use crate::modal_analysis::mirror_parities::PartMode;
use crate::modal_analysis::{Finer, ModalAnalysisError, RefinableDiscretization};

/// Largest part of the remainder of a mode that one step halves.
const MOST_OF_ALL: f64 = 0.9;

/// Modes, those with the largest errors, for which cells are halved.
const MOST_MODES: usize = 64;
/// Error for which cells are halved, in the accuracy asked for.
const AIM: f64 = 0.7;
/// Nodes for each halved cell, those that it halves beside it included. Seen: 370 to 860.
const MORE_NODES: f64 = 450.0;
/// Most steps to fewer halved cells where a grid has more nodes than it may have.
const MOST_STEPS: usize = 4;
/// Most halvings of a cell, which bounds memory.
const MOST_HALVINGS: usize = 4;
/// Share of an error that is left where all cells at inner edges are halved: that of an error ∝ edge^0.6.
const AT_EDGES: f64 = 0.66;
/// Most nodes of such a grid.
const MOST_NODES_AT_EDGES: f64 = 20_000.0;
/// Share of an error above which a step is not worth its work.
const NO_GAIN: f64 = 0.9;

impl ImmersedBody<'_> {
    /// A grid with smaller cells where modes are resolved least, of `most` nodes; `None` where these do not
    /// help.
    pub(super) fn finer_where_needed(
        &self,
        than: &Immersed,
        wanted: &Finer<'_, Vec<PartMode>>,
        most: f64,
    ) -> Result<Option<Immersed>, ModalAnalysisError> {
        let target = AIM * wanted.accuracy;
        let modes = 0..wanted.errors.len().min(wanted.modes.len());
        let mut worst: Vec<usize> = modes.filter(|mode| wanted.errors[*mode] > target).collect();
        worst.sort_by(|a, b| wanted.errors[*b].total_cmp(&wanted.errors[*a]));
        worst.truncate(MOST_MODES);
        let shapes: Vec<&[DVec3]> = worst.iter().map(|mode| &wanted.modes[*mode].mode.shape[..]).collect();
        let remainders = than.cells.remainders(&shapes, self.constants);
        let errors: Vec<f64> = worst.iter().map(|mode| wanted.errors[*mode] / target).collect();
        let mut more = (most - than.cells.node_count() as f64).max(0.0) / MORE_NODES;
        let gain = 2.0_f64.powf(self.convergence());
        for _ in 0..MOST_STEPS {
            let halved = cells_to_halve(&remainders, &errors, gain, more as usize);
            let mut inaccurate = errors.iter().zip(&halved.shares).filter(|(error, _)| AIM * **error > 1.0);
            if halved.cells.is_empty() || inaccurate.all(|(_, share)| *share > NO_GAIN) {
                return Ok(None);
            }
            let mut refinement = than.refinement.clone();
            halved.cells.iter().for_each(|cell| refinement.divide(*cell));
            let grid = (than.cells.grid(), &refinement);
            let cells = FiniteCells::new(self.framed(), grid, than.order, self.walls.thickness)?;
            if cells.node_count() as f64 <= most {
                let mut shares = vec![1.0; wanted.errors.len()];
                worst.iter().zip(halved.shares).for_each(|(mode, share)| shares[*mode] = share);
                return Ok(Some(Immersed { cells, refinement, shares, is_by_order: false, ..*than }));
            }
            more *= 0.5;
        }
        Ok(None)
    }

    /// A grid with smaller cells at all inner edges, of `most` nodes, whatever the remainders say; `None`
    /// without such edges, or of more nodes.
    pub(super) fn finer_at_edges(
        &self,
        than: &Immersed,
        (modes, most): (usize, f64),
    ) -> Result<Option<Immersed>, ModalAnalysisError> {
        let edges = inner_edges_of_walls(&self.surface, &self.walls);
        let at_edges = self.cells_at(&edges, &than.cells);
        let mut refinement = than.refinement.clone();
        at_edges.iter().for_each(|cell| refinement.divide(*cell));
        if at_edges.is_empty() {
            return Ok(None);
        }
        let grid = (than.cells.grid(), &refinement);
        let cells = FiniteCells::new(self.framed(), grid, than.order, self.walls.thickness)?;
        let shares = vec![AT_EDGES; modes];
        let (is_by_order, is_finer_at_edges) = (false, true);
        let mesh = Immersed { cells, refinement, shares, is_by_order, is_finer_at_edges, ..*than };
        Ok((mesh.cells.node_count() as f64 <= most.min(MOST_NODES_AT_EDGES)).then_some(mesh))
    }
}

/// Cells to halve, and q of each mode.
struct Halved {
    cells: Vec<LevelPlace>,
    shares: Vec<f64>,
}

/// The cells to halve, `most` at most, for errors in units of the accuracy; `gain` is that of halving.
fn cells_to_halve(remainders: &[Remainder], errors: &[f64], gain: f64, most: usize) -> Halved {
    let total = |mode: usize| remainders.iter().map(|own| own.energies[mode]).sum::<f64>();
    let totals: Vec<f64> = (0..errors.len()).map(total).collect();
    let part = |cell: usize, mode: usize| {
        if totals[mode] > 0.0 { (remainders[cell].energies[mode] / totals[mode]).max(0.0) } else { 0.0 }
    };
    // Halved part of the remainder of each mode, and that which the accuracy needs.
    let mut halved = vec![0.0; errors.len()];
    let needed: Vec<f64> = errors
        .iter()
        .map(|error| ((1.0 - 1.0 / error.max(1.0)) / (1.0 - 1.0 / gain)).min(MOST_OF_ALL))
        .collect();
    let mut left: Vec<usize> =
        (0..remainders.len()).filter(|cell| remainders[*cell].cell.0 < MOST_HALVINGS).collect();
    let mut cells = Vec::new();
    while cells.len() < most {
        let open: Vec<usize> = (0..errors.len()).filter(|mode| halved[*mode] < needed[*mode]).collect();
        let worth = |cell: usize| open.iter().map(|mode| errors[*mode] * part(cell, *mode)).sum::<f64>();
        let worths = left.iter().map(|cell| worth(*cell)).enumerate();
        let Some((place, best)) = worths.reduce(|a, b| if b.1 > a.1 { b } else { a }) else { break };
        if best <= 0.0 {
            break;
        }
        let cell = left.swap_remove(place);
        halved.iter_mut().enumerate().for_each(|(mode, sum)| *sum += part(cell, mode));
        cells.push(remainders[cell].cell);
    }
    let shares = halved.iter().map(|halved| 1.0 - (1.0 - 1.0 / gain) * halved.min(1.0)).collect();
    Halved { cells, shares }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cells_that_matter_are_halved() {
        // Mode 0 is resolved least in cell 2, mode 1 in cell 0; mode 2 is accurate.
        let energies = [[1.0, 8.0, 9.0], [1.0, 1.0, 9.0], [6.0, 0.5, 9.0], [2.0, 0.5, 9.0]];
        let remainders: Vec<Remainder> = energies
            .iter()
            .enumerate()
            .map(|(k, own)| Remainder { cell: (0, [k, 0, 0]), energies: own.to_vec() })
            .collect();
        let halved = cells_to_halve(&remainders, &[1.5, 2.0, 0.9], 4.0, 10);
        assert_eq!(halved.cells, [(0, [0, 0, 0]), (0, [2, 0, 0])]);
        let expected = [0.7, 0.85, 0.5].map(|part| 1.0 - 0.75 * part);
        for (found, expected) in halved.shares.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{:?}", halved.shares);
        }
        assert_eq!(cells_to_halve(&remainders, &[1.5, 2.0, 0.9], 4.0, 1).cells.len(), 1);
        assert!(cells_to_halve(&remainders, &[0.5; 3], 4.0, 10).cells.is_empty());
    }
}
