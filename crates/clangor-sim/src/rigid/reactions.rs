//! Reactions: how the bodies of a linkage share an impulse on one of them.
//!
//! An impulse P on a linkage calls up reactions λ in its joints that keep all blocked velocities as they are:
//!
//! `J M⁻¹ (P + Jᵀ λ) = 0`, so `λ = −A⁺ J M⁻¹ P` with `A = J M⁻¹ Jᵀ`.
//!
//! J has one row for each blocked direction (`joint`), M⁻¹ the inverse masses and inertias. The
//! pseudo-inverse A⁺ also serves rows that say the same, as those of two hinges of a door. Contacts are
//! solved against bodies that react in this way, so that a joint is as hard in an impact as at rest.
//!
//! [`Reactions::settle`] closes the joints: impulses along the present rows, by Newton's method, such that
//! the joints are exact at the middle of the *next* step. This is SHAKE (Ryckaert, Ciccotti and Berendsen
//! 1977) on the midpoints, which is symplectic: the energy of a pendulum oscillates by (ω Δt)² and does not
//! drift.
//!
//! A rope is a row whose impulse only pulls. Differs from contacts: it becomes taut at the middle of a step.

use std::ops::Range;

use clangor_core::pose::Pose;
use faer::{Mat, Side};
use glam::DVec3;

use super::joint::{Blocked, PlacedEnds};
use super::linkage::Linkages;
use super::mover::Mover;
use super::step_log::StepLog;

/// Eigenvalues of the scaled A below this are those of rows that say the same.
const REDUNDANT: f64 = 1e-9;
/// Joints that are closer than this are closed \[m, or rad\].
const CLOSED: f64 = 1e-13;
/// Rounds of Newton's method at most. Seen: 3 for single joints, 20 for ropes between linkages.
const MOST_ROUNDS: u32 = 40;
/// A rope that is shorter than its length by less than this resists an impact \[m\].
const TAUT: f64 = 1e-6;

/// A row of a joint, and the impulse along it so far.
struct Row {
    joint: usize,
    blocked: Blocked,
    /// The two ends among the movers.
    ends: [Option<usize>; 2],
    impulse: f64,
}

/// A rope, and how much a unit impulse along it changes the velocity of its length \[1/kg\].
struct Rope {
    row: Row,
    inverse_mass: f64,
    taut: bool,
}

/// Rows of one linkage and the pseudo-inverse of A, by columns.
struct Solved {
    rows: Range<usize>,
    inverse: Vec<f64>,
}

/// An impulse at the centre of mass of a mover, and an angular impulse.
pub(super) type Kick = (usize, DVec3, DVec3);

/// The joints of some linkages at one instant.
#[derive(Default)]
pub(super) struct Reactions {
    rows: Vec<Row>,
    ropes: Vec<Rope>,
    solved: Vec<Solved>,
    /// Linkage of each mover, among `solved`.
    of_mover: Vec<Option<usize>>,
    placed: Vec<(usize, PlacedEnds)>,
}

/// The total impulse of a joint on its near body.
pub(super) struct JointImpulse {
    joint: usize,
    /// The two ends among the movers.
    pub(super) ends: [Option<usize>; 2],
    /// From the centres of mass to the joint \[m\].
    pub(super) arms: [DVec3; 2],
    /// At the joint \[N s\].
    pub(super) impulse: DVec3,
    /// In addition to that of the impulse \[N m s\].
    pub(super) couple: DVec3,
}

impl Row {
    /// Velocity along the row.
    fn rate(&self, movers: &[Mover]) -> f64 {
        let of = |end: usize, sign: f64| {
            self.ends[end].map_or(0.0, |mover| {
                let Mover { velocity, spin, .. } = movers[mover];
                sign * (self.blocked.along.dot(velocity) + self.blocked.turning[end].dot(spin))
            })
        };
        of(0, 1.0) + of(1, -1.0)
    }

    /// What a unit impulse along the row does to each end.
    fn kicks(&self, impulse: f64) -> impl Iterator<Item = Kick> {
        let kick = move |end: usize, sign: f64| {
            let Blocked { along, turning } = self.blocked;
            self.ends[end].map(|mover| (mover, along * (sign * impulse), turning[end] * (sign * impulse)))
        };
        [kick(0, 1.0), kick(1, -1.0)].into_iter().flatten()
    }

    fn push(&mut self, movers: &mut [Mover], impulse: f64) {
        self.impulse += impulse;
        for (mover, linear, angular) in self.kicks(impulse) {
            movers[mover].push(linear, angular);
        }
    }
}

impl Reactions {
    /// Sets up the joints of these linkages. `place` gives the pose of a body and its number among the
    /// movers.
    pub(super) fn set_up(
        &mut self,
        linkages: &Linkages,
        chosen: impl Iterator<Item = usize>,
        place: &dyn Fn(usize) -> (Pose, usize),
        movers: &[Mover],
    ) {
        self.rows.clear();
        self.ropes.clear();
        self.solved.clear();
        self.placed.clear();
        self.of_mover.clear();
        self.of_mover.resize(movers.len(), None);
        for linkage in chosen {
            let first = self.rows.len();
            for &body in linkages.bodies_of(linkage) {
                self.of_mover[place(body).1] = Some(self.solved.len());
            }
            let mut ropes = Vec::new();
            for &index in linkages.joints_of(linkage) {
                let joint = &linkages.joints[index];
                let placed = joint.placed(&|body| place(body).0);
                let blocked = joint.blocked(&placed);
                let ends = joint.ends.map(|end| end.body.map(|body| place(body).1));
                let taut = joint.errors(&placed, &blocked).iter().any(|error| *error > -TAUT);
                let rows = blocked.iter().map(|&blocked| Row { joint: index, blocked, ends, impulse: 0.0 });
                match joint.is_rope() {
                    true => ropes.extend(rows.map(|row| Rope { row, inverse_mass: 0.0, taut })),
                    false => self.rows.extend(rows),
                }
                self.placed.push((index, placed));
            }
            let rows = first..self.rows.len();
            self.solved.push(Solved { inverse: pseudo_inverse(&self.rows[rows.clone()], movers), rows });
            for mut rope in ropes {
                rope.inverse_mass = self.own_response(movers, &rope.row);
                self.ropes.push(rope);
            }
        }
    }

    /// Whether a mover belongs to a linkage.
    pub(super) fn holds(&self, mover: usize) -> bool {
        self.of_mover.get(mover).is_some_and(Option::is_some)
    }

    /// Whether there are no joints.
    pub(super) fn is_empty(&self) -> bool {
        self.solved.is_empty()
    }

    /// Applies the reactions to impulses that the movers have already felt.
    pub(super) fn react(&mut self, movers: &mut [Mover], kicks: &[Kick]) {
        for slot in self.slots(kicks) {
            let reactions = self.reactions(movers, slot, kicks);
            for (row, impulse) in self.rows[self.solved[slot].rows.clone()].iter_mut().zip(reactions) {
                row.push(movers, impulse);
            }
        }
    }

    /// Velocity of A relative to B at a contact after a unit impulse `along` on A and its opposite on B, each
    /// given with its arm, reactions included.
    pub(super) fn response(&self, movers: &[Mover], ends: [(usize, DVec3); 2], along: DVec3) -> DVec3 {
        let kicks = [(0, 1.0), (1, -1.0)].map(|(end, sign)| {
            let (mover, arm): (usize, DVec3) = ends[end];
            (mover, along * sign, arm.cross(along) * sign)
        });
        let felt = |end: usize| {
            let (mover, arm) = ends[end];
            self.felt(movers, mover, &kicks).velocity_at(arm)
        };
        felt(0) - felt(1)
    }

    /// A mover, at rest before, after these impulses and the reactions to them.
    fn felt(&self, movers: &[Mover], mover: usize, kicks: &[Kick]) -> Mover {
        let mut still = movers[mover].still();
        let mut push = |(kicked, linear, angular): Kick| {
            if kicked == mover {
                still.push(linear, angular);
            }
        };
        kicks.iter().for_each(|kick| push(*kick));
        for slot in self.slots(kicks) {
            let reactions = self.reactions(movers, slot, kicks);
            for (row, impulse) in self.rows[self.solved[slot].rows.clone()].iter().zip(reactions) {
                row.kicks(impulse).for_each(&mut push);
            }
        }
        still
    }

    /// How much a unit impulse along a rope changes its own velocity \[1/kg\].
    fn own_response(&self, movers: &[Mover], row: &Row) -> f64 {
        let kicks: Vec<Kick> = row.kicks(1.0).collect();
        let mut after: Vec<Mover> = Vec::new();
        let mut ends = [None; 2];
        for (end, mover) in row.ends.iter().enumerate() {
            ends[end] = mover.map(|mover| {
                after.push(self.felt(movers, mover, &kicks));
                after.len() - 1
            });
        }
        Row { ends, ..*row }.rate(&after)
    }

    /// Linkages that impulses reach.
    fn slots(&self, kicks: &[Kick]) -> impl Iterator<Item = usize> + use<> {
        let of = |kick: &Kick| self.of_mover[kick.0];
        let first = kicks.first().and_then(of);
        let second = kicks.get(1).and_then(of).filter(|slot| Some(*slot) != first);
        [first, second].into_iter().flatten()
    }

    /// λ of the rows of a linkage.
    fn reactions(&self, movers: &[Mover], slot: usize, kicks: &[Kick]) -> Vec<f64> {
        let solved = &self.solved[slot];
        let change = |row: &Row| {
            let mut change = 0.0;
            for &(mover, linear, angular) in kicks {
                for (end, sign) in [(0, 1.0), (1, -1.0)] {
                    if row.ends[end] == Some(mover) {
                        let Mover { inverse_mass, inverse_inertia, .. } = movers[mover];
                        change += sign * inverse_mass * row.blocked.along.dot(linear);
                        change += sign * row.blocked.turning[end].dot(inverse_inertia * angular);
                    }
                }
            }
            -change
        };
        let wanted: Vec<f64> = self.rows[solved.rows.clone()].iter().map(change).collect();
        solved.solve(&wanted)
    }

    /// Pulls taut ropes that an impact lengthens. Returns the largest change of velocity \[m/s\].
    pub(super) fn pull_taut(&mut self, movers: &mut [Mover]) -> f64 {
        let mut largest = 0.0_f64;
        for index in 0..self.ropes.len() {
            let rope = &self.ropes[index];
            if rope.taut && rope.inverse_mass > 0.0 {
                let wanted = rope.row.rate(movers) / rope.inverse_mass;
                largest = largest.max(self.pull(movers, index, -wanted) * self.ropes[index].inverse_mass);
            }
        }
        largest
    }

    /// Adds an impulse along a rope, as far as it pulls. Returns the size of what was added.
    fn pull(&mut self, movers: &mut [Mover], index: usize, wanted: f64) -> f64 {
        let row = &mut self.ropes[index].row;
        let change = (row.impulse + wanted).min(0.0) - row.impulse;
        if change != 0.0 {
            row.push(movers, change);
            let kicks: Vec<Kick> = row.kicks(change).collect();
            self.react(movers, &kicks);
        }
        change.abs()
    }

    /// Closes all joints at the poses that `next` gives for movers with their present velocities, `duration`
    /// \[s\] later.
    pub(super) fn settle(
        &mut self,
        linkages: &Linkages,
        movers: &mut [Mover],
        duration: f64,
        next: &dyn Fn(usize, &Mover) -> Pose,
    ) {
        for _ in 0..MOST_ROUNDS {
            let mut worst = 0.0_f64;
            for slot in 0..self.solved.len() {
                let errors = self.errors(linkages, movers, self.solved[slot].rows.clone(), next);
                worst = errors.iter().fold(worst, |worst, error| worst.max(error.abs()));
                let wanted: Vec<f64> = errors.iter().map(|error| -error / duration).collect();
                let impulses = self.solved[slot].solve(&wanted);
                for (row, impulse) in self.rows[self.solved[slot].rows.clone()].iter_mut().zip(impulses) {
                    row.push(movers, impulse);
                }
            }
            for index in 0..self.ropes.len() {
                let Rope { row, inverse_mass, .. } = &self.ropes[index];
                if *inverse_mass <= 0.0 {
                    continue;
                }
                let placed = linkages.joints[row.joint].placed(&|body| next(body, &movers[body]));
                let error = linkages.joints[row.joint].errors(&placed, &[row.blocked])[0];
                if error > 0.0 || row.impulse < 0.0 {
                    worst = worst.max(error.abs());
                    let wanted = -error / (duration * inverse_mass);
                    self.pull(movers, index, wanted);
                }
            }
            if worst < CLOSED {
                break;
            }
        }
    }

    /// How far the joints of these rows are off at the poses that `next` gives. The movers are the bodies.
    fn errors(
        &self,
        linkages: &Linkages,
        movers: &[Mover],
        rows: Range<usize>,
        next: &dyn Fn(usize, &Mover) -> Pose,
    ) -> Vec<f64> {
        let mut errors = Vec::with_capacity(rows.len());
        for same in self.rows[rows].chunk_by(|a, b| a.joint == b.joint) {
            let joint = &linkages.joints[same[0].joint];
            let blocked: Vec<Blocked> = same.iter().map(|row| row.blocked).collect();
            let placed = joint.placed(&|body| next(body, &movers[body]));
            errors.extend(joint.errors(&placed, &blocked));
        }
        errors
    }

    /// The total impulse of each joint that acts.
    pub(super) fn totals(&self) -> impl Iterator<Item = JointImpulse> {
        let rows: Vec<&Row> = self.rows.iter().chain(self.ropes.iter().map(|rope| &rope.row)).collect();
        let total = |same: &[&Row]| {
            let Row { joint, ends, .. } = *same[0];
            let (mut impulse, mut couple) = (DVec3::ZERO, DVec3::ZERO);
            for row in same {
                impulse += row.blocked.along * row.impulse;
                if row.blocked.along == DVec3::ZERO {
                    couple += row.blocked.turning[0] * row.impulse;
                }
            }
            let arms = self.placed.iter().find(|(index, _)| *index == joint).map(|(_, placed)| placed.arms);
            Some(JointImpulse { joint, ends, arms: arms?, impulse, couple })
        };
        let totals: Vec<JointImpulse> = rows.chunk_by(|a, b| a.joint == b.joint).filter_map(total).collect();
        totals.into_iter().filter(|total| total.impulse != DVec3::ZERO || total.couple != DVec3::ZERO)
    }

    /// Forgets the impulses so far.
    pub(super) fn restart(&mut self) {
        self.rows.iter_mut().for_each(|row| row.impulse = 0.0);
        self.ropes.iter_mut().for_each(|rope| rope.row.impulse = 0.0);
    }

    /// Writes a row for each joint that acts.
    pub(super) fn log(&self, linkages: &Linkages, time: f64, log: &mut StepLog) {
        for total in self.totals() {
            let placed = self.placed.iter().find(|(index, _)| *index == total.joint);
            let Some((_, placed)) = placed else { continue };
            linkages.joints[total.joint].log(placed, (total.impulse, total.couple), time, log);
        }
    }
}

impl Solved {
    fn solve(&self, wanted: &[f64]) -> Vec<f64> {
        let count = wanted.len();
        let mut impulses = vec![0.0; count];
        for (column, value) in wanted.iter().enumerate() {
            let column = &self.inverse[column * count..][..count];
            impulses.iter_mut().zip(column).for_each(|(sum, factor)| *sum += factor * value);
        }
        impulses
    }
}

/// A⁺, by columns. Rows are scaled to a diagonal of ones, so that metres and radians compare.
fn pseudo_inverse(rows: &[Row], movers: &[Mover]) -> Vec<f64> {
    let count = rows.len();
    let between = |one: &Row, other: &Row| {
        let kicked = one.kicks(1.0).map(|(mover, linear, angular)| {
            let Mover { inverse_mass, inverse_inertia, .. } = movers[mover];
            let felt = (linear * inverse_mass, inverse_inertia * angular);
            let of = |end: usize, sign: f64| {
                let Blocked { along, turning } = other.blocked;
                let hit = other.ends[end] == Some(mover);
                if hit { sign * (along.dot(felt.0) + turning[end].dot(felt.1)) } else { 0.0 }
            };
            of(0, 1.0) + of(1, -1.0)
        });
        kicked.sum::<f64>()
    };
    let scale: Vec<f64> = rows
        .iter()
        .map(|row| {
            let own = between(row, row);
            if own > 0.0 { own.sqrt().recip() } else { 0.0 }
        })
        .collect();
    let scaled = Mat::from_fn(count, count, |i, j| {
        let (low, high) = (i.min(j), i.max(j));
        between(&rows[high], &rows[low]) * scale[i] * scale[j]
    });
    let mut inverse = vec![0.0; count * count];
    // A symmetric matrix of finite numbers has eigenvalues.
    let Ok(eigen) = scaled.self_adjoint_eigen(Side::Lower) else { return inverse };
    let (values, vectors) = (eigen.S(), eigen.U());
    for k in (0..count).filter(|&k| values[k] > REDUNDANT) {
        for j in 0..count {
            for i in 0..count {
                inverse[j * count + i] += vectors[(i, k)] * vectors[(j, k)] / values[k] * scale[i] * scale[j];
            }
        }
    }
    inverse
}
