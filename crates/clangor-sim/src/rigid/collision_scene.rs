//! The bodies and pairs that the collision phase works on.

use super::broad_phase::Neighbours;
use super::compliance::Compliance;
use super::linkage::Linkages;
use super::pair::{Pair, PairScratch, Step};
use super::shape::Shape;
use super::spring_balance::SpringBalance;
use super::state::BodyState;
use super::step_log::StepLog;

/// State that the collision phase reads and changes.
pub(super) struct Scene<'a> {
    pub(super) bodies: &'a mut [BodyState],
    pub(super) pairs: &'a mut [Pair],
    pub(super) neighbours: &'a Neighbours,
    pub(super) shapes: &'a [Shape],
    pub(super) linkages: &'a Linkages,
    pub(super) step: Step,
    pub(super) scratch: &'a mut PairScratch,
    pub(super) log: &'a mut StepLog,
    /// Takes the work of reactions.
    pub(super) balance: &'a mut SpringBalance,
    /// Modes of the bodies, where impacts are solved with them.
    pub(super) compliance: Option<Compliance<'a>>,
}
