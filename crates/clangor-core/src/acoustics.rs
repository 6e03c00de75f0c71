//! Acoustics of a scene: fluid, air absorption, room, reflecting floor, band limit.
//!
//! Shared by scenes, the offline renderer and the real-time engine. The propagation paths that follow from it
//! are computed in [`propagation`](crate::propagation).

use crate::medium::Medium;
use crate::propagation::{Air, Floor, Room};

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
    /// Highest frequency rendered without attenuation \[Hz\], above 0; `None`: as high as the sample rate
    /// allows. Default: `None`.
    pub max_frequency: Option<f64>,
}
