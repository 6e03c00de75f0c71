//! Geometry of the far pairs in single precision: test triangles, and the sources and their mirror images in
//! groups of vector lanes.

use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;

use super::layout::{AREA, BLOCK, CURL, FIELDS, GROUP, NORMAL, POINT, TURNING};
use crate::bem::triangles::pair_integrals::parity;
use crate::bem::triangles::pair_rules::THREE_POINTS;
use crate::bem::triangles::panels::Panels;

/// The corners of a group of sources that coincide in one vertex.
#[derive(Clone, Debug)]
pub(super) struct Corners {
    pub(super) vertex: u32,
    /// Indices of their real parts among the sums of a test vertex, one direction.
    pub(super) places: Vec<u16>,
}

/// Consecutive test triangles, and the vertices they use.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) first: usize,
    pub(super) vertices: Vec<u32>,
    pub(super) local: Vec<[usize; 3]>,
}

/// A test triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Test {
    pub(super) points: [[f32; 3]; 3],
    pub(super) normal: [f32; 3],
    pub(super) area: f32,
    pub(super) curls: [[f32; 3]; 3],
    /// x × n at the points.
    pub(super) turning: [[f32; 3]; 3],
}

/// The sources, or a mirror image of them.
#[derive(Clone, Debug)]
pub(super) struct FarImage {
    /// Groups × FIELDS × GROUP.
    pub(super) sources: Vec<f32>,
    /// Bits of the lanes of a group that a test triangle skips (near, earlier, past the end): test × groups.
    pub(super) skip: Vec<u16>,
    /// Whether a triangle meets its own image here. Such a pair counts half in each direction.
    pub(super) own: bool,
    pub(super) parities: [f32; RIGID_DOFS],
}

impl Test {
    pub(super) fn new(panels: &Panels, t: usize) -> Self {
        Test {
            points: points(panels, t),
            normal: single(panels.normals[t]),
            area: panels.areas[t] as f32,
            curls: panels.curls[t].map(single),
            turning: turning(panels, t),
        }
    }
}

impl Block {
    pub(super) fn new(panels: &Panels, first: usize) -> Self {
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
    pub(super) fn new(panels: &Panels, signs: DVec3, near: &[(u32, u32)]) -> Self {
        let image = panels.image(signs);
        let own = signs != DVec3::ONE;
        let count = panels.triangles.len();
        let groups = count.div_ceil(GROUP);
        let mut sources = vec![0.0; groups * FIELDS * GROUP];
        // Structure of arrays: quadrature points, curls, normals and areas of each source.
        for s in 0..groups * GROUP {
            let mut set = |field: usize, value: f32| {
                sources[(s / GROUP * FIELDS + field) * GROUP + s % GROUP] = value;
            };
            if s >= count {
                // Padding: outside the body, with zero area.
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
        // Lanes that each test triangle skips.
        let mut skip = vec![0_u16; count * groups];
        let mut mark = |t: usize, s: usize| skip[t * groups + s / GROUP] |= 1 << (s % GROUP);
        for t in 0..count {
            // Pairs with earlier triangles are already integrated; lanes past the end hold no triangle.
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
pub(super) fn corners(group: &[[u32; 3]]) -> Vec<Corners> {
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
