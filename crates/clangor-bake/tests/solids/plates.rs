//! Flat bodies as an author might mesh them, and the frequencies of thin free plates.

use std::f64::consts::{PI, TAU};

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::{DMat4, DVec2, DVec3, DVec4};

/// A disc, or a ring around a hole, of these radii and thickness \[m\], with `sides` around the axis y.
pub(crate) fn flat_ring(radius: f64, hole: f64, thickness: f64, sides: usize) -> TriMesh {
    let half = 0.5 * thickness;
    let profile = [[hole, -half], [radius, -half], [radius, half], [hole, half]].map(DVec2::from_array);
    let mut mesh = TriMesh::default();
    for p in profile {
        for k in 0..sides {
            let (sin, cos) = (TAU * k as f64 / sides as f64).sin_cos();
            mesh.vertices.push(DVec3::new(p.x * cos, p.y, p.x * sin));
        }
    }
    let at = |i: usize, k: usize| (i % 4 * sides + k % sides) as u32;
    for i in 0..4 {
        for k in 0..sides {
            let [a, b, c, d] = [at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    if hole == 0.0 { mesh.weld(1e-9 * radius) } else { mesh }
}

/// A plate across y with an outline in the plane, triangles from its first corner.
pub(crate) fn slab(corners: &[DVec2], thickness: f64) -> TriMesh {
    let count = corners.len() as u32;
    let level = |y: f64| corners.iter().map(move |c| DVec3::new(c.x, y, -c.y));
    let mut mesh = TriMesh {
        vertices: level(0.5 * thickness).chain(level(-0.5 * thickness)).collect(),
        triangles: Vec::new(),
    };
    for k in 1..count - 1 {
        mesh.triangles.extend([[0, k, k + 1], [count, count + k + 1, count + k]]);
    }
    for k in 0..count {
        let next = (k + 1) % count;
        mesh.triangles.extend([[k, count + k, count + next], [k, count + next, next]]);
    }
    mesh
}

/// A free Kirchhoff plate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plate {
    /// Young's modulus \[Pa\], Poisson's ratio and density [kg/m³].
    pub(crate) material: [f64; 3],
    /// Thickness \[m\].
    pub(crate) thickness: f64,
}

impl Plate {
    /// √(D/(ρ t)) [m²/s], D = E t³/(12 (1 − ν²)).
    fn stiffness(&self) -> f64 {
        let [modulus, ratio, density] = self.material;
        (modulus * self.thickness.powi(2) / (12.0 * (1.0 - ratio * ratio)) / density).sqrt()
    }

    /// The lowest `count` different frequencies \[Hz\] of a disc of a radius with a concentric hole \[m\].
    ///
    /// W = Σ c_f f_m(k r) cos mθ with J and I, and Y and K beside a hole; no moment and no effective shear at
    /// the edges: W'' + ν(W'/r − m²W/r²) = 0, (∇²W)' − (1−ν) m²/r² (W' − W/r) = 0.
    pub(crate) fn ring_frequencies(&self, radius: f64, hole: f64, count: usize) -> Vec<f64> {
        const STEP: f64 = 0.04;
        let mut found = Vec::new();
        for order in 0..8 {
            let f = |k: f64| self.edge_determinant(order, k, hole / radius);
            let (mut k, mut value) = (0.5, f(0.5));
            while k < 7.6 {
                let (next, after) = (k + STEP, f(k + STEP));
                if (value > 0.0) != (after > 0.0) {
                    let root = bisect(&f, k, next);
                    found.push((root / radius).powi(2) * self.stiffness() / TAU);
                }
                (k, value) = (next, after);
            }
        }
        found.sort_by(f64::total_cmp);
        found.truncate(count);
        found
    }

    fn edge_determinant(&self, order: i32, k: f64, hole: f64) -> f64 {
        let [_, ratio, _] = self.material;
        let m2 = f64::from(order * order);
        let kinds = [Bessel::J, Bessel::I, Bessel::Y, Bessel::K];
        let row = |kind: Bessel, r: f64| {
            let x = k * r;
            let (w, slope) = (kind.value(order, x), k * kind.slope(order, x));
            // ∇²W = ∓ k² W.
            let sign = if matches!(kind, Bessel::J | Bessel::Y) { -1.0 } else { 1.0 };
            let second = sign * k * k * w - slope / r + m2 * w / (r * r);
            let moment = second + ratio * (slope / r - m2 * w / (r * r));
            let shear = sign * k * k * slope - (1.0 - ratio) * m2 / (r * r) * (slope - w / r);
            [moment, shear]
        };
        if hole == 0.0 {
            let [[a, b], [c, d]] = [row(Bessel::J, 1.0), row(Bessel::I, 1.0)];
            return (a * d - b * c) / Bessel::I.value(order, k);
        }
        let columns = kinds.map(|kind| {
            let ([a, b], [c, d]) = (row(kind, 1.0), row(kind, hole));
            DVec4::new(a, b, c, d).normalize()
        });
        let [a, b, c, d] = columns;
        DMat4::from_cols(a, b, c, d).determinant()
    }

    /// The lowest frequencies \[Hz\] of a rectangle \[m\], by Ritz with products of Legendre polynomials,
    /// which
    /// are orthogonal: the mass matrix is diagonal.
    pub(crate) fn rectangle_frequencies(&self, sides: [f64; 2], count: usize) -> Vec<f64> {
        const TERMS: usize = 14;
        let [_, ratio, _] = self.material;
        // ∫ P_i^(a) P_j^(b) over [−1, 1], normalised.
        let rule = gauss(40);
        let tables: Vec<Vec<[f64; 3]>> = rule.iter().map(|(x, _)| legendre(TERMS, *x)).collect();
        let norm = |i: usize| (i as f64 + 0.5).sqrt();
        let integral = |i: usize, a: usize, j: usize, b: usize, side: f64| {
            let sum: f64 = rule.iter().zip(&tables).map(|((_, w), t)| w * t[i][a] * t[j][b]).sum();
            norm(i) * norm(j) * sum * (2.0 / side).powi((a + b) as i32)
        };
        let table = |a: usize, b: usize, side: f64| -> Vec<f64> {
            (0..TERMS * TERMS).map(|k| integral(k / TERMS, a, k % TERMS, b, side)).collect()
        };
        let of = |side: f64| [(0, 0), (1, 1), (2, 2), (2, 0), (0, 2)].map(|(a, b)| table(a, b, side));
        let (x, y) = (of(sides[0]), of(sides[1]));
        let size = TERMS * TERMS;
        let stiffness = faer::Mat::from_fn(size, size, |p, q| {
            let (i, j) = (p / TERMS * TERMS + q / TERMS, p % TERMS * TERMS + q % TERMS);
            x[2][i] * y[0][j]
                + x[0][i] * y[2][j]
                + ratio * (x[3][i] * y[4][j] + x[4][i] * y[3][j])
                + 2.0 * (1.0 - ratio) * x[1][i] * y[1][j]
        });
        let squares = stiffness.self_adjoint_eigenvalues(faer::Side::Lower).expect("eigenvalues");
        let mut all: Vec<f64> = squares.iter().map(|s| s.max(0.0).sqrt() * self.stiffness() / TAU).collect();
        all.sort_by(f64::total_cmp);
        // After three rigid motions.
        all[3..3 + count].to_vec()
    }
}

impl Plate {
    /// The lowest frequencies \[Hz\] of a polygon that is star-shaped about the origin, by Ritz with products
    /// of
    /// Legendre polynomials up to a total degree.
    pub(crate) fn polygon_frequencies(&self, corners: &[DVec2], count: usize) -> Vec<f64> {
        const DEGREE: usize = 11;
        let [_, ratio, _] = self.material;
        let reach = corners.iter().map(|c| c.length()).fold(0.0, f64::max);
        let pairs: Vec<[usize; 2]> =
            (0..=DEGREE).flat_map(|i| (0..=DEGREE - i).map(move |j| [i, j])).collect();
        let size = pairs.len();
        let (mut mass, mut stiffness) = (vec![0.0; size * size], vec![0.0; size * size]);
        let rule = gauss(16);
        for k in 0..corners.len() {
            let [a, b] = [corners[k], corners[(k + 1) % corners.len()]].map(|c| c / reach);
            for ((u, wu), (v, wv)) in rule.iter().flat_map(|p| rule.iter().map(move |q| (p, q))) {
                // Collapsed at the origin.
                let (s, t) = (0.5 * (1.0 + u), 0.5 * (1.0 + v));
                let (p, weight) = (s * a.lerp(b, t), 0.25 * wu * wv * s * a.perp_dot(b));
                let [x, y] = [p.x, p.y].map(|x| legendre(DEGREE + 1, x));
                let values: Vec<[f64; 4]> = pairs
                    .iter()
                    .map(|[i, j]| {
                        let (f, g) = (x[*i], y[*j]);
                        [f[0] * g[0], f[2] * g[0], f[0] * g[2], f[1] * g[1]]
                    })
                    .collect();
                for (m, f) in values.iter().enumerate() {
                    for (n, g) in values.iter().enumerate() {
                        mass[m * size + n] += weight * f[0] * g[0];
                        let bend = f[1] * g[1] + f[2] * g[2] + ratio * (f[1] * g[2] + f[2] * g[1]);
                        stiffness[m * size + n] +=
                            weight * (bend + 2.0 * (1.0 - ratio) * f[3] * g[3]) / reach.powi(4);
                    }
                }
            }
        }
        let mut all: Vec<f64> = generalised_eigenvalues(&stiffness, &mut mass, size)
            .into_iter()
            .map(|s| s.max(0.0).sqrt() * self.stiffness() / TAU)
            .collect();
        all.sort_by(f64::total_cmp);
        // After three rigid motions.
        all[3..3 + count].to_vec()
    }
}

/// λ of K x = λ M x, by the Cholesky factor of M, which replaces it.
fn generalised_eigenvalues(stiffness: &[f64], mass: &mut [f64], size: usize) -> Vec<f64> {
    for j in 0..size {
        for i in j..size {
            let sum: f64 = (0..j).map(|k| mass[i * size + k] * mass[j * size + k]).sum();
            let rest = mass[i * size + j] - sum;
            mass[i * size + j] = if i == j { rest.sqrt() } else { rest / mass[j * size + j] };
        }
    }
    // L⁻¹ K L⁻ᵀ, by rows and then by columns.
    let mut reduced = stiffness.to_vec();
    for transposed in [false, true] {
        let at = |i: usize, j: usize| if transposed { j * size + i } else { i * size + j };
        for column in 0..size {
            for i in 0..size {
                let sum: f64 = (0..i).map(|k| mass[i * size + k] * reduced[at(k, column)]).sum();
                reduced[at(i, column)] = (reduced[at(i, column)] - sum) / mass[i * size + i];
            }
        }
    }
    let matrix = faer::Mat::from_fn(size, size, |i, j| 0.5 * (reduced[i * size + j] + reduced[j * size + i]));
    matrix.self_adjoint_eigenvalues(faer::Side::Lower).expect("eigenvalues")
}

fn bisect(f: &dyn Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let positive = f(low) > 0.0;
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        *(if (f(middle) > 0.0) == positive { &mut low } else { &mut high }) = middle;
    }
    0.5 * (low + high)
}

/// Values, first and second derivatives of the Legendre polynomials.
fn legendre(count: usize, x: f64) -> Vec<[f64; 3]> {
    let mut all = vec![[1.0, 0.0, 0.0], [x, 1.0, 0.0]];
    for n in 1..count - 1 {
        let (a, b, m) = (all[n], all[n - 1], n as f64);
        let of = |d: usize| {
            let below = if d == 0 { 0.0 } else { d as f64 * a[d - 1] };
            ((2.0 * m + 1.0) * (x * a[d] + below) - m * b[d]) / (m + 1.0)
        };
        all.push([of(0), of(1), of(2)]);
    }
    all
}

/// Gauss–Legendre on [−1, 1].
fn gauss(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            for _ in 0..50 {
                let [value, slope, _] = legendre(n + 1, x)[n];
                x -= value / slope;
            }
            let slope = legendre(n + 1, x)[n][1];
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// Bessel functions of whole order, by their integrals (NIST Digital Library of Mathematical Functions 10.9,
/// 10.32), to ten digits.
#[derive(Clone, Copy, Debug)]
enum Bessel {
    J,
    I,
    Y,
    K,
}

impl Bessel {
    fn value(self, order: i32, x: f64) -> f64 {
        const PERIOD: usize = 96;
        const LONG: usize = 1500;
        let m = f64::from(order);
        let period = |f: &dyn Fn(f64) -> f64| {
            (0..PERIOD).map(|k| f(TAU * k as f64 / PERIOD as f64)).sum::<f64>() / PERIOD as f64
        };
        // Simpson's rule.
        let simpson = |f: &dyn Fn(f64) -> f64, to: f64, parts: usize| {
            let h = to / parts as f64;
            let weight = |k: usize| if k == 0 || k == parts { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
            (0..=parts).map(|k| weight(k) * f(h * k as f64)).sum::<f64>() * h / 3.0
        };
        let far = (60.0 / x).asinh() + 0.2 * m;
        match self {
            Bessel::J => period(&|t| (m * t - x * t.sin()).cos()),
            Bessel::I => period(&|t| (x * t.cos()).exp() * (m * t).cos()),
            Bessel::K => simpson(&|t| (-x * t.cosh()).exp() * (m * t).cosh(), far, LONG),
            Bessel::Y => {
                let sign = if order % 2 == 0 { 1.0 } else { -1.0 };
                let tail = |t: f64| ((m * t).exp() + sign * (-m * t).exp()) * (-x * t.sinh()).exp();
                (simpson(&|t| (x * t.sin() - m * t).sin(), PI, 300) - simpson(&tail, far, LONG)) / PI
            }
        }
    }

    /// The derivative, from the neighbours in order.
    fn slope(self, order: i32, x: f64) -> f64 {
        let next = self.value(order + 1, x);
        let here = f64::from(order) / x * self.value(order, x);
        match self {
            Bessel::J | Bessel::Y | Bessel::K => here - next,
            Bessel::I => here + next,
        }
    }
}
