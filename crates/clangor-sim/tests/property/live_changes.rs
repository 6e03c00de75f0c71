//! Changes of live worlds by whoever plays with them: thrown, added, removed, turned upside down, and
//! nonsense.

use crate::sphere_worlds::live::{deepest_overlap, marbles_in_a_box};
use crate::sphere_worlds::{G, material, plane, sphere, world};
use clangor_core::body::{BodyId, Link};
use clangor_sim::Solver;
use clangor_sim::live::{LiveError, LiveSettings, LiveWorld};
use glam::DVec3;

fn go(live: &mut LiveWorld, until: f64) {
    while !live.advance(until, 10_000).unwrap() {}
}

#[test]
fn a_resting_ball_is_thrown_again_and_again() {
    let steel = material(0.5, 0.2, 1e-4);
    let bodies =
        vec![sphere(0.01, DVec3::Y * 0.01, DVec3::ZERO, &steel), plane(DVec3::ZERO, DVec3::Y, &steel)];
    let world = world(bodies, Vec::new(), G);
    for solver in [Solver::Spheres, Solver::Rigid] {
        let mut live = LiveWorld::new(&world, LiveSettings { solver, ..LiveSettings::default() }).unwrap();
        for k in 0..5 {
            go(&mut live, f64::from(k));
            live.set_velocity(BodyId(0), DVec3::Y * 1.5).unwrap();
            go(&mut live, f64::from(k) + 0.05);
            assert!(live.states()[0].pose.position.y > 0.05);
        }
        go(&mut live, 5.0);
        assert!((live.states()[0].pose.position.y - 0.01).abs() < 1e-5);
        assert_eq!(live.solver(), solver);
        // The first landing after each throw is as fast as the throw.
        let landings = live.impacts().iter().filter(|pulse| (pulse.speed - 1.5).abs() < 0.02).count();
        assert_eq!(landings, 5, "{solver:?}");
    }
}

#[test]
fn balls_come_and_go_and_gravity_turns() {
    let glass = material(0.7, 0.3, 2e-4);
    for weightless in [false, true] {
        let mut world = marbles_in_a_box(30, 0.01, &glass);
        if weightless {
            world.gravity = DVec3::ZERO;
        }
        let mut live = LiveWorld::new(&world, LiveSettings::default()).unwrap();
        assert_eq!(live.solver() == Solver::Spheres, weightless);
        for k in 0..40_u32 {
            go(&mut live, 0.02 * f64::from(k));
            let x = 0.06 * (f64::from(k % 5) / 4.0 - 0.5);
            live.add(&glass, 0.006, DVec3::new(x, 0.3, 0.01), DVec3::NEG_Y).unwrap();
            if k % 4 == 0 {
                live.remove(BodyId(k / 4)).unwrap();
            }
            if k == 20 {
                live.set_gravity(DVec3::new(3.0, -5.0, 0.0)).unwrap();
            }
        }
        go(&mut live, 1.0);
        let deepest = deepest_overlap(&live);
        println!("deepest overlap {deepest:.1e} m");
        // Residual seen: 5e-5.
        assert!(deepest < 3e-4);
        let there = (0..live.count() as u32).filter(|id| live.body(BodyId(*id)).is_some()).count();
        assert_eq!(there, 30 + 5 + 40 - 10);
    }
}

#[test]
fn a_throw_on_a_rod_keeps_to_it_and_a_removed_ball_takes_its_rod_along() {
    let steel = material(0.9, 0.2, 1e-4);
    let bodies =
        vec![sphere(0.01, DVec3::ZERO, DVec3::ZERO, &steel), sphere(0.01, DVec3::X, DVec3::ZERO, &steel)];
    let hang = |body: u32| Link::Hang { body: BodyId(body), anchor: DVec3::new(f64::from(body), 0.3, 0.0) };
    let world = world(bodies, vec![hang(0), hang(1)], G);
    let mut live = LiveWorld::new(&world, LiveSettings::default()).unwrap();
    live.set_velocity(BodyId(0), DVec3::new(1.0, 5.0, 0.0)).unwrap();
    go(&mut live, 0.2);
    let length = live.states()[0].pose.position.distance(DVec3::Y * 0.3);
    assert!((length - 0.3).abs() < 1e-12);
    live.remove(BodyId(0)).unwrap();
    assert_eq!(live.links().len(), 1);
    go(&mut live, 0.4);
}

#[test]
fn nonsense_is_refused_and_changes_nothing() {
    let glass = material(0.7, 0.3, 2e-4);
    let mut live = LiveWorld::new(&marbles_in_a_box(20, 0.01, &glass), LiveSettings::default()).unwrap();
    go(&mut live, 0.1);
    let before = live.states();
    for time in [f64::NAN, -1.0, 1e9, f64::INFINITY] {
        assert!(matches!(live.advance(time, 100), Err(LiveError::BadNumber { .. })));
    }
    let far = DVec3::new(0.0, 5.0, 0.0);
    for bad in [f64::NAN, f64::INFINITY, 1e30] {
        assert!(live.set_velocity(BodyId(0), DVec3::splat(bad)).is_err());
        assert!(live.set_gravity(DVec3::splat(bad)).is_err());
        assert!(live.add(&glass, bad, far, DVec3::ZERO).is_err());
        assert!(live.add(&glass, 0.01, DVec3::splat(bad), DVec3::ZERO).is_err());
        assert!(live.add(&glass, 0.01, far, DVec3::splat(bad)).is_err());
    }
    assert!(live.add(&glass, 0.0, far, DVec3::ZERO).is_err());
    assert!(live.add(&glass, -1.0, far, DVec3::ZERO).is_err());
    let taken = before[3].pose.position;
    assert!(matches!(live.add(&glass, 0.01, taken, DVec3::ZERO), Err(LiveError::Overlap { .. })));
    assert!(matches!(live.remove(BodyId(99)), Err(LiveError::UnknownBody { body: 99 })));
    assert!(matches!(live.remove(BodyId(20)), Err(LiveError::NotFree { .. })));
    assert!(live.set_velocity(BodyId(u32::MAX), DVec3::ZERO).is_err());
    assert_eq!(live.states(), before);
}

#[test]
fn what_the_exact_solver_cannot_follow_is_stepped() {
    // Few balls, so that they start in the exact solver, and inelastic, so that they come to rest on each
    // other at once.
    let clay = material(0.3, 0.3, 2e-4);
    let mut bodies: Vec<_> = (0..8)
        .map(|k| {
            let at =
                DVec3::new(1e-3 * f64::from(k % 3), 0.011 + 0.0205 * f64::from(k), 5e-4 * f64::from(k % 2));
            sphere(0.01, at, DVec3::ZERO, &clay)
        })
        .collect();
    bodies.push(plane(DVec3::ZERO, DVec3::Y, &clay));
    for normal in [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z] {
        bodies.push(plane(normal * -0.013, normal, &clay));
    }
    let world = world(bodies, Vec::new(), G);
    let mut live =
        LiveWorld::new(&world, LiveSettings { exact_events: 5000.0, ..LiveSettings::default() }).unwrap();
    assert_eq!(live.solver(), Solver::Spheres);
    go(&mut live, 3.0);
    assert_eq!(live.solver(), Solver::Rigid);
    assert!(deepest_overlap(&live) < 3e-4);
}

#[test]
fn a_budget_bounds_an_advance() {
    let glass = material(0.7, 0.3, 2e-4);
    let mut live = LiveWorld::new(&marbles_in_a_box(50, 0.01, &glass), LiveSettings::default()).unwrap();
    assert!(!live.advance(50.0, 10).unwrap());
    assert!(live.time() < 0.1);
}

#[test]
fn a_hundred_thousand_changes_take_no_time_of_the_world() {
    let glass = material(0.7, 0.3, 2e-4);
    let mut live = LiveWorld::new(&marbles_in_a_box(5, 0.01, &glass), LiveSettings::default()).unwrap();
    for k in 0..100_000_u32 {
        let id = live.add(&glass, 0.01, DVec3::Y * 5.0, DVec3::ZERO).unwrap();
        live.set_velocity(BodyId(k % 5), DVec3::X).unwrap();
        live.remove(id).unwrap();
    }
    assert_eq!(live.count(), 5 + 5 + 1);
    go(&mut live, 0.5);
}

#[test]
fn a_crystal_of_touching_balls_is_stepped() {
    let glass = material(0.9, 0.2, 0.0);
    let radius = 0.01;
    let mut bodies: Vec<_> = (0..512_u32)
        .map(|k| {
            let at = DVec3::new(f64::from(k % 8), f64::from(k / 8 % 8), f64::from(k / 64)) * (2.0 * radius);
            sphere(radius, at, DVec3::ZERO, &glass)
        })
        .collect();
    bodies.push(sphere(radius, DVec3::new(-0.1, 0.03, 0.03), DVec3::X * 5.0, &glass));
    let mut live = LiveWorld::new(&world(bodies, Vec::new(), 0.0), LiveSettings::default()).unwrap();
    let energy = live.energy();
    go(&mut live, 0.1);
    assert_eq!(live.solver(), Solver::Rigid);
    assert!(live.energy() <= energy * (1.0 + 1e-12) && !live.impacts().is_empty());
}

#[test]
fn a_mob_of_fast_balls_stays_within_its_budget() {
    let glass = material(0.95, 0.2, 0.0);
    let mut live = LiveWorld::new(&marbles_in_a_box(300, 0.01, &glass), LiveSettings::default()).unwrap();
    for k in 0..300_u32 {
        let towards = DVec3::new(f64::from(k % 7) - 3.0, f64::from(k % 5) - 2.0, f64::from(k % 3) - 1.0);
        live.set_velocity(BodyId(k), towards.normalize_or(DVec3::X) * 199.0).unwrap();
    }
    for _ in 0..20 {
        live.advance(1.0, 2000).unwrap();
    }
    assert!(live.time() > 0.0 && deepest_overlap(&live) < 0.01);
}
