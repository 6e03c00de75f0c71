//! Impacts of a recording that is too long for memory, found in parts of time that overlap.
//!
//! ```text
//! part n        [-- overlap --|-------------- length --------------|-- overlap --]
//! part n + 1                                          [-- overlap --|---------- ...
//! joined                                                   ^ where both parts found the same
//! ```
//!
//! The search is local in time: its thresholds look at five frames on both sides, an impact takes jumps
//! within two frames, and each of the few rounds that begin with clean impacts sees what the one before left.
//! What two parts find in their overlap is therefore the same, but for their ends. They
//! are joined at the middle of the overlap if they agree in its inner half, otherwise where they agree
//! nearest to it. Impacts are then those of a search in the whole recording, which tests compare row by
//! row; the search itself does not prove it, and counts the joints at which the parts did not agree.

use std::collections::BTreeMap;

use clangor_core::body::{BodyId, World};
use clangor_core::timeline::{ContactRow, PoseRow};

use super::impacts::{MotionImpacts, find_impacts_in_noise};
use super::lasting_contacts::lasting_contacts;
use super::nested_bodies::NestedBodies;
use super::open_joints::OpenJoints;
use super::recording::RecordedBody;
use super::sunk_bodies::SunkBodies;

/// A stretch of time in which impacts are searched \[s\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part {
    /// First instant; 0 for the first part.
    pub(crate) from: f64,
    /// Where the next part begins; infinite for the last.
    pub(crate) to: f64,
    /// How far the frames reach beyond both ends.
    pub(crate) overlap: f64,
}

impl Part {
    /// The part after this one.
    pub(crate) fn next(self) -> Self {
        Part { from: self.to, to: self.to + (self.to - self.from), overlap: self.overlap }
    }

    /// Up to where its impacts are final before the next part is searched.
    pub(crate) fn final_to(self) -> f64 {
        self.to - 0.5 * self.overlap
    }

    /// Where parts are compared before a joint.
    fn compared(joint: f64, overlap: f64) -> [f64; 2] {
        [joint - 0.5 * overlap, joint + 0.5 * overlap]
    }
}

/// The impacts of one part after the other, numbered in order of time.
#[derive(Debug, Default)]
pub(crate) struct PartSearch {
    /// What the part before found around its end.
    tail: Option<MotionImpacts>,
    /// Impacts so far.
    impacts: u64,
    /// Joints at which the parts did not agree.
    pub(crate) doubtful_joints: u64,
    /// Bodies that lie too deep in planes.
    pub(crate) sunk: SunkBodies,
    /// Bodies that lie too deep in each other.
    pub(crate) nested: NestedBodies,
    /// Bodies that leave their joints.
    pub(crate) open_joints: OpenJoints,
    /// Deviation of Δv on one axis of each body that is noise [m/s].
    noise: Vec<f64>,
    /// Rows of lasting contact, if they are wanted.
    lasting: Option<Lasting>,
}

/// What rows of lasting contact need to go on.
#[derive(Debug, Default)]
struct Lasting {
    /// Rows of the impacts before the part that its first frames may share.
    recent: Vec<ContactRow>,
    /// Where the next rows begin \[s\].
    from: f64,
}

impl PartSearch {
    /// A search of impacts, and of lasting contacts too if they are wanted, of bodies with this `noise`: the
    /// deviation of Δv on one axis [m/s].
    pub(crate) fn new(noise: Vec<f64>, logs_lasting: bool) -> Self {
        PartSearch { noise, lasting: logs_lasting.then(Lasting::default), ..PartSearch::default() }
    }

    /// The impacts of a part, up to [`Part::final_to`] and after those of the parts before. Parts follow each
    /// other; `recorded` has the frames of this one with its overlaps.
    pub(crate) fn search(
        &mut self,
        world: &World,
        recorded: &[RecordedBody],
        v_min: f64,
        part: Part,
    ) -> MotionImpacts {
        let found = find_impacts_in_noise(world, recorded, v_min, &self.noise);
        self.sunk.look(world, recorded, &found.soft);
        self.nested.look(world, recorded);
        self.open_joints.look(world, recorded);
        let mut joint = f64::NEG_INFINITY;
        let mut rows = MotionImpacts::default();
        if let Some(tail) = self.tail.take() {
            joint = joint_of(&tail, &found, part.from, part.overlap).unwrap_or_else(|| {
                self.doubtful_joints += 1;
                part.from
            });
            self.append(&mut rows, &between(&tail, f64::NEG_INFINITY, joint));
        }
        self.append(&mut rows, &between(&found, joint, part.final_to()));
        if part.to.is_finite() {
            let [from, to] = Part::compared(part.to, part.overlap);
            self.tail = Some(between(&found, from.max(joint), to));
        }
        if let Some(lasting) = &mut self.lasting {
            let later = between(&found, part.final_to(), f64::INFINITY).contacts;
            lasting.log((world, recorded, &self.noise), (&mut rows.contacts, later), part);
        }
        rows
    }

    /// Adds rows with the next numbers of impacts.
    fn append(&mut self, rows: &mut MotionImpacts, found: &MotionImpacts) {
        let mut numbers: BTreeMap<u64, u64> = BTreeMap::new();
        for row in &found.contacts {
            let mut row = *row;
            if row.impact_id != 0 {
                row.impact_id = *numbers.entry(row.impact_id).or_insert_with(|| {
                    self.impacts += 1;
                    self.impacts
                });
            }
            rows.contacts.push(row);
        }
        let confidence = |(old, new): (u64, u64)| Some((new, *found.confidence.get(&old)?));
        rows.confidence.extend(numbers.into_iter().filter_map(confidence));
        rows.states.extend_from_slice(&found.states);
        rows.untouched.extend_from_slice(&found.untouched);
        rows.soft.extend_from_slice(&found.soft);
    }
}

impl Lasting {
    /// Puts the lasting contacts of a part among its rows, in the place of those that held a body up in a
    /// jump; `later` are rows after the end of the part.
    fn log(
        &mut self,
        (world, recorded, noise): (&World, &[RecordedBody], &[f64]),
        (rows, later): (&mut Vec<ContactRow>, Vec<ContactRow>),
        part: Part,
    ) {
        rows.retain(|row| row.impact_id != 0);
        let impacts = [self.recent.as_slice(), rows, &later].concat();
        let span = [self.from, part.final_to()];
        rows.extend(lasting_contacts(world, recorded, noise, &impacts, span));
        rows.sort_by(|a, b| a.time.total_cmp(&b.time));
        self.from = part.final_to();
        let is_recent = |row: &ContactRow| row.impact_id != 0 && row.time >= part.to - part.overlap;
        self.recent = rows.iter().copied().filter(is_recent).collect();
    }
}

/// What was found from one instant until before another.
fn between(found: &MotionImpacts, from: f64, to: f64) -> MotionImpacts {
    let contacts = rows_between(&found.contacts, |row| row.time, from, to).to_vec();
    let confidence = |row: &ContactRow| Some((row.impact_id, *found.confidence.get(&row.impact_id)?));
    MotionImpacts {
        confidence: contacts.iter().filter_map(confidence).collect(),
        contacts,
        states: rows_between(&found.states, |row| row.time, from, to).to_vec(),
        untouched: rows_between(&found.untouched, |(_, time)| *time, from, to).to_vec(),
        soft: rows_between(&found.soft, |push| push.time, from, to).to_vec(),
    }
}

fn rows_between<T>(rows: &[T], time: impl Fn(&T) -> f64, from: f64, to: f64) -> &[T] {
    let place = |instant: f64| rows.partition_point(|row| time(row) < instant);
    let (from, to) = (place(from), place(to));
    &rows[from..to.max(from)]
}

/// Where two parts are joined: nearest to the middle of what both have searched, with the same rows before
/// and after it; `None` if there is no such instant.
fn joint_of(earlier: &MotionImpacts, later: &MotionImpacts, middle: f64, overlap: f64) -> Option<f64> {
    let [from, to] = Part::compared(middle, overlap);
    let both = [earlier, later].map(|found| between(found, from, to));
    let mut times: Vec<f64> = both.iter().flat_map(times).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let agrees = |time: f64| {
        let [a, b] = both.each_ref().map(|found| between(found, time, time.next_up()));
        is_same(&a, &b)
    };
    let agreeing: Vec<bool> = times.iter().map(|time| agrees(*time)).collect();
    if agreeing.iter().all(|agrees| *agrees) {
        return Some(middle);
    }
    let instants = times.windows(2).zip(agreeing.windows(2));
    let joints = instants.filter(|(_, agrees)| agrees[0] && agrees[1]).map(|(w, _)| 0.5 * (w[0] + w[1]));
    joints.min_by(|a, b| (a - middle).abs().total_cmp(&(b - middle).abs()))
}

fn times(found: &MotionImpacts) -> Vec<f64> {
    let rows = found.contacts.iter().map(|row| row.time);
    rows.chain(found.states.iter().map(|row| row.time))
        .chain(found.untouched.iter().map(|(_, t)| *t))
        .collect()
}

/// Whether two searches found the same, whatever the numbers of their impacts.
fn is_same(a: &MotionImpacts, b: &MotionImpacts) -> bool {
    let unnumbered = |row: &ContactRow| ContactRow { impact_id: u64::from(row.impact_id != 0), ..*row };
    let contacts = |found: &MotionImpacts| found.contacts.iter().map(unnumbered).collect::<Vec<ContactRow>>();
    let rest = |found: &MotionImpacts| -> (Vec<PoseRow>, Vec<(BodyId, f64)>) {
        (found.states.clone(), found.untouched.clone())
    };
    contacts(a) == contacts(b) && rest(a) == rest(b)
}
