//! A struck sphere against the reference program of the shared folder, which works in the time domain.
//!
//! Runs where `CLANGOR_SHARED` names that folder and `python3` has NumPy.

use std::f64::consts::TAU;
use std::process::Command;

use crate::bodies::{pan_steel_ball, strike};
use clangor_core::contact::ForceProfile;
use clangor_core::glam::DVec3;
use clangor_core::medium::Medium;
use clangor_core::sound_model::acceleration::sphere_radiation::SphereModel;
use clangor_core::synthesis::SampleRate;
use clangor_core::synthesis::strike::{Strike, StrikeForce};
use num_complex::Complex64;

/// Samples per second of the reference, which is not band-limited.
const REFERENCE_RATE: f64 = 4e6;

/// Times [s] and pressures [Pa] for a peak acceleration of 1 m/s², 30° off the axis.
fn reference(radius: f64, distance: f64, tau: f64) -> Option<Vec<(f64, f64)>> {
    let script = format!("{}/reference/sphere_reference.py", std::env::var("CLANGOR_SHARED").ok()?);
    let arguments = [
        ("--radius", radius),
        ("--r", distance),
        ("--theta", 30.0),
        ("--width", tau),
        ("--fs", REFERENCE_RATE),
        ("--t1", (distance - radius) / 343.2 + tau + 25.0 * radius / 343.2),
    ];
    let mut command = Command::new("python3");
    command.arg(script);
    for (name, value) in arguments {
        command.arg(name).arg(format!("{value:e}"));
    }
    let output = command.output().ok().filter(|output| output.status.success())?;
    let text = String::from_utf8(output.stdout).ok()?;
    text.lines()
        .map(|line| line.split_once(',').and_then(|(t, p)| Some((t.parse().ok()?, p.parse().ok()?))))
        .collect()
}

/// ∫ p e^{−iωt} dt of samples.
fn spectrum_at(samples: impl Iterator<Item = (f64, f64)>, dt: f64, frequency: f64) -> Complex64 {
    samples.map(|(t, p)| Complex64::from_polar(p * dt, -TAU * frequency * t)).sum()
}

#[test]
fn struck_sphere_agrees_with_the_reference_program() {
    for (radius, distance, tau) in [(0.0075, 0.5, 37e-6), (0.02, 0.024, 120e-6), (0.05, 2.0, 300e-6)] {
        let Some(expected) = reference(radius, distance, tau) else {
            println!("skipped: CLANGOR_SHARED names no folder with a reference that python3 can run");
            return;
        };
        let body = pan_steel_ball(radius, DVec3::ZERO);
        // A peak acceleration of 1 m/s² is an impulse of M · 2τ/π.
        let impulse = body.mass * 2.0 * tau / std::f64::consts::PI;
        let angle = 30f64.to_radians();
        let impact = Strike {
            force: StrikeForce::Impulse { impulse: DVec3::Y * impulse, duration: Some(tau) },
            point: DVec3::NEG_Y * radius,
            listener: DVec3::new(angle.sin(), angle.cos(), 0.0) * distance,
            profile: ForceProfile::HalfSine,
            steps: 16.0,
            sample_rate: SampleRate::HZ_48000,
            max_frequency: None,
            seconds: None,
            medium: Medium::AIR,
            room: None,
            sphere_model: SphereModel::Exact,
        };
        let sound = strike(&body, &impact).unwrap();
        let (mut error, mut norm) = (0.0, 0.0);
        for j in 0..=40 {
            let frequency = 100.0 + 19_900.0 * f64::from(j) / 40.0;
            let ours = sound.times.iter().copied().zip(sound.pressures.iter().copied());
            let ours = spectrum_at(ours, 1.0 / 48_000.0, frequency);
            let theirs = spectrum_at(expected.iter().copied(), 1.0 / REFERENCE_RATE, frequency);
            error += (ours - theirs).norm_sqr();
            norm += theirs.norm_sqr();
        }
        let error = (error / norm).sqrt();
        // Largest residual seen: 5.7e-8, the sampling of the reference; 2.4e-10 at 20 MHz.
        assert!(error < 1e-4, "R = {radius} m, r = {distance} m, τ = {tau} s: {error:e}");
    }
}
