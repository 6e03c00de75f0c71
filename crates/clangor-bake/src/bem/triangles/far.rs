//! Far pairs: couplings of distant triangles by three points on each, in single precision.
//!
//! Each unordered pair is integrated once for both directions: the first triangle testing the second's field
//! (entry ij) and the reverse (ji) share distance, phase and G. Source triangles run in vector lanes. Sums
//! over the triangles of a block of test functions stay in cache, lane by lane, so that each entry of the
//! large matrices is updated once per block and vertex instead of once per pair of triangles.
//!
//! ```text
//! A_ij = −⟨φ_i, K φ_j⟩ + γ (⟨curl φ_i, G curl φ_j⟩ − k² ⟨φ_i n, G φ_j n⟩)
//! b_i = ⟨φ_i, S a + γ K' a⟩,    γ = −iγ'
//! ```

mod class_matrix;
mod geometry;
mod layout;
mod pair_lanes;

use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;
use num_complex::{Complex32, Complex64};
use pulp::{Simd, WithSimd};

pub(super) use self::class_matrix::ClassMatrix;
use self::class_matrix::totals;
use self::geometry::{Block, Corners, FarImage, Test, corners};
use self::layout::{BLOCK, FIELDS, GROUP, LOADS, SUMS};
use self::pair_lanes::PairLanes;
use super::lanes::Lanes;
use super::panels::Panels;

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

impl FarSystem {
    /// `near` lists for each image the pairs (t, s), t ≤ s, that are integrated by the near part.
    pub(super) fn new<'a>(
        panels: &Panels,
        images: &[DVec3],
        near: impl Iterator<Item = &'a [(u32, u32)]>,
    ) -> Self {
        let count = panels.triangles.len();
        let tests = (0..count).map(|t| Test::new(panels, t)).collect();
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
        pulp::Arch::new().dispatch(Assembly::<true, true> { system: self, k, coupling, classes, loads });
    }

    /// Adds the far pairs to the matrices alone.
    pub(super) fn assemble_matrices(&self, k: f64, coupling: f64, classes: &mut [ClassMatrix<'_>]) {
        let (k, coupling) = (k as f32, coupling as f32);
        pulp::Arch::new().dispatch(Assembly::<true, false> {
            system: self,
            k,
            coupling,
            classes,
            loads: &mut [],
        });
    }

    /// Adds the far pairs to the loads of all vertices alone.
    pub(super) fn assemble_loads(&self, k: f64, coupling: f64, loads: &mut [[Complex64; RIGID_DOFS]]) {
        let (k, coupling) = (k as f32, coupling as f32);
        pulp::Arch::new().dispatch(Assembly::<false, true> {
            system: self,
            k,
            coupling,
            classes: &mut [],
            loads,
        });
    }
}

/// `WITH_MATRIX`, `WITH_LOADS`: the matrices, the loads of the six motions, or both.
struct Assembly<'a, 'b, const WITH_MATRIX: bool, const WITH_LOADS: bool> {
    system: &'a FarSystem,
    k: f32,
    coupling: f32,
    classes: &'a mut [ClassMatrix<'b>],
    loads: &'a mut [[Complex64; RIGID_DOFS]],
}

impl<const WITH_MATRIX: bool, const WITH_LOADS: bool> WithSimd for Assembly<'_, '_, WITH_MATRIX, WITH_LOADS> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { system, k, coupling, classes, loads } = self;
        let parts = GROUP / S::F32_LANES;
        let (mut sums, mut vertex_totals) = (Vec::new(), Vec::new());
        let mut forward_loads = Vec::new();
        let mut backward_loads = vec![0.0_f32; 3 * LOADS * GROUP];
        for (g, image) in system.images.iter().enumerate() {
            let (sources, _) = S::as_simd_f32s(&image.sources);
            let groups = sources.len() / (FIELDS * parts);
            // Blocks of test triangles against groups of source triangles.
            for block in &system.blocks {
                forward_loads.clear();
                forward_loads.resize(block.vertices.len() * LOADS * GROUP, 0.0_f32);
                for group in block.first / GROUP..groups {
                    sums.clear();
                    if WITH_MATRIX {
                        sums.resize(block.vertices.len() * SUMS * GROUP, 0.0_f32);
                    }
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
                        // Couplings of one test triangle with the group, one register at a time.
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
                            pair.add::<WITH_MATRIX, WITH_LOADS>(skip, own, local, sums, [forward, backward]);
                        }
                    }
                    // Add the sums to the matrix of each parity class, and the loads of the sources.
                    if touched {
                        let corners = &system.corners[group];
                        if WITH_MATRIX {
                            totals(corners, &sums, &mut vertex_totals);
                        }
                        for class in classes.iter_mut() {
                            class.add(g, block, corners, &vertex_totals);
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
                // Loads of the test vertices, summed over lanes.
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
