//! Bodies of a scene that may break: the tetrahedra in which their stress is sought and along which cracks
//! run.
//!
//! What breaks is its tetrahedra, whose flat faces leave a little of a round body out. Their moments of
//! inertia count from the beginning, so that nothing jumps when the body breaks: its pieces together are what
//! it was.

use std::collections::BTreeMap;
use std::sync::Arc;

use clangor_bake::mesh::tetrahedra::TetMesh;
use clangor_bake::stress::fracture_mesh;
use clangor_core::body::BodyId;
use clangor_core::body::{Body, Surface, World};
use clangor_core::scene::Scene;
use clangor_core::scene::breaking::Breaking;
use clangor_core::scene::diagnostic::{Problem, SceneError, SceneErrors};
use clangor_sim::fracture::Breakable;
use clangor_sim::fracture::piece::Piece;
use rayon::prelude::*;

use crate::stages::sound_models::request::radiating;

/// Makes the tetrahedra of all bodies that may break, and gives these bodies the inertia of their tetrahedra.
///
/// # Errors
/// Every body that cannot be filled, at its place in the file.
pub(crate) fn breakables(scene: &Scene, world: &mut World) -> Result<Vec<Breakable>, SceneErrors> {
    let rules = scene.breaking_rules();
    let wanted: Vec<(BodyId, &Breaking)> =
        rules.iter().enumerate().filter_map(|(index, rule)| Some((BodyId(index as u32), (*rule)?))).collect();
    // Copies share their surface, and then their tetrahedra.
    let key = |body: &Body, breaking: &Breaking| {
        (Arc::as_ptr(&body.surface).addr(), breaking.edge.map(f64::to_bits))
    };
    let mut forms: BTreeMap<_, (&Surface, Option<f64>)> = BTreeMap::new();
    for (id, breaking) in &wanted {
        let body = &world.bodies[id.index()];
        forms.entry(key(body, breaking)).or_insert((&*body.surface, breaking.edge));
    }
    let filled: BTreeMap<_, Result<TetMesh, String>> =
        forms.into_par_iter().map(|(key, (surface, edge))| (key, fill(surface, edge))).collect();
    let mut breakables = Vec::new();
    let mut errors: Vec<SceneError> = Vec::new();
    for (id, breaking) in wanted {
        let description = scene.description_of(id);
        let body = &mut world.bodies[id.index()];
        match &filled[&key(body, breaking)] {
            Ok(mesh) => {
                if let Ok(mass) = Piece::whole(mesh).and_then(|piece| piece.mass_properties()) {
                    body.inertia = mass.inertia * (body.mass / mass.volume);
                }
                let seed = breaking.seed.unwrap_or(
                    scene.simulation.seed ^ (u64::from(id.0) + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15),
                );
                breakables.push(Breakable { body: id, mesh: mesh.clone(), breaking: breaking.clone(), seed });
            }
            Err(reason) => {
                let Some(description) = description else { continue };
                let error = SceneError {
                    place: description.geometry_place.clone(),
                    problem: Problem::Geometry {
                        reference: description.reference(0, 1.0).to_string(),
                        reason: format!("it cannot be filled with tetrahedra to break: {reason}"),
                        remedy: "set another `edge` under `fracture`, or repair the mesh".into(),
                    },
                };
                if !errors.contains(&error) {
                    errors.push(error);
                }
            }
        }
    }
    if errors.is_empty() { Ok(breakables) } else { Err(SceneErrors(errors)) }
}

fn fill(surface: &Surface, edge: Option<f64>) -> Result<TetMesh, String> {
    let (geometry, _) = radiating(surface).map_err(|e| e.to_string())?;
    fracture_mesh(&geometry, edge).map_err(|e| e.to_string())
}
