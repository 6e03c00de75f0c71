//! How heavy a contact is between bodies on joints whose poses are known, as in a recording.
//!
//! ```text
//! Δv = W J,  m = 1 / nᵀ W n        W: relative velocity at the point after unit impulses (`reactions`)
//! ```
//!
//! Ropes count as slack, and springs do not react in the time of an impact.

use clangor_core::body::{BodyId, World};
use clangor_core::pose::Pose;
use glam::{DMat3, DVec3};

use super::linkage::Linkages;
use super::mover::Mover;
use super::reactions::Reactions;
use super::state::BodyState;

/// The bodies of a world that joints hold.
pub struct JoinedBodies<'a> {
    world: &'a World,
    linkages: Linkages,
}

/// Where two bodies touch.
pub struct JoinedContact<'a> {
    /// The two bodies.
    pub bodies: [BodyId; 2],
    /// \[m, world\].
    pub point: DVec3,
    /// \[s\].
    pub time: f64,
    /// The poses of all bodies at that time.
    pub poses: &'a dyn Fn(BodyId) -> Pose,
}

/// Two bodies that touch, and what hangs together with them.
pub struct JoinedPair {
    movers: Vec<Mover>,
    reactions: Reactions,
    ends: [(usize, DVec3); 2],
}

impl<'a> JoinedBodies<'a> {
    /// The bodies on joints of a world that can be simulated, which are closed in its poses at the start;
    /// `None` if there are none.
    pub fn of(world: &'a World) -> Option<Self> {
        let bodies: Result<Vec<BodyState>, _> =
            world.bodies.iter().map(|body| BodyState::try_new(body, 0, 0.0)).collect();
        let linkages = Linkages::try_new(&world.links, &vec![None; world.links.len()], &bodies.ok()?).ok()?;
        (linkages.count() > 0).then_some(JoinedBodies { world, linkages })
    }

    /// Whether joints hold a body.
    pub fn hold(&self, body: BodyId) -> bool {
        self.linkages.of(body.index()).is_some()
    }

    /// How far the joints of a body and of all that hangs together with it are off at most \[m, or rad\], in
    /// these poses.
    pub fn gap(&self, body: BodyId, poses: &dyn Fn(BodyId) -> Pose) -> f64 {
        let Some(linkage) = self.linkages.of(body.index()) else { return 0.0 };
        let poses = |body: usize| poses(BodyId(body as u32));
        let joints = self.linkages.joints_of(linkage).iter().map(|&joint| &self.linkages.joints[joint]);
        joints.map(|joint| joint.gap(&poses)).fold(0.0, f64::max)
    }

    /// The two bodies of a contact; `None` if joints hold neither.
    pub fn pair(&self, contact: &JoinedContact<'_>) -> Option<JoinedPair> {
        let JoinedContact { bodies: pair, point, time, poses } = *contact;
        let mut chosen: Vec<usize> = pair.iter().filter_map(|body| self.linkages.of(body.index())).collect();
        chosen.dedup();
        if chosen.is_empty() {
            return None;
        }
        let mut bodies: Vec<usize> = pair.iter().map(|body| body.index()).collect();
        bodies.extend(chosen.iter().flat_map(|linkage| self.linkages.ends_of(*linkage)));
        bodies.sort_unstable();
        bodies.dedup();
        let movers: Vec<Mover> = bodies.iter().map(|body| self.mover(*body, time, poses)).collect();
        let number = |body: usize| bodies.partition_point(|other| *other < body);
        let place = |body: usize| (poses(BodyId(body as u32)), number(body));
        let mut reactions = Reactions::default();
        reactions.set_up(&self.linkages, (chosen.into_iter(), &[]), &place, (&movers, 0.0));
        let ends = pair.map(|body| (number(body.index()), point - poses(body).position));
        Some(JoinedPair { movers, reactions, ends })
    }

    fn mover(&self, body: usize, time: f64, poses: &dyn Fn(BodyId) -> Pose) -> Mover {
        let described = &self.world.bodies[body];
        let still = Mover {
            velocity: DVec3::ZERO,
            spin: DVec3::ZERO,
            inverse_mass: 0.0,
            inverse_inertia: DMat3::ZERO,
        };
        if !described.motion.is_movable_at(time) {
            return still;
        }
        let rotation = DMat3::from_quat(poses(BodyId(body as u32)).orientation);
        let inverse_inertia = rotation * described.inertia.inverse() * rotation.transpose();
        Mover { inverse_mass: described.mass.recip(), inverse_inertia, ..still }
    }
}

impl JoinedPair {
    /// W [1/kg]: what an impulse on the first body, and its opposite on the second, changes of the velocity
    /// of the first relative to the second at their point.
    pub fn mobility(&self) -> DMat3 {
        DMat3::from_cols_array_2d(
            &DVec3::AXES.map(|axis| self.reactions.response(&self.movers, self.ends, axis).to_array()),
        )
    }

    /// The effective mass \[kg\] of their contact along a unit normal, infinite where joints hold the point
    /// so well that nothing moves it.
    pub fn effective_mass(&mut self, normal: DVec3) -> f64 {
        let JoinedPair { movers, reactions, ends } = self;
        let mobility = reactions.response(movers, *ends, normal).dot(normal);
        if reactions.hold_point(movers, ends.map(|(number, _)| number), mobility) {
            return f64::INFINITY;
        }
        let masses = reactions.effective_masses(movers, &[(*ends, normal)]);
        masses.into_iter().flatten().next().unwrap_or(f64::INFINITY)
    }
}
