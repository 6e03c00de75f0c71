//! The whole band, by spectrum slicing.
//!
//! Shifts σ₁ < σ₂ < … lie inside the band, and every factorisation counts the modes below it. Around each
//! shift the iteration finds all unknown modes down to the previous shift, and half of those up to the next;
//! at the last shift, all up to the limit. Known modes are excluded from the next iteration, so that no
//! frequencies need comparing, which would fail for degenerate pairs.

use std::f64::consts::TAU;

use faer::Mat;

use super::factor::{Factor, factor};
use super::lanczos::{BLOCK, Found, Search, pack};
use super::{ModalError, Mode, Modes, frequency};
use crate::cost::eigensolver_work;
use crate::cost::work_limit::WorkLimit;
use crate::fem::ElasticSystem;
use crate::fem::elimination::Elimination;

/// Modes of a slice.
const SLICE: usize = 140;
/// Relative positions of shifts in their slices, with alternatives for when counts and modes disagree.
const PLACES: [f64; 3] = [0.75, 0.72, 0.77];
/// Residual above which modes are recomputed, ratio of ω² of the modes recomputed together, and largest
/// number of attempts.
const POLISHED: f64 = 4e-7;
const POLISHED_TOGETHER: f64 = 400.0;
const POLISHES: usize = 4;
/// Largest residual of an accepted mode.
const WORST_RESIDUAL: f64 = 1e-5;
/// Relative displacement of a shift that meets an eigenvalue.
const NUDGE: f64 = 1e-4;
const NUDGES: usize = 4;

/// Finds all modes up to `max_frequency` \[Hz\].
///
/// # Errors
/// [`ModalError`]; [`ModalError::Silent`] if the body has no modes in the band.
pub fn solve(system: &ElasticSystem, max_frequency: f64) -> Result<Modes, ModalError> {
    solve_in(&Elimination::new(system)?, system, max_frequency, &WorkLimit::none())
}

/// The same with the elimination of any system of the same pattern, within a limit of work.
pub(crate) fn solve_in(
    structure: &Elimination,
    system: &ElasticSystem,
    max_frequency: f64,
    work: &WorkLimit,
) -> Result<Modes, ModalError> {
    let mut outcome = solve_at(structure, system, max_frequency, (PLACES[0], work));
    for place in &PLACES[1..] {
        // A shift within rounding of a mode may count it on one side and find it on the other.
        if !matches!(outcome, Err(ModalError::Incomplete { .. })) {
            break;
        }
        outcome = solve_at(structure, system, max_frequency, (*place, work));
    }
    outcome
}

/// The same with shifts at a given position in their slices.
fn solve_at(
    structure: &Elimination,
    system: &ElasticSystem,
    max_frequency: f64,
    (place, work): (f64, &WorkLimit),
) -> Result<Modes, ModalError> {
    if !(max_frequency > 0.0 && max_frequency.is_finite()) {
        return Err(ModalError::Frequency(max_frequency));
    }
    // Factor at the upper limit: number of modes in the band.
    let rigid = system.rigid_count();
    let limit = (TAU * max_frequency).powi(2);
    work.spend(eigensolver_work::factor(structure))?;
    let (limit, top) = factor_near(structure, system, limit)?;
    if top.below < rigid {
        return Err(ModalError::LooseParts);
    }
    let total = top.below - rigid;
    let slices = total.div_ceil(SLICE);
    work.spend(eigensolver_work::iteration(structure, slices, total))?;
    let mut band = Band::new(system);
    // Empty band: find the first mode above it.
    if total == 0 {
        let first = Search {
            system,
            factor: &top,
            shift: limit,
            known: band.known.as_ref(),
            range: [limit, f64::INFINITY],
            below: 0,
            above: 1,
        };
        let first = frequency(first.run()?.values[0]);
        return Err(ModalError::Silent { first, limit: max_frequency });
    }
    let top_below = top.below;
    drop(top);
    // Factor at each shift in turn; the next one counts the modes up to it, so that two are in memory.
    let mut counts = Vec::new();
    let mut fractions = fractions(total, place).into_iter();
    let mut next = |below: &mut Vec<(f64, usize)>| -> Result<Option<(f64, Factor<'_>)>, ModalError> {
        let Some(fraction) = fractions.next() else { return Ok(None) };
        let (shift, factor) = factor_near(structure, system, fraction * limit)?;
        below.push((frequency(shift), factor.below - rigid));
        Ok(Some((shift, factor)))
    };
    let mut before = (0.0, rigid);
    let mut here = next(&mut counts)?;
    while let Some((shift, factor)) = here {
        // Lanczos iteration for the modes between the neighbours of the shift.
        let after = next(&mut counts)?;
        let (end, below_end) = after.as_ref().map_or((limit, top_below), |(s, f)| (*s, f.below));
        let there = below_end - factor.below;
        let above = if after.is_some() { there.div_ceil(2) } else { there };
        let expected = factor.below - before.1;
        let below = expected.checked_sub(band.between(before.0, shift)).ok_or(ModalError::Incomplete {
            found: 0,
            expected,
            frequency: frequency(shift),
        })?;
        band.search(&factor, shift, [before.0, end], below, above)?;
        before = (shift, factor.below);
        here = after;
    }
    counts.push((frequency(limit), total));
    // Recompute inaccurate modes, then verify the counts.
    let residual = band.polish(structure, limit)?;
    if residual.is_nan() || band.exceeds(WORST_RESIDUAL) {
        return Err(ModalError::Inaccurate { residual });
    }
    band.finish(counts, max_frequency, residual)
}

/// Positions of the shifts, as fractions of the highest ω².
fn fractions(total: usize, place: f64) -> Vec<f64> {
    let slices = total.div_ceil(SLICE);
    (0..slices).map(|k| ((k as f64 + place) / slices as f64).powi(2)).collect()
}

/// Factors near ω² = `shift`, displaced slightly if it is an eigenvalue.
fn factor_near<'a>(
    structure: &'a Elimination,
    system: &ElasticSystem,
    shift: f64,
) -> Result<(f64, Factor<'a>), ModalError> {
    let mut failure = ModalError::Singular { shift };
    for k in 0..NUDGES {
        let shift = shift * (1.0 + NUDGE * k as f64);
        match factor(structure, system, shift) {
            Ok(factor) => return Ok((shift, factor)),
            Err(error) => failure = error,
        }
    }
    Err(failure)
}

struct Band<'a> {
    system: &'a ElasticSystem,
    /// Number of rigid motions.
    rigid: usize,
    /// Rigid motions, then modes.
    known: Mat<f64>,
    values: Vec<f64>,
    solves: usize,
}

impl<'a> Band<'a> {
    fn new(system: &'a ElasticSystem) -> Self {
        let motions = system.rigid_motions();
        let rigid = motions.len();
        let known = Mat::from_fn(3 * system.node_count(), rigid, |i, k| motions[k][i]);
        Band { system, rigid, known, values: Vec::new(), solves: 0 }
    }

    fn between(&self, low: f64, high: f64) -> usize {
        self.values.iter().filter(|v| **v > low && **v < high).count()
    }

    fn search(
        &mut self,
        factor: &Factor<'_>,
        shift: f64,
        range: [f64; 2],
        below: usize,
        above: usize,
    ) -> Result<(), ModalError> {
        // Orthogonality to modes far from this slice is implied.
        let near: Vec<usize> = (0..self.rigid)
            .chain((0..self.values.len()).filter(|k| self.values[*k] > range[0]).map(|k| k + self.rigid))
            .collect();
        let known = Mat::from_fn(self.known.nrows(), near.len(), |i, k| self.known[(i, near[k])]);
        let search =
            Search { system: self.system, factor, shift, known: known.as_ref(), range, below, above };
        let Found { values, vectors, solves } = search.run()?;
        self.solves += solves;
        let old = self.known.ncols();
        let mut known = Mat::zeros(self.known.nrows(), old + vectors.ncols());
        known.subcols_mut(0, old).copy_from(&self.known);
        known.subcols_mut(old, vectors.ncols()).copy_from(&vectors);
        self.known = known;
        self.values.extend(values);
        Ok(())
    }

    /// Relative residual of every mode.
    fn residuals(&self) -> Vec<f64> {
        let size = self.known.nrows();
        let (mut shapes, mut stiff, mut heavy) =
            (vec![0.0; size * BLOCK], vec![0.0; size * BLOCK], vec![0.0; size * BLOCK]);
        let mut residuals = Vec::with_capacity(self.values.len());
        for (group, squares) in self.values.chunks(BLOCK).enumerate() {
            pack(self.known.subcols(self.rigid + group * BLOCK, squares.len()), &mut shapes);
            self.system.multiply_stiffness(&shapes, BLOCK, &mut stiff);
            self.system.multiply_mass(&shapes, BLOCK, &mut heavy);
            residuals.extend(squares.iter().enumerate().map(|(k, square)| {
                let lane = |all: &[f64]| all.iter().skip(k).step_by(BLOCK).copied().collect::<Vec<f64>>();
                let (stiff, heavy) = (lane(&stiff), lane(&heavy));
                let error: f64 = stiff.iter().zip(&heavy).map(|(k, m)| (k - square * m).powi(2)).sum();
                (error / heavy.iter().map(|m| m * m).sum::<f64>()).sqrt() / square
            }));
        }
        residuals
    }

    /// Whether a residual is above `most` and above what the rounding of K u alone may leave.
    ///
    /// The stiffness of a sheet across its thickness is many orders above that of its slow bending, which is
    /// a small difference of large forces: no vector of this precision has a smaller residual. The frequency
    /// is better by far, since its error is of second order in that of the shape.
    fn exceeds(&self, most: f64) -> bool {
        let residuals = self.residuals();
        let large = residuals.iter().enumerate().filter(|(_, residual)| **residual > most);
        large.into_iter().any(|(k, residual)| *residual > self.rounding(k))
    }

    /// ε ‖|K| |u|‖ / ‖ω² M u‖ of a mode.
    fn rounding(&self, k: usize) -> f64 {
        let shape: Vec<f64> = self.known.col(self.rigid + k).iter().copied().collect();
        let (mut forces, mut heavy) = (vec![0.0; shape.len()], vec![0.0; shape.len()]);
        self.system.add_force_magnitudes(&shape, &mut forces);
        self.system.multiply_mass(&shape, 1, &mut heavy);
        let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        f64::EPSILON * norm(&forces) / (self.values[k] * norm(&heavy))
    }

    /// Recomputes modes from a shift just below them, where rounding in factors of higher shifts has degraded
    /// them; none above the ω² of `limit` [1/s²].
    fn polish(&mut self, structure: &Elimination, limit: f64) -> Result<f64, ModalError> {
        let rigid = self.rigid;
        for _ in 0..POLISHES {
            // Lowest inaccurate mode.
            let residuals = self.residuals();
            let bad = (0..residuals.len()).filter(|k| residuals[*k] > POLISHED);
            let Some(lowest) = bad.map(|k| self.values[k]).reduce(f64::min) else { break };
            let mut sorted = self.values.clone();
            sorted.sort_by(f64::total_cmp);
            // The group begins and ends at gaps, so that no degenerate pair is split.
            let mut start = sorted.partition_point(|v| *v < lowest);
            while start > 0 && sorted[start] < 1.01 * sorted[start - 1] {
                start -= 1;
            }
            let ends = (start + 1..sorted.len())
                .find(|k| sorted[*k] > POLISHED_TOGETHER * lowest && sorted[*k] > 1.01 * sorted[*k - 1]);
            let high = ends.map_or(limit, |k| 0.5 * (sorted[k - 1] + sorted[k]));
            let below = if start == 0 { 0.0 } else { sorted[start - 1] };
            let low = 0.5 * (below + sorted[start]);
            // Factor just below the group, and check the count.
            let (shift, factor) = factor_near(structure, self.system, low)?;
            if factor.below != self.rigid + start {
                return Err(ModalError::Incomplete {
                    found: start,
                    expected: factor.below.saturating_sub(self.rigid),
                    frequency: frequency(shift),
                });
            }
            // Drop the modes of the group.
            let keep: Vec<usize> =
                (0..self.values.len()).filter(|k| self.values[*k] < low || self.values[*k] > high).collect();
            let again = self.values.len() - keep.len();
            let kept = |k: usize| if k < rigid { k } else { keep[k - rigid] + rigid };
            let columns = keep.len() + rigid;
            self.known = Mat::from_fn(self.known.nrows(), columns, |i, k| self.known[(i, kept(k))]);
            self.values = keep.iter().map(|k| self.values[*k]).collect();
            // Search from the shift, not from the kept mode below: rounding could lift that mode into the
            // range, and it would occur twice.
            self.search(&factor, shift, [shift, high], 0, again)?;
        }
        Ok(self.residuals().into_iter().fold(0.0, f64::max))
    }

    /// Verifies the counts and sorts the modes.
    fn finish(
        self,
        counts: Vec<(f64, usize)>,
        max_frequency: f64,
        residual: f64,
    ) -> Result<Modes, ModalError> {
        for (frequency, count) in &counts {
            let square = (TAU * frequency).powi(2);
            let found = self.between(0.0, square);
            if found != *count {
                return Err(ModalError::Incomplete { found, expected: *count, frequency: *frequency });
            }
        }
        let mut order: Vec<usize> = (0..self.values.len()).collect();
        order.sort_by(|a, b| self.values[*a].total_cmp(&self.values[*b]));
        let mode = |k: usize| {
            let shape: Vec<f64> = self.known.col(k + self.rigid).iter().copied().collect();
            Mode { frequency: frequency(self.values[k]), shape: self.system.displacements(&shape) }
        };
        let modes = order.into_iter().map(mode).collect();
        Ok(Modes { modes, max_frequency, residual, counts, solves: self.solves })
    }
}

#[cfg(test)]
mod tests {
    use clangor_core::material::presets::GLASS;
    use glam::DVec3;

    use super::*;
    use crate::fem::ElasticConstants;
    use crate::mesh::tetrahedra::block::block;
    use crate::modal_analysis::eigensolver::random;

    /// A window had 100 modes where 99 were counted: the recomputed group included the mode below it.
    #[test]
    fn modes_found_anew_are_found_once() {
        let mesh = block(DVec3::new(0.6, 0.8, 0.01), [5, 6, 1]).expect("a box");
        let system = ElasticSystem::new(&mesh, &ElasticConstants::of(&GLASS.material()).expect("glass"));
        let structure = Elimination::new(&system).expect("memory");
        let whole = solve(&system, 1200.0).expect("modes");
        let count = whole.modes.len();
        assert!(count > 12, "{count}");
        for spoilt in 1..count {
            let mut band = Band::new(&system);
            let rigid = band.known.clone();
            band.known = Mat::from_fn(rigid.nrows(), rigid.ncols() + count, |i, k| {
                match k.checked_sub(rigid.ncols()) {
                    None => rigid[(i, k)],
                    Some(mode) => whole.modes[mode].shape[i / 3][i % 3],
                }
            });
            band.values = whole.modes.iter().map(|m| (TAU * m.frequency).powi(2)).collect();
            let mut seed = 5;
            band.known
                .col_mut(rigid.ncols() + spoilt)
                .iter_mut()
                .for_each(|x| *x += 1e-8 * random(&mut seed));
            assert!(band.residuals()[spoilt] > POLISHED, "{:.1e}", band.residuals()[spoilt]);
            let residual = band.polish(&structure, (TAU * 1200.0_f64).powi(2)).expect("modes");
            assert!(
                residual < POLISHED && band.values.len() == count,
                "{residual:.1e} {}",
                band.values.len()
            );
            band.values.sort_by(f64::total_cmp);
            for (found, mode) in band.values.iter().zip(&whole.modes) {
                // Residual seen: at most 1e-10.
                assert!(
                    (frequency(*found) / mode.frequency - 1.0).abs() < 1e-9,
                    "{spoilt}: {}",
                    mode.frequency
                );
            }
        }
    }
}
