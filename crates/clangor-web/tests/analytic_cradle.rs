//! Newton's cradle through the interface of the page: its period against the elliptic integral, its clicks
//! against the offline run.

use std::f64::consts::PI;

use clangor_core::contact::{ContactSettings, PoseHistory, impact_pulses};
use clangor_core::scene::instantiate::load_shape;
use clangor_core::scene::{Scene, instantiate};
use clangor_core::timeline::Timeline;
use clangor_sim::record::RecordSettings;
use clangor_sim::{ContactModel, SimulationSettings, Solver, simulate};
use clangor_web::layout::CONTACT_STRIDE;
use clangor_web::wasm_buffer::{last_message, write};
use clangor_web::world::{with_events, world_advance, world_clear, world_load, world_solver, world_time};

const LENGTH: f64 = 0.15;
const G: f64 = 9.80665;
const RADIUS: f64 = 0.011;
/// Between neighbours at rest \[m\]. The impact crosses the gaps at the speed of the balls: the 10 µm of the
/// scene that ships would add 1.2e-3 to the period at 5 degrees.
const GAP: f64 = 1e-6;

/// Five hung balls of which the first is drawn aside by an angle [rad].
fn cradle(angle: f64) -> String {
    let pitch = 2.0 * RADIUS + GAP;
    let (x, y) = (-2.0 * pitch - LENGTH * angle.sin(), 0.25 - LENGTH * angle.cos());
    let hanging: Vec<String> = (-1..3).map(|k| format!("[{}, 0.1, 0.0]", f64::from(k) * pitch)).collect();
    format!(
        r#"
version = 1
[material.elastic]
base = "steel"
restitution = 1.0
[[body]]
name = "drawn"
shape = "sphere:{RADIUS}"
material = "elastic"
position = [{x}, {y}, 0.0]
[[body]]
name = "hanging"
shape = "sphere:{RADIUS}"
material = "elastic"
positions = [{}]
[[hang]]
body = "drawn"
anchor = [{}, 0.25, 0.0]
[[hang]]
body = "hanging"
offset = [0.0, 0.15, 0.0]
"#,
        hanging.join(", "),
        -2.0 * pitch
    )
}

/// Complete elliptic integral of the first kind of modulus k, by the arithmetic-geometric mean.
fn complete_elliptic(k: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - k * k).sqrt());
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    PI / (2.0 * a)
}

/// Impacts until `end` \[s\], fetched every 20 ms as a page does.
fn play(scene: &str, end: f64) -> Vec<[f64; CONTACT_STRIDE]> {
    assert_eq!(world_load(write(scene.as_bytes())), 0, "{}", last_message());
    let mut impacts = Vec::new();
    for k in 1..=(50.0 * end).round() as u32 {
        let until = f64::from(k) / 50.0;
        while world_time() < until {
            assert!(world_advance(until, 0.0) >= 0, "{}", last_message());
        }
        with_events(|_, contacts| {
            impacts.extend(contacts.as_chunks::<CONTACT_STRIDE>().0.iter().copied());
        });
        world_clear();
    }
    assert_eq!(world_solver(), 0);
    impacts
}

#[test]
fn the_period_is_that_of_the_elliptic_integral() {
    for degrees in [5.0_f64, 35.0] {
        let angle = degrees.to_radians();
        let impacts = play(&cradle(angle), 4.0);
        // The drawn ball is struck from its right when the impact comes back, once in a period.
        let struck: Vec<f64> =
            impacts.iter().filter(|c| c[1].min(c[2]) == 0.0 && c[3] > 0.1).map(|c| c[0]).collect();
        let period = 4.0 * (LENGTH / G).sqrt() * complete_elliptic((0.5 * angle).sin());
        let seen: Vec<f64> = struck.windows(3).step_by(2).map(|w| w[2] - w[0]).collect();
        assert!(seen.len() >= 3);
        for period_seen in seen {
            let error = (period_seen / period - 1.0).abs();
            println!("{degrees} degrees: {period_seen} s, error {error:.1e}");
            assert!(error < 1e-3);
        }
    }
}

#[test]
fn the_clicks_are_those_of_the_offline_run() {
    let text = include_str!("../../../scenes/newtons-cradle.toml");
    let end = 3.0;
    let scene = Scene::from_toml(text).unwrap();
    let world = instantiate(&scene, &mut load_shape).unwrap().world;
    let settings = SimulationSettings {
        solver: Solver::Auto,
        contact: ContactModel::Rigid,
        duration: end,
        time_step: 1e-3,
        record: RecordSettings::default(),
        sleep: true,
    };
    let mut timeline = Timeline::default();
    simulate(&world, &settings, &mut timeline, &mut |_| std::ops::ControlFlow::Continue(())).unwrap();
    let poses = PoseHistory::try_new(&world.bodies, &timeline.poses).unwrap();
    let (pulses, _) =
        impact_pulses(&world.bodies, &timeline.contacts, &poses, &ContactSettings::default()).unwrap();
    let pulses: Vec<_> = pulses.iter().filter(|pulse| pulse.time < end - 0.01).collect();

    let live = play(text, end);
    println!("{} clicks offline, {} live", pulses.len(), live.len());
    assert!(pulses.len() > 20 && live.len() >= pulses.len());
    let (mut time, mut speed) = (0.0_f64, 0.0_f64);
    for (pulse, seen) in pulses.iter().zip(&live) {
        let [a, b] = pulse.pair.map(|id| f64::from(id.0));
        assert_eq!([seen[1], seen[2]], [a, b]);
        time = time.max((seen[0] - pulse.onset).abs());
        speed = speed.max((seen[3] - pulse.speed).abs());
    }
    println!("{} clicks: times differ by {time:.1e} s, speeds by {speed:.1e} m/s", pulses.len());
    assert!(time < 1e-12 && speed < 1e-12);
}
