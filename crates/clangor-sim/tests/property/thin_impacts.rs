//! Impacts on bodies with modes in the time-stepped solver: Zener's restitution, ledger, energy, fallback.

use std::f64::consts::{PI, SQRT_2};
use std::ops::ControlFlow;

use clangor_core::body::{Body, BodyId, World};
use clangor_core::contact::{ModesAtContact, no_modes};
use clangor_core::glam::DVec3;
use clangor_core::material::{Material, presets};
use clangor_core::timeline::Timeline;
use clangor_sim::record::RecordSettings;
use clangor_sim::rigid::{ContactModes, Impulse, RigidWorld, StepLog};
use clangor_sim::{
    ContactModel, SimulationReport, SimulationSettings, Solver, simulate, simulate_with_modes,
};

use crate::scenes::{Random, ball, cuboid, floor, solid, world};

/// Modes of a square pane whose edges slide: cos cos, mass-normalised, along y.
struct Pane {
    side: f64,
    frequencies: Vec<f64>,
    waves: Vec<(f64, f64, f64)>,
    damping: f64,
}

impl Pane {
    fn new(material: &Material, side: f64, thickness: f64, highest: f64) -> Self {
        let Material { youngs_modulus, poisson_ratio, density, .. } = *material;
        let bending = youngs_modulus * thickness.powi(3) / (12.0 * (1.0 - poisson_ratio * poisson_ratio));
        let scale = 0.5 * PI / (side * side) * (bending / (density * thickness)).sqrt();
        let mass = density * thickness * side * side;
        let mut pane = Pane { side, frequencies: Vec::new(), waves: Vec::new(), damping: 0.0 };
        let most = (highest / scale).sqrt() as usize + 1;
        for m in 0..=most {
            for n in 0..=most {
                let frequency = scale * (m * m + n * n) as f64;
                if frequency > 0.0 && frequency <= highest {
                    let norm = [m, n].map(|k| if k == 0 { 1.0 } else { SQRT_2 });
                    pane.frequencies.push(frequency);
                    pane.waves.push((m as f64, n as f64, norm[0] * norm[1] / mass.sqrt()));
                }
            }
        }
        pane
    }

    fn at(&self, points: &[(DVec3, DVec3)]) -> ModesAtContact {
        let motions = |(place, _): &(DVec3, DVec3)| {
            let [x, z] = [place.x, place.z].map(|x| PI * (x / self.side + 0.5));
            self.waves.iter().map(|(m, n, u)| u * (m * x).cos() * (n * z).cos() * DVec3::Y).collect()
        };
        ModesAtContact {
            frequencies: self.frequencies.clone(),
            damping_ratios: vec![self.damping; self.frequencies.len()],
            motions: points.iter().map(motions).collect(),
        }
    }
}

fn settings(contact: ContactModel, duration: f64) -> SimulationSettings {
    SimulationSettings {
        solver: Solver::Rigid,
        contact,
        duration,
        time_step: 2.5e-4,
        record: RecordSettings { raw: true, ..RecordSettings::default() },
        sleep: false,
    }
}

fn run(
    world: &World,
    settings: &SimulationSettings,
    modes: clangor_core::contact::modal_energy::ModesOf<'_>,
) -> (Timeline, SimulationReport) {
    let mut timeline = Timeline::default();
    let go_on = &mut |_| ControlFlow::Continue(());
    let report = simulate_with_modes(world, (settings, modes), &mut timeline, go_on).unwrap();
    (timeline, report)
}

fn weightless(bodies: Vec<Body>) -> World {
    World { gravity: DVec3::ZERO, ..world(bodies) }
}

/// A material with this restitution.
fn losing(preset: &presets::Preset, restitution: f64) -> Material {
    preset.material().with_restitution(restitution)
}

fn pane_body(material: &Material, side: f64, thickness: f64) -> Body {
    solid("pane", material, &[cuboid(DVec3::new(0.5 * side, 0.5 * thickness, 0.5 * side))])
}

/// A steel ball of 5 mm at 1 m/s above the middle of a pane.
fn shot(thickness: f64) -> (World, Pane) {
    let glass = losing(&presets::GLASS, 1.0);
    let mut striker = ball(&losing(&presets::STEEL, 1.0), 0.005);
    striker.pose.position = DVec3::new(0.0, 0.5 * thickness + 0.005 + 1e-3, 0.0);
    striker.velocity = -DVec3::Y;
    let world = weightless(vec![pane_body(&glass, 0.25, thickness), striker]);
    (world, Pane::new(&glass, 0.25, thickness, 20e3))
}

#[test]
fn balls_bounce_off_free_panes_as_zener_says() {
    // Restitution on a pane of 50 × 50 cm with all modes, from an ODE of all coordinates.
    for (thickness, known) in [(0.003, 0.171), (0.004, 0.383), (0.006, 0.652), (0.010, 0.855)] {
        let (world, pane) = shot(thickness);
        let modes = |id: BodyId, points: &[(DVec3, DVec3)]| (id.0 == 0).then(|| pane.at(points));
        let (timeline, report) = run(&world, &settings(ContactModel::Compliant, 0.01), &modes);
        let impulse: f64 = timeline.contacts.iter().map(|row| row.impulse_n).sum();
        let restitution = impulse / world.bodies[1].mass - 1.0;
        println!("{thickness}: {restitution:.4} of {known}, {} modes", pane.frequencies.len());
        assert_eq!((report.solved, report.fallen_back), (1, 0));
        assert!((restitution - known).abs() < 0.02, "{thickness}: {restitution}");
    }
}

/// A pane and a ball or a second pane, thrown at each other any which way.
fn throw(random: &mut Random) -> (World, [Option<Pane>; 2]) {
    let material =
        |random: &mut Random| Material { friction: random.unit(), ..losing(&presets::GLASS, random.unit()) };
    let (first, second) = (material(random), material(random));
    let side = 0.1 + 0.1 * random.unit();
    let thickness = 0.002 + 0.004 * random.unit();
    let mut pane = pane_body(&first, side, thickness);
    let modes = Pane::new(&first, side, thickness, 8e3);
    let (mut other, others) = if random.unit() < 0.5 {
        let small = 0.5 * side;
        let mut body = pane_body(&second, small, thickness);
        body.name = "other".into();
        (body, Some(Pane::new(&second, small, thickness, 8e3)))
    } else {
        (ball(&second, 0.005 + 0.01 * random.unit()), None)
    };
    pane.pose.orientation = random.orientation();
    other.pose.orientation = random.orientation();
    pane.angular_velocity = 5.0 * random.unit() * random.direction();
    other.angular_velocity = 20.0 * random.unit() * random.direction();
    let way = random.direction();
    let reach = pane.surface.bounding_radius() + other.surface.bounding_radius() + 1e-3;
    other.pose.position = reach * way + 0.2 * side * random.direction();
    other.velocity = -(0.5 + 5.0 * random.unit()) * way;
    (weightless(vec![pane, other]), [Some(modes), others])
}

#[test]
fn momentum_is_kept_and_energy_never_grows() {
    let mut random = Random(0x51ab_77d1);
    let (mut linear, mut angular, mut gained) = (0.0_f64, 0.0_f64, f64::MIN);
    let mut counts = [0, 0];
    for case in 0..100 {
        let (world, panes) = throw(&mut random);
        let modes = |id: BodyId, points: &[(DVec3, DVec3)]| Some(panes[id.index()].as_ref()?.at(points));
        let Ok(mut rigid) = RigidWorld::try_new(&world, 2.5e-4, false) else { continue };
        let mut log = StepLog::new();
        let energy = |rigid: &RigidWorld| rigid.kinetic_energy() + rigid.modal_energy();
        let all = energy(&rigid);
        for _ in 0..400 {
            let before: Vec<_> = (0..2).map(|i| rigid.momentum(BodyId(i))).collect();
            let was = energy(&rigid);
            rigid
                .step_with(&mut log, Some(ContactModes { modes: &modes, v_min: 0.05, followed: false }))
                .unwrap();
            gained = gained.max((energy(&rigid) - was) / all);
            for (i, (momentum, spin)) in before.iter().enumerate() {
                let (mut sum, mut turn, mut size) = (DVec3::ZERO, DVec3::ZERO, 0.0);
                for Impulse { row, arm_a, arm_b } in log.impulses() {
                    let (arm, sign) = if row.body_a.index() == i { (arm_a, 1.0) } else { (arm_b, -1.0) };
                    sum += sign * row.impulse();
                    turn += sign * (arm.cross(row.impulse()) + row.couple);
                    size += row.impulse().length();
                }
                if size > 0.0 {
                    let after = rigid.momentum(BodyId(i as u32));
                    let radius = world.bodies[i].surface.bounding_radius();
                    linear = linear.max((after.0 - *momentum - sum).length() / size);
                    angular = angular.max((after.1 - *spin - turn).length() / (size * radius));
                }
            }
        }
        let (solved, fallen_back) = rigid.solved_impacts();
        counts[0] += solved;
        counts[1] += fallen_back;
        assert!(energy(&rigid) <= all * (1.0 + 1e-9), "{case}");
    }
    println!("{counts:?} solved and not; {linear:.1e} {angular:.1e}, energy gained {gained:.1e}");
    assert!(counts[0] > 60 && counts[1] == 0, "{counts:?}");
    assert!(linear < 1e-10 && angular < 1e-10 && gained < 1e-9);
}

/// A pane that falls on a floor, and a ball on it.
fn table() -> (World, Pane) {
    let glass = presets::GLASS.material();
    let mut pane = pane_body(&glass, 0.2, 0.004);
    pane.pose.position = DVec3::new(0.0, 0.05, 0.0);
    pane.pose.orientation = clangor_core::glam::DQuat::from_rotation_x(0.1);
    let mut striker = ball(&presets::STEEL.material(), 0.008);
    striker.pose.position = DVec3::new(0.02, 0.3, 0.01);
    let modes = Pane { damping: 0.005, ..Pane::new(&glass, 0.2, 0.004, 15e3) };
    (world(vec![floor(&presets::GRANITE.material()), pane, striker]), modes)
}

#[test]
fn the_rigid_setting_is_a_run_without_modes() {
    let (world, pane) = table();
    let modes = |id: BodyId, points: &[(DVec3, DVec3)]| (id.0 == 1).then(|| pane.at(points));
    let (rigid, report) = run(&world, &settings(ContactModel::Rigid, 0.5), &modes);
    let (without, _) = run(&world, &settings(ContactModel::Compliant, 0.5), &no_modes);
    let mut plain = Timeline::default();
    simulate(&world, &settings(ContactModel::Rigid, 0.5), &mut plain, &mut |_| ControlFlow::Continue(()))
        .unwrap();
    assert_eq!((report.solved, report.fallen_back), (0, 0));
    assert_eq!(rigid, without);
    assert_eq!(rigid, plain);
    let (solved, report) = run(&world, &settings(ContactModel::Compliant, 0.5), &modes);
    println!("{} solved, {} fell back", report.solved, report.fallen_back);
    assert!(report.solved > 2 && report.fallen_back == 0);
    assert_ne!(solved, rigid);
    assert_eq!(solved, run(&world, &settings(ContactModel::Compliant, 0.5), &modes).0);
}

#[test]
fn modes_that_are_none_fall_back_and_are_counted() {
    let (mut world, pane) = table();
    // The same restitution with and without vibration.
    for body in &mut world.bodies {
        body.material = body.material.clone().with_restitution(0.8);
    }
    let spoilt: [fn(&mut ModesAtContact); 5] = [
        |modes| modes.motions.iter_mut().for_each(|at| at[3] = DVec3::NAN),
        // Of no mass.
        |modes| modes.motions.iter_mut().for_each(|at| at[3] = DVec3::Y / 0.0),
        |modes| modes.frequencies[2] = f64::NAN,
        // Of another body.
        |modes| modes.motions.iter_mut().for_each(|at| at.truncate(2)),
        |modes| modes.damping_ratios.clear(),
    ];
    let (rigid, _) = run(&world, &settings(ContactModel::Rigid, 0.3), &no_modes);
    for spoil in spoilt {
        let modes = |id: BodyId, points: &[(DVec3, DVec3)]| {
            let mut modes = (id.0 == 1).then(|| pane.at(points))?;
            spoil(&mut modes);
            Some(modes)
        };
        let (timeline, report) = run(&world, &settings(ContactModel::Compliant, 0.3), &modes);
        assert!(report.solved == 0 && report.fallen_back > 0, "{report:?}");
        assert_eq!(timeline, rigid);
    }
}
