//! The force of an impact of two bodies over time, where the dynamics did not solve it: Hertz's contact with
//! the loss of the material.
//!
//! ```text
//! m d̈ = −F    F = k d^{3/2} + α √(k m) d^{1/4} ḋ        at every point of the impact
//! ```
//!
//! The two bodies move as before the impact and do not vibrate. Points, normal and stiffness are those of the
//! pulse of rigid bodies.
//!
//! Not covered: other bodies that touch at that instant; the vibration of the two.

use clangor_core::body::{Body, BodyId};
use clangor_core::contact::{
    ContactSide, GroupContact, GroupImpact, GroupMember, GroupSolver, ImpactPulse, LoadHistory, Spread,
    Touch, no_modes, touching,
};
use clangor_core::pose::Pose;
use glam::DVec3;

use super::contact_loads::PairImpact;

/// What each of the two bodies feels; `None` if the contact cannot be solved.
pub(super) fn pair_histories(
    impact: &PairImpact<'_>,
    pulse: &ImpactPulse,
    solver: &mut GroupSolver,
) -> Option<[LoadHistory; 2]> {
    let coefficients = impact.coefficients()?;
    let ids = impact.ids()?;
    let member = |i: usize| member(ids[i], impact.bodies[i], impact);
    let members = [member(0), member(1)];
    let strongest = impact.rows.iter().max_by(|a, b| a.impulse_n.total_cmp(&b.impulse_n))?;
    let sides = members.map(|member| member.side);
    let size = sides[0].bounding_radius.min(sides[1].bounding_radius);
    let touch = Touch {
        surfaces: impact.bodies.map(|body| body.map(|body| &*body.surface)),
        normal: pulse.normal,
        place: strongest.point,
        speed: pulse.speed,
        spread: Spread::of_places(pulse.points.iter().map(|(place, _)| *place), size, 0.0),
    };
    let sides = touching(sides, &touch);
    let velocity = |i: usize, place: DVec3| {
        let GroupMember { side, velocity, angular_velocity } = members[i];
        velocity + angular_velocity.cross(place - side.pose.position)
    };
    let contact = |(place, _): &(DVec3, DVec3)| GroupContact {
        members: [0, 1],
        sides,
        place: *place,
        normal: pulse.normal,
        gap: 0.0,
        approach: (velocity(1, *place) - velocity(0, *place)).dot(pulse.normal),
        restitution: coefficients.restitution.at(pulse.speed),
        friction: coefficients.friction,
    };
    let contacts: Vec<GroupContact> = pulse.points.iter().map(contact).collect();
    let group = GroupImpact { time: pulse.time, members: &members, contacts: &contacts, followed: true };
    solver.solve(&group, &no_modes)?;
    solver.load_history(&group, 0).zip(solver.load_history(&group, 1)).map(|(a, b)| [a, b])
}

/// A body as it was before the impact; one without a pose there does not move.
fn member(id: BodyId, body: Option<&Body>, impact: &PairImpact<'_>) -> GroupMember {
    let Some(body) = body else {
        let side = ContactSide::SURROUNDINGS;
        return GroupMember { side, velocity: DVec3::ZERO, angular_velocity: DVec3::ZERO };
    };
    match impact.poses.iter().rev().find(|row| row.body == id) {
        Some(row) => GroupMember {
            side: ContactSide::of_body(
                id,
                body,
                Pose { position: row.position, orientation: row.orientation },
            ),
            velocity: row.velocity,
            angular_velocity: row.angular_velocity,
        },
        None => GroupMember {
            side: ContactSide::of_body(id, body, body.pose),
            velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
        },
    }
}
