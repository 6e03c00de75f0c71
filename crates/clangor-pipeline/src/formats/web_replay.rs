//! A finished run as one file that the page replays: surfaces, motion, events and sound models.
//!
//! docs/format/replay.md describes the file. A player needs no simulation and no bake: it draws the poses,
//! sends the events to the real-time engine at their times, and places the listener anywhere.
//!
//! A body with impacts has up to two slots of the engine, because the acceleration field and the modes of
//! the ellipsoids that replace pieces have different frames. Differs from `render`: the parts that
//! [`event_schedule`](crate::stages::event_schedule) leaves out, and the near field.

mod events;
mod motion;
mod sounds;
mod surfaces;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId};
use clangor_core::contact::{ContactError, ContactSettings};
use clangor_core::realtime::event_row::ROW;
use clangor_core::sound_model::acceleration::model::AccelerationModel;
use clangor_core::sound_model::acceleration::model_evaluator::BankEvaluator;
use clangor_core::sound_model::files::tensor_file::TensorFileError;
use clangor_core::synthesis::Listener;
use clangor_core::synthesis::SoundModel;
use clangor_core::synthesis::modal::ModalSource;
use clangor_core::timeline::Timeline;
use safetensors::tensor::{Dtype, TensorView};
use serde_json::{Value, json};

use self::events::event_rows;
use self::motion::Motions;
use self::sounds::Sounds;
use self::surfaces::Surfaces;
use crate::formats::atomic_file::{OutputError, write_atomically};
use crate::stages::render::forces;

/// Version of the format: 2 has force histories, and rows that are longer by their number.
pub const VERSION: u32 = 2;
/// Poses per second \[Hz\].
pub const FRAME_RATE: f64 = 120.0;
/// Slots of the page's engine.
const MOST_SOUNDS: usize = 1024;

/// Reasons why a replay cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The contacts cannot be turned into forces.
    #[error(transparent)]
    Contact(#[from] ContactError),
    /// The sound model of a body cannot be encoded.
    #[error("the sound of \"{body}\" cannot be written: {source}")]
    Sound {
        /// The body.
        body: String,
        /// Why.
        source: TensorFileError,
    },
    /// The run needs more slots than the page has.
    #[error("{count} sounds of bodies are struck, and the page plays {MOST_SOUNDS}")]
    TooMany {
        /// Slots needed.
        count: usize,
    },
    /// The container cannot be encoded.
    #[error("the file cannot be made: {0}")]
    Container(#[from] safetensors::SafeTensorError),
    /// The file cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// Content of a replay.
pub struct Replay<'a> {
    /// All bodies of the run, in the order of their numbers.
    pub bodies: &'a [Body],
    /// Modal sources by body.
    pub ringing: &'a BTreeMap<BodyId, Arc<ModalSource>>,
    /// The whole run.
    pub timeline: &'a Timeline,
    /// Whether acceleration noise is included.
    pub clicks: bool,
    /// The sound model of each body.
    pub models: &'a [SoundModel],
    /// The acceleration model of a body with a field of its own.
    pub own_model: &'a dyn Fn(BodyId) -> Option<AccelerationModel>,
    /// The soundbank of ellipsoids.
    pub bank: Option<&'a BankEvaluator>,
    /// k = 2πf/c [1/m] at the highest frequency computed.
    pub max_wavenumber: f64,
    /// Settings of the contact forces.
    pub contact: &'a ContactSettings,
    /// Listeners of the scene.
    pub listeners: &'a [Listener],
    /// The scene as TOML; a player reads medium, floor, room and air from it.
    pub scene: &'a str,
    /// End of the run \[s\].
    pub duration: f64,
    /// Initial full-scale pressure \[Pa\].
    pub full_scale: f64,
}

/// Counts of what was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReplaySummary {
    /// Bodies.
    pub bodies: usize,
    /// Slots.
    pub sounds: usize,
    /// Rows of events.
    pub events: usize,
    /// Poses.
    pub poses: usize,
    /// Length of the file \[bytes\].
    pub bytes: usize,
}

/// Writes the file.
///
/// # Errors
/// [`ReplayError`]; the file appears only once it is complete.
pub fn write_replay(replay: &Replay<'_>, output: &Path) -> Result<ReplaySummary, ReplayError> {
    let (bytes, summary) = encode(replay)?;
    write_atomically(output, &bytes)?;
    Ok(summary)
}

/// The bytes of the file. The same run gives the same bytes.
///
/// # Errors
/// [`ReplayError`].
pub fn encode(replay: &Replay<'_>) -> Result<(Vec<u8>, ReplaySummary), ReplayError> {
    let Replay { bodies, timeline, .. } = *replay;
    let forces = forces(bodies, replay.ringing, timeline, replay.contact)?;
    let surfaces = Surfaces::of(bodies);
    let motions = Motions::of(bodies, &forces.poses, replay.duration);
    let sounds = Sounds::of(replay, &forces.pulses)?;
    if sounds.slots.len() > MOST_SOUNDS {
        return Err(ReplayError::TooMany { count: sounds.slots.len() });
    }
    let events = event_rows(&sounds, replay, &forces);
    let description = description(replay, &surfaces, &motions, &sounds);

    let mut arrays: Vec<(&str, Dtype, Vec<usize>, Vec<u8>)> = Vec::new();
    let mut add = |name, dtype, shape: &[usize], bytes| arrays.push((name, dtype, shape.to_vec(), bytes));
    let singles = |numbers: &[f32]| numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let integers = |numbers: &[u32]| numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    add(
        "events",
        Dtype::F64,
        &[events.len(), ROW],
        events.iter().flatten().flat_map(|x| x.to_le_bytes()).collect(),
    );
    add(
        "mesh.vertices",
        Dtype::F32,
        &[surfaces.vertices.len(), 3],
        singles(surfaces.vertices.as_flattened()),
    );
    add(
        "mesh.triangles",
        Dtype::U32,
        &[surfaces.triangles.len(), 3],
        integers(surfaces.triangles.as_flattened()),
    );
    add("mesh.ranges", Dtype::U32, &[surfaces.ranges.len(), 4], integers(surfaces.ranges.as_flattened()));
    add("poses", Dtype::F32, &[motions.rows.len(), 7], singles(motions.rows.as_flattened()));
    let mut ranges = Vec::new();
    let mut files = Vec::new();
    for slot in &sounds.slots {
        ranges.extend([files.len() as u32, slot.bytes.len() as u32]);
        files.extend_from_slice(&slot.bytes);
    }
    add("sounds.ranges", Dtype::U32, &[sounds.slots.len(), 2], integers(&ranges));
    add("sounds.bytes", Dtype::U8, &[files.len()], files);
    let views = arrays
        .iter()
        .map(|(name, dtype, shape, bytes)| Ok((*name, TensorView::new(*dtype, shape.clone(), bytes)?)))
        .collect::<Result<Vec<_>, safetensors::SafeTensorError>>()?;
    // One entry only: the order of several would differ from run to run.
    let header = [("clangor".to_string(), description.to_string())].into_iter().collect();
    let bytes = safetensors::serialize(views, Some(header))?;
    let summary = ReplaySummary {
        bodies: bodies.len(),
        sounds: sounds.slots.len(),
        events: events.len(),
        poses: motions.rows.len(),
        bytes: bytes.len(),
    };
    Ok((bytes, summary))
}

fn description(replay: &Replay<'_>, surfaces: &Surfaces, motions: &Motions, sounds: &Sounds) -> Value {
    let mut materials: BTreeMap<&str, usize> = BTreeMap::new();
    replay.bodies.iter().for_each(|body| _ = materials.insert(&body.material.name, 0));
    materials.values_mut().enumerate().for_each(|(at, index)| *index = at);
    let bodies: Vec<Value> = (0..replay.bodies.len())
        .map(|index| {
            let body = &replay.bodies[index];
            let mut value = surfaces.describe(index);
            let motion = &motions.bodies[index];
            value["name"] = json!(body.name);
            value["material"] = json!(materials.get(body.material.name.as_str()));
            value["birth_s"] = json!(body.life.birth);
            value["death_s"] = json!(Some(body.life.death).filter(|death| death.is_finite()));
            value["parent"] = json!(body.life.parent.map(|parent| parent.0));
            value["first_frame"] = json!(motion.first_frame);
            value["first_row"] = json!(motion.first_row);
            value["rows"] = json!(motion.rows);
            value
        })
        .collect();
    let listener = |listener: &Listener| {
        let ear = |receiver: usize| {
            listener.receiver_position(receiver.min(listener.receivers.len() - 1), 0.0).to_array()
        };
        json!({ "name": listener.name, "left": ear(0), "right": ear(1) })
    };
    let heard: Vec<_> = replay.listeners.iter().filter(|l| !l.receivers.is_empty()).map(listener).collect();
    json!({
        "kind": "replay",
        "version": VERSION,
        "program": format!("clangor {}", env!("CARGO_PKG_VERSION")),
        "duration_s": replay.duration,
        "frame_rate_hz": FRAME_RATE,
        "full_scale_pa": replay.full_scale,
        "scene": replay.scene,
        "listeners": heard,
        "materials": materials.keys().collect::<Vec<_>>(),
        "bodies": bodies,
        "sounds": sounds.slots.iter().map(sounds::Slot::describe).collect::<Vec<_>>(),
    })
}
