//! Mirror planes of a body: the waves are stepped on one side of each, and their images stand for the rest.
//!
//! Each rigid motion along or about the axes of the planes is even or odd under a reflection, and so is its
//! pressure. [`GHOSTS`] cells beyond a plane hold the images, with their sign, so that the cells before it
//! need no other stencil; the planes lie between cells.
//!
//! ```text
//! p(−x) = ±p(x)    translations: odd along x;  rotations: odd about y and z
//! ```
//!
//! Motions of the axes of the body are sums of those of the planes; the recorder reads multipoles about the
//! axes of the body.

use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::{DMat3, DVec3};

use super::lattice::{GHOSTS, Lattice};
use crate::bem::triangles::parity;
use crate::mesh::remesh::{frame_of, images_of};

/// Distance of vertices from a grid plane \[cells\], below which they are moved: faces in a grid plane would
/// open cells that are solid.
const CLEAR: f64 = 1e-3;

/// Planes of symmetry through the centre of mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mirrors {
    /// Rotation from the axes of the planes to those of the body.
    pub(super) frame: DMat3,
    /// Whether the plane across each of these axes is one.
    pub(super) planes: [bool; 3],
}

impl Mirrors {
    /// Planes with these orthogonal normals; none leave the axes of the body.
    pub(super) fn new(normals: &[DVec3]) -> Self {
        let (frame, planes) =
            if normals.is_empty() { (DMat3::IDENTITY, Default::default()) } else { frame_of(normals) };
        Mirrors { frame, planes: [planes.x, planes.y, planes.z] }
    }

    /// Whether there is a plane.
    pub(super) fn any(&self) -> bool {
        self.planes.contains(&true)
    }

    /// A vertex of the body \[cells\] in the axes of the planes, off the planes of the grid.
    pub(super) fn clear(&self, vertex: DVec3) -> DVec3 {
        let mut place = self.frame.transpose() * vertex;
        for (axis, _) in self.planes.iter().enumerate().filter(|(_, plane)| **plane) {
            let nearest = place[axis].round();
            if (place[axis] - nearest).abs() < CLEAR {
                place[axis] = if nearest == 0.0 { 0.0 } else { nearest + CLEAR * nearest.signum() };
            }
        }
        place
    }

    /// The signs of the images of a direction, itself first.
    pub(super) fn images(&self) -> Vec<DVec3> {
        images_of(self.planes)
    }

    /// The signs of the pressure of a motion under the reflection along each axis.
    pub(super) fn signs(&self, motion: usize) -> [f64; 3] {
        let sign = |axis: usize| parity(DVec3::ONE - 2.0 * DVec3::AXES[axis], motion);
        [0, 1, 2].map(|axis| if self.planes[axis] { sign(axis) } else { 1.0 })
    }

    /// From signals of motions of the axes of the planes to those of the axes of the body.
    pub(super) fn about_body(&self, signals: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        if self.frame == DMat3::IDENTITY {
            return signals;
        }
        let of_motion = |motion: usize| {
            let first = motion / 3 * 3;
            let shares = [0, 1, 2].map(|axis| self.frame.col(axis)[motion - first]);
            let parts = shares.into_iter().zip(&signals[first..]);
            let mut sum = vec![0.0; signals[first].len()];
            for (share, part) in parts {
                sum.iter_mut().zip(part).for_each(|(sum, value)| *sum += share * value);
            }
            sum
        };
        (0..RIGID_DOFS).map(of_motion).collect()
    }
}

/// Writes the images into the cells beyond the planes of a lattice.
pub(super) fn fill_ghosts(lattice: &Lattice, p: &mut [f32], signs: [f32; 3]) {
    let [nx, ny, nz] = lattice.size;
    let plane = nx * ny;
    // Along x within each row, along y row by row, along z plane by plane: corners get the images of images.
    if lattice.mirrored[0] {
        for row in p.chunks_exact_mut(nx) {
            for ghost in 0..GHOSTS {
                row[GHOSTS - 1 - ghost] = signs[0] * row[GHOSTS + ghost];
            }
        }
    }
    let copy = |block: &mut [f32], size: usize, sign: f32| {
        let (ghosts, cells) = block.split_at_mut(GHOSTS * size);
        for (to, from) in ghosts.chunks_exact_mut(size).rev().zip(cells.chunks_exact(size)) {
            to.iter_mut().zip(from).for_each(|(to, from)| *to = sign * from);
        }
    };
    if lattice.mirrored[1] {
        for k in 0..nz {
            copy(&mut p[k * plane..(k + 1) * plane], nx, signs[1]);
        }
    }
    if lattice.mirrored[2] {
        copy(p, plane, signs[2]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_have_the_sign_of_their_motion() {
        let mirrors = Mirrors::new(&[DVec3::X, DVec3::Z]);
        assert_eq!(mirrors.planes, [true, false, true]);
        // Translations are odd along themselves, rotations about the other axes.
        assert_eq!(mirrors.signs(0), [-1.0, 1.0, 1.0]);
        assert_eq!(mirrors.signs(3), [1.0, 1.0, -1.0]);
        let lattice = Lattice { size: [8, 4, 7], mirrored: [true, false, true] };
        let mut p: Vec<f32> = (0..lattice.cells()).map(|i| i as f32).collect();
        let before = p.clone();
        fill_ghosts(&lattice, &mut p, [-1.0, 1.0, 1.0]);
        let at = |cell: [usize; 3]| lattice.index(cell);
        assert_eq!(p[at([2, 1, 4])], -before[at([3, 1, 4])]);
        assert_eq!(p[at([5, 2, 0])], before[at([5, 2, 5])]);
        assert_eq!(p[at([0, 3, 2])], -before[at([5, 3, 3])]);
        assert_eq!(p[at([4, 3, 5])], before[at([4, 3, 5])]);
    }

    #[test]
    fn motions_of_turned_planes_make_up_those_of_the_body() {
        let mirrors = Mirrors::new(&[DVec3::new(0.6, 0.8, 0.0)]);
        // A signal that is the motion itself, along x of the body.
        let signals: Vec<Vec<f64>> =
            (0..RIGID_DOFS).map(|motion| vec![mirrors.frame.col(motion % 3).x]).collect();
        let about_body = mirrors.about_body(signals);
        for (motion, expected) in [1.0, 0.0, 0.0, 1.0, 0.0, 0.0].into_iter().enumerate() {
            assert!((about_body[motion][0] - expected).abs() < 1e-15, "{motion}");
        }
    }
}
