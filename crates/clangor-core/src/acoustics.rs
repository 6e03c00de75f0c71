//! Acoustics of a scene: fluid, air absorption, room, reflecting floor and planes, band limit.
//!
//! Shared by scenes, the offline renderer and the real-time engine. [`Acoustics::paths`] are the propagation
//! paths that follow from it.

use crate::medium::Medium;
use crate::propagation::{Air, Floor, PlanesError, PropagationPaths, ReflectingPlanes, Room};

/// Settings of the surroundings of sources and receivers.
///
/// The default is free space filled with dry air at 20 °C, without absorption and without a band limit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Acoustics {
    /// Fluid that carries the sound. Default: [`Medium::AIR`].
    pub medium: Medium,
    /// Absorption of the air; `None`: no absorption. Default: `None`.
    pub air: Option<Air>,
    /// Room around sources and receivers; `None`: no walls. Default: `None`.
    pub room: Option<Room>,
    /// Reflecting floor, used when no room is set. Default: [`Floor::None`].
    pub floor: Floor,
    /// Planes that reflect, used when no room is set. Default: none.
    pub planes: ReflectingPlanes,
    /// Highest frequency rendered without attenuation \[Hz\], above 0; `None`: as high as the sample rate
    /// allows. Default: `None`.
    pub max_frequency: Option<f64>,
}

impl Acoustics {
    /// The paths from a source to a receiver.
    pub fn paths(&self) -> PropagationPaths {
        PropagationPaths::new(self.floor, self.room, &self.planes, self.air)
    }

    /// Rejects reflecting planes in a room.
    ///
    /// # Errors
    /// [`PlanesError::AndRoom`].
    pub fn check(&self) -> Result<(), PlanesError> {
        match self.room.is_some() && !self.planes.as_slice().is_empty() {
            true => Err(PlanesError::AndRoom),
            false => Ok(()),
        }
    }
}
