//! Other tools' files: contact lists that people and programs write, and the motion as animated glTF.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clangor_core::body::{BodyId, Motion};
use clangor_core::timeline::TimelineSink;

use super::file_frame::FileAxes;
use super::imported_header::imported_header;
use super::listed_flights::listed_flights;
use crate::formats::contact_list::{ContactListError, read_listed_contacts};
use crate::formats::glb::{GlbError, GlbSummary, write_glb};
use crate::formats::named_bodies::NamedBodies;
use crate::formats::timeline_file::{TimelineError, TimelineReader, TimelineSummary, TimelineWriter};
use crate::motion::contact_checks::{ContactFault, check_contacts, no_contacts, time_outside};
use crate::motion::contact_steps::contact_steps;
use crate::motion::list_clock::long_clock;
use crate::motion::recording::MAX_TIME;
use crate::motion::repeated_contacts::RepeatedContacts;
use crate::stages::load::LoadedScene;
use crate::stages::simulate::{SimulateError, simulate_to_folder};

/// Why a file could not be exchanged.
#[derive(Debug, thiserror::Error)]
pub enum InterchangeError {
    /// The contact list is wrong.
    #[error(transparent)]
    List(#[from] ContactListError),
    /// A contact at a time that no timeline has.
    #[error(
        "{path}, row {row}: a contact is at t = {time} s; times run from 0 to {MAX_TIME} s, in seconds from \
         the beginning of the scene; divide milliseconds by 1000, and frame numbers by the frames per second"
    )]
    Time {
        /// The list.
        path: PathBuf,
        /// Line of a text, row of a Parquet file.
        row: usize,
        /// The time \[s\].
        time: f64,
    },
    /// A contact is impossible.
    #[error("{path}, {fault}")]
    Contact {
        /// The list.
        path: PathBuf,
        /// What is wrong.
        fault: ContactFault,
    },
    /// The timeline cannot be written or read.
    #[error(transparent)]
    Timeline(#[from] TimelineError),
    /// The glTF file cannot be written.
    #[error(transparent)]
    Glb(#[from] GlbError),
    /// The scene could not be simulated.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    /// A row did not reach the timeline.
    #[error("cannot write {path}: {source}")]
    Row {
        /// The timeline.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// No folder for the motion between simulation and export.
    #[error("there is no room for temporary files: {0}")]
    Temporary(std::io::Error),
}

impl InterchangeError {
    /// Whether the caller asked to stop.
    pub fn is_interruption(&self) -> bool {
        matches!(self, InterchangeError::Simulate(e) if e.is_interruption())
    }
}

/// How the bodies of a contact list move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ListedMotion {
    /// Free bodies that are listed fly from where the scene starts them, under gravity and the listed
    /// impulses.
    Flights,
    /// All stay where the scene starts them.
    AtRest,
}

/// How a contact list is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ListReading {
    /// How its bodies move.
    pub motion: ListedMotion,
    /// Its axes and units.
    pub axes: FileAxes,
}

impl From<ListedMotion> for ListReading {
    fn from(motion: ListedMotion) -> Self {
        ListReading { motion, axes: FileAxes::default() }
    }
}

/// What was made of a contact list.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedContacts {
    /// Rows of the timeline.
    pub rows: TimelineSummary,
    /// What is probably wrong.
    pub warnings: Vec<String>,
    /// What should be known.
    pub notices: Vec<String>,
}

/// Turns a contact list between the bodies of a scene into a timeline folder.
///
/// A list has no poses. Where bodies fly by it, its points are compared with their surfaces; of bodies that
/// stay where they are, points on those that could move freely are not checked.
///
/// # Errors
/// [`InterchangeError`]; no folder is left then.
pub fn import_contacts(
    loaded: &LoadedScene,
    list: &Path,
    reading: impl Into<ListReading>,
    output: &Path,
    replace: bool,
) -> Result<ImportedContacts, InterchangeError> {
    let ListReading { motion, axes } = reading.into();
    let bodies = &loaded.world.bodies;
    let mut rows = read_listed_contacts(list, &NamedBodies::of(&loaded.world))?;
    axes.in_seconds(&mut rows);
    if let Some(listed) = time_outside(&rows) {
        let (row, time) = (listed.line, listed.row.time);
        return Err(InterchangeError::Time { path: list.into(), row, time });
    }
    axes.in_metres(&mut rows);
    let pose_of = |id: BodyId, time: f64| match &bodies[id.index()].motion {
        Motion::Free | Motion::Guided(_) => None,
        Motion::Fixed => Some(bodies[id.index()].pose),
        Motion::Keyframed(track) => Some(track.sample(time).0),
    };
    let lines: Vec<usize> = rows.iter().map(|listed| listed.line).collect();
    let twice = RepeatedContacts::default().look(list, &rows);
    let steps = contact_steps(&loaded.world, &rows);
    let long = long_clock(&rows, loaded.scene.simulation.duration);
    let empty = rows.is_empty().then(|| no_contacts(list));
    let (rows, notices) = check_contacts(&loaded.world, rows, &pose_of)
        .map_err(|fault| InterchangeError::Contact { path: list.into(), fault })?;
    let mut notices: Vec<String> = notices.iter().map(ToString::to_string).collect();
    let warnings = long.map(|notice| notice.to_string()).into_iter();
    let warnings = warnings.chain(twice.map(|notice| notice.to_string()));
    let warnings = warnings.chain(steps.map(|notice| notice.to_string())).chain(empty).collect();
    let duration = rows.last().map_or(0.0, |r| r.time).max(loaded.scene.simulation.duration);
    let header = imported_header(loaded, loaded.world.clone(), "contact list", duration, None);
    let has_effective_mass = rows.iter().any(|row| row.effective_mass.is_some());
    let mut writer = TimelineWriter::create_for_contacts(output, &header, replace, has_effective_mass)?;
    let failed = |source| InterchangeError::Row { path: output.into(), source };
    for row in &rows {
        writer.contact(row).map_err(failed)?;
    }
    if motion == ListedMotion::Flights {
        let flights = listed_flights(loaded, &rows, duration);
        notices.extend(flights.notices(&loaded.world, &lines));
        flights.write(&loaded.world, &rows, &mut writer).map_err(failed)?;
    }
    Ok(ImportedContacts { rows: writer.finish()?, warnings, notices })
}

/// Simulates a scene and writes its motion, `rate` pictures per second.
///
/// # Errors
/// [`InterchangeError`].
pub fn export_scene_gltf(
    loaded: &LoadedScene,
    output: &Path,
    rate: f64,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<GlbSummary, InterchangeError> {
    // The motion of a long scene need not fit in memory: it goes through a timeline.
    let folder = tempfile::tempdir().map_err(InterchangeError::Temporary)?;
    let timeline = folder.path().join("motion.timeline");
    simulate_to_folder(loaded, false, &timeline, false, progress)?;
    export_timeline_gltf(&timeline, output, rate)
}

/// Writes the motion of a timeline folder, `rate` pictures per second.
///
/// # Errors
/// [`InterchangeError`].
pub fn export_timeline_gltf(
    timeline: &Path,
    output: &Path,
    rate: f64,
) -> Result<GlbSummary, InterchangeError> {
    let reader = TimelineReader::open(timeline)?;
    Ok(write_glb(output, &reader.bodies(), reader.poses()?, rate)?)
}
