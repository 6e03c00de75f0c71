//! Leapfrog time steps of the wave equation on a regular grid.
//!
//! Pressure at the cell centres and velocity at the faces, staggered in space and time, is the leapfrog of
//! \[PAN\] §4. Eliminating the velocities gives the same numbers from two arrays instead of four:
//!
//! ```text
//! p_new = 2p − p_old + λ² Δ_h p,     λ = c Δt/h
//! ```
//!
//! Differs: Δ_h is the isotropic 19-point Laplacian, 1/3 for the 6 cells across a face, 1/6 for the 12 across
//! an edge, −4 for the cell. A plane wave of any direction then obeys sin(ωΔt/2) = λ sin(kh/2) up to (kh)⁶,
//! so that reading the spectrum at that ω removes the dispersion. Cells near the body have separate rows
//! ([`Rows`](super::boundary::Rows)); a layer at the rim absorbs ([`super::absorber`]).

use pulp::{Simd, WithSimd};

use super::absorber::{Absorber, LAYER};
use super::boundary::Rows;
use super::lattice::{GROUND, Lattice, SQUARE};
use super::mirrors::fill_ghosts;
use super::row_blocks::{Block, update_row};
use crate::bem::triangles::lanes::Lanes;

/// Weight of an edge.
const SIXTH: f32 = 1.0 / 6.0;

/// The field of one motion.
#[derive(Clone, Debug)]
pub(super) struct WaveGrid<'a> {
    lattice: Lattice,
    rows: &'a Rows,
    drives: Vec<Drive>,
    pressure: Vec<f32>,
    /// One step earlier; becomes one step later.
    other: Vec<f32>,
    /// Weight of the edges at each cell of a row: none in the absorbing layers.
    weights: Vec<f32>,
    absorber: Absorber,
    near_body: Vec<f32>,
    arch: pulp::Arch,
    /// Signs of the images beyond the mirror planes.
    signs: [f32; 3],
}

/// Source terms of a motion of the body in each row.
#[derive(Clone, Debug, Default)]
pub(super) struct Drive {
    /// By its acceleration.
    pub(super) drive: Vec<f32>,
    /// By the second derivative of it.
    pub(super) bend: Vec<f32>,
}

impl Drive {
    /// One of the six rigid motions.
    pub(super) fn rigid(rows: &Rows, motion: usize) -> Self {
        Drive {
            drive: rows.drive.iter().map(|d| d[motion]).collect(),
            bend: rows.bend.iter().map(|b| b[motion]).collect(),
        }
    }
}

impl<'a> WaveGrid<'a> {
    /// Air at rest around a body that is driven in these motions, whose pressure has these signs under a
    /// reflection along each mirrored axis.
    pub(super) fn new(lattice: Lattice, rows: &'a Rows, drives: Vec<Drive>, signs: [f64; 3]) -> Self {
        WaveGrid {
            lattice,
            rows,
            drives,
            pressure: vec![GROUND; lattice.cells()],
            other: vec![GROUND; lattice.cells()],
            weights: edge_weights(lattice.size[0], lattice.mirrored[0]),
            absorber: Absorber::new(lattice),
            near_body: vec![0.0; rows.cells.len()],
            arch: pulp::Arch::new(),
            signs: signs.map(|sign| sign as f32),
        }
    }

    /// p at the cell centres.
    pub(super) fn pressure(&self) -> &[f32] {
        &self.pressure
    }

    /// Advances one time step, given for each motion the acceleration and its second derivative in units of
    /// (h/c)².
    pub(super) fn step(&mut self, motions: &[[f32; 2]]) {
        let WaveGrid { lattice, rows, drives, pressure, other, weights, absorber, near_body, arch, signs } =
            self;
        // Sources at the surface.
        near_body.fill(0.0);
        for (Drive { drive, bend }, [acceleration, bending]) in drives.iter().zip(motions) {
            if *acceleration != 0.0 || *bending != 0.0 {
                for ((new, d), b) in near_body.iter_mut().zip(drive).zip(bend) {
                    *new += d * acceleration + b * bending;
                }
            }
        }
        // Sparse rows of the cells near the body.
        let mut start = 0;
        for (row, new) in near_body.iter_mut().enumerate() {
            let cell = rows.cells[row] as usize;
            let end = rows.ends[row] as usize;
            let here = pressure[cell];
            let mut sum = 0.0;
            for (n, w) in rows.neighbours[start..end].iter().zip(&rows.weights[start..end]) {
                sum += w * (pressure[*n as usize] - here);
            }
            start = end;
            *new += 2.0 * here - other[cell] + sum;
        }
        // Regular stencil and absorbing layer everywhere.
        arch.dispatch(Sweep { lattice, p: pressure, new: other, weights, absorber });
        // Overwrite the cells near the body and inside it.
        for (cell, new) in rows.cells.iter().zip(near_body) {
            other[*cell as usize] = *new;
        }
        for cell in &rows.solid {
            other[*cell as usize] = GROUND;
        }
        fill_ghosts(lattice, other, *signs);
        std::mem::swap(pressure, other);
    }
}

/// The regular stencil and the absorbing layers of one time step, for the widest vectors of the machine.
///
/// A type instead of a closure: `pulp` calls a closure through a function of the standard library that is
/// compiled for the narrowest vectors, and the sweep with it.
struct Sweep<'a> {
    lattice: &'a Lattice,
    p: &'a [f32],
    new: &'a mut [f32],
    /// Weight of the edges at each cell of a row.
    weights: &'a [f32],
    absorber: &'a mut Absorber,
}

impl WithSimd for Sweep<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Sweep { lattice, p, new, weights, absorber } = self;
        let [nx, ny, nz] = lattice.size;
        let mirrored = lattice.mirrored;
        let plane = nx * ny;
        for k in 1..nz - 1 {
            for j in 1..ny - 1 {
                let at = k * plane + j * nx;
                let row = |from: usize| &p[from..from + nx];
                let new = &mut new[at..at + nx];
                let faces = [row(at - nx), row(at + nx), row(at - plane), row(at + plane)];
                let y = inner(j, ny, mirrored[1]).map(|cell| if cell { 1.0 } else { 0.0 });
                let z = inner(k, nz, mirrored[2]).map(|cell| if cell { 1.0 } else { 0.0 });
                if y[1] * z[1] == 0.0 {
                    advance_row(simd, new, row(at), faces);
                } else {
                    let edges = [
                        (row(at - plane - nx), y[0] * z[0]),
                        (row(at - plane + nx), y[2] * z[0]),
                        (row(at + plane - nx), y[0] * z[2]),
                        (row(at + plane + nx), y[2] * z[2]),
                    ];
                    let stencil =
                        Stencil { open: [y[0], y[2], z[0], z[2]], edges, weights, mirrored: mirrored[0] };
                    advance_inner_row(simd, new, row(at), faces, &stencil);
                }
                absorber.absorb_row(simd, lattice, p, new, [j, k]);
            }
        }
    }
}

/// Whether the cell before, the cell itself and the one after are outside of the absorbing layers.
#[inline(always)]
fn inner(cell: usize, n: usize, mirrored: bool) -> [bool; 3] {
    [cell - 1, cell, cell + 1].map(|c| (mirrored || c > LAYER) && c < n - 1 - LAYER)
}

/// Weight of the edges at each cell of a row of `n`: none in the absorbing layers.
fn edge_weights(n: usize, mirrored: bool) -> Vec<f32> {
    let is_inner = |cell: usize| (mirrored || cell > LAYER) && cell < n - 1 - LAYER;
    (0..n).map(|cell| if is_inner(cell) { SIXTH } else { 0.0 }).collect()
}

/// A row with its neighbours along x: the cells without the rim, those before and those after.
#[inline(always)]
fn shifted(row: &[f32]) -> [&[f32]; 3] {
    let n = row.len() - 2;
    [&row[..n], &row[1..][..n], &row[2..][..n]]
}

/// A row in the absorbing layers across y or z: the 7-point Laplacian. `faces` are the rows beside, in y and
/// in z.
#[inline(always)]
fn advance_row<S: Simd>(simd: S, new: &mut [f32], p: &[f32], [a, b, c, d]: [&[f32]; 4]) {
    let n = p.len() - 2;
    let [[_, a, _], [_, b, _], [_, c, _], [_, d, _]] = [shifted(a), shifted(b), shifted(c), shifted(d)];
    let [before, here, after] = shifted(p);
    update_row(
        simd,
        &mut new[1..][..n],
        #[inline(always)]
        |block, old| {
            let own = block.of(here);
            let across = block.of(a) + block.of(b) + block.of(c) + block.of(d);
            let sum = across + block.of(before) + block.of(after) - block.splat(6.0) * own;
            leap(block, old, own, sum)
        },
    );
}

/// Σ o (p_face − p) over the rows beside, `p` the last of the rows.
#[inline(always)]
fn sideways<S: Simd>(block: Block<S>, open: [f32; 4], [a, b, c, d, p]: [&[f32]; 5]) -> Lanes<S> {
    let [o0, o1, o2, o3] = open;
    let rows = block.splat(o0) * block.of(a) + block.splat(o1) * block.of(b);
    let rows = rows + block.splat(o2) * block.of(c) + block.splat(o3) * block.of(d);
    rows - block.splat(o0 + o1 + o2 + o3) * block.of(p)
}

/// The leapfrog: from the old pressure, p and the sum of the Laplacian to the new pressure.
#[inline(always)]
fn leap<S: Simd>(block: Block<S>, old: Lanes<S>, own: Lanes<S>, sum: Lanes<S>) -> Lanes<S> {
    block.splat(2.0) * own - old + block.splat(SQUARE) * sum
}

/// Rows across the edges along x, and which terms are outside of the absorbing layers.
struct Stencil<'a> {
    /// 1 for a row of the faces outside of the layers.
    open: [f32; 4],
    /// In the order −−, +−, −+, ++ of y and z, with the same mark.
    edges: [(&'a [f32], f32); 4],
    /// Weight of the edges at each cell.
    weights: &'a [f32],
    /// Whether the row begins at a mirror plane, without a layer.
    mirrored: bool,
}

/// A row outside of the absorbing layers across y and z: adds 1/6 Σ (p − p_a − p_b + p_ab) over the edges
/// that touch no layer, and nothing in the layers across x.
#[inline(always)]
fn advance_inner_row<S: Simd>(
    simd: S,
    new: &mut [f32],
    p: &[f32],
    [a, b, c, d]: [&[f32]; 4],
    stencil: &Stencil<'_>,
) {
    // Each row shifted by −1, 0 and +1.
    let ([a0, a1, a2], [b0, b1, b2]) = (shifted(a), shifted(b));
    let ([c0, c1, c2], [d0, d1, d2]) = (shifted(c), shifted(d));
    let [p0, p1, p2] = shifted(p);
    let Stencil { open, edges: [(e, m0), (f, m1), (g, m2), (h, m3)], weights, mirrored } = *stencil;
    let [[_, e, _], [_, f, _], [_, g, _], [_, h, _]] = [shifted(e), shifted(f), shifted(g), shifted(h)];
    let [_, weights, _] = shifted(weights);
    let n = p1.len();
    let new = &mut new[1..][..n];
    // 19-point Laplacian: edge terms along x, edge terms across x, face terms; then the leapfrog.
    update_row(
        simd,
        new,
        #[inline(always)]
        |block, old| {
            let before = sideways(block, open, [a0, b0, c0, d0, p0]);
            let beside = sideways(block, open, [a1, b1, c1, d1, p1]);
            let after = sideways(block, open, [a2, b2, c2, d2, p2]);
            let (own, a, b, c, d) = (block.of(p1), block.of(a1), block.of(b1), block.of(c1), block.of(d1));
            let (down, up) = (own - c, own - d);
            let around = block.splat(m0) * (down + block.of(e) - a)
                + block.splat(m1) * (down + block.of(f) - b)
                + block.splat(m2) * (up + block.of(g) - a)
                + block.splat(m3) * (up + block.of(h) - b);
            let across = a + b + c + d + block.of(p0) + block.of(p2) - block.splat(6.0) * own;
            let edges = before - block.splat(2.0) * beside + after + around;
            leap(block, old, own, across + block.of(weights) * edges)
        },
    );
    // Remove the edge terms between the first or last cell and the layer.
    let [o0, o1, o2, o3] = open;
    let side = |[a, b, c, d, p]: [f32; 5]| o0 * a + o1 * b + o2 * c + o3 * d - (o0 + o1 + o2 + o3) * p;
    let (first, last) = (LAYER, n - 1 - LAYER);
    if !mirrored {
        let outside = side([a0, b0, c0, d0, p0].map(|row| row[first]))
            - side([a1, b1, c1, d1, p1].map(|row| row[first]));
        new[first] -= SQUARE * SIXTH * outside;
    }
    let outside =
        side([a2, b2, c2, d2, p2].map(|row| row[last])) - side([a1, b1, c1, d1, p1].map(|row| row[last]));
    new[last] -= SQUARE * SIXTH * outside;
}
