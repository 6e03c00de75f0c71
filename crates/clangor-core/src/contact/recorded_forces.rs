//! Forces of impacts as a timeline carries them: from pulses to rows and back.
//!
//! ```text
//! pulses ─► rows (one per point and direction)
//! rows, points of the impact ─► shapes with the impulses of the points ─► pulses
//! ```
//!
//! Rows give the shapes; the impulses stay those of the contact rows. A row belongs to the point of the
//! impact that lies nearest to it, within 1 % of the size of the smaller body, and of points at one place to
//! that whose impulse points its way. What a point's impulse is more than its rows say goes with the
//! strongest of them. A point without rows has the shape of the sum of all normal forces.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;

use super::ContactError;
use super::force_history::ForceHistory;
use super::force_shape::ForceShape;
use super::impact::Impact;
use super::impact_pulse::ImpactPulse;
use super::impact_solver::SolvedForce;
use crate::timeline::ForceRow;

/// Largest distance of a row from its point, over the size of the smaller body.
const ONE_PLACE: f64 = 1e-2;
/// Distances that count as equal, over the size of the smaller body.
const SAME_DISTANCE: f64 = 1e-4;

/// The forces over time among pulses, in order of the pulses. Closed profiles have none, nor have pulses
/// outside numbered impacts.
pub fn force_rows(pulses: &[ImpactPulse]) -> Vec<ForceRow> {
    let mut rows = Vec::new();
    for pulse in pulses.iter().filter(|pulse| pulse.impact_id != 0) {
        let ForceShape::History(history) = &pulse.shape else { continue };
        let values: Arc<[f32]> = history.values().iter().map(|value| *value as f32).collect();
        let modal_gain = pulse.bodies.iter().flatten().map(|share| share.modal_gain).fold(1.0, f64::min);
        rows.extend(pulse.points.iter().map(|(point, impulse)| ForceRow {
            time: pulse.time,
            impact_id: pulse.impact_id,
            point: *point,
            impulse: *impulse,
            duration: pulse.duration,
            modal_gain,
            start: history.start(),
            step: history.step(),
            values: Arc::clone(&values),
        }));
    }
    rows
}

/// The recorded forces of a timeline, by impact.
pub(super) struct RecordedForces<'a> {
    rows: BTreeMap<u64, Vec<&'a ForceRow>>,
}

/// A shape that forces share.
struct SharedShape<'a> {
    row: &'a ForceRow,
    history: Arc<ForceHistory>,
}

impl<'a> RecordedForces<'a> {
    /// Checks all rows.
    pub(super) fn new(forces: &'a [ForceRow]) -> Result<Self, ContactError> {
        let mut rows: BTreeMap<u64, Vec<&ForceRow>> = BTreeMap::new();
        for row in forces {
            let located = |problem| ContactError::Force { impact_id: row.impact_id, time: row.time, problem };
            row.check().map_err(located)?;
            rows.entry(row.impact_id).or_default().push(row);
        }
        Ok(RecordedForces { rows })
    }

    /// The forces of an impact; `None` if none are recorded.
    pub(super) fn of(&self, impact: &Impact) -> Option<Vec<SolvedForce>> {
        let rows = self.rows.get(&impact.impact_id).filter(|_| impact.impact_id != 0)?;
        // Rows with the same shape share one history.
        let mut shapes: Vec<SharedShape<'_>> = Vec::new();
        let mut shape_of = Vec::with_capacity(rows.len());
        for row in rows {
            let found = shapes.iter().position(|shape| has_shape(shape.row, row));
            shape_of.push(match found {
                Some(at) => at,
                None => {
                    shapes.push(SharedShape { row, history: Arc::new(history_of(row)?) });
                    shapes.len() - 1
                }
            });
        }
        // The rows of each point.
        let mut rows_at: Vec<Vec<usize>> = vec![Vec::new(); impact.points.len()];
        for (index, row) in rows.iter().enumerate() {
            if let Some(point) = point_of(impact, row) {
                rows_at[point].push(index);
            }
        }
        let mut sum: Option<Arc<ForceHistory>> = None;
        let mut forces = Vec::with_capacity(rows.len());
        for (at, (point, own)) in impact.points.iter().zip(&rows_at).enumerate() {
            let strength = |index: &usize| rows[*index].impulse.length_squared();
            let Some(strongest) = own
                .iter()
                .copied()
                .reduce(|best, other| if strength(&other) > strength(&best) { other } else { best })
            else {
                if sum.is_none() {
                    sum = Some(Arc::new(sum_of(impact, &shapes, rows, &shape_of)?));
                }
                forces.push(SolvedForce {
                    point: at,
                    impulse: point.impulse,
                    couple: point.couple,
                    history: Arc::clone(sum.as_ref()?),
                    end: rows.iter().map(|row| row.duration).fold(0.0, f64::max),
                    modal_gain: rows.iter().map(|row| row.modal_gain).fold(1.0, f64::min),
                });
                continue;
            };
            let rest = point.impulse - own.iter().map(|index| rows[*index].impulse).sum::<DVec3>();
            forces.extend(own.iter().map(|&index| {
                let is_strongest = index == strongest;
                let (rest, couple) = if is_strongest { (rest, point.couple) } else { Default::default() };
                SolvedForce {
                    point: at,
                    impulse: rows[index].impulse + rest,
                    couple,
                    history: Arc::clone(&shapes[shape_of[index]].history),
                    end: rows[index].duration,
                    modal_gain: rows[index].modal_gain,
                }
            }));
        }
        Some(forces)
    }
}

/// Whether two rows have the same shape, duration and factor on the modes.
fn has_shape(a: &ForceRow, b: &ForceRow) -> bool {
    let numbers = |row: &ForceRow| [row.start, row.step, row.duration, row.modal_gain];
    numbers(a) == numbers(b) && (Arc::ptr_eq(&a.values, &b.values) || a.values == b.values)
}

/// The shape of a row, of unit impulse.
fn history_of(row: &ForceRow) -> Option<ForceHistory> {
    let area = row.area();
    let values = row.values.iter().map(|value| f64::from(*value) / area).collect();
    ForceHistory::restored(row.start, row.step, values)
}

/// Index of the point of the impact at which a row acts.
fn point_of(impact: &Impact, row: &ForceRow) -> Option<usize> {
    let [a, b] = &impact.sides;
    let size = a.bounding_radius.min(b.bounding_radius);
    let distance = |index: &usize| impact.points[*index].place.distance(row.point);
    let along = |index: &usize| impact.points[*index].impulse.normalize_or_zero().dot(row.impulse);
    let near: Vec<usize> =
        (0..impact.points.len()).filter(|index| distance(index) <= ONE_PLACE * size).collect();
    let least = near.iter().map(distance).fold(f64::INFINITY, f64::min);
    let nearest = near.into_iter().filter(|index| distance(index) <= least + SAME_DISTANCE * size);
    nearest.max_by(|a, b| along(a).total_cmp(&along(b)))
}

/// The shape of the sum of all normal forces, on the finest of their grids; that of the first row if they
/// have no sum.
fn sum_of(
    impact: &Impact,
    shapes: &[SharedShape<'_>],
    rows: &[&ForceRow],
    shape_of: &[usize],
) -> Option<ForceHistory> {
    let mut weights = vec![0.0; shapes.len()];
    for (row, shape) in rows.iter().zip(shape_of) {
        weights[*shape] += row.impulse.dot(impact.normal);
    }
    let histories = || shapes.iter().map(|shape| &shape.history);
    let step = histories().map(|history| history.step()).fold(f64::INFINITY, f64::min);
    let start = histories().map(|history| history.extent().0).fold(f64::INFINITY, f64::min);
    let end = histories().map(|history| history.extent().1).fold(f64::NEG_INFINITY, f64::max);
    let count = ((end - start) / step).round() as usize;
    let value = |k: usize| {
        let time = start + k as f64 * step;
        weights.iter().zip(histories()).map(|(weight, history)| weight * history.value(time)).sum::<f64>()
    };
    let values: Vec<f64> = (0..count).map(value).collect();
    let area = step * values.iter().sum::<f64>();
    let scaled = values.into_iter().map(|value| value / area).collect();
    let of_sum = (area > 0.0).then(|| ForceHistory::restored(start, step, scaled)).flatten();
    of_sum.or_else(|| history_of(rows.first()?))
}
