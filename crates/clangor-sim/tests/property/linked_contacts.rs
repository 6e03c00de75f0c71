//! Bodies on hinges and ropes that touch something close to a joint, or along a rope: energy never grows, and
//! impulses are those that the motion needs.

use clangor_core::body::{Body, BodyId, JointKind, Link, LinkEnd, Motion, World};
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::pose::Pose;
use clangor_core::timeline::ContactKind;
use clangor_sim::rigid::{RigidWorld, StepLog};

use crate::scenes::{ball, cuboid, floor, material, solid, world};

const STEP: f64 = 1e-4;

/// A wooden block at a place, turned about z.
fn block(half: DVec3, at: DVec3, angle: f64) -> Body {
    let mut block = solid("block", &material(700.0, 0.4, 0.4, 0.0), &[cuboid(half)]);
    block.pose = Pose { position: at, orientation: DQuat::from_rotation_z(angle) };
    block
}

fn fixed(half: DVec3, at: DVec3) -> Body {
    Body { motion: Motion::Fixed, ..block(half, at, 0.0) }
}

/// The first body on a hinge along z at a point of the world.
fn hinged(bodies: Vec<Body>, point: DVec3) -> World {
    let pose = bodies[0].pose;
    let at = pose.orientation.inverse() * (point - pose.position);
    let kind = JointKind::Hinge { axis: DVec3::Z, damping: 0.0 };
    let link = Link::Joint { body: BodyId(0), at, to: LinkEnd::Point(point), kind, collide: true };
    World { links: vec![link], ..world(bodies) }
}

/// What a run was like.
#[derive(Debug)]
struct Seen {
    /// Largest energy beyond that at the start \[J\].
    gained: f64,
    /// Largest spin \[rad/s\] and speed \[m/s\].
    spin: f64,
    speed: f64,
    /// Normal impulses of all impacts, of the hardest, and the largest of other contacts in a step \[N s\].
    impacts: f64,
    hardest: f64,
    pressed: f64,
    end: Pose,
}

fn run(world: &World, duration: f64) -> Seen {
    let mut rigid = RigidWorld::try_new(world, STEP, true).unwrap();
    let mut log = StepLog::new();
    let start = rigid.energy();
    let end = world.bodies[0].pose;
    let mut seen = Seen { gained: 0.0, spin: 0.0, speed: 0.0, impacts: 0.0, hardest: 0.0, pressed: 0.0, end };
    for _ in 0..(duration / STEP).round() as usize {
        rigid.step(&mut log).unwrap();
        let row = rigid.pose(BodyId(0));
        seen.gained = seen.gained.max(rigid.energy() - start);
        seen.spin = seen.spin.max(row.angular_velocity.length());
        seen.speed = seen.speed.max(row.velocity.length());
        for contact in log.impulses().iter().map(|impulse| impulse.row) {
            match contact.kind {
                ContactKind::Impact => {
                    seen.impacts += contact.impulse_n;
                    seen.hardest = seen.hardest.max(contact.impulse_n);
                }
                ContactKind::Contact => seen.pressed = seen.pressed.max(contact.impulse_n),
                _ => {}
            }
        }
        seen.end = Pose { position: row.position, orientation: row.orientation };
    }
    seen
}

/// A lid 20 cm long that falls shut from 80°. The top of its base is by `gap` below its underside, and begins
/// at the distance `base` from the axis \[m\].
fn lid(gap: f64, base: f64) -> World {
    let (point, angle) = (DVec3::Y * 0.05, 80.0_f64.to_radians());
    let at = point + DQuat::from_rotation_z(angle) * (DVec3::X * 0.1);
    let lid = block(DVec3::new(0.1, 0.0025, 0.1), at, angle);
    let base = fixed(DVec3::new(0.1, 0.025, 0.1), DVec3::new(0.1 + base, 0.0225 - gap, 0.0));
    hinged(vec![lid, base], point)
}

#[test]
fn a_lid_falls_shut_on_a_base_that_reaches_to_its_hinge() {
    let mut impacts = Vec::new();
    for (gap, base) in [(0.0, 0.0), (1e-5, 0.0), (0.0, 5e-4), (0.0, -0.01)] {
        let world = lid(gap, base);
        let (mass, inertia) = (world.bodies[0].mass, world.bodies[0].inertia.col(2).z);
        let fall = mass * 9.81 * 0.1 * 80.0_f64.to_radians().sin();
        let spin = (2.0 * fall / (inertia + mass * 0.01)).sqrt();
        let seen = run(&world, 1.0);
        println!("{gap} {base}: {fall:.3} J, {spin:.2} rad/s; {seen:?}");
        assert!(seen.gained < 1e-5 * fall, "{:.2e} J", seen.gained);
        assert!((seen.spin / spin - 1.0).abs() < 0.01, "{:.2} rad/s", seen.spin);
        assert!((seen.end.position.y - 0.05).abs() < 1e-4, "{:.5} m", seen.end.position.y);
        impacts.push(seen.impacts);
    }
    // Residuals seen: energy 1.2e-7, spin 1e-3, impulses 3e-5; 0.053 where the base begins behind the hinge.
    for impulse in &impacts {
        assert!((impulse / impacts[1] - 1.0).abs() < 0.1, "{impulse:.3} N s");
    }
}

#[test]
fn a_base_that_begins_at_any_distance_from_the_hinge_gives_no_energy() {
    for base in [1e-3, 2e-3, 3e-3, 5e-3, 0.01, 0.03, 0.1] {
        for gap in [-1e-5, 0.0, 1e-4] {
            let seen = run(&lid(gap, base), 0.7);
            println!("{base} {gap}: {seen:?}");
            // Residual seen: 1.6e-8 J of 0.135 J.
            assert!(seen.gained < 1e-6, "{:.2e} J", seen.gained);
        }
    }
}

#[test]
fn a_rod_hinged_at_its_foot_falls_on_a_block_as_on_a_plane() {
    let (point, angle) = (DVec3::Y * 0.01, -5.0_f64.to_radians());
    let at = point + DQuat::from_rotation_z(angle) * (DVec3::Y * 0.15);
    let rod = block(DVec3::new(0.01, 0.15, 0.01), at, angle);
    let slab = fixed(DVec3::new(0.5, 0.01, 0.5), DVec3::Y * -0.01);
    let on_block = run(&hinged(vec![rod.clone(), slab], point), 1.2);
    let on_plane = run(&hinged(vec![rod, floor(&material(700.0, 0.4, 0.4, 0.0))], point), 1.2);
    println!("{on_block:?}\n{on_plane:?}");
    // Residuals seen: 6e-4 of the impulse, 5 µm, 1e-8 J, 1.6e-4 N s.
    assert!((on_block.impacts / on_plane.impacts - 1.0).abs() < 0.01);
    assert!((on_block.end.position.y - 0.01).abs() < 1e-4);
    assert!(on_block.gained < 1e-6 && on_block.pressed < 0.01);
}

#[test]
fn a_bob_on_a_rope_that_grazes_the_ground_gains_nothing() {
    for low in [2e-5, 5e-6, 1e-4, 1e-3] {
        let (length, angle) = (0.3, 40.0_f64.to_radians());
        let top = DVec3::Y * (0.02 + length - low);
        let mut bob = ball(&material(7850.0, 0.4, 0.4, 0.0), 0.02);
        bob.pose.position = top - length * DVec3::new(angle.sin(), angle.cos(), 0.0);
        let fall = bob.mass * 9.81 * length * (1.0 - angle.cos());
        let speed = (2.0 * fall / bob.mass).sqrt();
        let slab = fixed(DVec3::new(0.1, 0.01, 0.1), DVec3::Y * -0.01);
        let mut world = world(vec![bob, slab]);
        let (to, kind) = (LinkEnd::Point(top), JointKind::Rope { length });
        world.links = vec![Link::Joint { body: BodyId(0), at: DVec3::ZERO, to, kind, collide: true }];
        let seen = run(&world, 1.2);
        println!("{low}: {fall:.3} J, {speed:.3} m/s; {seen:?}");
        // Residual seen: 1.9e-7 of the energy; the speed is never above.
        assert!(seen.gained < 1e-5 * fall, "{:.2e} J", seen.gained);
        assert!(seen.speed < 1.001 * speed, "{:.3} m/s", seen.speed);
    }
}

#[test]
fn friction_at_a_hinged_corner_is_no_more_than_the_impact_needs() {
    for low in [0.0, 2e-4, 1e-3] {
        let (point, angle) = (DVec3::Y * (0.32 - low), -40.0_f64.to_radians());
        let turn = DQuat::from_rotation_z(angle);
        let bob = block(DVec3::splat(0.02), point - turn * (DVec3::Y * 0.3), angle);
        let inertia = bob.inertia.col(2).z + bob.mass * 0.09;
        let fall = bob.mass * 9.81 * 0.3 * (1.0 - angle.cos());
        let slab = fixed(DVec3::new(0.1, 0.01, 0.1), DVec3::Y * -0.01);
        let seen = run(&hinged(vec![bob, slab], point), 0.6);
        // The corner is 0.02 m or less off the hinge; without friction it takes I Δω over that lever.
        let most = 1.5 * inertia * (2.0 * fall / inertia).sqrt() / 0.015;
        println!("{low}: {fall:.3} J, {most:.1} N s; {seen:?}");
        // Residuals seen: 1.8e-7 of the energy, 0.73 N s.
        assert!(seen.gained < 1e-5 * fall, "{:.2e} J", seen.gained);
        assert!(seen.hardest < most, "{:.2} N s", seen.hardest);
    }
}
