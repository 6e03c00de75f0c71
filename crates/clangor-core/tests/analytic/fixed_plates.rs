//! A ball on a fixed plate that only vibrates: by its modes in closed form (simply supported), against the
//! endless plate of the same thickness (Zener), while no wave has come back from the edges. And the balance
//! of energy.

use std::f64::consts::PI;

use clangor_core::body::{Body, BodyId, Motion};
use clangor_core::contact::{
    ContactSide, GroupContact, GroupImpact, GroupMember, GroupSolver, ModesAtContact, no_modes,
};
use clangor_core::glam::DVec3;
use clangor_core::material::{ThinPlate, presets};
use clangor_core::pose::Pose;
use clangor_core::shape::Shape;

const RADIUS: f64 = 0.01;
/// Length and width of the plate \[m\].
const SIDES: [f64; 2] = [1.0, 0.8];

/// The modes of the plate, simply supported, up to a frequency, at points.
fn modes(plate: &ThinPlate, limit: f64, points: &[(DVec3, DVec3)]) -> ModesAtContact {
    let speed = (plate.bending_stiffness / plate.mass_per_area).sqrt();
    let amplitude = 2.0 / (plate.mass_per_area * SIDES[0] * SIDES[1]).sqrt();
    let mut all = ModesAtContact { motions: vec![Vec::new(); points.len()], ..ModesAtContact::default() };
    let most = |side: f64| (side * (2.0 * PI * limit / speed).sqrt() / PI) as usize;
    for m in 1..=most(SIDES[0]) {
        for n in 1..=most(SIDES[1]) {
            let [k, l] = [m as f64 * PI / SIDES[0], n as f64 * PI / SIDES[1]];
            let frequency = speed * (k * k + l * l) / (2.0 * PI);
            if frequency > limit {
                break;
            }
            all.frequencies.push(frequency);
            all.damping_ratios.push(1e-4);
            for (motions, (x, _)) in all.motions.iter_mut().zip(points) {
                let shape = (k * (x.x + 0.43 * SIDES[0])).sin() * (l * (x.z + 0.37 * SIDES[1])).sin();
                motions.push(amplitude * shape * DVec3::Y);
            }
        }
    }
    all
}

/// Restitution of a steel ball, and the energy that the modes of the plate have after it, over that before.
fn bounce(thickness: f64, speed: f64, endless: bool) -> [f64; 2] {
    let (surface, mass) = Shape::parse("sphere:0.01").unwrap().surface().unwrap();
    let steel = presets::STEEL.material();
    let ball = Body::solid("ball", steel, surface, &mass).at(Pose::at(DVec3::Y * RADIUS));
    let glass = presets::GLASS.material();
    let plate = ThinPlate::new(&glass, thickness);
    let (surface, mass) =
        Shape::parse(&format!("box:{}x{thickness}x{}", SIDES[0], SIDES[1])).unwrap().surface().unwrap();
    let top = Pose::at(-0.5 * thickness * DVec3::Y);
    let board = match endless {
        true => Body::plate("board", glass, (DVec3::ZERO, DVec3::Y), thickness),
        false => Body::solid("board", glass, surface, &mass).at(top).with_motion(Motion::Fixed),
    };
    let sides = [(1, &ball), (0, &board)].map(|(id, body)| {
        ContactSide::of_body(BodyId(id), body, body.pose).touched_at(
            &body.surface,
            DVec3::Y,
            std::iter::once((DVec3::ZERO, 1.0)),
        )
    });
    assert!(!sides[1].is_movable());
    let velocity = [-speed * DVec3::Y, DVec3::ZERO];
    let members =
        [0, 1].map(|i| GroupMember { side: sides[i], velocity: velocity[i], angular_velocity: DVec3::ZERO });
    let contact = GroupContact {
        members: [0, 1],
        sides,
        place: DVec3::ZERO,
        normal: DVec3::Y,
        gap: 0.0,
        approach: speed,
        restitution: 1.0,
        friction: 0.0,
    };
    let group = GroupImpact { time: 0.0, members: &members, contacts: &[contact], followed: false };
    let mut solver = GroupSolver::default();
    let of_board = |id: BodyId, points: &[(DVec3, DVec3)]| (id.0 == 0).then(|| modes(&plate, 60e3, points));
    let impulse = match endless {
        true => solver.solve(&group, &no_modes).unwrap()[0].y,
        false => {
            assert!(solver.matters(&contact, &of_board));
            solver.solve(&group, &of_board).unwrap()[0].y
        }
    };
    let before = 0.5 * ball.mass * speed * speed;
    [impulse / (ball.mass * speed) - 1.0, solver.modal_energy() / before]
}

#[test]
fn a_ball_feels_an_endless_plate_until_waves_return() {
    for (thickness, speed) in [(0.008, 1.0), (0.006, 2.0), (0.005, 1.0)] {
        let [endless, _] = bounce(thickness, speed, true);
        let [fixed, modal] = bounce(thickness, speed, false);
        println!("{thickness} m, {speed} m/s: {fixed:.4} of {endless:.4}, {modal:.4} in the modes");
        assert!((fixed - endless).abs() < 0.02, "{fixed} of {endless}");
        // The rest is in the tail above the known modes, which is heat: never more than there was.
        let all = fixed * fixed + modal;
        assert!(all < 1.0 && all > 0.97, "{all}");
    }
}
