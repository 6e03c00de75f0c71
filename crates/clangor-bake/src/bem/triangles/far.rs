//! The part of the system that couples triangles at a distance: three points on each, in single precision.
//!
//! Each unordered pair is integrated once and serves both ways: the first triangle testing the second's field
//! (entry ij) and the reverse (ji) share distance, phase and G. Source triangles run in vector lanes. Sums
//! over the triangles of a block of test functions are kept in cache, lane by lane, so that an entry of the
//! big matrices is touched once per block and vertex instead of once per pair of triangles.
//!
//! ```text
//! A_ij = −⟨φ_i, K φ_j⟩ + γ (⟨curl φ_i, G curl φ_j⟩ − k² ⟨φ_i n, G φ_j n⟩),   b_i = ⟨φ_i, S a + γ K' a⟩,   γ = −iγ'
//! ```

use std::f32::consts::{PI, TAU};

use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;
use num_complex::{Complex32, Complex64};
use pulp::{Simd, WithSimd};

use super::lanes::Lanes;
use super::pair_integrals::parity;
use super::pair_rules::THREE_POINTS;
use super::panels::Panels;

/// Source triangles per group: the most lanes of any register.
const GROUP: usize = 16;

/// Test triangles per block: their sums for one group fit in the first cache.
const BLOCK: usize = 64;

// Fields of a source triangle.
const POINT: usize = 0;
const NORMAL: usize = 9;
const AREA: usize = 12;
const CURL: usize = 13;
const TURNING: usize = 22;
const FIELDS: usize = 31;

/// Sums of one test function and one group: both ways, three source functions, real and imaginary part.
const SUMS: usize = 12;

/// Real and imaginary parts of the loads of one test function.
const LOADS: usize = 2 * RIGID_DOFS;

/// The unknowns of one parity class and the matrix of its system.
#[derive(Debug)]
pub(super) struct ClassMatrix<'a> {
    /// Unknown of each vertex, `u32::MAX` without.
    pub(super) unknowns: &'a [u32],
    /// Sign of each image.
    pub(super) signs: &'a [f64],
    /// Column by column.
    pub(super) matrix: Vec<Complex32>,
    pub(super) size: usize,
}

/// Geometry of the far pairs, the same at all wavenumbers.
#[derive(Clone, Debug)]
pub(super) struct FarSystem {
    blocks: Vec<Block>,
    images: Vec<FarImage>,
    tests: Vec<Test>,
    triangles: Vec<[u32; 3]>,
    /// Vertices of each group of sources.
    corners: Vec<Vec<Corners>>,
}

/// The corners of a group of sources that are one vertex.
#[derive(Clone, Debug)]
struct Corners {
    vertex: u32,
    /// Where their real parts are among the sums of a test vertex, one way.
    places: Vec<u16>,
}

/// Consecutive test triangles, and the vertices they use.
#[derive(Clone, Debug)]
struct Block {
    first: usize,
    vertices: Vec<u32>,
    local: Vec<[usize; 3]>,
}

/// A test triangle.
#[derive(Clone, Copy, Debug)]
struct Test {
    points: [[f32; 3]; 3],
    normal: [f32; 3],
    area: f32,
    curls: [[f32; 3]; 3],
    /// x × n at the points.
    turning: [[f32; 3]; 3],
}

/// The sources, or a mirror image of them.
#[derive(Clone, Debug)]
struct FarImage {
    /// Groups × FIELDS × GROUP.
    sources: Vec<f32>,
    /// Whether lanes of a group are not for a test triangle: near it, before it, or past the end; test ×
    /// groups.
    skip: Vec<u16>,
    /// Whether a triangle meets its own image here; such a pair counts half each way.
    own: bool,
    parities: [f32; RIGID_DOFS],
}

impl FarSystem {
    /// `near` holds for each image the pairs (t, s), t ≤ s, that are integrated elsewhere.
    pub(super) fn new<'a>(
        panels: &Panels,
        images: &[DVec3],
        near: impl Iterator<Item = &'a [(u32, u32)]>,
    ) -> Self {
        let count = panels.triangles.len();
        let tests = (0..count)
            .map(|t| Test {
                points: points(panels, t),
                normal: single(panels.normals[t]),
                area: panels.areas[t] as f32,
                curls: panels.curls[t].map(single),
                turning: turning(panels, t),
            })
            .collect();
        let blocks = (0..count).step_by(BLOCK).map(|first| Block::new(panels, first)).collect();
        let images =
            images.iter().zip(near).map(|(signs, near)| FarImage::new(panels, *signs, near)).collect();
        let corners = panels.triangles.chunks(GROUP).map(corners).collect();
        Self { blocks, images, tests, triangles: panels.triangles.clone(), corners }
    }

    /// Adds the far pairs at wavenumber `k` [1/R], γ = −i`coupling`, to the matrices and to the loads of all
    /// vertices.
    pub(super) fn assemble(
        &self,
        k: f64,
        coupling: f64,
        classes: &mut [ClassMatrix<'_>],
        loads: &mut [[Complex64; RIGID_DOFS]],
    ) {
        let (k, coupling) = (k as f32, coupling as f32);
        pulp::Arch::new().dispatch(Assembly::<true> { system: self, k, coupling, classes, loads });
    }

    /// Adds the far pairs to the matrices alone.
    pub(super) fn assemble_matrices(&self, k: f64, coupling: f64, classes: &mut [ClassMatrix<'_>]) {
        let (k, coupling) = (k as f32, coupling as f32);
        pulp::Arch::new().dispatch(Assembly::<false> { system: self, k, coupling, classes, loads: &mut [] });
    }
}

impl Block {
    fn new(panels: &Panels, first: usize) -> Self {
        let end = (first + BLOCK).min(panels.triangles.len());
        let mut vertices: Vec<u32> = panels.triangles[first..end].iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        let local = panels.triangles[first..end]
            .iter()
            .map(|t| t.map(|v| vertices.partition_point(|u| *u < v)))
            .collect();
        Self { first, vertices, local }
    }
}

impl FarImage {
    fn new(panels: &Panels, signs: DVec3, near: &[(u32, u32)]) -> Self {
        let image = panels.image(signs);
        let own = signs != DVec3::ONE;
        let count = panels.triangles.len();
        let groups = count.div_ceil(GROUP);
        let mut sources = vec![0.0; groups * FIELDS * GROUP];
        for s in 0..groups * GROUP {
            let mut set = |field: usize, value: f32| {
                sources[(s / GROUP * FIELDS + field) * GROUP + s % GROUP] = value;
            };
            if s >= count {
                // Somewhere, without area.
                (0..9).for_each(|c| set(POINT + c, 3.0));
                continue;
            }
            for (p, (point, turning)) in points(&image, s).iter().zip(turning(&image, s)).enumerate() {
                for c in 0..3 {
                    set(POINT + 3 * p + c, point[c]);
                    set(TURNING + 3 * p + c, turning[c]);
                    set(CURL + 3 * p + c, single(image.curls[s][p])[c]);
                }
            }
            for c in 0..3 {
                set(NORMAL + c, single(image.normals[s])[c]);
            }
            set(AREA, image.areas[s] as f32);
        }
        let mut skip = vec![0_u16; count * groups];
        let mut mark = |t: usize, s: usize| skip[t * groups + s / GROUP] |= 1 << (s % GROUP);
        for t in 0..count {
            // Earlier triangles have had this pair; lanes past the end are no triangles.
            let from = t / GROUP * GROUP;
            (from..t + usize::from(!own)).for_each(|s| mark(t, s));
            (count..groups * GROUP).for_each(|s| mark(t, s));
        }
        near.iter().for_each(|&(t, s)| mark(t as usize, s as usize));
        let parities = std::array::from_fn(|d| parity(signs, d) as f32);
        Self { sources, skip, own, parities }
    }
}

/// The vertices of a group.
fn corners(group: &[[u32; 3]]) -> Vec<Corners> {
    let mut all: Vec<(u32, u16)> = Vec::new();
    for (lane, triangle) in group.iter().enumerate() {
        all.extend(triangle.iter().enumerate().map(|(j, v)| (*v, (2 * j * GROUP + lane) as u16)));
    }
    all.sort_unstable();
    all.chunk_by(|a, b| a.0 == b.0)
        .map(|same| Corners { vertex: same[0].0, places: same.iter().map(|(_, place)| *place).collect() })
        .collect()
}

fn single(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

fn points(panels: &Panels, t: usize) -> [[f32; 3]; 3] {
    THREE_POINTS.map(|(shares, _)| single(panels.point(t, shares)))
}

fn turning(panels: &Panels, t: usize) -> [[f32; 3]; 3] {
    THREE_POINTS.map(|(shares, _)| single(panels.point(t, shares).cross(panels.normals[t])))
}

/// `WITH_LOADS`: with those of the six motions, or without.
struct Assembly<'a, 'b, const WITH_LOADS: bool> {
    system: &'a FarSystem,
    k: f32,
    coupling: f32,
    classes: &'a mut [ClassMatrix<'b>],
    loads: &'a mut [[Complex64; RIGID_DOFS]],
}

impl<const WITH_LOADS: bool> WithSimd for Assembly<'_, '_, WITH_LOADS> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { system, k, coupling, classes, loads } = self;
        let parts = GROUP / S::F32_LANES;
        let mut sums = Vec::new();
        let mut forward_loads = Vec::new();
        let mut backward_loads = vec![0.0_f32; 3 * LOADS * GROUP];
        for (g, image) in system.images.iter().enumerate() {
            let (sources, _) = S::as_simd_f32s(&image.sources);
            let groups = sources.len() / (FIELDS * parts);
            for block in &system.blocks {
                forward_loads.clear();
                forward_loads.resize(block.vertices.len() * LOADS * GROUP, 0.0_f32);
                for group in block.first / GROUP..groups {
                    sums.clear();
                    sums.resize(block.vertices.len() * SUMS * GROUP, 0.0_f32);
                    backward_loads.fill(0.0);
                    let mut touched = false;
                    for (i, local) in block.local.iter().enumerate() {
                        let t = block.first + i;
                        if group < t / GROUP {
                            continue;
                        }
                        let skip = image.skip[t * groups + group];
                        if skip == u16::MAX {
                            continue;
                        }
                        touched = true;
                        let own = (image.own && group == t / GROUP).then_some(t % GROUP);
                        let (sums, _) = S::as_mut_simd_f32s(&mut sums);
                        let (forward, _) = S::as_mut_simd_f32s(&mut forward_loads);
                        let (backward, _) = S::as_mut_simd_f32s(&mut backward_loads);
                        for part in 0..parts {
                            let pair = PairLanes {
                                simd,
                                k: Lanes::splat(simd, k),
                                coupling: Lanes::splat(simd, coupling),
                                test: &system.tests[t],
                                sources: &sources[group * FIELDS * parts..][..FIELDS * parts],
                                part,
                                parts,
                            };
                            pair.add::<WITH_LOADS>(skip, own, local, sums, [forward, backward]);
                        }
                    }
                    if touched {
                        for class in classes.iter_mut() {
                            class.add(g, block, &system.corners[group], &sums);
                        }
                        if WITH_LOADS {
                            let sources = &system.triangles[group * GROUP..];
                            add_backward(loads, sources, &backward_loads, &image.parities);
                        }
                    }
                }
                if !WITH_LOADS {
                    continue;
                }
                for (vertex, values) in block.vertices.iter().zip(forward_loads.chunks_exact(LOADS * GROUP)) {
                    let mut values =
                        values.chunks_exact(GROUP).map(|lanes| lanes.iter().copied().map(f64::from).sum());
                    for load in &mut loads[*vertex as usize] {
                        *load += Complex64::new(values.next().unwrap_or(0.0), values.next().unwrap_or(0.0));
                    }
                }
            }
        }
    }
}

/// Loads of the sources as test functions.
fn add_backward(
    loads: &mut [[Complex64; RIGID_DOFS]],
    sources: &[[u32; 3]],
    values: &[f32],
    parities: &[f32; RIGID_DOFS],
) {
    for (lane, triangle) in sources.iter().take(GROUP).enumerate() {
        for (j, vertex) in triangle.iter().enumerate() {
            for (d, load) in loads[*vertex as usize].iter_mut().enumerate() {
                let at = (j * RIGID_DOFS + d) * 2 * GROUP + lane;
                let value = Complex32::new(values[at], values[at + GROUP]).scale(parities[d]);
                *load += Complex64::new(f64::from(value.re), f64::from(value.im));
            }
        }
    }
}

impl ClassMatrix<'_> {
    /// Adds the coupling of a test vertex with an image of a source vertex.
    pub(super) fn add_entry(&mut self, image: usize, row: u32, column: u32, value: Complex64) {
        let (row, column) = (self.unknowns[row as usize] as usize, self.unknowns[column as usize] as usize);
        if row < self.size && column < self.size {
            let value = value * self.signs[image];
            self.matrix[column * self.size + row] += Complex32::new(value.re as f32, value.im as f32);
        }
    }

    /// Adds the sums of a block of tests against a group of sources.
    #[inline(always)]
    fn add(&mut self, image: usize, block: &Block, sources: &[Corners], sums: &[f32]) {
        let sign = self.signs[image] as f32;
        let n = self.size;
        let total = |sums: &[f32], corners: &Corners| {
            let (mut re, mut im) = (0.0, 0.0);
            for at in &corners.places {
                re += sums[*at as usize];
                im += sums[*at as usize + GROUP];
            }
            Complex32::new(sign * re, sign * im)
        };
        for corners in sources {
            let column = self.unknowns[corners.vertex as usize] as usize;
            if column >= n {
                continue;
            }
            let column = &mut self.matrix[column * n..][..n];
            for (vertex, sums) in block.vertices.iter().zip(sums.chunks_exact(SUMS * GROUP)) {
                if let Some(entry) = column.get_mut(self.unknowns[*vertex as usize] as usize) {
                    *entry += total(&sums[..SUMS / 2 * GROUP], corners);
                }
            }
        }
        for (vertex, sums) in block.vertices.iter().zip(sums.chunks_exact(SUMS * GROUP)) {
            let column = self.unknowns[*vertex as usize] as usize;
            if column >= n {
                continue;
            }
            let column = &mut self.matrix[column * n..][..n];
            for corners in sources {
                if let Some(entry) = column.get_mut(self.unknowns[corners.vertex as usize] as usize) {
                    *entry += total(&sums[SUMS / 2 * GROUP..], corners);
                }
            }
        }
    }
}

/// One test triangle against the sources in one register.
struct PairLanes<'a, S: Simd> {
    simd: S,
    k: Lanes<S>,
    coupling: Lanes<S>,
    test: &'a Test,
    sources: &'a [S::f32s],
    part: usize,
    parts: usize,
}

/// A complex number per lane.
type Complexes<S> = [Lanes<S>; 2];

impl<S: Simd> PairLanes<'_, S> {
    #[inline(always)]
    fn splat(&self, value: f32) -> Lanes<S> {
        Lanes::splat(self.simd, value)
    }

    #[inline(always)]
    fn field(&self, field: usize) -> Lanes<S> {
        Lanes::of(self.simd, self.sources[field * self.parts + self.part])
    }

    #[inline(always)]
    fn vector(&self, field: usize) -> [Lanes<S>; 3] {
        [self.field(field), self.field(field + 1), self.field(field + 2)]
    }

    #[inline(always)]
    fn splats(&self, v: [f32; 3]) -> [Lanes<S>; 3] {
        [self.splat(v[0]), self.splat(v[1]), self.splat(v[2])]
    }

    /// Product of the areas over 4π · 36, zero where the pair is not for here.
    ///
    /// 1/9 is the weight of a pair of points, 1/4 belongs to [`spread`] on both sides.
    #[inline(always)]
    fn amplitude(&self, skip: u16, own: Option<usize>) -> Lanes<S> {
        let common = self.test.area / (4.0 * PI * 36.0);
        let areas = self.field(AREA);
        if skip == 0 && own.is_none() {
            return areas * self.splat(common);
        }
        let first = self.part * S::F32_LANES;
        let mut factors = [0.0_f32; GROUP];
        for (lane, factor) in factors.iter_mut().enumerate().take(S::F32_LANES) {
            if skip >> (first + lane) & 1 == 0 {
                *factor = if own == Some(first + lane) { 0.5 * common } else { common };
            }
        }
        areas * Lanes::of(self.simd, self.simd.partial_load_f32s(&factors[..S::F32_LANES]))
    }

    /// Adds the pair, both ways, to the sums of the test vertices and the loads.
    #[inline(always)]
    fn add<const WITH_LOADS: bool>(
        &self,
        skip: u16,
        own: Option<usize>,
        local: &[usize; 3],
        sums: &mut [S::f32s],
        [forward_loads, backward_loads]: [&mut [S::f32s]; 2],
    ) {
        let zero = self.splat(0.0);
        let amplitude = self.amplitude(skip, own);
        let rate = self.k * self.splat(1.0 / TAU);
        let p = &self.test.points;
        let x = [self.splats(p[0]), self.splats(p[1]), self.splats(p[2])];
        let n_test = self.splats(self.test.normal);
        let n_source = self.vector(NORMAL);
        // iγ'k² n·n, of −γk² n·n.
        let alignment = self.coupling * self.k * self.k * dot(n_test, n_source);
        let origin = self.vector(POINT);
        // (x − y)·n_y is the same for all y of a flat triangle.
        let mut above_source = [zero; 3];
        for a in 0..3 {
            above_source[a] = dot(difference(x[a], origin), n_source);
        }
        let p = &self.test.turning;
        let turning_test = [self.splats(p[0]), self.splats(p[1]), self.splats(p[2])];

        // Rows i, columns the points of the source.
        let mut forward = [[[zero; 2]; 3]; 3];
        let mut backward = [[[zero; 2]; 3]; 3];
        let mut total = [zero; 2];
        let mut load_total = [[zero; 2]; 3];
        let mut load_turning = [[[zero; 2]; 3]; 3];
        let mut back_total = [[zero; 2]; 3];
        // Component, then point of the source.
        let mut back_turning = [[[zero; 2]; 3]; 3];
        for b in 0..3 {
            let y = self.vector(POINT + 3 * b);
            let above_test = dot(difference(x[0], y), n_test);
            let mut ahead = [[zero; 2]; 3];
            let mut back = [[zero; 2]; 3];
            let mut load = [[zero; 2]; 3];
            for a in 0..3 {
                let d = difference(x[a], y);
                let square = dot(d, d).max(self.splat(1e-12));
                let inverse = square.inverse_root();
                let (sine, cosine) = (square * inverse * rate).turn();
                let value = [inverse * cosine, -(inverse * sine)];
                // −(dG/dr)/r = (1/r + ik) G / r.
                let slope = [
                    inverse * ((-(self.k * value[1])) + inverse * value[0]),
                    inverse * (self.k * value[0] + inverse * value[1]),
                ];
                let volume = [-(alignment * value[1]), alignment * value[0]];
                let by_source = [above_source[a] * slope[0], above_source[a] * slope[1]];
                let by_test = [above_test * slope[0], above_test * slope[1]];
                ahead[a] = [volume[0] - by_source[0], volume[1] - by_source[1]];
                back[a] = [volume[0] + by_test[0], volume[1] + by_test[1]];
                for z in 0..2 {
                    total[z] = total[z] + value[z];
                }
                if !WITH_LOADS {
                    continue;
                }
                // G − iγ' ∂G/∂n, of the test side and of the source side.
                load[a] = [value[0] - self.coupling * by_test[1], value[1] + self.coupling * by_test[0]];
                let other =
                    [value[0] + self.coupling * by_source[1], value[1] - self.coupling * by_source[0]];
                for z in 0..2 {
                    back_total[b][z] = back_total[b][z] + other[z];
                    for c in 0..3 {
                        back_turning[c][b][z] =
                            other[z].times_plus(turning_test[a][c], back_turning[c][b][z]);
                    }
                }
            }
            let (ahead, back) = (self.spread(ahead), self.spread(back));
            for i in 0..3 {
                forward[i][b] = ahead[i];
                backward[i][b] = back[i];
            }
            if !WITH_LOADS {
                continue;
            }
            let turning_source = self.vector(TURNING + 3 * b);
            let load = self.spread(load);
            for i in 0..3 {
                for z in 0..2 {
                    load_total[i][z] = load_total[i][z] + load[i][z];
                    for c in 0..3 {
                        load_turning[i][c][z] =
                            load[i][z].times_plus(turning_source[c], load_turning[i][c][z]);
                    }
                }
            }
        }

        // γ ΣG, and the 1/4 that the shape functions of constants do not have.
        let curl = self.coupling * self.splat(4.0);
        let total = [total[1] * curl, -(total[0] * curl)];
        let curls_source = [self.vector(CURL), self.vector(CURL + 3), self.vector(CURL + 6)];
        for i in 0..3 {
            let row = &mut sums[local[i] * SUMS * self.parts..][..SUMS * self.parts];
            let curl_test = self.splats(self.test.curls[i]);
            let (ahead, back) = (self.spread(forward[i]), self.spread(backward[i]));
            for j in 0..3 {
                let curls = dot(curl_test, curls_source[j]);
                for z in 0..2 {
                    let both = curls * total[z];
                    let at = (2 * j + z) * self.parts + self.part;
                    self.accumulate(&mut row[at], (ahead[j][z] + both) * amplitude);
                    let at = at + SUMS / 2 * self.parts;
                    self.accumulate(&mut row[at], (back[j][z] + both) * amplitude);
                }
            }
        }

        if !WITH_LOADS {
            return;
        }
        // Only one side is spread: 1/2 instead of 1/4.
        let amplitude = amplitude + amplitude;
        for i in 0..3 {
            for z in 0..2 {
                let through = load_total[i][z] * amplitude;
                for c in 0..3 {
                    let at = (local[i] * LOADS + 2 * c + z) * self.parts + self.part;
                    self.accumulate(&mut forward_loads[at], through * n_source[c]);
                    let at = at + RIGID_DOFS * self.parts;
                    self.accumulate(&mut forward_loads[at], load_turning[i][c][z] * amplitude);
                }
            }
        }
        let back_total = self.spread(back_total);
        let back_turning =
            [self.spread(back_turning[0]), self.spread(back_turning[1]), self.spread(back_turning[2])];
        for j in 0..3 {
            for z in 0..2 {
                let through = back_total[j][z] * amplitude;
                for c in 0..3 {
                    let at = (j * LOADS + 2 * c + z) * self.parts + self.part;
                    self.accumulate(&mut backward_loads[at], through * n_test[c]);
                    let at = at + RIGID_DOFS * self.parts;
                    self.accumulate(&mut backward_loads[at], back_turning[c][j][z] * amplitude);
                }
            }
        }
    }

    #[inline(always)]
    fn accumulate(&self, sum: &mut S::f32s, value: Lanes<S>) {
        *sum = self.simd.add_f32s(*sum, value.register());
    }

    /// Twice the integrals against the three shape functions of values at the three points: each function is
    /// 2/3 at its own point and 1/6 at the others.
    #[inline(always)]
    fn spread(&self, values: [Complexes<S>; 3]) -> [Complexes<S>; 3] {
        let third = self.splat(1.0 / 3.0);
        let mut out = values;
        for z in 0..2 {
            let share = (values[0][z] + values[1][z] + values[2][z]) * third;
            for i in 0..3 {
                out[i][z] = values[i][z] + share;
            }
        }
        out
    }
}

#[inline(always)]
fn dot<S: Simd>(a: [Lanes<S>; 3], b: [Lanes<S>; 3]) -> Lanes<S> {
    a[0].times_plus(b[0], a[1].times_plus(b[1], a[2] * b[2]))
}

#[inline(always)]
fn difference<S: Simd>(a: [Lanes<S>; 3], b: [Lanes<S>; 3]) -> [Lanes<S>; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
