//! What the pairs of an event do to each other: which of them hit, and which pass an impact on.
//!
//! A pair hits if it approaches at the threshold of sound and has a part of the impulse of such an impact. A
//! body that is alone with what nothing moves must approach it by a part of what the impulse changes, too.
//! The surfaces of a pile, or the balls of a cradle, touch when an impact meets one of them: they do not
//! approach, but in the time of the impact each is driven against the next one. Such a pair passes on an
//! impulse J, as in an impact at
//!
//! ```text
//! v = J / m (1 + e)        m: effective mass at the centre of the pushes of the pair
//! ```
//!
//! if v is above the threshold, its surfaces rest on each other before, and a hit that drives them together
//! reaches it through pairs that pass it on within a frame. Steady loads are no part of J: what holds a body
//! before or after its impact is taken from its jump.

use std::collections::{BTreeMap, BTreeSet};

use clangor_core::body::BodyId;
use clangor_core::material::PairCoefficients;
use glam::DVec3;

use super::{Event, Member, Scene};

/// Smallest share of the largest impulse of a pair that is a row.
const SMALLEST_SHARE: f64 = 1e-4;
/// Least impulse of an impact, over that of one at the threshold of sound.
const GIVEN: f64 = 0.5;
/// Least mean approach of the points of a body that meets what nothing moves, over what all impulses change
/// of it.
const LEAST_APPROACH: f64 = 0.15;
/// Distance of points that are one contact, as a share of the smaller body.
const MERGED: f64 = 0.075;
/// Largest relative velocity along the normal of surfaces that rest on each other [m/s], and its part that
/// gravity gives in a frame; the same across it. What slides fast, turns or parts passes nothing on: what a
/// fit says of it is uncertain.
const RESTS: (f64, f64) = (0.006, 0.3);
const SLIDES: f64 = 0.1;
/// Part of the speed of an impact with the same impulse that both may have beyond that.
const RESTS_BESIDE: f64 = 0.05;
/// Least part of an impulse along which the one that causes it drives the body. A hinge or a wrong fit gives
/// the rest of it.
const DRIVEN: f64 = 0.3;
/// Frames between events of which one passes on what the other one gives.
const AT_ONCE: f64 = 1.01;

/// What two bodies of an event do to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Met {
    /// They meet fast and hard enough for an impact.
    Hit,
    /// They pass on an impact.
    PassOn,
    /// Neither.
    Press,
}

/// A pair of bodies of an event, by their places in it, and what pushes them apart.
pub(super) struct Meeting {
    pub(super) pair: [usize; 2],
    pub(super) pushes: Vec<Push>,
    pub(super) met: Met,
    /// Speed of an impact with all its pushes [m/s].
    pub(super) speed: f64,
}

/// Of a meeting: the event, and which of its meetings.
type Place = (usize, usize);

/// Pairs that would pass on an impact press only where none reaches them. `meetings` are those of each event.
pub(super) fn hear(events: &[Event], meetings: &mut [Vec<Meeting>]) {
    let all = meetings.iter().enumerate().flat_map(|(event, of)| (0..of.len()).map(move |k| (event, k)));
    let all: Vec<Place> = all.collect();
    // The moving bodies of a pair, and what it gives to each; the pairs of each body.
    let given = |(event, k): Place| {
        let meeting = &meetings[event][k];
        let impulse: DVec3 = meeting.pushes.iter().map(|push| push.impulse).sum();
        let members = meeting.pair.map(|place| &events[event].members[place]).into_iter().zip([1.0, -1.0]);
        let moving = members.filter(|(member, _)| member.fit.inverse_mass > 0.0);
        moving.map(move |(member, sign)| (member.body, impulse * sign))
    };
    let mut of_body: BTreeMap<BodyId, Vec<(Place, DVec3)>> = BTreeMap::new();
    for of in &all {
        given(*of).for_each(|(body, impulse)| of_body.entry(body).or_default().push((*of, impulse)));
    }
    // From pair to pair, beginning with those that hit.
    let met = |(event, k): Place| meetings[event][k].met;
    let mut next: Vec<Place> = all.iter().copied().filter(|of| met(*of) == Met::Hit).collect();
    let mut heard: BTreeSet<Place> = next.iter().copied().collect();
    while let Some(one) = next.pop() {
        let reach = events[one.0].reach();
        for (body, push) in given(one) {
            for (other, back) in of_body[&body].iter().copied() {
                let is_near = (events[other.0].time - events[one.0].time).abs() <= reach;
                let drives = -push.dot(back) >= DRIVEN * back.length_squared();
                if is_near && drives && met(other) == Met::PassOn && heard.insert(other) {
                    next.push(other);
                }
            }
        }
    }
    for (event, k) in all.into_iter().filter(|of| !heard.contains(of)) {
        meetings[event][k].met = Met::Press;
    }
}

impl Event {
    /// The pairs that push each other; those that roll do not hit.
    pub(super) fn meetings(
        &self,
        scene: &Scene<'_>,
        v_min: f64,
        rolls: impl Fn([usize; 2]) -> bool,
    ) -> Vec<Meeting> {
        let mut pairs: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
        for (index, (contact, _)) in self.points.iter().enumerate() {
            pairs.entry(contact.bodies).or_default().push(index);
        }
        let meeting = |(pair, points)| {
            let found = self.meeting(scene, v_min, (pair, points))?;
            Some(if rolls(pair) { Meeting { met: Met::Press, ..found } } else { found })
        };
        pairs.into_iter().filter_map(meeting).collect()
    }

    fn meeting(&self, scene: &Scene<'_>, v_min: f64, of: ([usize; 2], Vec<usize>)) -> Option<Meeting> {
        let (pair, points) = of;
        let [a, b] = pair.map(|place| self.members[place]);
        let normal_impulse = |index: usize| self.impulses[index].dot(self.points[index].0.normal);
        let largest = points.iter().map(|index| normal_impulse(*index)).fold(0.0, f64::max);
        let pushing: Vec<usize> =
            points.into_iter().filter(|index| normal_impulse(*index) > SMALLEST_SHARE * largest).collect();
        let sizes = pair.map(|place| scene.surfaces[self.members[place].body.index()].radius);
        let near = MERGED * sizes[0].min(sizes[1]);
        let mut pushes =
            self.pushes_on_joints(scene, pair, near).unwrap_or_else(|| self.merged(&pushing, near));
        let strength = |push: &Push| push.normal_impulse();
        let order = |a: &usize, b: &usize| strength(&pushes[*a]).total_cmp(&strength(&pushes[*b]));
        let place = (0..pushes.len()).max_by(order)?;
        let strongest = pushes[place];
        let velocity = |point: DVec3| a.state.velocity_at(point) - b.state.velocity_at(point);
        let approach = |push: &Push| -velocity(push.point).dot(push.normal);
        // The velocity of a supported body is uncertain by what gravity adds in a frame, along gravity.
        let fall = scene.world.gravity.length() * a.window.or(b.window).map_or(0.0, |window| window.span);
        let along = fall * strongest.normal.dot(scene.world.gravity.normalize_or_zero()).abs();
        let least = if a.is_supported && b.is_supported { v_min + along } else { v_min };
        // At a wrong instant the place of a turning body may recede: its impulse says how fast it met.
        let of_strongest = scene.approach_of(&strongest, [&a, &b]);
        let given = of_strongest * pushes.iter().map(strength).sum::<f64>() / strength(&strongest);
        // In long frames the points share one impulse.
        let needed = if self.is_coarse() { given } else { of_strongest };
        let uncertain = scene.uncertain_speed(&a).max(scene.uncertain_speed(&b));
        let is_fast = pushes.iter().map(approach).fold(0.0, f64::max) >= least;
        let is_missed = needed >= least && approach(&strongest) + uncertain >= least;
        let whole = *self.merged(&pushing, f64::INFINITY).first()?;
        let speed = scene.approach_of(&whole, [&a, &b]);
        // What hardly approaches where it is driven off is led: a box that is tipped on its edge, whose fit
        // needs another corner.
        let of_push = |value: &dyn Fn(&Push) -> f64| -> f64 {
            let sum: f64 = pushes.iter().map(|push| value(push) * strength(push)).sum();
            sum / pushes.iter().map(strength).sum::<f64>()
        };
        let change = |push: &Push| self.change_at(pair, push.point).dot(push.normal);
        // What others drive may approach from rest within the frame.
        let is_alone = self.members.iter().filter(|member| member.fit.inverse_mass > 0.0).count() == 1;
        let comes = !is_alone || of_push(&approach) + uncertain >= LEAST_APPROACH * of_push(&change);
        // Far less than an impact at the threshold gives is what the fit of another impact leaves.
        let hits = (is_missed || is_fast) && comes && given >= GIVEN * v_min;
        if is_missed && !is_fast {
            pushes[place].approach = Some(needed);
        }
        let relative = velocity(whole.point);
        let parting = relative.dot(whole.normal);
        let across = (relative - whole.normal * parting).length();
        let more = RESTS.1 * fall + RESTS_BESIDE * speed;
        let rests = parting.abs() <= RESTS.0 + more && across <= SLIDES + more;
        let met = match speed >= least && rests {
            _ if hits => Met::Hit,
            true => Met::PassOn,
            false => Met::Press,
        };
        Some(Meeting { pair, pushes, met, speed })
    }

    /// What all impulses change of the relative velocity of a pair at a point [m/s].
    fn change_at(&self, pair: [usize; 2], point: DVec3) -> DVec3 {
        let [a, b] = pair.map(|place| {
            let (velocity, angular_velocity) = self.change_of(place);
            velocity + angular_velocity.cross(point - self.members[place].fit.centre)
        });
        a - b
    }

    /// How far from it in time an impact may be passed on \[s\].
    fn reach(&self) -> f64 {
        let spans = self.members.iter().filter_map(|member| member.window).map(|window| window.span);
        AT_ONCE * spans.fold(0.0, f64::max)
    }

    /// Points that push, those within `near` \[m\] of a stronger one joined with it: samples of one contact.
    fn merged(&self, pushing: &[usize], near: f64) -> Vec<Push> {
        let mut order = pushing.to_vec();
        order.sort_by(|a, b| self.impulses[*b].length().total_cmp(&self.impulses[*a].length()));
        let mut groups: Vec<(DVec3, Vec<usize>)> = Vec::new();
        for index in order {
            let point = self.points[index].0.point;
            match groups.iter_mut().find(|(centre, _)| centre.distance(point) < near) {
                Some((_, group)) => group.push(index),
                None => groups.push((point, vec![index])),
            }
        }
        let push = |(_, group): (DVec3, Vec<usize>)| {
            let weight = |index: usize| self.impulses[index].dot(self.points[index].0.normal);
            let total: f64 = group.iter().map(|index| weight(*index)).sum();
            let mean = |of: &dyn Fn(usize) -> DVec3| -> DVec3 {
                group.iter().map(|index| of(*index) * (weight(*index) / total)).sum()
            };
            Push {
                point: mean(&|index| self.points[index].0.point),
                normal: mean(&|index| self.points[index].0.normal).normalize(),
                impulse: group.iter().map(|index| self.impulses[*index]).sum(),
                gap: self.points[group[0]].1.gap,
                approach: None,
            }
        };
        groups.into_iter().map(push).collect()
    }
}

impl Scene<'_> {
    /// Approach speed of two bodies that an impulse drives apart with the restitution of their materials
    /// [m/s].
    fn approach_of(&self, push: &Push, pair: [&Member; 2]) -> f64 {
        let inverse = |member: &Member| member.inverse_mass_along(push.point, push.normal);
        let free = || pair.map(inverse).iter().sum::<f64>();
        let on_joints = self.mass_on_joints(pair, push.point, push.normal);
        let change = push.normal_impulse() * on_joints.map_or_else(free, f64::recip);
        let [a, b] = pair.map(|member| &self.world.bodies[member.body.index()].material);
        change / (1.0 + PairCoefficients::of(a, b).restitution.at(change))
    }

    /// What the velocity of a place of a turning body changes by in a frame, h ω² R [m/s].
    fn uncertain_speed(&self, member: &Member) -> f64 {
        let Some(window) = member.window else { return 0.0 };
        let radius = self.surfaces[member.body.index()].radius;
        window.span * member.state.angular_velocity.length_squared() * radius
    }
}

/// The impulse of one contact.
#[derive(Clone, Copy)]
pub(super) struct Push {
    pub(super) point: DVec3,
    pub(super) normal: DVec3,
    pub(super) impulse: DVec3,
    pub(super) gap: f64,
    /// Approach speed that it needs, where the states do not say it [m/s].
    pub(super) approach: Option<f64>,
}

impl Push {
    fn normal_impulse(&self) -> f64 {
        self.impulse.dot(self.normal)
    }
}
