//! Motion of the nodes of a glTF file, text or binary: frames in the world, surfaces, and names of materials.
//!
//! Nodes move with their parents. STEP, LINEAR and CUBICSPLINE are read; the frames of a node are the keys of
//! the finest curve that moves it, and smooth curves are read more finely. A scale of 0 hides a node: it is
//! not born yet, or dead. Y up, seconds and metres: the format allows nothing else. Files in other units are
//! read in seconds and metres all the same.

mod curve;
mod frames;
pub mod implicit_shape;
mod key_times;
mod node_names;
pub mod physics;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::pose::Pose;
use glam::DMat4;

use crate::formats::input_file::read_bounded;
use crate::formats::mesh_reader::gltf::document::{Animation, GltfFile, Node};
use crate::formats::mesh_reader::gltf::{Placed, append_node, placed_nodes};
use crate::formats::mesh_reader::{Located, MOST_BYTES, MeshFault, MeshFileError};
use crate::motion::file_units::FileUnits;
use crate::motion::recording::{Frame, LengthUnit, TimeUnit};
use curve::{Curves, is_morphed};
use frames::NodeMotion;
use implicit_shape::{ImplicitShape, ShapeFault};
use key_times::KeyFrames;
use node_names::unique_names;
use physics::{NodePhysics, PhysicsFault};

/// What is wrong with a node.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NodeFault {
    /// A surface that bones deform.
    #[error("it has a skin; a rigid body cannot be deformed: export each part as an object of its own")]
    Skin,
    /// A surface whose shape keys move.
    #[error(
        "its shape keys (morph targets) move; a rigid body cannot be deformed: export it without their \
         animation, in one shape"
    )]
    Morph,
    /// A matrix that is no translation, rotation and scale.
    #[error("its matrix shears it; apply the transform before the export (Blender: Ctrl-A, All Transforms)")]
    Shear,
    /// A scale that is not that of a body.
    #[error(
        "its scale is {x}, {y}, {z}; below another node, and where it changes over time, it must be the same \
         along all axes: apply the scale before the export (Blender: Ctrl-A, Scale), and remove keys that \
         squash the body"
    )]
    UnevenScale {
        /// Along x.
        x: f64,
        /// Along y.
        y: f64,
        /// Along z.
        z: f64,
    },
    /// A body that grows.
    #[error(
        "its scale at t = {time} s is {scale} of that where it is first shown; a body may only be hidden (0) \
         or shown (1), by STEP keys"
    )]
    ScaleOverTime {
        /// Time \[s\].
        time: f64,
        /// Scale over that of the first visible frame.
        scale: f64,
    },
    /// A body that comes back.
    #[error("it is shown again at t = {time} s; a body lives once: give it a second object")]
    ShownAgain {
        /// Time \[s\].
        time: f64,
    },
    /// Two curves for one property.
    #[error(
        "the animations {} and {} both move its {path}; choose one by --animation NAME, or export one only \
         (Blender: Animation mode \"Active actions merged\" or \"Scene\")", names[0], names[1]
    )]
    TwoAnimations {
        /// translation, rotation or scale.
        path: &'static str,
        /// Of the animations.
        names: [String; 2],
    },
    /// An implicit shape that is no solid.
    #[error("its implicit shape cannot be a body: {0}")]
    Shape(#[from] ShapeFault),
    /// Physics that no body has.
    #[error(transparent)]
    Physics(#[from] PhysicsFault),
    /// A surface that cannot be read.
    #[error("its mesh cannot be read: {reason}")]
    Mesh {
        /// What is wrong.
        reason: String,
    },
    /// A curve that cannot be read.
    #[error("its {path} cannot be read: {reason}")]
    Curve {
        /// translation, rotation or scale.
        path: &'static str,
        /// What is wrong.
        reason: String,
    },
}

/// A node that may be a body.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfNode {
    /// Its name, or `node-N`; with the names of nodes above it where several nodes have one name.
    pub name: String,
    /// Names of the nodes above it, the nearest first.
    pub ancestors: Vec<String>,
    /// Its triangles, if any \[m\], in the frame of the node with its scale.
    pub mesh: Option<TriMesh>,
    /// Name of its material: of its property `material`, of its first triangles, or of its physics material.
    pub material: Option<String>,
    /// Names of the materials of its other triangles, which are not used.
    pub unused_materials: Vec<String>,
    /// Frames of its origin while it is shown; one for a node that never moves.
    pub frames: Vec<Frame>,
    /// Pose of its origin at its birth.
    pub start: Pose,
    /// First instant at which it is shown \[s\].
    pub birth: f64,
    /// Last instant at which it is shown \[s\]; infinite if it is never hidden.
    pub death: f64,
    /// The implicit shape of its collider (`KHR_implicit_shapes`), with the scale of the node.
    pub shape: Option<ImplicitShape>,
    /// What `KHR_physics_rigid_bodies` says of it.
    pub physics: NodePhysics,
    /// Whether it or a node above it is animated.
    pub is_animated: bool,
    /// Number of the node whose curves move it, its own or that of the nearest above it: nodes with one
    /// number move as one.
    pub moved_by: Option<usize>,
    /// Whether keys of translation or rotation move it or a node above it, and not only those of scale, which
    /// show and hide.
    pub is_moved: bool,
}

/// A node that cannot be a body.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("node {name}: {fault}")]
pub struct FaultyNode {
    /// Its name, as in [`GltfNode`].
    pub name: String,
    /// Whether a body was to be made of it or of a node below it.
    pub is_solid: bool,
    /// What is wrong with it.
    pub fault: NodeFault,
}

/// When an animation begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstKey {
    /// Time of the first key of a body \[s\].
    pub time: f64,
    /// Mean distance of the keys of the finest curve \[s\].
    pub spacing: f64,
}

/// The nodes of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GltfMotion {
    /// Those that may be bodies, each after its parent.
    pub nodes: Vec<GltfNode>,
    /// Those that cannot, in the same order.
    pub faults: Vec<FaultyNode>,
    /// Solid nodes whose names are used several times: the name in the file, and that of the node.
    pub renamed: Vec<[String; 2]>,
    /// Names of all animations of the file, or `animation-N`.
    pub animations: Vec<String>,
    /// Whether there is an animation of those that are read.
    pub has_animation: bool,
    /// The first key of what moves bodies.
    pub first_key: Option<FirstKey>,
    /// Names of nodes that were left out with all below them.
    pub left_out: BTreeSet<String>,
}

/// What of a file is read.
#[derive(Clone, Copy, Debug, Default)]
pub struct GltfChoice<'a> {
    /// Names of nodes that are left out with all below them.
    pub leave_out: &'a [String],
    /// Name of the animation that moves the nodes; by default all of them do.
    pub animation: Option<&'a str>,
    /// Units of the file.
    pub units: FileUnits,
}

/// Reads nodes of the default scene.
///
/// # Errors
/// [`MeshFileError`] names the file, the place and what to do. Nodes that cannot be read are no errors:
/// [`GltfMotion::faults`].
pub fn read_gltf_motion(
    path: &Path,
    GltfChoice { leave_out, animation, units: FileUnits { length, time } }: &GltfChoice<'_>,
) -> Result<GltfMotion, MeshFileError> {
    let bytes =
        read_bounded(path, MOST_BYTES).map_err(|source| MeshFileError::Io { path: path.into(), source })?;
    let in_file = |located: Located| located.in_file(path);
    let mut file = GltfFile::open(&bytes, path.parent().unwrap_or(Path::new("."))).map_err(in_file)?;
    check_compression(&file).map_err(in_file)?;
    let placed = placed_nodes(&file.document).map_err(in_file)?;
    let animations = name_animations(&mut file.document.animations);
    let is_meant = |of: &Animation| animation.is_none_or(|name| of.name.as_deref() == Some(name));
    file.document.animations.retain(is_meant);
    let mut tree = NodeTree::of_file(&file, &placed, *length);
    let mut motion = GltfMotion {
        animations,
        has_animation: file.document.animations.iter().any(|animation| !animation.channels.is_empty()),
        ..GltfMotion::default()
    };
    motion.left_out = tree.leave_out(leave_out);
    let mut unreadable = tree.read_curves(*time);
    motion.first_key = tree.first_key();
    for place in (0..placed.len()).filter(|place| !tree.is_left_out[*place]) {
        let chain: Vec<usize> = tree.chain(place).collect();
        let read = match unreadable.remove(&place) {
            Some(fault) => Err(fault),
            // Reported at the node whose curve it is.
            None if chain.iter().any(|above| tree.is_lost[*above]) => continue,
            None => tree.read_node(&chain),
        };
        let name = tree.names[place].clone();
        let original = node_name(&file, &placed[place]);
        if tree.is_solid[place] && original != name {
            motion.renamed.push([original, name.clone()]);
        }
        match read {
            Ok(node) => motion.nodes.push(node),
            Err(fault) => {
                motion.faults.push(FaultyNode { name, is_solid: tree.carries_solid[place], fault });
            }
        }
    }
    Ok(motion)
}

/// Gives a name to each animation that has none; the names of all.
fn name_animations(animations: &mut [Animation]) -> Vec<String> {
    let name = |(k, animation): (usize, &mut Animation)| {
        animation.name.get_or_insert_with(|| format!("animation-{k}")).clone()
    };
    animations.iter_mut().enumerate().map(name).collect()
}

/// The nodes of a scene on their way to bodies; each list has a value for each of `placed`.
struct NodeTree<'a> {
    file: &'a GltfFile,
    unit: LengthUnit,
    placed: &'a [Placed],
    names: Vec<String>,
    is_solid: Vec<bool>,
    /// Whether it or a node below it is solid.
    carries_solid: Vec<bool>,
    is_left_out: Vec<bool>,
    curves: Vec<Curves>,
    /// Whether its curves cannot be read.
    is_lost: Vec<bool>,
}

impl<'a> NodeTree<'a> {
    fn of_file(file: &'a GltfFile, placed: &'a [Placed], unit: LengthUnit) -> Self {
        let own: Vec<String> = placed.iter().map(|placed| node_name(file, placed)).collect();
        let solid = |node: &Node| node.mesh.is_some() || node.extensions.physics.is_some();
        let is_solid: Vec<bool> = placed.iter().map(|p| solid(&file.document.nodes[p.node])).collect();
        let parents: Vec<Option<usize>> = placed.iter().map(|placed| placed.parent).collect();
        let mut carries_solid = is_solid.clone();
        // Every node comes after its parent.
        for place in (0..placed.len()).rev() {
            if let Some(parent) = parents[place].filter(|_| carries_solid[place]) {
                carries_solid[parent] = true;
            }
        }
        NodeTree {
            file,
            unit,
            placed,
            names: unique_names(&own, &parents, &is_solid),
            is_solid,
            carries_solid,
            is_left_out: vec![false; placed.len()],
            curves: Vec::new(),
            is_lost: vec![false; placed.len()],
        }
    }

    /// Leaves out the nodes of these names and all below them; gives the names that there are.
    fn leave_out(&mut self, names: &[String]) -> BTreeSet<String> {
        let mut found = BTreeSet::new();
        for place in 0..self.placed.len() {
            let original = node_name(self.file, &self.placed[place]);
            let is_meant = |name: &&String| **name == self.names[place] || **name == original;
            let meant: Vec<String> = names.iter().filter(is_meant).cloned().collect();
            let above = self.placed[place].parent;
            self.is_left_out[place] = !meant.is_empty() || above.is_some_and(|above| self.is_left_out[above]);
            found.extend(meant);
        }
        found
    }

    /// Reads the curves of all nodes, with times in this unit; gives what is wrong with them.
    fn read_curves(&mut self, unit: TimeUnit) -> BTreeMap<usize, NodeFault> {
        let mut faults = BTreeMap::new();
        let frames = KeyFrames::of_file(self.file, unit);
        for (place, node) in self.placed.iter().enumerate() {
            let read = match self.is_left_out[place] {
                true => Ok(Curves::default()),
                false => Curves::of_node(self.file, (unit, frames.as_ref()), node.node),
            };
            self.curves.push(read.unwrap_or_else(|fault| {
                self.is_lost[place] = true;
                faults.insert(place, fault);
                Curves::default()
            }));
        }
        faults
    }

    /// The first key of all curves that move solids.
    fn first_key(&self) -> Option<FirstKey> {
        let carrying = self.curves.iter().zip(&self.carries_solid).filter(|(_, carries)| **carries);
        let times: Vec<&[f64]> = carrying.flat_map(|(curves, _)| curves.times()).collect();
        let time = times.iter().filter_map(|times| times.first()).copied().fold(f64::INFINITY, f64::min);
        let spacing = |times: &&[f64]| match times {
            [first, .., last] => (last - first) / (times.len() - 1) as f64,
            _ => f64::INFINITY,
        };
        let spacing = times.iter().map(spacing).fold(f64::INFINITY, f64::min);
        (time.is_finite() && spacing.is_finite()).then_some(FirstKey { time, spacing })
    }

    /// A node and all above it.
    fn chain(&self, place: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(place), |place| self.placed[*place].parent)
    }

    /// The first node of a chain that goes up to the root.
    fn read_node(&self, chain: &[usize]) -> Result<GltfNode, NodeFault> {
        let NodeTree { file, placed, unit, .. } = *self;
        let place = chain[0];
        let node = &file.document.nodes[placed[place].node];
        if node.mesh.is_some() && node.skin.is_some() {
            return Err(NodeFault::Skin);
        }
        if is_morphed(file, placed[place].node)? {
            return Err(NodeFault::Morph);
        }
        let motion = NodeMotion::of_chain(file, (placed, &self.curves), chain, unit)?;
        let mesh = local_mesh(file, &placed[place], &motion)
            .map_err(|located| NodeFault::Mesh { reason: located.fault.to_string() })?;
        let mut physics = NodePhysics::of_node(&file.document, node)?;
        physics.centre_of_mass = physics.centre_of_mass.map(|centre| centre * motion.scale);
        physics.inertia = physics.inertia.map(|inertia| inertia * unit.metres.powi(2));
        let shape = physics.shape.map(|shape| ImplicitShape::of_file(&file.document, shape, motion.scale));
        let (material, unused_materials) = material_names(file, placed[place].node);
        let moves = |place: &usize| {
            self.curves[*place].translation.is_some() || self.curves[*place].rotation.is_some()
        };
        Ok(GltfNode {
            name: self.names[place].clone(),
            ancestors: chain[1..].iter().map(|place| self.names[*place].clone()).collect(),
            mesh: Some(mesh).filter(|mesh| !mesh.triangles.is_empty()),
            material: material.or_else(|| physics.material.clone()),
            unused_materials,
            frames: motion.frames,
            start: motion.start,
            birth: motion.birth,
            death: motion.death,
            shape: shape.transpose()?,
            physics,
            is_animated: motion.is_animated,
            moved_by: motion.moved_by,
            is_moved: chain.iter().any(moves),
        })
    }
}

/// Refuses surfaces and buffers that only a decoder could read.
fn check_compression(file: &GltfFile) -> Result<(), Located> {
    const DRACO: &str = "KHR_draco_mesh_compression";
    let document = &file.document;
    for (index, mesh) in document.meshes.iter().enumerate() {
        if mesh.primitives.iter().any(|primitive| primitive.extensions.contains_key(DRACO)) {
            let reason = "it is compressed by Draco; export it without compression";
            return Err(Located::at_element("mesh", index, MeshFault::Syntax { reason }));
        }
    }
    let meshopt = |name: &String| name == "EXT_meshopt_compression" || name == "KHR_meshopt_compression";
    if document.extensions_used.iter().any(meshopt) {
        let reason = "its buffers are compressed by meshopt; export it without compression";
        return Err(Located::whole(MeshFault::Syntax { reason }));
    }
    if document.extensions_used.iter().any(|name| name == "EXT_mesh_gpu_instancing") {
        let reason = "it has instances (EXT_mesh_gpu_instancing), which are not read; export it without them";
        return Err(Located::whole(MeshFault::Syntax { reason }));
    }
    Ok(())
}

fn node_name(file: &GltfFile, placed: &Placed) -> String {
    let name = file.document.nodes[placed.node].name.clone();
    name.filter(|name| !name.is_empty()).unwrap_or_else(|| format!("node-{}", placed.node))
}

/// The material of a node, and those of its other triangles.
fn material_names(file: &GltfFile, node: usize) -> (Option<String>, Vec<String>) {
    let document = &file.document;
    if let Some(name) = document.nodes[node].extras.get("material").and_then(|name| name.as_str()) {
        return (Some(name.into()), Vec::new());
    }
    let mesh = document.nodes[node].mesh.and_then(|mesh| document.meshes.get(mesh));
    let mut names: Vec<Option<String>> = Vec::new();
    for primitive in mesh.iter().flat_map(|mesh| &mesh.primitives) {
        let material = primitive.material.and_then(|material| document.materials.get(material));
        let name = material.and_then(|material| material.name.clone());
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let mut names = names.into_iter();
    let first = names.next().flatten();
    (first, names.map(|name| name.unwrap_or_else(|| "none".into())).collect())
}

/// The triangles of a node in its own frame, scaled.
fn local_mesh(file: &GltfFile, placed: &Placed, motion: &NodeMotion) -> Result<TriMesh, Located> {
    let mut mesh = TriMesh::default();
    let scaled =
        Placed { node: placed.node, parent: placed.parent, transform: DMat4::from_scale(motion.scale) };
    append_node(file, &scaled, &mut mesh)?;
    Ok(mesh)
}
