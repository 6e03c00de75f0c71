//! Timelines on disk: what is written comes back, and what is unfinished leaves nothing.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use clangor_core::body::{BodyId, Guide, Motion, Surface};
use clangor_core::geometry::principal_curvature::Curvature;
use clangor_core::timeline::{ContactKind, ContactRow, PoseRow, Timeline, TimelineSink};
use clangor_pipeline::formats::timeline_file::{TimelineReader, TimelineWriter};
use glam::{DQuat, DVec3};
use proptest::prelude::*;

use crate::timelines::{broken, example, header, read, recorded, row, tetrahedron, write};

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
        prop::option::of((1e-6..1e6f32).prop_map(f64::from)),
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
                effective_mass,
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
                    effective_mass,
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
    let exact =
        |r: &ContactRow| (r.time.to_bits(), r.body_a, r.body_b, r.kind, r.impact_id, r.effective_mass);
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
fn version_1_is_read() {
    let (_folder, path, timeline) = broken();
    let description = path.join("timeline.json");
    let text = fs::read_to_string(&description).unwrap();
    assert!(text.contains("\"version\": 2"));
    fs::write(&description, text.replace("\"version\": 2", "\"version\": 1")).unwrap();
    assert_eq!(TimelineReader::open(&path).unwrap().fractures(), timeline.fractures);
}
