//! Boundary-element methods for the Helmholtz equation outside a rigid body.

pub mod galerkin;
