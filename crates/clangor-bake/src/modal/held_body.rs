//! The modes of a body with what holds it.
//!
//! | body | modes |
//! |---|---|
//! | nothing holds it | those of the free body, without its six motions as a whole |
//! | supports hold it in place, or keyframes move it with them | all, those that were rigid among them |
//! | supports move freely with it | without the six lowest, which the dynamics already has |
//!
//! The last is right if the supports hardly bend the body: the six lowest are then its motions as a whole,
//! and the others carry no momentum. So their frequencies must be [`SOFT`] of the next at most.

use std::ops::ControlFlow;

use super::Effort;
use crate::fem::ElasticConstants;
use crate::fem::supports::{Support, SupportError};
use crate::geometry_class::bake_geometry::BakeGeometry;
use crate::modal_analysis::eigensolver::ModalError;
use crate::modal_analysis::{
    ModalAnalysis, ModalAnalysisError, ModalAnalysisOptions, ModalAnalysisProgress, draft_modal_analysis,
    draft_supported_modal_analysis, modal_analysis, supported_modal_analysis,
};

/// Motions of a whole body.
const RIGID_MOTIONS: usize = 6;
/// Highest frequency of the motions of a whole free body on its supports, over that of its first own mode.
pub const SOFT: f64 = 1.0 / 3.0;

/// Factor on the limit of a search that found no more than the motions of the whole body.
const WIDER: f64 = 2.0;

/// What holds a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Held<'a> {
    /// Its supports; empty for a free body.
    pub supports: &'a [Support],
    /// Whether body and supports move freely: its motion as a whole is then not among the modes.
    pub moves_freely: bool,
}

impl Held<'_> {
    /// All modes up to the limit of the options.
    ///
    /// # Errors
    /// [`ModalAnalysisError`].
    pub(super) fn modes(
        &self,
        geometry: &BakeGeometry,
        (constants, effort): (&ElasticConstants, Effort),
        options: &ModalAnalysisOptions,
        progress: &mut dyn FnMut(&ModalAnalysisProgress) -> ControlFlow<()>,
    ) -> Result<ModalAnalysis, ModalAnalysisError> {
        let supports = self.supports;
        let mut find = |options: &ModalAnalysisOptions| match (supports.is_empty(), effort) {
            (true, Effort::Exact) => modal_analysis(geometry, constants, options, progress),
            (true, Effort::Draft) => draft_modal_analysis(geometry, constants, options, progress),
            (false, Effort::Exact) => {
                supported_modal_analysis(geometry, constants, supports, options, progress)
            }
            (false, Effort::Draft) => {
                draft_supported_modal_analysis(geometry, constants, supports, options, progress)
            }
        };
        if supports.is_empty() || !self.moves_freely {
            return find(options);
        }
        // The first mode that is no motion of the whole may lie above the limit.
        let mut wider = *options;
        let found = loop {
            match find(&wider) {
                Ok(found) if found.modes.len() > RIGID_MOTIONS => break found,
                Ok(_) | Err(ModalAnalysisError::Modes(ModalError::Silent { .. })) => {
                    wider.max_frequency *= WIDER;
                }
                Err(error) => return Err(error),
            }
        };
        without_rigid_motions(found, options.max_frequency)
    }
}

/// The modes of more than the rigid motions, up to a limit \[Hz\].
fn without_rigid_motions(mut found: ModalAnalysis, limit: f64) -> Result<ModalAnalysis, ModalAnalysisError> {
    let [whole, first] = [RIGID_MOTIONS - 1, RIGID_MOTIONS].map(|k| found.modes[k].frequency);
    if whole > SOFT * first {
        return Err(SupportError::Stiff { whole, first }.into());
    }
    found.modes.drain(..RIGID_MOTIONS);
    found.modes.retain(|mode| mode.frequency < limit);
    found.max_frequency = limit;
    match found.modes.is_empty() {
        true => Err(ModalError::Silent { first, limit }.into()),
        false => Ok(found),
    }
}
