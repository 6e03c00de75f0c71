//! Boundary-element methods for the Helmholtz equation outside a rigid body.

pub mod galerkin;
pub mod octant;
pub mod revolution;
