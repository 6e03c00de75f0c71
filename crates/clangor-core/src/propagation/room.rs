//! A room and its air: reflections in the walls of a box, absorption, late reverberation.
//!
//! ```text
//! source ──► image sources of low order ─────────────────────────────► receiver
//!        └─► all later reflections together: late reverberation ─────►
//! ```
//!
//! Losses by frequency in walls and air are [`PathLoss`](super::PathLoss), from [`WallAbsorption`] and
//! [`Air`](super::Air).

use glam::DVec3;

use super::WallAbsorption;
pub use super::room_error::RoomError;

/// A rectangular room with walls along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    /// Its lowest corner \[m\].
    pub lowest: DVec3,
    /// Its highest corner \[m\].
    pub highest: DVec3,
    /// Absorption of the walls: at the lowest and highest x, then y (floor and ceiling), then z.
    pub walls: [WallAbsorption; 6],
    /// Largest number of reflections of an image source.
    pub image_order: u32,
    /// Whether late reverberation replaces the later reflections.
    pub late: bool,
}

impl Room {
    /// Rejects an invalid room.
    ///
    /// # Errors
    /// [`RoomError`].
    pub fn check(&self) -> Result<(), RoomError> {
        let Room { lowest, highest, .. } = *self;
        if !(self.extent().min_element() > 0.0 && self.extent().is_finite()) {
            return Err(RoomError::Empty { lowest, highest });
        }
        self.walls.iter().try_for_each(WallAbsorption::check)
    }

    /// Lengths of its edges \[m\].
    pub fn extent(&self) -> DVec3 {
        self.highest - self.lowest
    }

    /// Whether a point [m, world] is in the room.
    pub fn holds(&self, point: DVec3) -> bool {
        point.cmpge(self.lowest).all() && point.cmple(self.highest).all()
    }

    /// Volume \[m³\].
    pub fn volume(&self) -> f64 {
        self.extent().element_product()
    }

    /// Areas of the walls \[m²\], in the order of the walls.
    pub fn wall_areas(&self) -> [f64; 6] {
        let DVec3 { x, y, z } = self.extent();
        [y * z, y * z, x * z, x * z, x * y, x * y]
    }
}
