//! Balls on rods at any speed: they run, rods keep their length, and the energy never grows.

mod sphere_worlds;

use std::f64::consts::{PI, TAU};

use clangor_core::body::{Body, BodyId, Link, Motion, SpringEnd, World};
use clangor_core::timeline::PoseRow;
use clangor_sim::SimulationError;
use glam::DVec3;
use sphere_worlds::{G, kinetic_energy, material, plane, run, settings, sphere, world};

const POSE_RATE: f64 = 250.0;
/// Largest relative error of a rod's length, and largest growth of the energy relative to the initial one.
const BAR: f64 = 1e-9;

fn hang(body: usize, anchor: DVec3) -> Link {
    Link::Hang { body: BodyId(body as u32), anchor }
}

fn hung_at(anchor: DVec3, angle: f64, length: f64) -> DVec3 {
    anchor + DVec3::new(angle.sin(), -angle.cos(), 0.0) * length
}

/// Largest relative error of a rod's length, growth of the energy from one sample to the next, and loss of
/// energy over the whole, both relative to the energy at t = 0 above that of all rods hanging down.
#[derive(Clone, Copy, Debug, Default)]
struct Drift {
    rods: f64,
    growth: f64,
    loss: f64,
    impacts: usize,
}

impl Drift {
    fn worst(self, other: Drift) -> Drift {
        Drift {
            rods: self.rods.max(other.rods),
            growth: self.growth.max(other.growth),
            loss: self.loss.max(other.loss),
            impacts: self.impacts + other.impacts,
        }
    }
}

fn position_of(world: &World, frame: &[PoseRow], body: BodyId) -> DVec3 {
    frame.iter().find(|p| p.body == body).map_or(world.bodies[body.index()].pose.position, |p| p.position)
}

/// Energy of all springs \[J\].
fn spring_energy(world: &World, frame: &[PoseRow]) -> f64 {
    let energy = |link: &Link| match *link {
        Link::Spring { body, to, rest_length, stiffness, .. } => {
            let far = match to {
                SpringEnd::Point(point) => point,
                SpringEnd::Body(other) => position_of(world, frame, other),
            };
            0.5 * stiffness * (position_of(world, frame, body).distance(far) - rest_length).powi(2)
        }
        Link::Hang { .. } => 0.0,
    };
    world.links.iter().map(energy).sum()
}

/// Energy of gravity \[J\].
fn height_energy(world: &World, frame: &[PoseRow]) -> f64 {
    frame.iter().map(|p| -world.bodies[p.body.index()].mass * world.gravity.dot(p.position)).sum()
}

/// Energy of gravity of the hung balls above the lowest points of their rods \[J\].
fn lifted_energy(world: &World) -> f64 {
    let lifted = |link: &Link| match *link {
        Link::Hang { body, anchor } => {
            let hung = &world.bodies[body.index()];
            let (down, arm) = (world.gravity, hung.pose.position - anchor);
            hung.mass * (down.length() * arm.length() - down.dot(arm))
        }
        Link::Spring { .. } => 0.0,
    };
    world.links.iter().map(lifted).sum()
}

/// Poses at the pose rate. Impacts write poses of their own, which precede the sample of the same time.
fn samples(poses: &[PoseRow]) -> Vec<PoseRow> {
    let mut sorted: Vec<PoseRow> =
        poses.iter().filter(|p| (p.time * POSE_RATE).fract() == 0.0).copied().collect();
    sorted.sort_by(|p, q| p.time.total_cmp(&q.time).then(p.body.cmp(&q.body)));
    let last =
        |k: usize| sorted.get(k + 1).is_none_or(|q| (q.time, q.body) != (sorted[k].time, sorted[k].body));
    (0..sorted.len()).filter(|&k| last(k)).map(|k| sorted[k]).collect()
}

fn drift(world: &World, duration: f64) -> Result<Drift, SimulationError> {
    let (timeline, report) = run(world, &settings(duration, false, POSE_RATE))?;
    let moving = world.bodies.iter().filter(|b| b.motion == Motion::Free).count();
    let frames = samples(&timeline.poses);
    assert_eq!(frames.len(), moving * (1 + (duration * POSE_RATE).round() as usize));
    let energy = |f: &[PoseRow]| kinetic_energy(world, f) + height_energy(world, f) + spring_energy(world, f);
    let first = &frames[..moving];
    let scale = kinetic_energy(world, first) + spring_energy(world, first) + lifted_energy(world);
    let mut found = Drift { impacts: report.impacts as usize, ..Drift::default() };
    let (begin, mut least) = (energy(first), energy(first));
    for frame in frames.chunks(moving) {
        let now = energy(frame);
        found.growth = found.growth.max((now - least) / scale);
        found.loss = found.loss.max((begin - now) / scale);
        least = least.min(now);
        for link in &world.links {
            let Link::Hang { body, anchor } = *link else { continue };
            let length = world.bodies[body.index()].pose.position.distance(anchor);
            let error = position_of(world, frame, body).distance(anchor) / length - 1.0;
            found.rods = if error.is_finite() { found.rods.max(error.abs()) } else { f64::INFINITY };
        }
    }
    Ok(found)
}

/// Five balls of which the first `lifted` are drawn aside.
fn cradle(length: f64, degrees: f64, restitution: f64, lifted: usize) -> World {
    let (radius, gap) = (0.011, 1e-5);
    let steel = material(restitution, 0.1, 0.0);
    let anchor = |k: usize| DVec3::new(k as f64 * (2.0 * radius + gap), 0.0, 0.0);
    let angle = |k: usize| if k < lifted { -degrees.to_radians() } else { 0.0 };
    let bodies =
        (0..5).map(|k| sphere(radius, hung_at(anchor(k), angle(k), length), DVec3::ZERO, &steel)).collect();
    world(bodies, (0..5).map(|k| hang(k, anchor(k))).collect(), G)
}

/// A ball shot at the first of three hung ones, 2 mm off its centre and 20° upwards.
fn shot(length: f64, speed: f64, restitution: f64) -> World {
    let radius = 0.011;
    let steel = material(restitution, 0.1, 0.0);
    let anchor = |k: usize| DVec3::new(0.03 * k as f64, 0.0, 0.0);
    let mut bodies: Vec<_> =
        (0..3).map(|k| sphere(radius, hung_at(anchor(k), 0.0, length), DVec3::ZERO, &steel)).collect();
    let direction = DVec3::new(0.94, 0.34, 0.0).normalize();
    let from = hung_at(anchor(0), 0.0, length) - direction * 0.05 + DVec3::Z * 2e-3;
    bodies.push(sphere(radius, from, direction * speed, &steel));
    world(bodies, (0..3).map(|k| hang(k, anchor(k))).collect(), G)
}

/// The scenes by name, for one restitution.
fn designed(restitution: f64) -> Vec<(String, World)> {
    let mut scenes = Vec::new();
    for length in [0.1, 0.15, 0.4] {
        for (degrees, lifted) in [(30.0, 1), (55.0, 2), (70.0, 1), (90.0, 1), (105.0, 2), (120.0, 1)] {
            let name = format!("cradle of {length} m drawn to {degrees}°");
            scenes.push((name, cradle(length, degrees, restitution, lifted)));
        }
        for speed in [1.0, 3.0, 10.0, 25.0] {
            scenes.push((format!("shot of {speed} m/s at {length} m"), shot(length, speed, restitution)));
        }
    }
    scenes
}

/// Runs all scenes and holds them to the bars.
fn hold(scenes: Vec<(String, World)>, duration: f64, lossless: bool) {
    let (mut worst, count) = (Drift::default(), scenes.len());
    let mut failed = Vec::new();
    for (name, world) in scenes {
        if count > 100 {
            println!("start {name}");
        }
        let began = std::time::Instant::now();
        let done = drift(&world, duration);
        if began.elapsed().as_secs_f64() > 0.3 {
            println!("SLOW {name} {:?}", began.elapsed());
        }
        match done {
            Ok(found) => {
                if count < 100 {
                    println!("{name} {found:?}");
                }
                let kept = !lossless || found.loss <= BAR;
                if !(found.rods <= BAR && found.growth <= BAR && kept) {
                    failed.push(format!("{name}: {found:?}"));
                }
                worst = worst.worst(found);
            }
            Err(error) => failed.push(format!("{name}: {error}")),
        }
    }
    println!("{count} scenes: {worst:.1?}");
    assert!(failed.is_empty(), "{} of {count} fail:\n{}", failed.len(), failed.join("\n"));
}

#[test]
fn cradles_and_shots_run_at_any_speed() {
    for restitution in [1.0, 0.9, 0.5] {
        hold(designed(restitution), 3.0, false);
    }
}

/// Uniform numbers by SplitMix64.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn chance(&mut self, share: f64) -> bool {
        self.next() < share
    }

    fn direction(&mut self) -> DVec3 {
        let (z, angle) = (self.between(-1.0, 1.0), self.between(0.0, TAU));
        let flat = (1.0 - z * z).sqrt();
        DVec3::new(flat * angle.cos(), flat * angle.sin(), z)
    }
}

fn clear_of(bodies: &[Body], at: DVec3) -> bool {
    bodies.iter().all(|b| b.pose.position.distance(at) > 0.035)
}

/// One to six balls on one or two rods, some on springs, some shot at; perhaps a post and a floor.
fn random_world(seed: u64) -> World {
    let mut draw = Draw(seed);
    let restitution = if draw.chance(0.3) { 1.0 } else { draw.between(0.3, 1.0) };
    let steel = material(restitution, if draw.chance(0.5) { 0.0 } else { draw.between(0.0, 0.5) }, 0.0);
    let gravity = if draw.chance(0.15) { 0.0 } else { draw.between(1.0, 20.0) };
    let (mut bodies, mut links): (Vec<Body>, Vec<Link>) = (Vec::new(), Vec::new());
    let (count, in_line) = (1 + (draw.next() * 6.0) as usize, draw.chance(0.4));
    let (length, radius) = (draw.between(0.05, 0.5), draw.between(0.005, 0.015));
    let gap = if draw.chance(0.3) { 0.0 } else { 10.0_f64.powf(draw.between(-9.0, -3.0)) };
    let (drawn, lifted) = (draw.between(-PI, 0.0), (draw.next() * 3.0) as usize);
    while bodies.len() < count {
        let k = bodies.len();
        if in_line {
            let anchor = DVec3::X * (k as f64 * (2.0 * radius + gap));
            let angle = if k <= lifted { drawn } else { 0.0 };
            let push = if k == 0 { draw.between(0.0, 5.0) } else { 0.0 };
            let along = DVec3::new(angle.cos(), angle.sin(), 0.0);
            bodies.push(sphere(radius, hung_at(anchor, angle, length), along * push, &steel));
            links.push(hang(k, anchor));
            continue;
        }
        let anchor = DVec3::new(draw.between(-0.2, 0.2), draw.between(-0.1, 0.1), draw.between(-0.2, 0.2));
        let arm = draw.direction() * draw.between(0.05, 0.5);
        let across = arm.cross(draw.direction()).normalize() * draw.between(0.1, 5.0);
        if clear_of(&bodies, anchor + arm) {
            let size = draw.between(0.005, 0.015);
            bodies.push(sphere(size, anchor + arm, across, &steel));
            links.push(hang(k, anchor));
            if draw.chance(0.2) {
                links.push(hang(k, anchor + draw.direction() * draw.between(0.05, 0.2)));
            }
        }
    }
    if draw.chance(0.4) {
        let stiffness = 10.0_f64.powf(draw.between(0.0, 3.0));
        let (body, rest_length) = (BodyId(0), draw.between(0.0, 0.3));
        let damping = if draw.chance(0.5) { 0.0 } else { draw.between(0.0, 0.5) };
        let far = SpringEnd::Point(draw.direction() * 0.3);
        let to = if count > 1 && draw.chance(0.5) { SpringEnd::Body(BodyId(1)) } else { far };
        links.push(Link::Spring { body, to, rest_length, stiffness, damping });
    }
    for _ in 0..(draw.next() * 3.0) as usize {
        let target = &bodies[(draw.next() * count as f64) as usize];
        let (at, direction) = (target.pose.position, draw.direction());
        let aim = draw.direction() * draw.between(0.0, 0.01);
        let from = at - direction * draw.between(0.04, 0.3) + aim;
        if clear_of(&bodies, from) {
            let velocity = direction * draw.between(1.0, 25.0);
            bodies.push(sphere(draw.between(0.005, 0.015), from, velocity, &steel));
        }
    }
    let post = draw.direction() * draw.between(0.1, 0.4);
    if draw.chance(0.2) && clear_of(&bodies, post) {
        bodies.push(Body { motion: Motion::Fixed, ..sphere(0.01, post, DVec3::ZERO, &steel) });
    }
    if draw.chance(0.2) {
        let lowest = bodies.iter().map(|b| b.pose.position.y).fold(0.0, f64::min);
        let under = DVec3::Y * (lowest - draw.between(0.016, 0.1));
        bodies.push(plane(under, DVec3::Y, &steel));
    }
    world(bodies, links, gravity)
}

#[test]
fn random_hung_balls_run_at_any_speed() {
    let scenes = (FROM()..TO()).map(|seed| (format!("seed {seed}"), random_world(seed))).collect();
    hold(scenes, 1.0, false);
}

#[test]
fn lossless_hung_balls_keep_their_energy() {
    let lossless = |length: f64, speed: f64| {
        let mut scene = shot(length, speed, 1.0);
        for body in &mut scene.bodies {
            body.material.friction = 0.0;
        }
        (format!("shot of {speed} m/s at {length} m without friction"), scene)
    };
    let scenes = [0.1, 0.4].iter().flat_map(|&l| [1.0, 5.0, 25.0].map(|v| lossless(l, v)));
    hold(scenes.collect(), 3.0, true);
}
#[allow(non_snake_case)]
fn FROM() -> u64 {
    std::env::var("FROM").ok().and_then(|x| x.parse().ok()).unwrap_or(0)
}
#[allow(non_snake_case)]
fn TO() -> u64 {
    std::env::var("TO").ok().and_then(|x| x.parse().ok()).unwrap_or(300)
}
