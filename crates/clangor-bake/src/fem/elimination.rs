//! Symbolic factorisation, shared by all sparse factors of a body: order of elimination and pattern of the
//! factor.
//!
//! ```text
//! P A Pᵀ = L Lᵀ or L D Lᵀ,    A any combination of K and M
//! ```

use std::sync::{Mutex, PoisonError};

use faer::Side;
use faer::dyn_stack::MemBuffer;
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky, supernodal::SymbolicSupernodalCholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use glam::DMat3;

use super::ElasticSystem;
use super::ordering::{Fill, Ordering, best_ordering};
use super::out_of_memory::OutOfMemory;

/// Order and pattern. The factor is supernodal: columns of the same pattern are one dense block. Indices have
/// 32 bits: a factor of more than 2³¹ numbers, 17 GB, counts as one that does not fit.
pub(crate) struct Elimination {
    cholesky: SymbolicCholesky<u32>,
    /// Permutation: the unknown that is eliminated first, second and so on.
    order: Vec<u32>,
    /// Column starts and rows of the lower half of the matrix, by unknowns.
    starts: Vec<u32>,
    rows: Vec<u32>,
    fill: Fill,
    spare: Mutex<Spare>,
}

/// Memory of factors that are no longer needed, for the next ones: the system takes as long to supply new
/// pages as a quarter of a factorisation.
#[derive(Default)]
struct Spare {
    /// Numbers of factors.
    values: Vec<Vec<f64>>,
    /// Entries of a matrix.
    entries: Vec<f64>,
    /// Scratch of a factorisation.
    scratch: Option<MemBuffer>,
}

impl Elimination {
    pub(crate) fn new(system: &ElasticSystem) -> Result<Self, OutOfMemory> {
        let size = 3 * system.node_count();
        let (starts, rows) = unknowns(system).ok_or(OutOfMemory { unknowns: size })?;
        let Ordering { forward, inverse, fill } = best_ordering(system)?;
        let pattern = SymbolicSparseColMatRef::new_checked(size, size, &starts, None, &rows);
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let permutation = PermRef::new_checked(&forward, &inverse, size);
        let ordering = SymmetricOrdering::Custom(permutation);
        let cholesky = factorize_symbolic_cholesky(pattern, Side::Lower, ordering, parameters)
            .map_err(|_| OutOfMemory { unknowns: size })?;
        Ok(Elimination { cholesky, order: forward, starts, rows, fill, spare: Mutex::default() })
    }

    /// Number of unknowns.
    pub(crate) fn size(&self) -> usize {
        self.starts.len() - 1
    }

    pub(crate) fn cholesky(&self) -> &SymbolicCholesky<u32> {
        &self.cholesky
    }

    /// Columns of the factor that have the same pattern, as blocks.
    pub(crate) fn supernodes(&self) -> &SymbolicSupernodalCholesky<u32> {
        match self.cholesky.raw() {
            SymbolicCholeskyRaw::Supernodal(symbolic) => symbolic,
            SymbolicCholeskyRaw::Simplicial(_) => unreachable!("new demands supernodes"),
        }
    }

    /// Size of a factor, and the work to compute it.
    pub(crate) fn fill(&self) -> Fill {
        self.fill
    }

    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }

    pub(crate) fn out_of_memory(&self) -> OutOfMemory {
        OutOfMemory { unknowns: self.size() }
    }

    fn spare<T>(&self, take: impl FnOnce(&mut Spare) -> T) -> T {
        take(&mut self.spare.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Room for the numbers of a factor, with any numbers in it.
    pub(crate) fn room(&self) -> Result<Vec<f64>, OutOfMemory> {
        if let Some(values) = self.spare(|spare| spare.values.pop()) {
            return Ok(values);
        }
        let mut values = Vec::new();
        values.try_reserve_exact(self.cholesky.len_val()).map_err(|_| self.out_of_memory())?;
        values.resize(self.cholesky.len_val(), 0.0);
        Ok(values)
    }

    /// Keeps room from [`room`](Self::room) for the next factor.
    pub(crate) fn keep_room(&self, values: Vec<f64>) {
        self.spare(|spare| spare.values.push(values));
    }

    /// Scratch for a factorisation of which all need the same, `new` where none is kept.
    pub(crate) fn scratch(
        &self,
        new: impl FnOnce() -> Result<MemBuffer, OutOfMemory>,
    ) -> Result<MemBuffer, OutOfMemory> {
        self.spare(|spare| spare.scratch.take()).map_or_else(new, Ok)
    }

    /// Keeps the entries and the scratch of a factorisation for the next one.
    pub(crate) fn keep_scratch(&self, entries: Vec<f64>, scratch: MemBuffer) {
        self.spare(|spare| (spare.entries, spare.scratch) = (entries, Some(scratch)));
    }

    /// The entries of the lower half of a matrix, whose 3 × 3 blocks `block` gives by their place in the
    /// pattern of the system.
    pub(crate) fn gather(&self, system: &ElasticSystem, block: impl Fn(usize) -> DMat3) -> Vec<f64> {
        let mut entries = self.spare(|spare| std::mem::take(&mut spare.entries));
        entries.clear();
        entries.reserve(self.rows.len());
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
    pub(crate) fn matrix<'a>(&'a self, entries: &'a [f64]) -> SparseColMatRef<'a, u32, f64> {
        let size = self.size();
        let pattern = SymbolicSparseColMatRef::new_checked(size, size, &self.starts, None, &self.rows);
        SparseColMatRef::new(pattern, entries)
    }

    /// Decouples unknowns from all others: their rows and columns keep the diagonal only.
    pub(crate) fn detach(&self, entries: &mut [f64], held: &[usize]) {
        for column in 0..self.size() {
            let range = self.starts[column] as usize..self.starts[column + 1] as usize;
            for (row, entry) in self.rows[range.clone()].iter().zip(&mut entries[range]) {
                let row = *row as usize;
                if row != column && (held.contains(&row) || held.contains(&column)) {
                    *entry = 0.0;
                }
            }
        }
    }
}

/// Column starts and rows of the lower half, by unknowns; `None` if the starts need more than 32 bits.
fn unknowns(system: &ElasticSystem) -> Option<(Vec<u32>, Vec<u32>)> {
    let (columns, nodes) = system.pattern();
    let mut starts = vec![0];
    let mut rows = Vec::with_capacity(9 * nodes.len());
    for node in 0..system.node_count() {
        for axis in 0..3 {
            for other in &nodes[columns[node]..columns[node + 1]] {
                let from = if *other as usize == node { axis } else { 0 };
                rows.extend((from..3).map(|row| 3 * other + row));
            }
            starts.push(u32::try_from(rows.len()).ok()?);
        }
    }
    Some((starts, rows))
}
