//! Writing the forces of a timeline.

use std::path::Path;
use std::sync::Arc;

use clangor_core::timeline::{FORCE_REACH, ForceRow};

use super::description::TableFields;
use super::error::TimelineError;
use super::files::{FORCES_FILE, SAMPLES_FILE};
use super::force_columns::{StoredForce, StoredSample};
use super::table::writer::TableWriter;

/// How many earlier shapes are compared with that of a row.
const REMEMBERED: usize = 16;

/// Writes both tables of forces.
pub(super) struct ForceWriter {
    forces: TableWriter<StoredForce>,
    samples: TableWriter<StoredSample>,
    /// The latest shapes, and where they begin.
    recent: Vec<(Arc<[f32]>, u64)>,
}

impl ForceWriter {
    /// Creates the files in a folder; `slack` is how far rows of contacts may be out of order \[s\].
    pub(super) fn create(folder: &Path, slack: f64) -> Result<Self, TimelineError> {
        Ok(ForceWriter {
            forces: TableWriter::create(&folder.join(FORCES_FILE), Vec::new(), force_slack(slack))?,
            samples: TableWriter::create(&folder.join(SAMPLES_FILE), Vec::new(), 0.0)?,
            recent: Vec::new(),
        })
    }

    /// Appends a row.
    pub(super) fn push(&mut self, row: &ForceRow) -> Result<(), TimelineError> {
        row.check().map_err(|problem| self.forces.refused(problem.into()))?;
        let known = self.recent.iter().find(|(values, _)| Arc::ptr_eq(values, &row.values));
        let first_sample = match known {
            Some((_, first)) => *first,
            None => {
                let first = self.samples.rows();
                for value in row.values.iter() {
                    self.samples.push(&StoredSample { value: f64::from(*value) })?;
                }
                if self.recent.len() == REMEMBERED {
                    self.recent.remove(0);
                }
                self.recent.push((Arc::clone(&row.values), first));
                first
            }
        };
        self.forces.push(&StoredForce {
            time: row.time,
            impact_id: row.impact_id,
            point: row.point,
            impulse: row.impulse,
            duration: row.duration,
            modal_gain: row.modal_gain,
            start: row.start,
            step: row.step,
            first_sample,
            // Forces are at most 2 s long, in steps of 0.1 µs at least.
            samples: row.values.len() as u32,
        })
    }

    /// Completes the files: the fields of forces and samples.
    pub(super) fn finish(self) -> Result<[TableFields; 2], TimelineError> {
        Ok([self.forces.finish()?, self.samples.finish()?])
    }
}

/// How far rows of forces may be out of order \[s\], if those of contacts may be by `slack`: a force is known
/// when its contact ends.
pub(super) fn force_slack(slack: f64) -> f64 {
    slack + FORCE_REACH
}
