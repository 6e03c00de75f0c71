//! Time of the stress solver: `cargo bench --profile release -p clangor-bake --bench elastostatics`.
//!
//! A thin plate and a block at about 12 000 and 60 000 nodes: factorisation, solve with all fields, new
//! columns, stored ones. Measures processor time, independent of other load; half of it is the time on two
//! idle cores.

use std::time::Instant;

use clangor_bake::fem::ElasticConstants;
use clangor_bake::mesh::tetrahedra::block::block;
use clangor_bake::stress::{PointLoad, StressBody, StressOptions};
use clangor_core::material::presets::GLASS;
use glam::DVec3;

/// CPU time of the process, all threads together \[s\]; wall-clock time on systems that do not report it.
fn processor_time(start: Instant) -> f64 {
    std::fs::read_to_string("/proc/self/stat")
        .ok()
        .and_then(|stat| {
            let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
            Some((fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?) / 100.0)
        })
        .unwrap_or_else(|| start.elapsed().as_secs_f64())
}

/// Mean processor time of `times` runs [s].
fn mean(start: Instant, times: usize, mut run: impl FnMut(usize)) -> f64 {
    let before = processor_time(start);
    (0..times).for_each(&mut run);
    (processor_time(start) - before) / times as f64
}

fn main() {
    let start = Instant::now();
    let small = std::env::args().any(|a| a == "small");
    let bodies = [
        ("plate, 12k", DVec3::new(0.26, 0.26, 0.005), [32, 32, 1], true),
        ("block, 12k", DVec3::splat(0.1), [11, 11, 11], true),
        ("plate, 60k", DVec3::new(0.5, 0.5, 0.005), [54, 54, 2], false),
        ("block, 60k", DVec3::splat(0.1), [19, 19, 19], false),
    ];
    for (name, edges, cells, is_small) in bodies {
        let (Ok(mesh), Ok(constants)) = (block(edges, cells), ElasticConstants::of(&GLASS.material())) else {
            return;
        };
        if small && !is_small {
            continue;
        }
        let nodes = mesh.nodes.len();
        let before = processor_time(start);
        let mut body = match StressBody::new(mesh, &constants, &StressOptions::default()) {
            Ok(body) => body,
            Err(error) => return println!("{name}: {error}"),
        };
        let factor = processor_time(start) - before;
        // Four contacts below, displaced slightly from load to load.
        let loads = |k: usize| -> Vec<PointLoad> {
            let place = |a: f64, b: f64| PointLoad {
                point: DVec3::new(a * edges.x, b * edges.y, -0.5 * edges.z) * (1.0 + 1e-6 * k as f64),
                force: DVec3::new(0.1 * a, 0.1 * b, 1.0 + 0.01 * (k % 7) as f64),
            };
            vec![place(0.31, 0.3), place(-0.32, 0.29), place(0.3, -0.31), place(-0.31, -0.33)]
        };
        let mut sink = 0.0;
        let solve = mean(start, 10, |k| sink += body.solve(&loads(k)).map_or(0.0, |d| d.strain_energy));
        let first = mean(start, 1, |k| sink += body.maximum_tension(&loads(k)).map_or(0.0, |t| t.stress));
        let four = mean(start, 400, |k| sink += body.maximum_tension(&loads(k)).map_or(0.0, |t| t.stress));
        let one =
            mean(start, 400, |k| sink += body.maximum_tension(&loads(k)[..1]).map_or(0.0, |t| t.stress));
        let bound =
            mean(start, 4000, |k| sink += body.tension_bound(&loads(k)).ok().flatten().unwrap_or(0.0));
        println!(
            "{name}: {nodes} nodes, {:.0} M numbers; CPU / 2: factor {:.2} s, solve {:.1} ms, \
             four new contacts {:.0} ms, stored: four {:.3} ms, one {:.3} ms, bound {:.2} us ({sink:.1e})",
            1e-6 * body.factor_entries() as f64,
            0.5 * factor,
            0.5e3 * solve,
            0.5e3 * first,
            0.5e3 * four,
            0.5e3 * one,
            0.5e6 * bound,
        );
    }
}
