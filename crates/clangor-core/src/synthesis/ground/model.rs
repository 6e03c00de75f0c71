//! Ground models that can be a source.

use std::sync::Arc;

use super::plate::PlateSource;
use super::source::GroundSource;
use crate::reference::SlabSource;

/// A model of the ground.
#[derive(Clone, Debug, PartialEq)]
pub enum Ground {
    /// An elastic half-space.
    HalfSpace(Arc<GroundSource>),
    /// A thin endless plate.
    Plate(Arc<PlateSource>),
    /// A paper's ground model.
    Reference(Arc<SlabSource>),
}

impl From<Arc<GroundSource>> for Ground {
    fn from(ground: Arc<GroundSource>) -> Self {
        Ground::HalfSpace(ground)
    }
}

impl From<Arc<PlateSource>> for Ground {
    fn from(plate: Arc<PlateSource>) -> Self {
        Ground::Plate(plate)
    }
}
