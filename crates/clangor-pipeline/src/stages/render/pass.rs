//! One pass: one listener hears one selection of the sound, streamed into a sink.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;

use clangor_core::body::BodyId;
use clangor_core::output::compressor::Compressor;
use clangor_core::propagation::LateReverberation;
use clangor_core::synthesis::{AccelerationPulse, Listener, RenderReport};

use super::error::RenderError;
use super::modal_sources::VoiceSettings;
use super::modal_voices::ModalVoices;
use super::options::{FullScale, RenderOptions};
use super::propagation_paths::{PathGroup, PathRenderer, paths_to, reverberation, take_until};
use super::sounding_scene::SoundingScene;
use super::summary::RenderedFile;
use crate::analysis::levels::LevelMeter;
use crate::formats::wav::{Meaning, WavError, WavSpec, WavWriter};

/// What a pass gives besides samples; energies are ∫ p² dt over all receivers \[Pa² s\].
pub(super) struct Heard {
    pub(super) report: RenderReport,
    pub(super) energies: BTreeMap<BodyId, f64>,
    pub(super) missing_energies: BTreeMap<BodyId, f64>,
    pub(super) modal_energies: BTreeMap<BodyId, f64>,
}

/// Which vibrating bodies are heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Vibrating {
    /// All.
    All,
    /// One of them.
    Only(BodyId),
    /// None.
    None,
}

/// How far a rendering of several passes is.
pub(super) struct PassProgress<'a> {
    /// How many passes there are.
    pub(super) passes: usize,
    /// How many are done.
    pub(super) done: f64,
    pub(super) progress: &'a mut dyn FnMut(f64) -> ControlFlow<()>,
}

impl PassProgress<'_> {
    /// Reports that a part of this pass, from 0 to 1, is done.
    fn reached(&mut self, part: f64) -> Result<(), RenderError> {
        match (self.progress)((self.done + part) / self.passes as f64) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(RenderError::Interrupted),
        }
    }
}

/// One listener, one selection of clicks and voices.
pub(super) struct Pass<'a> {
    pub(super) listener: &'a Listener,
    pub(super) options: &'a RenderOptions,
    pub(super) scene: &'a SoundingScene,
    /// The clicks that are heard, in order of time.
    pub(super) clicks: &'a [AccelerationPulse],
    pub(super) vibrating: Vibrating,
}

/// Where the interleaved pressure \[Pa\] goes.
type Sink<'a> = dyn FnMut(&[f32]) -> Result<(), WavError> + 'a;

impl Pass<'_> {
    /// Pressure of a sample of 1 \[Pa\].
    pub(super) fn full_scale(&self, progress: &mut PassProgress<'_>) -> Result<f64, RenderError> {
        match self.options.full_scale {
            FullScale::Pascals(pressure) => Ok(pressure),
            FullScale::Peak(level) => {
                let mut peak = 0.0f32;
                self.stream(None, progress, &mut |samples| {
                    peak = samples.iter().fold(peak, |m, p| m.max(p.abs()));
                    Ok(())
                })?;
                // Silence has no peak to normalise.
                let peak = if peak > 0.0 { f64::from(peak) } else { 1.0 };
                Ok(peak / 10f64.powf(level / 20.0))
            }
        }
    }

    /// Renders into a file.
    pub(super) fn write(
        &self,
        path: &Path,
        full_scale: f64,
        progress: &mut PassProgress<'_>,
    ) -> Result<(RenderedFile, Heard), RenderError> {
        let sample_rate = self.options.synthesis.sample_rate.hz();
        let channels = self.listener.receivers.len() as u16;
        let spec = WavSpec {
            sample_rate,
            channels,
            format: self.options.format,
            full_scale,
            meaning: if self.options.compressor.is_some() { Meaning::Processed } else { Meaning::Pressure },
            note: format!("{}; listener \"{}\"", self.options.note, self.listener.name),
        };
        let mut file = WavWriter::create(path, spec)?;
        let mut meter = LevelMeter::new(channels, sample_rate, full_scale);
        let rate = self.options.synthesis.sample_rate.as_f64();
        let compressor = self.options.compressor.as_ref().map(|c| Compressor::new(c, rate, full_scale));
        let heard = self.stream(compressor, progress, &mut |samples| {
            meter.add(samples);
            file.write(samples)
        })?;
        let summary = file.finish()?;
        let rendered = RenderedFile {
            path: path.into(),
            listener: self.listener.name.clone(),
            stem: None,
            full_scale,
            levels: meter.levels(),
            clipped_samples: summary.clipped_samples,
        };
        Ok((rendered, heard))
    }

    /// Renders the pressure \[Pa\] into memory, interleaved.
    pub(super) fn collect(&self, progress: &mut PassProgress<'_>) -> Result<Vec<f32>, RenderError> {
        let mut pressure = Vec::new();
        self.stream(None, progress, &mut |samples| {
            pressure.extend_from_slice(samples);
            Ok(())
        })?;
        Ok(pressure)
    }

    /// Renders the pressure \[Pa\] into the sink, interleaved, a stretch at a time.
    fn stream(
        &self,
        mut compressor: Option<Compressor>,
        progress: &mut PassProgress<'_>,
        sink: &mut Sink<'_>,
    ) -> Result<Heard, RenderError> {
        let settings = &self.options.synthesis;
        let rate = settings.sample_rate.as_f64();
        let total = ((self.options.to - settings.start) * rate).round() as i64;
        let groups = paths_to(self.listener, &settings.acoustics);
        let mut late = reverberation(&settings.acoustics, rate)?;
        let mut path_renderers = self.path_renderers(&groups)?;
        let quiet_before = earliest_from(self.clicks);
        for (index, click) in self.clicks.iter().enumerate() {
            if click.time > self.options.to {
                break;
            }
            path_renderers.iter_mut().try_for_each(|path_renderer| path_renderer.push(click))?;
            let next = quiet_before.get(index + 1).copied().unwrap_or(f64::INFINITY);
            // Blocks that no later click reaches are rendered now, so that memory stays flat.
            if next.is_finite() && render_ready(&mut path_renderers, next) {
                let complete =
                    path_renderers.iter().map(|path_renderer| path_renderer.renderer.complete_until());
                let end = complete.fold(total, i64::min);
                hand_over(&mut path_renderers, &mut late, end, &mut compressor, sink)?;
                progress.reached(path_renderers[0].signal.first() as f64 / total as f64)?;
            }
        }
        for path_renderer in &mut path_renderers {
            for jobs in path_renderer.renderer.take_all().chunks(BLOCKS_AT_ONCE) {
                path_renderer.add(jobs);
                progress.reached(path_renderer.signal.first() as f64 / total as f64)?;
            }
        }
        while path_renderers[0].signal.first() < total {
            let end = (path_renderers[0].signal.first() + FRAMES_AT_ONCE).min(total);
            hand_over(&mut path_renderers, &mut late, end, &mut compressor, sink)?;
            progress.reached(path_renderers[0].signal.first() as f64 / total as f64)?;
        }
        let PathRenderer { renderer, signal, voices, .. } = &path_renderers[0];
        progress.done += 1.0;
        Ok(Heard {
            report: renderer.report().clone(),
            energies: signal.energies().clone(),
            missing_energies: signal.missing_energies().clone(),
            modal_energies: voices.energies().clone(),
        })
    }

    /// A renderer with voices for each group of paths.
    fn path_renderers<'p>(&'p self, groups: &'p [PathGroup]) -> Result<Vec<PathRenderer<'p>>, RenderError> {
        let (scene, settings) = (self.scene, &self.options.synthesis);
        let mut renderers = Vec::with_capacity(groups.len());
        for group in groups {
            renderers.push(PathRenderer::new(group, settings, |listener, paths| {
                let only = match self.vibrating {
                    Vibrating::None => return Ok(ModalVoices::none()),
                    Vibrating::All => None,
                    Vibrating::Only(body) => Some(body),
                };
                let voice = VoiceSettings { poses: &scene.poses, listener, settings, paths };
                scene.modal.voices(scene.rolling.as_ref(), voice, only)
            })?);
        }
        Ok(renderers)
    }
}

/// Renders the blocks of all paths that no force acting from `next` on \[s\] reaches; whether there were any.
fn render_ready(path_renderers: &mut [PathRenderer<'_>], next: f64) -> bool {
    let mut ready = false;
    for path_renderer in path_renderers {
        let jobs = path_renderer.renderer.take_ready(next);
        ready |= !jobs.is_empty();
        path_renderer.add(&jobs);
    }
    ready
}

/// Blocks rendered between two looks at whether to stop.
const BLOCKS_AT_ONCE: usize = 256;
/// Frames handed over at once.
const FRAMES_AT_ONCE: i64 = 1 << 16;

/// For each click, the earliest time at which the force of it or of a later one acts \[s\].
fn earliest_from(clicks: &[AccelerationPulse]) -> Vec<f64> {
    let mut earliest = vec![f64::INFINITY; clicks.len()];
    let mut least = f64::INFINITY;
    for (slot, click) in earliest.iter_mut().zip(clicks).rev() {
        least = least.min(click.time + click.shape.extent(click.duration).0);
        *slot = least;
    }
    earliest
}

/// Takes the samples before `end`, compresses them if asked to, and passes them on, interleaved.
fn hand_over(
    path_renderers: &mut [PathRenderer<'_>],
    late: &mut Option<LateReverberation>,
    end: i64,
    compressor: &mut Option<Compressor>,
    sink: &mut Sink<'_>,
) -> Result<(), RenderError> {
    if end <= path_renderers[0].signal.first() {
        return Ok(());
    }
    let mut channels = take_until(path_renderers, late, end)?;
    if let Some(compressor) = compressor {
        compressor.process(&mut channels);
    }
    let frames = channels.first().map_or(0, Vec::len);
    let mut interleaved = Vec::with_capacity(frames * channels.len());
    for frame in 0..frames {
        interleaved.extend(channels.iter().map(|c| c[frame] as f32));
    }
    Ok(sink(&interleaved)?)
}
