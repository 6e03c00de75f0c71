//! The bodies of a scene, copy by copy: geometry, mass, checks of size, placement.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::geometry::{GeometryError, LoadedGeometry, Loader};
use super::problems::Problems;
use super::supports::supports;
use crate::body::Body;
use crate::math::random::SplitMix;
use crate::quantity::{RADIUS, rounded};
use crate::scene::body_description::{
    BodyDescription, Copies, Geometry, GeometryKey, GeometryReference, PlacedBy,
};
use crate::scene::diagnostic::{Doubt, Problem, SceneError};
use crate::scene::placement::{Obstacle, Packing, in_ball, rotation};
use crate::scene::scene_description::Scene;

/// A body, not necessarily placed yet.
pub(super) struct Draft<'s> {
    description: &'s BodyDescription,
    body: Body,
}

/// Random numbers of one copy.
pub(super) struct Variation {
    /// Its geometry.
    pub(super) reference: GeometryReference,
    /// Its orientation, if random.
    orientation: Option<DQuat>,
    /// Its random angular velocity [rad/s].
    spin: DVec3,
}

/// The random numbers of a copy, counted from 0. They do not depend on those of other copies.
pub(super) fn variation(scene: &Scene, description: &BodyDescription, copy: usize) -> Variation {
    let seed = seed(scene, description) ^ (copy as u64 + 1).wrapping_mul(0xD1B5_4A32_D192_ED03);
    let mut random = SplitMix::new(seed);
    let [least, greatest] = description.scale;
    let reference = description.reference(copy, random.uniform(least, greatest));
    let (rotation, spin) = (rotation(&mut random), in_ball(&mut random));
    match &description.copies {
        Copies::Random(placement) => Variation {
            reference,
            orientation: placement.random_orientation.then_some(rotation),
            spin: spin * placement.max_spin,
        },
        _ => Variation { reference, orientation: None, spin: DVec3::ZERO },
    }
}

/// Every distinct geometry of a scene, in the order of its bodies: the arguments of the loader of
/// [`instantiate`](super::instantiate()).
pub fn references(scene: &Scene) -> Vec<GeometryReference> {
    let mut seen = BTreeSet::new();
    let mut references = Vec::new();
    for description in &scene.bodies {
        for copy in 0..description.count() {
            let reference = variation(scene, description, copy).reference;
            if seen.insert(reference.key()) {
                references.push(reference);
            }
        }
    }
    references
}

/// An error where bodies have more distinct geometries than are built, before any of them is.
pub(super) fn too_many_geometries(scene: &Scene) -> Option<SceneError> {
    let mut seen = BTreeSet::new();
    for description in &scene.bodies {
        // Spheres take no memory of their own.
        if matches!(&description.geometry, Geometry::Shape(text) if text.starts_with("sphere:")) {
            continue;
        }
        for copy in 0..description.count() {
            seen.insert(variation(scene, description, copy).reference.key());
            if seen.len() > MAX_GEOMETRIES {
                let problem = Problem::TooManyGeometries { limit: MAX_GEOMETRIES };
                return Some(SceneError { place: description.geometry_place.clone(), problem });
            }
        }
    }
    None
}

/// Distinct shapes, files and scales of a scene: each has a mesh in memory.
const MAX_GEOMETRIES: usize = 10_000;

/// Seed of a `[[body]]`: its own or the scene's, with the name mixed in (FNV-1a), so that two bodies draw
/// different numbers.
fn seed(scene: &Scene, description: &BodyDescription) -> u64 {
    let own = match &description.copies {
        Copies::Random(placement) => placement.seed,
        _ => None,
    };
    let mix = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3);
    let name = description.name.bytes().fold(0xCBF2_9CE4_8422_2325, mix);
    own.unwrap_or(scene.simulation.seed) ^ name
}

/// Loads every body; scattered ones are not placed yet.
pub(super) fn draft<'s>(scene: &'s Scene, load: &mut Loader<'_>, problems: &mut Problems) -> Vec<Draft<'s>> {
    let mut loaded: BTreeMap<GeometryKey, Option<LoadedGeometry>> = BTreeMap::new();
    let mut drafts = Vec::new();
    for description in &scene.bodies {
        for copy in 0..description.count() {
            let Variation { reference, orientation, spin } = variation(scene, description, copy);
            let geometry = loaded
                .entry(reference.key())
                .or_insert_with(|| geometry(description, &reference, load, problems));
            // One error for a file, independent of the number of its copies and scales.
            let Some(geometry) = geometry else { break };
            let mut pose = description.pose;
            if let Copies::At(positions) = &description.copies {
                pose.position = positions[copy];
            }
            pose.orientation = orientation.unwrap_or(pose.orientation);
            if description.placed_by == PlacedBy::Origin {
                pose.position += pose.orientation * geometry.mass.centre_of_mass;
            }
            let (name, material) = (description.copy_name(copy), description.material.clone());
            let mut body = Body::solid(name, material, Arc::clone(&geometry.surface), &geometry.mass)
                .at(pose)
                .with_velocity(description.velocity)
                .with_angular_velocity(description.angular_velocity + spin)
                .with_motion(description.motion.clone());
            description.given_mass.apply_to(&mut body);
            if let Some(edge_radius) = description.edge_radius {
                body.edge_radius = edge_radius;
            }
            let known = problems.errors.len();
            body.supports = supports(description, (&body, geometry), problems);
            drafts.push(Draft { description, body });
            if problems.errors.len() > known {
                break;
            }
        }
    }
    drafts
}

/// Loads one geometry and checks its size; `None` after an error.
fn geometry(
    description: &BodyDescription,
    reference: &GeometryReference,
    load: &mut Loader<'_>,
    problems: &mut Problems,
) -> Option<LoadedGeometry> {
    let place = || description.geometry_place.clone();
    let loaded = match load(reference) {
        Ok(loaded) => loaded,
        Err(GeometryError { reason, remedy }) => {
            problems.error(place(), Problem::Geometry { reference: reference.to_string(), reason, remedy });
            return None;
        }
    };
    for message in &loaded.warnings {
        problems.warn_once(place(), Doubt::Geometry { message: message.clone() });
    }
    let radius = loaded.surface.bounding_radius();
    if !RADIUS.admits(radius) {
        problems.error(place(), Problem::AbsurdSize { radius });
        return None;
    }
    if !(USUAL_MIN_RADIUS..=USUAL_MAX_RADIUS).contains(&radius) {
        let usual = "0.0005 m to 10 m; files in millimetres need scale = 0.001";
        let value = rounded(radius, 4);
        problems.warn(place(), Doubt::Unusual { what: "a bounding radius", value, unit: "m", usual });
    }
    Some(loaded)
}

/// Bounding radii outside these give a warning [m].
const USUAL_MIN_RADIUS: f64 = 0.5e-3;
const USUAL_MAX_RADIUS: f64 = 10.0;

/// Places every scattered body.
pub(super) fn place(
    scene: &Scene,
    drafts: Vec<Draft<'_>>,
    planes: &[Body],
    problems: &mut Problems,
) -> Vec<Body> {
    let is_scattered = |d: &Draft<'_>| matches!(d.description.copies, Copies::Random(_));
    let standing = drafts.iter().filter(|d| !is_scattered(d)).map(|d| &d.body).chain(planes);
    let obstacles: Vec<Obstacle> = standing.map(Obstacle::of).collect();
    let radii = drafts.iter().filter(|d| is_scattered(d)).map(|d| d.body.surface.bounding_radius());
    let mut packing = Packing::new(obstacles, radii.fold(0.0, f64::max));
    let mut bodies: Vec<Body> = Vec::with_capacity(drafts.len() + planes.len());
    let mut drafts = drafts.into_iter().peekable();
    for description in &scene.bodies {
        let mut random = SplitMix::new(seed(scene, description));
        let mut placed = 0;
        while let Some(draft) = drafts.next_if(|d| std::ptr::eq(d.description, description)) {
            let mut body = draft.body;
            if let Copies::Random(placement) = &description.copies {
                let radius = body.surface.bounding_radius();
                let Some(centre) = packing.place(placement.region, radius, &mut random) else {
                    let problem = Problem::DoesNotFit { placed, count: placement.count };
                    problems.error(placement.place.clone(), problem);
                    while drafts.next_if(|d| std::ptr::eq(d.description, description)).is_some() {}
                    break;
                };
                placed += 1;
                body.pose.position = centre;
            }
            bodies.push(body);
        }
    }
    bodies
}
