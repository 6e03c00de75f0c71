//! Steel balls fall on a granite floor for ten seconds: `cargo run --release --features playback --example
//! drop`.

use std::time::{Duration, Instant};

use avian3d::prelude::*;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use clangor_bevy::playback::{play, settings_for_device};
use clangor_bevy::{ClangorPlugin, Ears, Ground, Sounding};
use clangor_core::material::presets;
use clangor_core::realtime::EngineSettings;

const RADIUS: f32 = 0.02;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (plugin, engine) = ClangorPlugin::new(&settings_for_device(EngineSettings::default())?)?;
    let _stream = play(engine, 5.0)?;
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, PhysicsPlugins::default(), plugin));
    app.insert_resource(TimeUpdateStrategy::Automatic);
    app.add_systems(Startup, setup);
    app.finish();
    app.cleanup();
    let begin = Instant::now();
    while begin.elapsed() < Duration::from_secs(10) {
        app.update();
        std::thread::sleep(Duration::from_millis(4));
    }
    Ok(())
}

fn setup(mut commands: Commands) {
    commands.spawn((Ears, Transform::from_xyz(0.0, 0.5, 1.0)));
    let floor = Collider::half_space(Vec3::Y);
    let granite = Ground(presets::GRANITE.material());
    commands.spawn((RigidBody::Static, floor, Restitution::new(0.8), granite));
    for k in 0..20 {
        let place = Transform::from_xyz(0.1 * (k % 5) as f32, 0.3 + 0.2 * k as f32, 0.05 * (k % 3) as f32);
        commands.spawn((
            RigidBody::Dynamic,
            Collider::sphere(RADIUS),
            ColliderDensity(7850.0),
            Restitution::new(0.8),
            Sounding::ball(f64::from(RADIUS), presets::STEEL.material()),
            place,
        ));
    }
}
