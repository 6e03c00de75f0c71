//! Everything that sounds in a scene, ready to be heard by any listener.

use std::collections::{BTreeMap, BTreeSet};

use clangor_core::body::{Body, BodyId};
use clangor_core::contact::force_stream::{StreamSettings, force_stream};
use clangor_core::contact::{ContactReport, ImpactPulse, PoseHistory};
use clangor_core::synthesis::acceleration_pulse::clicks_of;
use clangor_core::synthesis::ground::{Ground, ground_clicks};
use clangor_core::synthesis::{AccelerationPulse, SoundSource};
use clangor_core::synthesis::{SoundModel, SoundPart};
use clangor_core::timeline::Timeline;

use super::error::RenderError;
use super::forces::{Forces, forces};
use super::ground::grounds;
use super::modal_sources::{ModalSources, modal_sources};
use super::modal_state_transfer::Breaking;
use super::modal_voices::Rolling;
use super::options::RenderOptions;
use super::summary::Stem;

/// A pair whose surfaces move more slowly is at rest, and silent [m/s].
const REST_SPEED: f64 = 1e-3;

/// Clicks, vibrating bodies and gentle forces of a run.
pub(super) struct SoundingScene {
    pub(super) poses: PoseHistory,
    /// Of bodies and grounds, in order of time.
    pub(super) clicks: Vec<AccelerationPulse>,
    /// The planes that sound.
    pub(super) grounds: BTreeMap<BodyId, Ground>,
    pub(super) modal: ModalSources,
    pub(super) rolling: Option<Rolling>,
}

impl SoundingScene {
    /// The sound of bodies with `models`, one each, in the run of a timeline; and what became of its impacts.
    pub(super) fn new(
        bodies: &[Body],
        models: &[SoundModel],
        timeline: &Timeline,
        options: &RenderOptions,
    ) -> Result<(Self, ContactReport), RenderError> {
        let modal = modal_sources(bodies, models, options.transfers)?;
        let Forces { poses, pulses, contacts } = forces(bodies, &modal, timeline, &options.contact)?;
        let rolling = rolling(bodies, timeline, &poses, options)?;
        let mut clicks = match options.parts.acceleration {
            true => body_clicks(&pulses, models),
            false => Vec::new(),
        };
        let grounds = grounds(bodies, options)?;
        clicks.extend(pulses.iter().flat_map(|pulse| ground_clicks(pulse, bodies, &grounds)));
        clicks.sort_by(|a, b| a.time.total_cmp(&b.time));
        let breaking = Breaking { fractures: &timeline.fractures, poses: &poses };
        let breaking = options.inherit_vibration.then_some(breaking);
        let modal = ModalSources::new(bodies, modal, &pulses, breaking);
        Ok((SoundingScene { poses, clicks, grounds, modal, rolling }, contacts))
    }

    /// The stems: each body and part that sounds, in their order.
    pub(super) fn stems(&self) -> BTreeSet<Stem> {
        let clicking = self.clicks.iter().map(|click| {
            let ground = self.grounds.contains_key(&click.body);
            Stem { body: click.body, part: if ground { SoundPart::Ground } else { SoundPart::Acceleration } }
        });
        let vibrating = self.modal.bodies().map(|body| Stem { body, part: SoundPart::Modal });
        clicking.chain(vibrating).collect()
    }
}

/// The clicks of bodies.
fn body_clicks(pulses: &[ImpactPulse], models: &[SoundModel]) -> Vec<AccelerationPulse> {
    let sources: Vec<SoundSource> = models.iter().map(|model| model.acceleration.source.clone()).collect();
    pulses.iter().flat_map(|pulse| clicks_of(pulse, &sources)).collect()
}

/// Forces too gentle to be impacts, if they are heard.
fn rolling(
    bodies: &[Body],
    timeline: &Timeline,
    poses: &PoseHistory,
    options: &RenderOptions,
) -> Result<Option<Rolling>, RenderError> {
    let Some(time_step) = options.rolling.filter(|_| options.parts.modal) else { return Ok(None) };
    let settings = StreamSettings { v_min: options.contact.v_min, time_step, rest_speed: REST_SPEED };
    let forces = force_stream(bodies, &timeline.contacts, poses, &settings)?;
    Ok(Some(Rolling { forces, time_step }))
}
