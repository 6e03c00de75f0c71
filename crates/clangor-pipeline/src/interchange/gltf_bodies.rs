//! The nodes of a glTF file as bodies of a world: those of the scene by their names, others from their meshes.

use clangor_core::body::{Body, BodyId, Life, Motion, World};
use clangor_core::material::{Material, presets};
use clangor_core::pose::Pose;
use glam::DVec3;

use crate::formats::gltf_motion::GltfNode;
use crate::motion::recording::{Frame, RecordedBody};
use crate::stages::load::mesh_geometry;

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
        "node {node}: {reason}; {remedy}. A floor is best a [[plane]] of the scene with the name of the node, \
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
         one (docs/format/materials.md), or describe the body in the scene"
    )]
    Material {
        /// The node.
        node: String,
        /// Name in the file, or "none".
        found: String,
    },
}

/// Adds the nodes to a world: fixed bodies where nothing moves them, and frames of those that are moved.
/// `notices` takes what should be known.
///
/// # Errors
/// [`GltfBodyFault`] names the node.
pub(super) fn add_nodes(
    world: &mut World,
    nodes: Vec<GltfNode>,
    notices: &mut Vec<String>,
) -> Result<Vec<RecordedBody>, GltfBodyFault> {
    let mut recorded = Vec::new();
    let in_scene: Vec<String> = world.bodies.iter().map(|body| body.name.clone()).collect();
    let mut seen: Vec<String> = Vec::new();
    for node in nodes {
        let described = in_scene.iter().position(|name| *name == node.name);
        let belongs_to_other = node.ancestors.iter().any(|name| in_scene.contains(name));
        if described.is_none() && (node.mesh.is_none() || belongs_to_other) {
            continue;
        }
        if described.is_some_and(|index| world.bodies[index].surface.is_plane()) {
            continue;
        }
        if seen.contains(&node.name) {
            return Err(GltfBodyFault::SameName { node: node.name });
        }
        seen.push(node.name.clone());
        let (index, centre) = match described {
            Some(index) => (index, centre_of_mass(&node, notices)),
            None => {
                let (body, centre) = new_body(world, &node, notices)?;
                world.bodies.push(body);
                (world.bodies.len() - 1, centre)
            }
        };
        let at_centre = |pose: Pose| Pose { position: pose.world_from_body(centre), ..pose };
        let body = &mut world.bodies[index];
        body.pose = at_centre(node.start);
        if let Some(mass) = node.mass {
            body.inertia *= mass / body.mass;
            body.mass = mass;
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
        recorded.push(RecordedBody { body: BodyId(index as u32), frames });
    }
    Ok(recorded)
}

/// Centre of mass in the frame of a node that the scene describes.
fn centre_of_mass(node: &GltfNode, notices: &mut Vec<String>) -> DVec3 {
    let Some(mesh) = node.mesh.clone() else { return DVec3::ZERO };
    match mesh_geometry(mesh, 1.0) {
        Ok(geometry) => geometry.mass.centre_of_mass,
        Err(_) => {
            notices.push(format!(
                "node {}: its mesh bounds no solid; its origin is taken for the centre of mass of the body of the scene",
                node.name
            ));
            DVec3::ZERO
        }
    }
}

fn new_body(
    world: &World,
    node: &GltfNode,
    notices: &mut Vec<String>,
) -> Result<(Body, DVec3), GltfBodyFault> {
    let mesh = node.mesh.clone().unwrap_or_default();
    let geometry = mesh_geometry(mesh, 1.0).map_err(|error| GltfBodyFault::Geometry {
        node: node.name.clone(),
        reason: error.reason,
        remedy: error.remedy,
    })?;
    notices.extend(geometry.warnings.iter().map(|warning| format!("node {}: {warning}", node.name)));
    let found = node.material.clone();
    let material = found.as_deref().and_then(|name| material(world, name)).ok_or_else(|| {
        let found = found.unwrap_or_else(|| "none".into());
        GltfBodyFault::Material { node: node.name.clone(), found }
    })?;
    let body = Body::solid(&node.name, material, geometry.surface, &geometry.mass);
    Ok((body, geometry.mass.centre_of_mass))
}

/// The material of a name, which may have the number that Blender gives to copies: `steel.001`.
fn material(world: &World, name: &str) -> Option<Material> {
    let find = |name: &str| {
        let used = world.bodies.iter().map(|body| &body.material).find(|material| material.name == name);
        used.cloned().or_else(|| presets::preset(name))
    };
    let copy =
        name.rsplit_once('.').filter(|(_, end)| end.len() == 3 && end.bytes().all(|b| b.is_ascii_digit()));
    find(name).or_else(|| find(copy?.0))
}
