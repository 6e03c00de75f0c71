//! Propagation from source to receiver: the paths by which sound arrives, with their loss, and late
//! reverberation.
//!
//! [`PropagationPaths`] lists the paths. The offline renderer and the real-time engine render the same voices
//! over them.

pub mod air;
pub mod floor;
pub mod image_source;
pub mod late_reverberation;
pub mod path_loss;
mod plane_images;
pub mod propagation_paths;
pub mod reflecting_plane;
pub mod room;
mod room_error;
pub mod room_images;
pub mod wall;

pub use air::Air;
pub use floor::Floor;
pub use image_source::ImageSource;
pub use late_reverberation::{LateReverberation, ReverberationTimes};
pub use path_loss::PathLoss;
pub use propagation_paths::PropagationPaths;
pub use reflecting_plane::{PlanesError, ReflectingPlane, ReflectingPlanes};
pub use room::{Room, RoomError};
pub use room_images::room_images;
pub use wall::{OCTAVES, WallAbsorption};
