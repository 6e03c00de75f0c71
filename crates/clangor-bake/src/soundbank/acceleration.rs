//! The bank of ellipsoids that replace bodies without an individual acceleration model.
//!
//! \[PROXY\] §5 has 66 ellipsoids, A = 0.5 m ≥ B ≥ C, B and C from 0.025 m to 0.5 m in steps of 0.0475 m.
//! Here A = 1, as the field does not depend on the size of an ellipsoid. Each is a boundary integral equation
//! on one octant at a few frequencies, instead of 500³ cells in time.
//!
//! Differs: the band. 48 kHz and A = 0.5 m would be kA = 440, which no proxy of small debris needs: a body of
//! A = 2.7, 5.5 and 10 cm reaches kA = 10, 20 and 37 at 20 kHz.
//!
//! Measured by `tests/paper_proxy_bank.rs`, for ellipsoids between those of the bank, at 2 A and kA to 14:
//! the error of the nearest is 7 to 55 % per motion, that of the bilinear mean of the four around it 2 to 5 %
//! (10 % for a motion that is nearly silent).

use std::ops::ControlFlow;

use clangor_core::math::radial::outgoing;
use clangor_core::sound_model::acceleration::field::{AccelerationField, RIGID_DOFS};
use clangor_core::sound_model::soundbank::ellipsoid_bank::{BankEntry, EllipsoidBank};
use glam::DVec3;

use crate::acceleration::{BakeError, BakeOptions, BakeProgress, Evidence, Method, bake_with};
use crate::bem::symmetric_patches::SymmetricPatchSolver;

/// Values of B and of C, in units of A.
const STEPS: usize = 11;
/// Initial spacing of frequencies in κ: half of what the slowest pole of an ellipsoid needs, so that a test
/// seldom adds any.
const SPACING: f64 = 20.0 / 14.0;
/// Nearest distance, in units of A, at which the truncation must hold.
const NEAREST: f64 = 1.2;

/// Proportions (B/A, C/A) of the 66 ellipsoids, ascending in B, then in C.
pub fn proportions() -> Vec<(f64, f64)> {
    let value = |k: usize| (k * 19 + 10) as f64 / 200.0;
    (0..STEPS).flat_map(|b| (0..=b).map(move |c| (value(b), value(c)))).collect()
}

/// Computes the bank up to kA = `max_wavenumber`.
///
/// # Errors
/// [`BakeError`].
pub fn build_bank(
    max_wavenumber: f64,
    accuracy: f64,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<(EllipsoidBank, Vec<Evidence>), BakeError> {
    let proportions = proportions();
    let (mut entries, mut evidence) = (Vec::new(), Vec::new());
    for (index, &(b, c)) in proportions.iter().enumerate() {
        let mut part = |inner: &BakeProgress| {
            let done = (index as f64 + inner.done) / proportions.len() as f64;
            progress(&BakeProgress { done, ..inner.clone() })
        };
        let (entry, found) = bank_entry(b, c, max_wavenumber, accuracy, &mut part)?;
        entries.push(entry);
        evidence.push(found);
    }
    // The proportions are sorted as the bank requires.
    let bank = EllipsoidBank::try_new(entries).unwrap_or_default();
    Ok((bank, evidence))
}

/// Computes one ellipsoid, 1 : b : c.
///
/// # Errors
/// [`BakeError`].
pub fn bank_entry(
    b: f64,
    c: f64,
    max_wavenumber: f64,
    accuracy: f64,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<(BankEntry, Evidence), BakeError> {
    // Half of the error is for the solver and the fit, half for the truncation.
    let options = BakeOptions { method: Method::Bem, ..BakeOptions::new(max_wavenumber, 0.5 * accuracy) };
    let solver = SymmetricPatchSolver::ellipsoid(DVec3::new(1.0, b, c), max_wavenumber, options.accuracy)?;
    let (mut model, mut evidence) = bake_with(&solver, SPACING, &options, progress)?;
    evidence.method = "boundary elements on one octant".to_owned();
    evidence.unknowns = solver.unknowns();
    leave_out_faint_terms(&mut model.field, 0.5 * accuracy);
    Ok((BankEntry { b, c, field: model.field }, evidence))
}

/// Drops the weakest terms: together, at [`NEAREST`] and at every node, below `accuracy` of the strongest
/// motion.
///
/// Terms of the first two orders are kept, as they decay least with distance.
fn leave_out_faint_terms(field: &mut AccelerationField, accuracy: f64) {
    let (order, count) = (field.order(), field.nodes.len());
    let mut energy = vec![vec![0.0; count]; field.terms.len()];
    let mut loudest = vec![0.0_f64; count];
    // Energy of each term and of the strongest motion at each node.
    for (j, node) in field.nodes.iter().enumerate() {
        let mut radial = Vec::new();
        outgoing(node.s, NEAREST, order, &mut radial);
        let mut by_motion = [0.0; RIGID_DOFS];
        for (row, term) in field.terms.iter().enumerate() {
            let value =
                f64::from(field.real[row * count + j]).hypot(f64::from(field.imaginary[row * count + j]));
            energy[row][j] = (radial[usize::from(term.n)].norm() * value).powi(2);
            by_motion[usize::from(term.degree)] += energy[row][j];
        }
        loudest[j] = by_motion.into_iter().fold(f64::MIN_POSITIVE, f64::max);
    }
    // Terms above order 2, weakest first.
    let level = |row: usize| energy[row].iter().zip(&loudest).map(|(e, l)| e / l).fold(0.0, f64::max);
    let mut faintest: Vec<(f64, usize)> =
        (0..field.terms.len()).filter(|&row| field.terms[row].n > 2).map(|row| (level(row), row)).collect();
    faintest.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
    let mut keep = vec![true; field.terms.len()];
    let mut left_out = [0.0; RIGID_DOFS];
    // Drop terms while their sum per motion stays below the threshold.
    for (level, row) in faintest {
        let sum = &mut left_out[usize::from(field.terms[row].degree)];
        *sum += level;
        if *sum > accuracy * accuracy {
            break;
        }
        keep[row] = false;
    }
    // Remove the dropped rows.
    let rows = |values: &[f32]| -> Vec<f32> {
        values.chunks(count).zip(&keep).filter(|(_, keep)| **keep).flat_map(|(row, _)| row).copied().collect()
    };
    (field.real, field.imaginary) = (rows(&field.real), rows(&field.imaginary));
    let mut kept = keep.iter();
    field.terms.retain(|_| kept.next() == Some(&true));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_the_66_ellipsoids_of_the_paper() {
        let all = proportions();
        assert_eq!(all.len(), 66);
        assert_eq!((all[0], all[65]), ((0.05, 0.05), (1.0, 1.0)));
        assert!(all.iter().all(|(b, c)| c <= b));
        // In the paper's metres: 0.025 + 0.0475 k.
        assert!((0.5 * all[2].1 - 0.0725).abs() < 1e-12);
    }
}
