//! The bodies of a scene, copy by copy: loaded, weighed, checked for size, placed.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::{Builder, GeometryError, LoadedGeometry, Loader, edge_radius};
use crate::body::{Body, Surface};
use crate::geometry::mass_properties::MassProperties;
use crate::pose::Pose;
use crate::scene::Scene;
use crate::scene::body_description::{BodyDescription, Copies, Geometry, GeometryReference, RandomPlacement};
use crate::scene::diagnostic::{Doubt, Problem};
use crate::scene::placement::{Obstacle, Packing, SplitMix64};

/// A body that may still want a place.
pub(super) struct Draft<'s> {
    description: &'s BodyDescription,
    body: Body,
}

/// Random numbers of one copy: independent of how many draws its neighbours took.
fn random_of(placement: &RandomPlacement, copy: usize) -> SplitMix64 {
    SplitMix64::new(placement.seed ^ (copy as u64 + 1).wrapping_mul(0xD1B5_4A32_D192_ED03))
}

/// Loads every body; scattered ones are not placed yet.
pub(super) fn draft<'s>(scene: &'s Scene, load: &mut Loader<'_>, builder: &mut Builder) -> Vec<Draft<'s>> {
    let mut loaded: BTreeMap<(Geometry, u64), Option<LoadedGeometry>> = BTreeMap::new();
    let mut drafts = Vec::new();
    for description in &scene.bodies {
        for copy in 0..description.count() {
            let mut pose = description.pose;
            let mut angular_velocity = description.angular_velocity;
            let mut random = SplitMix64::new(scene.simulation.seed ^ copy as u64);
            match &description.copies {
                Copies::One => {}
                Copies::At(positions) => pose = Pose { position: positions[copy], ..pose },
                Copies::Random(placement) => {
                    random = random_of(placement, copy);
                    let (rotation, spin) = (random.rotation(), random.in_ball());
                    if placement.random_orientation {
                        pose.orientation = rotation;
                    }
                    angular_velocity += spin * placement.max_spin;
                }
            }
            let [least, greatest] = description.scale;
            let reference = description.reference(copy, random.between(least, greatest));
            let key = (reference.geometry.clone(), reference.scale.to_bits());
            let geometry =
                loaded.entry(key).or_insert_with(|| geometry(description, &reference, load, builder));
            let Some(geometry) = geometry else { continue };
            let density = description.material.density;
            let body = Body {
                name: description.copy_name(copy),
                material: description.material.clone(),
                surface: Arc::clone(&geometry.surface),
                mass: density * geometry.mass.volume,
                inertia: geometry.mass.inertia * density,
                pose,
                velocity: description.velocity,
                angular_velocity,
                motion: description.motion.clone(),
                edge_radius: edge_radius(description, &geometry.surface),
            };
            drafts.push(Draft { description, body });
        }
    }
    drafts
}

/// Loads one geometry and judges its size; `None` after an error.
fn geometry(
    description: &BodyDescription,
    reference: &GeometryReference,
    load: &mut Loader<'_>,
    builder: &mut Builder,
) -> Option<LoadedGeometry> {
    let place = || description.geometry_place.clone();
    let loaded = match sphere(reference) {
        Some(sphere) => Ok(sphere),
        None => load(reference),
    };
    let loaded = match loaded {
        Ok(loaded) => loaded,
        Err(GeometryError { reason, remedy }) => {
            builder.error(place(), Problem::Geometry { reference: reference.to_string(), reason, remedy });
            return None;
        }
    };
    for message in &loaded.warnings {
        builder.warn(place(), Doubt::Geometry { message: message.clone() });
    }
    let radius = loaded.surface.bounding_radius();
    if !(MIN_RADIUS..=MAX_RADIUS).contains(&radius) {
        builder.error(place(), Problem::AbsurdSize { radius });
        return None;
    }
    if !(USUAL_MIN_RADIUS..=USUAL_MAX_RADIUS).contains(&radius) {
        let usual = "0.0005 m to 10 m; files in millimetres need scale = 0.001";
        builder.warn(place(), Doubt::Unusual { what: "a bounding radius", value: radius, unit: "m", usual });
    }
    Some(loaded)
}

/// Bounding radii outside these are refused [m].
const MIN_RADIUS: f64 = 1e-6;
const MAX_RADIUS: f64 = 1e3;

/// Bounding radii outside these are doubted [m].
const USUAL_MIN_RADIUS: f64 = 0.5e-3;
const USUAL_MAX_RADIUS: f64 = 10.0;

/// The geometry of `sphere:R`, in closed form.
fn sphere(reference: &GeometryReference) -> Option<LoadedGeometry> {
    let Geometry::Shape(text) = &reference.geometry else { return None };
    let radius: f64 = text.strip_prefix("sphere:")?.parse().ok()?;
    let radius = radius * reference.scale;
    if !(radius.is_finite() && radius > 0.0) {
        return None;
    }
    let volume = 4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius;
    let inertia = DMat3::from_diagonal(DVec3::splat(0.4 * volume * radius * radius));
    Some(LoadedGeometry {
        surface: Arc::new(Surface::Sphere { radius }),
        mass: MassProperties { volume, centre_of_mass: DVec3::ZERO, inertia },
        warnings: Vec::new(),
    })
}

/// Gives every scattered body a place.
pub(super) fn place(
    scene: &Scene,
    drafts: Vec<Draft<'_>>,
    planes: &[Body],
    builder: &mut Builder,
) -> Vec<Body> {
    let is_scattered = |d: &Draft<'_>| matches!(d.description.copies, Copies::Random(_));
    let standing = drafts.iter().filter(|d| !is_scattered(d)).map(|d| &d.body).chain(planes);
    let obstacles: Vec<Obstacle> = standing.map(Obstacle::of).collect();
    let radii = drafts.iter().filter(|d| is_scattered(d)).map(|d| d.body.surface.bounding_radius());
    let mut packing = Packing::new(obstacles, radii.fold(0.0, f64::max));
    let mut bodies: Vec<Body> = Vec::with_capacity(drafts.len() + planes.len());
    let mut drafts = drafts.into_iter().peekable();
    for description in &scene.bodies {
        let mut random = match &description.copies {
            Copies::Random(placement) => SplitMix64::new(placement.seed),
            _ => SplitMix64::new(0),
        };
        let mut placed = 0;
        while let Some(draft) = drafts.next_if(|d| std::ptr::eq(d.description, description)) {
            let mut body = draft.body;
            if let Copies::Random(placement) = &description.copies {
                let radius = body.surface.bounding_radius();
                let Some(centre) = packing.place(placement.region, radius, &mut random) else {
                    let problem = Problem::DoesNotFit { placed, count: placement.count };
                    builder.error(placement.place.clone(), problem);
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
