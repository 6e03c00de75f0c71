//! Files of a data set: a Parquet file for each part, with samples, or with the names of WAV files.
//!
//! A file appears under its name when it is complete, and says in its footer which data set it belongs to, so
//! that a run that was stopped continues with the parts that are missing.

use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clangor_core::glam::DVec3;

use super::Dataset;
use super::error::DatasetError;
use super::labels::LabelledStrike;
use super::shard::Shard;
use crate::formats::labelled_samples::{
    ColumnKind, ColumnValues, LabelledSamplesError, LabelledSamplesWriter, read_metadata,
};
use crate::formats::wav::{Meaning, SampleFormat, WavSpec, WavWriter};
use crate::session::Progress;

/// Rows of a row group: 25 MB of sounds of one second.
const GROUP_ROWS: u64 = 128;
/// Names in the footer.
const IDENTITY: &str = "clangor.identity";
const RECIPE: &str = "clangor.recipe";
const VERSION: &str = "clangor.version";

/// Where the samples are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FileKind {
    /// In the column `samples` of the Parquet file.
    #[default]
    Parquet,
    /// In WAV files, one for each strike, that the column `file_name` names.
    Wav,
}

/// A part of a data set in its file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WrittenShard {
    /// The Parquet file.
    pub path: PathBuf,
    /// Number of strikes.
    pub rows: u64,
    /// Whether the file was there already.
    pub kept: bool,
}

impl Dataset {
    /// Writes a part into a folder, which is created where there is none; keeps the file of the part if an
    /// earlier run has finished it.
    ///
    /// # Errors
    /// [`DatasetError::OtherDataset`], [`DatasetError::Damaged`], [`DatasetError::Write`], and those of
    /// [`strikes`](Self::strikes). No file is left then.
    pub fn write(
        &self,
        folder: &Path,
        shard: Shard,
        kind: FileKind,
        on_progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<WrittenShard, DatasetError> {
        let failed = |path: &Path, error: std::io::Error| DatasetError::Write {
            path: path.into(),
            reason: error.to_string(),
        };
        fs::create_dir_all(folder).map_err(|error| failed(folder, error))?;
        let identity = format!("{} {kind:?} {}/{}", self.identity, shard.number(), shard.of());
        self.check_others(folder, shard, kind)?;
        let (path, range) = (shard.file(folder), shard.range(self.count()));
        let rows = range.end - range.start;
        if path.exists() {
            check_identity(&path, &identity)?;
            return Ok(WrittenShard { path, rows, kept: true });
        }
        let sounds = folder.join(shard.stem());
        if kind == FileKind::Wav {
            fs::create_dir_all(&sounds).map_err(|error| failed(&sounds, error))?;
        }
        let metadata = [
            (IDENTITY, identity),
            (VERSION, env!("CARGO_PKG_VERSION").to_owned()),
            (RECIPE, self.text.clone()),
        ];
        let columns = columns(kind);
        let mut file = LabelledSamplesWriter::create(&path, &columns, &metadata).map_err(write_error)?;
        let mut next = range.start;
        while next < range.end {
            let group = next..(next + GROUP_ROWS).min(range.end);
            let mut reached = |progress: &Progress<'_>| {
                let within =
                    if progress.body.is_empty() { progress.done } else { return on_progress(progress) };
                let before = (group.start - range.start) as f64;
                let done = (before + within * (group.end - group.start) as f64) / rows as f64;
                on_progress(&Progress::of_render(done))
            };
            let strikes = self.strikes(group.clone(), &mut reached)?;
            if kind == FileKind::Wav {
                strikes.iter().try_for_each(|strike| write_wav(&sounds, strike))?;
            }
            let values: Vec<_> = columns.iter().map(|(name, _)| values(name, &strikes, shard)).collect();
            file.write(&values).map_err(write_error)?;
            next = group.end;
        }
        file.finish().map_err(write_error)?;
        Ok(WrittenShard { path, rows, kept: false })
    }

    /// Rejects a folder that has parts of another data set, or of this one divided otherwise.
    fn check_others(&self, folder: &Path, shard: Shard, kind: FileKind) -> Result<(), DatasetError> {
        let entries = fs::read_dir(folder)
            .map_err(|error| DatasetError::Write { path: folder.into(), reason: error.to_string() })?;
        let parts = entries.flatten().filter_map(|entry| Shard::of_file_name(entry.file_name().to_str()?));
        let Some(other) = parts.min_by_key(|part| (part.of() == shard.of(), part.number())) else {
            return Ok(());
        };
        let path = other.file(folder);
        if other.of() != shard.of() {
            let difference = format!("it has {} parts, not {}", other.of(), shard.of());
            return Err(DatasetError::OtherDataset { path, difference });
        }
        check_identity(&path, &format!("{} {kind:?} {}/{}", self.identity, other.number(), other.of()))
    }
}

/// Rejects a file of another data set, and one that cannot be read.
fn check_identity(path: &Path, identity: &str) -> Result<(), DatasetError> {
    let found = read_metadata(path, IDENTITY).map_err(|error| match error {
        LabelledSamplesError::Open { path, source } => DatasetError::Read { path, source },
        LabelledSamplesError::Parquet { path, reason } => DatasetError::Damaged { path, reason },
        LabelledSamplesError::Output(error) => DatasetError::Output(error),
    })?;
    match found {
        Some(found) if found == identity => Ok(()),
        _ => {
            let difference =
                "its recipe, table, object files, options, format or program version differ".into();
            Err(DatasetError::OtherDataset { path: path.into(), difference })
        }
    }
}

fn write_error(error: LabelledSamplesError) -> DatasetError {
    match error {
        LabelledSamplesError::Output(error) => DatasetError::Output(error),
        LabelledSamplesError::Open { path, source } => DatasetError::Read { path, source },
        LabelledSamplesError::Parquet { path, reason } => DatasetError::Write { path, reason },
    }
}

fn wav_name(strike: &LabelledStrike) -> String {
    format!("{:09}.wav", strike.index)
}

fn write_wav(folder: &Path, strike: &LabelledStrike) -> Result<(), DatasetError> {
    let spec = WavSpec {
        sample_rate: strike.sample_rate,
        channels: 1,
        format: SampleFormat::Float32,
        full_scale: WavSpec::default_full_scale(SampleFormat::Float32),
        meaning: Meaning::Pressure,
        note: format!(
            "{} of {}, begins {} s before the contact",
            strike.object, strike.material, -strike.start
        ),
    };
    let mut file = WavWriter::create(&folder.join(wav_name(strike)), spec)?;
    file.write(&strike.samples)?;
    file.finish()?;
    Ok(())
}

/// Components of vectors, as endings of columns.
const AXES: [&str; 3] = ["_x", "_y", "_z"];

/// The columns, in the order of the file.
fn columns(kind: FileKind) -> Vec<(&'static str, ColumnKind)> {
    use ColumnKind::{Flag, Integer, Number, Numbers, Samples, Text};
    let mut columns = vec![
        ("index", Integer),
        ("seed", Integer),
        ("object", Text),
        ("material", Text),
        ("mass", Number),
        ("draft", Flag),
        ("point_x", Number),
        ("point_y", Number),
        ("point_z", Number),
        ("normal_x", Number),
        ("normal_y", Number),
        ("normal_z", Number),
        ("striker", Text),
        ("striker_radius", Number),
        ("speed", Number),
        ("impulse_x", Number),
        ("impulse_y", Number),
        ("impulse_z", Number),
        ("peak_force", Number),
        ("contact_duration", Number),
        ("listener_x", Number),
        ("listener_y", Number),
        ("listener_z", Number),
        ("room", Text),
        ("body_x", Number),
        ("body_y", Number),
        ("body_z", Number),
        ("frequencies", Numbers),
        ("t60s", Numbers),
        ("sample_rate", Integer),
        ("start", Number),
        ("peak_pressure", Number),
        ("version", Text),
    ];
    columns.push(match kind {
        FileKind::Parquet => ("samples", Samples),
        FileKind::Wav => ("file_name", Text),
    });
    columns
}

/// The values of a column.
fn values(name: &str, strikes: &[LabelledStrike], shard: Shard) -> ColumnValues {
    let numbers = |of: &dyn Fn(&LabelledStrike) -> f64| {
        ColumnValues::Number(strikes.iter().map(|strike| Some(of(strike))).collect())
    };
    let maybe =
        |of: &dyn Fn(&LabelledStrike) -> Option<f64>| ColumnValues::Number(strikes.iter().map(of).collect());
    let integers =
        |of: &dyn Fn(&LabelledStrike) -> i64| ColumnValues::Integer(strikes.iter().map(of).collect());
    let texts =
        |of: &dyn Fn(&LabelledStrike) -> Option<String>| ColumnValues::Text(strikes.iter().map(of).collect());
    let lists =
        |of: &dyn Fn(&LabelledStrike) -> Vec<f64>| ColumnValues::Numbers(strikes.iter().map(of).collect());
    match name {
        "index" => integers(&|s| s.index as i64),
        "seed" => integers(&|s| s.seed as i64),
        "sample_rate" => integers(&|s| i64::from(s.sample_rate)),
        "draft" => ColumnValues::Flag(strikes.iter().map(|s| s.draft).collect()),
        "object" => texts(&|s| Some(s.object.clone())),
        "material" => texts(&|s| Some(s.material.clone())),
        "striker" => texts(&|s| Some(s.striker.as_ref()?.material.clone())),
        "room" => texts(&|s| Some(s.room.as_ref()?.name.clone())),
        "version" => texts(&|_| Some(env!("CARGO_PKG_VERSION").into())),
        "file_name" => texts(&|s| Some(format!("{}/{}", shard.stem(), wav_name(s)))),
        "mass" => numbers(&|s| s.mass),
        "peak_force" => numbers(&|s| s.peak_force),
        "contact_duration" => numbers(&|s| s.contact_duration),
        "start" => numbers(&|s| s.start),
        "peak_pressure" => numbers(&|s| s.peak_pressure),
        "striker_radius" => maybe(&|s| Some(s.striker.as_ref()?.radius)),
        "speed" => maybe(&|s| Some(s.striker.as_ref()?.speed)),
        "frequencies" => lists(&|s| s.frequencies.to_vec()),
        "t60s" => lists(&|s| s.t60s.to_vec()),
        "samples" => ColumnValues::Samples(strikes.iter().map(|s| s.samples.clone()).collect()),
        _ => maybe(&|s| component(name, s)),
    }
}

/// A component of a vector; `None` for the place in a room where there is none.
fn component(name: &str, strike: &LabelledStrike) -> Option<f64> {
    let axis = AXES.iter().position(|ending| name.ends_with(ending))?;
    let vector: DVec3 = match name.strip_suffix(AXES[axis])? {
        "point" => strike.point,
        "normal" => strike.normal,
        "impulse" => strike.impulse,
        "listener" => strike.listener,
        _ => strike.room.as_ref()?.body,
    };
    Some(vector[axis])
}
