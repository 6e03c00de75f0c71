//! Limits of the time-stepped solver: fast bodies, overlaps, invalid input, moving bodies, springs.

use std::ops::ControlFlow;
use std::sync::Arc;

use clangor_core::body::link::LoadCurve;
use clangor_core::body::{Body, BodyId, JointKind, Link, LinkEnd, Motion, Surface, World};
use clangor_core::geometry::convex::ConvexPart;
use clangor_core::glam::{DMat3, DQuat, DVec3};
use clangor_core::pose::{Keyframe, Pose, Track};
use clangor_core::timeline::{ContactKind, Timeline};
use clangor_sim::record::RecordSettings;
use clangor_sim::rigid::{RigidWorld, StepLog};
use clangor_sim::{ContactModel, SimulationError, SimulationSettings, Solver, simulate};

use crate::scenes::{Random, ball, bowl, cuboid, cylinder, die, floor, key, material, rock, solid, world};

fn weightless(bodies: Vec<Body>) -> World {
    World { gravity: DVec3::ZERO, ..world(bodies) }
}

/// Bodies thrown at 10 m/s against the floor and against a fixed plate of 2 mm stay on their side.
#[test]
fn nothing_tunnels_at_ten_metres_per_second() {
    let material = material(2500.0, 0.3, 0.5, 1e-4);
    let thrown = [
        ball(&material, 0.0075),
        cylinder(&material, 0.01213, 0.000875),
        solid("die", &material, &[die(0.008, 0.0008)]),
        solid("rock", &material, &[rock(5, 20, 0.015)]),
        solid("key", &material, &key()),
    ];
    for seed in 1..6 {
        for body in &thrown {
            for plate in [false, true] {
                let mut random = Random(seed * 1003);
                let mut body = body.clone();
                body.pose.position = DVec3::new(0.0, 0.05 + 1e-3 * random.unit(), 0.0);
                body.pose.orientation = random.orientation();
                body.velocity = DVec3::NEG_Y * 10.0;
                body.angular_velocity = random.direction() * 50.0;
                let name = body.name.clone();
                let ground = if plate {
                    let mut plate = solid("plate", &material, &[cuboid(DVec3::new(0.2, 1e-3, 0.2))]);
                    plate.motion = Motion::Fixed;
                    plate.pose.position = DVec3::NEG_Y * 1e-3;
                    plate
                } else {
                    floor(&material)
                };
                let mut rigid = RigidWorld::try_new(&world(vec![ground, body]), 2.5e-4, true).unwrap();
                let mut log = StepLog::new();
                for _ in 0..1000 {
                    rigid.step(&mut log).unwrap();
                    let height = rigid.pose(BodyId(1)).position.y;
                    assert!(
                        height > 0.0,
                        "{name} {seed} plate {plate}: at {height} m after {} s",
                        rigid.time()
                    );
                }
            }
        }
    }
}

#[test]
fn overlaps_at_the_start_are_refused_by_name_and_depth() {
    let material = material(2500.0, 0.3, 0.5, 0.0);
    let mut low = solid("low", &material, &[cuboid(DVec3::splat(0.01))]);
    let mut high = solid("high", &material, &[cuboid(DVec3::splat(0.01))]);
    low.pose.position = DVec3::Y * 0.01;
    high.pose.position = DVec3::Y * (0.03 - 3e-4);
    let refused = RigidWorld::try_new(&world(vec![floor(&material), low.clone(), high.clone()]), 1e-4, true);
    let Err(SimulationError::StartOverlap { a, b, depth, .. }) = refused else {
        panic!("accepted an overlap")
    };
    assert_eq!((a.as_str(), b.as_str()), ("low", "high"));
    // The hulls are rounded by 5 um each.
    assert!((depth - 3.1e-4).abs() < 1e-8, "{depth:e}");
    high.pose.position = DVec3::Y * (0.03 - 5e-5);
    assert!(RigidWorld::try_new(&world(vec![floor(&material), low, high]), 1e-4, true).is_ok());
}

#[test]
fn nonsense_is_an_error_and_not_a_panic() {
    let material = material(2500.0, 0.3, 0.5, 0.0);
    let fine = || {
        let mut body = solid("body", &material, &[cuboid(DVec3::splat(0.01))]);
        body.pose.position = DVec3::Y * 0.1;
        body
    };
    let with_part = |part: ConvexPart| {
        let mut body = fine();
        let Surface::Mesh(mut mesh) = (*body.surface).clone() else { panic!("a mesh") };
        mesh.parts = vec![part];
        body.surface = Arc::new(Surface::Mesh(mesh));
        body
    };
    let flat = [DVec3::ZERO, DVec3::X, DVec3::Z, DVec3::X + DVec3::Z].map(|p| p * 0.01);
    let mut bad = vec![
        with_part(ConvexPart::Hull(Vec::new())),
        with_part(ConvexPart::Hull(vec![DVec3::ZERO; 5])),
        with_part(ConvexPart::Hull(flat.to_vec())),
        with_part(ConvexPart::Hull(vec![DVec3::NAN; 5])),
        with_part(ConvexPart::Ball { centre: DVec3::ZERO, radius: 0.0 }),
        with_part(ConvexPart::Cylinder {
            centre: DVec3::ZERO,
            axis: DVec3::ZERO,
            radius: 0.01,
            half_height: 0.01,
        }),
        Body { mass: 0.0, ..fine() },
        Body { mass: f64::NAN, ..fine() },
        Body { inertia: DMat3::ZERO, ..fine() },
        Body { inertia: -DMat3::IDENTITY, ..fine() },
        Body { pose: Pose::at(DVec3::NAN), ..fine() },
        Body { motion: Motion::Free, ..floor(&material) },
    ];
    for body in bad.drain(..) {
        let refused = RigidWorld::try_new(&world(vec![body.clone()]), 1e-4, true);
        assert!(matches!(refused, Err(SimulationError::BadBody { .. })), "{body:?}");
    }
    for time_step in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = RigidWorld::try_new(&world(vec![fine()]), time_step, true);
        assert!(matches!(refused, Err(SimulationError::BadSetting { setting: "time_step", .. })));
    }
    let mut wild = fine();
    wild.velocity = DVec3::X * f64::INFINITY;
    let mut rigid = RigidWorld::try_new(&world(vec![wild]), 1e-4, true).unwrap();
    let outcome = rigid.step(&mut StepLog::new());
    assert!(matches!(outcome, Err(SimulationError::Diverged { body, .. }) if body == "body"));
    let hung = |length: f64, body: u32| Link::Joint {
        body: BodyId(body),
        at: DVec3::ZERO,
        to: LinkEnd::Point(DVec3::Y),
        kind: JointKind::Rod { length },
        collide: true,
    };
    let linked =
        |link: Link| RigidWorld::try_new(&World { links: vec![link], ..world(vec![fine()]) }, 1e-4, true);
    assert!(linked(hung(0.9, 0)).is_ok());
    assert!(matches!(linked(hung(1.0, 7)), Err(SimulationError::Unsupported { .. })));
    for length in [1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(linked(hung(length, 0)), Err(SimulationError::OpenJoint { .. })), "{length}");
    }
    assert!(RigidWorld::try_new(&world(Vec::new()), 1e-4, true).unwrap().step(&mut StepLog::new()).is_ok());
}

/// A plate that a track lifts at 1 m/s throws a resting ball: the impact's velocity is the plate's.
#[test]
fn keyframed_bodies_follow_their_track_and_push() {
    let material = material(2500.0, 1.0, 0.0, 0.0);
    let key = |time: f64, y: f64| Keyframe { time, pose: Pose::at(DVec3::Y * y) };
    let track =
        Track::try_new((0..12).map(|i| key(0.1 * f64::from(i), 0.1 * f64::from(i))).collect()).unwrap();
    let mut plate = solid("plate", &material, &[cuboid(DVec3::new(0.1, 0.005, 0.1))]);
    plate.motion = Motion::Keyframed(track.clone());
    let mut struck = ball(&material, 0.01);
    struck.pose.position = DVec3::Y * 0.5;
    let mut rigid = RigidWorld::try_new(&weightless(vec![plate, struck]), 2.5e-4, true).unwrap();
    let mut log = StepLog::new();
    let mut impacts = Vec::new();
    for _ in 0..2800 {
        rigid.step(&mut log).unwrap();
        impacts.extend(log.impulses().iter().filter(|i| i.row.kind == ContactKind::Impact).map(|i| i.row));
        let plate = rigid.pose(BodyId(0));
        assert_eq!(plate.position, track.sample(rigid.time()).0.position);
    }
    assert_eq!(impacts.len(), 1);
    // The surfaces meet when the plate's centre is at 0.485 m; residuals seen: 0 and 9e-16 m/s.
    assert!((impacts[0].time - 0.485).abs() < 1e-9, "{}", impacts[0].time);
    assert!((impacts[0].approach_speed() - 1.0).abs() < 1e-9);
    assert!((rigid.pose(BodyId(1)).velocity.y - 2.0).abs() < 1e-9);
}

/// A box on a turntable moves with it without slipping; on a tilted half-space it slides according to
/// Coulomb's law.
#[test]
fn friction_holds_on_a_turntable_and_slides_on_a_slope() {
    let material = material(2500.0, 0.0, 0.3, 0.0);
    let turn = |k: u32| Keyframe {
        time: 0.1 * f64::from(k),
        pose: Pose {
            position: DVec3::NEG_Y * 0.005,
            orientation: DQuat::from_rotation_y(0.2 * f64::from(k)),
        },
    };
    let mut table = solid("table", &material, &[cuboid(DVec3::new(0.2, 0.005, 0.2))]);
    table.motion = Motion::Keyframed(Track::try_new((0..20).map(turn).collect()).unwrap());
    let mut rider = solid("rider", &material, &[cuboid(DVec3::splat(0.01))]);
    rider.pose.position = DVec3::new(0.1, 0.01 + 1e-5, 0.0);
    // It starts with the table: 2 rad/s.
    rider.velocity = DVec3::NEG_Z * 0.2;
    rider.angular_velocity = DVec3::Y * 2.0;
    let mut rigid = RigidWorld::try_new(&world(vec![table, rider]), 2.5e-4, true).unwrap();
    let mut log = StepLog::new();
    for _ in 0..4000 {
        rigid.step(&mut log).unwrap();
    }
    let expected = DQuat::from_rotation_y(2.0) * DVec3::new(0.1, 0.0, 0.0);
    let position = rigid.pose(BodyId(1)).position;
    // Residual seen: 5e-5 m: within a step the box flies straight on, with a drift of a Δt²/8.
    let off = (position.x - expected.x).hypot(position.z - expected.z);
    assert!(off < 1e-4, "off by {off:e} m");

    let angle = 30.0_f64.to_radians();
    let slope = crate::scenes::plane(&material, DQuat::from_rotation_z(angle) * DVec3::Y, DVec3::ZERO);
    let mut slider = solid("slider", &material, &[cuboid(DVec3::new(0.02, 0.005, 0.02))]);
    let orientation = DQuat::from_rotation_z(angle);
    slider.pose = Pose { position: orientation * DVec3::Y * 0.005, orientation };
    let mut rigid = RigidWorld::try_new(&world(vec![slope, slider]), 2.5e-4, true).unwrap();
    for _ in 0..2000 {
        rigid.step(&mut log).unwrap();
    }
    let speed = rigid.pose(BodyId(1)).velocity.length();
    let expected = 9.81 * 0.5 * (angle.sin() - 0.3 * angle.cos());
    // Residual seen: 2e-7.
    assert!((speed / expected - 1.0).abs() < 1e-4, "{speed} against {expected}");
}

/// A mass on a spring swings at √(k/m), and the log balances.
#[test]
fn a_mass_on_a_spring_keeps_time() {
    let material = material(2500.0, 0.3, 0.5, 0.0);
    let mut mass = solid("mass", &material, &[cuboid(DVec3::splat(0.01))]);
    mass.pose.position = DVec3::X * 0.12;
    let stiffness = mass.mass * 100.0;
    let spring = Link::Spring {
        body: BodyId(0),
        at: DVec3::ZERO,
        to: LinkEnd::Point(DVec3::ZERO),
        rest_length: 0.1,
        stiffness,
        damping: 0.0,
    };
    let kilograms = mass.mass;
    let world = World { links: vec![spring], ..weightless(vec![mass]) };
    let mut rigid = RigidWorld::try_new(&world, 2.5e-4, true).unwrap();
    let mut log = StepLog::new();
    let mut pulled = DVec3::ZERO;
    let steps = (4.0 * std::f64::consts::PI / 10.0 / 2.5e-4) as usize;
    for _ in 0..steps {
        rigid.step(&mut log).unwrap();
        for impulse in log.impulses() {
            assert_eq!(impulse.row.kind, ContactKind::Constraint);
            pulled += impulse.row.impulse();
        }
    }
    let pose = rigid.pose(BodyId(0));
    let expected = 0.1 + 0.02 * (10.0 * rigid.time()).cos();
    // Residual seen: 9e-11 m.
    assert!((pose.position.x - expected).abs() < 1e-6, "{} against {expected}", pose.position.x);
    assert!((pose.velocity * kilograms - pulled).length() < 1e-12);
}

/// The whole path from a world with a compound body to merged impacts, poses and a report.
#[test]
fn a_bowl_falls_through_the_public_entrance() {
    let material = material(2500.0, 0.3, 0.5, 2e-4);
    let mut falling = solid("bowl", &material, &bowl());
    falling.pose = Pose { position: DVec3::Y * 0.12, orientation: DQuat::from_rotation_x(0.4) };
    let world = world(vec![floor(&material), falling]);
    let settings = SimulationSettings {
        solver: Solver::Auto,
        contact: ContactModel::default(),
        duration: 0.6,
        time_step: 2.5e-4,
        record: RecordSettings::default(),
        sleep: true,
    };
    let mut timeline = Timeline::default();
    let report = simulate(&world, &settings, &mut timeline, &mut |_| ControlFlow::Continue(())).unwrap();
    assert!(report.impacts > 2 && report.rows as usize == timeline.contacts.len());
    let first = &timeline.contacts[0];
    assert_eq!((first.kind, first.body_a, first.body_b), (ContactKind::Impact, BodyId(1), BodyId(0)));
    assert!(first.impulse_n > 0.0 && first.normal == DVec3::Y && first.point.y.abs() < 1e-9);
    let of_bowl = timeline.poses.iter().filter(|p| p.body == BodyId(1)).count();
    // One at the start, 600 at 1 kHz, and one per impact.
    assert_eq!(of_bowl as u64, 601 + report.impacts);
    let stopped = simulate(&world, &settings, &mut timeline, &mut |_| ControlFlow::Break(()));
    assert!(matches!(stopped, Err(SimulationError::Interrupted)));
}

/// Random heaps of every kind of body, of sizes from 2 mm to 0.5 m, with any losses, gravity and step: errors
/// are allowed; panics, numbers that are not finite and growing energy are not.
#[test]
fn wild_worlds_end_in_order() {
    let mut refused = 0;
    for seed in 1..40_u64 {
        let mut random = Random(seed * 0x9e37_79b9);
        let material = material(
            10.0_f64.powf(2.0 + 2.0 * random.unit()),
            if seed % 4 == 0 { 1.0 } else { random.unit() },
            random.unit() * 1.5,
            if seed % 3 == 0 { 0.0 } else { 1e-3 * random.unit() },
        );
        let mut bodies = vec![floor(&material)];
        let mut top = 0.0;
        for k in 0..8_u64 {
            let size = 10.0_f64.powf(-2.7 + 2.4 * random.unit());
            let mut body = match k % 5 {
                0 => ball(&material, size),
                1 => cylinder(&material, size, size * 10.0_f64.powf(-2.0 * random.unit())),
                2 => solid("rock", &material, &[rock(seed * 17 + k, 16, size)]),
                3 => solid(
                    "plate",
                    &material,
                    &[cuboid(DVec3::new(size, 0.02 * size, size * random.unit().max(0.05)))],
                ),
                _ => solid("needle", &material, &[cuboid(DVec3::new(0.01 * size, size, 0.02 * size))]),
            };
            let radius = body.surface.bounding_radius();
            top += radius;
            body.pose.position = DVec3::new(0.3 * size * random.signed(), top, 0.3 * size * random.signed());
            top += radius;
            body.pose.orientation = random.orientation();
            body.velocity = random.direction() * 3.0 * random.unit();
            body.angular_velocity = random.direction() * (1.0 / size) * random.unit();
            bodies.push(body);
        }
        let gravity = DVec3::NEG_Y * [0.0, 1.6, 9.81, 50.0][seed as usize % 4];
        let time_step = [1e-5, 1e-4, 2.5e-4, 1e-3][seed as usize / 4 % 4];
        let count = bodies.len() as u32;
        let mut rigid = RigidWorld::try_new(&World { gravity, ..world(bodies) }, time_step, true).unwrap();
        let mut log = StepLog::new();
        let (energy, kinetic) = (rigid.energy(), rigid.kinetic_energy());
        for _ in 0..600 {
            if rigid.step(&mut log).is_err() {
                refused += 1;
                break;
            }
            assert!(log.impulses().iter().all(|i| i.row.impulse().is_finite() && i.row.couple.is_finite()));
        }
        let gain = (rigid.energy() - energy) / kinetic;
        // Seen: 1.5e-14 of the kinetic energy at most.
        assert!(gain < 1e-6, "seed {seed}: energy grew by {gain:e}");
        assert!((0..count).all(|i| rigid.pose(BodyId(i)).position.is_finite()), "seed {seed}");
    }
    // No world was rejected.
    assert_eq!(refused, 0);
}

/// A smooth coin that lands tilted and spinning on a box wobbles to rest without sinking, as on a half-space.
#[test]
fn a_wobbling_coin_does_not_sink_into_a_box() {
    let material = material(7850.0, 0.5, 0.4, 1e-4);
    for seed in 1..5 {
        let mut random = Random(seed * 7717);
        let mut coin = cylinder(&material, 0.01213, 0.000875);
        coin.pose.position = DVec3::Y * 0.03;
        coin.pose.orientation = random.orientation();
        coin.angular_velocity = DVec3::Y * 40.0 + random.direction() * 20.0;
        let mut table = solid("table", &material, &[cuboid(DVec3::new(0.2, 0.01, 0.2))]);
        table.motion = Motion::Fixed;
        table.pose.position = DVec3::NEG_Y * 0.01;
        let mut rigid = RigidWorld::try_new(&world(vec![table, coin]), 1e-4, true).unwrap();
        let mut log = StepLog::new();
        let mut deepest = 0.0_f64;
        for _ in 0..15_000 {
            rigid.step(&mut log).unwrap();
            deepest = deepest.max(rigid.deepest_overlap());
        }
        // Seen: 2.3 µm; 60 µm with the closest points alone.
        assert!(deepest < 5e-6, "seed {seed}: {deepest:e} m");
    }
}

/// Sheets down to a 25 000th of their length, in any frame, land without gaining energy and lie flat.
#[test]
fn thin_sheets_land_and_lie() {
    let material = material(7850.0, 0.3, 0.4, 1e-4);
    for (half_thickness, seed) in [(5e-4, 1), (1e-4, 2), (2.5e-5, 3), (1e-5, 4)] {
        let mut random = Random(seed * 77);
        let turn = random.orientation();
        let corners = cuboid(DVec3::new(0.25, half_thickness, 0.12)).into_iter().map(|p| turn * p);
        let mut sheet = solid("sheet", &material, &[corners.collect()]);
        sheet.pose.position = DVec3::Y * 0.4;
        sheet.pose.orientation = random.orientation();
        let start = sheet.mass * 9.81 * 0.4;
        let mut rigid = RigidWorld::try_new(&world(vec![floor(&material), sheet]), 2.5e-4, true).unwrap();
        let mut log = StepLog::new();
        for _ in 0..12_000 {
            rigid.step(&mut log).unwrap();
            let energy = rigid.energy();
            assert!(energy < start * (1.0 + 1e-9), "{half_thickness}: {energy} of {start} J");
        }
        let pose = rigid.pose(BodyId(1));
        let normal = pose.orientation * (turn * DVec3::Y);
        println!("{half_thickness}: {:.2e} m high, tilt {:.1e}", pose.position.y, 1.0 - normal.y.abs());
        // Seen: its half thickness within 1.1 µm; bodies may overlap by a micrometre.
        assert!((pose.position.y - half_thickness).abs() < 2e-5, "{half_thickness}: {}", pose.position.y);
        assert!(1.0 - normal.y.abs() < 1e-6);
    }
}

/// What pushes a body by much of its size in a step is refused, with what and how much.
#[test]
fn loads_that_no_contact_could_follow_are_refused_with_a_step_that_can() {
    let material = material(7850.0, 0.3, 0.5, 0.0);
    let pushed = |force: f64, torque: f64, seconds: f64, time_step: f64| {
        let mut pushed = world(vec![ball(&material, 0.01)]);
        let along =
            |value: f64| LoadCurve::try_new(vec![(0.0, DVec3::Y * value), (seconds, DVec3::Y * value)]);
        let (force, torque) = (along(force).unwrap(), along(torque).unwrap());
        pushed.links = vec![Link::Load { body: BodyId(0), at: DVec3::ZERO, force, torque }];
        RigidWorld::try_new(&pushed, time_step, true).map(|_| ())
    };
    pushed(1e3, 0.0, 0.1, 2.5e-4).unwrap();
    // A tap of 0.1 N s.
    pushed(1e5, 0.0, 1e-6, 2.5e-4).unwrap();
    let Err(SimulationError::PushedTooFar(push)) = pushed(1e6, 0.0, 0.1, 2.5e-4) else {
        panic!("1 MN on 33 g")
    };
    assert_eq!((push.what, push.size), ("force", 1e6));
    assert!(push.to_string().contains("a force of 1000000 N moves"), "{push}");
    pushed(1e6, 0.0, 0.1, 0.99 * push.longest).unwrap();
    let Err(SimulationError::PushedTooFar(push)) = pushed(0.0, 1e6, 0.1, 2.5e-4) else {
        panic!("1 MN m on 33 g")
    };
    assert_eq!(push.what, "torque");
    // A tap far shorter than a step, sixteen times too strong.
    let Err(SimulationError::PushedTooFar(push)) = pushed(1e7, 0.0, 1e-5, 2.5e-4) else {
        panic!("100 N s on 33 g")
    };
    pushed(1e7, 0.0, 1e-5, 0.99 * push.longest).unwrap();
}

/// A torque across a slender rod turns it little, one along it much.
#[test]
fn torques_are_measured_by_the_inertia_about_their_axis() {
    let material = material(7850.0, 0.3, 0.5, 0.0);
    let refused = |torque: DVec3| {
        let mut turned = world(vec![ball(&material, 0.01)]);
        turned.bodies[0].inertia = DMat3::from_diagonal(DVec3::new(2e-8, 2.6e-3, 2.6e-3));
        turned.bodies[0].pose.orientation = DQuat::from_rotation_z(0.5 * std::f64::consts::PI);
        let torque = LoadCurve::try_new(vec![(0.0, torque), (0.1, torque)]).unwrap();
        let force = LoadCurve::try_new(vec![(0.0, DVec3::ZERO), (0.1, DVec3::ZERO)]).unwrap();
        turned.links = vec![Link::Load { body: BodyId(0), at: DVec3::ZERO, force, torque }];
        RigidWorld::try_new(&turned, 2.5e-4, true).is_err()
    };
    // The long axis of the rod is y now.
    assert!(!refused(DVec3::X * 0.7) && !refused(DVec3::Z * 0.7));
    assert!(refused(DVec3::Y * 0.7));
}
