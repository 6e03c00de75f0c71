//! Propagation from source to receiver: images, walls, air and late reverberation.

pub mod air;
pub mod floor;
pub mod image_source;
pub mod late_reverberation;
pub mod path_loss;
pub mod room;
mod room_error;
pub mod wall;

pub use air::Air;
pub use floor::Floor;
pub use image_source::{ImageSource, image_sources};
pub use late_reverberation::{LateReverberation, ReverberationTimes};
pub use path_loss::PathLoss;
pub use room::{Room, RoomError};
pub use wall::{OCTAVES, WallAbsorption};
