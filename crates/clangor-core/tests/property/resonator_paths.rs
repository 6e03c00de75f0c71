//! The paths of a bank of resonators share its modes and nothing else.

use clangor_core::contact::ForceProfile;
use clangor_core::synthesis::SampleRate;
use clangor_core::synthesis::modal::{ModalPressure, Resonance, ResonatorBank};
use num_complex::Complex64;

const MODES: usize = 45;

/// What some paths receive of the same modes: at rest, moving, with forces and without.
fn render(paths: &[usize]) -> Vec<Vec<f64>> {
    let resonance = |i: usize| Resonance {
        frequency: 110.0 + 430.0 * i as f64,
        damping_ratio: 1e-4 * (1 + i % 5) as f64,
    };
    let resonances: Vec<Resonance> = (0..MODES).map(resonance).collect();
    let rate = SampleRate::HZ_48000;
    let mut bank = ResonatorBank::new(&resonances, paths.len(), rate, 21_600.0, ModalPressure::Acceleration);
    let transfers = |path: usize, place: usize| -> Vec<Complex64> {
        (0..MODES).map(|i| Complex64::cis((1 + i * (path + 2) + 3 * place) as f64)).collect()
    };
    let amplitudes: Vec<f64> = (0..MODES).map(|i| 1.0 / (1 + i) as f64).collect();
    let mut outputs = vec![Vec::new(); paths.len()];
    for (heard, path) in paths.iter().enumerate() {
        bank.set_transfers(heard, &transfers(*path, 0));
    }
    bank.jump_to_transfers();
    for block in 0..12 {
        if block % 5 == 0 {
            let onset = bank.position() as f64 + 70.3;
            bank.add_pulse(&ForceProfile::HalfSine.into(), onset, 9e-5, &amplitudes);
        }
        // Path 0 stays where it is, the others move now and then.
        for (heard, path) in paths.iter().enumerate().filter(|(_, path)| **path > 0 && block % 3 > 0) {
            bank.set_transfers(heard, &transfers(*path, block));
        }
        bank.render(150, &mut outputs);
    }
    outputs
}

#[test]
fn a_path_has_the_same_bits_beside_any_others() {
    let alone: Vec<Vec<f64>> = (0..6).flat_map(|path| render(&[path])).collect();
    assert!(alone.iter().all(|samples| samples.iter().any(|p| p.abs() > 1e-3)));
    for count in 2..7 {
        let together = render(&(0..count).collect::<Vec<_>>());
        for (path, samples) in together.iter().enumerate() {
            assert!(*samples == alone[path], "path {path} of {count}");
        }
    }
    // A bank without paths renders nothing.
    assert!(render(&[]).is_empty());
}
