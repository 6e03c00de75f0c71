//! Errors in a room.

use glam::DVec3;

/// Error in a room.
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
    /// An absorption coefficient outside 0 to 1.
    #[error("a wall cannot absorb {value} of the energy at {octave} Hz: it is a share from 0 to 1")]
    Absorption {
        /// The coefficient \[-\].
        value: f64,
        /// The octave \[Hz\].
        octave: f64,
    },
    /// A room without absorption, which has no reverberation time.
    #[error("the walls of the room absorb nothing at {octave} Hz, so that its reverberation never ends")]
    Undamped {
        /// The octave \[Hz\].
        octave: f64,
    },
}
