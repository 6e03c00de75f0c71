//! CPU time and silence of a pile of rocks in a box: `cargo bench -p clangor-sim --bench rock_pile --
//! [KEY=VALUE]..`
//!
//! Keys: `rocks` (1000), `seconds` (6), `step` (2.5e-4), `sleep` (1), `restitution` (0.4), `seed` (2024),
//! `look` (200): steps between two measurements of overlap.

#[path = "../tests/scenes/rigid.rs"]
#[allow(dead_code)]
mod scenes;

use clangor_core::body::BodyId;
use clangor_sim::rigid::{RigidWorld, StepLog};

fn argument(key: &str, default: f64) -> f64 {
    let given = std::env::args().find_map(|a| a.strip_prefix(key)?.strip_prefix('=')?.parse().ok());
    given.unwrap_or(default)
}

/// User and system time of this process [s].
fn cpu_time() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or("").split_whitespace().collect();
    let ticks = |i: usize| fields.get(i).and_then(|f| f.parse::<f64>().ok()).unwrap_or(f64::NAN);
    (ticks(11) + ticks(12)) / 100.0
}

fn main() {
    let rocks = argument("rocks", 1000.0) as usize;
    let time_step = argument("step", 2.5e-4);
    let look = argument("look", 200.0) as usize;
    let sleep = argument("sleep", 1.0) > 0.0;
    let half = if rocks > 400 { 0.2 } else { 0.12 };
    let material = scenes::material(2650.0, argument("restitution", 0.4), 0.5, 5e-5);
    let world = scenes::rock_pile(rocks, half, &material, argument("seed", 2024.0) as u64);
    let first = world.bodies.len() - rocks;
    let mut rigid = RigidWorld::try_new(&world, time_step, sleep).expect("the pile starts without overlap");
    let mut log = StepLog::without_slow_contacts(0.05);
    let per_interval = (0.5 / time_step).round() as usize;
    let (start, mut since) = (cpu_time(), cpu_time());
    let (mut loud, mut sweeps, mut deepest) = (0, 0, 0.0_f64);
    println!("{rocks} rocks, step {time_step:e} s, sleep {sleep}");
    for k in 1..=(argument("seconds", 6.0) / time_step).round() as usize {
        rigid.step(&mut log).expect("the pile stays finite");
        loud += log.impulses().iter().filter(|i| i.row.approach_speed() > 0.05).count();
        if k % look == 0 {
            deepest = deepest.max(rigid.deepest_overlap());
        }
        if k % per_interval == 0 {
            let asleep = (first..world.bodies.len()).filter(|&i| rigid.is_asleep(BodyId(i as u32))).count();
            println!(
                "t {:.1} s: {loud} impulses > 5 cm/s, kinetic energy {:.2e} J, asleep {asleep}, \
                 overlap {:.1} um, {:.1} sweeps/step, CPU {:.2} s ({:.2} ms/step)",
                rigid.time(),
                rigid.kinetic_energy(),
                deepest * 1e6,
                (rigid.sweeps() - sweeps) as f64 / per_interval as f64,
                cpu_time() - since,
                (cpu_time() - since) * 1e3 / per_interval as f64,
            );
            (loud, sweeps, deepest, since) = (0, rigid.sweeps(), 0.0, cpu_time());
        }
    }
    for i in first..world.bodies.len() {
        if !rigid.is_asleep(BodyId(i as u32)) {}
    }
    let escaped = (first..world.bodies.len())
        .filter(|&i| {
            let p = rigid.pose(BodyId(i as u32)).position;
            p.y < 0.0 || p.x.abs() > half || p.z.abs() > half
        })
        .count();
    println!("CPU {:.1} s, {escaped} escaped", cpu_time() - start);
}
