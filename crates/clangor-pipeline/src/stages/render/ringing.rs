//! The ringing of all bodies as one listener hears it, a stretch at a time.
//!
//! Every body is a voice of its own. Voices are played on all threads, and added in the order of the bodies.

mod modal_state_transfer;

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId};
use clangor_core::contact::force_stream::StreamedForce;
use clangor_core::contact::{ImpactPulse, PoseHistory};
use clangor_core::material::Damping;
use clangor_core::reference::frac_transfer;
use clangor_core::sound_model::modal::model::{ModalModel, ModalTransfer};
use clangor_core::sound_model::soundbank::modal_soundbank::{ContactMapping, ModalProxy};
use clangor_core::synthesis::modal::{ModalError, ModalSettings, ModalSource, ModalState, ModalVoice};
use clangor_core::synthesis::{Listener, RenderSettings, SynthesisError};
use rayon::prelude::*;

use super::energy_limit::{EnergyLimits, impacts_on};
use crate::stages::sound_models::ringers::Ringers;
pub(super) use modal_state_transfer::Breaking;
pub use modal_state_transfer::ModalStateTransfer;

/// Frames that a voice plays at once.
const FRAMES: i64 = 1 << 14;

/// How modes become pressure, for comparison by ear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Transfers {
    /// As they were baked, on the acceleration of the mode.
    #[default]
    Baked,
    /// \[FRAC\] eq. (8): their magnitude, on the amplitude of the mode.
    Frac,
    /// The same without any: every mode sounds alike, equally in all directions, and all together radiate as
    /// much from equal amplitudes as they should. \[FRAC\] §6 compares with this.
    Unit,
}

impl Transfers {
    fn settings(self) -> ModalSettings {
        match self {
            Transfers::Baked => ModalSettings::default(),
            Transfers::Frac => frac_transfer::magnitude_settings(),
            Transfers::Unit => frac_transfer::unit_settings(),
        }
    }
}

/// An ellipsoid in place of a body of this damping.
fn proxy_source(
    proxy: &ModalProxy,
    transfers: Transfers,
    damping: &Damping,
    settings: &ModalSettings,
) -> Result<ModalSource, ModalError> {
    let mut own: Vec<ModalTransfer> = (0..proxy.mode_count()).map(|mode| proxy.transfer(mode)).collect();
    if transfers == Transfers::Unit {
        let crossing = TAU * proxy.radius() / proxy.material().medium.sound_speed;
        let modes: Vec<_> =
            own.into_iter().enumerate().map(|(mode, t)| (proxy.frequency(mode), Some(t))).collect();
        own = frac_transfer::unit_transfers(&modes, crossing);
    }
    ModalSource::of_proxy(proxy.clone(), ContactMapping::default(), &own, damping, settings)
}

/// The ringing bodies, ready to be played to any listener.
pub(super) struct RingingBodies {
    /// In the order of the bodies.
    sources: Vec<Ringer>,
    handovers: BTreeMap<BodyId, ModalStateTransfer>,
}

/// A ringing body, and what strikes it.
struct Ringer {
    body: BodyId,
    source: Arc<ModalSource>,
    impacts: Vec<ImpactPulse>,
    limits: EnergyLimits,
    /// What it takes over from what it was part of.
    handed: Option<ModalState>,
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
    ringers: &Ringers,
    transfers: Transfers,
) -> Result<BTreeMap<BodyId, Arc<ModalSource>>, UnplayableModes> {
    let settings = transfers.settings();
    let mut prepared: Vec<(&Arc<ModalModel>, &Damping, Arc<ModalSource>)> = Vec::new();
    let mut sources = BTreeMap::new();
    for (index, body) in bodies.iter().enumerate() {
        let id = BodyId(index as u32);
        let damping = &body.material.damping;
        let unplayable = |source| UnplayableModes { body: body.name.clone(), source };
        if let Some(proxy) = ringers.proxy(id) {
            let source = proxy_source(proxy, transfers, damping, &settings).map_err(unplayable)?;
            sources.insert(id, Arc::new(source));
            continue;
        }
        let Some(model) = ringers.modes(id) else { continue };
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

impl RingingBodies {
    /// Prepares the modes of those that ring; bodies that share modes and damping share what is prepared.
    /// With `breaking`, pieces take over the vibration of what they were part of.
    pub(super) fn new(
        bodies: &[Body],
        ringers: &Ringers,
        transfers: Transfers,
        (pulses, limit): (&[ImpactPulse], bool),
        breaking: Option<Breaking<'_>>,
    ) -> Result<Self, UnplayableModes> {
        let mut sources = Vec::new();
        for (body, source) in modal_sources(bodies, ringers, transfers)? {
            let (impacts, limits) = impacts_on(body, &source, pulses, limit);
            sources.push(Ringer { body, source, impacts, limits, handed: None });
        }
        let handovers = match breaking {
            Some(breaking) => {
                modal_state_transfer::transfer_modal_state(bodies, &mut sources, pulses, breaking)
            }
            None => BTreeMap::new(),
        };
        Ok(RingingBodies { sources, handovers })
    }

    /// What became of the vibration of each that broke.
    pub(super) fn handovers(&self) -> &BTreeMap<BodyId, ModalStateTransfer> {
        &self.handovers
    }

    /// The bodies, in their order.
    pub(super) fn bodies(&self) -> impl Iterator<Item = BodyId> {
        self.sources.iter().map(|ringer| ringer.body)
    }

    /// What became of the impacts on each.
    pub(super) fn limits(&self) -> BTreeMap<BodyId, EnergyLimits> {
        self.sources.iter().map(|ringer| (ringer.body, ringer.limits)).collect()
    }

    /// Those that are struck, or only one of them, as a listener hears them.
    pub(super) fn voices<'a>(
        &self,
        rolling: Option<&Rolling>,
        poses: &'a PoseHistory,
        listener: &'a Listener,
        settings: &RenderSettings,
        only: Option<BodyId>,
    ) -> Result<Voices<'a>, SynthesisError> {
        let mut voices = Vec::new();
        let wanted = |ringer: &&Ringer| only.is_none_or(|only| only == ringer.body);
        for Ringer { body, source, impacts, handed, .. } in self.sources.iter().filter(wanted) {
            let mut voice = ModalVoice::new(Arc::clone(source), *body, poses, listener, settings)?;
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
        Ok(Voices { voices, energies: BTreeMap::new(), rate, receivers: listener.receivers.len() })
    }
}

/// Forces too gentle to be impacts.
pub(super) struct Rolling {
    pub(super) forces: Vec<StreamedForce>,
    /// Of the dynamics \[s\].
    pub(super) time_step: f64,
}

/// A stretch of a voice.
struct Played {
    body: BodyId,
    /// Pressure at each receiver \[Pa\].
    channels: Vec<Vec<f64>>,
    /// ∫ p² dt over all receivers [Pa² s].
    energy: f64,
}

/// Voices in progress.
pub(super) struct Voices<'a> {
    voices: Vec<(BodyId, ModalVoice<'a>)>,
    energies: BTreeMap<BodyId, f64>,
    rate: f64,
    receivers: usize,
}

impl Voices<'_> {
    /// Silence.
    pub(super) fn none() -> Self {
        Voices { voices: Vec::new(), energies: BTreeMap::new(), rate: 1.0, receivers: 0 }
    }

    /// Adds the pressure \[Pa\] of the samples from `first` on to one channel per receiver.
    pub(super) fn add(&mut self, first: i64, channels: &mut [Vec<f64>]) -> Result<(), SynthesisError> {
        let count = channels.first().map_or(0, Vec::len) as i64;
        let mut from = 0;
        while from < count {
            let length = (count - from).min(FRAMES);
            let (receivers, rate) = (self.receivers, self.rate);
            let played: Vec<Option<Played>> = self
                .voices
                .par_iter_mut()
                .map(|(id, voice)| {
                    let begins = voice.first_sample();
                    if begins.is_none_or(|begins| begins >= first + from + length) {
                        return Ok(None);
                    }
                    let mut own = vec![vec![0.0; length as usize]; receivers];
                    voice.render_block(first + from, &mut own)?;
                    let energy = own.iter().flatten().map(|p| p * p).sum::<f64>() / rate;
                    Ok(Some(Played { body: *id, channels: own, energy }))
                })
                .collect::<Result<_, SynthesisError>>()?;
            for Played { body, channels: own, energy } in played.into_iter().flatten() {
                *self.energies.entry(body).or_default() += energy;
                for (channel, own) in channels.iter_mut().zip(own) {
                    let part = &mut channel[from as usize..(from + length) as usize];
                    part.iter_mut().zip(own).for_each(|(sum, p)| *sum += p);
                }
            }
            from += length;
        }
        Ok(())
    }

    /// ∫ p² dt [Pa² s] of each body so far, over all receivers.
    pub(super) fn energies(&self) -> &BTreeMap<BodyId, f64> {
        &self.energies
    }
}
