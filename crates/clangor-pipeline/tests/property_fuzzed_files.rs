//! Every reader of files under changed inputs (`fuzzing`): an error or a result, no panic and no hang, and
//! what is read is finite.
//!
//! CONTRIBUTING.md has the command of the long run.

#[path = "../../clangor-core/tests/fuzzing/mod.rs"]
#[allow(dead_code)]
mod fuzzing;
#[allow(dead_code)]
mod timelines;

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

use clangor_core::scene::Scene;
use clangor_core::timeline::Timeline;
use clangor_pipeline::formats::contact_list::read_contact_list;
use clangor_pipeline::formats::gltf_motion::{GltfChoice, read_gltf_motion};
use clangor_pipeline::formats::mesh_reader::read_mesh;
use clangor_pipeline::formats::named_bodies::NamedBodies;
use clangor_pipeline::formats::pose_table::read_pose_table;
use clangor_pipeline::formats::timeline_file::TimelineReader;
use clangor_pipeline::formats::wav::{Meaning, SampleFormat, WavReader, WavSpec, WavWriter};
use clangor_pipeline::interchange::audio_rigid_bodies::read_audio_bodies;
use clangor_pipeline::interchange::body_files::{ListedMotion, import_contacts};
use clangor_pipeline::stages::load::{load_mesh, load_scene, scene_from_text};
use clangor_pipeline::stages::simulate::{check_motion, simulation_settings};
use clangor_sim::simulate;
use fuzzing::{Target, fuzz, in_memory};

/// Longest motion that a scene is given here [s].
const SHORT: f64 = 0.02;
/// Longest wall time of such a motion, after which it is interrupted.
const PATIENCE: Duration = Duration::from_secs(5);

fn text(seeds: &[&str]) -> Vec<Vec<u8>> {
    seeds.iter().map(|seed| seed.as_bytes().to_vec()).collect()
}

fn shown<T, E: std::fmt::Display>(read: Result<T, E>, what: impl Fn(T) -> String) -> String {
    read.map_or_else(|error| error.to_string(), what)
}

/// Words of scenes.
const SCENE_WORDS: [&str; 48] = [
    "[[body]]\n",
    "[[plane]]\n",
    "[[listener]]\n",
    "[[spring]]\n",
    "[[rod]]\n",
    "[[hinge]]\n",
    "[[rope]]\n",
    "[[hang]]\n",
    "[[force]]\n",
    "[[body.support]]\n",
    "[render]\n",
    "[simulation]\n",
    "[room]\n",
    "version = 1\n",
    "shape = \"box:0.1x0.2x0.001\"\n",
    "shape = \"rock:7x0.01\"\n",
    "shape = \"bowl:0.06x0.003\"\n",
    "shape = \"coin:0.01x0.002\"\n",
    "shape = \"torus:0.03x0.01\"\n",
    "material = \"glass\"\n",
    "count = 3\n",
    "mesh = \"a.obj\"\n",
    "scale = 0.001\n",
    "solver = \"rigid\"\n",
    "solver = \"spheres\"\n",
    "thin = true\n",
    "position = [0, 0, 0]\n",
    "velocity = [0, -3, 0]\n",
    "angular_velocity = [1, 2, 300]\n",
    "press = 3\n",
    "keyframes = [{ time = 0, position = [0, 0, 0] }, { time = 0.01, position = [0, 1, 0] }]\n",
    "placement = { region = [[0, 0, 0], [1, 1, 1]], seed = 3 }\n",
    "let_go = 0.01\n",
    "gravity = [0, 0, 0]\n",
    "stiffness = 1e12\n",
    "rest_length = 0\n",
    "damping = 1e12\n",
    "breaks = true\n",
    "restitution = 0\n",
    "duration = 0.01\n",
    "time_step = 1e-6\n",
    "point = [0, 0, 0]\n",
    "to = [0, 1, 0]\n",
    "axis = [0, 0, 0]\n",
    "[material.mine]\nbase = \"steel\"\n",
    "youngs_modulus = 1\n",
    "motion = \"fixed\"\n",
    "'''",
];

/// A scene of every kind of section that moves or holds bodies.
const SCENE: &str = r#"
version = 1
gravity = [0.0, -9.81, 0.0]
[simulation]
duration = 0.02
time_step = 0.00025
[medium]
sound_speed = 343.0
[material.mine]
base = "steel"
restitution = 0.3
[[body]]
name = "ball"
shape = "sphere:0.005"
material = "mine"
position = [0, 0.006, 0]
velocity = [0.1, -1.0, 0]
[[body]]
name = "die"
shape = "box:0.01x0.01x0.01"
material = "glass"
position = [0.03, 0.02, 0]
angular_velocity = [3.0, 100.0, 0.0]
[[body]]
name = "held"
shape = "sphere:0.01"
material = "brass"
position = [0.1, 0.05, 0]
[[spring]]
body = "held"
to = [0.1, 0.1, 0]
stiffness = 1e9
damping = 0.1
[[rod]]
body = "die"
to = [0.03, 0.05, 0]
[[plane]]
material = "wood"
[[listener]]
position = [0, 0.5, 0.5]
"#;

fn scene_seeds() -> Vec<Vec<u8>> {
    let shipped = ["newtons-cradle", "pool-break", "dice", "bell", "set-down-mug", "ball-drop"];
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let read = |name: &str| fs::read(folder.join(name).with_extension("toml")).unwrap();
    let mut seeds = text(&[SCENE]);
    seeds.extend(shipped.map(read));
    seeds
}

#[test]
fn fuzz_scenes() {
    let target = Target::parser("scenes", "toml", scene_seeds(), &SCENE_WORDS);
    fuzz(&target, &|_, bytes| {
        let text = String::from_utf8_lossy(bytes);
        shown(Scene::from_toml(&text), |scene| format!("a scene of {}", scene.bodies.len().min(5)))
    });
}

/// The first instants of a scene, if they are few steps of few bodies.
fn brief(scene: &mut Scene) {
    let simulation = &mut scene.simulation;
    simulation.duration = simulation.duration.min(SHORT);
    simulation.time_step = simulation.time_step.max(1e-4);
}

#[test]
fn fuzz_simulated_scenes() {
    let target = Target { runs: true, ..Target::parser("simulated", "toml", scene_seeds(), &SCENE_WORDS) };
    fuzz(&target, &|path, bytes| {
        let Ok(text) = String::from_utf8(bytes.to_vec()) else { return "no text".into() };
        let loaded = match scene_from_text(path, text, &brief) {
            Ok(loaded) => loaded,
            Err(error) => return error.to_string(),
        };
        if let Err(error) = check_motion(&loaded) {
            return error.to_string();
        }
        let mut timeline = Timeline::default();
        let start = Instant::now();
        let patient =
            |_| if start.elapsed() < PATIENCE { ControlFlow::Continue(()) } else { ControlFlow::Break(()) };
        let settings = simulation_settings(&loaded.scene, true);
        let report = simulate(&loaded.world, &settings, &mut timeline, &mut { patient });
        let finite =
            |row: &clangor_core::timeline::PoseRow| row.position.is_finite() && row.velocity.is_finite();
        assert!(timeline.poses.iter().all(finite));
        assert!(timeline.contacts.iter().all(|row| row.impulse().is_finite() && row.point.is_finite()));
        shown(report, |report| format!("moved, {} impacts", report.impacts.min(3)))
    });
}

const OBJ: &str = "# a tetrahedron\no body\nv 0 0 0\nv 1 0 0\nv 0 1.5 0\nv 0 0 1e-1\nvn 0 0 1\nvt 0 0\n\
                   f 1 3 2\nf 1/1/1 2/1 4//1\nf -4 -1 -2\ng part\nusemtl x\nf 2 3 4\n";
const OBJ_WORDS: [&str; 14] = [
    "v ",
    "f ",
    "vn ",
    "g ",
    "o ",
    "l ",
    "\\\n",
    "/",
    "//",
    "-1",
    "nan",
    "1e39",
    "\r\n",
    "f 1 2 3 4 1 2 3 4\n",
];

fn meshed(path: &Path) -> String {
    shown(read_mesh(path), |mesh| {
        assert!(mesh.vertices.iter().all(|v| v.is_finite()));
        let count = mesh.vertices.len() as u32;
        assert!(mesh.triangles.iter().flatten().all(|corner| *corner < count));
        format!("{} triangles", mesh.triangles.len().min(9))
    })
}

#[test]
fn fuzz_obj() {
    fuzz(&Target::parser("obj", "obj", text(&[OBJ]), &OBJ_WORDS), &|path, _| meshed(path));
}

const PLY: &str = "ply\nformat ascii 1.0\ncomment ours\nelement vertex 4\n\
                   property double x\nproperty float y\n\
                   property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n\
                   0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
const PLY_WORDS: [&str; 14] = [
    "element face 3\n",
    "element other 2\n",
    "property list uchar int vertex_indices\n",
    "property double x\n",
    "property uchar red\n",
    "property list double double v\n",
    "binary_little_endian",
    "binary_big_endian",
    "end_header\n",
    "format ascii 1.0\n",
    "ascii",
    "list",
    "uint",
    "float",
];

fn binary_ply() -> Vec<u8> {
    let header = PLY.split_once("end_header\n").unwrap().0.replace("ascii", "binary_little_endian");
    let mut bytes = format!("{header}end_header\n").into_bytes();
    for [x, y, z] in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0_f32]] {
        bytes.extend(f64::from(x).to_le_bytes());
        bytes.extend([y, z].map(f32::to_le_bytes).concat());
    }
    for face in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3_i32]] {
        bytes.push(3);
        bytes.extend(face.map(i32::to_le_bytes).concat());
    }
    bytes
}

#[test]
fn fuzz_ply() {
    let seeds = vec![PLY.as_bytes().to_vec(), binary_ply()];
    fuzz(&Target::parser("ply", "ply", seeds, &PLY_WORDS), &|path, _| meshed(path));
}

const STL: &str = "solid ours\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
                   endloop\nendfacet\nendsolid ours\n";

#[test]
fn fuzz_stl() {
    let mut binary = vec![0_u8; 80];
    binary.extend(2_u32.to_le_bytes());
    for triangle in 0..2_u8 {
        let number = |k: u8| f32::from(k * triangle % 5).to_le_bytes();
        binary.extend((0..12).flat_map(number));
        binary.extend([0, 0]);
    }
    let words = ["facet normal ", "vertex ", "outer loop\n", "endloop\n", "endfacet\n", "solid", "nan"];
    let seeds = vec![STL.as_bytes().to_vec(), binary];
    fuzz(&Target::parser("stl", "stl", seeds, &words), &|path, _| meshed(path));
}

/// Words of glTF.
const GLTF_WORDS: [&str; 38] = [
    "\"nodes\":[",
    "\"children\":[0,1]",
    "\"mesh\":0",
    "\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]",
    "\"scale\":[0,0,0]",
    "\"scale\":[-1,1,1]",
    "\"rotation\":[0,0,0,0]",
    "\"translation\":[1e308,0,0]",
    "\"primitives\":[",
    "\"mode\":4",
    "\"mode\":5",
    "\"indices\":0",
    "\"POSITION\":0",
    "\"componentType\":5123",
    "\"componentType\":5126",
    "\"count\":4294967295",
    "\"byteOffset\":18446744073709551615",
    "\"byteStride\":0",
    "\"sparse\":{\"count\":1}",
    "\"type\":\"VEC3\"",
    "\"type\":\"MAT4\"",
    "\"bufferView\":99",
    "\"uri\":\"data:application/octet-stream;base64,AAAA\"",
    "\"uri\":\"../x\"",
    "\"byteLength\":0",
    "\"animations\":[",
    "\"samplers\":[",
    "\"channels\":[",
    "\"interpolation\":\"CUBICSPLINE\"",
    "\"extensions\":{",
    "\"KHR_implicit_shapes\":{\"shapes\":[{\"type\":\"sphere\",\"sphere\":{\"radius\":0}}]}",
    "null",
    "{}",
    "[]",
    "\"KHR_audio_rigid_bodies\":{",
    "\"path\":\"weights\"",
    "\"normalized\":true",
    "\"skin\":0",
];

/// Base64 of some bytes.
fn base64(bytes: &[u8]) -> String {
    const SIGNS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in bytes.chunks(3) {
        let word = (0..3).fold(0_u32, |word, k| word << 8 | u32::from(three.get(k).copied().unwrap_or(0)));
        for k in 0..4 {
            let sign = SIGNS[(word >> (18 - 6 * k) & 63) as usize] as char;
            text.push(if k <= three.len() as u32 { sign } else { '=' });
        }
    }
    text
}

/// A tetrahedron that moves along a line of two keys.
fn gltf() -> String {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0_f32]];
    let mut bytes: Vec<u8> = corners.concat().into_iter().flat_map(f32::to_le_bytes).collect();
    bytes.extend([0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3_u16].into_iter().flat_map(u16::to_le_bytes));
    bytes.extend([0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0_f32].into_iter().flat_map(f32::to_le_bytes));
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
"nodes":[{{"name":"die","mesh":0,"rotation":[0,0,0,1],"children":[1]}},
{{"name":"child","translation":[0,1,0]}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"mode":4}}]}}],
"animations":[{{"samplers":[{{"input":2,"output":3,"interpolation":"LINEAR"}}],
"channels":[{{"sampler":0,"target":{{"node":0,"path":"translation"}}}}]}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]}},
{{"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}},
{{"bufferView":2,"componentType":5126,"count":2,"type":"SCALAR","min":[0],"max":[0.5]}},
{{"bufferView":2,"byteOffset":8,"componentType":5126,"count":2,"type":"VEC3"}}],
"bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":24}},
{{"buffer":0,"byteOffset":72,"byteLength":32}}],
"buffers":[{{"byteLength":{},"uri":"data:application/octet-stream;base64,{}"}}]}}"#,
        bytes.len(),
        base64(&bytes)
    )
}

/// The binary container of a glTF without a buffer of its own.
fn glb() -> Vec<u8> {
    let mut json = gltf().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((20 + json.len() as u32).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes
}

#[test]
fn fuzz_gltf() {
    let target = Target::parser("gltf", "gltf", text(&[&gltf()]), &GLTF_WORDS);
    fuzz(&target, &|path, _| meshed(path));
}

#[test]
fn fuzz_glb() {
    fuzz(&Target::parser("glb", "glb", vec![glb()], &GLTF_WORDS), &|path, _| meshed(path));
}

#[test]
fn fuzz_gltf_motion() {
    let target = Target::parser("gltf-motion", "gltf", text(&[&gltf()]), &GLTF_WORDS);
    fuzz(&target, &|path, _| {
        shown(read_gltf_motion(path, &GltfChoice::default()), |file| {
            format!("{} nodes", file.nodes.len().min(9))
        })
    });
}

#[test]
fn fuzz_gltf_exchange() {
    let target = Target::parser("gltf-exchange", "gltf", text(&[AUDIO_BODY, &gltf()]), &GLTF_WORDS);
    fuzz(&target, &|path, _| {
        shown(read_audio_bodies(path), |bodies| format!("{} bodies", bodies.len().min(9)))
    });
}

/// A body of the draft extension, without a mesh.
const AUDIO_BODY: &str = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"name":"bar",
"extensions":{"KHR_audio_rigid_bodies":{"model":0,"material":0}}}],
"extensions":{"KHR_audio_rigid_bodies":{"materials":[{"density":7850,"youngsModulus":2e11,"poissonRatio":0.3,
"rayleighDampingAlpha":6,"rayleighDampingBeta":1e-7}],"models":[{"modes":[{"frequency":440,"decay":3.0,
"gains":[1.0,0.5]}],"positions":[0,1]}]}}}"#;

/// Meshes as bodies: mended, closed, weighed.
#[test]
fn fuzz_mended_meshes() {
    let target = Target { runs: true, ..Target::parser("mended", "obj", text(&[OBJ]), &OBJ_WORDS) };
    fuzz(&target, &|path, _| shown(load_mesh(path, 1.0).map_err(|error| error.reason), |_| "a body".into()));
}

const CSV: &str = "# ours\n\
                   t,body_a,body_b,point_x,point_y,point_z,normal_x,normal_y,normal_z,impulse_n,speed,kind\n\
                   0.5,ball,floor,0,0,0,0,1,0,0.001,1.5,impact\n0.6,1,,0,1e-3,0,0,2,0,1e-3,0.1,contact\n";
const JSONL: &str = "{\"t\": 0.5, \"body_a\": \"ball\", \"body_b\": 1, \"point\": [0, 0, 0], \
                     \"normal\": [0, 1, 0], \
                     \"impulse_n\": 1e-3, \"speed\": 1.5}\n# ours\n{\"t\": 0.6, \"body_a\": 0, \"kind\": \
                     \"impact\", \"point\": [0, 0, 0], \"normal\": [0, 0, -1], \"impulse_n\": 1e-3}\n";
const LIST_WORDS: [&str; 20] = [
    "t",
    "body_a",
    "world",
    "ball",
    "floor",
    "impulse_n",
    "impulse_x",
    "couple_x",
    "velocity_x",
    "impact_id",
    "depth",
    "\"impulse\": [0, 0, 0]",
    "\"couple\": [1, 1, 1]",
    "\"depth\": 1",
    "\"kind\": \"contact\"",
    ",",
    "\"",
    "\\u0000",
    "impact",
    "constraint",
];

fn named() -> NamedBodies<'static> {
    NamedBodies::new(["ball", "floor"])
}

fn listed(path: &Path) -> String {
    shown(read_contact_list(path, &named()), |rows| {
        let sane = |row: &clangor_core::timeline::ContactRow| {
            row.time.is_finite()
                && row.impulse().is_finite()
                && row.point.is_finite()
                && row.velocity.is_finite()
        };
        assert!(rows.iter().all(sane), "{rows:?}");
        format!("{} rows", rows.len().min(9))
    })
}

#[test]
fn fuzz_contact_lists() {
    fuzz(&Target::parser("lists-csv", "csv", text(&[CSV]), &LIST_WORDS), &|path, _| listed(path));
    fuzz(&Target::parser("lists-jsonl", "jsonl", text(&[JSONL]), &LIST_WORDS), &|path, _| listed(path));
}

#[test]
fn fuzz_pose_tables() {
    let table = "t,body,position_x,position_y,position_z,\
                 orientation_x,orientation_y,orientation_z,orientation_w\n\
                 0,ball,0,1,0,0,0,0,1\n0.1,ball,0,0.9,0,0,0,0.1,1\n0,1,0,0,0,0,0,0,1\n";
    let words = ["origin_x", "position_x", "orientation_w", "body", "t", ",", "\"", "ball", "floor", "nan"];
    fuzz(&Target::parser("poses", "csv", text(&[table]), &words), &|path, _| {
        shown(read_pose_table(path, &named()), |table| format!("{} bodies", table.bodies.len()))
    });
}

fn copy_folder(from: &Path, to: &Path) {
    fs::create_dir(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap().path();
        let copy = to.join(entry.file_name().unwrap());
        if entry.is_dir() {
            copy_folder(&entry, &copy);
        } else {
            fs::copy(&entry, copy).unwrap();
        }
    }
}

/// Bytes of a timeline's description and of its tables, without the hashes that would hide every change.
fn timeline_seeds() -> (tempfile::TempDir, std::path::PathBuf) {
    let (_folder, recorded, _) = timelines::broken();
    let folder = tempfile::tempdir_in(in_memory()).unwrap();
    let path = folder.path().join("fuzzed.timeline");
    copy_folder(&recorded, &path);
    let file = path.join("timeline.json");
    let mut description: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
    for table in ["contacts", "poses"] {
        description[table].as_object_mut().unwrap().remove("hash").unwrap();
    }
    fs::write(&file, serde_json::to_string_pretty(&description).unwrap()).unwrap();
    (folder, path)
}

fn read_folder(path: &Path) -> String {
    let read = TimelineReader::open(path).and_then(|reader| reader.read_all());
    shown(read, |timeline| format!("{} contacts", timeline.contacts.len().min(9)))
}

#[test]
fn fuzz_timeline_descriptions() {
    let (_folder, path) = timeline_seeds();
    let file = path.join("timeline.json");
    let words = [
        "null",
        "[]",
        "{}",
        "1e999",
        "-1",
        "\"radius\":",
        "\"half_space\"",
        "\"keyframed\":",
        "\"life\":",
        "true",
    ];
    let target = Target::parser("timeline-json", "json", vec![fs::read(&file).unwrap()], &words);
    fuzz(&target, &|_, bytes| {
        fs::write(&file, bytes).unwrap();
        read_folder(&path)
    });
}

#[test]
fn fuzz_timeline_tables() {
    for (name, table) in [
        ("timeline-contacts", "contacts.parquet"),
        ("timeline-poses", "poses.parquet"),
        ("timeline-fractures", "fractures.parquet"),
    ] {
        let (_folder, path) = timeline_seeds();
        let file = path.join(table);
        let target = Target::parser(name, "parquet", vec![fs::read(&file).unwrap()], &["PAR1", "PARE"]);
        fuzz(&target, &|_, bytes| {
            fs::write(&file, bytes).unwrap();
            read_folder(&path)
        });
    }
}

#[test]
fn fuzz_parquet_lists() {
    let (_folder, path) = timeline_seeds();
    let seeds = vec![fs::read(path.join("contacts.parquet")).unwrap()];
    fuzz(&Target::parser("lists-parquet", "parquet", seeds, &["PAR1"]), &|path, _| {
        shown(read_contact_list(path, &NamedBodies::new([""; 5])), |rows| {
            format!("{} rows", rows.len().min(9))
        })
    });
}

#[test]
fn fuzz_wav() {
    let folder = tempfile::tempdir().unwrap();
    let seed = |(at, format): (usize, SampleFormat)| {
        let path = folder.path().join(format!("{at}.wav"));
        let (full_scale, note) = (WavSpec::default_full_scale(format), "ours".into());
        let spec = WavSpec {
            sample_rate: 48_000,
            channels: 2,
            format,
            full_scale,
            meaning: Meaning::Pressure,
            note,
        };
        let mut writer = WavWriter::create(&path, spec).unwrap();
        writer.write(&[0.1, -0.1, 0.5, 0.0]).unwrap();
        writer.finish().unwrap();
        fs::read(&path).unwrap()
    };
    let seeds = [SampleFormat::Float32, SampleFormat::Pcm24].into_iter().enumerate().map(seed);
    let words = ["RIFF", "WAVE", "fmt ", "data", "fact", "LIST", "INFO", "ICMT", "RF64", "ds64"];
    fuzz(&Target::parser("wav", "wav", seeds.collect(), &words), &|path, _| {
        let mut samples = Vec::new();
        let read = WavReader::open(path).and_then(|mut reader| {
            while reader.read(&mut samples, 4096)? > 0 {}
            Ok(reader.info().channels)
        });
        assert!(samples.iter().all(|sample| sample.is_finite()));
        shown(read, |channels| format!("{} channels", channels.min(3)))
    });
}

/// A list moves the bodies of a scene, or is refused.
#[test]
fn fuzz_imported_lists() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let floor = "[[body]]\nname = \"floor\"\nshape = \"box:1x0.1x1\"\nmaterial = \"wood\"\n\
                 motion = \"fixed\"\n\
                 position = [0, -0.05, 0]\n";
    let ball =
        "[[body]]\nname = \"ball\"\nshape = \"sphere:0.01\"\nmaterial = \"steel\"\nposition = [0, 1.25, 0]\n";
    fs::write(&scene, format!("version = 1\n{ball}{floor}[[listener]]\nposition = [0, 1, 1]\n")).unwrap();
    let loaded = load_scene(&scene, &|_| {}).unwrap();
    let output = folder.path().join("out.timeline");
    let target = Target { runs: true, ..Target::parser("imported", "csv", text(&[CSV]), &LIST_WORDS) };
    fuzz(&target, &|path, _| {
        let made = import_contacts(&loaded, path, ListedMotion::Flights, &output, true);
        shown(made, |made| {
            let read = TimelineReader::open(&output).and_then(|reader| reader.read_all()).unwrap();
            assert!(read.poses.iter().all(|row| row.position.is_finite()));
            format!("imported, {} notices", made.notices.len())
        })
    });
}
