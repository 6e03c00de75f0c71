//! The flat triangles of a closed surface, with the geometry that the integrals need, and their mirror
//! images.

use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;

use crate::radiation::rigid_motions;

/// Triangles with three linear shape functions each. Lengths in the reference radius R.
#[derive(Clone, Debug)]
pub(super) struct Panels {
    pub(super) vertices: Vec<DVec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Unit normals into the fluid.
    pub(super) normals: Vec<DVec3>,
    pub(super) areas: Vec<f64>,
    pub(super) centroids: Vec<DVec3>,
    /// Largest distance of a corner from the centroid.
    pub(super) radii: Vec<f64>,
    /// Surface curls of the three shape functions, up to a common sign: opposite edge over twice the area.
    pub(super) curls: Vec<[DVec3; 3]>,
}

impl Panels {
    /// Panels of a surface whose triangles wind counter-clockwise seen from the fluid.
    pub(super) fn new(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Self {
        let count = triangles.len();
        let mut panels = Self {
            vertices,
            triangles,
            normals: Vec::with_capacity(count),
            areas: Vec::with_capacity(count),
            centroids: Vec::with_capacity(count),
            radii: Vec::with_capacity(count),
            curls: Vec::with_capacity(count),
        };
        for t in 0..count {
            let [a, b, c] = panels.corners(t);
            let twice = (b - a).cross(c - a);
            let centroid = (a + b + c) / 3.0;
            panels.normals.push(twice.normalize_or_zero());
            panels.areas.push(0.5 * twice.length());
            panels.centroids.push(centroid);
            panels.radii.push([a, b, c].map(|v| v.distance(centroid)).into_iter().fold(0.0, f64::max));
            panels.curls.push([c - b, a - c, b - a].map(|edge| edge / twice.length().max(f64::MIN_POSITIVE)));
        }
        panels
    }

    /// The image under the reflections whose signs are −1; every corner keeps its number.
    pub(super) fn image(&self, signs: DVec3) -> Self {
        let reflected = |v: &DVec3| signs * *v;
        let flip = signs.x * signs.y * signs.z;
        Self {
            vertices: self.vertices.iter().map(reflected).collect(),
            triangles: self.triangles.clone(),
            normals: self.normals.iter().map(reflected).collect(),
            areas: self.areas.clone(),
            centroids: self.centroids.iter().map(reflected).collect(),
            radii: self.radii.clone(),
            // A curl is an axial vector.
            curls: self.curls.iter().map(|curls| curls.map(|c| flip * reflected(&c))).collect(),
        }
    }

    pub(super) fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|v| self.vertices[v as usize])
    }

    /// The point with the given shares of the corners.
    pub(super) fn point(&self, triangle: usize, shares: [f64; 3]) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        a * shares[0] + b * shares[1] + c * shares[2]
    }

    /// Normal acceleration of the six motions at the three corners; it is linear in between.
    pub(super) fn motions(&self, triangle: usize) -> [[f64; RIGID_DOFS]; 3] {
        self.corners(triangle).map(|x| rigid_motions(x, self.normals[triangle]))
    }
}

/// Permutation along a space-filling curve (Morton's) that keeps neighbours together, in a cube of half side
/// `radius`.
pub(super) fn along_curve(points: &[DVec3], radius: f64) -> Vec<u32> {
    let code = |p: &DVec3| {
        let cell = ((*p / radius + DVec3::ONE) * 511.5).clamp(DVec3::ZERO, DVec3::splat(1023.0));
        (0..10).fold(0_u32, |code, bit| {
            let digit = |c: f64| (c as u32 >> bit & 1) << (3 * bit);
            code | digit(cell.x) | digit(cell.y) << 1 | digit(cell.z) << 2
        })
    };
    let codes: Vec<u32> = points.iter().map(code).collect();
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_by_key(|i| codes[*i as usize]);
    order
}
