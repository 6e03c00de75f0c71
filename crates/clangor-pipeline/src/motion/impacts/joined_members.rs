//! Bodies of an event that joints of the scene hold: heavier in a contact than free ones.
//!
//! ```text
//! W J = Δv,  |J_t| ≤ μ J_n        m = 1 / nᵀ W n        at the centre of the pushes of a pair
//! ```
//!
//! with their sum J, the jump Δv of the relative velocity there, and what W J an impulse changes of it,
//! joints reacting ([`JoinedBodies`](clangor_sim::rigid::JoinedBodies)). A joint answers an impulse in its
//! time, so that the momentum which a body gains is not what it was given: J of a fit of free bodies is wrong
//! where nothing else says it. A free body that meets one on joints says it, as one that meets a hand does
//! (`led_members`).
//!
//! The motion must be that of the joints: one that has left them by more than a part of the body moves free
//! bodies. Not for two pairs of one event, whose impulses the jumps do not tell apart.

use clangor_core::body::BodyId;
use clangor_sim::rigid::{JoinedContact, JoinedPair};
use glam::{DMat3, DVec3};

use super::led_members::jump_at;
use super::meetings::Push;
use super::{Event, Member, Scene};
use crate::motion::impulse_fit::FitContact;
use crate::motion::open_joints::{are_closed, pose_between};
use crate::motion::touch::Touch;

/// Mobility across the normal, over that along it, below which joints block a direction.
const BLOCKED: f64 = 0.02;

impl Scene<'_> {
    /// The effective mass of two members along a normal at a point, with the joints of the scene \[kg\],
    /// infinite where these hold the point; `None` if they hold neither member, or if the motion has left
    /// them.
    pub(super) fn mass_on_joints(&self, pair: [&Member; 2], point: DVec3, normal: DVec3) -> Option<f64> {
        self.pair_on_joints(pair, point).map(|mut joined| joined.effective_mass(normal))
    }

    fn pair_on_joints(&self, pair: [&Member; 2], point: DVec3) -> Option<JoinedPair> {
        let joined = self.joined.as_ref()?;
        let bodies = pair.map(|member| member.body);
        if !bodies.iter().any(|body| joined.hold(*body)) {
            return None;
        }
        let time = pair[0].time;
        let frames = |body: BodyId| {
            let frames = self.kinematics[body.index()].as_ref().map_or(&[][..], |known| known.frames);
            pose_between(&self.world.bodies[body.index()], frames, time)
        };
        if !are_closed((self.world, joined), bodies, &frames) {
            return None;
        }
        let poses = |body: BodyId| {
            let member = pair.iter().find(|member| member.body == body);
            member.map_or_else(|| frames(body), |member| member.state.pose)
        };
        joined.pair(&JoinedContact { bodies, point, time, poses: &poses })
    }

    /// Whether a member is one that a joint holds, or nothing moves.
    fn hangs_or_stands(&self, member: &Member) -> bool {
        let is_joined = self.joined.as_ref().is_some_and(|joined| joined.hold(member.body));
        is_joined || self.kinematics[member.body.index()].is_none()
    }
}

impl Event {
    /// What pushes a pair apart, if it is the only one and joints hold it; points within `near` \[m\] of
    /// another one are one contact. `None` otherwise.
    ///
    /// A linkage moves alike whatever point is pushed, so that its jumps do not say where it is, and a fit of
    /// free bodies pushes where these would move so. The points are therefore those with the smallest gap, as
    /// in an impact of faces that land flat (`flat_impacts`), of those that the joints do not hold.
    pub(super) fn pushes_on_joints(
        &self,
        scene: &Scene<'_>,
        pair: [usize; 2],
        near: f64,
    ) -> Option<Vec<Push>> {
        let [a, b] = pair.map(|place| &self.members[place]);
        let pushing = self.points.iter().zip(&self.impulses);
        let mut pushing = pushing.filter(|(_, impulse)| impulse.length_squared() > 0.0);
        if !pushing.all(|((contact, _), _)| contact.bodies == pair)
            || ![a, b].into_iter().all(|member| scene.hangs_or_stands(member))
        {
            return None;
        }
        let moves = |index: &usize| {
            let FitContact { bodies, point, normal, .. } = self.points[*index].0;
            let mass = || scene.mass_on_joints([a, b], point, normal);
            bodies == pair && mass().is_some_and(f64::is_finite)
        };
        let gap = |index: usize| self.points[index].1.gap;
        let mut own: Vec<usize> = (0..self.points.len()).filter(moves).collect();
        own.sort_by(|a, b| gap(*a).total_cmp(&gap(*b)));
        let first = *own.first()?;
        let closed = self.closed_gap(scene, first).max(f64::MIN_POSITIVE);
        let mut shares: Vec<(usize, f64)> = Vec::new();
        for index in own {
            let open = (gap(index) - gap(first)) / closed;
            let point = self.points[index].0.point;
            let is_known = shares.iter().any(|(other, _)| self.points[*other].0.point.distance(point) < near);
            if (open < 1.0 || index == first) && !is_known {
                shares.push((index, (1.0 - open).powi(2)));
            }
        }
        let whole: f64 = shares.iter().map(|(_, share)| share).sum();
        let mean = |of: fn(&FitContact) -> DVec3| -> DVec3 {
            shares.iter().map(|(index, share)| of(&self.points[*index].0) * (share / whole)).sum()
        };
        let (point, normal) = (mean(|one| one.point), mean(|one| one.normal).normalize_or_zero());
        let change = jump_at(a, point) - jump_at(b, point);
        let mobility = scene.pair_on_joints([a, b], point)?.mobility();
        let given = impulse_of_jump(&mobility, change, (normal, self.points[first].0.friction))?;
        let push = |(index, share): (usize, f64)| {
            let (FitContact { point, normal, .. }, Touch { gap, .. }) = self.points[index];
            Push { point, normal, impulse: given * (share / whole), gap, approach: None }
        };
        Some(shares.into_iter().map(push).collect())
    }
}

/// The impulse that changes a velocity within the cone of friction μ about a unit normal; `None` where none
/// does. In a direction that joints block across the normal it has no part: what changes there, as by the
/// weight that a hinge holds, is none of its doing.
fn impulse_of_jump(mobility: &DMat3, change: DVec3, (normal, friction): (DVec3, f64)) -> Option<DVec3> {
    let own = normal.dot(*mobility * normal);
    let project = |axis: DVec3| axis.reject_from_normalized(normal).to_array();
    let across = DMat3::from_cols_array_2d(&DVec3::AXES.map(project));
    // Tikhonov's solution of W J = Δv, of the part of Δv that it can reach.
    let inverse = (*mobility + across * (BLOCKED * own)).inverse();
    let free = inverse * (*mobility * (inverse * change));
    let along = free.reject_from_normalized(normal);
    let limit = friction * free.dot(normal);
    let direction = if along.length() <= limit {
        free / free.dot(normal)
    } else {
        normal + along.normalize_or_zero() * friction
    };
    let given = change.dot(normal) / normal.dot(*mobility * direction);
    (given.is_finite() && given > 0.0).then(|| direction * given)
}
