//! What a body sounds like: the pressure field of its motion per unit of acceleration.

pub mod sphere_radiation;
