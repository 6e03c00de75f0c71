//! What a body sounds like: the pressure field of its motion per unit of acceleration.

pub mod acceleration_field;
pub mod acceleration_model;
pub mod bank_file;
pub mod ellipsoid_bank;
pub mod modal_bank;
pub mod modal_bank_file;
pub mod modal_file;
pub mod modal_model;
pub mod modal_surface;
pub mod model_file;
pub mod near_field;
pub mod playable_field;
pub mod playable_model;
pub mod proxy_field;
pub mod published;
pub mod published_file;
pub mod radial;
pub mod sphere_radiation;
pub mod spherical_harmonics;
pub mod tensor_file;
