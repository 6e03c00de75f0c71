//! The impacts in a recorded motion: who touched whom, where, when, and with which impulse.
//!
//! Each jump of a body ([`jump_windows`](super)) is held against the surfaces around it at its instant.
//! Bodies that touch and jump together are one event, and the impulses at all of its points are those that
//! explain the jumps best. A body that does not jump, a plane, and a body that nothing moves take what is
//! left; so does one that a hand leads (`led_members`). Joints of the scene make a contact heavier
//! (`joined_members`). Bodies that have one impact alone come first (`clean_first`). Where a body is pushed
//! off what it does not approach, the instant is another one within a frame (`wrong_instants`). What is not
//! released at its first frame but carried (`releases`) has no impact before the second.
//!
//! The confidence of an impact is the explained share of the energy of the jumps of its event. Approaches
//! below the threshold of sound, and those of a body that a support holds, are rows of lasting contact.

mod bodies_between;
mod clean_first;
mod eased_motions;
mod event_rows;
mod flat_impacts;
mod joined_members;
mod last_keys;
mod led_members;
mod meetings;
mod reach;
mod releases;
mod rolling;
mod wrong_instants;

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Motion, World};
use clangor_core::material::PairCoefficients;
use clangor_core::timeline::{ContactRow, PoseRow};
use clangor_sim::rigid::JoinedBodies;
use glam::DVec3;

use self::meetings::{Meeting, hear};
use self::reach::Nearness;
use super::impulse_fit::{FitBody, FitContact};
use super::jump_windows::{JumpWindow, jump_windows};
use super::kinematics::{Inertia, Kinematics, State};
use super::neighbours::Neighbours;
use super::parts_of_one::windows_of_part;
use super::recording::RecordedBody;
use super::soft_contacts::SoftPush;
use super::touch::Touch;
use super::touching::SampledSurface;

/// Factors on those gaps that are tried until something touches.
const WIDER: [f64; 3] = [1.0, 4.0, 16.0];
/// Other instants that are tried where nothing touches, in frames.
const ELSEWHERE: [f64; 8] = [0.25, -0.25, 0.5, -0.5, 0.75, -0.75, 1.0, -1.0];
/// Friction above that of the materials that a recording may have: factor and sum.
const FRICTION_SLACK: (f64, f64) = (1.25, 0.05);
/// Unexplained share from which a wider gap is tried.
const POOR: f64 = 0.3;
/// Weight of the jump of a body that several impacts share, beside that of a body with one alone.
const MIXED: f64 = 0.02;

/// What was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionImpacts {
    /// Contacts, in order of time.
    pub contacts: Vec<ContactRow>,
    /// State of the bodies of each impact just before it, in order of time.
    pub states: Vec<PoseRow>,
    /// Explained share of each impact, by its id.
    pub confidence: BTreeMap<u64, f64>,
    /// Jumps of bodies that touch nothing at that time: body and time \[s\].
    pub untouched: Vec<(BodyId, f64)>,
    /// Pushes over several frames that are taken as one impact, in order of time.
    pub soft: Vec<SoftPush>,
}

/// Finds the impacts of recorded bodies of a world, which are [`Motion::Free`] there; `v_min` is the approach
/// speed below which an impact is lasting contact [m/s].
pub fn find_impacts(world: &World, recorded: &[RecordedBody], v_min: f64) -> MotionImpacts {
    find_impacts_in_noise(world, recorded, v_min, &[])
}

/// The same where the deviation of Δv on one axis of each body is noise [m/s]; none beyond the end of
/// `noise`.
pub(super) fn find_impacts_in_noise(
    world: &World,
    recorded: &[RecordedBody],
    v_min: f64,
    noise: &[f64],
) -> MotionImpacts {
    let mut scene = Scene::new(world, recorded);
    // Bodies of one recording have one noise; what exceeds that of the quietest may be what pushes them.
    let quietest = noise.iter().copied().filter(|noise| *noise > 0.0).fold(f64::INFINITY, f64::min);
    for (kinematics, noise) in scene.kinematics.iter_mut().zip(noise) {
        kinematics.iter_mut().for_each(|kinematics| kinematics.set_noise(noise.min(quietest)));
    }
    let mut found = MotionImpacts { soft: scene.soft_pushes(), ..MotionImpacts::default() };
    scene.find_how_bodies_start(recorded, v_min, noise);
    let mut events = scene.clean_events(recorded, v_min, noise);
    let windows = scene.windows_in_order(recorded, v_min, noise);
    let mut done = vec![false; windows.len()];
    for index in 0..windows.len() {
        if done[index] {
            continue;
        }
        done[index] = true;
        let is_at_end = scene.is_at_end(&windows[index]);
        let event = scene.event(&windows, index, &done, Search::All);
        event.iter().flat_map(|(_, used)| used).for_each(|index| done[*index] = true);
        match event {
            // A body in flight or on its way along a floor does not stop because its keys end.
            Some((event, _)) if is_at_end && !event.is_stop(&scene) => {}
            None if is_at_end => {}
            Some((event, _)) => events.push(event),
            None => found.untouched.push((windows[index].body, windows[index].time)),
        }
    }
    events.sort_by(|a, b| a.time.total_cmp(&b.time));
    let mut next_id = 1;
    let rolling = scene.rolling_pairs(&events);
    let mut meetings: Vec<Vec<Meeting>> = events
        .iter()
        .enumerate()
        .map(|(index, event)| event.meetings(&scene, v_min, |pair| rolling.contains(&(index, pair))))
        .collect();
    hear(&events, &mut meetings);
    for (event, meetings) in events.iter().zip(meetings) {
        event.write(&scene, meetings, &mut next_id, &mut found);
    }
    scene.drop_jumps_of_parts(&windows, &mut found);
    found.contacts.sort_by(|a, b| a.time.total_cmp(&b.time));
    found.states.sort_by(|a, b| a.time.total_cmp(&b.time));
    found
}

/// The bodies with what the search needs.
pub(super) struct Scene<'a> {
    pub(super) world: &'a World,
    pub(super) surfaces: Vec<Arc<SampledSurface>>,
    pub(super) kinematics: Vec<Option<Kinematics<'a>>>,
    /// Bodies that may come near each other.
    pub(super) neighbours: Neighbours,
    /// The joints of the scene, if it has any.
    joined: Option<JoinedBodies<'a>>,
    /// Group of each body whose parts move as one.
    groups: Vec<Option<usize>>,
    /// Places of the windows of each body, in order of time.
    windows: Vec<Vec<usize>>,
}

/// Through which bodies an event goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Search {
    /// Those that no other impact moves at the time.
    Clean,
    /// All of them.
    All,
}

/// Bodies that touch at an instant, and their points.
struct Event {
    time: f64,
    members: Vec<Member>,
    points: Vec<(FitContact, Touch)>,
    impulses: Vec<DVec3>,
    residual: f64,
}

/// A body of an event just before it.
#[derive(Clone, Copy)]
struct Member {
    body: BodyId,
    /// Instant of the event \[s\].
    time: f64,
    state: State,
    window: Option<JumpWindow>,
    fit: FitBody,
    is_supported: bool,
    /// Whether a hand makes it infinitely heavy.
    is_led: bool,
}

impl Member {
    /// Whether it has several impacts at the time.
    fn is_mixed(&self) -> bool {
        self.window.is_some_and(|window| !window.is_clean)
    }
}

/// Where an event is sought: at an instant \[s\], with gaps up to this factor on the least.
#[derive(Clone, Copy)]
struct Near {
    time: f64,
    factor: f64,
    search: Search,
}

impl<'a> Scene<'a> {
    pub(super) fn new(world: &'a World, recorded: &'a [RecordedBody]) -> Self {
        let mut known: BTreeMap<*const clangor_core::body::Surface, Arc<SampledSurface>> = BTreeMap::new();
        let surfaces = world.bodies.iter().map(|body| {
            let entry = known.entry(Arc::as_ptr(&body.surface));
            Arc::clone(entry.or_insert_with(|| Arc::new(SampledSurface::new(&body.surface))))
        });
        let surfaces: Vec<Arc<SampledSurface>> = surfaces.collect();
        let mut groups = vec![None; world.bodies.len()];
        let mut kinematics: Vec<Option<Kinematics<'a>>> = world.bodies.iter().map(|_| None).collect();
        for RecordedBody { body, frames, group } in recorded {
            groups[body.index()] = *group;
            let Body { mass, inertia, motion, .. } = &world.bodies[body.index()];
            if matches!(motion, Motion::Free) && frames.len() > 1 {
                let inertia = Inertia::new(*mass, *inertia, world.gravity);
                kinematics[body.index()] = Some(Kinematics::new(frames, inertia));
            }
        }
        let radii: Vec<f64> = surfaces.iter().map(|surface| surface.radius).collect();
        let neighbours = Neighbours::of(&world.bodies, &radii, &kinematics);
        let windows = vec![Vec::new(); world.bodies.len()];
        let joined = JoinedBodies::of(world);
        Scene { world, surfaces, kinematics, neighbours, joined, groups, windows }
    }

    /// The soft pushes of all bodies, in order of time.
    fn soft_pushes(&self) -> Vec<SoftPush> {
        let of_body = |(index, kinematics): (usize, &Option<Kinematics<'_>>)| {
            let Some(Kinematics { soft, frames, .. }) = kinematics else { return Vec::new() };
            let body = BodyId(index as u32);
            let push = |of: &Range<usize>| {
                let [time, end] = [of.start - 1, of.end].map(|k| frames[k].time);
                SoftPush { body, time, length: end - time }
            };
            soft.iter().map(push).collect()
        };
        let mut all: Vec<SoftPush> = self.kinematics.iter().enumerate().flat_map(of_body).collect();
        all.sort_by(|a, b| a.time.total_cmp(&b.time));
        all
    }

    /// Whether an impact is the end of the keys of its body.
    fn is_at_end(&self, window: &JumpWindow) -> bool {
        let of_body = self.kinematics[window.body.index()].as_ref();
        of_body.is_some_and(|kinematics| {
            kinematics.last_key + 1 < kinematics.frames.len() && window.first >= kinematics.last_key
        })
    }

    /// The windows of all bodies in the order of the bodies.
    fn windows(&self, recorded: &[RecordedBody], v_min: f64, noise: &[f64]) -> Vec<JumpWindow> {
        let (mut of_body, mut parts) = (vec![None; self.world.bodies.len()], BTreeMap::new());
        for body in recorded {
            of_body[body.body.index()] = Some(body);
            *parts.entry(body.group).or_insert(0) += 1;
        }
        let mut windows = Vec::new();
        for (index, body) in of_body.into_iter().enumerate() {
            let (Some(body), Some(kinematics)) = (body, &self.kinematics[index]) else { continue };
            let limits = (v_min, noise.get(index).copied().unwrap_or(0.0));
            let is_part = body.group.is_some() && parts[&body.group] > 1;
            windows.extend(if is_part {
                windows_of_part(self.world, recorded, body, limits, kinematics.start)
            } else {
                jump_windows(body.body, kinematics, limits)
            });
        }
        windows
    }

    /// A part that touches nothing jumps with that of its group which does.
    fn drop_jumps_of_parts(&self, windows: &[JumpWindow], found: &mut MotionImpacts) {
        let is_of_part = |(body, time): &(BodyId, f64)| {
            if self.groups[body.index()].is_none() {
                return false;
            }
            let span = windows.iter().find(|w| w.body == *body && w.time == *time).map_or(0.0, |w| w.span);
            let near = |row: &&ContactRow| (row.time - time).abs() <= 2.0 * span;
            let mut rows = found.contacts.iter().filter(near).flat_map(|row| [row.body_a, row.body_b]);
            rows.any(|other| self.move_as_one(other, *body))
        };
        let left = found.untouched.iter().copied().filter(|jump| !is_of_part(jump)).collect();
        found.untouched = left;
    }

    /// The same in order of time, with their places for each body.
    fn windows_in_order(&mut self, recorded: &[RecordedBody], v_min: f64, noise: &[f64]) -> Vec<JumpWindow> {
        let mut windows = self.windows(recorded, v_min, noise);
        windows.retain(|window| !self.is_eased(window));
        windows.sort_by(|a, b| a.time.total_cmp(&b.time));
        self.windows.iter_mut().for_each(Vec::clear);
        for (index, window) in windows.iter().enumerate() {
            self.windows[window.body.index()].push(index);
        }
        windows
    }

    /// The event of a window, and the windows of other bodies that belong to it, of those not yet done.
    fn event(
        &self,
        windows: &[JumpWindow],
        first: usize,
        done: &[bool],
        search: Search,
    ) -> Option<(Event, Vec<usize>)> {
        let mut best: Option<(Event, Vec<usize>)> = None;
        let JumpWindow { time, span, .. } = windows[first];
        let here = WIDER.map(|factor| (factor, 0.0));
        // Where two impacts share a frame, the instant is uncertain by one.
        let elsewhere = WIDER.into_iter().flat_map(|factor| ELSEWHERE.map(|part| (factor, part)));
        for (factor, part) in here.into_iter().chain(elsewhere) {
            // The instant of a body with one impact alone is exact, as is that of one that is released.
            let is_exact = search == Search::Clean || windows[first].first == 0;
            let is_hit = best.as_ref().is_some_and(|(event, _)| !event.is_pushed_without_approach());
            if part != 0.0 && (is_hit || is_exact) {
                break;
            }
            let instant = (time + part * span).max(0.0);
            let near = Near { time: instant, factor, search };
            let Some((event, used)) = self.event_within(windows, first, done, near) else { continue };
            let is_good = event.residual < POOR && !event.is_pushed_without_approach();
            let is_better = |(found, _): &(Event, Vec<usize>)| match part == 0.0 {
                true => event.residual < 0.7 * found.residual,
                false => is_good,
            };
            if best.as_ref().is_none_or(is_better) {
                best = Some((event, used));
            }
            if is_good {
                break;
            }
        }
        let (mut event, used) = best?;
        event.share(self, search);
        Some((event, used))
    }

    fn event_within(
        &self,
        windows: &[JumpWindow],
        first: usize,
        done: &[bool],
        Near { time, factor, search }: Near,
    ) -> Option<(Event, Vec<usize>)> {
        let start = windows[first];
        let (mut members, mut used) = (vec![self.member(start.body, Some(start), time)?], Vec::new());
        let mut points: Vec<(FitContact, Touch)> = Vec::new();
        let mut next = 0;
        while next < members.len() {
            let one = members[next];
            let goes_on = |place: usize, member: &Member| {
                let is_end = search == Search::Clean && place > 0 && member.is_mixed();
                member.fit.inverse_mass > 0.0 && !is_end
            };
            if !goes_on(next, &one) {
                next += 1;
                continue;
            }
            // What an impact sets in motion may rest on others, or meet them within the frame; what has an
            // impact of its own may be farther away at a wrong instant.
            let (factor, impact) = match one.window {
                Some(_) => (factor, 0.0),
                None => (1.0, start.velocity.length()),
            };
            let nearness = Nearness { span: start.span, factor, impact };
            let others = self.neighbours.of_body(one.body.index());
            for other in others.filter(|id| !self.move_as_one(one.body, *id)) {
                let place = members.iter().position(|member| member.body == other);
                // A pair is searched once, from the member that came first.
                if place.is_some_and(|place| place < next && goes_on(place, &members[place])) {
                    continue;
                }
                if place.is_none() && !self.may_meet(&one, other, time) {
                    continue;
                }
                let window = self.window_near(windows, other, time, start.span, done);
                let Some(member) = place
                    .map(|place| members[place])
                    .or_else(|| self.member(other, window.map(|index| windows[index]), time))
                else {
                    continue;
                };
                let found = self.touches(&one, &member, &nearness);
                if found.is_empty() {
                    continue;
                }
                let place = place.unwrap_or_else(|| {
                    used.extend(window);
                    members.push(member);
                    members.len() - 1
                });
                let friction = self.friction(one.body, other);
                points.extend(found.into_iter().map(|touch| {
                    let Touch { point, normal, .. } = touch;
                    (FitContact { bodies: [next, place], point, normal, friction }, touch)
                }));
            }
            next += 1;
        }
        self.drop_points_behind(&members, &mut points);
        if points.is_empty() {
            return None;
        }
        let contacts: Vec<FitContact> = points.iter().map(|(contact, _)| *contact).collect();
        let fit = self.fitted(&mut members, &contacts, (search, start.span))?;
        Some((Event { time, members, points, impulses: fit.impulses, residual: fit.residual }, used))
    }

    fn move_as_one(&self, a: BodyId, b: BodyId) -> bool {
        let [a, b] = [a, b].map(|id| self.groups[id.index()]);
        a.is_some() && a == b
    }

    /// μ of a pair with what recordings may have above it.
    pub(super) fn friction(&self, a: BodyId, b: BodyId) -> f64 {
        let material = |id: BodyId| &self.world.bodies[id.index()].material;
        FRICTION_SLACK.0 * PairCoefficients::of(material(a), material(b)).friction + FRICTION_SLACK.1
    }

    /// A window of a body within a frame of an instant that belongs to no event yet.
    fn window_near(
        &self,
        windows: &[JumpWindow],
        body: BodyId,
        time: f64,
        span: f64,
        done: &[bool],
    ) -> Option<usize> {
        let own = &self.windows[body.index()];
        let after = own.partition_point(|index| windows[*index].time < time - 1.01 * span);
        let near =
            own[after..].iter().copied().take_while(|index| windows[*index].time <= time + 1.01 * span);
        near.filter(|index| !done[*index])
            .min_by(|a, b| (windows[*a].time - time).abs().total_cmp(&(windows[*b].time - time).abs()))
    }

    /// A body at an instant; `None` if it does not exist then.
    fn member(&self, body: BodyId, window: Option<JumpWindow>, time: f64) -> Option<Member> {
        let described = &self.world.bodies[body.index()];
        if !described.life.holds(time) {
            return None;
        }
        let Some(kinematics) = &self.kinematics[body.index()] else {
            let state = state_of_unrecorded(described, time);
            let fit = FitBody::IMMOVABLE;
            return Some(Member { body, time, state, window: None, fit, is_supported: true, is_led: false });
        };
        let mut is_supported = false;
        let state = match window {
            Some(JumpWindow { first: 0, .. }) => kinematics.released(time),
            Some(window) => {
                is_supported = window.first > 1 && kinematics.is_supported(window.first - 1);
                kinematics.continued(window.first - 1, time)
            }
            None => kinematics.at(time)?,
        };
        let jumps = match window {
            Some(window) => (window.velocity, window.angular_momentum),
            None => small_jumps(kinematics, time),
        };
        let fit = FitBody::moved(&kinematics.inertia, state.pose, jumps);
        Some(Member { body, time, state, window, fit, is_supported, is_led: false })
    }
}

/// Bodies as they are fitted: what is mixed counts less beside the clean first one, and the less the lighter
/// it is, whose jump is greater for the same impulse.
fn fit_bodies(members: &[Member], search: Search) -> Vec<FitBody> {
    let weighted = |member: &Member| {
        let first = members[0].fit.inverse_mass;
        let ratio = if first > 0.0 { first / member.fit.inverse_mass } else { 1.0 };
        match search == Search::Clean && member.is_mixed() {
            true => member.fit.weighted(MIXED * ratio.min(1.0)),
            false => member.fit,
        }
    };
    members.iter().map(weighted).collect()
}

/// A body without frames: by its keyframes, or where it stands.
pub(super) fn state_of_unrecorded(body: &Body, time: f64) -> State {
    let still = (body.pose, DVec3::ZERO, DVec3::ZERO);
    let (pose, velocity, angular_velocity) = body.motion.track().map_or(still, |track| track.sample(time));
    State { pose, velocity, angular_velocity }
}

/// Jumps of the frames around an instant, of a body without an impact there, beyond what holds it.
fn small_jumps(kinematics: &Kinematics<'_>, time: f64) -> (DVec3, DVec3) {
    let index = kinematics.interval_at(time).filter(|_| kinematics.is_recorded_at(time));
    let Some(index) = index else { return (DVec3::ZERO, DVec3::ZERO) };
    let is_between = |k: &usize| *k > 0 && *k + 1 < kinematics.frames.len();
    let held = |k: &usize| is_between(k) && kinematics.is_supported(*k);
    let gravity = kinematics.inertia.gravity;
    let frames = || index..=index + 1;
    let velocity = |k: usize| {
        let (jump, whole) = (kinematics.left[k], kinematics.jumps[k]);
        if held(&k) && jump.velocity == whole.velocity {
            jump.velocity + gravity * jump.span
        } else {
            jump.velocity
        }
    };
    (frames().map(velocity).sum(), frames().map(|k| kinematics.left[k].angular_momentum).sum())
}
