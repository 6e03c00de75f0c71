//! Integrals over the part of a body inside each cell, exact, from the triangles of its surface.
//!
//! For a function f in a cell from z₀ to z₁, with F(x, y, z) = ∫_{z₀}^{min(z, z₁)} f dz and F = 0 below z₀,
//!
//! ```text
//! ∫_{body ∩ cell} f dV = ∮_{surface in the column of the cell} F n_z dA
//! ```
//!
//! by Gauss's theorem, as nothing of the surface is left out. Only triangles are clipped, against planes of
//! the grid; the faces of the cells do not matter. Above the cell, F does not depend on z: one two-dimensional
//! moment of each cell, summed down the column, closes it. With Legendre polynomials for f, of degree 2p
//! along each axis, the moments become weights on the Gauss points of the cube that integrate products of two
//! displacements exactly. Weights may be negative.

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;
use pulp::{Simd, WithSimd};
use rayon::prelude::*;

use super::basis::Basis;
use super::grid::CellGrid;
use crate::quadrature::gauss_legendre;

/// Points per direction for a vanishing triangle: the polynomials of a small one vary little, but their high
/// degrees must not alias.
const FEWEST_POINTS: f64 = 4.5;
/// Largest number of moments along an axis.
const MOST: usize = 9;
/// Most corners of a clipped triangle.
const CORNERS: usize = 9;

/// Legendre moments of a body in the cells of a grid, in coordinates from −1 to 1 in each cell.
pub(super) struct CellIntegrals {
    grid: CellGrid,
    /// Moments along an axis: 2p + 1.
    count: usize,
    /// ∫ P_a(x) P_b(y) P_c(z), by cell, c, a, b.
    moments: Vec<f64>,
}

/// A piece of a triangle in one cell, in units of cells from the corner of the cell.
struct Piece {
    cell: usize,
    corners: [DVec3; 3],
}

impl CellIntegrals {
    pub(super) fn new(surface: &TriMesh, grid: &CellGrid, basis: &Basis) -> Self {
        let count = basis.points().len();
        let full = 3 * basis.degree() + 2;
        let rules: Vec<Vec<(f64, f64)>> = (0..=full).map(gauss_legendre).collect();
        let pieces = pieces(surface, grid);
        // Cells in parallel; the pieces of each in a fixed order.
        let (flat, cube) = (count * count, count.pow(3));
        let cells: Vec<(usize, Vec<f64>, Vec<f64>)> = pieces
            .par_chunk_by(|a, b| a.cell == b.cell)
            .map(|own| {
                let (mut moments, mut column) = (vec![0.0; cube], vec![0.0; flat]);
                let (moments_of, column_of) = (&mut moments[..], &mut column[..]);
                pulp::Arch::new().dispatch(Sums {
                    pieces: own,
                    rules: &rules,
                    count,
                    moments: moments_of,
                    column: column_of,
                });
                (own[0].cell, moments, column)
            })
            .collect();
        let total = grid.counts.iter().product::<usize>();
        let (mut moments, mut columns) = (vec![0.0; total * cube], vec![0.0; total * flat]);
        for (cell, own, column) in cells {
            moments[cell * cube..(cell + 1) * cube].copy_from_slice(&own);
            columns[cell * flat..(cell + 1) * flat].copy_from_slice(&column);
        }
        // The surface above a cell closes its column.
        let levels = grid.counts[2];
        for top in (0..total).filter(|cell| cell % levels > 0).collect::<Vec<_>>().into_iter().rev() {
            let (below, above) = columns.split_at_mut(top * flat);
            let below = &mut below[(top - 1) * flat..];
            for (k, value) in above[..flat].iter().enumerate() {
                moments[(top - 1) * cube + k] += value;
                below[k] += value;
            }
        }
        CellIntegrals { grid: *grid, count, moments }
    }

    fn of(&self, place: [usize; 3]) -> &[f64] {
        let cube = self.count.pow(3);
        let cell = self.grid.index(place);
        &self.moments[cell * cube..(cell + 1) * cube]
    }

    /// Filled part of a cell.
    pub(super) fn filled(&self, place: [usize; 3]) -> f64 {
        self.of(place)[0] / 8.0
    }

    /// Weights on the Gauss points of a unit cube, by x, y, z.
    pub(super) fn weights(&self, place: [usize; 3], basis: &Basis) -> Vec<f64> {
        let n = self.count;
        let table = basis.from_legendre();
        let moments = self.of(place);
        // One axis after another: from (c, a, b) to (a, b, z), (b, z, x), (z, x, y), each moving the first
        // axis to the end.
        let transform = |from: &[f64]| {
            let mut to = vec![0.0; n * n * n];
            for rest in 0..n * n {
                for q in 0..n {
                    let sum: f64 = (0..n).map(|k| table[q * n + k] * from[k * n * n + rest]).sum();
                    to[rest * n + q] = sum;
                }
            }
            to
        };
        let by_zxy = transform(&transform(&transform(moments)));
        let mut weights = vec![0.0; n * n * n];
        for (k, value) in by_zxy.into_iter().enumerate() {
            let (z, x, y) = (k / (n * n), k / n % n, k % n);
            // Moments are over a cube of edge 2.
            weights[(x * n + y) * n + z] = value / 8.0;
        }
        weights
    }
}

/// All triangles, clipped to the cells, by cell.
fn pieces(surface: &TriMesh, grid: &CellGrid) -> Vec<Piece> {
    let mut pieces = Vec::new();
    let range = |polygon: &Polygon, axis: usize| {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for corner in polygon.corners() {
            (low, high) = (low.min(corner[axis]), high.max(corner[axis]));
        }
        low.floor() as usize..=(high.floor() as usize).min(grid.counts[axis] - 1)
    };
    for t in 0..surface.triangles.len() {
        let triangle = Polygon::triangle(surface.corners(t).map(|x| grid.scaled(x)));
        for i in range(&triangle, 0) {
            let slab = triangle.between(0, i as f64);
            if slab.is_empty() {
                continue;
            }
            for j in range(&slab, 1) {
                let bar = slab.between(1, j as f64);
                if bar.is_empty() {
                    continue;
                }
                for k in range(&bar, 2) {
                    let part = bar.between(2, k as f64);
                    let corner = DVec3::new(i as f64, j as f64, k as f64);
                    let cell = grid.index([i, j, k]);
                    let corners = part.corners();
                    for q in 1..corners.len().max(2) - 1 {
                        let corners = [corners[0], corners[q], corners[q + 1]].map(|x| x - corner);
                        pieces.push(Piece { cell, corners });
                    }
                }
            }
        }
    }
    pieces.sort_by_key(|piece| piece.cell);
    pieces
}

/// A convex polygon.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [DVec3; CORNERS],
    count: usize,
}

impl Polygon {
    fn triangle([a, b, c]: [DVec3; 3]) -> Self {
        let mut corners = [DVec3::ZERO; CORNERS];
        corners[..3].copy_from_slice(&[a, b, c]);
        Polygon { corners, count: 3 }
    }

    fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    fn is_empty(&self) -> bool {
        self.count < 3
    }

    /// The part from `low` to `low` + 1 along an axis.
    fn between(&self, axis: usize, low: f64) -> Self {
        self.clipped(axis, low, 1.0).clipped(axis, low + 1.0, -1.0)
    }

    /// The part above a plane for side 1, below it for side −1.
    fn clipped(&self, axis: usize, plane: f64, side: f64) -> Self {
        let mut part = Polygon { corners: [DVec3::ZERO; CORNERS], count: 0 };
        let mut push = |corner: DVec3| {
            part.corners[part.count] = corner;
            part.count += 1;
        };
        let corners = self.corners();
        for (n, here) in corners.iter().enumerate() {
            let next = corners[(n + 1) % corners.len()];
            let (a, b) = (side * (here[axis] - plane), side * (next[axis] - plane));
            if a >= 0.0 {
                push(*here);
            }
            if (a >= 0.0) != (b >= 0.0) {
                let mut cut = *here + a / (a - b) * (next - *here);
                cut[axis] = plane;
                push(cut);
            }
        }
        part
    }
}

/// Sums of the pieces of one cell.
struct Sums<'a> {
    pieces: &'a [Piece],
    /// Gauss rules by their number of points.
    rules: &'a [Vec<(f64, f64)>],
    count: usize,
    /// ∮ P_a P_b ∫P_c n_z dA, by c, a, b.
    moments: &'a mut [f64],
    /// The same for a point above the cell, where c = 0 alone remains.
    column: &'a mut [f64],
}

impl WithSimd for Sums<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        match self.count {
            7 => self.sum::<7, 49>(),
            9 => self.sum::<9, 81>(),
            other => unreachable!("{other} moments along an axis"),
        }
    }
}

impl Sums<'_> {
    /// With N moments along an axis, and N² in a plane.
    #[inline(always)]
    fn sum<const N: usize, const PLANE: usize>(self) {
        const { assert!(N <= MOST && PLANE == N * N) }
        let full = self.rules.len() - 1;
        let moments = self.moments.as_chunks_mut::<PLANE>().0;
        let column = &mut self.column.as_chunks_mut::<PLANE>().0[0];
        for Piece { corners: [a, b, c], .. } in self.pieces {
            let (ab, ac) = (*b - *a, *c - *a);
            // n_z dA, twice.
            let area = ab.x * ac.y - ab.y * ac.x;
            if area == 0.0 {
                continue;
            }
            let extent =
                ab.abs().max_element().max(ac.abs().max_element()).max((*c - *b).abs().max_element());
            let points = full.min((FEWEST_POINTS + full as f64 * extent.sqrt()) as usize);
            // Points of a collapsed square.
            for (u, wu) in &self.rules[points] {
                for (v, wv) in &self.rules[points] {
                    let at = *a + *u * ab + v * (1.0 - u) * ac;
                    // The cell has edge 2 in the coordinates of the polynomials.
                    let weight = 4.0 * wu * wv * (1.0 - u) * area;
                    let x = legendre::<N>(2.0 * at.x - 1.0);
                    let y = legendre::<N>(2.0 * at.y - 1.0);
                    let z = integrated::<N>(2.0 * at.z - 1.0);
                    let mut plane = [0.0; PLANE];
                    for i in 0..N {
                        for j in 0..N {
                            plane[i * N + j] = weight * x[i] * y[j];
                        }
                    }
                    for (sum, value) in column.iter_mut().zip(&plane) {
                        *sum += 2.0 * value;
                    }
                    for (sums, z) in moments.iter_mut().zip(z) {
                        for (sum, value) in sums.iter_mut().zip(&plane) {
                            *sum += z * value;
                        }
                    }
                }
            }
        }
    }
}

/// P_0 … P_{N−1}.
#[inline(always)]
fn legendre<const N: usize>(y: f64) -> [f64; N] {
    let mut all = [1.0; N];
    all[1] = y;
    for k in 1..N - 1 {
        let order = k as f64;
        all[k + 1] = ((2.0 * order + 1.0) * y * all[k] - order * all[k - 1]) / (order + 1.0);
    }
    all
}

/// ∫_{−1}^{z} P_k, for k < N.
#[inline(always)]
fn integrated<const N: usize>(z: f64) -> [f64; N] {
    let values = legendre::<N>(z);
    let order = (N - 1) as f64;
    let next = ((2.0 * order + 1.0) * z * values[N - 1] - order * values[N - 2]) / (order + 1.0);
    std::array::from_fn(|k| match k {
        0 => z + 1.0,
        _ => (if k + 1 < N { values[k + 1] } else { next } - values[k - 1]) / (2 * k + 1) as f64,
    })
}
