//! Timelines that carry the forces of their impacts: what is written comes back and sounds alike, what cannot
//! be a force is refused by name.

use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Life, MeshSurface, Motion, Surface, World};
use clangor_core::contact::{ContactSettings, ForceSettings};
use clangor_core::geometry::convex::ConvexPart;
use clangor_core::geometry::hull::convex_hull;
use clangor_core::material::presets;
use clangor_core::medium::Medium;
use clangor_core::pose::Pose;
use clangor_core::scene::render_description::{GroundSound, Parts};
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel, ModalTransfer};
use clangor_core::sound_model::modal::surface::ModalSurface;
use clangor_core::synthesis::{BodyModes, Listener, RenderSettings, SoundModel, SoundSource};
use clangor_core::timeline::{ForceRow, FractureRow, Timeline, TimelineSink};
use clangor_pipeline::formats::timeline_file::{Origin, TimelineHeader, TimelineReader, TimelineWriter};
use clangor_pipeline::formats::wav::{SampleFormat, WavReader};
use clangor_pipeline::stages::render::{
    FullScale, RenderOptions, RenderSummary, Transfers, read_impacts, render, timeline_forces,
};
use clangor_sim::record::RecordSettings;
use clangor_sim::{ContactModel, SimulationSettings, Solver, simulate};
use glam::{DMat3, DQuat, DVec3};
use num_complex::Complex64;
use tempfile::TempDir;

const HALF: DVec3 = DVec3::new(0.05, 0.003, 0.04);
const DURATION: f64 = 0.5;

/// A glass tile with these half edges, at rest at the origin.
fn tile() -> Body {
    let corner = |k: usize| {
        let sign = |bit: usize| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
        DVec3::new(sign(0), sign(1), sign(2)) * HALF
    };
    let corners: Vec<DVec3> = (0..8).map(corner).collect();
    let mesh = convex_hull(&corners).unwrap();
    let (surface, mass) = MeshSurface::try_new(mesh, vec![ConvexPart::Hull(corners)]).unwrap();
    let material = presets::GLASS.material();
    Body::solid("tile", material, Surface::Mesh(surface), &mass).with_edge_radius(1e-4)
}

fn world() -> World {
    let floor = Body {
        name: "floor".into(),
        surface: Arc::new(Surface::HalfSpace),
        mass: f64::INFINITY,
        inertia: DMat3::from_diagonal(DVec3::INFINITY),
        motion: Motion::Fixed,
        ..tile()
    };
    let mut tile = tile();
    tile.pose = Pose { position: DVec3::Y * 0.1, orientation: DQuat::from_rotation_z(0.5) };
    World { bodies: vec![floor, tile], links: Vec::new(), gravity: DVec3::Y * -9.81 }
}

fn header() -> TimelineHeader {
    let settings = settings();
    let origin = Origin::of_simulation(&settings, Solver::Rigid, 1);
    TimelineHeader { world: world(), medium: Medium::AIR, origin, scene: None }
}

fn settings() -> SimulationSettings {
    SimulationSettings {
        solver: Solver::Rigid,
        contact: ContactModel::default(),
        duration: DURATION,
        time_step: 2e-4,
        record: RecordSettings::default(),
        sleep: true,
    }
}

/// The tile falls on the floor.
fn recorded() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.timeline");
    let mut writer = TimelineWriter::create(&path, &header(), false).unwrap();
    simulate(&world(), &settings(), &mut writer, &mut |_| ControlFlow::Continue(())).unwrap();
    writer.finish().unwrap();
    (folder, path)
}

fn options() -> RenderOptions {
    RenderOptions {
        listeners: vec![Listener::fixed("microphone", DVec3::new(0.5, 0.6, 0.4))],
        contact: ContactSettings::default(),
        synthesis: RenderSettings::default(),
        parts: Parts { acceleration: true, modal: true, ground: false },
        transfers: Transfers::Baked,
        rolling: None,
        ground: GroundSound::None,
        inherit_vibration: false,
        to: DURATION,
        format: SampleFormat::Float32,
        full_scale: FullScale::Pascals(1.0),
        compressor: None,
        stems: false,
        note: String::new(),
    }
}

/// Displacement across a face at a place, in half edges.
type Bending = fn(DVec3) -> f64;

/// The floor, and a tile with three modes that bend it across its faces.
fn models(bodies: &[Body]) -> Vec<SoundModel> {
    let mut models: Vec<SoundModel> =
        SoundSource::spheres(bodies).into_iter().map(SoundModel::without_modes).collect();
    let (mut nodes, mut triangles) = (Vec::new(), Vec::new());
    for side in [-1.0, 1.0] {
        for corners in [[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0]], [[-1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]] {
            let first = nodes.len() as u32;
            let corner: [DVec3; 3] = corners.map(|[x, z]: [f64; 2]| HALF * DVec3::new(x, side, z));
            nodes.extend(corner);
            nodes.extend([(0, 1), (1, 2), (2, 0)].map(|(a, b)| 0.5 * (corner[a] + corner[b])));
            triangles.push(std::array::from_fn(|n| first + n as u32));
        }
    }
    let scale = 2.0 / bodies[1].mass.sqrt();
    let mode = |(frequency, shape): (f64, Bending)| ModalMode {
        frequency,
        mesh_error: 0.0,
        support_damping: 0.0,
        shape: nodes.iter().map(|x| DVec3::Y * scale * shape(*x / HALF)).collect(),
        transfer: Some(ModalTransfer { order: 0, coefficients: vec![Complex64::ONE] }),
    };
    let shapes: [(f64, Bending); 3] =
        [(1700.0, |x| x.x * x.z), (3900.0, |x| x.x * x.x - 0.5), (6100.0, |x| x.z * x.z - 0.5)];
    models[1].modal = BodyModes::Own(Arc::new(ModalModel {
        radius: HALF.length(),
        medium: Medium::AIR,
        density: bodies[1].material.density,
        max_frequency: 20_000.0,
        statistical_above: None,
        modes: shapes.map(mode).to_vec(),
        surface: ModalSurface { nodes, triangles },
    }));
    models
}

/// What is heard of a timeline, and what became of its impacts.
fn hear(timeline: &Timeline, options: &RenderOptions, file: &Path) -> (Vec<f32>, RenderSummary) {
    let bodies = world().bodies;
    let go_on = &mut |_| ControlFlow::Continue(());
    let summary = render(&bodies, &models(&bodies), timeline, options, file, go_on).unwrap();
    let mut samples = Vec::new();
    let mut reader = WavReader::open(file).unwrap();
    while reader.read(&mut samples, 1 << 16).unwrap() > 0 {}
    (samples, summary)
}

/// The timeline on disk with its forces, beside it.
fn with_forces(path: &Path) -> (PathBuf, Vec<ForceRow>) {
    let reader = TimelineReader::open(path).unwrap();
    let timeline = read_impacts(&reader, &[BodyId(1)].into(), false).unwrap();
    let bodies = world().bodies;
    let forces = timeline_forces(&bodies, &models(&bodies), &timeline, &options()).unwrap();
    let target = path.with_file_name("forces.timeline");
    let summary = reader.copy_with_forces(&forces, &target, true).unwrap();
    assert_eq!(summary.forces, forces.len() as u64);
    assert_eq!(summary.contacts, reader.rows().contacts);
    (target, forces)
}

fn read(path: &Path) -> Timeline {
    TimelineReader::open(path).unwrap().read_all().unwrap()
}

#[test]
fn stored_forces_sound_as_the_solve() {
    let (folder, path) = recorded();
    let (target, _) = with_forces(&path);
    let [plain, stored] = [&path, &target].map(|path| read(path));
    assert!(plain.forces.is_empty());
    let file = folder.path().join("a.wav");
    let (solved, summary) = hear(&plain, &options(), &file);
    let (recorded, again) = hear(&stored, &options(), &file);
    let (before, after) = (summary.contacts.solves, again.contacts.solves);
    println!("{before:?}\n{after:?}");
    assert!(before.solved > 3 && before.recorded == 0);
    assert_eq!((after.recorded, after.solved, after.closed), (before.solved, 0, before.closed));
    let deviation = |a: &[f32], b: &[f32]| {
        let peak = a.iter().fold(0.0_f32, |m, p| m.max(p.abs()));
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) / peak
    };
    // Residual seen: 5.0e-8 of the peak.
    let worst = deviation(&solved, &recorded);
    println!("all forces: {worst:e}");
    assert_eq!(solved.len(), recorded.len());
    assert!(worst < 1e-5, "{worst:e}");
    // Half of the forces: the other impacts are solved, with bodies that ring from all.
    let mut half = stored.clone();
    half.forces.retain(|force| force.impact_id % 2 == 0);
    let (mixed, summary) = hear(&half, &options(), &file);
    let solves = summary.contacts.solves;
    assert!(solves.recorded > 0 && solves.recorded + solves.solved == before.solved, "{solves:?}");
    let worst = deviation(&solved, &mixed);
    // Residual seen: 3.4e-3 of the peak: shapes that differ by less than 0.5 % are stored as one.
    println!("half of the forces: {worst:e}");
    assert!(worst < 5e-3, "{worst:e}");
    // Forces of rigid bodies do not come from a timeline.
    let rigid = RenderOptions {
        contact: ContactSettings { forces: ForceSettings::default().rigid(), ..ContactSettings::default() },
        ..options()
    };
    let (a, _) = hear(&plain, &rigid, &file);
    let (b, summary) = hear(&stored, &rigid, &file);
    assert!(a == b && summary.contacts.solves.recorded == 0);
    assert!(deviation(&solved, &a) > 0.01);
}

#[test]
fn impulses_of_the_contacts_stand() {
    let (folder, path) = recorded();
    let (target, _) = with_forces(&path);
    let plain = read(&target);
    let file = folder.path().join("a.wav");
    let (expected, _) = hear(&plain, &options(), &file);
    // Impulses of rows divide those of their points; places far off give shapes alone.
    let mut other = plain.clone();
    for force in &mut other.forces {
        force.impulse *= 0.5;
    }
    let (halved, _) = hear(&other, &options(), &file);
    for force in &mut other.forces {
        force.point.x += 1.0;
    }
    let (moved, summary) = hear(&other, &options(), &file);
    assert!(summary.contacts.solves.recorded > 3);
    let energy = |samples: &[f32]| samples.iter().map(|p| f64::from(p * p)).sum::<f64>();
    for (name, found) in [("halved", halved), ("moved", moved)] {
        let ratio = energy(&found) / energy(&expected);
        println!("{name}: {ratio}");
        // Seen: 1.002 and 1.004. Half the impulse would give 0.25.
        assert!((0.8..1.25).contains(&ratio), "{name}: {ratio}");
    }
}

#[test]
fn forces_come_back() {
    let (_folder, path) = recorded();
    let (target, forces) = with_forces(&path);
    let back = read(&target);
    assert_eq!(back.contacts, read(&path).contacts);
    assert_eq!(back.poses, read(&path).poses);
    assert_eq!(back.forces.len(), forces.len());
    for (read, written) in back.forces.iter().zip(&forces) {
        let near = |a: DVec3, b: DVec3| (a - b).abs().max_element() <= 6e-8 * b.abs().max_element();
        assert!(near(read.point, written.point) && near(read.impulse, written.impulse));
        let rest = |row: &ForceRow| ForceRow { point: DVec3::ZERO, impulse: DVec3::ZERO, ..row.clone() };
        assert_eq!(rest(read), rest(written));
        // 4 samples per period of 24 kHz, from 8 samples before the onset.
        assert!((read.step * 96e3 - 1.0).abs() < 1e-12 && (read.start * 96e3 + 8.0).abs() < 1e-9);
    }
    // Shapes are stored once for all points that share them.
    let shapes = |rows: &[ForceRow]| {
        rows.windows(2).filter(|pair| !Arc::ptr_eq(&pair[0].values, &pair[1].values)).count()
    };
    assert_eq!(shapes(&back.forces), shapes(&forces));
    // A copy of a copy, in its own place.
    let reader = TimelineReader::open(&target).unwrap();
    reader.copy_with_forces(&back.forces, &target, true).unwrap();
    assert_eq!(read(&target), back);
    // A timeline without is what it was before forces were known.
    let text = fs::read_to_string(path.join("timeline.json")).unwrap();
    assert!(!text.contains("force") && !path.join("forces.parquet").exists());
    reader.copy_with_forces(&[], &target, true).unwrap();
    assert_eq!(read(&target), read(&path));
}

#[test]
fn copies_keep_births() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("broken.timeline");
    let mut writer = TimelineWriter::create(&path, &header(), false).unwrap();
    let start = world().bodies;
    for (first, parent, time) in [(2, 1, 0.1), (4, 2, 0.2)] {
        let row =
            FractureRow { time, first_child: BodyId(first), children: 2, ..FractureRow::of(BodyId(parent)) };
        let piece = |k: u32| Body {
            name: format!("piece {}", first + k),
            life: Life::of_piece(BodyId(parent), time),
            ..start[1].clone()
        };
        writer.fracture(&row, &[piece(0), piece(1)]).unwrap();
    }
    writer.finish().unwrap();
    let reader = TimelineReader::open(&path).unwrap();
    let copy = folder.path().join("copy.timeline");
    reader.copy_with_forces(&[], &copy, false).unwrap();
    assert_eq!(read(&copy), read(&path));
    let copied = TimelineReader::open(&copy).unwrap();
    assert_eq!(copied.header(), reader.header());
    assert_eq!(copied.bodies(), reader.bodies());
}

#[test]
fn impossible_forces_are_refused() {
    let (_folder, path) = recorded();
    let (target, forces) = with_forces(&path);
    let good = forces[0].clone();
    type Change = fn(&mut ForceRow);
    let cases: [(Change, &str); 10] = [
        (|f| f.time = f64::NAN, "holds a number that is not finite"),
        (|f| f.impulse.x = f64::INFINITY, "holds a number that is not finite"),
        (|f| f.values = [1.0, f32::NAN].into(), "holds a number that is not finite"),
        (|f| f.step = 0.0, "has a step of 0 s"),
        (|f| f.step = -1e-5, "has a step of -0.00001 s"),
        (|f| f.start = -1e9, "acts from -1000000000 s"),
        (|f| f.duration = 0.0, "lasts 0 s"),
        (|f| f.modal_gain = 2.0, "has a factor of 2 on the modes"),
        (|f| f.values = [0.0; 3].into(), "has a shape of area 0, not 1"),
        (|f| f.impact_id = 999_999, "impact_id is 999999, which no contact has"),
    ];
    let reader = TimelineReader::open(&path).unwrap();
    let bodies = world().bodies;
    for (change, expected) in cases {
        let mut bad = good.clone();
        change(&mut bad);
        let rows = [good.clone(), bad.clone()];
        let message = match reader.copy_with_forces(&rows, &target, true) {
            // An unknown impact is found when the contacts are known.
            Ok(_) => TimelineReader::open(&target).unwrap().read_all().unwrap_err().to_string(),
            Err(error) => error.to_string(),
        };
        assert!(message.contains("forces.parquet, row 1: "), "{message}");
        assert!(message.contains(expected), "{message}");
        // In memory as well, but for what is not used.
        let timeline = Timeline { forces: rows.to_vec(), ..reader.read_all().unwrap() };
        let found = timeline_forces(&bodies, &models(&bodies), &timeline, &options());
        assert_eq!(found.is_ok(), bad.impact_id == 999_999, "{expected}");
    }
}

#[test]
fn tables_that_disagree_are_refused() {
    let (_folder, path) = recorded();
    let (target, forces) = with_forces(&path);
    let (small, _) = with_forces(&path);
    let file = target.join("timeline.json");
    let text = fs::read_to_string(&file).unwrap();
    // The samples of a shorter table, with its own hash and number.
    let other = path.with_file_name("other.timeline");
    TimelineReader::open(&path).unwrap().copy_with_forces(&forces[..1], &other, true).unwrap();
    fs::copy(other.join("force_samples.parquet"), small.join("force_samples.parquet")).unwrap();
    let failure = |path: &Path| match TimelineReader::open(path) {
        Ok(reader) => reader.read_all().unwrap_err().to_string(),
        Err(error) => error.to_string(),
    };
    assert!(failure(&small).contains("force_samples.parquet has changed"), "{}", failure(&small));
    let part = |text: &str| {
        let start = text.find("\"force_samples\"").unwrap();
        let end = start + text[start..].find('}').unwrap() + 1;
        (text[..start].to_string(), text[start..end].to_string(), text[end..].to_string())
    };
    let short = part(&fs::read_to_string(other.join("timeline.json")).unwrap()).1;
    let (before, _, after) = part(&text);
    fs::write(&file, format!("{before}{short}{after}")).unwrap();
    let message = failure(&target);
    assert!(message.contains("forces.parquet, row ") && message.contains("are no shape"), "{message}");
    // No samples at all.
    let comma = after.trim_start().strip_prefix(',').unwrap();
    fs::write(&file, format!("{before}{comma}")).unwrap();
    assert!(failure(&target).contains("force_samples.parquet has"), "{}", failure(&target));
    fs::remove_file(target.join("force_samples.parquet")).unwrap();
    assert!(failure(&target).contains("is missing"), "{}", failure(&target));
}
