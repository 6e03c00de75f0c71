//! Every shipped scene decodes and instantiates without an error or a warning, and nothing overlaps at its
//! start.

use std::path::{Path, PathBuf};
use std::thread;

use clangor_core::body::{Body, Surface};
use clangor_core::geometry::convex::ConvexPart;
use clangor_core::glam::DVec3;
use clangor_core::scene::instantiate::{Instance, load_shape};
use clangor_core::scene::{Scene, instantiate};

fn scene_files() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|e| e == "toml"));
    files.sort();
    files
}

fn load(file: &Path) -> Instance {
    let name = file.display();
    let scene =
        Scene::from_toml(&std::fs::read_to_string(file).unwrap()).unwrap_or_else(|e| panic!("{name}:\n{e}"));
    let instance = instantiate(&scene, &mut load_shape).unwrap_or_else(|e| panic!("{name}:\n{e}"));
    assert_eq!((scene.warnings, &instance.warnings), (vec![], &vec![]), "{name}");
    instance
}

/// Least height of a body above a plane [m].
fn height(body: &Body, plane: &Body) -> f64 {
    let height = |point: DVec3| plane.pose.body_from_world(body.pose.world_from_body(point)).y;
    match &*body.surface {
        Surface::Sphere { radius } => height(DVec3::ZERO) - radius,
        Surface::HalfSpace | Surface::Plate { .. } => f64::INFINITY,
        Surface::Mesh(mesh) => mesh.mesh.vertices.iter().map(|v| height(*v)).fold(f64::INFINITY, f64::min),
    }
}

/// Least distance of the vertices of one body from the surface of another [m]; of the centres, for spheres.
fn gap(a: &Body, b: &Body) -> f64 {
    let centres = (a.pose.position - b.pose.position).length();
    match (&*a.surface, &*b.surface) {
        (Surface::Sphere { radius: ra }, Surface::Sphere { radius: rb }) => centres - ra - rb,
        (Surface::HalfSpace | Surface::Plate { .. }, _) => height(b, a),
        (_, Surface::HalfSpace | Surface::Plate { .. }) => height(a, b),
        (Surface::Mesh(mesh), _) => {
            let points = mesh.mesh.vertices.iter().map(|v| a.pose.world_from_body(*v));
            points.map(|p| distance(b, p)).fold(f64::INFINITY, f64::min)
        }
        (Surface::Sphere { radius }, _) => distance(b, a.pose.position) - radius,
    }
}

fn distance(body: &Body, point: DVec3) -> f64 {
    let local = body.pose.body_from_world(point);
    match &*body.surface {
        Surface::Sphere { radius } => local.length() - radius,
        Surface::HalfSpace | Surface::Plate { .. } => local.y,
        Surface::Mesh(mesh) => mesh.signed_distance(local),
    }
}

#[test]
fn shipped_scenes_are_sound_and_start_without_overlap() {
    let files = scene_files();
    let names: Vec<String> =
        files.iter().map(|f| f.file_stem().unwrap().to_string_lossy().into_owned()).collect();
    for name in [
        "ball-drop",
        "newtons-cradle",
        "pool-break",
        "dice",
        "coins",
        "key-chain",
        "mug-and-coin",
        "rocks-small",
        "rocks-large",
    ] {
        assert!(names.iter().any(|n| n == name), "{name} is not shipped");
    }
    for file in &files {
        let bodies = &load(file).world.bodies;
        let half = |first: usize| {
            for (i, a) in bodies.iter().enumerate().skip(first).step_by(2) {
                for b in &bodies[..i] {
                    let far = (a.pose.position - b.pose.position).length()
                        > a.surface.bounding_radius() + b.surface.bounding_radius();
                    if far {
                        continue;
                    }
                    let gap = gap(a, b).min(gap(b, a));
                    // Balls that rest on a plane touch it to rounding.
                    let apart = gap > -1e-12;
                    assert!(apart, "{}: {} and {} overlap by {gap} m", file.display(), a.name, b.name);
                }
            }
        };
        thread::scope(|scope| {
            [0, 1].map(|first| scope.spawn(move || half(first))).map(|h| h.join().unwrap())
        });
    }
}

#[test]
fn the_keys_hang_on_the_ring() {
    let file = scene_files().into_iter().find(|f| f.ends_with("key-chain.toml")).unwrap();
    let world = load(&file).world;
    let ring = world.bodies.iter().find(|b| b.name == "ring").unwrap();
    for key in world.bodies.iter().filter(|b| b.name.ends_with("-key")) {
        // The middle of the hole, which is the origin of the key's mesh, is inside the tube of the ring:
        // threaded.
        let Surface::Mesh(surface) = &*key.surface else { panic!("a key is a mesh") };
        let shape = clangor_core::shape::Shape::parse("key").unwrap();
        let centre = shape.surface().unwrap().1.centre_of_mass;
        let hole = key.pose.world_from_body(-centre);
        assert!(distance(ring, hole) < -0.001, "{}", key.name);
        assert!(!surface.contains(-centre));
        // And the tube passes through without touching the convex parts: 2.3 mm of clearance less the
        // sectors' error.
        for part in &surface.parts {
            let ConvexPart::Hull(points) = part else { continue };
            let nearest = points.iter().map(|p| distance(ring, key.pose.world_from_body(*p)));
            assert!(nearest.fold(f64::INFINITY, f64::min) > 0.0015, "{}", key.name);
        }
    }
}
