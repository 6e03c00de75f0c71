//! The geometry of a body in its most exact known form. Its class decides the solver.

use clangor_core::geometry::meridian::Meridian;
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;

/// The geometry of a body about its centre of mass \[m\].
#[derive(Clone, Debug, PartialEq)]
pub enum BakeGeometry {
    /// An ellipsoid with these semi-axes along x, y, z; spheres included.
    Ellipsoid {
        /// Semi-axes \[m\].
        semi_axes: DVec3,
    },
    /// A box with rounded edges and corners.
    RoundedBox {
        /// Full edges along x, y, z \[m\].
        edges: DVec3,
        /// Radius of the rounding \[m\]; 0 for sharp edges.
        round: f64,
    },
    /// A body that is axisymmetric about y.
    Axisymmetric(Meridian),
    /// Any closed surface.
    Mesh(TriMesh),
}
