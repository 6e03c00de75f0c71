//! Perfectly matched layer at the rim of the grid: absorbs outgoing waves.
//!
//! In the layer the coordinate across it is stretched by s(ω) = 1 + σ/(α + iω). Division by s is a
//! convolution with a decaying exponential, which one number per cell remembers (Roden and Gedney 2000; for
//! the second-order equation Pasalic and McGarry 2010):
//!
//! ```text
//! ψ ← b ψ + a ∂p,    ζ ← b ζ + a (∂²p + ∂ψ),    p'' = Δp + ∂ψ + ζ,    b = e^{−(σ+α)Δt},  a = σ/(σ+α) (b − 1)
//! ```
//!
//! Waves much slower than α see a real stretch by 1 + σ/α: a distant wall. The near field of a body at low
//! frequency does not propagate, and no layer absorbs it; it decays over the stretched distance. The memory
//! variables exist in the layers only.

use pulp::Simd;

use super::lattice::{COURANT, Lattice, SQUARE};
use super::row_blocks::{update_row, update_rows};

/// Thickness \[cells\].
pub(super) const LAYER: usize = 8;
/// Power of the depth with which σ grows.
const GRADING: f64 = 3.0;
/// σ h/c at the rim.
const STRONGEST: f64 = 0.8 * (GRADING + 1.0);
/// α h/c where the layer begins.
const SHIFT: f64 = 0.05;

/// Faces of a layer, from the last cell outside of it to the rim.
pub(super) const FACES: usize = LAYER + 1;

/// Coefficients and memory variables of the layers.
#[derive(Clone, Debug)]
pub(super) struct Absorber {
    /// Coefficients of the lower and upper layer.
    profiles: [Profile; 2],
    /// ψ and ζ of the layers along x: for each row and side a block of faces.
    x: [Vec<[f32; FACES]>; 2],
    /// ψ and ζ of the layers along y: rows, for each plane and face.
    y: [Vec<f32>; 2],
    /// ψ and ζ of the layers along z.
    z: [Vec<f32>; 2],
}

/// a and b at faces and at cells. Face f lies between cells f and f + 1 of the block; cells 1 … [`LAYER`] are
/// updated.
#[derive(Clone, Copy, Debug)]
struct Profile {
    face: [[f32; 2]; FACES],
    cell: [[f32; 2]; FACES],
}

impl Profile {
    /// `depth` of a point at a distance from cell 0 of the block, in layers.
    fn new(depth: impl Fn(f64) -> f64) -> Self {
        let at = |x: f64| {
            let d = depth(x);
            if d <= 0.0 {
                return [0.0, 1.0];
            }
            let sigma = STRONGEST * d.powf(GRADING) * COURANT;
            let alpha = SHIFT * (1.0 - d).max(0.0) * COURANT;
            let b = (-(sigma + alpha)).exp();
            [(sigma / (sigma + alpha) * (b - 1.0)) as f32, b as f32]
        };
        Profile {
            face: std::array::from_fn(|f| at(f as f64 + 0.5)),
            cell: std::array::from_fn(|c| at(c as f64)),
        }
    }
}

/// Of the lower and the upper layer.
fn profiles() -> [Profile; 2] {
    let layer = LAYER as f64;
    [Profile::new(|x| (layer - x) / layer), Profile::new(|x| (x - 1.0) / layer)]
}

impl Absorber {
    /// (a, b) at each face, then at each cell, of the lower and the upper layer.
    #[cfg(feature = "gpu")]
    pub(super) fn profiles() -> [[[f32; 4]; FACES]; 2] {
        profiles().map(|p| std::array::from_fn(|i| [p.face[i][0], p.face[i][1], p.cell[i][0], p.cell[i][1]]))
    }

    pub(super) fn new(lattice: Lattice) -> Self {
        let [nx, ny, nz] = lattice.size;
        Absorber {
            profiles: profiles(),
            x: std::array::from_fn(|_| vec![[0.0; FACES]; 2 * ny * nz]),
            y: std::array::from_fn(|_| vec![0.0; 2 * FACES * nx * nz]),
            z: std::array::from_fn(|_| vec![0.0; 2 * FACES * nx * ny]),
        }
    }

    /// Adds the terms of the layers to a row of new pressures; rows come in ascending order.
    #[inline(always)]
    pub(super) fn absorb_row<S: Simd>(
        &mut self,
        simd: S,
        lattice: &Lattice,
        p: &[f32],
        new: &mut [f32],
        [j, k]: [usize; 2],
    ) {
        let [nx, ny, nz] = lattice.size;
        let plane = nx * ny;
        let at = k * plane + j * nx;
        let row = &p[at..at + nx];
        let mirrored = lattice.mirrored;
        for (side, profile) in self.profiles.iter().enumerate().skip(usize::from(mirrored[0])) {
            let from = side * (nx - 1 - FACES);
            let block = 2 * (k * ny + j) + side;
            let cells = new[from..].first_chunk_mut::<FACES>();
            if let (Some(p), Some(new)) = (row[from..].first_chunk::<{ FACES + 1 }>(), cells) {
                let [psi, zeta] = &mut self.x;
                absorb_block(profile, p, new, &mut psi[block], &mut zeta[block]);
            }
        }
        // Between one face and the next lie a row (y) or a plane (z) of memories.
        if let Some((side, cell)) = layer_of(j, ny, mirrored[1]) {
            let first = ((2 * k + side) * FACES + cell) * nx;
            let rows = [&p[at - nx..at], row, &p[at + nx..at + 2 * nx]];
            let memories = Memories { psi_zeta: &mut self.y, first, stride: nx };
            absorb_across(simd, &self.profiles[side], cell, rows, new, memories);
        }
        if let Some((side, cell)) = layer_of(k, nz, mirrored[2]) {
            let first = ((side * FACES + cell) * ny + j) * nx;
            let rows = [&p[at - plane..at - plane + nx], row, &p[at + plane..at + plane + nx]];
            let memories = Memories { psi_zeta: &mut self.z, first, stride: plane };
            absorb_across(simd, &self.profiles[side], cell, rows, new, memories);
        }
    }
}

/// The layer that contains a cell of a line of `n`, and the cell's index in its block; none at a mirrored
/// beginning.
#[inline(always)]
fn layer_of(cell: usize, n: usize, mirrored: bool) -> Option<(usize, usize)> {
    let upper = n - 1 - FACES;
    if (1..=LAYER).contains(&cell) && !mirrored {
        Some((0, cell))
    } else if cell > upper && cell < n - 1 {
        Some((1, cell - upper))
    } else {
        None
    }
}

/// A layer that lies across x: `p` and `new` are the cells of its block.
#[inline(always)]
fn absorb_block(
    profile: &Profile,
    p: &[f32; FACES + 1],
    new: &mut [f32; FACES],
    psi: &mut [f32; FACES],
    zeta: &mut [f32; FACES],
) {
    let mut slope = [0.0; FACES];
    for f in 0..FACES {
        let [a, b] = profile.face[f];
        slope[f] = p[f + 1] - p[f];
        psi[f] = b * psi[f] + a * slope[f];
    }
    for c in 1..FACES {
        let [a, b] = profile.cell[c];
        let stretch = psi[c] - psi[c - 1];
        zeta[c] = b * zeta[c] + a * (slope[c] - slope[c - 1] + stretch);
        new[c] += SQUARE * (stretch + zeta[c]);
    }
}

/// ψ and ζ of a layer across y or z, and the position of one row in them.
struct Memories<'a> {
    psi_zeta: &'a mut [Vec<f32>; 2],
    /// Index of the row's first number.
    first: usize,
    /// Difference of the indices of one face and the next.
    stride: usize,
}

/// A layer across y or z: a whole row of cells `cell` deep in the block, and the rows before and after it.
#[inline(always)]
fn absorb_across<S: Simd>(
    simd: S,
    profile: &Profile,
    cell: usize,
    [below, here, above]: [&[f32]; 3],
    new: &mut [f32],
    Memories { psi_zeta: [psi, zeta], first, stride }: Memories<'_>,
) {
    // Without the rim at both ends.
    let n = here.len() - 2;
    let (before, after) = psi.split_at_mut(first);
    let lower = &mut before[first - stride + 1..][..n];
    let upper = &mut after[1..][..n];
    let zeta = &mut zeta[first + 1..][..n];
    let [below, here, above] = [below, here, above].map(|row| &row[1..][..n]);
    let new = &mut new[1..][..n];
    if cell == 1 {
        // The face below has not been updated by an earlier row.
        let [a, b] = profile.face[0];
        update_row(
            simd,
            lower,
            #[inline(always)]
            |block, psi| block.splat(b) * psi + block.splat(a) * (block.of(here) - block.of(below)),
        );
    }
    let ([a, b], [a_cell, b_cell]) = (profile.face[cell], profile.cell[cell]);
    let lower = &*lower;
    update_rows(
        simd,
        [upper, zeta, new],
        #[inline(always)]
        |block, [psi, zeta, new]| {
            let own = block.of(here);
            let (down, up) = (own - block.of(below), block.of(above) - own);
            let psi = block.splat(b) * psi + block.splat(a) * up;
            let stretch = psi - block.of(lower);
            let zeta = block.splat(b_cell) * zeta + block.splat(a_cell) * (up - down + stretch);
            [psi, zeta, new + block.splat(SQUARE) * (stretch + zeta)]
        },
    );
}
