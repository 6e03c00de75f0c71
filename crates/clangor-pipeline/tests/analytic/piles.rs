//! Stacks, walls and pyramids of boxes that land together, and stacks at rest: the ground gives the momentum
//! of all, and each pair carries what lies on it.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

use crate::imported_motion::{folder, import};
use clangor_core::body::{Body, BodyId, MeshSurface, Surface, World};
use clangor_core::material::presets;
use clangor_core::pose::Pose;
use clangor_core::shape::Shape;
use clangor_core::timeline::ContactKind;
use clangor_pipeline::formats::timeline_file::TimelineReader;
use clangor_pipeline::motion::impacts::find_impacts;
use clangor_pipeline::motion::recording::{Frame, RecordedBody};
use glam::DVec3;

const G: f64 = 9.80665;
const EDGE: f64 = 0.04;
/// Distance of boxes on each other: their surfaces are the same to the last digit.
const RISE: f64 = EDGE;

/// Places of boxes in columns of a height, with a gap \[m\] between them.
fn wall(columns: usize, height: usize, gap: f64) -> Vec<DVec3> {
    let place = |k: usize| DVec3::new((k % columns) as f64 * (EDGE + gap), (k / columns) as f64 * RISE, 0.0);
    (0..columns * height).map(place).collect()
}

/// Places of boxes in rows, each a box shorter than the one below.
fn pyramid(longest: usize) -> Vec<DVec3> {
    let row = |r: usize| {
        let place = move |k: usize| DVec3::new(k as f64 + 0.5 * r as f64, r as f64, 0.0);
        (0..longest - r).map(move |k| place(k) * DVec3::new(EDGE + 1e-4, RISE, EDGE))
    };
    (0..longest).flat_map(row).collect()
}

/// The impacts of boxes that fall from rest and stay where they land at an instant \[s\]: what the ground
/// gives, over the momentum of all, and what each box is given by all that it touches, over its own.
fn landing(places: &[DVec3], instant: f64) -> (f64, Vec<f64>) {
    let mesh = Shape::parse(&format!("box:{EDGE}x{EDGE}x{EDGE}")).unwrap().mesh();
    let (surface, mass) = MeshSurface::try_new(mesh, Vec::new()).unwrap();
    let surface = Arc::new(Surface::Mesh(surface));
    let body =
        |k: usize| Body::solid(format!("box{k}"), presets::WOOD.material(), Arc::clone(&surface), &mass);
    let mut bodies: Vec<Body> = (0..places.len()).map(body).collect();
    bodies.push(Body::plane("floor", presets::GRANITE.material(), DVec3::ZERO, DVec3::Y));
    let recorded = |(k, place): (usize, &DVec3)| {
        let frame = |row: u64| {
            let time = row as f64 / 240.0;
            let height = 0.5 * G * (instant - time).max(0.0) * (instant + time);
            Frame { time, pose: Pose::at(*place + DVec3::Y * (0.5 * EDGE + height)), row }
        };
        RecordedBody { body: BodyId(k as u32), frames: (0..144).map(frame).collect(), group: None }
    };
    let recorded: Vec<RecordedBody> = places.iter().enumerate().map(recorded).collect();
    let due = bodies[0].mass * G * instant;
    let floor = BodyId(places.len() as u32);
    let world = World { bodies, links: Vec::new(), gravity: DVec3::NEG_Y * G };
    let mut given = vec![0.0; places.len() + 1];
    for row in find_impacts(&world, &recorded, 0.05).contacts {
        if row.kind == ContactKind::Impact {
            given[row.body_a.index()] += row.impulse().y / due;
            given[row.body_b.index()] -= row.impulse().y / due;
        }
    }
    let of_ground = -given.swap_remove(floor.index()) / places.len() as f64;
    (of_ground, given)
}

#[test]
fn analytic_boxes_that_land_together_have_their_momentum_from_the_ground() {
    let piles = [1, 2, 5, 10, 11, 12, 20, 100].map(|n| (format!("stack of {n}"), wall(1, n, 0.0)));
    let walls = [(5, 3, 1e-4), (5, 5, 1e-4), (5, 5, 2e-3), (20, 1, 0.0), (10, 10, 1e-4)]
        .map(|(columns, height, gap)| (format!("{columns} x {height}, {gap}"), wall(columns, height, gap)));
    let pyramids = [3, 5, 8].map(|n| (format!("pyramid of {n}"), pyramid(n)));
    // A micrometre between each box and the next.
    let apart = [5, 20, 100].map(|n| {
        let places = wall(1, n, 0.0).into_iter().map(|place| place + DVec3::Y * (1e-6 * place.y / RISE));
        (format!("stack of {n} with gaps"), places.collect())
    });
    let mut wrong = Vec::new();
    for (name, places) in piles.into_iter().chain(walls).chain(pyramids).chain(apart) {
        // On a frame and between two.
        for instant in [0.2, 0.2013] {
            let start = std::time::Instant::now();
            let (given, of_boxes) = landing(&places, instant);
            let worst = of_boxes.iter().map(|of| (of - 1.0).abs()).fold(0.0, f64::max);
            println!("{name}, {instant} s: {given:.6}, worst box {worst:.1e}, {:.2?}", start.elapsed());
            if !((given - 1.0).abs() < 0.01 && worst < 0.05) {
                wrong.push(format!("{name}, {instant} s: {given}, {worst}"));
            }
        }
    }
    // Seen: 0.6 % from the ground, and 4.4 % of a box in the wall of a hundred.
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn analytic_stacks_at_rest_carry_what_lies_on_each() {
    for count in [2, 3, 4, 5, 6, 8, 10, 16, 20] {
        let start = std::time::Instant::now();
        let mut scene = String::from("version = 1\n[render]\nrolling = true\n");
        scene += "[[plane]]\nname = \"floor\"\nmaterial = \"granite\"\n";
        scene += "[[listener]]\nposition = [0.3, 0.4, 0.4]\n";
        let mut rows = String::from("t,body,position_x,position_y,position_z,");
        rows += "orientation_x,orientation_y,orientation_z,orientation_w\n";
        for k in 0..count {
            let y = 0.5 * EDGE + f64::from(k) * RISE;
            write!(scene, "[[body]]\nname = \"box{k}\"\nshape = \"box:{EDGE}x{EDGE}x{EDGE}\"\n").unwrap();
            writeln!(scene, "material = \"wood\"\nposition = [0.0, {y}, 0.0]").unwrap();
            for row in 0..24 {
                writeln!(rows, "{},box{k},0,{y},0,0,0,0,1", f64::from(row) / 240.0).unwrap();
            }
        }
        let folder = folder(&scene, &[("poses.csv", &rows)]);
        import(folder.path(), &["poses.csv"], &[], false).unwrap();
        let reader = TimelineReader::open(&folder.path().join("out.timeline")).unwrap();
        let bodies = reader.header().world.bodies.clone();
        let step = reader.header().origin.time_step;
        let place =
            |id: BodyId| bodies[id.index()].name.strip_prefix("box").map(|k| k.parse::<i32>().unwrap());
        let weight = bodies.iter().find(|body| body.name == "box0").unwrap().mass * G * step;
        // By the lower body of each pair, -1 for the floor, and the step.
        let mut carried: BTreeMap<(i32, u64), f64> = BTreeMap::new();
        for row in reader.read_all().unwrap().contacts {
            assert_eq!(row.kind, ContactKind::Contact);
            let [a, b] = [row.body_a, row.body_b].map(|id| place(id).unwrap_or(-1));
            assert_eq!((a - b).abs(), 1, "{a}, {b}");
            *carried.entry((a.min(b), (row.time / step).round() as u64)).or_default() += row.impulse_n;
        }
        let off = carried
            .iter()
            .map(|((k, _), j)| (j / weight - f64::from(count - 1 - k)).abs() / f64::from(count));
        let off = off.fold(0.0, f64::max);
        println!("{count} boxes: {off:.1e} of the weight of all, {:.2?}", start.elapsed());
        assert_eq!(carried.len(), 22 * count as usize, "each pair in each step");
        // Seen: 3e-5.
        assert!(off < 1e-3, "{count} boxes: {off}");
    }
}
