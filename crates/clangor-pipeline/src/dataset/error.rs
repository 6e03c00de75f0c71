//! Why a data set cannot be made.

use std::fmt;
use std::path::PathBuf;

use clangor_core::scene::diagnostic::SceneErrors;
use clangor_core::synthesis::SynthesisError;
use clangor_core::synthesis::strike::StrikeError;

use crate::formats::atomic_file::OutputError;
use crate::formats::record_table::RecordTableError;
use crate::formats::wav::WavError;
use crate::session;
use crate::stages::sound_models::ModelOptionsError;

/// Why a data set cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    /// A recipe or a table cannot be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Mistakes in a recipe.
    #[error("{}{errors}", prefixed(path.as_ref()))]
    Recipe {
        /// Its file, if it has one.
        path: Option<PathBuf>,
        /// Its text.
        text: String,
        /// All of them.
        errors: SceneErrors,
    },
    /// The table of strikes cannot be read.
    #[error(transparent)]
    Table(#[from] RecordTableError),
    /// A value of the table is wrong.
    #[error("{row}: {column} {fault}")]
    Cell {
        /// The file and its line or row.
        row: RowPlace,
        /// The column.
        column: String,
        /// What is wrong.
        fault: String,
    },
    /// A table that says too little, with nothing in the recipe to draw from.
    #[error("{path}: the column {column} is missing, and the recipe has no {section} to draw from")]
    MissingColumn {
        /// The table.
        path: PathBuf,
        /// The first of the columns.
        column: &'static str,
        /// The section of the recipe that could take its place.
        section: &'static str,
    },
    /// A table without rows.
    #[error("{path} has no rows")]
    EmptyTable {
        /// The table.
        path: PathBuf,
    },
    /// A number that is none of a strike.
    #[error("there is no strike {index}: the data set has {count}, from 0")]
    Index {
        /// The number.
        index: u64,
        /// Number of strikes.
        count: u64,
    },
    /// A part that does not exist.
    #[error("{text} is no part of a data set; write K/N with K from 1 to N, and N at most {most}")]
    Shard {
        /// What was asked for.
        text: String,
        /// Most parts.
        most: u32,
    },
    /// A strike that makes no sound.
    #[error("{place} (\"{object}\"): {source}")]
    Strike {
        /// The strike.
        place: StrikePlace,
        /// The body.
        object: String,
        /// Why.
        source: Box<StrikeError>,
    },
    /// A body whose sound model cannot be had.
    #[error("object \"{object}\" of {material}: {source}")]
    Object {
        /// The body.
        object: String,
        /// Its material.
        material: String,
        /// Why.
        source: Box<session::Error>,
    },
    /// A room that holds not both of body and listener.
    #[error(
        "strike {index}: in {tries} draws, room \"{room}\" never held body and listener; correct `body` of \
         the room or `distance` and `position` of the listeners"
    )]
    OutsideRoom {
        /// The strike.
        index: u64,
        /// The room.
        room: String,
        /// Draws.
        tries: u32,
    },
    /// Files of another data set are in the folder.
    #[error("{path} belongs to another data set ({difference}); choose another folder, or remove it")]
    OtherDataset {
        /// The file.
        path: PathBuf,
        /// What differs.
        difference: String,
    },
    /// A file of the data set cannot be read.
    #[error("{path} is damaged ({reason}); remove it and run again")]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A file cannot be written.
    #[error("cannot write {path}: {reason}")]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// Options that no model can be baked with.
    #[error(transparent)]
    Options(#[from] ModelOptionsError),
    /// A sample rate at which nothing is rendered.
    #[error(transparent)]
    SampleRate(#[from] SynthesisError),
    /// A file cannot be put in place.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A sound file cannot be written.
    #[error(transparent)]
    Wav(#[from] WavError),
    /// Stopped by the caller.
    #[error("interrupted; finished files are kept")]
    Interrupted,
}

impl DatasetError {
    /// Whether the progress callback asked to stop.
    pub fn is_interruption(&self) -> bool {
        match self {
            DatasetError::Interrupted => true,
            DatasetError::Object { source, .. } => source.is_interruption(),
            _ => false,
        }
    }
}

fn prefixed(path: Option<&PathBuf>) -> String {
    path.map_or("recipe: ".into(), |path| format!("{}: ", path.display()))
}

/// A row of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RowPlace {
    /// The table.
    pub path: PathBuf,
    /// Line of a text from 1, or row of a Parquet file from 0.
    pub row: u64,
}

impl fmt::Display for RowPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let is_binary = self.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("parquet"));
        write!(f, "{}, {} {}", self.path.display(), if is_binary { "row" } else { "line" }, self.row)
    }
}

/// Where a strike is said.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StrikePlace {
    /// It was drawn.
    Drawn {
        /// Its number.
        index: u64,
    },
    /// A row of a table says it, and the column at fault.
    Listed {
        /// The row.
        row: RowPlace,
        /// The column.
        column: &'static str,
    },
}

impl fmt::Display for StrikePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StrikePlace::Drawn { index } => write!(f, "strike {index}"),
            StrikePlace::Listed { row, column } => write!(f, "{row}: {column}"),
        }
    }
}
