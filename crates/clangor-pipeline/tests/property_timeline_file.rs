//! Timelines on disk: what is written comes back, what is damaged is refused by name, what is unfinished
//! leaves nothing.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clangor_core::body::link::LoadCurve;
use clangor_core::body::{
    Body, BodyId, Guide, JointKind, Life, Link, LinkEnd, MeshSurface, Motion, Surface, World,
};
use clangor_core::geometry::principal_curvature::Curvature;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::material::{Damping, Material};
use clangor_core::medium::Medium;
use clangor_core::pose::{Keyframe, Pose, Track};
use clangor_core::timeline::{ContactKind, ContactRow, FractureRow, PoseRow, Timeline, TimelineSink};
use clangor_pipeline::formats::timeline_file::{
    Origin, RowProblem, TimelineError, TimelineHeader, TimelineReader, TimelineWriter,
};
use glam::{DMat3, DQuat, DVec3};
use proptest::prelude::*;
use tempfile::TempDir;

fn material(damping: Damping) -> Material {
    Material {
        name: "steel".into(),
        density: 7850.0,
        youngs_modulus: 200e9,
        poisson_ratio: 0.29,
        restitution: 0.1 + 0.2,
        restitution_speed: None,
        rigid_restitution: Some(0.25),
        yield_strength: None,
        friction: 0.3,
        rolling_loss: 5e-5,
        damping,
        tensile_strength: None,
        fracture_energy: Some(1.0 / 3.0),
        source: "a \"book\"\n(1999)".into(),
    }
}

fn tetrahedron() -> MeshSurface {
    let vertices = vec![DVec3::X * 0.1, DVec3::Y / 3.0, DVec3::Z, DVec3::splat(-1e-3)];
    let mesh = TriMesh { vertices, triangles: vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]] };
    let curvature = |i: u32| Curvature {
        principal: [f64::from(i) / 3.0, -1.0 / 7.0],
        direction: DVec3::new(0.1, f64::from(i), -0.3).normalize(),
    };
    MeshSurface::restored(mesh, vec![0.1, -2.0, 1.0 / 7.0, 4.0], 0.1 + 0.7)
        .with_curvature((0..4).map(curvature).collect())
}

fn header() -> TimelineHeader {
    let body = |name: &str, surface: &Arc<Surface>, motion| Body {
        name: name.into(),
        material: material(Damping::T60(0.3)),
        surface: Arc::clone(surface),
        mass: 0.1,
        inertia: DMat3::from_cols_array(&[1.0, 0.2, 0.3, 0.2, 2.0, 0.6, 0.3, 0.6, 3.0]) * 1e-7,
        pose: Pose { position: DVec3::new(0.1, 0.2, 0.3), orientation: DQuat::from_rotation_y(0.3) },
        velocity: DVec3::new(1e-300, -0.0, 5e-324),
        angular_velocity: DVec3::X * std::f64::consts::PI,
        motion,
        edge_radius: 2e-4,
        supports: Vec::new(),
        life: Life::LASTING,
    };
    let key = |time, x| Keyframe { time, pose: Pose::at(DVec3::X * x) };
    let track = Track::try_new(vec![key(-0.1, 0.0), key(0.3, 1.0)]).unwrap();
    let rock = Arc::new(Surface::Mesh(tetrahedron()));
    let ball = Arc::new(Surface::Sphere { radius: 0.0075 });
    let mut bodies = vec![
        body("rock 1", &rock, Motion::Free),
        body("rock 2", &rock, Motion::Keyframed(track)),
        body("équal", &Arc::new((*rock).clone()), Motion::Fixed),
        body("ball", &ball, Motion::Free),
        body("floor", &Arc::new(Surface::HalfSpace), Motion::Fixed),
    ];
    bodies[1].material = material(Damping::Rayleigh { alpha: 6.0, beta: 1e-7, g: 0.1 });
    bodies[2].material = material(Damping::Modes {
        t60: vec![[440.0, 1.0 / 3.0], [5e3, 0.1]],
        otherwise: Box::new(Damping::T60Table(vec![[100.0, 1.5]])),
    });
    bodies[3].material = material(Damping::LossFactorTable(vec![[100.0, 1e-4], [2e3, 0.1]]));
    bodies[4].mass = f64::INFINITY;
    bodies[4].inertia = DMat3::from_diagonal(DVec3::INFINITY);
    let spring = |to| Link::Spring {
        body: BodyId(0),
        at: DVec3::ZERO,
        to,
        rest_length: 0.1,
        stiffness: 3.3,
        damping: 0.0,
    };
    let joint = |to, kind| Link::Joint { body: BodyId(0), at: DVec3::ONE, to, kind, collide: true };
    let links = vec![
        Link::Hang { body: BodyId(3), anchor: DVec3::Y },
        spring(LinkEnd::Point(DVec3::ONE)),
        spring(LinkEnd::centre(BodyId(3))),
        joint(LinkEnd::Point(DVec3::NEG_Y), JointKind::Ball { damping: 0.5 }),
        joint(LinkEnd::centre(BodyId(1)), JointKind::Hinge { axis: DVec3::Z, damping: 0.0 }),
        joint(LinkEnd::Body { body: BodyId(1), at: DVec3::X }, JointKind::Rod { length: 0.25 }),
        joint(LinkEnd::Point(DVec3::ZERO), JointKind::Rope { length: 2.0 }),
        Link::Load {
            body: BodyId(0),
            at: DVec3::X,
            force: LoadCurve::try_new(vec![(0.0, DVec3::X), (0.25, DVec3::Y)]).unwrap(),
            torque: LoadCurve::default(),
        },
    ];
    TimelineHeader {
        world: World { bodies, links, gravity: DVec3::new(0.0, -9.81, 0.0) },
        medium: Medium { density: 1.2, sound_speed: 340.1 },
        origin: Origin {
            solver: "rigid".into(),
            time_step: 1e-4,
            duration: 2.0,
            v_min: 0.05,
            pose_rate: 1000.0,
            raw_log: true,
            sleep: false,
            seed: u64::MAX,
            impact_modes: vec![(BodyId(0), "0123456789abcdef".into())],
        },
        scene: Some("version = 1\n".into()),
    }
}

/// A vector that 32 bits hold exactly.
fn vector() -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(prop::num::f32::NORMAL | prop::num::f32::ZERO | prop::num::f32::SUBNORMAL)
        .prop_map(|v| DVec3::from(v.map(f64::from)))
}

fn scalar() -> impl Strategy<Value = f64> {
    prop::num::f32::NORMAL.prop_map(f64::from)
}

fn contact() -> impl Strategy<Value = ContactRow> {
    let bodies = (0u32..5, prop_oneof![0u32..5, Just(u32::MAX)]);
    let kind = (0u8..5).prop_map(|code| ContactKind::from_code(code).unwrap());
    let axis =
        prop_oneof![Just(DVec3::X), Just(-DVec3::Y), Just(DVec3::new(0.6f32.into(), 0.0, 0.8f32.into()))];
    (
        (0.0..1e-4),
        bodies,
        kind,
        axis,
        scalar(),
        prop::array::uniform4(vector()),
        scalar(),
        prop_oneof![Just(0), any::<u64>()],
    )
        .prop_map(
            |(
                time,
                (a, b),
                kind,
                normal,
                impulse_n,
                [point, impulse_t, couple, velocity],
                depth,
                impact_id,
            )| {
                ContactRow {
                    time,
                    body_a: BodyId(a),
                    body_b: BodyId(b),
                    kind,
                    point,
                    normal,
                    impulse_n,
                    impulse_t,
                    couple,
                    velocity,
                    depth,
                    impact_id,
                }
            },
        )
}

fn pose() -> impl Strategy<Value = PoseRow> {
    ((0.0..1e-4), 0u32..5, prop::array::uniform3(vector()), 0.0..6.0f64).prop_map(
        |(time, body, [p, v, w], angle)| {
            let q = DQuat::from_rotation_z(angle).to_array().map(|x| f64::from(x as f32));
            PoseRow {
                time,
                body: BodyId(body),
                position: p,
                orientation: DQuat::from_array(q),
                velocity: v,
                angular_velocity: w,
            }
        },
    )
}

fn write(
    path: &Path,
    header: &TimelineHeader,
    timeline: &Timeline,
) -> Result<(), Box<dyn std::error::Error>> {
    let mut writer = TimelineWriter::create(path, header, true)?;
    let mut births = &timeline.births[..];
    for row in &timeline.fractures {
        let (children, later) = births.split_at(row.children as usize);
        // As they are born, nobody knows when they will die.
        let children: Vec<Body> = children.iter().map(|b| Body { life: born(b.life), ..b.clone() }).collect();
        writer.fracture(row, &children)?;
        births = later;
    }
    for row in &timeline.contacts {
        writer.contact(row)?;
    }
    for row in &timeline.poses {
        writer.pose(row)?;
    }
    let summary = writer.finish()?;
    assert_eq!(summary.contacts, timeline.contacts.len() as u64);
    assert_eq!(summary.poses, timeline.poses.len() as u64);
    assert_eq!(summary.fractures, timeline.fractures.len() as u64);
    assert_eq!(summary.births, timeline.births.len() as u64);
    Ok(())
}

fn born(life: Life) -> Life {
    Life { death: f64::INFINITY, ..life }
}

/// The example, in which the first rock breaks at 0.3 s into three, and the second of these at 0.4 s into
/// two.
fn broken() -> (TempDir, PathBuf, Timeline) {
    let (folder, path, _) = example();
    let start = header().world.bodies;
    let mut timeline = Timeline::default();
    for (parent, first, count, time) in [(0, 5, 3, 0.1 + 0.2), (6, 8, 2, 0.4)] {
        let row = FractureRow {
            time,
            parent: BodyId(parent),
            first_child: BodyId(first),
            children: count,
            impact_energy: 2.0 / 3.0,
            strain_energy: 1.0 / 3.0,
            fracture_energy: 0.1,
            kinetic_energy_gain: 1.0 / 3.0 - 0.1,
            crack_area: 1e-5 / 7.0,
            duration: 1e-4 / 3.0,
            seed: u64::MAX - 1,
        };
        let piece = |k: u32| {
            let surface = tetrahedron().scaled(1.0 + f64::from(first + k));
            Body {
                name: format!("piece {}", first + k),
                surface: Arc::new(Surface::Mesh(surface)),
                life: Life::of_piece(BodyId(parent), time),
                ..start[3].clone()
            }
        };
        timeline.fracture(&row, &(0..count).map(piece).collect::<Vec<_>>()).unwrap();
    }
    timeline.contacts = vec![
        row(0.1),
        ContactRow { body_a: BodyId(6), body_b: BodyId(7), kind: ContactKind::Fracture, ..row(0.1 + 0.2) },
        ContactRow { body_a: BodyId(9), ..row(0.5) },
    ];
    write(&path, &header(), &timeline).unwrap();
    (folder, path, timeline)
}

fn row(time: f64) -> ContactRow {
    ContactRow {
        time,
        body_a: BodyId(0),
        body_b: BodyId::WORLD,
        kind: ContactKind::Contact,
        point: DVec3::ONE,
        normal: DVec3::Y,
        impulse_n: 1.0,
        impulse_t: DVec3::ZERO,
        couple: DVec3::ZERO,
        velocity: DVec3::ZERO,
        depth: 0.0,
        impact_id: 0,
    }
}

/// A finished timeline of a few thousand rows.
fn example() -> (TempDir, PathBuf, Timeline) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.timeline");
    let contacts =
        (0..3000).map(|i| ContactRow { depth: f64::from(i), ..row(f64::from(i / 7) * 1e-4) }).collect();
    let poses = (0..50)
        .map(|i| PoseRow {
            time: f64::from(i) * 1e-3,
            body: BodyId(1),
            position: DVec3::X * f64::from(i),
            orientation: DQuat::IDENTITY,
            velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
        })
        .collect();
    let timeline = Timeline { contacts, poses, ..Timeline::default() };
    write(&path, &header(), &timeline).unwrap();
    (folder, path, timeline)
}

fn recorded(contacts: Vec<ContactRow>, poses: Vec<PoseRow>) -> Timeline {
    Timeline { contacts, poses, ..Timeline::default() }
}

/// Reads everything there is.
fn read(path: &Path) -> Result<Timeline, TimelineError> {
    TimelineReader::open(path)?.read_all()
}

/// Rows of lasting contacts are stored to half the steps that docs/format/timeline.md lists, and to 32 bits.
fn check_rounded(read: &ContactRow, written: &ContactRow) -> Result<(), TestCaseError> {
    let impulse = written.impulse().length();
    let near = |a: DVec3, b: DVec3, step: f64| {
        (a - b).abs().max_element() <= 0.5 * step + 6e-8 * b.abs().max_element()
    };
    prop_assert!(near(read.point, written.point, 2f64.powi(-21)));
    prop_assert!(near(read.normal, written.normal, 2f64.powi(-18)));
    prop_assert!(near(read.velocity, written.velocity, 2f64.powi(-18)));
    prop_assert!(near(read.impulse(), written.impulse(), 3.0 * impulse * 2f64.powi(-14)));
    prop_assert!(near(read.couple, written.couple, impulse * 2f64.powi(-21)));
    prop_assert!(near(DVec3::X * read.depth, DVec3::X * written.depth, 2f64.powi(-27)));
    let exact = |r: &ContactRow| (r.time.to_bits(), r.body_a, r.body_b, r.kind, r.impact_id);
    prop_assert_eq!(exact(read), exact(written));
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn rows_come_back_bit_exact(
        contacts in prop::collection::vec(contact(), 0..2500),
        poses in prop::collection::vec(pose(), 0..100),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.timeline");
        write(&path, &header(), &recorded(contacts.clone(), poses.clone())).unwrap();
        let reader = TimelineReader::open(&path).unwrap();
        let back = reader.contacts().unwrap().collect::<Result<Vec<_>, _>>().unwrap();
        prop_assert_eq!(back.len(), contacts.len());
        for (read, written) in back.iter().zip(&contacts) {
            if written.kind == ContactKind::Contact && written.impact_id == 0 {
                check_rounded(read, written)?;
            } else {
                prop_assert_eq!(read, written);
            }
        }
        prop_assert_eq!(reader.poses().unwrap().collect::<Result<Vec<_>, _>>().unwrap(), poses);
        prop_assert!(read(&path).unwrap().contacts.is_sorted_by_key(|r| r.time));
    }
}

#[test]
fn world_comes_back_bit_exact() {
    let (_folder, path, timeline) = example();
    let reader = TimelineReader::open(&path).unwrap();
    assert_eq!(reader.header(), &header());
    assert_eq!(reader.program(), concat!("clangor ", env!("CARGO_PKG_VERSION")));
    assert_eq!(reader.rows().contacts, 3000);
    assert_eq!(read(&path).unwrap(), timeline);
    // Equal surfaces are stored once, and shared by the bodies that are read.
    assert_eq!(fs::read_dir(path.join("meshes")).unwrap().count(), 1);
    let bodies = &reader.header().world.bodies;
    assert!(Arc::ptr_eq(&bodies[0].surface, &bodies[2].surface));
    // Minus zero and the smallest number are themselves.
    assert!(bodies[0].velocity.y.is_sign_negative() && bodies[0].velocity.z > 0.0);
}

#[test]
fn a_led_body_comes_back() {
    let (folder, mut header) = (tempfile::tempdir().unwrap(), header());
    let Motion::Keyframed(track) = header.world.bodies[1].motion.clone() else { panic!("no keyframes") };
    header.world.bodies[1].motion = Motion::Guided(Guide { track, press: Some(1.5), let_go: None });
    let path = folder.path().join("run.timeline");
    write(&path, &header, &Timeline::default()).unwrap();
    assert_eq!(TimelineReader::open(&path).unwrap().header().world.bodies[1], header.world.bodies[1]);
}

#[test]
fn births_come_back_bit_exact() {
    let (_folder, path, timeline) = broken();
    let reader = TimelineReader::open(&path).unwrap();
    assert_eq!(reader.read_all().unwrap(), timeline);
    assert_eq!(reader.bodies(), timeline.all_bodies(&header().world.bodies));
    let deaths: Vec<f64> = reader.bodies().iter().map(|body| body.life.death).collect();
    assert_eq!((deaths[0], deaths[6], deaths[5]), (0.1 + 0.2, 0.4, f64::INFINITY));
    // Of the beginning it differs from what was written by the death that came later.
    let mut start = header();
    start.world.bodies[0].life.death = 0.1 + 0.2;
    assert_eq!(reader.header(), &start);
    assert_eq!(fs::read_dir(path.join("meshes")).unwrap().count(), 6);
    // A timeline in which nothing breaks has no such table.
    let (_folder, whole, _) = example();
    assert!(path.join("fractures.parquet").exists() && !whole.join("fractures.parquet").exists());
}

#[test]
fn births_that_contradict_themselves_are_refused() {
    let (_folder, path, timeline) = broken();
    let file = path.join("timeline.json");
    let good = fs::read_to_string(&file).unwrap();
    let cases = [
        (
            "\"birth\": 0.30000000000000004",
            "\"birth\": 0.25",
            "fractures.parquet, row 0: pieces 5 to 5 + 3 - 1",
        ),
        ("\"birth\": 0.4", "\"birth\": -0.4", "bodies[8].life.birth is -0.4"),
        ("\"death\": 0.4", "\"death\": 0.35", "fractures.parquet, row 1: pieces 8 to 8 + 2 - 1"),
        ("\"death\": 0.4", "\"death\": 0.2", "bodies[6].life.death is 0.2, before the birth at 0.3"),
        ("\"parent\": 6", "\"parent\": 8", "bodies[8].life.parent is 8, which does not come before it"),
        ("\"parent\": 6", "\"parent\": null", "bodies[8].life has no parent, but comes after"),
        ("\"rows\": 2", "\"rows\": 0", "bodies[5].life has a parent, but fractures.parquet does not know"),
    ];
    for (from, to, expected) in cases {
        assert!(good.contains(from), "{from}");
        fs::write(&file, good.replacen(from, to, 1)).unwrap();
        let message = read(&path).unwrap_err().to_string();
        assert!(message.contains(expected), "{from} -> {to}: {message}");
    }
    fs::write(&file, &good).unwrap();
    fs::remove_file(path.join("fractures.parquet")).unwrap();
    assert!(matches!(read(&path), Err(TimelineError::Missing { .. })));

    // What is written is checked as well.
    let (dead, unborn) = (row(0.31), ContactRow { body_a: BodyId(8), ..row(0.31) });
    for (bad, expected) in [
        (dead, "body_a is 0, which lives from 0 s to 0.30000000000000004 s, but the row is of 0.31 s"),
        (unborn, "body_a is 8, which lives from 0.4 s to inf s"),
    ] {
        let wrong = Timeline { contacts: vec![bad], ..timeline.clone() };
        let message = write(&path, &header(), &wrong).unwrap_err().to_string();
        assert!(message.contains("contacts.parquet, row 0: ") && message.contains(expected), "{message}");
    }
    let mut wrong = timeline.clone();
    wrong.fractures[0].first_child = BodyId(6);
    let message = write(&path, &header(), &wrong).unwrap_err().to_string();
    assert!(message.contains("fractures.parquet, row 0: pieces 6 to"), "{message}");
    let mut wrong = timeline;
    wrong.births[1].velocity.x = f64::NAN;
    let message = write(&path, &header(), &wrong).unwrap_err().to_string();
    assert!(message.contains("timeline.json") && message.contains("a piece"), "{message}");
}

#[test]
fn unfinished_timeline_leaves_what_was_there() {
    let (folder, path, timeline) = example();
    let mut writer = TimelineWriter::create(&path, &header(), true).unwrap();
    writer.contact(&row(0.0)).unwrap();
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    drop(writer);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    assert_eq!(read(&path).unwrap(), timeline);
    let again = TimelineWriter::create(&path, &header(), false).err().unwrap();
    assert!(again.to_string().contains("--force"), "{again}");
    write(&path, &header(), &Timeline::default()).unwrap();
    assert_eq!(read(&path).unwrap(), Timeline::default());
}

#[test]
fn impossible_rows_are_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.timeline");
    let good = row(1.0);
    let wrong = [
        (ContactRow { body_a: BodyId(5), ..good }, "body_a is 5, but there are 5 bodies"),
        (ContactRow { body_a: BodyId::WORLD, ..good }, "body_a is 4294967295"),
        (ContactRow { normal: DVec3::Y * 1.1, ..good }, "normal has length 1.1"),
        (ContactRow { normal: DVec3::NAN, ..good }, "normal has length NaN"),
        (ContactRow { impulse_n: f64::NAN, ..good }, "impulse_n is NaN"),
        (ContactRow { depth: 1e39, ..good }, "depth is 1"),
        (ContactRow { time: f64::INFINITY, ..good }, "t is inf"),
        (ContactRow { time: 0.999, ..good }, "time 0.999 s comes after 1 s"),
    ];
    for (bad, expected) in wrong {
        let error = write(&path, &header(), &recorded(vec![good, bad], vec![])).unwrap_err();
        let message = error.to_string();
        assert!(message.contains("contacts.parquet, row 1: ") && message.contains(expected), "{message}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
    // Within the window of a merged impact order is free, and a link needs no normal.
    let earlier = ContactRow { time: 0.9995, ..good };
    let link = ContactRow { kind: ContactKind::Constraint, normal: DVec3::ZERO, ..good };
    write(&path, &header(), &recorded(vec![good, earlier, link], vec![])).unwrap();
    let mut bad_header = header();
    bad_header.world.gravity.y = f64::NAN;
    assert!(matches!(TimelineWriter::create(&path, &bad_header, true), Err(TimelineError::Json { .. })));
}

/// Lets tables be changed, as one who edits them does.
fn forget_hashes(path: &Path) {
    let file = path.join("timeline.json");
    let text = fs::read_to_string(&file).unwrap();
    let mut description: serde_json::Value = serde_json::from_str(&text).unwrap();
    for table in ["contacts", "poses"] {
        description[table].as_object_mut().unwrap().remove("hash").unwrap();
    }
    fs::write(&file, description.to_string()).unwrap();
}

#[test]
fn changed_tables_are_refused() {
    let (_folder, path, _) = example();
    let file = path.join("contacts.parquet");
    let mut bytes = fs::read(&file).unwrap();
    // A value, not the structure: the decoder alone would not notice.
    bytes[200] ^= 1;
    fs::write(&file, bytes).unwrap();
    let message = read(&path).unwrap_err().to_string();
    assert!(message.contains("contacts.parquet has changed since it was written"), "{message}");
}

#[test]
fn damaged_tables_are_refused_by_name() {
    let (_folder, path, _) = example();
    forget_hashes(&path);
    for table in ["contacts.parquet", "poses.parquet"] {
        let file = path.join(table);
        let good = fs::read(&file).unwrap();
        for length in [0, 3, 100, good.len() / 2, good.len() - 1] {
            fs::write(&file, &good[..length]).unwrap();
            let message = read(&path).unwrap_err().to_string();
            assert!(message.contains(table) && message.contains("again"), "{message}");
        }
        fs::remove_file(&file).unwrap();
        assert!(matches!(read(&path), Err(TimelineError::Missing { .. })));
        fs::write(&file, &good).unwrap();
        read(&path).unwrap();
    }
    // A table of another run, and a table of other columns.
    let (_other_folder, other, _) = example();
    write(&other, &header(), &recorded(vec![row(0.0)], vec![])).unwrap();
    fs::copy(other.join("contacts.parquet"), path.join("contacts.parquet")).unwrap();
    assert!(matches!(read(&path), Err(TimelineError::RowCount { promised: 3000, found: 1, .. })));
    fs::copy(other.join("poses.parquet"), path.join("contacts.parquet")).unwrap();
    assert!(matches!(read(&path), Err(TimelineError::MissingColumn { column: "body_a", .. })));
}

/// The beginning of the hash of a mesh, as the file is indented.
const MESH_HASH: &str = "\"mesh\": {\n          \"hash\": \"";

#[test]
fn tampered_description_is_refused_by_field() {
    let (_folder, path, _) = example();
    let file = path.join("timeline.json");
    let good = fs::read_to_string(&file).unwrap();
    let cases = [
        ("\"version\": 2", "\"version\": 3", "has format version 3; this program reads versions 1 to 2"),
        ("clangor timeline", "other timeline", "format is \"other timeline\""),
        ("\"mass\": 0.1", "\"mass\": -0.1", "bodies[0].mass is -0.1, not positive"),
        ("\"mass\": 0.1", "\"mass\": null", "line 53, column 18: expected a number or \"infinity\""),
        ("\"mass\": 0.1", "\"weight\": 0.1", "unknown field `weight`"),
        ("\"poisson_ratio\": 0.29", "\"poisson_ratio\": 0.6", "material.poisson_ratio is 0.6"),
        ("\"rock 2\"", "\"rock 1\"", "bodies[1].name \"rock 1\" is not unique"),
        ("\"time\": 0.3", "\"time\": -0.3", "bodies[1].motion has no keys, or times that do not increase"),
        ("\"rows\": 3000", "\"rows\": 3001", "contacts.parquet has 3000 rows"),
        ("\"radius\": 0.0075", "\"radius\": 0", "radius is 0, not positive"),
        ("\"sound_speed\": 340.1", "\"sound_speed\": 1e999", "number out of range"),
        ("\"hash\": \"", "\"hash\": \"0", "contacts.parquet has changed since it was written"),
        (MESH_HASH, "\"mesh\": {\n          \"hash\": \"../", "is not 32 hexadecimal digits"),
        ("\"body\": 3", "\"body\": 9", "links[0].body is 9, but there are 5 bodies"),
        ("\"body\": 0", "\"body\": 9", "origin.impact_modes.body is 9, but there are 5 bodies"),
    ];
    for (from, to, expected) in cases {
        assert!(good.contains(from), "{from}");
        fs::write(&file, good.replacen(from, to, 1)).unwrap();
        let message = read(&path).unwrap_err().to_string();
        assert!(message.contains(expected), "{from} -> {to}: {message}");
    }
    fs::write(&file, &good[..good.len() - 2]).unwrap();
    assert!(matches!(read(&path), Err(TimelineError::Json { .. })));
    // Fewer bodies than the rows name.
    let bodies = good.find("\"name\": \"rock 2\"").unwrap();
    let start = good[..bodies].rfind('{').unwrap();
    let links = good.find("\"links\"").unwrap();
    let cut = format!("{} ], {}", good[..start].trim_end().trim_end_matches(','), &good[links..]);
    let cut = cut.replace("\"body\": 3", "\"body\": 0").replace("\"body\": 1", "\"body\": 0");
    fs::write(&file, cut).unwrap();
    let error = read(&path).unwrap_err();
    let expected = RowProblem::Body { column: "body", body: 1, bodies: 1 };
    assert!(matches!(&error, TimelineError::Row { row: 0, problem, .. } if *problem == expected), "{error}");
}

/// Gives the only surface of a timeline other vertex properties: the names, and how many doubles after the
/// position each vertex keeps.
fn with_vertex_properties(path: &Path, names: &[&str]) {
    let file = fs::read_dir(path.join("meshes")).unwrap().next().unwrap().unwrap().path();
    let bytes = fs::read(&file).unwrap();
    let end = b"end_header\n";
    let start = bytes.windows(end.len()).position(|window| window == end).unwrap() + end.len();
    let header = String::from_utf8(bytes[..start].to_vec()).unwrap();
    let drop = |line: &&str| {
        let name = line.strip_prefix("property double ").unwrap_or_default();
        !(name.starts_with("curvature") || name.starts_with("direction")) || names.contains(&name)
    };
    let header: Vec<&str> = header.lines().filter(drop).collect();
    let mut changed = (header.join("\n") + "\n").into_bytes();
    // Four vertices of nine doubles; the properties in question come last.
    for vertex in bytes[start..start + 4 * 72].chunks(72) {
        changed.extend_from_slice(&vertex[..32 + 8 * names.len()]);
    }
    changed.extend_from_slice(&bytes[start + 4 * 72..]);
    let former = file.file_stem().unwrap().to_str().unwrap().to_owned();
    let hash = format!("{:032x}", twox_hash::XxHash3_128::oneshot(&changed));
    fs::write(path.join("meshes").join(format!("{hash}.ply")), changed).unwrap();
    let description = path.join("timeline.json");
    let text = fs::read_to_string(&description).unwrap();
    assert!(text.contains(&former));
    fs::write(&description, text.replace(&former, &hash)).unwrap();
}

#[test]
fn surfaces_without_principal_curvatures_have_the_mean_in_all_directions() {
    let (_folder, path, _) = example();
    with_vertex_properties(&path, &[]);
    let reader = TimelineReader::open(&path).unwrap();
    let Surface::Mesh(surface) = &*reader.header().world.bodies[0].surface else { panic!("a mesh") };
    assert_eq!(surface.mesh, tetrahedron().mesh);
    assert_eq!(surface.mean_curvature, tetrahedron().mean_curvature);
    let wanted: Vec<Curvature> = surface.mean_curvature.iter().map(|h| Curvature::isotropic(*h)).collect();
    assert_eq!(surface.curvature, wanted);
    // Some of the properties are a mistake.
    let (_folder, path, _) = example();
    with_vertex_properties(&path, &["curvature_1", "curvature_2", "direction_x"]);
    let error = read(&path).unwrap_err();
    assert!(error.to_string().contains("but not all"), "{error}");
}

#[test]
fn damaged_mesh_is_refused_by_hash() {
    let (_folder, path, _) = example();
    let mesh = fs::read_dir(path.join("meshes")).unwrap().next().unwrap().unwrap().path();
    let mut bytes = fs::read(&mesh).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(&mesh, bytes).unwrap();
    assert!(matches!(read(&path), Err(TimelineError::Changed { .. })));
    fs::remove_file(&mesh).unwrap();
    assert!(matches!(read(&path), Err(TimelineError::Missing { .. })));
}

#[test]
fn places_that_are_no_timeline_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    assert!(matches!(read(&folder.path().join("none")), Err(TimelineError::Missing { .. })));
    assert!(matches!(read(folder.path()), Err(TimelineError::Missing { .. })));
    let file = folder.path().join("a.timeline");
    fs::write(&file, "no folder").unwrap();
    assert!(read(&file).is_err());
    assert!(TimelineWriter::create(&file, &header(), true).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn damaged_bytes_are_rows_or_an_error(
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
        at_end: bool,
    ) {
        let (path, good) = damage_target();
        let mut bytes = good.clone();
        for (index, byte) in edits {
            // Half of the cases hit the footer, where the structure is.
            let span = if at_end { bytes.len().min(900) } else { bytes.len() };
            let start = bytes.len() - span;
            bytes[start + index.index(span)] = byte;
        }
        fs::write(path.join("contacts.parquet"), bytes).unwrap();
        if let Ok(timeline) = read(path) {
            prop_assert!(timeline.contacts.iter().all(|r| r.time.is_finite() && r.point.is_finite()));
        }
    }
}

/// A timeline to damage, shared by the cases, and the good bytes of its contacts.
fn damage_target() -> &'static (PathBuf, Vec<u8>) {
    static TARGET: std::sync::OnceLock<(TempDir, (PathBuf, Vec<u8>))> = std::sync::OnceLock::new();
    let make = || {
        let (folder, path, _) = example();
        forget_hashes(&path);
        let good = fs::read(path.join("contacts.parquet")).unwrap();
        (folder, (path, good))
    };
    &TARGET.get_or_init(make).1
}

#[test]
fn version_1_is_read() {
    let (_folder, path, timeline) = broken();
    let description = path.join("timeline.json");
    let text = fs::read_to_string(&description).unwrap();
    assert!(text.contains("\"version\": 2"));
    fs::write(&description, text.replace("\"version\": 2", "\"version\": 1")).unwrap();
    assert_eq!(TimelineReader::open(&path).unwrap().fractures(), timeline.fractures);
}
