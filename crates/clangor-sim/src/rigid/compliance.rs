//! What the collision phase needs to solve contacts of bodies that give way.

use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Surface};
use clangor_core::contact::modal_energy::ModesOf;
use clangor_core::contact::{ContactSide, GroupSolver};
use clangor_core::material::{Material, PairRestitution};
use clangor_core::pose::Pose;

use super::pair::Pair;

/// The modes of bodies, and from which approach speed on they matter.
#[derive(Clone, Copy)]
pub struct ContactModes<'m> {
    /// Modes of each body that has any.
    pub modes: ModesOf<'m>,
    /// Slower impacts follow the law of rigid bodies [m/s].
    pub v_min: f64,
    /// Whether the log says what solved impacts do to each body over time.
    pub followed: bool,
}

/// A body as it gives way, without its pose.
pub(super) struct BodySide {
    pub(super) side: ContactSide,
    pub(super) surface: Arc<Surface>,
}

impl BodySide {
    pub(super) fn new(id: BodyId, body: &Body) -> Self {
        BodySide { side: ContactSide::of_body(id, body, Pose::IDENTITY), surface: Arc::clone(&body.surface) }
    }
}

/// What a solve needs besides the block.
pub(super) struct Compliance<'a> {
    pub(super) modes: ContactModes<'a>,
    pub(super) sides: &'a [BodySide],
    pub(super) materials: &'a [Material],
    pub(super) solver: &'a mut GroupSolver,
}

impl Compliance<'_> {
    /// Whether a body has modes.
    pub(super) fn vibrates(&self, body: usize) -> bool {
        (self.modes.modes)(BodyId(body as u32), &[]).is_some()
    }

    /// Whether a body takes energy from impacts: by its modes, or as an endless plate.
    pub(super) fn gives_way(&self, body: usize) -> bool {
        self.sides[body].side.plate_mobility > 0.0 || self.vibrates(body)
    }

    /// Restitution of a pair by the law of rigid bodies: that of whole bodies, if one of them has modes.
    pub(super) fn whole_restitution(&self, pair: &Pair) -> PairRestitution {
        let [a, b] = pair.ends();
        match self.vibrates(a) || self.vibrates(b) {
            true => PairRestitution::of_whole_bodies(&self.materials[a], &self.materials[b]),
            false => pair.coefficients.restitution,
        }
    }
}
