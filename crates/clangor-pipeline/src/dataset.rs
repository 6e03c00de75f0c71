//! Data sets: many impacts on many bodies, with labels.
//!
//! ```text
//! recipe, table ─► strike i = f(seed, i) ─► sound model of its body ─► forces, pressure, labels ─► files
//! ```
//!
//! The sound of a strike is that of [`Strike`](crate::session::Strike) with the same point, force and
//! listener, bit for bit. Sound models are found in the cache or baked; all are exact, unless drafts are
//! asked for. The format of recipes, tables and files is in `docs/format/dataset.md`.
//!
//! ```no_run
//! use std::ops::ControlFlow;
//!
//! use clangor_pipeline::dataset::{Dataset, DatasetOptions, FileKind, Shard};
//!
//! let dataset = Dataset::open("bowls.toml".as_ref(), DatasetOptions::default())?;
//! for shard in Shard::all(Shard::usual_number(dataset.count()))? {
//!     dataset.write("bowls".as_ref(), shard, FileKind::Parquet, &mut |_| ControlFlow::Continue(()))?;
//! }
//! # Ok::<(), clangor_pipeline::dataset::DatasetError>(())
//! ```

mod draws;
mod error;
mod files;
mod identity;
mod labels;
mod shard;
mod strike_table;
mod strikes;
mod struck_bodies;
mod surface_points;

use std::fs;
use std::ops::{ControlFlow, Range};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use clangor_core::scene::strike_recipe::StrikeRecipe;
use clangor_core::synthesis::SampleRate;
use rayon::prelude::*;

pub use self::error::{DatasetError, RowPlace, StrikePlace};
pub use self::files::{FileKind, WrittenShard};
pub use self::labels::{LabelledStrike, StrikeRoomLabel, StrikerLabel};
pub use self::shard::Shard;
use self::strike_table::read_strikes;
use self::strikes::{DrawnStrike, Strikes};
pub use self::struck_bodies::BodyRemark;
use self::struck_bodies::{BodySettings, ReadyBody, StruckBodies};
use crate::session::Progress;
use crate::session::struck_model::ModelChoice;
use crate::stages::sound_models::{ModelOptions, Quality};

/// Strikes for each thread between two reports of progress.
const STRIKES_PER_THREAD: usize = 4;

/// How a data set is made, beside its recipe.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DatasetOptions {
    /// How sound models are baked. `patience` has no effect: all are exact, unless drafts are asked for.
    pub models: ModelOptions,
    /// Folder of baked sound models. Default: `CLANGOR_CACHE`, or the system's folder for caches.
    pub cache: Option<PathBuf>,
    /// Seed in place of the recipe's.
    pub seed: Option<u64>,
}

/// A data set: see the module.
#[derive(Debug)]
pub struct Dataset {
    strikes: Strikes,
    settings: BodySettings,
    /// The text of the recipe.
    text: String,
    /// Hash of everything that the samples depend on, but for sound models and files that a table names.
    identity: String,
    bodies: Mutex<StruckBodies>,
}

impl Dataset {
    /// Opens a recipe (`.toml`), or a table of strikes (`.csv`, `.jsonl`, `.parquet`) that says all.
    ///
    /// # Errors
    /// [`DatasetError::Read`], and those of [`from_text`](Self::from_text).
    pub fn open(path: &Path, options: DatasetOptions) -> Result<Self, DatasetError> {
        let folder = path.parent().unwrap_or(Path::new(""));
        if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
            let table = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let recipe = StrikeRecipe { table: Some(table), ..StrikeRecipe::default() };
            return Dataset::new(recipe, String::new(), folder, options);
        }
        let bytes = fs::read(path).map_err(|source| DatasetError::Read { path: path.into(), source })?;
        let text = String::from_utf8(bytes).map_err(|error| DatasetError::Read {
            path: path.into(),
            source: std::io::Error::new(std::io::ErrorKind::InvalidData, error),
        })?;
        Dataset::of_recipe(text, Some(path), folder, options)
    }

    /// A data set from the text of a recipe; paths in it are relative to `folder`.
    ///
    /// # Errors
    /// [`DatasetError::Recipe`] with all mistakes; [`DatasetError::Table`], [`DatasetError::Cell`] and
    /// [`DatasetError::MissingColumn`] for its table; [`DatasetError::Options`].
    pub fn from_text(text: &str, folder: &Path, options: DatasetOptions) -> Result<Self, DatasetError> {
        Dataset::of_recipe(text.into(), None, folder, options)
    }

    fn of_recipe(
        text: String,
        path: Option<&Path>,
        folder: &Path,
        options: DatasetOptions,
    ) -> Result<Self, DatasetError> {
        let recipe = StrikeRecipe::from_toml(&text).map_err(|errors| DatasetError::Recipe {
            path: path.map(Path::to_path_buf),
            text: text.clone(),
            errors,
        })?;
        Dataset::new(recipe, text, folder, options)
    }

    fn new(
        recipe: StrikeRecipe,
        text: String,
        folder: &Path,
        options: DatasetOptions,
    ) -> Result<Self, DatasetError> {
        let DatasetOptions { mut models, cache, seed } = options;
        if models.quality != Quality::Draft {
            models.patience = Some(f64::INFINITY);
        }
        let recipe = StrikeRecipe { seed: seed.unwrap_or(recipe.seed), ..recipe };
        let sample_rate = SampleRate::try_new(recipe.sample_rate)?;
        models.check(sample_rate.as_f64())?;
        let table = recipe.table.as_ref().map(|table| folder.join(table));
        let rows = table.as_deref().map(|path| Ok::<_, DatasetError>((path, read_strikes(path)?)));
        let identity = identity::of(&text, &recipe, table.as_deref(), folder, &models)?;
        let strikes = Strikes::new(recipe, rows.transpose()?)?;
        let choice = ModelChoice { acceleration_rule: None, options: models, cache };
        let settings = BodySettings { folder: folder.into(), choice, sample_rate };
        Ok(Dataset { strikes, settings, text, identity, bodies: Mutex::default() })
    }

    /// Number of strikes.
    pub fn count(&self) -> u64 {
        self.strikes.count()
    }

    /// Number of bodies, each of one material, that strikes may need.
    pub fn body_count(&self) -> usize {
        self.strikes.bodies().len()
    }

    /// The strikes of some numbers, in order. Sound models that are not in the cache are baked, with their
    /// progress; it breaks to stop.
    ///
    /// # Errors
    /// [`DatasetError::Index`], [`DatasetError::OutsideRoom`], [`DatasetError::Object`],
    /// [`DatasetError::Strike`], and [`DatasetError::Interrupted`] after a break.
    pub fn strikes(
        &self,
        range: Range<u64>,
        on_progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<Vec<LabelledStrike>, DatasetError> {
        let mut bodies = self.bodies();
        bodies.begin_group();
        let mut ready: Vec<(DrawnStrike, Arc<ReadyBody>)> = Vec::new();
        for index in range {
            let strike = self.strikes.strike(index)?;
            let body = bodies.obtain(&self.strikes, strike.body, &self.settings, on_progress)?;
            ready.push((strike, body));
        }
        drop(bodies);
        let mut labelled = Vec::with_capacity(ready.len());
        for group in ready.chunks(STRIKES_PER_THREAD * rayon::current_num_threads()) {
            let sounds = group.par_iter().map(|(strike, body)| self.labelled(strike, body));
            for sound in sounds.collect::<Vec<_>>() {
                labelled.push(sound?);
            }
            let done = labelled.len() as f64 / ready.len() as f64;
            if on_progress(&Progress::of_render(done)).is_break() {
                return Err(DatasetError::Interrupted);
            }
        }
        Ok(labelled)
    }

    /// Bakes the sound models of a part of the objects, in all of their materials, into the cache. Returns
    /// the number of bodies, each of one material.
    ///
    /// # Errors
    /// [`DatasetError::Object`].
    pub fn bake(
        &self,
        part: Shard,
        on_progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<usize, DatasetError> {
        let bodies = self.strikes.bodies();
        let mut objects: Vec<usize> = bodies.iter().map(|(object, _)| *object).collect();
        objects.dedup();
        let range = part.range(objects.len() as u64);
        let own = &objects[range.start as usize..range.end as usize];
        let wanted = bodies.iter().filter(|(object, _)| own.binary_search(object).is_ok());
        let mut count = 0;
        for key in wanted {
            // No body is kept: only the cache and the remarks matter.
            let mut bodies = StruckBodies::default();
            bodies.obtain(&self.strikes, *key, &self.settings, on_progress)?;
            self.bodies().add_remarks(bodies);
            count += 1;
        }
        Ok(count)
    }

    /// Defects of the sound models that were found or baked since the last call, once for each body.
    pub fn take_remarks(&self) -> Vec<BodyRemark> {
        self.bodies().take_remarks()
    }

    fn bodies(&self) -> MutexGuard<'_, StruckBodies> {
        self.bodies.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
