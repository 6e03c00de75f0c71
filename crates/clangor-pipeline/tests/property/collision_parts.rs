//! Convex parts of mesh files: those of the whole file, found only where bodies move, once for each mesh and
//! error, and the same from the cache.

use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

use clangor_core::body::{MeshSurface, Surface};
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::shape::Shape;
use clangor_pipeline::formats::mesh_reader::read_mesh;
use clangor_pipeline::formats::model_cache::ModelCache;
use clangor_pipeline::stages::find_collision_parts::find_collision_parts;
use clangor_pipeline::stages::load::{LoadError, LoadedScene, load_scene};
use clangor_sim::decompose::{DecomposeSettings, convex_parts};

/// A flat ring, whose hull is no good.
fn write_ring(folder: &Path) {
    let TriMesh { vertices, triangles } = Shape::parse("torus:0.03x0.01@0.006").unwrap().mesh();
    let mut text = String::new();
    for v in vertices {
        // Off the centre, so that the parts have to follow the centre of mass.
        writeln!(text, "v {} {} {}", v.x + 0.3, 0.1 * v.y, v.z).unwrap();
    }
    for t in triangles {
        writeln!(text, "f {} {} {}", t[0] + 1, t[1] + 1, t[2] + 1).unwrap();
    }
    std::fs::write(folder.join("ring.obj"), text).unwrap();
}

const SCENE: &str = "version = 1
[[body]]
mesh = \"ring.obj\"
material = \"steel\"
scale = 0.5
[[body]]
mesh = \"ring.obj\"
material = \"steel\"
scale = 0.5
collision_error = 0.3
position = [1, 0, 0]
[[listener]]
position = [0.3, 0.4, 0.2]
";

fn load(folder: &Path) -> LoadedScene {
    std::fs::write(folder.join("rings.toml"), SCENE).unwrap();
    load_scene(&folder.join("rings.toml"), &|_| ()).unwrap()
}

fn surface(loaded: &LoadedScene, body: usize) -> &MeshSurface {
    let Surface::Mesh(surface) = &*loaded.world.bodies[body].surface else { panic!("a mesh") };
    surface
}

#[test]
fn property_parts_are_found_once_and_only_on_demand() {
    let folder = tempfile::tempdir().unwrap();
    write_ring(folder.path());
    let cache = ModelCache::new(folder.path().join("cache"));
    let mut first = load(folder.path());
    assert!((0..2).all(|body| surface(&first, body).parts.is_empty()));
    assert!(!cache.folder().exists());

    find_collision_parts(&mut first, Some(&cache)).unwrap();
    let from_cache = |loaded: &LoadedScene| -> Vec<bool> {
        loaded.collisions.obtained.iter().map(|found| found.cached).collect()
    };
    assert_eq!(from_cache(&first), [false, false]);
    let mut second = load(folder.path());
    find_collision_parts(&mut second, Some(&cache)).unwrap();
    assert_eq!(from_cache(&second), [true, true]);
    assert!((0..2).all(|body| surface(&first, body) == surface(&second, body)));

    // What the file gave before parts were put off, bit by bit.
    let mesh = read_mesh(&folder.path().join("ring.obj")).unwrap();
    let mesh = mesh.weld(1e-9 * mesh.diagonal());
    let parts = convex_parts(&mesh, DecomposeSettings::default()).unwrap().parts;
    let whole = MeshSurface::try_new(mesh, parts).unwrap().0.scaled(0.5);
    assert_eq!(*surface(&first, 0), whole);

    // The larger error gives fewer parts; the outer radius of the ring is 2 cm.
    let (usual, coarse) = (&first.collisions.obtained[0], &first.collisions.obtained[1]);
    assert!(coarse.parts < usual.parts, "{} and {}", coarse.parts, usual.parts);
    assert!(coarse.surface_error <= 0.3 * 0.02 && usual.surface_error < coarse.surface_error);
    assert!(first.collisions.remarks.is_empty() && first.collisions.warnings.len() == 1);
}

#[test]
fn property_a_damaged_entry_is_replaced_and_said() {
    let folder = tempfile::tempdir().unwrap();
    write_ring(folder.path());
    let cache = ModelCache::new(folder.path().join("cache"));
    let mut first = load(folder.path());
    find_collision_parts(&mut first, Some(&cache)).unwrap();
    for entry in std::fs::read_dir(cache.folder()).unwrap() {
        let path = entry.unwrap().path();
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() - 9]).unwrap();
    }
    let mut second = load(folder.path());
    find_collision_parts(&mut second, Some(&cache)).unwrap();
    assert!(second.collisions.obtained.iter().all(|found| !found.cached));
    assert_eq!(second.collisions.remarks.len(), 2);
    assert!(second.collisions.remarks.iter().all(|remark| remark.contains("is not valid")));
    assert_eq!(surface(&first, 0), surface(&second, 0));
}

#[test]
fn property_an_error_that_cannot_be_reached_is_said_and_a_shape_refuses_one() {
    let folder = tempfile::tempdir().unwrap();
    write_ring(folder.path());
    let text = |geometry: &str| {
        format!("version = 1\n[[body]]\n{geometry}\nmaterial = \"steel\"\ncollision_error = 0.0001\n")
    };
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text("shape = \"sphere:0.01\"")).unwrap();
    let refused = load_scene(&path, &|_| ()).unwrap_err();
    assert!(matches!(refused, LoadError::Scene { .. }));
    assert!(refused.to_string().contains("`shape`, whose convex parts are known"), "{refused}");

    std::fs::write(&path, text("mesh = \"ring.obj\"")).unwrap();
    let mut loaded = load_scene(&path, &|_| ()).unwrap();
    find_collision_parts(&mut loaded, None).unwrap();
    let warning = loaded.collisions.warnings[0].to_string();
    assert!(warning.contains("of `collision_error`") && warning.contains("convex parts"), "{warning}");
    assert!(warning.contains("these are the finest parts"), "{warning}");
    let parts = Arc::clone(&loaded.world.bodies[0].surface);
    find_collision_parts(&mut loaded, None).unwrap();
    assert!(Arc::ptr_eq(&parts, &loaded.world.bodies[0].surface));
}
