//! A vibrating body, and what drives it.

use std::sync::Arc;

use clangor_core::body::BodyId;
use clangor_core::contact::ImpactPulse;
use clangor_core::synthesis::modal::{ModalSource, ModalState};

/// A vibrating body, and what drives it.
pub(super) struct StruckSource {
    pub(super) body: BodyId,
    pub(super) source: Arc<ModalSource>,
    /// The impacts on it.
    pub(super) impacts: Vec<ImpactPulse>,
    /// What it takes over from the body that it was part of.
    pub(super) handed: Option<ModalState>,
}
