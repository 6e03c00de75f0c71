//! Modes of a free ellipsoid by the Rayleigh–Ritz method with polynomials.
//!
//! With x = (a ξ, b η, c ζ) every ellipsoid maps to the unit ball. Polynomials orthonormal on the ball make
//! the mass matrix a multiple of the identity. The stiffness is a sum of integrals over the ball, divided by
//! products of semi-axes:
//!
//! ```text
//! u_i = Σ q_ip φ_p(ξ)
//! K_ip,jq = λ ∫ ∂_iφ_p ∂_jφ_q /(a_i a_j) + μ ∫ ∂_jφ_p ∂_iφ_q /(a_i a_j) + δ_ij μ Σ_k ∫ ∂_kφ_p ∂_kφ_q /a_k²
//! ```
//!
//! so that the integrals are computed once, and an ellipsoid takes eight small symmetric eigenvalue problems,
//! one for each parity class. Frequencies converge from above, faster than any power of the degree. Source:
//! Visscher et al. (1991), "On the normal modes of free vibration of inhomogeneous and anisotropic elastic
//! objects".
//!
//! On the surface a polynomial of degree N is a sum of spherical harmonics of (ξ, η, ζ) up to degree N.
//! Shapes are given in these: see `clangor_core::sound_model::soundbank::modal_soundbank`.

use clangor_core::math::spherical_harmonics::solid_harmonics;
use clangor_core::sound_model::soundbank::modal_soundbank::parity_harmonics;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use glam::DVec3;
use rayon::prelude::*;

use crate::modal_analysis::eigensolver::symmetric_eigenvectors;
use crate::quadrature::gauss_legendre;

/// Relative difference of the frequencies of a degenerate pair due to rounding.
const PAIR: f64 = 1e-7;
/// Fraction of the largest coefficient above which another counts as equally large.
const AS_LARGE: f64 = 0.999;

/// Parity classes: bit 0 is set where a function is odd in x, bit 1 in y, bit 2 in z.
const CLASSES: usize = 8;

/// Polynomials on the unit ball up to a degree, and their integrals.
pub struct BallPolynomials {
    degree: usize,
    /// Of each parity class.
    classes: Vec<Scalars>,
}

/// Orthonormal scalar polynomials of one parity.
struct Scalars {
    /// √(weight) × ∂_k φ_p at the points of the ball, a column for each p.
    slopes: [Mat<f64>; 3],
    /// Coefficients of φ_p on the surface in the harmonics of its parity, a column for each p.
    harmonics: Mat<f64>,
}

/// A mode of an ellipsoid of E = 1 and ρ = 1.
#[derive(Clone, Debug, PartialEq)]
pub struct EllipsoidMode {
    /// ω.
    pub angular_frequency: f64,
    /// Parity class: x → −x takes u to −(−u_x, u_y, u_z) if bit 0 is set, and so on.
    pub parity: u8,
    /// Coefficients of u_x, u_y, u_z, normalised by ∫ u² dV = 1, in the harmonics of their parities.
    pub shape: [Vec<f64>; 3],
}

/// A point of the rule on an octant of the ball, with the weight of all eight.
struct Point {
    direction: DVec3,
    radius: f64,
    weight: f64,
}

impl BallPolynomials {
    /// Even degree, at least 2.
    pub fn new(degree: usize) -> Self {
        let degree = degree.max(2).next_multiple_of(2);
        let points = ball_points(degree);
        // The rule on the sphere is that of the outermost shell, divided by its weights.
        let shell = sphere_points(degree);
        let classes =
            (0..CLASSES).into_par_iter().map(|parity| scalars(parity as u8, degree, &points, &shell));
        BallPolynomials { degree, classes: classes.collect() }
    }

    /// Highest degree.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// All modes below an angular frequency of the ellipsoid of E = 1, ρ = 1 and this Poisson ratio, by
    /// frequency. Rigid motions are left out.
    ///
    /// Modes of one frequency are sorted by parity, and the first of the largest coefficients is positive.
    /// Ellipsoids of other sizes therefore have the same modes in the same order and with the same signs.
    pub fn modes(&self, semi_axes: DVec3, poisson_ratio: f64, limit: f64) -> Vec<EllipsoidMode> {
        let mut modes: Vec<EllipsoidMode> = (0..CLASSES)
            .into_par_iter()
            .flat_map_iter(|parity| self.modes_of_class(parity, semi_axes, poisson_ratio, limit))
            .collect();
        modes.sort_by(|a, b| {
            a.angular_frequency.total_cmp(&b.angular_frequency).then(a.parity.cmp(&b.parity))
        });
        let same =
            |a: &EllipsoidMode, b: &EllipsoidMode| b.angular_frequency <= a.angular_frequency * (1.0 + PAIR);
        for pair in modes.chunk_by_mut(same) {
            let mean = pair.iter().map(|mode| mode.angular_frequency).sum::<f64>() / pair.len() as f64;
            pair.iter_mut().for_each(|mode| mode.angular_frequency = mean);
            pair.sort_by_key(|mode| mode.parity);
        }
        modes
    }

    /// The lowest angular frequency.
    pub fn first(&self, semi_axes: DVec3, poisson_ratio: f64) -> f64 {
        let all = self.modes(semi_axes, poisson_ratio, f64::INFINITY);
        all.first().map_or(f64::NAN, |mode| mode.angular_frequency)
    }

    fn modes_of_class(&self, parity: usize, semi_axes: DVec3, nu: f64, limit: f64) -> Vec<EllipsoidMode> {
        let lambda = nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
        let mu = 0.5 / (1.0 + nu);
        let of = [0, 1, 2].map(|i| &self.classes[parity ^ (1 << i)]);
        let counts = of.map(|scalars| scalars.slopes[0].ncols());
        let starts = [0, counts[0], counts[0] + counts[1]];
        let size = counts.iter().sum();
        // Assembly: 3 × 3 blocks of the stiffness, lower half, from integrals on the ball.
        let mut stiffness = Mat::<f64>::zeros(size, size);
        for i in 0..3 {
            for j in 0..=i {
                let mut block = stiffness.submatrix_mut(starts[i], starts[j], counts[i], counts[j]);
                let mut add = |k: usize, l: usize, factor: f64| {
                    let (left, right) = (of[i].slopes[k].transpose(), &of[j].slopes[l]);
                    let factor = factor / (semi_axes[k] * semi_axes[l]);
                    matmul(block.as_mut(), Accum::Add, left, right, factor, Par::Seq);
                };
                if i == j {
                    (0..3).for_each(|k| add(k, k, if k == i { lambda + 2.0 * mu } else { mu }));
                } else {
                    add(i, j, lambda);
                    add(j, i, mu);
                }
            }
        }
        // Symmetrise, and solve the eigenvalue problem.
        for column in 0..size {
            for row in 0..column {
                stiffness[(row, column)] = stiffness[(column, row)];
            }
        }
        let vectors = symmetric_eigenvectors(stiffness.as_ref());
        let images = &stiffness * &vectors;
        // Eigenvalues as Rayleigh quotients, sorted; rigid motions come first.
        let mut order: Vec<(f64, usize)> =
            (0..size).map(|k| (vectors.col(k).transpose() * images.col(k), k)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let volume = semi_axes.element_product();
        let kept =
            order.into_iter().skip(rigid_motions(parity)).filter(|(square, _)| *square < limit * limit);
        kept.map(|(square, k)| {
            // Shapes as harmonics on the surface, normalised, with a fixed sign.
            let mut shape: [Vec<f64>; 3] = [0, 1, 2].map(|i| {
                let own = vectors.col(k).subrows(starts[i], counts[i]);
                let values = &of[i].harmonics * own;
                values.iter().map(|u| u / volume.sqrt()).collect()
            });
            let largest = shape.iter().flatten().fold(0.0, |most: f64, u| most.max(u.abs()));
            let first = shape.iter().flatten().find(|u| u.abs() >= AS_LARGE * largest);
            if first.is_some_and(|u| *u < 0.0) {
                shape.iter_mut().flatten().for_each(|u| *u = -*u);
            }
            EllipsoidMode { angular_frequency: square.max(0.0).sqrt(), parity: parity as u8, shape }
        })
        .collect()
    }
}

/// Translations are odd in one coordinate, rotations in two.
fn rigid_motions(parity: usize) -> usize {
    usize::from(matches!(parity.count_ones(), 1 | 2))
}

/// The positive half of a Gauss–Legendre rule on [−1, 1], for even functions.
fn half_rule(points: usize) -> impl Iterator<Item = (f64, f64)> {
    gauss_legendre(2 * points).into_iter().skip(points).map(|(x, w)| (2.0 * x - 1.0, 2.0 * w))
}

/// A rule on the sphere, exact for products of two polynomials of one parity up to a degree.
fn sphere_points(degree: usize) -> Vec<(DVec3, f64)> {
    let count = degree / 2 + 1;
    let turn = std::f64::consts::FRAC_PI_2 / count as f64;
    half_rule(count)
        .flat_map(|(z, weight)| {
            let across = (1.0 - z * z).sqrt();
            (0..count).map(move |k| {
                let (sin, cos) = ((k as f64 + 0.5) * turn).sin_cos();
                (DVec3::new(across * cos, across * sin, z), 8.0 * weight * turn)
            })
        })
        .collect()
}

/// A rule in the ball, exact likewise.
fn ball_points(degree: usize) -> Vec<Point> {
    let shell = sphere_points(degree);
    half_rule(degree / 2 + 1)
        .flat_map(|(radius, weight)| {
            shell.iter().map(move |(direction, on_shell)| Point {
                direction: *direction,
                radius,
                weight: weight * radius * radius * on_shell,
            })
        })
        .collect()
}

/// Products of Legendre polynomials, made orthonormal on the ball by the Gram–Schmidt process, applied twice.
fn scalars(parity: u8, degree: usize, points: &[Point], shell: &[(DVec3, f64)]) -> Scalars {
    let odd = [0, 1, 2].map(|axis| usize::from(parity >> axis & 1));
    // Exponents of the parity, by total degree.
    let mut powers: Vec<[usize; 3]> = Vec::new();
    for l in (odd[0]..=degree).step_by(2) {
        for m in (odd[1]..=degree - l).step_by(2) {
            powers.extend((odd[2]..=degree - l - m).step_by(2).map(|n| [l, m, n]));
        }
    }
    powers.sort_by_key(|p| (p.iter().sum::<usize>(), *p));
    let count = points.len();
    // One column each: values, three slopes, and values on the surface.
    let length = 4 * count + shell.len();
    let mut columns = vec![vec![0.0; length]; powers.len()];
    let tables: Vec<[Vec<(f64, f64)>; 3]> =
        points.iter().map(|p| (p.radius * p.direction).to_array().map(|x| legendre(x, degree))).collect();
    let outside: Vec<[Vec<(f64, f64)>; 3]> =
        shell.iter().map(|(d, _)| d.to_array().map(|x| legendre(x, degree))).collect();
    // Products of Legendre polynomials at the points.
    for (column, [l, m, n]) in columns.iter_mut().zip(&powers) {
        for (at, (point, [x, y, z])) in points.iter().zip(&tables).enumerate() {
            let (p, q, r) = (x[*l], y[*m], z[*n]);
            let root = point.weight.sqrt();
            let values = [p.0 * q.0 * r.0, p.1 * q.0 * r.0, p.0 * q.1 * r.0, p.0 * q.0 * r.1];
            values.iter().enumerate().for_each(|(k, v)| column[k * count + at] = root * v);
        }
        for (at, [x, y, z]) in outside.iter().enumerate() {
            column[4 * count + at] = x[*l].0 * y[*m].0 * z[*n].0;
        }
    }
    // Modified Gram–Schmidt, twice.
    for k in 0..columns.len() {
        let (done, rest) = columns.split_at_mut(k);
        let own = &mut rest[0];
        for _ in 0..2 {
            for before in &*done {
                let share = dot(&before[..count], &own[..count]);
                own.iter_mut().zip(before).for_each(|(x, b)| *x -= share * b);
            }
        }
        let norm = dot(&own[..count], &own[..count]).sqrt();
        own.iter_mut().for_each(|x| *x /= norm);
    }
    // Slopes at the points, and projection of the surface values onto harmonics.
    let slopes = [1, 2, 3].map(|k| Mat::from_fn(count, columns.len(), |at, p| columns[p][k * count + at]));
    let kept = parity_harmonics(parity, degree);
    let mut all = Vec::new();
    let mut to_harmonics = Mat::<f64>::zeros(kept.len(), shell.len());
    for (at, (direction, weight)) in shell.iter().enumerate() {
        solid_harmonics(*direction, degree, &mut all);
        kept.iter().enumerate().for_each(|(row, y)| to_harmonics[(row, at)] = weight * all[*y as usize]);
    }
    let surface = Mat::from_fn(shell.len(), columns.len(), |at, p| columns[p][4 * count + at]);
    Scalars { slopes, harmonics: to_harmonics * surface }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// P_n(x) and P_n'(x).
fn legendre(x: f64, degree: usize) -> Vec<(f64, f64)> {
    let mut values = vec![(1.0, 0.0)];
    let (mut before, mut here) = ((0.0, 0.0), (1.0, 0.0));
    for n in 0..degree {
        let j = n as f64;
        let value = ((2.0 * j + 1.0) * x * here.0 - j * before.0) / (j + 1.0);
        let slope = x * here.1 + (j + 1.0) * here.0;
        (before, here) = (here, (value, slope));
        values.push(here);
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_has_the_frequencies_of_lamb() {
        let ball = BallPolynomials::new(10);
        let modes = ball.modes(DVec3::ONE, 0.34, 3.0);
        // ω a/c_s of the lowest modes of a free sphere with ν = 0.34: torsion l = 2, spheroidal l = 2, both
        // fivefold; roots of (l − 1) j_l(x) = x j_{l+1}(x), x = 2.501133 for l = 2.
        let shear = (2.0 * 1.34_f64).sqrt();
        let torsion = modes.iter().filter(|m| (m.angular_frequency * shear - 2.501_133).abs() < 1e-5);
        assert_eq!(torsion.count(), 5, "{:?}", modes.iter().map(|m| m.angular_frequency).collect::<Vec<_>>());
    }

    #[test]
    fn more_polynomials_change_nothing() {
        let (few, many) = (BallPolynomials::new(12), BallPolynomials::new(14));
        for semi_axes in
            [DVec3::new(0.05, 0.7, 0.71), DVec3::new(0.1, 0.15, 0.98), DVec3::new(0.3, 0.5, 0.81)]
        {
            let limit = 4.0 * few.first(semi_axes, 0.2);
            let (few, many) = (few.modes(semi_axes, 0.2, limit), many.modes(semi_axes, 0.2, limit));
            for (k, (few, many)) in few.iter().zip(&many).enumerate() {
                let error = few.angular_frequency / many.angular_frequency - 1.0;
                // From above. Residual seen: 3e-6, the 33rd of the thickest.
                assert!((-1e-9..1e-5).contains(&error), "{semi_axes}, mode {k}: {error:e}");
            }
        }
    }
}
