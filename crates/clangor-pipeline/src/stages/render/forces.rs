//! The forces of a timeline: impacts and the releases of cracks.

use clangor_core::body::Body;
use clangor_core::contact::{
    ContactError, ContactReport, ContactSettings, ImpactPulse, PoseHistory, crack_pulses, impact_pulses,
};
use clangor_core::timeline::{ContactRow, Timeline};

/// The impacts and the releases of cracks of a timeline, as forces.
pub(crate) struct Forces {
    pub(crate) poses: PoseHistory,
    /// In order of time.
    pub(crate) pulses: Vec<ImpactPulse>,
    pub(super) contacts: ContactReport,
}

pub(crate) fn forces(
    bodies: &[Body],
    timeline: &Timeline,
    settings: &ContactSettings,
) -> Result<Forces, ContactError> {
    let poses = PoseHistory::try_new(bodies, &timeline.poses)?;
    // What touches gently has no number.
    let impacts: Vec<ContactRow> =
        timeline.contacts.iter().filter(|row| row.impact_id != 0).copied().collect();
    let (mut pulses, contacts) = impact_pulses(bodies, &impacts, &poses, settings)?;
    pulses.extend(crack_pulses(bodies, &impacts, &timeline.fractures, &poses, settings.profile)?);
    pulses.sort_by(|a, b| a.time.total_cmp(&b.time));
    Ok(Forces { poses, pulses, contacts })
}
