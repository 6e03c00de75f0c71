//! A box that breaks in two where it lands, from the solver to the sound: recorded, read back, and heard.

use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId, MeshSurface, Motion, Surface, World};
use clangor_core::contact::{ContactSettings, no_modes};
use clangor_core::geometry::convex::ConvexPart;
use clangor_core::geometry::hull::convex_hull;
use clangor_core::material::presets;
use clangor_core::medium::Medium;
use clangor_core::pose::Pose;
use clangor_core::scene::render_description::{GroundSound, Parts};
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel, ModalTransfer};
use clangor_core::sound_model::modal::surface::ModalSurface;
use clangor_core::synthesis::{BodyModes, SoundModel, SoundPart};
use clangor_core::synthesis::{Listener, RenderSettings, SoundSource};
use clangor_core::timeline::{ContactKind, ContactRow, FractureRow, PoseRow, Timeline, TimelineSink};
use clangor_pipeline::formats::timeline_file::{Origin, TimelineHeader, TimelineReader, TimelineWriter};
use clangor_pipeline::formats::wav::{SampleFormat, WavReader};
use clangor_pipeline::stages::render::{
    FullScale, ModalStateTransfer, RenderOptions, RenderSummary, Transfers, read_impacts, render,
};
use clangor_sim::record::RecordSettings;
use clangor_sim::rigid::{CrackImpulse, Replacement, RigidWorld, StepLog};
use clangor_sim::{ContactModel, SimulationError, SimulationSettings, Solver, simulate_breaking};
use glam::{DMat3, DQuat, DVec3};
use num_complex::Complex64;

const HALF: DVec3 = DVec3::new(0.03, 0.01, 0.02);
const DURATION: f64 = 1.5;
const MICROPHONE: DVec3 = DVec3::new(0.5, 0.6, 0.4);

/// A box with these half edges, at rest at the origin.
fn cuboid(name: &str, half: DVec3) -> Body {
    let corner = |k: usize| {
        let sign = |bit: usize| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
        DVec3::new(sign(0), sign(1), sign(2)) * half
    };
    let corners: Vec<DVec3> = (0..8).map(corner).collect();
    let mesh = convex_hull(&corners).unwrap();
    let (surface, mass) = MeshSurface::try_new(mesh, vec![ConvexPart::Hull(corners)]).unwrap();
    // As pieces are, whose vibration is not known.
    let material = presets::GLASS.rigid_material();
    Body::solid(name, material, Surface::Mesh(surface), &mass).with_edge_radius(1e-4)
}

fn world() -> World {
    let floor = Body {
        surface: Arc::new(Surface::HalfSpace),
        mass: f64::INFINITY,
        inertia: DMat3::from_diagonal(DVec3::INFINITY),
        motion: Motion::Fixed,
        ..cuboid("floor", HALF)
    };
    let mut tile = cuboid("tile", HALF);
    tile.pose = Pose { position: DVec3::Y * 0.2, orientation: DQuat::from_rotation_z(0.5) };
    World { bodies: vec![floor, tile], links: Vec::new(), gravity: DVec3::Y * -9.81 }
}

fn settings(time_step: f64) -> SimulationSettings {
    SimulationSettings {
        solver: Solver::Rigid,
        contact: ContactModel::default(),
        duration: DURATION,
        time_step,
        record: RecordSettings { raw: true, ..RecordSettings::default() },
        sleep: true,
    }
}

/// Breaks the tile in the middle when it is hit, and drives the halves apart.
fn halve(rigid: &RigidWorld, log: &StepLog) -> Vec<Replacement> {
    let tile = BodyId(1);
    let hit = |row: &ContactRow| row.kind == ContactKind::Impact && row.body_a == tile;
    if !rigid.is_alive(tile) || !log.impulses().iter().any(|impulse| hit(&impulse.row)) {
        return Vec::new();
    }
    let now = rigid.pose(tile);
    let axis = now.orientation * DVec3::X;
    let impulse = axis * 0.002;
    let half = |side: f64| {
        let arm = axis * (0.5 * side * HALF.x);
        let mut half = cuboid(if side > 0.0 { "right" } else { "left" }, HALF * DVec3::new(0.5, 1.0, 1.0));
        half.pose = Pose { position: now.position + arm, orientation: now.orientation };
        half.velocity = now.velocity + now.angular_velocity.cross(arm) + impulse * side / half.mass;
        half.angular_velocity = now.angular_velocity;
        half
    };
    let crack = CrackImpulse {
        piece_a: 0,
        piece_b: 1,
        point: now.position,
        normal: axis,
        impulse,
        couple: DVec3::ZERO,
    };
    let row = FractureRow { crack_area: 4.0 * HALF.y * HALF.z, duration: 1e-4, ..FractureRow::of(tile) };
    vec![Replacement { row, pieces: vec![half(1.0), half(-1.0)], cracks: vec![crack] }]
}

/// Memory and disk at once.
struct Both(Timeline, TimelineWriter);

impl TimelineSink for Both {
    fn contact(&mut self, row: &ContactRow) -> std::io::Result<()> {
        self.0.contact(row)?;
        self.1.contact(row)
    }

    fn pose(&mut self, row: &PoseRow) -> std::io::Result<()> {
        self.0.pose(row)?;
        self.1.pose(row)
    }

    fn fracture(&mut self, row: &FractureRow, children: &[Body]) -> std::io::Result<()> {
        self.0.fracture(row, children)?;
        self.1.fracture(row, children)
    }
}

/// Simulates into a folder; what was recorded in memory comes back.
fn simulate(folder: &Path, time_step: f64) -> Timeline {
    let settings = settings(time_step);
    let header = TimelineHeader {
        world: world(),
        medium: Medium::AIR,
        origin: Origin::of_simulation(&settings, Solver::Rigid, 0),
        scene: None,
    };
    let mut sink = Both(Timeline::default(), TimelineWriter::create(folder, &header, true).unwrap());
    let mut breaker = |rigid: &mut RigidWorld, log: &mut StepLog| Ok::<_, SimulationError>(halve(rigid, log));
    let go_on = &mut |_| ControlFlow::Continue(());
    let report = simulate_breaking(&world(), (&settings, &no_modes), &mut sink, &mut breaker, go_on).unwrap();
    assert_eq!((report.fractures, report.births), (1, 2));
    let Both(timeline, writer) = sink;
    let summary = writer.finish().unwrap();
    assert_eq!((summary.fractures, summary.births), (1, 2));
    timeline
}

#[test]
fn what_breaks_is_recorded_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.timeline");
    for time_step in [2e-4, 1e-4, 5e-5] {
        let timeline = simulate(&path, time_step);
        let reader = TimelineReader::open(&path).unwrap();
        let read = reader.read_all().unwrap();
        assert_eq!((read.contacts.len(), read.poses.len()), (timeline.contacts.len(), timeline.poses.len()));
        assert_eq!(read.fractures, timeline.fractures);
        let whole = timeline.all_bodies(&world().bodies);
        let bodies = reader.bodies();
        let lives = |bodies: &[Body]| bodies.iter().map(|b| (b.name.clone(), b.life)).collect::<Vec<_>>();
        assert_eq!(lives(&bodies), lives(&whole));

        // It breaks in the step in which it lands: 0.18 s of fall.
        let FractureRow { time, parent, first_child, children, .. } = timeline.fractures[0];
        assert_eq!((parent, first_child, children), (BodyId(1), BodyId(2), 2));
        let impact = timeline.contacts.iter().find(|row| row.kind == ContactKind::Impact).unwrap();
        assert!((0.0..=time_step * (1.0 + 1e-9)).contains(&(time - impact.time)), "{time} {}", impact.time);
        // The dead have a pose at their death and none later, the born one at their birth and none earlier.
        let times = |id: u32| timeline.poses.iter().filter(move |p| p.body == BodyId(id)).map(|p| p.time);
        assert_eq!(times(1).fold(0.0, f64::max), time);
        for piece in [2, 3] {
            assert_eq!(times(piece).fold(f64::INFINITY, f64::min), time);
            assert!(times(piece).fold(0.0, f64::max) > DURATION - 2e-3);
        }
        // Momentum goes on: what the tile had, the halves have.
        let momentum = |id: u32| {
            let row = timeline.poses.iter().find(|p| p.body == BodyId(id) && p.time == time).unwrap();
            row.velocity * whole[id as usize].mass
        };
        // Residual seen: 2e-17 N s of 0.1.
        assert!((momentum(1) - momentum(2) - momentum(3)).length() < 1e-15);
        // Halves that part and fall do not hit each other again; in the end all is quiet.
        let rows =
            || timeline.contacts.iter().filter(|row| row.time > time && row.kind != ContactKind::Fracture);
        assert!(rows().all(|row| row.body_a != BodyId(1)), "the dead are hit");
        assert!(rows().any(|row| row.body_a == BodyId(2)) && rows().any(|row| row.body_a == BodyId(3)));
        let loud = rows().filter(|row| row.time > DURATION - 0.2 && row.approach_speed() > 0.05).count();
        assert_eq!(loud, 0);
    }
}

fn options() -> RenderOptions {
    RenderOptions {
        listeners: vec![Listener::fixed("microphone", MICROPHONE)],
        contact: ContactSettings::default(),
        synthesis: RenderSettings::default(),
        parts: Parts { acceleration: true, modal: false, ground: false },
        transfers: Transfers::Baked,
        rolling: None,
        ground: GroundSound::None,
        inherit_vibration: true,
        to: DURATION,
        format: SampleFormat::Float32,
        full_scale: FullScale::Pascals(1.0),
        compressor: None,
        stems: true,
        note: String::new(),
    }
}

/// Bodies that click as spheres.
fn spheres(bodies: &[Body]) -> Vec<SoundModel> {
    SoundSource::spheres(bodies).into_iter().map(SoundModel::without_modes).collect()
}

fn hear(bodies: &[Body], timeline: &Timeline, file: &Path) -> RenderSummary {
    let options = options();
    let models = spheres(bodies);
    render(bodies, &models, timeline, &options, file, &mut |_| ControlFlow::Continue(())).unwrap()
}

/// Modes of a box with these half edges that bend it, the longest at `lowest` \[Hz\].
fn modes(half: DVec3, lowest: f64) -> BodyModes {
    let steps = 6;
    let (mut nodes, mut triangles) = (Vec::new(), Vec::new());
    for side in [-1.0, 1.0] {
        for (i, k) in (0..steps).flat_map(|i| (0..steps).map(move |k| (i, k))) {
            let place = |[i, k]: [f64; 2]| {
                let part = |n: f64| 2.0 * n / f64::from(steps) - 1.0;
                half * DVec3::new(part(i), side, part(k))
            };
            let [i, k] = [i, k].map(f64::from);
            let corners = [[i, k], [i + 1.0, k], [i + 1.0, k + 1.0], [i, k + 1.0]];
            for triangle in [[0, 1, 2], [0, 2, 3]] {
                let corner: [[f64; 2]; 3] = triangle.map(|c: usize| corners[c]);
                let first = nodes.len() as u32;
                let middle = |a: usize, b: usize| [0, 1].map(|n| 0.5 * (corner[a][n] + corner[b][n]));
                nodes.extend(corner.map(place));
                nodes.extend([middle(0, 1), middle(1, 2), middle(2, 0)].map(place));
                triangles.push(std::array::from_fn(|n| first + n as u32));
            }
        }
    }
    let scale = (4.0 / cuboid("", half).mass).sqrt();
    let mode = |[m, n]: [f64; 2]| {
        let wave = |x: f64, half: f64, count: f64| (0.5 * PI * count * (x / half + 1.0)).cos();
        let shape = |x: &DVec3| DVec3::Y * scale * wave(x.x, half.x, m) * wave(x.z, half.z, n);
        ModalMode {
            frequency: lowest * ((m / half.x).powi(2) + (n / half.z).powi(2)) / (2.0 / HALF.x).powi(2),
            mesh_error: 0.0,
            support_damping: 0.0,
            shape: nodes.iter().map(shape).collect(),
            transfer: Some(ModalTransfer { order: 0, coefficients: vec![Complex64::ONE] }),
        }
    };
    BodyModes::Own(Arc::new(ModalModel {
        radius: half.length(),
        medium: Medium::AIR,
        density: 2600.0,
        max_frequency: 20_000.0,
        statistical_above: None,
        modes: [[2.0, 0.0], [1.0, 1.0], [0.0, 2.0], [2.0, 1.0], [3.0, 0.0]].map(mode).to_vec(),
        surface: ModalSurface { nodes, triangles },
    }))
}

#[test]
fn halves_ring_on_with_what_the_tile_rang_with() {
    let folder = tempfile::tempdir().unwrap();
    let recorded = simulate(&folder.path().join("a.timeline"), 1e-4);
    let bodies = recorded.all_bodies(&world().bodies);
    let half = || modes(HALF * DVec3::new(0.5, 1.0, 1.0), 900.0);
    let mut models = spheres(&bodies);
    for (model, modal) in models[1..].iter_mut().zip([modes(HALF, 900.0), half(), half()]) {
        model.modal = modal;
    }
    let parts = Parts { acceleration: false, modal: true, ground: false };
    let [on, off] = [true, false].map(|inherit_vibration| {
        let options = RenderOptions { parts, inherit_vibration, ..options() };
        let file = folder.path().join(format!("{inherit_vibration}.wav"));
        let go_on = &mut |_| ControlFlow::Continue(());
        render(&bodies, &models, &recorded, &options, &file, go_on).unwrap()
    });
    let ModalStateTransfer { had, handed } = on.handovers[&BodyId(1)];
    println!("{handed:.1e} J of {had:.1e} J");
    assert!(handed > 0.01 * had && handed <= had * (1.0 + 1e-12) && off.handovers.is_empty());
    let birth = recorded.fractures[0].time;
    for body in [2, 3] {
        let stem = |summary: &RenderSummary| {
            let own = |file: &&clangor_pipeline::stages::render::RenderedFile| {
                file.stem.is_some_and(|s| s.body == BodyId(body))
            };
            samples(&summary.files.iter().find(own).unwrap().path)
        };
        let taken: Vec<f32> = stem(&on).iter().zip(stem(&off)).map(|(on, off)| on - off).collect();
        let peak = |part: &[f32]| part.iter().fold(0.0f32, |m, p| m.max(p.abs()));
        let arrives = ((birth + 0.8 / 343.0) * 48_000.0) as usize;
        // It rises for a millisecond, and then rings down.
        assert!(peak(&taken[..arrives - 60]) < 1e-6 * peak(&taken));
        assert!(peak(&taken[arrives + 48..arrives + 200]) > 0.3 * peak(&taken));
        assert!(peak(&taken[arrives + 48_000..]) < 0.1 * peak(&taken));
    }
    // What the cracks take is not left to vibrate.
    let mut costly = recorded.clone();
    costly.fractures[0].fracture_energy = 1e3;
    let options = RenderOptions { parts, ..options() };
    let file = folder.path().join("c.wav");
    let summary =
        render(&bodies, &models, &costly, &options, &file, &mut |_| ControlFlow::Continue(())).unwrap();
    assert!(summary.handovers.is_empty(), "{:?}", summary.handovers);
}

fn samples(path: &Path) -> Vec<f32> {
    let mut samples = Vec::new();
    let mut reader = WavReader::open(path).unwrap();
    while reader.read(&mut samples, 1 << 16).unwrap() > 0 {}
    samples
}

#[test]
fn the_halves_are_heard_from_their_birth_on() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.timeline");
    let recorded = simulate(&path, 1e-4);
    let reader = TimelineReader::open(&path).unwrap();
    let bodies = reader.bodies();
    let timeline = read_impacts(&reader, &Default::default(), false).unwrap();
    assert_eq!(timeline.all_bodies(&reader.header().world.bodies), bodies);
    let summary = hear(&bodies, &timeline, &folder.path().join("a.wav"));
    let birth = timeline.fractures[0].time;
    let loudest = |body: u32| {
        let stem = |file: &&clangor_pipeline::stages::render::RenderedFile| {
            file.stem.is_some_and(|s| s.body == BodyId(body) && s.part == SoundPart::Acceleration)
        };
        let file = summary.files.iter().find(stem).unwrap();
        let samples = samples(&file.path);
        assert!(samples.iter().all(|p| p.is_finite()));
        // Sound from the nearest corner, less the reach of the band limit.
        let arrives = ((birth + 0.6 / 343.0 - 1e-3) * 48_000.0) as usize;
        let peak = |part: &[f32]| part.iter().fold(0.0f32, |m, p| m.max(p.abs()));
        (peak(&samples[..arrives]), peak(&samples[arrives..]))
    };
    for half in [2, 3] {
        let (before, after) = loudest(half);
        // Residual seen: 5e-11, the skirt of the band limit.
        assert!(before < 1e-8 * after && after > 1e-3, "{half}: {before:e} {after:e}");
        assert!(summary.energies[&BodyId(half)] > 0.0);
        assert!(summary.contacts.bodies[half as usize].pulses > 0);
    }
    // The tile sounds by the impact that breaks it, and then no more.
    let tile = &summary.contacts.bodies[1];
    assert!(tile.pulses == 1 && loudest(1).1 > 1e-3, "{tile:?}");

    // Out of memory or from the disk, it is the same sound but for the 32 bits of the rows.
    let whole = recorded.all_bodies(&world().bodies);
    let direct = hear(&whole, &recorded, &folder.path().join("b.wav"));
    for (body, energy) in &summary.energies {
        // Residual seen: 3e-7.
        assert!((direct.energies[body] / energy - 1.0).abs() < 1e-5, "{body:?}");
    }
}
