//! The forces of one impact: on the rigid motion of the two bodies, on their modes, and on the ground.
//!
//! ```text
//! two sides, points, approach or impulses ─► effective mass, radii, compliance ─► k, τ (Hertz)
//!   modes hardly excited, one point       ─► Hertz's pulse in closed form
//!   else                                  ─► solve of the contact: F(t) of every point
//!                                         ─► Σj/M, I⁻¹ Σ x×j of each body             acceleration noise
//!                                         ─► impulses at the points                   modal sound
//!                                         ─► impulses into a plane                    ground
//! ```
//!
//! This is the only place where an impact becomes forces: the offline renderer, the strike of a single body,
//! the real-time engine and its front ends all call [`contact_forces`](fn@contact_forces). The impulses are
//! those of the motion: recorded by a solver of rigid bodies, or (1 + e) m V along the normal
//! ([`Impact::with_restitution`]). What the solve of the contact ([`impact_solver`](super::impact_solver))
//! adds is their course: one force history for click, ringing and ground. What of an impulse a contact that
//! gives way does not give moves the bodies and the ground slowly, and no modes (`slow_rest`).
//!
//! Where no solve is possible, all points share Hertz's pulse, and the forces on the modes are bounded by the
//! energy of the approach ([`modal_energy`](super::modal_energy)); where these are less than half of it, the
//! rest of the impulse acts slowly (`slow_rest`). The profiles of the papers are
//! rigid-body forces, and bounded likewise on the modes.

use std::sync::Arc;

use super::ContactError;
use super::contact_side::ContactSide;
use super::force_profile::ForceProfile;
use super::force_shape::ForceShape;
use super::hertz::HertzContact;
use super::impact::{ContactPoint, Impact};
use super::impact_pulse::{BodyPulse, ImpactPulse};
use super::impact_solver::{ImpactSolver, MOST_SCALE, SolveInput, SolvedForce};
use super::modal_energy::{ModesAtContact, ModesOf, bound_modal_energy, modal_energy_ratio};
use super::slow_rest::slow_rest;
use crate::body::BodyId;

/// How the force of an impact comes about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ImpactModel {
    /// A solve of the contact where modes are excited or several points touch, else Hertz's pulse.
    #[default]
    Solved,
    /// The force of rigid bodies, with the modes bounded by the energy of the approach.
    Rigid,
    /// A given force, of which no approach is known and nothing bounds the modes.
    Given,
}

/// How impacts become forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceSettings {
    /// Time profile of a force without a solve; only Hertz's allows one.
    pub profile: ForceProfile,
    /// Whether the contact is solved.
    pub model: ImpactModel,
    /// Steps of a solve per first duration of the contact.
    pub steps: f64,
    /// Highest frequency of a solved force \[Hz\].
    pub band: f64,
}

/// Greatest force of Hertz's pulse in its mean over the duration.
const HERTZ_PEAK: f64 = 1.84;
/// Steps per first duration offline: 0.15 dB from many steps in 90 % of impacts on thin bodies.
pub const OFFLINE_STEPS: f64 = 16.0;
/// Steps per first duration in real time: 0.6 dB.
pub const LIVE_STEPS: f64 = 8.0;

impl Default for ForceSettings {
    fn default() -> Self {
        ForceSettings {
            profile: ForceProfile::default(),
            model: ImpactModel::default(),
            steps: OFFLINE_STEPS,
            band: 24e3,
        }
    }
}

impl ForceSettings {
    /// With the step of real time.
    #[must_use]
    pub fn live(self) -> Self {
        ForceSettings { steps: LIVE_STEPS, ..self }
    }

    /// The forces of rigid bodies.
    #[must_use]
    pub fn rigid(self) -> Self {
        ForceSettings { model: ImpactModel::Rigid, ..self }
    }
}

/// The forces of an impact, each with its own time shape: one pulse, or several of the same impact.
///
/// `modes` gives the modes of each body that vibrates. Impacts of a timeline pass through one `solver` in
/// order of time.
///
/// # Errors
/// [`ContactError::NoDuration`] for bodies that contacts cannot move, an approach speed that is not positive,
/// or a contact without compliance.
pub fn contact_forces(
    impact: &Impact,
    modes: ModesOf<'_>,
    settings: &ForceSettings,
    solver: &mut ImpactSolver,
) -> Result<Vec<ImpactPulse>, ContactError> {
    let Prepared { contact, own, mut pulse, modal_share: share } = Prepared::new(impact, modes, settings)?;
    let input = SolveInput {
        impact,
        contact: &contact,
        modes: own.each_ref().map(Option::as_ref),
        steps: settings.steps,
        band: settings.band,
    };
    match settings.model {
        ImpactModel::Given => return Ok(vec![pulse]),
        ImpactModel::Solved if settings.allows_histories() => {
            if input.is_closed(share) {
                solver.ring_closed(&input, &pulse, share);
                return Ok(vec![pulse]);
            }
            if let Some(forces) = solver.solve(&input) {
                return Ok(pulses_of(impact, &pulse, forces));
            }
            solver.count_fallback();
            bound_modal_energy(&mut pulse);
            return Ok(bounded_pulses(impact, pulse, settings.band));
        }
        ImpactModel::Solved | ImpactModel::Rigid => {}
    }
    // Bound of the forces on the modes.
    bound_modal_energy(&mut pulse);
    Ok(vec![pulse])
}

/// A pulse of rigid bodies of which the modes take a part g, and the rest of its impulse, which acts slowly
/// where they take little: a force that is bounded on the modes is so on the motion.
fn bounded_pulses(impact: &Impact, pulse: ImpactPulse, band: f64) -> Vec<ImpactPulse> {
    let gain = pulse.bodies.iter().flatten().map(|share| share.modal_gain).fold(1.0, f64::min);
    let impulse = impact.points.iter().map(|point| point.impulse.length()).sum::<f64>();
    let greatest = gain * impulse * HERTZ_PEAK / pulse.duration;
    let rest = (gain * MOST_SCALE < 1.0)
        .then(|| slow_rest((1.0 - gain) * impulse, (greatest, pulse.duration), band))
        .flatten();
    let Some((history, end)) = rest else { return vec![pulse] };
    let part = |(share, duration, shape, modal_gain): (f64, f64, ForceShape, f64)| {
        let scaled = |point: &ContactPoint| ContactPoint {
            impulse: share * point.impulse,
            couple: share * point.couple,
            ..*point
        };
        let points: Vec<ContactPoint> = impact.points.iter().map(scaled).collect();
        let body = |side: usize, sign: f64| {
            let moved =
                |_| BodyPulse { modal_gain, ..BodyPulse::new(&impact.sides[side], &points, sign, duration) };
            pulse.bodies[side].map(moved)
        };
        ImpactPulse {
            duration,
            shape,
            bodies: [body(0, 1.0), body(1, -1.0)],
            points: points.iter().map(|point| (point.place, point.impulse)).collect(),
            ..pulse.clone()
        }
    };
    let fast = (gain, pulse.duration, pulse.shape.clone(), 1.0);
    let slow = (1.0 - gain, end, ForceShape::History(history), 0.0);
    vec![part(fast), part(slow)]
}

/// The pulses of an impact whose `forces` a timeline holds.
///
/// # Errors
/// As [`contact_forces`].
pub(super) fn recorded_contact_forces(
    impact: &Impact,
    forces: Vec<SolvedForce>,
    modes: ModesOf<'_>,
    settings: &ForceSettings,
    solver: &mut ImpactSolver,
) -> Result<Vec<ImpactPulse>, ContactError> {
    let Prepared { contact, own, pulse, .. } = Prepared::new(impact, modes, settings)?;
    let input = SolveInput {
        impact,
        contact: &contact,
        modes: own.each_ref().map(Option::as_ref),
        steps: settings.steps,
        band: settings.band,
    };
    solver.ring_recorded(&input, &forces);
    Ok(pulses_of(impact, &pulse, forces))
}

impl ForceSettings {
    /// Whether forces over time take the place of a closed profile.
    pub(super) fn allows_histories(&self) -> bool {
        self.model == ImpactModel::Solved && self.profile == ForceProfile::Hertz
    }
}

/// What is known of an impact before its force.
struct Prepared {
    contact: HertzContact,
    /// Modes of A and B at the points.
    own: [Option<ModesAtContact>; 2],
    /// The pulse of rigid bodies.
    pulse: ImpactPulse,
    /// Energy that it would give the modes, over that of the approach.
    modal_share: f64,
}

impl Prepared {
    fn new(impact: &Impact, modes: ModesOf<'_>, settings: &ForceSettings) -> Result<Self, ContactError> {
        // Stiffness and duration by Hertz from effective mass, radii, compliance and speed.
        let (contact, _) = impact.hertz();
        let mut pulse = rigid_pulse(impact, settings)?;
        // Modes at the points, and the energy that the closed pulse would give them.
        let own = [0, 1].map(|side| {
            let share = pulse.bodies[side]?;
            modes(share.body, &share.local(&pulse.points, if side == 0 { 1.0 } else { -1.0 }))
        });
        // A body that contacts cannot move takes part by its vibration.
        for (side, share) in pulse.bodies.iter_mut().enumerate() {
            if own[side].is_none() && !impact.sides[side].is_movable() {
                *share = None;
            }
        }
        let modal_share = modal_energy_ratio(&pulse, [own[0].as_ref(), own[1].as_ref()]);
        pulse.modal_energy_ratio = if modal_share.is_finite() { modal_share } else { 0.0 };
        Ok(Prepared { contact, own, pulse, modal_share })
    }
}

/// The pulse of rigid bodies: all points share one profile.
fn rigid_pulse(impact: &Impact, settings: &ForceSettings) -> Result<ImpactPulse, ContactError> {
    let (contact, range) = impact.hertz();
    let duration = contact.duration();
    if !(duration > 0.0 && duration.is_finite()) {
        let body = impact.sides[0].body.0;
        return Err(ContactError::NoDuration { body, time: impact.time, duration });
    }
    // Impulse and change of the velocities of each body.
    let [a, b] = impact.sides;
    let share = |side: ContactSide, sign: f64| {
        (side.body != BodyId::WORLD).then(|| BodyPulse::new(&side, &impact.points, sign, duration))
    };
    Ok(ImpactPulse {
        impact_id: impact.impact_id,
        time: impact.time,
        onset: impact.time,
        duration,
        shape: settings.profile.into(),
        speed: impact.speed,
        effective_mass: 1.0 / contact.inverse_mass,
        radius: (contact.relative_radii[0] * contact.relative_radii[1]).sqrt(),
        range,
        point: impact.point,
        normal: impact.normal,
        velocity_before: None,
        pair: [a.body, b.body],
        bodies: [share(a, 1.0), share(b, -1.0)],
        points: impact.points.iter().map(|point| (point.place, point.impulse)).collect(),
        modal_energy_ratio: 0.0,
    })
}

/// The pulses of solved forces: points whose force has the same shape share one.
fn pulses_of(impact: &Impact, rigid: &ImpactPulse, mut forces: Vec<SolvedForce>) -> Vec<ImpactPulse> {
    let mut pulses = Vec::new();
    while let Some(first) = forces.first().cloned() {
        let (same, others): (Vec<SolvedForce>, Vec<SolvedForce>) =
            forces.into_iter().partition(|force| Arc::ptr_eq(&force.history, &first.history));
        forces = others;
        let acting = |force: &SolvedForce| ContactPoint {
            impulse: force.impulse,
            couple: force.couple,
            ..impact.points[force.point]
        };
        let points: Vec<ContactPoint> = same.iter().map(acting).collect();
        let share = |side: usize, sign: f64| {
            rigid.bodies[side].map(|_| BodyPulse {
                modal_gain: first.modal_gain,
                ..BodyPulse::new(&impact.sides[side], &points, sign, first.end)
            })
        };
        pulses.push(ImpactPulse {
            duration: first.end,
            shape: ForceShape::History(Arc::clone(&first.history)),
            bodies: [share(0, 1.0), share(1, -1.0)],
            points: points.iter().map(|point| (point.place, point.impulse)).collect(),
            ..rigid.clone()
        });
    }
    pulses
}
