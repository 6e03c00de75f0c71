//! The search for the convex parts of a scene's mesh files, before its motion begins.
//!
//! Meshes are searched side by side; bodies of one mesh and error share their parts.

use std::sync::Arc;
use std::time::Instant;

use clangor_core::scene::diagnostic::{Doubt, Problem, SceneError, SceneErrors, SceneWarning};
use clangor_sim::decompose::Decomposition;
use rayon::prelude::*;

use super::collision_parts::{CollidingMesh, ObtainedParts};
use super::load::{LoadError, LoadedScene};
use crate::formats::model_cache::ModelCache;

/// Parts further off the surface than this fraction of the bounding radius make a warning, unless a scene
/// asks for another error.
const DOUBTFUL_DEVIATION: f64 = 0.01;

/// Gives the bodies of mesh files their convex parts, from the cache or by a decomposition. What has been
/// found is not sought again.
///
/// # Errors
/// [`LoadError::Scene`] for a mesh without parts, at its place in the file.
pub fn find_collision_parts(loaded: &mut LoadedScene, cache: Option<&ModelCache>) -> Result<(), LoadError> {
    if !loaded.collisions.obtained.is_empty() {
        return Ok(());
    }
    let meshes = std::mem::take(&mut loaded.collisions.meshes);
    let search = |colliding: &CollidingMesh| {
        let started = Instant::now();
        (colliding.mesh.parts(colliding.error, cache), started.elapsed())
    };
    let found: Vec<_> = meshes.par_iter().map(search).collect();
    let mut errors = Vec::new();
    for (colliding, (outcome, time)) in meshes.iter().zip(found) {
        let first = colliding.bodies[0];
        let Some(description) = loaded.scene.description_of(first) else { continue };
        let place = description.geometry_place.clone();
        let parts = match outcome {
            Ok(parts) => parts,
            Err(error) => {
                let problem = Problem::Geometry {
                    reference: description.reference(0, 1.0).to_string(),
                    reason: error.to_string(),
                    remedy: "simplify the mesh, or build the body from the shape library".into(),
                };
                errors.push(SceneError { place, problem });
                continue;
            }
        };
        let surface_error = colliding.mesh.surface_error(&parts.decomposition);
        let message = colliding.doubt(&parts.decomposition);
        let doubt = |message| SceneWarning { place, doubt: Doubt::Geometry { message } };
        loaded.collisions.warnings.extend(message.map(doubt));
        loaded.collisions.remarks.extend(parts.remarks);
        loaded.collisions.obtained.push(ObtainedParts {
            body: first,
            parts: parts.decomposition.parts.len(),
            surface_error,
            cached: parts.cached,
            time,
        });
        let bare = &loaded.world.bodies[first.index()].surface;
        let surface = Arc::new(colliding.mesh.with_parts(bare, &parts.decomposition));
        for id in &colliding.bodies {
            loaded.world.bodies[id.index()].surface = Arc::clone(&surface);
        }
    }
    loaded.collisions.meshes = meshes;
    if errors.is_empty() {
        return Ok(());
    }
    loaded.collisions.obtained.clear();
    let (path, text) = (loaded.path.clone(), loaded.text.clone());
    Err(LoadError::Scene { path, text, errors: SceneErrors(errors) })
}

impl CollidingMesh {
    /// What to say of parts that are farther off the surface than asked for, or than usual.
    fn doubt(&self, parts: &Decomposition) -> Option<String> {
        let deviation = self.mesh.deviation(parts);
        if deviation <= self.error.unwrap_or(DOUBTFUL_DEVIATION) {
            return None;
        }
        let (asked, remedy) = match self.error {
            Some(error) => (
                format!(", not the {:.1} % of `collision_error`", 100.0 * error),
                "these are the finest parts; a shape of the library has exact ones",
            ),
            None => (String::new(), "a smaller `collision_error` of the body gives finer parts"),
        };
        let count = match parts.parts.len() {
            1 => "1 convex part that is".to_owned(),
            count => format!("{count} convex parts that are"),
        };
        Some(format!(
            "collisions see {count} up to {:.2e} m ({:.1} % of its size{asked}) off the surface: {remedy}",
            self.mesh.surface_error(parts),
            deviation * 100.0
        ))
    }
}
