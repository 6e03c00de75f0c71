//! Errors of a fracture.

use clangor_bake::fem::ElasticError;
use clangor_bake::mesh::tetrahedra::TetMeshError;
use clangor_bake::stress::ElastostaticsError;
use clangor_core::contact::ContactError;
use clangor_core::geometry::solid::MeshError;
use clangor_core::glam::DVec3;

/// Why a body cannot be broken.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FractureError {
    /// A setting is out of range.
    #[error("{setting} = {value:e} is not possible for a fracture")]
    Setting {
        /// Which number.
        setting: &'static str,
        /// Its value.
        value: f64,
    },
    /// Lists have different lengths.
    #[error("there are {got} {what}, but {wanted} are needed")]
    Counts {
        /// What was counted.
        what: &'static str,
        /// Number present.
        got: usize,
        /// Number needed.
        wanted: usize,
    },
    /// The material has no strength or no toughness.
    #[error("material \"{material}\" has no {number}")]
    Unknown {
        /// The material.
        material: String,
        /// Which number.
        number: &'static str,
    },
    /// The material has no valid elastic constants.
    #[error(transparent)]
    Elastic(#[from] ElasticError),
    /// The stress cannot be computed.
    #[error(transparent)]
    Stress(#[from] ElastostaticsError),
    /// The impact that loads the body is invalid.
    #[error(transparent)]
    ContactLoad(#[from] ContactError),
    /// A piece has no valid collision shape.
    #[error("one of its pieces {0}")]
    Collision(&'static str),
    /// The impulses of the cracks cannot be computed.
    #[error(transparent)]
    Impulse(#[from] NoImpulse),
    /// The body is not connected before it breaks.
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

/// Why the impulses of a crack cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoImpulse {
    /// The crack consumed all energy.
    #[error("the crack leaves {0:.3e} J for the motion of the pieces")]
    NoSurplus(f64),
    /// The faces of the crack carried no stress.
    #[error("the crack runs where the body carries no load")]
    NoTraction,
    /// Lists have different lengths.
    #[error("a crack face names {what} {index}, but there are {count}")]
    Missing {
        /// Kind of item.
        what: &'static str,
        /// Its index.
        index: usize,
        /// Number present.
        count: usize,
    },
    /// A mass, an inertia or a stress is not finite, or an inertia cannot be inverted.
    #[error("a stress, a mass or an inertia is not finite or zero")]
    NotFinite,
}
