//! Exported motion, read back with the `gltf` crate, which shares no code with our writer, and with our mesh
//! reader.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Life, MeshSurface, Motion, Surface, World};
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::material::{Damping, Material};
use clangor_core::pose::{Keyframe, Pose, Track};
use clangor_core::timeline::PoseRow;
use clangor_pipeline::formats::glb::{GlbError, write_glb};
use clangor_pipeline::formats::mesh_reader::read_mesh;
use glam::{DMat3, DQuat, DVec3};
use gltf::animation::util::ReadOutputs;

fn body(name: &str, surface: &Arc<Surface>, position: DVec3, motion: Motion) -> Body {
    let material = Material {
        name: "steel".into(),
        density: 7850.0,
        youngs_modulus: 200e9,
        poisson_ratio: 0.29,
        restitution: 0.5,
        restitution_speed: None,
        rigid_restitution: None,
        yield_strength: None,
        friction: 0.3,
        rolling_loss: 0.0,
        damping: Damping::LossFactor(1e-3),
        tensile_strength: None,
        fracture_energy: None,
        source: String::new(),
    };
    Body::new(name, material, Arc::clone(surface), 1.0, DMat3::IDENTITY)
        .at(position)
        .with_motion(motion)
        .with_edge_radius(1e-4)
}

fn world() -> World {
    let vertices = vec![DVec3::X, DVec3::Y, DVec3::Z, DVec3::splat(-0.5)];
    let triangles = vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
    let rock =
        Arc::new(Surface::Mesh(MeshSurface::restored(TriMesh { vertices, triangles }, vec![1.0; 4], 0.1)));
    let ball = Arc::new(Surface::Sphere { radius: 0.01 });
    let key = |time, x| Keyframe { time, pose: Pose::at(DVec3::X * x) };
    let track = Track::try_new(vec![key(0.0, 0.0), key(0.5, 2.0)]).unwrap();
    let bodies = vec![
        body("rock", &rock, DVec3::Y, Motion::Free),
        body("twin", &rock, DVec3::Y * 2.0, Motion::Fixed),
        body("ball", &ball, DVec3::ZERO, Motion::Keyframed(track)),
        body("floor", &Arc::new(Surface::HalfSpace), DVec3::ZERO, Motion::Fixed),
    ];
    World { bodies, links: Vec::new(), gravity: DVec3::ZERO }
}

/// Flies and tumbles.
fn motion(time: f64) -> Pose {
    let position = DVec3::new(0.3 * time, 1.0 - 4.9 * time * time, 0.0);
    Pose { position, orientation: DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 20.0 * time) }
}

fn row(time: f64) -> PoseRow {
    let pose = motion(time);
    PoseRow {
        time,
        body: BodyId(0),
        position: pose.position,
        orientation: pose.orientation,
        velocity: DVec3::ZERO,
        angular_velocity: DVec3::ZERO,
    }
}

/// Translations and rotations of each animated node, and the common instants.
type Animation = (Vec<f32>, BTreeMap<String, Vec<[f32; 3]>>, BTreeMap<String, Vec<[f32; 4]>>);

fn animation(document: &gltf::Document, blob: &[u8]) -> Animation {
    let (mut times, mut moves, mut turns) = (Vec::new(), BTreeMap::new(), BTreeMap::new());
    for channel in document.animations().next().unwrap().channels() {
        let reader = channel.reader(|_| Some(blob));
        times = reader.read_inputs().unwrap().collect();
        let name = channel.target().node().name().unwrap().to_string();
        match reader.read_outputs().unwrap() {
            ReadOutputs::Translations(values) => _ = moves.insert(name, values.collect()),
            ReadOutputs::Rotations(values) => _ = turns.insert(name, values.into_f32().collect()),
            _ => panic!("only translations and rotations are written"),
        }
    }
    (times, moves, turns)
}

fn export(path: &Path, rate: f64) -> (gltf::Document, Vec<u8>) {
    let rows = (0..=1000).map(|k| Ok(row(f64::from(k) * 1e-3)));
    let summary = write_glb(path, &world().bodies, rows, rate).unwrap();
    assert_eq!((summary.nodes, summary.animated, summary.frames), (4, 2, rate as usize + 1));
    let gltf = gltf::Gltf::open(path).unwrap();
    let blob = gltf.blob.clone().unwrap();
    (gltf.document, blob)
}

#[test]
fn another_reader_sees_the_same_motion() {
    let folder = tempfile::tempdir().unwrap();
    for rate in [60.0, 120.0, 240.0] {
        let (document, blob) = export(&folder.path().join("a.glb"), rate);
        let (times, moves, turns) = animation(&document, &blob);
        assert_eq!(times.len(), rate as usize + 1);
        assert_eq!(moves.keys().collect::<Vec<_>>(), ["ball", "rock"]);
        let (mut worst_move, mut worst_turn) = (0.0f64, 0.0f64);
        let mut last = DQuat::IDENTITY;
        for (k, time) in times.iter().enumerate() {
            assert!((f64::from(*time) - k as f64 / rate).abs() < 1e-7);
            let expected = motion(k as f64 / rate);
            let position = DVec3::from(moves["rock"][k].map(f64::from));
            let orientation = DQuat::from_array(turns["rock"][k].map(f64::from));
            worst_move = worst_move.max(position.distance(expected.position));
            worst_turn = worst_turn.max(1.0 - orientation.dot(expected.orientation).abs());
            assert!(orientation.dot(last) > 0.0, "the shorter way round");
            last = orientation;
        }
        // Seen: 1.2e-6 m, the sag of a chord of 1 ms under gravity; 5e-8 by f32.
        assert!(worst_move < 2e-6 && worst_turn < 2e-7, "{worst_move:e} {worst_turn:e}");
        // A body without rows follows its track.
        assert!((moves["ball"][rate as usize / 4][0] - 1.0).abs() < 1e-6);
        assert!((moves["ball"][rate as usize][0] - 2.0).abs() < 1e-6);
    }
}

#[test]
fn another_reader_sees_the_same_bodies() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    let (document, blob) = export(&path, 120.0);
    let names: Vec<_> = document.nodes().map(|n| n.name().unwrap().to_string()).collect();
    assert_eq!(names, ["rock", "twin", "ball", "floor"]);
    // Bodies of one surface share a mesh.
    let meshes: Vec<_> = document.nodes().map(|n| n.mesh().unwrap().index()).collect();
    assert_eq!(meshes, [0, 0, 1, 2]);
    let expected = world();
    let Surface::Mesh(rock) = &*expected.bodies[0].surface else { panic!("a mesh") };
    let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|_| Some(&blob));
    let positions: Vec<DVec3> =
        reader.read_positions().unwrap().map(|p| DVec3::from(p.map(f64::from))).collect();
    assert_eq!(positions, rock.mesh.vertices);
    let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
    assert_eq!(indices, rock.mesh.triangles.concat());
    let sphere = document.meshes().nth(1).unwrap().primitives().next().unwrap();
    for position in sphere.reader(|_| Some(&blob)).read_positions().unwrap() {
        assert!((DVec3::from(position.map(f64::from)).length() - 0.01).abs() < 1e-8);
    }
    // Our own reader: all bodies in one, where they start.
    let mesh = read_mesh(&path).unwrap();
    assert_eq!(&mesh.vertices[..4], rock.mesh.vertices.iter().map(|v| *v + DVec3::Y).collect::<Vec<_>>());
    assert_eq!(mesh.vertices[4], rock.mesh.vertices[0] + DVec3::Y * 2.0);
    let floor = mesh.corners(mesh.triangles.len() - 1);
    assert!((floor[1] - floor[0]).cross(floor[2] - floor[0]).y > 0.0, "the floor faces up");
}

#[test]
fn impossible_exports_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    let wrong = |rows: Vec<PoseRow>, rate| {
        write_glb(&path, &world().bodies, rows.into_iter().map(Ok), rate).unwrap_err()
    };
    for rate in [0.0, -1.0, f64::NAN, 1e9] {
        assert!(matches!(wrong(vec![], rate), GlbError::Rate { .. }));
    }
    let stranger = PoseRow { body: BodyId(4), ..row(0.0) };
    assert!(matches!(wrong(vec![stranger], 60.0), GlbError::Body { body: 4, bodies: 4 }));
    assert!(matches!(wrong(vec![row(1e12)], 60.0), GlbError::TooLarge { .. }));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    let nothing = World { bodies: Vec::new(), links: Vec::new(), gravity: DVec3::ZERO };
    write_glb(&path, &nothing.bodies, std::iter::empty(), 60.0).unwrap();
    assert_eq!(gltf::Gltf::open(&path).unwrap().nodes().count(), 0);
}

#[test]
fn bodies_are_seen_while_they_live() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    let mut bodies = world().bodies;
    bodies[0].life.death = 0.25;
    let piece = Body { name: "piece".into(), life: Life::of_piece(BodyId(0), 0.25), ..bodies[0].clone() };
    bodies.push(Body { life: Life { death: 0.75, ..piece.life }, ..piece });
    let of_piece = |k: i32| PoseRow { body: BodyId(4), ..row(f64::from(k) * 1e-3) };
    let rows = (0..=250).map(|k| row(f64::from(k) * 1e-3)).chain((250..=750).map(of_piece)).map(Ok);
    write_glb(&path, &bodies, rows, 60.0).unwrap();
    let gltf = gltf::Gltf::open(&path).unwrap();
    let blob = gltf.blob.clone().unwrap();
    let mut scales = BTreeMap::new();
    for channel in gltf.animations().next().unwrap().channels() {
        let reader = channel.reader(|_| Some(&blob));
        let times: Vec<f32> = reader.read_inputs().unwrap().collect();
        let Some(ReadOutputs::Scales(values)) = reader.read_outputs() else { continue };
        assert_eq!(channel.sampler().interpolation(), gltf::animation::Interpolation::Step);
        let keys: Vec<(f32, [f32; 3])> = times.into_iter().zip(values).collect();
        scales.insert(channel.target().node().name().unwrap().to_string(), keys);
    }
    let (seen, hidden) = ([1.0; 3], [0.0; 3]);
    assert_eq!(scales["rock"], [(0.0, seen), (0.25, hidden)]);
    assert_eq!(scales["piece"], [(0.0, hidden), (0.25, seen), (0.75, hidden)]);
    assert_eq!(scales.len(), 2);
    // Viewers that play nothing show the beginning.
    let shown: Vec<_> = gltf.nodes().map(|node| node.transform().decomposed().2).collect();
    assert_eq!(shown, [seen, seen, seen, seen, hidden]);
}
