//! The click of a noisy mesh of a mug to 20 kHz at 1 %, and its error at three frequencies:
//! `cargo bench --profile release -p clangor-bake --bench clicks [-- FREQUENCY_HZ]`. Takes minutes.
//!
//! The reference is a solution on uniform triangles of a sixth of the shortest wave (2.86 mm for 20 kHz). The
//! error is that of the level: of each motion against the loudest, rotations at equal surface speed,
//! at 0.15 m.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use clangor_bake::acceleration::{BakeOptions, bake};
use clangor_bake::bem::triangles::{Equation, TriangleSolver};
use clangor_bake::fitting::comparison::{directions, six_pressures};
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::mesh::remesh::{RemeshOptions, remesh, remesh_symmetric};
use clangor_bake::radiation::{RadiationSample, RadiationSolver};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::math::radial::outgoing;
use clangor_core::math::spherical_harmonics::solid_harmonics;
use clangor_core::shape::Shape;
use glam::{DQuat, DVec3};
use num_complex::Complex64;

/// Distance at which fields are compared \[m\].
const DISTANCE: f64 = 0.15;
/// Where, in parts of the highest frequency.
const PLACES: [f64; 3] = [0.11, 0.48, 0.93];
/// Highest order of the reference.
const ORDER: usize = 29;
const ACCURACY: f64 = 0.01;

fn main() {
    let highest = std::env::args().filter_map(|a| a.parse::<f64>().ok()).next().unwrap_or(20e3);
    let k = TAU * highest / 343.0;
    let mesh = noisy_mug(2.1e-3);
    let start = seconds();
    let geometry = BakeGeometry::of_mesh(&mesh);
    let (model, evidence) =
        bake(&geometry, &BakeOptions::new(k, ACCURACY), &mut |_| ControlFlow::Continue(())).expect("a field");
    println!("{} triangles to {highest} Hz: {:.1} CPU-s", mesh.triangles.len(), seconds() - start);
    println!("{evidence:?}");
    // The reference, with one mirror plane.
    let planes = BakeGeometry::Mesh(mesh.clone()).mirror_normals(4e-4);
    let edge = TAU / k / 6.0;
    let options = RemeshOptions::new(edge, edge);
    let (fine, _) = remesh_symmetric(&mesh, &planes, &options).expect("a mesh");
    let solver = TriangleSolver::try_symmetric(&fine, k, Equation::BurtonMiller).expect("small");
    println!("reference: {} unknowns\nkHz, level errors of the six motions", solver.unknowns());
    for place in PLACES {
        let sample = solver.solve(&[place * k], ORDER).expect("finite").remove(0);
        let expected = pressures(&sample, solver.reference_radius(), model.radius);
        let seen: Vec<[Complex64; 6]> = directions(DIRECTIONS)
            .map(|d| six_pressures(&model, d * DISTANCE, place * k, model.radius))
            .collect();
        let phase = Complex64::cis(place * k * DISTANCE);
        let size = |d: usize| expected.iter().map(|p| p[d].norm_sqr()).sum::<f64>().sqrt();
        let loudest = (0..6).map(size).fold(0.0, f64::max);
        let errors: Vec<String> = (0..6)
            .map(|d| {
                let off = seen.iter().zip(&expected).map(|(a, b)| (a[d] * phase - b[d]).norm_sqr());
                format!("{:.1e}", off.sum::<f64>().sqrt() / loudest)
            })
            .collect();
        println!("{:6.2}  {}", 1e-3 * place * highest, errors.join("  "));
    }
}

/// Directions compared.
const DIRECTIONS: usize = 40;

/// Pressures of the six motions without their common phase, rotations of unit speed at `arm` \[m\].
fn pressures(sample: &RadiationSample, radius: f64, arm: f64) -> Vec<[Complex64; 6]> {
    let mut radial = Vec::new();
    outgoing(Complex64::I * sample.wavenumber * radius, DISTANCE / radius, ORDER, &mut radial);
    let of = |direction: DVec3| {
        let mut harmonics = Vec::new();
        solid_harmonics(direction, ORDER, &mut harmonics);
        std::array::from_fn(|d| {
            let unit = if d < 3 { 1.0 } else { arm };
            let terms = sample.coefficients[d].iter().zip(&harmonics).enumerate();
            terms.map(|(i, (c, y))| radial[i.isqrt()] * c * *y).sum::<Complex64>() / unit
        })
    };
    directions(DIRECTIONS).map(of).collect()
}

/// A mug as a scan: turned, uneven triangles, noise of 1 % of an edge; about its centre of mass.
fn noisy_mug(edge: f64) -> TriMesh {
    let shape = Shape::parse("mug").expect("a shape").mesh();
    let options = RemeshOptions::new(0.6 * edge, 1.6 * edge);
    let (mut mesh, _) = remesh(&shape, &options).expect("a mesh");
    let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 0.7, -0.4);
    let mut state = 12345_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    for v in &mut mesh.vertices {
        *v = turn * *v + DVec3::new(random(), random(), random()) * (0.01 * edge);
    }
    mesh.relative_to(MassProperties::of(&mesh).expect("a solid").centre_of_mass)
}

/// Processor time of all threads that still run \[s\].
fn seconds() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let of = |task: std::fs::DirEntry| {
        let text = std::fs::read_to_string(task.path().join("schedstat")).unwrap_or_default();
        text.split_whitespace().next().and_then(|nanoseconds| nanoseconds.parse::<f64>().ok())
    };
    tasks.filter_map(of).sum::<f64>() * 1e-9
}
