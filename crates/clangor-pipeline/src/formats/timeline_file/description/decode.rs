//! From a description to the header of a timeline, with every number checked.

use std::collections::{BTreeMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use clangor_core::body::support::{Support, SupportKind, SupportRegion};
use clangor_core::body::{Body, BodyId, Guide, Life, Motion, Surface, World};
use clangor_core::material::{Damping, Material};
use clangor_core::medium::Medium;
use clangor_core::pose::{Keyframe, Pose, Track};
use clangor_core::quantity;
use glam::{DMat3, DQuat};
use serde::Deserialize;

use super::checks::Checks;
use super::links;
use super::{
    BodyFields, DampingFields, Description, FORMAT_NAME, ImpactModesFields, KeyFields, LifeFields,
    MaterialFields, MotionFields, RegionFields, SupportFields, SupportKindFields, SurfaceFields,
};
use crate::formats::timeline_file::error::TimelineError;
use crate::formats::timeline_file::files::MESH_FOLDER;
use crate::formats::timeline_file::header::{FORMAT_VERSION, OLDEST_VERSION, Origin, TimelineHeader};
use crate::formats::timeline_file::surface_file;

/// Reads the text of a description and the meshes in `folder` that it names.
pub(in crate::formats::timeline_file) fn read(
    path: &Path,
    text: &[u8],
    folder: &Path,
) -> Result<(Description, TimelineHeader), TimelineError> {
    check_version(path, text)?;
    let description = check_json(path, text)?;
    let field = |field: String, problem: String| TimelineError::Field { path: path.into(), field, problem };
    let mut checks = Checks::new(path, description.bodies.len());
    checks.settings(&description)?;
    let mut names = HashSet::new();
    let mut surfaces: BTreeMap<String, Arc<Surface>> = BTreeMap::new();
    let mut bodies = Vec::new();
    for (index, fields) in description.bodies.iter().enumerate() {
        if !names.insert(fields.name.as_str()) {
            return Err(field(format!("bodies[{index}].name"), format!("\"{}\" is not unique", fields.name)));
        }
        let surface = match &fields.surface {
            SurfaceFields::Sphere { radius } => {
                checks.quantity(
                    &format!("bodies[{index}].surface.sphere.radius"),
                    *radius,
                    quantity::RADIUS,
                )?;
                Arc::new(Surface::Sphere { radius: *radius })
            }
            SurfaceFields::HalfSpace {} => Arc::new(Surface::HalfSpace),
            SurfaceFields::Plate { thickness } => checks.plate(index, *thickness)?,
            SurfaceFields::Mesh { hash, volume } => {
                checks.quantity(
                    &format!("bodies[{index}].surface.mesh.volume"),
                    *volume,
                    quantity::VOLUME,
                )?;
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
    let links = links::decode(&checks, &description.links)?;
    let origin = &description.origin;
    let of_body = |modes: &ImpactModesFields| {
        let body = checks.body_id("origin.impact_modes.body", modes.body);
        body.map(|body| (body, modes.model.clone()))
    };
    let impact_modes = origin.impact_modes.iter().map(of_body).collect::<Result<_, _>>()?;
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
            impact_modes,
        },
        scene: description.scene.clone(),
    };
    Ok((description, header))
}

/// Decodes the text, which refuses missing, unknown and null fields.
pub(in crate::formats::timeline_file) fn check_json(
    path: &Path,
    text: &[u8],
) -> Result<Description, TimelineError> {
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

impl Checks<'_> {
    /// Checks the numbers that belong to no body.
    fn settings(&self, description: &Description) -> Result<(), TimelineError> {
        let (medium, origin) = (&description.medium, &description.origin);
        for (name, value, range) in [
            ("medium.density", medium.density, quantity::MEDIUM_DENSITY),
            ("medium.sound_speed", medium.sound_speed, quantity::SOUND_SPEED),
            ("origin.time_step", origin.time_step, quantity::TIMELINE_STEP),
            ("origin.duration", origin.duration, quantity::TIMELINE_DURATION),
            ("origin.v_min", origin.v_min, quantity::V_MIN),
            ("origin.pose_rate", origin.pose_rate, quantity::TIMELINE_POSE_RATE),
        ] {
            self.quantity(name, value, range)?;
        }
        self.vector("gravity", description.gravity, quantity::COORDINATE)
    }

    fn body(
        &mut self,
        index: usize,
        fields: &BodyFields,
        surface: Arc<Surface>,
    ) -> Result<Body, TimelineError> {
        let at = |name: &str| format!("bodies[{index}].{name}");
        let mass = f64::from(fields.mass);
        if mass != f64::INFINITY {
            self.quantity(&at("mass"), mass, quantity::MASS)?;
        }
        // Planes have none.
        if fields.edge_radius != 0.0 {
            self.quantity(&at("edge_radius"), fields.edge_radius, quantity::EDGE_RADIUS)?;
        }
        for (name, vector, range) in [
            ("position", fields.position, quantity::COORDINATE),
            ("velocity", fields.velocity, quantity::COORDINATE),
            ("angular_velocity", fields.angular_velocity, quantity::COORDINATE),
        ] {
            self.vector(&at(name), vector, range)?;
        }
        let m = &fields.material;
        self.check_material(&at("material"), m)?;
        let damping = damping_of(&m.damping);
        damping.check().map_err(|e| self.field(&at("material.damping"), e.to_string()))?;
        let motion = match &fields.motion {
            MotionFields::Free => Motion::Free,
            MotionFields::Fixed => Motion::Fixed,
            MotionFields::Keyframed(keys) => Motion::Keyframed(self.track(&at("motion"), keys)?),
            MotionFields::Guided { keys, press, let_go } => {
                let name = at("motion");
                if let Some(press) = press {
                    self.quantity(&format!("{name}.press"), *press, quantity::PRESS)?;
                }
                if let Some(time) = let_go.filter(|time| !(*time >= 0.0 && time.is_finite())) {
                    return Err(self.field(&format!("{name}.let_go"), format!("is {time} s")));
                }
                Motion::Guided(Guide { track: self.track(&name, keys)?, press: *press, let_go: *let_go })
            }
        };
        let inertia = fields.inertia.map(|row| row.map(f64::from));
        self.inertia(&at("inertia"), inertia)?;
        Ok(Body {
            name: fields.name.clone(),
            material: Material {
                name: m.name.clone(),
                density: m.density,
                youngs_modulus: m.youngs_modulus,
                poisson_ratio: m.poisson_ratio,
                restitution: m.restitution,
                restitution_speed: m.restitution_speed,
                rigid_restitution: m.rigid_restitution,
                yield_strength: m.yield_strength,
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
            supports: self.supports(index, &fields.supports)?,
        })
    }

    /// Checks the numbers of a material in the field `material`, but for its damping.
    fn check_material(&self, material: &str, m: &MaterialFields) -> Result<(), TimelineError> {
        let at = |name: &str| format!("{material}.{name}");
        for (name, value, range) in [
            ("density", Some(m.density), quantity::DENSITY),
            ("youngs_modulus", Some(m.youngs_modulus), quantity::MODULUS),
            ("poisson_ratio", Some(m.poisson_ratio), quantity::POISSON),
            ("restitution", Some(m.restitution), quantity::RESTITUTION),
            ("restitution_speed", m.restitution_speed, quantity::RESTITUTION_SPEED),
            ("rigid_restitution", m.rigid_restitution, quantity::RESTITUTION),
            ("yield_strength", m.yield_strength, quantity::STRENGTH),
            ("friction", Some(m.friction), quantity::FRICTION),
            ("rolling_loss", Some(m.rolling_loss), quantity::ROLLING_LOSS),
            ("tensile_strength", m.tensile_strength, quantity::STRENGTH),
            ("fracture_energy", m.fracture_energy, quantity::FRACTURE_ENERGY),
        ] {
            if let Some(value) = value {
                self.quantity(&at(name), value, range)?;
            }
        }
        Ok(())
    }

    /// Refuses a matrix that is not the inertia of a body: principal moments are positive, or infinite.
    fn inertia(&self, name: &str, rows: [[f64; 3]; 3]) -> Result<(), TimelineError> {
        let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = rows;
        let is_finite = rows.iter().flatten().all(|number| number.is_finite());
        let tolerance = 1e-9 * (xx.abs() + yy.abs() + zz.abs());
        let is_symmetric = [xy - yx, xz - zx, yz - zy].iter().all(|skew| skew.abs() <= tolerance);
        let minors = [xx, xx * yy - xy * yx, DMat3::from_cols_array_2d(&rows).determinant()];
        let has_diagonal = [xx, yy, zz].iter().all(|moment| *moment > 0.0);
        // Where an axis is infinite, the others are not mixed with it.
        let is_definite = !is_finite || is_symmetric && minors.iter().all(|minor| *minor > 0.0);
        if has_diagonal && is_definite {
            return Ok(());
        }
        Err(self.field(name, "is not a symmetric matrix with positive principal moments".into()))
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

    fn supports(&self, index: usize, all: &[SupportFields]) -> Result<Vec<Support>, TimelineError> {
        let mut supports = Vec::with_capacity(all.len());
        for (at, fields) in all.iter().enumerate() {
            let name = |part: &str| format!("bodies[{index}].supports[{at}].{part}");
            let region = match fields.region {
                RegionFields::Ball { centre, radius } => {
                    self.positive(&name("region.ball.radius"), radius)?;
                    SupportRegion::Ball { centre: centre.into(), radius }
                }
                RegionFields::Box { low, high } => {
                    for (low, high) in low.into_iter().zip(high) {
                        self.positive(&name("region.box.high less low"), high - low)?;
                    }
                    SupportRegion::Box { low: low.into(), high: high.into() }
                }
            };
            let kind = match fields.kind {
                SupportKindFields::Clamped => SupportKind::Clamped,
                SupportKindFields::Sprung { stiffness, damping } => {
                    for (part, numbers) in [("stiffness", stiffness), ("damping", damping)] {
                        for number in numbers {
                            self.not_negative(&name(part), number)?;
                        }
                    }
                    SupportKind::Sprung { stiffness: stiffness.into(), damping: damping.into() }
                }
            };
            supports.push(Support { region, kind });
        }
        Ok(supports)
    }

    fn track(&self, name: &str, keys: &[KeyFields]) -> Result<Track, TimelineError> {
        let key = |k: &KeyFields| {
            self.vector(name, k.position, quantity::COORDINATE)?;
            Ok(Keyframe { time: k.time, pose: self.pose(name, k.position, k.orientation)? })
        };
        let track = Track::try_new(keys.iter().map(key).collect::<Result<_, TimelineError>>()?);
        let problem = || self.field(name, "has no keys, or times that do not increase".into());
        track.ok_or_else(problem)
    }

    fn pose(&self, name: &str, position: [f64; 3], orientation: [f64; 4]) -> Result<Pose, TimelineError> {
        let orientation = DQuat::from_array(orientation);
        if (orientation.length_squared() - 1.0).abs() > 1e-6 {
            let problem = format!("has a quaternion of length {}, not 1", orientation.length());
            return Err(self.field(name, problem));
        }
        Ok(Pose { position: position.into(), orientation })
    }

    fn plate(&self, index: usize, thickness: f64) -> Result<Arc<Surface>, TimelineError> {
        self.quantity(&format!("bodies[{index}].surface.plate.thickness"), thickness, quantity::THICKNESS)?;
        Ok(Arc::new(Surface::Plate { thickness }))
    }
}
