//! The impulses of one step with their exact arms, in groups of one pair and one instant.

use std::ops::Range;

use clangor_core::body::BodyId;
use clangor_core::contact::LoadHistory;
use clangor_core::timeline::{ContactKind, ContactRow, PoseRow};
use glam::DVec3;

use super::state::Instant;

/// One impulse and the arms at which it acted, about the centres of mass.
///
/// The momentum of A changes by `row.impulse()`, its angular momentum about the centre of mass by
/// `arm_a × row.impulse() + row.couple`; those of B by the opposite impulse and couple with `arm_b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impulse {
    /// The row of the timeline.
    pub row: ContactRow,
    /// From the centre of mass of A to the point \[m\].
    pub arm_a: DVec3,
    /// From the centre of mass of B to the point \[m\].
    pub arm_b: DVec3,
}

/// An impulse on body A at one contact point.
pub(super) struct ContactImpulse {
    /// Contact point \[m\].
    pub(super) point: DVec3,
    /// Unit normal from B to A.
    pub(super) normal: DVec3,
    /// Overlap \[m\].
    pub(super) depth: f64,
    /// Normal impulse \[N s\].
    pub(super) impulse_n: f64,
    /// Tangential impulse \[N s\].
    pub(super) impulse_t: DVec3,
    /// Couple impulse \[N m s\].
    pub(super) couple: DVec3,
    /// Velocity of A relative to B at the point before the impulse \[m/s\].
    pub(super) velocity: DVec3,
    /// Of bodies on joints: that with the reactions of the joints \[kg\].
    pub(super) effective_mass: Option<f64>,
}

impl Impulse {
    /// An impulse on body `a` and its opposite on body `b`, each body given with its arm \[m\].
    pub(super) fn between(
        (a, arm_a): (u32, DVec3),
        (b, arm_b): (u32, DVec3),
        kind: ContactKind,
        time: f64,
        impulse: ContactImpulse,
    ) -> Self {
        let ContactImpulse { point, normal, depth, impulse_n, impulse_t, couple, velocity, effective_mass } =
            impulse;
        let row = ContactRow {
            time,
            body_a: BodyId(a),
            body_b: BodyId(b),
            kind,
            point,
            normal,
            impulse_n,
            impulse_t,
            couple,
            velocity,
            depth,
            impact_id: 0,
            effective_mass,
        };
        Impulse { row, arm_a, arm_b }
    }
}

/// The impulses of one pair at one instant, and the poses of its moving bodies before them.
pub(super) struct Group {
    pub(super) kind: ContactKind,
    pub(super) rows: Range<usize>,
    pub(super) poses: Range<usize>,
    pub(super) solved: bool,
}

/// The impulses of one pair at one instant.
#[derive(Clone, Copy, Debug)]
pub struct PairImpulses<'l> {
    /// What they are.
    pub kind: ContactKind,
    /// Their rows.
    pub rows: &'l [ContactRow],
    /// Poses of the moving bodies before them.
    pub poses: &'l [PoseRow],
    /// Whether they are those of a solve of the contacts.
    pub solved: bool,
}

/// What a solved impact does to one of its bodies over time.
#[derive(Clone, Debug, PartialEq)]
pub struct SolvedLoad {
    /// Number of the solve in its step.
    pub solve: usize,
    /// The body before the impact.
    pub state: PoseRow,
    /// Forces and stored energy from the time of `state` on.
    pub history: LoadHistory,
}

/// The impulses of one step.
#[derive(Default)]
pub struct StepLog {
    impulses: Vec<Impulse>,
    rows: Vec<ContactRow>,
    poses: Vec<PoseRow>,
    groups: Vec<Group>,
    loads: Vec<SolvedLoad>,
    skip_slower: Option<f64>,
}

impl StepLog {
    /// A log of every impulse.
    pub fn new() -> Self {
        StepLog::default()
    }

    /// A log without the rows of lasting contacts that approach slower than `speed` \[m/s\].
    pub fn without_slow_contacts(speed: f64) -> Self {
        StepLog { skip_slower: Some(speed), ..StepLog::default() }
    }

    /// The impulses of the last step.
    pub fn impulses(&self) -> &[Impulse] {
        &self.impulses
    }

    pub(super) fn clear(&mut self) {
        self.impulses.clear();
        self.rows.clear();
        self.poses.clear();
        self.groups.clear();
        self.loads.clear();
    }

    /// The approach speed \[m/s\] below which contact rows are skipped.
    pub(super) fn skips_slower(&self) -> Option<f64> {
        self.skip_slower
    }

    pub(super) fn begin(&mut self, kind: ContactKind) {
        self.groups.push(Group {
            kind,
            rows: self.rows.len()..self.rows.len(),
            poses: self.poses.len()..self.poses.len(),
            solved: false,
        });
    }

    /// The group that began last comes from a solve of the contacts.
    pub(super) fn mark_solved(&mut self) {
        if let Some(group) = self.groups.last_mut() {
            group.solved = true;
        }
    }

    pub(super) fn pose(&mut self, time: f64, body: usize, instant: &Instant) {
        self.poses.push(instant.pose_row(time, body));
    }

    /// What a solved impact does to each of its bodies.
    pub(super) fn solved_loads(&mut self, loads: impl Iterator<Item = (PoseRow, LoadHistory)>) {
        let solve = self.loads.last().map_or(0, |last| last.solve + 1);
        self.loads.extend(loads.map(|(state, history)| SolvedLoad { solve, state, history }));
    }

    pub(super) fn impulse(&mut self, impulse: Impulse) {
        self.impulses.push(impulse);
        self.rows.push(impulse.row);
    }

    /// Writes the impulse of a link on body A, and its opposite on B, each given with its arm \[m\]; no B is
    /// the world. `velocity` is that of A relative to B at the point.
    pub(super) fn link(
        &mut self,
        time: f64,
        [(a, arm_a), (b, arm_b)]: [(Option<usize>, DVec3); 2],
        (point, velocity): (DVec3, DVec3),
        (impulse, couple): (DVec3, DVec3),
    ) {
        let id = |body: Option<usize>| body.map_or(BodyId::WORLD, |body| BodyId(body as u32));
        let row = ContactRow {
            time,
            body_a: id(a),
            body_b: id(b),
            kind: ContactKind::Constraint,
            point,
            normal: impulse.normalize_or_zero(),
            impulse_n: impulse.length(),
            impulse_t: DVec3::ZERO,
            couple,
            velocity,
            depth: 0.0,
            impact_id: 0,
            effective_mass: None,
        };
        self.begin(ContactKind::Constraint);
        self.impulse(Impulse { row, arm_a, arm_b });
        self.end();
    }

    /// Scales an impulse.
    pub(super) fn scale(&mut self, place: usize, factor: f64) {
        if let Some(impulse) = self.impulses.get_mut(place) {
            impulse.row.impulse_n *= factor;
            impulse.row.impulse_t *= factor;
            impulse.row.couple *= factor;
            self.rows[place] = impulse.row;
        }
    }

    pub(super) fn end(&mut self) {
        if let Some(group) = self.groups.last_mut() {
            group.rows.end = self.rows.len();
            group.poses.end = self.poses.len();
        }
    }

    /// The impulses of each pair at each instant, in the order of their times.
    pub fn groups(&self) -> impl Iterator<Item = PairImpulses<'_>> {
        self.groups.iter().map(|group| PairImpulses {
            kind: group.kind,
            rows: &self.rows[group.rows.clone()],
            poses: &self.poses[group.poses.clone()],
            solved: group.solved,
        })
    }

    /// What solved impacts do to their bodies, where [`followed`](super::ContactModes::followed) is set.
    pub fn loads(&self) -> &[SolvedLoad] {
        &self.loads
    }
}
