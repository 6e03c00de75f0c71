//! The paths by which a listener hears: directly, by each image of low order in the walls of a room, and by
//! all later reflections together.
//!
//! Each path is a listener of its own, mirrored as the image is, with a renderer and voices of its own, which
//! lose on the path what its walls and the air take. What late reverberation hears are the six reflections in
//! a single wall, times their distance.

use clangor_core::medium::Medium;
use clangor_core::propagation::{Air, LateReverberation, PathLoss, Room, RoomError, image_sources};
use clangor_core::synthesis::{
    AccelerationPulse, BlockJob, BlockMemory, Listener, OverlapAdd, RenderSettings, Renderer, SoundSource,
    SynthesisError,
};
use glam::DVec3;
use rayon::prelude::*;

use super::modal_voices::ModalVoices;

/// Where a path leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    /// To the receivers.
    Receivers,
    /// Into the late reverberation.
    Reverberation,
}

/// One path, before anything is heard.
pub(super) struct PropagationPath {
    listener: Listener,
    settings: RenderSettings,
    end: End,
    /// Whether it met the floor, of which the ground's own sound is no reflection.
    met_floor: bool,
}

/// All paths to a listener, the direct one first.
pub(super) fn paths_to(
    listener: &Listener,
    settings: &RenderSettings,
    room: Option<&Room>,
    air: Option<Air>,
) -> Vec<PropagationPath> {
    let with = |loss: PathLoss| RenderSettings { loss, ..*settings };
    let direct = PropagationPath {
        listener: listener.clone(),
        settings: with(PathLoss::through(air)),
        end: End::Receivers,
        met_floor: false,
    };
    let mut paths = vec![direct];
    let Some(room) = room else { return paths };
    paths.extend(image_sources(room).iter().map(|image| PropagationPath {
        listener: listener.mirrored(image),
        settings: with(PathLoss::by(image, room, air)),
        end: End::Receivers,
        met_floor: image.met_floor(),
    }));
    if room.late {
        let middle = listener.receivers.iter().sum::<DVec3>() / listener.receivers.len().max(1) as f64;
        let head = Listener { receivers: vec![middle], ..listener.clone() };
        let single = image_sources(&Room { image_order: 1, ..*room });
        paths.extend(single.iter().map(|image| PropagationPath {
            listener: head.mirrored(image),
            settings: with(PathLoss::by(image, room, air).unspread()),
            end: End::Reverberation,
            met_floor: image.met_floor(),
        }));
    }
    paths
}

/// The network that the paths into it feed; `None` without such paths.
pub(super) fn reverberation(
    room: Option<&Room>,
    air: Option<Air>,
    medium: &Medium,
    rate: f64,
) -> Result<Option<LateReverberation>, RoomError> {
    let Some(room) = room else { return Ok(None) };
    room.check()?;
    let late = || LateReverberation::new(room, air.as_ref(), medium.sound_speed, rate);
    room.late.then(late).transpose()
}

/// One path in progress.
pub(super) struct PathRenderer<'a> {
    path: &'a PropagationPath,
    pub(super) renderer: Renderer,
    pub(super) signal: OverlapAdd,
    pub(super) voices: ModalVoices<'a>,
}

impl<'a> PathRenderer<'a> {
    /// `voices` makes what rings, for a listener with settings.
    pub(super) fn new(
        path: &'a PropagationPath,
        voices: impl FnOnce(&'a Listener, &RenderSettings) -> Result<ModalVoices<'a>, SynthesisError>,
    ) -> Result<Self, SynthesisError> {
        Ok(PathRenderer {
            renderer: Renderer::new(&path.listener, &path.settings)?,
            signal: OverlapAdd::new(path.listener.receivers.len(), 0),
            voices: voices(&path.listener, &path.settings)?,
            path,
        })
    }

    /// Takes a click.
    pub(super) fn push(&mut self, click: &AccelerationPulse) -> Result<(), SynthesisError> {
        let is_ground = matches!(click.source, SoundSource::Ground { .. });
        if is_ground && self.path.met_floor { Ok(()) } else { self.renderer.push(click) }
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
        match path_renderer.path.end {
            End::Reverberation => entering.append(&mut channels),
            End::Receivers if sum.is_empty() => sum = channels,
            End::Receivers => {
                for (sum, channel) in sum.iter_mut().zip(channels) {
                    sum.iter_mut().zip(channel).for_each(|(sum, p)| *sum += p);
                }
            }
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
