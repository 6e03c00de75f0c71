//! Processor time and power of the modes of ceramic bodies that are not axisymmetric, by boundary elements at
//! two accuracies and by finite differences in time: `cargo bench -p clangor-bake --bench modal_radiation --
//! BODY [EDGE] [kHz] [ACCURACY]`, the longest edge of the tetrahedra in mm. Further arguments: `waves` adds
//! the finite differences, `finer=PART` a run at that part of the error, of the waves as of the edges, `few`
//! leaves only every eighth mode.

mod cpu_time;

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use clangor_bake::fem::{ElasticConstants, ElasticSystem};
use clangor_bake::mesh::remesh::resolution::resolution;
use clangor_bake::mesh::tetrahedra::shape_mesh;
use clangor_bake::modal_analysis::eigensolver;
use clangor_bake::modal_radiation::bem_transfer::BemModalSolver;
use clangor_bake::modal_radiation::fdtd_transfer::FdtdModalSolver;
use clangor_bake::modal_radiation::{ModalMotion, ModalSolver};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::material::presets::CERAMIC;
use clangor_core::medium::Medium;
use clangor_core::shape::Shape;
use clangor_core::sound_model::modal::model::ModalTransfer;
use clangor_core::sound_model::modal::surface::ModalSurface;
use cpu_time::cpu_time;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let Some(name) = arguments.first() else {
        println!("BODY [EDGE in mm] [kHz] [ACCURACY] [waves] [finer=PART] [few]");
        return;
    };
    let number = |i: usize, default: f64| arguments.get(i).and_then(|a| a.parse().ok()).unwrap_or(default);
    let (edge, limit, accuracy) = (1e-3 * number(1, 6.0), 1e3 * number(2, 20.0), number(3, 0.015));
    let has = |word: &str| arguments.iter().any(|a| a == word);

    let shape = Shape::parse(name).expect("a shape");
    let surface = shape.mesh();
    let centre = MassProperties::of(&surface).expect("a solid").centre_of_mass;
    let surface = surface.relative_to(centre);
    let (tetrahedra, start) = (shape_mesh(&shape, edge).expect("a mesh"), cpu_time());
    let constants = ElasticConstants::of(&CERAMIC.material()).expect("an elastic material");
    let found = eigensolver::solve(&ElasticSystem::new(&tetrahedra, &constants), limit).expect("modes");
    println!(
        "{name}: {} modes of {} nodes, {:.1} CPU-s",
        found.modes.len(),
        tetrahedra.nodes.len(),
        cpu_time() - start
    );
    let elements = ModalSurface {
        nodes: tetrahedra.nodes.iter().map(|x| *x - centre).collect(),
        triangles: tetrahedra.surface(),
    };
    let k = |frequency: f64| TAU * frequency / Medium::default().sound_speed;
    let motions: Vec<ModalMotion<'_>> = found
        .modes
        .iter()
        .step_by(if has("few") { 8 } else { 1 })
        .map(|mode| ModalMotion { wavenumber: k(mode.frequency), shape: &mode.shape })
        .collect();
    let highest = k(limit);
    let radius = elements.radius();

    let by_elements = |part: f64| {
        let start = cpu_time();
        // The error of the waves is of second order in the edges.
        let solver =
            BemModalSolver::try_new(&surface, highest / part.sqrt(), part * accuracy).expect("a mesh");
        let transfers = timed(&solver, &elements, &motions);
        println!(
            "elements for {:.4}: {} unknowns, {:.1} CPU-s in all",
            part * accuracy,
            solver.unknowns(),
            cpu_time() - start
        );
        transfers
    };
    let usual = by_elements(1.0);
    let compare = |what: &str, other: &[ModalTransfer]| {
        println!("{what}:   κ   power/ρR⁴/c [dB]   against the above [%]   order");
        for ((motion, usual), other) in motions.iter().zip(&usual).zip(other) {
            let kappa = motion.wavenumber * radius;
            let (a, b) = (usual.power(kappa), other.power(kappa));
            println!(
                "{kappa:10.2} {:10.1} {:10.2} {:6}",
                10.0 * a.log10(),
                100.0 * (b / a - 1.0),
                usual.order
            );
        }
    };
    let finer = arguments.iter().find_map(|a| a.strip_prefix("finer=")?.parse().ok());
    if let Some(part) = finer {
        compare("finer", &by_elements(part));
    }
    if has("waves") {
        let start = cpu_time();
        let wall = resolution(&surface, highest, accuracy).expect("a wall").wall;
        let solver = FdtdModalSolver::try_new(&surface, highest, wall).expect("a grid");
        let transfers = timed(&solver, &elements, &motions);
        println!("waves: {} cells, {:.1} CPU-s in all", solver.cells(), cpu_time() - start);
        compare("waves", &transfers);
    }
}

fn timed(
    solver: &dyn ModalSolver,
    elements: &ModalSurface,
    motions: &[ModalMotion<'_>],
) -> Vec<ModalTransfer> {
    solver.transfers(elements, motions, &mut |_| ControlFlow::Continue(())).expect("a solution")
}
