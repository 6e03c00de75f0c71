//! Contact loads: the impacts of a step as forces on breakable bodies.
//!
//! ```text
//! F = (π/2) j/τ,    E = ½ m V²,    ΔE = ½ j V (1 − e)
//! ```
//!
//! j is the impulse at each point, τ Hertz's duration, m the effective mass, V the approach speed, e the
//! restitution. E is the largest strain energy that the impact can cause in a body, ΔE the kinetic energy
//! that it dissipates.
//!
//! Differs: \[FRAC\] uses the force j/Δt, which grows as steps shrink.

use std::f64::consts::FRAC_PI_2;

use clangor_core::body::{Body, BodyId};
use clangor_core::contact::{
    ContactError, ContactSettings, ForceSettings, ImpactPulse, PoseHistory, impact_pulses,
};
use clangor_core::material::PairCoefficients;
use clangor_core::scene::breaking::Load;
use clangor_core::timeline::{ContactRow, PoseRow};
use glam::DVec3;

use crate::record::MERGE_WINDOW;

/// The load of one impact on one body.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ContactLoad {
    /// End of the load \[s\]: it acts for the duration of the pulse, and at least for the time within which
    /// impulses are merged into one impact.
    pub(super) end: f64,
    /// Points \[m\] and forces \[N\] in the axes of the body, about its centre of mass.
    pub(super) forces: Vec<(DVec3, DVec3)>,
    /// Largest strain energy that it can cause \[J\].
    pub(super) energy: f64,
    /// Kinetic energy that it dissipates \[J\].
    pub(super) loss: f64,
}

/// The force pulse of an impact of two bodies, from the rows of the pair at one instant and the poses before.
/// `None` if the approach is slower than `v_min` \[m/s\].
///
/// # Errors
/// [`ContactError`] for numbers that are not finite.
pub(super) fn pair_pulse(
    pair: [Option<&Body>; 2],
    rows: &[ContactRow],
    poses: &[PoseRow],
    v_min: f64,
) -> Result<Option<ImpactPulse>, ContactError> {
    let Some(first) = rows.first() else { return Ok(None) };
    // Hertz's formula needs only these two bodies, renumbered 0 and 1.
    let ids = [first.body_a, first.body_b];
    let pair: Vec<Body> = pair.into_iter().flatten().cloned().collect();
    let own = |id: BodyId| match ids.iter().position(|own| *own == id) {
        Some(at) if id != BodyId::WORLD => BodyId(at as u32),
        _ => BodyId::WORLD,
    };
    let rows: Vec<ContactRow> = rows
        .iter()
        .map(|row| ContactRow { body_a: own(row.body_a), body_b: own(row.body_b), impact_id: 1, ..*row })
        .collect();
    let known = poses.iter().filter(|pose| ids.contains(&pose.body));
    let poses: Vec<PoseRow> = known.map(|pose| PoseRow { body: own(pose.body), ..*pose }).collect();
    // The load takes the impulse and the duration of rigid bodies.
    let forces = ForceSettings::default().rigid();
    let settings = ContactSettings { v_min, forces, chain_onset: false };
    let (pulses, _) = impact_pulses(&pair, &rows, &PoseHistory::try_new(&pair, &poses)?, &settings)?;
    Ok(pulses.into_iter().next())
}

/// The load of an impact on one of its two bodies, as forces in the axes of that body. `None` if `body` is
/// not part of the impact.
pub(super) fn contact_load_on(
    body: BodyId,
    pulse: &ImpactPulse,
    rows: &[ContactRow],
    pair: [Option<&Body>; 2],
    load: Load,
    time_step: f64,
) -> Option<ContactLoad> {
    let side = [rows.first()?.body_a, rows.first()?.body_b].iter().position(|id| *id == body)?;
    let sign = if side == 0 { 1.0 } else { -1.0 };
    let pose = pulse.bodies[side]?.pose;
    let to_body = pose.orientation.inverse();
    let per_impulse = match load {
        Load::HalfSinePeak => FRAC_PI_2 / pulse.duration,
        Load::Step => 1.0 / time_step,
    };
    let restitution = match pair {
        [Some(a), Some(b)] => PairCoefficients::of(&a.material, &b.material).restitution,
        [Some(only), None] | [None, Some(only)] => {
            PairCoefficients::of(&only.material, &only.material).restitution
        }
        [None, None] => return None,
    };
    let lost_in = |row: &ContactRow| {
        let speed = row.approach_speed();
        0.5 * row.impulse_n * speed * (1.0 - restitution.at(speed))
    };
    let lost: f64 = rows.iter().map(lost_in).sum();
    Some(ContactLoad {
        end: pulse.time + pulse.duration.max(MERGE_WINDOW),
        forces: pulse
            .points
            .iter()
            .map(|(point, impulse)| (pose.body_from_world(*point), to_body * *impulse * (sign * per_impulse)))
            .collect(),
        energy: 0.5 * pulse.effective_mass * pulse.speed * pulse.speed,
        loss: lost.max(0.0),
    })
}
