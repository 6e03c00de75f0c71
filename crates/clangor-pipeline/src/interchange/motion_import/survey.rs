//! First reading of a table of poses: everything is checked, nothing kept but the first frames of each body,
//! and it is known how the table can be read as a stream.

use std::path::Path;

use clangor_core::body::{BodyId, World};

use super::super::file_frame::FileFrame;
use super::led_bodies::{check_movable, is_of_scene};
use super::recording::FramesOfTable;
use super::{MotionFiles, MotionImportError};
use crate::formats::named_bodies::NamedBodies;
use crate::formats::pose_table::{LATE, LATENESS, PoseSink, PoseTableError, PositionOf, insert, scan_poses};
use crate::formats::record_table::MAX_ROWS;
use crate::motion::frame_checks::FrameChecks;
use crate::motion::parts::Part;
use crate::motion::quaternion_order::QuaternionOrder;
use crate::motion::recording::Frame;
use crate::stages::load::LoadedScene;

/// Frames of a body that are kept around a part: the search of impacts looks at five on both sides of a
/// frame, and at a body's way in the four intervals around it.
pub(super) const KEPT: usize = 8;
/// Most rows of a stream, which needs no memory for them: an hour of 1000 bodies at 1000 Hz.
pub(super) const MOST_STREAMED: u64 = 4_000_000_000;
/// Poses of a part: a part takes 280 bytes for each.
const PART_POSES: f64 = 500_000.0;
/// Shortest recording of which a rate is computed \[s\].
const SHORTEST: f64 = 1e-3;
/// Overlap of parts in mean frames: impacts are compared in its inner half, with 16 frames on both sides in
/// which the search forgets where it began.
const OVERLAP_FRAMES: f64 = 64.0;
/// Overlap in longest frames, for impacts between frames that are far apart; of bodies that miss more than
/// the second value \[s\] no impact is known to a frame.
const OVERLAP_LONGEST: (f64, f64) = (8.0, 0.1);
/// Least overlap \[s\]: rest, and forces without noise, take up to 50 ms on both sides of a frame.
const OVERLAP_LEAST: f64 = 0.25;

/// What a table holds.
pub(super) struct Survey {
    pub(super) position_of: PositionOf,
    /// Bodies, in the order of their first rows.
    pub(super) bodies: Vec<SurveyedBody>,
    /// Latest time \[s\].
    pub(super) latest: f64,
    rows: u64,
    /// How late rows come after those of other bodies \[s\].
    late: f64,
    /// The first row that comes too late for a stream: its number, its time, and the latest before.
    unsorted: Option<(u64, [f64; 2])>,
}

/// A body of a table.
pub(super) struct SurveyedBody {
    pub(super) body: BodyId,
    /// Its first frames, [`KEPT`] at most.
    pub(super) first: Vec<Frame>,
    pub(super) checks: FrameChecks,
}

/// How a table is read as a stream.
#[derive(Clone, Copy, Debug)]
pub(super) struct StreamPlan {
    /// The first part.
    pub(super) part: Part,
    /// Time after the end of a part and its overlap at which all of its rows have come \[s\].
    pub(super) lookahead: f64,
}

impl Survey {
    /// How the table is read as a stream; `None` if it has to be kept in memory.
    ///
    /// # Errors
    /// [`PoseTableError::Gap`] if it can be neither.
    pub(super) fn plan(
        &self,
        path: &Path,
        world: &World,
        files: &MotionFiles,
    ) -> Result<Option<StreamPlan>, MotionImportError> {
        if self.unsorted.is_some() || self.bodies.is_empty() {
            return Ok(None);
        }
        // A table of one instant is a single part.
        let rate = self.rows as f64 / self.latest.max(SHORTEST);
        let frame = self.bodies.len() as f64 / rate;
        let gap = self.bodies.iter().map(|body| body.checks.longest()).fold(0.0, f64::max);
        let (times, longest) = OVERLAP_LONGEST;
        let overlap = (OVERLAP_FRAMES * frame).max(times * gap.min(longest)).max(OVERLAP_LEAST);
        let length = files.part_length.unwrap_or(PART_POSES / rate).max(2.0 * overlap);
        // The velocity at the frame after a listed contact takes the frame after that.
        let ahead = if files.contacts.is_empty() { gap } else { 2.0 * gap };
        let lookahead = ahead + self.late + LATE;
        if (length + 2.0 * overlap + lookahead).min(self.latest) * rate <= MAX_ROWS as f64 {
            let part = Part { from: 0.0, to: length, overlap };
            return Ok(Some(StreamPlan { part, lookahead }));
        }
        if self.rows <= MAX_ROWS {
            return Ok(None);
        }
        let sparsest = self.bodies.iter().max_by(|a, b| a.checks.longest().total_cmp(&b.checks.longest()));
        let body = sparsest.map_or_else(String::new, |body| world.bodies[body.body.index()].name.clone());
        Err(PoseTableError::Gap { path: path.into(), body, gap }.into())
    }
}

/// Reads and checks a table.
///
/// # Errors
/// [`MotionImportError`].
pub(super) fn survey(
    loaded: &LoadedScene,
    path: &Path,
    files: &MotionFiles,
) -> Result<Survey, MotionImportError> {
    let world = &loaded.world;
    let mut surveyor = Surveyor {
        loaded,
        files,
        path,
        frame_of: FramesOfTable::new(world, files, PositionOf::CentreOfMass),
        place_of: vec![None; world.bodies.len()],
        pending: Vec::new(),
        survey: Survey {
            position_of: PositionOf::CentreOfMass,
            bodies: Vec::new(),
            latest: 0.0,
            rows: 0,
            late: 0.0,
            unsorted: None,
        },
    };
    scan_poses(path, &NamedBodies::of(world), &mut surveyor)?;
    for place in 0..surveyor.pending.len() {
        surveyor.release(place, f64::INFINITY)?;
    }
    Ok(surveyor.survey)
}

struct Surveyor<'a> {
    loaded: &'a LoadedScene,
    files: &'a MotionFiles,
    path: &'a Path,
    frame_of: FramesOfTable,
    place_of: Vec<Option<usize>>,
    /// Frames of each body before which a late one may come.
    pending: Vec<Vec<Frame>>,
    survey: Survey,
}

impl Surveyor<'_> {
    fn place(&mut self, id: BodyId) -> Result<usize, MotionImportError> {
        if let Some(place) = self.place_of[id.index()] {
            return Ok(place);
        }
        let body = &self.loaded.world.bodies[id.index()];
        check_movable(body, self.path)?;
        let sound_speed = self.loaded.scene.acoustics.medium.sound_speed;
        let order = QuaternionOrder::new(body.inertia, FileFrame::of(self.files.axes).turn());
        let checks = FrameChecks::new(sound_speed, self.loaded.world.gravity, self.files.units());
        let checks = checks.with_order(order);
        self.survey.bodies.push(SurveyedBody { body: id, first: Vec::new(), checks });
        self.pending.push(Vec::new());
        let place = self.pending.len() - 1;
        self.place_of[id.index()] = Some(place);
        Ok(place)
    }

    /// How far a row comes after later ones.
    fn count(&mut self, frame: &Frame) -> Result<(), MotionImportError> {
        let survey = &mut self.survey;
        survey.rows += 1;
        let late = survey.latest - frame.time;
        survey.late = survey.late.max(late);
        if late > LATENESS && survey.unsorted.is_none() {
            survey.unsorted = Some((frame.row, [frame.time, survey.latest]));
        }
        survey.latest = survey.latest.max(frame.time);
        match survey.unsorted {
            Some((row, [time, latest])) if survey.rows > MAX_ROWS => {
                Err(PoseTableError::NotSorted { path: self.path.into(), row, time, latest }.into())
            }
            _ => Ok(()),
        }
    }

    /// Checks the frames of a body before a time.
    fn release(&mut self, place: usize, before: f64) -> Result<(), MotionImportError> {
        let pending = &mut self.pending[place];
        let SurveyedBody { body, first, checks } = &mut self.survey.bodies[place];
        let name = &self.loaded.world.bodies[body.index()].name;
        let count = pending.iter().take_while(|frame| frame.time < before).count();
        for mut frame in pending.drain(..count) {
            checks
                .push(name, &mut frame)
                .map_err(|error| MotionImportError::Recording { path: self.path.into(), error })?;
            if first.len() < KEPT {
                first.push(frame);
            }
        }
        Ok(())
    }
}

impl PoseSink for Surveyor<'_> {
    type Error = MotionImportError;

    fn most_rows(&self) -> u64 {
        MOST_STREAMED
    }

    fn begin(&mut self, position_of: PositionOf) {
        self.survey.position_of = position_of;
        self.frame_of.set_position(position_of);
    }

    fn pose(&mut self, body: BodyId, mut frame: Frame) -> Result<(), MotionImportError> {
        frame.time *= self.files.axes.time_unit.seconds;
        let described = &self.loaded.world.bodies[body.index()];
        self.frame_of.learn_centre(self.loaded, described, body, self.path)?;
        self.frame_of.place(body, &mut frame);
        if is_of_scene(described, &frame, self.path)? {
            return Ok(());
        }
        let place = self.place(body)?;
        self.count(&frame)?;
        let newest = self.pending[place].last().map_or(f64::NEG_INFINITY, |last| last.time);
        if frame.time < newest - LATE {
            // Later than any that may be late: the check says so.
            self.release(place, f64::INFINITY)?;
        }
        insert(&mut self.pending[place], frame);
        self.release(place, frame.time.max(newest) - LATE)
    }
}

#[cfg(test)]
mod tests {
    use clangor_core::body::Body;
    use clangor_core::material::presets::preset;
    use clangor_core::medium::Medium;
    use clangor_core::pose::Pose;
    use clangor_core::scene::STANDARD_GRAVITY;
    use glam::DVec3;

    use super::*;
    use crate::motion::file_units::FileUnits;

    /// A table of this many rows in an hour, with a body that has no frame for `gap` seconds.
    fn table(rows: u64, gap: f64) -> Survey {
        let mut checks = FrameChecks::new(Medium::AIR.sound_speed, STANDARD_GRAVITY, FileUnits::default());
        for time in [0.0, gap] {
            checks.push("still", &mut Frame { time, pose: Pose::at(DVec3::ZERO), row: 0 }).unwrap();
        }
        let still = SurveyedBody { body: BodyId(0), first: Vec::new(), checks };
        let position_of = PositionOf::CentreOfMass;
        Survey { position_of, bodies: vec![still], latest: 3600.0, rows, late: 0.0, unsorted: None }
    }

    #[test]
    fn a_gap_that_would_fill_the_memory_is_refused() {
        let bodies = vec![Body::sphere("still", preset("steel").unwrap(), 0.01)];
        let world = World { bodies, links: Vec::new(), gravity: DVec3::NEG_Y };
        let plan = |rows: u64, gap: f64| {
            table(rows, gap).plan(Path::new("a.parquet"), &world, &MotionFiles::default())
        };
        assert!(plan(86_400_000, 600.0).unwrap().is_some(), "ten minutes of 100 bodies at 240 Hz");
        assert!(plan(19_000_000, 3600.0).unwrap().is_some(), "all fits");
        let message = plan(86_400_000, 3000.0).unwrap_err().to_string();
        assert!(message.contains("body still has no frame for 3000 s"), "{message}");
    }
}
