//! Motion that another program recorded becomes a timeline: poses, and contacts that are recorded too or are
//! found in the motion.
//!
//! A single table of poses in order of time is read as a stream, twice: once to check all of it, and once for
//! its impacts and poses, in parts of time that overlap. Memory then depends on the number of bodies and
//! on the rate, not on the length. Contact lists are kept in memory, and so are the poses of several tables,
//! of glTF files, and of tables that are not in order.

mod error;
mod falls;
mod lasting_log;
mod led_bodies;
mod listed;
mod pose_rows;
mod recording;
mod stream;
mod survey;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clangor_core::body::{Body, BodyId, Motion, World};
use clangor_core::timeline::{ContactRow, PoseRow, TimelineSink};

use super::file_frame::FileAxes;
use super::imported_header::imported_header;
use crate::formats::timeline_file::{TimelineSummary, TimelineWriter};
use crate::motion::file_units::FileUnits;
use crate::motion::frame_checks::notices;
use crate::motion::impacts::MotionImpacts;
use crate::motion::parts::{Part, PartSearch};
use crate::motion::recording::RecordedBody;
use crate::stages::load::LoadedScene;
pub use error::MotionImportError;
use falls::fall_remarks;
use lasting_log::{lasting_log, noise_of_bodies};
use listed::{ListedContacts, span};
use pose_rows::pose_rows;
use recording::{Recording, read_recording};
use stream::import_stream;
use survey::survey;

/// Files of one recording.
#[derive(Clone, Debug, Default)]
pub struct MotionFiles {
    /// Animated glTF files.
    pub gltf: Vec<PathBuf>,
    /// Tables of poses.
    pub poses: Vec<PathBuf>,
    /// Contact lists; with any of them, impacts are not searched in the motion.
    pub contacts: Vec<PathBuf>,
    /// Axes of the tables of poses and the contact lists, and units of all files: those of glTF too, whose
    /// meshes, poses and inertia have the unit of length.
    pub axes: FileAxes,
    /// Length of the parts in which a table is searched that is read as a stream \[s\]; by default that of
    /// half a million poses. The result does not depend on it.
    pub part_length: Option<f64>,
    /// Names of nodes of the glTF files that are left out, each with all nodes below it.
    pub leave_out: Vec<String>,
    /// Name of the animation of the glTF files that moves their nodes; by default all of them do.
    pub animation: Option<String>,
    /// Whether every lasting contact is a row for each frame, as where the scene has `rolling = true`.
    pub raw_log: bool,
}

/// What was imported.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionSummary {
    /// Rows of the timeline.
    pub rows: TimelineSummary,
    /// Bodies that the recording moves.
    pub moved: usize,
    /// What was found in the motion; `None` if contacts were recorded.
    pub found: Option<FoundImpacts>,
    /// What is probably wrong.
    pub warnings: Vec<String>,
    /// What should be known.
    pub notices: Vec<String>,
}

impl MotionFiles {
    /// Units of all files.
    fn units(&self) -> FileUnits {
        FileUnits { length: self.axes.unit, time: self.axes.time_unit }
    }
}

/// The impacts that were found in a motion; the timeline has their rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FoundImpacts {
    /// Explained share of the jumps of each impact, by its number, from 1.
    pub confidence: Vec<f64>,
    /// Jumps of bodies that touch nothing at that time.
    pub untouched: u64,
    /// Body and time \[s\] of the first of them.
    pub first_untouched: Option<(BodyId, f64)>,
    /// Pushes over several frames that are taken as one impact.
    pub soft: u64,
    /// Longest time of one \[s\].
    pub longest_soft: f64,
    /// Body and time \[s\] of the first.
    pub first_soft: Option<(BodyId, f64)>,
}

impl FoundImpacts {
    /// Adds those of a later part.
    fn extend(&mut self, rows: &MotionImpacts) {
        self.confidence.extend(rows.confidence.values());
        self.untouched += rows.untouched.len() as u64;
        self.first_untouched = self.first_untouched.or(rows.untouched.first().copied());
        self.soft += rows.soft.len() as u64;
        self.longest_soft = rows.soft.iter().map(|push| push.length).fold(self.longest_soft, f64::max);
        self.first_soft = self.first_soft.or(rows.soft.first().map(|push| (push.body, push.time)));
    }

    /// Notices of soft contacts, and of jumps without contact.
    fn remarks(&self, world: &World) -> impl Iterator<Item = String> {
        self.remark_on_soft(world).into_iter().chain(self.remark_on_untouched(world))
    }

    fn remark_on_soft(&self, world: &World) -> Option<String> {
        let (body, time) = self.first_soft?;
        let pushes = match self.soft {
            1 => "1 impact is".into(),
            count => format!("{count} impacts are"),
        };
        let (name, longest) = (name_of(world, body), 1e3 * self.longest_soft);
        Some(format!(
            "{pushes} a push over several frames, up to {longest:.0} ms long, the first on {name} at \
             t = {time:.4} s: each is taken as one impulse at its beginning; stiffer contacts of the engine, \
             poses without a smoothing filter, or a contact list with the impulses are more exact"
        ))
    }

    fn remark_on_untouched(&self, world: &World) -> Option<String> {
        let (body, time) = self.first_untouched?;
        let jumps = match self.untouched {
            1 => "1 jump of the motion touches nothing and is silent: that".into(),
            count => format!("{count} jumps of the motion touch nothing and are silent, the first"),
        };
        let name = name_of(world, body);
        Some(format!(
            "{jumps} of {name} at t = {time:.4} s: a hand, a body that is not in the files, or surfaces \
             that stay apart (a collision margin)"
        ))
    }
}

/// Turns a recording of the bodies of a scene into a timeline folder.
///
/// # Errors
/// [`MotionImportError`]; no folder is left then.
pub fn import_motion(
    loaded: &LoadedScene,
    files: &MotionFiles,
    output: &Path,
    replace: bool,
) -> Result<MotionSummary, MotionImportError> {
    if let [table] = &files.poses[..]
        && files.gltf.is_empty()
    {
        let survey = survey(loaded, table, files)?;
        if let Some(plan) = survey.plan(table, &loaded.world, files)? {
            return import_stream(loaded, table, files, (survey, plan), (output, replace));
        }
    }
    import_in_memory(loaded, files, output, replace)
}

fn import_in_memory(
    loaded: &LoadedScene,
    files: &MotionFiles,
    output: &Path,
    replace: bool,
) -> Result<MotionSummary, MotionImportError> {
    let mut world = loaded.world.clone();
    let mut remarks = Vec::new();
    let Recording { recorded, checks, paths, from_gltf, held, smallest, .. } =
        read_recording(loaded, files, &mut world, &mut remarks)?;
    let name = |id: BodyId| name_of(&world, id);
    let paths: Vec<&Path> = paths.iter().map(PathBuf::as_path).collect();
    let falls = fall_remarks(&world, files, (&checks, &paths), smallest);
    let mut warnings = falls.warnings;
    remarks.extend(falls.size);
    remarks.extend(notices(&checks, from_gltf, &name).iter().map(ToString::to_string));
    if files.axes.z_up && files.poses.is_empty() && files.contacts.is_empty() {
        remarks.push(
            "--up z is for tables and contact lists; a glTF file has y up: export it with +Y up".into(),
        );
    }
    remarks.extend(unrecorded(&world, &recorded));
    remarks.extend(unbroken(loaded, &recorded));
    let (mut found, mut step) = (None, None);
    let (contacts, states) = if files.contacts.is_empty() {
        let part = Part { from: 0.0, to: f64::INFINITY, overlap: 0.0 };
        let log = lasting_log(loaded, files, &checks);
        remarks.extend(log.remark.map(String::from));
        step = log.step;
        let mut search = PartSearch::new(noise_of_bodies(&checks, world.bodies.len()), step.is_some());
        let rows = search.search(&world, &recorded, loaded.scene.simulation.v_min, part);
        let mut summary = FoundImpacts::default();
        summary.extend(&rows);
        remarks.extend(summary.remarks(&world));
        remarks.extend(search.sunk.notices(&world).iter().map(ToString::to_string));
        remarks.extend(search.open_joints.notices(&world).iter().map(ToString::to_string));
        remarks.extend(search.nested.notices(&world).iter().map(ToString::to_string));
        found = Some(summary);
        (rows.contacts, rows.states)
    } else {
        let mut lists = ListedContacts::read(&world, files, span(&recorded))?;
        let contacts = lists.take_before(f64::INFINITY, &recorded)?;
        remarks.extend(lists.remarks());
        warnings.append(&mut lists.warnings);
        (contacts, Vec::<PoseRow>::new())
    };
    remarks.extend(unheard(&world, &held, &contacts));
    let last_of = |body: &Body| body.motion.track()?.keys().last().map(|key| key.time);
    let frames = recorded.iter().filter_map(|body| Some(body.frames.last()?.time));
    let keys = world.bodies[loaded.world.bodies.len()..].iter().filter_map(last_of);
    let duration = frames.chain(keys).chain(contacts.iter().map(|row| row.time)).fold(0.0, f64::max);
    let header = imported_header(loaded, world, "recorded motion", duration, step);
    let has_effective_mass = contacts.iter().any(|row| row.effective_mass.is_some());
    let mut writer = TimelineWriter::create_for_contacts(output, &header, replace, has_effective_mass)?;
    let failed = |source| MotionImportError::Row { path: output.into(), source };
    for row in &contacts {
        writer.contact(row).map_err(failed)?;
    }
    for row in pose_rows(&recorded, &states, 0.0, f64::INFINITY) {
        writer.pose(&row).map_err(failed)?;
    }
    let rows = writer.finish()?;
    Ok(MotionSummary { rows, moved: recorded.len() + held.len(), found, warnings, notices: remarks })
}

fn name_of(world: &World, id: BodyId) -> String {
    world.bodies.get(id.index()).map_or_else(String::new, |body| body.name.clone())
}

/// Bodies that would break in a simulation, and whose motion is recorded.
fn unbroken(loaded: &LoadedScene, recorded: &[RecordedBody]) -> Option<String> {
    let is_moved = |id: BodyId| recorded.iter().any(|body| body.body == id);
    let whole = loaded.breakables.iter().filter(|breakable| is_moved(breakable.body));
    let names: Vec<String> = whole.map(|breakable| name_of(&loaded.world, breakable.body)).collect();
    (!names.is_empty()).then(|| {
        format!(
            "`fracture` does nothing for bodies that the files move, which stay whole: {}",
            names.join(", ")
        )
    })
}

/// Bodies that are moved from outside and strike nothing: what cannot move does not sound under them.
fn unheard(world: &World, held: &[BodyId], contacts: &[ContactRow]) -> Option<String> {
    let strikes = |id: &BodyId| contacts.iter().any(|row| [row.body_a, row.body_b].contains(id));
    let silent: Vec<String> = held.iter().filter(|id| !strikes(id)).map(|id| name_of(world, *id)).collect();
    (!silent.is_empty()).then(|| {
        format!(
            "no impact moves these bodies (isKinematic, or a mass of 0), and they have none on what cannot \
             move either: {}; without that mark their impacts follow from their motion",
            silent.join(", ")
        )
    })
}

/// Bodies that could move, but stand still since no file moves them.
fn unrecorded(world: &World, recorded: &[RecordedBody]) -> Option<String> {
    let known: BTreeSet<usize> = recorded.iter().map(|body| body.body.index()).collect();
    let is_left = |index: usize, body: &Body| matches!(body.motion, Motion::Free) && !known.contains(&index);
    let left: Vec<&str> = world
        .bodies
        .iter()
        .enumerate()
        .filter(|(index, body)| is_left(*index, body))
        .map(|(_, body)| body.name.as_str())
        .collect();
    (!left.is_empty()).then(|| {
        format!("the files have no motion of these bodies, which stay where they begin: {}", left.join(", "))
    })
}
