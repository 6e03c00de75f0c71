//! The ears are where their entity is in the world: under a parent that moves and turns, and in frames
//! without a step of the physics.

use std::f32::consts::FRAC_PI_2;
use std::time::Duration;

use avian3d::prelude::*;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use clangor_bevy::{ClangorPlugin, Ears, Sound};
use clangor_core::glam::DVec3;
use clangor_core::pose::Pose;
use clangor_core::realtime::{Engine, EngineSettings, ImpactEvent, ImpactTarget, engine};

/// Of a frame: far below the step of the physics.
const FRAME: Duration = Duration::from_millis(1);
const STEP: Duration = Duration::from_secs(3600);
/// The ears in the frame of their parent [m].
const LOCAL: Vec3 = Vec3::new(0.1, 0.2, -0.4);
/// Compared [samples]: 43 ms, in which sound comes 14 m far.
const SAMPLES: usize = 2048;

/// An impact on a ball at the origin.
fn impact() -> ImpactEvent {
    ImpactEvent {
        target: ImpactTarget::Sphere { radius: 0.02 },
        time: 0.005,
        duration: 1e-4,
        force: None,
        pose: Pose::at(DVec3::ZERO),
        velocity_change: DVec3::new(0.3, 1.0, -0.5),
        angular_velocity_change: DVec3::ZERO,
        point: DVec3::ZERO,
        impulse: DVec3::ZERO,
    }
}

/// Both channels of an engine.
fn rendered(engine: &mut Engine) -> [Vec<f64>; 2] {
    let channels = engine.render(SAMPLES);
    [channels[0].to_vec(), channels[1].to_vec()]
}

/// The impact at ears with this centre and this unit vector to the right, by an engine without Bevy.
fn at(centre: DVec3, right: DVec3) -> [Vec<f64>; 2] {
    let (mut controller, mut engine) = engine(&EngineSettings::default()).unwrap();
    controller.place_listener(centre, right).unwrap();
    controller.send(impact()).unwrap();
    rendered(&mut engine)
}

/// Largest difference, over the largest pressure.
fn apart(heard: &[Vec<f64>; 2], exact: &[Vec<f64>; 2]) -> f64 {
    let peak = exact.iter().flatten().fold(0.0, |most: f64, p| most.max(p.abs()));
    let pairs = heard.iter().flatten().zip(exact.iter().flatten());
    pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) / peak
}

#[test]
fn ears_under_a_moving_parent_are_where_the_world_shows_them() {
    let (plugin, mut engine) = ClangorPlugin::new(&EngineSettings::default()).unwrap();
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, PhysicsPlugins::default(), plugin));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(FRAME));
    app.insert_resource(Time::<Fixed>::from_duration(STEP));
    let parent = app.world_mut().spawn(Transform::default()).id();
    app.world_mut().spawn((Ears, Transform::from_translation(LOCAL), ChildOf(parent)));
    app.finish();
    app.cleanup();
    app.update();
    // A quarter turn to the left: the local x axis becomes −z of the world, the local −z axis −x.
    let moved = Transform::from_xyz(2.0, 0.5, 1.0).with_rotation(Quat::from_rotation_y(FRAC_PI_2));
    app.world_mut().entity_mut(parent).insert(moved);
    app.update();
    assert_eq!(app.world().resource::<Time<Physics>>().elapsed(), Duration::ZERO, "no step of the physics");

    let mut sound = app.world_mut().resource_mut::<Sound>();
    sound.controller().send(impact()).unwrap();
    let heard = rendered(&mut engine);
    let exact = at(DVec3::new(1.6, 0.7, 0.9), -DVec3::Z);
    // Transforms of Bevy have single precision.
    let residual = apart(&heard, &exact);
    assert!(residual < 1e-4, "{residual:e}");
    let unmoved = apart(&heard, &at(DVec3::new(0.1, 0.2, -0.4), DVec3::X));
    assert!(unmoved > 0.5, "the local place sounds otherwise: {unmoved}");
}
