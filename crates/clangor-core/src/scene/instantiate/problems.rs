//! Errors and warnings of an instantiation, collected so that all are reported at once.

use crate::scene::diagnostic::{Doubt, Place, Problem, SceneError, SceneWarning};

/// Collects errors and warnings.
#[derive(Default)]
pub(super) struct Problems {
    pub(super) errors: Vec<SceneError>,
    pub(super) warnings: Vec<SceneWarning>,
}

impl Problems {
    pub(super) fn error(&mut self, place: Place, problem: Problem) {
        self.errors.push(SceneError { place, problem });
    }

    pub(super) fn warn(&mut self, place: Place, doubt: Doubt) {
        let warning = SceneWarning { place, doubt };
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }

    /// A warning of a geometry, at the first body that has it.
    pub(super) fn warn_once(&mut self, place: Place, doubt: Doubt) {
        if !self.warnings.iter().any(|warning| warning.doubt == doubt) {
            self.warnings.push(SceneWarning { place, doubt });
        }
    }
}
