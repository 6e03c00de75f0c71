//! Every solver takes the same restitution at the same speed: a ball on a plane, by the event-driven solver,
//! alone and in a cluster, the time-stepped one, and both of a live world.

mod sphere_worlds;

use clangor_core::body::{BodyId, World};
use clangor_core::material::{Material, PairCoefficients, presets};
use clangor_sim::live::{LiveSettings, LiveWorld};
use clangor_sim::{ContactModel, SimulationSettings, Solver};
use glam::DVec3;
use sphere_worlds::{plane, run, settings, sphere, world};

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
            // Residual seen 1e-15.
            assert!((bounce - known).abs() < 1e-12, "{solver:?} {contact:?} {speed}: {bounce} of {known}");
        }
        for solver in [Solver::Spheres, Solver::Rigid] {
            let mut live =
                LiveWorld::new(&world, LiveSettings { solver, ..LiveSettings::default() }).unwrap();
            while !live.advance(0.02, 1000).unwrap() {}
            let bounce = live.states()[0].velocity.y / speed;
            // Residual seen 1e-15.
            assert!((bounce - known).abs() < 1e-12, "live {solver:?} {speed}: {bounce} of {known}");
        }
    }
}

/// Two balls that touch, hit by a third: the contact is solved through its time with the damping of e(V).
#[test]
fn clusters_lose_more_in_harder_impacts() {
    let kept = |speed: f64| {
        let steel = yielding();
        let at = |x: f64, v: f64| sphere(0.01, DVec3::X * x, DVec3::X * v, &steel);
        let row = world(vec![at(0.0, speed), at(0.021, 0.0), at(0.041, 0.0)], Vec::new(), 0.0);
        let contact = ContactModel::Compliant;
        let settings = SimulationSettings { contact, ..settings(0.05, false, 1e3) };
        let (timeline, _) = run(&row, &settings).unwrap();
        let last = timeline.poses.iter().filter(|pose| pose.body == BodyId(2)).next_back().unwrap();
        last.velocity.x / speed
    };
    // The last ball gets ((1 + e)/2)² of the speed from separate impacts; measured within 0.01 of that.
    for speed in SPEEDS {
        let steel = yielding();
        let restitution = PairCoefficients::of(&steel, &steel).restitution.at(speed);
        let separate = (0.5 * (1.0 + restitution)).powi(2);
        println!("{speed} m/s: {:.4}, separate {separate:.4}", kept(speed));
        assert!((kept(speed) - separate).abs() < 0.06, "{speed}: {} of {separate}", kept(speed));
    }
    assert!(kept(8.0) < kept(2.0) && kept(2.0) < kept(0.5) && kept(0.5) < kept(0.1));
}
