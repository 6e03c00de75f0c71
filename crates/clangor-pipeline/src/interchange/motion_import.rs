//! Motion that another program recorded becomes a timeline: poses, and contacts that are recorded too or are
//! found in the motion.

mod error;
mod pose_rows;

use std::path::{Path, PathBuf};

use clangor_core::body::{Body, BodyId, Motion, World};
use clangor_core::contact::PoseHistory;
use clangor_core::pose::{Keyframe, Pose, Track};
use clangor_core::scene::instantiate::GeometryError;
use clangor_core::timeline::{ContactRow, PoseRow, TimelineSink};
use glam::{DQuat, DVec3};

use super::gltf_bodies::add_nodes;
use super::imported_header::imported_header;
use crate::formats::contact_list::{ListedContact, read_listed_contacts};
use crate::formats::gltf_motion::read_gltf_motion;
use crate::formats::pose_table::{PositionOf, read_pose_table};
use crate::formats::timeline_file::{TimelineSummary, TimelineWriter};
use crate::motion::contact_checks::{ContactFault, check_clock, check_contacts, time_outside};
use crate::motion::impacts::{MotionImpacts, find_impacts};
use crate::motion::recording::{Frame, RecordedBody, check_frames, notices};
use crate::stages::load::{LoadedScene, load_geometry};
pub use error::MotionImportError;
use pose_rows::{pose_rows, velocities};

/// Files of one recording.
#[derive(Clone, Debug, Default)]
pub struct MotionFiles {
    /// Animated glTF files.
    pub gltf: Vec<PathBuf>,
    /// Tables of poses.
    pub poses: Vec<PathBuf>,
    /// Contact lists; with any of them, impacts are not searched in the motion.
    pub contacts: Vec<PathBuf>,
    /// Whether the tables of poses and the contact lists have z up.
    pub z_up: bool,
}

/// What was imported.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionSummary {
    /// Rows of the timeline.
    pub rows: TimelineSummary,
    /// Bodies that the recording moves.
    pub moved: usize,
    /// Impacts that were found in the motion, with their confidence; `None` if contacts were recorded.
    pub found: Option<MotionImpacts>,
    /// What should be known.
    pub notices: Vec<String>,
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
    let mut world = loaded.world.clone();
    let mut remarks = Vec::new();
    let Recording { recorded, from_gltf, held } = read_recording(loaded, files, &mut world, &mut remarks)?;
    let name = |id: BodyId| loaded_name(&world, id);
    remarks.extend(notices(&recorded, from_gltf, &name, world.gravity).iter().map(ToString::to_string));
    if files.z_up && files.poses.is_empty() && files.contacts.is_empty() {
        remarks.push(
            "--up z is for tables and contact lists; a glTF file has y up: export it with +Y up".into(),
        );
    }
    remarks.extend(unrecorded(&world, &recorded));
    let v_min = loaded.scene.simulation.v_min;
    let (contacts, found) = if files.contacts.is_empty() {
        let found = find_impacts(&world, &recorded, v_min);
        if !found.untouched.is_empty() {
            let (body, time) = found.untouched[0];
            let count = found.untouched.len();
            remarks.push(format!(
                "{count} jumps of the motion touch nothing and are silent, the first of {} at t = \
                 {time:.4} s: a \
                 hand, or a body that is not in the files",
                loaded_name(&world, body)
            ));
        }
        (found.contacts.clone(), Some(found))
    } else {
        (read_contacts(&world, &recorded, files, &mut remarks)?, None)
    };
    let last_of = |body: &Body| match &body.motion {
        Motion::Keyframed(track) => track.keys().last().map(|key| key.time),
        _ => None,
    };
    let frames = recorded.iter().filter_map(|body| Some(body.frames.last()?.time));
    let keys = world.bodies[loaded.world.bodies.len()..].iter().filter_map(last_of);
    let duration = frames.chain(keys).chain(contacts.iter().map(|row| row.time)).fold(0.0, f64::max);
    let header = imported_header(loaded, world, "recorded motion", duration);
    let mut writer = TimelineWriter::create(output, &header, replace)?;
    let failed = |source| MotionImportError::Row { path: output.into(), source };
    for row in &contacts {
        writer.contact(row).map_err(failed)?;
    }
    let states = found.as_ref().map_or(&[][..], |found| &found.states);
    for row in pose_rows(&recorded, states) {
        writer.pose(&row).map_err(failed)?;
    }
    let rows = writer.finish()?;
    Ok(MotionSummary { rows, moved: recorded.len() + held.len(), found, notices: remarks })
}

fn loaded_name(world: &World, id: BodyId) -> String {
    world.bodies.get(id.index()).map_or_else(String::new, |body| body.name.clone())
}

/// The bodies that files move.
#[derive(Default)]
struct Recording {
    /// Those that move freely, of glTF files first.
    recorded: Vec<RecordedBody>,
    /// How many are of glTF files.
    from_gltf: usize,
    /// Those that are moved from outside, by keyframes of the world.
    held: Vec<BodyId>,
}

/// Reads all files of poses, checks them, and puts the bodies where they begin.
fn read_recording(
    loaded: &LoadedScene,
    files: &MotionFiles,
    world: &mut World,
    remarks: &mut Vec<String>,
) -> Result<Recording, MotionImportError> {
    let Recording { mut recorded, mut from_gltf, mut held } = Recording::default();
    let sources =
        files.gltf.iter().map(|path| (path, true)).chain(files.poses.iter().map(|path| (path, false)));
    for (path, is_gltf) in sources {
        let (bodies, kinematic) = if is_gltf {
            let nodes = read_gltf_motion(path)?;
            let added = add_nodes(world, nodes, remarks);
            added.map_err(|fault| MotionImportError::Node { path: path.clone(), fault })?
        } else {
            (read_poses(loaded, world, path, files.z_up)?, Vec::new())
        };
        for mut body in bodies {
            let described = &world.bodies[body.body.index()];
            let name = described.name.clone();
            if recorded.iter().any(|other| other.body == body.body) {
                return Err(MotionImportError::Twice { path: path.clone(), body: name });
            }
            let motion = match described.motion {
                Motion::Free => None,
                Motion::Fixed => Some("fixed"),
                Motion::Keyframed(_) | Motion::Guided(_) => Some("moved by keyframes"),
            };
            if let Some(motion) = motion {
                return Err(MotionImportError::NotFree { path: path.clone(), body: name, motion });
            }
            let mass = described.mass;
            if !(mass > 0.0 && mass.is_finite()) {
                return Err(MotionImportError::NoMass { body: name, mass });
            }
            check_frames(&name, &mut body.frames, loaded.scene.acoustics.medium.sound_speed)
                .map_err(|error| MotionImportError::Recording { path: path.clone(), error })?;
            let is_held = kinematic.contains(&body.body);
            let keys =
                body.frames.iter().map(|Frame { time, pose, .. }| Keyframe { time: *time, pose: *pose });
            if let Some(track) = Track::try_new(keys.collect()).filter(|_| is_held) {
                world.bodies[body.body.index()].motion = Motion::Keyframed(track);
                held.push(body.body);
            } else if !body.frames.is_empty() {
                recorded.push(body);
                from_gltf += usize::from(is_gltf);
            }
        }
    }
    if recorded.is_empty() && held.is_empty() {
        let path = files.gltf.iter().chain(&files.poses).next().cloned().unwrap_or_default();
        return Err(MotionImportError::NothingMoves { path });
    }
    for RecordedBody { body, frames } in &recorded {
        let body = &mut world.bodies[body.index()];
        if body.life.birth <= 0.0 {
            body.pose = frames[0].pose;
        }
        (body.velocity, body.angular_velocity) = velocities(frames, 0);
    }
    Ok(Recording { recorded, from_gltf, held })
}

/// Bodies of a table of poses.
fn read_poses(
    loaded: &LoadedScene,
    world: &World,
    path: &Path,
    z_up: bool,
) -> Result<Vec<RecordedBody>, MotionImportError> {
    let named = |name: &str| world.body_named(name);
    let table = read_pose_table(path, world.bodies.len(), &named)?;
    let turn = turn(z_up);
    let mut bodies = Vec::with_capacity(table.bodies.len());
    for (id, frames) in table.bodies {
        let body = &world.bodies[id.index()];
        let centre = match table.position_of {
            PositionOf::CentreOfMass => DVec3::ZERO,
            PositionOf::Origin => centre_in_file(loaded, body).map_err(|reason| {
                MotionImportError::Centre { path: path.into(), body: body.name.clone(), reason }
            })?,
        };
        let frame = |frame: Frame| {
            let Pose { position, orientation } = frame.pose;
            // The axes of the body stay those of its file.
            let pose = Pose { position: turn * position, orientation: turn * orientation };
            let pose = Pose { position: pose.world_from_body(centre), ..pose };
            Frame { pose, ..frame }
        };
        bodies.push(RecordedBody { body: id, frames: frames.into_iter().map(frame).collect() });
    }
    Ok(bodies)
}

/// The rotation of a file to y up.
fn turn(z_up: bool) -> DQuat {
    if z_up { DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2) } else { DQuat::IDENTITY }
}

/// Centre of mass of a body of the scene in the frame of its shape or file \[m\]; zero for a body that the
/// scene does not describe by a geometry (a plane).
fn centre_in_file(loaded: &LoadedScene, body: &Body) -> Result<DVec3, GeometryError> {
    let copies = loaded.scene.bodies.iter().flat_map(|d| (0..d.count()).map(move |copy| (d, copy)));
    let Some((description, copy)) = copies.into_iter().find(|(d, copy)| d.copy_name(*copy) == body.name)
    else {
        return Ok(DVec3::ZERO);
    };
    // Sizes are drawn by chance; the body tells what its own is.
    let folder = loaded.path.parent().unwrap_or(Path::new(""));
    let geometry = load_geometry(folder, &description.reference(copy, 1.0))?;
    let factor = body.surface.bounding_radius() / geometry.surface.bounding_radius();
    Ok(geometry.mass.centre_of_mass * factor)
}

/// Bodies that could move, but stand still since no file names them.
fn unrecorded(world: &World, recorded: &[RecordedBody]) -> Option<String> {
    let is_left = |index: usize, body: &Body| {
        matches!(body.motion, Motion::Free) && !recorded.iter().any(|r| r.body.index() == index)
    };
    let left: Vec<&str> = world
        .bodies
        .iter()
        .enumerate()
        .filter(|(index, body)| is_left(*index, body))
        .map(|(_, body)| body.name.as_str())
        .collect();
    (!left.is_empty())
        .then(|| format!("not in the files, and so at rest where the scene starts them: {}", left.join(", ")))
}

/// Contacts of all lists, checked against the motion.
fn read_contacts(
    world: &World,
    recorded: &[RecordedBody],
    files: &MotionFiles,
    remarks: &mut Vec<String>,
) -> Result<Vec<ContactRow>, MotionImportError> {
    let named = |name: &str| world.body_named(name);
    let poses: Vec<PoseRow> = pose_rows(recorded, &[]).collect();
    let history = PoseHistory::try_new(&world.bodies, &poses)?;
    let pose_of = |id: BodyId, time: f64| {
        let body = &world.bodies[id.index()];
        let is_known = !matches!(body.motion, Motion::Free) || recorded.iter().any(|r| r.body == id);
        is_known.then(|| history.at(id, time))
    };
    let span = span(world, recorded);
    let turn = turn(files.z_up);
    let mut contacts = Vec::new();
    for path in &files.contacts {
        let mut rows = read_listed_contacts(path, world.bodies.len(), &named)?;
        if let Some(time) = time_outside(&rows) {
            return Err(MotionImportError::Time { path: path.clone(), time });
        }
        let refused = |fault| MotionImportError::Contact { path: path.clone(), fault };
        let offset = contacts.iter().map(|row: &ContactRow| row.impact_id).max().unwrap_or(0);
        for ListedContact { line, row, .. } in &mut rows {
            for vector in
                [&mut row.point, &mut row.normal, &mut row.velocity, &mut row.impulse_t, &mut row.couple]
            {
                *vector = turn * *vector;
            }
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
    let tracks = world.bodies.iter().filter_map(|body| match &body.motion {
        Motion::Keyframed(track) => Some(track.keys()),
        _ => None,
    });
    let keys = tracks.flat_map(|keys| [keys.first(), keys.last()]).flatten();
    let times = frames.map(|frame| frame.time).chain(keys.map(|key| key.time));
    times.fold([f64::INFINITY, 0.0], |[from, to], time| [time.min(from), time.max(to)])
}
