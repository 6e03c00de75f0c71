//! Contacts of lists, checked against the recorded motion of the bodies, also part by part.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clangor_core::body::{BodyId, Motion, World};
use clangor_core::contact::PoseHistory;
use clangor_core::pose::Pose;
use clangor_core::timeline::{ContactKind, ContactRow, PoseRow};
use clangor_sim::rigid::{JoinedBodies, JoinedContact};

use super::pose_rows::pose_rows;
use super::{MotionFiles, MotionImportError};
use crate::formats::contact_list::{ListedContact, read_listed_contacts};
use crate::formats::named_bodies::NamedBodies;
use crate::motion::contact_checks::{ContactChecks, ContactFault, check_clock, no_contacts, time_outside};
use crate::motion::contact_steps::contact_steps;
use crate::motion::listed_impulses::ListedImpulses;
use crate::motion::open_joints::are_closed;
use crate::motion::recording::RecordedBody;
use crate::motion::repeated_contacts::RepeatedContacts;

/// The contacts of all lists of a recording.
pub(super) struct ListedContacts<'a> {
    world: &'a World,
    lists: Vec<(PathBuf, ContactChecks<'a>)>,
    impulses: ListedImpulses,
    /// What is probably wrong.
    pub(super) warnings: Vec<String>,
}

impl<'a> ListedContacts<'a> {
    /// Reads the lists of a motion between two instants \[s\].
    pub(super) fn read(
        world: &'a World,
        files: &MotionFiles,
        motion: [f64; 2],
    ) -> Result<Self, MotionImportError> {
        let mut read = ListedContacts {
            world,
            lists: Vec::new(),
            impulses: ListedImpulses::new(world),
            warnings: Vec::new(),
        };
        let span = with_keyframes(world, motion);
        let mut repeated = RepeatedContacts::default();
        let mut offset = 0;
        for path in &files.contacts {
            let mut rows = read_listed_contacts(path, &NamedBodies::of(world))?;
            files.axes.in_seconds(&mut rows);
            if let Some(listed) = time_outside(&rows) {
                let (row, time) = (listed.line, listed.row.time);
                return Err(MotionImportError::Time { path: path.clone(), row, time });
            }
            read.warnings.extend(rows.is_empty().then(|| no_contacts(path)));
            let twice = repeated.look(path, &rows);
            read.warnings.extend(twice.map(|notice| format!("{}: {notice}", path.display())));
            let steps = contact_steps(world, &rows);
            read.warnings.extend(steps.map(|notice| format!("{}: {notice}", path.display())));
            let refused = |fault| MotionImportError::Contact { path: path.clone(), fault };
            files.axes.in_metres(&mut rows);
            for ListedContact { line, row, .. } in &mut rows {
                if row.impact_id > 0 {
                    let too_large = ContactFault::ImpactId { row: *line, id: row.impact_id };
                    row.impact_id = row.impact_id.checked_add(offset).ok_or_else(|| refused(too_large))?;
                }
            }
            offset = rows.iter().map(|listed| listed.row.impact_id).fold(offset, u64::max);
            check_clock(&rows, span).map_err(refused)?;
            read.lists.push((path.clone(), ContactChecks::new(world, rows)));
        }
        Ok(read)
    }

    fn left(&self) -> impl Iterator<Item = &ContactRow> {
        self.lists.iter().flat_map(|(_, checks)| checks.left()).map(|listed| &listed.row)
    }

    /// Time of the last contact that is not taken yet \[s\].
    pub(super) fn last_time(&self) -> f64 {
        self.left().map(|row| row.time).fold(0.0, f64::max)
    }

    /// Whether any contact that is not taken yet has an effective mass, or may have one of joints.
    pub(super) fn may_have_effective_mass(&self) -> bool {
        self.left().any(|row| row.effective_mass.is_some()) || JoinedBodies::of(self.world).is_some()
    }

    /// Takes the contacts before a time \[s\], in order of time, checked against the motion around them.
    pub(super) fn take_before(
        &mut self,
        time: f64,
        recorded: &[RecordedBody],
    ) -> Result<Vec<ContactRow>, MotionImportError> {
        if !self.left().any(|row| row.time < time) {
            return Ok(Vec::new());
        }
        let world = self.world;
        let poses: Vec<PoseRow> = pose_rows(recorded, &[], 0.0, f64::INFINITY).collect();
        let history = PoseHistory::try_new(&world.bodies, &poses)?;
        let moved: BTreeSet<BodyId> = recorded.iter().map(|body| body.body).collect();
        let pose_of = |id: BodyId, time: f64| {
            let is_known = match world.bodies[id.index()].motion {
                Motion::Fixed | Motion::Keyframed(_) => true,
                Motion::Free | Motion::Guided(_) => moved.contains(&id),
            };
            is_known.then(|| history.at(id, time))
        };
        let mut contacts = Vec::new();
        for (path, checks) in &mut self.lists {
            let refused = |fault| MotionImportError::Contact { path: path.clone(), fault };
            contacts.extend(checks.check_before(time, &pose_of).map_err(refused)?);
        }
        contacts.sort_by(|a, b| a.time.total_cmp(&b.time));
        self.impulses.look(world, &contacts, recorded);
        if let Some(joined) = JoinedBodies::of(world) {
            for row in contacts.iter_mut().filter(|row| row.effective_mass.is_none()) {
                row.effective_mass = mass_on_joints((world, &joined), row, &|id| history.at(id, row.time));
            }
        }
        Ok(contacts)
    }

    /// What should be known of the contacts that are taken.
    pub(super) fn remarks(&self) -> impl Iterator<Item = String> {
        let of_list = |(path, checks): &(PathBuf, ContactChecks<'_>)| {
            let path = path.display().to_string();
            checks.notices().into_iter().map(move |notice| format!("{path}: {notice}"))
        };
        self.lists.iter().flat_map(of_list).chain(self.impulses.notices(self.world))
    }
}

/// The effective mass of an impact of bodies on joints, if their poses are those of the joints \[kg\].
fn mass_on_joints(
    (world, joined): (&World, &JoinedBodies<'_>),
    row: &ContactRow,
    poses: &dyn Fn(BodyId) -> Pose,
) -> Option<f64> {
    let bodies = [row.body_a, row.body_b];
    if row.kind != ContactKind::Impact || !are_closed((world, joined), bodies, poses) {
        return None;
    }
    let mut pair = joined.pair(&JoinedContact { bodies, point: row.point, time: row.time, poses })?;
    Some(pair.effective_mass(row.normal)).filter(|mass| mass.is_finite())
}

/// First and last instant of the frames of bodies \[s\].
pub(super) fn span(recorded: &[RecordedBody]) -> [f64; 2] {
    let frames = recorded.iter().flat_map(|body| [body.frames.first(), body.frames.last()]).flatten();
    frames.fold([f64::INFINITY, 0.0], |[from, to], frame| [frame.time.min(from), frame.time.max(to)])
}

/// First and last instant at which frames or keyframes move anything \[s\].
fn with_keyframes(world: &World, motion: [f64; 2]) -> [f64; 2] {
    let tracks = world.bodies.iter().filter_map(|body| Some(body.motion.track()?.keys()));
    let keys = tracks.flat_map(|keys| [keys.first(), keys.last()]).flatten();
    keys.fold(motion, |[from, to], key| [key.time.min(from), key.time.max(to)])
}
