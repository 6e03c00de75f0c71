//! The time loop on a graphics processor: the same update as [`super::grid`], one invocation for each cell.
//!
//! ```text
//! record (every few steps) ─► rows (cells near the body) ─► sweep (other cells, layers) ─► the next step
//! ```
//!
//! Pressures stay on the device. Only those at the points of the sphere are read back, in blocks of steps,
//! and are expanded into multipoles here. Motions run side by side, as many as occupy the device.
//!
//! Differs from the processor: a bit per cell excludes the body and the cells near it from the sweep; the
//! processor computes and overwrites them. Every sum has the same order, so that the results are equal apart
//! from products and sums that a device fuses.

use std::fmt::Write;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use clangor_core::sound_model::acceleration::field::RIGID_DOFS;

use super::WaveError;
use super::absorber::{Absorber, FACES, LAYER};
use super::boundary::Rows;
use super::lattice::{GROUND, Lattice, SQUARE};
use super::pulse::Pulse;
use super::recorder::{Recorder, TAPS};
use crate::gpu::{Gpu, GpuBuffer, GpuError, GpuTask};

/// Cells that occupy a device; motions of smaller grids run side by side.
const BUSY: usize = 1 << 24;
/// Most records of a block.
const MOST_RECORDS: usize = 64;
/// Least time of a block, for which the cost of waiting is small.
const BLOCK: Duration = Duration::from_millis(100);

/// Inputs of a run.
pub(super) struct GpuRun<'a> {
    pub(super) lattice: &'a Lattice,
    pub(super) rows: &'a Rows,
    pub(super) recorder: &'a Recorder,
    pub(super) pulse: &'a Pulse,
    /// Steps between records.
    pub(super) stride: usize,
    pub(super) steps: usize,
}

/// The multipoles of each motion, as the time loop on the processor returns them.
pub(super) fn signals(
    run: &GpuRun<'_>,
    progress: &(dyn Fn(f64) -> ControlFlow<()> + Sync),
) -> Result<Vec<Vec<f64>>, WaveError> {
    let gpu = Gpu::open()?;
    let cells = run.lattice.cells();
    let fit = (gpu.most_words() as usize / cells).min(BUSY / cells).clamp(1, RIGID_DOFS);
    // Balanced groups: 3 and 3 instead of 4 and 2.
    let lanes = RIGID_DOFS.div_ceil(RIGID_DOFS.div_ceil(fit));
    let mut signals = vec![Vec::new(); RIGID_DOFS];
    for (turn, signals) in signals.chunks_mut(lanes).enumerate() {
        let first = turn * lanes;
        let together = signals.len();
        let tasks = Tasks::new(&gpu, run, first, together)?;
        let mut on_progress =
            |done: f64| progress((first as f64 + done * together as f64) / RIGID_DOFS as f64);
        tasks.run(&gpu, run, signals, &mut on_progress)?;
    }
    Ok(signals)
}

/// A step of a few motions, from either of the two fields to the other.
struct Tasks {
    record: [GpuTask; 2],
    step: [[GpuTask; 2]; 2],
    /// Pressures at the points of the sphere: for each record, motion and point.
    records: GpuBuffer,
    /// Words of a record.
    record_length: usize,
}

impl Tasks {
    fn new(gpu: &Gpu, run: &GpuRun<'_>, first: usize, lanes: usize) -> Result<Self, GpuError> {
        let GpuRun { lattice, rows, recorder, pulse, stride, .. } = run;
        let [nx, ny, nz] = lattice.size.map(|n| n as u32);
        let longest = nx.max(ny).max(nz);
        // Parameters of the run and profiles of the absorbing layer.
        let points = recorder.points();
        let record_length = lanes * points;
        let sizes = [rows.cells.len(), points, *stride, MOST_RECORDS].map(|n| n as u32);
        let [row_count, point_count, ..] = sizes;
        let mut words = vec![nx, ny, nz, lanes as u32, first as u32];
        words.extend(sizes);
        words.extend([longest, 0, 0]);
        words.extend(Absorber::profiles().iter().flatten().flatten().map(|x| x.to_bits()));
        let run = gpu.upload(&words)?;

        // Pressure fields of two steps, and memory variables of the layers.
        let rest = vec![GROUND.to_bits(); lanes * lattice.cells()];
        let fields = [gpu.upload(&rest)?, gpu.upload(&rest)?];
        drop(rest);
        let memories = lanes * 6 * FACES * (longest * longest) as usize;
        let psi = [gpu.zeros(memories)?, gpu.zeros(memories)?];
        let zeta = gpu.zeros(memories)?;
        // Rows near the body, drives, and the points of the recorder.
        let kept = gpu.upload(&kept_cells(lattice, rows))?;
        let [row_words, link_words, drive_words] = row_words(rows);
        let (row_words, links) = (gpu.upload(&row_words)?, gpu.upload(&link_words)?);
        let drives = gpu.upload(&drive_words)?;
        let pulse_words: Vec<u32> =
            (0..=pulse.values.len()).flat_map(|step| pulse.at(step).map(f32::to_bits)).collect();
        let pulse = gpu.upload(&pulse_words)?;
        let point_words = gpu.upload(&recorder.words())?;
        let clock = gpu.zeros(1)?;
        let records = gpu.zeros(MOST_RECORDS * record_length)?;

        // Kernels, and their bindings for both directions of the double buffer.
        let kernel = |name, source| gpu.kernel(name, &program(source));
        let record = kernel("record", include_str!("gpu/record.wgsl"))?;
        let near_body = kernel("rows", include_str!("gpu/rows.wgsl"))?;
        let sweep = kernel("sweep", include_str!("gpu/sweep.wgsl"))?;

        let lanes = lanes as u32;
        let (of_rows, of_points) = (row_count.div_ceil(64), point_count.div_ceil(64));
        let of_cells = [nx.div_ceil(16), ny.div_ceil(8), nz * lanes];
        let record_from =
            |p| gpu.task(&record, &[&run, p, &point_words, &clock, &records], [of_points, lanes, 1]);
        let step_from = |from: usize| {
            let (p, next) = (&fields[from], &fields[1 - from]);
            let row_buffers = [&run, p, next, &row_words, &links, &drives, &pulse, &clock];
            let sweep_buffers = [&run, p, next, &kept, &psi[from], &psi[1 - from], &zeta, &clock];
            Ok([
                gpu.task(&near_body, &row_buffers, [of_rows, lanes, 1])?,
                gpu.task(&sweep, &sweep_buffers, of_cells)?,
            ])
        };
        Ok(Tasks {
            record: [record_from(&fields[0])?, record_from(&fields[1])?],
            step: [step_from(0)?, step_from(1)?],
            records,
            record_length,
        })
    }

    /// Runs all steps and appends the record to the signal of each motion.
    fn run(
        &self,
        gpu: &Gpu,
        run: &GpuRun<'_>,
        signals: &mut [Vec<f64>],
        progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<(), WaveError> {
        let GpuRun { stride, steps, recorder, .. } = *run;
        let count = steps.div_ceil(stride);
        // Short blocks first, for an early report; they grow until waiting is negligible.
        let (mut done, mut block) = (0, 1);
        while done < count {
            let started = Instant::now();
            // A block ends with the buffer.
            let slot = done % MOST_RECORDS;
            let end = (done + block.min(MOST_RECORDS - slot)).min(count);
            // Queue the steps of the block, with a record every `stride` steps.
            let tasks = (done * stride..(end * stride).min(steps)).flat_map(|step| {
                let record = (step % stride == 0).then_some(&self.record[step % 2]);
                record.into_iter().chain(&self.step[step % 2])
            });
            gpu.run(tasks)?;
            // Read the block back and expand it into multipoles.
            let words = slot * self.record_length..(slot + end - done) * self.record_length;
            let pressures = gpu.read(&self.records, words)?;
            for record in pressures.chunks_exact(self.record_length) {
                for (pressures, signal) in record.chunks_exact(recorder.points()).zip(&mut *signals) {
                    recorder.project(pressures.iter().copied(), signal);
                }
            }
            done = end;
            if progress(done as f64 / count as f64).is_break() {
                return Err(WaveError::Interrupted);
            }
            if started.elapsed() < BLOCK {
                block = (2 * block).min(MOST_RECORDS);
            }
        }
        Ok(())
    }
}

/// A kernel preceded by the definitions that it shares with the other kernels and with the processor.
fn program(source: &str) -> String {
    let mut text = String::new();
    for (name, value) in [("LAYER", LAYER), ("FACES", FACES), ("TAPS", TAPS)] {
        // Writing to a string does not fail.
        let _ = writeln!(text, "const {name} = {value}u;");
    }
    let _ = writeln!(text, "const SQUARE = {SQUARE:?}f;\nconst SIXTH = {:?}f;", 1.0_f32 / 6.0);
    text + include_str!("gpu/run.wgsl") + source
}

/// A bit for each cell that the sweep skips.
fn kept_cells(lattice: &Lattice, rows: &Rows) -> Vec<u32> {
    let mut bits = vec![0; lattice.cells().div_ceil(32)];
    for cell in rows.cells.iter().chain(&rows.solid) {
        bits[*cell as usize / 32] |= 1 << (cell % 32);
    }
    bits
}

/// Rows, links and drives in the layout of the kernel.
fn row_words(rows: &Rows) -> [Vec<u32>; 3] {
    let (mut heads, mut drives) = (Vec::new(), Vec::new());
    let mut start = 0;
    for (row, (cell, end)) in rows.cells.iter().zip(&rows.ends).enumerate() {
        heads.extend([*cell, start, *end]);
        drives.extend(rows.drive[row].iter().chain(&rows.bend[row]).map(|x| x.to_bits()));
        start = *end;
    }
    let links = rows.neighbours.iter().zip(&rows.weights).flat_map(|(n, w)| [*n, w.to_bits()]);
    [heads, links.collect(), drives]
}
