//! From the header of a timeline to its description.

use std::collections::BTreeMap;
use std::sync::Arc;

use clangor_core::body::support::{Support, SupportKind, SupportRegion};
use clangor_core::body::{Body, BodyId, Guide, Life, Motion, Surface};
use clangor_core::material::Damping;
use clangor_core::pose::Keyframe;

use super::links;
use super::{
    BodyFields, DampingFields, Description, Extended, FORMAT_NAME, ImpactModesFields, KeyFields, LifeFields,
    MaterialFields, MediumFields, MotionFields, OriginFields, RegionFields, SupportFields, SupportKindFields,
    SurfaceFields, TableFields, Units,
};
use crate::formats::timeline_file::header::{FORMAT_VERSION, TimelineHeader};
use crate::formats::timeline_file::{hash, surface_file};

/// A description and the content of the mesh files that it names, by hash.
pub(in crate::formats::timeline_file) fn describe(
    header: &TimelineHeader,
) -> (Description, BTreeMap<String, Vec<u8>>) {
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
        forces: None,
        force_samples: None,
        origin: OriginFields {
            solver: origin.solver.clone(),
            time_step: origin.time_step,
            duration: origin.duration,
            v_min: origin.v_min,
            pose_rate: origin.pose_rate,
            raw_log: origin.raw_log,
            sleep: origin.sleep,
            seed: origin.seed,
            impact_modes: origin
                .impact_modes
                .iter()
                .map(|(body, model)| ImpactModesFields { body: body.0, model: model.clone() })
                .collect(),
        },
        medium: MediumFields { density: header.medium.density, sound_speed: header.medium.sound_speed },
        gravity: header.world.gravity.to_array(),
        bodies,
        links: header.world.links.iter().map(links::encode).collect(),
        scene: header.scene.clone(),
    };
    (description, files)
}

impl Description {
    /// Adds the pieces of a body that broke, and returns the content of their mesh files by hash.
    ///
    /// # Errors
    /// A number that JSON does not have.
    pub(in crate::formats::timeline_file) fn replace(
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
        Surface::Plate { thickness } => (SurfaceFields::Plate { thickness: *thickness }, None),
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
            restitution_speed: material.restitution_speed,
            rigid_restitution: material.rigid_restitution,
            yield_strength: material.yield_strength,
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
            Motion::Guided(Guide { track, press, let_go }) => MotionFields::Guided {
                keys: track.keys().iter().map(key_fields).collect(),
                press: *press,
                let_go: *let_go,
            },
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
        supports: body.supports.iter().map(support_fields).collect(),
    }
}

fn support_fields(support: &Support) -> SupportFields {
    SupportFields {
        region: match support.region {
            SupportRegion::Ball { centre, radius } => {
                RegionFields::Ball { centre: centre.to_array(), radius }
            }
            SupportRegion::Box { low, high } => {
                RegionFields::Box { low: low.to_array(), high: high.to_array() }
            }
        },
        kind: match support.kind {
            SupportKind::Clamped => SupportKindFields::Clamped,
            SupportKind::Sprung { stiffness, damping } => {
                SupportKindFields::Sprung { stiffness: stiffness.to_array(), damping: damping.to_array() }
            }
        },
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

fn key_fields(key: &Keyframe) -> KeyFields {
    KeyFields {
        time: key.time,
        position: key.pose.position.to_array(),
        orientation: key.pose.orientation.to_array(),
    }
}
