//! A listener's renderers and voices over the propagation paths: those to the receivers, and those into the
//! late reverberation.
//!
//! Late reverberation is fed by what arrives in the middle of the receivers.

use std::sync::Arc;

use clangor_core::acoustics::Acoustics;
use clangor_core::propagation::{LateReverberation, PropagationPaths, RoomError};
use clangor_core::synthesis::{
    AccelerationPulse, BlockJob, BlockMemory, Listener, OverlapAdd, RenderSettings, Renderer, SynthesisError,
};
use glam::DVec3;
use rayon::prelude::*;

use super::modal_voices::ModalVoices;

/// Where paths lead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    /// To the receivers.
    Receivers,
    /// Into the late reverberation.
    Reverberation,
}

/// Paths to one end, before anything is heard.
pub(super) struct PathGroup {
    listener: Listener,
    paths: Arc<PropagationPaths>,
    end: End,
}

/// All paths to a listener; those to the receivers first.
pub(super) fn paths_to(listener: &Listener, acoustics: &Acoustics) -> Vec<PathGroup> {
    let all = acoustics.paths();
    let paths = Arc::new(all.heard());
    let mut groups = vec![PathGroup { listener: listener.clone(), paths, end: End::Receivers }];
    let feeding = all.feeding();
    if feeding.count() > 0 {
        let middle = listener.receivers.iter().sum::<DVec3>() / listener.receivers.len().max(1) as f64;
        let head = Listener { receivers: vec![middle], ..listener.clone() };
        groups.push(PathGroup { listener: head, paths: Arc::new(feeding), end: End::Reverberation });
    }
    groups
}

/// The late reverberation of a room; `None` without it.
pub(super) fn reverberation(
    acoustics: &Acoustics,
    rate: f64,
) -> Result<Option<LateReverberation>, RoomError> {
    let Acoustics { medium, air, room, .. } = acoustics;
    let Some(room) = room else { return Ok(None) };
    room.check()?;
    let late = || LateReverberation::new(room, air.as_ref(), medium.sound_speed, rate);
    room.late.then(late).transpose()
}

/// Paths to one end in progress.
pub(super) struct PathRenderer<'a> {
    end: End,
    pub(super) renderer: Renderer,
    pub(super) signal: OverlapAdd,
    pub(super) voices: ModalVoices<'a>,
}

impl<'a> PathRenderer<'a> {
    /// `voices` makes the voices of bodies, for a listener and paths.
    pub(super) fn new(
        group: &'a PathGroup,
        settings: &RenderSettings,
        voices: impl FnOnce(&'a Listener, &Arc<PropagationPaths>) -> Result<ModalVoices<'a>, SynthesisError>,
    ) -> Result<Self, SynthesisError> {
        let PathGroup { listener, paths, end } = group;
        let channels = match end {
            End::Receivers => listener.receivers.len(),
            End::Reverberation => LateReverberation::INPUTS,
        };
        let voices = ModalVoices { channels, ..voices(listener, paths)? };
        Ok(PathRenderer {
            renderer: Renderer::along(listener, settings, Arc::clone(paths))?,
            signal: OverlapAdd::new(channels, 0),
            voices,
            end: *end,
        })
    }

    /// Takes a click.
    pub(super) fn push(&mut self, click: &AccelerationPulse) -> Result<(), SynthesisError> {
        self.renderer.push(click)
    }

    /// Renders blocks, on all processors, and adds them in their order.
    pub(super) fn add(&mut self, jobs: &[BlockJob]) {
        let blocks: Vec<_> =
            jobs.par_iter().map_init(BlockMemory::default, |memory, job| job.render_with(memory)).collect();
        blocks.iter().for_each(|block| self.signal.add(block));
    }
}

/// The samples before `end` of all paths together, one channel per receiver.
pub(super) fn take_until(
    path_renderers: &mut [PathRenderer<'_>],
    late: &mut Option<LateReverberation>,
    end: i64,
) -> Result<Vec<Vec<f64>>, SynthesisError> {
    let mut sum: Vec<Vec<f64>> = Vec::new();
    let mut entering: Vec<Vec<f64>> = Vec::new();
    for path_renderer in path_renderers {
        let first = path_renderer.signal.first();
        let mut channels = path_renderer.signal.take_until(end);
        path_renderer.voices.add(first, &mut channels)?;
        match path_renderer.end {
            End::Reverberation => entering = channels,
            End::Receivers => sum = channels,
        }
    }
    if let Some(late) = late {
        let mut outputs = vec![0.0; sum.len()];
        for frame in 0..sum.first().map_or(0, Vec::len) {
            outputs.fill(0.0);
            late.step(&std::array::from_fn(|input| entering[input][frame]), &mut outputs);
            sum.iter_mut().zip(&outputs).for_each(|(channel, p)| channel[frame] += p);
        }
    }
    Ok(sum)
}
