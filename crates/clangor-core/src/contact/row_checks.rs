//! Rejects timeline rows of unknown or dead bodies, rows with numbers that are not finite, and impossible
//! effective masses.

use super::ContactError;
use crate::body::{Body, BodyId, Life};
use crate::quantity::EFFECTIVE_MASS;
use crate::timeline::ContactRow;

/// Rejects rows of bodies that are unknown or not alive, numbers that are not finite, and impossible
/// effective masses.
pub(super) fn check_row(bodies: &[Body], row: &ContactRow) -> Result<(), ContactError> {
    for id in [row.body_a, row.body_b].into_iter().filter(|id| *id != BodyId::WORLD) {
        check_body(bodies, id, "contact", row.time)?;
    }
    if let Some(mass) = row.effective_mass.filter(|mass| !EFFECTIVE_MASS.admits(*mass)) {
        return Err(ContactError::EffectiveMass { body: row.body_a.0, time: row.time, mass });
    }
    let vectors = [row.point, row.normal, row.impulse_t, row.couple, row.velocity];
    let finite = row.time.is_finite() && row.impulse_n.is_finite() && vectors.iter().all(|v| v.is_finite());
    if finite {
        Ok(())
    } else {
        Err(ContactError::NotFinite { what: "contact", body: row.body_a.0, time: row.time })
    }
}

/// Rejects bodies that are unknown, or not alive at a time \[s\].
pub(super) fn check_body(
    bodies: &[Body],
    id: BodyId,
    what: &'static str,
    time: f64,
) -> Result<(), ContactError> {
    let Some(body) = bodies.get(id.index()) else {
        return Err(ContactError::UnknownBody { what, body: id.0, bodies: bodies.len(), time });
    };
    let Life { birth, death, .. } = body.life;
    // A time that is not finite is reported as such.
    if body.life.holds(time) || !time.is_finite() {
        return Ok(());
    }
    Err(ContactError::NotAlive { what, body: id.0, time, birth, death })
}
