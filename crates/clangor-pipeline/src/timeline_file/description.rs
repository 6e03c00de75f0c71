//! `timeline.json`: everything about a timeline but its rows.
//!
//! The structures mirror the file, not the library: the library may change without the format. Unknown keys are
//! refused, so that a misspelt one is not ignored.

mod checked;

pub(super) use checked::{check_json, read};

use std::collections::BTreeMap;
use std::sync::Arc;

use clangor::body::{Body, Link, Motion, SpringEnd, Surface};
use clangor::material::Damping;
use clangor::pose::Keyframe;
use serde::{Deserialize, Serialize};

use super::{FORMAT_VERSION, TimelineHeader, hash, surface_file};

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
    /// XXH3-128 of the file; left out by programs that do not compute it, and by whoever edits the table.
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
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
enum SurfaceFields {
    Sphere { radius: f64 },
    HalfSpace {},
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
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
enum MotionFields {
    Free,
    Fixed,
    Keyframed(Vec<KeyFields>),
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyFields {
    time: f64,
    position: [f64; 3],
    orientation: [f64; 4],
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
enum LinkFields {
    Hang { body: u32, anchor: [f64; 3] },
    Spring { body: u32, to: SpringEndFields, rest_length: f64, stiffness: f64, damping: f64 },
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
enum SpringEndFields {
    Point([f64; 3]),
    Body(u32),
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

/// A description and the content of the mesh files that it names, by hash.
pub(super) fn describe(header: &TimelineHeader) -> (Description, BTreeMap<String, Vec<u8>>) {
    let mut files = BTreeMap::new();
    // Copies of a body share their surface: each is hashed once.
    let mut hashed: Vec<(*const Surface, String)> = Vec::new();
    let mut bodies = Vec::new();
    for body in &header.world.bodies {
        let surface = match &*body.surface {
            Surface::Sphere { radius } => SurfaceFields::Sphere { radius: *radius },
            Surface::HalfSpace => SurfaceFields::HalfSpace {},
            Surface::Mesh(surface) => {
                let address = Arc::as_ptr(&body.surface);
                let known = hashed.iter().rev().find(|(a, _)| *a == address).map(|(_, hash)| hash.clone());
                let hash = known.unwrap_or_else(|| {
                    let bytes = surface_file::to_bytes(surface);
                    let name = hash::of(&bytes);
                    files.insert(name.clone(), bytes);
                    hashed.push((address, name.clone()));
                    name
                });
                SurfaceFields::Mesh { hash, volume: surface.volume }
            }
        };
        bodies.push(body_fields(body, surface));
    }
    let origin = &header.origin;
    let description = Description {
        format: FORMAT_NAME.into(),
        version: FORMAT_VERSION.into(),
        program: concat!("clangor ", env!("CARGO_PKG_VERSION")).into(),
        units: Units { length: "m".into(), mass: "kg".into(), time: "s".into(), angle: "rad".into() },
        contacts: TableFields::default(),
        poses: TableFields::default(),
        origin: OriginFields {
            solver: origin.solver.clone(),
            time_step: origin.time_step,
            duration: origin.duration,
            v_min: origin.v_min,
            pose_rate: origin.pose_rate,
            raw_log: origin.raw_log,
            sleep: origin.sleep,
            seed: origin.seed,
        },
        medium: MediumFields { density: header.medium.density, sound_speed: header.medium.sound_speed },
        gravity: header.world.gravity.to_array(),
        bodies,
        links: header.world.links.iter().map(link_fields).collect(),
        scene: header.scene.clone(),
    };
    (description, files)
}

fn body_fields(body: &Body, surface: SurfaceFields) -> BodyFields {
    let material = &body.material;
    BodyFields {
        name: body.name.clone(),
        surface,
        mass: body.mass.into(),
        inertia: body.inertia.transpose().to_cols_array_2d().map(|row| row.map(Extended::from)),
        edge_radius: body.edge_radius,
        material: MaterialFields {
            name: material.name.clone(),
            density: material.density,
            youngs_modulus: material.youngs_modulus,
            poisson_ratio: material.poisson_ratio,
            restitution: material.restitution,
            friction: material.friction,
            rolling_loss: material.rolling_loss,
            damping: match material.damping {
                Damping::LossFactor(eta) => DampingFields::LossFactor(eta),
                Damping::T60(time) => DampingFields::T60(time),
            },
            tensile_strength: material.tensile_strength,
            fracture_energy: material.fracture_energy,
            source: material.source.clone(),
        },
        motion: match &body.motion {
            Motion::Free => MotionFields::Free,
            Motion::Fixed => MotionFields::Fixed,
            Motion::Keyframed(track) => {
                MotionFields::Keyframed(track.keys().iter().map(key_fields).collect())
            }
        },
        position: body.pose.position.to_array(),
        orientation: body.pose.orientation.to_array(),
        velocity: body.velocity.to_array(),
        angular_velocity: body.angular_velocity.to_array(),
    }
}

fn key_fields(key: &Keyframe) -> KeyFields {
    KeyFields {
        time: key.time,
        position: key.pose.position.to_array(),
        orientation: key.pose.orientation.to_array(),
    }
}

fn link_fields(link: &Link) -> LinkFields {
    match *link {
        Link::Hang { body, anchor } => LinkFields::Hang { body: body.0, anchor: anchor.to_array() },
        Link::Spring { body, to, rest_length, stiffness, damping } => LinkFields::Spring {
            body: body.0,
            to: match to {
                SpringEnd::Point(point) => SpringEndFields::Point(point.to_array()),
                SpringEnd::Body(body) => SpringEndFields::Body(body.0),
            },
            rest_length,
            stiffness,
            damping,
        },
    }
}
