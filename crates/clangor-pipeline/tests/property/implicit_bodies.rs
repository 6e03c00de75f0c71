//! Nodes with an implicit shape become bodies of that shape, with mass, inertia, restitution and friction
//! of the file; what is no body is refused by node.

use std::fs;
use std::path::Path;

use crate::imported_motion::{folder, import};
use clangor_core::body::{Body, Motion, Surface};
use clangor_pipeline::formats::timeline_file::TimelineReader;
use glam::DVec3;
use serde_json::{Value, json};

const SCENE: &str = r#"version = 1
[material.putty]
base = "steel"
density = 2000.0
[[listener]]
position = [0.3, 0.4, 0.4]
"#;
const G: f64 = 9.80665;
const RATE: f64 = 240.0;

/// A file with one node that falls 0.5 m and bounces with half its speed, and an endless plane; `shape` and
/// `physics` are those of the node.
fn document(shape: &Value, node: &Value, half_height: f64) -> (Value, Vec<u8>) {
    let fall = (2.0 * 0.5 / G).sqrt();
    let height = |t: f64| match t {
        t if t < fall => 0.5 - 0.5 * G * t * t,
        t => 0.5 * G * fall * (t - fall) - 0.5 * G * (t - fall).powi(2),
    };
    let times: Vec<f32> = (0..120).map(|k| (f64::from(k) / RATE) as f32).collect();
    let places = times.iter().flat_map(|t| [0.0, (half_height + height(f64::from(*t))) as f32, 0.0]);
    let bytes: Vec<u8> = times.iter().copied().chain(places).flat_map(|x| x.to_le_bytes()).collect();
    let mut falling = json!({ "name": "thing" });
    falling.as_object_mut().unwrap().extend(node.as_object().unwrap().clone());
    let ground = json!({ "collider": { "geometry": { "shape": 1 } } });
    let document = json!({
        "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0, 1] }],
        "nodes": [falling, { "name": "ground", "extras": { "material": "granite" },
            "extensions": { "KHR_physics_rigid_bodies": ground } }],
        "extensions": {
            "KHR_implicit_shapes": { "shapes": [shape, { "type": "plane" }] },
            "KHR_physics_rigid_bodies": { "physicsMaterials": [
                { "name": "putty", "restitution": 0.25, "dynamicFriction": 0.125 },
                { "restitution": 1.5 },
            ] },
        },
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 120, "type": "SCALAR" },
            { "bufferView": 1, "componentType": 5126, "count": 120, "type": "VEC3" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 480 },
            { "buffer": 0, "byteOffset": 480, "byteLength": 1440 },
        ],
        "buffers": [{ "byteLength": bytes.len(), "uri": "data.bin" }],
        "animations": [{
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
            "samplers": [{ "input": 0, "output": 1, "interpolation": "LINEAR" }],
        }],
    });
    (document, bytes)
}

/// A node with a collider of shape 0, with these properties of its motion.
fn node(motion: &Value, material: usize) -> Value {
    json!({ "extensions": { "KHR_physics_rigid_bodies": {
        "motion": motion, "collider": { "geometry": { "shape": 0 }, "physicsMaterial": material },
    } } })
}

/// Imports it; the bodies, the notices, and the impacts.
fn run(shape: &Value, node: &Value, half_height: f64) -> Result<(Vec<Body>, Vec<String>, usize), String> {
    let (document, bytes) = document(shape, node, half_height);
    let folder = folder(SCENE, &[("a.gltf", &document.to_string())]);
    fs::write(folder.path().join("data.bin"), bytes).unwrap();
    let summary = import(folder.path(), &["a.gltf"], &[], false)?;
    let out: &Path = &folder.path().join("out.timeline");
    let bodies = TimelineReader::open(out).unwrap().header().world.bodies.clone();
    Ok((bodies, summary.notices, summary.found.unwrap().confidence.len()))
}

#[test]
fn property_a_node_with_an_implicit_shape_is_a_body_of_that_shape() {
    let pi = std::f64::consts::PI;
    let sphere = json!({ "type": "sphere", "sphere": { "radius": 0.02 } });
    let cuboid = json!({ "type": "box", "box": { "size": [0.04, 0.02, 0.06] } });
    let cylinder = json!({ "type": "cylinder",
        "cylinder": { "height": 0.03, "radiusBottom": 0.02, "radiusTop": 0.02 } });
    let capsule = json!({ "type": "capsule",
        "capsule": { "height": 0.04, "radiusBottom": 0.01, "radiusTop": 0.01 } });
    let cases = [
        (sphere, 0.02, 4.0 / 3.0 * pi * 8e-6),
        (cuboid, 0.01, 4.8e-5),
        (cylinder, 0.015, pi * 4e-4 * 0.03),
        (capsule, 0.03, pi * 1e-4 * 0.04 + 4.0 / 3.0 * pi * 1e-6),
    ];
    for (shape, half_height, volume) in cases {
        let (bodies, notices, impacts) = run(&shape, &node(&json!({}), 0), half_height).unwrap();
        assert_eq!((bodies.len(), impacts), (2, 1), "{shape}: {notices:?}");
        let [thing, ground] = [&bodies[0], &bodies[1]];
        // Exact but for the capsule, whose mesh is 8e-4 smaller.
        assert!((thing.mass / (2000.0 * volume) - 1.0).abs() < 1e-3, "{shape}: {}", thing.mass);
        let material = &thing.material;
        assert_eq!((material.name.as_str(), material.restitution, material.friction), ("putty", 0.25, 0.125));
        assert!(matches!(*ground.surface, Surface::HalfSpace) && matches!(ground.motion, Motion::Fixed));
        assert_eq!(ground.material.name, "granite");
    }
}

#[test]
fn property_mass_and_inertia_are_those_of_the_file() {
    let sphere = json!({ "type": "sphere", "sphere": { "radius": 0.02 } });
    let motion = json!({ "mass": 2.0, "inertiaDiagonal": [1e-3, 2e-3, 2.5e-3],
        "inertiaOrientation": [0.0, 0.0, 0.5_f64.sqrt(), 0.5_f64.sqrt()],
        "centerOfMass": [0.0, 0.001, 0.0] });
    let mut jointed = node(&motion, 0);
    jointed["extensions"]["KHR_physics_rigid_bodies"]["joint"] = json!({ "connectedNode": 1, "joint": 0 });
    let (bodies, notices, _) = run(&sphere, &jointed, 0.02).unwrap();
    assert_eq!(bodies[0].mass, 2.0);
    // A quarter turn about z exchanges x and y.
    let expected = DVec3::new(2e-3, 1e-3, 2.5e-3);
    let inertia = bodies[0].inertia;
    assert!(DVec3::new(inertia.x_axis.x, inertia.y_axis.y, inertia.z_axis.z).distance(expected) < 1e-12);
    let wanted = "node thing: its joint is not read";
    assert!(notices.iter().any(|notice| notice.contains(wanted)), "{wanted}: {notices:?}");
    // The centre of mass lies 1 mm above that of the ball, which becomes a mesh about it.
    let form = bodies[0].form_of_uneven().expect("it is not homogeneous");
    assert!(form.centre_of_mass.distance(DVec3::new(0.0, -0.001, 0.0)) < 1e-9, "{}", form.centre_of_mass);
    let (centred, ..) = run(&sphere, &node(&json!({ "mass": 2.0 }), 0), 0.02).unwrap();
    let [at, was] = [bodies[0].pose.position, centred[0].pose.position];
    assert!((at - was).distance(DVec3::new(0.0, 0.001, 0.0)) < 1e-9, "{at} {was}");
    // An infinite mass is moved from outside.
    let (bodies, ..) = run(&sphere, &node(&json!({ "mass": 0.0 }), 0), 0.02).unwrap();
    assert!(matches!(bodies[0].motion, Motion::Keyframed(_)));
}

#[test]
fn property_shapes_and_physics_that_no_body_has_are_refused_by_node() {
    let sphere = |radius: f64| json!({ "type": "sphere", "sphere": { "radius": radius } });
    let ends = |kind: &str, height: f64, bottom: f64| {
        let mut shape = json!({ "type": kind });
        shape[kind] = json!({ "height": height, "radiusBottom": bottom, "radiusTop": 0.01 });
        shape
    };
    let plain = node(&json!({}), 0);
    let scaled = |scale: [f64; 3]| {
        let mut scaled = plain.clone();
        scaled["scale"] = json!(scale);
        scaled
    };
    let cases = [
        (sphere(0.0), plain.clone(), "its radius is 0; it must be above 0 m"),
        (json!({ "type": "torus" }), plain.clone(), "torus is none of sphere, box"),
        (ends("capsule", 0.01, 0.05), plain.clone(), "one end lies within the other"),
        (ends("capsule", 0.03, 0.01), scaled([1.0, 2.0, 1.0]), "a capsule under the scale 1, 2, 1"),
        (ends("cylinder", 0.03, 0.01), scaled([2.0, 1.0, 1.0]), "a cylinder under the scale 2, 1, 1"),
        (sphere(0.02), node(&json!({ "mass": -1.0 }), 0), "its mass in KHR_physics_rigid_bodies is -1.0"),
        (sphere(0.02), node(&json!({ "mass": 1.0, "inertiaDiagonal": [1.0, 1.0, 9.0] }), 0), "none exceeds"),
        (sphere(0.02), node(&json!({}), 1), "its restitution in KHR_physics_rigid_bodies is 1.5"),
        (sphere(0.02), node(&json!({}), 7), "its physicsMaterial in KHR_physics_rigid_bodies is 7"),
    ];
    for (shape, node, wanted) in cases {
        let message = run(&shape, &node, 0.02).unwrap_err();
        assert!(message.contains("node thing") && message.contains(wanted), "{wanted}: {message}");
    }
    let mut missing = plain.clone();
    missing["extensions"]["KHR_physics_rigid_bodies"]["collider"]["geometry"]["shape"] = json!(9);
    let message = run(&sphere(0.02), &missing, 0.02).unwrap_err();
    assert!(message.contains("there is no shape 9"), "{message}");
    // A sphere drawn out is an ellipsoid.
    let (bodies, ..) = run(&sphere(0.02), &scaled([1.0, 1.0, 2.0]), 0.02).unwrap();
    let volume = 4.0 / 3.0 * std::f64::consts::PI * 8e-6 * 2.0;
    assert!((bodies[0].mass / (2000.0 * volume) - 1.0).abs() < 1e-6, "{}", bodies[0].mass);
}
