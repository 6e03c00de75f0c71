//! Transfers on a graphics processor against those on the processor: equal to 1e-5 of the largest of a mode.
//!
//! Needs the feature `gpu` and a Vulkan device; a software device works. Without one it prints `skipped:`.

use clangor_bake::gpu::{Gpu, GpuError};
use clangor_bake::modal_radiation::gpu_transfers::GpuTransfers;
use clangor_core::math::spherical_harmonics::count;
use clangor_core::sound_model::modal::model::ModalTransfer;
use glam::DVec3;
use num_complex::Complex64;

#[test]
fn transfers_are_alike_on_both() {
    let gpu = match Gpu::open() {
        Ok(gpu) => gpu,
        Err(why @ GpuError::NoDevice) => {
            println!("skipped: {why}");
            return;
        }
        Err(why) => panic!("{why}"),
    };
    println!("on {}", gpu.name());
    // Orders about κ + 4, and coefficients that decay with n, as those of real bodies do.
    let transfers: Vec<(ModalTransfer, f64)> = (0..20)
        .map(|mode| {
            let wavenumber = 0.5 + 1.6 * mode as f64;
            let order = wavenumber as usize + 4;
            let coefficients = (0..count(order))
                .map(|i| {
                    let phase = (1.3 * (i * (mode + 1)) as f64).sin();
                    Complex64::from_polar(1.0 / (1.0 + (i as f64).sqrt()), 6.0 * phase)
                })
                .collect();
            (ModalTransfer { order, coefficients }, wavenumber)
        })
        .collect();
    let pairs: Vec<_> = transfers.iter().map(|(t, k)| (t, *k)).collect();
    let mut there = GpuTransfers::new(&gpu, &pairs).expect("buffers");
    let places: Vec<DVec3> = (0..12)
        .map(|i| {
            let turn =
                DVec3::new((0.7 * i as f64).sin(), (1.9 * i as f64).cos(), (2.3 * i as f64).sin() + 0.1);
            turn.normalize() * [1.0, 1.5, 10.0, 300.0][i % 4]
        })
        .chain([2.0 * DVec3::Z, -2.0 * DVec3::Z])
        .collect();
    // Two calls: the second reuses the buffers.
    for places in [&places[..], &places[..], &places[..5]] {
        let values = there.evaluate(places).expect("a run");
        assert_eq!(values.len(), places.len() * transfers.len());
        for (mode, (transfer, wavenumber)) in transfers.iter().enumerate() {
            let here: Vec<Complex64> =
                places.iter().map(|x| x.length() * transfer.undelayed(*x, *wavenumber)).collect();
            let largest = here.iter().map(|p| p.norm()).fold(0.0, f64::max);
            for (at, (x, p)) in places.iter().zip(&here).enumerate() {
                let error = (x.length() * values[at * transfers.len() + mode] - p).norm() / largest;
                // Residual seen: 1.3e-6 on llvmpipe.
                assert!(error < 1e-5, "mode {mode} at {x}: {error:e}");
            }
        }
    }
}

#[test]
fn nothing_is_asked_and_nothing_answered() {
    let Ok(gpu) = Gpu::open() else { return };
    let mut none = GpuTransfers::new(&gpu, &[]).expect("buffers");
    assert!(none.evaluate(&[DVec3::X]).expect("a run").is_empty());
}
