//! A body in the real-time engine against the same impact rendered offline.

use std::ops::ControlFlow;

use clangor_core::acoustics::Acoustics;
use clangor_core::glam::DVec3;
use clangor_core::material::presets;
use clangor_core::pose::Pose;
use clangor_core::realtime::{EngineSettings, Event, ImpactEvent, engine};
use clangor_core::synthesis::strike::{LEAD, StrikeForce, Striker};
use clangor_pipeline::session::{LiveBody, Meeting, Partner, Strike, StruckBody};
use clangor_pipeline::stages::sound_models::ModelOptions;
use clangor_pipeline::stages::sound_models::quality::Quality;

const BAND: f64 = 8e3;
const RATE: f64 = 48e3;
const EAR: DVec3 = DVec3::new(0.5, 0.3, 0.4);
/// Time of the impact \[s\].
const TIME: f64 = 0.05;

fn settings() -> EngineSettings {
    let acoustics = Acoustics { max_frequency: Some(BAND), ..Acoustics::default() };
    EngineSettings { acoustics, receivers: 1, ..EngineSettings::default() }
}

fn bar(cache: &tempfile::TempDir) -> Strike {
    let options =
        ModelOptions { quality: Quality::Draft, max_frequency: Some(BAND), ..ModelOptions::default() };
    let bar = StruckBody::shape("box:0.2x0.03x0.008", "brass").unwrap();
    Strike::new(bar).models(options).cache(cache.path()).listener(EAR).seconds(0.1)
}

fn live(strike: Strike) -> LiveBody {
    strike.live_body(&settings(), &mut |_| ControlFlow::Continue(())).unwrap()
}

/// The pressure at the ear of events on the body in slot 0, aligned with a sound that begins [`LEAD`] before
/// the impact.
fn played(body: &LiveBody, events: Vec<ImpactEvent>, count: usize) -> Vec<f64> {
    let (mut controller, mut engine) = engine(&settings()).unwrap();
    controller.put(0, Some(body.object(&settings()))).unwrap();
    controller.send(Event::Receivers([EAR; 2])).unwrap();
    for event in events {
        controller.send(ImpactEvent { time: TIME + event.time, ..event }).unwrap();
    }
    let start = ((TIME + engine.latency() - LEAD) * RATE).round() as usize;
    let mut sound = Vec::new();
    while sound.len() < start + count {
        sound.extend_from_slice(&engine.render(128)[0]);
    }
    let report = controller.report();
    assert_eq!([report.late, report.refused, report.lost], [0; 3]);
    sound[start..start + count].to_vec()
}

/// Largest difference over the peak of the first.
fn apart(one: &[f64], other: &[f64]) -> f64 {
    let largest = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, f64::max);
    largest(&mut one.iter().zip(other).map(|(a, b)| a - b)) / largest(&mut one.iter().copied())
}

#[test]
fn the_engine_plays_what_a_strike_renders() {
    let cache = tempfile::tempdir().unwrap();
    let impulse = DVec3::new(0.001, -0.002, 0.003);
    let ball = Striker { heard: false, ..Striker::new(presets::STEEL.material(), 0.006, 1.0) };
    let offline =
        [bar(&cache).impulse(impulse).render().unwrap(), bar(&cache).striker(ball.clone()).render().unwrap()];
    let body = live(bar(&cache));
    assert!(body.modes() > 3, "{}", body.modes());
    let forces = [StrikeForce::Impulse { impulse, duration: None }, StrikeForce::Striker(ball)];
    for (sound, force) in offline.iter().zip(forces) {
        let events = body.strike(0, force, None, &Pose::IDENTITY).unwrap();
        let error = apart(&sound.pressures, &played(&body, events, sound.pressures.len()));
        println!("{error:.1e}");
        // Residual seen: 3.4e-5, of the delays of the engine.
        assert!(error < 1e-3, "{error:.1e}");
    }
}

#[test]
fn a_meeting_with_the_ground_is_louder_than_with_a_softer_one() {
    let cache = tempfile::tempdir().unwrap();
    let body = live(bar(&cache));
    let meeting = Meeting { point: DVec3::new(0.09, -0.015, 0.0), normal: DVec3::Y, speed: 1.0 };
    let [stone, wood] = [presets::GRANITE, presets::WOOD].map(|preset| {
        let material = preset.material();
        let events = body.meet((0, Pose::IDENTITY), Partner::Ground(&material), &meeting).unwrap();
        // The impulse stops the point: (1 + e) m_eff v, upwards.
        let impulse: f64 = events.iter().map(|event| event.impulse.y).sum();
        assert!(impulse > 0.0);
        let sound = played(&body, events, 4800);
        sound.iter().map(|p| p.abs()).fold(0.0, f64::max)
    });
    println!("{stone:.2} and {wood:.2} Pa");
    assert!(stone > wood && wood > 0.0, "{stone} {wood}");
}
