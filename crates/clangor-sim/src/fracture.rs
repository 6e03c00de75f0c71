//! Brittle bodies that break: where, into which pieces, and with which impulses.
//!
//! ```text
//! strain energy ──► pattern ──► split ──► pieces ──► crack_impulse ──► velocities
//!                   regions     cells                 stress released
//! ```
//!
//! | module | what |
//! |---|---|
//! | [`pattern`] | as many regions as the strain energy pays for |
//! | [`split`] | closed pieces that fit together, and the crack between them |
//! | [`piece`] | a body of tetrahedra that knows its old surface from its cracks |
//! | [`motion`] | how pieces move when they come off |
//! | [`crack_impulse`] | how the released stress drives them apart |
//! | [`hulls`] | what pieces collide with |
//!
//! Stresses and energies come from outside (`clangor_bake::stress`); what happens to the pieces afterwards is
//! the solver's business.
//!
//! Source: \[FRAC\] §3.2 and §3.3.

pub mod breaking;
mod cells;
mod coarsen;
mod contact_loads;
pub mod crack_impulse;
mod fragments;
pub mod hulls;
pub mod motion;
pub mod pattern;
pub mod piece;
pub mod split;
mod tetrahedron_parts;

use clangor_bake::fem::ElasticError;
use clangor_bake::mesh::tetrahedra::TetMeshError;
use clangor_bake::stress::ElastostaticsError;
use clangor_core::contact::ContactError;
use clangor_core::geometry::solid::MeshError;
use clangor_core::glam::DVec3;

pub use breaking::{Breakable, BreakingBodies};
use crack_impulse::NoImpulse;
use pattern::{PatternSettings, draw_pattern};
use piece::Piece;
use split::{CrackFace, Score, Split, split_by_regions, split_by_scores};

/// A body that has broken.
#[derive(Clone, Debug, PartialEq)]
pub struct Shatter {
    /// The pieces, in the frame of the body.
    pub pieces: Vec<Piece>,
    /// The triangles between them.
    pub crack_faces: Vec<CrackFace>,
    /// Strain energy E_S before the fracture \[J\].
    pub strain_energy: f64,
    /// Energy E_F = G_c A_F that the cracks took \[J\]; at most η E_S.
    pub fracture_energy: f64,
}

impl Shatter {
    /// What is left for the motion of the pieces, E_S − E_F \[J\].
    pub fn surplus(&self) -> f64 {
        self.strain_energy - self.fracture_energy
    }
}

/// Breaks a body as far as its strain energy \[J\] goes; `energy_density` \[J/m³\] is that of each corner of
/// its mesh. `None` if it does not go far enough for any crack.
///
/// # Errors
/// [`FractureError`].
pub fn shatter(
    body: &Piece,
    energy_density: &[f64],
    strain_energy: f64,
    settings: &PatternSettings,
) -> Result<Option<Shatter>, FractureError> {
    let Some(pattern) = draw_pattern(&body.mesh, energy_density, strain_energy, settings)? else {
        return Ok(None);
    };
    Ok(afforded(split_by_regions(body, &pattern.region)?, strain_energy, settings))
}

/// Breaks a body along the planes that it was scored with, all of them at once. `None` if they do not divide
/// it, or cost more than the strain energy \[J\] pays for.
///
/// # Errors
/// [`FractureError`].
pub fn shatter_along(
    body: &Piece,
    scores: &[Score],
    strain_energy: f64,
    settings: &PatternSettings,
) -> Result<Option<Shatter>, FractureError> {
    settings.check()?;
    if !(strain_energy >= 0.0 && strain_energy.is_finite()) {
        return Err(FractureError::Setting { setting: "strain energy", value: strain_energy });
    }
    Ok(afforded(split_by_scores(body, scores)?, strain_energy, settings))
}

fn afforded(split: Option<Split>, strain_energy: f64, settings: &PatternSettings) -> Option<Shatter> {
    let Split { pieces, crack_faces } = split?;
    let area: f64 = crack_faces.iter().map(|f| f.area_vector().length()).sum();
    let fracture_energy = settings.fracture_energy * area;
    // The pattern has counted the same area in another order.
    let affordable = settings.efficiency * strain_energy * (1.0 + 1e-12);
    (fracture_energy <= affordable).then_some(Shatter { pieces, crack_faces, strain_energy, fracture_energy })
}

/// Why a body cannot be broken.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FractureError {
    /// A number makes no sense.
    #[error("{setting} = {value:e} is not possible for a fracture")]
    Setting {
        /// Which number.
        setting: &'static str,
        /// Its value.
        value: f64,
    },
    /// Lists do not fit.
    #[error("there are {got} {what}, but {wanted} are needed")]
    Counts {
        /// Of what.
        what: &'static str,
        /// How many there are.
        got: usize,
        /// How many there should be.
        wanted: usize,
    },
    /// Its material does not say how strong or how tough it is.
    #[error("material \"{material}\" has no {number}")]
    Unknown {
        /// The material.
        material: String,
        /// Which number.
        number: &'static str,
    },
    /// Its material is not elastic.
    #[error(transparent)]
    Elastic(#[from] ElasticError),
    /// Its stress cannot be computed.
    #[error(transparent)]
    Stress(#[from] ElastostaticsError),
    /// The impact that breaks it makes no sense.
    #[error(transparent)]
    ContactLoad(#[from] ContactError),
    /// A piece cannot collide.
    #[error("one of its pieces {0}")]
    Collision(&'static str),
    /// The cracks give impulses that are no numbers.
    #[error(transparent)]
    Impulse(#[from] NoImpulse),
    /// The body falls into parts that do not hang together before it breaks.
    #[error("the body has {0} parts that do not hang together; only one body at a time can break")]
    Parts(usize),
    /// Tetrahedra without volume.
    #[error("the body or its pieces have no valid tetrahedra: {0}")]
    Mesh(#[from] TetMeshError),
    /// A surface that is not closed.
    #[error("the body or its pieces are not closed: {0}")]
    Surface(#[from] MeshError),
    /// A surface that touches itself at a vertex.
    #[error(
        "the surface touches itself at {position}, where two parts of it meet in one vertex; remesh the body"
    )]
    Pinched {
        /// Where \[m\].
        position: DVec3,
    },
}
