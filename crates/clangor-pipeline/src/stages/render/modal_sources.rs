//! The vibrating bodies of a scene: the source of the modes of each, and what drives it.

use std::collections::BTreeMap;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId};
use clangor_core::contact::{ImpactPulse, PoseHistory};
use clangor_core::material::Damping;
use clangor_core::propagation::PropagationPaths;
use clangor_core::reference::frac_transfer;
use clangor_core::sound_model::modal::model::ModalModel;
use clangor_core::synthesis::SoundModel;
use clangor_core::synthesis::modal::{ModalError, ModalSource, ModalVoice};
use clangor_core::synthesis::{Listener, RenderSettings, SynthesisError};

use super::impacts_by_body::impacts_by_body;
use super::modal_state_transfer::{Breaking, ModalStateTransfer, transfer_modal_state};
use super::modal_voices::{ModalVoices, Rolling};
use super::struck_source::StruckSource;
use super::transfers::{Transfers, proxy_source};

/// The vibrating bodies, ready to be played to any listener.
pub(super) struct ModalSources {
    /// In the order of the bodies.
    sources: Vec<StruckSource>,
    handovers: BTreeMap<BodyId, ModalStateTransfer>,
}

/// How the voices of bodies are heard.
#[derive(Clone, Copy)]
pub(super) struct VoiceSettings<'a, 's> {
    pub(super) poses: &'a PoseHistory,
    pub(super) listener: &'a Listener,
    pub(super) settings: &'s RenderSettings,
    pub(super) paths: &'s Arc<PropagationPaths>,
}

/// A body of which the modes cannot be played.
#[derive(Debug, thiserror::Error)]
#[error("the modes of \"{body}\" cannot be played: {source}")]
pub struct UnplayableModes {
    /// The body.
    body: String,
    /// Why.
    source: ModalError,
}

/// What each body that rings is played by; bodies that share modes and damping share it.
///
/// # Errors
/// [`UnplayableModes`].
pub fn modal_sources(
    bodies: &[Body],
    models: &[SoundModel],
    transfers: Transfers,
) -> Result<BTreeMap<BodyId, Arc<ModalSource>>, UnplayableModes> {
    let settings = transfers.settings();
    let mut prepared: Vec<(&Arc<ModalModel>, &Damping, Arc<ModalSource>)> = Vec::new();
    let mut sources = BTreeMap::new();
    for (index, (body, model)) in bodies.iter().zip(models).enumerate() {
        let id = BodyId(index as u32);
        let damping = &body.material.damping;
        let unplayable = |source| UnplayableModes { body: body.name.clone(), source };
        if let Some(proxy) = model.modal.proxy() {
            let source = proxy_source(proxy, transfers, damping, &settings).map_err(unplayable)?;
            sources.insert(id, Arc::new(source));
            continue;
        }
        let Some(model) = model.modal.own() else { continue };
        let same = prepared.iter().find(|(m, d, _)| Arc::ptr_eq(m, model) && *d == damping);
        let source = match same {
            Some((_, _, source)) => Arc::clone(source),
            None => {
                let played = match transfers {
                    Transfers::Unit => Arc::new(frac_transfer::unit_model(model)),
                    Transfers::Baked | Transfers::Frac => Arc::clone(model),
                };
                let source = Arc::new(ModalSource::new(played, damping, &settings).map_err(unplayable)?);
                prepared.push((model, damping, Arc::clone(&source)));
                source
            }
        };
        sources.insert(id, source);
    }
    Ok(sources)
}

impl ModalSources {
    /// The bodies with these modal sources, and the impacts on them. With `breaking`, pieces take over the
    /// vibration of what they were part of.
    pub(super) fn new(
        bodies: &[Body],
        modal: BTreeMap<BodyId, Arc<ModalSource>>,
        pulses: &[ImpactPulse],
        breaking: Option<Breaking<'_>>,
    ) -> Self {
        let mut by_body = impacts_by_body(pulses);
        let mut sources = Vec::new();
        for (body, source) in modal {
            let impacts = by_body.remove(&body).unwrap_or_default();
            sources.push(StruckSource { body, source, impacts, handed: None });
        }
        let handovers = match breaking {
            Some(breaking) => transfer_modal_state(bodies, &mut sources, pulses, breaking),
            None => BTreeMap::new(),
        };
        ModalSources { sources, handovers }
    }

    /// What became of the vibration of each that broke.
    pub(super) fn handovers(&self) -> &BTreeMap<BodyId, ModalStateTransfer> {
        &self.handovers
    }

    /// The bodies, in their order.
    pub(super) fn bodies(&self) -> impl Iterator<Item = BodyId> {
        self.sources.iter().map(|struck| struck.body)
    }

    /// Those that are struck, or only one of them, as a listener hears them.
    pub(super) fn voices<'a>(
        &self,
        rolling: Option<&Rolling>,
        voice: VoiceSettings<'a, '_>,
        only: Option<BodyId>,
    ) -> Result<ModalVoices<'a>, SynthesisError> {
        let VoiceSettings { poses, listener, settings, paths } = voice;
        let mut voices = Vec::new();
        let wanted = |ringer: &&StruckSource| only.is_none_or(|only| only == ringer.body);
        for StruckSource { body, source, impacts, handed, .. } in self.sources.iter().filter(wanted) {
            let mut voice =
                ModalVoice::along(Arc::clone(source), *body, poses, listener, settings, Arc::clone(paths))?;
            voice.push_pulses(impacts)?;
            if let Some(state) = handed {
                voice.inherit_state(state)?;
            }
            if let Some(Rolling { forces, time_step }) = rolling {
                voice.push_stream(forces, *time_step)?;
            }
            voices.push((*body, voice));
        }
        let rate = settings.sample_rate.as_f64();
        Ok(ModalVoices { voices, energies: BTreeMap::new(), rate, channels: listener.receivers.len() })
    }
}
