//! The shipped scenes with joints, ropes, forces and hands: ends stay together, momentum is balanced by the
//! rows of the log, and energy grows only by what forces and hands give.

use std::path::Path;

use clangor_core::body::{BodyId, JointKind, Link, LinkEnd, World};
use clangor_core::glam::DVec3;
use clangor_core::scene::instantiate::load_shape;
use clangor_core::scene::{Scene, instantiate};
use clangor_core::timeline::ContactKind;
use clangor_sim::rigid::{Impulse, RigidWorld, StepLog};

/// The worst of a run.
#[derive(Debug, Default)]
struct Found {
    /// Distance of the ends of joints \[m\].
    drift: f64,
    /// Imbalance of momentum in a step, relative to the impulses.
    imbalance: f64,
    /// Largest growth of the energy in a step without forces and hands, in the largest kinetic energy.
    gain: f64,
    impacts: u32,
}

fn load(name: &str) -> (World, f64, f64) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(format!("{name}.toml"));
    let scene = Scene::from_toml(&std::fs::read_to_string(path).unwrap()).unwrap();
    let world = instantiate(&scene, &mut load_shape).unwrap().world;
    (world, scene.simulation.time_step, scene.simulation.duration)
}

/// How far the ends of a joint are off.
fn off(rigid: &RigidWorld, link: &Link) -> f64 {
    let point = |body: BodyId, at: DVec3| {
        let row = rigid.pose(body);
        row.position + row.orientation * at
    };
    let Link::Joint { body, at, to, kind, .. } = link else { return 0.0 };
    let far = match to {
        LinkEnd::Point(point) => *point,
        LinkEnd::Body { body, at } => point(*body, *at),
    };
    let distance = point(*body, *at).distance(far);
    match kind {
        JointKind::Ball { .. } | JointKind::Hinge { .. } => distance,
        JointKind::Rod { length } => (distance - length).abs(),
        JointKind::Rope { length } => (distance - length).max(0.0),
    }
}

fn run(name: &str) -> Found {
    let (world, time_step, duration) = load(name);
    let mut rigid = RigidWorld::try_new(&world, time_step, true).unwrap();
    let (mut log, mut found) = (StepLog::new(), Found::default());
    let (mut scale, mut grown) = (0.0_f64, 0.0_f64);
    let mut lowest = f64::INFINITY;
    for _ in 0..(duration / time_step).round() as usize {
        let count = world.bodies.len();
        let before: Vec<_> = (0..count).map(|i| rigid.momentum(BodyId(i as u32))).collect();
        let awake: Vec<bool> = (0..count).map(|i| !rigid.is_asleep(BodyId(i as u32))).collect();
        rigid.step(&mut log).unwrap();
        found.drift = world.links.iter().map(|link| off(&rigid, link)).fold(found.drift, f64::max);
        let mut sums = vec![(DVec3::ZERO, 0.0); count];
        let (mut driven, mut asleep) = (false, false);
        for Impulse { row, .. } in log.impulses() {
            for (body, sign) in [(row.body_a, 1.0), (row.body_b, -1.0)] {
                if let Some(sum) = sums.get_mut(body.index()) {
                    sum.0 += row.impulse() * sign;
                    sum.1 += row.impulse().length();
                }
            }
            found.impacts += u32::from(row.kind == ContactKind::Impact);
            asleep |= row.kind == ContactKind::Sleep;
        }
        for (i, body) in world.bodies.iter().enumerate() {
            driven |= matches!(body.motion, clangor_core::body::Motion::Guided(_));
            let moved = rigid.momentum(BodyId(i as u32)).0 - before[i].0;
            let weight = world.gravity * (body.mass * time_step);
            if body.motion.is_movable() && awake[i] && !rigid.is_asleep(BodyId(i as u32)) {
                let off = (moved - weight - sums[i].0).length();
                found.imbalance = found.imbalance.max(off / (sums[i].1 + weight.length()));
            }
        }
        driven |= world.links.iter().any(|link| matches!(link, Link::Load { .. }));
        let energy = rigid.energy();
        if !driven && !asleep {
            grown = grown.max(energy - lowest);
        }
        lowest = lowest.min(energy);
        scale = scale.max(rigid.kinetic_energy());
    }
    found.gain = grown / scale.max(f64::MIN_POSITIVE);
    println!("{name}: {found:?}");
    found
}

#[test]
fn a_bell_with_a_clapper() {
    let found = run("bell");
    // Residuals seen: 6e-7 m, 1e-13, 5e-11.
    assert!(found.drift < 1e-5 && found.imbalance < 1e-9 && found.gain < 1e-4 && found.impacts > 5);
}

#[test]
fn a_bar_and_a_striker_on_ropes() {
    let found = run("hung-bar");
    // Residuals seen: 1.4e-8 m, 6e-14, 4e-5: an oscillation by (ω Δt)².
    assert!(found.drift < 1e-5 && found.imbalance < 1e-9 && found.gain < 1e-4 && found.impacts > 3);
}

#[test]
fn a_door_on_two_hinges() {
    let found = run("door");
    // Residuals seen: 2e-9 m, 2e-14.
    assert!(found.drift < 1e-5 && found.imbalance < 1e-9 && found.impacts > 1);
}

#[test]
fn a_mug_that_is_set_down_and_let_go() {
    let found = run("set-down-mug");
    // Residual seen: 3e-14.
    assert!(found.imbalance < 1e-9 && found.impacts > 3);
}
