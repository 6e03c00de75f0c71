//! Solids of nodes: of their meshes, which copies share, or of their implicit shapes.

use std::sync::Arc;

use clangor_core::body::{Body, Surface};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::scene::instantiate::{GeometryError, LoadedGeometry};
use clangor_core::shape::Shape;
use glam::DVec3;

use super::fault::GltfBodyFault;
use crate::formats::gltf_motion::GltfNode;
use crate::formats::gltf_motion::implicit_shape::ImplicitShape;
use crate::stages::load::mesh_geometry;

/// Largest difference of distances of vertices on a sphere, relative; 32-bit files have 1e-7.
const ROUND: f64 = 1e-4;
/// Least volume of a mesh on a sphere over that of the ball: about 80 triangles.
const FILLED: f64 = 0.8;
/// Distance of vertices that is rounding, over the diagonal of the mesh. Programs that apply the transforms
/// of copies round each of them to 32 bits.
const SAME_VERTEX: f64 = 1e-6;

/// Solids of meshes, which copies share.
#[derive(Default)]
pub(super) struct Solids {
    known: Vec<(TriMesh, LoadedGeometry)>,
}

impl Solids {
    fn of(&mut self, mesh: &TriMesh) -> Result<LoadedGeometry, GeometryError> {
        if let Some((_, geometry)) = self.known.iter().find(|(known, _)| is_copy(known, mesh)) {
            return Ok(geometry.clone());
        }
        let geometry = match sphere(mesh) {
            Some(sphere) => sphere,
            None => mesh_geometry(mesh.clone(), 1.0)?,
        };
        self.known.push((mesh.clone(), geometry.clone()));
        Ok(geometry)
    }
}

/// Whether two meshes have the same triangles, and the same vertices up to rounding.
fn is_copy(known: &TriMesh, mesh: &TriMesh) -> bool {
    if known.vertices.len() != mesh.vertices.len() || known.triangles != mesh.triangles {
        return false;
    }
    let most = SAME_VERTEX * known.diagonal();
    known.vertices.iter().zip(&mesh.vertices).all(|(a, b)| a.distance(*b) <= most)
}

/// The ball whose surface a mesh approximates: all vertices at one distance from a point, and most of the
/// volume between them. Its facets would make another contact than a sphere.
fn sphere(mesh: &TriMesh) -> Option<LoadedGeometry> {
    let mass = MassProperties::of(mesh).ok()?;
    let centre = mass.centre_of_mass;
    let distances = || mesh.vertices.iter().map(|vertex| vertex.distance(centre));
    let radius = distances().sum::<f64>() / mesh.vertices.len() as f64;
    let is_round = distances().all(|distance| (distance - radius).abs() < ROUND * radius);
    let ball = MassProperties::of_sphere(radius);
    if !is_round || mass.volume < FILLED * ball.volume {
        return None;
    }
    Some(LoadedGeometry {
        surface: Arc::new(Surface::Sphere { radius }),
        mass: MassProperties { centre_of_mass: centre, ..ball },
        warnings: vec![format!(
            "its {} vertices lie on a sphere of {radius:.6} m, which it is taken for",
            mesh.vertices.len()
        )],
    })
}

/// The solid of a node: of its mesh, or else of its implicit shape; `None` for a plane, and without both.
pub(super) fn solid_of(
    solids: &mut Solids,
    node: &GltfNode,
) -> Result<Option<LoadedGeometry>, GltfBodyFault> {
    let of_mesh = |error| no_solid(node, error);
    if let Some(mesh) = &node.mesh {
        return Ok(Some(solids.of(mesh).map_err(of_mesh)?));
    }
    match node.shape {
        Some(ImplicitShape::Form(form)) => {
            let shape = Shape::try_new(form, None).map_err(|error| error.to_string());
            let solid = shape.and_then(|shape| shape.surface().map_err(|error| error.to_string()));
            let (surface, mass) = solid.map_err(|reason| GltfBodyFault::Geometry {
                node: node.name.clone(),
                reason,
                remedy: "give it a mesh".into(),
            })?;
            Ok(Some(LoadedGeometry { surface: Arc::new(surface), mass, warnings: Vec::new() }))
        }
        Some(shape) => match shape.mesh() {
            Some(mesh) => Ok(Some(solids.of(&mesh).map_err(of_mesh)?)),
            None => Ok(None),
        },
        None => Ok(None),
    }
}

/// Centre of mass of a body of the scene in the frame of its node: as far from that of the node's solid as
/// the scene has it. The origin if the node has no solid.
pub(super) fn centre_of_mass(
    solids: &mut Solids,
    body: &Body,
    node: &GltfNode,
) -> Result<DVec3, GltfBodyFault> {
    let form = body.form_of_uneven().map_or(DVec3::ZERO, |form| form.centre_of_mass);
    Ok(solid_of(solids, node)?.map_or(DVec3::ZERO, |solid| solid.mass.centre_of_mass - form))
}

/// A node whose surface bounds no solid.
pub(super) fn no_solid(node: &GltfNode, error: GeometryError) -> GltfBodyFault {
    GltfBodyFault::Geometry { node: node.name.clone(), reason: error.reason, remedy: error.remedy }
}
