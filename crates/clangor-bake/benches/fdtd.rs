//! Throughput of the time-domain solver: `cargo bench -p clangor-bake --bench fdtd`, with `--features gpu`
//! also on a graphics processor.
//!
//! Cell updates per second and core of six runs around a sphere, including absorbing layers and recording, on
//! grids of three sizes. Measures processor time, independent of other load; on a graphics processor
//! wall-clock time. A software device is slow, and runs the smallest grid only.

mod cpu_time;

use std::ops::ControlFlow;
#[cfg(feature = "gpu")]
use std::time::Instant;

use clangor_bake::fdtd::{Boundary, WaveOptions, WaveSolver};
#[cfg(feature = "gpu")]
use clangor_bake::{fdtd::WaveDevice, gpu::Gpu};
use clangor_core::shape::Shape;
use cpu_time::cpu_time;

fn main() {
    let Ok(shape) = Shape::parse("sphere:1") else { return };
    let mesh = shape.mesh();
    for cells_per_radius in [8.0, 16.0, 32.0] {
        let options = WaveOptions {
            max_wavenumber: 2.75,
            spacing: 1.0 / cells_per_radius,
            order: 8,
            boundary: Boundary::CutCells,
            longest: 1.0,
        };
        let Ok(solver) = WaveSolver::try_new(&mesh, options) else { return };
        let before = cpu_time();
        let Ok(field) = solver.run(&|_| ControlFlow::Continue(())) else { return };
        let spent = cpu_time() - before;
        println!(
            "{cells_per_radius:4} cells per radius: {:9} cells, {:6.2} CPU-s, {:5.0} Mcell/s per core",
            solver.cells(),
            spent,
            1e-6 * field.updates() / spent
        );
        #[cfg(feature = "gpu")]
        on_graphics_processor(&solver);
    }
}

#[cfg(feature = "gpu")]
fn on_graphics_processor(solver: &WaveSolver) {
    let gpu = match Gpu::open() {
        Ok(gpu) => gpu,
        Err(why) => return println!("    {why}"),
    };
    if gpu.is_software() && solver.cells() > 500_000 {
        return;
    }
    let started = Instant::now();
    match solver.run_on(WaveDevice::Gpu, &|_| ControlFlow::Continue(())) {
        Ok(field) => {
            let spent = started.elapsed().as_secs_f64();
            println!("    on {}: {spent:6.2} s, {:5.0} Mcell/s", gpu.name(), 1e-6 * field.updates() / spent);
        }
        Err(why) => println!("    {why}"),
    }
}
