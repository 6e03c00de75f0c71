//! Force streams, contact damping, and rendering without allocation.

use std::f64::consts::TAU;

use crate::ringing::{RADIUS, body, impact, mode, poses, source, still};
use clangor_core::body::{BodyId, Motion};
use clangor_core::contact::{ForceProfile, StreamPoint, StreamSettings, StreamedForce, force_stream};
use clangor_core::glam::DVec3;
use clangor_core::material::Damping;
use clangor_core::medium::Medium;
use clangor_core::pose::{Keyframe, Pose, Track};
use clangor_core::synthesis::modal::{ModalPressure, ModalSettings, ModalVoice, Resonance, ResonatorBank};
use clangor_core::synthesis::{Listener, RenderSettings, SampleRate};
use clangor_core::timeline::{ContactKind, ContactRow};
use num_complex::Complex64;

const STEP: f64 = 2.5e-4;
const PLACE: DVec3 = DVec3::new(0.03, 0.02, 0.0);

fn undamped_by_air() -> ModalSettings {
    ModalSettings { radiation_damping: false, ..ModalSettings::default() }
}

/// Impulses of a force along z, one per step.
fn stream(force: impl Fn(f64) -> f64, seconds: f64) -> Vec<StreamedForce> {
    (0..(seconds / STEP) as usize)
        .map(|i| {
            let time = (i as f64 + 0.37) * STEP;
            let impulse = DVec3::Z * (STEP * force(time));
            let points = vec![StreamPoint { place: PLACE, impulse, normal: DVec3::Z }];
            StreamedForce { time, body: BodyId(0), points }
        })
        .collect()
}

fn streamed(
    modes: Vec<clangor_core::sound_model::modal::model::ModalMode>,
    forces: &[StreamedForce],
    count: usize,
) -> Vec<f64> {
    let source = source(modes, &Damping::T60(0.03), &undamped_by_air());
    let (poses, listener) = (still(), Listener::fixed("microphone", DVec3::new(0.0, 0.0, 1.0)));
    let mut voice =
        ModalVoice::new(source, BodyId(0), &poses, &listener, &RenderSettings::default()).unwrap();
    voice.push_stream(forces, STEP).unwrap();
    let mut channels = vec![vec![0.0; count]];
    voice.render_block(0, &mut channels).unwrap();
    channels.swap_remove(0)
}

#[test]
fn a_streamed_force_shakes_a_mode_as_a_steady_one_does() {
    let (frequency, shaken) = (1000.0, 700.0);
    let coefficient = Complex64::new(0.6, -0.8);
    let heard = streamed(
        vec![mode(frequency, 2.0 * DVec3::Z, vec![coefficient])],
        &stream(|t| 3.0 * (TAU * shaken * t).cos(), 0.3),
        12_000,
    );
    let decay = 3.0 * 10f64.ln() / 0.03;
    let pole = Complex64::new(-decay, ((TAU * frequency).powi(2) - decay * decay).sqrt());
    let transfer = Medium::AIR.density * RADIUS * (0.25 / std::f64::consts::PI).sqrt() * coefficient * RADIUS;
    let scale = Complex64::new(0.0, -1.0) * pole / pole.im;
    let mut error: f64 = 0.0;
    let mut level: f64 = 0.0;
    for (k, pressure) in heard.iter().enumerate().skip(8000) {
        let time = k as f64 / 48_000.0 - 1.0 / Medium::AIR.sound_speed;
        // A = c ẇ, where w follows both halves of the cosine.
        let velocity: Complex64 = [shaken, -shaken]
            .map(|f| {
                let s = Complex64::new(0.0, TAU * f);
                3.0 * s * (s * time).exp() / (s - pole)
            })
            .iter()
            .sum();
        let exact = (transfer * scale * velocity).re;
        error = error.max((pressure - exact).abs());
        level = level.max(exact.abs());
    }
    // Residual seen: 4e-5.
    assert!(error < 2e-4 * level, "{:e}", error / level);
}

#[test]
fn no_sound_above_half_the_rate_of_the_steps() {
    // Images of a force at 1 kHz lie at 3 and 5 kHz, where there are modes.
    let tone = stream(|t| (TAU * 1000.0 * t).cos(), 0.3);
    let loudest = |frequency: f64| {
        let heard = streamed(vec![mode(frequency, DVec3::Z, vec![Complex64::ONE])], &tone, 12_000);
        heard[6000..].iter().fold(0.0f64, |m, p| m.max(p.abs()))
    };
    // Without a resonance the feed-through of the force is left, Ω²/(ω² − Ω²) of it: 1/8 and 1/24.
    let (low, high) = (loudest(3000.0), loudest(5000.0));
    let expected = Medium::AIR.density * RADIUS * RADIUS * (0.25 / std::f64::consts::PI).sqrt();
    for (loudest, part) in [(low, 1.0 / 8.0), (high, 1.0 / 24.0)] {
        // Residual seen: 1.2e-4.
        assert!((loudest / (expected * part) - 1.0).abs() < 1e-3, "{loudest:e} {:e}", expected * part);
    }
}

/// A row of a contact of body 0 with the world, at `time` [s], with a normal impulse [N s].
fn row(time: f64, impulse_n: f64) -> ContactRow {
    ContactRow {
        time,
        body_a: BodyId(0),
        body_b: BodyId::WORLD,
        kind: ContactKind::Contact,
        point: DVec3::ZERO,
        normal: DVec3::Y,
        impulse_n,
        impulse_t: DVec3::ZERO,
        couple: DVec3::ZERO,
        velocity: DVec3::ZERO,
        depth: 0.0,
        impact_id: 0,
        effective_mass: None,
    }
}

#[test]
fn a_load_leaves_no_force_and_a_body_at_rest_no_sound() {
    let settings = StreamSettings { v_min: 0.05, time_step: STEP, rest_speed: 1e-3 };
    let key = |time: f64| Keyframe { time, pose: Pose::at(DVec3::X * 0.5 * time) };
    let moving =
        poses(Motion::Keyframed(Track::try_new((-1..8).map(|i| key(0.1 * f64::from(i))).collect()).unwrap()));
    let resting = poses(Motion::Free);
    // Half a second of weight, with a bump in the middle.
    let bump = |i: usize| if i == 1000 { 1.0 } else { 0.0 };
    let mut rows: Vec<ContactRow> =
        (0..2000).map(|i| row(i as f64 * STEP, STEP * (9.81 + bump(i)))).collect();
    // An impact is not part of the stream; an impact slower than v_min is.
    let impact = |time: f64, speed: f64, id: u64| ContactRow {
        kind: ContactKind::Impact,
        velocity: -speed * DVec3::Y,
        impact_id: id,
        ..row(time, 1.0)
    };
    rows.extend([impact(0.3, 0.2, 1), impact(0.400_01, 0.01, 2)]);
    let bodies = [body(Motion::Free)];
    let forces = force_stream(&bodies, &rows, &moving, &settings).unwrap();
    assert_eq!(forces.len(), 2001);
    assert!(forces.windows(2).all(|pair| pair[0].time <= pair[1].time));
    let impulse = |i: usize| forces[i].points[0].impulse.y;
    // Far from the bump and from the ends the load is removed. Residual seen: 5e-3, a step more or less in 50
    // ms.
    assert!((0..2000).filter(|i| (200..800).contains(i)).all(|i| impulse(i).abs() < 0.01 * 9.81 * STEP));
    assert!((impulse(1000) / STEP - 1.0).abs() < 0.1, "{}", impulse(1000) / STEP);
    assert!(impulse(1601) > 0.9);
    let quiet = force_stream(&bodies, &rows, &resting, &settings).unwrap();
    assert!(quiet.iter().flat_map(|force| &force.points).all(|point| point.impulse == DVec3::ZERO));
    let nan = [ContactRow { impulse_n: f64::NAN, ..rows[0] }];
    assert!(force_stream(&bodies, &nan, &moving, &settings).is_err());
}

#[test]
fn a_contact_damps_what_it_touches() {
    let frequency = 2000.0;
    let damping = 40.0;
    let settings = ModalSettings { contact_damping: damping, ..undamped_by_air() };
    let source =
        source(vec![mode(frequency, 0.5 * DVec3::Z, vec![Complex64::ONE])], &Damping::T60(2.0), &settings);
    let (poses, listener) = (still(), Listener::fixed("microphone", DVec3::new(0.0, 0.0, 1.0)));
    let mut voice =
        ModalVoice::new(source, BodyId(0), &poses, &listener, &RenderSettings::default()).unwrap();
    voice.push_pulses(&[impact(0.01, 50e-6, Pose::IDENTITY)]).unwrap();
    voice.push_stream(&stream(|_| 0.0, 1.0)[400..], STEP).unwrap();
    let mut channels = vec![vec![0.0; 24_000]];
    voice.render_block(0, &mut channels).unwrap();
    let level = |at: usize| channels[0][at..at + 240].iter().map(|p| p * p).sum::<f64>().ln() * 0.5;
    let rate = |from: usize, to: usize| (level(from) - level(to)) / ((to - from) as f64 / 48_000.0);
    let own = 3.0 * 10f64.ln() / 2.0;
    // Free until 0.1 s, then ½ c (n·U)² more. Residual seen: 7e-8.
    assert!((rate(1200, 3600) / own - 1.0).abs() < 1e-6, "{}", rate(1200, 3600));
    let touched = own + 0.5 * damping * 0.25;
    assert!((rate(6000, 20_400) / touched - 1.0).abs() < 1e-6, "{} {touched}", rate(6000, 20_400));
}

#[test]
fn rendering_does_not_allocate() {
    let resonances: Vec<Resonance> =
        (1..100).map(|i| Resonance { frequency: 150.0 * f64::from(i), damping_ratio: 1e-4 }).collect();
    let transfers = vec![Complex64::ONE; resonances.len()];
    let rate = SampleRate::HZ_48000;
    let mut bank = ResonatorBank::new(&resonances, 2, rate, 21_600.0, ModalPressure::Acceleration);
    bank.add_pulse(&ForceProfile::HalfSine.into(), 90.0, 5e-5, &vec![1.0; resonances.len()]);
    let mut outputs: Vec<Vec<f64>> = (0..2).map(|_| Vec::with_capacity(10_000)).collect();
    // The vector instructions of the machine are looked up once.
    bank.render(64, &mut outputs);
    let counted = allocation_counter::measure(|| {
        for _ in 0..40 {
            (0..2).for_each(|path| bank.set_transfers(path, &transfers));
            bank.render(192, &mut outputs);
        }
    });
    assert_eq!(counted.count_total, 0);
    assert!(outputs[0].iter().any(|p| *p != 0.0));

    // A voice in the air, once its memory has grown.
    let value = |i: usize| Complex64::cis(i as f64);
    let source = source(
        vec![mode(900.0, DVec3::Z, (0..64).map(value).collect())],
        &Damping::T60(5.0),
        &undamped_by_air(),
    );
    let key = |time: f64| Keyframe { time, pose: Pose::at(DVec3::X * time) };
    let poses =
        poses(Motion::Keyframed(Track::try_new((-1..9).map(|i| key(f64::from(i))).collect()).unwrap()));
    let listener = Listener::fixed("microphone", DVec3::new(0.0, 1.0, 1.0));
    let mut voice =
        ModalVoice::new(source, BodyId(0), &poses, &listener, &RenderSettings::default()).unwrap();
    voice.push_pulses(&[impact(0.01, 5e-5, Pose::IDENTITY)]).unwrap();
    let mut channels = vec![vec![0.0; 512]];
    (0..100).for_each(|i| voice.render_block(512 * i, &mut channels).unwrap());
    let counted = allocation_counter::measure(|| {
        (100..200).for_each(|i| voice.render_block(512 * i, &mut channels).unwrap());
    });
    assert_eq!(counted.count_total, 0);
    assert!(channels[0].iter().any(|p| *p != 0.0));
}
