//! Boundary elements against finite differences in time: nothing in common but the equations.

use std::ops::ControlFlow;

use clangor::body::Surface;
use clangor::geometry::tri_mesh::TriMesh;
use clangor::shape::Shape;
use clangor_bake::acceleration_noise::{BakeGeometry, BakeOptions, Method, bake, bake_with};
use clangor_bake::comparison::{FieldErrors, compare};
use clangor_bake::wave::{Boundary, WaveDevice, WaveOptions, WaveSolver};
use glam::DVec3;

/// 2π 12 kHz / c [1/m].
const HIGHEST: f64 = 219.7;

fn surface(shape: &str) -> TriMesh {
    match Shape::parse(shape).expect("a shape").surface().expect("a solid").0 {
        Surface::Mesh(surface) => surface.mesh,
        _ => panic!("a mesh"),
    }
}

/// Field by boundary elements against that of time stepping with cells of `spacing` \[m\], at 2 R.
fn difference(geometry: &BakeGeometry, mesh: &TriMesh, spacing: f64) -> FieldErrors {
    let options = BakeOptions {
        max_wavenumber: HIGHEST,
        accuracy: 3e-3,
        method: Method::Bem,
        device: WaveDevice::Cpu,
        near_field: false,
    };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let (elements, _) = bake(geometry, &options, go_on).expect("boundary elements");
    let waves = WaveSolver::try_new(
        mesh,
        WaveOptions {
            max_wavenumber: HIGHEST,
            spacing,
            order: 8,
            boundary: Boundary::CutCells,
            longest: 12.0,
        },
    )
    .expect("a grid");
    let field = waves.run(&|_| ControlFlow::Continue(())).expect("a run");
    let (waves, _) = bake_with(&field, 0.8, &options, go_on).expect("a fit");
    compare(&waves, &elements, 2.0, (1.83, HIGHEST))
}

#[test]
fn an_ellipsoid_sounds_alike() {
    let semi_axes = DVec3::new(0.02, 0.012, 0.008);
    let mesh = surface("ellipsoid:0.02x0.012x0.008@0.0006");
    let errors = difference(&BakeGeometry::Ellipsoid { semi_axes }, &mesh, 1.25e-3);
    // Residual seen: 0.14 % level, 0.3 % own.
    assert!(errors.worst_level() < 0.01, "{errors:?}");
}

#[test]
fn a_rounded_die_sounds_alike() {
    let geometry = BakeGeometry::RoundedBox { edges: DVec3::splat(0.015), round: 0.003 };
    let errors = difference(&geometry, &surface("die:0.015x0.003@0.0006"), 8e-4);
    // Residual seen: 0.32 % level and own.
    assert!(errors.worst_level() < 0.01, "{errors:?}");
}

#[test]
fn a_coin_sounds_alike() {
    let shape = Shape::parse("coin").expect("a shape");
    let meridian = shape.meridian().expect("a body of revolution");
    let errors = difference(&BakeGeometry::Revolution(meridian), &surface("coin"), 5e-4);
    // Residual seen: 0.34 % level, 1.3 % own.
    assert!(errors.worst_level() < 0.01, "{errors:?}");
}
