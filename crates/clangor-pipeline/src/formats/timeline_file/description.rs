//! `timeline.json`: everything about a timeline but its rows.
//!
//! The structures mirror the file, not the library: the library may change without the format. Unknown keys
//! are rejected, so that a misspelt one is not ignored.

mod checks;
pub(super) mod decode;
pub(super) mod encode;
mod links;

use links::LinkFields;
use serde::{Deserialize, Serialize};

/// What the description of a timeline says, its meshes not yet read.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Description {
    format: String,
    version: u64,
    pub(super) program: String,
    units: Units,
    pub(super) contacts: TableFields,
    pub(super) poses: TableFields,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) fractures: Option<TableFields>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) forces: Option<TableFields>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) force_samples: Option<TableFields>,
    origin: OriginFields,
    medium: MediumFields,
    gravity: [f64; 3],
    bodies: Vec<BodyFields>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    links: Vec<LinkFields>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    scene: Option<String>,
}

/// What a table must hold.
#[derive(Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TableFields {
    pub(super) rows: u64,
    /// XXH3-128 of the file; left out by programs that do not compute it, and after the table is edited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) hash: Option<String>,
}

const FORMAT_NAME: &str = "clangor timeline";

/// Said for the reader of the file; nothing else is supported.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Units {
    length: String,
    mass: String,
    time: String,
    angle: String,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct OriginFields {
    solver: String,
    time_step: f64,
    duration: f64,
    v_min: f64,
    pose_rate: f64,
    raw_log: bool,
    sleep: bool,
    seed: u64,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    impact_modes: Vec<ImpactModesFields>,
}

/// A body that gave way in impacts, and the hash of its modal model.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ImpactModesFields {
    body: u32,
    model: String,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct MediumFields {
    density: f64,
    sound_speed: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BodyFields {
    name: String,
    surface: SurfaceFields,
    mass: Extended,
    /// Rows of the symmetric tensor.
    inertia: [[Extended; 3]; 3],
    edge_radius: f64,
    material: MaterialFields,
    motion: MotionFields,
    position: [f64; 3],
    orientation: [f64; 4],
    velocity: [f64; 3],
    angular_velocity: [f64; 3],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    life: Option<LifeFields>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    supports: Vec<SupportFields>,
}

/// What holds a body, in its frame.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SupportFields {
    region: RegionFields,
    kind: SupportKindFields,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
enum RegionFields {
    Ball { centre: [f64; 3], radius: f64 },
    Box { low: [f64; 3], high: [f64; 3] },
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
enum SupportKindFields {
    Clamped,
    Sprung { stiffness: [f64; 3], damping: [f64; 3] },
}

/// When a body exists; left out for one that is there from beginning to end.
#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LifeFields {
    birth: f64,
    death: Extended,
    parent: Option<u32>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
enum SurfaceFields {
    Sphere { radius: f64 },
    HalfSpace {},
    Plate { thickness: f64 },
    Mesh { hash: String, volume: f64 },
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct MaterialFields {
    name: String,
    density: f64,
    youngs_modulus: f64,
    poisson_ratio: f64,
    restitution: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    restitution_speed: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    rigid_restitution: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    yield_strength: Option<f64>,
    friction: f64,
    rolling_loss: f64,
    damping: DampingFields,
    tensile_strength: Option<f64>,
    fracture_energy: Option<f64>,
    source: String,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
enum DampingFields {
    LossFactor(f64),
    T60(f64),
    Rayleigh { alpha: f64, beta: f64, g: f64 },
    LossFactorTable(Vec<[f64; 2]>),
    T60Table(Vec<[f64; 2]>),
    Modes { t60: Vec<[f64; 2]>, otherwise: Box<DampingFields> },
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
enum MotionFields {
    Free,
    Fixed,
    Keyframed(Vec<KeyFields>),
    Guided { keys: Vec<KeyFields>, press: Option<f64>, let_go: Option<f64> },
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyFields {
    time: f64,
    position: [f64; 3],
    orientation: [f64; 4],
}

/// A number that may be infinite, which JSON has no numeral for.
#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a number or \"infinity\"")]
enum Extended {
    Finite(f64),
    Word(Infinite),
}

#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Infinite {
    Infinity,
}

impl From<f64> for Extended {
    fn from(value: f64) -> Self {
        if value == f64::INFINITY { Extended::Word(Infinite::Infinity) } else { Extended::Finite(value) }
    }
}

impl From<Extended> for f64 {
    fn from(value: Extended) -> Self {
        match value {
            Extended::Finite(value) => value,
            Extended::Word(Infinite::Infinity) => f64::INFINITY,
        }
    }
}

impl Description {
    /// Ends the simulated time \[s\] earlier.
    pub(super) fn cut(&mut self, duration: f64) {
        self.origin.duration = self.origin.duration.min(duration);
    }

    /// Makes the time at least this long \[s\].
    pub(super) fn extend(&mut self, duration: f64) {
        self.origin.duration = self.origin.duration.max(duration);
    }
}
