//! Bodies with their modes go through a glTF file and come back, to the precision of its numbers.

use std::f64::consts::TAU;
use std::path::Path;

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::sound_model::modal::surface::{ModalSurface, SurfaceLocator};
use clangor_pipeline::formats::mesh_reader::read_mesh;
use clangor_pipeline::interchange::audio_rigid_bodies::{
    AudioBody, AudioMaterial, AudioWriteError, BodyMass, Ringing, RingingMode, read_audio_bodies,
    write_audio_body,
};
use glam::{DMat3, DQuat, DVec3};
use proptest::prelude::*;
use serde_json::{Value, json};

/// A tetrahedron of six-node triangles, its corners at the corners of a box.
fn surface(size: DVec3) -> ModalSurface {
    let corner = |x, y, z| DVec3::new(x, y, z) * size;
    let mut nodes = vec![
        corner(1.0, 1.0, 1.0),
        corner(1.0, -1.0, -1.0),
        corner(-1.0, 1.0, -1.0),
        corner(-1.0, -1.0, 1.0),
    ];
    let edges = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
    // Bulging, as the nodes of curved bodies are.
    nodes.extend(edges.map(|[a, b]: [usize; 2]| 0.6 * (nodes[a] + nodes[b])));
    let middle = |a: u32, b: u32| {
        4 + edges.iter().position(|e| *e == [a.min(b) as usize, a.max(b) as usize]).unwrap() as u32
    };
    let triangles = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]
        .map(|[a, b, c]| [a, b, c, middle(a, b), middle(b, c), middle(c, a)]);
    ModalSurface { nodes, triangles: triangles.to_vec() }
}

fn body(size: DVec3, modes: Vec<RingingMode>) -> AudioBody {
    let surface = surface(size);
    let mesh = surface.quarters();
    let mass = MassProperties::of(&mesh).unwrap();
    AudioBody {
        name: "bowl".into(),
        mesh,
        material: AudioMaterial {
            name: Some("steel".into()),
            density: Some(7850.0),
            youngs_modulus: Some(2e11),
            poisson_ratio: Some(0.29),
            alpha: Some(5.0),
            beta: None,
        },
        mass: Some(BodyMass::of_solid(&mass, 7850.0)),
        ringing: Some(Ringing { surface, modes, max_frequency: Some(20_000.0) }),
        gain: 1.0,
        remarks: Vec::new(),
    }
}

fn mode(frequency: f64, decay_rate: f64, seed: f64) -> RingingMode {
    let wave = |i: usize| 10.0 * (seed + 0.7 * i as f64).sin();
    let shape = (0..10).map(|i| DVec3::new(wave(i), wave(3 * i + 1), -wave(7 * i + 2))).collect();
    RingingMode { frequency, decay_rate, shape }
}

fn modes() -> Vec<RingingMode> {
    vec![mode(440.0, 3.0, 0.1), mode(1234.5, 0.0, 0.7), mode(1234.5, 900.0, 1.9), mode(18_000.25, 21.0, 4.0)]
}

fn written(folder: &Path, body: &AudioBody) -> AudioBody {
    let path = folder.join("body.glb");
    write_audio_body(&path, body).unwrap();
    let mut bodies = read_audio_bodies(&path).unwrap();
    assert_eq!(bodies.len(), 1);
    bodies.remove(0)
}

/// Difference as a part of the larger.
fn off(a: f64, b: f64) -> f64 {
    if a == b { 0.0 } else { (a - b).abs() / a.abs().max(b.abs()) }
}

fn single(v: DVec3) -> DVec3 {
    v.as_vec3().as_dvec3()
}

fn largest(m: DMat3) -> f64 {
    m.to_cols_array().into_iter().fold(0.0, |a, x| a.max(x.abs()))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn what_is_written_is_read(
        size in prop::array::uniform3(1e-3..2.0_f64),
        numbers in prop::collection::vec((20.0..20_000.0_f64, 0.0..0.5_f64, -9.0..9.0_f64), 1..6),
    ) {
        let mut modes: Vec<RingingMode> =
            numbers.iter().map(|(f, ratio, seed)| mode(*f, ratio * TAU * f, *seed)).collect();
        modes.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        let folder = tempfile::tempdir().unwrap();
        let body = body(DVec3::from_array(size), modes);
        let back = written(folder.path(), &body);
        prop_assert_eq!(&back.material, &body.material);
        prop_assert_eq!((&back.name, back.gain, &back.remarks), (&body.name, 1.0, &Vec::new()));
        prop_assert_eq!(&back.mesh.triangles, &body.mesh.triangles);
        let (mass, was) = (back.mass.unwrap(), body.mass.unwrap());
        prop_assert_eq!((mass.mass, mass.centre_of_mass), (was.mass, was.centre_of_mass));
        // Residual seen: 9e-16, of the rotation to the principal axes and back.
        prop_assert!(largest(mass.inertia - was.inertia) < 1e-14 * largest(was.inertia));
        let (ringing, was) = (back.ringing.unwrap(), body.ringing.unwrap());
        prop_assert_eq!(ringing.max_frequency, was.max_frequency);
        prop_assert_eq!(&ringing.surface.triangles, &was.surface.triangles);
        let nodes: Vec<DVec3> = was.surface.nodes.iter().copied().map(single).collect();
        prop_assert_eq!(&ringing.surface.nodes, &nodes);
        for (mode, was) in ringing.modes.iter().zip(&was.modes) {
            // 32 bits round by 6e-8; f from f_d and d is a sum of squares. Residual seen: 6e-8.
            prop_assert!(off(mode.frequency, was.frequency) < 1e-7, "{mode:?} {was:?}");
            prop_assert!(off(mode.decay_rate, was.decay_rate) < 6e-8);
            let shape: Vec<DVec3> = was.shape.iter().copied().map(single).collect();
            prop_assert_eq!(&mode.shape, &shape);
        }
    }
}

/// The document and the binary part of a GLB file.
fn unpacked(path: &Path) -> (Value, Vec<u8>) {
    let bytes = std::fs::read(path).unwrap();
    let glb = gltf::Glb::from_slice(&bytes).unwrap();
    (serde_json::from_slice(&glb.json).unwrap(), glb.bin.unwrap().into_owned())
}

fn packed(path: &Path, document: &Value, binary: Vec<u8>) {
    let json = document.to_string().into_bytes();
    let header = gltf::binary::Header { magic: *b"glTF", version: 2, length: 0 };
    let glb = gltf::Glb { header, json: json.into(), bin: Some(binary.into()) };
    std::fs::write(path, glb.to_vec().unwrap()).unwrap();
}

/// A file after changes to its document.
fn edited(folder: &Path, body: &AudioBody, edit: impl FnOnce(&mut Value)) -> Vec<AudioBody> {
    let path = folder.join("edited.glb");
    write_audio_body(&path, body).unwrap();
    let (mut document, binary) = unpacked(&path);
    edit(&mut document);
    packed(&path, &document, binary);
    read_audio_bodies(&path).unwrap()
}

#[test]
fn the_file_has_what_the_draft_asks_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("body.glb");
    let body = body(DVec3::splat(0.01), modes());
    assert_eq!(write_audio_body(&path, &body).unwrap(), 4);
    // The whole file is valid to another reader, and a program that knows nothing of sound sees the mesh.
    let gltf = gltf::Gltf::open(&path).unwrap();
    assert_eq!(gltf.nodes().next().unwrap().name(), Some("bowl"));
    assert_eq!(read_mesh(&path).unwrap().triangles, body.mesh.triangles);
    let (document, _) = unpacked(&path);
    assert_eq!(document["extensionsUsed"], json!(["KHR_audio_rigid_bodies"]));
    assert!(document.get("extensionsRequired").is_none());
    let extension = &document["extensions"]["KHR_audio_rigid_bodies"];
    let model = &extension["modalModels"][0];
    let accessor = |name: &str| {
        let a = &document["accessors"][model[name].as_u64().unwrap() as usize];
        (a["type"].as_str().unwrap(), a["componentType"].as_u64().unwrap(), a["count"].as_u64().unwrap())
    };
    assert_eq!(accessor("frequencies"), ("SCALAR", 5126, 4));
    assert_eq!(accessor("decayRates"), ("SCALAR", 5126, 4));
    assert_eq!(accessor("positions"), ("VEC3", 5126, 10));
    assert_eq!(accessor("shapes"), ("VEC3", 5126, 40));
    assert_eq!(accessor("indices"), ("SCALAR", 5125, 48));
    assert_eq!(model["material"], json!(0));
    let material = &extension["acousticMaterials"][0];
    let expected = json!({
        "name": "steel", "density": 7850.0, "youngsModulus": 2e11, "poissonRatio": 0.29, "alpha": 5.0,
    });
    assert_eq!(*material, expected);
    let node = &document["nodes"][0]["extensions"]["KHR_audio_rigid_bodies"];
    assert_eq!(*node, json!({ "modalModel": 0, "acousticSurface": 0 }));
    let mass = &model["massProperties"];
    assert!(mass["mass"].as_f64().unwrap() > 0.0);
    for (name, count) in [("centerOfMass", 3), ("inertiaDiagonal", 3), ("inertiaOrientation", 4)] {
        assert_eq!(mass[name].as_array().unwrap().len(), count, "{name}");
    }
    // What is heard of the third mode: √(f² − (d/2π)²); the loudest comes first, the one that dies at once
    // last.
    let blob = gltf.blob.as_ref().unwrap();
    let numbers = |name: &str| {
        let accessor = gltf.accessors().nth(model[name].as_u64().unwrap() as usize).unwrap();
        gltf::accessor::Iter::<f32>::new(accessor, |_| Some(blob)).unwrap().collect::<Vec<f32>>()
    };
    let frequencies = numbers("frequencies");
    assert!(frequencies.contains(&(((1234.5_f64 - 900.0 / TAU) * (1234.5 + 900.0 / TAU)).sqrt() as f32)));
    assert_eq!(numbers("decayRates").last(), Some(&900.0));
}

#[test]
fn a_node_moves_turns_and_sizes_its_model() {
    let folder = tempfile::tempdir().unwrap();
    let body = body(DVec3::new(0.01, 0.02, 0.03), modes());
    let still = written(folder.path(), &body);
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -2.0).normalize(), 0.8);
    let shift = DVec3::new(0.5, -0.25, 2.0);
    for scale in [2.5, -2.5] {
        let moved = edited(folder.path(), &body, |document| {
            document["nodes"] = json!([
                { "children": [1], "translation": shift.to_array(), "rotation": turn.to_array() },
                document["nodes"][0].take(),
            ]);
            document["nodes"][1]["scale"] = json!([scale, scale, scale]);
        });
        let [moved] = &moved[..] else { panic!("one body") };
        let (ringing, was) = (moved.ringing.as_ref().unwrap(), still.ringing.as_ref().unwrap());
        let sign = f64::signum(scale);
        for (a, b) in ringing.surface.nodes.iter().zip(&was.surface.nodes) {
            // Residual seen: 4e-16.
            assert!(a.distance(shift + turn * (scale * *b)) < 1e-15);
        }
        for (mode, was) in ringing.modes.iter().zip(&was.modes) {
            // The numbers hold for the size that the scene gives the body: only directions change.
            assert_eq!((mode.frequency, mode.decay_rate), (was.frequency, was.decay_rate));
            for (a, b) in mode.shape.iter().zip(&was.shape) {
                // Residual seen: 4e-15.
                assert!(a.distance(turn * (sign * *b)) < 1e-13, "{a} {b}");
            }
        }
        // A mirrored surface is still outward.
        assert!(MassProperties::of(&ringing.surface.quarters()).unwrap().volume > 0.0);
        assert_eq!(moved.mesh.vertices, read_mesh(&folder.path().join("edited.glb")).unwrap().vertices);
        let (mass, was) = (moved.mass.unwrap(), still.mass.unwrap());
        let axes = DMat3::from_quat(turn);
        let expected = axes * was.inertia * axes.transpose();
        // Residual seen: 1e-16 of the largest.
        assert!(largest(mass.inertia - expected) < 1e-14 * largest(expected));
        assert_eq!(mass.mass, was.mass);
    }
}

#[test]
fn shapes_are_linear_between_the_points_of_others() {
    let folder = tempfile::tempdir().unwrap();
    let body = body(DVec3::splat(0.01), modes());
    let bodies = edited(folder.path(), &body, |document| {
        let model = &mut document["extensions"]["KHR_audio_rigid_bodies"]["modalModels"][0];
        model.as_object_mut().unwrap().remove("extras");
    });
    let (ringing, was) = (bodies[0].ringing.as_ref().unwrap(), body.ringing.as_ref().unwrap());
    assert_eq!(ringing.surface.triangles.len(), 16);
    let locator = SurfaceLocator::new(&ringing.surface);
    let quarters: TriMesh = was.surface.quarters();
    for triangle in &quarters.triangles {
        let weights = [0.2, 0.5, 0.3];
        let at =
            |values: &[DVec3]| -> DVec3 { (0..3).map(|k| weights[k] * values[triangle[k] as usize]).sum() };
        let place = locator.nearest(at(&quarters.vertices)).unwrap();
        // Residual seen: 3e-7, of positions in 32 bits in shapes of 10.
        let shape = place.interpolate(&ringing.modes[0].shape);
        assert!(shape.distance(at(&was.modes[0].shape)) < 1e-5, "{shape}");
    }
    // Without triangles the points of the mesh take what is nearest, here at the same places.
    let bodies = edited(folder.path(), &body, |document| {
        let model = &mut document["extensions"]["KHR_audio_rigid_bodies"]["modalModels"][0];
        model.as_object_mut().unwrap().remove("extras");
        model.as_object_mut().unwrap().remove("indices");
    });
    assert_eq!(bodies[0].ringing, Some(Ringing { max_frequency: None, ..ringing.clone() }));
    // And without a mesh the body looks as its triangles do.
    let bodies = edited(folder.path(), &body, |document| {
        document["nodes"][0].as_object_mut().unwrap().remove("mesh");
    });
    assert_eq!(bodies[0].mesh.triangles, body.mesh.triangles);
}

#[test]
fn the_mass_of_the_moving_body_holds() {
    let folder = tempfile::tempdir().unwrap();
    let body = body(DVec3::splat(0.01), modes());
    let mut motion = json!({ "mass": 0.25, "inertiaDiagonal": [1.0, 2.0, 3.0] });
    let with = |motion: &Value| {
        let bodies = edited(folder.path(), &body, |document| {
            document["nodes"][0]["extensions"]["KHR_physics_rigid_bodies"] = json!({ "motion": motion });
        });
        (bodies[0].mass.unwrap(), bodies[0].remarks.clone())
    };
    let (mass, remarks) = with(&motion);
    assert_eq!((mass.mass, mass.inertia), (0.25, DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0))));
    assert!(remarks[0].contains("0.25 kg"), "{remarks:?}");
    motion["isKinematic"] = json!(true);
    assert_eq!(with(&motion).0.mass, body.mass.unwrap().mass);
}

#[test]
fn a_model_of_another_size_is_known_by_its_mass() {
    let folder = tempfile::tempdir().unwrap();
    let body = body(DVec3::splat(0.01), modes());
    let was = written(folder.path(), &body).ringing.unwrap();
    let bodies = edited(folder.path(), &body, |document| {
        let mass = 8.0 * body.mass.unwrap().mass;
        document["nodes"][0]["extensions"]["KHR_physics_rigid_bodies"] =
            json!({ "motion": { "mass": mass } });
        document["nodes"][0]["scale"] = json!([2.0, 2.0, 2.0]);
    });
    assert!(bodies[0].remarks[0].contains("resized"), "{:?}", bodies[0].remarks);
    assert!(off(bodies[0].mass.unwrap().mass, 8.0 * body.mass.unwrap().mass) < 1e-15);
    let ringing = bodies[0].ringing.as_ref().unwrap();
    for (mode, was) in ringing.modes.iter().zip(&was.modes) {
        // Residual seen: 0. The material has α = 5 alone.
        assert!(off(mode.frequency, 0.5 * was.frequency) < 1e-14);
        assert!(mode.shape[3].distance(8.0_f64.powf(-0.5) * was.shape[3]) < 1e-13);
        assert_eq!(mode.decay_rate, 2.5);
    }
    assert_eq!(ringing.surface.nodes[1], 2.0 * was.surface.nodes[1]);
}

#[test]
fn a_file_holds_several_bodies_and_silent_ones() {
    let folder = tempfile::tempdir().unwrap();
    let bodies = edited(folder.path(), &body(DVec3::splat(0.01), modes()), |document| {
        let node = document["nodes"][0].clone();
        let mut silent = node.clone();
        silent["name"] = json!("floor");
        silent["extensions"]["KHR_audio_rigid_bodies"] = json!({ "acousticSurface": 0 });
        let mut plain = node.clone();
        plain["extensions"] = json!({});
        plain["children"] = json!([4]);
        let mut copy = node.clone();
        copy["name"] = json!("copy");
        copy["extensions"]["KHR_audio_rigid_bodies"]["gain"] = json!(0.5);
        let inert = json!({ "name": "inert", "extensions": { "KHR_audio_rigid_bodies": {} } });
        document["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
        document["nodes"] = json!([node, silent, plain, inert, copy]);
    });
    let names: Vec<(&str, bool, f64)> =
        bodies.iter().map(|b| (b.name.as_str(), b.ringing.is_some(), b.gain)).collect();
    assert_eq!(names, [("bowl", true, 1.0), ("floor", false, 1.0), ("copy", true, 0.5)]);
    assert_eq!(bodies[1].material.youngs_modulus, Some(2e11));
}

#[test]
fn bodies_without_ringing_are_not_written_as_ringing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("body.glb");
    // Damped beyond ringing.
    let creeping = mode(100.0, TAU * 101.0, 0.3);
    let refused = write_audio_body(&path, &body(DVec3::splat(0.01), vec![creeping.clone()]));
    assert!(matches!(refused, Err(AudioWriteError::Silent { .. })));
    for (frequency, decay, nodes) in [(0.0, 1.0, 10), (1e3, f64::NAN, 10), (1e3, -1.0, 10), (1e3, 1.0, 9)] {
        let mut mode = mode(frequency, decay, 0.1);
        mode.shape.truncate(nodes);
        let refused = write_audio_body(&path, &body(DVec3::splat(0.01), vec![mode]));
        assert!(matches!(refused, Err(AudioWriteError::Mode { mode: 0, .. })), "{refused:?}");
    }
    assert!(!path.exists());
    let both = body(DVec3::splat(0.01), vec![creeping, mode(440.0, 3.0, 0.3)]);
    assert_eq!(write_audio_body(&path, &both).unwrap(), 1);
    let mut silent = both.clone();
    silent.ringing = None;
    let back = written(folder.path(), &silent);
    assert_eq!((back.ringing, back.material), (None, silent.material));
}
