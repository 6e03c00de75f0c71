//! Rows of an event: contacts of each pair of bodies, and the states of those that jump.

use std::collections::BTreeMap;

use clangor_core::material::PairCoefficients;
use clangor_core::timeline::{ContactKind, ContactRow, PoseRow};
use glam::DVec3;

use super::led_members::mass_beside_led;
use super::{Event, Member, MotionImpacts, Scene};

/// Smallest share of the largest impulse of a pair that is a row.
const SMALLEST_SHARE: f64 = 1e-4;
/// Least impulse of an impact, over that of one at the threshold of sound.
const GIVEN: f64 = 0.5;
/// Distance of points that are one contact, as a share of the smaller body.
const MERGED: f64 = 0.075;

impl Event {
    /// Writes the rows of each pair; those of a pair that rolls are no impact.
    pub(super) fn write(
        &self,
        scene: &Scene<'_>,
        (v_min, rolls): (f64, &dyn Fn([usize; 2]) -> bool),
        next_id: &mut u64,
        found: &mut MotionImpacts,
    ) {
        let mut pairs: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
        for (index, (contact, _)) in self.points.iter().enumerate() {
            pairs.entry(contact.bodies).or_default().push(index);
        }
        let mut is_heard = false;
        for (pair, points) in pairs {
            let [a, b] = pair.map(|place| self.members[place]);
            let normal_impulse = |index: usize| self.impulses[index].dot(self.points[index].0.normal);
            let largest = points.iter().map(|index| normal_impulse(*index)).fold(0.0, f64::max);
            let pushing: Vec<usize> = points
                .into_iter()
                .filter(|index| normal_impulse(*index) > SMALLEST_SHARE * largest)
                .collect();
            let sizes = pair.map(|place| scene.surfaces[self.members[place].body.index()].radius);
            let pushes = self.merged(&pushing, MERGED * sizes[0].min(sizes[1]));
            let strongest = pushes.iter().max_by(|a, b| a.normal_impulse().total_cmp(&b.normal_impulse()));
            let Some(strongest) = strongest.copied() else { continue };
            let velocity = |point: DVec3| a.state.velocity_at(point) - b.state.velocity_at(point);
            let approach = |push: &Push| -velocity(push.point).dot(push.normal);
            let mut speed = pushes.iter().map(approach).fold(0.0, f64::max);
            // The velocity of a supported body is uncertain by what gravity adds in a frame.
            let fall = scene.world.gravity.length() * a.window.or(b.window).map_or(0.0, |window| window.span);
            let least = if a.is_supported && b.is_supported { v_min + fall } else { v_min };
            // At a wrong instant the place of a turning body may recede: its impulse says how fast it met.
            let needed = scene.approach_of(&strongest, [&a, &b]);
            let uncertain = scene.uncertain_speed(&a).max(scene.uncertain_speed(&b));
            let is_missed = speed < least && needed >= least && approach(&strongest) + uncertain >= least;
            if is_missed {
                speed = needed;
            }
            // Far less than an impact at the threshold gives is what the fit of another impact leaves.
            let given = needed * sum_over(&pushes, &strongest);
            let is_impact = speed >= least && given >= GIVEN * v_min && !rolls(pair);
            let impact_id = if is_impact { *next_id } else { 0 };
            if is_impact {
                *next_id += 1;
                is_heard = true;
                found.confidence.insert(impact_id, (1.0 - self.residual).clamp(0.0, 1.0));
            }
            found.contacts.extend(pushes.into_iter().map(|Push { point, normal, impulse, gap }| {
                let mut relative = velocity(point);
                if is_missed && point == strongest.point {
                    relative -= normal * (relative.dot(normal) + speed);
                }
                ContactRow {
                    time: self.time,
                    body_a: a.body,
                    body_b: b.body,
                    kind: if is_impact { ContactKind::Impact } else { ContactKind::Contact },
                    point,
                    normal,
                    impulse_n: impulse.dot(normal),
                    impulse_t: impulse - normal * impulse.dot(normal),
                    couple: DVec3::ZERO,
                    velocity: relative,
                    depth: -gap,
                    impact_id,
                    effective_mass: if is_impact { mass_beside_led([&a, &b], point, normal) } else { None },
                }
            }));
        }
        if is_heard {
            let moving = self.members.iter().filter(|member| member.window.is_some());
            found.states.extend(moving.map(|member| PoseRow {
                time: self.time,
                body: member.body,
                position: member.state.pose.position,
                orientation: member.state.pose.orientation,
                velocity: member.state.velocity,
                angular_velocity: member.state.angular_velocity,
            }));
        }
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
            }
        };
        groups.into_iter().map(push).collect()
    }
}

/// The normal impulses of all over that of one of them.
fn sum_over(pushes: &[Push], one: &Push) -> f64 {
    pushes.iter().map(Push::normal_impulse).sum::<f64>() / one.normal_impulse()
}

impl Push {
    fn normal_impulse(&self) -> f64 {
        self.impulse.dot(self.normal)
    }
}

impl Scene<'_> {
    /// Approach speed of two bodies that an impulse drives apart with the restitution of their materials
    /// [m/s].
    fn approach_of(&self, push: &Push, pair: [&Member; 2]) -> f64 {
        let inverse = |member: &Member| member.inverse_mass_along(push.point, push.normal);
        let change = push.normal_impulse() * pair.map(inverse).iter().sum::<f64>();
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
struct Push {
    point: DVec3,
    normal: DVec3,
    impulse: DVec3,
    gap: f64,
}
