//! Time per mode: `cargo bench --profile release -p clangor-bake --bench modes`.
//!
//! All modes of square plates and a block, thin and solid, at about 12 000 and 30 000 nodes. Processor time of assembly,
//! ordering, factors and iteration, so that other work on the machine does not count.

use std::time::Instant;

use clangor::material::presets::GLASS;
use clangor_bake::elasticity::{ElasticConstants, ElasticSystem};
use clangor_bake::modes::solve;
use clangor_bake::tetrahedra::block::block;
use glam::DVec3;

/// Seconds that this process has run, all threads together; on systems that do not tell, the clock on the wall.
fn processor_time(start: Instant) -> f64 {
    std::fs::read_to_string("/proc/self/stat")
        .ok()
        .and_then(|stat| {
            let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
            Some((fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?) / 100.0)
        })
        .unwrap_or_else(|| start.elapsed().as_secs_f64())
}

fn main() {
    let start = Instant::now();
    let bodies = [
        ("plate 26 x 26 x 0.5 cm", DVec3::new(0.26, 0.26, 0.005), [32, 32, 1], 20e3),
        ("pane 40 x 40 x 0.3 cm", DVec3::new(0.4, 0.4, 0.003), [50, 50, 1], 7e3),
        ("block 10 x 10 x 10 cm", DVec3::new(0.1, 0.1, 0.1), [11, 11, 11], 60e3),
    ];
    for (name, edges, cells, limit) in bodies {
        let (Ok(mesh), Ok(constants)) = (block(edges, cells), ElasticConstants::of(&GLASS.material())) else {
            return;
        };
        let before = processor_time(start);
        let system = ElasticSystem::new(&mesh, &constants);
        let modes = match solve(&system, limit) {
            Ok(modes) => modes,
            Err(error) => return println!("{name}: {error}"),
        };
        let spent = processor_time(start) - before;
        let count = modes.modes.len();
        println!(
            "{name}: {} nodes, {count} modes to {:.1} kHz, {} solves, {spent:.2} CPU-s, {:.1} ms per mode, residual {:.0e}",
            system.node_count(),
            1e-3 * limit,
            modes.solves,
            1e3 * spent / count as f64,
            modes.residual
        );
    }
}
