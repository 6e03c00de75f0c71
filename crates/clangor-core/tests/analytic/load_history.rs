//! Force and stored energy of an impact over time against Hertz's closed forms and the balance of energy.

use std::f64::consts::{PI, SQRT_2};

use clangor_core::body::{Body, BodyId};
use clangor_core::contact::hertz::HertzContact;
use clangor_core::contact::modal_energy::ModesOf;
use clangor_core::contact::{
    ContactSide, GroupContact, GroupImpact, GroupMember, GroupSolver, LoadHistory, ModesAtContact, no_modes,
};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::glam::DVec3;
use clangor_core::material::{Material, presets};
use clangor_core::pose::Pose;
use clangor_core::shape::Shape;

const RADIUS: f64 = 0.01;

fn body(shape: &str, material: &Material, at: DVec3) -> Body {
    let (surface, mass): (_, MassProperties) = Shape::parse(shape).unwrap().surface().unwrap();
    Body::solid(shape, material.clone(), surface, &mass).at(Pose { position: at, ..Pose::IDENTITY })
}

/// A ball of 1 cm that falls on a body below it, with a restitution; what both feel, and the contact.
fn fall(
    below: &Body,
    (speed, restitution): (f64, f64),
    modes: ModesOf<'_>,
) -> ([LoadHistory; 2], HertzContact) {
    let ball = body("sphere:0.01", &presets::STEEL.material(), DVec3::Y * RADIUS);
    let sides = [(1, &ball), (0, below)].map(|(id, body)| {
        let side = ContactSide::of_body(BodyId(id), body, body.pose);
        // No waves into the floor.
        let side = ContactSide { radiation: 0.0, ..side };
        side.touched_at(&body.surface, DVec3::Y, std::iter::once((DVec3::ZERO, 1.0)))
    });
    let members = [-speed * DVec3::Y, DVec3::ZERO];
    let members =
        [0, 1].map(|i| GroupMember { side: sides[i], velocity: members[i], angular_velocity: DVec3::ZERO });
    let contact = GroupContact {
        members: [0, 1],
        sides,
        place: DVec3::ZERO,
        normal: DVec3::Y,
        gap: 0.0,
        approach: speed,
        restitution,
        friction: 0.0,
    };
    let group = GroupImpact { time: 0.0, members: &members, contacts: &[contact], followed: true };
    let mut solver = GroupSolver::default();
    solver.solve(&group, modes).unwrap();
    let histories = [0, 1].map(|member| solver.load_history(&group, member).unwrap());
    let hertz = HertzContact {
        inverse_mass: sides.iter().map(|side| side.inverse_effective_mass(DVec3::ZERO, DVec3::Y)).sum(),
        relative_radii: [RADIUS; 2],
        compliance: sides.iter().map(|side| side.compliance).sum(),
        speed,
    };
    (histories, hertz)
}

/// Time at which Hertz's approach reaches a part s of the largest, over d_m/V: ∫ ds/√(1 − s^{5/2}).
fn time_of(part: f64) -> f64 {
    let n = 20_000;
    let step = part / f64::from(n);
    (0..n).map(|i| step / (1.0 - ((f64::from(i) + 0.5) * step).powf(2.5)).sqrt()).sum()
}

#[test]
fn a_hertz_pulse_has_its_force_and_energy_at_every_instant() {
    let stone = Body::plane("floor", presets::GRANITE.material(), DVec3::ZERO, DVec3::Y);
    let (histories, hertz) = fall(&stone, (2.0, 1.0), &no_modes);
    let [ball, floor] = &histories;
    let (deepest, stiffness) = (hertz.largest_approach(), hertz.stiffness());
    let peak = stiffness * deepest.powf(1.5);
    let energy = 0.5 * 2.0 * 2.0 / hertz.inverse_mass;
    let mut worst = [0.0_f64; 2];
    for part in [0.1, 0.2, 0.4, 0.6, 0.8, 0.9] {
        let time = time_of(part) * deepest / 2.0;
        let (force, stored) = (ball.forces_at(time).collect::<Vec<_>>(), ball.stored_at(time));
        let known = stiffness * (part * deepest).powf(1.5);
        let closed = 0.4 * known * part * deepest;
        worst[0] = worst[0].max((force[0].y - known).abs() / peak);
        worst[1] = worst[1].max((stored - closed).abs() / energy);
        let (opposite, same) = (floor.forces_at(time).collect::<Vec<_>>(), floor.stored_at(time));
        assert!((force[0] + opposite[0]).length() < 1e-12 * peak && stored == same);
    }
    println!("force {:.1e} of the peak, energy {:.1e} of the approach", worst[0], worst[1]);
    // Residuals seen: 7.9e-3 and 3.1e-3, of lines between 24 steps per duration.
    assert!(worst[0] < 1e-2 && worst[1] < 5e-3, "{worst:?}");
    assert!((ball.energy / energy - 1.0).abs() < 5e-3, "{} {energy}", ball.energy);
    // The solve goes on for some steps after the force has ended.
    let last = ball.forces.iter().rposition(|force| *force != DVec3::ZERO).unwrap() as f64 * ball.step;
    assert!((last / hertz.duration() - 1.0).abs() < 0.06 && ball.duration() >= last, "{last}");
}

#[test]
fn losses_leave_less_than_the_approach() {
    let stone = Body::plane("floor", presets::GRANITE.material(), DVec3::ZERO, DVec3::Y);
    for restitution in [0.9, 0.5, 0.1] {
        let ([ball, _], hertz) = fall(&stone, (2.0, restitution), &no_modes);
        let energy = 2.0 / hertz.inverse_mass;
        let lost = energy * (1.0 - restitution * restitution);
        assert!((ball.heat / lost - 1.0).abs() < 0.02, "{restitution}: {} {lost}", ball.heat);
        assert!(ball.stored.iter().all(|stored| (0.0..energy).contains(stored)));
        assert_eq!(ball.ringing, 0.0);
    }
}

#[test]
fn contact_and_modes_store_what_motion_lost() {
    // A pane with sliding edges, hit at its middle.
    let glass = presets::GLASS.material();
    let (side, thickness) = (0.25, 0.004);
    let pane = body("box:0.25x0.004x0.25", &glass, -0.5 * thickness * DVec3::Y);
    let plate = glass.youngs_modulus * thickness.powi(3) / (12.0 * (1.0 - glass.poisson_ratio.powi(2)));
    let scale = 0.5 * PI / (side * side) * (plate / (glass.density * thickness)).sqrt();
    let mut found = ModesAtContact::default();
    let mut motions = Vec::new();
    for (m, n) in (0..30).flat_map(|m| (0..30).map(move |n| (m, n))).filter(|k| *k != (0, 0)) {
        let frequency = scale * f64::from(m * m + n * n);
        if frequency < 20e3 {
            let [a, b] = [m, n].map(|k| if k == 0 { 1.0 } else { SQRT_2 * (0.5 * PI * f64::from(k)).cos() });
            found.frequencies.push(frequency);
            motions.push(DVec3::Y * (a * b / pane.mass.sqrt()));
        }
    }
    found.damping_ratios = vec![0.0; found.frequencies.len()];
    found.motions = vec![motions];
    let modes = |id: BodyId, _: &[(DVec3, DVec3)]| (id.0 == 0).then(|| found.clone());
    let ([ball, struck], hertz) = fall(&pane, (1.0, 1.0), &modes);
    let energy = 0.5 / hertz.inverse_mass;
    // Motion lost at each instant, from the impulse so far: j V − j²/(2 m).
    let (mut impulse, mut worst) = (0.0, 0.0_f64);
    for (n, stored) in struck.stored.iter().enumerate().skip(1) {
        impulse -= 0.5 * struck.step * (struck.forces[n - 1].y + struck.forces[n].y);
        let lost = impulse - 0.5 * impulse * impulse * hertz.inverse_mass;
        worst = worst.max((lost - stored).abs() / energy);
        assert!(*stored <= energy * (1.0 + 1e-9));
    }
    println!("balance {worst:.1e}, ringing {:.3} of the approach", struck.ringing / energy);
    // Residual seen: 8.1e-3, of the trapezium.
    assert!(worst < 1e-2, "{worst:e}");
    // Without modes of its own, the ball feels the contact alone.
    assert!(ball.ringing == 0.0 && struck.ringing > 0.3 * energy);
}

#[test]
fn half_of_the_impulse_follows_the_deepest_approach() {
    let floor = body("box:0.2x0.2x0.2", &presets::GLASS.material(), DVec3::NEG_Y * 0.1);
    let ([history, _], hertz) = fall(&floor, (1.0, 1.0), &no_modes);
    let half = 0.5 * hertz.duration();
    assert_eq!(
        (history.shares_after(0.0), history.shares_after(2.0 * history.duration())),
        (vec![1.0], vec![0.0])
    );
    let [share] = history.shares_after(half)[..] else { panic!("one point") };
    println!("share {share}");
    // Residual seen: 3e-5.
    assert!((share - 0.5).abs() < 1e-3, "{share}");
    let mut ended = history.clone();
    ended.end_at(half);
    assert!((ended.duration() - half).abs() <= history.step);
    let after = 1.01 * half + history.step;
    assert_eq!(
        (ended.forces_at(after).collect::<Vec<_>>(), ended.stored_at(after)),
        (vec![DVec3::ZERO], 0.0)
    );
}
