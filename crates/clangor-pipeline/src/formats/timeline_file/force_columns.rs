//! The two tables of forces: one row per force, and the samples of their shapes.
//!
//! Shapes follow one another in the table of samples. A row names its shape by first sample and length;
//! several rows may name the same one.

use std::collections::BTreeMap;
use std::sync::Arc;

use clangor_core::body::Life;
use clangor_core::timeline::ForceRow;
use glam::DVec3;

use super::columns::{Column, Field, TableRow, double, float};
use super::error::RowProblem;

/// A force as the file holds it; the fields are those of [`ForceRow`].
#[derive(Clone, Copy)]
pub(super) struct StoredForce {
    pub(super) time: f64,
    pub(super) impact_id: u64,
    pub(super) point: DVec3,
    pub(super) impulse: DVec3,
    pub(super) duration: f64,
    pub(super) modal_gain: f64,
    pub(super) start: f64,
    pub(super) step: f64,
    /// Place of the first sample among all samples.
    pub(super) first_sample: u64,
    /// Number of samples.
    pub(super) samples: u32,
}

impl StoredForce {
    /// The row with these samples [1/s].
    pub(super) fn with(&self, values: Arc<[f32]>) -> ForceRow {
        ForceRow {
            time: self.time,
            impact_id: self.impact_id,
            point: self.point,
            impulse: self.impulse,
            duration: self.duration,
            modal_gain: self.modal_gain,
            start: self.start,
            step: self.step,
            values,
        }
    }
}

impl TableRow for StoredForce {
    fn columns() -> Vec<Column<Self>> {
        vec![
            double!("t", time),
            Column { name: "impact_id", field: Field::U64(|r| r.impact_id, |r, v| r.impact_id = v) },
            float!("point_x", point.x),
            float!("point_y", point.y),
            float!("point_z", point.z),
            float!("impulse_x", impulse.x),
            float!("impulse_y", impulse.y),
            float!("impulse_z", impulse.z),
            double!("duration", duration),
            double!("modal_gain", modal_gain),
            double!("start", start),
            double!("step", step),
            Column { name: "first_sample", field: Field::U64(|r| r.first_sample, |r, v| r.first_sample = v) },
            Column { name: "samples", field: Field::U32(|r| r.samples, |r, v| r.samples = v) },
        ]
    }

    const BLANK: Self = StoredForce {
        time: 0.0,
        impact_id: 0,
        point: DVec3::ZERO,
        impulse: DVec3::ZERO,
        duration: 0.0,
        modal_gain: 0.0,
        start: 0.0,
        step: 0.0,
        first_sample: 0,
        samples: 0,
    };

    fn time(&self) -> f64 {
        self.time
    }

    fn stored(&self) -> Self {
        *self
    }

    /// The whole row is checked with its samples, when there are.
    fn check(&self, _: &[Life]) -> Result<(), RowProblem> {
        Ok(())
    }
}

/// A sample of a shape [1/s].
#[derive(Clone, Copy)]
pub(super) struct StoredSample {
    pub(super) value: f64,
}

impl TableRow for StoredSample {
    fn columns() -> Vec<Column<Self>> {
        vec![float!("value", value)]
    }

    const BLANK: Self = StoredSample { value: 0.0 };

    /// Samples have no time of their own.
    fn time(&self) -> f64 {
        0.0
    }

    fn stored(&self) -> Self {
        *self
    }

    fn check(&self, _: &[Life]) -> Result<(), RowProblem> {
        Ok(())
    }
}

/// Joins rows and samples, as the tables are read.
pub(super) struct ShapeReader {
    samples: Vec<f32>,
    /// Shapes so far, by first sample.
    shapes: BTreeMap<u64, Arc<[f32]>>,
    /// Where the next new shape begins.
    next: u64,
}

impl ShapeReader {
    /// With all samples.
    pub(super) fn new(samples: Vec<f32>) -> Self {
        ShapeReader { samples, shapes: BTreeMap::new(), next: 0 }
    }

    /// The next row with its samples, checked. Shapes neither overlap nor leave gaps, so that a file cannot
    /// ask for more memory than it has samples.
    pub(super) fn join(&mut self, row: &StoredForce) -> Result<ForceRow, RowProblem> {
        let StoredForce { first_sample: first, samples: count, .. } = *row;
        let unknown = RowProblem::Samples { first, count, samples: self.samples.len() as u64 };
        let known = self.shapes.get(&first).filter(|values| values.len() == count as usize);
        let values = match known {
            Some(values) => Arc::clone(values),
            None if first == self.next => {
                let place = usize::try_from(first).unwrap_or(usize::MAX);
                let end = place.saturating_add(count as usize);
                let Some(values) = self.samples.get(place..end) else { return Err(unknown) };
                let values: Arc<[f32]> = values.into();
                self.next += u64::from(count);
                self.shapes.insert(first, Arc::clone(&values));
                values
            }
            None => return Err(unknown),
        };
        let force = row.with(values);
        force.check()?;
        Ok(force)
    }
}
