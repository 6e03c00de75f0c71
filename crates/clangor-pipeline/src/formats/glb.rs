//! The motion of a scene as a binary glTF file (GLB), to be looked at in Blender or any viewer.
//!
//! One node per body, with its surface and one animation of translations and rotations. Poses are sampled at
//! a common rate, linearly between rows: a picture, not a record; sound needs the timeline. Spheres become
//! icospheres of about 500 triangles, half-spaces square plates that reach under the whole motion. Metres and
//! y up in both formats. A body that is not alive has the scale 0, which the format has for what is not to be
//! seen.

pub(crate) mod container;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clangor_core::body::{Body, Life, Motion, Surface};
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::pose::Pose;
use clangor_core::shape::{Form, Shape, ShapeError};
use clangor_core::timeline::PoseRow;
use glam::DVec3;
use serde_json::{Value, json};

use crate::formats::atomic_file::{OutputError, write_atomically};
use crate::formats::timeline_file::TimelineError;
use container::{Container, container_bytes};

/// Pictures per second where none are chosen \[Hz\].
pub const DEFAULT_RATE: f64 = 120.0;

/// Why a GLB file could not be written.
#[derive(Debug, thiserror::Error)]
pub enum GlbError {
    /// The rate is not positive, or more than a viewer can use.
    #[error("{rate} pictures per second cannot be exported; choose 1 to 10 000 Hz")]
    Rate {
        /// The rate \[Hz\].
        rate: f64,
    },
    /// The poses could not be read.
    #[error(transparent)]
    Rows(#[from] TimelineError),
    /// A pose of a body that is not in the world.
    #[error("a pose names body {body}, but there are {bodies}")]
    Body {
        /// The body named.
        body: u32,
        /// Bodies there are.
        bodies: usize,
    },
    /// A sphere too small or large for a mesh.
    #[error(transparent)]
    Sphere(#[from] ShapeError),
    /// The format cannot hold so much.
    #[error(
        "{path} would have {bytes} bytes, more than the 4 GiB that GLB can hold; lower the rate or cut the \
         time"
    )]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Bytes it would have.
        bytes: u64,
    },
    /// The file could not be put in place.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// What an exported file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GlbSummary {
    /// Bodies.
    pub nodes: usize,
    /// Bodies that move.
    pub animated: usize,
    /// Instants of the animation.
    pub frames: usize,
}

/// Writes `bodies`, all that ever were, and their motion by `poses`, `rate` pictures per second
/// [`DEFAULT_RATE`].
///
/// `poses` come in order of time as a timeline has them. A body without any moves by its track if it is
/// keyframed, else it stands still.
///
/// # Errors
/// [`GlbError`]; no file is left then.
pub fn write_glb(
    path: &Path,
    bodies: &[Body],
    poses: impl Iterator<Item = Result<PoseRow, TimelineError>>,
    rate: f64,
) -> Result<GlbSummary, GlbError> {
    if !(1.0..=10_000.0).contains(&rate) {
        return Err(GlbError::Rate { rate });
    }
    let tracks = sample(path, bodies, poses, rate)?;
    let mut out = Container::default();
    let frames = tracks.iter().map(|t| t.poses.len()).max().unwrap_or(0);
    let reach = reach(bodies, &tracks);
    let meshes = Meshes::write(&mut out, bodies, reach)?;
    let (mut channels, mut samplers) = write_animation(&mut out, &tracks, frames, rate);
    write_lives(&mut out, bodies, &mut channels, &mut samplers);
    let animated = tracks.iter().filter(|t| t.moves).count();
    let nodes: Vec<Value> = bodies
        .iter()
        .zip(&meshes.of_body)
        .map(|(body, mesh)| {
            let mut node = json!({
                "name": body.name,
                "mesh": mesh,
                "translation": body.pose.position.to_array(),
                "rotation": body.pose.orientation.normalize().to_array(),
            });
            if body.life.birth > 0.0 {
                node["scale"] = json!([0.0, 0.0, 0.0]);
            }
            node
        })
        .collect();
    let mut document = json!({
        "asset": { "version": "2.0", "generator": concat!("Clangor ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "name": "scene", "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": meshes.meshes,
        "materials": meshes.materials,
        "accessors": out.accessors,
        "bufferViews": out.views,
        "buffers": [{ "byteLength": out.bytes.len() }],
    });
    if !channels.is_empty() {
        document["animations"] = json!([{ "name": "motion", "channels": channels, "samplers": samplers }]);
    }
    // The format forbids empty lists.
    if let Some(fields) = document.as_object_mut() {
        fields.retain(|_, value| value.as_array().is_none_or(|list| !list.is_empty()));
        if out.bytes.is_empty() {
            fields.remove("buffers");
        }
    }
    write_atomically(path, &container_bytes(path, &document, out.bytes)?)?;
    Ok(GlbSummary { nodes: bodies.len(), animated, frames })
}

/// A body's poses at the common instants.
struct Sampled {
    poses: Vec<Pose>,
    moves: bool,
}

/// Brings rows to the instants k / rate.
fn sample(
    path: &Path,
    bodies: &[Body],
    rows: impl Iterator<Item = Result<PoseRow, TimelineError>>,
    rate: f64,
) -> Result<Vec<Sampled>, GlbError> {
    let mut tracks: Vec<Vec<Pose>> = vec![Vec::new(); bodies.len()];
    let mut latest: Vec<(f64, Pose)> = bodies.iter().map(|b| (b.life.birth, b.pose)).collect();
    let mut has_rows = vec![false; bodies.len()];
    let mut end: f64 = 0.0;
    for row in rows {
        let row = row?;
        let body = row.body.index();
        if body >= bodies.len() {
            return Err(GlbError::Body { body: row.body.0, bodies: bodies.len() });
        }
        end = end.max(row.time);
        // A wrong time must not fill the memory: a body's translation and rotation take 28 bytes an instant.
        let bytes = 28.0 * end * rate;
        if bytes > f64::from(u32::MAX) {
            return Err(GlbError::TooLarge { path: path.into(), bytes: bytes as u64 });
        }
        let (time, pose) = latest[body];
        let next = Pose { position: row.position, orientation: row.orientation.normalize() };
        if has_rows[body] && row.time <= time {
            // Rows of impacts come a little late; their instants have been passed.
            continue;
        }
        has_rows[body] = true;
        let track = &mut tracks[body];
        while track.len() as f64 / rate <= row.time {
            let instant = track.len() as f64 / rate;
            let s = if row.time > time { (instant - time) / (row.time - time) } else { 1.0 };
            track.push(pose.between(&next, s.clamp(0.0, 1.0)));
        }
        latest[body] = (row.time, next);
    }
    let keyed_end = bodies.iter().filter_map(|b| match &b.motion {
        Motion::Keyframed(track) => track.keys().last().map(|k| k.time),
        _ => None,
    });
    let end = if end > 0.0 { end } else { keyed_end.fold(0.0, f64::max) };
    let frames = (end * rate).ceil() as usize + 1;
    let sampled = bodies.iter().zip(tracks).zip(latest).zip(has_rows);
    Ok(sampled
        .map(|(((body, mut poses), (_, last)), has_rows)| {
            for frame in poses.len()..frames {
                poses.push(match &body.motion {
                    Motion::Keyframed(track) if !has_rows => track.sample(frame as f64 / rate).0,
                    _ => last,
                });
            }
            finish_track(body, poses)
        })
        .collect())
}

/// Keeps quaternions on one side, as viewers interpolate their components; a body that never moves needs no
/// frames.
fn finish_track(body: &Body, mut poses: Vec<Pose>) -> Sampled {
    let mut last = body.pose.orientation;
    for pose in &mut poses {
        if pose.orientation.dot(last) < 0.0 {
            pose.orientation = -pose.orientation;
        }
        last = pose.orientation;
    }
    let near = |pose: &Pose| {
        pose.position.distance(body.pose.position) < STILL
            && 1.0 - pose.orientation.dot(body.pose.orientation).abs() < STILL
    };
    let moves = !poses.iter().all(near);
    Sampled { poses: if moves { poses } else { Vec::new() }, moves }
}

/// A body whose pose stays this close to where it began, \[m\] and 1 − cos of half the angle, does not move.
const STILL: f64 = 1e-7;

/// How far from the origin anything finite gets \[m\].
fn reach(bodies: &[Body], tracks: &[Sampled]) -> f64 {
    bodies
        .iter()
        .zip(tracks)
        .filter(|(body, _)| !body.surface.is_plane())
        .flat_map(|(body, track)| {
            let radius = body.surface.bounding_radius();
            let poses = std::iter::once(&body.pose).chain(&track.poses);
            poses.map(move |pose| pose.position.length() + radius)
        })
        .fold(0.5, f64::max)
}

/// The meshes and materials of the bodies; equal surfaces of equal material are shared.
struct Meshes {
    meshes: Vec<Value>,
    materials: Vec<Value>,
    of_body: Vec<usize>,
}

impl Meshes {
    fn write(out: &mut Container, bodies: &[Body], reach: f64) -> Result<Self, GlbError> {
        let mut all = Meshes { meshes: Vec::new(), materials: Vec::new(), of_body: Vec::new() };
        let mut materials: BTreeMap<&str, usize> = BTreeMap::new();
        let mut surfaces: BTreeMap<(*const Surface, usize), usize> = BTreeMap::new();
        let mut spheres: BTreeMap<(u64, usize), usize> = BTreeMap::new();
        for body in bodies {
            let count = materials.len();
            let material = *materials.entry(body.material.name.as_str()).or_insert(count);
            if material == count {
                all.materials.push(material_json(&body.material.name, count));
            }
            let known = match &*body.surface {
                Surface::Sphere { radius } => {
                    spheres.entry((radius.to_bits(), material)).or_insert(usize::MAX)
                }
                _ => surfaces.entry((Arc::as_ptr(&body.surface), material)).or_insert(usize::MAX),
            };
            if *known == usize::MAX {
                *known = all.meshes.len();
                let mesh = match &*body.surface {
                    Surface::Sphere { radius } => {
                        Shape::try_new(Form::Sphere { radius: *radius }, Some(0.25 * radius))?.mesh()
                    }
                    Surface::HalfSpace | Surface::Plate { .. } => {
                        plate(2.0 * (reach + body.pose.position.length()))
                    }
                    Surface::Mesh(surface) => surface.mesh.clone(),
                };
                all.meshes.push(out.mesh(&body.name, &mesh, Some(material)));
            }
            all.of_body.push(*known);
        }
        Ok(all)
    }
}

/// A square in the plane y = 0 that faces +y, of this width \[m\].
fn plate(width: f64) -> TriMesh {
    let h = 0.5 * width;
    let vertices = [(-h, -h), (-h, h), (h, h), (h, -h)].map(|(x, z)| DVec3::new(x, 0.0, z)).to_vec();
    TriMesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]] }
}

/// A material that can be told from its neighbours: hues by the golden angle.
fn material_json(name: &str, index: usize) -> Value {
    let hue = (index as f64 * 0.618_034).fract() * std::f64::consts::TAU;
    let channel = |shift: f64| 0.5 + 0.25 * (hue + shift).cos();
    json!({
        "name": name,
        "doubleSided": true,
        "pbrMetallicRoughness": {
            "baseColorFactor": [channel(0.0), channel(-2.094), channel(2.094), 1.0],
            "metallicFactor": 0.0,
            "roughnessFactor": 0.6,
        },
    })
}

/// Channels and samplers of the one animation.
fn write_animation(
    out: &mut Container,
    tracks: &[Sampled],
    frames: usize,
    rate: f64,
) -> (Vec<Value>, Vec<Value>) {
    let (mut channels, mut samplers) = (Vec::new(), Vec::new());
    if frames == 0 {
        return (channels, samplers);
    }
    let times: Vec<f32> = (0..frames).map(|k| (k as f64 / rate) as f32).collect();
    let input = out.floats(&times, "SCALAR", true);
    for (node, track) in tracks.iter().enumerate().filter(|(_, t)| t.moves) {
        let positions: Vec<f32> =
            track.poses.iter().flat_map(|p| p.position.to_array().map(|x| x as f32)).collect();
        let rotations: Vec<f32> =
            track.poses.iter().flat_map(|p| p.orientation.to_array().map(|x| x as f32)).collect();
        for (values, shape, target) in [(positions, "VEC3", "translation"), (rotations, "VEC4", "rotation")] {
            let output = out.floats(&values, shape, false);
            channels.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": target } }));
            samplers.push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
        }
    }
    (channels, samplers)
}

/// Channels and samplers that show each body while it lives.
fn write_lives(out: &mut Container, bodies: &[Body], channels: &mut Vec<Value>, samplers: &mut Vec<Value>) {
    for (node, body) in bodies.iter().enumerate() {
        let Life { birth, death, .. } = body.life;
        let mut keys = vec![(0.0_f32, if birth > 0.0 { 0.0_f32 } else { 1.0 })];
        keys.extend((birth > 0.0).then_some((birth as f32, 1.0)));
        keys.extend(death.is_finite().then_some((death as f32, 0.0)));
        // Times must increase; a body that dies as it is born is never seen.
        keys.dedup_by(|later, earlier| later.0 <= earlier.0);
        if keys.len() == 1 {
            continue;
        }
        let times: Vec<f32> = keys.iter().map(|(time, _)| *time).collect();
        let scales: Vec<f32> = keys.iter().flat_map(|(_, scale)| [*scale; 3]).collect();
        let input = out.floats(&times, "SCALAR", true);
        let output = out.floats(&scales, "VEC3", false);
        channels.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": "scale" } }));
        samplers.push(json!({ "input": input, "output": output, "interpolation": "STEP" }));
    }
}
