//! A ball falls in avian3d, and its click is heard when it lands, as loud as the contact says.

use std::time::Duration;

use avian3d::prelude::*;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use clangor_bevy::{ClangorPlugin, EAR_DISTANCE, Ears, Ground, Sound, Sounding};
use clangor_core::body::BodyId;
use clangor_core::contact::ForceProfile;
use clangor_core::contact::hertz::HertzContact;
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::material::presets;
use clangor_core::realtime::EngineSettings;
use clangor_core::synthesis::{
    AccelerationPulse, Listener, OverlapAdd, RenderSettings, Renderer, SoundSource,
};

const STEP: f64 = 1.0 / 240.0;
const RATE: f64 = 48_000.0;
const RADIUS: f32 = 0.02;
const RESTITUTION: f32 = 0.8;
/// Of the centre above the floor at the beginning.
const HEIGHT: f32 = 0.5;
const EARS: Vec3 = Vec3::new(0.0, 0.4, 1.0);

fn world() -> (App, clangor_core::realtime::Engine) {
    let (plugin, engine) = ClangorPlugin::new(&EngineSettings::default()).unwrap();
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, PhysicsPlugins::default(), plugin));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(STEP)));
    app.insert_resource(Time::<Fixed>::from_seconds(STEP));
    app.world_mut().spawn((Ears, Transform::from_translation(EARS)));
    // A slab of which avian3d knows a mass, 4 g.
    let slab = (Collider::cuboid(0.2, 0.1, 0.2), Transform::from_xyz(0.0, -0.05, 0.0));
    let granite = Ground(presets::GRANITE.material());
    app.world_mut().spawn((RigidBody::Static, slab, Restitution::new(RESTITUTION), granite));
    app.world_mut().spawn((
        RigidBody::Dynamic,
        Collider::sphere(RADIUS),
        ColliderDensity(7850.0),
        Restitution::new(RESTITUTION),
        Sounding::ball(f64::from(RADIUS), presets::STEEL.material()),
        Transform::from_xyz(0.0, HEIGHT, 0.0),
    ));
    app.finish();
    app.cleanup();
    (app, engine)
}

#[test]
fn a_ball_is_heard_when_it_lands() {
    let (mut app, mut engine) = world();
    let mut heard = Vec::new();
    for step in 1..=240 {
        app.update();
        while (heard.len() as f64) < f64::from(step) * STEP * RATE {
            heard.extend_from_slice(&engine.render(100)[0]);
        }
    }
    assert!(app.world().resource::<Sound>().impacts >= 2, "it bounces");
    let peak = heard.iter().fold(0.0, |m: f64, p| m.max(p.abs()));
    let onset = heard.iter().position(|p| p.abs() > 0.1 * peak).unwrap() as f64 / RATE;
    // It falls freely, and the sound comes by air.
    let fall = (2.0 * f64::from(HEIGHT - RADIUS) / 9.81).sqrt();
    let left = EARS - Vec3::new(0.5 * EAR_DISTANCE as f32, 0.0, 0.0);
    let landed = Vec3::new(0.0, RADIUS, 0.0);
    let arrival = fall + f64::from(left.distance(landed)) / 343.2 + engine.latency();
    // The physics knows the time to a step: residual seen 3.8 ms, of 4.2 ms.
    assert!((onset - arrival).abs() < 2.0 * STEP, "{onset} {arrival}");
    let exact = offline(left, fall, landed);
    // The fall is as exact as steps are: residual seen 1.5e-3.
    assert!((peak / exact - 1.0).abs() < 0.02, "{peak} {exact}");
}

/// Peak pressure [Pa] of the first bounce as the offline renderer has it, of the velocities of a free fall.
fn offline(ear: Vec3, fall: f64, centre: Vec3) -> f64 {
    let exact = |v: Vec3| DVec3::from_array(v.to_array().map(f64::from));
    let (steel, granite) = (presets::STEEL.material(), presets::GRANITE.material());
    let (radius, speed) = (f64::from(RADIUS), 9.81 * fall);
    let mass = 7850.0 * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let contact = HertzContact {
        inverse_mass: 1.0 / mass,
        relative_radii: [radius; 2],
        compliance: steel.contact_compliance() + granite.contact_compliance(),
        speed,
    };
    let click = AccelerationPulse {
        body: BodyId(0),
        time: 0.01,
        duration: contact.duration(),
        shape: ForceProfile::Hertz.into(),
        centre: exact(centre),
        orientation: DQuat::IDENTITY,
        velocity_change: DVec3::Y * (1.0 + f64::from(RESTITUTION)) * speed,
        angular_velocity_change: DVec3::ZERO,
        source: SoundSource::Sphere { radius },
    };
    let mut renderer =
        Renderer::new(&Listener::fixed("ear", exact(ear)), &RenderSettings::default()).unwrap();
    renderer.push(&click).unwrap();
    let mut signal = OverlapAdd::new(1, 0);
    renderer.take_all().iter().for_each(|job| signal.add(&job.render()));
    signal.take_until(4800)[0].iter().fold(0.0, |m: f64, p| m.max(p.abs()))
}
