//! Impacts become sound at listeners, and sound becomes WAV files.
//!
//! ```text
//! impacts ─► force pulses ─► clicks, voices ─► one pass per listener and stem ─► WAV, levels, energies
//! ```
//!
//! A pass streams: blocks of clicks are rendered on all threads, added in a fixed order, joined by what rings
//! meanwhile, and written as soon as they are complete. Normalising takes a pass of its own to find the peak,
//! so that memory stays flat however long the sound is.

mod energy_limit;
mod file_names;
mod ground;
mod propagation_paths;
mod ringing;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clangor_core::body::{Body, BodyId};
use clangor_core::contact::force_stream::{StreamSettings, force_stream};
use clangor_core::contact::{
    ContactError, ContactReport, ContactSettings, ImpactPulse, PoseHistory, crack_pulses, impact_pulses,
};
use clangor_core::output::compressor::Compressor;
use clangor_core::propagation::{Air, LateReverberation, Room, RoomError};
use clangor_core::scene::render_description::{Compressor as CompressorSettings, GroundSound, Parts};
use clangor_core::synthesis::acceleration_pulse::clicks_of;
use clangor_core::synthesis::ground::{GroundError, ground_clicks};
use clangor_core::synthesis::{
    AccelerationPulse, Listener, RenderReport, RenderSettings, Renderer, SoundSource, SynthesisError,
};
use clangor_core::timeline::{ContactRow, Timeline};

pub use self::energy_limit::EnergyLimits;
pub(crate) use self::energy_limit::impacts_on;
use self::file_names::{check_distinct, file_name};
use self::ringing::{Breaking, RingingBodies, Rolling, Voices};
pub use self::ringing::{ModalStateTransfer, Transfers, UnplayableModes, modal_sources};
use crate::formats::atomic_file::check_folder;
use crate::formats::timeline_file::{TimelineError, TimelineReader};
use crate::formats::wav::{Meaning, SampleFormat, WavError, WavSpec, WavWriter};
use crate::plots::levels::{LevelMeter, Levels};
use crate::stages::sound_models::ringers::Ringers;
use propagation_paths::{PathRenderer, paths_to, reverberation, take_until};

/// Why nothing was rendered.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The contacts cannot be turned into forces.
    #[error(transparent)]
    Contact(#[from] ContactError),
    /// The sound cannot be synthesised.
    #[error(transparent)]
    Synthesis(#[from] SynthesisError),
    /// A plane cannot sound.
    #[error("{0}; change the material, or use ground = \"none\"")]
    Ground(#[from] GroundError),
    /// The room cannot reflect.
    #[error(transparent)]
    Room(#[from] RoomError),
    /// Modes cannot be played.
    #[error(transparent)]
    Modes(#[from] UnplayableModes),
    /// A file cannot be written.
    #[error(transparent)]
    Wav(#[from] WavError),
    /// There is nobody to render for.
    #[error("there is no listener; add a [[listener]] to the scene, or use --listener X,Y,Z")]
    NoListener,
    /// Nothing between start and end.
    #[error("the sound would end at {to} s, not after its start at {from} s")]
    NothingToWrite {
        /// Start \[s\].
        from: f64,
        /// End \[s\].
        to: f64,
    },
    /// Two sounds of the same file name.
    #[error("{first} and {second} would both be written to {path}; rename one")]
    SameFile {
        /// What would be written first.
        first: String,
        /// What would replace it.
        second: String,
        /// Where.
        path: PathBuf,
    },
    /// Stopped by the caller.
    #[error("interrupted")]
    Interrupted,
}

/// What full scale of a file is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FullScale {
    /// This pressure \[Pa\].
    Pascals(f64),
    /// Whatever brings the loudest sample of a listener to this level \[dBFS\].
    Peak(f64),
}

/// How to render, and what to write.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    /// Who listens.
    pub listeners: Vec<Listener>,
    /// Impacts to forces.
    pub contact: ContactSettings,
    /// Forces to pressure; `start` is the time of the first sample written \[s\].
    pub synthesis: RenderSettings,
    /// What of the sound is rendered.
    pub parts: Parts,
    /// How modes become pressure.
    pub transfers: Transfers,
    /// How planes sound that are hit.
    pub ground: GroundSound,
    /// What the air takes from the sound; `None`: nothing.
    pub air: Option<Air>,
    /// The room around everything.
    pub room: Option<Room>,
    /// Whether impacts put no more energy into modes than the motion lost.
    pub limit_energy: bool,
    /// Whether pieces go on with the vibration of what they were part of.
    pub inherit_vibration: bool,
    /// Time step \[s\] of the dynamics whose gentle forces make bodies ring too; `None`: only impacts do.
    pub rolling: Option<f64>,
    /// End of the sound \[s\].
    pub to: f64,
    /// Format of a sample.
    pub format: SampleFormat,
    /// What full scale means.
    pub full_scale: FullScale,
    /// Dynamic range compression, after which a file is no longer pressure.
    pub compressor: Option<CompressorSettings>,
    /// Also a file for each body that sounds.
    pub stems: bool,
    /// A line for the comment of the files.
    pub note: String,
}

impl RenderOptions {
    /// Whether these options can give sound: to be asked before a long simulation.
    ///
    /// # Errors
    /// Those of [`render`] that do not depend on the impacts.
    pub fn check(&self, bodies: &[Body], output: &Path) -> Result<(), RenderError> {
        check_folder(output).map_err(WavError::from)?;
        self.check_sound()?;
        check_distinct(self, bodies, output)
    }

    /// Whether anybody can hear anything: the same without files.
    ///
    /// # Errors
    /// Those of [`render`] that depend neither on the impacts nor on files.
    pub fn check_sound(&self) -> Result<(), RenderError> {
        if self.listeners.is_empty() {
            return Err(RenderError::NoListener);
        }
        let from = self.synthesis.start;
        if self.to <= from {
            return Err(RenderError::NothingToWrite { from, to: self.to });
        }
        for listener in &self.listeners {
            Renderer::new(listener, &self.synthesis)?;
        }
        let rate = self.synthesis.sample_rate.as_f64();
        reverberation(self.room.as_ref(), self.air, &self.synthesis.medium, rate)?;
        Ok(())
    }
}

/// What bodies sound as.
#[derive(Clone, Copy, Debug)]
pub struct Sounds<'a> {
    /// When they are accelerated, in their order.
    pub sources: &'a [SoundSource],
    /// When they vibrate.
    pub ringers: &'a Ringers,
}

/// One part of the sound of one body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Stem {
    /// The body.
    pub body: BodyId,
    /// The part.
    pub part: StemPart,
}

/// A part of a body's sound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum StemPart {
    /// Clicks.
    Acceleration,
    /// Ringing.
    Modal,
    /// Ground that is hit.
    Ground,
}

impl std::fmt::Display for StemPart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            StemPart::Acceleration => "acceleration",
            StemPart::Modal => "modal",
            StemPart::Ground => "ground",
        })
    }
}

/// A file that was written.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderedFile {
    /// Where.
    pub path: PathBuf,
    /// Who heard it.
    pub listener: String,
    /// What is in a stem.
    pub stem: Option<Stem>,
    /// Pressure of a sample of 1 \[Pa\].
    pub full_scale: f64,
    /// How loud it is.
    pub levels: Levels,
    /// Samples beyond full scale (24-bit only).
    pub clipped_samples: u64,
}

/// What a rendering did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderSummary {
    /// The files, in order of listener; a mix before its stems.
    pub files: Vec<RenderedFile>,
    /// What became of the impacts.
    pub contacts: ContactReport,
    /// What each listener could not hear.
    pub listeners: Vec<RenderReport>,
    /// Sum of ∫ p² dt of the clicks over all receivers \[Pa² s\] by body.
    pub energies: BTreeMap<BodyId, f64>,
    /// The same of the ringing.
    pub modal_energies: BTreeMap<BodyId, f64>,
    /// The same of the ground, by plane.
    pub ground_energies: BTreeMap<BodyId, f64>,
    /// What became of the vibration of bodies that broke.
    pub handovers: BTreeMap<BodyId, ModalStateTransfer>,
    /// Energy of the impacts on bodies that ring, against that which they have.
    pub energy_limits: BTreeMap<BodyId, EnergyLimits>,
    /// Estimates of the same above the band of the fields, for bodies whose field ends within the band
    /// rendered.
    pub missing_energies: BTreeMap<BodyId, f64>,
}

/// The impacts and the releases of cracks of a timeline, as forces.
pub(crate) struct Forces {
    pub(crate) poses: PoseHistory,
    /// In order of time.
    pub(crate) pulses: Vec<ImpactPulse>,
    contacts: ContactReport,
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

/// Renders the impacts of a timeline for every listener into `output`; `sounds` says what each body sounds
/// as.
///
/// One listener makes the file `output`; several make `NAME.LISTENER.wav` each. Stems are
/// `….BODY.acceleration.wav`, `….BODY.modal.wav` and `….PLANE.ground.wav`. `progress` is told which part of
/// the work is done, from 0 to 1.
///
/// # Errors
/// [`RenderError`]; a file appears only once it is complete.
pub fn render(
    bodies: &[Body],
    sounds: &Sounds<'_>,
    timeline: &Timeline,
    options: &RenderOptions,
    output: &Path,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<RenderSummary, RenderError> {
    options.check(bodies, output)?;
    let Forces { poses, pulses, contacts } = forces(bodies, timeline, &options.contact)?;
    let rolling = match options.rolling.filter(|_| options.parts.modal) {
        Some(time_step) => {
            let v_min = options.contact.v_min;
            let settings = StreamSettings { v_min, time_step, rest_speed: REST_SPEED };
            Some(Rolling { forces: force_stream(bodies, &timeline.contacts, &poses, &settings)?, time_step })
        }
        None => None,
    };
    let mut clicks: Vec<AccelerationPulse> = match options.parts.acceleration {
        true => pulses.iter().flat_map(|p| clicks_of(p, sounds.sources)).collect(),
        false => Vec::new(),
    };
    let grounds = ground::grounds(bodies, options)?;
    clicks.extend(pulses.iter().flat_map(|pulse| ground_clicks(pulse, bodies, &grounds)));
    clicks.sort_by(|a, b| a.time.total_cmp(&b.time));
    let impacts = (&pulses[..], options.limit_energy);
    let breaking = Breaking { fractures: &timeline.fractures, poses: &poses };
    let breaking = options.inherit_vibration.then_some(breaking);
    let ringing = RingingBodies::new(bodies, sounds.ringers, options.transfers, impacts, breaking)?;

    let mut stems = vec![None];
    if options.stems {
        let clicking = clicks.iter().map(|click| {
            let ground = grounds.contains_key(&click.body);
            Stem { body: click.body, part: if ground { StemPart::Ground } else { StemPart::Acceleration } }
        });
        let ringing = ringing.bodies().map(|body| Stem { body, part: StemPart::Modal });
        let sounding: BTreeSet<Stem> = clicking.chain(ringing).collect();
        stems.extend(sounding.into_iter().map(Some));
    }
    let passes = options.listeners.len()
        * (stems.len() + usize::from(matches!(options.full_scale, FullScale::Peak(_))));
    let mut summary = RenderSummary {
        contacts,
        energy_limits: ringing.limits(),
        handovers: ringing.handovers().clone(),
        ..RenderSummary::default()
    };
    let mut done = 0.0;
    for listener in &options.listeners {
        let mut full_scale = None;
        for &stem in &stems {
            let own: Vec<AccelerationPulse>;
            let (heard, ringing) = match stem {
                None => (&clicks[..], Some((&ringing, None))),
                Some(Stem { body, part: StemPart::Acceleration | StemPart::Ground }) => {
                    own = clicks.iter().filter(|c| c.body == body).cloned().collect();
                    (&own[..], None)
                }
                Some(Stem { body, part: StemPart::Modal }) => (&[][..], Some((&ringing, Some(body)))),
            };
            let mut pass = Pass {
                listener,
                options,
                clicks: heard,
                ringing,
                rolling: rolling.as_ref(),
                poses: &poses,
                passes,
                done: &mut done,
                progress: &mut *progress,
            };
            // Stems keep the full scale of their mix, so that they add up to it.
            let scale = match full_scale {
                Some(scale) => scale,
                None => pass.full_scale()?,
            };
            full_scale = Some(scale);
            let named = stem.map(|stem| (bodies[stem.body.index()].name.as_str(), stem.part));
            let path = file_name(output, options, listener, named);
            let (file, heard) = pass.write(&path, scale)?;
            if stem.is_none() {
                summary.listeners.push(heard.report);
                let (ground, energies) =
                    heard.energies.into_iter().partition(|(body, _)| grounds.contains_key(body));
                let sums: [(_, BTreeMap<BodyId, f64>); 4] = [
                    (&mut summary.energies, energies),
                    (&mut summary.ground_energies, ground),
                    (&mut summary.missing_energies, heard.missing_energies),
                    (&mut summary.modal_energies, heard.modal_energies),
                ];
                for (sum, energies) in sums {
                    energies.into_iter().for_each(|(body, energy)| *sum.entry(body).or_default() += energy);
                }
            }
            summary.files.push(RenderedFile { stem, ..file });
        }
    }
    Ok(summary)
}

/// What came of a pass besides samples.
struct Heard {
    report: RenderReport,
    energies: BTreeMap<BodyId, f64>,
    missing_energies: BTreeMap<BodyId, f64>,
    modal_energies: BTreeMap<BodyId, f64>,
}

/// One listener, one selection of clicks and voices.
struct Pass<'a> {
    listener: &'a Listener,
    options: &'a RenderOptions,
    clicks: &'a [AccelerationPulse],
    /// What rings: all bodies, or one of them.
    ringing: Option<(&'a RingingBodies, Option<BodyId>)>,
    rolling: Option<&'a Rolling>,
    poses: &'a PoseHistory,
    /// How many passes there are.
    passes: usize,
    /// How many are done.
    done: &'a mut f64,
    progress: &'a mut dyn FnMut(f64) -> ControlFlow<()>,
}

impl Pass<'_> {
    /// Pressure of a sample of 1 \[Pa\].
    fn full_scale(&mut self) -> Result<f64, RenderError> {
        match self.options.full_scale {
            FullScale::Pascals(pressure) => Ok(pressure),
            FullScale::Peak(level) => {
                let mut peak = 0.0f32;
                self.stream(None, &mut |samples| {
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
    fn write(&mut self, path: &Path, full_scale: f64) -> Result<(RenderedFile, Heard), RenderError> {
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
        let heard = self.stream(compressor, &mut |samples| {
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

    /// Renders and hands over the pressure \[Pa\], interleaved, a stretch at a time.
    fn stream(
        &mut self,
        mut compressor: Option<Compressor>,
        sink: &mut dyn FnMut(&[f32]) -> Result<(), WavError>,
    ) -> Result<Heard, RenderError> {
        let settings = &self.options.synthesis;
        let rate = settings.sample_rate.as_f64();
        let total = ((self.options.to - settings.start) * rate).round() as i64;
        let (room, air) = (self.options.room.as_ref(), self.options.air);
        let paths = paths_to(self.listener, settings, room, air);
        let (ringing, rolling, poses) = (self.ringing, self.rolling, self.poses);
        let mut late = reverberation(room, air, &settings.medium, rate)?;
        let mut path_renderers = Vec::with_capacity(paths.len());
        for path in &paths {
            path_renderers.push(PathRenderer::new(path, |listener, settings| match ringing {
                Some((bodies, only)) => bodies.voices(rolling, poses, listener, settings, only),
                None => Ok(Voices::none()),
            })?);
        }
        let quiet_before = earliest_from(self.clicks);
        for (index, click) in self.clicks.iter().enumerate() {
            if click.time > self.options.to {
                break;
            }
            path_renderers.iter_mut().try_for_each(|path_renderer| path_renderer.push(click))?;
            let next = quiet_before.get(index + 1).copied().unwrap_or(f64::INFINITY);
            if next.is_finite() {
                let mut ready = false;
                for path_renderer in &mut path_renderers {
                    let jobs = path_renderer.renderer.take_ready(next);
                    ready |= !jobs.is_empty();
                    path_renderer.add(&jobs);
                }
                if ready {
                    let complete =
                        path_renderers.iter().map(|path_renderer| path_renderer.renderer.complete_until());
                    let end = complete.fold(total, i64::min);
                    hand_over(&mut path_renderers, &mut late, end, &mut compressor, sink)?;
                    self.reached(path_renderers[0].signal.first() as f64 / total as f64)?;
                }
            }
        }
        for path_renderer in &mut path_renderers {
            for jobs in path_renderer.renderer.take_all().chunks(BLOCKS_AT_ONCE) {
                path_renderer.add(jobs);
                self.reached(path_renderer.signal.first() as f64 / total as f64)?;
            }
        }
        while path_renderers[0].signal.first() < total {
            let end = (path_renderers[0].signal.first() + FRAMES_AT_ONCE).min(total);
            hand_over(&mut path_renderers, &mut late, end, &mut compressor, sink)?;
            self.reached(path_renderers[0].signal.first() as f64 / total as f64)?;
        }
        let PathRenderer { renderer, signal, voices, .. } = &path_renderers[0];
        *self.done += 1.0;
        Ok(Heard {
            report: renderer.report().clone(),
            energies: signal.energies().clone(),
            missing_energies: signal.missing_energies().clone(),
            modal_energies: voices.energies().clone(),
        })
    }

    /// Tells how much of this pass is done, from 0 to 1.
    fn reached(&mut self, part: f64) -> Result<(), RenderError> {
        match (self.progress)((*self.done + part) / self.passes as f64) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(RenderError::Interrupted),
        }
    }
}

/// A pair whose surfaces move more slowly is at rest, and silent [m/s].
const REST_SPEED: f64 = 1e-3;
/// Blocks rendered between two looks at whether to stop.
const BLOCKS_AT_ONCE: usize = 256;
/// Frames handed over at once.
const FRAMES_AT_ONCE: i64 = 1 << 16;

/// For each click, the earliest time at which the force of it or of a later one acts \[s\].
fn earliest_from(clicks: &[AccelerationPulse]) -> Vec<f64> {
    let mut earliest = vec![f64::INFINITY; clicks.len()];
    let mut least = f64::INFINITY;
    for (slot, click) in earliest.iter_mut().zip(clicks).rev() {
        least = least.min(click.time + click.profile.extent(click.duration).0);
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
    sink: &mut dyn FnMut(&[f32]) -> Result<(), WavError>,
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

/// The impacts of a timeline folder and the poses of their bodies at them, and all poses of the bodies that
/// are `followed` and of their pieces, leaving the rest on the disk; with `rolling`, what touches them gently
/// too.
///
/// # Errors
/// [`TimelineError`] for rows that cannot be read.
pub fn read_impacts(
    reader: &TimelineReader,
    followed: &BTreeSet<BodyId>,
    rolling: bool,
) -> Result<Timeline, TimelineError> {
    let mut timeline = Timeline {
        fractures: reader.fractures().to_vec(),
        births: reader.births().to_vec(),
        ..Timeline::default()
    };
    let mut followed = followed.clone();
    for fracture in reader.fractures() {
        if followed.contains(&fracture.parent) {
            followed.extend(fracture.pieces());
        }
    }
    for row in reader.contacts()? {
        let row = row?;
        let gentle = || rolling && [row.body_a, row.body_b].iter().any(|id| followed.contains(id));
        if row.impact_id != 0 || gentle() {
            timeline.contacts.push(row);
        }
    }
    timeline.contacts.sort_by(|a, b| a.time.total_cmp(&b.time));
    let impacts = timeline.contacts.iter().filter(|r| r.impact_id != 0);
    let times: Vec<f64> = impacts.map(|r| r.time).collect();
    // A pose at an impact has its very time; where there is none, its neighbours at the pose rate are needed.
    let margin =
        if reader.header().origin.pose_rate > 0.0 { 1.5 / reader.header().origin.pose_rate } else { 0.0 };
    for row in reader.poses()? {
        let row = row?;
        let after = times.partition_point(|t| *t < row.time - margin);
        if followed.contains(&row.body) || times.get(after).is_some_and(|t| *t <= row.time + margin) {
            timeline.poses.push(row);
        }
    }
    timeline.poses.sort_by(|a, b| a.time.total_cmp(&b.time));
    Ok(timeline)
}
