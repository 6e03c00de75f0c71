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

use std::ops::Range;

use super::absorber::{Absorber, LAYER};
use super::boundary::Rows;
use super::lattice::{GROUND, Lattice, SQUARE};

/// The field of one motion.
#[derive(Clone, Debug)]
pub(super) struct WaveGrid<'a> {
    lattice: Lattice,
    rows: &'a Rows,
    drives: Vec<Drive>,
    pressure: Vec<f32>,
    /// One step earlier; becomes one step later.
    other: Vec<f32>,
    absorber: Absorber,
    near_body: Vec<f32>,
    arch: pulp::Arch,
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
    /// Air at rest around a body that is driven in these motions.
    pub(super) fn new(lattice: Lattice, rows: &'a Rows, drives: Vec<Drive>) -> Self {
        WaveGrid {
            lattice,
            rows,
            drives,
            pressure: vec![GROUND; lattice.cells()],
            other: vec![GROUND; lattice.cells()],
            absorber: Absorber::new(lattice),
            near_body: vec![0.0; rows.cells.len()],
            arch: pulp::Arch::new(),
        }
    }

    /// p at the cell centres.
    pub(super) fn pressure(&self) -> &[f32] {
        &self.pressure
    }

    /// Advances one time step, given for each motion the acceleration and its second derivative in units of
    /// (h/c)².
    pub(super) fn step(&mut self, motions: &[[f32; 2]]) {
        let WaveGrid { lattice, rows, drives, pressure, other, absorber, near_body, arch } = self;
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
        arch.dispatch(
            #[inline(always)]
            || sweep(lattice, pressure, other, absorber),
        );
        // Overwrite the cells near the body and inside it.
        for (cell, new) in rows.cells.iter().zip(near_body) {
            other[*cell as usize] = *new;
        }
        for cell in &rows.solid {
            other[*cell as usize] = GROUND;
        }
        std::mem::swap(pressure, other);
    }
}

#[inline(always)]
fn sweep(lattice: &Lattice, p: &[f32], new: &mut [f32], absorber: &mut Absorber) {
    let [nx, ny, nz] = lattice.0;
    let plane = nx * ny;
    for k in 1..nz - 1 {
        for j in 1..ny - 1 {
            let at = k * plane + j * nx;
            let row = |from: usize| &p[from..from + nx];
            let new = &mut new[at..at + nx];
            let faces = [row(at - nx), row(at + nx), row(at - plane), row(at + plane)];
            let y = inner(j, ny).map(|cell| if cell { 1.0 } else { 0.0 });
            let z = inner(k, nz).map(|cell| if cell { 1.0 } else { 0.0 });
            if y[1] * z[1] == 0.0 {
                advance_row(new, row(at), faces, 1..nx - 1);
            } else {
                let edges = [
                    (row(at - plane - nx), y[0] * z[0]),
                    (row(at - plane + nx), y[2] * z[0]),
                    (row(at + plane - nx), y[0] * z[2]),
                    (row(at + plane + nx), y[2] * z[2]),
                ];
                advance_row(new, row(at), faces, 1..LAYER + 1);
                advance_inner_row(new, row(at), faces, [y[0], y[2], z[0], z[2]], edges);
                advance_row(new, row(at), faces, nx - 1 - LAYER..nx - 1);
            }
            absorber.absorb_row(lattice, p, new, j, k);
        }
    }
}

/// Whether the cell before, the cell itself and the one after are outside of the absorbing layers.
#[inline(always)]
fn inner(cell: usize, n: usize) -> [bool; 3] {
    [cell - 1, cell, cell + 1].map(|c| c > LAYER && c < n - 1 - LAYER)
}

/// Cells of a row in the absorbing layer: the 7-point Laplacian. `faces` are the rows beside, in y and in z.
#[inline(always)]
fn advance_row(new: &mut [f32], p: &[f32], faces: [&[f32]; 4], cells: Range<usize>) {
    let Range { start, end } = cells;
    let n = end - start;
    let [a, b, c, d] = faces.map(|r| &r[start..][..n]);
    let (before, here, after) = (&p[start - 1..][..n], &p[start..][..n], &p[start + 1..][..n]);
    let new = &mut new[start..][..n];
    for i in 0..n {
        let sum = a[i] + b[i] + c[i] + d[i] + before[i] + after[i] - 6.0 * here[i];
        new[i] = 2.0 * here[i] - new[i] + SQUARE * sum;
    }
}

/// Cells of a row outside of the absorbing layers: adds 1/6 Σ (p − p_a − p_b + p_ab) over the edges that
/// touch no layer. `open` is 1 for a row of `faces` outside of the layers; `edges` are the rows across an
/// edge along x, in the order −−, +−, −+, ++ of y and z, with the same mark.
#[inline(always)]
fn advance_inner_row<'a>(
    new: &mut [f32],
    p: &'a [f32],
    faces: [&'a [f32]; 4],
    open: [f32; 4],
    edges: [(&'a [f32], f32); 4],
) {
    const SIXTH: f32 = 1.0 / 6.0;
    let start = LAYER + 1;
    let end = p.len() - start;
    let n = end - start;
    // Each row shifted by −1, 0 and +1: slices of equal length, which vectorise.
    let windows = |r: &'a [f32]| [&r[start - 1..][..n], &r[start..][..n], &r[start + 1..][..n]];
    let [[a0, a1, a2], [b0, b1, b2], [c0, c1, c2], [d0, d1, d2]] = faces.map(windows);
    let [p0, p1, p2] = windows(p);
    let [e, f, g, h] = edges.map(|(r, _)| &r[start..][..n]);
    let [o0, o1, o2, o3] = open;
    let [m0, m1, m2, m3] = edges.map(|e| e.1);
    let all = o0 + o1 + o2 + o3;
    let new = &mut new[start..][..n];
    // 19-point Laplacian: edge terms along x, edge terms across x, face terms; then the leapfrog.
    for i in 0..n {
        let before = o0 * a0[i] + o1 * b0[i] + o2 * c0[i] + o3 * d0[i] - all * p0[i];
        let beside = o0 * a1[i] + o1 * b1[i] + o2 * c1[i] + o3 * d1[i] - all * p1[i];
        let after = o0 * a2[i] + o1 * b2[i] + o2 * c2[i] + o3 * d2[i] - all * p2[i];
        let (down, up) = (p1[i] - c1[i], p1[i] - d1[i]);
        let around = m0 * (down + e[i] - a1[i])
            + m1 * (down + f[i] - b1[i])
            + m2 * (up + g[i] - a1[i])
            + m3 * (up + h[i] - b1[i]);
        let across = a1[i] + b1[i] + c1[i] + d1[i] + p0[i] + p2[i] - 6.0 * p1[i];
        let sum = across + SIXTH * (before - 2.0 * beside + after + around);
        new[i] = 2.0 * p1[i] - new[i] + SQUARE * sum;
    }
    // Remove the edge terms between the first or last cell and the layer.
    let sideways = |[a, b, c, d, p]: [f32; 5]| o0 * a + o1 * b + o2 * c + o3 * d - all * p;
    let last = n - 1;
    let outside =
        sideways([a0[0], b0[0], c0[0], d0[0], p0[0]]) - sideways([a1[0], b1[0], c1[0], d1[0], p1[0]]);
    new[0] -= SQUARE * SIXTH * outside;
    let outside = sideways([a2[last], b2[last], c2[last], d2[last], p2[last]])
        - sideways([a1[last], b1[last], c1[last], d1[last], p1[last]]);
    new[last] -= SQUARE * SIXTH * outside;
}
