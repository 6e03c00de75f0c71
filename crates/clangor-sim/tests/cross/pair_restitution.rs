//! Every solver takes the same restitution at the same speed: a ball on a plane, by the event-driven solver,
//! alone and in a cluster, the time-stepped one, and both of a live world.

use crate::sphere_worlds::{plane, run, settings, sphere, world};
use clangor_core::body::{BodyId, World};
use clangor_core::material::{Material, PairCoefficients, presets};
use clangor_sim::live::{LiveSettings, LiveWorld};
use clangor_sim::{ContactModel, SimulationSettings, Solver};
use glam::DVec3;

const SPEEDS: [f64; 4] = [0.1, 0.5, 2.0, 8.0];

/// A ball that loses by viscosity and by plastic flow.
fn yielding() -> Material {
    let steel = presets::STEEL.material();
    Material { yield_strength: Some(2.5e8), friction: 0.0, rolling_loss: 0.0, ..steel }
}

fn falling_ball(speed: f64) -> World {
    let (steel, ground) = (yielding(), Material { friction: 0.0, ..presets::GRANITE.material() });
    let ball = sphere(0.01, DVec3::Y * 0.0105, DVec3::NEG_Y * speed, &steel);
    world(vec![ball, plane(DVec3::ZERO, DVec3::Y, &ground)], Vec::new(), 0.0)
}

fn expected(speed: f64) -> f64 {
    let world = falling_ball(speed);
    PairCoefficients::of(&world.bodies[0].material, &world.bodies[1].material).restitution.at(speed)
}

#[test]
fn all_solvers_bounce_alike() {
    for speed in SPEEDS {
        let world = falling_ball(speed);
        let known = expected(speed);
        for (solver, contact) in [
            (Solver::Spheres, ContactModel::Rigid),
            (Solver::Spheres, ContactModel::Compliant),
            (Solver::Rigid, ContactModel::Rigid),
            (Solver::Rigid, ContactModel::Compliant),
        ] {
            let settings = SimulationSettings { solver, contact, ..settings(0.02, false, 1e3) };
            let (timeline, _) = run(&world, &settings).unwrap();
            let impulse: f64 = timeline.contacts.iter().map(|row| row.impulse_n).sum();
            let bounce = impulse / (world.bodies[0].mass * speed) - 1.0;
            // Rounding alone.
            assert!((bounce - known).abs() < 1e-12, "{solver:?} {contact:?} {speed}: {bounce} of {known}");
        }
        for solver in [Solver::Spheres, Solver::Rigid] {
            let mut live =
                LiveWorld::new(&world, LiveSettings { solver, ..LiveSettings::default() }).unwrap();
            while !live.advance(0.02, 1000).unwrap() {}
            let bounce = live.states()[0].velocity.y / speed;
            // Rounding alone.
            assert!((bounce - known).abs() < 1e-12, "live {solver:?} {speed}: {bounce} of {known}");
        }
    }
}

/// Two balls that touch, hit by a third: the contacts are solved through their time with the damping of e(V),
/// as those of a material whose restitution is e(V) at every speed.
#[test]
fn clusters_take_the_restitution_at_the_speed_of_their_impact() {
    let kept = |speed: f64, material: &Material| {
        let at = |x: f64, v: f64| sphere(0.01, DVec3::X * x, DVec3::X * v, material);
        let row = world(vec![at(0.0, speed), at(0.021, 0.0), at(0.041, 0.0)], Vec::new(), 0.0);
        let contact = ContactModel::Compliant;
        let settings = SimulationSettings { contact, ..settings(0.05, false, 1e3) };
        let (timeline, _) = run(&row, &settings).unwrap();
        timeline.poses.iter().rfind(|pose| pose.body == BodyId(2)).unwrap().velocity.x / speed
    };
    let mut last = 1.0;
    for speed in SPEEDS {
        let steel = yielding();
        let restitution = PairCoefficients::of(&steel, &steel).restitution.at(speed);
        let constant = Material { yield_strength: None, ..steel.clone().with_restitution(restitution) };
        let (own, known) = (kept(speed, &steel), kept(speed, &constant));
        println!("{speed} m/s: {own:.4}, {known:.4}, e = {restitution:.4}");
        // The same contacts and damping: rounding alone.
        assert!((own - known).abs() < 1e-9, "{speed}: {own} of {known}");
        assert!(own < last);
        last = own;
    }
}
