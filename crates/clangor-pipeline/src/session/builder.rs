//! Settings to open a session with.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clangor_core::acoustics::Acoustics;
use clangor_core::contact::{ContactSettings, ForceSettings};
use clangor_core::glam::DVec3;
use clangor_core::scene::Scene;
use clangor_core::scene::body_description::Copies;
use clangor_core::scene::diagnostic::Place;
use clangor_core::scene::listener::ListenerDescription;
use clangor_core::scene::render_description::{self as description, Parts};
use clangor_core::sound_model::AccelerationRule;
use clangor_core::synthesis::{RenderSettings, SampleRate};

use super::error::Error;
use super::progress::Progress;
use super::source::Source;
use super::{OnProgress, Session};
use crate::formats::model_cache::ModelCache;
use crate::formats::wav::{SampleFormat, WavSpec};
use crate::stages::load::{load_scene, scene_in_memory};
use crate::stages::render::{FullScale, RenderOptions, Transfers};
use crate::stages::sound_models::ModelOptions;

/// Settings of a session in place of those of its scene; what is not set follows the scene.
#[derive(Default)]
pub struct SessionBuilder<'p> {
    listeners: Vec<ListenerDescription>,
    duration: Option<f64>,
    seed: Option<u64>,
    window: (Option<f64>, Option<f64>),
    sample_rate: Option<u32>,
    parts: Option<Parts>,
    transfers: Transfers,
    acceleration_rule: Option<AccelerationRule>,
    models: ModelOptions,
    format: Option<SampleFormat>,
    full_scale: Option<FullScale>,
    stems: bool,
    cache: Option<PathBuf>,
    keep: Option<(PathBuf, bool)>,
    on_progress: Option<OnProgress<'p>>,
}

impl<'p> SessionBuilder<'p> {
    /// Everything as the scene says.
    pub fn new() -> Self {
        SessionBuilder::default()
    }

    /// Adds a listener at a position \[m\]; the listeners of the scene do not count then.
    #[must_use]
    pub fn listener(mut self, position: impl Into<DVec3>) -> Self {
        let (position, number) = (position.into(), self.listeners.len() + 1);
        let field = format!("--listener {},{},{}", position.x, position.y, position.z);
        let place = Place { field, ..Place::default() };
        let listener = ListenerDescription::mono(format!("listener-{number}"), position);
        self.listeners.push(ListenerDescription { place, ..listener });
        self
    }

    /// Simulated time \[s\].
    #[must_use]
    pub fn duration(self, seconds: f64) -> Self {
        SessionBuilder { duration: Some(seconds), ..self }
    }

    /// Seed of random placements and crack patterns.
    #[must_use]
    pub fn seed(self, seed: u64) -> Self {
        SessionBuilder { seed: Some(seed), ..self }
    }

    /// Start of the written sound \[s\]. Default: 0.
    #[must_use]
    pub fn from(self, start: f64) -> Self {
        SessionBuilder { window: (Some(start), self.window.1), ..self }
    }

    /// End of the written sound \[s\]. Default: that of the motion.
    #[must_use]
    pub fn to(self, end: f64) -> Self {
        SessionBuilder { window: (self.window.0, Some(end)), ..self }
    }

    /// Samples per second \[Hz\], 8000 to 384 000.
    #[must_use]
    pub fn sample_rate(self, hz: u32) -> Self {
        SessionBuilder { sample_rate: Some(hz), ..self }
    }

    /// Parts of the sound that are rendered.
    #[must_use]
    pub fn parts(self, parts: Parts) -> Self {
        SessionBuilder { parts: Some(parts), ..self }
    }

    /// How modes become pressure. Default: by their transfers.
    #[must_use]
    pub fn transfers(self, transfers: Transfers) -> Self {
        SessionBuilder { transfers, ..self }
    }

    /// One rule for the fields of all bodies.
    #[must_use]
    pub fn acceleration(self, rule: AccelerationRule) -> Self {
        SessionBuilder { acceleration_rule: Some(rule), ..self }
    }

    /// How sound models are baked, and the highest frequency that is rendered in full.
    #[must_use]
    pub fn models(self, models: ModelOptions) -> Self {
        SessionBuilder { models, ..self }
    }

    /// Format of a sample.
    #[must_use]
    pub fn format(self, format: SampleFormat) -> Self {
        SessionBuilder { format: Some(format), ..self }
    }

    /// What full scale of a file is.
    #[must_use]
    pub fn full_scale(self, full_scale: FullScale) -> Self {
        SessionBuilder { full_scale: Some(full_scale), ..self }
    }

    /// Whether a file is written for each body and part that sounds. Default: no.
    #[must_use]
    pub fn stems(self, stems: bool) -> Self {
        SessionBuilder { stems, ..self }
    }

    /// Folder of baked sound models. Default: `CLANGOR_CACHE`, or the system's folder for caches.
    #[must_use]
    pub fn cache(self, folder: impl Into<PathBuf>) -> Self {
        SessionBuilder { cache: Some(folder.into()), ..self }
    }

    /// Keeps the simulated timeline in a folder; with `replace`, in place of an older one.
    #[must_use]
    pub fn keep_timeline(self, folder: impl Into<PathBuf>, replace: bool) -> Self {
        SessionBuilder { keep: Some((folder.into(), replace)), ..self }
    }

    /// Sends progress to `on_progress`, which breaks to stop.
    #[must_use]
    pub fn on_progress(self, on_progress: impl FnMut(&Progress<'_>) -> ControlFlow<()> + Send + 'p) -> Self {
        SessionBuilder { on_progress: Some(Box::new(on_progress)), ..self }
    }

    /// Opens a scene (`.toml`) or a timeline folder (`.timeline`).
    ///
    /// # Errors
    /// [`Error::Load`] with every error of a scene at once, [`Error::Timeline`], [`Error::AlreadySimulated`]
    /// for
    /// settings of the simulation of a timeline, [`Error::ModelOptions`], [`Error::Synthesis`].
    pub fn open(self, path: impl AsRef<Path>) -> Result<Session<'p>, Error> {
        let path = path.as_ref();
        let is_timeline = path.is_dir() || path.extension().is_some_and(|ending| ending == "timeline");
        let source = match is_timeline {
            true => {
                self.check_simulated(path)?;
                Source::of_timeline(path, &self.listeners)?
            }
            false => Source::from_scene(load_scene(path, &|scene| self.adjust(scene))?),
        };
        // The folder says more of the person than of the sound.
        let name = path.file_name().unwrap_or(path.as_os_str()).display().to_string();
        self.session(source, name)
    }

    /// A session for a scene in memory; mesh files are looked for in the current folder.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn from_scene(self, mut scene: Scene) -> Result<Session<'p>, Error> {
        self.adjust(&mut scene);
        let source = Source::from_scene(scene_in_memory(scene)?);
        self.session(source, "a scene in memory".into())
    }

    /// Rejects settings of the simulation of a timeline.
    fn check_simulated(&self, path: &Path) -> Result<(), Error> {
        let settings = [
            ("a folder for the timeline", self.keep.is_some()),
            ("a seed", self.seed.is_some()),
            ("a duration", self.duration.is_some()),
        ];
        match settings.into_iter().find(|(_, set)| *set) {
            Some((setting, _)) => Err(Error::AlreadySimulated { path: path.into(), setting }),
            None => Ok(()),
        }
    }

    /// Replaces what is set in a scene before bodies are made of it.
    fn adjust(&self, scene: &mut Scene) {
        if let Some(seed) = self.seed {
            reseed(scene, seed);
        }
        scene.simulation.duration = self.duration.unwrap_or(scene.simulation.duration);
        if !self.listeners.is_empty() {
            scene.listeners.clone_from(&self.listeners);
        }
    }

    fn session(self, source: Source, note: String) -> Result<Session<'p>, Error> {
        let options = self.render_options(&source, note)?;
        let nothing: OnProgress<'p> = Box::new(|_| ControlFlow::Continue(()));
        Ok(Session {
            source,
            options,
            model_options: self.models,
            acceleration_rule: self.acceleration_rule,
            cache: ModelCache::find(self.cache.as_deref()),
            keep: self.keep,
            on_progress: self.on_progress.unwrap_or(nothing),
            plan: None,
            motion: None,
            models: None,
        })
    }

    /// The settings of the scene under those of the builder.
    fn render_options(&self, source: &Source, note: String) -> Result<RenderOptions, Error> {
        let settings = &source.settings;
        let format = self.format.unwrap_or(match settings.bits {
            description::SampleFormat::Float32 => SampleFormat::Float32,
            description::SampleFormat::Int24 => SampleFormat::Pcm24,
        });
        let full_scale = self.full_scale.unwrap_or(match settings.level {
            description::Level::Default => FullScale::Pascals(WavSpec::default_full_scale(format)),
            description::Level::FullScale(pressure) => FullScale::Pascals(pressure),
            description::Level::Normalize(level) => FullScale::Peak(level),
        });
        let sample_rate = SampleRate::try_new(self.sample_rate.unwrap_or(settings.sample_rate))?;
        self.models.check(sample_rate.as_f64())?;
        Ok(RenderOptions {
            listeners: source.listeners.clone(),
            contact: ContactSettings {
                v_min: source.v_min,
                forces: ForceSettings {
                    profile: settings.pulse,
                    steps: f64::from(settings.contact_steps),
                    band: 0.5 * sample_rate.as_f64(),
                    ..ForceSettings::default()
                },
                chain_onset: settings.chain_onset,
            },
            synthesis: RenderSettings {
                sample_rate,
                start: self.window.0.unwrap_or(0.0),
                acoustics: Acoustics {
                    max_frequency: self.models.max_frequency.or(source.acoustics.max_frequency),
                    ..source.acoustics
                },
                sphere_model: settings.radiation,
            },
            parts: self.parts.unwrap_or(settings.parts),
            transfers: self.transfers,
            ground: settings.ground,
            inherit_vibration: settings.inherit_vibration,
            rolling: source.time_step.filter(|_| settings.rolling),
            to: self.window.1.unwrap_or(source.duration),
            format,
            full_scale,
            compressor: settings.compressor,
            stems: self.stems,
            note,
        })
    }
}

/// Draws every random placement and crack pattern of a scene from a new seed.
pub fn reseed(scene: &mut Scene, seed: u64) {
    scene.simulation.seed = seed;
    for body in &mut scene.bodies {
        if let Some(breaking) = &mut body.breaking {
            breaking.seed = None;
        }
        if let Copies::Random(placement) = &mut body.copies {
            placement.seed = None;
        }
    }
}
