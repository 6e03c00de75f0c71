//! CPU time of a live world: marbles that fall into a box. `cargo bench -p clangor-sim --bench live_pile --
//! [KEY=VALUE]..`
//!
//! Keys: `marbles` (300), `seconds` (3), `radius` (0.02), `restitution` (0.6), `step` (0.001953125),
//! `advance` (0.02).

#[path = "../tests/sphere_worlds/mod.rs"]
mod sphere_worlds;

use clangor_sim::live::{LiveSettings, LiveWorld};
use sphere_worlds::live::{deepest_overlap, marbles_in_a_box};
use sphere_worlds::material;

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
    let (count, radius) = (argument("marbles", 300.0) as usize, argument("radius", 0.02));
    let glass = material(argument("restitution", 0.6), 0.2, 2e-4);
    let world = marbles_in_a_box(count, radius, &glass);
    let settings = LiveSettings { time_step: argument("step", 1.0 / 512.0), ..LiveSettings::default() };
    let mut live = LiveWorld::new(&world, settings).expect("the marbles start apart");
    let (advance, mut next) = (argument("advance", 0.02), 0.0);
    let (mut since, mut impacts, mut deepest) = (cpu_time(), 0, 0.0_f64);
    println!("{count} marbles");
    for half in 1..=(2.0 * argument("seconds", 3.0)) as u32 {
        while next < 0.5 * f64::from(half) {
            next += advance;
            while !live.advance(next, 8000).expect("it goes on") {}
            impacts += live.impacts().len();
            live.clear();
            deepest = deepest.max(deepest_overlap(&live));
        }
        let cpu = cpu_time() - since;
        println!(
            "t {:.1} s: {impacts} impacts, energy {:.4e} J, overlap {:.1} um, CPU {cpu:.2} s",
            live.time(),
            live.energy(),
            1e6 * deepest
        );
        (since, impacts, deepest) = (cpu_time(), 0, 0.0);
    }
}
