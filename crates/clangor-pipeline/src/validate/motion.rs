//! Motion between impacts and the balance of the log: pendulum, rolling, momentum of a pile.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use clangor_core::body::{Body, BodyId, Link, World};
use clangor_core::glam::DVec3;
use clangor_core::material::Material;
use clangor_core::shape::Shape;
use clangor_core::timeline::{PoseRow, Timeline};
use clangor_sim::record::RecordSettings;
use clangor_sim::rigid::{Impulse, RigidWorld, StepLog};
use clangor_sim::{ContactModel, SimulationSettings, Solver, simulate};

use super::dynamics::{GRAVITY, RADIUS, ball, material, plane};
use super::{Check, Extent, Fault, Outcome, Validation};

const SECTION: &str = "Motion and balance";

pub(super) fn run(extent: Extent, table: &mut Validation) -> Outcome {
    pendulum(table)?;
    sliding(table)?;
    balance(extent, table)
}

fn poses(world: &World, duration: f64, pose_rate: f64) -> Result<Vec<PoseRow>, Fault> {
    let mut timeline = Timeline::default();
    let settings = SimulationSettings {
        solver: Solver::Spheres,
        contact: ContactModel::Rigid,
        duration,
        time_step: 2.5e-4,
        record: RecordSettings { v_min: 0.05, pose_rate, raw: false },
        sleep: false,
    };
    simulate(world, &settings, &mut timeline, &mut |_| ControlFlow::Continue(()))?;
    Ok(timeline.poses)
}

/// A pendulum of large swing passes the bottom after quarter periods of the complete elliptic integral.
fn pendulum(table: &mut Validation) -> Outcome {
    let (length, swing) = (0.25, 1.0_f64);
    let anchor = DVec3::Y;
    let start = anchor + DVec3::new(swing.sin(), -swing.cos(), 0.0) * length;
    let bob = ball("bob", &material(1.0, 0.0)?, start, DVec3::ZERO);
    let world = World {
        bodies: vec![bob],
        links: vec![Link::Hang { body: BodyId(0), anchor }],
        gravity: DVec3::NEG_Y * GRAVITY,
    };
    // T = 4 √(L/g) K(sin(θ/2)) with K by the arithmetic-geometric mean.
    let (mut a, mut b) = (1.0, (0.5 * swing).cos());
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), f64::sqrt(a * b));
    }
    let period = 2.0 * PI / a * (length / GRAVITY).sqrt();
    // After ten and a quarter periods it hangs straight down: the pose there is where it is at the end.
    let end = 10.25 * period;
    let rows = poses(&world, end, 1.0 / end)?;
    let last = rows.iter().filter(|p| p.time <= end * (1.0 + 1e-12)).max_by(|p, q| p.time.total_cmp(&q.time));
    let last = last.ok_or("the pendulum has no pose at its end")?;
    table.checks.push(Check {
        section: SECTION,
        quantity:
            "pendulum of 1 rad swing: distance from the lowest point after 10¼ periods, over its length"
                .into(),
        reference: "period by the complete elliptic integral",
        error: (last.position - (anchor - DVec3::Y * length)).length() / length,
        bar: 1e-9,
        unit: "",
    });
    Ok(())
}

/// A ball that starts sliding ends up rolling at 5/7 of its speed.
fn sliding(table: &mut Validation) -> Outcome {
    let material = Material { friction: 0.2, rolling_loss: 0.0, ..material(0.5, 0.2)? };
    let bodies =
        vec![ball("ball", &material, DVec3::Y * RADIUS, DVec3::X), plane(&material, DVec3::ZERO, DVec3::Y)];
    let world = World { bodies, links: Vec::new(), gravity: DVec3::NEG_Y * GRAVITY };
    let rows = poses(&world, 0.5, 10.0)?;
    let last = rows.iter().filter(|p| p.body == BodyId(0)).max_by(|p, q| p.time.total_cmp(&q.time));
    let last = last.ok_or("the ball has no pose at its end")?;
    table.checks.push(Check {
        section: SECTION,
        quantity: "ball that slides until it rolls: speed, over the speed at which it started".into(),
        reference: "5/7",
        error: (last.velocity.x - 5.0 / 7.0).abs(),
        bar: 1e-9,
        unit: "",
    });
    Ok(())
}

/// What the log of a pile says, against what its bodies do, in every step.
fn balance(extent: Extent, table: &mut Validation) -> Outcome {
    let (rocks, duration) = match extent {
        Extent::Quick => (20, 0.6),
        Extent::Full => (60, 1.5),
    };
    let material = Material { rolling_loss: 5e-5, ..material(0.4, 0.5)? };
    let mut bodies = vec![plane(&material, DVec3::ZERO, DVec3::Y)];
    for axis in [DVec3::X, DVec3::Z] {
        bodies.push(plane(&material, axis * -0.06, axis));
        bodies.push(plane(&material, axis * 0.06, -axis));
    }
    let first = bodies.len();
    for i in 0..rocks {
        let (surface, mass) = Shape::parse(&format!("rock:{i}x0.012@0.006"))?.surface()?;
        let cell = DVec3::new(f64::from(i % 3) - 1.0, f64::from(i / 6) + 0.8, f64::from(i / 3 % 2) - 0.5);
        let upright = ball(&format!("rock {i}"), &material, cell * 0.036, DVec3::ZERO);
        bodies.push(Body {
            surface: surface.into(),
            mass: material.density * mass.volume,
            inertia: mass.inertia * material.density,
            ..upright
        });
    }
    let world = World { bodies, links: Vec::new(), gravity: DVec3::NEG_Y * GRAVITY };
    let time_step = 2.5e-4;
    let mut rigid = RigidWorld::try_new(&world, time_step, true)?;
    let mut log = StepLog::new();
    let mut worst = 0.0_f64;
    for _ in 0..(duration / time_step) as usize {
        let free = first..world.bodies.len();
        let state = |rigid: &RigidWorld| -> Vec<_> {
            free.clone()
                .map(|i| (rigid.momentum(BodyId(i as u32)), rigid.is_asleep(BodyId(i as u32))))
                .collect()
        };
        let before = state(&rigid);
        rigid.step(&mut log)?;
        let mut sums = vec![(DVec3::ZERO, DVec3::ZERO, 0.0); world.bodies.len()];
        for Impulse { row, arm_a, arm_b } in log.impulses() {
            for (body, arm, sign) in [(row.body_a, arm_a, 1.0), (row.body_b, arm_b, -1.0)] {
                let Some(sum) = sums.get_mut(body.index()) else { continue };
                sum.0 += row.impulse() * sign;
                sum.1 += (arm.cross(row.impulse()) + row.couple) * sign;
                sum.2 += row.impulse().length();
            }
        }
        for ((i, (was, slept)), (is, sleeps)) in free.clone().zip(before).zip(state(&rigid)) {
            if slept && sleeps {
                continue;
            }
            let weight = world.gravity * (world.bodies[i].mass * time_step);
            let (linear, angular, size) = sums[i];
            let scale = size + weight.length();
            let arm = world.bodies[i].surface.bounding_radius();
            worst = worst.max((is.0 - was.0 - weight - linear).length() / scale);
            worst = worst.max((is.1 - was.1 - angular).length() / (scale * arm));
        }
    }
    table.checks.push(Check {
        section: SECTION,
        quantity: format!(
            "pile of {rocks} rocks with sleep: momentum and angular momentum of every body in every step"
        ),
        reference: "weight and the logged impulses and couples",
        error: worst,
        bar: 1e-10,
        unit: "",
    });
    Ok(())
}
