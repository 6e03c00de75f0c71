//! Time per mode: `cargo bench --profile release -p clangor-bake --bench eigensolver`.
//!
//! All modes of square plates and a block, thin and solid, at about 12 000 and 30 000 nodes. Measures
//! processor time of assembly, ordering, factorisation and iteration, independent of other load on the
//! machine. Last, the block as the program solves it: hexahedra of order 4 and mirror planes, on two meshes.

mod cpu_time;

use std::ops::ControlFlow;

use clangor_bake::fem::{ElasticConstants, ElasticSystem};
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::mesh::tetrahedra::block::block;
use clangor_bake::modal_analysis::eigensolver::solve;
use clangor_bake::modal_analysis::{ModalAnalysisOptions, modal_analysis};
use clangor_core::material::presets::GLASS;
use cpu_time::cpu_time;
use glam::DVec3;

fn main() {
    let bodies = [
        ("plate 26 x 26 x 0.5 cm", DVec3::new(0.26, 0.26, 0.005), [32, 32, 1], 20e3),
        ("pane 40 x 40 x 0.3 cm", DVec3::new(0.4, 0.4, 0.003), [50, 50, 1], 7e3),
        ("block 10 x 10 x 10 cm", DVec3::new(0.1, 0.1, 0.1), [11, 11, 11], 60e3),
    ];
    for (name, edges, cells, limit) in bodies {
        let (Ok(mesh), Ok(constants)) = (block(edges, cells), ElasticConstants::of(&GLASS.material())) else {
            return;
        };
        let before = cpu_time();
        let system = ElasticSystem::new(&mesh, &constants);
        let modes = match solve(&system, limit) {
            Ok(modes) => modes,
            Err(error) => return println!("{name}: {error}"),
        };
        let spent = cpu_time() - before;
        let count = modes.modes.len();
        println!(
            "{name}: {} nodes, {count} modes to {:.1} kHz, {} solves, {spent:.2} CPU-s, \
             {:.1} ms of CPU time per mode (CPU / 2: {:.1} ms), residual {:.0e}",
            system.node_count(),
            1e-3 * limit,
            modes.solves,
            1e3 * spent / count as f64,
            0.5e3 * spent / count as f64,
            modes.residual
        );
    }
    let geometry = BakeGeometry::RoundedBox { edges: DVec3::splat(0.1), round: 0.0 };
    let Ok(constants) = ElasticConstants::of(&GLASS.material()) else { return };
    let before = cpu_time();
    let options = ModalAnalysisOptions::to(60e3);
    match modal_analysis(&geometry, &constants, &options, &mut |_| ControlFlow::Continue(())) {
        Ok(found) => println!(
            "block 10 x 10 x 10 cm by bricks and mirrors: {} nodes, {} modes, {:.1} ms of CPU time per mode",
            found.nodes,
            found.modes.len(),
            1e3 * (cpu_time() - before) / found.modes.len() as f64
        ),
        Err(error) => println!("block by bricks and mirrors: {error}"),
    }
}
