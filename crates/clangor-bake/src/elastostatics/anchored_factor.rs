//! Factors of the stiffness of a free body.
//!
//! ```text
//! K u = f,    P K_h Pᵀ = L Lᵀ
//! ```
//!
//! K does not resist the six rigid motions. Six unknowns are held, so chosen that no rigid motion is left: K_h is K with
//! their rows and columns cut off. Where the forces balance, whatever holds the body carries nothing, and u is right up to
//! a rigid motion.
//!
//! Source: \[FRAC\] App. B. Differs: there three points are held along directions of their own, by a sparse change of
//! basis; here unknowns are held as they are, picked by pivots from the rows of the rigid motions, which cannot fail
//! where three points happen to lie on one line.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::LltRef;
use faer::{Conj, MatMut, Par, Side, Spec};
use glam::DVec3;

use super::ElastostaticsError;
use super::balance::Balance;
use crate::elasticity::ElasticSystem;
use crate::elasticity::elimination::Elimination;

/// Largest relative error of the displacement that is good enough: a thousandth of the error of a fine mesh.
const WORST_SOLVE: f64 = 1e-5;

pub(super) struct AnchoredFactor {
    structure: Elimination,
    values: Vec<f64>,
    held: [usize; 6],
}

impl AnchoredFactor {
    pub(super) fn new(system: &ElasticSystem, balance: &Balance) -> Result<Self, ElastostaticsError> {
        let structure = Elimination::new(system)?;
        let held = held_unknowns(system.nodes());
        let mut entries = structure.gather(system, |entry| system.shifted_block(entry, 0.0));
        structure.detach(&mut entries, &held);
        let mut values = structure.room()?;
        let scratch = structure.cholesky().factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default());
        let mut buffer = MemBuffer::try_new(scratch).map_err(|_| structure.out_of_memory())?;
        structure
            .cholesky()
            .factorize_numeric_llt(
                &mut values,
                structure.matrix(&entries),
                Side::Lower,
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut buffer),
                Spec::default(),
            )
            .map_err(|_| ElastostaticsError::Singular { error: f64::INFINITY })?;
        let factor = AnchoredFactor { structure, values, held };
        let error = factor.solve_error(system, balance);
        // A comparison that is false for NaN.
        if error <= WORST_SOLVE { Ok(factor) } else { Err(ElastostaticsError::Singular { error }) }
    }

    /// Numbers in the factor.
    pub(super) fn entries(&self) -> usize {
        self.values.len()
    }

    /// Solves K u = f in place for `width` balanced loads, one after the other; u is zero at the held unknowns.
    pub(super) fn solve(&self, loads: &mut [f64], width: usize) {
        let size = self.structure.size();
        for load in loads.chunks_exact_mut(size) {
            self.held.iter().for_each(|k| load[*k] = 0.0);
        }
        let cholesky = self.structure.cholesky();
        let mut buffer = MemBuffer::new(cholesky.solve_in_place_scratch::<f64>(width, Par::Seq));
        LltRef::new(cholesky, &self.values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(loads, size, width),
            Par::Seq,
            MemStack::new(&mut buffer),
        );
    }

    /// Relative error of the displacement that is found for the forces of a known one.
    fn solve_error(&self, system: &ElasticSystem, balance: &Balance) -> f64 {
        let nodes = system.nodes();
        let size = nodes.iter().fold(f64::MIN_POSITIVE, |size, x| size.max(x.length()));
        // Bends of the whole body: what is soft is what rounding hurts most.
        let bend = |x: &DVec3| {
            let y = *x / size;
            DVec3::new(y.y * y.z, y.z * y.x, y.x * y.y)
        };
        let mut known: Vec<DVec3> = nodes.iter().map(bend).collect();
        let flat: Vec<f64> = known.iter().flat_map(|u| u.to_array()).collect();
        let mut found = vec![0.0; flat.len()];
        system.multiply_stiffness(&flat, 1, &mut found);
        self.solve(&mut found, 1);
        let mut found: Vec<DVec3> = found.chunks_exact(3).map(DVec3::from_slice).collect();
        balance.remove_rigid_motion(&mut known);
        balance.remove_rigid_motion(&mut found);
        let square: f64 = known.iter().map(|u| u.length_squared()).sum();
        let error: f64 = known.iter().zip(&found).map(|(u, v)| u.distance_squared(*v)).sum();
        (error / square).sqrt()
    }
}

/// Six unknowns that together allow no rigid motion: at each step the one that what is left of the motions moves most.
fn held_unknowns(nodes: &[DVec3]) -> [usize; 6] {
    let middle = nodes.iter().sum::<DVec3>() / nodes.len().max(1) as f64;
    let size = nodes.iter().fold(f64::MIN_POSITIVE, |size, x| size.max(x.distance(middle)));
    let row = |unknown: usize| -> [f64; 6] {
        let x = (nodes[unknown / 3] - middle) / size;
        let axis = unknown % 3;
        let turns = [DVec3::X, DVec3::Y, DVec3::Z].map(|a| a.cross(x)[axis]);
        std::array::from_fn(|k| if k < 3 { if k == axis { 1.0 } else { 0.0 } } else { turns[k - 3] })
    };
    let dot = |a: &[f64; 6], b: &[f64; 6]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut rows: Vec<[f64; 6]> = (0..3 * nodes.len()).map(row).collect();
    std::array::from_fn(|_| {
        let squares = rows.iter().map(|r| dot(r, r)).enumerate();
        let (best, square) = squares.fold((0, 0.0), |best, here| if here.1 > best.1 { here } else { best });
        let pivot = rows[best];
        for r in &mut rows {
            let share = dot(r, &pivot) / square;
            r.iter_mut().zip(&pivot).for_each(|(r, p)| *r -= share * p);
        }
        best
    })
}
