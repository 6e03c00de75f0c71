//! Interface of the radiation solvers: the field of six rigid motions at given wavenumbers.
//!
//! The exterior Neumann problem Δp + k²p = 0, ∂p/∂n = −ρ a_n on the surface, outgoing, with ρ = 1 and a_n =
//! g_i(x): e_i·n for a unit acceleration along an axis, (e_i × x)·n for a unit angular acceleration about an
//! axis through the centre of mass, which is the origin. Time dependence e^{+iωt}, so that a wavenumber with
//! negative imaginary part belongs to a growing motion, away from the resonances.

use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;
use num_complex::Complex64;

/// Reasons why a field cannot be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RadiationError {
    /// More unknowns than a dense solution can hold.
    #[error(
        "the body needs {unknowns} unknowns at {wavenumber:.4e} 1/m, more than the {most} that fit; use \
         another method or a lower band"
    )]
    TooLarge {
        /// Unknowns needed.
        unknowns: usize,
        /// Largest number supported.
        most: usize,
        /// Wavenumber k [1/m].
        wavenumber: f64,
    },
    /// Residual pressure at points inside the body.
    #[error("the solution at {wavenumber:.4e} 1/m cannot be told from a resonance of the body's inside")]
    Resonance {
        /// Wavenumber k [1/m].
        wavenumber: f64,
    },
    /// A surface without faces.
    #[error("the surface has no triangles")]
    Empty,
    /// The solver belongs to another body than the modes.
    #[error("a body of {radius:.4} m is {distance:.4} m from the surface whose modes it is to radiate")]
    OffSurface {
        /// Largest distance between the two surfaces \[m\].
        distance: f64,
        /// Bounding radius \[m\].
        radius: f64,
    },
    /// A mode without a motion for every node.
    #[error("a mode moves {given} nodes of a surface that has {nodes}")]
    Shape {
        /// Nodes of the mode.
        given: usize,
        /// Nodes of the surface.
        nodes: usize,
    },
    /// More multipoles than supported.
    #[error(
        "a mode at {wavenumber:.4e} 1/m needs multipoles to order {order}, more than the {most} that are \
         computed"
    )]
    Orders {
        /// Order needed, about kR.
        order: usize,
        /// Highest order.
        most: usize,
        /// Wavenumber k [1/m].
        wavenumber: f64,
    },
    /// Stopped by the caller.
    #[error("interrupted")]
    Interrupted,
    /// A solution that is not finite.
    #[error("the solution at {wavenumber:.4e} 1/m is not finite")]
    NotFinite {
        /// Wavenumber k [1/m].
        wavenumber: f64,
    },
}

/// The field of the six motions at one wavenumber.
#[derive(Clone, Debug, PartialEq)]
pub struct RadiationSample {
    /// k [1/m] at which it was solved; near the requested one, possibly with a negative imaginary part.
    pub wavenumber: Complex64,
    /// Outgoing multipoles of each motion on the sphere of radius `reference_radius` \[m\] about the origin:
    /// p e^{ikr} = Σ c_nm x^{−(n+1)} θₙ(ikRx)/θₙ(ikR) Y_nm, x = r/R, without the special factor of the
    /// monopole. Translations \[m\], rotations \[m²\]. Index n² + n + m.
    pub coefficients: [Vec<Complex64>; RIGID_DOFS],
    /// Pressure of each motion at the vertices of [`RadiationSolver::surface`]; empty without a surface.
    pub surface_pressure: Vec<[Complex64; RIGID_DOFS]>,
}

/// A solver of the six rigid motions of one body, in the frame with the centre of mass at the origin.
pub trait RadiationSolver: Sync {
    /// The six fields at each wavenumber [1/m], in the same order; `order` is the highest n of the
    /// coefficients.
    ///
    /// A solver may shift a wavenumber off the real axis, and records that in the sample.
    ///
    /// # Errors
    /// [`RadiationError`].
    fn solve(&self, wavenumbers: &[f64], order: usize) -> Result<Vec<RadiationSample>, RadiationError>;

    /// Bounding radius R \[m\] about the centre of mass: the radius of the coefficients.
    fn reference_radius(&self) -> f64;

    /// Mesh of the surface pressures, if any. The boundary integral over it gives the near field.
    fn surface(&self) -> Option<&TriMesh>;
}

/// g_1 … g_6 at a point x of the surface with normal n (of any length).
pub fn rigid_motions(x: DVec3, n: DVec3) -> [f64; RIGID_DOFS] {
    let r = x.cross(n);
    [n.x, n.y, n.z, r.x, r.y, r.z]
}
