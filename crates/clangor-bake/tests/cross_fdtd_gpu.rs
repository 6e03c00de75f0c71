//! The time loop on a graphics processor against that on the processor: the records agree to 1e-5.
//!
//! Needs the feature `gpu` and a Vulkan device; a software device works. Without one it prints `skipped:`.

use std::ops::ControlFlow;

use clangor_bake::fdtd::{Boundary, WaveDevice, WaveError, WaveField, WaveOptions, WaveSolver};
use clangor_bake::gpu::{Gpu, GpuError};
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::shape::Shape;

/// Whether there is a device; if not, prints a message.
fn has_device() -> bool {
    match Gpu::open() {
        Ok(gpu) => {
            println!("on {}", gpu.name());
            true
        }
        Err(why @ GpuError::NoDevice) => {
            println!("skipped: {why}");
            false
        }
        Err(why) => panic!("{why}"),
    }
}

fn mesh(shape: &str) -> TriMesh {
    Shape::parse(shape).expect("a shape").mesh()
}

fn solver(mesh: &TriMesh, spacing: f64, max_wavenumber: f64) -> WaveSolver {
    let options =
        WaveOptions { max_wavenumber, spacing, order: 6, boundary: Boundary::CutCells, longest: 2.0 };
    WaveSolver::try_new(mesh, options).expect("a grid")
}

fn run(solver: &WaveSolver, device: WaveDevice) -> WaveField {
    solver.run_on(device, &|_| ControlFlow::Continue(())).expect("a run")
}

/// Largest difference of the recorded multipoles of a motion over the largest multipole of that motion, or
/// over `least` of that of the strongest motion if that is larger.
fn difference(here: &WaveField, there: &WaveField, least: f64) -> f64 {
    let largest = |signal: &[f64]| signal.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    let loudest = here.signals().iter().map(|s| largest(s)).fold(0.0, f64::max);
    let pairs = here.signals().iter().zip(there.signals());
    pairs
        .map(|(a, b)| {
            assert_eq!(a.len(), b.len());
            let apart: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
            largest(&apart) / largest(a).max(least * loudest)
        })
        .fold(0.0, f64::max)
}

#[test]
fn a_sphere_radiates_alike_on_both() {
    if !has_device() {
        return;
    }
    let solver = solver(&mesh("sphere:1@0.05"), 0.25, 4.0);
    let (here, there) = (run(&solver, WaveDevice::Cpu), run(&solver, WaveDevice::Gpu));
    // The rotations of a sphere radiate only rounding, which is compared with the translations.
    let difference = difference(&here, &there, 1.0);
    println!("residual {difference:.2e}");
    assert!(difference < 1e-5, "{difference:e}");
    assert!(here.signals()[0].iter().any(|x| x.abs() > 0.01));
}

#[test]
fn a_key_radiates_alike_on_both() {
    if !has_device() {
        return;
    }
    // Concave, with a hole and thin walls: all motions differ.
    let mesh = mesh("key");
    let spacing = mesh.bounding_radius(clangor_core::glam::DVec3::ZERO) / 8.0;
    let solver = solver(&mesh, spacing, 1.0 / spacing);
    let (here, there) = (run(&solver, WaveDevice::Cpu), run(&solver, WaveDevice::Gpu));
    let difference = difference(&here, &there, 0.0);
    println!("residual {difference:.2e}");
    assert!(difference < 1e-5, "{difference:e}");
}

#[test]
fn a_run_stops_when_told() {
    if !has_device() {
        return;
    }
    let solver = solver(&mesh("sphere:1@0.2"), 0.25, 2.75);
    let stopped = solver.run_on(WaveDevice::Gpu, &|_| ControlFlow::Break(()));
    assert!(matches!(stopped, Err(WaveError::Interrupted)));
}

#[test]
fn a_device_says_what_it_cannot_do() {
    if !has_device() {
        return;
    }
    let gpu = Gpu::open().expect("a device");
    let broken = gpu.kernel("broken", "fn main() { let x = ; }");
    assert!(matches!(broken, Err(GpuError::Failed { .. })), "{broken:?}");
    let gpu = Gpu::open().expect("a device");
    let huge = gpu.zeros(usize::MAX / 8);
    assert!(matches!(huge, Err(GpuError::TooLarge { .. })), "{huge:?}");
}
