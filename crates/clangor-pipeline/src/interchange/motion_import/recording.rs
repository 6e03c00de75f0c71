//! Frames of glTF files and tables, kept in memory, and what they need of the scene.

use std::collections::BTreeMap;
use std::path::Path;

use clangor_core::body::{Body, BodyId, Motion, World};
use clangor_core::pose::{Keyframe, Pose, Track};
use clangor_core::scene::instantiate::GeometryError;
use glam::{DQuat, DVec3};

use super::pose_rows::velocities;
use super::{MotionFiles, MotionImportError};
use crate::formats::gltf_motion::read_gltf_motion;
use crate::formats::pose_table::{PositionOf, read_pose_table};
use crate::interchange::gltf_bodies::add_nodes;
use crate::motion::frame_checks::{FrameChecks, check_frames};
use crate::motion::recording::{Frame, RecordedBody};
use crate::stages::load::{LoadedScene, load_geometry};

/// The bodies that files move.
#[derive(Default)]
pub(super) struct Recording {
    /// Those that move freely, of glTF files first.
    pub(super) recorded: Vec<RecordedBody>,
    /// What was seen of them, in the same order.
    pub(super) checks: Vec<(BodyId, FrameChecks)>,
    /// How many are of glTF files.
    pub(super) from_gltf: usize,
    /// Those that are moved from outside, by keyframes of the world.
    pub(super) held: Vec<BodyId>,
}

/// Reads all files of poses, checks them, and puts the bodies where they begin.
pub(super) fn read_recording(
    loaded: &LoadedScene,
    files: &MotionFiles,
    world: &mut World,
    remarks: &mut Vec<String>,
) -> Result<Recording, MotionImportError> {
    let mut recording = Recording::default();
    let sources =
        files.gltf.iter().map(|path| (path, true)).chain(files.poses.iter().map(|path| (path, false)));
    let mut groups: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for (file, (path, is_gltf)) in sources.enumerate() {
        let (bodies, kinematic) = if is_gltf {
            let nodes = read_gltf_motion(path)?;
            let added = add_nodes(world, &loaded.scene.materials, nodes, remarks);
            added.map_err(|fault| MotionImportError::Node { path: path.clone(), fault })?
        } else {
            (read_poses(loaded, world, path, files.z_up)?, Vec::new())
        };
        for mut body in bodies {
            let id = body.body;
            // One number for each group of all files.
            body.group = body.group.map(|group| {
                let next = groups.len();
                *groups.entry((file, group)).or_insert(next)
            });
            let name = world.bodies[id.index()].name.clone();
            if recording.recorded.iter().any(|other| other.body == id) {
                return Err(MotionImportError::Twice { path: path.clone(), body: name });
            }
            check_movable(&world.bodies[id.index()], path)?;
            let checks = FrameChecks::new(loaded.scene.acoustics.medium.sound_speed, world.gravity);
            let checks = check_frames(&name, &mut body.frames, checks)
                .map_err(|error| MotionImportError::Recording { path: path.clone(), error })?;
            let is_held = kinematic.contains(&id);
            // The format holds the last value of a curve.
            if is_gltf && !is_held && world.bodies[id.index()].life.death.is_infinite() {
                body.hold_last();
            }
            let keys =
                body.frames.iter().map(|Frame { time, pose, .. }| Keyframe { time: *time, pose: *pose });
            if let Some(track) = Track::try_new(keys.collect()).filter(|_| is_held) {
                world.bodies[id.index()].motion = Motion::Keyframed(track);
                recording.held.push(id);
            } else if !body.frames.is_empty() {
                recording.recorded.push(body);
                recording.checks.push((id, checks));
                recording.from_gltf += usize::from(is_gltf);
            }
        }
    }
    if recording.recorded.is_empty() && recording.held.is_empty() {
        let path = files.gltf.iter().chain(&files.poses).next().cloned().unwrap_or_default();
        return Err(MotionImportError::NothingMoves { path });
    }
    for RecordedBody { body, frames, .. } in &recording.recorded {
        start(&mut world.bodies[body.index()], frames);
    }
    Ok(recording)
}

/// Refuses a body that the scene holds or moves, and one that no impulse could move.
pub(super) fn check_movable(body: &Body, path: &Path) -> Result<(), MotionImportError> {
    let motion = match body.motion {
        Motion::Free => None,
        Motion::Fixed => Some("fixed"),
        Motion::Keyframed(_) | Motion::Guided(_) => Some("moved by keyframes"),
    };
    let name = || body.name.clone();
    if let Some(motion) = motion {
        return Err(MotionImportError::NotFree { path: path.into(), body: name(), motion });
    }
    let mass = body.mass;
    if mass > 0.0 && mass.is_finite() {
        Ok(())
    } else {
        Err(MotionImportError::NoMass { body: name(), mass })
    }
}

/// Starts a body as its first frames move it.
pub(super) fn start(body: &mut Body, frames: &[Frame]) {
    let Some(first) = frames.first() else { return };
    if body.life.birth <= 0.0 {
        body.pose = first.pose;
    }
    (body.velocity, body.angular_velocity) = velocities(frames, 0);
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
    let mut frame_of = FramesOfTable::new(world, z_up, table.position_of);
    let mut bodies = Vec::with_capacity(table.bodies.len());
    for (body, mut frames) in table.bodies {
        frame_of.learn_centre(loaded, &world.bodies[body.index()], body, path)?;
        frames.iter_mut().for_each(|frame| frame_of.place(body, frame));
        bodies.push(RecordedBody { body, frames, group: None });
    }
    Ok(bodies)
}

/// Turns poses as a table has them into those of centres of mass, y up.
pub(super) struct FramesOfTable {
    turn: DQuat,
    position_of: PositionOf,
    /// Centre of mass of each body in the frame of its shape or file \[m\], once it is known.
    centres: Vec<Option<DVec3>>,
}

impl FramesOfTable {
    pub(super) fn new(world: &World, z_up: bool, position_of: PositionOf) -> Self {
        FramesOfTable { turn: turn(z_up), position_of, centres: vec![None; world.bodies.len()] }
    }

    /// What the positions of the table are.
    pub(super) fn set_position(&mut self, position_of: PositionOf) {
        self.position_of = position_of;
    }

    /// Finds the centre of mass of a body, before its first frame.
    pub(super) fn learn_centre(
        &mut self,
        loaded: &LoadedScene,
        described: &Body,
        body: BodyId,
        path: &Path,
    ) -> Result<(), MotionImportError> {
        if self.position_of == PositionOf::Origin {
            let centre = centre_in_file(loaded, described).map_err(|reason| MotionImportError::Centre {
                path: path.into(),
                body: described.name.clone(),
                reason,
            })?;
            self.centres[body.index()] = Some(centre);
        }
        Ok(())
    }

    /// Turns one frame. The axes of the body stay those of its file.
    pub(super) fn place(&self, body: BodyId, frame: &mut Frame) {
        let centre = self.centres[body.index()].unwrap_or(DVec3::ZERO);
        if centre == DVec3::ZERO && self.turn == DQuat::IDENTITY {
            return;
        }
        let Pose { position, orientation } = frame.pose;
        let pose = Pose { position: self.turn * position, orientation: self.turn * orientation };
        frame.pose = Pose { position: pose.world_from_body(centre), ..pose };
    }
}

/// The rotation of a file to y up.
pub(super) fn turn(z_up: bool) -> DQuat {
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
    if let Some(centre) = description.given_mass.centre_of_mass {
        return Ok(centre);
    }
    // Sizes are drawn by chance; the body tells what its own is.
    let folder = loaded.path.parent().unwrap_or(Path::new(""));
    let geometry = load_geometry(folder, &description.reference(copy, 1.0))?;
    let factor = body.surface.bounding_radius() / geometry.surface.bounding_radius();
    Ok(geometry.mass.centre_of_mass * factor)
}
