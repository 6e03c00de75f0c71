//! Recordings of other programs: every format and codec says the same, and what is wrong is told by body
//! and row.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use crate::imported_motion::{folder, import, scene};
use clangor_core::body::{BodyId, Motion};
use clangor_core::timeline::ContactKind;
use clangor_pipeline::formats::timeline_file::TimelineReader;
use clangor_pipeline::interchange::motion_import::MotionSummary;
use glam::{DQuat, DVec3};
use parquet::basic::{BrotliLevel, Compression, GzipLevel, ZstdLevel};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use serde_json::json;
use tempfile::TempDir;

const SCENE: &str = scene!(
    r#"[[body]]
name = "anvil"
shape = "box:0.1x0.1x0.1"
material = "steel"
position = [5.0, 0.05, 0.0]
motion = "fixed"
"#
);
const RATE: f64 = 240.0;
const G: f64 = 9.80665;

/// Height of a ball that falls from 0.5 m and bounces once, without loss of its half.
fn height(time: f64) -> f64 {
    let impact = (2.0 * 0.49 / G).sqrt();
    if time < impact {
        return 0.5 - 0.5 * G * time * time;
    }
    let t = time - impact;
    0.01 + 0.5 * G * impact * t - 0.5 * G * t * t
}

fn rows() -> Vec<[f64; 2]> {
    (0..120).map(|k| f64::from(k) / RATE).map(|t| [t, height(t)]).collect()
}

fn poses_csv() -> String {
    let line = |[t, y]: [f64; 2]| format!("{t},ball,0,{y},0,0,0,0,1\n");
    let head =
        "t,body,position_x,position_y,position_z,orientation_x,orientation_y,orientation_z,orientation_w\n";
    head.to_string() + &rows().into_iter().map(line).collect::<String>()
}

fn write_parquet(path: &Path, compression: Compression) {
    let columns = ["position_x", "position_y", "position_z"];
    let doubles: String = columns.iter().map(|name| format!("required double {name};")).collect();
    let schema = format!("message poses {{ required double t; required binary body (UTF8); {doubles} }}");
    let schema = Arc::new(parse_message_type(&schema).unwrap());
    let properties = Arc::new(WriterProperties::builder().set_compression(compression).build());
    let file = fs::File::create(path).unwrap();
    let mut writer = SerializedFileWriter::new(file, schema, properties).unwrap();
    let mut group = writer.next_row_group().unwrap();
    let rows = rows();
    let zeros = vec![0.0; rows.len()];
    let numbers: [Option<Vec<f64>>; 5] = [
        Some(rows.iter().map(|row| row[0]).collect()),
        None,
        Some(zeros.clone()),
        Some(rows.iter().map(|row| row[1]).collect()),
        Some(zeros),
    ];
    for values in numbers {
        let mut column = group.next_column().unwrap().unwrap();
        match values {
            Some(values) => column.typed::<DoubleType>().write_batch(&values, None, None),
            None => {
                let names = vec![ByteArray::from("ball"); rows.len()];
                column.typed::<ByteArrayType>().write_batch(&names, None, None)
            }
        }
        .unwrap();
        column.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
}

fn timeline(folder: &Path) -> clangor_core::timeline::Timeline {
    TimelineReader::open(&folder.join("out.timeline")).unwrap().read_all().unwrap()
}

#[test]
fn property_every_format_and_codec_gives_the_same_timeline() {
    let jsonl: String = rows()
        .into_iter()
        .map(|[t, y]| json!({ "t": t, "body": "ball", "position": [0.0, y, 0.0] }).to_string() + "\n")
        .collect();
    // The origin of a sphere is its centre; with z up, y is −z.
    let origin: String = "t,body,origin_x,origin_y,origin_z\n".to_string()
        + &rows().into_iter().map(|[t, y]| format!("{t},0,0,0,{y}\n")).collect::<String>();
    let folder = folder(SCENE, &[("a.csv", &poses_csv()), ("b.jsonl", &jsonl), ("z.csv", &origin)]);
    let path = folder.path();
    let first = import(path, &["a.csv"], &[], false).unwrap();
    assert_eq!((first.moved, first.found.as_ref().unwrap().confidence.len()), (1, 1));
    let expected = timeline(path);
    assert_eq!(expected.poses.len(), 121, "one at the impact");
    import(path, &["b.jsonl"], &[], false).unwrap();
    assert_eq!(timeline(path), expected);
    import(path, &["z.csv"], &[], true).unwrap();
    let turned = timeline(path);
    let impulse = |t: &clangor_core::timeline::Timeline| t.contacts[0].impulse();
    assert!(impulse(&turned).distance(impulse(&expected)) < 1e-9 * impulse(&expected).length());
    let codecs = [
        Compression::UNCOMPRESSED,
        Compression::SNAPPY,
        Compression::GZIP(GzipLevel::default()),
        Compression::LZ4_RAW,
        Compression::ZSTD(ZstdLevel::default()),
        Compression::BROTLI(BrotliLevel::default()),
    ];
    for codec in codecs {
        write_parquet(&path.join("c.parquet"), codec);
        import(path, &["c.parquet"], &[], false).unwrap_or_else(|error| panic!("{codec:?}: {error}"));
        assert_eq!(timeline(path), expected, "{codec:?}");
    }
}

#[test]
fn property_the_body_keeps_its_mass_and_moves_as_recorded() {
    let folder = folder(SCENE, &[("a.csv", &poses_csv())]);
    import(folder.path(), &["a.csv"], &[], false).unwrap();
    let reader = TimelineReader::open(&folder.path().join("out.timeline")).unwrap();
    let ball = &reader.header().world.bodies[0];
    assert!(ball.mass > 0.03 && matches!(ball.motion, Motion::Free));
    let impact = timeline(folder.path()).contacts[0];
    assert_eq!((impact.body_a, impact.body_b, impact.kind), (BodyId(0), BodyId(2), ContactKind::Impact));
    // Falls with v = g t and leaves with half of it. Errors seen: 0 s, 5e-8 (32-bit rows).
    let instant = (2.0 * 0.49 / G).sqrt();
    println!(
        "{:.1e} s, {:.1e}",
        impact.time - instant,
        impact.impulse_n / (1.5 * G * instant * ball.mass) - 1.0
    );
    assert!((impact.time - instant).abs() < 1e-6, "{}", impact.time);
    assert!((impact.impulse_n / (1.5 * G * instant * ball.mass) - 1.0).abs() < 1e-5, "{}", impact.impulse_n);
}

const CONTACTS: &str = "t,body_a,body_b,point_x,point_y,point_z,normal_x,normal_y,normal_z,impulse_n,speed\n";

#[test]
fn property_a_contact_on_a_plane_belongs_to_it_unless_the_list_names_another() {
    let list = |second: &str, y: f64| format!("{CONTACTS}0.3161,ball,{second},0,{y},0,0,1,0,0.1,3.1\n");
    let poses = poses_csv();
    let files = [("a.csv", poses.as_str()), ("none.csv", &list("", 0.0)), ("world.csv", &list("world", 0.0))];
    let folder = folder(SCENE, &files);
    let summary = import(folder.path(), &["a.csv"], &["none.csv"], false).unwrap();
    assert_eq!(timeline(folder.path()).contacts[0].body_b, BodyId(2));
    assert!(
        summary.notices.iter().any(|notice| notice.contains("belongs to the plane floor")),
        "{summary:?}"
    );
    import(folder.path(), &["a.csv"], &["world.csv"], false).unwrap();
    assert_eq!(timeline(folder.path()).contacts[0].body_b, BodyId::WORLD);
    // A little off the surface: moved onto it, and told.
    fs::write(folder.path().join("off.csv"), list("floor", 0.003)).unwrap();
    let summary = import(folder.path(), &["a.csv"], &["off.csv"], false).unwrap();
    assert!(summary.notices.iter().any(|notice| notice.contains("off the surface")), "{summary:?}");
}

#[test]
fn property_impossible_contacts_are_refused_with_row_and_body() {
    let poses = poses_csv();
    let cases = [
        ("0.3161,ball,ball,0,0,0,0,1,0,0.1,3.1", "row 2: ball touches itself"),
        ("0.3161,ball,floor,3.7,0.0,0,0,1,0,0.1,3.1", "row 2: the point is 3.7"),
        ("0.3161,ball,floor,0,0,0,0,1,0,100,3.1", "row 2: impulse_n on ball is 100 N s"),
        (
            "0.3161,ball,floor,0,0,0,0,-1,0,0.1,3.1",
            "row 2: the normal of the contact of ball points into the plane floor",
        ),
        (
            "0.3161,ball,,0,0,0,0,-1,0,0.1,3.1",
            "row 2: the normal of the contact of ball points into the plane floor",
        ),
        ("0.3161,nobody,floor,0,0,0,0,1,0,0.1,3.1", "line 2: body_a is nobody"),
        ("0.3161,ball,floor,0,0,0,0,1,0,NaN,3.1", "line 2: impulse_n is NaN"),
    ];
    for (row, wanted) in cases {
        let list = format!("{CONTACTS}{row}\n");
        let folder = folder(SCENE, &[("a.csv", &poses), ("list.csv", &list)]);
        let message = import(folder.path(), &["a.csv"], &["list.csv"], false).unwrap_err();
        assert!(message.contains(wanted), "{message}");
        assert!(!folder.path().join("out.timeline").exists());
    }
    let receding = "{\"t\": 0.3161, \"body_a\": \"ball\", \"body_b\": \"floor\", \"point\": [0, 0, 0], \
                    \"normal\": [0, 1, 0], \"impulse_n\": 0.1, \"velocity\": [0, 2, 0]}\n";
    let folder = folder(SCENE, &[("a.csv", &poses), ("list.jsonl", receding)]);
    let message = import(folder.path(), &["a.csv"], &["list.jsonl"], false).unwrap_err();
    assert!(message.contains("row 1: ball recedes from what it hits with 2 m/s"), "{message}");
}

#[test]
fn property_bad_poses_are_refused_with_row_and_body() {
    let head = "t,body,position_x,position_y,position_z\n";
    let quaternion =
        "t,body,position_x,position_y,position_z,orientation_x,orientation_y,orientation_z,orientation_w\n";
    let cases = [
        (format!("{head}0,ball,0,NaN,0\n"), "row 2: position_y is NaN"),
        (format!("{head}0,ball,0,,0\n"), "row 2: position_y is empty"),
        (format!("{head}0,ball,0,high,0\n"), "row 2: position_y is high"),
        (
            format!("{head}0,bell,0,0,0\n"),
            "row 2: body is bell, which is neither the name nor the number of a body; did you mean ball?",
        ),
        (
            format!("{head}0.1,ball,0,1,0\n0.0,ball,0,1,0\n"),
            "body ball, row 3: t = 0 s comes after t = 0.1 s",
        ),
        (format!("{head}0.1,ball,0,1,0\n0.1,ball,0,2,0\n"), "body ball, row 3: t = 0.1 s comes after"),
        (format!("{head}-1,ball,0,1,0\n"), "body ball, row 2: t = -1 s"),
        (format!("{head}0,ball,0,1,0\n0.01,ball,9,1,0\n"), "body ball, row 3: it moves 9 m within 0.01 s"),
        (
            format!("{head}0,ball,0,1,0\n0.1,ball,0,1,0\n0.2,ball,3,1,0\n0.3,ball,3,1,0\n"),
            "body ball, row 4: it moves 3 m",
        ),
        (format!("{quaternion}0,ball,0,1,0,0,0,0,2\n"), "body ball, row 2: the orientation has length 2"),
        (format!("{head}0,anvil,0,1,0\n0.1,anvil,0,1.01,0\n"), "moves anvil, which is fixed in the scene"),
        (format!("{head}0,floor,0,1,0\n0.1,floor,0,1.01,0\n"), "moves floor, which is fixed in the scene"),
        (
            "t,body,position_x,position_y\n0,ball,0,0\n".into(),
            "has no column position_z; there are t, body, position_x, position_y",
        ),
        (head.replace("t,", "Time,"), "has no column t; there are Time, body, position_x,"),
        (
            head.replace("position_x", "Position_X"),
            "has no column position_x; there are t, body, Position_X, position_y, position_z; rename \
             Position_X to position_x; docs/format/timeline.md",
        ),
        (
            "t,body,position_x,position_y,position_z,colour\n0,ball,0,0,0,1\n".into(),
            "column colour is unknown",
        ),
        (head.into(), "has no poses"),
        (format!("{head}0,ball,0\n"), "line 2: there are 3 values, but the header has 5"),
    ];
    for (text, wanted) in cases {
        let folder = folder(SCENE, &[("a.csv", &text)]);
        let message = import(folder.path(), &["a.csv"], &[], false).unwrap_err();
        assert!(message.contains(wanted), "{text}: {message}");
        assert!(!folder.path().join("out.timeline").exists());
    }
    let damaged = folder(SCENE, &[("a.parquet", "PAR1 but nothing else"), ("a.txt", "")]);
    for (name, wanted) in
        [("a.parquet", "damaged or no Parquet"), ("a.txt", "name it .csv"), ("b.csv", "cannot read")]
    {
        let message = import(damaged.path(), &[name], &[], false).unwrap_err();
        assert!(message.contains(wanted), "{message}");
    }
}

#[test]
fn property_doubtful_poses_are_told() {
    let head = "t,body,position_x,position_y,position_z\n";
    let uneven = format!("{head}0,ball,0,1,0\n0.01,ball,0,1,0\n0.03,ball,0,1,0\n");
    let z_up: String = head.to_string()
        + &rows().into_iter().map(|[t, y]| format!("{t},ball,0,3,{y}\n")).collect::<String>();
    // The scalar first, of a ball that never turns.
    let scalar_first = poses_csv().replace(",0,0,0,1\n", ",1,0,0,0\n");
    for (text, wanted) in [
        (uneven, "frames are 0.01 s to 0.0"),
        (z_up, "import it with --up z"),
        (scalar_first, "body ball, row 2: orientation_x is 1 and orientation_w 0 where the motion begins"),
    ] {
        let folder = folder(SCENE, &[("a.csv", &text)]);
        let summary = import(folder.path(), &["a.csv"], &[], false).unwrap();
        assert!(summary.notices.iter().any(|notice| notice.contains(wanted)), "{:?}", summary.notices);
    }
}

/// A glTF file with one animated tetrahedron below an empty; `node` and `sampler` replace parts of it.
fn gltf(node: &serde_json::Value, keys: &[f32], values: &[f32], path: &str, interpolation: &str) -> String {
    let corners = [[0.0_f32, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]];
    let indices: [u32; 12] = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
    let floats = corners.iter().flatten().chain(keys).chain(values);
    let mut bytes: Vec<u8> = floats.flat_map(|x| x.to_le_bytes()).collect();
    let first_index = bytes.len();
    bytes.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
    let count = keys.len();
    let width = values.len() / if interpolation == "CUBICSPLINE" { 3 * count } else { count };
    let view =
        |offset: usize, length: usize| json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
    let accessor = |view: usize, kind: u32, count: usize, shape: &str| {
        let mut accessor = json!({ "bufferView": view, "componentType": kind, "count": count });
        accessor["type"] = shape.into();
        accessor
    };
    let mut body = json!({ "name": "stone", "mesh": 0 });
    body.as_object_mut().unwrap().extend(node.as_object().unwrap().clone());
    let shape = if width == 4 { "VEC4" } else { "VEC3" };
    json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "parent", "translation": [0.0, 1.0, 0.0], "children": [1] }, body],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "material": 0 }] }],
        "materials": [{ "name": "granite.001" }],
        "accessors": [
            accessor(0, 5126, 4, "VEC3"), accessor(3, 5125, 12, "SCALAR"),
            accessor(1, 5126, count, "SCALAR"), accessor(2, 5126, values.len() / width, shape),
        ],
        "bufferViews": [
            view(0, 48), view(48, 4 * count), view(48 + 4 * count, 4 * values.len()), view(first_index, 48),
        ],
        "buffers": [{ "byteLength": bytes.len(), "uri": "data.bin" }],
        "animations": [{
            "channels": [{ "sampler": 0, "target": { "node": 1, "path": path } }],
            "samplers": [{ "input": 2, "output": 3, "interpolation": interpolation }],
        }],
        "data": bytes,
    })
    .to_string()
}

/// Imports that file; its bytes go to the file beside it.
fn import_gltf(text: &str) -> (TempDir, Result<MotionSummary, String>) {
    let mut document: serde_json::Value = serde_json::from_str(text).unwrap();
    let bytes = document.as_object_mut().unwrap().remove("data").unwrap();
    let bytes: Vec<u8> = serde_json::from_value(bytes).unwrap();
    let folder = folder(SCENE, &[("a.gltf", &document.to_string())]);
    fs::write(folder.path().join("data.bin"), bytes).unwrap();
    let summary = import(folder.path(), &["a.gltf"], &[], false);
    (folder, summary)
}

#[test]
fn property_nodes_move_with_their_parents_by_all_interpolations() {
    let half = DVec3::new(0.0, 0.5, 0.0);
    let cases = [
        ("LINEAR", vec![0.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
        ("STEP", vec![0.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
        // Zero tangents: 3 s² − 2 s³.
        ("CUBICSPLINE", [[0.0; 9], [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]].concat()),
    ];
    for (interpolation, values) in &cases {
        let quarter = json!({ "scale": [2.0, 2.0, 2.0] });
        let (folder, summary) =
            import_gltf(&gltf(&quarter, &[0.0, 1.0], values, "translation", interpolation));
        summary.unwrap_or_else(|error| panic!("{interpolation}: {error}"));
        let reader = TimelineReader::open(&folder.path().join("out.timeline")).unwrap();
        let stone = reader.header().world.bodies.iter().find(|body| body.name == "stone").unwrap().clone();
        // The volume of a tetrahedron of edges 0.2 m, of granite.
        assert!((stone.mass / (0.008 / 6.0 * stone.material.density) - 1.0).abs() < 1e-6, "{}", stone.mass);
        let poses = timeline(folder.path()).poses;
        let last = poses.last().unwrap();
        let centre = DVec3::splat(0.05) + DVec3::Y;
        assert!(last.position.distance(centre + 2.0 * half) < 1e-6, "{interpolation}: {}", last.position);
        if *interpolation == "CUBICSPLINE" {
            let quarter =
                poses.iter().find(|row| (row.time - 0.25).abs() < 1e-9).expect("240 frames a second");
            assert!(quarter.position.distance(centre + DVec3::Y * 0.15625) < 1e-6, "{}", quarter.position);
        }
    }
    let mass = json!({ "extensions": { "KHR_physics_rigid_bodies": { "motion": { "mass": 2.0 } } } });
    let (folder, summary) = import_gltf(&gltf(&mass, &[0.0, 1.0], &cases[0].1, "translation", "LINEAR"));
    summary.unwrap();
    let reader = TimelineReader::open(&folder.path().join("out.timeline")).unwrap();
    assert_eq!(reader.header().world.bodies.iter().find(|body| body.name == "stone").unwrap().mass, 2.0);

    let turn = DQuat::from_rotation_z(1.0).to_array().map(|x| x as f32);
    let values = [[0.0, 0.0, 0.0, 1.0], turn].concat();
    let (folder, summary) = import_gltf(&gltf(&json!({}), &[0.0, 1.0], &values, "rotation", "LINEAR"));
    summary.unwrap();
    let last = *timeline(folder.path()).poses.last().unwrap();
    // 32-bit components: 3e-8 seen.
    assert!((last.orientation - DQuat::from_rotation_z(1.0)).length() < 1e-6, "{}", last.orientation);
    let centre = DQuat::from_rotation_z(1.0) * DVec3::splat(0.025) + DVec3::Y;
    assert!(last.position.distance(centre) < 1e-6, "{}", last.position);
}

#[test]
fn property_bad_nodes_are_refused_with_their_name() {
    let moved = [0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let case = |node: serde_json::Value, values: &[f32], path: &str| {
        let keys: Vec<f32> = (0..values.len() / 3).map(|k| k as f32).collect();
        let (folder, result) = import_gltf(&gltf(&node, &keys, values, path, "LINEAR"));
        assert!(!folder.path().join("out.timeline").exists() || result.is_ok());
        result
    };
    let refused = |node, values: &[f32], path, wanted: &str| {
        let message = case(node, values, path).unwrap_err();
        assert!(message.contains("node stone") && message.contains(wanted), "{message}");
    };
    refused(json!({ "skin": 0 }), &moved, "translation", "it has a skin");
    refused(json!({}), &[1.0, 1.0, 1.0, 1.5, 1.5, 1.5], "scale", "its scale at t = 1 s is 1.5 of that");
    refused(json!({}), &[1.0, 1.0, 1.0, 1.0, 2.0, 1.0], "scale", "its scale is 1, 2, 1");
    let again = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    refused(json!({}), &again, "scale", "it is shown again at t = 2 s");
    refused(json!({}), &[0.0, 0.0, 0.0, f32::NAN, 0.0, 0.0], "translation", "key 1 is not finite");
    // Hidden from one second on, and at rest until then.
    let message = case(json!({}), &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0], "scale").unwrap_err();
    assert!(message.contains("only keys of scale, which show and hide stone,"), "{message}");
    // Never shown: no body, and nothing else moves.
    let message = case(json!({}), &[0.0; 6], "scale").unwrap_err();
    assert!(message.contains("moves no body"), "{message}");
    // One factor for each axis of a body that never changes is applied to its mesh.
    assert!(case(json!({ "scale": [1.0, 2.0, 1.0] }), &moved, "translation").is_ok());

    let text = gltf(&json!({}), &[0.0, 1.0], &moved, "translation", "LINEAR");
    for (from, to, wanted) in [
        ("granite.001", "unobtainium", "node stone: its material is unobtainium"),
        ("\"byteLength\":48,\"byteOffset\":0", "\"byteLength\":36,\"byteOffset\":0", "truncated"),
        ("\"count\":12", "\"count\":9", "node stone"),
        ("LINEAR", "BEZIER", "BEZIER is no interpolation"),
        (
            "\"indices\":1",
            "\"extensions\":{\"KHR_draco_mesh_compression\":{}},\"indices\":1",
            "mesh 0: it is compressed by Draco",
        ),
        (
            "\"scenes\"",
            "\"extensionsUsed\":[\"EXT_meshopt_compression\"],\"scenes\"",
            "compressed by meshopt",
        ),
    ] {
        assert!(text.contains(from), "{from} in {text}");
        let message = import_gltf(&text.replace(from, to)).1.unwrap_err();
        assert!(message.contains(wanted), "{message}");
    }
}

#[test]
fn property_bodies_that_lie_deep_in_a_plane_are_told_with_row_and_depth() {
    let sunk = |depth: f64| {
        let line = |[t, y]: [f64; 2]| format!("{t},ball,0,{},0\n", y - depth);
        let table: String = rows().into_iter().map(line).collect();
        let table = format!("t,body,position_x,position_y,position_z\n{table}");
        let folder = folder(SCENE, &[("a.csv", &table)]);
        let summary = import(folder.path(), &["a.csv"], &[], false).unwrap();
        summary.notices.into_iter().find(|notice| notice.contains("deep in the plane"))
    };
    assert_eq!(sunk(0.0), None);
    let notice = sunk(0.006).expect("a notice");
    let lowest = rows().into_iter().map(|[_, y]| y).fold(f64::INFINITY, f64::min);
    let depth = 1e3 * (0.016 - lowest);
    let row = 2 + rows().iter().position(|[_, y]| *y == lowest).unwrap();
    assert!(notice.contains(&format!("ball lies up to {depth:.1} mm deep in the plane floor")), "{notice}");
    assert!(notice.contains(&format!("(row {row}, t = ")), "{notice}");
}

#[test]
fn property_a_plate_on_the_floor_may_be_hit_from_above() {
    let scene = SCENE
        .replace("sphere:0.01", "box:0.2x0.003x0.2")
        .replace("0.5, 0.0]\n[[body]]", "0.0015, 0.0]\n[[body]]");
    let poses: String = (0..60).map(|k| format!("{},ball,0,0.0015,0\n", f64::from(k) / RATE)).collect();
    let poses = format!("t,body,position_x,position_y,position_z\n{poses}");
    let summary = |y: f64| {
        let list = format!("{CONTACTS}0.1,ball,,0,{y},0,0,-1,0,0.001,0.1\n");
        let folder = folder(&scene, &[("a.csv", &poses), ("list.csv", &list)]);
        import(folder.path(), &["a.csv"], &["list.csv"], false)
    };
    assert!(summary(0.003).is_ok(), "{:?}", summary(0.003));
    let message = summary(0.0).unwrap_err();
    assert!(message.contains("the normal of the contact of ball points into the plane floor"), "{message}");
}
