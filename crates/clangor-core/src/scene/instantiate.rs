//! From a [`Scene`] to a [`World`]: loads geometry, places copies, and resolves links.
//!
//! Order of bodies: those of the file with their copies, then the planes. A scattered copy depends on the
//! seed, on the bodies that are not scattered, and on the copies before it.

mod copies;
mod geometry;
mod links;
mod listeners;
mod problems;
mod supports;

use std::collections::BTreeMap;

use super::body_description::{BodyDescription, Copies, Geometry, PlaneDescription};
use super::diagnostic::{Problem, SceneError, SceneErrors, SceneWarning};
use super::listener::below_floor;
use super::scene_description::{MAX_BODIES, Scene};
use crate::body::{Body, BodyId, World};

pub use copies::references;
pub use geometry::{GeometryError, LoadedGeometry, Loader, load_shape};
use problems::Problems;

/// A world, and the warnings of its construction.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// The world.
    pub world: World,
    /// Warnings; those of the scene are not repeated.
    pub warnings: Vec<SceneWarning>,
}

/// Instantiates a scene.
///
/// `load` is called once for each distinct geometry, in the order of [`references`]; [`load_shape`] is
/// sufficient for shapes.
///
/// # Errors
/// All errors in geometry, placement, links and listeners, in the order of the file.
pub fn instantiate(scene: &Scene, load: &mut Loader<'_>) -> Result<Instance, SceneErrors> {
    let mut problems = Problems::default();
    let total = scene.bodies.iter().fold(0u64, |sum, b| sum.saturating_add(b.count() as u64));
    if total > MAX_BODIES {
        let place = scene.bodies.first().map(|b| b.place.clone()).unwrap_or_default();
        problems.error(place, Problem::TooManyBodies { count: total, limit: MAX_BODIES });
        return Err(SceneErrors(problems.errors));
    }
    if let Some(error) = copies::too_many_geometries(scene) {
        return Err(SceneErrors(vec![error]));
    }
    problems.errors.extend(below_floor(&scene.listeners, scene.acoustics.floor));
    let drafts = copies::draft(scene, load, &mut problems);
    let planes: Vec<Body> = scene.planes.iter().map(plane).collect();
    let bodies = copies::place(scene, drafts, &planes, &mut problems);
    if problems.errors.is_empty() {
        let mut world = World { bodies, links: Vec::new(), gravity: scene.gravity };
        world.bodies.extend(planes);
        links::link(scene, &names(scene), &mut world, &mut problems);
        listeners::check(scene, &world, &mut problems);
        if problems.errors.is_empty() {
            return Ok(Instance { world, warnings: problems.warnings });
        }
    }
    problems.errors.sort_by_key(|e| e.place.order());
    Err(SceneErrors(problems.errors))
}

/// The errors of a scene's mesh files alone; its shapes were checked where they were read.
pub(super) fn file_errors(scene: &Scene, load: &mut Loader<'_>) -> Vec<SceneError> {
    let mut problems = Problems::default();
    let is_file = |b: &&BodyDescription| matches!(b.geometry, Geometry::File(_));
    let bodies = scene.bodies.iter().filter(is_file).cloned().collect();
    copies::draft(&Scene { bodies, ..scene.clone() }, load, &mut problems);
    problems.errors
}

fn plane(description: &PlaneDescription) -> Body {
    let PlaneDescription { name, point, normal, material, thickness, .. } = description;
    match thickness {
        Some(thickness) => Body::plate(name, material.clone(), (*point, *normal), *thickness),
        None => Body::plane(name, material.clone(), *point, *normal),
    }
}

/// Bodies of the world by name, and groups of copies by the name of their `[[body]]`.
fn names(scene: &Scene) -> BTreeMap<String, Vec<BodyId>> {
    let mut names: BTreeMap<String, Vec<BodyId>> = BTreeMap::new();
    let mut next = 0;
    for description in &scene.bodies {
        for copy in 0..description.count() {
            if description.copies != Copies::One {
                names.entry(description.copy_name(copy)).or_default().push(BodyId(next));
            }
            names.entry(description.name.clone()).or_default().push(BodyId(next));
            next += 1;
        }
    }
    names
}
