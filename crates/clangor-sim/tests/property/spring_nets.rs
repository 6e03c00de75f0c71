//! Nets of springs of any stiffness and damping between light bodies that are thrown, spin, and collide:
//! energy never grows, momentum balances, and every run ends.

use clangor_core::body::{Body, BodyId, Link, LinkEnd, World};
use clangor_core::glam::DVec3;
use clangor_sim::rigid::{RigidWorld, StepLog};

use crate::scenes::{Random, ball, cuboid, floor, material, solid, world};

/// Steps of a run.
const STEPS: usize = 200;
/// Seeds of each kind of net.
const SEEDS: u64 = 16;

/// What a net is like.
#[derive(Clone, Copy, Debug)]
struct Kind {
    /// Powers of ten of the stiffness \[N/m\].
    decades: [f64; 2],
    /// Whether springs have dampers of 1e-3 to 1e6 N s/m.
    damped: bool,
    /// Whether springs are attached off the centres of mass.
    off_centre: bool,
    /// Fastest spin \[rad/s\].
    spin: f64,
    /// Fastest speed \[m/s\].
    speed: f64,
    /// Whether two balls are thrown into the net, above a floor.
    contacts: bool,
    /// Most strain at the start; above 0.1, a fifth of the springs has no rest length.
    strain: f64,
}

/// Springs of 1e4 to 1e12 N/m without strain.
const STIFF: Kind = Kind {
    decades: [4.0, 12.0],
    damped: false,
    off_centre: false,
    spin: 0.0,
    speed: 5.0,
    contacts: false,
    strain: 0.0,
};
/// Springs of 0.1 to 1000 N/m, with much strain.
const SOFT: Kind = Kind { decades: [-1.0, 3.0], strain: 0.5, ..STIFF };
/// Springs of every stiffness.
const MIXED: Kind = Kind { decades: [-1.0, 12.0], strain: 0.1, off_centre: true, spin: 1e3, ..STIFF };

/// Two to six balls and bars of 0.5 to 5 mm in a row, thrown in all directions.
fn thrown(random: &mut Random, kind: Kind, spacing: f64) -> Vec<Body> {
    let steel = material(7850.0, 0.3 + 0.6 * random.unit(), 0.3, 0.0);
    let count = 2 + (random.unit() * 5.0) as u32;
    let mut bodies = Vec::new();
    for k in 0..count {
        let radius = 10_f64.powf(-3.3 + random.unit());
        let bar = || solid("bar", &steel, &[cuboid(DVec3::new(3.0, 1.0, 0.6) * radius)]);
        let mut body = if k % 3 < 2 { ball(&steel, radius) } else { bar() };
        body.pose.position = DVec3::X * spacing * f64::from(k) + random.direction() * 0.2 * spacing;
        body.velocity = random.direction() * kind.speed * random.unit();
        body.angular_velocity = random.direction() * kind.spin * random.unit();
        bodies.push(body);
    }
    bodies
}

/// A spring between a body and the next one, or a point nearby.
fn spring(random: &mut Random, kind: Kind, (bodies, near): (&[Body], u32), spacing: f64) -> Link {
    let next = (near + 1) % bodies.len() as u32;
    let mut hold = |body: u32| {
        let radius = bodies[body as usize].surface.bounding_radius();
        if kind.off_centre { random.direction() * 0.9 * radius } else { DVec3::ZERO }
    };
    let (at, far) = (hold(near), hold(next));
    let place = |body: u32| bodies[body as usize].pose.position;
    let (to, other) = if random.unit() < 0.5 {
        let point = place(near) + random.direction() * spacing * (0.5 + random.unit());
        (LinkEnd::Point(point), point)
    } else {
        (LinkEnd::Body { body: BodyId(next), at: far }, place(next) + far)
    };
    let stiffness = 10_f64.powf(kind.decades[0] + (kind.decades[1] - kind.decades[0]) * random.unit());
    let damping = if kind.damped { 10_f64.powf(-3.0 + 9.0 * random.unit()) } else { 0.0 };
    let length = (place(near) + at).distance(other);
    let slack = kind.strain > 0.1 && random.unit() < 0.2;
    let rest_length = if slack { 0.0 } else { length * (1.0 + kind.strain * random.signed()) };
    Link::Spring { body: BodyId(near), at, to, rest_length, stiffness, damping }
}

fn net(seed: u64, kind: Kind) -> World {
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let spacing = 0.02 + 0.03 * random.unit();
    let mut bodies = thrown(&mut random, kind, spacing);
    let count = bodies.len() as u32;
    let springs = count + (random.unit() * f64::from(2 * count)) as u32;
    let links = (0..springs).map(|k| spring(&mut random, kind, (&bodies, k % count), spacing)).collect();
    if kind.contacts {
        let steel = material(7850.0, 0.9, 0.3, 0.0);
        for k in 0..2_u32 {
            let mut missile = ball(&steel, 0.002);
            let x = spacing * f64::from(count) * random.unit();
            missile.pose.position = DVec3::new(x, 0.08 + 0.02 * f64::from(k), 0.0);
            let aim = bodies[(k % count) as usize].pose.position - missile.pose.position;
            missile.velocity = aim.normalize() * kind.speed;
            bodies.push(missile);
        }
        let mut below = floor(&steel);
        below.pose.position = DVec3::NEG_Y * 0.05;
        bodies.push(below);
    }
    World { links, ..world(bodies) }
}

fn time_step(seed: u64) -> f64 {
    [1e-5, 1e-4, 2.5e-4, 1e-3][seed as usize % 4]
}

/// Largest growth of the energy of motion and weight, and of that energy with the springs, both relative to
/// the motion and the strain of the start. With the springs, it is the lesser of two steps in a row: in the
/// step in which a spring passes through no length its energy has no exact value.
fn growth(seed: u64, kind: Kind) -> (f64, f64) {
    let mut rigid = RigidWorld::try_new(&net(seed, kind), time_step(seed), true).unwrap();
    let mut log = StepLog::new();
    let first = rigid.energy() + rigid.spring_energy();
    let scale = rigid.kinetic_energy() + rigid.spring_energy();
    let (mut motion, mut all, mut last) = (0.0_f64, 0.0_f64, first);
    for _ in 0..STEPS {
        // Nets of springs alone can always be followed.
        rigid.step(&mut log).unwrap_or_else(|error| panic!("net {seed}, {kind:?}: {error}"));
        motion = motion.max(rigid.energy() - first);
        let now = rigid.energy() + rigid.spring_energy();
        all = all.max(now.min(last) - first);
        last = now;
    }
    (motion / scale, all / scale)
}

/// Bodies never move with more energy than there was, on springs of any stiffness and damping, whatever
/// they are attached to, hit, or spin by in a step.
#[test]
fn nets_of_stiff_springs_never_throw_bodies_faster() {
    let kinds = [
        STIFF,
        Kind { damped: true, ..STIFF },
        Kind { strain: 1e-3, ..STIFF },
        Kind { strain: 0.3, ..STIFF },
        Kind { contacts: true, ..STIFF },
        Kind { off_centre: true, spin: 1e2, ..STIFF },
        Kind { off_centre: true, spin: 1e4, ..STIFF },
        Kind { off_centre: true, spin: 1e3, contacts: true, ..STIFF },
        Kind { damped: true, ..SOFT },
        Kind { damped: true, contacts: true, ..MIXED },
        Kind { speed: 50.0, contacts: true, ..MIXED },
    ];
    for kind in kinds {
        let grown = (1..=SEEDS).map(|seed| (growth(seed, kind).0, seed));
        let (worst, seed) = grown.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        println!("{kind:?}: {worst:.1e} in net {seed}");
        // Seen: none. Without the balance: factors of 1e1 to 9e4 and more, and an error in 64 of 176 runs.
        assert!(worst <= 1e-3, "{kind:?}, net {seed}: {worst:e}");
    }
}

/// Undamped springs that a step follows keep motion and strain together, or lose some.
#[test]
fn nets_of_soft_springs_gain_no_energy() {
    let kinds = [SOFT, Kind { off_centre: true, spin: 1e4, ..SOFT }];
    for kind in kinds {
        let grown = (1..=2 * SEEDS).map(|seed| (growth(seed, kind).1, seed));
        let (worst, seed) = grown.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        println!("{kind:?}: {worst:.1e} in net {seed}");
        // Seen: 6e-4.
        assert!(worst <= 2e-3, "{kind:?}, net {seed}: {worst:e}");
    }
}

/// A free net of light balls that turn about each other by large angles in a step keeps its momentum, and the
/// log holds every impulse.
#[test]
fn braked_nets_balance_momentum() {
    let steel = material(7850.0, 0.5, 0.3, 0.0);
    let mut random = Random(77);
    let mut bodies = Vec::new();
    for k in 0..4 {
        let mut body = ball(&steel, 0.001);
        body.pose.position = DVec3::X * 0.01 * f64::from(k) + random.direction() * 0.002;
        body.velocity = random.direction() * 20.0;
        body.angular_velocity = random.direction() * 1e3;
        bodies.push(body);
    }
    let mut links = Vec::new();
    for (a, b) in [(0_u32, 1_u32), (1, 2), (2, 3), (3, 0), (0, 2)] {
        let [at, far] = [0, 1].map(|_| random.direction() * 0.0008);
        let place = |body: u32| bodies[body as usize].pose.position;
        let rest_length = (place(a) + at).distance(place(b) + far);
        let to = LinkEnd::Body { body: BodyId(b), at: far };
        links.push(Link::Spring { body: BodyId(a), at, to, rest_length, stiffness: 1e9, damping: 0.0 });
    }
    let world = World { gravity: DVec3::ZERO, links, ..world(bodies) };
    let mut rigid = RigidWorld::try_new(&world, 1e-3, true).unwrap();
    let mut log = StepLog::new();
    let state = |rigid: &RigidWorld| [0, 1, 2, 3].map(|body| rigid.momentum(BodyId(body)));
    let total = |all: [(DVec3, DVec3); 4]| all.iter().map(|own| own.0).sum::<DVec3>();
    let (first, energy) = (total(state(&rigid)), rigid.kinetic_energy());
    let scale = world.bodies[0].mass * 20.0;
    let (mut worst, mut drift, mut most) = ([0.0_f64; 2], 0.0_f64, 0.0_f64);
    for _ in 0..STEPS {
        let before = state(&rigid);
        rigid.step(&mut log).unwrap();
        let mut sums = [(DVec3::ZERO, DVec3::ZERO); 4];
        for impulse in log.impulses() {
            let row = &impulse.row;
            for (body, arm, sign) in [(row.body_a, impulse.arm_a, 1.0), (row.body_b, impulse.arm_b, -1.0)] {
                let Some(sum) = sums.get_mut(body.index()) else { continue };
                sum.0 += row.impulse() * sign;
                sum.1 += (arm.cross(row.impulse()) + row.couple) * sign;
            }
        }
        for ((after, before), sum) in state(&rigid).iter().zip(before).zip(sums) {
            worst[0] = worst[0].max((after.0 - before.0 - sum.0).length() / scale);
            worst[1] = worst[1].max((after.1 - before.1 - sum.1).length() / (scale * 1e-3));
        }
        drift = drift.max((total(state(&rigid)) - first).length() / scale);
        most = most.max(rigid.kinetic_energy() / energy);
    }
    println!("imbalance {worst:?}, drift of the momentum {drift:.1e}, energy {most}");
    // Seen: 1.9e-16 and 1.1e-18; 1.6e-11; 0.37.
    assert!(worst[0] < 1e-9 && worst[1] < 1e-9, "{worst:?}");
    assert!(drift < 1e-9, "{drift:e}");
    assert!(most <= 1.001, "{most}");
}

/// Springs of absurd stiffness, mass, damping and length end in a result or an error, and never in a panic.
#[test]
fn absurd_springs_end_in_order() {
    let steel = material(7850.0, 0.5, 0.3, 0.0);
    let mut refused = 0;
    for (stiffness, damping) in
        [(1e308, 0.0), (1e12, 1e308), (1e-300, 0.0), (f64::INFINITY, 0.0), (1.0, -1.0)]
    {
        for mass in [1e-30, 1e-3, 1e30] {
            for (at, rest_length) in [(DVec3::ZERO, 0.0), (DVec3::X * 0.001, 0.0), (DVec3::X * 0.001, 1e300)]
            {
                let mut body = ball(&steel, 0.001);
                body.inertia *= mass / body.mass;
                body.mass = mass;
                body.velocity = DVec3::Y * 5.0;
                let fixed = LinkEnd::Point(at);
                let same = LinkEnd::Body { body: BodyId(0), at: -at };
                let link = |to| Link::Spring { body: BodyId(0), at, to, rest_length, stiffness, damping };
                let world = World { links: vec![link(fixed), link(same)], ..world(vec![body]) };
                let Ok(mut rigid) = RigidWorld::try_new(&world, 2.5e-4, true) else {
                    refused += 1;
                    continue;
                };
                let mut log = StepLog::new();
                let ended = (0..20).try_for_each(|_| rigid.step(&mut log));
                refused += u32::from(ended.is_err());
            }
        }
    }
    println!("{refused} refused of 45");
    // Eighteen have no numbers or a negative one.
    assert!(refused >= 18, "{refused}");
}
