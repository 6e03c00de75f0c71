//! In which order to eliminate the unknowns.
//!
//! Approximate minimum degree on the graph of the nodes; the three unknowns of a node stay together.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

use super::ModalError;
use crate::elasticity::ElasticSystem;

/// A permutation of the unknowns and its inverse.
pub(super) struct Ordering {
    pub(super) forward: Vec<usize>,
    pub(super) inverse: Vec<usize>,
}

pub(super) fn best_ordering(system: &ElasticSystem) -> Result<Ordering, ModalError> {
    let count = system.node_count();
    let (starts, rows) = system.pattern();
    let rows: Vec<usize> = rows.iter().map(|r| *r as usize).collect();
    let graph = SymbolicSparseColMatRef::new_checked(count, count, starts, None, &rows);
    let memory = || ModalError::Memory { unknowns: 3 * count };
    let (mut forward, mut inverse) = (vec![0; count], vec![0; count]);
    let mut buffer = MemBuffer::try_new(amd::order_maybe_unsorted_scratch::<usize>(count, rows.len()))
        .map_err(|_| memory())?;
    amd::order_maybe_unsorted(
        &mut forward,
        &mut inverse,
        graph,
        amd::Control::default(),
        MemStack::new(&mut buffer),
    )
    .map_err(|_| memory())?;
    Ok(by_unknowns(&forward))
}

fn by_unknowns(nodes: &[usize]) -> Ordering {
    let forward: Vec<usize> = nodes.iter().flat_map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect();
    let mut inverse = vec![0; forward.len()];
    forward.iter().enumerate().for_each(|(k, n)| inverse[*n] = k);
    Ordering { forward, inverse }
}
