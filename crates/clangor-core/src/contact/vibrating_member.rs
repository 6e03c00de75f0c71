//! A body of an impact with its vibration, as a member of a solve of the contact.
//!
//! ```text
//! side, modes at its points, ringing ─► poles, states, shapes at every point, tails above the last mode
//! ```
//!
//! A body keeps its vibration from impact to impact. It then meets the next one with its surface where the
//! vibration has brought it: the gap of the rigid surfaces is less by the displacement of its modes
//! ([`opening`](VibratingMember::opening)).

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glam::{DMat3, DVec3};
use num_complex::Complex64;

use super::compliant::{Member, ModalTail, modal_tail};
use super::contact_side::ContactSide;
use super::modal_energy::ModesAtContact;
use crate::body::BodyId;

/// Damping ratio from which a mode does not vibrate.
const MAX_RATIO: f64 = 0.9;

/// λ of the modes of a body; 0 for one that does not vibrate.
pub(super) fn modal_poles(modes: &ModesAtContact) -> Vec<Complex64> {
    let pole = |(frequency, ratio): (&f64, &f64)| {
        let omega = TAU * frequency;
        if *frequency > 0.0 && (0.0..MAX_RATIO).contains(ratio) {
            Complex64::new(-ratio * omega, omega * (1.0 - ratio * ratio).sqrt())
        } else {
            Complex64::ZERO
        }
    };
    modes.frequencies.iter().zip(&modes.damping_ratios).map(pole).collect()
}

/// How a body rings at a time.
#[derive(Clone, Debug)]
struct Ringing {
    time: f64,
    /// w = q̇ − λ̄q of each mode [m kg^½/s].
    state: Vec<Complex64>,
    /// ½ Σ (q̇² + |λ|² q²) \[J\].
    energy: f64,
}

/// The vibration of bodies between impacts.
#[derive(Clone, Debug, Default)]
pub(super) struct RingingBodies {
    bodies: BTreeMap<BodyId, Ringing>,
}

impl RingingBodies {
    /// Keeps the states of the modes of a body at a time.
    pub(super) fn set(&mut self, body: BodyId, time: f64, poles: &[Complex64], state: Vec<Complex64>) {
        let energy = |(w, pole): (&Complex64, &Complex64)| {
            let displacement = if pole.im > 0.0 { w.im / pole.im } else { 0.0 };
            let rate = w.re + pole.re * displacement;
            0.5 * (rate * rate + pole.norm_sqr() * displacement * displacement)
        };
        let energy = state.iter().zip(poles).map(energy).sum();
        self.bodies.insert(body, Ringing { time, state, energy });
    }

    /// Forgets a body.
    pub(super) fn remove(&mut self, body: BodyId) {
        self.bodies.remove(&body);
    }

    /// How a body with these poles rings at a time, without new forces.
    ///
    /// Impacts may overlap. Before the end of the last one the vibration has its phase, but no more
    /// amplitude.
    pub(super) fn state_at(&self, body: BodyId, poles: &[Complex64], time: f64) -> Vec<Complex64> {
        match self.bodies.get(&body).filter(|ringing| ringing.state.len() == poles.len()) {
            None => vec![Complex64::ZERO; poles.len()],
            Some(Ringing { time: since, state, .. }) => {
                let passed = time - since;
                let turn =
                    |pole: &Complex64| Complex64::new(pole.re * passed.max(0.0), pole.im * passed).exp();
                state.iter().zip(poles).map(|(w, pole)| w * turn(pole)).collect()
            }
        }
    }

    /// Energy of all vibration, that of each body when it was last kept \[J\].
    pub(super) fn energy(&self) -> f64 {
        self.bodies.values().map(|ringing| ringing.energy).sum()
    }
}

/// A body of an impact, with its modes at the points of its contacts.
pub(super) struct VibratingMember {
    /// The body with its modes, those of tails last.
    pub(super) member: Member,
    /// λ of its known modes; 0 for those that do not vibrate.
    pub(super) poles: Vec<Complex64>,
    /// U [kg^−½] of all modes at each of its points, in the axes of the world; empty without modes.
    pub(super) shapes: Vec<Vec<DVec3>>,
}

impl VibratingMember {
    /// A body at rest, that vibrates as `ringing` has it at `time` \[s\].
    ///
    /// `contacts` has, for each of the points of `modes`, the unit normal of the contact \[world\] and the
    /// duration τ of rigid bodies \[s\].
    pub(super) fn new(
        side: &ContactSide,
        modes: Option<&ModesAtContact>,
        contacts: &[(DVec3, f64)],
        (ringing, time): (&RingingBodies, f64),
    ) -> Self {
        let mut member = rigid_member(side);
        let Some(modes) = modes else {
            let shapes = vec![Vec::new(); contacts.len()];
            return VibratingMember { member, poles: Vec::new(), shapes };
        };
        let poles = modal_poles(modes);
        let tails = tails(side, modes, contacts);
        // A mode that does not vibrate has no shape; any pole serves.
        let pole = |pole: &Complex64| if pole.im > 0.0 { *pole } else { Complex64::new(0.0, 1.0) };
        let above = tails.iter().flat_map(|tail| tail.poles.iter().copied());
        member.poles = poles.iter().map(pole).chain(above).collect();
        member.state = ringing.state_at(side.body, &poles, time);
        member.state.resize(member.poles.len(), Complex64::ZERO);
        let to_world = side.pose.orientation;
        let shapes_at = |(at, (normal, _)): (usize, &(DVec3, f64))| {
            let vibrates = |(motion, pole): (&DVec3, &Complex64)| {
                if pole.im > 0.0 { to_world * *motion } else { DVec3::ZERO }
            };
            let known = modes.motions[at].iter().zip(&poles).map(vibrates);
            let above = tails.iter().enumerate().flat_map(|(other, tail)| {
                let shape = if other == at { tail.shape * *normal } else { DVec3::ZERO };
                std::iter::repeat_n(shape, tail.poles.len())
            });
            known.chain(above).collect()
        };
        let shapes = contacts.iter().enumerate().map(shapes_at).collect();
        VibratingMember { member, poles, shapes }
    }

    /// Displacement \[m\] of its surface at one of its points along a unit vector \[world\].
    pub(super) fn opening(&self, at: usize, direction: DVec3) -> f64 {
        let displaced = self.member.poles.iter().zip(&self.member.state).zip(&self.shapes[at]);
        displaced.map(|((pole, w), shape)| shape.dot(direction) * w.im / pole.im).sum()
    }

    /// States of its known modes.
    pub(super) fn known_state(&self) -> &[Complex64] {
        &self.member.state[..self.poles.len()]
    }
}

/// The modes above the last known one of a body, a tail for each contact.
fn tails(side: &ContactSide, modes: &ModesAtContact, contacts: &[(DVec3, f64)]) -> Vec<ModalTail> {
    let highest = modes.frequencies.iter().copied().fold(0.0, f64::max);
    let to_body = side.pose.orientation.inverse();
    let tail = |((normal, duration), motions): (&(DVec3, f64), &Vec<DVec3>)| {
        let normal = to_body * *normal;
        let along = modes.frequencies.iter().zip(motions).map(|(f, u)| (TAU * f, u.dot(normal)));
        modal_tail(along, highest, *duration)
    };
    contacts.iter().zip(&modes.motions).map(tail).collect()
}

/// A body of an impact without modes, at rest.
fn rigid_member(side: &ContactSide) -> Member {
    let turn = DMat3::from_quat(side.pose.orientation);
    let (inverse_mass, inverse_inertia) = side.answer();
    Member {
        inverse_mass,
        inverse_inertia: turn * inverse_inertia * turn.transpose(),
        centre: side.pose.position,
        velocity: DVec3::ZERO,
        angular_velocity: DVec3::ZERO,
        acceleration: DVec3::ZERO,
        poles: Vec::new(),
        state: Vec::new(),
    }
}
