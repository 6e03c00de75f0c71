//! Processor time and power of the modes of ceramic bodies that are not round, by boundary elements at two accuracies and by
//! finite differences in time: `cargo bench -p clangor-bake --bench modal_radiation -- BODY [EDGE] [kHz] [ACCURACY]`, the
//! longest edge of the tetrahedra in mm. Further arguments: `waves` adds the finite differences, `finer` a run at an eighth of
//! the error, `few` leaves only every eighth mode.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use clangor::geometry::mass_properties::MassProperties;
use clangor::material::presets::CERAMIC;
use clangor::medium::Medium;
use clangor::model::modal_model::ModalTransfer;
use clangor::model::modal_surface::ModalSurface;
use clangor::shape::Shape;
use clangor_bake::elasticity::{ElasticConstants, ElasticSystem};
use clangor_bake::modal_radiation::triangles::TriangleModes;
use clangor_bake::modal_radiation::waves::WaveModes;
use clangor_bake::modal_radiation::{ModalMotion, ModalSolver};
use clangor_bake::modes;
use clangor_bake::remesh::resolution::resolution;
use clangor_bake::tetrahedra::shape_mesh;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let Some(name) = arguments.first() else {
        println!("BODY [EDGE in mm] [kHz] [ACCURACY] [waves] [finer] [few]");
        return;
    };
    let number = |i: usize, default: f64| arguments.get(i).and_then(|a| a.parse().ok()).unwrap_or(default);
    let (edge, limit, accuracy) = (1e-3 * number(1, 6.0), 1e3 * number(2, 20.0), number(3, 0.015));
    let has = |word: &str| arguments.iter().any(|a| a == word);

    let shape = Shape::parse(name).expect("a shape");
    let surface = shape.mesh();
    let centre = MassProperties::of(&surface).expect("a solid").centre_of_mass;
    let surface = surface.relative_to(centre);
    let (tetrahedra, start) = (shape_mesh(&shape, edge).expect("a mesh"), seconds());
    let constants = ElasticConstants::of(&CERAMIC.material()).expect("an elastic material");
    let found = modes::solve(&ElasticSystem::new(&tetrahedra, &constants), limit).expect("modes");
    println!(
        "{name}: {} modes of {} nodes, {:.1} CPU-s",
        found.modes.len(),
        tetrahedra.nodes.len(),
        seconds() - start
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

    let by_elements = |accuracy: f64| {
        let start = seconds();
        let solver = TriangleModes::try_new(&surface, highest, accuracy).expect("a mesh");
        let transfers = timed(&solver, &elements, &motions);
        println!(
            "elements for {accuracy}: {} unknowns, {:.1} CPU-s in all",
            solver.unknowns(),
            seconds() - start
        );
        transfers
    };
    let usual = by_elements(accuracy);
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
    if has("finer") {
        compare("finer", &by_elements(0.12 * accuracy));
    }
    if has("waves") {
        let start = seconds();
        let wall = resolution(&surface, highest, accuracy).expect("a wall").wall;
        let solver = WaveModes::try_new(&surface, highest, wall).expect("a grid");
        let transfers = timed(&solver, &elements, &motions);
        println!("waves: {} cells, {:.1} CPU-s in all", solver.cells(), seconds() - start);
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

/// Processor time of all threads where the system tells it [s].
fn seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<f64> = text
        .rsplit(')')
        .next()
        .unwrap_or_default()
        .split_whitespace()
        .filter_map(|f| f.parse().ok())
        .collect();
    // After the state, a letter that is no number: user and system time in hundredths.
    fields.get(10).zip(fields.get(11)).map_or(0.0, |(user, system)| 0.01 * (user + system))
}
