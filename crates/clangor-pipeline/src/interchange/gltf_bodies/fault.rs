//! Nodes that are no bodies: all of them in one message, and what to do.

use std::collections::BTreeSet;
use std::fmt;
use std::path::PathBuf;

use clangor_core::material::presets;

use crate::formats::gltf_motion::NodeFault;

/// Most nodes that a message names; more are counted.
const MOST_NAMED: usize = 50;
/// Most options that a message writes out.
const MOST_OPTIONS: usize = 6;

/// Why a node is no body.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GltfBodyFault {
    /// It cannot be read.
    #[error("node {node}: {fault}")]
    Unreadable {
        /// The node.
        node: String,
        /// What is wrong with it.
        fault: NodeFault,
    },
    /// A surface that bounds no solid.
    #[error("node {node}: {reason}; {remedy}")]
    Geometry {
        /// The node.
        node: String,
        /// What is wrong with its mesh.
        reason: String,
        /// What to do.
        remedy: String,
    },
    /// No material, or one that is not known.
    #[error(
        "node {node}: {}",
        match (found, like) {
            (None, _) => "it has no material".into(),
            (Some(found), None) => format!("its material is {found}, which is not known"),
            (Some(found), Some(like)) => {
                format!("its material is {found}, which is not known; is it {like}?")
            }
        }
    )]
    Material {
        /// The node.
        node: String,
        /// Name in the file.
        found: Option<String>,
        /// A known name that is the same but for case and the number of a copy.
        like: Option<String>,
    },
}

impl GltfBodyFault {
    /// The name of the node.
    pub fn node(&self) -> &str {
        match self {
            GltfBodyFault::Unreadable { node, .. }
            | GltfBodyFault::Geometry { node, .. }
            | GltfBodyFault::Material { node, .. } => node,
        }
    }
}

/// The nodes of a recording that are no bodies, with their files, and what to do.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GltfBodyFaults {
    /// Each with the file that it is in.
    pub list: Vec<(PathBuf, GltfBodyFault)>,
    /// Names of the materials of the scene.
    pub materials: BTreeSet<String>,
}

impl GltfBodyFaults {
    fn known_materials(&self) -> String {
        let scene = self.materials.iter().map(String::as_str).filter(|name| presets::preset(name).is_none());
        let names: Vec<&str> = scene.chain(presets::PRESETS.iter().map(|preset| preset.name)).collect();
        names.join(", ")
    }

    /// The options that leave out the nodes, as a shell reads them.
    fn options(&self) -> String {
        if self.list.len() > MOST_OPTIONS {
            return "--leave-out NAME for each of them, or for a node above them,".into();
        }
        let plain = |name: &str| name.chars().all(|c| c.is_alphanumeric() || "._-/".contains(c));
        let option = |(_, fault): &(PathBuf, GltfBodyFault)| match fault.node() {
            name if plain(name) => format!("--leave-out {name}"),
            name => format!("--leave-out {name:?}"),
        };
        self.list.iter().map(option).collect::<Vec<_>>().join(" ")
    }
}

impl fmt::Display for GltfBodyFaults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.list.len() > 1 {
            writeln!(f, "{} nodes cannot be bodies:", self.list.len())?;
        }
        for (path, fault) in self.list.iter().take(MOST_NAMED) {
            writeln!(f, "{}, {fault}", path.display())?;
        }
        if let more @ 1.. = self.list.len().saturating_sub(MOST_NAMED) {
            writeln!(f, "and {more} more")?;
        }
        let has = |is: fn(&GltfBodyFault) -> bool| self.list.iter().any(|(_, fault)| is(fault));
        if has(|fault| matches!(fault, GltfBodyFault::Material { .. })) {
            writeln!(
                f,
                "Known materials: {} (docs/format/materials.md). Name the material of the node after one, \
                 give the node a property \"material\" with such a name, or describe the body in the scene.",
                self.known_materials()
            )?;
        }
        if has(|fault| matches!(fault, GltfBodyFault::Geometry { .. })) {
            writeln!(
                f,
                "A floor is best a [[plane]] of the scene with the name of the node, whose mesh is then not \
                 used."
            )?;
        }
        write!(
            f,
            "What makes no sound can be left out: {} leaves out a node and all below it; so does an export \
             of less (Blender: Include > Selected Objects, or Visible Objects).",
            self.options()
        )
    }
}
