//! Acceleration noise: the pressure field of the six rigid motions of a body.

pub mod field;
pub mod field_evaluator;
pub mod model;
pub mod model_evaluator;
pub mod near_field;
pub mod proxy_field;
pub mod sphere_radiation;
