//! Input of recorded motion where a reader may go wrong without a message: times in 32 bits, axes, origins,
//! clocks, names that look like numbers, and lists that claim too much.

use std::fs;
use std::path::Path;

use crate::imported_motion::{folder, import, import_in, scene};
use crate::parquet_columns::write_alike;
use clangor_core::body::{BodyId, Motion};
use clangor_core::timeline::Timeline;
use clangor_pipeline::formats::gltf_motion::{GltfChoice, GltfNode, read_gltf_motion};
use clangor_pipeline::formats::timeline_file::TimelineReader;
use clangor_pipeline::interchange::body_files::{ListedMotion, import_contacts};
use clangor_pipeline::interchange::motion_import::{MotionFiles, import_motion};
use clangor_pipeline::motion::file_units::LengthUnit;
use clangor_pipeline::stages::load::load_scene;
use glam::DVec3;
use parquet::basic::{Compression, ZstdLevel};
use serde_json::{Value, json};

const SCENE: &str = scene!(
    r#"[[body]]
name = "anvil"
shape = "box:0.1x0.1x0.1"
material = "steel"
position = [5.0, 0.05, 0.0]
"#
);
const G: f64 = 9.80665;
const HEAD: &str = "t,body,position_x,position_y,position_z\n";
const CONTACTS: &str = "t,body_a,body_b,point_x,point_y,point_z,normal_x,normal_y,normal_z,impulse_n,speed\n";

fn timeline(folder: &Path) -> Timeline {
    TimelineReader::open(&folder.join("out.timeline")).unwrap().read_all().unwrap()
}

/// A ball that falls from 0.5 m and bounces at 0.3161 s with half of its speed, up being axis `up`.
fn falling(rate: f64, up: usize) -> String {
    falling_in(rate, up, 1.0)
}

/// The same with this many units in a metre.
fn falling_in(rate: f64, up: usize, units: f64) -> String {
    let impact = (2.0 * 0.49 / G).sqrt();
    let height = |t: f64| match t < impact {
        true => 0.5 - 0.5 * G * t * t,
        false => 0.01 + 0.5 * G * impact * (t - impact) - 0.5 * G * (t - impact).powi(2),
    };
    let line = |k: u32| {
        let t = f64::from(k) / rate;
        let mut position = [0.0; 3];
        position[up] = units * height(t);
        format!("{t},ball,{},{},{}\n", position[0], position[1], position[2])
    };
    HEAD.to_string() + &(0..(0.5 * rate) as u32).map(line).collect::<String>()
}

/// A curve of the node `stone`.
pub(super) struct Channel {
    pub(super) path: &'static str,
    pub(super) interpolation: &'static str,
    pub(super) keys: Vec<f64>,
    pub(super) values: Vec<f32>,
}

/// Writes `a.gltf`: a tetrahedron of edges 0.1 m with these curves; `node` adds to its node.
pub(super) fn write_gltf(folder: &Path, node: &Value, channels: &[Channel]) {
    let corners = [[0.0_f32, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]];
    let mut bytes: Vec<u8> = corners.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let indices: [u32; 12] = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
    bytes.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
    let mut views = vec![
        json!({ "buffer": 0, "byteOffset": 0, "byteLength": 48 }),
        json!({ "buffer": 0, "byteOffset": 48, "byteLength": 48 }),
    ];
    let mut accessors = vec![
        json!({ "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" }),
        json!({ "bufferView": 1, "componentType": 5125, "count": 12, "type": "SCALAR" }),
    ];
    let (mut samplers, mut targets) = (Vec::new(), Vec::new());
    for Channel { path, interpolation, keys, values } in channels {
        let keys: Vec<f32> = keys.iter().map(|time| *time as f32).collect();
        let (shape, width) = if *path == "rotation" { ("VEC4", 4) } else { ("VEC3", 3) };
        for (floats, shape, width) in [(&keys, "SCALAR", 1), (values, shape, width)] {
            let view = json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": 4 * floats.len() });
            accessors.push(json!({ "bufferView": views.len(), "componentType": 5126,
                "count": floats.len() / width, "type": shape }));
            views.push(view);
            bytes.extend(floats.iter().flat_map(|x| x.to_le_bytes()));
        }
        targets.push(json!({ "sampler": samplers.len(), "target": { "node": 0, "path": path } }));
        let (input, output) = (accessors.len() - 2, accessors.len() - 1);
        samplers.push(json!({ "input": input, "output": output, "interpolation": interpolation }));
    }
    let mut body = json!({ "name": "stone", "mesh": 0 });
    body.as_object_mut().unwrap().extend(node.as_object().unwrap().clone());
    let document = json!({
        "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0] }], "nodes": [body],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "material": 0 }] }],
        "materials": [{ "name": "granite" }],
        "accessors": accessors, "bufferViews": views,
        "buffers": [{ "byteLength": bytes.len(), "uri": "data.bin" }],
        "animations": [{ "channels": targets, "samplers": samplers }],
    });
    fs::write(folder.join("a.gltf"), document.to_string()).unwrap();
    fs::write(folder.join("data.bin"), bytes).unwrap();
}

fn stone(node: &Value, channels: &[Channel]) -> Result<GltfNode, String> {
    let folder = tempfile::tempdir().unwrap();
    write_gltf(folder.path(), node, channels);
    let path = folder.path().join("a.gltf");
    let mut motion = read_gltf_motion(&path, &GltfChoice::default()).map_err(|error| error.to_string())?;
    motion.faults.first().map_or_else(|| Ok(motion.nodes.remove(0)), |fault| Err(fault.to_string()))
}

/// A rise of 1 cm a frame over 60 frames.
fn rising(rate: f64, interpolation: &'static str) -> Channel {
    let keys = (0..60).map(|k| f64::from(k) / rate).collect();
    let values = (0..60).flat_map(|k| [0.0, 0.01 * k as f32, 0.0]).collect();
    Channel { path: "translation", interpolation, keys, values }
}

#[test]
fn property_frames_have_the_values_of_their_keys() {
    for rate in [24.0, 30.0, 24.0 / 1.001] {
        for interpolation in ["STEP", "LINEAR"] {
            let frames = stone(&json!({}), &[rising(rate, interpolation)]).unwrap().frames;
            assert_eq!(frames.len(), 60);
            for (k, frame) in frames.iter().enumerate() {
                assert!((frame.time - k as f64 / rate).abs() < 1e-12, "{rate} Hz, {k}: {}", frame.time);
                let expected = 0.01 * k as f64;
                // Values of 32 bits: 2e-8 seen; the key before would be 0.01 off.
                let error = (frame.pose.position.y - expected).abs();
                assert!(error < 1e-7, "{interpolation} at {rate} Hz, frame {k}: off by {error}");
            }
        }
    }
}

#[test]
fn property_a_birth_on_a_frame_is_at_its_time() {
    for rate in [24.0, 30.0] {
        for birth in 1..58 {
            let birth_time = f64::from(birth) / rate;
            let values = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0];
            let keys = vec![0.0, birth_time, 59.0 / rate];
            let scale = Channel { path: "scale", interpolation: "STEP", keys, values };
            let channels = [rising(rate, "LINEAR"), scale];
            let node = stone(&json!({}), &channels).unwrap();
            assert_eq!(node.birth, birth_time, "frame {birth} at {rate} Hz");
            assert_eq!(node.frames[0].time, birth_time, "frame {birth} at {rate} Hz");
            if birth % 10 == 7 {
                let folder = folder(SCENE, &[]);
                write_gltf(folder.path(), &json!({}), &channels);
                import(folder.path(), &["a.gltf"], &[], false).unwrap();
            }
        }
    }
}

#[test]
fn property_keys_beyond_an_hour_are_refused_with_node_and_key() {
    for (time, wanted) in [(1e30, "key 1 is at t = 10000000"), (-1.0, "key 0 is at t = -1 s")] {
        let mut keys = vec![0.0, time];
        keys.sort_by(f64::total_cmp);
        let curve =
            Channel { path: "translation", interpolation: "CUBICSPLINE", keys, values: vec![0.0; 18] };
        let message = stone(&json!({}), &[curve]).unwrap_err();
        assert!(message.contains("node stone") && message.contains(wanted), "{message}");
        assert!(message.contains("0 to 3600 s"), "{message}");
    }
}

#[test]
fn property_frames_cover_all_curves_and_divide_smooth_ones() {
    let turn = |keys: Vec<f64>, interpolation: &'static str| {
        let (rest, quarter) = ([0.0_f32, 0.0, 0.0, 1.0], [0.0, 0.0, 0.5_f32.sqrt(), 0.5_f32.sqrt()]);
        let value = |k: usize| if k == 0 { rest } else { quarter };
        let values: Vec<f32> = match interpolation {
            "CUBICSPLINE" => (0..keys.len()).flat_map(|k| [[0.0; 4], value(k), [0.0; 4]].concat()).collect(),
            _ => (0..keys.len()).flat_map(value).collect(),
        };
        Channel { path: "rotation", interpolation, keys, values }
    };
    // 60 keys within a quarter of a second, and a turn that ends after three seconds.
    let frames = stone(&json!({}), &[rising(240.0, "LINEAR"), turn(vec![0.0, 2.0, 3.0], "LINEAR")]);
    let frames = frames.unwrap().frames;
    assert_eq!(frames.last().unwrap().time, 3.0);
    assert!((frames.last().unwrap().pose.orientation.z - 0.5_f64.sqrt()).abs() < 1e-6);
    // The finest curve is linear, the other is smooth.
    let frames = stone(&json!({}), &[rising(24.0, "LINEAR"), turn(vec![0.0, 2.0], "CUBICSPLINE")]);
    let frames = frames.unwrap().frames;
    assert!(frames.windows(2).all(|w| w[1].time - w[0].time < 1.001 / 240.0 || w[0].time >= 2.0));
    assert!((frames.last().unwrap().time - 59.0 / 24.0).abs() < 1e-12);
}

#[test]
fn property_a_mirrored_node_has_a_mirrored_mesh() {
    let node = stone(&json!({ "scale": [-1.0, 1.0, 1.0] }), &[rising(24.0, "LINEAR")]).unwrap();
    let least = node.mesh.unwrap().vertices.iter().map(|vertex| vertex.x).fold(0.0, f64::min);
    assert!((least + 0.1).abs() < 1e-6, "{least}");
}

#[test]
fn property_axes_and_unit_are_those_of_lists_too() {
    let list = |point: &str, normal: &str| {
        format!(
            "t,body_a,point_x,point_y,point_z,normal_x,normal_y,normal_z,impulse_n,impulse_t_x,impulse_t_y,\
             impulse_t_z,velocity_x,velocity_y,velocity_z\n0.3161,ball,{point},{normal},0.1"
        )
    };
    let y = list("0,0,0", "0,1,0") + ",0.001,0,0.002,0.1,-3,0.2\n";
    let z = list("0,0,0", "0,0,1") + ",0.001,-0.002,0,0.1,-0.2,-3\n";
    let mm = list("0,0,0", "0,0,1") + ",0.001,-0.002,0,100,-200,-3000\n";
    let (y_poses, z_poses) = (falling(240.0, 1), falling(240.0, 2));
    let z_mm_poses = falling_in(240.0, 2, 1e3);
    let folder = folder(SCENE, &[("y.csv", &y_poses), ("z.csv", &z_poses), ("yl.csv", &y), ("zl.csv", &z)]);
    for (name, text) in [("mm.csv", &z_mm_poses), ("mml.csv", &mm)] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    import(folder.path(), &["y.csv"], &["yl.csv"], false).unwrap();
    let expected = timeline(folder.path());
    let millimetres = LengthUnit { metres: 0.001 };
    for (poses, list, unit) in
        [("z.csv", "zl.csv", LengthUnit::default()), ("mm.csv", "mml.csv", millimetres)]
    {
        import_in(folder.path(), &[poses], &[list], (true, unit)).unwrap();
        let turned = timeline(folder.path());
        assert_eq!(turned.poses.len(), expected.poses.len());
        // Seen: poses within 2e-16 m, contacts within 3e-16, the impulse within 4e-5.
        for (a, b) in turned.poses.iter().zip(&expected.poses) {
            assert!(a.position.distance(b.position) < 1e-9, "{} for {}", a.position, b.position);
        }
        let (contacts, expected) = (turned.contacts, &expected.contacts);
        assert_eq!((contacts.len(), contacts[0].body_b), (1, expected[0].body_b));
        for (a, b) in [
            (contacts[0].point, expected[0].point),
            (contacts[0].normal, expected[0].normal),
            (contacts[0].velocity, expected[0].velocity),
            (contacts[0].impulse_t, expected[0].impulse_t),
        ] {
            assert!(a.distance(b) < 1e-6, "{poses}: {a} for {b}");
        }
        // Without a list as a stream, with the same impact.
        import_in(folder.path(), &[poses], &[], (true, unit)).unwrap();
        let found = timeline(folder.path()).contacts;
        assert!((found[0].impulse_n / 0.1529 - 1.0).abs() < 1e-2, "{}", found[0].impulse_n);
    }
}

#[test]
fn property_a_gltf_file_with_z_up_is_told_to_be_exported_again() {
    let folder = folder(SCENE, &[]);
    let fall = (0..60).map(|k| f64::from(k) / 120.0);
    let values = fall.clone().flat_map(|t| [0.0, 3.0, (1.0 - 0.5 * G * t * t) as f32]).collect();
    let keys = fall.collect();
    let curve = Channel { path: "translation", interpolation: "LINEAR", keys, values };
    write_gltf(folder.path(), &json!({}), &[curve]);
    for z_up in [false, true] {
        let notices = import(folder.path(), &["a.gltf"], &[], z_up).unwrap().notices;
        assert!(notices.iter().any(|notice| notice.contains("export it with +Y up")), "{notices:?}");
        assert!(!notices.iter().any(|notice| notice.contains("import it with --up z")), "{notices:?}");
    }
}

#[test]
fn property_origins_are_those_of_the_copy_that_is_named() {
    let tetrahedron = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let scene = SCENE.to_string()
        + "[[body]]\nname = \"ball-1\"\nmesh = \"stone.obj\"\nmaterial = \"steel\"\n\
           position = [2.0, 1.0, 0.0]\n";
    let head = HEAD.replace("position", "origin");
    let poses = format!("{head}0,ball-1,2,1,0\n0.01,ball-1,2,1,0\n");
    let folder = folder(&scene, &[("stone.obj", tetrahedron), ("a.csv", &poses)]);
    import(folder.path(), &["a.csv"], &[], false).unwrap();
    let position = timeline(folder.path()).poses[0].position;
    assert!(position.distance(DVec3::new(2.025, 1.025, 0.025)) < 1e-6, "{position}");
    // A geometry that cannot be read again is an error, not a centre of 0.
    let loaded = load_scene(&folder.path().join("scene.toml"), &|_| ()).unwrap();
    fs::remove_file(folder.path().join("stone.obj")).unwrap();
    let files = MotionFiles { poses: vec![folder.path().join("a.csv")], ..MotionFiles::default() };
    let message = import_motion(&loaded, &files, &folder.path().join("b.timeline"), true).unwrap_err();
    assert!(message.to_string().contains("origins of ball-1"), "{message}");
}

#[test]
fn property_a_described_node_with_an_open_mesh_is_refused() {
    let folder = folder(SCENE, &[]);
    write_gltf(folder.path(), &json!({ "name": "ball" }), &[rising(24.0, "LINEAR")]);
    let path = folder.path().join("a.gltf");
    let open = fs::read_to_string(&path).unwrap().replace("\"count\":12", "\"count\":9");
    fs::write(&path, open).unwrap();
    let message = import(folder.path(), &["a.gltf"], &[], false).unwrap_err();
    assert!(message.contains("node ball"), "{message}");
}

#[test]
fn regression_a_mesh_without_volume_is_refused_with_its_node() {
    let folder = folder(SCENE, &[]);
    write_gltf(folder.path(), &json!({ "scale": [1.0, 0.0, 1.0] }), &[rising(24.0, "LINEAR")]);
    let message = import(folder.path(), &["a.gltf"], &[], false).unwrap_err();
    assert!(message.contains("node stone"), "{message}");
    assert!(!folder.path().join("out.timeline").exists());
}

#[test]
fn property_contacts_of_another_clock_are_refused() {
    let poses = falling(240.0, 1);
    // The ball is at 0.45 m then, and the point below it.
    let above = format!("{CONTACTS}0.1,ball,floor,0,0.441,0,0,1,0,0.1,3.1\n");
    let later = format!("{CONTACTS}100,ball,floor,0,0,0,0,1,0,0.1,3.1\n");
    let never = format!("{CONTACTS}4000,ball,floor,0,0,0,0,1,0,0.1,3.1\n");
    let files =
        [("a.csv", poses.as_str()), ("above.csv", &above), ("later.csv", &later), ("never.csv", &never)];
    let folder = folder(SCENE, &files);
    for (list, wanted) in [
        ("above.csv", "off the surface of floor"),
        ("later.csv", "the clock of the motion"),
        ("never.csv", "times run from 0 to 3600 s"),
    ] {
        let message = import(folder.path(), &["a.csv"], &[list], false).unwrap_err();
        assert!(message.contains(wanted), "{list}: {message}");
    }
}

#[test]
fn property_numbers_of_impacts_of_two_lists_do_not_overflow() {
    let list = |id: u64| {
        CONTACTS.replace("speed", "speed,impact_id")
            + &format!("0.3161,ball,floor,0,0,0,0,1,0,0.1,3.1,{id}\n")
    };
    let files = [("a.csv", falling(240.0, 1)), ("one.csv", list(7)), ("two.csv", list(u64::MAX))];
    let files: Vec<(&str, &str)> = files.iter().map(|(name, text)| (*name, text.as_str())).collect();
    let folder = folder(SCENE, &files);
    let message = import(folder.path(), &["a.csv"], &["one.csv", "two.csv"], false).unwrap_err();
    assert!(message.contains("row 2: impact_id is 18446744073709551615"), "{message}");
}

#[test]
fn property_the_impulse_of_a_light_body_is_not_excused_by_a_heavy_one() {
    // The ball of 33 g could give 0.2 N s at 3.1 m/s, the anvil of 7.9 kg 49 N s.
    let heavy = "0.5,anvil,floor,5,0,0,0,1,0,40,3.1\n";
    let light = |impulse: f64| format!("0.3,ball,floor,0,0,0,0,1,0,{impulse},3.1\n");
    let pressed = "0.4,anvil,ball,5,0,0,0,1,0,40,3.1\n0.4,ball,floor,5,0,0,0,1,0,40,0.01\n";
    let folder = folder(SCENE, &[]);
    let loaded = load_scene(&folder.path().join("scene.toml"), &|_| ()).unwrap();
    let refused = |rows: &str| {
        let list = folder.path().join("list.csv");
        fs::write(&list, format!("{CONTACTS}{rows}")).unwrap();
        let out = folder.path().join("out.timeline");
        import_contacts(&loaded, &list, ListedMotion::Flights, &out, true)
            .err()
            .map(|error| error.to_string())
    };
    assert_eq!(refused(&(light(0.2) + heavy)), None);
    let message = refused(&(light(20.0) + heavy)).expect("a hundred times what is possible");
    assert!(message.contains("row 2: impulse_n on ball is 20 N s"), "{message}");
    // Pressed from above, the ball gives the floor what the anvil gives it.
    assert_eq!(refused(pressed), None);
}

#[test]
fn property_a_name_that_looks_like_a_number_is_a_name() {
    let body = |name: &str, x: u32| {
        format!(
            "[[body]]\nname = \"{name}\"\nshape = \"sphere:0.01\"\nmaterial = \"steel\"\n\
             position = [{x}.0, 1.0, 0.0]\n"
        )
    };
    // Numbers 0 to 4, and the plane.
    let names = ["zero", "one", "01", "1e3", "inf"];
    let bodies: String = names.iter().zip(0..).map(|(name, x)| body(name, x)).collect();
    let scene = format!(
        "version = 1\n{bodies}{}",
        SCENE.split_once("[[plane]]").unwrap().1.replacen('\n', "[[plane]]\n", 1)
    );
    for (name, index) in [("01", 2), ("1e3", 3), ("inf", 4), ("1", 1), ("one", 1)] {
        let poses = format!("{HEAD}0,{name},0,3,0\n0.01,{name},0,3,0\n");
        let folder = folder(&scene, &[("a.csv", &poses)]);
        import(folder.path(), &["a.csv"], &[], false).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(timeline(folder.path()).poses[0].body, BodyId(index), "{name}");
    }
    for name in ["002", "+1", "1.0"] {
        let poses = format!("{HEAD}0,{name},0,3,0\n");
        let folder = folder(&scene, &[("a.csv", &poses)]);
        let message = import(folder.path(), &["a.csv"], &[], false).unwrap_err();
        assert!(message.contains(&format!("body is {name}")), "{message}");
    }
}

#[test]
fn property_tables_that_claim_too_much_are_refused_before_they_are_read() {
    let folder = folder(SCENE, &[]);
    let path = folder.path();
    // Twenty-one million contacts in 300 kB. (Poses are a stream.)
    let zstd = Compression::ZSTD(ZstdLevel::default());
    let names = ["t", "body_a", "point_x", "point_y", "point_z"];
    write_alike(&path.join("long.parquet"), &names, &[(21_000_000, &[0.0; 5])], zstd);
    let size = fs::metadata(path.join("long.parquet")).unwrap().len();
    assert!(size < 500_000, "{size} bytes");
    fs::write(path.join("a.csv"), falling(240.0, 1)).unwrap();
    let message = import(path, &["a.csv"], &["long.parquet"], false).unwrap_err();
    assert!(message.contains("more than 20000000 rows"), "{message}");
    // A new key in each line.
    let line = |k: u32| format!("{{\"t\": {k}, \"body\": 0, \"position\": [0, 0, 0], \"key{k}\": 0}}\n");
    fs::write(path.join("keys.jsonl"), (0..10_000).map(line).collect::<String>()).unwrap();
    let message = import(path, &["keys.jsonl"], &[], false).unwrap_err();
    assert!(message.contains("column key0 is unknown"), "{message}");
    // A single line without end.
    fs::write(path.join("line.csv"), format!("{HEAD}{}", "0".repeat(2 << 20))).unwrap();
    let message = import(path, &["line.csv"], &[], false).unwrap_err();
    assert!(message.contains("line 2: the line is longer"), "{message}");
    // A row of a Parquet file is no line.
    write_alike(&path.join("list.parquet"), &["t", "body_a"], &[(1, &[0.3, 9.0])], zstd);
    let message = import(path, &["a.csv"], &["list.parquet"], false).unwrap_err();
    assert!(message.contains("row 0: body_a is 9"), "{message}");
}

#[test]
fn regression_a_place_that_no_timeline_has_is_refused_with_its_row() {
    let poses = format!("{HEAD}0,ball,0,1000000,0\n0.1,ball,0,1000000,0\n");
    let folder = folder(SCENE, &[("a.csv", &poses)]);
    let message = import(folder.path(), &["a.csv"], &[], false).unwrap_err();
    assert!(message.contains("row 2: a coordinate is 1000000; a number in m from -100000"), "{message}");
}

#[test]
fn property_a_kinematic_node_yields_to_no_impact() {
    // A ball falls onto a stone that comes towards it.
    let folder = folder(SCENE, &[("a.csv", &falling(240.0, 1))]);
    let physics = |motion: Value| json!({ "extensions": { "KHR_physics_rigid_bodies": motion } });
    let motion =
        |is_kinematic: bool| physics(json!({ "motion": { "isKinematic": is_kinematic, "mass": 2.0 } }));
    for is_kinematic in [false, true] {
        write_gltf(folder.path(), &motion(is_kinematic), &[rising(240.0, "LINEAR")]);
        let loaded = load_scene(&folder.path().join("scene.toml"), &|_| ()).unwrap();
        let file = |name: &str| vec![folder.path().join(name)];
        let files = MotionFiles { gltf: file("a.gltf"), poses: file("a.csv"), ..MotionFiles::default() };
        let out = folder.path().join("out.timeline");
        assert_eq!(import_motion(&loaded, &files, &out, true).unwrap().moved, 2);
        let bodies = TimelineReader::open(&out).unwrap().header().world.bodies.clone();
        let stone = bodies.iter().find(|body| body.name == "stone").unwrap();
        assert_eq!(stone.mass, 2.0);
        match &stone.motion {
            Motion::Keyframed(track) => assert!(is_kinematic && track.keys().len() == 60),
            other => assert!(!is_kinematic && *other == Motion::Free),
        }
    }
    let collider = json!({ "collider": { "geometry": { "shape": 0 } } });
    let mut node = physics(collider);
    node["name"] = "wall".into();
    write_gltf(folder.path(), &node, &[rising(240.0, "LINEAR")]);
    let path = folder.path().join("a.gltf");
    let text = fs::read_to_string(&path).unwrap().replace("\"mesh\":0,", "").replace(",\"mesh\":0", "");
    let mut document: Value = serde_json::from_str(&text).unwrap();
    document["extensions"] =
        json!({ "KHR_implicit_shapes": { "shapes": [{ "type": "sphere", "sphere": { "radius": 0.1 } }] } });
    fs::write(&path, document.to_string()).unwrap();
    let loaded = load_scene(&folder.path().join("scene.toml"), &|_| ()).unwrap();
    let files =
        MotionFiles { gltf: vec![path], poses: vec![folder.path().join("a.csv")], ..MotionFiles::default() };
    let notices = import_motion(&loaded, &files, &folder.path().join("out.timeline"), true).unwrap().notices;
    assert!(
        notices.iter().any(|notice| notice.contains("node wall: it has an implicit shape and no material")),
        "{notices:?}"
    );
}

#[test]
fn property_a_key_without_a_rotation_is_refused_with_its_number() {
    for (interpolation, values) in [
        ("LINEAR", vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]),
        ("CUBICSPLINE", [[0.0; 4], [0.0, 0.0, 0.0, 1.0], [0.0; 4], [0.0; 4], [0.0; 4], [0.0; 4]].concat()),
    ] {
        let curve = Channel { path: "rotation", interpolation, keys: vec![0.0, 1.0], values };
        let message = stone(&json!({}), &[curve]).unwrap_err();
        assert!(message.contains("rotation") && message.contains("key 1 has length 0"), "{message}");
    }
}

#[test]
fn property_bodies_that_leave_their_joints_or_would_break_are_named() {
    let scene = SCENE.to_string()
        + "[[body]]\nname = \"tile\"\nshape = \"box:0.1x0.1x0.01\"\nmaterial = \"glass\"\nfracture = {}\n\
           position = [2.0, 1.0, 0.0]\n\
           [[hinge]]\nbody = \"tile\"\npoint = [2.0, 1.05, 0.0]\naxis = [0, 0, 1]\n";
    let poses = |speed: f64| {
        let row = |k: u32| format!("{:?},tile,{:?},1,0\n", f64::from(k) / 60.0, 2.0 + speed * f64::from(k));
        format!("{HEAD}{}", (0..30).map(row).collect::<String>())
    };
    // Radius 71 mm: 58 mm are more than 5 % of it, 2.9 mm are not.
    for (speed, leaves) in [(0.002, true), (0.0001, false)] {
        let folder = folder(&scene, &[("a.csv", &poses(speed))]);
        let notices = import(folder.path(), &["a.csv"], &[], false).unwrap().notices;
        println!("{notices:?}");
        let named = |text: &str| notices.iter().any(|notice| notice.contains(text));
        assert_eq!(named("tile leaves the joints of the scene by up to 58.0 mm"), leaves, "{notices:?}");
        assert!(named("`fracture` does nothing") && named("stay whole: tile"), "{notices:?}");
    }
}
