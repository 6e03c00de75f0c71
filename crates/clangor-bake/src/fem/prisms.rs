//! Stiffness and mass of a flat plate of triangular prisms: order 4 in the plane, order 2 or 4 across it.
//!
//! ```text
//! N_ip(x, y, z) = T_i(x, y) l_p(z),    T_i of fourth order on the lattice of a triangle, l_p on even nodes
//! ```
//!
//! As hexahedra in a box ([`bricks`](super::bricks)), prisms much wider than the plate is thick bend without
//! locking. Triangles are straight, so that integrals are products of those of one triangle and one interval.

use glam::{DMat3, DVec2, DVec3};

use super::across_walls::{Columns, Unknowns};
use super::bricks::{Axis, is_wall};
use super::rigid_motions::rigid_motions;
use super::{ElasticConstants, ElasticSystem, Elements};
use crate::quadrature::gauss_legendre;

/// Order in the plane.
pub(crate) const ORDER: usize = 4;
/// Nodes of a triangle of this order.
pub(crate) const LATTICE: usize = 15;
/// Points of the quadrature in each direction, exact for the mass.
const POINTS: usize = 6;

/// The nodes of a triangle by their barycentric coordinates times the order.
pub(crate) fn lattice() -> [[usize; 3]; LATTICE] {
    let mut all = [[0; 3]; LATTICE];
    let each = (0..=ORDER).flat_map(|i| (0..=ORDER - i).map(move |j| [i, j, ORDER - i - j]));
    all.iter_mut().zip(each).for_each(|(own, at)| *own = at);
    all
}

/// A plate of prisms.
#[derive(Clone, Debug)]
pub(crate) struct Prisms {
    /// Corners of the triangles in the plane \[m\].
    pub(crate) corners: Vec<[DVec2; 3]>,
    /// Nodes of each prism: those of the lattice, level by level.
    pub(crate) elements: Vec<Vec<u32>>,
    /// Cells across: 1 for order 2, 2 for order 4.
    pub(crate) layers: usize,
    /// \[m\]
    pub(crate) thickness: f64,
    /// Columns: the two directions of the plane and the normal.
    pub(crate) frame: DMat3,
}

type Table = [[f64; LATTICE]; LATTICE];

/// Integrals over a triangle of area 1; derivatives are with respect to the barycentric coordinates.
struct Integrals {
    /// ∫ T_i T_j.
    plain: Table,
    /// ∫ ∂_a T_i T_j.
    mixed: [Table; 3],
    /// ∫ ∂_a T_i ∂_b T_j.
    steep: [[Table; 3]; 3],
}

impl Integrals {
    fn new() -> Self {
        let zero = [[0.0; LATTICE]; LATTICE];
        let mut all = Integrals { plain: zero, mixed: [zero; 3], steep: [[zero; 3]; 3] };
        let rule = gauss_legendre(POINTS);
        for (u, wu) in &rule {
            for (v, wv) in &rule {
                // Collapsed square.
                let at = [*u, (1.0 - u) * v, (1.0 - u) * (1.0 - v)];
                let weight = 2.0 * wu * wv * (1.0 - u);
                let shapes = lattice().map(|index| shape(index, at));
                for (i, (value, slopes)) in shapes.iter().enumerate() {
                    for (j, (other, other_slopes)) in shapes.iter().enumerate() {
                        all.plain[i][j] += weight * value * other;
                        for (a, slope) in slopes.iter().enumerate() {
                            all.mixed[a][i][j] += weight * slope * other;
                            for (b, other_slope) in other_slopes.iter().enumerate() {
                                all.steep[a][b][i][j] += weight * slope * other_slope;
                            }
                        }
                    }
                }
            }
        }
        all
    }
}

/// Value and derivatives of a shape function, Π P_i(L_a) with P_i(L) = Π_{m<i} (4L − m)/(m + 1).
fn shape(index: [usize; 3], at: [f64; 3]) -> (f64, [f64; 3]) {
    let factor = |a: usize| {
        let (mut value, mut slope) = (1.0, 0.0);
        for m in 0..index[a] {
            let (m, order) = (m as f64, ORDER as f64);
            slope = (slope * (order * at[a] - m) + value * order) / (m + 1.0);
            value *= (order * at[a] - m) / (m + 1.0);
        }
        (value, slope)
    };
    let [(p, dp), (q, dq), (r, dr)] = [0, 1, 2].map(factor);
    (p * q * r, [dp * q * r, p * dq * r, p * q * dr])
}

/// Area \[m²\] and gradients of the barycentric coordinates [1/m] of a triangle.
fn gradients([a, b, c]: [DVec2; 3]) -> (f64, [DVec2; 3]) {
    let twice = (b - a).perp_dot(c - a);
    // The gradient of a corner is normal to the side across it.
    (0.5 * twice, [c - b, a - c, b - a].map(|side| side.perp() / twice))
}

/// Stiffness and mass of a plate on these nodes \[m\], in the frame of the body.
pub(crate) fn plate_of_prisms(
    prisms: &Prisms,
    nodes: &[DVec3],
    constants: &ElasticConstants,
    unknowns: Unknowns,
) -> ElasticSystem {
    let integrals = Integrals::new();
    let across = Axis::new(prisms.thickness, prisms.layers, unknowns);
    let ElasticConstants { lame_lambda: lambda, shear_modulus: mu, density } = *constants;
    let (frame, back) = (prisms.frame, prisms.frame.transpose());
    let mut columns = Vec::new();
    if is_wall(prisms.layers, unknowns) {
        let of_element =
            |e: &Vec<u32>| (0..LATTICE).map(|i| [0, 1, 2].map(|level| e[level * LATTICE + i])).collect();
        columns = prisms.elements.iter().flat_map::<Vec<[u32; 3]>, _>(of_element).collect();
        // Neighbours share the columns of their sides.
        columns.sort_unstable();
        columns.dedup();
    }
    let elements = Elements {
        nodes: nodes.to_vec(),
        elements: &prisms.elements,
        rigid: rigid_motions(nodes).into(),
        columns: Columns(columns),
    };
    ElasticSystem::assemble(elements, |e| {
        let (area, slopes) = gradients(prisms.corners[e]);
        let (integrals, across) = (&integrals, &across);
        move |n: usize, m: usize| {
            let ([i, p], [j, q]) = ([n % LATTICE, n / LATTICE], [m % LATTICE, m / LATTICE]);
            // ∫ ∂_r N_n ∂_s N_m.
            let line = |of: bool, with: bool| area * across.integral(p, q, [of, with]);
            let mut products = DMat3::ZERO;
            for (a, slope) in slopes.iter().enumerate() {
                for (b, other) in slopes.iter().enumerate() {
                    let part = integrals.steep[a][b][i][j] * line(false, false);
                    for r in 0..2 {
                        for s in 0..2 {
                            products.col_mut(s)[r] += part * slope[r] * other[s];
                        }
                    }
                }
                for r in 0..2 {
                    products.col_mut(2)[r] += integrals.mixed[a][i][j] * slope[r] * line(false, true);
                    products.col_mut(r)[2] += integrals.mixed[a][j][i] * slope[r] * line(true, false);
                }
            }
            products.col_mut(2)[2] = integrals.plain[i][j] * line(true, true);
            let dot = products.x_axis.x + products.y_axis.y + products.z_axis.z;
            let block =
                lambda * products + mu * products.transpose() + DMat3::from_diagonal(DVec3::splat(mu * dot));
            (frame * block * back, density * integrals.plain[i][j] * line(false, false))
        }
    })
}
