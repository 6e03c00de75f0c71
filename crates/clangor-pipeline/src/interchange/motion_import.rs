//! Motion that another program recorded becomes a timeline: poses, and contacts that are recorded too or are
//! found in the motion.

use std::path::{Path, PathBuf};

use clangor_core::body::{Body, BodyId, Motion, World};
use clangor_core::contact::{ContactError, PoseHistory};
use clangor_core::pose::Pose;
use clangor_core::scene::instantiate::GeometryError;
use clangor_core::timeline::{ContactRow, PoseRow, TimelineSink};
use glam::{DQuat, DVec3};

use super::gltf_bodies::{GltfBodyFault, add_nodes};
use crate::formats::contact_list::{ContactListError, ListedContact, read_listed_contacts};
use crate::formats::gltf_motion::{GltfMotionError, read_gltf_motion};
use crate::formats::pose_table::{PoseTableError, PositionOf, read_pose_table};
use crate::formats::timeline_file::{Origin, TimelineError, TimelineHeader, TimelineSummary, TimelineWriter};
use crate::motion::contact_checks::{ContactFault, check_clock, check_contacts, time_outside};
use crate::motion::impacts::{MotionImpacts, find_impacts};
use crate::motion::recording::{Frame, MAX_TIME, RecordedBody, RecordingError, check_frames, notices};
use crate::stages::load::{LoadedScene, load_geometry};

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

/// Why a recording could not be imported.
#[derive(Debug, thiserror::Error)]
pub enum MotionImportError {
    /// A glTF file is wrong.
    #[error(transparent)]
    Gltf(#[from] GltfMotionError),
    /// A node is no body.
    #[error("{path}, {fault}")]
    Node {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        fault: GltfBodyFault,
    },
    /// A table of poses is wrong.
    #[error(transparent)]
    Poses(#[from] PoseTableError),
    /// Frames are wrong.
    #[error("{path}, {error}")]
    Recording {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        error: RecordingError,
    },
    /// A contact list is wrong.
    #[error(transparent)]
    List(#[from] ContactListError),
    /// A contact is impossible.
    #[error("{path}, {fault}")]
    Contact {
        /// The list.
        path: PathBuf,
        /// What is wrong.
        fault: ContactFault,
    },
    /// A contact at a time that no timeline has.
    #[error("{path}: a contact is at t = {time} s; times run from 0 to {MAX_TIME} s")]
    Time {
        /// The list.
        path: PathBuf,
        /// The time \[s\].
        time: f64,
    },
    /// The poses are those of no body, or not finite.
    #[error(transparent)]
    Motion(#[from] ContactError),
    /// The centre of mass of a body whose origins are given is not known.
    #[error("{path} gives origins of {body}, whose centre of mass cannot be told: {reason}")]
    Centre {
        /// The table.
        path: PathBuf,
        /// The body.
        body: String,
        /// Why not.
        reason: GeometryError,
    },
    /// Nothing of the scene moves.
    #[error("{path} moves no body of the scene; nodes and rows belong to bodies by their names")]
    NothingMoves {
        /// The first file.
        path: PathBuf,
    },
    /// Two files move a body.
    #[error("{path} moves {body}, which another file moves too")]
    Twice {
        /// The later file.
        path: PathBuf,
        /// The body.
        body: String,
    },
    /// The scene moves the body, or holds it.
    #[error(
        "{path} moves {body}, which is {motion} in the scene; leave that out of the scene, or {body} out \
         of the file"
    )]
    NotFree {
        /// The file.
        path: PathBuf,
        /// The body.
        body: String,
        /// Fixed, or moved by keyframes.
        motion: &'static str,
    },
    /// A body without mass.
    #[error("{body} has a mass of {mass} kg; a body that others move needs a mass above 0")]
    NoMass {
        /// The body.
        body: String,
        /// Its mass \[kg\].
        mass: f64,
    },
    /// The timeline cannot be written.
    #[error(transparent)]
    Timeline(#[from] TimelineError),
    /// A row did not reach the timeline.
    #[error("cannot write {path}: {source}")]
    Row {
        /// The timeline.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
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
    let (recorded, from_gltf) = read_recording(loaded, files, &mut world, &mut remarks)?;
    let name = |id: BodyId| loaded_name(&world, id);
    remarks.extend(notices(&recorded, from_gltf, &name, world.gravity).iter().map(ToString::to_string));
    if files.z_up && files.poses.is_empty() && files.contacts.is_empty() {
        remarks.push(
            "--up z is for tables and contact lists; a glTF file has y up: export it with +Y up".into(),
        );
    }
    remarks.extend(unrecorded(&world, &recorded));
    let poses = pose_rows(&recorded);
    let v_min = loaded.scene.simulation.v_min;
    let (contacts, poses, found) = if files.contacts.is_empty() {
        let found = find_impacts(&world, &recorded, v_min);
        let mut poses = [poses, found.states.clone()].concat();
        // The state before an impact comes last at its time.
        poses.sort_by(|a, b| a.time.total_cmp(&b.time));
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
        (found.contacts.clone(), poses, Some(found))
    } else {
        (read_contacts(&world, &recorded, &poses, files, &mut remarks)?, poses, None)
    };
    let last = |times: &mut dyn Iterator<Item = f64>| times.fold(0.0, f64::max);
    let duration =
        last(&mut poses.iter().map(|row| row.time)).max(last(&mut contacts.iter().map(|row| row.time)));
    let header = header(loaded, world, duration);
    let mut writer = TimelineWriter::create(output, &header, replace)?;
    let failed = |source| MotionImportError::Row { path: output.into(), source };
    for row in &contacts {
        writer.contact(row).map_err(failed)?;
    }
    for row in &poses {
        writer.pose(row).map_err(failed)?;
    }
    let rows = writer.finish()?;
    Ok(MotionSummary { rows, moved: recorded.len(), found, notices: remarks })
}

fn loaded_name(world: &World, id: BodyId) -> String {
    world.bodies.get(id.index()).map_or_else(String::new, |body| body.name.clone())
}

fn header(loaded: &LoadedScene, world: World, duration: f64) -> TimelineHeader {
    let simulation = &loaded.scene.simulation;
    TimelineHeader {
        world,
        medium: loaded.scene.acoustics.medium,
        origin: Origin {
            solver: "recorded motion".into(),
            time_step: 0.0,
            duration,
            v_min: simulation.v_min,
            pose_rate: 0.0,
            raw_log: false,
            sleep: false,
            seed: simulation.seed,
            impact_modes: Vec::new(),
        },
        scene: Some(loaded.text.clone()),
    }
}

/// Reads all files of poses, checks them, and puts the bodies where they begin. The bodies of glTF files come
/// first; the second value is their number.
fn read_recording(
    loaded: &LoadedScene,
    files: &MotionFiles,
    world: &mut World,
    remarks: &mut Vec<String>,
) -> Result<(Vec<RecordedBody>, usize), MotionImportError> {
    let mut recorded: Vec<RecordedBody> = Vec::new();
    let mut from_gltf = 0;
    let sources =
        files.gltf.iter().map(|path| (path, true)).chain(files.poses.iter().map(|path| (path, false)));
    for (path, is_gltf) in sources {
        let bodies = if is_gltf {
            let nodes = read_gltf_motion(path)?;
            let added = add_nodes(world, nodes, remarks);
            added.map_err(|fault| MotionImportError::Node { path: path.clone(), fault })?
        } else {
            read_poses(loaded, world, path, files.z_up)?
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
                Motion::Keyframed(_) => Some("moved by keyframes"),
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
            if !body.frames.is_empty() {
                recorded.push(body);
                from_gltf += usize::from(is_gltf);
            }
        }
    }
    if recorded.is_empty() {
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
    Ok((recorded, from_gltf))
}

/// Bodies of a table of poses.
fn read_poses(
    loaded: &LoadedScene,
    world: &World,
    path: &Path,
    z_up: bool,
) -> Result<Vec<RecordedBody>, MotionImportError> {
    let named = |name: &str| world.bodies.iter().position(|b| b.name == name).map(|i| BodyId(i as u32));
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

/// Velocity [m/s] and angular velocity [rad/s] at a frame: the means of the intervals beside it.
fn velocities(frames: &[Frame], at: usize) -> (DVec3, DVec3) {
    let low = at.saturating_sub(1);
    let high = (at + 1).min(frames.len() - 1);
    let span = frames[high].time - frames[low].time;
    if span <= 0.0 {
        return (DVec3::ZERO, DVec3::ZERO);
    }
    let mut turn = frames[high].pose.orientation * frames[low].pose.orientation.inverse();
    if turn.w < 0.0 {
        turn = -turn;
    }
    ((frames[high].pose.position - frames[low].pose.position) / span, turn.to_scaled_axis() / span)
}

fn pose_rows(recorded: &[RecordedBody]) -> Vec<PoseRow> {
    let mut rows: Vec<PoseRow> = recorded
        .iter()
        .flat_map(|RecordedBody { body, frames }| {
            (0..frames.len()).map(move |at| {
                let Frame { time, pose, .. } = frames[at];
                let (velocity, angular_velocity) = velocities(frames, at);
                let Pose { position, orientation } = pose;
                PoseRow { time, body: *body, position, orientation, velocity, angular_velocity }
            })
        })
        .collect();
    rows.sort_by(|a, b| a.time.total_cmp(&b.time));
    rows
}

/// Contacts of all lists, checked against the motion.
fn read_contacts(
    world: &World,
    recorded: &[RecordedBody],
    poses: &[PoseRow],
    files: &MotionFiles,
    remarks: &mut Vec<String>,
) -> Result<Vec<ContactRow>, MotionImportError> {
    let named = |name: &str| world.bodies.iter().position(|b| b.name == name).map(|i| BodyId(i as u32));
    let history = PoseHistory::try_new(&world.bodies, poses)?;
    let pose_of = |id: BodyId, time: f64| {
        let body = &world.bodies[id.index()];
        let is_known = !matches!(body.motion, Motion::Free) || recorded.iter().any(|r| r.body == id);
        is_known.then(|| history.at(id, time))
    };
    let span = [poses.first(), poses.last()].map(|row| row.map_or(0.0, |row| row.time));
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
