//! Frames of glTF files and tables, kept in memory, and what they need of the scene.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use clangor_core::body::{Body, BodyId, Motion, World};
use clangor_core::pose::{Keyframe, Pose, Track};
use clangor_core::scene::instantiate::GeometryError;
use glam::DVec3;

use super::super::file_frame::FileFrame;
use super::led_bodies::{check_movable, is_of_scene};
use super::pose_rows::velocities;
use super::{MotionFiles, MotionImportError};
use crate::formats::gltf_motion::{GltfChoice, read_gltf_motion};
use crate::formats::named_bodies::NamedBodies;
use crate::formats::pose_table::{PositionOf, read_pose_table};
use crate::interchange::gltf_bodies::fault::GltfBodyFaults;
use crate::interchange::gltf_bodies::{NodeBodies, add_nodes};
use crate::motion::frame_checks::{FrameChecks, check_frames};
use crate::motion::quaternion_order::QuaternionOrder;
use crate::motion::recording::{Frame, RecordedBody};
use crate::stages::load::{LoadedScene, load_geometry};

/// The bodies that files move.
#[derive(Default)]
pub(super) struct Recording {
    /// Those that move freely, of glTF files first.
    pub(super) recorded: Vec<RecordedBody>,
    /// What was seen of them, in the same order.
    pub(super) checks: Vec<(BodyId, FrameChecks)>,
    /// Their files, in the same order.
    pub(super) paths: Vec<PathBuf>,
    /// How many are of glTF files.
    pub(super) from_gltf: usize,
    /// Those that are moved from outside, by keyframes of the world.
    pub(super) held: Vec<BodyId>,
    /// Diameter of the smallest body that has its size from a file and moves \[m\].
    pub(super) smallest: Option<f64>,
    /// All of them.
    known: BTreeSet<BodyId>,
}

/// What the glTF files of a recording have in common.
#[derive(Default)]
struct GltfFiles {
    /// For each file what became of its nodes.
    bodies: Vec<(PathBuf, NodeBodies)>,
    /// Whether one of them has an animation.
    has_animation: bool,
}

/// Reads all files of poses, checks them, and puts the bodies where they begin.
pub(super) fn read_recording(
    loaded: &LoadedScene,
    files: &MotionFiles,
    world: &mut World,
    remarks: &mut Vec<String>,
) -> Result<Recording, MotionImportError> {
    let mut recording = Recording::default();
    let mut gltf = read_gltf_files(loaded, files, world, remarks)?;
    // One number for each group of all files.
    let mut groups: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for (file, (path, nodes)) in gltf.bodies.iter_mut().enumerate() {
        for mut body in std::mem::take(&mut nodes.recorded) {
            body.group = body.group.map(|group| {
                let next = groups.len();
                *groups.entry((file, group)).or_insert(next)
            });
            let is_held = nodes.kinematic.contains(&body.body);
            recording.take(loaded, (world, files), (path, body), is_held)?;
        }
        let smallest = [recording.smallest, nodes.smallest].into_iter().flatten();
        recording.smallest = smallest.reduce(f64::min);
    }
    recording.from_gltf = recording.recorded.len();
    // The format holds the last value of a curve.
    let lives = |body: &&mut RecordedBody| world.bodies[body.body.index()].life.death.is_infinite();
    recording.recorded.iter_mut().filter(lives).for_each(RecordedBody::hold_last);
    for path in &files.poses {
        for body in read_poses(loaded, world, path, files)? {
            recording.take(loaded, (world, files), (path, body), false)?;
        }
    }
    if recording.recorded.is_empty() && recording.held.is_empty() {
        return Err(nothing_moves(files, gltf));
    }
    for RecordedBody { body, frames, .. } in &recording.recorded {
        start(&mut world.bodies[body.index()], frames);
    }
    Ok(recording)
}

/// Reads the glTF files and adds their nodes to the world.
fn read_gltf_files(
    loaded: &LoadedScene,
    files: &MotionFiles,
    world: &mut World,
    remarks: &mut Vec<String>,
) -> Result<GltfFiles, MotionImportError> {
    let materials = &loaded.scene.materials;
    let mut gltf = GltfFiles::default();
    let mut left_out = BTreeSet::new();
    let mut animations = Vec::new();
    let (leave_out, animation) = (&files.leave_out[..], files.animation.as_deref());
    let choice = GltfChoice { leave_out, animation, units: files.units() };
    let mut faults = GltfBodyFaults::default();
    for path in &files.gltf {
        let mut motion = read_gltf_motion(path, &choice)?;
        animations.append(&mut motion.animations);
        left_out.append(&mut motion.left_out);
        gltf.has_animation |= motion.has_animation;
        let mut nodes = add_nodes(world, materials, motion, remarks);
        faults.list.extend(nodes.faults.drain(..).map(|fault| (path.clone(), fault)));
        gltf.bodies.push((path.clone(), nodes));
    }
    if let Some(name) = files.leave_out.iter().find(|name| !left_out.contains(*name)) {
        return Err(MotionImportError::LeaveOut { name: name.clone() });
    }
    if let Some(name) = files.animation.as_ref().filter(|name| !animations.contains(name)) {
        return Err(MotionImportError::Animation { name: name.clone(), known: animations });
    }
    if faults.list.is_empty() {
        return Ok(gltf);
    }
    let used = loaded.world.bodies.iter().map(|body| &body.material).chain(materials);
    faults.materials = used.map(|material| material.name.clone()).collect();
    Err(MotionImportError::Nodes(faults))
}

/// Why nothing is recorded.
fn nothing_moves(files: &MotionFiles, gltf: GltfFiles) -> MotionImportError {
    let path = files.gltf.iter().chain(&files.poses).next().cloned().unwrap_or_default();
    if files.poses.is_empty() && !gltf.has_animation {
        return MotionImportError::NoAnimation { path };
    }
    let mut shown = gltf.bodies.into_iter().flat_map(|(_, nodes)| nodes.only_shown);
    match shown.next() {
        None => MotionImportError::NothingMoves { path },
        Some(node) => MotionImportError::OnlyShown { path, node, others: shown.count() },
    }
}

impl Recording {
    /// Checks the frames of a body and keeps them; `is_held` says that it is moved from outside.
    fn take(
        &mut self,
        loaded: &LoadedScene,
        (world, files): (&mut World, &MotionFiles),
        (path, mut body): (&Path, RecordedBody),
        is_held: bool,
    ) -> Result<(), MotionImportError> {
        let id = body.body;
        let described = &mut world.bodies[id.index()];
        if self.known.contains(&id) {
            return Err(MotionImportError::Twice { path: path.into(), body: described.name.clone() });
        }
        check_movable(described, path)?;
        let sound_speed = loaded.scene.acoustics.medium.sound_speed;
        let checks = FrameChecks::new(sound_speed, world.gravity, files.units());
        // The order of glTF is given.
        let checks = match files.poses.iter().any(|table| table == path) {
            true => {
                checks.with_order(QuaternionOrder::new(described.inertia, FileFrame::of(files.axes).turn()))
            }
            false => checks,
        };
        let checks = check_frames(&described.name, &mut body.frames, checks)
            .map_err(|error| MotionImportError::Recording { path: path.into(), error })?;
        let keys = body.frames.iter().map(|Frame { time, pose, .. }| Keyframe { time: *time, pose: *pose });
        if let Some(track) = Track::try_new(keys.collect()).filter(|_| is_held) {
            described.motion = Motion::Keyframed(track);
            self.held.push(id);
        } else if !body.frames.is_empty() {
            self.known.insert(id);
            self.recorded.push(body);
            self.checks.push((id, checks));
            self.paths.push(path.into());
        }
        Ok(())
    }
}

/// Starts a body as its first frames move it, without the hand that leads it in the scene.
pub(super) fn start(body: &mut Body, frames: &[Frame]) {
    let Some(first) = frames.first() else { return };
    if matches!(body.motion, Motion::Guided(_)) {
        body.motion = Motion::Free;
    }
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
    files: &MotionFiles,
) -> Result<Vec<RecordedBody>, MotionImportError> {
    let table = read_pose_table(path, &NamedBodies::of(world))?;
    let mut frame_of = FramesOfTable::new(world, files, table.position_of);
    let mut bodies = Vec::with_capacity(table.bodies.len());
    for (body, mut frames) in table.bodies {
        let described = &world.bodies[body.index()];
        frame_of.learn_centre(loaded, described, body, path)?;
        for frame in &mut frames {
            frame.time *= files.axes.time_unit.seconds;
            frame_of.place(body, frame);
        }
        let mut is_led = true;
        for frame in &frames {
            is_led = is_led && is_of_scene(described, frame, path)?;
        }
        if is_led {
            continue;
        }
        bodies.push(RecordedBody { body, frames, group: None });
    }
    Ok(bodies)
}

/// Turns poses as a table has them into those of centres of mass in metres, y up.
pub(super) struct FramesOfTable {
    file: FileFrame,
    position_of: PositionOf,
    /// Centre of mass of each body in the frame of its shape or file \[m\], once it is known.
    centres: Vec<Option<DVec3>>,
}

impl FramesOfTable {
    pub(super) fn new(world: &World, files: &MotionFiles, position_of: PositionOf) -> Self {
        FramesOfTable {
            file: FileFrame::of(files.axes),
            position_of,
            centres: vec![None; world.bodies.len()],
        }
    }

    /// What the positions of the table are.
    pub(super) fn set_position(&mut self, position_of: PositionOf) {
        self.position_of = position_of;
    }

    /// Finds the centre of mass of a body, before its first frame. It is looked for once.
    pub(super) fn learn_centre(
        &mut self,
        loaded: &LoadedScene,
        described: &Body,
        body: BodyId,
        path: &Path,
    ) -> Result<(), MotionImportError> {
        if self.position_of == PositionOf::Origin && self.centres[body.index()].is_none() {
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
        if centre == DVec3::ZERO && self.file.is_identity() {
            return;
        }
        let Pose { position, orientation } = frame.pose;
        let (position, orientation) = (self.file.place(position), self.file.orientation(orientation));
        let pose = Pose { position, orientation };
        frame.pose = Pose { position: pose.world_from_body(centre), ..pose };
    }
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
