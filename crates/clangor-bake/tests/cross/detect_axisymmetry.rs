//! Sections detected on meshes against the exact ones of their shapes.

use std::ops::ControlFlow;

use clangor_bake::fem::ElasticConstants;
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::geometry_class::detect_axisymmetry::fitted_meridian;
use clangor_bake::modal_analysis::{ModalAnalysisOptions, modal_analysis};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::material::presets::CERAMIC;
use clangor_core::shape::Shape;

/// A shape's triangles about their centre of mass.
fn mesh(shape: &str) -> TriMesh {
    let mesh = Shape::parse(shape).expect("a shape").mesh();
    let centre = MassProperties::of(&mesh).expect("a solid").centre_of_mass;
    mesh.relative_to(centre)
}

fn frequencies(geometry: &BakeGeometry) -> Vec<f64> {
    let constants = ElasticConstants::of(&CERAMIC.material()).expect("an elastic material");
    let mut go_on = |_: &_| ControlFlow::Continue(());
    let found =
        modal_analysis(geometry, &constants, &ModalAnalysisOptions::to(12e3), &mut go_on).expect("modes");
    found.modes.iter().map(|m| m.frequency).collect()
}

#[test]
fn a_bowl_of_triangles_rings_as_the_exact_one() {
    let exact = Shape::parse("bowl").expect("a shape").meridian().expect("a section").about_centre_of_mass();
    let rough = mesh("bowl");
    let fit = fitted_meridian(&rough).expect("an axisymmetric body");
    // Seen: 1.3e-4 m; the facets reduce the volume by some per mille.
    let lost = fit.meridian.volume() / exact.volume() - 1.0;
    assert!(fit.deviation < 3e-4 && lost.abs() < 0.02, "{:.1e} {lost:.1e}", fit.deviation);
    let (fitted, exact) = (
        frequencies(&BakeGeometry::axisymmetric(fit.meridian)),
        frequencies(&BakeGeometry::axisymmetric(exact)),
    );
    assert_eq!(fitted.len(), exact.len());
    for (a, b) in fitted.iter().zip(&exact) {
        // Seen: 1.5e-3 for the first pair.
        assert!((a / b - 1.0).abs() < 5e-3, "{a} {b}");
    }
}

#[test]
fn other_bodies_have_no_section() {
    for shape in ["mug", "key", "box:0.1x0.1x0.1", "ellipsoid:0.03x0.02x0.011", "rock:3x0.01"] {
        assert_eq!(fitted_meridian(&mesh(shape)), None, "{shape}");
    }
    for shape in ["torus:0.05x0.01", "cylinder:0.01x0.05", "wineglass", "plate"] {
        assert!(fitted_meridian(&mesh(shape)).is_some(), "{shape}");
    }
}
