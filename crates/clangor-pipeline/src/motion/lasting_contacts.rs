//! Rows of lasting contact of a recorded motion: what holds, brakes and turns bodies that rest, slide or
//! roll.
//!
//! At each frame, the change of motion of a body beyond gravity and impacts ([`lasting_jumps`](super)) is the
//! impulse of its contacts in one step, from the middle of the frame before to that of the frame after:
//!
//! ```text
//! Σ J + Σ_impacts J = m (Δv − g h)        J = j_n n + j_t,  j_n ≥ 0,  |j_t| ≤ 1.25 μ j_n + 0.05 j_n
//! ```
//!
//! Surfaces that touch at the frame say where and along which normal, and all bodies that touch share what
//! explains their motion best ([`lasting_fit`](super)). What a hand leads ([`led_bodies`](super)) gives
//! what others need, and needs nothing. A body at rest passes loads on, but what a body does
//! that has no frames at the same instants is not asked. Contacts below 4 % of a body's weight are not
//! sought: that is four deviations of the noise that is left. Where noise moves a body by more than
//! 2 µm, all points of a pair have the same share of its load: which of them touch is not known better.
//!
//! It is what a log of the steps of a simulation says, with steps of a frame. It has no micro-impacts of
//! rough surfaces, nor anything else that is faster than half of the frame rate.

use std::collections::BTreeMap;

use clangor_core::body::{BodyId, World};
use clangor_core::material::PairCoefficients;
use clangor_core::pose::Pose;
use clangor_core::timeline::{ContactKind, ContactRow};
use glam::DVec3;

use super::impacts::{Scene, state_of_unrecorded};
use super::impulse_fit::{FitBody, FitContact};
use super::kinematics::{Kinematics, State};
use super::lasting_fit::{EXPLAINED, FitPair, SharedLoad, share_load};
use super::lasting_jumps::{LastingJump, Push, RecordedMotion, lasting_jumps};
use super::led_bodies::{Pushes, Reach};
use super::recording::RecordedBody;
use super::touch::Touch;
use super::touching::{Clearance, Placed, lasting_touches, may_touch};

/// Gaps that count as touching: a share of the smaller body, a share of the way in a frame, and the digits of
/// 32-bit files \[m\]; and the factors on them that are tried.
const TOUCHING: (f64, f64, f64) = (0.003, 0.03, 2e-5);
const WIDER: [f64; 2] = [1.0, 5.0];
/// Unexplained share of the energy from which the wider gap is tried.
const POOR: f64 = 0.1;
/// Lightest contact that is sought, over the weight of the body, and in deviations of the noise.
const LIGHT: (f64, f64) = (0.04, 4.0);
/// Distance of points that are one contact, as a share of the smaller body.
const MERGED: f64 = 0.04;
/// Rolling loss above that of the materials that a recording may have, as with friction.
const ROLLING_SLACK: f64 = 1.25;
/// Noise of positions from which the points of a pair share its load evenly \[m\]: at rest it looks like a
/// surface speed of 0.3 mm/s within 10 ms.
const RESTLESS: f64 = 2e-6;
/// Frames that differ by less than this share of their length are of one instant.
const SAME_INSTANT: f64 = 1e-3;

/// The rows of frames from one instant until before another, in order of time. `noise` is the deviation of Δv
/// on one axis of each body [m/s]; `impacts` are the rows of all impacts around that time.
pub(super) fn lasting_contacts(
    world: &World,
    recorded: &[RecordedBody],
    noise: &[f64],
    impacts: &[ContactRow],
    [from, to]: [f64; 2],
) -> Vec<ContactRow> {
    let scene = Scene::new(world, recorded);
    let noise_of = |index: usize| noise.get(index).copied().unwrap_or(0.0);
    let of_bodies = rows_of_bodies(impacts, world.bodies.len());
    let jumps = scene.kinematics.iter().enumerate().map(|(index, kinematics)| {
        let kinematics = kinematics.as_ref()?;
        let reach = scene.surfaces[index].radius;
        let motion = RecordedMotion { kinematics, reach, noise: noise_of(index) };
        Some(lasting_jumps(motion, &pushes(&of_bodies[index], BodyId(index as u32), kinematics)))
    });
    let jumps: Vec<Option<Vec<LastingJump>>> = jumps.collect();
    let mut search =
        Search { scene: &scene, jumps: &jumps, noise, frame_of: Vec::new(), known: BTreeMap::new() };
    let mut rows = Vec::new();
    for step in steps(&scene, [from, to]).chunk_by(|a, b| b.time - a.time < SAME_INSTANT * a.span) {
        search.step(step, &mut rows);
    }
    rows
}

/// The rows of impacts of each of so many bodies.
fn rows_of_bodies(impacts: &[ContactRow], bodies: usize) -> Vec<Vec<&ContactRow>> {
    let mut rows = vec![Vec::new(); bodies];
    for row in impacts.iter().filter(|row| row.impact_id != 0) {
        for id in [row.body_a, row.body_b] {
            if let Some(own) = rows.get_mut(id.index()) {
                own.push(row);
            }
        }
    }
    rows
}

/// What the impacts of a body give to it.
fn pushes(own: &[&ContactRow], body: BodyId, kinematics: &Kinematics<'_>) -> Vec<Push> {
    let push = |row: &&ContactRow| {
        let sign = if row.body_a == body { 1.0 } else { -1.0 };
        let index = kinematics.interval_at(row.time)?;
        let centre = match index.checked_sub(1) {
            Some(before) => kinematics.continued(before, row.time).pose.position,
            None => kinematics.at(row.time)?.pose.position,
        };
        let impulse = row.impulse() * sign;
        let moment = (row.point - centre).cross(impulse) + row.couple * sign;
        Some(Push { time: row.time, impulse, moment })
    };
    own.iter().filter_map(push).collect()
}

/// A frame of a body.
#[derive(Clone, Copy)]
struct Entry {
    time: f64,
    span: f64,
    body: usize,
    frame: usize,
}

/// All frames from one instant until before another, in order of time.
fn steps(scene: &Scene<'_>, [from, to]: [f64; 2]) -> Vec<Entry> {
    let mut entries = Vec::new();
    for (body, kinematics) in scene.kinematics.iter().enumerate() {
        let Some(kinematics) = kinematics else { continue };
        let frames = kinematics.frames;
        let first = frames.partition_point(|frame| frame.time < from).max(1);
        for frame in (first..frames.len().saturating_sub(1)).take_while(|k| frames[*k].time < to) {
            let (time, span) = (frames[frame].time, kinematics.jumps[frame].span);
            entries.push(Entry { time, span, body, frame });
        }
    }
    entries.sort_by(|a, b| a.time.total_cmp(&b.time).then(a.body.cmp(&b.body)));
    entries
}

/// Touches of a pair in the poses and with the gap in which they were found, and what else is known then.
#[derive(Default)]
struct KnownPair {
    found: Option<([Pose; 2], f64, Vec<Touch>)>,
    clearance: Clearance,
}

struct Search<'a> {
    scene: &'a Scene<'a>,
    jumps: &'a [Option<Vec<LastingJump>>],
    noise: &'a [f64],
    /// Frame of each body in the present step.
    frame_of: Vec<Option<usize>>,
    /// What need not be asked again.
    known: BTreeMap<(usize, usize), KnownPair>,
}

/// A body of a group that touches.
#[derive(Clone, Copy)]
struct Member {
    body: usize,
    state: State,
    fit: FitBody,
    /// Deviation of its positions that is noise \[m\].
    deviation: f64,
}

/// Bodies that touch each other, their pairs, and their points.
#[derive(Default)]
struct Group {
    members: Vec<Member>,
    pairs: Vec<FitPair>,
    contacts: Vec<FitContact>,
    touches: Vec<Touch>,
}

impl Search<'_> {
    /// The rows of one step.
    fn step(&mut self, step: &[Entry], rows: &mut Vec<ContactRow>) {
        let (time, span) = (step[0].time, step[0].span);
        self.frame_of.clear();
        self.frame_of.resize(self.jumps.len(), None);
        step.iter().for_each(|entry| self.frame_of[entry.body] = Some(entry.frame));
        let mut done = vec![false; self.jumps.len()];
        for Entry { body, .. } in step {
            if done[*body] || !self.is_carried(*body) {
                continue;
            }
            let mut best: Option<(Group, SharedLoad)> = None;
            for wider in WIDER {
                let group = self.group(*body, time, wider * span, wider);
                let bodies = self.fit_bodies(&group);
                let load = share_load(&bodies, (&group.contacts, &[]), &group.pairs, EXPLAINED);
                let is_good = load.residual < POOR;
                if best.as_ref().is_none_or(|(_, other)| load.residual < 0.7 * other.residual) {
                    best = Some((group, load));
                }
                if is_good {
                    break;
                }
            }
            let Some((group, mut load)) = best else { continue };
            share_evenly_in_noise(&group, &mut load);
            let moved = group.members.iter().filter(|member| member.fit.inverse_mass > 0.0);
            moved.for_each(|member| done[member.body] = true);
            write(&group, &load, time, rows);
        }
    }

    fn jump(&self, body: usize) -> Option<LastingJump> {
        self.jumps[body].as_ref()?.get(self.frame_of[body]?).copied()
    }

    fn noise_of(&self, body: usize) -> f64 {
        self.noise.get(body).copied().unwrap_or(0.0)
    }

    /// Whether something must hold a body in this step.
    fn is_carried(&self, body: usize) -> bool {
        let Some(jump) = self.jump(body) else { return false };
        let fall = self.scene.world.gravity.length() * jump.span;
        // What smoothing left of the noise is at most the share of the weight.
        let light = if fall > 0.0 { LIGHT.0 * fall } else { LIGHT.1 * self.noise_of(body) };
        jump.velocity.length() > light
    }

    /// The bodies that touch a body, and each other through bodies that something moves.
    fn group(&mut self, first: usize, time: f64, way: f64, wider: f64) -> Group {
        let mut group = Group::default();
        group.members.extend(self.member(first, time));
        let mut next = 0;
        while next < group.members.len() {
            let one = group.members[next];
            next += 1;
            if one.fit.inverse_mass <= 0.0 {
                continue;
            }
            let scene = self.scene;
            for other in scene.neighbours.of_body(one.body).map(BodyId::index) {
                let place = group.members.iter().position(|member| member.body == other);
                // A pair is asked once, from the member that came first.
                if place.is_some_and(|p| p + 1 < next && group.members[p].fit.inverse_mass > 0.0) {
                    continue;
                }
                let member = place.map(|place| group.members[place]).or_else(|| self.member(other, time));
                let Some(member) = member else { continue };
                let touches = self.touches(&one, &member, way, wider);
                if touches.is_empty() {
                    continue;
                }
                let place = place.unwrap_or_else(|| {
                    group.members.push(member);
                    group.members.len() - 1
                });
                self.add_pair(&mut group, [next - 1, place], touches);
            }
        }
        group
    }

    fn add_pair(&self, group: &mut Group, bodies: [usize; 2], touches: Vec<Touch>) {
        let ids = bodies.map(|place| BodyId(group.members[place].body as u32));
        let [a, b] = ids.map(|id| &self.scene.world.bodies[id.index()].material);
        let (friction, start) = (self.scene.friction(ids[0], ids[1]), group.contacts.len());
        let contact = |touch: &Touch| {
            let Touch { point, normal, .. } = *touch;
            FitContact { bodies, point, normal, friction }
        };
        group.contacts.extend(touches.iter().map(contact));
        group.touches.extend(touches);
        let lever = ROLLING_SLACK * PairCoefficients::of(a, b).rolling_loss;
        group.pairs.push(FitPair { bodies, contacts: start..group.contacts.len(), lever });
    }

    /// The bodies of a group as they are fitted: a hand gives what is missing to those that it leads.
    fn fit_bodies(&self, group: &Group) -> Vec<FitBody> {
        let fit = |(place, member): (usize, &Member)| {
            let centre = member.fit.centre;
            let heavy = FitBody { centre, ..FitBody::IMMOVABLE };
            if self.is_led(group, place) { heavy } else { member.fit }
        };
        group.members.iter().enumerate().map(fit).collect()
    }

    /// Whether something else than the bodies that a member touches leads it around this step.
    fn is_led(&self, group: &Group, place: usize) -> bool {
        let body = group.members[place].body;
        let Some(kinematics) = &self.scene.kinematics[body] else { return false };
        let Some(frame) = self.frame_of[body] else { return false };
        let pushes = Pushes::around(kinematics, frame, frame);
        if !pushes.are_steady() {
            return false;
        }
        let own = group.contacts.iter().filter(|contact| contact.bodies.contains(&place));
        let reaches: Vec<Reach> = own.map(|contact| Reach::of(contact, place)).collect();
        pushes.are_led(&reaches, &reaches)
    }

    /// A body in this step; `None` if it does not exist then.
    fn member(&self, body: usize, time: f64) -> Option<Member> {
        let described = &self.scene.world.bodies[body];
        if !described.life.holds(time) {
            return None;
        }
        let held = |state| Member { body, state, fit: FitBody::IMMOVABLE, deviation: 0.0 };
        let Some(kinematics) = &self.scene.kinematics[body] else {
            return Some(held(state_of_unrecorded(described, time)));
        };
        let Some((jump, frame)) = self.jump(body).zip(self.frame_of[body]) else {
            return Some(held(kinematics.at(time)?));
        };
        let (pose, before) = (kinematics.frames[frame].pose, kinematics.intervals[frame - 1]);
        let fit = FitBody::moved(&kinematics.inertia, pose, (jump.velocity, jump.angular_momentum));
        let (velocity, angular_velocity) = (before.velocity, before.angular_velocity);
        let deviation = self.noise_of(body) * jump.span / 6.0_f64.sqrt();
        Some(Member { body, state: State { pose, velocity, angular_velocity }, fit, deviation })
    }

    fn touches(&mut self, a: &Member, b: &Member, way: f64, wider: f64) -> Vec<Touch> {
        let placed =
            |member: &Member| Placed { sampled: &self.scene.surfaces[member.body], pose: member.state.pose };
        let (one, two) = (placed(a), placed(b));
        let size = one.sampled.radius.min(two.sampled.radius);
        let (share, of_way, least) = TOUCHING;
        let spin = |member: &Member, reach: f64| {
            if reach.is_finite() { member.state.angular_velocity.length() * reach } else { 0.0 }
        };
        let turning = spin(a, one.sampled.radius).max(spin(b, two.sampled.radius));
        let speed = (a.state.velocity - b.state.velocity).length() + turning;
        let within = wider * (share * size + least) + of_way * speed * way;
        if !may_touch(one, two, within) {
            return Vec::new();
        }
        let poses = [a.state.pose, b.state.pose];
        let KnownPair { found, clearance } = self.known.entry((a.body, b.body)).or_default();
        if let Some((_, _, touches)) = found.as_ref().filter(|known| known.0 == poses && known.1 == within) {
            return touches.clone();
        }
        let touches = lasting_touches(one, two, (within, MERGED * size), clearance);
        *found = Some((poses, within, touches.clone()));
        touches
    }
}

/// Gives all points of pairs that noise moves the same share of their load.
fn share_evenly_in_noise(group: &Group, load: &mut SharedLoad) {
    for pair in &group.pairs {
        if pair.bodies.iter().any(|place| group.members[*place].deviation > RESTLESS) {
            let own = &mut load.impulses[pair.contacts.clone()];
            let mean = own.iter().sum::<DVec3>() / own.len() as f64;
            own.fill(mean);
        }
    }
}

/// Writes the rows of a group, all points of a pair that pushes.
fn write(group: &Group, load: &SharedLoad, time: f64, rows: &mut Vec<ContactRow>) {
    for (pair, couple) in group.pairs.iter().zip(&load.couples) {
        let [a, b] = pair.bodies.map(|place| &group.members[place]);
        let normal_impulse = |k: usize| load.impulses[k].dot(group.contacts[k].normal);
        let strongest =
            pair.contacts.clone().max_by(|a, b| normal_impulse(*a).total_cmp(&normal_impulse(*b)));
        let Some(strongest) = strongest.filter(|k| normal_impulse(*k) > 0.0) else { continue };
        let row = |k: usize| {
            let (contact, impulse) = (&group.contacts[k], load.impulses[k]);
            let (point, normal) = (contact.point, contact.normal);
            ContactRow {
                time,
                body_a: BodyId(a.body as u32),
                body_b: BodyId(b.body as u32),
                kind: ContactKind::Contact,
                point,
                normal,
                impulse_n: impulse.dot(normal),
                impulse_t: impulse - normal * impulse.dot(normal),
                couple: if k == strongest { *couple } else { DVec3::ZERO },
                velocity: a.state.velocity_at(point) - b.state.velocity_at(point),
                depth: -group.touches[k].gap,
                impact_id: 0,
                effective_mass: None,
            }
        };
        rows.extend(pair.contacts.clone().map(row));
    }
}
