//! Invariants of the sound of the ground for any material and place.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;

use clangor_core::body::BodyId;
use clangor_core::contact::{ContactSettings, PoseHistory, impact_pulses};
use clangor_core::glam::DVec3;
use clangor_core::material::Material;
use clangor_core::material::presets::preset;
use clangor_core::medium::Medium;
use clangor_core::scene::instantiate::load_shape;
use clangor_core::scene::{Scene, instantiate};
use clangor_core::synthesis::ground::{GroundError, GroundSource, ground_clicks};
use clangor_core::synthesis::{Listener, OverlapAdd, RenderSettings, Renderer, SoundSource};
use clangor_core::timeline::{ContactKind, ContactRow};
use num_complex::Complex64;

fn ground(name: &str) -> Arc<GroundSource> {
    Arc::new(GroundSource::try_new(&preset(name).unwrap(), &Medium::AIR).unwrap())
}

#[test]
fn sound_changes_smoothly_with_the_direction_through_every_critical_angle() {
    for name in ["granite", "soil", "rubber", "wood", "plastic"] {
        let ground = ground(name);
        let place = |i: u32| {
            let theta = f64::from(i) * 1e-3;
            DVec3::new(theta.sin(), theta.cos(), 0.0)
        };
        let omega = [TAU * 200.0, TAU * 3000.0];
        let all: Vec<_> = (0..1570).map(|i| ground.transfer(place(i), &omega)).collect();
        for k in 0..2 {
            let largest = all.iter().map(|p| p[k].norm()).fold(0.0, f64::max);
            assert!(largest.is_finite() && largest > 0.0);
            // x = 55: a wave along the ground turns by at most 0.055 (n sin θ) per step.
            let turn = 1e-3 * omega[k] / 343.2 * ground.solid.shear_square.sqrt().max(1.0);
            let curve = |w: &[Vec<Complex64>]| (w[0][k] - 2.0 * w[1][k] + w[2][k]).norm();
            let worst = all.windows(3).map(curve).fold(0.0, f64::max);
            // A jump of 3e-3, the error of the sum, is allowed; residual seen below.
            let allowed = (turn * turn + 3e-3) * 2.0 * largest;
            println!("{name} {k}: {:.1e} of {:.1e}", worst / largest, allowed / largest);
            assert!(worst < allowed, "{name}, {} Hz: {}", omega[k] / TAU, worst / largest);
        }
    }
}

#[test]
fn no_pressure_before_the_first_wave_can_arrive() {
    for name in ["granite", "soil", "plastic"] {
        let ground = ground(name);
        let place = DVec3::new(1.5, 0.6, 0.0);
        let click = clangor_core::synthesis::AccelerationPulse {
            body: BodyId(0),
            time: 0.02,
            duration: 3e-4,
            shape: clangor_core::contact::ForceProfile::HalfSine.into(),
            centre: DVec3::ZERO,
            orientation: clangor_core::glam::DQuat::IDENTITY,
            velocity_change: DVec3::ZERO,
            angular_velocity_change: DVec3::ZERO,
            source: SoundSource::Ground { ground: Arc::clone(&ground).into(), impulse: 0.1 },
        };
        let mut renderer =
            Renderer::new(&Listener::fixed("listener", place), &RenderSettings::default()).unwrap();
        renderer.push(&click).unwrap();
        let mut signal = OverlapAdd::new(1, 0);
        renderer.take_all().iter().for_each(|job| signal.add(&job.render()));
        let sound = signal.take_until(4800).swap_remove(0);
        let distance = place.length();
        let (sin, cos) = (place.x / distance, place.y / distance);
        let fastest = 343.2 / ground.solid.pressure_speed();
        let first = if fastest < sin { (1.0 - fastest * fastest).sqrt() * cos + fastest * sin } else { 1.0 };
        // The band limit rings for 88 samples, and falls to a thousandth of its peak in 20.
        let until = ((0.02 + first * distance / 343.2) * 48_000.0) as usize - 20;
        let peak = |samples: &[f64]| samples.iter().fold(0.0, |m: f64, p| m.max(p.abs()));
        let early = peak(&sound[..until]) / peak(&sound);
        println!("{name}: {early:.1e} before the first wave");
        assert!(early < 3e-3, "{name}: {early:e}");
        let force: f64 = sound.iter().sum::<f64>() / sound.iter().map(|p| p.abs()).sum::<f64>();
        assert!(force.abs() < 2e-2, "{name}: pressure leaves no impulse behind, but {force:e}");
    }
}

#[test]
fn ground_is_pressed_by_what_falls_on_it() {
    let text = "version = 1\n[[body]]\nname = \"ball\"\nshape = \"sphere:0.01\"\nmaterial = \"steel\"\n\
                position = [0, 0.01, 0]\n[[plane]]\nname = \"floor\"\nmaterial = \"soil\"";
    let scene = Scene::from_toml(text).unwrap();
    let world = instantiate(&scene, &mut load_shape).unwrap().world;
    let plane = BodyId(1);
    let grounds = BTreeMap::from([(plane, ground("soil").into())]);
    let row = ContactRow {
        time: 0.3,
        impact_id: 1,
        kind: ContactKind::Impact,
        body_a: BodyId(0),
        body_b: plane,
        point: DVec3::new(0.0, 1e-5, 0.0),
        normal: DVec3::Y,
        impulse_n: 0.07,
        velocity: DVec3::new(0.3, -2.0, 0.0),
        impulse_t: DVec3::X * 0.01,
        couple: DVec3::ZERO,
        depth: 0.0,
        effective_mass: None,
    };
    // The same seen from the plane.
    let reversed =
        ContactRow { body_a: plane, body_b: BodyId(0), normal: -DVec3::Y, velocity: -row.velocity, ..row };
    for row in [row, reversed] {
        let poses = PoseHistory::try_new(&world.bodies, &[]).unwrap();
        let settings = ContactSettings::default();
        let (pulses, _) = impact_pulses(&world.bodies, &[row], &poses, &settings).unwrap();
        let clicks = ground_clicks(&pulses[0], &world.bodies, &grounds);
        assert_eq!(clicks.len(), 1);
        let SoundSource::Ground { impulse, .. } = clicks[0].source else { panic!("a ground") };
        assert!((impulse - 0.07).abs() < 1e-15 && clicks[0].centre.y.abs() < 1e-15);
        assert_eq!((clicks[0].body, clicks[0].time), (plane, 0.3));
        // A listener below gets no pressure.
        assert!(clicks[0].source.silent_at(DVec3::new(0.3, -0.1, 0.0)));
        assert!(ground_clicks(&pulses[0], &world.bodies, &BTreeMap::new()).is_empty());
    }
}

#[test]
fn what_is_no_solid_is_refused() {
    let soil = preset("soil").unwrap();
    for material in [
        Material { poisson_ratio: 0.5, ..soil.clone() },
        Material { density: f64::NAN, ..soil.clone() },
        Material { youngs_modulus: 0.0, ..soil.clone() },
    ] {
        let error = GroundSource::try_new(&material, &Medium::AIR).unwrap_err();
        assert!(matches!(error, GroundError::Material { .. }), "{error}");
    }
    let vacuum = Medium { density: 0.0, ..Medium::AIR };
    assert!(matches!(GroundSource::try_new(&soil, &vacuum), Err(GroundError::Medium { .. })));
}
