//! Our exact integration of modes against the one of \[PAN\]: Newmark's with β = ¼ and γ = ½ at 192 kHz.

use std::f64::consts::TAU;

use clangor_core::contact::ForceProfile;
use clangor_core::synthesis::SampleRate;
use clangor_core::synthesis::modal::{ModalPressure, Resonance, ResonatorBank};
use num_complex::Complex64;

const RATE: f64 = 192_000.0;

/// q̈ of a mode at the samples, under a half-sine of unit modal impulse.
fn newmark(mode: Resonance, onset: f64, duration: f64, count: usize) -> Vec<f64> {
    let (step, omega) = (1.0 / RATE, TAU * mode.frequency);
    let damping = 2.0 * mode.damping_ratio * omega;
    let (mut q, mut velocity, mut acceleration) = (0.0, 0.0, 0.0);
    let at = |k: usize| {
        let force = ForceProfile::HalfSine.value(k as f64 / RATE - onset, duration);
        let known = q + step * velocity + 0.25 * step * step * acceleration;
        let half = velocity + 0.5 * step * acceleration;
        let next = (force - damping * half - omega * omega * known)
            / (1.0 + 0.5 * step * damping + 0.25 * step * step * omega * omega);
        q = known + 0.25 * step * step * next;
        velocity = half + 0.5 * step * next;
        acceleration = next;
        next
    };
    (0..count).map(at).collect()
}

#[test]
fn newmark_and_exact_integration_agree_as_far_as_newmark_goes() {
    let (onset, duration, count) = (0.002, 300e-6, 4000);
    for frequency in [200.0, 700.0, 2400.0] {
        let mode = Resonance { frequency, damping_ratio: 0.003 };
        let rate = SampleRate::try_new(RATE as u32).unwrap();
        let mut bank = ResonatorBank::new(&[mode], 1, rate, 0.45 * RATE, ModalPressure::Acceleration);
        bank.set_transfers(0, &[Complex64::ONE]);
        bank.jump_to_transfers();
        bank.add_pulse(&ForceProfile::HalfSine.into(), onset * RATE, duration, &[1.0]);
        let mut ours = vec![Vec::new()];
        bank.render(count, &mut ours);
        let theirs = newmark(mode, onset, duration, count);
        let level = theirs[600..].iter().fold(0.0f64, |m, a| m.max(a.abs()));
        let error = ours[0][600..].iter().zip(&theirs[600..]).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        // Newmark's frequency is low by (ωT)²/12, which turns the phase by as much × ω × the time.
        let omega = TAU * frequency;
        let turned = omega * (count as f64 / RATE - onset) * (omega / RATE).powi(2) / 12.0;
        // The half-sine of 58 samples has (π/58)²/12 = 2.5e-4 too little area. Residuals seen: 1.3e-4, 3e-3,
        // 7e-2.
        assert!(error < (1.1 * turned + 5e-4) * level, "{frequency}: {:e}, {turned:e}", error / level);
        assert!(error > 1e-5 * level);
    }
}
