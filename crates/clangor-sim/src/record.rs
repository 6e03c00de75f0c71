//! The log: raw solver rows become impacts and a force stream.
//!
//! An impact is all impulses of one pair of bodies within [`MERGE_WINDOW`] of its first instant. Its speed is
//! the approach speed before that instant, the maximum over the instant's points. Rows of impacts slower than
//! `v_min` belong to the force stream of resting, sliding and rolling contact, and a slow impact never
//! absorbs a faster one. A contact-phase row that approaches faster than `v_min` also starts an impact. The
//! force stream is written only on request.

mod time_order;

use std::collections::BTreeMap;

use clangor_core::body::{Body, BodyId};
use clangor_core::timeline::{ContactKind, ContactRow, FractureRow, PoseRow, TimelineSink};

use crate::SimulationReport;
use time_order::TimeOrder;

/// Impulses of a pair within this time of the first are one impact \[s\].
pub const MERGE_WINDOW: f64 = 0.5e-3;

/// Which rows and poses are logged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordSettings {
    /// Impacts slower than this relative normal speed are dropped \[m/s\]; \[PAN\] §4.3 uses 5 cm/s.
    pub v_min: f64,
    /// Poses per second and body \[Hz\]; with 0, poses are written only at impacts.
    pub pose_rate: f64,
    /// Every row of the solver is written, not only kept impacts.
    pub raw: bool,
}

impl Default for RecordSettings {
    fn default() -> Self {
        RecordSettings { v_min: 0.05, pose_rate: 1000.0, raw: false }
    }
}

/// Collects a solver's rows, merges impacts, and writes those that the settings select to the sink.
pub struct Recorder<'a> {
    settings: RecordSettings,
    sink: &'a mut dyn TimelineSink,
    open: BTreeMap<(BodyId, BodyId), OpenImpact>,
    next_id: u64,
    report: SimulationReport,
    order: TimeOrder,
    struck: BTreeMap<BodyId, PoseRow>,
}

/// A recorder between two of its sinks: the impacts that later rows may still join, and the counts so far.
#[derive(Default)]
pub struct Suspended {
    open: BTreeMap<(BodyId, BodyId), OpenImpact>,
    last_id: u64,
    report: SimulationReport,
    order: TimeOrder,
    /// States of the bodies that impacts of the latest instant have struck, before all of them.
    struck: BTreeMap<BodyId, PoseRow>,
}

/// An impact that later rows may still join.
struct OpenImpact {
    rows: Vec<ContactRow>,
    poses: Vec<PoseRow>,
    speed: f64,
    start: f64,
}

impl<'a> Recorder<'a> {
    /// A recorder that writes into `sink`.
    pub fn new(settings: RecordSettings, sink: &'a mut dyn TimelineSink) -> Self {
        Recorder::resume(settings, Suspended::default(), sink)
    }

    /// Continues from a suspended recorder, with a new sink.
    pub fn resume(settings: RecordSettings, from: Suspended, sink: &'a mut dyn TimelineSink) -> Self {
        let Suspended { open, last_id, report, order, struck } = from;
        Recorder { settings, sink, open, next_id: last_id + 1, report, order, struck }
    }

    /// Releases the sink; open impacts stay open.
    pub fn suspend(self) -> Suspended {
        let Recorder { open, next_id, report, order, struck, .. } = self;
        Suspended { open, last_id: next_id - 1, report, order, struck }
    }

    /// The settings.
    pub fn settings(&self) -> &RecordSettings {
        &self.settings
    }

    /// Records the rows of one impact: one pair of bodies (A and B in the same order in every row), one
    /// instant, one or more points. `poses` are the states of its moving bodies at that instant, before the
    /// impulse. Those before all impacts of that instant are kept: they show where a chain of touching bodies
    /// is struck.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn impact(&mut self, rows: &[ContactRow], poses: &[PoseRow]) -> std::io::Result<()> {
        let Some(first) = rows.first() else { return Ok(()) };
        let speed = rows.iter().map(ContactRow::approach_speed).fold(0.0, f64::max);
        for row in rows {
            self.report.deepest_overlap = self.report.deepest_overlap.max(row.depth);
        }
        let pair = (first.body_a, first.body_b);
        let v_min = self.settings.v_min;
        let poses: Vec<PoseRow> = poses.iter().map(|pose| self.before_instant(pose)).collect();
        let joins = self
            .open
            .get(&pair)
            .is_some_and(|o| first.time - o.start <= MERGE_WINDOW && (o.speed >= v_min || speed < v_min));
        if joins && let Some(open) = self.open.get_mut(&pair) {
            if first.time == open.start {
                open.speed = open.speed.max(speed);
            }
            open.rows.extend_from_slice(rows);
            return Ok(());
        }
        let impact = OpenImpact { rows: rows.to_vec(), poses, speed, start: first.time };
        match self.open.insert(pair, impact) {
            Some(over) => self.close(over),
            None => Ok(()),
        }
    }

    /// The state of a body before all impacts of an instant, of its state before one of them.
    fn before_instant(&mut self, pose: &PoseRow) -> PoseRow {
        if self.struck.values().next().is_some_and(|earlier| earlier.time != pose.time) {
            self.struck.clear();
        }
        *self.struck.entry(pose.body).or_insert(*pose)
    }

    /// Records the rows of one pair's lasting contact in one step. Rows that approach faster than `v_min`
    /// become an impact.
    pub fn contact(&mut self, rows: &[ContactRow], poses: &[PoseRow]) -> std::io::Result<()> {
        if rows.iter().any(|r| r.kind == ContactKind::Contact && r.approach_speed() > self.settings.v_min) {
            return self.impact(rows, poses);
        }
        for row in rows {
            self.report.deepest_overlap = self.report.deepest_overlap.max(row.depth);
        }
        if self.settings.raw {
            for row in rows {
                self.write(row)?;
            }
        }
        Ok(())
    }

    /// Whether the caller may skip building rows of lasting contacts that approach slower than `v_min`.
    pub fn ignores_slow_contacts(&self) -> bool {
        !self.settings.raw
    }

    /// Time between two poses of a body \[s\]; infinite if none are wanted.
    pub fn pose_interval(&self) -> f64 {
        if self.settings.pose_rate > 0.0 { 1.0 / self.settings.pose_rate } else { f64::INFINITY }
    }

    /// Records a pose at the pose rate.
    pub fn pose(&mut self, row: &PoseRow) -> std::io::Result<()> {
        self.order.pose(row, self.sink)
    }

    /// From now on, rows and poses are written in the order of their times. `since` is the earliest time
    /// \[s\] that a row or pose may still have: now, or the onset of a contact that lasts. Without a call
    /// they are written as they come, an impact when it is over.
    pub(crate) fn keep_order(&mut self, since: f64) -> std::io::Result<()> {
        let before = self.open.values().map(|open| open.start).fold(since, f64::min);
        self.order.release(before, self.sink)
    }

    /// Records a fracture, its pieces, and the impulses of its cracks; the impulses between the same two
    /// pieces form one impact.
    pub fn fracture(
        &mut self,
        row: &FractureRow,
        pieces: &[Body],
        mut cracks: Vec<ContactRow>,
    ) -> std::io::Result<()> {
        self.report.fractures += 1;
        self.report.births += pieces.len() as u64;
        self.sink.fracture(row, pieces)?;
        cracks.sort_by_key(|crack| (crack.body_a, crack.body_b));
        for same in cracks.chunk_by(|a, b| (a.body_a, a.body_b) == (b.body_a, b.body_b)) {
            for crack in same {
                self.write(&ContactRow { impact_id: self.next_id, ..*crack })?;
            }
            self.next_id += 1;
        }
        Ok(())
    }

    /// Closes the impacts that have ended by `time` \[s\]; only contacts that last may still have earlier
    /// rows.
    pub fn advance(&mut self, time: f64) -> std::io::Result<()> {
        let over: Vec<_> =
            self.open.iter().filter(|(_, o)| time - o.start > MERGE_WINDOW).map(|(k, _)| *k).collect();
        let mut closed: Vec<OpenImpact> = over.iter().filter_map(|k| self.open.remove(k)).collect();
        closed.sort_by(|a, b| a.rows[0].time.total_cmp(&b.rows[0].time));
        for impact in closed {
            self.close(impact)?;
        }
        Ok(())
    }

    /// Counts an event of the sphere solver.
    pub(crate) fn count_event(&mut self) {
        self.report.events += 1;
    }

    /// Counts impacts whose contacts were solved, and those that could not be.
    #[cfg(feature = "rigid")]
    pub(crate) fn count_solves(&mut self, (solved, fallen_back): (u64, u64)) {
        self.report.solved += solved;
        self.report.fallen_back += fallen_back;
    }

    /// Closes everything and reports.
    pub fn finish(mut self, time: f64) -> std::io::Result<SimulationReport> {
        self.advance(f64::INFINITY)?;
        self.order.release(f64::INFINITY, self.sink)?;
        self.report.time = time;
        Ok(self.report)
    }

    fn close(&mut self, impact: OpenImpact) -> std::io::Result<()> {
        let kept = impact.speed >= self.settings.v_min;
        if kept {
            self.report.impacts += 1;
        } else {
            self.report.dropped_impacts += 1;
            let bodies = impact.rows.first().map_or([BodyId::WORLD; 2], |r| [r.body_a, r.body_b]);
            for body in bodies.into_iter().filter(|b| *b != BodyId::WORLD) {
                let counts = &mut self.report.dropped_by_body;
                counts.resize(counts.len().max(body.index() + 1), 0);
                counts[body.index()] += 1;
            }
        }
        if !kept && !self.settings.raw {
            return Ok(());
        }
        let id = if kept { self.next_id } else { 0 };
        self.next_id += u64::from(kept);
        if kept {
            for pose in &impact.poses {
                self.order.pose(pose, self.sink)?;
            }
        }
        for row in &impact.rows {
            self.write(&ContactRow { impact_id: id, ..*row })?;
        }
        Ok(())
    }

    fn write(&mut self, row: &ContactRow) -> std::io::Result<()> {
        self.report.rows += 1;
        self.order.contact(row, self.sink)
    }
}

#[cfg(test)]
mod tests {
    use clangor_core::glam::DVec3;
    use clangor_core::timeline::Timeline;

    use super::*;

    fn row(time: f64, speed: f64) -> ContactRow {
        ContactRow {
            time,
            body_a: BodyId(0),
            body_b: BodyId::WORLD,
            kind: ContactKind::Impact,
            point: DVec3::ZERO,
            normal: DVec3::Y,
            impulse_n: speed,
            impulse_t: DVec3::ZERO,
            couple: DVec3::ZERO,
            velocity: DVec3::NEG_Y * speed,
            depth: 0.0,
            impact_id: 0,
            effective_mass: None,
        }
    }

    fn record(rows: &[ContactRow], raw: bool) -> (Timeline, SimulationReport) {
        let mut timeline = Timeline::default();
        let mut recorder = Recorder::new(RecordSettings { raw, ..RecordSettings::default() }, &mut timeline);
        for r in rows {
            recorder.impact(&[*r], &[]).unwrap();
            recorder.advance(r.time).unwrap();
        }
        let report = recorder.finish(1.0).unwrap();
        (timeline, report)
    }

    #[test]
    fn repeats_within_the_window_are_one_impact_and_keep_their_rows() {
        let (timeline, report) = record(&[row(0.1, 1.0), row(0.1003, 0.02), row(0.1006, 0.2)], false);
        let ids: Vec<u64> = timeline.contacts.iter().map(|r| r.impact_id).collect();
        assert_eq!(ids, [1, 1, 2]);
        assert_eq!((report.impacts, report.rows), (2, 3));
    }

    #[test]
    fn a_slow_touch_does_not_swallow_the_impact_after_it() {
        let (timeline, report) = record(&[row(0.1, 0.01), row(0.1002, 0.5)], false);
        assert_eq!(timeline.contacts.len(), 1);
        assert_eq!((report.impacts, report.dropped_impacts), (1, 1));
        assert_eq!(report.dropped_by_body, [1]);
        let (raw, _) = record(&[row(0.1, 0.01), row(0.1002, 0.5)], true);
        assert_eq!(raw.contacts.iter().map(|r| r.impact_id).collect::<Vec<_>>(), [0, 1]);
    }
}
