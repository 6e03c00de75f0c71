//! CPU time of the rational fit: `cargo bench -p clangor-bake --bench rational`.
//!
//! 40 functions with 120 common poles, sampled at 88 frequencies and fitted by 38 nodes, without a tolerance
//! that ends the fit earlier. The last step solves for 76 real columns over 2000 complex rows, those of the
//! 50 samples that are no nodes. Prints the time of the whole fit, and of its last node.

mod cpu_time;

use std::hint::black_box;

use clangor_bake::fitting::rational::{FunctionSample, fit};
use cpu_time::cpu_time;
use num_complex::Complex64;

const SAMPLES: usize = 88;
const FUNCTIONS: usize = 40;
const NODES: usize = 38;
const POLES: usize = 120;

/// Values on the imaginary axis of sums over damped resonances, of one amplitude for each function and pole.
fn samples() -> Vec<FunctionSample> {
    let pole = |j: usize| Complex64::new(-0.02 - 0.01 * (j % 7) as f64, 0.25 + 0.25 * j as f64);
    let amplitude = |v: usize, j: usize| Complex64::cis((1 + v * (j + 3)) as f64);
    let value = |s: Complex64, v: usize| -> Complex64 {
        (0..POLES)
            .map(|j| {
                let (a, p) = (amplitude(v, j), pole(j));
                a / (s - p) + a.conj() / (s - p.conj())
            })
            .sum()
    };
    (0..SAMPLES)
        .map(|i| {
            let s = Complex64::new(0.0, 0.1 + 30.0 * i as f64 / SAMPLES as f64);
            let values = (0..FUNCTIONS).map(|v| value(s, v)).collect();
            FunctionSample { s, values, weights: vec![0.1; FUNCTIONS], group: 1 }
        })
        .collect()
}

/// CPU time of a fit [s], the mean over a second.
fn time(samples: &[FunctionSample], nodes: usize) -> f64 {
    let mut fits = 0;
    let begin = cpu_time();
    while cpu_time() - begin < 1.0 {
        black_box(fit(samples, 0.0, nodes));
        fits += 1;
    }
    (cpu_time() - begin) / f64::from(fits)
}

fn main() {
    let samples = samples();
    let (all, before) = (time(&samples, NODES), time(&samples, NODES - 1));
    println!("{} columns, {} rows: ", 2 * NODES, (SAMPLES - NODES) * FUNCTIONS);
    println!("  fit from the first node to the last: {:8.3} ms CPU", 1e3 * all);
    println!("  its last node:                       {:8.3} ms CPU", 1e3 * (all - before));
}
