//! What numbers of a description must be, with the place where they stand in every refusal.

use std::path::Path;

use clangor_core::body::BodyId;
use clangor_core::quantity::{Quantity, readable};

use crate::formats::timeline_file::error::TimelineError;

/// What a description is checked against.
pub(super) struct Checks<'a> {
    path: &'a Path,
    /// Number of bodies.
    count: usize,
}

impl<'a> Checks<'a> {
    pub(super) fn new(path: &'a Path, count: usize) -> Self {
        Checks { path, count }
    }

    pub(super) fn positive(&self, name: &str, value: f64) -> Result<(), TimelineError> {
        if value > 0.0 { Ok(()) } else { Err(self.field(name, format!("is {value}, not positive"))) }
    }

    pub(super) fn not_negative(&self, name: &str, value: f64) -> Result<(), TimelineError> {
        if value >= 0.0 { Ok(()) } else { Err(self.field(name, format!("is {value}, not zero or more"))) }
    }

    /// Refuses a number outside the range that scenes have too.
    pub(super) fn quantity(&self, name: &str, value: f64, range: Quantity) -> Result<(), TimelineError> {
        if range.admits(value) {
            return Ok(());
        }
        Err(self.field(name, format!("is {}, not {}", readable(value), range.expected())))
    }

    /// Refuses a vector with a component outside a range.
    pub(super) fn vector(&self, name: &str, vector: [f64; 3], range: Quantity) -> Result<(), TimelineError> {
        vector.into_iter().try_for_each(|component| self.quantity(name, component, range))
    }

    pub(super) fn body_id(&self, name: &str, body: u32) -> Result<BodyId, TimelineError> {
        let problem = || format!("is {body}, but there are {} bodies", self.count);
        Some(BodyId(body)).filter(|id| id.index() < self.count).ok_or_else(|| self.field(name, problem()))
    }

    pub(super) fn field(&self, name: &str, problem: String) -> TimelineError {
        TimelineError::Field { path: self.path.into(), field: name.into(), problem }
    }
}
