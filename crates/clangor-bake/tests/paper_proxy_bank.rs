//! The bank of ellipsoids: bake time, size, smoothness (\[PROXY\] Fig. 4), and error of the nearest entry.
//!
//! `cargo test -p clangor-bake --release --test paper_proxy_bank -- --ignored --nocapture` builds the whole
//! bank, about two minutes of CPU time.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use clangor_bake::soundbank::acceleration::{bank_entry, build_bank};
use clangor_core::sound_model::acceleration::field::{AccelerationField, RIGID_DOFS};
use clangor_core::sound_model::acceleration::proxy_field::mean_field;
use glam::{DMat3, DVec3};
use num_complex::Complex64;

/// Pressures of one motion at twice the longest semi-axis, 16 directions, 20 frequencies; `scale` is the
/// longest semi-axis.
fn pressures(field: &AccelerationField, degree: usize, scale: f64) -> Vec<Complex64> {
    let mut z = [0.0; RIGID_DOFS];
    z[degree] = if degree < 3 { scale } else { scale * scale };
    let mut values = Vec::new();
    for k in 0..16 {
        let height = (f64::from(k) + 0.5) / 8.0 - 1.0;
        let (sin, cos) = (2.4 * f64::from(k) + 0.3).sin_cos();
        let ring = (1.0 - height * height).sqrt();
        let x = 2.0 * DVec3::new(ring * cos, ring * sin, height);
        for kappa in 1..=20 {
            let kappa = 0.7 * f64::from(kappa);
            values.push(field.pressure(&z, x / scale, kappa * scale));
        }
    }
    values
}

/// Relative L2 difference.
fn difference(a: &[Complex64], b: &[Complex64]) -> f64 {
    let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b).norm_sqr()).sum();
    (square / b.iter().map(Complex64::norm_sqr).sum::<f64>()).sqrt()
}

#[test]
fn neighbours_in_the_bank_sound_alike() {
    let mut quiet = |_: &_| ControlFlow::Continue(());
    let mut entry = |b, c| bank_entry(b, c, 14.0, 3e-3, &mut quiet).unwrap();
    let (near, evidence) = entry(1.0, 0.525);
    // The fit's own evidence, at held-out frequencies.
    assert!(evidence.held_out_error < 3e-3, "{}", evidence.held_out_error);
    let (next, _) = entry(1.0, 0.43);
    let change = difference(&pressures(&next.field, 2, 1.0), &pressures(&near.field, 2, 1.0));
    // Seen: 0.28 over the whole band, most of it phase at the upper end, where k ΔC = 1.3.
    assert!(change < 0.4, "{change}");
}

#[test]
#[ignore = "builds the whole bank"]
fn the_whole_bank() {
    let start = cpu_seconds();
    let (bank, evidence) = build_bank(20.0, 1e-3, &mut |_| ControlFlow::Continue(())).unwrap();
    let spent = cpu_seconds() - start;
    let (mut numbers, mut terms) = (0, 0);
    for (entry, evidence) in bank.entries().iter().zip(&evidence) {
        numbers += entry.field.real.len();
        terms += entry.field.terms.len();
        println!(
            "1 : {} : {}  {} unknowns, {} solves, {} nodes, {} terms of order {}, held out {:.1e}, ring \
             {:.1}",
            entry.b,
            entry.c,
            evidence.unknowns,
            evidence.solves,
            entry.field.nodes.len(),
            entry.field.terms.len(),
            entry.field.order(),
            evidence.held_out_error,
            entry.field.ring_time
        );
    }
    println!(
        "{spent:.0} s CPU; {terms} terms, {numbers} complex numbers = {:.2} MB at 16 bit",
        4e-6 * numbers as f64
    );
    let at = |b: f64, c: f64| {
        let near = |e: &&clangor_core::sound_model::soundbank::ellipsoid_bank::BankEntry| {
            (e.b - b).abs() + (e.c - c).abs() < 1e-6
        };
        &bank.entries().iter().find(near).unwrap().field
    };
    let value = |k: usize| 0.05 + 0.095 * k as f64;
    println!("PROXY Fig. 4: change of p_3 at 2 A from one ellipsoid to the next, kA to 14");
    for (name, of) in [
        ("A = B, C varies", Box::new(|k| (1.0, value(k))) as Box<dyn Fn(usize) -> (f64, f64)>),
        ("C = 0.05, B varies", Box::new(|k| (value(k), 0.05))),
        ("B = C vary", Box::new(|k| (value(k), value(k)))),
    ] {
        print!("{name}:");
        for k in 1..11 {
            let ((b0, c0), (b1, c1)) = (of(k - 1), of(k));
            print!(" {:.3}", difference(&pressures(at(b0, c0), 2, 1.0), &pressures(at(b1, c1), 2, 1.0)));
        }
        println!();
    }
    println!(
        "an ellipsoid between those of the bank: nearest with the same A, with the same volume; the mean of \
         those around"
    );
    for (i, j, fb, fc) in
        [(8, 5, 0.5, 0.5), (9, 0, 0.5, 0.5), (6, 1, 0.3, 0.5), (10, 2, 0.0, 0.4), (4, 2, 0.5, 0.2)]
    {
        let (b, c) = (value(i) + 0.095 * fb, value(j) + 0.095 * fc);
        let (own, _) = bank_entry(b, c, 20.0, 1e-3, &mut |_| ControlFlow::Continue(())).unwrap();
        let ellipsoid = DVec3::new(1.0, b, c);
        let square = ellipsoid * ellipsoid;
        let inertia = DMat3::from_diagonal(DVec3::splat(square.element_sum()) - square);
        let proxy = bank.proxy_for(inertia, 4.0 / 3.0 * PI * ellipsoid.element_product()).unwrap();
        let mean = mean_field(&bank, &proxy, usize::MAX);
        let (bn, cn) = (value(i + usize::from(fb > 0.49)), value(j + usize::from(fc > 0.49)));
        let volume = (b * c / (bn * cn)).cbrt();
        print!("1 : {b:.3} : {c:.3}");
        for degree in 0..RIGID_DOFS {
            let exact = pressures(&own.field, degree, 1.0);
            let same_axis = pressures(at(bn, cn), degree, 1.0);
            let same_volume = pressures(at(bn, cn), degree, volume);
            let between = pressures(&mean, degree, 1.0);
            print!(
                "  {:.3} {:.3} {:.3}",
                difference(&same_axis, &exact),
                difference(&same_volume, &exact),
                difference(&between, &exact)
            );
        }
        println!();
    }
    assert!(evidence.iter().all(|e| e.held_out_error < 1e-3));
    assert!(4 * numbers < 2_000_000);
}

/// CPU time of this process \[s\].
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after = stat.rsplit(')').next().unwrap_or_default();
    let ticks = |k: usize| after.split_whitespace().nth(k).and_then(|t| t.parse::<f64>().ok()).unwrap_or(0.0);
    (ticks(11) + ticks(12)) / 100.0
}
