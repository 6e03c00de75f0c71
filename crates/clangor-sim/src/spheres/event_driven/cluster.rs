//! A cluster of touching balls and planes at one instant.

use clangor_core::timeline::{ContactRow, PoseRow};
use glam::DVec3;

use crate::spheres::impact::{ImpulsePair, Member, Touch};

/// A ball or a plane of the simulation.
#[derive(Clone, Copy, Debug)]
pub(super) enum Participant {
    /// Index of a ball.
    Ball(usize),
    /// Index of a plane.
    Plane(usize),
}

/// A cluster of touching balls and planes at one instant.
#[derive(Default)]
pub(super) struct Cluster {
    pub(super) participants: Vec<Participant>,
    pub(super) members: Vec<Member>,
    pub(super) positions: Vec<DVec3>,
    pub(super) touches: Vec<Touch>,
    pub(super) impulse_pairs: Vec<ImpulsePair>,
    /// Velocity and angular velocity of the members before the impact.
    pub(super) before: Vec<(DVec3, DVec3)>,
    pub(super) near: Vec<usize>,
    pub(super) rows: Vec<ContactRow>,
    pub(super) poses: Vec<PoseRow>,
}

impl Cluster {
    /// Empties the cluster.
    pub(super) fn clear(&mut self) {
        self.participants.clear();
        self.members.clear();
        self.positions.clear();
        self.touches.clear();
        self.impulse_pairs.clear();
        self.before.clear();
    }
}
