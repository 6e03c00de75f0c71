//! Symbolic factorisation, shared by all sparse factors of a body: order of elimination and pattern of the
//! factor.
//!
//! ```text
//! P A Pᵀ = L Lᵀ or L D Lᵀ,    A any combination of K and M
//! ```

use faer::Side;
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky, supernodal::SymbolicSupernodalCholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use glam::DMat3;

use super::ElasticSystem;
use super::ordering::{Ordering, best_ordering};
use super::out_of_memory::OutOfMemory;

/// Order and pattern. The factor is supernodal: columns of the same pattern are one dense block.
pub(crate) struct Elimination {
    cholesky: SymbolicCholesky<usize>,
    /// Permutation: the unknown that is eliminated first, second and so on.
    order: Vec<usize>,
    /// Column starts and rows of the lower half of the matrix, by unknowns.
    starts: Vec<usize>,
    rows: Vec<usize>,
}

impl Elimination {
    pub(crate) fn new(system: &ElasticSystem) -> Result<Self, OutOfMemory> {
        let (starts, rows) = unknowns(system);
        let size = 3 * system.node_count();
        let Ordering { forward, inverse } = best_ordering(system)?;
        let pattern = SymbolicSparseColMatRef::new_checked(size, size, &starts, None, &rows);
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let permutation = PermRef::new_checked(&forward, &inverse, size);
        let ordering = SymmetricOrdering::Custom(permutation);
        let cholesky = factorize_symbolic_cholesky(pattern, Side::Lower, ordering, parameters)
            .map_err(|_| OutOfMemory { unknowns: size })?;
        Ok(Elimination { cholesky, order: forward, starts, rows })
    }

    /// Number of unknowns.
    pub(crate) fn size(&self) -> usize {
        self.starts.len() - 1
    }

    pub(crate) fn cholesky(&self) -> &SymbolicCholesky<usize> {
        &self.cholesky
    }

    /// Columns of the factor that have the same pattern, as blocks.
    pub(crate) fn supernodes(&self) -> &SymbolicSupernodalCholesky<usize> {
        match self.cholesky.raw() {
            SymbolicCholeskyRaw::Supernodal(symbolic) => symbolic,
            SymbolicCholeskyRaw::Simplicial(_) => unreachable!("new demands supernodes"),
        }
    }

    pub(crate) fn order(&self) -> &[usize] {
        &self.order
    }

    pub(crate) fn out_of_memory(&self) -> OutOfMemory {
        OutOfMemory { unknowns: self.size() }
    }

    /// Zeros for the numbers of a factor.
    pub(crate) fn room(&self) -> Result<Vec<f64>, OutOfMemory> {
        let mut values = Vec::new();
        values.try_reserve_exact(self.cholesky.len_val()).map_err(|_| self.out_of_memory())?;
        values.resize(self.cholesky.len_val(), 0.0);
        Ok(values)
    }

    /// The entries of the lower half of a matrix, whose 3 × 3 blocks `block` gives by their place in the
    /// pattern of the system.
    pub(crate) fn gather(&self, system: &ElasticSystem, block: impl Fn(usize) -> DMat3) -> Vec<f64> {
        let mut entries = Vec::with_capacity(self.rows.len());
        let (columns, _) = system.pattern();
        for node in 0..system.node_count() {
            for axis in 0..3 {
                for entry in columns[node]..columns[node + 1] {
                    let from = if entry == columns[node] { axis } else { 0 };
                    let block = block(entry);
                    entries.extend((from..3).map(|row| block.col(axis)[row]));
                }
            }
        }
        entries
    }

    /// The matrix of entries from [`gather`](Self::gather).
    pub(crate) fn matrix<'a>(&'a self, entries: &'a [f64]) -> SparseColMatRef<'a, usize, f64> {
        let size = self.size();
        let pattern = SymbolicSparseColMatRef::new_checked(size, size, &self.starts, None, &self.rows);
        SparseColMatRef::new(pattern, entries)
    }

    /// Decouples unknowns from all others: their rows and columns keep the diagonal only.
    pub(crate) fn detach(&self, entries: &mut [f64], held: &[usize]) {
        for column in 0..self.size() {
            let range = self.starts[column]..self.starts[column + 1];
            for (row, entry) in self.rows[range.clone()].iter().zip(&mut entries[range]) {
                if *row != column && (held.contains(row) || held.contains(&column)) {
                    *entry = 0.0;
                }
            }
        }
    }
}

/// Column starts and rows of the lower half, by unknowns.
fn unknowns(system: &ElasticSystem) -> (Vec<usize>, Vec<usize>) {
    let (columns, nodes) = system.pattern();
    let mut starts = vec![0];
    let mut rows = Vec::with_capacity(9 * nodes.len());
    for node in 0..system.node_count() {
        for axis in 0..3 {
            for other in &nodes[columns[node]..columns[node + 1]] {
                let other = *other as usize;
                let from = if other == node { axis } else { 0 };
                rows.extend((from..3).map(|row| 3 * other + row));
            }
            starts.push(rows.len());
        }
    }
    (starts, rows)
}
