//! Parity of the motions about the mirror planes of a body, and the unknowns that remain.
//!
//! Under a reflection a translation is a vector and a rotation an axial vector. The pressure has the sign of
//! the motion. Where it is odd about a plane it vanishes on it, so that vertices there have no unknown.

use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;

use super::pair_integrals::parity;

/// Marks a vertex without an unknown.
const NONE: u32 = u32::MAX;

/// Motions with the same parities.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ParityClass {
    /// Degrees of freedom in the frame of the planes.
    pub(super) motions: Vec<usize>,
    /// Sign of each image.
    pub(super) signs: Vec<f64>,
    /// Unknown of each vertex of the cell, `u32::MAX` without.
    pub(super) unknowns: Vec<u32>,
    /// Unknowns.
    pub(super) size: usize,
}

impl ParityClass {
    /// The classes of the six motions, over a cell whose vertices on a plane have coordinate zero there.
    pub(super) fn all(vertices: &[DVec3], images: &[DVec3]) -> Vec<Self> {
        let mut classes: Vec<Self> = Vec::new();
        for motion in 0..RIGID_DOFS {
            let signs: Vec<f64> = images.iter().map(|image| parity(*image, motion)).collect();
            match classes.iter_mut().find(|class| class.signs == signs) {
                Some(class) => class.motions.push(motion),
                None => {
                    let class = Self::new(signs, vertices, images);
                    classes.push(Self { motions: vec![motion], ..class });
                }
            }
        }
        classes
    }

    /// The class of fields with the given sign on each image, without any of the six motions.
    pub(super) fn new(signs: Vec<f64>, vertices: &[DVec3], images: &[DVec3]) -> Self {
        let mut size = 0;
        let mut number = |vertex: &DVec3| {
            // A vertex fixed by a reflection has no unknown if the reflection negates its pressure.
            let vanishes =
                images.iter().zip(&signs).any(|(image, sign)| *sign < 0.0 && *image * *vertex == *vertex);
            if vanishes {
                return NONE;
            }
            size += 1;
            size - 1
        };
        let unknowns = vertices.iter().map(&mut number).collect();
        Self { motions: Vec::new(), signs, unknowns, size: size as usize }
    }

    /// Vertices of the unknowns, in order.
    pub(super) fn vertices(&self) -> impl Iterator<Item = usize> {
        self.unknowns.iter().enumerate().filter(|(_, unknown)| **unknown != NONE).map(|(vertex, _)| vertex)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_planes_make_six_classes_and_none_makes_one() {
        let vertices = [DVec3::ONE, DVec3::new(0.0, 1.0, 1.0), DVec3::new(0.0, 0.0, 1.0)];
        let one = ParityClass::all(&vertices, &[DVec3::ONE]);
        assert_eq!((one.len(), one[0].motions.len(), one[0].size), (1, RIGID_DOFS, 3));
        let mirrored = [DVec3::ONE, DVec3::new(-1.0, 1.0, 1.0)];
        let two = ParityClass::all(&vertices, &mirrored);
        assert_eq!([&two[0].motions[..], &two[1].motions[..]], [[0, 4, 5], [1, 2, 3]]);
        assert_eq!(two[0].unknowns, [0, NONE, NONE]);
        assert_eq!(two[1].size, 3);
        let signs = |bits: u32| DVec3::from_array([0, 1, 2].map(|k| 1.0 - 2.0 * f64::from(bits >> k & 1)));
        let images: Vec<DVec3> = (0..8).map(signs).collect();
        let six = ParityClass::all(&vertices, &images);
        assert!(six.len() == RIGID_DOFS && six.iter().all(|class| class.motions.len() == 1));
        // Translation along z is even about x = 0 and y = 0.
        assert_eq!(six[2].size, 3);
        assert_eq!(six[2].vertices().collect::<Vec<_>>(), [0, 1, 2]);
    }
}
