//! Radiation of all modes of axisymmetric bodies:
//! `cargo bench --profile release -p clangor-bake --bench modal_axisymmetric`.
//!
//! Measures processor time of the radiation alone, and with `-- finer` the power of each mode relative to
//! that of a finer run. Names of shapes select some of them.

mod cpu_time;

use std::ops::ControlFlow;

use clangor_bake::bem::axisymmetric::AxisymmetricOptions;
use clangor_bake::fem::{ElasticConstants, ElasticSystem};
use clangor_bake::mesh::tetrahedra::shape_mesh;
use clangor_bake::modal_analysis::eigensolver::solve;
use clangor_bake::modal_radiation::axisymmetric::AxisymmetricModalSolver;
use clangor_bake::modal_radiation::{ModalMotion, ModalSolver};
use clangor_core::material::presets::{CERAMIC, STEEL};
use clangor_core::shape::Shape;
use clangor_core::sound_model::modal::surface::ModalSurface;
use cpu_time::cpu_time;
use glam::DVec3;

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let is_finer = asked.iter().any(|a| a == "finer");
    let sound_speed = 343.0;
    for (name, material, edge) in [("coin", STEEL, 1.5e-3), ("bowl", CERAMIC, 5e-3), ("plate", CERAMIC, 7e-3)]
    {
        if asked.iter().any(|a| a != "finer") && !asked.iter().any(|a| a == name) {
            continue;
        }
        let Ok(shape) = Shape::parse(name) else { return };
        let Some(meridian) = shape.meridian() else { return };
        let (Ok(mesh), Ok(constants)) =
            (shape_mesh(&shape, edge), ElasticConstants::of(&material.material()))
        else {
            return println!("{name}: no mesh");
        };
        let before = cpu_time();
        let modes = match solve(&ElasticSystem::new(&mesh, &constants), 20e3) {
            Ok(modes) => modes.modes,
            Err(error) => return println!("{name}: {error}"),
        };
        println!(
            "{name}: {} nodes, {} modes, {:.1} CPU-s",
            mesh.nodes.len(),
            modes.len(),
            cpu_time() - before
        );
        let centre = DVec3::Y * meridian.centre_of_mass();
        let surface = ModalSurface {
            nodes: mesh.nodes.iter().map(|x| x - centre).collect(),
            triangles: mesh.surface(),
        };
        let motions: Vec<ModalMotion<'_>> = modes
            .iter()
            .map(|mode| ModalMotion {
                wavenumber: std::f64::consts::TAU * mode.frequency / sound_speed,
                shape: &mode.shape,
            })
            .collect();
        let solver = AxisymmetricModalSolver::new(&meridian.about_centre_of_mass(), DVec3::Y);
        let run = |solver: &AxisymmetricModalSolver| {
            let before = cpu_time();
            let found = solver.transfers(&surface, &motions, &mut |_| ControlFlow::Continue(()));
            (found, cpu_time() - before)
        };
        let (transfers, spent) = match run(&solver) {
            (Ok(transfers), spent) => (transfers, spent),
            (Err(error), _) => return println!("{name}: {error}"),
        };
        let orders: usize = transfers.iter().map(|t| t.order).sum();
        println!("{name}: radiation {spent:.2} CPU-s, sum of orders {orders}");
        if !is_finer {
            continue;
        }
        let options = AxisymmetricOptions {
            nodes_per_wavelength: 16.0,
            edge_levels: 6,
            ..AxisymmetricOptions::new(0.0)
        };
        let (Ok(finer), spent) = run(&solver.with_options(options)) else { return };
        println!("{name}: finer {spent:.2} CPU-s");
        let radius = surface.radius();
        for ((motion, transfer), finer) in motions.iter().zip(&transfers).zip(&finer) {
            let kr = motion.wavenumber * radius;
            let (power, finer) = (transfer.power(kr), finer.power(kr));
            println!(
                "  {:8.1} Hz kR {kr:5.2} order {:2} power {power:.3e} {:+.1e}",
                motion.wavenumber * sound_speed / std::f64::consts::TAU,
                transfer.order,
                power / finer - 1.0
            );
        }
    }
}
