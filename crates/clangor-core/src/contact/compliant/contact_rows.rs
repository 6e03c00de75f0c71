//! Rows of contact space: one direction at one contact, with what a force along it does to both bodies.
//!
//! ```text
//! separation along u:  ṡ = Σ_side ±(u·v + (r × u)·ω)      W = J M⁻¹ Jᵀ [1/kg]
//! ```

use glam::{DMat3, DVec3};

use super::member::{Member, MemberContact};

/// A body that a row pushes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RowSide {
    pub(super) member: usize,
    /// Force on the body per force of the row: u on A, −u on B.
    pub(super) push: DVec3,
    /// Its torque about the centre of mass \[m\].
    pub(super) torque: DVec3,
}

/// A direction at a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ContactRow {
    pub(super) sides: [Option<RowSide>; 2],
    /// Rate of separation besides that of the members [m/s].
    pub(super) own_speed: f64,
}

/// Rigid part of a member.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RigidMember {
    pub(super) inverse_mass: f64,
    pub(super) inverse_inertia: DMat3,
    pub(super) velocity: DVec3,
    pub(super) angular_velocity: DVec3,
    pub(super) acceleration: DVec3,
}

impl RigidMember {
    pub(super) fn new(member: &Member) -> Self {
        RigidMember {
            inverse_mass: member.inverse_mass,
            inverse_inertia: member.inverse_inertia,
            velocity: member.velocity,
            angular_velocity: member.angular_velocity,
            acceleration: member.acceleration,
        }
    }
}

impl ContactRow {
    /// The row of a contact along a unit vector.
    pub(super) fn new(contact: &MemberContact, direction: DVec3, members: &[Member]) -> Self {
        let side = |at: usize, sign: f64| {
            contact.members[at].map(|member| {
                let push = sign * direction;
                RowSide { member, push, torque: (contact.point - members[member].centre).cross(push) }
            })
        };
        ContactRow { sides: [side(0, 1.0), side(1, -1.0)], own_speed: contact.velocity.dot(direction) }
    }

    fn sum(&self, of_side: impl Fn(&RowSide) -> f64) -> f64 {
        self.sides.iter().flatten().map(of_side).sum()
    }

    /// Rate of separation [m/s].
    pub(super) fn velocity(&self, members: &[RigidMember]) -> f64 {
        self.own_speed
            + self.sum(|side| {
                let member = &members[side.member];
                side.push.dot(member.velocity) + side.torque.dot(member.angular_velocity)
            })
    }

    /// Its constant acceleration by gravity [m/s²].
    pub(super) fn acceleration(&self, members: &[RigidMember]) -> f64 {
        self.sum(|side| side.push.dot(members[side.member].acceleration))
    }

    /// The greatest acceleration by which gravity could bring the bodies together [m/s²], were one held.
    pub(super) fn greatest_pull(&self, members: &[RigidMember]) -> f64 {
        self.sum(|side| side.push.dot(members[side.member].acceleration).abs())
    }

    /// Acceleration along this row per force along another [1/kg].
    pub(super) fn coupling(&self, other: &ContactRow, members: &[RigidMember]) -> f64 {
        self.sum(|side| {
            let member = &members[side.member];
            let same = other.sides.iter().flatten().find(|b| b.member == side.member);
            same.map_or(0.0, |b| {
                member.inverse_mass * side.push.dot(b.push)
                    + side.torque.dot(member.inverse_inertia * b.torque)
            })
        })
    }
}
