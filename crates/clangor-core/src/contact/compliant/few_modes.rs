//! The same step as [`advance`](ModalPropagator::advance) for members with few modes and many contacts, as
//! coins in a heap: vectors go along the contacts, and there is one sum over a vector for each mode instead
//! of one for each contact.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::modal_propagator::ModalPropagator;

/// Most modes of such a member, and fewest rows of its contacts.
pub(super) const FEW: usize = 8;
pub(super) const MANY_ROWS: usize = 4;

impl ModalPropagator {
    /// Advances the modes `own`, without padding, by a step of these forces; `across` has the shapes of a
    /// mode at all rows, mode after mode. `sums` become Σ φ q for each row, after the next step without
    /// force.
    pub(super) fn advance_few(
        &mut self,
        arch: Arch,
        own: Range<usize>,
        across: &[f64],
        forces: &[f64],
        sums: &mut [f64],
    ) {
        arch.dispatch(AdvanceFew { modes: self, own, across, forces, sums });
    }
}

struct AdvanceFew<'a> {
    modes: &'a mut ModalPropagator,
    own: Range<usize>,
    across: &'a [f64],
    forces: &'a [f64],
    sums: &'a mut [f64],
}

impl WithSimd for AdvanceFew<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let AdvanceFew { modes, own, across, forces, sums } = self;
        sums.fill(0.0);
        let ModalPropagator { turn, push, now, next, .. } = modes;
        for (i, shape) in own.zip(across.chunks_exact(forces.len().max(1))) {
            // The force on the mode.
            let drive = dot(simd, shape, forces);
            // This step, and the next one without force.
            let [re, im] = [0, 1].map(|part| next[part][i] + push[part][i] * drive);
            (now[0][i], now[1][i]) = (re, im);
            next[0][i] = turn[0][i] * re - turn[1][i] * im;
            next[1][i] = turn[0][i] * im + turn[1][i] * re;
            add(simd, sums, shape, next[1][i]);
        }
    }
}

/// Σ a b.
#[inline(always)]
fn dot<S: Simd>(simd: S, a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_end), (b, b_end)) = (S::as_simd_f64s(a), S::as_simd_f64s(b));
    let ends = [a_end, b_end].map(|end| simd.partial_load_f64s(end));
    let sum = simd.mul_f64s(ends[0], ends[1]);
    simd.reduce_sum_f64s(a.iter().zip(b).fold(sum, |sum, (a, b)| simd.mul_add_f64s(*a, *b, sum)))
}

/// sums += a factor.
#[inline(always)]
fn add<S: Simd>(simd: S, sums: &mut [f64], a: &[f64], factor: f64) {
    let factor = simd.splat_f64s(factor);
    let ((sums, sums_end), (a, a_end)) = (S::as_mut_simd_f64s(sums), S::as_simd_f64s(a));
    for (sum, a) in sums.iter_mut().zip(a) {
        *sum = simd.mul_add_f64s(*a, factor, *sum);
    }
    let end = simd.mul_add_f64s(simd.partial_load_f64s(a_end), factor, simd.partial_load_f64s(sums_end));
    simd.partial_store_f64s(sums_end, end);
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::super::modal_propagator::LANES;
    use super::*;

    #[test]
    fn few_modes_move_as_many() {
        let poles: Vec<Complex64> = (0..3).map(|i| Complex64::new(-20.0, 9e3 * f64::from(i + 1))).collect();
        let states: Vec<Complex64> = (0..3).map(|i| Complex64::new(0.3, 0.1 * f64::from(i))).collect();
        let padded = |values: &[Complex64]| {
            let mut values = values.to_vec();
            values.resize(LANES, Complex64::ZERO);
            values
        };
        let mut worst = 0.0_f64;
        for rows in [1, 2, 7, 8, 19] {
            let shape = |row: usize, mode: usize| ((3 * row + 5 * mode) as f64).sin();
            let shapes: Vec<f64> = (0..rows)
                .flat_map(|row| (0..LANES).map(move |mode| if mode < 3 { shape(row, mode) } else { 0.0 }))
                .collect();
            let across: Vec<f64> =
                (0..3).flat_map(|mode| (0..rows).map(move |row| shape(row, mode))).collect();
            let [mut many, mut few] = [0, 1].map(|_| {
                let mut modes = ModalPropagator::default();
                modes.prepare(&padded(&poles), &padded(&states), 2e-6, false);
                modes
            });
            let (mut expected, mut found) = (vec![0.0; rows], vec![0.0; rows]);
            for step in 0..50 {
                let forces: Vec<f64> = (0..rows).map(|row| ((row + step) % 4) as f64).collect();
                many.advance(Arch::new(), 0..LANES, &shapes, &forces, &mut expected);
                few.advance_few(Arch::new(), 0..3, &across, &forces, &mut found);
            }
            for (a, b) in found.iter().zip(&expected) {
                worst = worst.max((a - b).abs() / b.abs());
            }
            worst = worst.max((few.energy() / many.energy() - 1.0).abs());
        }
        // Residual seen: 8e-16.
        assert!(worst < 1e-12, "{worst:e}");
    }
}
