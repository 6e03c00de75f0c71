//! The log: raw solver rows become impacts and a force stream.
//!
//! An impact is all impulses of one pair of bodies whose times follow each other by at most [`MERGE_WINDOW`]. Its
//! speed is the approach speed before its first instant, the maximum over that instant's points; an impact slower than
//! `v_min` is not one, and its rows join the force stream of resting, sliding and rolling contact. A contact-phase
//! row that approaches faster than `v_min` starts an impact too. The force stream is written only on request.

use std::collections::BTreeMap;

use clangor::body::BodyId;
use clangor::timeline::{ContactKind, ContactRow, PoseRow, TimelineSink};

use crate::SimulationReport;

/// Impulses of a pair that follow each other within this time are one impact [s].
pub const MERGE_WINDOW: f64 = 0.5e-3;

/// What is logged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordSettings {
    /// Impacts slower than this relative normal speed are dropped [m/s]; \[PAN\] §4.3 uses 5 cm/s.
    pub v_min: f64,
    /// Poses per second and body [Hz].
    pub pose_rate: f64,
    /// Every row of the solver is written, not only kept impacts.
    pub raw: bool,
}

impl Default for RecordSettings {
    fn default() -> Self {
        RecordSettings { v_min: 0.05, pose_rate: 1000.0, raw: false }
    }
}

/// Collects a solver's rows, merges impacts, and passes on what the settings ask for.
pub struct Recorder<'a> {
    settings: RecordSettings,
    sink: &'a mut dyn TimelineSink,
    open: BTreeMap<(BodyId, BodyId), OpenImpact>,
    next_id: u64,
    report: SimulationReport,
}

/// An impact that later rows may still join.
struct OpenImpact {
    rows: Vec<ContactRow>,
    poses: Vec<PoseRow>,
    speed: f64,
    last: f64,
}

impl<'a> Recorder<'a> {
    /// A recorder that writes into `sink`.
    pub fn new(settings: RecordSettings, sink: &'a mut dyn TimelineSink) -> Self {
        Recorder { settings, sink, open: BTreeMap::new(), next_id: 1, report: SimulationReport::default() }
    }

    /// The settings.
    pub fn settings(&self) -> &RecordSettings {
        &self.settings
    }

    /// Takes the rows of one impact: one pair of bodies (A and B in the same order in every row), one instant, one
    /// or more points. `poses` are the states of its moving bodies at that instant, before the impulse.
    pub fn impact(&mut self, rows: &[ContactRow], poses: &[PoseRow]) {
        let Some(first) = rows.first() else { return };
        let speed = rows.iter().map(ContactRow::approach_speed).fold(0.0, f64::max);
        for row in rows {
            self.report.deepest_overlap = self.report.deepest_overlap.max(row.depth);
        }
        let open = self.open.entry((first.body_a, first.body_b)).or_insert_with(|| OpenImpact {
            rows: Vec::new(),
            poses: Vec::new(),
            speed: 0.0,
            last: first.time,
        });
        if open.rows.is_empty() {
            open.poses.extend_from_slice(poses);
        }
        if open.rows.first().is_none_or(|r| r.time == first.time) {
            open.speed = open.speed.max(speed);
        }
        open.last = first.time;
        open.rows.extend_from_slice(rows);
    }

    /// Takes the rows of one pair's lasting contact in one step. Rows that approach faster than `v_min` are an impact.
    pub fn contact(&mut self, rows: &[ContactRow], poses: &[PoseRow]) -> std::io::Result<()> {
        if rows.iter().any(|r| r.kind == ContactKind::Contact && r.approach_speed() > self.settings.v_min) {
            self.impact(rows, poses);
            return Ok(());
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

    /// Takes a pose at the pose rate.
    pub fn pose(&mut self, row: &PoseRow) -> std::io::Result<()> {
        self.sink.pose(row)
    }

    /// Tells that no row before `time` will follow: closes the impacts that are over.
    pub fn advance(&mut self, time: f64) -> std::io::Result<()> {
        let over: Vec<_> =
            self.open.iter().filter(|(_, o)| time - o.last > MERGE_WINDOW).map(|(k, _)| *k).collect();
        let mut closed: Vec<OpenImpact> = over.iter().filter_map(|k| self.open.remove(k)).collect();
        closed.sort_by(|a, b| a.rows[0].time.total_cmp(&b.rows[0].time));
        for impact in closed {
            self.close(impact)?;
        }
        Ok(())
    }

    /// Closes everything and reports.
    pub fn finish(mut self, time: f64) -> std::io::Result<SimulationReport> {
        self.advance(f64::INFINITY)?;
        self.report.time = time;
        Ok(self.report)
    }

    fn close(&mut self, impact: OpenImpact) -> std::io::Result<()> {
        let kept = impact.speed >= self.settings.v_min;
        if kept {
            self.report.impacts += 1;
        } else {
            self.report.dropped_impacts += 1;
        }
        if !kept && !self.settings.raw {
            return Ok(());
        }
        let id = if kept { self.next_id } else { 0 };
        self.next_id += u64::from(kept);
        if kept {
            for pose in &impact.poses {
                self.sink.pose(pose)?;
            }
        }
        for row in &impact.rows {
            self.write(&ContactRow { impact_id: id, ..*row })?;
        }
        Ok(())
    }

    fn write(&mut self, row: &ContactRow) -> std::io::Result<()> {
        self.report.rows += 1;
        self.sink.contact(row)
    }
}
