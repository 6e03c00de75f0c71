//! Jumps of bodies that roll: a coin that settles, whose point of contact races around its rim.
//!
//! Just before it lies flat, such a coin turns about another diameter within a millisecond. Its jumps are as
//! large as those of an impact, but its rim never leaves the floor, and little is lost. A pair rolls where
//!
//! ```text
//! −Σ j·v⁺ / Σ j·v⁻ > max(0.9, e + 0.1)        v: relative velocity before (−) and after (+)
//! largest gap − smallest gap < 2 µm + 0.05 |v⁻| h        at the frames around it
//! ```
//!
//! with the restitution e of the pair and the length h of a frame: an impact loses energy, and one that loses
//! little parts the surfaces by about |v⁻| h, at least where |v⁻| > 2 g h. A block that falls over keeps its
//! edge on the floor too, but loses 1 − e² of what drives it. What a pair does within two and a half frames
//! of that, while its surfaces stay together, is the same motion. So are later and slower turns of a pair
//! that has not parted by 2 µm at any frame since: the last ones before it lies still lose as much as an
//! impact. Where many points are near, as those of a rim, 0.75 takes the place of 0.9.
//!
//! A ball on a curved track has a steady push too, which changes its direction in each frame as an impact
//! would. It rolls where the pushes of five frames go over into each other and it touches the track in all of
//! them.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::{Range, RangeInclusive};

use clangor_core::body::{BodyId, Surface};
use clangor_core::material::PairCoefficients;
use clangor_core::pose::Pose;
use glam::DVec3;

use super::reach::TOUCHING;
use super::{Event, Scene, state_of_unrecorded};
use crate::motion::jump_windows::{JumpWindow, lasting_rows};
use crate::motion::kinematics::Kinematics;
use crate::motion::touching::touches;

/// Least share of the approach that comes back, the same where many points are near, as those of a rim, and
/// its least excess over the restitution of the pair.
const RETURNED: f64 = 0.9;
const RETURNED_BY_RIM: f64 = 0.75;
const ABOVE_RESTITUTION: f64 = 0.1;
/// Points of a pair from which they are those of a rim; the faces of a box have four.
const RIM: usize = 9;
/// Change of the gap of surfaces that stay together: rounding \[m\], and a share of the way in a frame.
const TOGETHER: (f64, f64) = (2e-6, 0.05);
/// Approach, over g h, from which frames show it: what comes back is in flight for more than three of them,
/// and weight changes it by half at most.
const FLIGHT: f64 = 2.0;
/// Frames between events of one motion.
const SAME_MOTION: f64 = 2.5;

/// A pair of bodies of an event, by the place of the event and those of the bodies in it.
pub(super) type PairOfEvent = (usize, [usize; 2]);

impl Scene<'_> {
    /// The pairs that roll through an event, of events in order of time.
    pub(super) fn rolling_pairs(&self, events: &[Event]) -> BTreeSet<PairOfEvent> {
        let pairs = |index: usize| {
            let pushing = events[index].points.iter().zip(&events[index].impulses);
            let pushing = pushing.filter(|(_, impulse)| impulse.length_squared() > 0.0);
            let pairs: BTreeSet<[usize; 2]> = pushing.map(|((contact, _), _)| contact.bodies).collect();
            pairs.into_iter().map(move |pair| (index, pair))
        };
        let all: Vec<PairOfEvent> = (0..events.len()).flat_map(pairs).collect();
        let approach = |(index, pair): &PairOfEvent| events[*index].approach(*pair);
        let rolls = |of: &&PairOfEvent| {
            let Approach { speed, returned } = approach(of);
            let event = &events[of.0];
            let least = if event.is_round(of.1) { RETURNED_BY_RIM } else { RETURNED };
            let least = least.max(self.restitution(of, events, speed) + ABOVE_RESTITUTION);
            // A slow body may be on the floor again before a frame shows its flight.
            let shows = speed > FLIGHT * self.world.gravity.length() * event.span(of.1);
            returned > least && shows && self.stay_together(event, of.1, speed) || self.is_guided(event, of.1)
        };
        let mut rolling: BTreeSet<PairOfEvent> = all.iter().filter(rolls).copied().collect();
        // What belongs to the same motion.
        let bodies = |(index, pair): &PairOfEvent| {
            let [a, b] = pair.map(|place| events[*index].members[place].body);
            if a < b { [a, b] } else { [b, a] }
        };
        let known: Vec<(f64, [BodyId; 2])> =
            rolling.iter().map(|of| (events[of.0].time, bodies(of))).collect();
        let mut last: BTreeMap<[BodyId; 2], (f64, f64)> = BTreeMap::new();
        for of in &all {
            let (event, speed) = (&events[of.0], approach(of).speed);
            let reach = SAME_MOTION * event.span(of.1);
            let from = known.partition_point(|(time, _)| *time < event.time - reach);
            let near = known[from..].iter().take_while(|(time, _)| *time <= event.time + reach);
            let is_near = near.into_iter().any(|(_, pair)| *pair == bodies(of));
            let before = last.get(&bodies(of)).copied();
            let goes_on = |(time, most): (f64, f64)| speed <= most && self.keep_touching(event, of.1, time);
            if before.is_some_and(goes_on) || is_near && self.stay_together(event, of.1, speed) {
                rolling.insert(*of);
            }
            if rolling.contains(of) {
                // A turn may have several jumps.
                let same = before.filter(|(time, _)| event.time - time <= reach);
                last.insert(bodies(of), (event.time, same.map_or(speed, |(_, most)| most.max(speed))));
            }
        }
        rolling
    }

    fn restitution(&self, (index, pair): &PairOfEvent, events: &[Event], speed: f64) -> f64 {
        let body = |place: usize| events[*index].members[place].body.index();
        let [a, b] = pair.map(|place| &self.world.bodies[body(place)].material);
        PairCoefficients::of(a, b).restitution.at(speed)
    }

    /// Whether the gap of a pair stays what it is at the frames around an event.
    fn stay_together(&self, event: &Event, pair: [usize; 2], speed: f64) -> bool {
        let Some((window, _)) = self.frames_of(event, pair) else { return false };
        let play = TOGETHER.0 + TOGETHER.1 * speed * window.span;
        self.keep_gap(event, pair, window.first.saturating_sub(1)..=window.last + 1, play)
    }

    /// Whether a pair has touched from an instant \[s\] to the frame after an event.
    fn keep_touching(&self, event: &Event, pair: [usize; 2], from: f64) -> bool {
        let Some((window, kinematics)) = self.frames_of(event, pair) else { return false };
        let first = kinematics.frames.partition_point(|frame| frame.time < from);
        self.keep_gap(event, pair, first..=window.last + 1, TOGETHER.0)
    }

    /// Whether a ball follows a surface through an event: its pushes go over into each other, what the
    /// surface gives is no more than these, and it touches the surface at all of their frames.
    fn is_guided(&self, event: &Event, pair: [usize; 2]) -> bool {
        let surfaces = pair.map(|place| &self.surfaces[event.members[place].body.index()]);
        let Some((window, kinematics)) = self.frames_of(event, pair) else { return false };
        if !surfaces.iter().any(|sampled| matches!(*sampled.surface, Surface::Sphere { .. })) {
            return false;
        }
        let size = surfaces.iter().map(|sampled| sampled.radius).fold(f64::INFINITY, f64::min);
        let gravity = self.world.gravity.length();
        let touches =
            |row: &Range<usize>| self.keep_gap(event, pair, row.start..=row.end - 1, TOUCHING.0 * size);
        // A ball between others that passes an impact on hardly moves: its own pushes are far smaller.
        let given: DVec3 = event.impulses_of(pair).sum();
        let pushed = |row: &Range<usize>| -> f64 {
            kinematics.jumps[row.clone()].iter().map(|jump| jump.velocity.length()).sum()
        };
        let is_of_row = |row: &Range<usize>| given.length() <= kinematics.inertia.mass * pushed(row);
        // The frames before the event too: what comes to rest on the surface has touched it since alone.
        lasting_rows(&kinematics.jumps, window.first, gravity).any(|row| is_of_row(&row) && touches(&row))
    }

    /// The window of the first of a pair that has one, and the frames of that body.
    fn frames_of(&self, event: &Event, pair: [usize; 2]) -> Option<(JumpWindow, &Kinematics<'_>)> {
        let members = pair.map(|place| event.members[place]);
        members.iter().find_map(|member| member.window.zip(self.kinematics[member.body.index()].as_ref()))
    }

    /// Whether the gap of a pair changes by no more than `play` \[m\] in a range of frames.
    fn keep_gap(&self, event: &Event, pair: [usize; 2], frames: RangeInclusive<usize>, play: f64) -> bool {
        let Some((_, kinematics)) = self.frames_of(event, pair) else { return false };
        let bodies = pair.map(|place| event.members[place].body);
        let last = kinematics.frames.len() - 1;
        let mut gaps = [f64::INFINITY, f64::NEG_INFINITY];
        (*frames.start()..=(*frames.end()).min(last)).all(|frame| {
            let time = kinematics.frames[frame].time;
            let [Some(one), Some(two)] = bodies.map(|body| self.pose_at(body, time)) else {
                return false;
            };
            let [a, b] = bodies;
            // The gap of two bodies that rest is unknown to the digits of their file.
            let within = if gaps[0].is_finite() { gaps[0] + play } else { TOUCHING.2 + play };
            let found = touches(self.placed(a, one), self.placed(b, two), within);
            let Some(gap) = found.iter().map(|touch| touch.gap).reduce(f64::min) else { return false };
            gaps = [gaps[0].min(gap), gaps[1].max(gap)];
            gaps[1] - gaps[0] <= play
        })
    }

    /// The pose of a body at an instant.
    pub(super) fn pose_at(&self, body: BodyId, time: f64) -> Option<Pose> {
        match &self.kinematics[body.index()] {
            Some(kinematics) => kinematics.at(time).map(|state| state.pose),
            None => Some(state_of_unrecorded(&self.world.bodies[body.index()], time).pose),
        }
    }
}

/// How fast a pair of an event approaches at its fastest point [m/s], and the share of that which comes back.
pub(super) struct Approach {
    pub(super) speed: f64,
    returned: f64,
}

impl Event {
    pub(super) fn approach(&self, pair: [usize; 2]) -> Approach {
        let [a, b] = pair.map(|place| self.members[place]);
        let [of_a, of_b] = pair.map(|place| self.change_of(place));
        let (mut before, mut after, mut speed) = (0.0, 0.0, 0.0_f64);
        for ((contact, _), impulse) in self.points.iter().zip(&self.impulses) {
            if contact.bodies != pair {
                continue;
            }
            let point = contact.point;
            let velocity = a.state.velocity_at(point) - b.state.velocity_at(point);
            let turned = of_a.1.cross(point - a.fit.centre) - of_b.1.cross(point - b.fit.centre);
            before -= impulse.dot(velocity);
            after += impulse.dot(velocity + of_a.0 - of_b.0 + turned);
            if impulse.length_squared() > 0.0 {
                speed = speed.max(-velocity.dot(contact.normal));
            }
        }
        Approach { speed, returned: if before > 0.0 { after / before } else { 0.0 } }
    }

    /// The impulses of a pair on its first body [N s].
    fn impulses_of(&self, pair: [usize; 2]) -> impl Iterator<Item = DVec3> {
        let all = self.points.iter().zip(&self.impulses);
        all.filter(move |((contact, _), _)| contact.bodies == pair).map(|(_, impulse)| *impulse)
    }

    /// Whether as many points of a pair are near as those of a rim.
    fn is_round(&self, pair: [usize; 2]) -> bool {
        self.points.iter().filter(|(contact, _)| contact.bodies == pair).count() >= RIM
    }

    /// Length of the frame of a pair around it \[s\].
    fn span(&self, pair: [usize; 2]) -> f64 {
        let [a, b] = pair.map(|place| self.members[place].window);
        a.or(b).map_or(0.0, |window| window.span)
    }

    /// Δv and Δω of a member by all impulses.
    pub(super) fn change_of(&self, place: usize) -> (DVec3, DVec3) {
        let body = &self.members[place].fit;
        let (impulse, moment) = self.given_to(place);
        (impulse * body.inverse_mass, body.inverse_inertia * moment)
    }

    /// The impulse [N s] on a member, and its moment about the centre of mass [N m s].
    pub(super) fn given_to(&self, place: usize) -> (DVec3, DVec3) {
        let centre = self.members[place].fit.centre;
        let (mut impulse, mut moment) = (DVec3::ZERO, DVec3::ZERO);
        for ((contact, _), push) in self.points.iter().zip(&self.impulses) {
            for (other, sign) in contact.bodies.into_iter().zip([1.0, -1.0]) {
                if other == place {
                    impulse += *push * sign;
                    moment += (contact.point - centre).cross(*push) * sign;
                }
            }
        }
        (impulse, moment)
    }
}
