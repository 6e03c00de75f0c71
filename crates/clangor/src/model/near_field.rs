//! The field close to a body, inside the ball where its multipoles converge.
//!
//! Multipoles about the centre of mass are valid outside the bounding sphere only. Closer, the pressure is the boundary
//! integral over the surface,
//!
//! ```text
//! p(x) = ∫ (p ∂G/∂n + ρ a_n G) dS,    G = e^{−ikr}/(4πr)
//! ```
//!
//! with the surface pressure p that the solver found, linear on each triangle, and a_n of the rigid motion.

use crate::geometry::tri_mesh::TriMesh;

/// Surface pressures of the six motions, in the units of
/// [`AccelerationField`](super::acceleration_field::AccelerationField): lengths over R, s = ikR, p/(ρ R) for z = (a, R α).
#[derive(Clone, Debug, PartialEq)]
pub struct NearField {
    /// The surface, its vertices over R, the centre of mass at the origin.
    pub surface: TriMesh,
    /// Real parts: for each vertex, for each degree of freedom, the values at the nodes of the field.
    pub real: Vec<f32>,
    /// Imaginary parts.
    pub imaginary: Vec<f32>,
}
