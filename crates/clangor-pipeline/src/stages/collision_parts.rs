//! The convex parts with which mesh files collide, found before anything moves: in the cache, or by a
//! decomposition.
//!
//! Only the dynamics need them. Modes, fields and strikes of a mesh do without, and a scene gets them from
//! [`find_collision_parts`](mod@super::find_collision_parts). They are made of the mesh as its file has it,
//! so that all scales of a file share one entry of the cache; the entry is named by the hash of mesh and
//! error.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use clangor_core::body::{BodyId, Surface, World};
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::DVec3;
use clangor_core::scene::Scene;
use clangor_core::scene::diagnostic::SceneWarning;
use clangor_sim::decompose::{
    DecomposeError, DecomposeSettings, Decomposition, convex_parts, convex_parts_within,
};

use crate::formats::model_cache::{Lookup, ModelCache, collision_parts_key};

/// A closed mesh as its file has it, and where the body made of it has its origin.
#[derive(Clone, Debug)]
pub struct CollisionMesh {
    mesh: Arc<TriMesh>,
    /// In the frame of the file.
    centre_of_mass: DVec3,
    /// Of the file to metres.
    scale: f64,
}

/// The convex parts of a mesh.
#[derive(Clone, Debug)]
pub struct FoundParts {
    /// In the frame and scale of the file.
    pub decomposition: Decomposition,
    /// Whether the cache had them.
    pub cached: bool,
    /// An entry of the cache that was replaced or could not be written.
    pub remarks: Vec<String>,
}

impl CollisionMesh {
    /// A mesh with its centre of mass, in its own frame, whose unit is `scale` metres.
    pub(super) fn new(mesh: Arc<TriMesh>, centre_of_mass: DVec3, scale: f64) -> Self {
        CollisionMesh { mesh, centre_of_mass, scale }
    }

    /// The same mesh for a body with another centre of mass, in the frame and unit of the file.
    pub(super) fn about(self, centre_of_mass: DVec3) -> Self {
        CollisionMesh { centre_of_mass, ..self }
    }

    /// Bounding radius about the middle of the bounding box, in the unit of the file.
    fn radius(&self) -> f64 {
        let (low, high) = self.mesh.bounds();
        self.mesh.bounding_radius(0.5 * (low + high))
    }

    /// Largest distance of the parts from the surface, over the bounding radius.
    pub fn deviation(&self, parts: &Decomposition) -> f64 {
        parts.surface_error / self.radius()
    }

    /// The same in metres.
    pub fn surface_error(&self, parts: &Decomposition) -> f64 {
        parts.surface_error * self.scale
    }

    /// The convex parts, from the cache or by a decomposition; within `error` of the surface, as a fraction
    /// of the bounding radius, if that can be reached.
    ///
    /// # Errors
    /// [`DecomposeError`].
    pub fn parts(
        &self,
        error: Option<f64>,
        cache: Option<&ModelCache>,
    ) -> Result<FoundParts, DecomposeError> {
        let key = collision_parts_key(&self.mesh, error);
        let mut remarks = Vec::new();
        match cache.map_or(Lookup::Missing, |cache| cache.read_collision_parts(&key)) {
            Lookup::Found(decomposition) => {
                return Ok(FoundParts { decomposition: *decomposition, cached: true, remarks });
            }
            Lookup::Missing => (),
            Lookup::Invalid(reason) => remarks.push(format!("{reason}; the parts are computed again")),
        }
        let decomposition = match error {
            Some(error) => convex_parts_within(&self.mesh, error * self.radius())?,
            None => convex_parts(&self.mesh, DecomposeSettings::default())?,
        };
        if let Some(Err(error)) = cache.map(|cache| cache.write_collision_parts(&key, &decomposition)) {
            remarks.push(format!("the convex parts could not be kept: {error}"));
        }
        Ok(FoundParts { decomposition, cached: false, remarks })
    }

    /// The surface of a body made of this mesh, with its parts.
    pub(super) fn with_parts(&self, surface: &Surface, found: &Decomposition) -> Surface {
        let Surface::Mesh(mesh) = surface else { return surface.clone() };
        let parts = found.parts.iter().map(|p| p.relative_to(self.centre_of_mass).scaled(self.scale));
        Surface::Mesh(mesh.clone().with_parts(parts.collect()))
    }
}

/// The meshes of a scene that collide, and what was found of them.
#[derive(Clone, Debug, Default)]
pub struct Collisions {
    pub(super) meshes: Vec<CollidingMesh>,
    /// One row for each mesh, in the order of its first body; empty before the parts are found.
    pub obtained: Vec<ObtainedParts>,
    /// Parts that are far off the surface.
    pub warnings: Vec<SceneWarning>,
    /// Entries of the cache that were replaced or could not be written.
    pub remarks: Vec<String>,
}

/// A mesh, the largest error of its parts, and the bodies of this mesh and error.
#[derive(Clone, Debug)]
pub(super) struct CollidingMesh {
    pub(super) mesh: CollisionMesh,
    pub(super) error: Option<f64>,
    pub(super) bodies: Vec<BodyId>,
}

/// How the convex parts of a mesh were obtained.
#[derive(Clone, Debug, PartialEq)]
pub struct ObtainedParts {
    /// The first body of the mesh.
    pub body: BodyId,
    /// Number of parts.
    pub parts: usize,
    /// Largest distance from the surface of the body \[m\].
    pub surface_error: f64,
    /// Whether the cache had them.
    pub cached: bool,
    /// Time this took.
    pub time: Duration,
}

impl Collisions {
    /// The bodies of a world whose surfaces were read from mesh files.
    pub(super) fn from_scene(
        scene: &Scene,
        world: &World,
        meshes: impl Iterator<Item = (Arc<Surface>, CollisionMesh)>,
    ) -> Self {
        let address = |surface: &Arc<Surface>| Arc::as_ptr(surface).addr();
        let files: BTreeMap<usize, CollisionMesh> = meshes.map(|(s, m)| (address(&s), m)).collect();
        let mut found: Vec<CollidingMesh> = Vec::new();
        let mut known: BTreeMap<(usize, Option<u64>), usize> = BTreeMap::new();
        for (id, body) in (0..).map(BodyId).zip(&world.bodies) {
            let surface = address(&body.surface);
            let Some(mesh) = files.get(&surface) else { continue };
            let error = scene.description_of(id).and_then(|description| description.collision_error);
            let at = *known.entry((surface, error.map(f64::to_bits))).or_insert(found.len());
            if at == found.len() {
                found.push(CollidingMesh { mesh: mesh.clone(), error, bodies: Vec::new() });
            }
            found[at].bodies.push(id);
        }
        Collisions { meshes: found, ..Collisions::default() }
    }
}
