//! Errors and warnings of an instantiation, collected so that all are reported at once.

use std::collections::HashSet;

use crate::scene::diagnostic::{Doubt, Place, Problem, SceneError, SceneWarning};

/// Collects errors and warnings.
#[derive(Default)]
pub(super) struct Problems {
    pub(super) errors: Vec<SceneError>,
    pub(super) warnings: Vec<SceneWarning>,
    /// What has been warned of: the start of its place and its text; of geometries the text alone.
    warned: HashSet<(Option<usize>, String)>,
}

impl Problems {
    pub(super) fn error(&mut self, place: Place, problem: Problem) {
        self.errors.push(SceneError { place, problem });
    }

    pub(super) fn warn(&mut self, place: Place, doubt: Doubt) {
        if self.warned.insert((Some(place.span.start), doubt.to_string())) {
            self.warnings.push(SceneWarning { place, doubt });
        }
    }

    /// A warning of a geometry, at the first body that has it.
    pub(super) fn warn_once(&mut self, place: Place, doubt: Doubt) {
        if self.warned.insert((None, doubt.to_string())) {
            self.warnings.push(SceneWarning { place, doubt });
        }
    }
}
