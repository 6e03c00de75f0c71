//! Cost of the event-driven spheres: an elastic gas of 7.5 mm balls at 1 m/s in a cubic box, 4.5 % solid, no
//! gravity.
//!
//! `cargo bench -p clangor-sim --bench spheres [-- N ...]`: CPU seconds per simulated second, impacts, cost
//! per impact and per event (impact, cell left, search renewed), memory per ball and the drift of the kinetic
//! energy, for 1 000, 3 000, 10 000 and 30 000 balls. One thread, so that CPU time equals elapsed time.
//!
//! The cost per impact also grows because the walls matter less in a larger box: impacts on walls, which are
//! cheap and replace impacts between balls, become rare, and more cells are left per impact. An event is the
//! unit that does not depend on that.

#[path = "../tests/sphere_worlds/mod.rs"]
mod sphere_worlds;

use std::ops::ControlFlow;
use std::sync::LazyLock;
use std::time::Instant;

use clangor_core::body::{Body, World};
use clangor_core::timeline::{ContactRow, FractureRow, PoseRow, TimelineSink};
use clangor_sim::record::RecordSettings;
use clangor_sim::{SimulationSettings, simulate};
use glam::DVec3;
use sphere_worlds::{kinetic_energy, material, plane, settings, sphere, world};

/// Balls on a cubic lattice with a shift and a direction each, both from a low-discrepancy sequence.
fn gas(count: usize) -> World {
    let (radius, solid, speed) = (7.5e-3, 0.045, 1.0);
    let ball_volume = 4.0 / 3.0 * std::f64::consts::PI * f64::powi(radius, 3);
    let edge = (count as f64 * ball_volume / solid).cbrt();
    let rows = (count as f64).cbrt().ceil() as usize;
    let pitch = (edge - 2.0 * radius) / rows as f64;
    let elastic = material(1.0, 0.0, 0.0);
    let fraction = |k: usize, irrational: f64| (k as f64 * irrational).fract();
    let mut bodies: Vec<_> = (0..count)
        .map(|k| {
            let cell = DVec3::new((k % rows) as f64, (k / rows % rows) as f64, (k / rows / rows) as f64);
            let play = (pitch - 2.0 * radius) * 0.99;
            let shift = DVec3::new(
                fraction(k, 0.618_033_988_7),
                fraction(k, 0.414_213_562_3),
                fraction(k, 0.732_050_807_5),
            );
            let position = radius + cell * pitch + radius + shift * play;
            let z = 2.0 * fraction(k, 0.236_067_977_4) - 1.0;
            let (sin, cos) = (std::f64::consts::TAU * fraction(k, 0.645_751_311_0)).sin_cos();
            let flat = (1.0 - z * z).sqrt();
            sphere(radius, position, DVec3::new(flat * cos, flat * sin, z) * speed, &elastic)
        })
        .collect();
    for axis in DVec3::AXES {
        bodies.push(plane(DVec3::ZERO, axis, &elastic));
        bodies.push(plane(axis * edge, -axis, &elastic));
    }
    world(bodies, vec![], 0.0)
}

/// Counts the impulses, keeps the first and the latest kinetic energy.
#[derive(Default)]
struct Counter {
    rows: u64,
    end: f64,
    poses: Vec<PoseRow>,
}

impl TimelineSink for Counter {
    fn contact(&mut self, _row: &ContactRow) -> std::io::Result<()> {
        self.rows += 1;
        Ok(())
    }

    fn pose(&mut self, row: &PoseRow) -> std::io::Result<()> {
        // Only the two samples of the whole world count, not the poses of impacts.
        if row.time == 0.0 || row.time == self.end {
            self.poses.push(*row);
        }
        Ok(())
    }

    fn fracture(&mut self, _row: &FractureRow, _children: &[Body]) -> std::io::Result<()> {
        Ok(())
    }
}

/// CPU time of this thread \[s\]; wall-clock time on systems without `schedstat`.
fn cpu_seconds() -> f64 {
    static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
    let schedstat = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds: Option<f64> = schedstat.split(' ').next().and_then(|n| n.parse().ok());
    nanoseconds.map_or_else(|| BEGIN.elapsed().as_secs_f64(), |n| 1e-9 * n)
}

/// Resident memory of the process \[B\]; `None` on systems without `/proc`.
fn held_bytes() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:"))?;
    Some(1024.0 * line.trim().trim_end_matches("kB").trim().parse::<f64>().ok()?)
}

fn main() {
    let asked: Vec<usize> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let counts = if asked.is_empty() { vec![1000, 3000, 10_000, 30_000] } else { asked };
    println!("   balls  CPU s/s    impacts/s  us/impact  events/impact  us/event  B/ball    energy drift");
    for count in counts {
        let world = gas(count);
        let duration = (10_000.0 / count as f64).clamp(1.0, 4.0);
        let base = settings(duration, false, 1.0 / duration);
        let quiet = SimulationSettings { record: RecordSettings { v_min: 0.05, ..base.record }, ..base };
        let mut counter = Counter { end: duration, ..Counter::default() };
        let (before, mut within) = (held_bytes(), None);
        let begin = cpu_seconds();
        let done = simulate(&world, &quiet, &mut counter, &mut |_| {
            within = within.or_else(held_bytes);
            ControlFlow::Continue(())
        });
        let spent = cpu_seconds() - begin;
        let report = match done {
            Ok(report) => report,
            Err(error) => {
                println!("{count:8}  {error}");
                continue;
            }
        };
        let impacts = (report.impacts + report.dropped_impacts) as f64;
        let at = |time: f64| counter.poses.iter().filter(|p| p.time == time).copied().collect::<Vec<_>>();
        let (first, last) = (kinetic_energy(&world, &at(0.0)), kinetic_energy(&world, &at(duration)));
        let events = report.events as f64;
        let bytes = before.zip(within).map_or(f64::NAN, |(before, within)| within - before);
        println!(
            "{count:8}  {:7.3}  {:11.0}  {:9.3}  {:13.2}  {:8.3}  {:6.0}  {:+14.2e}",
            spent / duration,
            impacts / duration,
            1e6 * spent / impacts,
            events / impacts,
            1e6 * spent / events,
            bytes / count as f64,
            last / first - 1.0
        );
    }
}
