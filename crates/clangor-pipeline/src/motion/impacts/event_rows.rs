//! Rows of an event: contacts of each pair of bodies, and the states of those that jump.

use clangor_core::timeline::{ContactKind, ContactRow, PoseRow};
use glam::DVec3;

use super::led_members::mass_beside_led;
use super::meetings::{Meeting, Met, Push};
use super::{Event, Member, MotionImpacts, Scene};

impl Event {
    /// Writes the rows of each pair.
    pub(super) fn write(
        &self,
        scene: &Scene<'_>,
        meetings: Vec<Meeting>,
        next_id: &mut u64,
        found: &mut MotionImpacts,
    ) {
        let is_heard = meetings.iter().any(|meeting| meeting.met != Met::Press);
        for Meeting { pair, pushes, met, speed } in meetings {
            let [a, b] = pair.map(|place| self.members[place]);
            let is_impact = met != Met::Press;
            let passed = (met == Met::PassOn).then_some(speed);
            let impact_id = if is_impact { *next_id } else { 0 };
            if is_impact {
                *next_id += 1;
                found.confidence.insert(impact_id, (1.0 - self.residual).clamp(0.0, 1.0));
            }
            found.contacts.extend(pushes.into_iter().map(
                |Push { point, normal, impulse, gap, approach }| {
                    let mut relative = a.state.velocity_at(point) - b.state.velocity_at(point);
                    if let Some(speed) = approach.or(passed) {
                        relative -= normal * (relative.dot(normal) + speed);
                    }
                    let mass = || {
                        let on_joints = scene.mass_on_joints([&a, &b], point, normal);
                        on_joints
                            .or_else(|| mass_beside_led([&a, &b], point, normal))
                            .filter(|mass| mass.is_finite())
                    };
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
                        effective_mass: is_impact.then(mass).flatten(),
                    }
                },
            ));
        }
        if is_heard {
            // Those at rest too: they show where a chain is struck.
            let moving = |member: &&Member| member.window.is_some() || member.fit.inverse_mass > 0.0;
            let moving = self.members.iter().filter(moving);
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
}
