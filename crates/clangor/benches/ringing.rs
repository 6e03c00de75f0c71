//! Time to play ringing bodies, on one core: `cargo bench --profile release -p clangor --bench ringing`. It is that of the
//! processor where the system tells (Linux), so that other programs do not count.
//!
//! * `bank`: modes ringing at 48 kHz, heard by one, two and four receivers, at rest and with transfers that move; how many
//!   play in real time, and whether the cost grows with their number as it should.
//! * `blows`: the same with a hundred blows a second.
//! * `transfer`: the transfers of 76 modes of about 70 000 coefficients for a new place, as \[FRAC\] times them (156 ms on
//!   eight cores, 0.3 ms on its graphics processor), and with \[FRAC\]'s own rule for the order.
//!
//! Words after `--` choose the lines that hold one of them.

use std::hint::black_box;
use std::sync::LazyLock;
use std::time::Instant;

use clangor::contact::ForceProfile;
use clangor::glam::DVec3;
use clangor::model::modal_model::ModalTransfer;
use clangor::synthesis::SampleRate;
use clangor::synthesis::modal::{
    ModalBank, ModalPressure, Resonance, TransferEvaluator, TransferMemory, TransferOrder,
};
use num_complex::Complex64;

/// Time that this thread has had [s], or else that on the wall; in Linux counted in steps of some milliseconds.
fn seconds() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    let statistics = std::fs::read_to_string("/proc/self/schedstat").ok();
    let nanoseconds = statistics.and_then(|s| s.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| START.elapsed().as_secs_f64(), |ns| 1e-9 * ns)
}

/// The least time [s] of several measurements, each of which repeats until the steps of the clock do not matter.
fn best(mut work: impl FnMut()) -> f64 {
    let mut measure = || {
        let begin = seconds();
        let mut repeats = 0;
        while seconds() - begin < 0.1 {
            work();
            repeats += 1;
        }
        (seconds() - begin) / f64::from(repeats)
    };
    (0..5).map(|_| measure()).fold(f64::INFINITY, f64::min)
}

/// Time [s] for a second of so many modes, heard by so many receivers.
fn bank(modes: usize, receivers: usize, moving: bool, blows: bool) -> f64 {
    let resonances: Vec<Resonance> = (0..modes)
        .map(|i| Resonance { frequency: 100.0 + 19_000.0 * i as f64 / modes as f64, damping_ratio: 1e-5 })
        .collect();
    let rate = SampleRate::HZ_48000;
    let mut bank = ModalBank::new(&resonances, receivers, rate, 21_600.0, ModalPressure::Acceleration);
    let transfers = [1.0, 2.0].map(|p| (0..modes).map(|i| Complex64::cis(p * i as f64)).collect::<Vec<_>>());
    let amplitudes = vec![1.0; modes];
    (0..receivers).for_each(|path| bank.set_transfers(path, &transfers[0]));
    bank.jump_to_transfers();
    bank.add_pulse(ForceProfile::HalfSine, 100.0, 50e-6, &amplitudes);
    let mut outputs = vec![Vec::with_capacity(48_000); receivers];
    let mut block = 0;
    best(|| {
        outputs.iter_mut().for_each(Vec::clear);
        for _ in 0..250 {
            if moving {
                (0..receivers).for_each(|path| bank.set_transfers(path, &transfers[block % 2]));
            }
            if blows && block % 5 < 2 {
                bank.add_pulse(ForceProfile::HalfSine, bank.position() as f64 + 100.5, 50e-6, &amplitudes);
            }
            block += 1;
            bank.render(192, &mut outputs);
        }
        black_box(&outputs);
    })
}

/// Time [s] for the transfers of a place, and the number of coefficients.
fn transfer(orders: TransferOrder) -> (f64, usize) {
    // 76 modes up to 20 kHz whose orders sum up to 2176, as those of a plate whose modes are evenly spread.
    let transfers: Vec<(ModalTransfer, f64)> = (0..76)
        .map(|i| {
            let order = (i as f64 * 32.0 / 75.0 + 12.6).round() as usize;
            let value = |k: usize| Complex64::new((k as f64).sin(), (k as f64).cos());
            let coefficients = (0..(order + 1).pow(2)).map(value).collect();
            (ModalTransfer { order, coefficients }, order as f64 - 4.0)
        })
        .collect();
    let total: usize = transfers.iter().map(|(t, _)| t.order).sum();
    assert!((2100..2250).contains(&total), "{total}");
    let evaluator = TransferEvaluator::new(transfers.iter().map(|(t, k)| (Some(t), *k)), orders);
    let (mut memory, mut values) = (TransferMemory::default(), Vec::new());
    let mut angle = 0.0f64;
    let time = best(|| {
        angle += 0.1;
        let (sin, cos) = angle.sin_cos();
        evaluator.evaluate(DVec3::new(cos, 0.3, sin) * (2.0 + cos), &mut memory, &mut values);
        black_box(&values);
    });
    (time, evaluator.coefficients())
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let wanted = |name: &str| words.is_empty() || words.iter().any(|word| name.contains(word.as_str()));
    if wanted("transfer") {
        for (name, orders) in [("baked", TransferOrder::Baked), ("FRAC", TransferOrder::Published)] {
            let (time, coefficients) = transfer(orders);
            println!("transfer, orders {name}: {coefficients} coefficients, {:.4} ms", 1e3 * time);
        }
    }
    if wanted("bank") {
        for modes in [1_000, 5_000, 20_000] {
            for (receivers, moving) in [(1, false), (1, true), (2, true), (4, true)] {
                let time = bank(modes, receivers, moving, false);
                let (each, real_time) = (1e9 * time / (48_000.0 * modes as f64), modes as f64 / time);
                let how = if moving { "moving" } else { "at rest" };
                println!(
                    "bank, {modes} modes, {receivers} receivers {how}: {time:.4} s/s, {each:.3} ns a mode and sample, \
                     {real_time:.0} modes in real time"
                );
            }
        }
    }
    if wanted("blows") {
        let time = bank(1_000, 1, true, true);
        println!("blows, 1000 modes, 100 a second: {time:.4} s/s, {:.0} modes in real time", 1_000.0 / time);
    }
}
