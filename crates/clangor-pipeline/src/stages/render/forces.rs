//! The forces of a timeline: impacts and the releases of cracks.

use std::collections::BTreeMap;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId};
use clangor_core::contact::{
    ContactError, ContactReport, ContactSettings, ImpactPulse, PoseHistory, StruckBodies, crack_pulses,
    force_rows, impact_pulses_on,
};
use clangor_core::glam::DVec3;
use clangor_core::synthesis::SoundModel;
use clangor_core::synthesis::modal::ModalSource;
use clangor_core::timeline::{ContactRow, ForceRow, Timeline};

use super::error::RenderError;
use super::modal_sources::modal_sources;
use super::options::RenderOptions;

/// The impacts and the releases of cracks of a timeline, as forces.
pub(crate) struct Forces {
    pub(crate) poses: PoseHistory,
    /// In order of time.
    pub(crate) pulses: Vec<ImpactPulse>,
    pub(super) contacts: ContactReport,
}

/// The forces on bodies, of which `modal` are the modal sources.
pub(crate) fn forces(
    bodies: &[Body],
    modal: &BTreeMap<BodyId, Arc<ModalSource>>,
    timeline: &Timeline,
    settings: &ContactSettings,
) -> Result<Forces, ContactError> {
    let poses = PoseHistory::try_new(bodies, &timeline.poses)?;
    // What touches gently has no number.
    let impacts: Vec<ContactRow> =
        timeline.contacts.iter().filter(|row| row.impact_id != 0).copied().collect();
    let modes =
        |id: BodyId, points: &[(DVec3, DVec3)]| modal.get(&id).map(|source| source.at_contact(points));
    let struck = StruckBodies { bodies, poses: &poses, modes: &modes, forces: &timeline.forces };
    let (mut pulses, contacts) = impact_pulses_on(struck, &impacts, settings)?;
    pulses.extend(crack_pulses(struck, &impacts, &timeline.fractures, &settings.forces)?);
    pulses.sort_by(|a, b| a.time.total_cmp(&b.time));
    Ok(Forces { poses, pulses, contacts })
}

/// The forces of a timeline over time, as [`render`](super::render()) finds or solves them; impacts with a
/// closed profile have none. `models` has the sound model of each body.
///
/// # Errors
/// [`RenderError`].
pub fn timeline_forces(
    bodies: &[Body],
    models: &[SoundModel],
    timeline: &Timeline,
    options: &RenderOptions,
) -> Result<Vec<ForceRow>, RenderError> {
    let modal = modal_sources(bodies, models, options.transfers)?;
    Ok(force_rows(&forces(bodies, &modal, timeline, &options.contact)?.pulses))
}
