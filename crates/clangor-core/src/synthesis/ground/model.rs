//! Ground models that can be a source.

use std::sync::Arc;

use super::source::GroundSource;
use crate::reference::SlabSource;

/// A model of the ground.
#[derive(Clone, Debug, PartialEq)]
pub enum Ground {
    /// An elastic half-space.
    HalfSpace(Arc<GroundSource>),
    /// A paper's ground model.
    Reference(Arc<SlabSource>),
}

impl From<Arc<GroundSource>> for Ground {
    fn from(ground: Arc<GroundSource>) -> Self {
        Ground::HalfSpace(ground)
    }
}
