//! Modes of a sphere, U·n = Yₙₘ, on flat triangles: surface pressure, multipoles and power against the exact
//! solution, at irregular frequencies too.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use clangor_bake::bem::triangles::{Equation, TriangleSolver};
use clangor_bake::mesh::remesh::SymmetricMesh;
use clangor_bake::modal_radiation::bem_transfer::BemModalSolver;
use clangor_bake::modal_radiation::{ModalMotion, ModalSolver};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::math::spherical_harmonics::{index, solid_harmonics};
use clangor_core::shape::Shape;
use clangor_core::sound_model::modal::surface::ModalSurface;
use glam::{BVec3, DMat3, DVec3};
use num_complex::Complex64;

/// 1280 triangles and more, with the volume of the sphere of radius 1.
fn sphere() -> TriMesh {
    let mut mesh = Shape::parse("sphere:1@0.145").expect("a shape").mesh();
    let scale = (4.0 / 3.0 * PI / MassProperties::of(&mesh).expect("a solid").volume).cbrt();
    mesh.vertices.iter_mut().for_each(|v| *v *= scale);
    assert!(mesh.triangles.len() >= 1280);
    mesh
}

/// The sphere as faces of six nodes.
fn elements() -> ModalSurface {
    let mesh = Shape::parse("sphere:1@0.2").expect("a shape").mesh();
    let mut nodes: Vec<DVec3> = mesh.vertices.iter().map(|v| v.normalize()).collect();
    let mut triangles = Vec::new();
    for [a, b, c] in &mesh.triangles {
        // Each midpoint occurs twice, once for each side: sharing is not required.
        let first = nodes.len() as u32;
        for (p, q) in [(a, b), (b, c), (c, a)] {
            nodes.push((nodes[*p as usize] + nodes[*q as usize]).normalize());
        }
        triangles.push([*a, *b, *c, first, first + 1, first + 2]);
    }
    ModalSurface { nodes, triangles }
}

fn harmonic(x: DVec3, n: usize, m: isize) -> f64 {
    let mut values = Vec::new();
    solid_harmonics(x.normalize(), n, &mut values);
    values[index(n, m)]
}

/// cₙₘ of the sphere of radius 1: −e^{s}/(d ln h/dx) at x = 1, with h ∝ e^{−sx} x^{−(n+1)} θₙ(sx).
fn exact(n: usize, k: f64) -> Complex64 {
    let s = Complex64::new(0.0, k);
    let (mut theta, mut slope) = (vec![Complex64::ONE, s + 1.0], vec![Complex64::ZERO, Complex64::ONE]);
    for n in 2..=n.max(2) {
        let odd = (2 * n - 1) as f64;
        theta.push(odd * theta[n - 1] + s * s * theta[n - 2]);
        slope.push(odd * slope[n - 1] + 2.0 * s * theta[n - 2] + s * s * slope[n - 2]);
    }
    -s.exp() / (-s - (n + 1) as f64 + s * slope[n] / theta[n])
}

/// Share of ρc|v|² S/2 that is radiated: Re of the impedance.
fn efficiency(n: usize, k: f64) -> f64 {
    // p = c e^{−s}, v = a/(iω).
    (exact(n, k) * (-Complex64::new(0.0, k)).exp() * Complex64::new(0.0, k)).re.abs()
}

const RIGID_DOFS: [(usize, isize); 4] = [(0, 0), (1, -1), (2, 1), (5, 3)];
/// π and 4.4934 are resonances of the ball with p = 0 on its surface, of n = 0 and 1.
const WAVENUMBERS: [f64; 5] = [0.1, 2.0, PI, 4.4934, 8.0];

#[test]
fn multipoles_of_modes_are_exact() {
    let (mesh, surface) = (sphere(), elements());
    let symmetric = SymmetricMesh { cell: mesh, mirrors: BVec3::FALSE, frame: DMat3::IDENTITY };
    let solver = BemModalSolver::on(symmetric);
    let shapes: Vec<Vec<DVec3>> = RIGID_DOFS
        .iter()
        .map(|(n, m)| surface.nodes.iter().map(|x| *x * harmonic(*x, *n, *m)).collect())
        .collect();
    let (mut worst, mut worst_power) = (0.0_f64, 0.0_f64);
    for wavenumber in WAVENUMBERS {
        let motions: Vec<ModalMotion<'_>> =
            shapes.iter().map(|shape| ModalMotion { wavenumber, shape }).collect();
        let transfers =
            solver.transfers(&surface, &motions, &mut |_| ControlFlow::Continue(())).expect("a solution");
        for ((n, m), transfer) in RIGID_DOFS.iter().zip(transfers) {
            if efficiency(*n, wavenumber) < 1e-4 {
                continue;
            }
            let expected = exact(*n, wavenumber);
            let wrong: f64 = transfer
                .coefficients
                .iter()
                .enumerate()
                .map(|(i, c)| (c - if i == index(*n, *m) { expected } else { Complex64::ZERO }).norm_sqr())
                .sum();
            worst = worst.max(wrong.sqrt() / expected.norm());
            let power = 0.5 * efficiency(*n, wavenumber) / wavenumber.powi(2);
            worst_power = worst_power.max((transfer.power(wavenumber) / power - 1.0).abs());
        }
    }
    // Residuals seen: 0.93 % and 1.7 % at ka = 8, five edges on a wave; 0.23 % and 0.2 % at 4.5 but for n =
    // 5: 0.7 % and 1.1 %.
    assert!(worst < 1e-2 && worst_power < 2e-2, "{worst} {worst_power}");
}

#[test]
fn surface_pressures_of_modes_are_exact() {
    let mesh = sphere();
    let solver = TriangleSolver::try_new(&mesh, 8.0, Equation::BurtonMiller).expect("small");
    let mut worst = 0.0_f64;
    for wavenumber in WAVENUMBERS {
        for (n, m) in RIGID_DOFS {
            let corner = |t: &[u32; 3]| t.map(|v| harmonic(mesh.vertices[v as usize], n, m));
            let accelerations: Vec<[f64; 3]> = mesh.triangles.iter().map(corner).collect();
            let pressures = solver.surface_pressure(wavenumber, &accelerations).expect("a solution");
            let expected = exact(n, wavenumber) * Complex64::new(0.0, -wavenumber).exp();
            let (mut wrong, mut size) = (0.0, 0.0);
            for (p, x) in pressures.iter().zip(&mesh.vertices) {
                let expected = expected * harmonic(*x, n, m);
                wrong += (p - expected).norm_sqr();
                size += expected.norm_sqr();
            }
            worst = worst.max((wrong / size).sqrt());
        }
    }
    // Residual seen: 0.75 %, of n = 5; 0.3 % of the others.
    assert!(worst < 1e-2, "{worst}");
}
