//! The lowest frequency of a free solid of any shape, by polynomials over it: the Rayleigh–Ritz method
//! without a volume mesh.
//!
//! With ξ = Rᵀ(x − x̄)/ℓ in the principal frame, ℓ the largest extents from the centre of mass, and monomials
//! φ_p(ξ) up to a degree,
//!
//! ```text
//! u_i = Σ q_ip φ_p,    M_pq = ∫ φ_p φ_q dV
//! K_ip,jq = ∫ λ ∂_iφ_p ∂_jφ_q + μ ∂_jφ_p ∂_iφ_q + δ_ij μ Σ_k ∂_kφ_p ∂_kφ_q dV
//! ```
//!
//! are sums of the moments of the solid, and those are integrals over its closed surface: for f homogeneous
//! of degree d
//!
//! ```text
//! ∫ f dV = 1/(d + 3) ∮ f ξ·n dS,   on a triangle (a, b, c) with det(a, b, c) ∫∫ f du dv
//! ```
//!
//! by a Gauss rule that is exact for the degree, or has a negligible error for a small triangle. A rough
//! crack therefore costs only its triangles. The frequency converges from above. Thin plates are not too
//! stiff in bending: a deflection of degree N involves in-plane motions of the same degree.
//!
//! Sources: Visscher et al. (1991), "On the normal modes of free vibration of inhomogeneous and anisotropic
//! elastic objects", for bodies of simple shape; the moments of a polyhedron are those of its signed
//! tetrahedra. Not for shapes with deep notches, holes or thin walls around a cavity, whose lowest mode is no
//! polynomial of low degree.

use std::f64::consts::TAU;

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::principal_axes::principal_axes;
use clangor_core::geometry::solid::MeshError;
use clangor_core::geometry::tri_mesh::TriMesh;
use faer::linalg::matmul::matmul;
use faer::linalg::solvers::Solve;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, Mat, MatRef, Par, Side};
use glam::DVec3;

use crate::fem::ElasticConstants;
use crate::modal_analysis::eigensolver::symmetric_eigenvectors;
use crate::quadrature::gauss_legendre;

/// Supported degrees.
const RIGID_DOFS: std::ops::RangeInclusive<usize> = 2..=8;
/// Number of fields of degree 2 in three components, rigid motions included: start block of the iteration.
const START: usize = 30;
/// Relative change of ω² in a step that counts as converged.
const STILL: f64 = 1e-6;
/// Relative error of an integral over a triangle.
const LEFT_OUT: f64 = 1e-12;
/// Triangles per batch of points.
const BATCH: usize = 64;
/// Most steps.
const MOST_STEPS: usize = 30;

/// Reasons why polynomials give no lowest frequency.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SolidError {
    /// The surface encloses no solid.
    #[error(transparent)]
    Surface(#[from] MeshError),
    /// Unsupported degree.
    #[error("polynomials of degree {0}; from 2 to 8 are taken")]
    Degree(usize),
    /// Polynomials that are linearly dependent to rounding, or a stiffness that is not positive.
    #[error("the {matrix} of polynomials of degree {degree} over a solid of {extents} m is not positive")]
    Singular {
        /// Name of the matrix.
        matrix: &'static str,
        /// The degree.
        degree: usize,
        /// ℓ \[m\].
        extents: DVec3,
    },
}

/// The lowest frequency \[Hz\] of a free solid enclosed by a closed surface, by polynomials of a degree from
/// 2 to 8.
///
/// # Errors
/// [`SolidError`].
pub fn lowest_by_polynomials(
    surface: &TriMesh,
    constants: &ElasticConstants,
    degree: usize,
) -> Result<f64, SolidError> {
    if !RIGID_DOFS.contains(&degree) {
        return Err(SolidError::Degree(degree));
    }
    // Principal frame, scaled to unit extents; moments up to twice the degree.
    let mass = MassProperties::of(surface)?;
    let (_, axes) = principal_axes(mass.inertia);
    let rotated = surface.vertices.iter().map(|x| axes.transpose() * (*x - mass.centre_of_mass));
    let mut vertices: Vec<DVec3> = rotated.collect();
    let extents = vertices.iter().fold(DVec3::ZERO, |largest, x| largest.max(x.abs()));
    vertices.iter_mut().for_each(|x| *x /= extents);
    let moments = Moments::of(&vertices, &surface.triangles, 2 * degree);
    let singular = |matrix| SolidError::Singular { matrix, degree, extents };

    // Mass matrix and its Cholesky factor.
    let powers = powers(degree);
    let count = powers.len();
    let gram = Mat::from_fn(count, count, |p, q| moments.of_product(powers[p], powers[q]));
    let lower = gram.llt(Side::Lower).map_err(|_| singular("mass"))?;
    // Rows: polynomials orthonormal on the solid.
    let mut orthonormal = Mat::<f64>::identity(count, count);
    solve_lower_triangular_in_place(lower.L(), orthonormal.as_mut(), Par::Seq);

    let (lambda, mu) =
        (constants.lame_lambda / constants.density, constants.shear_modulus / constants.density);
    // Integrals of products of slopes.
    let slopes: [[Mat<f64>; 3]; 3] = std::array::from_fn(|k| {
        std::array::from_fn(|l| match l <= k {
            true => between(&orthonormal, &moments, &powers, [k, l], extents),
            false => Mat::new(),
        })
    });
    // ∫ ∂_kφ_p ∂_lφ_q.
    let slope = |k: usize, l: usize, p: usize, q: usize| match l <= k {
        true => slopes[k][l][(p, q)],
        false => slopes[l][k][(q, p)],
    };
    // Stiffness matrix.
    let mut stiffness = Mat::from_fn(3 * count, 3 * count, |row, column| {
        let ([i, j], [p, q]) = ([row / count, column / count], [row % count, column % count]);
        let own = lambda * slope(i, j, p, q) + mu * slope(j, i, p, q);
        own + if i == j { mu * (0..3).map(|k| slope(k, k, p, q)).sum::<f64>() } else { 0.0 }
    });
    let unmoved = rigid_motions(lower.L(), &powers, extents);
    // Shift the rigid motions above all other eigenvalues.
    let lift = (0..3 * count).map(|k| stiffness[(k, k)]).fold(0.0, f64::max);
    matmul(stiffness.as_mut(), Accum::Add, &unmoved, unmoved.transpose(), lift, Par::Seq);
    // Lowest eigenvalue.
    let square = lowest(&stiffness, count).ok_or_else(|| singular("stiffness"))?;
    Ok(square.max(0.0).sqrt() / TAU)
}

/// Exponents of the monomials, by degree.
fn powers(degree: usize) -> Vec<[usize; 3]> {
    let mut powers = Vec::new();
    for l in 0..=degree {
        for m in 0..=degree - l {
            powers.extend((0..=degree - l - m).map(|n| [l, m, n]));
        }
    }
    powers.sort_by_key(|p| (p.iter().sum::<usize>(), *p));
    powers
}

/// ∫ ξ^i η^j ζ^k dV, i + j + k up to a degree.
struct Moments {
    degree: usize,
    /// A row for each pair (i, j), a column for each k.
    values: Mat<f64>,
}

impl Moments {
    /// The row of a pair: all j of the lower i first.
    fn row(&self, i: usize, j: usize) -> usize {
        i * (2 * self.degree + 3 - i) / 2 + j
    }

    fn of_product(&self, p: [usize; 3], q: [usize; 3]) -> f64 {
        let [i, j, k] = [p[0] + q[0], p[1] + q[1], p[2] + q[2]];
        self.values[(self.row(i, j), k)] / (i + j + k + 3) as f64
    }

    /// Moments of the solid within triangles that are counter-clockwise seen from outside.
    fn of(vertices: &[DVec3], triangles: &[[u32; 3]], degree: usize) -> Self {
        let width = degree + 1;
        let rows = width * (width + 1) / 2;
        let mut moments = Moments { degree, values: Mat::zeros(rows, width) };
        let rules: Vec<Vec<[f64; 3]>> = (1..=degree / 2 + 1).map(triangle_rule).collect();
        for some in triangles.chunks(BATCH) {
            // Quadrature points of the batch.
            let points: Vec<(DVec3, f64)> = some
                .iter()
                .flat_map(|corners| {
                    let [a, b, c] = corners.map(|v| vertices[v as usize]);
                    let volume = a.dot(b.cross(c));
                    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
                    let rule = &rules[points(longest, degree) - 1];
                    rule.iter().map(move |[s, t, w]| (a + *s * (b - a) + *t * (c - a), w * volume))
                })
                .collect();
            // Weighted products of powers of ξ and η, and powers of ζ.
            let (mut flat, mut high) =
                (Mat::<f64>::zeros(rows, points.len()), Mat::<f64>::zeros(width, points.len()));
            for (column, (point, weight)) in points.iter().enumerate() {
                let (mut row, mut of_x) = (0, *weight);
                for i in 0..width {
                    let mut of_y = of_x;
                    for _ in 0..width - i {
                        flat[(row, column)] = of_y;
                        of_y *= point.y;
                        row += 1;
                    }
                    of_x *= point.x;
                }
                let mut of_z = 1.0;
                for k in 0..width {
                    high[(k, column)] = of_z;
                    of_z *= point.z;
                }
            }
            // All moments of the batch as one matrix product.
            matmul(moments.values.as_mut(), Accum::Add, &flat, high.transpose(), 1.0, Par::Seq);
        }
        moments
    }
}

/// Points along an edge of this length, in extents of the solid, for polynomials of a degree.
///
/// The rule of n points has an error of about C(degree, 2n) (length/4)^2n, and none from half the degree on.
fn points(length: f64, degree: usize) -> usize {
    let exact = degree / 2 + 1;
    let mut left = 1.0;
    for n in 1..exact {
        for k in [2 * n - 2, 2 * n - 1] {
            left *= 0.25 * length * (degree - k) as f64 / (k + 1) as f64;
        }
        if left <= LEFT_OUT {
            return n;
        }
    }
    exact
}

/// (s, t, weight) on the triangle 0 ≤ s, t, s + t ≤ 1: a square collapsed, which raises the degree by one.
fn triangle_rule(points: usize) -> Vec<[f64; 3]> {
    let line = gauss_legendre(points);
    let across = |(s, w): &(f64, f64)| {
        let (s, w) = (*s, *w);
        line.iter().map(move |(t, v)| [s, (1.0 - s) * t, (1.0 - s) * w * v]).collect::<Vec<_>>()
    };
    line.iter().flat_map(across).collect()
}

/// ∫ ∂_kφ_p ∂_lφ_q of orthonormal polynomials, slopes along x.
fn between(
    orthonormal: &Mat<f64>,
    moments: &Moments,
    powers: &[[usize; 3]],
    [k, l]: [usize; 2],
    extents: DVec3,
) -> Mat<f64> {
    let count = powers.len();
    let lowered = |mut power: [usize; 3], axis: usize| {
        let factor = power[axis] as f64;
        power[axis] = power[axis].saturating_sub(1);
        (factor, power)
    };
    let of_monomials = Mat::from_fn(count, count, |p, q| {
        let ((f, p), (g, q)) = (lowered(powers[p], k), lowered(powers[q], l));
        if f * g == 0.0 { 0.0 } else { f * g * moments.of_product(p, q) / (extents[k] * extents[l]) }
    });
    orthonormal * of_monomials * orthonormal.transpose()
}

/// The six rigid motions in the orthonormal polynomials, orthonormal themselves.
fn rigid_motions(lower: MatRef<'_, f64>, powers: &[[usize; 3]], extents: DVec3) -> Mat<f64> {
    let count = powers.len();
    let place = |power: [usize; 3]| powers.iter().position(|p| *p == power).unwrap_or(0);
    let linear = |axis: usize| place(std::array::from_fn(|k| usize::from(k == axis)));
    let mut motions = Mat::<f64>::zeros(3 * count, 6);
    for axis in 0..3 {
        let mut moved: Vec<(usize, usize, usize, f64)> = vec![(axis, axis, place([0; 3]), 1.0)];
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        moved.push((3 + axis, i, linear(j), -extents[j]));
        moved.push((3 + axis, j, linear(i), extents[i]));
        for (motion, component, monomial, amount) in moved {
            // Coefficients of φ = L φ' from those of φ.
            for p in 0..=monomial {
                motions[(component * count + p, motion)] += lower[(monomial, p)] * amount;
            }
        }
    }
    orthonormalise(&mut motions);
    motions
}

/// Gram–Schmidt process, applied twice.
fn orthonormalise(columns: &mut Mat<f64>) {
    for k in 0..columns.ncols() {
        for _ in 0..2 {
            for before in 0..k {
                let share = columns.col(before).transpose() * columns.col(k);
                for row in 0..columns.nrows() {
                    columns[(row, k)] -= share * columns[(row, before)];
                }
            }
        }
        let norm = columns.col(k).norm_l2();
        columns.col_mut(k).iter_mut().for_each(|x| *x /= norm);
    }
}

/// The lowest eigenvalue of a positive matrix, by inverse iteration with a block of the lowest polynomials.
fn lowest(matrix: &Mat<f64>, count: usize) -> Option<f64> {
    let factor = matrix.llt(Side::Lower).ok()?;
    let of_start = START / 3;
    let mut block = Mat::from_fn(3 * count, START, |row, column| {
        f64::from(row / count == column / of_start && row % count == column % of_start)
    });
    let mut before = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        block = factor.solve(&block);
        orthonormalise(&mut block);
        let reduced = block.transpose() * (matrix * &block);
        let vectors = symmetric_eigenvectors(reduced.as_ref());
        let images = &reduced * &vectors;
        let values = (0..START).map(|k| vectors.col(k).transpose() * images.col(k));
        let square = values.fold(f64::INFINITY, f64::min);
        if (before - square).abs() <= STILL * square {
            return Some(square);
        }
        before = square;
    }
    before.is_finite().then_some(before)
}

#[cfg(test)]
mod tests {
    use clangor_core::geometry::refine::refine_to_edge;
    use clangor_core::material::presets::GLASS;
    use clangor_core::shape::Shape;

    use super::*;
    use crate::soundbank::modal::ellipsoid_modes::BallPolynomials;

    #[test]
    fn moments_of_a_brick_are_products() {
        let side = |corner: u32, axis: u32| f64::from(corner >> axis & 1) * 2.0 - 1.0;
        let corner = |k: u32| DVec3::new(side(k, 0), side(k, 1), side(k, 2));
        let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        let mesh = TriMesh { vertices: (0..8).map(corner).collect(), triangles };
        // Small triangles get fewer points.
        let fine = refine_to_edge(&mesh, 0.1);
        let one = |i: usize| if i.is_multiple_of(2) { 2.0 / (i as f64 + 1.0) } else { 0.0 };
        for mesh in [mesh, fine] {
            let mut worst = 0.0_f64;
            let moments = Moments::of(&mesh.vertices, &mesh.triangles, 16);
            for [i, j, k] in powers(16) {
                let found = moments.of_product([i, j, k], [0; 3]);
                worst = worst.max((found - one(i) * one(j) * one(k)).abs());
            }
            // 1e-14 seen, with 12 and with 12 288 triangles.
            assert!(worst < 1e-12, "{worst:e}");
        }
    }

    /// The same method by other integrals: the mesh of an ellipsoid against polynomials on the ball.
    #[test]
    fn an_ellipsoid_has_the_frequency_of_the_ball() {
        let glass = GLASS.material();
        let constants = ElasticConstants::of(&glass).expect("an elastic material");
        let axes = DVec3::new(0.01, 0.03, 0.05);
        let surface = Shape::parse("ellipsoid:0.01x0.03x0.05").expect("an ellipsoid").mesh();
        let speed = (glass.youngs_modulus / glass.density).sqrt();
        let ball = BallPolynomials::new(6).first(axes, glass.poisson_ratio) * speed / TAU;
        let found = lowest_by_polynomials(&surface, &constants, 6).expect("a frequency");
        // 11 376.8 and 11 371.1 Hz seen, the first with 7220 flat triangles.
        assert!((found / ball - 1.0).abs() < 2e-3, "{found} {ball}");
    }

    #[test]
    fn what_is_no_solid_is_refused() {
        let constants = ElasticConstants::of(&GLASS.material()).expect("an elastic material");
        let mut open = Shape::parse("box:1x1x1").expect("a box").mesh();
        assert_eq!(lowest_by_polynomials(&open, &constants, 9), Err(SolidError::Degree(9)));
        open.vertices.iter_mut().for_each(|x| x.z = 0.0);
        assert!(matches!(lowest_by_polynomials(&open, &constants, 4), Err(SolidError::Surface(_))));
    }
}
