//! Rows of contact lists that are the steps of one contact: an engine with soft contacts writes its force at
//! each of them, and each row sounds as an impact of its own.
//!
//! ```text
//! rows of one pair at t, t + h, t + 2h, …      at least five, h ≤ 20 ms, equal to 1 %
//! ```
//!
//! Two bodies that really meet so often do not meet at even intervals. Rows that share an `impact_id` are one
//! impact already.

use std::collections::BTreeMap;
use std::fmt;

use clangor_core::body::{BodyId, World};
use clangor_core::timeline::ContactKind;

use crate::formats::contact_list::ListedContact;

/// Fewest instants of a series, its longest interval \[s\], and how much that may differ, over it.
const FEWEST: u64 = 5;
const LONGEST: f64 = 0.02;
const EVEN: f64 = 0.01;

/// The longest series of a list, for people.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StepsNotice {
    bodies: [String; 2],
    /// Instants of the longest series, its interval \[s\] and its first row.
    count: u64,
    interval: f64,
    row: usize,
    /// How many series there are.
    all: u64,
}

/// Instants of a pair at even intervals, so far.
#[derive(Clone, Copy)]
struct Series {
    row: usize,
    count: u64,
    time: f64,
    interval: f64,
    impact_id: u64,
}

/// Finds the series of rows, which come in order of time.
pub(crate) fn contact_steps(world: &World, rows: &[ListedContact]) -> Option<StepsNotice> {
    let mut open: BTreeMap<[BodyId; 2], Series> = BTreeMap::new();
    let mut longest: Option<([BodyId; 2], Series)> = None;
    let mut all = 0;
    for ListedContact { line, row, .. } in rows.iter().filter(|listed| listed.row.kind == ContactKind::Impact)
    {
        let pair = [row.body_a.min(row.body_b), row.body_a.max(row.body_b)];
        let (time, impact_id) = (row.time, row.impact_id);
        let first = Series { row: *line, count: 1, time, interval: 0.0, impact_id };
        let Some(series) = open.get_mut(&pair) else {
            open.insert(pair, first);
            continue;
        };
        let step = time - series.time;
        let is_one = impact_id > 0 && impact_id == series.impact_id;
        if step == 0.0 && !is_one {
            continue;
        }
        let is_even = series.count == 1 || (step / series.interval - 1.0).abs() < EVEN;
        if is_one || step > LONGEST || !is_even {
            *series = first;
            continue;
        }
        *series = Series { count: series.count + 1, time, interval: step, impact_id, ..*series };
        all += u64::from(series.count == FEWEST);
        if series.count >= FEWEST && longest.is_none_or(|(_, longest)| series.count > longest.count) {
            longest = Some((pair, *series));
        }
    }
    let (pair, Series { row, count, interval, .. }) = longest?;
    let name = |id: BodyId| world.bodies.get(id.index()).map_or_else(|| "world".into(), |b| b.name.clone());
    Some(StepsNotice { bodies: pair.map(name), count, interval, row, all })
}

impl fmt::Display for StepsNotice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let StepsNotice { bodies: [one, other], count, interval, row, all } = self;
        let series = if *all > 1 { format!(", the longest of {all} series") } else { String::new() };
        write!(
            f,
            "row {row}: {one} and {other} have {count} impacts at intervals of {:.3} ms{series}: steps of \
             one contact, as an engine writes them, and each sounds as an impact of its own; give the rows \
             of one contact the same impact_id, or list the sum of their impulses once",
            1e3 * interval
        )
    }
}

#[cfg(test)]
mod tests {
    use clangor_core::timeline::ContactRow;
    use glam::DVec3;

    use super::*;

    fn series_of(times: impl IntoIterator<Item = f64>, id: u64) -> Option<(u64, usize)> {
        let world = World { bodies: Vec::new(), links: Vec::new(), gravity: DVec3::ZERO };
        let row = |(line, time): (usize, f64)| {
            let row = ContactRow {
                time,
                body_a: BodyId(0),
                body_b: BodyId(1),
                kind: ContactKind::Impact,
                point: DVec3::ZERO,
                normal: DVec3::Y,
                impulse_n: 0.1,
                impulse_t: DVec3::ZERO,
                couple: DVec3::ZERO,
                velocity: -DVec3::Y,
                depth: 0.0,
                impact_id: id,
                effective_mass: None,
            };
            ListedContact { line, row, names_second: true }
        };
        let rows: Vec<ListedContact> = times.into_iter().enumerate().map(row).collect();
        contact_steps(&world, &rows).map(|notice| (notice.count, notice.row))
    }

    #[test]
    fn steps_of_one_contact_are_seen_and_bounces_are_not() {
        let steps = |k: u32| 0.319 + 0.001 * f64::from(k);
        assert_eq!(series_of((0..19).map(steps), 0), Some((19, 0)));
        assert_eq!(series_of((0..19).map(steps), 1), None);
        // Four corners at each step.
        assert_eq!(series_of((0..40).map(|k| steps(k / 4)), 0), Some((10, 0)));
        // Bounces that become shorter.
        assert_eq!(series_of((0..30).map(|k| 0.3 - 0.3 * 0.9_f64.powi(k)), 0), None);
    }
}
