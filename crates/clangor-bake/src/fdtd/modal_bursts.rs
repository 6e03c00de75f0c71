//! Several modes in one run: each is a burst at its frequency, and the modes are separated in frequency.
//!
//! Mode j accelerates the surface by a_j(t) = e^{−(t − t₀)²/2w²} cos ω_j(t − t₀). The recorded signal is
//! linear in the modes,
//!
//! ```text
//! X(ω_j) = Σ_i S_i(ω_j) H_i(ω_j) ≈ S_j(ω_j) H_j(ω_j),     S_i(ω_j)/S_j(ω_j) ≈ e^{−(ω_i − ω_j)² w²/2}
//! ```
//!
//! so that one spectral line of the signal, echoes included, over that of the burst is the field of mode j at
//! its frequency, to 1e-4 if bursts are long enough for the smallest interval. Modes are assigned to runs so
//! that intervals are wide: neighbours in frequency run apart, and the number of runs times their length is
//! minimal.
//!
//! Simulating several modes of different frequencies together follows KleinPAT (J.-H. Wang and D. L. James,
//! ACM Trans. Graph. 38, 2019). Differs: bursts with known spectra replace steady oscillations separated by
//! least squares in a window, so that no settling time is needed.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use clangor_core::math::spherical_harmonics::count;
use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;

use super::field::Reading;
use super::grid::{Drive, WaveGrid};
use super::lattice::{COURANT, phase_per_step};
use super::recorder::Recorder;
use super::tail::Tail;
use super::{OVERSAMPLING, WaveError, WaveOptions, WaveSolver};

/// Width of a burst times the distance to the next frequency: e^{−x²/2} = 4e-5.
const APART: f64 = 4.5;
/// Widths from the first step to the middle, and from there to the last.
const HALF_LENGTH: f64 = 4.7;
/// Least width times own frequency: shorter bursts have a spectrum beyond the band.
const LEAST_WIDTH: f64 = 2.2;
/// Intervals between frequencies that are tried, in the highest frequency.
const INTERVALS: [f64; 7] = [0.02, 0.035, 0.06, 0.1, 0.16, 0.25, 0.4];

/// A cell through which the surface drives the air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrivenPlace {
    /// Middle of the cell \[m\], next to the surface.
    pub position: DVec3,
    /// ∫ n dS over the surface in the cell \[m²\].
    pub area: DVec3,
}

/// A mode to simulate.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveMotion {
    /// k [1/m].
    pub wavenumber: f64,
    /// ∫ U·n dS at each of the [`WaveSolver::places`] [unit of U times m²].
    pub flux: Vec<f64>,
}

/// a(nΔt) of a mode.
struct Burst {
    phase: f64,
    width: f64,
    middle: f64,
}

impl Burst {
    fn value(&self, step: f64) -> f64 {
        let t = step - self.middle;
        if t.abs() > HALF_LENGTH * self.width {
            return 0.0;
        }
        (-0.5 * (t / self.width).powi(2)).exp() * (self.phase * t).cos()
    }

    /// a and a'' at a step, time in h/c.
    fn at(&self, step: usize) -> [f32; 2] {
        let step = step as f64;
        let here = self.value(step);
        let bend = self.value(step + 1.0) - 2.0 * here + self.value(step - 1.0);
        [here as f32, (bend / (COURANT * COURANT)) as f32]
    }

    /// Σ a(nΔt) e^{−iφn}.
    fn spectrum(&self, phase: f64) -> Complex64 {
        let last = (2.0 * self.middle).ceil() as usize;
        (0..=last).map(|n| Complex64::from_polar(self.value(n as f64), -phase * n as f64)).sum()
    }
}

impl WaveSolver {
    /// The cells through which the surface drives the air.
    pub fn places(&self) -> Vec<DrivenPlace> {
        let strides = self.lattice.strides();
        let h = self.options.spacing;
        self.driven()
            .map(|row| {
                let cell = self.rows.cells[row] as usize;
                let at = [cell % strides[1], cell / strides[1] % self.lattice.size[1], cell / strides[2]];
                let middle = DVec3::from_array(at.map(|x| x as f64 + 0.5));
                let [x, y, z, ..] = self.rows.drive[row].map(f64::from);
                let area = DVec3::new(x, y, z) / f64::from(self.rows.scale[row]) * (h * h);
                DrivenPlace { position: (middle - self.centre) * h, area }
            })
            .collect()
    }

    /// Rows with surface in them.
    fn driven(&self) -> impl Iterator<Item = usize> {
        (0..self.rows.cells.len()).filter(|row| self.rows.drive[*row][..3].iter().any(|d| *d != 0.0))
    }

    /// The multipoles of each motion at its wavenumber, up to the order of the options, about the origin and
    /// of size 1 on the sphere of the bounding radius of the surface \[m times the unit of U\].
    ///
    /// # Errors
    /// [`WaveError::Interrupted`], [`WaveError::Mirrored`].
    pub fn run_modes(
        &self,
        motions: &[WaveMotion],
        progress: &(dyn Fn(f64) -> ControlFlow<()> + Sync),
    ) -> Result<Vec<Vec<Complex64>>, WaveError> {
        if self.mirrors.any() {
            return Err(WaveError::Mirrored);
        }
        let phases: Vec<f64> = motions.iter().map(|m| self.phase(m.wavenumber)).collect();
        let runs = colours(&phases, self.steps_after());
        let recorder = self.recorder([1.0; 3]);
        let done = AtomicUsize::new(0);
        let all: usize = runs.iter().map(|run| self.steps(&phases, run)).sum();
        let on_progress = |steps: usize| {
            let done = done.fetch_add(steps, Ordering::Relaxed) + steps;
            progress(done as f64 / all.max(1) as f64)
        };
        let solved: Result<Vec<_>, WaveError> =
            runs.par_iter().map(|run| self.run_together(motions, run, &recorder, &on_progress)).collect();
        let mut results = vec![Vec::new(); motions.len()];
        for (run, solved) in runs.iter().zip(solved?) {
            for (motion, coefficients) in run.iter().zip(solved) {
                results[*motion] = coefficients;
            }
        }
        Ok(results)
    }

    /// Cell updates that [`run_modes`](Self::run_modes) would take for modes of these wavenumbers.
    pub fn updates_of_modes(&self, wavenumbers: &[f64]) -> f64 {
        let steps = steps_of_modes(wavenumbers, self.options.spacing, self.steps_after());
        steps * self.cells() as f64
    }

    fn phase(&self, wavenumber: f64) -> f64 {
        phase(wavenumber, self.options.spacing)
    }

    /// Steps from the end of the bursts to the end of a run.
    fn steps_after(&self) -> usize {
        self.options.steps_after(self.radius)
    }

    fn steps(&self, phases: &[f64], run: &[usize]) -> usize {
        steps(phases, run, self.steps_after())
    }

    /// The multipoles of the modes of one run.
    fn run_together(
        &self,
        motions: &[WaveMotion],
        run: &[usize],
        recorder: &Recorder,
        on_progress: &(dyn Fn(usize) -> ControlFlow<()> + Sync),
    ) -> Result<Vec<Vec<Complex64>>, WaveError> {
        let order = self.options.order;
        let h = self.options.spacing;
        // Bursts of the modes, wide enough to separate their frequencies.
        let phases: Vec<f64> = run.iter().map(|i| self.phase(motions[*i].wavenumber)).collect();
        let width = width(&phases);
        let middle = (HALF_LENGTH * width).ceil();
        let bursts: Vec<Burst> = phases.iter().map(|phase| Burst { phase: *phase, width, middle }).collect();
        // Sampling interval and number of steps.
        let highest = phases.iter().copied().fold(0.0, f64::max) + APART / width;
        let stride = (std::f64::consts::TAU / (OVERSAMPLING * highest)).floor().max(1.0) as usize;
        let steps = 2 * middle as usize + self.steps_after();
        // Time loop: record, drive, step.
        let drives = run.iter().map(|i| self.drive(&motions[*i].flux)).collect();
        let mut grid = WaveGrid::new(self.lattice, &self.rows, drives, [1.0; 3]);
        let mut signal = Vec::with_capacity((steps / stride + 1) * count(order));
        let mut accelerations = vec![[0.0; 2]; run.len()];
        for step in 0..steps {
            if step % stride == 0 {
                recorder.record(&self.lattice, grid.pressure(), &mut signal);
                if on_progress(stride.min(steps - step)).is_break() {
                    return Err(WaveError::Interrupted);
                }
            }
            accelerations.iter_mut().zip(&bursts).for_each(|(a, burst)| *a = burst.at(step));
            grid.step(&accelerations);
        }
        // Continuation of the free decay.
        let free = 2 * middle as usize + self.steps_of_passage();
        let signals = [signal];
        let tail = Tail::fit(&signals, count(order), free.div_ceil(stride), &[1.0]);
        // Spectral line of each mode over that of its burst.
        let reading = Reading { spacing: h, radius: self.radius, recorded: order, stride };
        let multipoles = |(i, burst): (&usize, &Burst)| {
            let wavenumber = Complex64::from(motions[*i].wavenumber);
            let spectrum = burst.spectrum(burst.phase);
            reading.multipoles(wavenumber, order, &signals[0], spectrum, |phase, sums| {
                tail.add_spectrum(0, phase, sums);
            })
        };
        Ok(run.iter().zip(&bursts).map(multipoles).collect())
    }

    /// A mode in the units of the grid.
    fn drive(&self, flux: &[f64]) -> Drive {
        let rows = &self.rows;
        let square = self.options.spacing.powi(2);
        let mut drive = Drive { drive: vec![0.0; rows.cells.len()], bend: vec![0.0; rows.cells.len()] };
        for (row, flux) in self.driven().zip(flux) {
            let value = (flux / square) as f32 * rows.scale[row];
            drive.drive[row] = value;
            // The lever of the cell is the same for all motions.
            let along = |values: &[f32]| values.iter().zip(&rows.drive[row]).map(|(a, b)| a * b).sum::<f32>();
            let size = along(&rows.drive[row][..3]);
            drive.bend[row] = value * along(&rows.bend[row][..3]) / size;
        }
        drive
    }
}

impl WaveOptions {
    /// Cell updates of [`WaveSolver::run_modes`] for modes of these wavenumbers [1/m], of a body of bounding
    /// radius `radius` \[m\], without a grid.
    pub(crate) fn expected_updates_of_modes(&self, wavenumbers: &[f64], radius: f64) -> f64 {
        let [cells, after] = self.extent(radius, 0);
        steps_of_modes(wavenumbers, self.spacing, after as usize) * cells
    }
}

/// Phase of a wave per step, with cells of `spacing` \[m\].
fn phase(wavenumber: f64, spacing: f64) -> f64 {
    phase_per_step(Complex64::from(wavenumber * spacing)).re
}

/// Steps of a run, with `after` from the end of its bursts.
fn steps(phases: &[f64], run: &[usize], after: usize) -> usize {
    let of_run: Vec<f64> = run.iter().map(|i| phases[*i]).collect();
    (2.0 * HALF_LENGTH * width(&of_run)).ceil() as usize + after
}

/// Steps of all runs for modes of these wavenumbers.
fn steps_of_modes(wavenumbers: &[f64], spacing: f64, after: usize) -> f64 {
    let phases: Vec<f64> = wavenumbers.iter().map(|k| phase(*k, spacing)).collect();
    colours(&phases, after).iter().map(|run| steps(&phases, run, after) as f64).sum()
}

/// Width of the bursts of one run [steps].
fn width(phases: &[f64]) -> f64 {
    let highest = phases.iter().copied().fold(0.0, f64::max);
    let lowest = phases.iter().copied().fold(f64::INFINITY, f64::min);
    let mut sorted = phases.to_vec();
    sorted.sort_by(f64::total_cmp);
    let nearest = sorted.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    // The mirror image of the lowest frequency lies at its negative.
    (APART / nearest).max(0.5 * APART / lowest).max(LEAST_WIDTH / highest)
}

/// Assignment of modes to runs that minimises the total number of steps; `after` steps follow the bursts of
/// each run.
fn colours(phases: &[f64], after: usize) -> Vec<Vec<usize>> {
    let mut sorted: Vec<usize> = (0..phases.len()).collect();
    sorted.sort_by(|a, b| phases[*a].total_cmp(&phases[*b]));
    let highest = phases.iter().copied().fold(0.0, f64::max);
    let coloured = |interval: f64| {
        let mut runs: Vec<Vec<usize>> = Vec::new();
        for i in &sorted {
            let free = |run: &&mut Vec<usize>| {
                run.last().is_none_or(|last| phases[*i] - phases[*last] >= interval * highest)
            };
            match runs.iter_mut().find(free) {
                Some(run) => run.push(*i),
                None => runs.push(vec![*i]),
            }
        }
        runs
    };
    let cost = |runs: &Vec<Vec<usize>>| -> f64 {
        let of = |run: &Vec<usize>| {
            let of_run: Vec<f64> = run.iter().map(|i| phases[*i]).collect();
            2.0 * HALF_LENGTH * width(&of_run) + after as f64
        };
        runs.iter().map(of).sum()
    };
    let alone: Vec<Vec<usize>> = sorted.iter().map(|i| vec![*i]).collect();
    INTERVALS
        .iter()
        .map(|interval| coloured(*interval))
        .fold(alone, |best, runs| if cost(&runs) < cost(&best) { runs } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mode_is_in_one_run_and_neighbours_are_apart() {
        let phases: Vec<f64> = (1..40).map(|i| 0.01 * f64::from(i) + 1e-6 * f64::from(i % 2)).collect();
        // With a short decay a few runs are cheaper than one with long bursts.
        let [short, long] = [0, 300].map(|after| colours(&phases, after));
        assert!(short.len() > 1 && short.len() < 20 && long.len() == 1, "{} {}", short.len(), long.len());
        for run in short.iter().chain(&long) {
            let own: Vec<f64> = run.iter().map(|i| phases[*i]).collect();
            let width = width(&own);
            for i in &own {
                for j in own.iter().filter(|j| *j != i) {
                    let burst = Burst { phase: *j, width, middle: (HALF_LENGTH * width).ceil() };
                    let leak = burst.spectrum(*i).norm() / burst.spectrum(*j).norm();
                    // Residual seen: 4e-5, truncation at both ends included.
                    assert!(leak < 3e-4, "{i} {j}: {leak:e}");
                }
            }
        }
        for runs in [short, long] {
            let mut all: Vec<usize> = runs.concat();
            all.sort_unstable();
            assert_eq!(all, (0..39).collect::<Vec<_>>());
        }
        assert!(colours(&[], 10).is_empty());
    }
}
