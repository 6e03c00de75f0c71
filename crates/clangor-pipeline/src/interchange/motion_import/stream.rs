//! Second reading of a table of poses: impacts part by part, found or of lists, and poses as they come.

use std::path::Path;

use clangor_core::body::{BodyId, Motion, World};
use clangor_core::timeline::TimelineSink;

use super::falls::fall_remarks;
use super::lasting_log::{lasting_log, noise_of_bodies};
use super::listed::{ListedContacts, span};
use super::pose_rows::pose_rows;
use super::recording::{FramesOfTable, start};
use super::survey::{KEPT, MOST_STREAMED, StreamPlan, Survey};
use super::{FoundImpacts, MotionFiles, MotionImportError, MotionSummary, name_of, unbroken, unrecorded};
use crate::formats::named_bodies::NamedBodies;
use crate::formats::pose_table::{PoseSink, PoseTableError, PositionOf, insert, scan_poses};
use crate::formats::record_table::MAX_ROWS;
use crate::formats::timeline_file::TimelineWriter;
use crate::interchange::imported_header::imported_header;
use crate::motion::frame_checks::notices;
use crate::motion::parts::{Part, PartSearch};
use crate::motion::recording::{Frame, RecordedBody, TimeUnit};
use crate::stages::load::LoadedScene;

/// Imports a surveyed table into a folder, which is replaced or not.
///
/// # Errors
/// [`MotionImportError`]; no folder is left then.
pub(super) fn import_stream(
    loaded: &LoadedScene,
    path: &Path,
    files: &MotionFiles,
    (survey, plan): (Survey, StreamPlan),
    (output, replace): (&Path, bool),
) -> Result<MotionSummary, MotionImportError> {
    let mut world = loaded.world.clone();
    let Survey { position_of, bodies, latest, .. } = survey;
    let mut frame_of = FramesOfTable::new(&world, files, position_of);
    let (mut recorded, mut checks) = (Vec::with_capacity(bodies.len()), Vec::with_capacity(bodies.len()));
    let mut place_of = vec![None; world.bodies.len()];
    for body in bodies {
        let described = &mut world.bodies[body.body.index()];
        frame_of.learn_centre(loaded, described, body.body, path)?;
        start(described, &body.first);
        place_of[body.body.index()] = Some(recorded.len());
        recorded.push(RecordedBody { body: body.body, frames: body.first, group: None });
        checks.push((body.body, body.checks));
    }
    let name = |id: BodyId| name_of(&world, id);
    let mut remarks: Vec<String> = notices(&checks, 0, &name).iter().map(ToString::to_string).collect();
    remarks.extend(unrecorded(&world, &recorded));
    remarks.extend(unbroken(loaded, &recorded));
    let falls = fall_remarks(&world, files, (&checks, &vec![path; checks.len()]), None);
    let mut warnings = falls.warnings;
    // Whether a hand leads a body in some impact is known at the end.
    let (mut step, mut latest, mut may_have_mass) = (None, latest, true);
    let contacts = if files.contacts.is_empty() {
        let log = lasting_log(loaded, files, &checks);
        remarks.extend(log.remark.map(String::from));
        step = log.step;
        let search = PartSearch::new(noise_of_bodies(&checks, world.bodies.len()), step.is_some());
        Contacts::Searched(Box::new(search), FoundImpacts::default())
    } else {
        let mut lists = ListedContacts::read(&world, files, [span(&recorded)[0], latest])?;
        latest = latest.max(lists.last_time());
        may_have_mass = lists.may_have_effective_mass();
        warnings.append(&mut lists.warnings);
        Contacts::Listed(lists)
    };
    let header = imported_header(loaded, world.clone(), "recorded motion", latest, step);
    let known_to = recorded.iter().map(|body| body.frames.last().map_or(0.0, |frame| frame.time)).collect();
    let mut stream = PoseStream {
        path,
        output,
        world: &world,
        time_unit: files.axes.time_unit,
        v_min: loaded.scene.simulation.v_min,
        frame_of,
        place_of,
        known_to,
        recorded,
        part: plan.part,
        lookahead: plan.lookahead,
        written_to: 0.0,
        joints: 0,
        kept: 0,
        contacts,
        writer: TimelineWriter::create_for_contacts(output, &header, replace, may_have_mass)?,
    };
    scan_poses(path, &NamedBodies::of(&world), &mut stream)?;
    stream.part.to = f64::INFINITY;
    stream.finish_part()?;
    let PoseStream { mut writer, contacts, recorded, joints, .. } = stream;
    writer.extend_to_latest();
    let found = match contacts {
        Contacts::Searched(search, found) => {
            remarks.extend(found.remarks(&world));
            remarks.extend(search_remarks(&search, &world, (plan.part.to, joints)));
            Some(found)
        }
        Contacts::Listed(lists) => {
            remarks.extend(lists.remarks());
            None
        }
    };
    Ok(MotionSummary { rows: writer.finish()?, moved: recorded.len(), found, warnings, notices: remarks })
}

/// What should be known of a search in parts of a length \[s\] with so many joints.
fn search_remarks(search: &PartSearch, world: &World, (length, joints): (f64, u64)) -> Vec<String> {
    let sunk = search.sunk.notices(world).into_iter().map(|notice| notice.to_string());
    let nested = search.nested.notices(world).into_iter().map(|notice| notice.to_string());
    let open = search.open_joints.notices(world).into_iter().map(|notice| notice.to_string());
    let mut remarks: Vec<String> = sunk.chain(nested).chain(open).collect();
    if search.doubtful_joints > 0 {
        remarks.push(format!(
            "the recording was searched in parts of {length:.1} s; at {} of {joints} joints the parts agree \
             on no impact: impacts there may differ from those of a search in one piece",
            search.doubtful_joints
        ));
    }
    remarks
}

/// Where the contacts of a stream come from.
enum Contacts<'a> {
    /// They are found in its motion.
    Searched(Box<PartSearch>, FoundImpacts),
    /// Lists have them.
    Listed(ListedContacts<'a>),
}

/// A table on its way to a timeline.
struct PoseStream<'a> {
    path: &'a Path,
    output: &'a Path,
    world: &'a World,
    time_unit: TimeUnit,
    v_min: f64,
    frame_of: FramesOfTable,
    place_of: Vec<Option<usize>>,
    /// Times of the last frames that the survey kept \[s\].
    known_to: Vec<f64>,
    /// Frames of this part with its overlaps, and of the rows ahead.
    recorded: Vec<RecordedBody>,
    part: Part,
    lookahead: f64,
    /// Poses before this time are written \[s\].
    written_to: f64,
    joints: u64,
    /// Frames that are kept.
    kept: u64,
    contacts: Contacts<'a>,
    writer: TimelineWriter,
}

impl PoseSink for PoseStream<'_> {
    type Error = MotionImportError;

    fn most_rows(&self) -> u64 {
        MOST_STREAMED
    }

    fn begin(&mut self, position_of: PositionOf) {
        self.frame_of.set_position(position_of);
    }

    fn pose(&mut self, body: BodyId, mut frame: Frame) -> Result<(), MotionImportError> {
        let place = self.place_of[body.index()];
        // The survey has found that the table has such a body as the scene does.
        let led = matches!(self.world.bodies[body.index()].motion, Motion::Fixed | Motion::Keyframed(_));
        if place.is_none() && led {
            return Ok(());
        }
        let place = place.ok_or_else(|| MotionImportError::Changed { path: self.path.into() })?;
        frame.time *= self.time_unit.seconds;
        while frame.time > self.part.to + self.part.overlap + self.lookahead {
            self.finish_part()?;
            self.part = self.part.next();
            self.joints += 1;
        }
        if frame.time > self.known_to[place] {
            self.frame_of.place(body, &mut frame);
            let orientation = frame.pose.orientation;
            frame.pose.orientation = orientation / orientation.length();
            insert(&mut self.recorded[place].frames, frame);
            self.kept += 1;
            if self.kept > MAX_ROWS {
                let from = self.part.from - self.part.overlap;
                let (path, row) = (self.path.into(), frame.row);
                return Err(PoseTableError::Dense { path, row, from: from.max(0.0), to: frame.time }.into());
            }
        }
        Ok(())
    }
}

impl PoseStream<'_> {
    /// Searches the part, writes what is final, and forgets what the next part does not need.
    fn finish_part(&mut self) -> Result<(), MotionImportError> {
        let part = self.part;
        let (contacts, states) = match &mut self.contacts {
            Contacts::Searched(search, found) => {
                let rows = search.search(self.world, &self.recorded, self.v_min, part);
                found.extend(&rows);
                (rows.contacts, rows.states)
            }
            Contacts::Listed(lists) => (lists.take_before(part.final_to(), &self.recorded)?, Vec::new()),
        };
        let failed = |source| MotionImportError::Row { path: self.output.into(), source };
        for row in &contacts {
            self.writer.contact(row).map_err(failed)?;
        }
        for row in pose_rows(&self.recorded, &states, self.written_to, part.final_to()) {
            self.writer.pose(&row).map_err(failed)?;
        }
        self.written_to = part.final_to();
        self.kept = 0;
        for RecordedBody { frames, .. } in &mut self.recorded {
            let needed = frames.partition_point(|frame| frame.time < part.to - part.overlap);
            frames.drain(..needed.saturating_sub(KEPT));
            self.kept += frames.len() as u64;
        }
        Ok(())
    }
}
