//! Motion of the nodes of a glTF file, text or binary: frames in the world, surfaces, and names of materials.
//!
//! Nodes move with their parents. STEP, LINEAR and CUBICSPLINE are read; the frames of a node are the keys of
//! the finest curve that moves it, and smooth curves are read more finely. A scale of 0 hides a node: it is
//! not born yet, or dead. Metres, y up, seconds: the format allows nothing else.

mod curve;
mod frames;
pub mod implicit_shape;
mod key_times;
pub mod physics;

use std::path::{Path, PathBuf};

use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::pose::Pose;
use glam::DMat4;

use crate::formats::input_file::read_bounded;
use crate::formats::mesh_reader::gltf::document::GltfFile;
use crate::formats::mesh_reader::gltf::{Placed, append_node, placed_nodes};
use crate::formats::mesh_reader::{Located, MOST_BYTES, MeshFault, MeshFileError};
use crate::motion::recording::Frame;
use curve::Curves;
use frames::NodeMotion;
use implicit_shape::{ImplicitShape, ShapeFault};
use key_times::KeyFrames;
use physics::{NodePhysics, PhysicsFault};

/// Why the motion of a glTF file could not be read.
#[derive(Debug, thiserror::Error)]
pub enum GltfMotionError {
    /// The file or its geometry is wrong.
    #[error(transparent)]
    File(#[from] MeshFileError),
    /// A node is wrong.
    #[error("{path}, node {node}: {fault}")]
    Node {
        /// The file.
        path: PathBuf,
        /// Name of the node, or its number.
        node: String,
        /// What is wrong with it.
        fault: NodeFault,
    },
}

/// What is wrong with a node.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NodeFault {
    /// A surface that bones deform.
    #[error("it has a skin; a rigid body cannot be deformed: export each part as an object of its own")]
    Skin,
    /// A scale that is not that of a body.
    #[error(
        "its scale is {x}, {y}, {z} below another node; apply the scale before the export (Blender: \
         Ctrl-A, Scale)"
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
    #[error("its scale is {scale} of the first at t = {time} s; a body may only be hidden (0) or shown (1)")]
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
    #[error("two animations move its {path}; export one animation only")]
    TwoAnimations {
        /// translation, rotation or scale.
        path: &'static str,
    },
    /// An implicit shape that is no solid.
    #[error("its implicit shape cannot be a body: {0}")]
    Shape(#[from] ShapeFault),
    /// Physics that no body has.
    #[error(transparent)]
    Physics(#[from] PhysicsFault),
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
    /// Its name, or `node-N`.
    pub name: String,
    /// Names of the nodes above it, the nearest first.
    pub ancestors: Vec<String>,
    /// Its triangles, if any \[m\], in the frame of the node with its scale.
    pub mesh: Option<TriMesh>,
    /// Name of its material: of its property `material`, of its first triangles, or of its physics material.
    pub material: Option<String>,
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
    /// Number of the node whose curves move it, its own or that of the nearest above it: nodes with one number
    /// move as one.
    pub moved_by: Option<usize>,
}

/// Reads the nodes of the default scene.
///
/// # Errors
/// [`GltfMotionError`] names the file, the node and what to do.
pub fn read_gltf_motion(path: &Path) -> Result<Vec<GltfNode>, GltfMotionError> {
    let bytes =
        read_bounded(path, MOST_BYTES).map_err(|source| MeshFileError::Io { path: path.into(), source })?;
    let in_file = |located: Located| GltfMotionError::from(located.in_file(path));
    let file = GltfFile::open(&bytes, path.parent().unwrap_or(Path::new("."))).map_err(in_file)?;
    check_compression(&file).map_err(in_file)?;
    let placed = placed_nodes(&file.document).map_err(in_file)?;
    let name = |place: usize| node_name(&file, &placed[place]);
    let at_node = |place: usize| {
        let node = name(place);
        move |fault| GltfMotionError::Node { path: path.into(), node, fault }
    };
    let frames = KeyFrames::of_file(&file);
    let mut curves: Vec<Curves> = Vec::with_capacity(placed.len());
    for (place, node) in placed.iter().enumerate() {
        curves.push(Curves::of_node(&file, frames.as_ref(), node.node).map_err(at_node(place))?);
    }
    let mut nodes = Vec::new();
    for place in 0..placed.len() {
        let node = &file.document.nodes[placed[place].node];
        if node.mesh.is_some() && node.skin.is_some() {
            return Err(at_node(place)(NodeFault::Skin));
        }
        let chain: Vec<usize> = std::iter::successors(Some(place), |p| placed[*p].parent).collect();
        let motion = NodeMotion::of_chain(&file, &placed, &curves, &chain).map_err(at_node(place))?;
        let mesh = local_mesh(&file, &placed[place], &motion).map_err(in_file)?;
        let fault = |fault: NodeFault| at_node(place)(fault);
        let mut physics = NodePhysics::of_node(&file.document, node).map_err(|e| fault(e.into()))?;
        physics.centre_of_mass = physics.centre_of_mass.map(|centre| centre * motion.scale);
        let shape = physics.shape.map(|shape| ImplicitShape::of_file(&file.document, shape, motion.scale));
        let shape = shape.transpose().map_err(|e| fault(e.into()))?;
        nodes.push(GltfNode {
            name: name(place),
            ancestors: chain[1..].iter().map(|place| name(*place)).collect(),
            mesh: Some(mesh).filter(|mesh| !mesh.triangles.is_empty()),
            material: material_name(&file, placed[place].node).or_else(|| physics.material.clone()),
            frames: motion.frames,
            start: motion.start,
            birth: motion.birth,
            death: motion.death,
            shape,
            physics,
            is_animated: motion.is_animated,
            moved_by: motion.moved_by,
        });
    }
    Ok(nodes)
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
    Ok(())
}

fn node_name(file: &GltfFile, placed: &Placed) -> String {
    let name = file.document.nodes[placed.node].name.clone();
    name.filter(|name| !name.is_empty()).unwrap_or_else(|| format!("node-{}", placed.node))
}

fn material_name(file: &GltfFile, node: usize) -> Option<String> {
    if let Some(name) = file.document.nodes[node].extras.get("material").and_then(|name| name.as_str()) {
        return Some(name.into());
    }
    let mesh = file.document.meshes.get(file.document.nodes[node].mesh?)?;
    let material = mesh.primitives.first()?.material?;
    file.document.materials.get(material)?.name.clone()
}

/// The triangles of a node in its own frame, scaled.
fn local_mesh(file: &GltfFile, placed: &Placed, motion: &NodeMotion) -> Result<TriMesh, Located> {
    let mut mesh = TriMesh::default();
    let scaled =
        Placed { node: placed.node, parent: placed.parent, transform: DMat4::from_scale(motion.scale) };
    append_node(file, &scaled, &mut mesh)?;
    Ok(mesh)
}
