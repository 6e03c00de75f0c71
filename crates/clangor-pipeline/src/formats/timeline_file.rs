//! Timelines on disk: a folder `NAME.timeline` that opens in pandas, Polars and DuckDB.
//!
//! ```text
//! NAME.timeline/timeline.json      bodies, pieces included, links, medium, settings, counts of rows
//!               contacts.parquet   one row per contact point
//!               poses.parquet      one row per body and instant
//!               fractures.parquet  one row per body that broke, if any did
//!               forces.parquet     one row per recorded force of a contact point, if any is
//!               force_samples.parquet   the samples of their shapes
//!               meshes/HASH.ply    every distinct surface, with its mean curvature
//! ```
//!
//! The folder is enough to render without the scene. Rows are streamed both ways, so that memory does not
//! grow with their number. Times are `f64`, other numbers `f32`: a position at 1 m is good to 60 nm; lasting
//! contacts of a raw log are rounded to half a micrometre and the like (`resolution.rs`). The format is
//! specified in `docs/format/timeline.md`.
//!
//! Convex parts are not stored: they serve collision, and a timeline is what remains after it.

mod columns;
mod description;
mod error;
mod files;
mod force_columns;
mod force_copy;
mod force_writer;
mod hash;
mod header;
mod reader;
mod resolution;
mod summary;
mod surface_file;
mod table;
mod writer;

pub use error::{RowProblem, TimelineError};
pub use header::{FORMAT_VERSION, Origin, TimelineHeader};
pub use reader::TimelineReader;
pub use summary::TimelineSummary;
pub use writer::TimelineWriter;
