//! A body with its sound model, which may be struck any number of times.
//!
//! [`Strike`](super::Strike) makes one for one impact; a data set keeps it for all impacts on that body.

use std::ops::ControlFlow;
use std::sync::Arc;

use clangor_core::body::Body;
use clangor_core::contact::ImpactPulse;
use clangor_core::scene::render_description::Parts;
use clangor_core::synthesis::modal::{ModalSettings, ModalSource, Resonance};
use clangor_core::synthesis::source_rule::SourceKind;
use clangor_core::synthesis::strike::{self, StrikeForce};
use clangor_core::synthesis::{BodyModes, SoundSource};

use super::error::Error;
use super::progress::Progress;
use super::struck_body::StruckBody;
use super::struck_model::{ModelChoice, StruckModel};
use super::struck_sound::{StrikeRemark, StruckSound};

/// Radius of the source in place of a part that is not asked for, over that of the body: no listener is
/// inside.
const POINT_SIZE: f64 = 1e-6;
/// Parts of the duration of a closed form between which its peak is looked for.
const PEAK_STEPS: u32 = 256;

/// A body with its sound model: see the module.
#[derive(Clone, Debug)]
pub(crate) struct SoundingBody {
    body: Body,
    source: SoundSource,
    clicks: bool,
    resonator: Option<Arc<ModalSource>>,
    modal: Option<BodyModes>,
    acceleration: Option<SourceKind>,
    remarks: Vec<StrikeRemark>,
}

impl SoundingBody {
    /// Finds or bakes the parts of the sound model. Of the impact, the settings of the sound matter.
    ///
    /// # Errors
    /// [`Error::Models`], [`Error::Modes`], [`Error::ModelField`].
    pub(crate) fn obtain(
        struck: &StruckBody,
        choice: &ModelChoice,
        parts: &Parts,
        impact: &strike::Strike,
        on_progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<Self, Error> {
        let body = struck.body();
        let mut model =
            StruckModel { struck, choice, impact: impact.clone(), on_progress, remarks: Vec::new() };
        let modal = if parts.modal { model.modes()? } else { None };
        let resonator = modal.as_ref().map(|modes| resonator(body, modes)).transpose()?.flatten();
        let (source, acceleration) = match parts.acceleration {
            true => model.source()?,
            false => (point_source(body), None),
        };
        let remarks = model.remarks;
        let (body, clicks) = (body.clone(), parts.acceleration);
        Ok(SoundingBody { body, source, clicks, resonator, modal, acceleration, remarks })
    }

    /// Its oscillators, by the damping of its material.
    pub(crate) fn resonances(&self) -> &[Resonance] {
        self.resonator.as_ref().map_or(&[], |resonator| resonator.resonances())
    }

    /// The body.
    pub(crate) fn body(&self) -> &Body {
        &self.body
    }

    /// What radiates when it is accelerated, and what rings.
    pub(crate) fn sources(&self) -> (&SoundSource, Option<&Arc<ModalSource>>) {
        (&self.source, self.resonator.as_ref())
    }

    /// Defects of its sound model.
    pub(crate) fn remarks(&self) -> &[StrikeRemark] {
        &self.remarks
    }

    /// The sound of an impact, which ends at `seconds` \[s\], and its forces.
    ///
    /// # Errors
    /// [`Error::Strike`].
    pub(crate) fn sound(
        &self,
        impact: &strike::Strike,
        seconds: f64,
    ) -> Result<(StruckSound, Vec<ImpactPulse>), Error> {
        let SoundingBody { body, source, resonator, .. } = self;
        let pulses = strike::forces(body, resonator.as_deref(), impact)?;
        let mut clicks = strike::clicks(&pulses, source, impact)?;
        // With a striker that is heard, the point in place of the body stays: it is 180 dB below.
        let is_heard = matches!(&impact.force, StrikeForce::Striker(striker) if striker.heard);
        if !self.clicks && !is_heard {
            clicks.clear();
        }
        let count = strike::samples(impact, seconds);
        let pressures = strike::pressure(body, (&pulses, resonator.as_ref()), &clicks, impact, count)?;
        let of_body = || pulses.iter().filter_map(|pulse| pulse.bodies[0]);
        let sound = StruckSound {
            pressures,
            times: strike::times(impact, count),
            sample_rate: impact.sample_rate,
            point: impact.point,
            listener: impact.listener,
            contact_duration: pulses.iter().map(|pulse| pulse.duration).fold(0.0, f64::max),
            velocity_change: of_body().map(|share| share.velocity_change).sum(),
            impulse: of_body().map(|share| share.impulse).sum(),
            peak_force: pulses.iter().map(peak_force).fold(0.0, f64::max),
            modal_energy_ratio: pulses.iter().map(|pulse| pulse.modal_energy_ratio).fold(0.0, f64::max),
            radius: body.surface.equal_volume_radius(),
            travel_time: impact.listener.length() / impact.medium.sound_speed,
            modes: self.resonances().len(),
            modal: self.modal.clone(),
            acceleration: self.acceleration,
            remarks: self.remarks.clone(),
            note: format!("{} of {}", body.name, body.material.name),
        };
        Ok((sound, pulses))
    }
}

/// A source so small that no listener is inside.
pub(super) fn point_source(body: &Body) -> SoundSource {
    SoundSource::Sphere { radius: POINT_SIZE * body.surface.bounding_radius() }
}

/// The oscillators of a body with modes of its own, by the damping of its material.
fn resonator(body: &Body, modes: &BodyModes) -> Result<Option<Arc<ModalSource>>, Error> {
    let BodyModes::Own(model) = modes else { return Ok(None) };
    let source = ModalSource::new(Arc::clone(model), &body.material.damping, &ModalSettings::default())
        .map_err(|source| Error::Modes { name: body.name.clone(), source })?;
    Ok(Some(Arc::new(source)))
}

/// Largest force of an impact \[N\].
fn peak_force(pulse: &ImpactPulse) -> f64 {
    let impulse = pulse.bodies[0].map_or(0.0, |share| share.impulse.length());
    let (from, to) = pulse.shape.extent(pulse.duration);
    let at = |step: u32| from + (to - from) * f64::from(step) / f64::from(PEAK_STEPS);
    let values = (0..=PEAK_STEPS).map(|step| pulse.shape.value(at(step), pulse.duration));
    impulse * values.fold(0.0, f64::max)
}
