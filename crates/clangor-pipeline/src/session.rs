//! From a scene to its sound, in one object: open, simulate, obtain sound models, render.
//!
//! ```text
//! open ─► simulate ─► obtain models ─► render
//! ```
//!
//! Each step runs the steps before it that have not run yet, and keeps its result. A session of a timeline
//! folder also writes the run for the page ([`Session::export_web`]), and any session hands it over in
//! the real-time engine ([`Session::levelled_run`]). For a single impact on a single body there is
//! [`Strike`].
//!
//! ```no_run
//! use clangor_pipeline::session::Session;
//!
//! let mut session = Session::open("scenes/ball-drop.toml")?;
//! let sound = session.render("ball-drop.wav")?;
//! println!("{} samples, peak {} Pa", sound.frames, sound.peak);
//! # Ok::<(), clangor_pipeline::session::Error>(())
//! ```

pub mod bake;
pub mod bake_scene;
mod builder;
pub mod compare;
mod compare_error;
mod error;
mod levelled_run;
mod live_body;
pub mod named_body;
mod progress;
mod saved_forces;
pub(crate) mod sounding_body;
mod source;
pub mod strike;
mod struck_body;
pub(crate) mod struck_model;
mod struck_sound;
mod top_point;
mod web_export;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clangor_core::body::{Body, BodyId};
use clangor_core::scene::Scene;
use clangor_core::sound_model::AccelerationRule;
use clangor_core::synthesis::SoundPart;
use clangor_core::timeline::Timeline;
use clangor_sim::SimulationReport;

pub use self::bake::{Bake, BakedBody, BakedFile};
pub use self::bake_scene::{BakedField, SceneBake};
pub use self::builder::{SessionBuilder, reseed};
pub use self::compare::{Compare, Comparison};
pub use self::compare_error::CompareError;
pub use self::error::Error;
pub use self::levelled_run::LevelledRun;
pub use self::live_body::{LiveBody, Meeting, Partner};
pub use self::named_body::{GltfBody, NamedSolid};
pub use self::progress::{Progress, Stage};
use self::source::{Motion, Source};
pub use self::strike::{DEFAULT_IMPULSE, Strike};
pub use self::struck_body::StruckBody;
pub use self::struck_sound::{StrikeRemark, StruckSound, check_sound_file};
pub use self::web_export::ExportedReplay;
use crate::formats::model_cache::ModelCache;
use crate::formats::soundbank::default_bank;
use crate::stages::find_collision_parts::find_collision_parts;
use crate::stages::find_impact_modes::find_impact_modes;
use crate::stages::load::LoadedScene;
use crate::stages::render::{
    HeardPressure, RenderOptions, RenderSummary, check_output, read_impacts, render, render_in_memory,
};
use crate::stages::simulate::{check_motion, simulate_and_keep, simulate_impacts};
use crate::stages::sound_models::{
    ModalPlanSettings, ModelOptions, SoundModelPlan, SoundModelProgress, SoundModelSettings, SoundModelStore,
    SoundModels,
};

/// Receives the progress of a session; breaks to stop it.
pub type OnProgress<'p> = Box<dyn FnMut(&Progress<'_>) -> ControlFlow<()> + Send + 'p>;

/// A scene or a timeline on its way to sound; see the module.
pub struct Session<'p> {
    source: Source,
    options: RenderOptions,
    model_options: ModelOptions,
    acceleration_rule: Option<AccelerationRule>,
    cache: Option<ModelCache>,
    /// Where the simulated timeline is kept, and whether an older one is replaced.
    keep: Option<(PathBuf, bool)>,
    on_progress: OnProgress<'p>,
    plan: Option<SoundModelPlan>,
    motion: Option<RecordedMotion>,
    models: Option<SoundModels>,
}

/// What moved, and how the simulation went; no report for a timeline that was opened.
struct RecordedMotion {
    timeline: Timeline,
    report: Option<SimulationReport>,
}

/// Sound written to files.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderedSound {
    /// Samples per channel of each file.
    pub frames: u64,
    /// Largest absolute pressure in any mix \[Pa\].
    pub peak: f64,
    /// Files, levels, energies, and what became of the impacts.
    pub summary: RenderSummary,
}

impl<'p> Session<'p> {
    /// Opens a scene (`.toml`) or a timeline folder (`.timeline`) with default settings.
    ///
    /// # Errors
    /// [`Error::Load`] for a scene, with all its errors at once; [`Error::Timeline`] for a timeline.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        SessionBuilder::new().open(path)
    }

    /// A session for a scene in memory; mesh files are looked for in the current folder.
    ///
    /// # Errors
    /// [`Error::Load`].
    pub fn from_scene(scene: Scene) -> Result<Self, Error> {
        SessionBuilder::new().from_scene(scene)
    }

    /// Settings to open a session with.
    pub fn builder() -> SessionBuilder<'p> {
        SessionBuilder::new()
    }

    /// Sends the progress of all following steps to `on_progress`, which breaks to stop.
    #[must_use]
    pub fn on_progress(self, on_progress: impl FnMut(&Progress<'_>) -> ControlFlow<()> + Send + 'p) -> Self {
        Session { on_progress: Box::new(on_progress), ..self }
    }

    /// Tells the receiver of progress how far a step outside the session is; breaks to stop it.
    pub fn report(&mut self, progress: &Progress<'_>) -> ControlFlow<()> {
        (self.on_progress)(progress)
    }

    /// The bodies: those present from the beginning, and after [`simulate`](Self::simulate) all that ever
    /// were.
    pub fn bodies(&self) -> &[Body] {
        &self.source.bodies
    }

    /// The same, to be changed before [`plan`](Self::plan).
    pub fn bodies_mut(&mut self) -> &mut [Body] {
        &mut self.source.bodies
    }

    /// The scene with its text and warnings; `None` for a timeline.
    pub fn scene(&self) -> Option<&LoadedScene> {
        match &self.source.motion {
            Motion::Scene(loaded) => Some(loaded),
            Motion::Timeline(_) => None,
        }
    }

    /// How the sound is rendered.
    pub fn options(&self) -> &RenderOptions {
        &self.options
    }

    /// How the sound models are obtained.
    pub fn model_options(&self) -> &ModelOptions {
        &self.model_options
    }

    /// Whether the scene asks for rolling that the dynamics cannot give.
    pub fn lacks_rolling(&self) -> bool {
        self.source.settings.rolling && self.options.rolling.is_none()
    }

    /// The sound models to be obtained, to be given known ones before the simulation.
    pub fn plan(&mut self) -> &mut SoundModelPlan {
        let Session { source, options, model_options, acceleration_rule, .. } = self;
        self.plan.get_or_insert_with(|| {
            let synthesis = &options.synthesis;
            let modal = ModalPlanSettings {
                options: model_options.modal(synthesis.acoustics.medium, synthesis.band().0),
                proxy_frequency: source.settings.proxy_frequency,
            };
            let settings = SoundModelSettings {
                acceleration: model_options.acceleration(synthesis.max_wavenumber()),
                wants_acceleration: options.parts.acceleration,
                modal: Some(modal).filter(|_| options.parts.modal),
                patience: model_options.patience(),
            };
            let plan = SoundModelPlan::new(&source.bodies, &source.rules, settings);
            match *acceleration_rule {
                Some(rule) => plan.with_acceleration_rule(rule),
                None => plan,
            }
        })
    }

    /// Simulates the scene, or reads the timeline, as far as it is heard. Returns the report of a simulation;
    /// `None` for a timeline.
    ///
    /// # Errors
    /// [`Error::Simulate`], [`Error::Timeline`], and those of settings that give no sound.
    pub fn simulate(&mut self) -> Result<Option<&SimulationReport>, Error> {
        if self.motion.is_none() {
            self.options.check_sound()?;
            let followed = self.plan().followed();
            let motion = self.record(&followed)?;
            self.source.bodies = motion.timeline.all_bodies(&self.source.bodies);
            self.motion = Some(motion);
        }
        Ok(self.motion.as_ref().and_then(|motion| motion.report.as_ref()))
    }

    /// The impacts and the poses at them, and all poses of the `followed` bodies.
    fn record(&mut self, followed: &BTreeSet<BodyId>) -> Result<RecordedMotion, Error> {
        let loaded = match &mut self.source.motion {
            Motion::Scene(loaded) => loaded,
            Motion::Timeline(reader) => {
                let timeline = read_impacts(reader, followed, self.options.rolling.is_some())?;
                return Ok(RecordedMotion { timeline, report: None });
            }
        };
        let total = loaded.scene.simulation.duration;
        let on_progress = &mut self.on_progress;
        let mut modal = |p: &SoundModelProgress<'_>| {
            on_progress(&Progress { stage: Stage::Modal, done: p.done, body: p.body, step: p.step })
        };
        find_collision_parts(loaded, self.cache.as_ref())?;
        // No long search for a scene that cannot move.
        check_motion(loaded)?;
        loaded.give_modes(find_impact_modes(loaded, self.cache.as_ref(), &mut modal)?);
        let reached =
            &mut |time: f64| on_progress(&Progress::of_time(Stage::Simulation, "simulate", (time, total)));
        let (timeline, report) = match &self.keep {
            Some((folder, replace)) => simulate_and_keep(loaded, followed, folder, *replace, reached)?,
            None => simulate_impacts(loaded, followed, reached)?,
        };
        Ok(RecordedMotion { timeline, report: Some(report) })
    }

    /// The sound models of the struck bodies, found in the cache or baked; simulates first.
    ///
    /// # Errors
    /// [`Error::Models`], and those of [`simulate`](Self::simulate).
    pub fn obtain_models(&mut self) -> Result<&SoundModels, Error> {
        self.simulate()?;
        if self.models.is_none() {
            let contacts = self.motion.iter().flat_map(|motion| &motion.timeline.contacts);
            let struck: BTreeSet<BodyId> = contacts.flat_map(|row| [row.body_a, row.body_b]).collect();
            let mut plan = self.plan().clone();
            plan.give_energies(self.impact_energies());
            let bank = default_bank();
            let store = SoundModelStore { cache: self.cache.as_ref(), bank: bank.as_ref() };
            let on_progress = &mut self.on_progress;
            let mut reached = |p: &SoundModelProgress<'_>| {
                let stage = if p.part == SoundPart::Modal { Stage::Modal } else { Stage::Acceleration };
                on_progress(&Progress { stage, done: p.done, body: p.body, step: p.step })
            };
            let mut models = plan.find(&self.source.bodies, &struck, store, &mut reached)?;
            if let Motion::Scene(loaded) = &self.source.motion {
                models.remarks.extend(loaded.modes.remarks.iter().cloned());
            }
            self.models = Some(models);
        }
        Ok(self.models.get_or_insert_default())
    }

    /// Energy Σ J²/2m that impacts give each body \[J\].
    fn impact_energies(&self) -> BTreeMap<BodyId, f64> {
        let mut energies = BTreeMap::new();
        for row in self.motion.iter().flat_map(|motion| &motion.timeline.contacts) {
            let square = row.impulse_n * row.impulse_n + row.impulse_t.length_squared();
            for id in [row.body_a, row.body_b] {
                let mass = self.source.bodies.get(id.index()).map_or(f64::INFINITY, |body| body.mass);
                *energies.entry(id).or_insert(0.0) += 0.5 * square / mass;
            }
        }
        energies
    }

    /// Checks whether the files of [`render`](Self::render) can be written, before a long simulation.
    ///
    /// # Errors
    /// [`Error::Render`].
    pub fn check_output(&self, output: impl AsRef<Path>) -> Result<(), Error> {
        Ok(check_output(&self.options, &self.source.bodies, output.as_ref())?)
    }

    /// Renders into a WAV file, one for each listener and stem; see [`render`]. Simulates and obtains models
    /// first.
    ///
    /// # Errors
    /// [`Error`]; a file appears only once it is complete.
    pub fn render(&mut self, output: impl AsRef<Path>) -> Result<RenderedSound, Error> {
        if self.motion.is_none() {
            self.check_output(&output)?;
        }
        self.obtain_models()?;
        let (Some(motion), Some(models)) = (&self.motion, &self.models) else {
            return Err(Error::Interrupted);
        };
        let mut reached = |done: f64| (self.on_progress)(&Progress::of_render(done));
        let (bodies, options) = (&self.source.bodies, &self.options);
        let summary =
            render(bodies, &models.bodies, &motion.timeline, options, output.as_ref(), &mut reached)?;
        let mixes = || summary.files.iter().filter(|file| file.stem.is_none());
        let peaks = mixes().flat_map(|file| file.levels.channels.iter().map(|channel| channel.peak));
        Ok(RenderedSound {
            frames: mixes().map(|file| file.levels.frames).max().unwrap_or(0),
            peak: peaks.fold(0.0, f64::max),
            summary,
        })
    }

    /// Renders the pressure at each listener into memory. Simulates and obtains models first.
    ///
    /// # Errors
    /// [`Error`].
    pub fn pressures(&mut self) -> Result<Vec<HeardPressure>, Error> {
        self.obtain_models()?;
        let (Some(motion), Some(models)) = (&self.motion, &self.models) else {
            return Err(Error::Interrupted);
        };
        let mut reached = |done: f64| (self.on_progress)(&Progress::of_render(done));
        let (bodies, options) = (&self.source.bodies, &self.options);
        Ok(render_in_memory(bodies, &models.bodies, &motion.timeline, options, &mut reached)?)
    }

    /// What moved, of what is heard; empty before [`simulate`](Self::simulate).
    pub fn timeline(&self) -> Option<&Timeline> {
        self.motion.as_ref().map(|motion| &motion.timeline)
    }

    /// The sound models; `None` before [`obtain_models`](Self::obtain_models).
    pub fn models(&self) -> Option<&SoundModels> {
        self.models.as_ref()
    }
}
