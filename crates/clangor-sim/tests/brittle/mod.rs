//! A brittle tile that hits a stone floor, and the results of its run.

use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::stress::fracture_mesh;
use clangor_core::body::{Body, BodyId, World};
use clangor_core::glam::{DMat3, DQuat, DVec3};
use clangor_core::material::{Material, presets};
use clangor_core::pose::Pose;
use clangor_core::scene::breaking::Breaking;
use clangor_core::shape::Shape;
use clangor_sim::fracture::{Breakable, BreakingBodies};
use clangor_sim::record::RecordSettings;
use clangor_sim::rigid::{Replacement, RigidWorld, StepLog};
use clangor_sim::{ContactModel, SimulationSettings, Solver};

pub(crate) const EDGES: DVec3 = DVec3::new(0.12, 0.006, 0.12);

/// A tile of given fracture energy \[J/m²\] that falls from a height \[m\] with a speed \[m/s\] onto a plane,
/// tilted by an angle \[°\].
pub(crate) fn tile(
    toughness: f64,
    (drop, speed): (f64, f64),
    degrees: f64,
    breaking: Breaking,
    seed: u64,
) -> (World, Vec<Breakable>) {
    let material = Material { fracture_energy: Some(toughness), ..presets::CERAMIC.material() };
    let shape = Shape::parse(&format!("box:{}x{}x{}", EDGES.x, EDGES.y, EDGES.z)).unwrap();
    let (surface, mass) = shape.surface().unwrap();
    let pose = Pose {
        position: DVec3::Y * drop,
        orientation: DQuat::from_axis_angle(DVec3::new(0.3, 0.0, 1.0).normalize(), degrees.to_radians()),
    };
    let tile = Body::solid("tile", material, surface, &mass)
        .at(pose)
        .with_velocity(DVec3::NEG_Y * speed)
        .with_angular_velocity(DVec3::new(0.3, 1.0, 0.0));
    let floor = Body::plane("floor", presets::GRANITE.material(), DVec3::ZERO, DVec3::Y);
    let mesh = fracture_mesh(&BakeGeometry::RoundedBox { edges: EDGES, round: 0.0 }, Some(0.01)).unwrap();
    let breakable = Breakable { body: BodyId(0), mesh, breaking, seed };
    let world = World { bodies: vec![tile, floor], links: Vec::new(), gravity: DVec3::NEG_Y * 9.80665 };
    (world, vec![breakable])
}

/// Results of one run.
#[derive(Default)]
pub(crate) struct Run {
    pub(crate) replacements: Vec<Replacement>,
    /// Largest energy after a step over the energy at the beginning.
    pub(crate) most_energy: f64,
    /// Largest jump of momentum and of angular momentum over a fracture, as parts of those of the pieces.
    pub(crate) jump: f64,
    /// Kinetic energy gained from cracks, and its expected value \[J\].
    pub(crate) gains: Vec<(f64, f64)>,
    /// Velocities of the first bodies at the end \[m/s\].
    pub(crate) velocities: Vec<DVec3>,
    /// Momentum of all bodies at the end \[N s\].
    pub(crate) momentum: DVec3,
}

pub(crate) fn run(world: &World, breakables: Vec<Breakable>, step: f64, duration: f64) -> Run {
    run_with(ContactModel::Compliant, world, breakables, (step, duration))
}

/// A run with this law of impacts.
pub(crate) fn run_with(
    contact: ContactModel,
    world: &World,
    breakables: Vec<Breakable>,
    (step, duration): (f64, f64),
) -> Run {
    let mut rigid = RigidWorld::try_new(world, step, true).unwrap();
    let settings = SimulationSettings {
        solver: Solver::Rigid,
        contact,
        duration,
        time_step: step,
        record: RecordSettings { v_min: 0.05, ..RecordSettings::default() },
        sleep: true,
    };
    let mut breaking = BreakingBodies::new(world, breakables, &settings).unwrap();
    let mut log = StepLog::new();
    let mut seen = Run::default();
    let start = rigid.energy();
    for _ in 0..(duration / step) as usize {
        rigid.step(&mut log).unwrap();
        for replacement in breaking.look(&mut rigid, &mut log).unwrap() {
            let parent = replacement.row.parent;
            let state = rigid.pose(parent);
            let (momentum, spin) = rigid.momentum(parent);
            let about = |r: DVec3, p: DVec3| (r - state.position).cross(p);
            let (mut after, mut turning, mut size) = (DVec3::ZERO, DVec3::ZERO, [1e-12; 2]);
            for piece in &replacement.pieces {
                let turn = DMat3::from_quat(piece.pose.orientation);
                let inertia = turn * piece.inertia * turn.transpose();
                let (p, l) = (piece.velocity * piece.mass, inertia * piece.angular_velocity);
                after += p;
                turning += l + about(piece.pose.position, p);
                size[0] += p.length();
                size[1] += l.length() + about(piece.pose.position, p).length();
            }
            let jump = ((after - momentum).length() / size[0]).max((turning - spin).length() / size[1]);
            seen.jump = seen.jump.max(jump);
            let surplus = replacement.row.strain_energy - replacement.row.fracture_energy;
            seen.gains.push((replacement.row.kinetic_energy_gain, surplus));
            rigid.replace(parent, &replacement.pieces).unwrap();
            seen.replacements.push(replacement);
        }
        seen.most_energy = seen.most_energy.max(rigid.energy() / start);
    }
    let all = |count: usize| (0..count as u32).map(BodyId);
    seen.velocities = all(world.bodies.len()).map(|body| rigid.pose(body).velocity).collect();
    let alive = all(rigid.count()).filter(|body| rigid.is_alive(*body));
    seen.momentum = alive.map(|body| rigid.momentum(body).0).filter(|p| p.is_finite()).sum();
    seen
}

impl Run {
    /// Masses of the pieces that are whole at the end [kg].
    pub(crate) fn masses(&self, whole: f64) -> Vec<f64> {
        let broken: Vec<f64> =
            self.replacements.iter().map(|r| r.pieces.iter().map(|p| p.mass).sum()).collect();
        let mut masses: Vec<f64> =
            self.replacements.iter().flat_map(|r| r.pieces.iter().map(|p| p.mass)).collect();
        // Removes pieces that broke again; the mass of such a piece is the sum of its own pieces.
        for lost in broken.iter().filter(|m| (**m - whole).abs() > 1e-9 * whole) {
            let nearest =
                |a: &usize, b: &usize| (masses[*a] - lost).abs().total_cmp(&(masses[*b] - lost).abs());
            if let Some(at) = (0..masses.len()).min_by(nearest) {
                masses.swap_remove(at);
            }
        }
        masses.sort_by(f64::total_cmp);
        masses
    }
}
