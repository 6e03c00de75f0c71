//! Sparse factors of K − σ M, and the number of eigenvalues below σ (Sturm count).
//!
//! ```text
//! P (K − σ M) Pᵀ = L D Lᵀ
//! ```
//!
//! By Sylvester's law of inertia D has as many negative entries as there are eigenvalues below σ. The count
//! does not depend on any iteration, so it proves that a spectrum is complete.
//!
//! There is no pivoting. Small pivots lose digits; a solve with a known solution measures the loss.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::sparse::linalg::cholesky::{LdltRef, supernodal::SupernodalLdltRef};
use faer::{Conj, MatMut, Par, Side, Spec};

use super::ModalError;
use crate::fem::ElasticSystem;
use crate::fem::elimination::Elimination;

/// Largest acceptable relative error of a solve; the iteration corrects the rest.
const WORST_SOLVE: f64 = 1e-5;

/// Factors at one shift.
pub(super) struct Factor<'a> {
    structure: &'a Elimination,
    values: Vec<f64>,
    /// Eigenvalues below the shift.
    pub(super) below: usize,
}

/// Factors K − σ M.
///
/// # Errors
/// [`ModalError::Singular`] if σ is too close to an eigenvalue, [`ModalError::Memory`].
pub(super) fn factor<'a>(
    structure: &'a Elimination,
    system: &ElasticSystem,
    shift: f64,
) -> Result<Factor<'a>, ModalError> {
    let entries = structure.gather(system, |entry| system.shifted_block(entry, shift));
    let mut values = structure.room()?;
    let cholesky = structure.cholesky();
    let mut scratch = structure.scratch(|| {
        let size = cholesky.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Spec::default());
        MemBuffer::try_new(size).map_err(|_| structure.out_of_memory())
    })?;
    let done = cholesky
        .factorize_numeric_ldlt(
            &mut values,
            structure.matrix(&entries),
            Side::Lower,
            LdltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut scratch),
            Spec::default(),
        )
        .map(|_| ())
        .map_err(|_| ModalError::Singular { shift });
    structure.keep_scratch(entries, scratch);
    let below = negative_pivots(structure, &values);
    let factor = Factor { structure, values, below };
    done?;
    let error = factor.solve_error(system, shift);
    // This comparison is false for NaN.
    if error <= WORST_SOLVE { Ok(factor) } else { Err(ModalError::Singular { shift }) }
}

fn negative_pivots(structure: &Elimination, values: &[f64]) -> usize {
    let symbolic = structure.supernodes();
    let factor = SupernodalLdltRef::new(symbolic, values);
    let negative = |s: usize| {
        let block = factor.supernode(s).val();
        (0..block.ncols()).filter(|k| block[(*k, *k)] < 0.0).count()
    };
    (0..symbolic.n_supernodes()).map(negative).sum()
}

impl Drop for Factor<'_> {
    fn drop(&mut self) {
        self.structure.keep_room(std::mem::take(&mut self.values));
    }
}

impl Factor<'_> {
    /// Solves (K − σ M) x = b for all columns of `b`, in place.
    pub(super) fn solve(&self, b: MatMut<'_, f64>) {
        let cholesky = self.structure.cholesky();
        let mut buffer = MemBuffer::new(cholesky.solve_in_place_scratch::<f64>(b.ncols(), Par::Seq));
        LdltRef::new(cholesky, &self.values).solve_in_place_with_conj(
            Conj::No,
            b,
            Par::Seq,
            MemStack::new(&mut buffer),
        );
    }

    /// Relative error of the solution for a known vector, in the norm of the mass: unknowns that hardly touch
    /// the body carry no mass, and their digits do not matter.
    ///
    /// The vector is the solution for random forces, as those of the iteration are. The forces of a vector
    /// with all frequencies in it would be those of the highest, 10¹⁶ of the lowest in a foil: rounded,
    /// they say nothing of the lowest.
    fn solve_error(&self, system: &ElasticSystem, shift: f64) -> f64 {
        let size = 3 * system.node_count();
        let mut seed = 1;
        let mut random: Vec<f64> = (0..size).map(|_| super::random(&mut seed)).collect();
        system.hold(&mut random, 1);
        let (mut known, mut stiff, mut heavy) = (vec![0.0; size], vec![0.0; size], vec![0.0; size]);
        system.multiply_mass(&random, 1, &mut known);
        self.solve(MatMut::from_column_major_slice_mut(&mut known, size, 1));
        system.multiply_stiffness(&known, 1, &mut stiff);
        system.multiply_mass(&known, 1, &mut heavy);
        let mut b: Vec<f64> = stiff.iter().zip(&heavy).map(|(k, m)| k - shift * m).collect();
        self.solve(MatMut::from_column_major_slice_mut(&mut b, size, 1));
        b.iter_mut().zip(&known).for_each(|(x, y)| *x -= y);
        let mut square = |x: &[f64]| {
            system.multiply_mass(x, 1, &mut heavy);
            x.iter().zip(&heavy).map(|(x, m)| x * m).sum::<f64>()
        };
        // Rounding may leave a tiny negative square.
        (square(&b).max(0.0) / square(&known)).sqrt()
    }
}
