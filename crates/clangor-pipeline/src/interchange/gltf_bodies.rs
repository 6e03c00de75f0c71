//! The nodes of a glTF file as bodies of a world: those of the scene by their names, others from their
//! meshes.

use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Life, Motion, Surface, World};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::material::{Material, presets};
use clangor_core::pose::Pose;
use clangor_core::scene::body_description::GivenMass;
use clangor_core::scene::instantiate::{GeometryError, LoadedGeometry};
use clangor_core::shape::Shape;
use glam::DVec3;

use crate::formats::gltf_motion::GltfNode;
use crate::formats::gltf_motion::implicit_shape::ImplicitShape;
use crate::formats::gltf_motion::physics::NodePhysics;
use crate::motion::recording::{Frame, RecordedBody};
use crate::stages::load::mesh_geometry;

/// Largest difference of distances of vertices on a sphere, relative; 32-bit files have 1e-7.
const ROUND: f64 = 1e-4;
/// Distance of two centres of mass that is rounding, over the bounding radius.
const SAME_CENTRE: f64 = 1e-3;
/// Least volume of a mesh on a sphere over that of the ball: about 80 triangles.
const FILLED: f64 = 0.8;

/// Why a node is no body.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GltfBodyFault {
    /// Two nodes of one name.
    #[error("node {node}: there are two of this name; bodies need different names")]
    SameName {
        /// The node.
        node: String,
    },
    /// A surface that bounds no solid.
    #[error(
        "node {node}: {reason}; {remedy}. A floor is best a [[plane]] of the scene with the name of the \
         node, \
         whose mesh is then not used"
    )]
    Geometry {
        /// The node.
        node: String,
        /// What is wrong with its mesh.
        reason: String,
        /// What to do.
        remedy: String,
    },
    /// No material.
    #[error(
        "node {node}: its material is {found}, which is neither one of the scene nor a preset; name it after \
         one (docs/format/materials.md), give the node a property \"material\" with such a name, or \
         describe the \
         body in the scene"
    )]
    Material {
        /// The node.
        node: String,
        /// Name in the file, or "none".
        found: String,
    },
}

/// Adds the nodes to a world: fixed bodies where nothing moves them, and frames of those that are moved. The
/// second value has those of them that are moved from outside. `materials` are those of the scene;
/// `notices` takes what should be known.
///
/// # Errors
/// [`GltfBodyFault`] names the node.
pub(super) fn add_nodes(
    world: &mut World,
    materials: &[Material],
    nodes: Vec<GltfNode>,
    notices: &mut Vec<String>,
) -> Result<(Vec<RecordedBody>, Vec<BodyId>), GltfBodyFault> {
    let (mut recorded, mut kinematic) = (Vec::new(), Vec::new());
    let in_scene: Vec<String> = world.bodies.iter().map(|body| body.name.clone()).collect();
    let mut seen: Vec<String> = Vec::new();
    let is_body = |node: &&GltfNode| node.mesh.is_some() || (node.physics.has_motion && node.shape.is_some());
    let solid: Vec<String> = nodes.iter().filter(is_body).map(|node| node.name.clone()).collect();
    let mut solids = Solids::default();
    for node in nodes {
        let described = in_scene.iter().position(|name| *name == node.name);
        let belongs_to_other = node.ancestors.iter().any(|name| in_scene.contains(name));
        // A collider below a body is a part of it.
        let is_part = node.mesh.is_none() && node.ancestors.iter().any(|name| solid.contains(name));
        let is_solid = node.mesh.is_some() || node.shape.is_some();
        if described.is_none() && (!is_solid || belongs_to_other || is_part) {
            continue;
        }
        if described.is_none() && node.mesh.is_none() && node.material.is_none() {
            notices.push(format!(
                "node {}: it has an implicit shape and no material, and is left out; give it a property \
                 \"material\", or a body of the scene its name",
                node.name
            ));
            continue;
        }
        if described.is_some_and(|index| world.bodies[index].surface.is_plane()) {
            continue;
        }
        if !node.birth.is_finite() {
            notices.push(format!("node {}: it is never shown (scale 0), and left out", node.name));
            continue;
        }
        if seen.contains(&node.name) {
            return Err(GltfBodyFault::SameName { node: node.name });
        }
        seen.push(node.name.clone());
        if node.physics.has_joint {
            notices
                .push(format!("node {}: its joint is not read; the node moves as it is animated", node.name));
        }
        let (index, mut centre) = match described {
            Some(index) => (index, centre_of_mass(&mut solids, &world.bodies[index], &node)?),
            None => {
                let (body, centre) = new_body(world, materials, &mut solids, &node, notices)?;
                world.bodies.push(body);
                (world.bodies.len() - 1, centre)
            }
        };
        let body = &mut world.bodies[index];
        if let Some(given) = node.physics.centre_of_mass.filter(|_| !body.surface.is_plane()) {
            centre = moved_centre(body, centre, given).map_err(|error| no_solid(&node, error))?;
        }
        let at_centre = |pose: Pose| Pose { position: pose.world_from_body(centre), ..pose };
        body.pose = at_centre(node.start);
        if !body.surface.is_plane() {
            apply_physics(body, &node.physics);
        } else if node.is_animated {
            notices.push(format!("node {}: a plane does not move; it stays where it begins", node.name));
            continue;
        }
        if !node.is_animated {
            if described.is_none() {
                body.motion = Motion::Fixed;
            }
            continue;
        }
        body.life = Life { birth: node.birth, death: node.death, parent: None };
        let frames =
            node.frames.iter().map(|frame| Frame { pose: at_centre(frame.pose), ..*frame }).collect();
        let body = BodyId(index as u32);
        kinematic.extend(node.physics.is_kinematic.then_some(body));
        recorded.push(RecordedBody { body, frames, group: node.moved_by });
    }
    Ok((recorded, kinematic))
}

/// Moves the centre of mass of a body, which is at `centre` in the frame of a node, to the given one; they
/// are the same up to rounding in most files. Gives the place of the centre of mass of the body afterwards.
fn moved_centre(body: &mut Body, centre: DVec3, given: DVec3) -> Result<DVec3, GeometryError> {
    let away = given - centre;
    if away.length() <= SAME_CENTRE * body.surface.bounding_radius() {
        return Ok(centre);
    }
    let geometry =
        LoadedGeometry { surface: Arc::clone(&body.surface), mass: body.homogeneous(), warnings: Vec::new() };
    let mass = MassProperties { centre_of_mass: DVec3::ZERO, ..geometry.mass };
    body.surface = LoadedGeometry { mass, ..geometry }.with_centre_of_mass(away)?.surface;
    Ok(given)
}

/// Mass, inertia, restitution and friction as the file has them.
fn apply_physics(body: &mut Body, physics: &NodePhysics) {
    let NodePhysics { mass, inertia, .. } = *physics;
    GivenMass { mass, inertia, centre_of_mass: None }.apply_to(body);
    if let Some(restitution) = physics.restitution {
        body.material = body.material.clone().with_restitution(restitution);
    }
    body.material.friction = physics.friction.unwrap_or(body.material.friction);
}

/// Solids of meshes, which copies share.
#[derive(Default)]
struct Solids {
    known: Vec<(TriMesh, LoadedGeometry)>,
}

impl Solids {
    fn of(&mut self, mesh: &TriMesh) -> Result<LoadedGeometry, GeometryError> {
        if let Some((_, geometry)) = self.known.iter().find(|(known, _)| known == mesh) {
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
fn solid_of(solids: &mut Solids, node: &GltfNode) -> Result<Option<LoadedGeometry>, GltfBodyFault> {
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
fn centre_of_mass(solids: &mut Solids, body: &Body, node: &GltfNode) -> Result<DVec3, GltfBodyFault> {
    let form = body.form_of_uneven().map_or(DVec3::ZERO, |form| form.centre_of_mass);
    Ok(solid_of(solids, node)?.map_or(DVec3::ZERO, |solid| solid.mass.centre_of_mass - form))
}

fn no_solid(node: &GltfNode, error: GeometryError) -> GltfBodyFault {
    GltfBodyFault::Geometry { node: node.name.clone(), reason: error.reason, remedy: error.remedy }
}

fn new_body(
    world: &World,
    materials: &[Material],
    solids: &mut Solids,
    node: &GltfNode,
    notices: &mut Vec<String>,
) -> Result<(Body, DVec3), GltfBodyFault> {
    let solid = solid_of(solids, node)?;
    let found = node.material.clone();
    let material = found.as_deref().and_then(|name| material(world, materials, name)).ok_or_else(|| {
        let found = found.unwrap_or_else(|| "none".into());
        GltfBodyFault::Material { node: node.name.clone(), found }
    })?;
    let Some(geometry) = solid else {
        return Ok((Body::plane(&node.name, material, DVec3::ZERO, DVec3::Y), DVec3::ZERO));
    };
    notices.extend(geometry.warnings.iter().map(|warning| format!("node {}: {warning}", node.name)));
    let body = Body::solid(&node.name, material, geometry.surface, &geometry.mass);
    Ok((body, geometry.mass.centre_of_mass))
}

/// The material of a name, which may have the number that Blender gives to copies: `steel.001`.
fn material(world: &World, materials: &[Material], name: &str) -> Option<Material> {
    let find = |name: &str| {
        let all = world.bodies.iter().map(|body| &body.material).chain(materials);
        let used = all.into_iter().find(|material| material.name == name);
        used.cloned().or_else(|| presets::preset(name))
    };
    let copy =
        name.rsplit_once('.').filter(|(_, end)| end.len() == 3 && end.bytes().all(|b| b.is_ascii_digit()));
    find(name).or_else(|| find(copy?.0))
}
