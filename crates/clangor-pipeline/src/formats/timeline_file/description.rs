//! `timeline.json`: everything about a timeline but its rows.
//!
//! The structures mirror the file, not the library: the library may change without the format. Unknown keys
//! are refused, so that a misspelt one is not ignored.

use std::collections::{BTreeMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Life, Link, Motion, SpringEnd, Surface, World};
use clangor_core::material::{Damping, Material};
use clangor_core::medium::Medium;
use clangor_core::pose::{Keyframe, Pose, Track};
use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

use super::{
    FORMAT_VERSION, MESH_FOLDER, OLDEST_VERSION, Origin, TimelineError, TimelineHeader, hash, surface_file,
};

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
    #[serde(default, skip_serializing_if = "Option::is_none")]
    life: Option<LifeFields>,
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
        let address = Arc::as_ptr(&body.surface);
        let known = hashed.iter().rev().find(|(a, _)| *a == address).map(|(_, hash)| hash.clone());
        let (surface, file) = surface_fields(&body.surface, known);
        if let Some((hash, bytes)) = file {
            files.insert(hash.clone(), bytes);
            hashed.push((address, hash));
        }
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
        fractures: None,
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

impl Description {
    /// Ends the simulated time \[s\] earlier.
    pub(super) fn cut(&mut self, duration: f64) {
        self.origin.duration = self.origin.duration.min(duration);
    }

    /// Adds the pieces of a body that broke, and returns the content of their mesh files by hash.
    ///
    /// # Errors
    /// A number that JSON does not have.
    pub(super) fn replace(
        &mut self,
        parent: BodyId,
        pieces: &[Body],
    ) -> Result<Vec<(String, Vec<u8>)>, serde_json::Error> {
        let mut files = Vec::new();
        for piece in pieces {
            let (surface, file) = surface_fields(&piece.surface, None);
            let fields = body_fields(piece, surface);
            // JSON turns NaN into null, which is no number: better refused now than found when the file is
            // read.
            serde_json::from_slice::<BodyFields>(&serde_json::to_vec(&fields)?)?;
            self.bodies.push(fields);
            files.extend(file);
        }
        if let (Some(parent), Some(piece)) = (self.bodies.get_mut(parent.index()), pieces.first()) {
            let life =
                parent.life.unwrap_or(LifeFields { birth: 0.0, death: f64::INFINITY.into(), parent: None });
            parent.life = Some(LifeFields { death: piece.life.birth.into(), ..life });
        }
        Ok(files)
    }
}

/// The description of a surface; unless the hash of its file is `known`, also that and the file's content.
fn surface_fields(surface: &Surface, known: Option<String>) -> (SurfaceFields, Option<(String, Vec<u8>)>) {
    match surface {
        Surface::Sphere { radius } => (SurfaceFields::Sphere { radius: *radius }, None),
        Surface::HalfSpace => (SurfaceFields::HalfSpace {}, None),
        Surface::Mesh(surface) => {
            let volume = surface.volume;
            if let Some(hash) = known {
                return (SurfaceFields::Mesh { hash, volume }, None);
            }
            let bytes = surface_file::to_bytes(surface);
            let hash = hash::of(&bytes);
            (SurfaceFields::Mesh { hash: hash.clone(), volume }, Some((hash, bytes)))
        }
    }
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
            damping: damping_fields(&material.damping),
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
        life: (body.life != Life::LASTING).then(|| LifeFields {
            birth: body.life.birth,
            death: body.life.death.into(),
            parent: body.life.parent.map(|id| id.0),
        }),
    }
}

fn damping_fields(damping: &Damping) -> DampingFields {
    match damping {
        Damping::LossFactor(eta) => DampingFields::LossFactor(*eta),
        Damping::T60(time) => DampingFields::T60(*time),
        Damping::Rayleigh { alpha, beta, g } => DampingFields::Rayleigh { alpha: *alpha, beta: *beta, g: *g },
        Damping::LossFactorTable(rows) => DampingFields::LossFactorTable(rows.clone()),
        Damping::T60Table(rows) => DampingFields::T60Table(rows.clone()),
        Damping::Modes { t60, otherwise } => {
            DampingFields::Modes { t60: t60.clone(), otherwise: Box::new(damping_fields(otherwise)) }
        }
    }
}

fn damping_of(fields: &DampingFields) -> Damping {
    match fields {
        DampingFields::LossFactor(eta) => Damping::LossFactor(*eta),
        DampingFields::T60(time) => Damping::T60(*time),
        DampingFields::Rayleigh { alpha, beta, g } => Damping::Rayleigh { alpha: *alpha, beta: *beta, g: *g },
        DampingFields::LossFactorTable(rows) => Damping::LossFactorTable(rows.clone()),
        DampingFields::T60Table(rows) => Damping::T60Table(rows.clone()),
        DampingFields::Modes { t60, otherwise } => {
            Damping::Modes { t60: t60.clone(), otherwise: Box::new(damping_of(otherwise)) }
        }
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

/// Reads the text of a description and the meshes in `folder` that it names.
pub(super) fn read(
    path: &Path,
    text: &[u8],
    folder: &Path,
) -> Result<(Description, TimelineHeader), TimelineError> {
    check_version(path, text)?;
    let description = check_json(path, text)?;
    let field = |field: String, problem: String| TimelineError::Field { path: path.into(), field, problem };
    let mut checks = Checks { path, count: description.bodies.len() };
    checks.positive("medium.density", description.medium.density)?;
    checks.positive("medium.sound_speed", description.medium.sound_speed)?;
    for (name, value) in [
        ("origin.time_step", description.origin.time_step),
        ("origin.duration", description.origin.duration),
        ("origin.v_min", description.origin.v_min),
        ("origin.pose_rate", description.origin.pose_rate),
    ] {
        checks.not_negative(name, value)?;
    }
    let mut names = HashSet::new();
    let mut surfaces: BTreeMap<String, Arc<Surface>> = BTreeMap::new();
    let mut bodies = Vec::new();
    for (index, fields) in description.bodies.iter().enumerate() {
        if !names.insert(fields.name.as_str()) {
            return Err(field(format!("bodies[{index}].name"), format!("\"{}\" is not unique", fields.name)));
        }
        let surface = match &fields.surface {
            SurfaceFields::Sphere { radius } => {
                checks.positive(&format!("bodies[{index}].surface.sphere.radius"), *radius)?;
                Arc::new(Surface::Sphere { radius: *radius })
            }
            SurfaceFields::HalfSpace {} => Arc::new(Surface::HalfSpace),
            SurfaceFields::Mesh { hash, volume } => {
                checks.positive(&format!("bodies[{index}].surface.mesh.volume"), *volume)?;
                if hash.len() != 32 || !hash.bytes().all(|b| b.is_ascii_hexdigit()) {
                    let problem = "is not 32 hexadecimal digits".into();
                    return Err(field(format!("bodies[{index}].surface.mesh.hash"), problem));
                }
                match surfaces.get(hash) {
                    Some(surface) => Arc::clone(surface),
                    None => {
                        let file = folder.join(MESH_FOLDER).join(format!("{hash}.ply"));
                        let surface = Arc::new(Surface::Mesh(surface_file::read(&file, hash, *volume)?));
                        surfaces.insert(hash.clone(), Arc::clone(&surface));
                        surface
                    }
                }
            }
        };
        bodies.push(checks.body(index, fields, surface)?);
    }
    let links =
        description.links.iter().enumerate().map(|(i, l)| checks.link(i, l)).collect::<Result<_, _>>()?;
    let origin = &description.origin;
    let header = TimelineHeader {
        world: World { bodies, links, gravity: description.gravity.into() },
        medium: Medium { density: description.medium.density, sound_speed: description.medium.sound_speed },
        origin: Origin {
            solver: origin.solver.clone(),
            time_step: origin.time_step,
            duration: origin.duration,
            v_min: origin.v_min,
            pose_rate: origin.pose_rate,
            raw_log: origin.raw_log,
            sleep: origin.sleep,
            seed: origin.seed,
        },
        scene: description.scene.clone(),
    };
    Ok((description, header))
}

/// Decodes the text, which refuses missing, unknown and null fields.
pub(super) fn check_json(path: &Path, text: &[u8]) -> Result<Description, TimelineError> {
    serde_json::from_slice(text).map_err(|e| json_error(path, &e))
}

/// Refuses other versions before their unknown keys are complained about.
fn check_version(path: &Path, text: &[u8]) -> Result<(), TimelineError> {
    #[derive(Deserialize)]
    struct Version {
        format: String,
        version: u64,
    }
    let found: Version = serde_json::from_slice(text).map_err(|e| json_error(path, &e))?;
    if found.format != FORMAT_NAME {
        let problem = format!("is \"{}\", not \"{FORMAT_NAME}\"", found.format);
        return Err(TimelineError::Field { path: path.into(), field: "format".into(), problem });
    }
    if !(u64::from(OLDEST_VERSION)..=u64::from(FORMAT_VERSION)).contains(&found.version) {
        return Err(TimelineError::Version { path: path.into(), found: found.version });
    }
    Ok(())
}

fn json_error(path: &Path, error: &serde_json::Error) -> TimelineError {
    // The position is a field of its own; serde_json appends it to the text as well.
    let text = error.to_string();
    let reason = text.rsplit_once(" at line ").map_or(text.as_str(), |(reason, _)| reason).into();
    TimelineError::Json { path: path.into(), line: error.line(), column: error.column(), reason }
}

/// Turns fields into bodies and links, refusing what cannot be.
struct Checks<'a> {
    path: &'a Path,
    count: usize,
}

impl Checks<'_> {
    fn body(
        &mut self,
        index: usize,
        fields: &BodyFields,
        surface: Arc<Surface>,
    ) -> Result<Body, TimelineError> {
        let at = |name: &str| format!("bodies[{index}].{name}");
        let mass = f64::from(fields.mass);
        if mass != f64::INFINITY {
            self.positive(&at("mass"), mass)?;
        }
        self.not_negative(&at("edge_radius"), fields.edge_radius)?;
        let m = &fields.material;
        for (name, value) in [("density", m.density), ("youngs_modulus", m.youngs_modulus)] {
            self.positive(&at(&format!("material.{name}")), value)?;
        }
        for (name, value) in
            [("restitution", m.restitution), ("friction", m.friction), ("rolling_loss", m.rolling_loss)]
        {
            self.not_negative(&at(&format!("material.{name}")), value)?;
        }
        if !(m.poisson_ratio > -1.0 && m.poisson_ratio <= 0.5) {
            let problem = format!("is {}, not above -1 and at most 0.5", m.poisson_ratio);
            return Err(self.field(&at("material.poisson_ratio"), problem));
        }
        let damping = damping_of(&m.damping);
        damping.check().map_err(|e| self.field(&at("material.damping"), e.to_string()))?;
        let motion = match &fields.motion {
            MotionFields::Free => Motion::Free,
            MotionFields::Fixed => Motion::Fixed,
            MotionFields::Keyframed(keys) => {
                let keys = keys
                    .iter()
                    .map(|k| {
                        Ok(Keyframe {
                            time: k.time,
                            pose: self.pose(&at("motion"), k.position, k.orientation)?,
                        })
                    })
                    .collect::<Result<_, TimelineError>>()?;
                let track = Track::try_new(keys);
                let problem =
                    || self.field(&at("motion"), "has no keys, or times that do not increase".into());
                Motion::Keyframed(track.ok_or_else(problem)?)
            }
        };
        let inertia = fields.inertia.map(|row| row.map(f64::from));
        Ok(Body {
            name: fields.name.clone(),
            material: Material {
                name: m.name.clone(),
                density: m.density,
                youngs_modulus: m.youngs_modulus,
                poisson_ratio: m.poisson_ratio,
                restitution: m.restitution,
                friction: m.friction,
                rolling_loss: m.rolling_loss,
                damping,
                tensile_strength: m.tensile_strength,
                fracture_energy: m.fracture_energy,
                source: m.source.clone(),
            },
            surface,
            mass,
            inertia: DMat3::from_cols_array_2d(&inertia).transpose(),
            pose: self.pose(&at("orientation"), fields.position, fields.orientation)?,
            velocity: fields.velocity.into(),
            angular_velocity: fields.angular_velocity.into(),
            motion,
            edge_radius: fields.edge_radius,
            life: self.life(index, fields.life)?,
        })
    }

    fn life(&self, index: usize, fields: Option<LifeFields>) -> Result<Life, TimelineError> {
        let Some(LifeFields { birth, death, parent }) = fields else { return Ok(Life::LASTING) };
        let (death, parent) = (f64::from(death), parent.map(BodyId));
        self.not_negative(&format!("bodies[{index}].life.birth"), birth)?;
        if death.is_nan() || death < birth {
            let problem = format!("is {death}, before the birth at {birth}");
            return Err(self.field(&format!("bodies[{index}].life.death"), problem));
        }
        if let Some(parent) = parent.filter(|id| id.index() >= index) {
            let problem = format!("is {}, which does not come before it", parent.0);
            return Err(self.field(&format!("bodies[{index}].life.parent"), problem));
        }
        Ok(Life { birth, death, parent })
    }

    fn link(&self, index: usize, link: &LinkFields) -> Result<Link, TimelineError> {
        let body_id = |body: u32| {
            let id = BodyId(body);
            let problem = || format!("is {body}, but there are {} bodies", self.count);
            if id.index() < self.count {
                Ok(id)
            } else {
                Err(self.field(&format!("links[{index}].body"), problem()))
            }
        };
        Ok(match link {
            LinkFields::Hang { body, anchor } => {
                Link::Hang { body: body_id(*body)?, anchor: DVec3::from_array(*anchor) }
            }
            LinkFields::Spring { body, to, rest_length, stiffness, damping } => Link::Spring {
                body: body_id(*body)?,
                to: match to {
                    SpringEndFields::Point(point) => SpringEnd::Point(DVec3::from_array(*point)),
                    SpringEndFields::Body(body) => SpringEnd::Body(body_id(*body)?),
                },
                rest_length: *rest_length,
                stiffness: *stiffness,
                damping: *damping,
            },
        })
    }

    fn pose(&self, name: &str, position: [f64; 3], orientation: [f64; 4]) -> Result<Pose, TimelineError> {
        let orientation = DQuat::from_array(orientation);
        if (orientation.length_squared() - 1.0).abs() > 1e-6 {
            let problem = format!("has a quaternion of length {}, not 1", orientation.length());
            return Err(self.field(name, problem));
        }
        Ok(Pose { position: position.into(), orientation })
    }

    fn positive(&self, name: &str, value: f64) -> Result<(), TimelineError> {
        if value > 0.0 { Ok(()) } else { Err(self.field(name, format!("is {value}, not positive"))) }
    }

    fn not_negative(&self, name: &str, value: f64) -> Result<(), TimelineError> {
        if value >= 0.0 { Ok(()) } else { Err(self.field(name, format!("is {value}, not zero or more"))) }
    }

    fn field(&self, name: &str, problem: String) -> TimelineError {
        TimelineError::Field { path: self.path.into(), field: name.into(), problem }
    }
}
