//! Why a timeline could not be written or read.

use std::io;
use std::path::PathBuf;

use clangor_core::quantity::EFFECTIVE_MASS;
use clangor_core::timeline::ForceProblem;

use super::header::{FORMAT_VERSION, OLDEST_VERSION};
use crate::formats::atomic_file::OutputError;
use crate::formats::mesh_reader::{MeshFault, MeshPlace};

/// Why a timeline could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum TimelineError {
    /// The folder could not be put in place.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The operating system refused.
    #[error("cannot {action} {path}: {source}")]
    Io {
        /// What was attempted.
        action: &'static str,
        /// On which path.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A file of the folder is missing.
    #[error("{path} is missing: the folder is no complete timeline; simulate or import it again")]
    Missing {
        /// The file.
        path: PathBuf,
    },
    /// The description is not the JSON it should be.
    #[error("{path}, line {line}, column {column}: {reason}")]
    Json {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What was expected.
        reason: String,
    },
    /// A field of the description holds an impossible value.
    #[error("{path}: {field} {problem}")]
    Field {
        /// The file.
        path: PathBuf,
        /// The field.
        field: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The format is newer or older than this program.
    #[error(
        "{path} has format version {found}; this program reads versions {OLDEST_VERSION} to {FORMAT_VERSION}"
    )]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: u64,
    },
    /// Parquet data that cannot be written or decoded.
    #[error("{path} is damaged or no Parquet file ({reason}); simulate or import the timeline again")]
    Parquet {
        /// The file.
        path: PathBuf,
        /// What the decoder met.
        reason: String,
    },
    /// A column is missing.
    #[error("{path} has no column {column}; docs/format/timeline.md lists the columns")]
    MissingColumn {
        /// The file.
        path: PathBuf,
        /// The column.
        column: &'static str,
    },
    /// A column has another type.
    #[error("{path}: column {column} must be {expected}, not {found}; convert it")]
    ColumnType {
        /// The file.
        path: PathBuf,
        /// The column.
        column: &'static str,
        /// Its type by the format.
        expected: &'static str,
        /// Its type in the file.
        found: String,
    },
    /// A row holds an impossible value.
    #[error("{path}, row {row}: {problem}")]
    Row {
        /// The file.
        path: PathBuf,
        /// The row, from 0.
        row: u64,
        /// What is wrong with it.
        problem: RowProblem,
    },
    /// The description and the table disagree.
    #[error("{path} has {found} rows, timeline.json says {promised}; the files belong to different runs")]
    RowCount {
        /// The table.
        path: PathBuf,
        /// Rows by the description.
        promised: u64,
        /// Rows there are.
        found: u64,
    },
    /// A mesh is damaged.
    #[error("{path}, {place}: {fault}")]
    Mesh {
        /// The mesh file.
        path: PathBuf,
        /// Where in it.
        place: MeshPlace,
        /// What is wrong there.
        fault: MeshFault,
    },
    /// A file is not the one that was written.
    #[error(
        "{path} has changed since it was written: its hash is {found}, timeline.json says {expected}; \
         restore it, or remove the hash of an edited table from timeline.json"
    )]
    Changed {
        /// The file.
        path: PathBuf,
        /// The hash of its content.
        found: String,
        /// The hash that it should have.
        expected: String,
    },
}

/// What is wrong with a row.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RowProblem {
    /// A number is NaN, infinite, or beyond 32 bits.
    #[error("{column} is {value}, not a finite 32-bit number")]
    NotFinite {
        /// The column.
        column: &'static str,
        /// The value.
        value: f64,
    },
    /// A value is absent.
    #[error("{column} is null")]
    Null {
        /// The column.
        column: &'static str,
    },
    /// A body that the description does not list.
    #[error("{column} is {body}, but there are {bodies} bodies")]
    Body {
        /// The column.
        column: &'static str,
        /// The number given.
        body: u32,
        /// Bodies there are.
        bodies: usize,
    },
    /// A body that is not there at that time.
    #[error("{column} is {body}, which lives from {birth} s to {death} s, but the row is of {time} s")]
    NotAlive {
        /// The column.
        column: &'static str,
        /// The body.
        body: u32,
        /// Time of the row \[s\].
        time: f64,
        /// First instant of the body \[s\].
        birth: f64,
        /// Last instant of the body \[s\].
        death: f64,
    },
    /// Pieces that are not those which the bodies tell of.
    #[error(
        "pieces {first} to {first} + {count} - 1 are not what is born of the parent as it dies at {time} s"
    )]
    Pieces {
        /// The first piece.
        first: u32,
        /// How many.
        count: u32,
        /// When \[s\].
        time: f64,
    },
    /// A time before that of an earlier row.
    #[error("time {time} s comes after {latest} s; sort the rows by time")]
    Order {
        /// Time of the row \[s\].
        time: f64,
        /// Latest time before it \[s\].
        latest: f64,
    },
    /// An effective mass that cannot be one.
    #[error(
        "effective_mass is {value}; it must be {}, or null for that of the bodies alone",
        EFFECTIVE_MASS.expected()
    )]
    EffectiveMass {
        /// The number given \[kg\].
        value: f64,
    },
    /// A value in a column that the table was not given.
    #[error("{column} has a value, but the table was created without this column")]
    NoColumn {
        /// The column.
        column: &'static str,
    },
    /// A kind of contact that is unknown.
    #[error("kind {code} is unknown; 0 impact, 1 contact, 2 constraint, 3 fracture, 4 sleep")]
    Kind {
        /// The number given.
        code: i32,
    },
    /// A force that cannot be one.
    #[error("the force {0}")]
    Force(#[from] ForceProblem),
    /// A shape that is not in the table of samples.
    #[error(
        "the {count} samples from {first} on are no shape: shapes follow one another, and there are \
         {samples} samples"
    )]
    Samples {
        /// First sample.
        first: u64,
        /// How many.
        count: u32,
        /// Samples there are.
        samples: u64,
    },
    /// A force of an impact without contacts.
    #[error("impact_id is {impact_id}, which no contact has")]
    Impact {
        /// The impact.
        impact_id: u64,
    },
    /// A normal or quaternion that is not of length 1.
    #[error("{column} has length {length}, not 1")]
    NotUnit {
        /// The columns.
        column: &'static str,
        /// Their length.
        length: f64,
    },
}
