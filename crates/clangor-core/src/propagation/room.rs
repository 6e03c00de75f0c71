//! What a room and its air do to sound on the way: reflections in the walls of a box, absorption, late
//! reverberation.
//!
//! ```text
//! source ──► image sources of low order ─────────────────────────────► receiver
//!        └─► all later reflections together: late reverberation ─────►
//! ```
//!
//! Walls and air take from a wave by its frequency: [`PathLoss`](super::PathLoss), from [`WallAbsorption`] and
//! [`Air`](super::Air).

use glam::DVec3;

use super::WallAbsorption;

/// A rectangular room with walls along the axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Room {
    /// Its lowest corner \[m\].
    pub lowest: DVec3,
    /// Its highest corner \[m\].
    pub highest: DVec3,
    /// What the walls absorb: at the lowest and highest x, then y (floor and ceiling), then z.
    pub walls: [WallAbsorption; 6],
    /// Up to so many reflections are images of their own.
    pub image_order: u32,
    /// Whether later ones sound as well.
    pub late: bool,
}

/// Why a room is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RoomError {
    /// Walls that do not enclose anything.
    #[error("a room from {lowest} m to {highest} m encloses nothing")]
    Empty {
        /// Its lowest corner \[m\].
        lowest: DVec3,
        /// Its highest corner \[m\].
        highest: DVec3,
    },
    /// An absorption coefficient that is none.
    #[error("a wall cannot absorb {value} of the energy at {octave} Hz: it is a share from 0 to 1")]
    Absorption {
        /// The coefficient \[-\].
        value: f64,
        /// The octave \[Hz\].
        octave: f64,
    },
    /// A room that never falls silent, which late reverberation cannot follow.
    #[error("the walls of the room absorb nothing at {octave} Hz, so that its reverberation never ends")]
    Undamped {
        /// The octave \[Hz\].
        octave: f64,
    },
}

impl Room {
    /// Refuses what cannot be a room.
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

    /// Areas of the walls \[m²\], in their order.
    pub fn wall_areas(&self) -> [f64; 6] {
        let DVec3 { x, y, z } = self.extent();
        [y * z, y * z, x * z, x * z, x * y, x * y]
    }
}
