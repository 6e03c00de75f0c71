//! Time to evaluate the transfers of 76 modes of Σ (n + 1)² = 70 thousand coefficients (Σ n = 2176, \[FRAC\]
//! §4) at a place, new each call: on one core, and on a graphics processor.

use std::time::Instant;

use clangor_core::math::spherical_harmonics::count;
use clangor_core::sound_model::modal::model::ModalTransfer;
use glam::DVec3;
use num_complex::Complex64;

fn transfers() -> Vec<(ModalTransfer, f64)> {
    (0..76)
        .map(|mode| {
            // From 14 to 43, Σ = 2176.
            let order = 14 + (29 * mode + 44) / 75;
            let value = |i: usize| Complex64::from_polar(1.0, (i * (mode + 1)) as f64);
            (
                ModalTransfer { order, coefficients: (0..count(order)).map(value).collect() },
                order as f64 - 4.0,
            )
        })
        .collect()
}

fn place(call: usize) -> DVec3 {
    let turn = 0.01 * call as f64;
    DVec3::new(turn.sin(), turn.cos(), 0.3).normalize() * (3.0 + turn)
}

/// Median of the times of calls [ms].
fn median(calls: usize, mut call: impl FnMut(usize)) -> f64 {
    let mut times: Vec<f64> = (0..calls)
        .map(|n| {
            let start = Instant::now();
            call(n);
            1e3 * start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[calls / 2]
}

fn main() {
    let transfers = transfers();
    let orders: usize = transfers.iter().map(|(t, _)| t.order).sum();
    let coefficients: usize = transfers.iter().map(|(t, _)| t.coefficients.len()).sum();
    println!("{} modes, Σ n = {orders}, {coefficients} coefficients", transfers.len());
    let here = median(50, |call| {
        let sum: Complex64 = transfers.iter().map(|(t, k)| t.undelayed(place(call), *k)).sum();
        std::hint::black_box(sum);
    });
    println!("in double precision, mode by mode: {here:.3} ms");
    #[cfg(feature = "gpu")]
    on_device(&transfers);
}

#[cfg(feature = "gpu")]
fn on_device(transfers: &[(ModalTransfer, f64)]) {
    use clangor_bake::gpu::Gpu;
    use clangor_bake::modal_radiation::gpu_transfers::GpuTransfers;
    let gpu = match Gpu::open() {
        Ok(gpu) => gpu,
        Err(why) => {
            println!("{why}");
            return;
        }
    };
    let pairs: Vec<_> = transfers.iter().map(|(t, k)| (t, *k)).collect();
    let mut there = GpuTransfers::new(&gpu, &pairs).expect("buffers");
    for places in [1, 64] {
        let time = median(20, |call| {
            let places: Vec<DVec3> = (0..places).map(|n| place(call + n)).collect();
            std::hint::black_box(there.evaluate(&places).expect("a run"));
        });
        println!("{places} places at a time on {}: {:.3} ms each", gpu.name(), time / places as f64);
    }
}
