//! A timeline with every kind of body, link and row, and its writing and reading.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clangor_core::body::link::LoadCurve;
use clangor_core::body::{Body, BodyId, JointKind, Life, Link, LinkEnd, MeshSurface, Motion, Surface, World};
use clangor_core::geometry::principal_curvature::Curvature;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::material::{Damping, Material};
use clangor_core::medium::Medium;
use clangor_core::pose::{Keyframe, Pose, Track};
use clangor_core::timeline::{ContactKind, ContactRow, FractureRow, PoseRow, Timeline, TimelineSink};
use clangor_pipeline::formats::timeline_file::{
    Origin, TimelineError, TimelineHeader, TimelineReader, TimelineWriter,
};
use glam::{DMat3, DQuat, DVec3};
use tempfile::TempDir;

pub(crate) fn material(damping: Damping) -> Material {
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

pub(crate) fn tetrahedron() -> MeshSurface {
    let vertices = vec![DVec3::X * 0.1, DVec3::Y / 3.0, DVec3::Z, DVec3::splat(-1e-3)];
    let mesh = TriMesh { vertices, triangles: vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]] };
    let curvature = |i: u32| Curvature {
        principal: [f64::from(i) / 3.0, -1.0 / 7.0],
        direction: DVec3::new(0.1, f64::from(i), -0.3).normalize(),
    };
    MeshSurface::restored(mesh, vec![0.1, -2.0, 1.0 / 7.0, 4.0], 0.1 + 0.7)
        .with_curvature((0..4).map(curvature).collect())
}

pub(crate) fn header() -> TimelineHeader {
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

pub(crate) fn write(
    path: &Path,
    header: &TimelineHeader,
    timeline: &Timeline,
) -> Result<(), Box<dyn std::error::Error>> {
    let has_effective_mass = timeline.contacts.iter().any(|row| row.effective_mass.is_some());
    let mut writer = TimelineWriter::create_for_contacts(path, header, true, has_effective_mass)?;
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

pub(crate) fn born(life: Life) -> Life {
    Life { death: f64::INFINITY, ..life }
}

/// The example, in which the first rock breaks at 0.3 s into three, and the second of these at 0.4 s into
/// two.
pub(crate) fn broken() -> (TempDir, PathBuf, Timeline) {
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

pub(crate) fn row(time: f64) -> ContactRow {
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
        effective_mass: None,
    }
}

/// A finished timeline of a few thousand rows.
pub(crate) fn example() -> (TempDir, PathBuf, Timeline) {
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

pub(crate) fn recorded(contacts: Vec<ContactRow>, poses: Vec<PoseRow>) -> Timeline {
    Timeline { contacts, poses, ..Timeline::default() }
}

/// Reads everything there is.
pub(crate) fn read(path: &Path) -> Result<Timeline, TimelineError> {
    TimelineReader::open(path)?.read_all()
}
