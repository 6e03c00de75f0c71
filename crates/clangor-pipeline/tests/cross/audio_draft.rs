//! The extension against the draft itself: what we write is valid by its schemas, and its own samples can be
//! read.
//!
//! The draft is not ours to ship (CC-BY-4.0). It is fetched and named by
//!
//! ```sh
//! git clone --filter=blob:none --no-checkout https://github.com/khiner/MeshEditor
//! git -C MeshEditor sparse-checkout set glTF_PhysicalAudio
//! git -C MeshEditor checkout 2ea03a88204b8075cf46b6c7532dc91678c784c4
//! export CLANGOR_AUDIO_DRAFT=$PWD/MeshEditor/glTF_PhysicalAudio
//! cargo test --release -p clangor-pipeline --test cross audio_draft:: -- --show-output
//! ```
//!
//! The schemas are interpreted here: they use few keywords, any other is an error, and a validator with all
//! of them would bring thirty crates. What glTF itself defines, which the draft refers to, is restated below.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::sound_model::modal::surface::ModalSurface;
use clangor_pipeline::interchange::audio_rigid_bodies::{
    AudioBody, AudioMaterial, BodyMass, Ringing, RingingMode, read_audio_bodies, write_audio_body,
};
use glam::DVec3;
use serde_json::{Value, json};

const EXTENSION: &str = "KHR_audio_rigid_bodies";

/// The folder of the draft, if there is one.
fn draft() -> Option<PathBuf> {
    let folder = std::env::var_os("CLANGOR_AUDIO_DRAFT");
    if folder.is_none() {
        println!("skipped, as CLANGOR_AUDIO_DRAFT is not set");
    }
    folder.map(PathBuf::from)
}

/// Schemas by the name of their file.
struct Schemas(BTreeMap<String, Value>);

impl Schemas {
    /// Those of glTF that are referred to, in our words.
    fn of_gltf() -> Self {
        let property = json!({
            "type": "object",
            "properties": { "extensions": { "type": "object" }, "extras": {} },
        });
        let child = json!({
            "allOf": [{ "$ref": "glTFProperty.schema.json" }], "properties": { "name": { "type": "string" } },
        });
        let texture = json!({ "type": "object", "required": ["index"] });
        let known = [
            ("glTFid.schema.json", json!({ "type": "integer", "minimum": 0 })),
            ("glTFProperty.schema.json", property),
            ("glTFChildOfRootProperty.schema.json", child),
            ("material.normalTextureInfo.schema.json", texture),
        ];
        Schemas(known.into_iter().map(|(name, schema)| (name.to_string(), schema)).collect())
    }

    fn of_draft(folder: &Path) -> Self {
        let mut schemas = Schemas::of_gltf();
        let folder = folder.join("extensions/2.0/Khronos").join(EXTENSION).join("schema");
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            schemas.0.insert(name, serde_json::from_slice(&fs::read(&path).unwrap()).unwrap());
        }
        assert!(schemas.0.len() >= 9, "no schemas in {}", folder.display());
        schemas
    }

    /// What is wrong with a value, each with its place.
    fn faults(&self, schema: &Value, value: &Value, place: &str) -> Vec<String> {
        let mut faults = Vec::new();
        for (keyword, wanted) in schema.as_object().expect("a schema is an object") {
            let good = match (keyword.as_str(), value) {
                ("$schema" | "$id" | "title" | "description" | "gltf_detailedDescription" | "default", _) => {
                    true
                }
                ("$ref", _) => {
                    let name = wanted.as_str().unwrap();
                    let other = self.0.get(name).unwrap_or_else(|| panic!("there is no schema {name}"));
                    faults.extend(self.faults(other, value, place));
                    true
                }
                ("allOf", _) => {
                    faults
                        .extend(wanted.as_array().unwrap().iter().flat_map(|s| self.faults(s, value, place)));
                    true
                }
                ("type", _) => match wanted.as_str().unwrap() {
                    "object" => value.is_object(),
                    "array" => value.is_array(),
                    "string" => value.is_string(),
                    "number" => value.is_number(),
                    "integer" => value.as_f64().is_some_and(|x| x.fract() == 0.0),
                    other => panic!("the type {other} is not known"),
                },
                ("properties", Value::Object(fields)) => {
                    for (name, schema) in wanted.as_object().unwrap() {
                        if let Some(field) = fields.get(name) {
                            faults.extend(self.faults(schema, field, &format!("{place}/{name}")));
                        }
                    }
                    true
                }
                ("required", Value::Object(fields)) => {
                    wanted.as_array().unwrap().iter().all(|name| fields.contains_key(name.as_str().unwrap()))
                }
                ("dependentRequired", Value::Object(fields)) => {
                    wanted.as_object().unwrap().iter().all(|(name, needed)| {
                        let needed = needed.as_array().unwrap();
                        !fields.contains_key(name)
                            || needed.iter().all(|n| fields.contains_key(n.as_str().unwrap()))
                    })
                }
                ("items", Value::Array(items)) => {
                    for (at, item) in items.iter().enumerate() {
                        faults.extend(self.faults(wanted, item, &format!("{place}/{at}")));
                    }
                    true
                }
                ("minItems", Value::Array(items)) => items.len() as u64 >= wanted.as_u64().unwrap(),
                ("maxItems", Value::Array(items)) => items.len() as u64 <= wanted.as_u64().unwrap(),
                ("minimum", Value::Number(x)) => x.as_f64() >= wanted.as_f64(),
                ("maximum", Value::Number(x)) => x.as_f64() <= wanted.as_f64(),
                ("exclusiveMinimum", Value::Number(x)) => x.as_f64() > wanted.as_f64(),
                ("exclusiveMaximum", Value::Number(x)) => x.as_f64() < wanted.as_f64(),
                // A keyword for another type says nothing.
                (
                    "properties" | "required" | "dependentRequired" | "items" | "minItems" | "maxItems"
                    | "minimum" | "maximum" | "exclusiveMinimum" | "exclusiveMaximum",
                    _,
                ) => true,
                (other, _) => panic!("the keyword {other} is not known"),
            };
            if !good {
                faults.push(format!("{place}: {keyword} {wanted}, not {value}"));
            }
        }
        faults
    }

    /// What is wrong with the extension of a document and of its nodes.
    fn faults_of(&self, document: &Value) -> Vec<String> {
        let schema = |name: &str| &self.0[&format!("{name}.{EXTENSION}.schema.json")];
        let mut faults = self.faults(schema("glTF"), &document["extensions"][EXTENSION], "document");
        for (at, node) in document["nodes"].as_array().unwrap().iter().enumerate() {
            if let Some(extension) = node["extensions"].get(EXTENSION) {
                faults.extend(self.faults(schema("node"), extension, &format!("node {at}")));
            }
        }
        faults
    }
}

/// A tetrahedron with everything that we write.
fn body() -> AudioBody {
    let mut nodes = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let edges = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
    nodes.extend(edges.map(|[a, b]: [usize; 2]| 0.5 * (nodes[a] + nodes[b])));
    let triangles = [[0, 2, 1, 5, 7, 4], [0, 1, 3, 4, 8, 6], [0, 3, 2, 6, 9, 5], [1, 2, 3, 7, 9, 8]];
    let surface = ModalSurface { nodes, triangles: triangles.to_vec() };
    let mesh = surface.quarters();
    let mass = MassProperties::of(&mesh).unwrap();
    let mode = |frequency| RingingMode { frequency, decay_rate: 5.0, shape: vec![DVec3::ONE; 10] };
    AudioBody {
        name: "tetra".into(),
        mesh,
        material: AudioMaterial {
            name: Some("steel".into()),
            density: Some(7850.0),
            youngs_modulus: Some(2e11),
            poisson_ratio: Some(0.29),
            alpha: Some(5.0),
            beta: Some(3e-8),
        },
        mass: Some(BodyMass::of_solid(&mass, 7850.0)),
        ringing: Some(Ringing { surface, modes: vec![mode(440.0), mode(880.0)], max_frequency: Some(2e4) }),
        gain: 0.5,
        remarks: Vec::new(),
    }
}

/// The document that is written for a body.
fn document(folder: &Path, body: &AudioBody) -> Value {
    let path = folder.join("body.glb");
    write_audio_body(&path, body).unwrap();
    serde_json::from_slice(&gltf::Glb::from_slice(&fs::read(&path).unwrap()).unwrap().json).unwrap()
}

#[test]
fn what_is_written_is_valid_by_the_schemas() {
    let Some(draft) = draft() else { return };
    let schemas = Schemas::of_draft(&draft);
    let folder = tempfile::tempdir().unwrap();
    let full = body();
    let mut bare = full.clone();
    (bare.material, bare.mass, bare.ringing) = (AudioMaterial::default(), None, None);
    for body in [&full, &bare] {
        let faults = schemas.faults_of(&document(folder.path(), body));
        assert!(faults.is_empty(), "{faults:#?}");
    }
    // Every property of the draft is written, but for those of finishes.
    let written = document(folder.path(), &full)["extensions"][EXTENSION].clone();
    for (list, schema) in [("modalModels", "model"), ("acousticMaterials", "material")] {
        let properties = &schemas.0[&format!("glTF.{EXTENSION}.{schema}.schema.json")]["properties"];
        for name in
            properties.as_object().unwrap().keys().filter(|n| !["extensions", "extras"].contains(&n.as_str()))
        {
            assert!(written[list][0].get(name).is_some(), "{list} have no {name}");
        }
    }
    // The schemas can refuse.
    let good = document(folder.path(), &full);
    for (pointer, bad) in [
        ("modalModels/0/massProperties/mass", json!(0)),
        ("modalModels/0/massProperties/centerOfMass", json!([0, 0])),
        ("modalModels/0/shapes", json!(-1)),
        ("modalModels/0/name", json!(7)),
        ("modalModels", json!([])),
        ("acousticMaterials/0/poissonRatio", json!(0.5)),
        ("acousticMaterials/0/density", json!("7850")),
    ] {
        let mut document = good.clone();
        *document.pointer_mut(&format!("/extensions/{EXTENSION}/{pointer}")).unwrap() = bad;
        assert_eq!(schemas.faults_of(&document).len(), 1, "{pointer}");
    }
}

/// The samples below a folder.
fn samples(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            samples(&path, found);
        } else if path.extension().is_some_and(|e| e == "gltf") {
            found.push(path);
        }
    }
}

#[test]
fn the_samples_of_the_draft_can_be_read() {
    let Some(draft) = draft() else { return };
    let schemas = Schemas::of_draft(&draft);
    let mut files = Vec::new();
    samples(&draft.join("samples"), &mut files);
    files.sort();
    assert!(files.len() > 10, "{files:?}");
    let folder = tempfile::tempdir().unwrap();
    let (mut bodies, mut modes, mut norms) = (0, 0, (f64::INFINITY, 0.0_f64));
    for path in &files {
        let document: Value = serde_json::from_slice(&fs::read(path).unwrap()).unwrap();
        let faults = schemas.faults_of(&document);
        assert!(faults.is_empty(), "{}: {faults:#?}", path.display());
        let read = read_audio_bodies(path).unwrap();
        let models = &document["extensions"][EXTENSION]["modalModels"];
        for body in &read {
            bodies += 1;
            assert_eq!(body.remarks.iter().find(|r| r.contains("not part")), None, "{}", path.display());
            let Some(ringing) = &body.ringing else { continue };
            modes += ringing.modes.len();
            let rms = weighted_norms(body, ringing);
            norms = rms.iter().fold(norms, |(low, high), r| (low.min(*r), high.max(*r)));
            // Seen: 0.94 to 1.72.
            assert!(rms.iter().all(|r| (0.9..2.5).contains(r)), "{} {}: {rms:?}", path.display(), body.name);
            // And back through our own writer.
            let ours = folder.path().join("ours.glb");
            write_audio_body(&ours, body).unwrap();
            let [back] = &read_audio_bodies(&ours).unwrap()[..] else { panic!("one body") };
            for (a, b) in back.ringing.as_ref().unwrap().modes.iter().zip(&ringing.modes) {
                assert!((a.frequency / b.frequency - 1.0).abs() < 1e-7, "{a:?} {b:?}");
                assert!((a.decay_rate / b.decay_rate - 1.0).abs() < 1e-7);
            }
            // d = (α + β ω²)/2, by which the samples were made.
            if let (Some(alpha), Some(beta)) = (body.material.alpha, body.material.beta) {
                for mode in &ringing.modes {
                    let rate = 0.5 * (alpha + beta * (TAU * mode.frequency).powi(2));
                    // Residual seen: 0.
                    assert!((mode.decay_rate / rate - 1.0).abs() < 1e-6, "{} {rate}", mode.decay_rate);
                }
            }
        }
        let sounding = read.iter().filter(|b| b.ringing.is_some()).count();
        assert!(sounding >= models.as_array().map_or(0, Vec::len), "{}", path.display());
    }
    println!("{} files, {bodies} bodies, {modes} modes, norms {norms:.2?}", files.len());
}

/// √(mass · mean of |U|² over the surface) of each mode: of the size of 1 for shapes that are normalised by
/// the mass.
fn weighted_norms(body: &AudioBody, ringing: &Ringing) -> Vec<f64> {
    let quarters = ringing.surface.quarters();
    let areas: Vec<f64> = (0..quarters.triangles.len()).map(|t| quarters.area_vector(t).length()).collect();
    let mean = |mode: &RingingMode| {
        let corner = |n: &u32| mode.shape[*n as usize].length_squared() / 3.0;
        let sum = quarters.triangles.iter().zip(&areas).map(|(t, a)| a * t.iter().map(corner).sum::<f64>());
        sum.sum::<f64>() / areas.iter().sum::<f64>()
    };
    let mass = body.mass.expect("the samples have masses").mass;
    ringing.modes.iter().map(|mode| (mass * mean(mode)).sqrt()).collect()
}
