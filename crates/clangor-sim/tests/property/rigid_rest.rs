//! Dropped bodies come to rest and are silent from then on.
//!
//! A body rests once its surface has been slower than 2 cm/s for 50 ms. From 0.5 s after that no contact may
//! approach faster than 5 cm/s, the threshold of audible impacts.

use clangor_core::body::link::{JointKind, LinkEnd, LoadCurve};
use clangor_core::body::{Body, BodyId, Guide, Link, Motion, World};
use clangor_core::glam::DVec3;
use clangor_core::material::Material;
use clangor_core::pose::{Keyframe, Pose, Track};
use clangor_core::timeline::{ContactKind, ContactRow};
use clangor_sim::rigid::{RigidWorld, StepLog};

use crate::scenes::{Random, cuboid, floor, material, named, rock_pile, solid, world};

const TIME_STEP: f64 = 2.5e-4;
const COIN_STEP: f64 = 1e-4;
const RESTING: f64 = 0.02;
const LOUD: f64 = 0.05;

/// The ten shapes, with the time that each may take to come to rest \[s\]: shapes with round edges roll.
fn shapes(material: &Material, seed: u64) -> Vec<(Body, f64)> {
    let rock = format!("rock:{seed}x0.0125");
    let shard = format!("shard:{seed}x0.04");
    [
        ("prism:64x0.01213x0.00175", 4.0),
        ("coin", 15.0),
        ("die", 4.0),
        ("prism:6x0.01x0.006", 4.0),
        (rock.as_str(), 4.0),
        (shard.as_str(), 4.0),
        ("ring", 15.0),
        ("bowl", 15.0),
        ("key", 4.0),
        ("mug", 15.0),
    ]
    .map(|(text, limit)| (named(text, material), limit))
    .to_vec()
}

/// Results of a drop.
struct Drop {
    rest: Option<f64>,
    loud_after: usize,
    overlap: f64,
    /// Surface speed at the end [m/s].
    speed: f64,
}

fn drop(body: &Body, material: &Material, seed: u64, limit: f64) -> Drop {
    let mut random = Random(seed * 7919 + 1);
    let mut body = body.clone();
    let radius = body.surface.bounding_radius();
    body.pose.position = DVec3::Y * (0.1 + radius);
    body.pose.orientation = random.orientation();
    body.velocity = DVec3::new(random.signed(), 0.0, random.signed()) * 0.2;
    body.angular_velocity = DVec3::new(random.signed(), random.signed(), random.signed()) * 20.0;
    // The contact point of a smooth coin that falls flat moves along its rim at thousands of radians per
    // second; \[PAN\] Table 2 uses finer steps for it.
    let time_step = if body.name == "coin" { COIN_STEP } else { TIME_STEP };
    let mut rigid = RigidWorld::try_new(&world(vec![floor(material), body]), time_step, true).unwrap();
    let mut log = StepLog::new();
    let id = BodyId(1);
    let mut result = Drop { rest: None, loud_after: 0, overlap: 0.0, speed: 0.0 };
    let mut slow_since = None;
    while rigid.time() < result.rest.map_or(limit, |t| t + 1.5) {
        rigid.step(&mut log).unwrap();
        let now = rigid.time();
        for impulse in log.impulses() {
            result.overlap = result.overlap.max(impulse.row.depth);
            if result.rest.is_some_and(|t| now > t + 0.5) && impulse.row.approach_speed() > LOUD {
                result.loud_after += 1;
            }
        }
        result.speed = rigid.surface_speed(id);
        if result.speed >= RESTING {
            slow_since = None;
        } else {
            let since = *slow_since.get_or_insert(now);
            if now - since > 0.05 && result.rest.is_none() {
                result.rest = Some(since);
            }
        }
    }
    result
}

/// Drops every shape with these seeds and checks rest, silence and overlap.
fn drop_all(seeds: std::ops::Range<u64>) {
    let material = material(2500.0, 0.3, 0.5, 2e-4);
    let mut failures = Vec::new();
    for seed in seeds {
        for (body, limit) in shapes(&material, seed + 1) {
            let d = drop(&body, &material, seed + 1, limit);
            let rest = d.rest.unwrap_or(f64::INFINITY);
            let line = format!(
                "{:24} seed {seed}: rest {rest:.2} s, loud after {}, overlap {:.1} um, last speed {:.1e} m/s",
                body.name,
                d.loud_after,
                d.overlap * 1e6,
                d.speed
            );
            println!("{line}");
            // Seen: rest after 1.9 s at most, 3.5 s for rolling shapes and 12 s for the bowl; overlap 3.1 um.
            if rest > limit || d.loud_after > 0 || d.overlap > 5e-6 {
                failures.push(line);
            }
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn a_hundred_dropped_shapes_come_to_rest_and_stay_silent() {
    drop_all(0..10);
}

/// Number of audible impulses from `from` to `to` [s], and the deepest overlap after `from` [m].
fn loud_between(world: &World, time_step: f64, sleep: bool, from: f64, to: f64) -> (usize, f64) {
    let mut rigid = RigidWorld::try_new(world, time_step, sleep).unwrap();
    let mut log = StepLog::new();
    let (mut loud, mut overlap) = (0, 0.0_f64);
    while rigid.time() < to {
        rigid.step(&mut log).unwrap();
        if rigid.time() > from {
            loud += log.impulses().iter().filter(|i| i.row.approach_speed() > LOUD).count();
            overlap = overlap.max(rigid.deepest_overlap());
        }
    }
    (loud, overlap)
}

#[test]
fn a_pile_of_a_hundred_rocks_falls_silent() {
    let material = material(2650.0, 0.4, 0.5, 5e-5);
    for sleep in [true, false] {
        let (loud, overlap) =
            loud_between(&rock_pile(100, 0.08, &material, 2024), TIME_STEP, sleep, 1.5, 2.0);
        println!("sleep {sleep}: {loud} loud, overlap {:.1} um", overlap * 1e6);
        // Overlap seen: 2.1 um.
        assert!(loud == 0 && overlap < 5e-6, "{loud} loud, overlap {overlap:e} m");
    }
}

/// A tower of boxes neither sinks nor makes audible impacts, also under a heavy load.
#[test]
fn a_stack_of_twenty_boxes_stands() {
    for (count, load) in [(20, 1.0), (10, 100.0)] {
        let material = material(1000.0, 0.4, 0.5, 0.0);
        let half = 0.008;
        let mut bodies = vec![floor(&material)];
        for i in 0..count {
            let mut b = solid("box", &material, &[cuboid(DVec3::splat(half))]);
            // Hulls touch at a distance of 10 um.
            b.pose.position = DVec3::Y * (half + i as f64 * (2.0 * half + 1e-5));
            if i + 1 == count {
                b.mass *= load;
                b.inertia *= load;
            }
            bodies.push(b);
        }
        let world = world(bodies);
        let mut rigid = RigidWorld::try_new(&world, 1e-4, false).unwrap();
        let mut log = StepLog::new();
        let (mut loud, mut overlap) = (0, 0.0_f64);
        for _ in 0..20_000 {
            rigid.step(&mut log).unwrap();
            loud += log.impulses().iter().filter(|i| i.row.approach_speed() > LOUD).count();
            overlap = overlap.max(rigid.deepest_overlap());
        }
        let top = BodyId(count);
        let sink = world.bodies[count as usize].pose.position.y - rigid.pose(top).position.y;
        println!(
            "{count} boxes, load {load}: {loud} loud, sink {:.1} um, overlap {:.1} um, \
             kinetic energy {:.1e} J",
            sink * 1e6,
            overlap * 1e6,
            rigid.kinetic_energy()
        );
        // Seen: no loud impulse, sink -6 to 14 um, overlap 3.0 um.
        assert!(loud == 0 && sink.abs() < 5e-5 && overlap < 5e-6);
    }
}

/// A force on a body that begins at once and lasts.
fn load(body: BodyId, force: DVec3) -> Link {
    let force = LoadCurve::try_new(vec![(0.0, force), (10.0, force)]).unwrap();
    Link::Load { body, at: DVec3::ZERO, force, torque: LoadCurve::default() }
}

/// Steps with a loud approach before and after 0.3 s of 1 s, and the speed of a body at the end [m/s].
fn loud_steps(scene: &World, time_step: f64, body: BodyId) -> (usize, usize, f64) {
    let mut rigid = RigidWorld::try_new(scene, time_step, false).unwrap();
    let mut log = StepLog::new();
    let (mut early, mut late) = (0, 0);
    while rigid.time() < 1.0 {
        rigid.step(&mut log).unwrap();
        let is_loud = |row: &ContactRow| row.kind != ContactKind::Constraint && row.approach_speed() > LOUD;
        let loud = log.impulses().iter().any(|i| is_loud(&i.row));
        *if rigid.time() < 0.3 { &mut early } else { &mut late } += usize::from(loud);
    }
    (early, late, rigid.surface_speed(body))
}

/// Bodies that a force, a spring or a hand presses against a floor, with up to 100 000 times their weight,
/// bounce a few times and are silent from then on.
#[test]
fn pressed_bodies_come_to_rest() {
    let material = material(700.0, 0.5, 0.5, 5e-5);
    let half = 0.015;
    let body = BodyId(1);
    let spring = Link::Spring {
        body,
        at: DVec3::ZERO,
        to: LinkEnd::Point(DVec3::NEG_Y * 0.2),
        rest_length: 0.0,
        stiffness: 1000.0,
        damping: 0.1,
    };
    let key = |time: f64, y: f64| Keyframe { time, pose: Pose { position: DVec3::Y * y, ..Pose::IDENTITY } };
    let track = Track::try_new(vec![key(0.0, 0.02), key(0.2, -0.05)]).unwrap();
    let hand = Motion::Guided(Guide { track, press: Some(20.0), let_go: None });
    let cases = [
        ("5 N", Some(load(body, DVec3::NEG_Y * 5.0)), Motion::Free),
        ("200 N", Some(load(body, DVec3::NEG_Y * 200.0)), Motion::Free),
        ("spring", Some(spring), Motion::Free),
        ("hand", None, hand),
    ];
    for (name, link, motion) in cases {
        for on_plane in [true, false] {
            // A stronger press is refused at longer steps.
            let time_steps = if name == "hand" { &[1e-4][..] } else { &[1e-4, 1e-3] };
            for &time_step in time_steps {
                let mut cube = solid("cube", &material, &[cuboid(DVec3::splat(half))]);
                cube.pose.position = DVec3::new(0.0, half + 5e-3, 0.0);
                cube.motion = motion.clone();
                let mut block = solid("block", &material, &[cuboid(DVec3::splat(0.1))]);
                block.pose.position = DVec3::NEG_Y * 0.1;
                block.motion = Motion::Fixed;
                let mut scene = world(vec![if on_plane { floor(&material) } else { block }, cube]);
                scene.links.extend(link.clone());
                let (early, late, speed) = loud_steps(&scene, time_step, body);
                println!(
                    "{name}, plane {on_plane}, {time_step} s: {early} loud steps in 0.3 s, {late} later, \
                     {speed:.1e} m/s at the end"
                );
                // Seen: 2 to 8 loud steps, none later; in every step where pushes count as approaches.
                assert!(early < 20 && late == 0, "{name}: {early}, {late}");
                assert!(speed < 1e-3, "{name}: {speed:e} m/s");
            }
        }
    }
}

/// A force that a joint takes is no approach.
#[test]
fn a_force_on_a_joint_is_silent() {
    let material = material(700.0, 0.5, 0.5, 5e-5);
    let body = BodyId(1);
    // A plank on the floor, with a hinge at its centre.
    let mut plank = solid("plank", &material, &[cuboid(DVec3::new(0.2, 0.005, 0.02))]);
    plank.pose.position = DVec3::Y * 0.0051;
    let hinge = Link::Joint {
        body,
        at: DVec3::ZERO,
        to: LinkEnd::Point(plank.pose.position),
        kind: JointKind::Hinge { axis: DVec3::Z, damping: 0.0 },
        collide: true,
    };
    let mut taken = world(vec![floor(&material), plank.clone()]);
    taken.links = vec![hinge, load(body, DVec3::Y * 50.0)];
    let (early, late, _) = loud_steps(&taken, 2.5e-4, body);
    println!("taken by the hinge: {early}, {late}");
    assert_eq!((early, late), (0, 0));
}
