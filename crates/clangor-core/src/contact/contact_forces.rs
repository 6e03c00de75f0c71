//! The forces of one impact: on the rigid motion of the two bodies, on their modes, and on the ground.
//!
//! ```text
//! two sides, points, approach or impulses ─► effective mass, curvature, compliance ─► duration τ (Hertz)
//!                                         ─► Σj/M, I⁻¹ Σ x×j of each body             acceleration noise
//!                                         ─► gain g of the forces on the modes        modal sound
//!                                         ─► impulses into a plane                    ground
//! ```
//!
//! This is the only place where an impact becomes forces: the offline renderer, the strike of a single body,
//! the real-time engine and its front ends all call [`contact_forces`](fn@contact_forces). The impulses are
//! those of rigid bodies: recorded by a solver, or (1 + e) m V along the normal
//! ([`Impact::with_restitution`]). All points of an impact share one time profile of one duration
//! ([`hertz`](super::hertz)). The forces on the modes are bounded by the energy of the approach
//! ([`modal_energy`](super::modal_energy)).
//!
//! Not covered: a force whose history follows from the contact giving way, and friction of an approach.

use super::ContactError;
use super::contact_side::ContactSide;
use super::force_profile::ForceProfile;
use super::impact::Impact;
use super::impact_pulse::{BodyPulse, ImpactPulse};
use super::modal_energy::{ModesOf, bound_modal_energy};

/// How impacts become forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceSettings {
    /// Time profile of the force.
    pub profile: ForceProfile,
    /// Whether the modes get at most the energy of the approach.
    pub limit_energy: bool,
}

impl Default for ForceSettings {
    fn default() -> Self {
        ForceSettings { profile: ForceProfile::default(), limit_energy: true }
    }
}

/// The forces of an impact. `modes` gives the modes of each body that vibrates.
///
/// # Errors
/// [`ContactError::NoDuration`] for bodies that contacts cannot move, an approach speed that is not positive,
/// or a contact without compliance.
pub fn contact_forces(
    impact: &Impact,
    modes: ModesOf<'_>,
    settings: &ForceSettings,
) -> Result<ImpactPulse, ContactError> {
    // Duration by Hertz from effective mass, curvature, compliance and speed.
    let (contact, range) = impact.hertz();
    let duration = contact.duration();
    if !(duration > 0.0 && duration.is_finite()) {
        let body = impact.sides[0].body.0;
        return Err(ContactError::NoDuration { body, time: impact.time, duration });
    }
    // Impulse and change of the velocities of each movable body.
    let [a, b] = impact.sides;
    let share = |side: ContactSide, sign: f64| {
        side.is_movable().then(|| BodyPulse::new(&side, &impact.points, sign, duration))
    };
    let mut pulse = ImpactPulse {
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
    };
    // Bound of the forces on the modes.
    bound_modal_energy(&mut pulse, modes, settings.limit_energy);
    Ok(pulse)
}
