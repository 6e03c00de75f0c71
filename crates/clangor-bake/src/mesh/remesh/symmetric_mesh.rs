//! A surface symmetric about up to three orthogonal planes, stored as the part between the planes.
//!
//! The rest is copies with signs changed, so that the symmetry is exact to the last bit.

use std::collections::HashMap;

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::{BVec3, DMat3, DVec3};

/// A vertex nearer to a plane than this part of its shortest edge is moved onto it: cutting there would leave
/// slivers.
const SNAP: f64 = 0.05;

/// The surface of a mirror-symmetric solid about the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct SymmetricMesh {
    /// Where the coordinates along the mirrored axes of `frame` are not negative \[m\]; exactly zero on the
    /// planes. The whole surface if no axis is mirrored.
    pub cell: TriMesh,
    /// Which axes of `frame` are mirrored.
    pub mirrors: BVec3,
    /// Rotation from the frame of `cell` to that of the body; the identity if the planes are coordinate
    /// planes.
    pub frame: DMat3,
}

/// A vertex of the whole surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageVertex {
    /// The vertex of the cell.
    pub original: u32,
    /// Factors of its coordinates, ±1.
    pub signs: DVec3,
}

impl SymmetricMesh {
    /// Signs of the images, the cell itself first.
    pub fn images(&self) -> Vec<DVec3> {
        images_of([self.mirrors.x, self.mirrors.y, self.mirrors.z])
    }

    /// The whole surface in the frame of the body, and where its vertices come from. The vertices of the cell
    /// come first.
    pub fn whole(&self) -> (TriMesh, Vec<ImageVertex>) {
        let mut whole = TriMesh::default();
        let mut origin = Vec::new();
        let count = self.cell.vertices.len();
        // Vertex numbers of each image.
        let mut numbers: Vec<Vec<u32>> = Vec::new();
        let images = self.images();
        for signs in &images {
            let mut number = Vec::with_capacity(count);
            for (original, position) in self.cell.vertices.iter().enumerate() {
                // A vertex on a plane is its own image and keeps the number it has without that reflection.
                let folded = DVec3::select(position.cmpeq(DVec3::ZERO), DVec3::ONE, *signs);
                let earlier = images.iter().position(|i| *i == folded).filter(|i| *i < numbers.len());
                number.push(match earlier {
                    Some(image) => numbers[image][original],
                    None => {
                        whole.vertices.push(self.frame * (*signs * *position));
                        origin.push(ImageVertex { original: original as u32, signs: *signs });
                        (whole.vertices.len() - 1) as u32
                    }
                });
            }
            // An odd number of reflections reverses the orientation.
            let flipped = signs.x * signs.y * signs.z < 0.0;
            whole.triangles.extend(self.cell.triangles.iter().map(|t| {
                let [a, b, c] = t.map(|v| number[v as usize]);
                if flipped { [a, c, b] } else { [a, b, c] }
            }));
            numbers.push(number);
        }
        (whole, origin)
    }
}

/// Signs of the images by reflections along these axes, the original first.
pub(crate) fn images_of(mirrors: [bool; 3]) -> Vec<DVec3> {
    let mut images = vec![DVec3::ONE];
    for (axis, mirrored) in DVec3::AXES.into_iter().zip(mirrors) {
        if mirrored {
            images.extend(images.clone().into_iter().map(|signs| signs * (DVec3::ONE - 2.0 * axis)));
        }
    }
    images
}

/// A frame that contains the given orthogonal directions among its axes, and flags for those axes. Directions
/// along coordinate axes give the identity.
pub(crate) fn frame_of(normals: &[DVec3]) -> (DMat3, BVec3) {
    let mut columns = [None; 3];
    for normal in normals.iter().take(3) {
        let free = (0..3).filter(|k| columns[*k].is_none());
        let Some(axis) = free.max_by(|i, j| normal[*i].abs().total_cmp(&normal[*j].abs())) else { break };
        columns[axis] = Some(if normal[axis] < 0.0 { -*normal } else { *normal });
    }
    let mirrors = BVec3::from_array(columns.map(|c| c.is_some()));
    // Missing axes: coordinate axes, orthogonalised.
    for k in 0..3 {
        if columns[k].is_none() {
            let rest = |axis: DVec3| columns.iter().flatten().fold(axis, |a, c| a - a.dot(*c) * *c);
            let best = DVec3::AXES.map(rest);
            let longest = [k, (k + 1) % 3, (k + 2) % 3]
                .into_iter()
                .reduce(|i, j| if best[j].length() > best[i].length() + 1e-9 { j } else { i });
            columns[k] = longest.map(|i| best[i].normalize_or_zero());
        }
    }
    let [x, y, z] = columns.map(Option::unwrap_or_default);
    let frame = DMat3::from_cols(x, y, z);
    (if frame.determinant() < 0.0 { DMat3::from_cols(x, y, -z) } else { frame }, mirrors)
}

/// The part of a closed surface where the coordinate along `axis` is positive.
pub(super) fn positive_half(mesh: &TriMesh, axis: usize) -> TriMesh {
    // Snap vertices close to the plane onto it.
    let mut shortest = vec![f64::INFINITY; mesh.vertices.len()];
    for (t, corners) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(t);
        let length = a.distance(b).min(b.distance(c)).min(c.distance(a));
        corners.iter().for_each(|v| shortest[*v as usize] = shortest[*v as usize].min(length));
    }
    let mut vertices = mesh.vertices.clone();
    for (v, length) in vertices.iter_mut().zip(&shortest) {
        if v[axis].abs() < SNAP * length {
            v[axis] = 0.0;
        }
    }
    let mut half = TriMesh { vertices, triangles: Vec::new() };
    let mut cuts: HashMap<(u32, u32), u32> = HashMap::new();
    // Clip each triangle; cut points are shared between neighbours.
    for corners in &mesh.triangles {
        let mut kept: Vec<u32> = Vec::with_capacity(4);
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let (da, db) = (half.vertices[a as usize][axis], half.vertices[b as usize][axis]);
            if da >= 0.0 {
                kept.push(a);
            }
            if da * db < 0.0 {
                kept.push(*cuts.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let (low, high) = (half.vertices[a.min(b) as usize], half.vertices[a.max(b) as usize]);
                    let mut cut = low.lerp(high, low[axis] / (low[axis] - high[axis]));
                    cut[axis] = 0.0;
                    half.vertices.push(cut);
                    (half.vertices.len() - 1) as u32
                }));
            }
        }
        let beyond = kept.iter().any(|v| half.vertices[*v as usize][axis] > 0.0);
        if beyond {
            half.triangles.extend((2..kept.len()).map(|k| [kept[0], kept[k - 1], kept[k]]));
        }
    }
    // Drop the vertices of the other half.
    half.weld(0.0)
}
