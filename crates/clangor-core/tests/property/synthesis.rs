//! Invariants of any clicks: linearity, symmetry, exact onsets, no aliasing, the floor, energy, the same
//! bits.

use std::f64::consts::TAU;

use clangor_core::body::BodyId;
use clangor_core::contact::ForceProfile;
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::pose::{Keyframe, Pose, Track};
use clangor_core::synthesis::listener::Floor;
use clangor_core::synthesis::{
    AccelerationPulse, BlockJob, Listener, OverlapAdd, RenderSettings, Renderer, SampleRate, SoundSource,
    SynthesisError,
};
use num_complex::Complex64;

const RADIUS: f64 = 0.0075;

fn sphere(radius: f64) -> SoundSource {
    SoundSource::Sphere { radius }
}

fn click() -> AccelerationPulse {
    AccelerationPulse {
        body: BodyId(0),
        time: 0.0123,
        duration: 50e-6,
        shape: ForceProfile::HalfSine.into(),
        centre: DVec3::new(0.1, 0.2, -0.1),
        orientation: DQuat::IDENTITY,
        velocity_change: DVec3::new(0.3, -1.0, 0.2),
        angular_velocity_change: DVec3::ZERO,
        source: sphere(RADIUS),
    }
}

fn microphone() -> Listener {
    Listener::fixed("microphone", DVec3::new(0.4, 0.5, 0.2))
}

fn settings(rate: u32, floor: Floor) -> RenderSettings {
    RenderSettings::default().with_sample_rate(SampleRate::try_new(rate).unwrap()).with_floor(floor)
}

/// All receivers' samples from t = 0 on.
fn render_channels(
    clicks: &[AccelerationPulse],
    listener: &Listener,
    settings: &RenderSettings,
    samples: i64,
) -> Vec<Vec<f64>> {
    let mut renderer = Renderer::new(listener, settings).unwrap();
    clicks.iter().for_each(|click| renderer.push(click).unwrap());
    let mut signal = OverlapAdd::new(listener.receivers.len(), 0);
    renderer.take_all().iter().for_each(|job| signal.add(&job.render()));
    signal.take_until(samples)
}

fn render(clicks: &[AccelerationPulse], settings: &RenderSettings) -> Vec<f64> {
    let samples = (0.03 * settings.sample_rate.as_f64()) as i64;
    render_channels(clicks, &microphone(), settings, samples).swap_remove(0)
}

/// ∫ p e^{−iωt} dt of samples from t = 0 on.
fn spectrum_at(samples: &[f64], rate: f64, frequency: f64) -> Complex64 {
    let turn = |i: usize| Complex64::from_polar(1.0 / rate, -TAU * frequency * i as f64 / rate);
    samples.iter().enumerate().map(|(i, p)| p * turn(i)).sum()
}

/// Largest difference over the largest value of `b`.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    let largest = b.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
}

/// Largest difference of two spectra from 100 Hz to a frequency [Hz], over the largest value.
fn spectral_difference(to: f64, a: impl Fn(f64) -> Complex64, b: impl Fn(f64) -> Complex64) -> f64 {
    let frequencies = (0..80).map(|j| 100.0 + (to - 100.0) * f64::from(j) / 79.0);
    let pairs: Vec<_> = frequencies.map(|f| (a(f), b(f))).collect();
    let largest = pairs.iter().map(|(_, b)| b.norm()).fold(0.0, f64::max);
    pairs.iter().map(|(a, b)| (a - b).norm()).fold(0.0, f64::max) / largest
}

#[test]
fn onset_between_samples_is_a_pure_delay() {
    let settings = settings(48_000, Floor::None);
    let on_time = render(&[click()], &settings);
    for fraction in [0.13, 0.5, 0.77] {
        let shift = fraction / 48_000.0;
        let late = render(&[AccelerationPulse { time: click().time + shift, ..click() }], &settings);
        let error = spectral_difference(
            24_000.0,
            |f| spectrum_at(&late, 48_000.0, f),
            |f| spectrum_at(&on_time, 48_000.0, f) * Complex64::from_polar(1.0, -TAU * f * shift),
        );
        // Residual seen: 5e-11.
        assert!(error < 1e-9, "{fraction}: {error:e}");
    }
}

#[test]
fn low_rate_is_the_high_rate_without_what_it_cannot_carry() {
    // Short and small: most of its energy is above 24 kHz and would alias.
    let click = AccelerationPulse { duration: 8e-6, source: sphere(0.002), ..click() };
    let low = render(std::slice::from_ref(&click), &settings(48_000, Floor::None));
    let high = render(&[click], &settings(192_000, Floor::None));
    let error = spectral_difference(
        20_000.0,
        |f| spectrum_at(&low, 48_000.0, f),
        |f| spectrum_at(&high, 192_000.0, f),
    );
    // Residual seen: 1.7e-9, the reach of the band limit at both rates; bar 1e-4.
    assert!(error < 1e-8, "{error:e}");
    // Nothing remains above the band of the low rate.
    let above = |f| spectrum_at(&low, 48_000.0, f).norm() / spectrum_at(&high, 192_000.0, f).norm();
    for frequency in [23_300.0, 23_700.0, 24_000.0] {
        // Seen: 1.7e-9.
        assert!(above(frequency) < 1e-8, "{frequency} Hz: {:e}", above(frequency));
    }
}

#[test]
fn highest_frequency_cuts_the_rest_and_leaves_what_is_below() {
    let full = settings(48_000, Floor::None);
    let cut = full.with_max_frequency(Some(8_000.0));
    let (full, cut) = (render(&[click()], &full), render(&[click()], &cut));
    let error =
        spectral_difference(8_000.0, |f| spectrum_at(&cut, 48_000.0, f), |f| spectrum_at(&full, 48_000.0, f));
    // Residual seen: 2.8e-9.
    assert!(error < 1e-8, "{error:e}");
    let left = |f| spectrum_at(&cut, 48_000.0, f).norm() / spectrum_at(&full, 48_000.0, f).norm();
    // The transition is 1/15 of the rate wide: 3.2 kHz. Seen: 6e-11.
    assert!(left(11_300.0) < 1e-8, "{:e}", left(11_300.0));
}

#[test]
fn sound_is_linear() {
    let settings = settings(48_000, Floor::Rigid { height: 0.0 });
    let other =
        AccelerationPulse { time: 0.0131, source: sphere(0.02), velocity_change: DVec3::X, ..click() };
    let scaled = AccelerationPulse { velocity_change: 3.0 * click().velocity_change, ..click() };
    let together = render(&[scaled, other.clone()], &settings);
    let (one, two) = (render(&[click()], &settings), render(&[other], &settings));
    let sum: Vec<f64> = one.iter().zip(&two).map(|(a, b)| 3.0 * a + b).collect();
    // Residual seen: 1e-15.
    assert!(difference(&together, &sum) < 1e-13);
}

#[test]
fn turning_and_mirroring_everything_changes_nothing() {
    let settings = settings(48_000, Floor::None);
    let position = microphone().receiver_position(0, 0.0);
    let before = render(&[click()], &settings);
    let turn = DQuat::from_scaled_axis(DVec3::new(0.3, -1.1, 0.7));
    let mirror = DVec3::new(-1.0, 1.0, 1.0);
    let changes: [&dyn Fn(DVec3) -> DVec3; 2] = [&|v| turn * v, &|v| mirror * v];
    for change in changes {
        let click = click();
        let moved = AccelerationPulse {
            centre: change(click.centre),
            velocity_change: change(click.velocity_change),
            ..click
        };
        let listener = Listener::fixed("microphone", change(position));
        let after = render_channels(&[moved], &listener, &settings, before.len() as i64).swap_remove(0);
        // Residual seen: 3e-12, the rounding of the distance times the slope of the sound.
        assert!(difference(&after, &before) < 1e-10);
    }
}

#[test]
fn sound_doubles_on_a_rigid_floor() {
    let settings = settings(48_000, Floor::Rigid { height: 0.5 });
    let source = AccelerationPulse { centre: DVec3::new(0.1, 0.7, -0.1), ..click() };
    let free = render(std::slice::from_ref(&source), &settings.with_floor(Floor::None));
    let doubled: Vec<f64> = free.iter().map(|p| 2.0 * p).collect();
    // The microphone lies on the floor, where both waves arrive together. Residual seen: 0.
    assert!(difference(&render(&[source], &settings), &doubled) < 1e-14);
}

#[test]
fn floor_adds_the_sound_of_the_mirrored_source() {
    // Near the floor the waves overlap and share a block; far from it they do not.
    for (height, expected_joint) in [(0.19, true), (-1.5, false)] {
        let settings = settings(48_000, Floor::Rigid { height });
        let click = click();
        let image = AccelerationPulse {
            centre: DVec3 { y: 2.0 * height - click.centre.y, ..click.centre },
            velocity_change: DVec3 { y: -click.velocity_change.y, ..click.velocity_change },
            ..click.clone()
        };
        let free = settings.with_floor(Floor::None);
        let both = render(&[click.clone(), image], &free);
        // Residual seen: 2e-10, the part of a click that its block cuts off.
        assert!(difference(&render(std::slice::from_ref(&click), &settings), &both) < 1e-9, "{height}");

        let mut renderer = Renderer::new(&microphone(), &settings).unwrap();
        renderer.push(&click).unwrap();
        let clicks: usize = renderer.take_all().iter().map(|job| job.render().energies.len()).sum();
        assert_eq!(clicks == 1, expected_joint);
    }
}

#[test]
fn energies_are_those_of_the_samples() {
    for (duration, floor) in
        [(50e-6, Floor::None), (50e-6, Floor::Rigid { height: 0.19 }), (2e-3, Floor::None)]
    {
        let settings = settings(48_000, floor);
        let mut renderer = Renderer::new(&microphone(), &settings).unwrap();
        renderer.push(&AccelerationPulse { duration, body: BodyId(5), ..click() }).unwrap();
        let mut signal = OverlapAdd::new(1, 0);
        renderer.take_all().iter().for_each(|job| signal.add(&job.render()));
        let samples = signal.take_until(1440).swap_remove(0);
        let sum: f64 = samples.iter().map(|p| p * p / 48_000.0).sum();
        // Residual seen: 2e-14.
        assert!((signal.energies()[&BodyId(5)] / sum - 1.0).abs() < 1e-12);
    }
}

#[test]
fn samples_do_not_depend_on_segments_or_on_who_renders_which_block() {
    let settings = settings(48_000, Floor::Rigid { height: -0.3 });
    let listener = Listener::spaced_pair("pair", Track::fixed(Pose::at(DVec3::new(0.4, 0.5, 0.2))), 0.17);
    let clicks: Vec<AccelerationPulse> = (0..3000)
        .map(|i| AccelerationPulse {
            time: f64::from(i) * 2e-3,
            source: sphere([0.004, 0.0075, 0.05, 0.3][i as usize % 4]),
            centre: DVec3::new(0.01 * f64::from(i % 37), 0.9, 1.0),
            duration: 30e-6 + 1e-6 * f64::from(i % 50),
            ..click()
        })
        .collect();
    let samples = (6.2 * 48_000.0) as i64;
    let whole = render_channels(&clicks, &listener, &settings, samples);

    for segment in [0.01, 0.7, 2.9] {
        let mut renderer = Renderer::new(&listener, &settings).unwrap();
        let mut signal = OverlapAdd::new(2, 0);
        let mut streamed = vec![Vec::new(); 2];
        let mut add = |jobs: Vec<BlockJob>, until: i64| {
            // As if threads finished in reverse.
            let mut blocks: Vec<_> = jobs.iter().rev().map(BlockJob::render).collect();
            blocks.reverse();
            blocks.iter().for_each(|block| signal.add(block));
            for (channel, taken) in streamed.iter_mut().zip(signal.take_until(until)) {
                channel.extend(taken);
            }
        };
        let mut next = segment;
        for click in &clicks {
            while click.time >= next {
                let jobs = renderer.take_ready(next);
                add(jobs, renderer.complete_until().min(samples));
                next += segment;
            }
            renderer.push(click).unwrap();
        }
        let jobs = renderer.take_all();
        add(jobs, samples);
        assert!(streamed == whole, "segments of {segment} s");
    }
}

#[test]
fn moving_listener_receives_at_its_place_at_the_arrival() {
    let key = |time, x| Keyframe { time, pose: Pose::at(DVec3::new(x, 0.5, 0.2)) };
    let track = Track::try_new(vec![key(0.0, 30.0), key(1.0, 0.0)]).unwrap();
    let listener = Listener::mono("walker", track);
    let settings = settings(48_000, Floor::None);
    let moving = render_channels(&[click()], &listener, &settings, 9600).swap_remove(0);
    // The sound takes about 0.09 s, in which the listener has come closer.
    let mut arrival = click().time;
    for _ in 0..100 {
        let distance = (listener.receiver_position(0, arrival) - click().centre).length();
        arrival = click().time + (distance - RADIUS) / 343.2;
    }
    let there = Listener::fixed("there", listener.receiver_position(0, arrival));
    let fixed = render_channels(&[click()], &there, &settings, 9600).swap_remove(0);
    // Residual seen: 5e-12.
    assert!(difference(&moving, &fixed) < 1e-10);
    assert!(arrival - click().time > 0.08);
}

#[test]
fn gaussian_carries_the_same_impulse() {
    let settings = settings(48_000, Floor::None);
    let half_sine = render(&[click()], &settings);
    let gaussian =
        render(&[AccelerationPulse { shape: ForceProfile::Gaussian.into(), ..click() }], &settings);
    let at = |samples: &[f64]| spectrum_at(samples, 48_000.0, 20.0);
    // Both spectra are flat at 20 Hz. Residual seen: 1e-6, the second moments (ωτ)² differ.
    assert!((at(&gaussian) - at(&half_sine)).norm() < 1e-5 * at(&half_sine).norm());
    assert!(difference(&gaussian, &half_sine) > 1e-3);
}

#[test]
fn receiver_inside_the_sphere_is_counted_and_silent() {
    let listener = Listener::fixed("inside", click().centre + DVec3::X * 0.005);
    let mut renderer = Renderer::new(&listener, &settings(48_000, Floor::None)).unwrap();
    renderer.push(&click()).unwrap();
    assert_eq!(renderer.take_all().len(), 0);
    assert_eq!(renderer.report().receiver_inside, 1);
    assert_eq!(renderer.report().first_inside, Some((0, BodyId(0), click().time)));
}

#[test]
fn body_below_the_floor_is_counted_and_silent() {
    let mut renderer = Renderer::new(&microphone(), &settings(48_000, Floor::Rigid { height: 0.3 })).unwrap();
    renderer.push(&click()).unwrap();
    assert_eq!(renderer.take_all().len(), 0);
    assert_eq!(renderer.report().below_floor, 1);
}

#[test]
fn clicks_that_end_before_the_start_are_not_rendered() {
    let full = settings(48_000, Floor::None);
    let late = RenderSettings { start: 1.0, ..full };
    let mut renderer = Renderer::new(&microphone(), &late).unwrap();
    renderer.push(&click()).unwrap();
    assert_eq!(renderer.take_all().len(), 0);
    // A sound that overlaps the start keeps its end.
    let across = RenderSettings { start: 662.0 / 48_000.0, ..full };
    let (whole, end) = (render(&[click()], &full), render(&[click()], &across));
    // Residual seen: 1.3e-10.
    let error = difference(&end, &whole[662..]);
    assert!(error < 1e-9, "{error:e}");
}

#[test]
fn bad_input_is_an_error() {
    let free = settings(48_000, Floor::None);
    let push = |click: AccelerationPulse| Renderer::new(&microphone(), &free).unwrap().push(&click);
    for bad in [
        AccelerationPulse { time: f64::NAN, ..click() },
        AccelerationPulse { duration: 0.0, ..click() },
        AccelerationPulse { source: sphere(f64::INFINITY), ..click() },
        AccelerationPulse { velocity_change: DVec3::new(0.0, f64::INFINITY, 0.0), ..click() },
    ] {
        assert!(matches!(push(bad.clone()), Err(SynthesisError::BadPulse { .. })), "{bad:?}");
    }
    assert!(matches!(
        push(AccelerationPulse { duration: 1e3, ..click() }),
        Err(SynthesisError::TooLong { .. })
    ));

    let below = settings(48_000, Floor::Rigid { height: 0.6 });
    assert!(matches!(Renderer::new(&microphone(), &below), Err(SynthesisError::BelowFloor { y: 0.5, .. })));
    let deaf = Listener { receivers: Vec::new(), ..microphone() };
    assert!(matches!(Renderer::new(&deaf, &free), Err(SynthesisError::NoReceivers { .. })));
    assert!(SampleRate::try_new(7_999).is_err() && SampleRate::try_new(384_001).is_err());

    let mut renderer = Renderer::new(&microphone(), &free).unwrap();
    renderer.push(&click()).unwrap();
    renderer.take_ready(10.0);
    assert!(matches!(renderer.push(&click()), Err(SynthesisError::Late { .. })));
}
