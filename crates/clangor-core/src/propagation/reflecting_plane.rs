//! Planes that reflect sound, of any orientation.
//!
//! A plane is infinite and fixed in the world. It reflects what comes from its front, the side of its normal.

use glam::DVec3;

use super::image_source::ImageSource;
use super::wall::WallAbsorption;

/// Highest order of reflections in planes.
pub const MOST_ORDERS: u32 = 4;

/// Largest number of planes, for each order from 1 on. With a rigid floor as one more plane there are at most
/// 64 images: n (1 + (n − 1) + (n − 1)² + …) for n planes.
const MOST_PLANES: [usize; MOST_ORDERS as usize] = [7, 7, 3, 2];

/// Distance \[m\], and difference of unit normals, at which two planes are the same.
const SAME: f64 = 1e-9;

/// Error in the reflecting planes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanesError {
    /// More planes than the engine has paths for.
    #[error("{count} planes reflect, and at most {limit} may for reflections of order {order}")]
    TooMany {
        /// Their number.
        count: usize,
        /// Largest number.
        limit: usize,
        /// Order of the reflections.
        order: u32,
    },
    /// An order of zero, or above the highest.
    #[error("reflections in planes of order {order} are not between 1 and {MOST_ORDERS}")]
    Order {
        /// The order.
        order: u32,
    },
    /// The same plane twice.
    #[error("reflecting plane {second} is the same as reflecting plane {first}, counted from 0")]
    Same {
        /// Index of the first.
        first: usize,
        /// Index of the second.
        second: usize,
    },
    /// A normal whose length is not 1, or a position that is not finite.
    #[error("reflecting plane {plane} has the normal {normal} at {offset} m along it")]
    Place {
        /// Index of the plane.
        plane: usize,
        /// Its normal.
        normal: DVec3,
        /// Its offset \[m\].
        offset: f64,
    },
    /// An absorption coefficient outside 0 to 1.
    #[error("reflecting plane {plane} absorbs a share of {value}, which is not between 0 and 1")]
    Absorption {
        /// Index of the plane.
        plane: usize,
        /// The coefficient \[-\].
        value: f64,
    },
    /// Planes and a room.
    #[error("planes reflect, and so does a room: only one of them may")]
    AndRoom,
}

/// A plane that reflects sound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReflectingPlane {
    /// Unit normal, towards the side that reflects.
    pub normal: DVec3,
    /// Position along the normal \[m\]: n·x of the points of the plane.
    pub offset: f64,
    /// Share of the energy that it absorbs.
    pub absorption: WallAbsorption,
}

impl ReflectingPlane {
    /// The plane through `point` \[m\] with this unit `normal`.
    pub fn through(point: DVec3, normal: DVec3, absorption: WallAbsorption) -> Self {
        ReflectingPlane { normal, offset: normal.dot(point), absorption }
    }

    /// Height of a point above the plane \[m\]; negative behind it.
    pub fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// Whether both reflect in the same place, whatever they absorb.
    pub fn coincides(&self, other: &ReflectingPlane) -> bool {
        self.normal.distance(other.normal) <= SAME && (self.offset - other.offset).abs() <= SAME
    }

    /// Image of an image in the plane, which has this index among the reflectors.
    pub(super) fn mirrored(&self, image: &ImageSource, reflector: usize) -> ImageSource {
        image.mirrored(self.normal, self.offset, reflector)
    }
}

/// The planes of a scene that reflect sound, without allocated memory. The default: none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReflectingPlanes {
    planes: [ReflectingPlane; MOST_PLANES[0]],
    count: usize,
    order: u32,
}

impl Default for ReflectingPlanes {
    fn default() -> Self {
        let none = ReflectingPlane { normal: DVec3::Y, offset: 0.0, absorption: WallAbsorption::even(0.0) };
        ReflectingPlanes { planes: [none; MOST_PLANES[0]], count: 0, order: 1 }
    }
}

impl ReflectingPlanes {
    /// Planes with reflections of up to `order`. At most 7 planes at orders 1 and 2, 3 at order 3, 2 at order
    /// 4.
    ///
    /// # Errors
    /// [`PlanesError`].
    pub fn try_new(planes: &[ReflectingPlane], order: u32) -> Result<Self, PlanesError> {
        if !(1..=MOST_ORDERS).contains(&order) {
            return Err(PlanesError::Order { order });
        }
        let limit = MOST_PLANES[order as usize - 1];
        if planes.len() > limit {
            return Err(PlanesError::TooMany { count: planes.len(), limit, order });
        }
        for (index, plane) in planes.iter().enumerate() {
            let ReflectingPlane { normal, offset, absorption } = *plane;
            if !(normal.length() - 1.0).abs().le(&SAME) || !offset.is_finite() {
                return Err(PlanesError::Place { plane: index, normal, offset });
            }
            if let Some(value) = absorption.0.into_iter().find(|share| !(0.0..=1.0).contains(share)) {
                return Err(PlanesError::Absorption { plane: index, value });
            }
            if let Some(first) = planes[..index].iter().position(|other| other.coincides(plane)) {
                return Err(PlanesError::Same { first, second: index });
            }
        }
        let mut all = ReflectingPlanes { order, count: planes.len(), ..ReflectingPlanes::default() };
        all.planes[..planes.len()].copy_from_slice(planes);
        Ok(all)
    }

    /// The planes.
    pub fn as_slice(&self) -> &[ReflectingPlane] {
        &self.planes[..self.count]
    }

    /// Largest number of reflections on a path.
    pub fn order(&self) -> u32 {
        self.order
    }

    /// The same planes with reflections of at most this order, and of the first at least.
    #[must_use]
    pub fn up_to_order(self, order: u32) -> Self {
        ReflectingPlanes { order: self.order.min(order).max(1), ..self }
    }
}
