//! A finished run as one file that the page replays: surfaces, motion, impacts, and what sounds in them.
//!
//! docs/format/replay.md describes the file. Nothing in it has to be simulated or baked: whoever plays it
//! draws the poses, hands the events to the live engine as their time comes, and may listen from anywhere.
//!
//! A body that is struck has up to two slots of the engine, since fields and modes of the ellipsoids that
//! stand for pieces have frames of their own. Differs from `render`: what
//! [`live_score`](crate::stages::event_schedule) leaves out, and close to a body its far field.

mod motion;
mod sounds;
mod surfaces;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId};
use clangor_core::contact::{ContactError, ContactSettings};
use clangor_core::sound_model::SoundModel;
use clangor_core::sound_model::acceleration::model::AccelerationModel;
use clangor_core::sound_model::acceleration::model_evaluator::BankEvaluator;
use clangor_core::sound_model::files::tensor_file::TensorFileError;
use clangor_core::synthesis::Listener;
use clangor_core::synthesis::modal::ModalSource;
use clangor_core::timeline::Timeline;
use safetensors::tensor::{Dtype, TensorView};
use serde_json::{Value, json};

use self::motion::Motions;
use self::sounds::Sounds;
use self::surfaces::Surfaces;
use crate::formats::atomic_file::{OutputError, write_atomically};
use crate::stages::render::forces;

/// Version of the format.
pub const VERSION: u32 = 1;
/// Poses per second \[Hz\].
pub const FRAME_RATE: f64 = 120.0;
/// Numbers of an event.
const STRIDE: usize = 24;
/// Slots that the engine of the page has.
const MOST_SOUNDS: usize = 1024;

/// Why no file could be written.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The contacts cannot be turned into forces.
    #[error(transparent)]
    Contact(#[from] ContactError),
    /// What a body sounds like cannot be written.
    #[error("the sound of \"{body}\" cannot be written: {source}")]
    Sound {
        /// The body.
        body: String,
        /// Why.
        source: TensorFileError,
    },
    /// More than the page plays.
    #[error("{count} sounds of bodies are struck, and the page plays {MOST_SOUNDS}")]
    TooMany {
        /// How many.
        count: usize,
    },
    /// The container cannot hold it.
    #[error("the file cannot be made: {0}")]
    Container(#[from] safetensors::SafeTensorError),
    /// The file could not be put in place.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// What goes into the file.
pub struct Replay<'a> {
    /// All that ever were.
    pub bodies: &'a [Body],
    /// What rings, with its modes.
    pub ringing: &'a BTreeMap<BodyId, Arc<ModalSource>>,
    /// Whether impacts put no more energy into modes than the motion lost.
    pub limit_energy: bool,
    /// The whole run.
    pub timeline: &'a Timeline,
    /// Whether clicks are heard.
    pub clicks: bool,
    /// The sound model of each body.
    pub models: &'a [SoundModel],
    /// The model of a body that clicks by a field of its own.
    pub own_model: &'a dyn Fn(BodyId) -> Option<AccelerationModel>,
    /// The ellipsoids that stand for others.
    pub bank: Option<&'a BankEvaluator>,
    /// k = 2πf/c [1/m] of the highest frequency that is heard.
    pub max_wavenumber: f64,
    /// How impacts become forces.
    pub contact: &'a ContactSettings,
    /// Who may listen.
    pub listeners: &'a [Listener],
    /// The scene's text, of which medium, floor, room and air count.
    pub scene: &'a str,
    /// End of the run \[s\].
    pub duration: f64,
    /// Pressure that is as loud as can be \[Pa\], to begin with.
    pub full_scale: f64,
}

/// What was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReplaySummary {
    /// Bodies.
    pub bodies: usize,
    /// Slots.
    pub sounds: usize,
    /// Events.
    pub events: usize,
    /// Poses.
    pub poses: usize,
    /// Length of the file.
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
    let forces = forces(bodies, timeline, replay.contact)?;
    let surfaces = Surfaces::of(bodies);
    let motions = Motions::of(bodies, &forces.poses, replay.duration);
    let sounds = Sounds::of(replay, &forces.pulses)?;
    if sounds.slots.len() > MOST_SOUNDS {
        return Err(ReplayError::TooMany { count: sounds.slots.len() });
    }
    let events = sounds.events(replay, &forces);
    let description = description(replay, &surfaces, &motions, &sounds);

    let mut arrays: Vec<(&str, Dtype, Vec<usize>, Vec<u8>)> = Vec::new();
    let mut add = |name, dtype, shape: &[usize], bytes| arrays.push((name, dtype, shape.to_vec(), bytes));
    let singles = |numbers: &[f32]| numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let integers = |numbers: &[u32]| numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    add(
        "events",
        Dtype::F64,
        &[events.len(), STRIDE],
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
    json!({
        "kind": "replay",
        "version": VERSION,
        "program": format!("clangor {}", env!("CARGO_PKG_VERSION")),
        "duration_s": replay.duration,
        "frame_rate_hz": FRAME_RATE,
        "full_scale_pa": replay.full_scale,
        "scene": replay.scene,
        "listeners": replay.listeners.iter().filter(|l| !l.receivers.is_empty()).map(listener).collect::<Vec<_>>(),
        "materials": materials.keys().collect::<Vec<_>>(),
        "bodies": bodies,
        "sounds": sounds.slots.iter().map(sounds::Slot::describe).collect::<Vec<_>>(),
    })
}
