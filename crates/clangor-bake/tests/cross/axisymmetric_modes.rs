//! Axisymmetric bodies: the section's modes against those of tetrahedra, frequencies and shapes; their
//! surface against the exact volume.

use std::ops::ControlFlow;

use clangor_bake::fem::{ElasticConstants, ElasticSystem};
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::mesh::tetrahedra::shape_mesh;
use clangor_bake::modal_analysis::eigensolver::{Modes, solve};
use clangor_bake::modal_analysis::{ModalAnalysis, ModalAnalysisOptions, modal_analysis};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::material::presets::{CERAMIC, COPPER};
use clangor_core::shape::Shape;
use clangor_core::sound_model::modal::surface::SurfaceLocator;
use glam::{DMat3, DVec3};

fn axisymmetric(shape: &str, constants: &ElasticConstants, limit: f64) -> ModalAnalysis {
    let meridian = Shape::parse(shape).expect("a shape").meridian().expect("a section");
    let geometry = BakeGeometry::axisymmetric(meridian.about_centre_of_mass());
    let mut go_on = |_: &_| ControlFlow::Continue(());
    modal_analysis(&geometry, constants, &ModalAnalysisOptions::to(limit), &mut go_on).expect("modes")
}

/// Σ u(x) u(y)ᵀ over the modes of one frequency, independent of the choice of basis.
fn product(shapes: &[(DVec3, DVec3)]) -> DMat3 {
    shapes.iter().map(|(u, v)| DMat3::from_cols(*u * v.x, *u * v.y, *u * v.z)).sum()
}

fn size(m: DMat3) -> f64 {
    m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Largest difference of frequencies, and of the products of shapes over the largest of them.
fn differences(axisymmetric: &ModalAnalysis, filled: &Modes, nodes: &[DVec3], at: &[u32]) -> (f64, f64) {
    let locator = SurfaceLocator::new(&axisymmetric.surface);
    let places: Vec<_> = at.iter().map(|n| locator.nearest(nodes[*n as usize]).expect("a place")).collect();
    let (mut by_frequency, mut by_shape) = (0.0_f64, 0.0_f64);
    let mut from = 0;
    for group in axisymmetric.modes.chunk_by(|a, b| b.frequency < a.frequency * (1.0 + 1e-9)) {
        let others = &filled.modes[from..from + group.len()];
        from += group.len();
        for (a, b) in group.iter().zip(others) {
            by_frequency = by_frequency.max((a.frequency / b.frequency - 1.0).abs());
        }
        let pairs = (0..at.len()).map(|k| {
            let other = (k * 7 + 3) % at.len();
            let own = group.iter().map(|m| [k, other].map(|k| places[k].interpolate(&m.shape)));
            let theirs = others.iter().map(|m| [k, other].map(|k| m.shape[at[k] as usize]));
            let [own, theirs] = [own.collect::<Vec<_>>(), theirs.collect()]
                .map(|all| product(&all.iter().map(|[u, v]| (*u, *v)).collect::<Vec<_>>()));
            (size(own), size(own - theirs))
        });
        let (largest, error) = pairs.fold((0.0_f64, 0.0_f64), |(a, b), (x, y)| (a.max(x), b.max(y)));
        by_shape = by_shape.max(error / largest);
    }
    (by_frequency, by_shape)
}

#[test]
fn sections_and_tetrahedra_agree() {
    // Shape, elements [m], limit [Hz].
    for (shape, edge, limit) in [("coin", 0.0013, 43e3), ("torus:0.05x0.01", 0.006, 17e3)] {
        let constants = ElasticConstants::of(&COPPER.material()).expect("an elastic material");
        let axisymmetric = axisymmetric(shape, &constants, limit);
        let mesh = shape_mesh(&Shape::parse(shape).expect("a shape"), edge).expect("a mesh");
        let filled = solve(&ElasticSystem::new(&mesh, &constants), limit * 1.01).expect("modes");
        let mut on_surface: Vec<u32> = mesh.surface().into_iter().flatten().step_by(13).collect();
        on_surface.sort_unstable();
        on_surface.dedup();
        let (frequency, shape_error) = differences(&axisymmetric, &filled, &mesh.nodes, &on_surface);
        // Seen: 2.2e-3, 2.1e-2; 8.6e-4, 3.0e-2. Most of it is the error of the tetrahedra.
        assert!(frequency < 4e-3 && shape_error < 0.05, "{shape}: {frequency:.1e} {shape_error:.1e}");
    }
}

#[test]
fn surfaces_are_closed_and_have_the_volume() {
    let constants = ElasticConstants::of(&CERAMIC.material()).expect("an elastic material");
    for (shape, limit) in [("bowl", 10e3), ("plate", 5e3), ("wineglass", 10e3), ("torus:0.02x0.006", 1e5)] {
        let axisymmetric = axisymmetric(shape, &constants, limit);
        let mass = MassProperties::of(&axisymmetric.surface.quarters()).expect("a closed surface");
        let exact = Shape::parse(shape).expect("a shape").meridian().expect("a section").volume();
        let error = mass.volume / exact - 1.0;
        // Seen: 2e-3, 1e-3, 4e-3, 2e-2, from the facets.
        assert!(error.abs() < 0.02, "{shape}: {error:.1e}");
    }
}
