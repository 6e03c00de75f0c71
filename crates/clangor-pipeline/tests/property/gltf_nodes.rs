//! Nodes of glTF files as programs write them: set dressing, instances of one name, meshes that differ by
//! rounding, several materials, keys that only show and hide. Each becomes the right body or a message.

use std::fs;
use std::path::Path;

use clangor_core::body::{Body, BodyId, Motion};
use clangor_core::timeline::Timeline;
use clangor_pipeline::formats::timeline_file::TimelineReader;
use clangor_pipeline::interchange::file_frame::FileAxes;
use clangor_pipeline::interchange::motion_import::{MotionFiles, MotionSummary, import_motion};
use clangor_pipeline::motion::recording::LengthUnit;
use clangor_pipeline::stages::load::{load_named, load_scene};
use serde_json::{Value, json};
use tempfile::TempDir;

const SCENE: &str = "version = 1\n[[plane]]\nname = \"floor\"\nmaterial = \"granite\"\n\
                     [[listener]]\nposition = [0.3, 0.4, 0.4]\n";
/// Frames per second of the animations.
const RATE: f32 = 24.0;

/// A glTF file in the making.
#[derive(Default)]
struct File {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
    materials: Vec<String>,
    animations: Vec<Value>,
}

impl File {
    fn accessor(&mut self, bytes: &[u8], kind: u32, count: usize, shape: &str) -> usize {
        let mut accessor = json!({ "bufferView": self.views.len(), "componentType": kind, "count": count });
        accessor["type"] = shape.into();
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() }));
        self.accessors.push(accessor);
        self.bytes.extend(bytes);
        self.accessors.len() - 1
    }

    fn floats(&mut self, values: &[f32], shape: &str) -> usize {
        let width = if shape == "VEC3" { 3 } else { 1 };
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, values.len() / width, shape)
    }

    /// A box of 0.1 m one of whose corners is `moved` along x, with these materials in turn; open at the top
    /// if there is none.
    fn cuboid(&mut self, moved: f32, materials: &[&str]) -> usize {
        let corner = |k: usize| [k & 1, k >> 1 & 1, k >> 2].map(|bit| 0.1 * bit as f32 - 0.05);
        let mut corners: Vec<f32> = (0..8).flat_map(corner).collect();
        corners[21] += moved;
        let positions = self.floats(&corners, "VEC3");
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [0, 4, 6, 2], [1, 3, 7, 5], [2, 6, 7, 3]];
        let triangles: Vec<[u32; 3]> =
            faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        let shown = if materials.is_empty() { &triangles[..10] } else { &triangles[..] };
        let parts = shown.chunks(shown.len().div_ceil(materials.len().max(1)));
        let mut primitives = Vec::new();
        for (at, part) in parts.enumerate() {
            let bytes: Vec<u8> = part.iter().flatten().flat_map(|index| index.to_le_bytes()).collect();
            let indices = self.accessor(&bytes, 5125, 3 * part.len(), "SCALAR");
            let mut primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices });
            if let Some(material) = materials.get(at).or(Some(&"steel")).filter(|name| !name.is_empty()) {
                primitive["material"] = self.materials.len().into();
                self.materials.push((*material).into());
            }
            primitives.push(primitive);
        }
        self.meshes.push(json!({ "primitives": primitives }));
        self.meshes.len() - 1
    }

    fn node(&mut self, node: Value) -> usize {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    /// A node with a box of this material.
    fn solid(&mut self, name: &str, material: &str) -> usize {
        let mesh = self.cuboid(0.0, &[material]);
        self.node(json!({ "name": name, "mesh": mesh, "translation": [2.0, 1.0, 0.0] }))
    }

    /// An animation with one curve.
    fn animate(&mut self, node: usize, path: &str, (keys, values): (&[f32], &[f32]), how: &str) {
        let (input, output) = (self.floats(keys, "SCALAR"), self.floats(values, "VEC3"));
        self.animations.push(json!({
            "channels": [{ "sampler": 0, "target": { "node": node, "path": path } }],
            "samplers": [{ "input": input, "output": output, "interpolation": how }],
        }));
    }

    /// Lets a node fall from 1 m for half a second, with its first key at this frame.
    fn fall(&mut self, node: usize, first: u16) {
        let keys: Vec<f32> = (first..first + 12).map(|frame| f32::from(frame) / RATE).collect();
        let height = |frame: u16| 1.0 - 4.903 * (f32::from(frame) / RATE).powi(2);
        let values: Vec<f32> = (0..12).flat_map(|frame| [0.0, height(frame), 0.0]).collect();
        self.animate(node, "translation", (&keys, &values), "LINEAR");
    }

    fn write(&self, folder: &Path) {
        let children: Vec<u64> = self
            .nodes
            .iter()
            .flat_map(|node| node["children"].as_array().cloned().unwrap_or_default())
            .filter_map(|child| child.as_u64())
            .collect();
        let roots: Vec<usize> =
            (0..self.nodes.len()).filter(|node| !children.contains(&(*node as u64))).collect();
        let names: Vec<Value> = self.materials.iter().map(|name| json!({ "name": name })).collect();
        let document = json!({
            "asset": { "version": "2.0" }, "scenes": [{ "nodes": roots }], "nodes": self.nodes,
            "meshes": self.meshes, "materials": names, "accessors": self.accessors,
            "bufferViews": self.views, "animations": self.animations,
            "buffers": [{ "byteLength": self.bytes.len(), "uri": "data.bin" }],
        });
        fs::write(folder.join("a.gltf"), document.to_string()).unwrap();
        fs::write(folder.join("data.bin"), &self.bytes).unwrap();
    }

    fn import(&self, scene: &str, leave_out: &[&str]) -> Result<Imported, String> {
        self.import_in(LengthUnit::default(), scene, leave_out)
    }

    fn import_in(&self, unit: LengthUnit, scene: &str, leave_out: &[&str]) -> Result<Imported, String> {
        let leave_out = leave_out.iter().map(ToString::to_string).collect();
        let axes = FileAxes { unit, ..FileAxes::default() };
        self.import_with(scene, MotionFiles { leave_out, axes, ..MotionFiles::default() })
    }

    fn import_with(&self, scene: &str, files: MotionFiles) -> Result<Imported, String> {
        let folder = tempfile::tempdir().unwrap();
        self.write(folder.path());
        fs::write(folder.path().join("scene.toml"), scene).unwrap();
        let loaded = load_scene(&folder.path().join("scene.toml"), &|_| ()).unwrap();
        let files = MotionFiles { gltf: vec![folder.path().join("a.gltf")], ..files };
        let out = folder.path().join("out.timeline");
        let summary = import_motion(&loaded, &files, &out, true).map_err(|error| error.to_string())?;
        Ok(Imported { folder, summary })
    }
}

struct Imported {
    folder: TempDir,
    summary: MotionSummary,
}

impl Imported {
    fn reader(&self) -> TimelineReader {
        TimelineReader::open(&self.folder.path().join("out.timeline")).unwrap()
    }

    fn timeline(&self) -> Timeline {
        self.reader().read_all().unwrap()
    }

    fn body(&self, name: &str) -> (BodyId, Body) {
        let bodies = self.reader().header().world.bodies.clone();
        let index = bodies.iter().position(|body| body.name == name);
        let index = index.unwrap_or_else(|| panic!("no {name} in {:?}", bodies.iter().map(|b| &b.name)));
        (BodyId(index as u32), bodies[index].clone())
    }

    fn notices(&self, text: &str) -> usize {
        self.summary.notices.iter().filter(|notice| notice.contains(text)).count()
    }
}

/// A file with one box of steel that falls.
fn falling() -> File {
    let mut file = File::default();
    let cube = file.solid("Cube", "steel");
    file.fall(cube, 0);
    file
}

#[test]
fn property_all_faulty_nodes_are_named_at_once_and_can_be_left_out() {
    let mut file = falling();
    let velvet = file.solid("Cushion", "Velvet");
    let sofa = file.solid("Sofa", "Leather");
    file.nodes[sofa]["children"] = json!([velvet]);
    let open = file.cuboid(0.0, &[]);
    file.node(json!({ "name": "Statue", "mesh": open }));
    let character = file.solid("Old man", "steel");
    file.nodes[character]["skin"] = json!(0);
    let message = file.import(SCENE, &[]).err().unwrap();
    let wanted = [
        "4 nodes cannot be bodies",
        "node Sofa: its material is Leather,",
        "node Cushion: its material is Velvet,",
        "node Statue: the surface is open",
        "Solidify, and Apply Modifiers in the export",
        "node Old man: it has a skin",
        "--leave-out Sofa",
        "--leave-out \"Old man\"",
        "Selected Objects",
    ];
    for text in wanted {
        assert!(message.contains(text), "{text}: {message}");
    }
    assert_eq!(message.matches("steel, copper").count(), 1, "{message}");
    let message = file.import(SCENE, &["Sofa"]).err().unwrap();
    assert!(message.contains("2 nodes cannot be bodies"), "{message}");
    let imported = file.import(SCENE, &["Sofa", "Statue", "Old man"]).unwrap();
    let names: Vec<String> = imported.reader().header().world.bodies.iter().map(|b| b.name.clone()).collect();
    assert_eq!(names, ["floor", "Cube"]);
    let message = file.import(SCENE, &["Sofa", "Sopha"]).err().unwrap();
    assert!(message.contains("no glTF file has a node Sopha"), "{message}");
}

#[test]
fn property_a_message_names_fifty_nodes_and_counts_the_others() {
    let mut file = falling();
    for k in 0..60 {
        file.solid(&format!("Leaf{k}"), "Leather");
    }
    let message = file.import(SCENE, &[]).err().unwrap();
    assert_eq!(message.matches("its material is Leather").count(), 50, "{message}");
    assert!(message.contains("60 nodes cannot be bodies") && message.contains("and 10 more"), "{message}");
}

#[test]
fn property_a_name_of_other_case_suggests_the_material() {
    let with = |material: &str| {
        let mut file = falling();
        file.solid("Box", material);
        file.import(SCENE, &[]).err()
    };
    assert_eq!(with("steel.002"), None);
    for (material, wanted) in [
        ("Steel", "its material is Steel, which is not known; is it steel?"),
        ("WOOD.001", "is it wood?"),
        ("Leather", "its material is Leather, which is not known\n"),
        ("", "node Box: it has no material\n"),
    ] {
        let message = with(material).unwrap();
        assert!(message.contains(wanted), "{message}");
    }
}

/// A file with two instances of a coin below `Inst0` and `Inst1`; the second one falls and is shown from
/// frame 2 on.
fn instances() -> File {
    let mut file = falling();
    for (k, material) in [(0, "brass"), (1, "glass")] {
        let coin = file.solid("Coin", material);
        file.nodes[coin]["translation"] = json!([0.0, 0.0, 0.0]);
        let name = format!("Inst{k}");
        let above = file.node(json!({ "name": name, "children": [coin], "translation": [k + 1, 3.0, 0.0] }));
        if k == 1 {
            file.fall(above, 0);
            let keys = [0.0, 2.0 / RATE, 11.0 / RATE];
            file.animate(coin, "scale", (&keys, &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]), "STEP");
        }
    }
    file
}

#[test]
fn property_nodes_of_one_name_have_those_of_their_parents() {
    let imported = instances().import(SCENE, &[]).unwrap();
    assert_eq!(imported.notices("\"Inst0/Coin\", Coin is \"Inst1/Coin\""), 1, "{:?}", imported.summary);
    let (_, first) = imported.body("Inst0/Coin");
    assert_eq!((first.motion, first.material.name.as_str()), (Motion::Fixed, "brass"));
    let (id, second) = imported.body("Inst1/Coin");
    assert_eq!((second.motion, second.material.name.as_str()), (Motion::Free, "glass"));
    assert_eq!(second.life.birth, 2.0 / f64::from(RATE));
    let poses = imported.timeline().poses;
    let first = poses.iter().find(|row| row.body == id).unwrap();
    assert_eq!(first.time, second.life.birth);
    // The animation is that of the second one, from 1 m at the time 0.
    assert!((first.position.y - (1.0 - 4.903 / 144.0)).abs() < 1e-6, "{}", first.position);
    let imported = instances().import(SCENE, &["Inst1/Coin"]).unwrap();
    assert_eq!(imported.reader().header().world.bodies.len(), 3);
}

#[test]
fn property_a_body_of_the_scene_matches_a_full_name() {
    let body = "[[body]]\nname = \"Inst1/Coin\"\nshape = \"box:0.1x0.1x0.1\"\nmaterial = \"wood\"\n";
    let imported = instances().import(&format!("{SCENE}{body}"), &[]).unwrap();
    let (id, coin) = imported.body("Inst1/Coin");
    assert_eq!((id, coin.material.name.as_str()), (BodyId(0), "wood"));
    assert!(imported.timeline().poses.iter().any(|row| row.body == id));
    assert_eq!(imported.notices("the files have no motion"), 0, "{:?}", imported.summary);
}

#[test]
fn property_a_plane_that_is_not_where_its_node_is_is_told() {
    // The box is 0.05 m high above its node.
    for (y, notices) in [(-0.05, 0), (-0.0495, 0), (-0.048, 1), (0.7, 1)] {
        let mut file = falling();
        let floor = file.solid("floor", "granite");
        file.nodes[floor]["translation"] = json!([0.0, y, 0.0]);
        let imported = file.import(SCENE, &[]).unwrap();
        assert_eq!(
            imported.notices("node floor: its mesh ends at y ="),
            notices,
            "{y}: {:?}",
            imported.summary
        );
    }
}

#[test]
fn property_meshes_that_differ_by_rounding_are_one_solid() {
    // Eight units in the last place of 32 bits, and a dent.
    for (moved, is_same) in [(3e-8, true), (1e-4, false)] {
        let mut file = falling();
        let mesh = file.cuboid(moved, &["steel"]);
        file.node(json!({ "name": "Copy", "mesh": mesh }));
        let imported = file.import(SCENE, &[]).unwrap();
        let ((_, cube), (_, copy)) = (imported.body("Cube"), imported.body("Copy"));
        assert_eq!(cube.surface == copy.surface, is_same, "{moved}");
        assert!(copy.pose.position.x.abs() < 2e-4, "{}", copy.pose.position);
    }
}

#[test]
fn property_a_file_in_centimetres_gives_the_bodies_and_the_motion_of_one_in_metres() {
    let mass = json!({ "motion": { "mass": 2.0, "centerOfMass": [0.01, 0.0, 0.0],
                                   "inertiaDiagonal": [0.004, 0.004, 0.004] } });
    let mut metres = falling();
    metres.nodes[0]["extensions"] = json!({ "KHR_physics_rigid_bodies": mass });
    let expected = metres.import(SCENE, &[]).unwrap();
    let mut large = metres;
    large.nodes[0]["extensions"]["KHR_physics_rigid_bodies"]["motion"]["inertiaDiagonal"] =
        json!([40, 40, 40]);
    large.node(json!({ "name": "Root", "scale": [100, 100, 100], "children": [0] }));
    let message = large.import(SCENE, &[]).err().unwrap();
    assert!(message.contains("m/s") && message.ends_with("import it with --scale 0.01"), "{message}");
    // Below the speed of sound, a warning says that the file falls too fast, and no notice that it is large.
    let tenth = large.import_in(LengthUnit { metres: 0.1 }, SCENE, &[]).unwrap();
    let warning = &tenth.summary.warnings[0];
    assert!(warning.contains("Cube falls with 98.1 m/s²") && warning.ends_with("--scale 0.01"), "{warning}");
    assert_eq!(tenth.notices("m across"), 0, "{:?}", tenth.summary);
    // Without any fall, the size is all there is.
    let mut still = falling();
    still.animations.clear();
    still.animate(0, "translation", (&[0.0, 1.0], &[0.0, 1.0, 0.0, 0.0, 0.5, 0.0]), "LINEAR");
    let still = still.import_in(LengthUnit { metres: 10.0 }, SCENE, &[]).unwrap();
    assert_eq!(still.notices("1.7 m across; a file in centimetres"), 1, "{:?}", still.summary);
    assert_eq!(still.summary.warnings, [""; 0]);
    let read = large.import_in(LengthUnit { metres: 0.01 }, SCENE, &[]).unwrap();
    assert_eq!(read.notices("m across"), 0, "{:?}", read.summary);
    let ((_, expected_body), (_, body)) = (expected.body("Cube"), read.body("Cube"));
    // Seen: no difference.
    let radius = expected_body.surface.bounding_radius();
    assert!((body.surface.bounding_radius() / radius - 1.0).abs() < 1e-6);
    assert!(body.pose.position.distance(expected_body.pose.position) < 1e-6, "{}", body.pose.position);
    let difference = body.inertia - expected_body.inertia;
    let largest = difference.to_cols_array().into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    assert!(largest < 1e-12 * expected_body.inertia.x_axis.x, "{}", body.inertia);
    let (expected, read) = (expected.timeline().poses, read.timeline().poses);
    assert_eq!(expected.len(), read.len());
    for (a, b) in expected.iter().zip(&read) {
        assert!(a.position.distance(b.position) < 1e-6, "{} for {}", b.position, a.position);
    }
}

#[test]
fn property_what_is_only_shown_and_hidden_stands_still() {
    let shown = |file: &mut File| {
        let plate = file.solid("Box", "wood");
        let keys = [0.0, 2.0 / RATE];
        file.animate(plate, "scale", (&keys, &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]), "STEP");
    };
    let mut file = falling();
    shown(&mut file);
    let imported = file.import(SCENE, &[]).unwrap();
    assert_eq!(imported.notices("Box"), 0, "{:?}", imported.summary);
    let (_, plate) = imported.body("Box");
    assert_eq!((plate.motion, plate.life.birth), (Motion::Fixed, 2.0 / f64::from(RATE)));
    let mut file = File::default();
    shown(&mut file);
    let message = file.import(SCENE, &[]).err().unwrap();
    assert!(message.contains("only keys of scale, which show and hide Box,"), "{message}");
}

#[test]
fn property_animations_that_are_missing_or_double_name_the_setting() {
    let mut file = File::default();
    let cube = file.solid("Cube", "steel");
    let message = file.import(SCENE, &[]).err().unwrap();
    for text in ["has no animation", "Bake to Keyframes", "Bake All Objects Animations"] {
        assert!(message.contains(text), "{message}");
    }
    file.fall(cube, 0);
    assert!(file.import(SCENE, &[]).is_ok());
    file.fall(cube, 0);
    let message = file.import(SCENE, &[]).err().unwrap();
    assert!(message.contains("animation-0 and animation-1 both move its translation"), "{message}");
    assert!(message.contains("--animation NAME"), "{message}");
    assert!(message.contains("\"Active actions merged\" or \"Scene\""), "{message}");
}

#[test]
fn property_one_of_several_animations_moves_the_bodies() {
    let mut file = File::default();
    let cube = file.solid("Cube", "steel");
    file.fall(cube, 0);
    file.animations[0]["name"] = "Drop".into();
    // As far up as the other down, in twelve frames.
    let keys: Vec<f32> = (0..12_u16).map(|frame| f32::from(frame) / RATE).collect();
    let values: Vec<f32> = (0..12_u16).flat_map(|frame| [0.0, 1.0 + 0.01 * f32::from(frame), 0.0]).collect();
    file.animate(cube, "translation", (&keys, &values), "LINEAR");
    file.animations[1]["name"] = "Lift".into();
    let end = |animation: &str| {
        let animation = Some(animation.to_string());
        let files = MotionFiles { animation, ..MotionFiles::default() };
        let imported = file.import_with(SCENE, files).unwrap();
        let (body, _) = imported.body("Cube");
        let poses = imported.timeline().poses;
        poses.iter().rfind(|row| row.body == body).unwrap().position.y
    };
    assert!(end("Drop") < 1.0 && end("Lift") > 1.0, "{} {}", end("Drop"), end("Lift"));
    let files = MotionFiles { animation: Some("Rise".into()), ..MotionFiles::default() };
    let message = file.import_with(SCENE, files).err().unwrap();
    assert!(message.contains("no animation Rise"), "{message}");
    assert!(message.contains("known: Drop, Lift"), "{message}");
}

#[test]
fn property_materials_beside_the_first_are_told() {
    let mut file = falling();
    assert_eq!(file.import(SCENE, &[]).unwrap().notices("not used"), 0);
    let mesh = file.cuboid(0.0, &["wood", "steel"]);
    file.node(json!({ "name": "Mallet", "mesh": mesh }));
    let imported = file.import(SCENE, &[]).unwrap();
    assert_eq!(imported.notices("node Mallet: it is of its first material, wood; not used: steel"), 1);
    assert_eq!(imported.body("Mallet").1.material.name, "wood");
}

#[test]
fn property_a_late_first_key_is_told() {
    for (frame, notices) in [(0, 0), (1, 0), (2, 1), (1001, 1)] {
        let mut file = File::default();
        let cube = file.solid("Cube", "steel");
        file.fall(cube, frame);
        let imported = file.import(SCENE, &[]).unwrap();
        let time = f64::from(frame) / f64::from(RATE);
        assert_eq!(imported.notices(&format!("is at t = {time:.4} s")), notices, "{:?}", imported.summary);
        assert_eq!(imported.notices("Set all glTF Animation starting at 0"), notices);
    }
}

#[test]
fn property_shape_keys_shape_the_body_and_may_not_move() {
    // One that doubles a box along y.
    let morphed = || {
        let mut file = falling();
        let offsets: Vec<f32> = (0..8).flat_map(|k| [0.0, 0.1 * (k >> 1 & 1) as f32 - 0.05, 0.0]).collect();
        let target = file.floats(&offsets, "VEC3");
        file.meshes[0]["primitives"][0]["targets"] = json!([{ "POSITION": target }]);
        file
    };
    let mass = |file: &File| file.import(SCENE, &[]).unwrap().body("Cube").1.mass;
    let whole = mass(&morphed());
    let mut file = morphed();
    file.meshes[0]["weights"] = json!([0.5]);
    assert!((mass(&file) / whole - 1.5).abs() < 1e-6, "{}", mass(&file) / whole);
    file.nodes[0]["weights"] = json!([1.0]);
    assert!((mass(&file) / whole - 2.0).abs() < 1e-6, "{}", mass(&file) / whole);
    // An animation that keeps the weights, and one that does not.
    for (weights, is_read) in [([1.0, 1.0], true), ([1.0, 0.5], false), ([0.5, 0.5], false)] {
        let mut file = morphed();
        file.nodes[0]["weights"] = json!([1.0]);
        let (input, output) = (file.floats(&[0.0, 0.4], "SCALAR"), file.floats(&weights, "SCALAR"));
        file.animations.push(json!({
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
            "samplers": [{ "input": input, "output": output }],
        }));
        match file.import(SCENE, &[]) {
            Ok(_) => assert!(is_read, "{weights:?}"),
            Err(message) => assert!(!is_read && message.contains("node Cube: its shape keys"), "{message}"),
        }
    }
}

#[test]
fn property_a_sheared_node_is_refused_and_a_hidden_one_left_out() {
    let mut file = falling();
    let block = file.solid("Block", "steel");
    file.nodes[block].as_object_mut().unwrap().remove("translation");
    let matrix =
        |shear: f64| [1.0, 0.0, 0.0, 0.0, shear, 1.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 2.0, 1.0, 0.0, 1.0];
    file.nodes[block]["matrix"] = json!(matrix(0.5));
    let message = file.import(SCENE, &[]).err().unwrap();
    assert!(message.contains("node Block: its matrix shears it"), "{message}");
    file.nodes[block]["matrix"] = json!(matrix(0.0));
    let straight = file.import(SCENE, &[]).unwrap();
    assert!((straight.body("Block").1.mass / straight.body("Cube").1.mass - 2.0).abs() < 1e-6);
    file.nodes[block]["extensions"] = json!({ "KHR_node_visibility": { "visible": false } });
    let hidden = file.import(SCENE, &[]).unwrap();
    assert_eq!(hidden.notices("never shown"), 1, "{:?}", hidden.summary.notices);
    assert!(hidden.reader().header().world.bodies.iter().all(|body| body.name != "Block"));
}

#[test]
fn property_one_node_of_a_file_is_a_body() {
    let mut file = falling();
    let block = file.solid("Block", "steel");
    file.nodes[block]["scale"] = json!([2.0, 1.0, 1.0]);
    let folder = tempfile::tempdir().unwrap();
    file.write(folder.path());
    let named = |name: &str| load_named(folder.path().join(format!("a.gltf#{name}")), 1.0);
    let volume = |name: &str| named(name).unwrap().mass.volume;
    assert!((volume("Block") / volume("Cube") - 2.0).abs() < 1e-6);
    let unknown = named("Sphere").unwrap_err();
    assert!(unknown.to_string().contains("\"Sphere\"") && unknown.remedy.contains("\"Cube\", \"Block\""));
}
