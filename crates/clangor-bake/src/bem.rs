//! Boundary-element methods for the Helmholtz equation outside a rigid body.

pub mod axisymmetric;
pub mod symmetric_patches;
pub mod triangles;
