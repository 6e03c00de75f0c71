//! A body that is one node of a glTF file: `FILE.glb#NODE`, the name as `inspect` prints it.
//!
//! Its triangles are those of the node alone, in its own frame with its scale and that of the nodes above it.

use std::ffi::OsStr;
use std::path::Path;

use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::scene::instantiate::GeometryError;

use crate::formats::gltf_motion::{GltfChoice, GltfMotion, read_gltf_motion};

/// Most names in a message.
const MOST_NAMES: usize = 12;

/// A file, and the name of a node or body in it; a # in the name of an existing file belongs to its name.
pub(crate) fn file_and_node(word: &OsStr) -> (&OsStr, Option<&str>) {
    match word.to_str().and_then(|text| text.rsplit_once('#')) {
        Some((file, node)) if is_gltf_file(file.as_ref()) && !Path::new(word).exists() => {
            (file.as_ref(), Some(node))
        }
        _ => (word, None),
    }
}

/// Whether a name ends like that of a glTF file.
pub(crate) fn is_gltf_file(file: &OsStr) -> bool {
    let ending = Path::new(file).extension().map(OsStr::to_ascii_lowercase);
    ending.is_some_and(|ending| ending == "glb" || ending == "gltf")
}

/// The bodies of a glTF file of several, as the names by which each is taken.
pub(super) fn nodes_to_choose(file: &Path) -> Option<String> {
    if !is_gltf_file(file.as_os_str()) {
        return None;
    }
    let motion = read_gltf_motion(file, &GltfChoice::default()).ok()?;
    let several = motion.nodes.iter().filter(|node| node.mesh.is_some()).nth(1).is_some();
    several.then(|| nodes_with_triangles(&motion, |name| format!("{}#{name}", file.display())))
}

/// The first nodes of a file that have triangles, each as `shown` writes its name.
fn nodes_with_triangles(motion: &GltfMotion, shown: impl Fn(&str) -> String) -> String {
    let bodies = motion.nodes.iter().filter(|node| node.mesh.is_some());
    bodies.take(MOST_NAMES).map(|node| shown(&node.name)).collect::<Vec<_>>().join(", ")
}

/// The triangles of a node.
pub(super) fn node_mesh(file: &Path, name: &str) -> Result<TriMesh, GeometryError> {
    let refused = |reason: String, remedy: &str| GeometryError { reason, remedy: remedy.into() };
    let motion = read_gltf_motion(file, &GltfChoice::default())
        .map_err(|error| refused(error.to_string(), "correct the path, or export the file again"))?;
    if let Some(node) = motion.nodes.iter().find(|node| node.name == name && node.mesh.is_some()) {
        return Ok(node.mesh.clone().unwrap_or_default());
    }
    let file = file.display();
    if let Some(faulty) = motion.faults.iter().find(|faulty| faulty.name == name) {
        return Err(refused(format!("{file}: {faulty}"), "export the file again"));
    }
    let names = nodes_with_triangles(&motion, |name| format!("\"{name}\""));
    let known = if names.is_empty() { "no node with triangles".into() } else { names };
    Err(refused(format!("{file} has no node with triangles \"{name}\""), &format!("it has {known}")))
}
