//! Reactions: how the bodies of a linkage share an impulse on one of them.
//!
//! An impulse P on a linkage calls up reactions λ in its joints that keep all blocked velocities as they are:
//!
//! `J M⁻¹ (P + Jᵀ λ) = 0`, so `λ = −A⁺ J M⁻¹ P` with `A = J M⁻¹ Jᵀ`.
//!
//! J has one row for each blocked direction (`joint`), M⁻¹ the inverse masses and inertias. The
//! pseudo-inverse A⁺ (`joint_row`) also serves rows that say the same, as those of two hinges of a door.
//! Contacts are solved against bodies that react in this way, so that a joint is as hard in an impact as at
//! rest.
//!
//! A rope is a row whose impulse only pulls. While it pulls in a step it reacts like a rod, unless a contact
//! pushes it; otherwise it takes part in the sweeps of contacts like a contact. Differs from contacts: it
//! becomes taut at the middle of a step.

use std::ops::Range;

use clangor_core::pose::Pose;
use glam::DVec3;

use super::joint::{Blocked, PlacedEnds};
use super::joint_row::{Rope, Row, pseudo_inverse};
use super::linkage::Linkages;
use super::mover::{Kick, Mover};
use super::step_log::StepLog;
use super::stiff_spring::Give;

/// Joints hold a point whose mobility is below this part of that of the whole linkage: an axis so near has
/// play and gives way.
const HELD: f64 = 1e-3;
/// The same below which rods and ropes, stiff as they are, do not count in the effective mass of an impact.
const YIELDS: f64 = 1e-3;
/// A rope that is shorter than its length by less than this resists an impact \[m\].
const TAUT: f64 = 1e-6;
/// Between the middles of two steps, ends that pass each other at a speed v come nearer by v² Δt² / 8 L; a
/// rope resists within this many times as much.
const CHORD: f64 = 2.0;

/// Rows of one linkage and the pseudo-inverse of A, by columns.
struct Solved {
    linkage: usize,
    /// Of all its bodies \[kg\].
    mass: f64,
    rows: Range<usize>,
    inverse: Vec<f64>,
}

/// The joints of some linkages at one instant.
#[derive(Default)]
pub(super) struct Reactions {
    rows: Vec<Row>,
    solved: Vec<Solved>,
    /// Linkage of each mover, among `solved`.
    of_mover: Vec<Option<usize>>,
    placed: Vec<(usize, PlacedEnds)>,
    /// Rows of damped joints, about the rotation that they brake.
    brakes: Vec<Row>,
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

impl Reactions {
    /// Sets up the joints of these linkages in steps of `length` \[s\]; the ropes named by their joints pull.
    /// `place` gives the pose of a body and its number among the movers.
    pub(super) fn set_up(
        &mut self,
        linkages: &Linkages,
        (chosen, pulling): (impl Iterator<Item = usize>, &[(usize, f64)]),
        place: &dyn Fn(usize) -> (Pose, usize),
        (movers, length): (&[Mover], f64),
    ) {
        self.rows.clear();
        self.solved.clear();
        self.placed.clear();
        self.brakes.clear();
        self.of_mover.clear();
        self.of_mover.resize(movers.len(), None);
        for linkage in chosen {
            let first = self.rows.len();
            for &body in linkages.bodies_of(linkage) {
                self.of_mover[place(body).1] = Some(self.solved.len());
            }
            for &index in linkages.joints_of(linkage) {
                let joint = &linkages.joints[index];
                let placed = joint.placed(&|body| place(body).0);
                let blocked = joint.blocked(&placed, length);
                let ends = joint.ends.map(|end| end.body.map(|body| place(body).1));
                let rope = joint.is_rope().then(|| {
                    let near = TAUT + CHORD * chord(&placed, ends, movers, length);
                    let taut = joint.errors(&placed, &blocked).iter().any(|error| *error > -near);
                    let pulls = pulling.iter().any(|(pulling, _)| *pulling == index);
                    Rope { taut, pulls, limit: 0.0 }
                });
                let gives = joint.gives(&placed, &blocked, length);
                let row = |(&blocked, give): (&Blocked, Option<Give>)| Row {
                    joint: index,
                    blocked,
                    ends,
                    impulse: 0.0,
                    rope,
                    give,
                    released: false,
                };
                self.rows.extend(blocked.iter().zip(gives).map(row));
                self.placed.push((index, placed));
            }
            let mass = linkages.bodies_of(linkage).iter().map(|&body| movers[place(body).1].inverse_mass);
            let mass = mass.filter(|inverse| *inverse > 0.0).map(f64::recip).sum();
            self.solved.push(Solved { linkage, mass, rows: first..self.rows.len(), inverse: Vec::new() });
            self.factorize(self.solved.len() - 1, movers);
        }
    }

    /// Finds the pseudo-inverse of the rows of a linkage that react.
    pub(super) fn factorize(&mut self, slot: usize, movers: &[Mover]) {
        let solved = &mut self.solved[slot];
        solved.inverse = pseudo_inverse(&self.rows[solved.rows.clone()], movers);
    }

    /// Rows of a linkage.
    pub(super) fn rows_of(&mut self, slot: usize) -> &mut [Row] {
        &mut self.rows[self.solved[slot].rows.clone()]
    }

    /// Impulses of the rows of a linkage that change their velocities as wanted.
    pub(super) fn solve(&self, slot: usize, wanted: &[f64]) -> Vec<f64> {
        self.solved[slot].solve(wanted)
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

    /// Whether joints hold a contact so well that nothing moves it, as close to an axis: its `mobility`
    /// \[1/kg\] is nothing against those of both bodies, each with all that hangs on it.
    pub(super) fn hold_point(&self, movers: &[Mover], bodies: [usize; 2], mobility: f64) -> bool {
        let whole = |body: usize| match self.of_mover.get(body) {
            Some(Some(slot)) => self.solved[*slot].mass.recip(),
            _ => movers[body].inverse_mass,
        };
        let moved = bodies.into_iter().filter(|&body| movers[body].inverse_mass > 0.0);
        mobility <= HELD * moved.map(whole).fold(f64::INFINITY, f64::min)
    }

    /// Whether a rope pulls, and reacts like a rod.
    pub(super) fn has_pulling_ropes(&self) -> bool {
        self.rows.iter().any(|row| row.rope.is_some_and(|rope| rope.pulls))
    }

    /// Lets those ropes go that pull so far and that an impulse `along` on A, and its opposite on B, would
    /// push: they take part in the sweeps of contacts.
    pub(super) fn let_pushed_ropes_go(&mut self, movers: &[Mover], ends: [(usize, DVec3); 2], along: DVec3) {
        let [(a, arm_a), (b, arm_b)] = ends;
        let kicks = [(a, along, arm_a.cross(along)), (b, -along, -arm_b.cross(along))];
        for slot in self.slots(&kicks) {
            let reactions = self.reactions(movers, slot, &kicks);
            let mut pushed = false;
            for (row, impulse) in self.rows[self.solved[slot].rows.clone()].iter_mut().zip(reactions) {
                if let Some(rope) = row.rope.as_mut().filter(|rope| rope.pulls && impulse > 0.0) {
                    rope.pulls = false;
                    pushed = true;
                }
            }
            if pushed {
                self.factorize(slot, movers);
            }
        }
    }

    /// Effective masses \[kg\] of contacts along their normals, after a solve: with the reactions of joints,
    /// and of the ropes that pull in it; `None` where no body of a contact has joints.
    pub(super) fn effective_masses(
        &mut self,
        movers: &[Mover],
        contacts: &[([(usize, DVec3); 2], DVec3)],
    ) -> Vec<Option<f64>> {
        let tensed = self.rows.iter().any(Row::is_tensed);
        if tensed {
            self.let_ropes_pull(movers, Row::is_tensed);
        }
        let mass = |&(ends, normal): &([(usize, DVec3); 2], DVec3)| {
            ends.iter().any(|end| self.holds(end.0)).then(|| {
                let alone = ends.map(|(mover, arm)| movers[mover].inverse_mass_at(arm, normal));
                let inverse = self.response(movers, ends, normal).dot(normal);
                let alone = alone[0] + alone[1];
                // What hits a rod or a rope along its length hits the body that hangs on it.
                if inverse > YIELDS * alone { inverse.recip() } else { alone.recip() }
            })
        };
        let masses = contacts.iter().map(mass).collect();
        if tensed {
            self.let_ropes_pull(movers, |_| false);
        }
        masses
    }

    /// Of all ropes, those chosen react like rods.
    fn let_ropes_pull(&mut self, movers: &[Mover], chosen: impl Fn(&Row) -> bool) {
        for row in &mut self.rows {
            let pulls = chosen(row);
            row.rope.iter_mut().for_each(|rope| rope.pulls = pulls);
        }
        (0..self.solved.len()).for_each(|slot| self.factorize(slot, movers));
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
        self.pull_ropes(movers, |rope| rope.taut.then_some(0.0))
    }

    /// Pulls slack ropes that would be too long at the middle of the next step. Returns the largest change of
    /// velocity \[m/s\].
    pub(super) fn pull_back(&mut self, movers: &mut [Mover]) -> f64 {
        self.pull_ropes(movers, |rope| (!rope.pulls).then_some(rope.limit))
    }

    /// Pulls ropes that grow faster than their limits [m/s], one after the other.
    fn pull_ropes(&mut self, movers: &mut [Mover], limit: impl Fn(Rope) -> Option<f64>) -> f64 {
        let mut largest = 0.0_f64;
        for index in 0..self.rows.len() {
            let row = self.rows[index];
            let Some(limit) = row.rope.and_then(&limit) else { continue };
            let excess = row.rate(movers) - limit;
            if excess <= 0.0 && row.impulse == 0.0 {
                continue;
            }
            let mobility = self.own_response(movers, &row);
            if mobility > 0.0 {
                let change = (row.impulse - excess / mobility).min(0.0) - row.impulse;
                self.push(movers, index, change);
                largest = largest.max(change.abs() * mobility);
            }
        }
        largest
    }

    /// Adds an impulse along a row that does not react.
    fn push(&mut self, movers: &mut [Mover], index: usize, impulse: f64) {
        self.rows[index].push(movers, impulse);
        let kicks: Vec<Kick> = self.rows[index].kicks(impulse).collect();
        self.react(movers, &kicks);
    }

    /// Impulses of the ropes that pull, by joint, for the next step to begin with.
    pub(super) fn tensions(&self) -> Vec<(usize, f64)> {
        let pulling = self.rows.iter().filter(|row| row.is_tensed());
        pulling.map(|row| (row.joint, row.impulse)).collect()
    }

    /// Begins with the impulses of the last step.
    pub(super) fn begin_with(&mut self, movers: &mut [Mover], tensions: &[(usize, f64)]) {
        for row in self.rows.iter_mut().filter(|row| row.rope.is_some()) {
            if let Some((_, impulse)) = tensions.iter().find(|(joint, _)| *joint == row.joint) {
                row.push(movers, *impulse);
            }
        }
    }

    /// Brakes the rotation in damped joints over a step of `length` \[s\], with the couple at its end,
    /// `c ω / (1 + c w Δt)`, w the mobility of the linkage about ω: no damping is too strong for a step.
    pub(super) fn brake(&mut self, linkages: &Linkages, movers: &mut [Mover], length: f64) {
        for at in 0..self.placed.len() {
            let (index, placed) = &self.placed[at];
            let joint = &linkages.joints[*index];
            let ends = joint.ends.map(|end| end.body);
            let spin = |movers: &[Mover]| {
                let of = |end: usize| ends[end].map_or(DVec3::ZERO, |body| movers[body].spin);
                of(0) - of(1)
            };
            let (damping, braked) = joint.damped(placed, spin(movers));
            let Some(about) = braked.try_normalize().filter(|_| damping > 0.0) else { continue };
            let blocked = Blocked { along: DVec3::ZERO, turning: [about; 2] };
            let (rope, give, released) = (None, None, false);
            let mut row = Row { joint: *index, blocked, ends, impulse: 0.0, rope, give, released };
            let mobility = self.own_response(movers, &row);
            let impulse = -damping * length * braked.length() / (1.0 + damping * length * mobility);
            row.push(movers, impulse);
            let kicks: Vec<Kick> = row.kicks(impulse).collect();
            self.react(movers, &kicks);
            self.brakes.push(row);
        }
    }

    /// Whether a joint brakes.
    pub(super) fn has_brakes(&self) -> bool {
        !self.brakes.is_empty()
    }

    /// The total impulse of each joint that acts.
    pub(super) fn totals(&self) -> impl Iterator<Item = JointImpulse> {
        let rows: Vec<&Row> = self.rows.iter().chain(&self.brakes).collect();
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
    }

    /// Forgets the impulses of one linkage.
    pub(super) fn restart_slot(&mut self, slot: usize) {
        self.rows_of(slot).iter_mut().for_each(|row| row.impulse = 0.0);
    }

    /// Takes the impulses of a linkage back from these movers.
    pub(super) fn take_back(&self, slot: usize, movers: &mut [Mover]) {
        for row in &self.rows[self.solved[slot].rows.clone()] {
            for (mover, linear, angular) in row.kicks(-row.impulse) {
                movers[mover].push(linear, angular);
            }
        }
    }

    /// `Σ λ s` of the impulses of a linkage and the velocities along its rows \[J\], and the sum of the
    /// magnitudes of the impulses \[N s\].
    pub(super) fn power(&self, slot: usize, movers: &[Mover]) -> (f64, f64) {
        let rows = &self.rows[self.solved[slot].rows.clone()];
        let power = |row: &Row| row.impulse * row.rate(movers);
        (rows.iter().map(power).sum(), rows.iter().map(|row| row.impulse.abs()).sum())
    }

    /// Releases the stiff springs: they do not react any more.
    pub(super) fn release_springs(&mut self, movers: &[Mover]) {
        self.rows.iter_mut().for_each(|row| row.released |= row.give.is_some());
        (0..self.solved.len()).for_each(|slot| self.factorize(slot, movers));
    }

    /// Work \[J\] of the impulses so far, by linkage: `Σ λ (s + s⁺) / 2`, with the velocities along its rows
    /// before and after all impulses at this pose.
    pub(super) fn works(&self, before: &[Mover], after: &[Mover]) -> impl Iterator<Item = (usize, f64)> {
        let of = |(slot, solved): (usize, &Solved)| {
            (solved.linkage, 0.5 * (self.power(slot, before).0 + self.power(slot, after).0))
        };
        self.solved.iter().enumerate().map(of)
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

/// How much nearer the ends of a rope come between the middles of two steps, as they pass each other \[m\].
fn chord(placed: &PlacedEnds, ends: [Option<usize>; 2], movers: &[Mover], length: f64) -> f64 {
    let velocity =
        |end: usize| ends[end].map_or(DVec3::ZERO, |mover| movers[mover].velocity_at(placed.arms[end]));
    let between = placed.points[0].distance(placed.points[1]);
    let travel = (velocity(0) - velocity(1)).length_squared() * length * length;
    travel / (8.0 * between.max(f64::MIN_POSITIVE))
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
