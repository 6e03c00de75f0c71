//! Sparse factors of K − σ M, and how many eigenvalues lie below σ.
//!
//! ```text
//! P (K − σ M) Pᵀ = L D Lᵀ
//! ```
//!
//! By Sylvester's law of inertia D has as many negative entries as there are eigenvalues below σ. That number is exact
//! however badly an iteration goes, so it is what the completeness of a spectrum is proven with.
//!
//! There is no pivoting. Where a pivot comes out small, the factors lose digits; this is measured by solving for a
//! known vector.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky, supernodal::SupernodalLdltRef,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side, Spec};

use super::ModalError;
use super::ordering::{Ordering, best_ordering};
use crate::elasticity::ElasticSystem;

/// Largest relative error of a solve that is good enough: the iteration after it mends the rest.
const WORST_SOLVE: f64 = 1e-5;

/// What the factors of all shifts share: the ordering and where their entries are.
pub(super) struct Structure {
    cholesky: SymbolicCholesky<usize>,
    starts: Vec<usize>,
    rows: Vec<usize>,
}

/// Factors at one shift.
pub(super) struct Factor<'a> {
    structure: &'a Structure,
    values: Vec<f64>,
    /// Eigenvalues below the shift.
    pub(super) below: usize,
}

impl Structure {
    pub(super) fn new(system: &ElasticSystem) -> Result<Self, ModalError> {
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
            .map_err(|_| ModalError::Memory { unknowns: size })?;
        Ok(Structure { cholesky, starts, rows })
    }

    /// Numbers in a factor.
    pub(super) fn entries(&self) -> usize {
        self.cholesky.len_val()
    }

    /// Factors K − σ M.
    ///
    /// # Errors
    /// [`ModalError::Singular`] if σ is too close to an eigenvalue, [`ModalError::Memory`].
    pub(super) fn factor(&self, system: &ElasticSystem, shift: f64) -> Result<Factor<'_>, ModalError> {
        let size = 3 * system.node_count();
        let memory = || ModalError::Memory { unknowns: size };
        let mut entries = Vec::with_capacity(self.rows.len());
        let (columns, _) = system.pattern();
        for node in 0..system.node_count() {
            for axis in 0..3 {
                for entry in columns[node]..columns[node + 1] {
                    let block = system.shifted_block(entry, shift);
                    let from = if entry == columns[node] { axis } else { 0 };
                    entries.extend((from..3).map(|row| block.col(axis)[row]));
                }
            }
        }
        let pattern = SymbolicSparseColMatRef::new_checked(size, size, &self.starts, None, &self.rows);
        let matrix = SparseColMatRef::new(pattern, entries.as_slice());
        let mut values = Vec::new();
        values.try_reserve_exact(self.entries()).map_err(|_| memory())?;
        values.resize(self.entries(), 0.0);
        let scratch = self.cholesky.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Spec::default());
        let mut buffer = MemBuffer::try_new(scratch).map_err(|_| memory())?;
        self.cholesky
            .factorize_numeric_ldlt(
                &mut values,
                matrix,
                Side::Lower,
                LdltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut buffer),
                Spec::default(),
            )
            .map_err(|_| ModalError::Singular { shift })?;
        let below = self.negative_pivots(&values);
        let factor = Factor { structure: self, values, below };
        let error = factor.solve_error(system, shift);
        // A comparison that is false for NaN.
        if error <= WORST_SOLVE { Ok(factor) } else { Err(ModalError::Singular { shift }) }
    }

    fn negative_pivots(&self, values: &[f64]) -> usize {
        let SymbolicCholeskyRaw::Supernodal(symbolic) = self.cholesky.raw() else { return 0 };
        let factor = SupernodalLdltRef::new(symbolic, values);
        let negative = |s: usize| {
            let block = factor.supernode(s).val();
            (0..block.ncols()).filter(|k| block[(*k, *k)] < 0.0).count()
        };
        (0..symbolic.n_supernodes()).map(negative).sum()
    }
}

impl Factor<'_> {
    /// Solves (K − σ M) x = b for all columns of `b`, in place.
    pub(super) fn solve(&self, b: MatMut<'_, f64>) {
        let cholesky = &self.structure.cholesky;
        let mut buffer = MemBuffer::new(cholesky.solve_in_place_scratch::<f64>(b.ncols(), Par::Seq));
        LdltRef::new(cholesky, &self.values).solve_in_place_with_conj(
            Conj::No,
            b,
            Par::Seq,
            MemStack::new(&mut buffer),
        );
    }

    /// Relative error of the solution for M times a known vector with all frequencies in it.
    fn solve_error(&self, system: &ElasticSystem, shift: f64) -> f64 {
        let size = 3 * system.node_count();
        let mut seed = 1;
        let known: Vec<f64> = (0..size).map(|_| super::random(&mut seed)).collect();
        let (mut stiff, mut heavy) = (vec![0.0; size], vec![0.0; size]);
        system.multiply_stiffness(&known, 1, &mut stiff);
        system.multiply_mass(&known, 1, &mut heavy);
        let mut b: Vec<f64> = stiff.iter().zip(&heavy).map(|(k, m)| k - shift * m).collect();
        self.solve(MatMut::from_column_major_slice_mut(&mut b, size, 1));
        let square = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        let error: f64 = b.iter().zip(&known).map(|(x, y)| (x - y) * (x - y)).sum();
        (error / square(&known)).sqrt()
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
