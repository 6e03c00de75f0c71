//! Springs faster than a step follows, up to the stiffest that a scene accepts, against closed forms.

use std::ops::ControlFlow;

use clangor_core::body::{Body, BodyId, Link, LinkEnd, World};
use clangor_core::glam::DVec3;
use clangor_core::timeline::Timeline;
use clangor_sim::record::RecordSettings;
use clangor_sim::rigid::{RigidWorld, StepLog};
use clangor_sim::{ContactModel, SimulationError, SimulationSettings, Solver, choose_solver, simulate};

use crate::scenes::{Random, ball, cuboid, floor, material, solid, world};

const G: f64 = 9.81;
const STEP: f64 = 2.5e-4;
/// Stiffest spring of a scene [N/m].
const STIFFEST: f64 = 1e12;

/// A steel ball of 1 cm diameter, 4.1 g.
fn steel_ball(position: DVec3) -> Body {
    let mut body = ball(&material(7850.0, 0.5, 0.3, 0.0), 0.005);
    body.pose.position = position;
    body
}

fn spring(body: u32, to: LinkEnd, (rest_length, stiffness, damping): (f64, f64, f64)) -> Link {
    Link::Spring { body: BodyId(body), at: DVec3::ZERO, to, rest_length, stiffness, damping }
}

fn stepped(world: &World, steps: usize, seen: &mut dyn FnMut(&RigidWorld)) -> RigidWorld {
    let mut rigid = RigidWorld::try_new(world, STEP, true).unwrap();
    let mut log = StepLog::new();
    for _ in 0..steps {
        rigid.step(&mut log).unwrap();
        seen(&rigid);
    }
    rigid
}

/// A weight stretches a spring by m g/k, whatever the step.
#[test]
fn a_weight_stretches_a_stiff_spring_by_its_load() {
    for stiffness in [1e6, 1e8, 1e10, STIFFEST] {
        let hung = steel_ball(DVec3::NEG_Y * 0.1);
        let stretch = hung.mass * G / stiffness;
        let links = vec![spring(0, LinkEnd::Point(DVec3::ZERO), (0.1, stiffness, 0.0))];
        let rigid = stepped(&World { links, ..world(vec![hung]) }, 400, &mut |_| {});
        let at = rigid.pose(BodyId(0)).position;
        let error = (-at.y - 0.1 - stretch).abs();
        println!("{stiffness:e} N/m: {stretch:.3e} m, off by {error:.1e} m");
        // Residuals seen: at most 2e-17 m, a rounding of the position, in a stretch of 4e-14 m.
        assert!(error < 1e-3 * stretch + 3e-17, "{stiffness:e}: {at}");
        assert!(at.x == 0.0 && at.z == 0.0);
    }
}

/// On a stiff spring a ball is a pendulum of the spring's length: its period by the arithmetic-geometric
/// mean.
#[test]
fn a_stiff_spring_swings_as_a_rod() {
    let (length, start) = (0.2, 0.8_f64);
    let hung = steel_ball(DVec3::new(start.sin(), -start.cos(), 0.0) * length);
    let links = vec![spring(0, LinkEnd::Point(DVec3::ZERO), (length, STIFFEST, 0.0))];
    let (mut times, mut last, mut widest) = (Vec::new(), f64::NAN, 0.0_f64);
    stepped(&World { links, ..world(vec![hung]) }, 12_000, &mut |rigid| {
        let pose = rigid.pose(BodyId(0));
        if last < 0.0 && pose.position.x >= 0.0 {
            times.push(rigid.time() - STEP * pose.position.x / (pose.position.x - last));
        }
        last = pose.position.x;
        widest = if rigid.time() > 2.0 { widest.max(last) } else { widest };
    });
    let (mut a, mut g) = (1.0, (0.5 * start).cos());
    for _ in 0..20 {
        (a, g) = (0.5 * (a + g), f64::sqrt(a * g));
    }
    let wanted = std::f64::consts::TAU * (length / G).sqrt() / a;
    let period = (times[times.len() - 1] - times[0]) / (times.len() - 1) as f64;
    println!("period {:.1e}, amplitude {:.1e}", period / wanted - 1.0, widest / (length * start.sin()) - 1.0);
    // Residuals seen: 4e-7 and 2e-6, as of a rod at this step.
    assert!((period / wanted - 1.0).abs() < 1e-5);
    assert!((widest / (length * start.sin()) - 1.0).abs() < 1e-4);
}

/// Backward Euler leaves 1/√(1 + ω² Δt²) of the amplitude after each step: exactly what its documentation
/// says.
#[test]
fn an_unresolved_oscillation_decays_by_the_stated_factor() {
    let body = steel_ball(DVec3::X * 0.1001);
    // ω Δt = 2.
    let stiffness = body.mass * (2.0 / STEP).powi(2);
    let links = vec![spring(0, LinkEnd::Point(DVec3::ZERO), (0.1, stiffness, 0.0))];
    let weightless = World { gravity: DVec3::ZERO, links, ..world(vec![body.clone()]) };
    let energy = |rigid: &RigidWorld| {
        // At the middle of the next step, where the law holds.
        let pose = rigid.pose(BodyId(0));
        let x = pose.position.x + 0.5 * STEP * pose.velocity.x - 0.1;
        0.5 * body.mass * pose.velocity.length_squared() + 0.5 * stiffness * x * x
    };
    let mut energies = Vec::new();
    stepped(&weightless, 8, &mut |rigid| energies.push(energy(rigid)));
    for pair in energies.windows(2) {
        // E⁺ (1 + ω² Δt²) = E for each step. Residual seen: 2e-13.
        assert!((pair[1] * 5.0 / pair[0] - 1.0).abs() < 1e-9, "{energies:?}");
    }
}

/// A damper alone, too strong for a step: the ball stops, and is not thrown back.
#[test]
fn a_damper_of_any_strength_brakes() {
    for damping in [1e3, 1e6, 1e12] {
        let mut body = steel_ball(DVec3::X * 0.1);
        body.velocity = DVec3::X;
        let links = vec![spring(0, LinkEnd::Point(DVec3::ZERO), (0.1, 1e-9, damping))];
        let weightless = World { gravity: DVec3::ZERO, links, ..world(vec![body.clone()]) };
        let mut last = 1.0;
        stepped(&weightless, 4, &mut |rigid| {
            let speed = rigid.pose(BodyId(0)).velocity.x;
            // After a step 1/(1 + c Δt/m). Residuals seen: 1e-12 of the first speed.
            last /= 1.0 + damping * STEP / body.mass;
            assert!((speed - last).abs() < 1e-9, "{damping:e}: {speed} against {last}");
        });
    }
}

/// Kinetic energy, weight and springs of a world [J].
fn energy(rigid: &RigidWorld, world: &World) -> f64 {
    let point = |end: &LinkEnd| match *end {
        LinkEnd::Point(point) => point,
        LinkEnd::Body { body, at } => {
            let pose = rigid.pose(body);
            pose.position + pose.orientation * at
        }
    };
    let stored = |link: &Link| match *link {
        Link::Spring { body, at, ref to, rest_length, stiffness, .. } => {
            let length = point(&LinkEnd::Body { body, at }).distance(point(to));
            0.5 * stiffness * (length - rest_length).powi(2)
        }
        _ => 0.0,
    };
    rigid.energy() + world.links.iter().map(stored).sum::<f64>()
}

/// Balls and bars joined to each other and to fixed points, on centres and off them, with springs of 1e3 to
/// 1e12 N/m and any damping; each is strained by `strain` of its length at most, or has no rest length and
/// is soft.
fn net(seed: u64, strain: f64) -> World {
    let steel = material(7850.0, 0.5, 0.3, 0.0);
    let mut random = Random(seed * 7919);
    let mut bodies = Vec::new();
    for k in 0..4 {
        let bar = || solid("bar", &steel, &[cuboid(DVec3::new(0.02, 0.004, 0.003))]);
        let mut body = if k % 2 == 0 { ball(&steel, 0.005) } else { bar() };
        body.pose.position = DVec3::X * 0.2 * f64::from(k) + random.direction() * 0.02;
        body.velocity = random.direction();
        bodies.push(body);
    }
    let mut links = Vec::new();
    for k in 0..6_u32 {
        let soft = k % 4 == 0;
        let decades = if soft { [-1.0, 1.0] } else { [3.0, 12.0] };
        let stiffness = 10_f64.powf(decades[0] + (decades[1] - decades[0]) * random.unit());
        let damping = if k % 3 == 0 { 10_f64.powf(9.0 * random.unit()) } else { 0.0 };
        let at = if k % 2 == 0 { DVec3::ZERO } else { random.direction() * 0.004 };
        let to = if k < 4 {
            LinkEnd::Point(random.direction() * 0.5)
        } else {
            LinkEnd::Body { body: BodyId((k + 1) % 4), at }
        };
        let place = |body: usize, at: DVec3| bodies[body].pose.position + at;
        let far = match to {
            LinkEnd::Point(point) => point,
            LinkEnd::Body { body, at } => place(body.index(), at),
        };
        let length = place(k as usize % 4, at).distance(far);
        let rest_length = if soft { 0.0 } else { length * (1.0 + strain * random.signed()) };
        links.push(Link::Spring { body: BodyId(k % 4), at, to, rest_length, stiffness, damping });
    }
    World { gravity: DVec3::ZERO, links, ..world(bodies) }
}

/// Bodies never move with more energy than there was at the start. What a stiff spring stores between the
/// middles of steps means nothing: there a chord of 40 nm is a joule.
#[test]
fn nets_of_stiff_springs_never_gain_energy() {
    let mut followed = 0;
    for strain in [0.0, 1e-6, 1e-3, 0.1] {
        for seed in 1..9 {
            let world = net(seed, strain);
            let mut rigid = RigidWorld::try_new(&world, STEP, true).unwrap();
            let (first, mut most) = (energy(&rigid, &world), f64::NEG_INFINITY);
            let mut log = StepLog::new();
            let ended = (0..600).try_for_each(|_| {
                rigid.step(&mut log)?;
                most = most.max(rigid.kinetic_energy());
                Ok(())
            });
            println!("strain {strain:e}, net {seed}: {first:.3e} J, then {most:.3e} J, {ended:?}");
            match ended {
                Ok(()) => followed += 1,
                // Strained by kilojoules, or braced so that it cannot move: said, with what helps.
                Err(error @ SimulationError::StrainedSpring { .. }) => {
                    assert!(error.to_string().contains("time_step"), "{error}");
                }
                Err(error) => panic!("{error}"),
            }
            assert!(most <= first * 1.01, "net {seed} of strain {strain}: {first:e} J, then {most:e} J");
        }
    }
    assert!(followed >= 16, "{followed}");
}

fn settings(duration: f64, solver: Solver) -> SimulationSettings {
    let contact = ContactModel::default();
    let record = RecordSettings::default();
    SimulationSettings { solver, contact, duration, time_step: STEP, record, sleep: true }
}

/// A ball of 1 cm on a spring: the event-driven solver follows it while its work is bounded; stiffer
/// springs are stepped, in as many steps as the time step says.
#[test]
fn the_work_does_not_grow_with_the_stiffness() {
    let mut most = 0;
    for stiffness in [1e4, 1e6, 1e7, 1e9, STIFFEST] {
        let links = vec![spring(0, LinkEnd::Point(DVec3::ZERO), (0.1, stiffness, 0.0))];
        let world = World { links, ..world(vec![steel_ball(DVec3::NEG_Y * 0.1), floor_below()]) };
        let chosen = choose_solver(&world, Solver::Auto);
        let expected = if stiffness < 2e7 { Solver::Spheres } else { Solver::Rigid };
        assert_eq!(chosen, expected, "{stiffness:e}");
        let mut timeline = Timeline::default();
        let report =
            simulate(
                &world,
                &settings(0.05, Solver::Auto),
                &mut timeline,
                &mut |_| ControlFlow::Continue(()),
            );
        let report = report.unwrap();
        println!("{stiffness:e} N/m: {} events", report.events);
        most = most.max(report.events);
        // Who insists is told what is too fast, and what to do.
        let exact = simulate(&world, &settings(0.05, Solver::Spheres), &mut timeline, &mut |_| {
            ControlFlow::Continue(())
        });
        match (expected, exact) {
            (Solver::Spheres, exact) => assert!(exact.is_ok()),
            (_, Err(error @ SimulationError::NotASphere { .. })) => {
                assert!(error.to_string().contains("spring") && error.to_string().contains("\"rigid\""));
            }
            (_, exact) => panic!("{stiffness:e}: {exact:?}"),
        }
    }
    // Segments of the fastest spring that is followed, 7e4 rad/s for 0.05 s.
    assert!(most > 100 && most < 20_000, "{most}");
}

fn floor_below() -> Body {
    let mut floor = floor(&material(7850.0, 0.5, 0.3, 0.0));
    floor.pose.position = DVec3::NEG_Y;
    floor
}

/// A ball that drops on another one held by the stiffest spring rebounds as from a fixed one.
#[test]
fn a_stiff_spring_holds_against_impacts() {
    let held = steel_ball(DVec3::ZERO);
    let mut thrown = steel_ball(DVec3::Y * 0.02);
    thrown.velocity = DVec3::NEG_Y;
    let links = vec![spring(0, LinkEnd::Point(DVec3::NEG_Y * 0.1), (0.1, STIFFEST, 0.0))];
    let world = World { gravity: DVec3::ZERO, links, ..world(vec![held, thrown]) };
    let rigid = stepped(&world, 400, &mut |_| {});
    let (held, thrown) = (rigid.pose(BodyId(0)), rigid.pose(BodyId(1)));
    println!("held {:e} m/s, thrown {} m/s", held.velocity.length(), thrown.velocity.y);
    // Restitution 0.5 of a whole approach of 1 m/s; residual seen: 1e-7.
    assert!((thrown.velocity.y - 0.5).abs() < 1e-3);
    assert!(held.velocity.length() < 1e-9 && held.position.length() < 1e-9);
}
