//! Modal sound: the modes of a body, their shapes on its surface and the field of each.

pub mod model;
pub mod surface;
