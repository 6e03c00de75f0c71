//! Image of a source or a receiver after reflections in planes: an isometry of space.
//!
//! ```text
//! x' = T x + o        T orthogonal, with determinant 1 or −1
//! ```
//!
//! The source is mirrored as a whole, with its motion and its field. By reciprocity, the source itself makes
//! at the mirrored receiver what its image makes at the receiver (\[HW\] §4). Which images exist is decided
//! by [`room_images`](mod@super::room_images) and `plane_images`.

use glam::{DMat3, DVec3};

/// Largest number of reflecting planes: the six walls of a room, or planes and a floor.
pub const MOST_REFLECTORS: usize = 8;

/// Image by a sequence of reflections; none for the direct path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageSource {
    /// T, the image of vectors.
    pub turn: DMat3,
    /// o, the image of the origin of the world \[m\].
    pub origin: DVec3,
    /// Number of reflections in each reflector, in their order.
    pub reflections: [u32; MOST_REFLECTORS],
}

impl ImageSource {
    /// The source itself.
    pub const SOURCE: ImageSource =
        ImageSource { turn: DMat3::IDENTITY, origin: DVec3::ZERO, reflections: [0; MOST_REFLECTORS] };

    /// The image of this image in the plane with this unit normal at `offset` \[m\] along it; the plane has
    /// this index among the reflectors.
    #[must_use]
    pub fn mirrored(&self, normal: DVec3, offset: f64, reflector: usize) -> Self {
        let mirror =
            DMat3::IDENTITY - DMat3::from_cols(normal.x * normal, normal.y * normal, normal.z * normal) * 2.0;
        let mut reflections = self.reflections;
        reflections[reflector] += 1;
        let origin = 2.0 * offset * normal + mirror * self.origin;
        ImageSource { turn: mirror * self.turn, origin, reflections }
    }

    /// Number of reflections.
    pub fn order(&self) -> u32 {
        self.reflections.iter().sum()
    }

    /// The image of a point [m, world].
    pub fn image(&self, point: DVec3) -> DVec3 {
        self.origin + self.turn * point
    }

    /// The point [m, world] whose image is this one: a receiver in the space of the source itself.
    pub fn unfolded(&self, image: DVec3) -> DVec3 {
        self.turn.transpose() * (image - self.origin)
    }

    /// Whether both map all points within kilometres to the same place, to a micrometre.
    pub fn coincides(&self, other: &ImageSource) -> bool {
        const TOLERANCE: f64 = 1e-9;
        let distance = self.origin.distance(other.origin);
        self.turn.abs_diff_eq(other.turn, TOLERANCE) && distance <= TOLERANCE * (1.0 + self.origin.length())
    }
}
