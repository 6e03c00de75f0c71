//! The nodes of a glTF file as bodies of a world: those of the scene by their names, others from their
//! meshes.

pub(super) mod fault;
mod materials;
mod solids;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Life, Motion, World};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::material::Material;
use clangor_core::pose::Pose;
use clangor_core::scene::body_description::GivenMass;
use clangor_core::scene::instantiate::{GeometryError, LoadedGeometry};
use glam::DVec3;

use crate::formats::gltf_motion::physics::NodePhysics;
use crate::formats::gltf_motion::{FirstKey, GltfMotion, GltfNode};
use crate::motion::recording::{Frame, RecordedBody};
use fault::GltfBodyFault;
use materials::{material, similar_name};
use solids::{Solids, centre_of_mass, no_solid, solid_of};

/// Distance of two centres of mass that is rounding, over the bounding radius.
const SAME_CENTRE: f64 = 1e-3;
/// Difference of the heights of a plane and of its node that is told: \[m\], and over the size of the node.
const SAME_HEIGHT: (f64, f64) = (1e-3, 0.01);
/// Distances of keys after 0 at which a first key is early.
const EARLY: f64 = 1.5;
/// Names in a notice; more are counted.
const MOST_NAMES: usize = 5;

/// What nodes have become.
#[derive(Default)]
pub(super) struct NodeBodies {
    /// Frames of those that are moved.
    pub(super) recorded: Vec<RecordedBody>,
    /// Those of them that are moved from outside.
    pub(super) kinematic: Vec<BodyId>,
    /// Names of those that are only shown and hidden.
    pub(super) only_shown: Vec<String>,
    /// Diameter of the smallest of those that are moved and have their size from the file \[m\].
    pub(super) smallest: Option<f64>,
    /// Nodes that are no bodies.
    pub(super) faults: Vec<GltfBodyFault>,
}

/// Adds the nodes to a world: fixed bodies where nothing moves them, and frames of those that are moved.
/// `materials` are those of the scene; `notices` takes what should be known.
pub(super) fn add_nodes(
    world: &mut World,
    materials: &[Material],
    motion: GltfMotion,
    notices: &mut Vec<String>,
) -> NodeBodies {
    notices.extend(renamed(&motion.renamed));
    notices.extend(motion.first_key.and_then(late));
    let in_scene: BTreeMap<String, usize> =
        world.bodies.iter().enumerate().rev().map(|(index, body)| (body.name.clone(), index)).collect();
    let is_body = |node: &&GltfNode| node.mesh.is_some() || (node.physics.has_motion && node.shape.is_some());
    let solid = motion.nodes.iter().filter(is_body).map(|node| node.name.clone()).collect();
    let mut added = NodeBodies::default();
    for faulty in motion.faults {
        if faulty.is_solid || in_scene.contains_key(&faulty.name) {
            added.faults.push(GltfBodyFault::Unreadable { node: faulty.name, fault: faulty.fault });
        }
    }
    let mut adder = Adder { world, materials, in_scene, solid, solids: Solids::default(), added, notices };
    for node in &motion.nodes {
        if let Err(fault) = adder.add(node) {
            adder.added.faults.push(fault);
        }
    }
    let Adder { added, world, in_scene, .. } = adder;
    NodeBodies { smallest: smallest(world, &in_scene, &added.recorded), ..added }
}

/// Diameter of the smallest moved body of which the scene does not give the size \[m\].
fn smallest(world: &World, in_scene: &BTreeMap<String, usize>, recorded: &[RecordedBody]) -> Option<f64> {
    let bodies = recorded.iter().map(|body| &world.bodies[body.body.index()]);
    let of_file = bodies.filter(|body| !in_scene.contains_key(&body.name));
    let diameter = |body: &Body| 2.0 * body.surface.bounding_radius();
    of_file.map(diameter).reduce(f64::min)
}

/// A notice of names that several nodes have.
fn renamed(nodes: &[[String; 2]]) -> Option<String> {
    let last = nodes.last()?;
    let first: Vec<String> =
        nodes.iter().take(MOST_NAMES).map(|[from, to]| format!("{from} is \"{to}\"")).collect();
    let more = match nodes.len().saturating_sub(MOST_NAMES) {
        0 => String::new(),
        more => format!(", and {more} more, the last of which is \"{}\"", last[1]),
    };
    Some(format!(
        "several nodes have one name, as instances of a collection do; bodies have the names of their \
         parents too: {}{more}",
        first.join(", ")
    ))
}

/// A notice of an animation that does not begin at 0.
fn late(first: FirstKey) -> Option<String> {
    let FirstKey { time, spacing } = first;
    (time > EARLY * spacing).then(|| {
        format!(
            "the first key of the animation is at t = {time:.4} s, and the sound is silent until then; \
             \"Set all glTF Animation starting at 0\" in the export of Blender puts it at 0"
        )
    })
}

/// Nodes on their way into a world.
struct Adder<'a> {
    world: &'a mut World,
    materials: &'a [Material],
    /// Bodies that were there before.
    in_scene: BTreeMap<String, usize>,
    /// Names of nodes that are bodies by themselves.
    solid: BTreeSet<String>,
    solids: Solids,
    added: NodeBodies,
    notices: &'a mut Vec<String>,
}

impl Adder<'_> {
    fn add(&mut self, node: &GltfNode) -> Result<(), GltfBodyFault> {
        // Also of a node that is no body, as a pivot below one.
        if node.physics.has_joint {
            self.note(node, "its joint is not read; the node moves as it is animated");
        }
        let described = self.in_scene.get(&node.name).copied();
        if described.is_none() && !self.is_candidate(node) {
            return Ok(());
        }
        if let Some(index) = described.filter(|index| self.world.bodies[*index].surface.is_plane()) {
            self.compare_with_plane(index, node);
            return Ok(());
        }
        if !node.birth.is_finite() {
            self.note(node, "it is never shown (scale 0), and left out");
            return Ok(());
        }
        let (index, centre) = match described {
            Some(index) => (index, centre_of_mass(&mut self.solids, &self.world.bodies[index], node)?),
            None => {
                let (body, centre) = self.new_body(node)?;
                self.world.bodies.push(body);
                (self.world.bodies.len() - 1, centre)
            }
        };
        self.put(node, index, centre, described.is_none())
    }

    /// Whether a node that the scene does not describe is a body.
    fn is_candidate(&mut self, node: &GltfNode) -> bool {
        let belongs_to_other = node.ancestors.iter().any(|name| self.in_scene.contains_key(name));
        // A collider below a body is a part of it.
        let is_part = node.mesh.is_none() && node.ancestors.iter().any(|name| self.solid.contains(name));
        let is_solid = node.mesh.is_some() || node.shape.is_some();
        if !is_solid || belongs_to_other || is_part {
            return false;
        }
        let is_bare = node.mesh.is_none() && node.material.is_none();
        if is_bare {
            self.note(
                node,
                "it has an implicit shape and no material, and is left out; give it a property \"material\", \
                 or a body of the scene its name",
            );
        }
        !is_bare
    }

    fn note(&mut self, node: &GltfNode, text: &str) {
        self.notices.push(format!("node {}: {text}", node.name));
    }

    /// Tells where the mesh of a node is not where the plane of the scene is that stands for it.
    fn compare_with_plane(&mut self, index: usize, node: &GltfNode) {
        let Some(mesh) = &node.mesh else { return };
        let Pose { position, orientation } = self.world.bodies[index].pose;
        let normal = orientation * DVec3::Y;
        let heights = mesh.vertices.iter().map(|vertex| node.start.world_from_body(*vertex).dot(normal));
        let (highest, plane) = (heights.fold(f64::NEG_INFINITY, f64::max), position.dot(normal));
        let (length, share) = SAME_HEIGHT;
        if (highest - plane).abs() > length.min(share * mesh.diagonal()) {
            let along = if normal == DVec3::Y { "y" } else { "the height along its normal" };
            self.note(
                node,
                &format!(
                    "its mesh ends at {along} = {highest:.4} m, but the plane of the scene that stands for \
                     it is at {plane:.4} m; give the plane a `point`, or move the node"
                ),
            );
        }
    }

    fn new_body(&mut self, node: &GltfNode) -> Result<(Body, DVec3), GltfBodyFault> {
        let solid = solid_of(&mut self.solids, node)?;
        let found = node.material.as_deref();
        let known = found.and_then(|name| material(self.world, self.materials, name));
        let material = known.ok_or_else(|| GltfBodyFault::Material {
            node: node.name.clone(),
            found: node.material.clone(),
            like: found.and_then(|name| similar_name(self.world, self.materials, name)),
        })?;
        if !node.unused_materials.is_empty() {
            let unused = node.unused_materials.join(", ");
            self.note(node, &format!("it is of its first material, {}; not used: {unused}", material.name));
        }
        let Some(geometry) = solid else {
            return Ok((Body::plane(&node.name, material, DVec3::ZERO, DVec3::Y), DVec3::ZERO));
        };
        geometry.warnings.iter().for_each(|warning| self.note(node, warning));
        let body = Body::solid(&node.name, material, geometry.surface, &geometry.mass);
        Ok((body, geometry.mass.centre_of_mass))
    }

    /// Puts a body, whose centre of mass is at `centre` in the frame of its node, where the node is, and
    /// keeps its frames.
    fn put(
        &mut self,
        node: &GltfNode,
        index: usize,
        mut centre: DVec3,
        is_new: bool,
    ) -> Result<(), GltfBodyFault> {
        let body = &mut self.world.bodies[index];
        let is_plane = body.surface.is_plane();
        if let Some(given) = node.physics.centre_of_mass.filter(|_| !is_plane) {
            centre = moved_centre(body, centre, given).map_err(|error| no_solid(node, error))?;
        }
        let at_centre = |pose: Pose| Pose { position: pose.world_from_body(centre), ..pose };
        body.pose = at_centre(node.start);
        if !is_plane {
            apply_physics(body, &node.physics);
        } else if node.is_animated {
            self.note(node, "a plane does not move; it stays where it begins");
            return Ok(());
        }
        if is_new && !node.is_moved {
            body.motion = Motion::Fixed;
        }
        if node.is_animated {
            body.life = Life { birth: node.birth, death: node.death, parent: None };
        }
        if !node.is_moved {
            self.added.only_shown.extend(node.is_animated.then(|| node.name.clone()));
            return Ok(());
        }
        let frames =
            node.frames.iter().map(|frame| Frame { pose: at_centre(frame.pose), ..*frame }).collect();
        let body = BodyId(index as u32);
        self.added.kinematic.extend(node.physics.is_kinematic.then_some(body));
        self.added.recorded.push(RecordedBody { body, frames, group: node.moved_by });
        Ok(())
    }
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
