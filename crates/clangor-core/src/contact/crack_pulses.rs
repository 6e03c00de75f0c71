//! Converts the release of cracks into force pulses.
//!
//! An opening crack releases the tractions between its two faces: an impulse on one piece and its opposite on
//! the other, over the duration of the fracture (\[FRAC\] §3.3). There is no contact, hence no curvature and
//! no Hertz duration. A bent plate that breaks releases a couple and hardly any net force. The speed V of the
//! pulse is therefore defined by the energy
//!
//! ```text
//! ½ m V² = ½ Σ_d (j²/m_d + L_d·I_d⁻¹ L_d)
//! ```
//!
//! which impulse j and couple alone would give to two pieces d at rest. L_d is the angular impulse on a piece
//! about its centre of mass, m the effective mass along the normal.

use std::collections::BTreeMap;

use glam::DVec3;

use super::contact_forces::ForceSettings;
use super::contact_side::ContactSide;
use super::impact::ContactPoint;
use super::modal_energy::{bound_modal_energy, modal_energy_ratio};
use super::row_checks::check_row;
use super::{BodyPulse, ContactError, HertzRange, ImpactPulse, StruckBodies};
use crate::body::BodyId;
use crate::timeline::{ContactKind, ContactRow, FractureRow};

/// Turns the rows of cracks into pulses, in order of time; rows of the same impact id are one pulse.
///
/// # Errors
/// Bodies that are unknown, not alive, or not born of one of the `fractures`; numbers that are not finite;
/// fractures that take no time.
pub fn crack_pulses(
    struck: StruckBodies<'_>,
    rows: &[ContactRow],
    fractures: &[FractureRow],
    settings: &ForceSettings,
) -> Result<Vec<ImpactPulse>, ContactError> {
    let mut cracks: BTreeMap<u64, Vec<ContactRow>> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.kind == ContactKind::Fracture && row.impact_id != 0) {
        check_row(struck.bodies, row)?;
        cracks.entry(row.impact_id).or_default().push(*row);
    }
    let mut pulses = Vec::new();
    for rows in cracks.values() {
        pulses.extend(pulse(struck, rows, fractures, settings)?);
    }
    pulses.sort_by(|a, b| a.time.total_cmp(&b.time));
    Ok(pulses)
}

/// The pulse of the rows of one crack; `None` without impulse.
fn pulse(
    struck: StruckBodies<'_>,
    rows: &[ContactRow],
    fractures: &[FractureRow],
    settings: &ForceSettings,
) -> Result<Option<ImpactPulse>, ContactError> {
    let StruckBodies { bodies, poses, modes, .. } = struck;
    let ContactRow { time, body_a, body_b, impact_id, .. } = rows[0];
    // Duration of the fracture.
    let duration = duration_at_birth(fractures, body_a).unwrap_or(0.0);
    if !(duration > 0.0 && duration.is_finite()) {
        return Err(ContactError::NoDuration { body: body_a.0, time, duration });
    }
    // Mean point and normal, weighted by impulse.
    let strengths: Vec<f64> = rows.iter().map(|row| row.impulse().length()).collect();
    let total: f64 = strengths.iter().sum();
    if total == 0.0 || body_b == BodyId::WORLD {
        return Ok(None);
    }
    let weighted = |of: fn(&ContactRow) -> DVec3| -> DVec3 {
        rows.iter().zip(&strengths).map(|(row, strength)| of(row) * (strength / total)).sum()
    };
    let point = weighted(|row| row.point);
    let Some(normal) = weighted(|row| row.normal).try_normalize() else { return Ok(None) };
    // Effective mass along the normal.
    let side = |id: BodyId| ContactSide::of_body(id, &bodies[id.index()], poses.at(id, time));
    let [a, b] = [body_a, body_b].map(side);
    let inverse_mass = a.inverse_effective_mass(point, normal) + b.inverse_effective_mass(point, normal);
    // Impulse and change of the velocities of each piece.
    let acting = |r: &ContactRow| ContactPoint {
        impulse: r.impulse(),
        couple: r.couple,
        ..ContactPoint::approaching(r.point, r.normal, DVec3::ZERO)
    };
    let points: Vec<ContactPoint> = rows.iter().map(acting).collect();
    let shares = [(a, 1.0), (b, -1.0)].map(|(side, sign)| BodyPulse::new(&side, &points, sign, duration));
    // Speed V by the energy of impulse and couple.
    let twice_energy = |share: &BodyPulse| {
        share.impulse.dot(share.velocity_change) + share.angular_impulse.dot(share.angular_velocity_change)
    };
    let mut pulse = ImpactPulse {
        impact_id,
        time,
        onset: time,
        duration,
        shape: settings.profile.into(),
        speed: (shares.iter().map(twice_energy).sum::<f64>() * inverse_mass).sqrt(),
        effective_mass: inverse_mass.recip(),
        radius: f64::INFINITY,
        range: HertzRange::Within,
        point,
        normal,
        velocity_before: None,
        pair: [body_a, body_b],
        bodies: shares.map(Some),
        points: rows.iter().map(|row| (row.point, row.impulse())).collect(),
        modal_energy_ratio: 0.0,
    };
    let own = [0, 1].map(|side| {
        let share = pulse.bodies[side]?;
        modes(share.body, &share.local(&pulse.points, if side == 0 { 1.0 } else { -1.0 }))
    });
    let ratio = modal_energy_ratio(&pulse, own.each_ref().map(Option::as_ref));
    pulse.modal_energy_ratio = if ratio.is_finite() { ratio } else { 0.0 };
    bound_modal_energy(&mut pulse);
    Ok(Some(pulse))
}

/// Duration \[s\] of the fracture from which a body was born.
fn duration_at_birth(fractures: &[FractureRow], body: BodyId) -> Option<f64> {
    let last = fractures.partition_point(|fracture| fracture.first_child <= body).checked_sub(1)?;
    let fracture = fractures[last];
    (body.0 - fracture.first_child.0 < fracture.children).then_some(fracture.duration)
}
