//! The field of a sphere about a point that need not be its centre, made from the exact solution.

use std::f64::consts::{PI, TAU};

use clangor_core::glam::DVec3;
use clangor_core::math::spherical_harmonics::{count, index, solid_harmonics};
use clangor_core::sound_model::acceleration::field::{AccelerationField, Node, RIGID_DOFS, Term};
use num_complex::Complex64;

/// p/ρ at `x` of a sphere of radius `a` about `centre` with acceleration `acceleration`, s = ik and c = 1.
/// Time begins with the acceleration: the wave leaves the surface at once.
pub(crate) fn sphere_pressure(
    s: Complex64,
    a: f64,
    centre: DVec3,
    acceleration: DVec3,
    x: DVec3,
) -> Complex64 {
    let towards = x - centre;
    let r = towards.length();
    let sigma = s * a;
    let along = acceleration.dot(towards) / r;
    along * a * (s * a * a / r + a * a / (r * r)) / (sigma * sigma + 2.0 * sigma + 2.0) * (-s * (r - a)).exp()
}

/// Motion of a sphere's centre at `offset` for each degree of freedom of the body.
pub(crate) fn centre_motions(offset: DVec3) -> [DVec3; RIGID_DOFS] {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    std::array::from_fn(|i| if i < 3 { axes[i] } else { axes[i - 3].cross(offset) })
}

/// The field of a sphere of radius `a` at `offset` from the centre of mass, both over R, up to `order` and κ
/// = `band`.
///
/// The nodes are the upper half of 2·`nodes` Chebyshev points on [−iκ, iκ], the weights those of polynomial
/// interpolation times σ² + 2σ + 2, which puts the two poles of the sphere where they are. What is left to
/// interpolate is entire.
pub(crate) fn sphere_field(
    a: f64,
    offset: DVec3,
    order: usize,
    band: f64,
    nodes: usize,
) -> AccelerationField {
    let place = |j: usize| Complex64::new(0.0, band * (PI * (2 * j + 1) as f64 / (4 * nodes) as f64).cos());
    let weight = |j: usize| {
        let s = place(j);
        let scale = 2.0 / band;
        let others = (0..2 * nodes).filter(|k| *k != j).map(|k| (s - place(k)) * scale);
        let sigma = s * a;
        (sigma * sigma + 2.0 * sigma + 2.0) / others.product::<Complex64>()
    };
    let nodes: Vec<Node> = (0..nodes).map(|j| Node { s: place(j), weight: weight(j) }).collect();

    // Projection on the bounding sphere: equal steps in φ, Gauss in z.
    let rule = gauss(2 * order + 24);
    let turns = 4 * order + 49;
    let mut harmonics = Vec::new();
    let mut values = vec![[Complex64::ZERO; RIGID_DOFS]; count(order) * nodes.len()];
    for (z, w) in &rule {
        for k in 0..turns {
            let phi = TAU * k as f64 / turns as f64;
            let x = DVec3::new((1.0 - z * z).sqrt() * phi.cos(), (1.0 - z * z).sqrt() * phi.sin(), *z);
            solid_harmonics(x, order, &mut harmonics);
            for (j, node) in nodes.iter().enumerate() {
                for (degree, motion) in centre_motions(offset).into_iter().enumerate() {
                    let p = sphere_pressure(node.s, a, offset, motion, x)
                        * node.s.exp()
                        * (w * TAU / turns as f64);
                    for (i, y) in harmonics.iter().enumerate() {
                        let p = if i == 0 { p / (node.s * node.s) } else { p };
                        values[i * nodes.len() + j][degree] += *y * p;
                    }
                }
            }
        }
    }
    let mut field = AccelerationField {
        max_wavenumber: band,
        ring_time: 23.0 * a + 1.0,
        nodes,
        terms: Vec::new(),
        real: Vec::new(),
        imaginary: Vec::new(),
    };
    let largest = values.iter().flatten().map(|v| v.norm()).fold(0.0, f64::max);
    for n in 0..=order {
        for m in -(n as isize)..=n as isize {
            for degree in 0..RIGID_DOFS {
                let at = index(n, m) * field.nodes.len();
                let row = &values[at..at + field.nodes.len()];
                if row.iter().all(|v| v[degree].norm() < 1e-13 * largest) {
                    continue;
                }
                field.terms.push(Term { n: n as u8, m: m as i8, degree: degree as u8 });
                field.real.extend(row.iter().map(|v| v[degree].re as f32));
                field.imaginary.extend(row.iter().map(|v| v[degree].im as f32));
            }
        }
    }
    field
}

/// Gauss–Legendre nodes and weights on [−1, 1].
fn gauss(n: usize) -> Vec<(f64, f64)> {
    let legendre = |x: f64| {
        let (mut before, mut here) = (1.0, x);
        for k in 2..=n {
            let k = k as f64;
            (before, here) = (here, ((2.0 * k - 1.0) * x * here - (k - 1.0) * before) / k);
        }
        (here, n as f64 * (x * here - before) / (x * x - 1.0))
    };
    (0..n)
        .map(|i| {
            let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            for _ in 0..20 {
                let (value, slope) = legendre(x);
                x -= value / slope;
            }
            (x, 2.0 / ((1.0 - x * x) * legendre(x).1.powi(2)))
        })
        .collect()
}
