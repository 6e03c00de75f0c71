//! Clicks as they happen against the offline renderer, and what a real-time thread may not do.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::sphere_field::sphere_field;
use crate::sphere_near_field::sphere_near_field;
use clangor_core::acoustics::Acoustics;
use clangor_core::body::{BodyId, Surface};
use clangor_core::contact::ForceProfile;
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::propagation::{Air, PathLoss, PropagationPaths};
use clangor_core::sound_model::acceleration::field_evaluator::FieldEvaluator;
use clangor_core::synthesis::listener::Floor;
use clangor_core::synthesis::live_pulses::{LOOK_AHEAD, LiveField, LivePulses, LiveReport};
use clangor_core::synthesis::{
    AccelerationPulse, FieldSource, Listener, OverlapAdd, RenderSettings, Renderer, SoundSource,
};

const RATE: f64 = 48_000.0;
const BLOCK: usize = 128;
const FLOOR: Floor = Floor::Rigid { height: -0.6 };
const EARS: [DVec3; 2] = [DVec3::new(0.4, 0.5, 0.2), DVec3::new(0.57, 0.5, 0.25)];

fn field() -> Arc<FieldSource> {
    let radius = 0.02;
    let band = 0.484 * RATE * TAU * radius / 343.2;
    let field = sphere_field(0.3, DVec3::new(0.2, 0.1, -0.3), 8, band, 10 + (1.2 * band) as usize);
    let field = Arc::new(FieldEvaluator::try_new(&field).unwrap());
    let surface = Arc::new(Surface::Sphere { radius: 0.5 * radius });
    Arc::new(FieldSource::new(field, None, radius, DQuat::from_rotation_x(0.4), surface))
}

/// Clicks of spheres and of a field, in order of time, up to fifty in a block.
fn clicks(field: &SoundSource) -> Vec<AccelerationPulse> {
    let spread = |k: u32, step: f64| (f64::from(k) * step).fract() - 0.5;
    let click = |k: u32| AccelerationPulse {
        body: BodyId(k),
        time: 0.01 + 3e-4 * f64::from(k / 5) + 1e-6 * f64::from(k % 5),
        duration: 40e-6 + 1e-4 * spread(k, 0.37).abs(),
        shape: ForceProfile::HalfSine.into(),
        centre: DVec3::new(spread(k, 0.618), 0.5 + spread(k, 0.271), spread(k, 0.113) - 0.4),
        orientation: DQuat::from_rotation_y(f64::from(k)),
        velocity_change: DVec3::new(spread(k, 0.7), 1.0, spread(k, 0.9)),
        angular_velocity_change: DVec3::X * 20.0 * spread(k, 0.31),
        source: match k % 3 {
            0 => field.clone(),
            _ => SoundSource::Sphere { radius: 0.004 + 0.01 * spread(k, 0.57).abs() },
        },
    };
    (0..200).map(click).collect()
}

fn settings() -> RenderSettings {
    let acoustics = Acoustics { floor: FLOOR, air: Some(Air::default()), ..Acoustics::default() };
    RenderSettings::default().with_acoustics(acoustics)
}

fn paths() -> PropagationPaths {
    settings().acoustics.paths()
}

/// Silence, with a field in place that clicks may name.
fn live(field: &FieldSource) -> (LivePulses, SoundSource) {
    let settings = settings();
    let mut live = LivePulses::new(&settings, &paths(), 1, EARS.len(), 0.5).unwrap();
    let field = LiveField::new(field, &settings);
    let source = field.source();
    assert!(live.put_field(0, Some(field)).is_none());
    (live, source)
}

/// Adds a click as receivers hear it by all paths.
fn push(live: &mut LivePulses, paths: &PropagationPaths, click: &AccelerationPulse, receivers: &[DVec3]) {
    for (receiver, place) in receivers.iter().enumerate() {
        for path in 0..paths.count() {
            let Some(towards) = paths.towards(path, click.centre, *place) else { continue };
            if live.first_sample(click, towards).is_some() {
                live.play(click, towards, path, &[(receiver, 1.0)]);
            }
        }
    }
}

fn offline(clicks: &[AccelerationPulse], samples: usize) -> Vec<Vec<f64>> {
    let mut listener = Listener::fixed("ears", DVec3::ZERO);
    listener.receivers = EARS.to_vec();
    let mut renderer = Renderer::new(&listener, &settings()).unwrap();
    clicks.iter().for_each(|click| renderer.push(click).unwrap());
    let mut signal = OverlapAdd::new(2, 0);
    renderer.take_all().iter().for_each(|job| signal.add(&job.render()));
    signal.take_until(samples as i64)
}

#[test]
fn a_live_click_agrees_with_the_offline_click() {
    let (mut live, field) = live(&field());
    let (clicks, paths) = (clicks(&field), paths());
    let mut to_come = clicks.iter().peekable();
    let mut heard = [Vec::new(), Vec::new()];
    // A click is known in the block in which it begins, and heard as late as its sound needs to get here and
    // the look-ahead.
    while heard[0].len() < 4800 {
        let end = (heard[0].len() + BLOCK + LOOK_AHEAD) as f64 / RATE;
        while let Some(click) = to_come.next_if(|click| click.time < end) {
            push(&mut live, &paths, click, &EARS);
        }
        for (receiver, heard) in heard.iter_mut().enumerate() {
            let mut block = [0.0; BLOCK];
            live.take(receiver, &mut block);
            heard.extend(block);
        }
    }
    let offline = offline(&clicks, 4800);
    for (live, offline) in heard.iter().zip(&offline) {
        let peak = offline.iter().fold(0.0, |m: f64, p| m.max(p.abs()));
        let apart = live.iter().zip(offline).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Residual seen: 6e-8, what blocks of other lengths cut off.
        assert!(peak > 0.1 && apart < 1e-5 * peak, "{apart:e} of {peak:e}");
    }
    assert_eq!(live.report(), LiveReport { waves: 800, ..LiveReport::default() });
}

#[test]
fn live_clicks_allocate_nothing() {
    let (mut live, field) = live(&field());
    let (clicks, paths) = (clicks(&field), paths());
    let mut block = [0.0; BLOCK];
    let counted = allocation_counter::measure(|| {
        for click in &clicks {
            push(&mut live, &paths, click, &EARS);
            (0..2).for_each(|receiver| live.take(receiver, &mut block));
        }
    });
    assert_eq!(counted.count_total, 0, "{counted:?}");
}

#[test]
fn waves_left_out_are_counted() {
    let clicks = clicks(&SoundSource::Field(field()));
    let paths = PropagationPaths::direct(PathLoss::default());
    let mut live = LivePulses::new(&RenderSettings::default(), &paths, 1, 1, 0.1).unwrap();
    let sphere = &clicks[1];
    let push =
        |live: &mut LivePulses, click: &AccelerationPulse, place: DVec3| push(live, &paths, click, &[place]);
    push(&mut live, &AccelerationPulse { velocity_change: DVec3::NAN, ..sphere.clone() }, EARS[0]);
    push(&mut live, &clicks[0], EARS[0]);
    push(&mut live, sphere, sphere.centre);
    push(&mut live, sphere, sphere.centre + 400.0 * DVec3::X);
    live.take(0, &mut [0.0; 4800]);
    push(&mut live, sphere, EARS[0]);
    let wanted = LiveReport { waves: 1, late: 1, distant: 1, refused: 2, inside: 1 };
    assert_eq!(live.report(), wanted);
}

#[test]
fn a_receiver_in_the_bounding_sphere_gets_the_field_on_it() {
    let radius = 0.02;
    let exact = sphere_field(1.0, DVec3::ZERO, 1, 6.0, 16);
    let near = sphere_near_field(&exact, 16);
    let field = Arc::new(FieldEvaluator::try_new(&exact).unwrap());
    // A cup, say: most of the bounding sphere is air.
    let surface = Arc::new(Surface::Sphere { radius: 1e-4 * radius });
    let source = FieldSource::new(field, Some(Arc::new(near)), radius, DQuat::IDENTITY, surface);
    let settings = RenderSettings::default();
    let heard = |distance: f64| {
        let mut live =
            LivePulses::new(&settings, &PropagationPaths::direct(PathLoss::default()), 1, 1, 0.1).unwrap();
        let field = LiveField::new(&source, &settings);
        let click = AccelerationPulse { source: field.source(), ..clicks(&field.source())[1].clone() };
        live.put_field(0, Some(field));
        let towards = distance * radius * DVec3::new(0.48, 0.6, 0.64);
        assert!(live.first_sample(&click, towards).is_some());
        live.play(&click, towards, 0, &[(0, 1.0)]);
        let mut samples = vec![0.0; 4800];
        live.take(0, &mut samples);
        samples
    };
    let on_it = heard(1.0);
    assert!(on_it.iter().any(|p| *p != 0.0));
    for distance in [1e-3, 0.3, 0.99] {
        let inside = heard(distance);
        let apart = inside.iter().zip(&on_it).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // The same but for rounding of the place.
        assert!(apart < 1e-9 * on_it.iter().fold(0.0, |m: f64, p| m.max(p.abs())), "{distance}: {apart:e}");
    }
}
