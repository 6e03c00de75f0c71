//! Piles of live worlds: energy, momentum, overlap and rest in steps of time, and one bounce against the
//! exact solver.

use std::collections::BTreeMap;

use crate::sphere_worlds::live::{deepest_overlap, marbles_in_a_box};
use crate::sphere_worlds::{G, material, plane, sphere, world};
use clangor_core::body::{BodyId, Motion, Surface, World};
use clangor_core::timeline::{ContactKind, ContactRow};
use clangor_sim::Solver;
use clangor_sim::live::{BodyState, LiveSettings, LiveWorld};
use glam::DVec3;

fn stepped() -> LiveSettings {
    LiveSettings { solver: Solver::Rigid, ..LiveSettings::default() }
}

fn go(live: &mut LiveWorld, until: f64) {
    while !live.advance(until, 10_000).unwrap() {}
}

#[test]
fn a_pile_loses_energy_until_it_sleeps() {
    let radius = 0.01;
    let world = marbles_in_a_box(120, radius, &material(0.7, 0.3, 2e-4));
    let mut live = LiveWorld::new(&world, LiveSettings::default()).unwrap();
    let (start, mut last) = (live.energy(), f64::INFINITY);
    let (mut growth, mut deepest) = (0.0_f64, 0.0_f64);
    for k in 1..=400 {
        go(&mut live, 0.005 * f64::from(k));
        growth = growth.max((live.energy() - last) / start);
        deepest = deepest.max(deepest_overlap(&live) / radius);
        last = live.energy();
    }
    assert_eq!(live.solver(), Solver::Rigid);
    println!("largest growth {growth:.1e} of the energy, deepest overlap {deepest:.1e} of a radius");
    // Overlap is corrected without adding speed. Residual seen: 1e-6.
    assert!(growth < 1e-5);
    // Residual seen: 8e-3, while it falls together.
    assert!(deepest < 0.03);
    let rest = deepest_overlap(&live) / radius;
    println!("at rest {rest:.1e}");
    assert!(rest < 2e-3);
    let still = live.states().iter().filter(|state| state.velocity == DVec3::ZERO).count();
    assert_eq!(still, live.count());
}

/// Largest residual of the momentum of a ball over 20 ms, relative to the impulses on it, and the same for
/// spin.
fn ledger(world: &World, end: f64) -> (f64, f64) {
    let mut live = LiveWorld::new(world, LiveSettings { log: true, ..stepped() }).unwrap();
    let mut moments: Vec<(f64, Vec<BodyState>)> = vec![(0.0, live.states())];
    for k in 1..=(50.0 * end) as u32 {
        go(&mut live, 0.02 * f64::from(k));
        moments.push((live.time(), live.states()));
    }
    let rows = live.take_log();
    assert!(rows.iter().any(|row| row.kind == ContactKind::Contact));
    let (mut linear, mut angular) = (0.0_f64, 0.0_f64);
    // The impacts of the last half millisecond are still open.
    for pair in moments[..moments.len() - 1].windows(2) {
        let [(from, before), (to, after)] = pair else { continue };
        let mut sums: BTreeMap<BodyId, (DVec3, DVec3, f64)> = BTreeMap::new();
        // Impacts have their own instants, which may be the start of a step; all other rows have the end of
        // their step.
        let within = |row: &&ContactRow| match row.kind {
            ContactKind::Impact => row.time >= *from && row.time < *to,
            _ => row.time > *from && row.time <= *to,
        };
        for row in rows.iter().filter(within) {
            for (id, sign) in [(row.body_a, 1.0), (row.body_b, -1.0)] {
                let Some(body) = world.bodies.get(id.index()) else { continue };
                let Surface::Sphere { radius } = *body.surface else { continue };
                let (impulse, arm) = (row.impulse() * sign, row.normal * (-sign * radius));
                let held = matches!(row.kind, ContactKind::Sleep | ContactKind::Constraint);
                let arm = if held { DVec3::ZERO } else { arm };
                let sum = sums.entry(id).or_default();
                sum.0 += impulse;
                sum.1 += arm.cross(impulse) + row.couple * sign;
                sum.2 += impulse.length();
            }
        }
        for (k, body) in world.bodies.iter().enumerate().filter(|(_, body)| body.motion == Motion::Free) {
            let Surface::Sphere { radius } = *body.surface else { continue };
            let (sum, torque, size) = sums.get(&BodyId(k as u32)).copied().unwrap_or_default();
            let weight = world.gravity * (body.mass * (to - from));
            let size = size + weight.length();
            let change = (after[k].velocity - before[k].velocity) * body.mass;
            let spin = (after[k].angular_velocity - before[k].angular_velocity) * body.inertia.x_axis.x;
            linear = linear.max((change - weight - sum).length() / size);
            angular = angular.max((spin - torque).length() / (size * radius));
        }
    }
    (linear, angular)
}

#[test]
fn every_ball_of_a_pile_balances() {
    let world = marbles_in_a_box(60, 0.01, &material(0.6, 0.3, 2e-4));
    let (linear, angular) = ledger(&world, 0.4);
    println!("momentum {linear:.1e}, angular momentum {angular:.1e}");
    // Residuals seen: 1e-15.
    assert!(linear < 1e-12 && angular < 1e-12);
}

/// Speeds and times of the impacts until `end` \[s\], and the last states.
fn impacts(world: &World, solver: Solver, end: f64) -> (Vec<(f64, f64)>, Vec<BodyState>) {
    let mut live = LiveWorld::new(world, LiveSettings { solver, ..LiveSettings::default() }).unwrap();
    go(&mut live, end);
    (live.impacts().iter().map(|pulse| (pulse.time, pulse.speed)).collect(), live.states())
}

#[test]
fn flying_balls_collide_as_in_the_exact_solver() {
    let glass = material(0.8, 0.3, 0.0);
    let mut spinning = sphere(0.012, DVec3::new(0.0, 0.3, 0.0), DVec3::new(0.4, 0.5, 0.1), &glass);
    spinning.angular_velocity = DVec3::new(20.0, -5.0, 60.0);
    let bodies = vec![
        spinning,
        sphere(0.02, DVec3::new(0.15, 0.12, 0.03), DVec3::new(-0.1, 0.8, 0.0), &glass),
        plane(DVec3::ZERO, DVec3::Y, &glass),
        plane(DVec3::X * -0.1, DVec3::new(1.0, 0.2, 0.0), &glass),
    ];
    let world = world(bodies, Vec::new(), G);
    let end = 0.6;
    let ((exact, last), (steps, stepped_last)) =
        (impacts(&world, Solver::Spheres, end), impacts(&world, Solver::Rigid, end));
    println!("{} impacts", exact.len());
    assert!(exact.len() > 4 && exact.len() == steps.len());
    let mut worst = 0.0_f64;
    for ((time, speed), (stepped_time, stepped_speed)) in exact.iter().zip(&steps) {
        worst = worst.max((time - stepped_time).abs()).max((speed - stepped_speed).abs());
    }
    // The stepped world is up to one step further.
    let beyond = (last[0].pose.position - stepped_last[0].pose.position).length();
    println!("times and speeds differ by {worst:.1e}, places by {beyond:.1e}");
    // Residual seen: 1e-13.
    assert!(worst < 1e-11 && beyond < 0.01);
}

#[test]
fn a_sliding_ball_comes_to_roll() {
    let wood = material(0.5, 0.3, 0.0);
    let radius = 0.02;
    let bodies =
        vec![sphere(radius, DVec3::Y * radius, DVec3::X, &wood), plane(DVec3::ZERO, DVec3::Y, &wood)];
    let world = world(bodies, Vec::new(), G);
    let (_, last) = impacts(&world, Solver::Rigid, 0.5);
    let speed = last[0].velocity.x;
    println!("{speed}");
    // It rolls at 5/7 of its speed. Residual seen: 1e-15.
    assert!((speed - 5.0 / 7.0).abs() < 1e-9);
    assert!((last[0].angular_velocity.z + speed / radius).abs() < 1e-6);
}

#[test]
fn the_cut_of_time_does_not_matter() {
    let world = marbles_in_a_box(40, 0.01, &material(0.7, 0.3, 2e-4));
    let play = |advances: u32, most: u64| {
        let mut live = LiveWorld::new(&world, LiveSettings::default()).unwrap();
        let mut seen = Vec::new();
        for k in 1..=advances {
            while !live.advance(0.5 * f64::from(k) / f64::from(advances), most).unwrap() {}
            seen.extend(live.impacts().iter().map(|pulse| (pulse.time, pulse.onset, pulse.speed)));
            live.clear();
        }
        seen.retain(|(time, ..)| *time < 0.49);
        seen
    };
    let whole = play(1, u64::MAX);
    assert!(whole.len() > 100);
    let pieces = play(50, 300);
    assert_eq!(whole.len(), pieces.len());
    for (one, other) in whole.iter().zip(&pieces) {
        assert_eq!(one, other);
    }
}
