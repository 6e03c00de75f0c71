//! Every way in which the extension of a file can be wrong is told with its place, and nothing panics.

use std::path::Path;

use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::sound_model::modal::surface::ModalSurface;
use clangor_pipeline::interchange::audio_rigid_bodies::{
    AudioBody, AudioMaterial, BodyMass, Ringing, RingingMode, read_audio_bodies, write_audio_body,
};
use glam::{DMat3, DVec3};
use serde_json::{Value, json};

/// A tetrahedron with two modes, as a document and its binary part.
fn good(folder: &Path) -> (Value, Vec<u8>) {
    let mut nodes = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let edges = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
    nodes.extend(edges.map(|[a, b]: [usize; 2]| 0.5 * (nodes[a] + nodes[b])));
    let triangles = [[0, 2, 1, 5, 7, 4], [0, 1, 3, 4, 8, 6], [0, 3, 2, 6, 9, 5], [1, 2, 3, 7, 9, 8]];
    let surface = ModalSurface { nodes, triangles: triangles.to_vec() };
    let mode = |frequency| RingingMode { frequency, decay_rate: 5.0, shape: vec![DVec3::ONE; 10] };
    let mesh = TriMesh {
        vertices: surface.nodes[..4].to_vec(),
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    };
    let body = AudioBody {
        name: "tetra".into(),
        mesh,
        material: AudioMaterial { name: Some("steel".into()), density: Some(7850.0), ..Default::default() },
        mass: Some(BodyMass { mass: 1.0, centre_of_mass: DVec3::ZERO, inertia: DMat3::IDENTITY }),
        ringing: Some(Ringing { surface, modes: vec![mode(440.0), mode(880.0)], max_frequency: None }),
        gain: 1.0,
        remarks: Vec::new(),
    };
    let path = folder.join("good.glb");
    write_audio_body(&path, &body).unwrap();
    let glb = std::fs::read(path).unwrap();
    let glb = gltf::Glb::from_slice(&glb).unwrap();
    (serde_json::from_slice(&glb.json).unwrap(), glb.bin.unwrap().into_owned())
}

fn write(path: &Path, document: &Value, binary: &[u8]) {
    let header = gltf::binary::Header { magic: *b"glTF", version: 2, length: 0 };
    let json = document.to_string().into_bytes();
    let glb = gltf::Glb { header, json: json.into(), bin: Some(binary.into()) };
    std::fs::write(path, glb.to_vec().unwrap()).unwrap();
}

const EXTENSION: &str = "KHR_audio_rigid_bodies";

/// Where the numbers of an accessor begin.
fn begin(document: &Value, property: &str) -> usize {
    let accessor = accessor(document, property);
    let view = document["accessors"][accessor]["bufferView"].as_u64().unwrap() as usize;
    document["bufferViews"][view]["byteOffset"].as_u64().unwrap() as usize
}

fn accessor(document: &Value, property: &str) -> usize {
    document["extensions"][EXTENSION]["modalModels"][0][property].as_u64().unwrap() as usize
}

#[test]
fn bad_numbers_are_told_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.glb");
    let (document, binary) = good(folder.path());
    write(&path, &document, &binary);
    assert_eq!(read_audio_bodies(&path).unwrap().len(), 1);
    let nan = f32::NAN.to_le_bytes();
    for (property, at, bytes, wanted) in [
        (
            "frequencies",
            1,
            (-440.0_f32).to_le_bytes(),
            "frequencies 1 is -440, and must be finite and positive",
        ),
        ("frequencies", 0, 0.0_f32.to_le_bytes(), "frequencies 0 is 0"),
        ("frequencies", 0, nan, "frequencies 0 is NaN"),
        ("decayRates", 1, (-1.0_f32).to_le_bytes(), "decayRates 1 is -1"),
        ("decayRates", 1, f32::INFINITY.to_le_bytes(), "decayRates 1 is inf"),
        ("positions", 7, nan, "positions 2 is NaN"),
        ("shapes", 59, nan, "shapes 19 is NaN"),
        ("indices", 5, 10_u32.to_le_bytes(), "indices 5 is 10, and must be less than the count of positions"),
        ("indices", 13, 3_u32.to_le_bytes(), "triangles 4 to 7 are said to be the quarters"),
    ] {
        let mut binary = binary.clone();
        let start = begin(&document, property) + 4 * at;
        binary[start..start + 4].copy_from_slice(&bytes);
        write(&path, &document, &binary);
        let message = read_audio_bodies(&path).unwrap_err().to_string();
        assert!(message.contains(wanted) && message.contains("modalModels 0"), "{property}: {message}");
    }
}

/// A change to the document.
type Edit = Box<dyn Fn(&mut Value)>;

/// Sets what a JSON pointer names.
fn set(pointer: &'static str, value: Value) -> Edit {
    Box::new(move |document| {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        let parent = document.pointer_mut(parent).unwrap();
        match parent {
            Value::Array(list) => list[key.parse::<usize>().unwrap()] = value.clone(),
            other => other[key] = value.clone(),
        }
    })
}

/// Sets a field of the accessor of a property.
fn field(property: &'static str, key: &'static str, value: Value) -> Edit {
    Box::new(move |document| {
        let accessor = accessor(document, property);
        document["accessors"][accessor][key] = value.clone();
    })
}

const MODEL: &str = "/extensions/KHR_audio_rigid_bodies/modalModels/0";

#[test]
fn bad_documents_are_told_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.glb");
    let (document, binary) = good(folder.path());
    let material = |key: &'static str, value: Value| -> Edit {
        Box::new(move |d| d["extensions"][EXTENSION]["acousticMaterials"][0][key] = value.clone())
    };
    let model = |key: &'static str, value: Value| -> Edit {
        Box::new(move |d| *d.pointer_mut(MODEL).unwrap().get_mut(key).unwrap() = value.clone())
    };
    let mass = |key: &'static str, value: Value| -> Edit {
        Box::new(move |d| d.pointer_mut(MODEL).unwrap()["massProperties"][key] = value.clone())
    };
    let node = |key: &'static str, value: Value| -> Edit {
        Box::new(move |d| d["nodes"][0]["extensions"][EXTENSION][key] = value.clone())
    };
    let without = |key: &'static str| -> Edit {
        Box::new(move |d| {
            d.pointer_mut(MODEL).unwrap().as_object_mut().unwrap().remove(key).unwrap();
        })
    };
    let at_model = "KHR_audio_rigid_bodies modalModels 0: ";
    let at_material = "KHR_audio_rigid_bodies acousticMaterials 0: ";
    let at_node = "node 0 \"tetra\": ";
    let cases: Vec<(Edit, &str, &str)> = vec![
        (field("decayRates", "count", json!(1)), at_model, "decayRates has 1 elements, and needs 2"),
        (field("frequencies", "count", json!(0)), at_model, "frequencies has 0 elements, and needs 1"),
        (field("positions", "count", json!(0)), at_model, "positions has 0 elements"),
        (field("positions", "count", json!(9)), at_model, "shapes has 20 elements, and needs 2 × 9"),
        (field("shapes", "count", json!(19)), at_model, "shapes has 19 elements, and needs 2 × 10"),
        (field("shapes", "count", json!(21)), at_model, "shapes: the file is truncated"),
        (field("shapes", "count", json!(u64::MAX / 2)), at_model, "shapes: the file is truncated"),
        (field("shapes", "count", json!(-1)), "", "not that of a glTF"),
        (field("shapes", "type", json!("SCALAR")), at_model, "shapes is an accessor of SCALAR"),
        (field("frequencies", "componentType", json!(5123)), at_model, "must be SCALAR of FLOAT"),
        (field("frequencies", "sparse", json!({})), at_model, "sparse"),
        (
            field("indices", "count", json!(47)),
            at_model,
            "indices has 47 elements, and needs a multiple of 3",
        ),
        (field("indices", "count", json!(0)), at_model, "indices has 0 elements"),
        (field("indices", "count", json!(45)), at_model, "triangles 12 to 15 are said"),
        (model("frequencies", json!(99)), at_model, "names frequencies 99"),
        (model("frequencies", json!("four")), at_model, "invalid type: string \"four\""),
        (model("material", json!(1)), at_model, "names acousticMaterials 1, of which there are 1"),
        (without("shapes"), at_model, "missing field `shapes`"),
        (without("decayRates"), at_model, "missing field `decayRates`"),
        (material("density", json!(0.0)), at_material, "density is 0, and must be positive"),
        (material("density", json!("heavy")), at_material, "invalid type"),
        (material("youngsModulus", json!(-1.0)), at_material, "youngsModulus is -1"),
        (
            material("poissonRatio", json!(0.5)),
            at_material,
            "poissonRatio is 0.5, and must be between -1 and 0.5",
        ),
        (material("alpha", json!(-1e-3)), at_material, "alpha is -0.001"),
        (mass("mass", json!(0.0)), at_model, "mass is 0"),
        (mass("mass", Value::Null), at_model, "missing field `mass`"),
        (mass("inertiaDiagonal", json!([1.0, -1.0, 1.0])), at_model, "inertiaDiagonal 1 is -1"),
        (mass("inertiaDiagonal", json!([1.0, 1.0])), at_model, "invalid length 2"),
        (mass("inertiaOrientation", json!([0.0, 0.0, 0.0, 0.0])), at_model, "inertiaOrientation is 0"),
        (node("modalModel", json!(3)), at_node, "names modalModels 3, of which there are 1"),
        (node("acousticSurface", json!(1)), at_node, "names acousticSurfaces 1"),
        (node("gain", json!(-0.5)), at_node, "gain is -0.5"),
        (set("/nodes/0/scale", json!([1.0, 1.0, 1.01])), at_node, "stretched"),
        (set("/nodes/0/scale", json!([0.0, 0.0, 0.0])), at_node, "stretched"),
        (set("/extensions/KHR_audio_rigid_bodies", json!([])), "KHR_audio_rigid_bodies: ", "invalid type"),
        (
            set("/extensions/KHR_audio_rigid_bodies", json!({ "models": [], "materials": [] })),
            "KHR_audio_rigid_bodies: ",
            "materials, models belongs to another draft",
        ),
        (
            Box::new(|d| {
                d["extensions"] = json!({});
                d["extensionsUsed"] = json!(["KHR_audio_modal"]);
            }),
            "KHR_audio_rigid_bodies: ",
            "KHR_audio_modal belongs to another draft",
        ),
        (
            Box::new(|d| {
                d["nodes"][0].as_object_mut().unwrap().remove("mesh");
                d.pointer_mut(MODEL).unwrap().as_object_mut().unwrap().remove("indices");
                d.pointer_mut(MODEL).unwrap().as_object_mut().unwrap().remove("extras");
            }),
            at_model,
            "no triangles",
        ),
        (
            Box::new(|d| {
                let mut child = d["nodes"][0].clone();
                child["name"] = json!("child");
                d["nodes"].as_array_mut().unwrap().push(child);
                d["nodes"][0]["children"] = json!([1]);
            }),
            at_node,
            "the body's modalModel has 2 elements",
        ),
    ];
    for (edit, place, wanted) in cases {
        let mut document = document.clone();
        edit(&mut document);
        write(&path, &document, &binary);
        let message = match read_audio_bodies(&path) {
            Ok(bodies) => panic!("{wanted}: {bodies:?}"),
            Err(error) => error.to_string(),
        };
        assert!(message.contains(wanted) && message.contains(place), "{wanted}: {message}");
        assert!(message.contains("bad.glb"), "{message}");
    }
}

#[test]
fn damaged_files_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.glb");
    let (document, binary) = good(folder.path());
    write(&path, &document, &binary);
    let bytes = std::fs::read(&path).unwrap();
    for at in (0..bytes.len()).step_by(7) {
        std::fs::write(&path, &bytes[..at]).unwrap();
        assert!(read_audio_bodies(&path).is_err() || at == 0, "cut at {at}");
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x55;
        std::fs::write(&path, &damaged).unwrap();
        let _ = read_audio_bodies(&path);
    }
}

#[test]
fn what_is_unknown_is_told_and_has_no_effect() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("more.glb");
    let (document, binary) = good(folder.path());
    write(&path, &document, &binary);
    let plain = read_audio_bodies(&path).unwrap();
    let mut more = document.clone();
    more["extensions"][EXTENSION]["modalModels"][0]["transfer"] = json!(3);
    more["extensions"][EXTENSION]["modalModels"][0]["extras"]["other"] = json!({ "anything": [] });
    more["extensions"][EXTENSION]["acousticMaterials"][0]["colour"] = json!("red");
    write(&path, &more, &binary);
    let read = read_audio_bodies(&path).unwrap();
    assert_eq!(read[0].ringing, plain[0].ringing);
    let remarks = read[0].remarks.join("\n");
    assert!(
        remarks.contains("modalModels 0: transfer") && remarks.contains("acousticMaterials 0: colour"),
        "{remarks}"
    );
    // No bodies in files that have no such extension.
    std::fs::write(folder.path().join("a.obj"), "v 0 0 0\n").unwrap();
    assert_eq!(read_audio_bodies(&folder.path().join("a.obj")).unwrap(), []);
    more["extensions"] = json!({});
    write(&path, &more, &binary);
    assert_eq!(read_audio_bodies(&path).unwrap(), []);
    let missing = read_audio_bodies(&folder.path().join("missing.glb")).unwrap_err().to_string();
    assert!(missing.contains("missing.glb"), "{missing}");
}
