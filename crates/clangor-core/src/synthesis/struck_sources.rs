//! The pressure of a struck body at one receiver: its clicks and its ringing, by all paths of its room.
//!
//! Direct sound and first reflections are exact; what enters the late reverberation is rendered for its six
//! inputs ([`LateReverberation`]), as in a scene.

use std::sync::Arc;

use glam::DVec3;

use super::listener::Listener;
use super::modal::{ModalSource, ModalVoice};
use super::offline::BlockMemory;
use super::offline::overlap_add::OverlapAdd;
use super::offline::renderer::Renderer;
use super::render_settings::RenderSettings;
use super::strike_error::StrikeError;
use super::striker::STRUCK;
use crate::acoustics::Acoustics;
use crate::body::Body;
use crate::contact::{ImpactPulse, PoseHistory};
use crate::propagation::{LateReverberation, PropagationPaths};
use crate::synthesis::acceleration_pulse::AccelerationPulse;

/// What sounds when a body is struck.
#[derive(Clone, Copy, Debug)]
pub struct StruckSources<'a> {
    /// The body, at rest.
    pub body: &'a Body,
    /// Forces on its modes.
    pub pulses: &'a [ImpactPulse],
    /// Clicks.
    pub clicks: &'a [AccelerationPulse],
    /// Its modes, if it rings.
    pub modes: Option<&'a Arc<ModalSource>>,
}

/// Pressure at a receiver \[m\]: `count` samples \[Pa\].
///
/// # Errors
/// [`StrikeError::Synthesis`], [`StrikeError::Room`].
pub fn pressure(
    sources: &StruckSources<'_>,
    receiver: DVec3,
    settings: &RenderSettings,
    count: usize,
) -> Result<Vec<f64>, StrikeError> {
    let Acoustics { medium, air, room, .. } = &settings.acoustics;
    let listener = Listener::fixed("listener", receiver);
    let paths = settings.acoustics.paths();
    let heard = (Arc::new(paths.heard()), 1);
    let mut sum = along(sources, (&listener, settings), heard, count)?.swap_remove(0);
    let Some(room) = room.as_ref().filter(|room| room.late) else { return Ok(sum) };
    let inputs = (Arc::new(paths.feeding()), LateReverberation::INPUTS);
    let entering = along(sources, (&listener, settings), inputs, count)?;
    let rate = settings.sample_rate.as_f64();
    let mut late = LateReverberation::new(room, air.as_ref(), medium.sound_speed, rate)?;
    for (frame, pressure) in sum.iter_mut().enumerate() {
        late.step(&std::array::from_fn(|input| entering[input][frame]), std::slice::from_mut(pressure));
    }
    Ok(sum)
}

/// The signals of some paths, which lead into this number of channels.
fn along(
    sources: &StruckSources<'_>,
    (listener, settings): (&Listener, &RenderSettings),
    (paths, channels): (Arc<PropagationPaths>, usize),
    count: usize,
) -> Result<Vec<Vec<f64>>, StrikeError> {
    let mut renderer = Renderer::along(listener, settings, Arc::clone(&paths))?;
    for click in sources.clicks {
        renderer.push(click)?;
    }
    let mut signal = OverlapAdd::new(channels, 0);
    let mut memory = BlockMemory::default();
    for job in renderer.take_all() {
        signal.add(&job.render_with(&mut memory));
    }
    let mut sum = signal.take_until(count as i64);
    let Some(modes) = sources.modes else { return Ok(sum) };
    // A body without rows stays at its start, so this cannot fail.
    let poses = PoseHistory::try_new(std::slice::from_ref(sources.body), &[])
        .map_err(|_| StrikeError::NotFinite { what: "the pose" })?;
    let mut voice = ModalVoice::along(Arc::clone(modes), STRUCK, &poses, listener, settings, paths)?;
    voice.push_pulses(sources.pulses)?;
    let mut ringing = vec![vec![0.0; count]; channels];
    voice.render_block(0, &mut ringing)?;
    for (channel, ringing) in sum.iter_mut().zip(&ringing) {
        channel.iter_mut().zip(ringing).for_each(|(sum, p)| *sum += p);
    }
    Ok(sum)
}
