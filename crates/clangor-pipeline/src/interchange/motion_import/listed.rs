//! Contacts of lists, checked against the recorded motion of the bodies.

use std::collections::BTreeSet;

use clangor_core::body::{BodyId, Motion, World};
use clangor_core::contact::PoseHistory;
use clangor_core::timeline::{ContactRow, PoseRow};

use super::file_frame::FileFrame;
use super::pose_rows::pose_rows;
use super::{MotionFiles, MotionImportError};
use crate::formats::contact_list::{ListedContact, read_listed_contacts};
use crate::formats::named_bodies::NamedBodies;
use crate::motion::contact_checks::{ContactFault, check_clock, check_contacts, time_outside};
use crate::motion::recording::RecordedBody;
use crate::motion::repeated_contacts::RepeatedContacts;

/// Contacts of all lists, checked against the motion.
pub(super) fn read_contacts(
    world: &World,
    recorded: &[RecordedBody],
    files: &MotionFiles,
    remarks: &mut Vec<String>,
) -> Result<Vec<ContactRow>, MotionImportError> {
    let poses: Vec<PoseRow> = pose_rows(recorded, &[], 0.0, f64::INFINITY).collect();
    let history = PoseHistory::try_new(&world.bodies, &poses)?;
    let moved: BTreeSet<BodyId> = recorded.iter().map(|body| body.body).collect();
    let pose_of = |id: BodyId, time: f64| {
        let body = &world.bodies[id.index()];
        let is_known = !matches!(body.motion, Motion::Free) || moved.contains(&id);
        is_known.then(|| history.at(id, time))
    };
    let span = span(world, recorded);
    let file = FileFrame::of(files);
    let mut contacts = Vec::new();
    let mut repeated = RepeatedContacts::default();
    for path in &files.contacts {
        let mut rows = read_listed_contacts(path, &NamedBodies::of(world))?;
        rows.iter_mut().for_each(|listed| listed.row.time *= files.time_unit.seconds);
        if let Some(listed) = time_outside(&rows) {
            let (row, time) = (listed.line, listed.row.time);
            return Err(MotionImportError::Time { path: path.clone(), row, time });
        }
        let twice = repeated.look(path, &rows);
        remarks.extend(twice.map(|notice| format!("{}: {notice}", path.display())));
        let refused = |fault| MotionImportError::Contact { path: path.clone(), fault };
        let offset = contacts.iter().map(|row: &ContactRow| row.impact_id).max().unwrap_or(0);
        for ListedContact { line, row, .. } in &mut rows {
            for vector in [&mut row.normal, &mut row.impulse_t, &mut row.couple] {
                *vector = file.direction(*vector);
            }
            for vector in [&mut row.point, &mut row.velocity] {
                *vector = file.place(*vector);
            }
            row.depth *= files.unit.metres;
            if row.impact_id > 0 {
                let too_large = ContactFault::ImpactId { row: *line, id: row.impact_id };
                row.impact_id = row.impact_id.checked_add(offset).ok_or_else(|| refused(too_large))?;
            }
        }
        check_clock(&rows, span).map_err(refused)?;
        let (rows, notices) = check_contacts(world, rows, &pose_of).map_err(refused)?;
        remarks.extend(notices.iter().map(|notice| format!("{}: {notice}", path.display())));
        contacts.extend(rows);
    }
    contacts.sort_by(|a, b| a.time.total_cmp(&b.time));
    Ok(contacts)
}

/// First and last instant at which files move anything \[s\].
fn span(world: &World, recorded: &[RecordedBody]) -> [f64; 2] {
    let frames = recorded.iter().flat_map(|body| [body.frames.first(), body.frames.last()]).flatten();
    let tracks = world.bodies.iter().filter_map(|body| Some(body.motion.track()?.keys()));
    let keys = tracks.flat_map(|keys| [keys.first(), keys.last()]).flatten();
    let times = frames.map(|frame| frame.time).chain(keys.map(|key| key.time));
    times.fold([f64::INFINITY, 0.0], |[from, to], time| [time.min(from), time.max(to)])
}
