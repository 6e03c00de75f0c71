//! Integrals over the part of a body inside each cell, exact, from the triangles of its surface.
//!
//! For a function f in a cell from z₀ to z₁, with F(x, y, z) = ∫_{z₀}^{min(z, z₁)} f dz and F = 0 below z₀,
//!
//! ```text
//! ∫_{body ∩ cell} f dV = ∮_{surface in the column of the cell} F n_z dA
//! ```
//!
//! by Gauss's theorem, as nothing of the surface is left out. Only triangles are clipped, against planes of
//! the grid; the faces of the cells do not matter. Above the cell, F does not depend on z: one
//! two-dimensional moment of each cell, summed down the column, closes it. With Legendre polynomials for f,
//! of degree 2p along each axis, the moments become weights on the Gauss points of the cube that integrate
//! products of two displacements exactly. Weights may be negative.

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;
use pulp::{Simd, WithSimd};
use rayon::prelude::*;

use super::basis::Basis;
use super::chain::{Cap, Chain, Origin};
use super::division::Divided;
use super::grid::CellGrid;
use super::polygon::Polygon;
use crate::quadrature::gauss_legendre;

/// Points per direction for a vanishing triangle: the polynomials of a small one vary little, but their high
/// degrees must not alias.
const FEWEST_POINTS: f64 = 4.5;
/// The same in a section: a tie is far stiffer than the rest of a cell, and must not become negative.
const FEWEST_SECTION_POINTS: f64 = 7.5;

/// Legendre moments of a body in one cell, in coordinates from −1 to 1.
#[derive(Clone)]
pub(super) struct CellMoments {
    /// Place of the cell in the grid.
    pub(super) place: [usize; 3],
    /// Sum of the area vectors of the surface in the cell, in units of its faces.
    pub(super) surface: DVec3,
    /// Moments along an axis: 2p + 1.
    count: usize,
    /// ∫ P_a(x) P_b(y) P_c(z), by c, a, b; empty of a cell that is not wanted.
    moments: Vec<f64>,
}

/// A piece of a triangle in one cell, in units of cells from the corner of the cell.
struct Piece {
    place: [usize; 3],
    corners: [DVec3; 3],
    /// Twice the measure dA of the integral: n_z dA for volumes.
    measure: f64,
}

impl Piece {
    fn upwards(place: [usize; 3], corners: [DVec3; 3]) -> Self {
        let [ab, ac] = [corners[1] - corners[0], corners[2] - corners[0]];
        Piece { place, corners, measure: ab.x * ac.y - ab.y * ac.x }
    }
}

/// The moments of all cells that hold a part of the body, ascending by place; only the surface in those that
/// are not `wanted`.
pub(super) fn cell_moments(
    surface: &TriMesh,
    grid: &CellGrid,
    basis: &Basis,
    wanted: impl Fn([usize; 3]) -> bool + Sync,
) -> Vec<CellMoments> {
    let count = basis.points().len();
    let rules = rules(basis);
    // Cells in parallel; the pieces of each in a fixed order.
    let pieces = pieces(surface, grid);
    let touched = |own: &[Piece]| {
        let mut touched = Touched::new(own, &rules, count);
        if !wanted(touched.place) {
            touched.moments = Vec::new();
        }
        touched
    };
    let touched: Vec<Touched> = pieces.par_chunk_by(|a, b| a.place == b.place).map(touched).collect();
    let column = |cell: &Touched| [cell.place[0], cell.place[1]];
    touched
        .chunk_by(|a, b| column(a) == column(b))
        .flat_map(|column| closed(column, count, &wanted))
        .collect()
}

/// Gauss rules by their number of points, up to that for a triangle as large as the cell.
pub(super) fn rules(basis: &Basis) -> Vec<Vec<(f64, f64)>> {
    (0..=3 * basis.degree() + 2).map(gauss_legendre).collect()
}

/// The moments of a part of a cell, from its closed chain.
pub(super) fn part_moments(
    place: [usize; 3],
    chain: &Chain,
    rules: &[Vec<(f64, f64)>],
    count: usize,
) -> CellMoments {
    // Vertical faces, and the bottom of the cell, add nothing.
    let counts = |cap: &&Cap| matches!(cap.origin, Origin::Face(5) | Origin::Division(_));
    let caps = chain.caps.iter().filter(counts).flat_map(Cap::cones);
    let all = chain.triangles.iter().copied().chain(caps);
    let pieces: Vec<Piece> = all.map(|corners| Piece::upwards(place, corners)).collect();
    let mut moments = vec![0.0; count.pow(3)];
    let column = &mut vec![0.0; count * count];
    let sums = Sums { pieces: &pieces, rules, count, section: false, moments: &mut moments, column };
    pulp::Arch::new().dispatch(sums);
    CellMoments { place, surface: DVec3::ZERO, count, moments }
}

/// The moments of a section through a cell: ∫ P_a(x) P_b(y) P_c(z) dA over triangles of signed area.
pub(super) fn section_moments<'a>(
    place: [usize; 3],
    section: impl Iterator<Item = &'a Divided>,
    rules: &[Vec<(f64, f64)>],
    count: usize,
) -> CellMoments {
    let pieces: Vec<Piece> = section.map(|t| Piece { place, corners: t.corners, measure: t.area }).collect();
    let mut moments = vec![0.0; count.pow(3)];
    let column = &mut vec![0.0; count * count];
    let sums = Sums { pieces: &pieces, rules, count, section: true, moments: &mut moments, column };
    pulp::Arch::new().dispatch(sums);
    CellMoments { place, surface: DVec3::ZERO, count, moments }
}

/// Sums over the surface in one cell.
struct Touched {
    place: [usize; 3],
    surface: DVec3,
    /// ∮ P_a P_b ∫P_c n_z dA, by c, a, b.
    moments: Vec<f64>,
    /// The same as seen from the cells below.
    above: Vec<f64>,
}

impl Touched {
    fn new(pieces: &[Piece], rules: &[Vec<(f64, f64)>], count: usize) -> Self {
        let (mut moments, mut above) = (vec![0.0; count.pow(3)], vec![0.0; count * count]);
        let sums = Sums { pieces, rules, count, section: false, moments: &mut moments, column: &mut above };
        pulp::Arch::new().dispatch(sums);
        let area_vector = |[a, b, c]: [DVec3; 3]| 0.5 * (b - a).cross(c - a);
        let surface = pieces.iter().map(|piece| area_vector(piece.corners)).sum();
        Touched { place: pieces[0].place, surface, moments, above }
    }
}

/// The cells of a column: the surface above each closes it.
fn closed(column: &[Touched], count: usize, wanted: impl Fn([usize; 3]) -> bool) -> Vec<CellMoments> {
    let (first, last) = (&column[0], &column[column.len() - 1]);
    let mut above = vec![0.0; count * count];
    let mut cells = Vec::new();
    let mut rest = column.iter().rev().peekable();
    for level in (first.place[2]..=last.place[2]).rev() {
        let place = [first.place[0], first.place[1], level];
        let own = rest.next_if(|cell| cell.place == place);
        let mut moments = match own {
            _ if !wanted(place) => Vec::new(),
            Some(own) => own.moments.clone(),
            None => vec![0.0; count.pow(3)],
        };
        moments.iter_mut().zip(&above).for_each(|(moment, above)| *moment += above);
        if let Some(own) = own {
            above.iter_mut().zip(&own.above).for_each(|(sum, own)| *sum += own);
        }
        let surface = own.map_or(DVec3::ZERO, |own| own.surface);
        cells.push(CellMoments { place, surface, count, moments });
    }
    cells.reverse();
    cells
}

impl CellMoments {
    /// Filled part of a cell.
    pub(super) fn filled(&self) -> f64 {
        self.moments[0] / 8.0
    }

    /// Area of a section, in that of a face of the cell.
    pub(super) fn section_area(&self) -> f64 {
        self.moments[0] / 4.0
    }

    /// Adds another part of the same cell.
    pub(super) fn add(&mut self, other: &CellMoments) {
        self.moments.iter_mut().zip(&other.moments).for_each(|(sum, other)| *sum += other);
    }

    /// Weights on the Gauss points of a unit cube, by x, y, z.
    pub(super) fn weights(&self, basis: &Basis) -> Vec<f64> {
        let n = self.count;
        let table = basis.legendre_to_points();
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
        let by_zxy = transform(&transform(&transform(&self.moments)));
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
                    let corners = part.corners();
                    for q in 1..corners.len().max(2) - 1 {
                        let corners = [corners[0], corners[q], corners[q + 1]].map(|x| x - corner);
                        pieces.push(Piece::upwards([i, j, k], corners));
                    }
                }
            }
        }
    }
    pieces.sort_by_key(|piece| piece.place);
    pieces
}

/// Sums of the pieces of one cell.
struct Sums<'a> {
    pieces: &'a [Piece],
    /// Gauss rules by their number of points.
    rules: &'a [Vec<(f64, f64)>],
    count: usize,
    /// Whether functions of z are P_c, not ∫P_c.
    section: bool,
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
            5 => self.sum::<5, 25>(),
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
        const { assert!(PLANE == N * N) }
        let full = self.rules.len() - 1;
        let moments = self.moments.as_chunks_mut::<PLANE>().0;
        let column = &mut self.column.as_chunks_mut::<PLANE>().0[0];
        for Piece { corners: [a, b, c], measure: area, .. } in self.pieces {
            let (ab, ac) = (*b - *a, *c - *a);
            if *area == 0.0 {
                continue;
            }
            let extent =
                ab.abs().max_element().max(ac.abs().max_element()).max((*c - *b).abs().max_element());
            let fewest = if self.section { FEWEST_SECTION_POINTS } else { FEWEST_POINTS };
            let points = full.min((fewest + full as f64 * extent.sqrt()) as usize);
            // Points of a collapsed square.
            for (u, wu) in &self.rules[points] {
                for (v, wv) in &self.rules[points] {
                    let at = *a + *u * ab + v * (1.0 - u) * ac;
                    // The cell has edge 2 in the coordinates of the polynomials.
                    let weight = 4.0 * wu * wv * (1.0 - u) * area;
                    let x = legendre::<N>(2.0 * at.x - 1.0);
                    let y = legendre::<N>(2.0 * at.y - 1.0);
                    let z = 2.0 * at.z - 1.0;
                    let z = if self.section { legendre::<N>(z) } else { integrated::<N>(z) };
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
