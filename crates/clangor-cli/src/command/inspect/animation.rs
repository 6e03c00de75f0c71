//! Nodes of an animated glTF file, as `clangor import gltf` would read them: surface, material and keys.

use std::path::Path;

use clangor_pipeline::formats::gltf_motion::{GltfChoice, GltfMotion, GltfNode, read_gltf_motion};
use clangor_pipeline::motion::file_units::{FileUnits, LengthUnit};
use clangor_pipeline::stages::load::mesh_geometry;
use serde_json::{Value, json};

use crate::console::{Console, counted, four_digits};
use crate::failure::Failure;

/// The nodes of a glTF file that has an animation; `None` for any other file.
pub(super) fn read(path: &Path, scale: f64) -> Option<GltfMotion> {
    let ending = path.extension()?.to_str()?.to_ascii_lowercase();
    if !matches!(ending.as_str(), "gltf" | "glb") {
        return None;
    }
    // Other files are reported where the surface is read.
    let units = FileUnits { length: LengthUnit { metres: scale }, ..FileUnits::default() };
    read_gltf_motion(path, &GltfChoice { units, ..GltfChoice::default() })
        .ok()
        .filter(|motion| motion.has_animation)
}

pub(super) fn report(path: &Path, motion: &GltfMotion, console: &Console) -> Result<(), Failure> {
    let solid: Vec<&GltfNode> =
        motion.nodes.iter().filter(|node| node.mesh.is_some() || node.shape.is_some()).collect();
    let faulty: Vec<_> = motion.faults.iter().filter(|node| node.is_solid).collect();
    let times = || solid.iter().filter(|node| node.is_moved).flat_map(|node| &node.frames).map(|f| f.time);
    let (first, last) = (times().fold(f64::INFINITY, f64::min), times().fold(0.0, f64::max));
    let span = if first <= last { format!(", keys from {first:.4} to {last:.4} s") } else { String::new() };
    console.say(format_args!(
        "{}: animation, {} that can be bodies{span}",
        path.display(),
        counted(solid.len(), "node", "nodes")
    ));
    if motion.animations.len() > 1 {
        let names: Vec<String> = motion.animations.iter().map(|name| format!("\"{name}\"")).collect();
        console.say(format_args!(
            "animations {}: clangor import gltf takes one of them by --animation NAME",
            names.join(", ")
        ));
    }
    let mut nodes = Vec::new();
    for node in solid {
        let surface = Surface::of(node);
        console.say(format_args!(
            "node \"{}\": {}, {}, {}",
            node.name,
            surface.text(),
            node.material.as_deref().map_or("no material".into(), |name| format!("material {name}")),
            motion_of(node)
        ));
        nodes.push(json!({
            "name": node.name, "material": node.material, "triangles": surface.triangles,
            "edges_m": surface.edges, "volume_m3": surface.volume, "fault": surface.fault,
            "frames": node.frames.len(), "moves": node.is_moved,
        }));
    }
    for node in &faulty {
        console.warn(format_args!("{node}"));
    }
    let faulty = faulty.iter().map(|node| json!({ "name": node.name, "fault": node.fault.to_string() }));
    let faulty: Vec<Value> = faulty.collect();
    console.say(
        "clangor import gltf SCENE.toml FILE makes a timeline of it; strike, bake and the `mesh` of a scene \
         take one node as FILE#NAME, or all as one body",
    );
    console.json(
        &json!({ "animations": motion.animations, "nodes": nodes, "faults": faulty, "duration_s": last }),
    );
    Ok(())
}

/// How a node is moved.
fn motion_of(node: &GltfNode) -> String {
    let times = [node.frames.first(), node.frames.last()].map(|frame| frame.map(|frame| frame.time));
    let frames = counted(node.frames.len(), "frame", "frames");
    match (node.is_moved, times) {
        (true, [Some(first), Some(last)]) if last > first => {
            let rate = (node.frames.len() - 1) as f64 / (last - first);
            format!("{frames}, {} per second", four_digits(rate))
        }
        (true, _) => frames,
        (false, _) if node.is_animated => "shown and hidden only".into(),
        (false, _) => "does not move".into(),
    }
}

/// The surface of a node.
struct Surface {
    triangles: Option<usize>,
    edges: Option<[f64; 3]>,
    volume: Option<f64>,
    fault: Option<String>,
}

impl Surface {
    fn of(node: &GltfNode) -> Self {
        let Some(mesh) = &node.mesh else {
            return Surface { triangles: None, edges: None, volume: None, fault: None };
        };
        let (low, high) = mesh.bounds();
        let (volume, fault) = match mesh_geometry(mesh.clone(), 1.0) {
            Ok(geometry) => (Some(geometry.mass.volume), None),
            Err(error) => (None, Some(format!("no body: {}; {}", error.reason, error.remedy))),
        };
        let (triangles, edges) = (Some(mesh.triangles.len()), Some((high - low).to_array()));
        Surface { triangles, edges, volume, fault }
    }

    fn text(&self) -> String {
        let (Some(triangles), Some([x, y, z])) = (self.triangles, self.edges) else {
            return "an implicit shape".into();
        };
        let solid = match (&self.fault, self.volume) {
            (Some(fault), _) => fault.clone(),
            (None, Some(volume)) => format!("{volume:.3e} m³"),
            (None, None) => String::new(),
        };
        let triangles = counted(triangles, "triangle", "triangles");
        format!("{triangles}, {} × {} × {} m, {solid}", four_digits(x), four_digits(y), four_digits(z))
    }
}
