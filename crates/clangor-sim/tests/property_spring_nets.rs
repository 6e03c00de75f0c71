//! Nets of springs of any stiffness, with light bodies thrown into them: energy never grows.

#[path = "scenes/rigid.rs"]
#[allow(dead_code)]
mod scenes;

use clangor_core::body::{Body, BodyId, Link, LinkEnd, World};
use clangor_core::glam::DVec3;
use clangor_sim::SimulationError;
use clangor_sim::rigid::{RigidWorld, StepLog};

use scenes::{Random, ball, cuboid, floor, material, solid, world};

#[derive(Clone, Copy, Debug)]
struct Kind {
    decades: [f64; 2],
    damped: bool,
    off_centre: bool,
    spin: f64,
    speed: f64,
    contacts: bool,
    strain: f64,
    gravity: bool,
}

fn net(seed: u64, kind: Kind) -> World {
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let steel = material(7850.0, if seed % 2 == 0 { 0.9 } else { 0.3 }, 0.3, 0.0);
    let mut bodies = Vec::new();
    let count = 2 + (random.unit() * 5.0) as u32;
    let spacing = 0.02 + 0.03 * random.unit();
    for k in 0..count {
        let radius = 10_f64.powf(-3.3 + 1.0 * random.unit());
        let bar = || solid("bar", &steel, &[cuboid(DVec3::new(radius * 3.0, radius, 0.6 * radius))]);
        let mut body = if k % 3 < 2 { ball(&steel, radius) } else { bar() };
        body.pose.position = DVec3::X * spacing * f64::from(k) + random.direction() * 0.2 * spacing;
        body.velocity = random.direction() * kind.speed * random.unit();
        body.angular_velocity = random.direction() * kind.spin * random.unit();
        bodies.push(body);
    }
    let mut links = Vec::new();
    let springs = count + (random.unit() * f64::from(2 * count)) as u32;
    for k in 0..springs {
        let near = k % count;
        let radius = |body: u32| bodies[body as usize].surface.bounding_radius();
        let mut hold = |body: u32| if kind.off_centre { random.direction() * 0.9 * radius(body) } else { DVec3::ZERO };
        let at = hold(near);
        let far = hold((near + 1) % count);
        let anchored = random.unit() < 0.5;
        let to = if anchored {
            LinkEnd::Point(bodies[near as usize].pose.position + random.direction() * spacing * (0.5 + random.unit()))
        } else {
            LinkEnd::Body { body: BodyId((near + 1) % count), at: far }
        };
        let stiffness = 10_f64.powf(kind.decades[0] + (kind.decades[1] - kind.decades[0]) * random.unit());
        let damping = if kind.damped { 10_f64.powf(-3.0 + 9.0 * random.unit()) } else { 0.0 };
        let place = |body: u32, at: DVec3| bodies[body as usize].pose.position + at;
        let other = match to {
            LinkEnd::Point(point) => point,
            LinkEnd::Body { body, at } => place(body.0, at),
        };
        let length = place(near, at).distance(other);
        let rest_length = if random.unit() < 0.2 && kind.strain > 0.1 { 0.0 } else { length * (1.0 + kind.strain * random.signed()) };
        links.push(Link::Spring { body: BodyId(near), at, to, rest_length, stiffness, damping });
    }
    if kind.contacts {
        for k in 0..2 {
            let mut thrown = ball(&steel, 0.002);
            thrown.pose.position = DVec3::new(spacing * f64::from(count) * random.unit(), 0.08 + 0.02 * f64::from(k), 0.0);
            thrown.velocity = (bodies[(k as usize) % count as usize].pose.position - thrown.pose.position).normalize() * kind.speed;
            bodies.push(thrown);
        }
        let mut below: Body = floor(&steel);
        below.pose.position = DVec3::NEG_Y * 0.05;
        bodies.push(below);
    }
    let gravity = if kind.gravity { DVec3::NEG_Y * 9.81 } else { DVec3::ZERO };
    World { gravity, links, ..world(bodies) }
}

/// Growth of the energy of a run, relative to the largest before; and how it ended.
fn run(world: &World, step: f64, steps: usize) -> Result<(f64, f64, f64, Result<(), SimulationError>), SimulationError> {
    let mut rigid = RigidWorld::try_new(world, step, true)?;
    let mut log = StepLog::new();
    let stiff = |link: &Link| matches!(link, Link::Spring { .. });
    assert!(world.links.iter().any(stiff));
    let first = rigid.energy() + rigid.spring_energy();
    let base = first - (rigid.energy() - rigid.kinetic_energy());
    let mut most = 0.0_f64;
    let mut lowest = first;
    let mut rise = 0.0_f64;
    let ended = (0..steps).try_for_each(|_| {
        rigid.step(&mut log)?;
        let now = rigid.energy() + rigid.spring_energy();
        most = most.max(now - first);
        lowest = lowest.min(now);
        rise = rise.max(rigid.energy() - first);
        Ok(())
    });
    Ok((base, rise / base, most / base, ended))
}

#[test]
fn survey() {
    let sets: Vec<(&str, Kind)> = {
        let base = Kind { decades: [4.0, 12.0], damped: false, off_centre: false, spin: 0.0, speed: 5.0, contacts: false, strain: 0.0, gravity: true };
        vec![
            ("stiff", base),
            ("stiff damped", Kind { damped: true, ..base }),
            ("stiff strained", Kind { strain: 1e-3, ..base }),
            ("stiff very strained", Kind { strain: 0.3, ..base }),
            ("stiff contacts", Kind { contacts: true, ..base }),
            ("stiff off", Kind { off_centre: true, spin: 100.0, ..base }),
            ("stiff off spin", Kind { off_centre: true, spin: 10000.0, ..base }),
            ("stiff off all", Kind { off_centre: true, spin: 1000.0, contacts: true, ..base }),
            ("soft", Kind { decades: [-1.0, 3.0], strain: 0.5, ..base }),
            ("soft damped", Kind { decades: [-1.0, 3.0], strain: 0.5, damped: true, ..base }),
            ("soft off spin", Kind { decades: [-1.0, 3.0], strain: 0.5, off_centre: true, spin: 10000.0, ..base }),
            ("mixed all", Kind { decades: [-1.0, 12.0], strain: 0.1, off_centre: true, spin: 1000.0, contacts: true, damped: true, ..base }),
            ("mixed fast", Kind { decades: [-1.0, 12.0], strain: 0.1, off_centre: true, spin: 1000.0, speed: 50.0, contacts: true, ..base }),
        ]
    };
    for (name, kind) in sets {
        let (mut worst, mut worst_rise, mut failed, mut grew, mut count) = ((0.0, 0, 0.0), 0.0_f64, 0, 0, 0);
        let mut firsterr = None;
        for seed in 1..40 {
            let step = [1e-5, 1e-4, 2.5e-4, 1e-3][seed as usize % 4];
            let begin = std::time::Instant::now();
            let result = run(&net(seed, kind), step, 200);
            if begin.elapsed().as_secs_f64() > 0.5 { println!("   slow {name} {seed} {step} {:?} {:?}", begin.elapsed(), result.as_ref().map(|r| (r.0, r.1))); }
            match result {
                Ok((base, most, rise, ended)) => {
                    count += 1;
                    if most > 1e-3 || rise > 1e-3 { println!("   {name} {seed} {step} base {base:e} motion {most:e} total {rise:e}"); grew += 1; }
                    if most > worst.0 { worst = (most, seed, base); }
                    worst_rise = worst_rise.max(rise);
                    if let Err(e) = ended { failed += 1; firsterr.get_or_insert(e.to_string()); }
                }
                Err(e) => { firsterr.get_or_insert(format!("start {e}")); }
            }
        }
        println!("{name:22} {count} nets, {grew} grew, {failed} ended, worst {:.3e} (seed {}, {:.2e} J), total {worst_rise:.2e} {}", worst.0, worst.1, worst.2, firsterr.unwrap_or_default());
    }
}


#[test]
fn one() {
    let base = Kind { decades: [4.0, 12.0], damped: false, off_centre: false, spin: 0.0, speed: 5.0, contacts: false, strain: 0.0, gravity: true };
    let soft = Kind { decades: [-1.0, 3.0], strain: 0.5, ..base };
    let which: u64 = std::env::var("SEED").unwrap().parse().unwrap();
    let kind = match std::env::var("KIND").unwrap().as_str() { "soft" => soft, "off" => Kind { off_centre: true, spin: 1000.0, contacts: true, ..base }, _ => Kind { damped: true, ..base } };
    for (kind, seed, count) in [(kind, which, 200)] {
    let step = [1e-5, 1e-4, 2.5e-4, 1e-3][seed as usize % 4];
    let world = net(seed, kind);
    println!("==== {kind:?} {seed} {step}");
    for link in &world.links { if let Link::Spring { body, at, to, rest_length, stiffness, damping } = link { let m = world.bodies[body.index()].mass; println!("{body:?} {at:?} {to:?} {rest_length} {stiffness:e} {damping:e} m {} kw {:e}", m, stiffness / m * step * step); } }
    let mut rigid = RigidWorld::try_new(&world, step, true).unwrap();
    let mut log = StepLog::new();
    let mut last = rigid.energy() + rigid.spring_energy();
    println!("{:e} {:e} {:e} sum {last:e}", rigid.energy(), rigid.kinetic_energy(), rigid.spring_energy());
    for n in 0..count {
        if let Err(e) = rigid.step(&mut log) { println!("{e}"); break; }
        let now = rigid.energy() + rigid.spring_energy();
        if (now > last * 1.01 && now > 0.0) || n < 12 { println!("{n} U+K {:e} K {:e} V {:e} sum {now:e}", rigid.energy(), rigid.kinetic_energy(), rigid.spring_energy()); }
        last = now;
    }
    }
}
