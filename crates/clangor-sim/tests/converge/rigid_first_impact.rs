//! The first impact of tumbling bodies does not depend on the time step.

use clangor_core::body::Body;
use clangor_core::glam::DVec3;
use clangor_core::timeline::ContactRow;
use clangor_sim::rigid::{RigidWorld, StepLog};

use crate::scenes::{Random, cylinder, die, floor, material, rock, solid, world};

/// Rows of the first impact instant.
fn first_impact(bodies: &[Body], time_step: f64) -> Vec<ContactRow> {
    let mut rigid = RigidWorld::try_new(&world(bodies.to_vec()), time_step, false).unwrap();
    let mut log = StepLog::new();
    while rigid.time() < 0.5 {
        rigid.step(&mut log).unwrap();
        if let Some(first) = log.impulses().first() {
            let same = |row: &ContactRow| row.time == first.row.time;
            return log.impulses().iter().map(|i| i.row).filter(same).collect();
        }
    }
    panic!("nothing struck within 0.5 s");
}

/// Largest differences of time [s] and impulse (relative) between 0.1 or 0.25 ms and a fiftieth of it.
fn differences(bodies: &[Body]) -> (f64, f64) {
    let (mut time, mut impulse) = (0.0_f64, 0.0_f64);
    for time_step in [1e-4, 2.5e-4] {
        let (coarse, fine) = (first_impact(bodies, time_step), first_impact(bodies, time_step / 50.0));
        let total = |rows: &[ContactRow]| rows.iter().map(ContactRow::impulse).sum::<DVec3>();
        time = time.max((coarse[0].time - fine[0].time).abs());
        impulse = impulse.max((total(&coarse) - total(&fine)).length() / total(&fine).length());
    }
    (time, impulse)
}

fn thrown(mut body: Body, height: f64, seed: u64) -> Body {
    let mut random = Random(seed);
    body.pose.position = DVec3::new(0.0, height, 0.0);
    body.pose.orientation = random.orientation();
    body.velocity = DVec3::new(random.signed(), 0.0, random.signed()) * 0.3;
    body.angular_velocity = random.direction() * 60.0;
    body
}

#[test]
fn bodies_that_fall_on_a_floor() {
    let material = material(2500.0, 0.5, 0.4, 0.0);
    let (mut time, mut impulse) = (0.0_f64, 0.0_f64);
    for seed in 1..6 {
        let shapes = [
            solid("die", &material, &[die(0.008, 0.0008)]),
            solid("rock", &material, &[rock(seed, 20, 0.015)]),
            cylinder(&material, 0.01213, 0.000875),
        ];
        for shape in shapes {
            let differ = differences(&[floor(&material), thrown(shape, 0.15, seed * 77)]);
            (time, impulse) = (time.max(differ.0), impulse.max(differ.1));
        }
    }
    println!("floor: time {time:.2e} s, impulse {impulse:.2e}");
    // Residuals seen: 7.6e-12 s and 1.6e-9.
    assert!(time < 1e-7 && impulse < 1e-5, "time {time:.2e} s, impulse {impulse:.2e}");
}

#[test]
fn rocks_that_meet_in_the_air() {
    let material = material(2500.0, 0.5, 0.4, 0.0);
    let (mut time, mut impulse) = (0.0_f64, 0.0_f64);
    for seed in 1..6 {
        let mut low = thrown(solid("low", &material, &[rock(seed, 20, 0.015)]), 1.0, seed * 31);
        let mut high = thrown(solid("high", &material, &[rock(seed + 50, 16, 0.015)]), 1.06, seed * 57);
        low.velocity = DVec3::Y;
        high.velocity = DVec3::new(0.1, -0.5, 0.0);
        let differ = differences(&[low, high]);
        (time, impulse) = (time.max(differ.0), impulse.max(differ.1));
    }
    println!("air: time {time:.2e} s, impulse {impulse:.2e}");
    // Residuals seen: 6.3e-12 s and 1.9e-10.
    assert!(time < 1e-7 && impulse < 1e-5, "time {time:.2e} s, impulse {impulse:.2e}");
}
