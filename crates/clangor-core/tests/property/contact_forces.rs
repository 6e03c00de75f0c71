//! The forces of one impact: what they do to the motion of both bodies, and how much energy they give to
//! modes.

use std::f64::consts::{PI, TAU};

use clangor_core::body::{Body, BodyId};
use clangor_core::contact::contact_side::ContactSide;
use clangor_core::contact::modal_energy::ModesOf;
use clangor_core::contact::{
    ContactError, ForceProfile, ForceSettings, Impact, ImpactModel, ImpactPulse, ImpactSolver,
    ModesAtContact, contact_forces, no_modes,
};
use clangor_core::glam::{DMat3, DQuat, DVec3};
use clangor_core::material::presets;
use clangor_core::pose::Pose;

const A: BodyId = BodyId(0);
const B: BodyId = BodyId(1);

/// A turned steel ball with the inertia of an oblong body, and a glass ball below it.
fn sides() -> [ContactSide; 2] {
    let mut oblong = Body::sphere("oblong", presets::STEEL.material(), 0.02);
    oblong.inertia = DMat3::from_diagonal(DVec3::new(1.0, 3.0, 2.0) * 2e-5);
    let ball = Body::sphere("ball", presets::GLASS.material(), 0.015);
    let turned = Pose {
        position: DVec3::new(0.1, 0.2, -0.1),
        orientation: DQuat::from_scaled_axis(DVec3::new(0.4, -1.0, 0.3)),
    };
    let flat = ContactSide::of_body(A, &oblong, turned);
    let below = Pose::at(DVec3::new(0.11, 0.165, -0.1));
    let round =
        ContactSide::of_body(B, &ball, below).touched_at(&ball.surface, DVec3::Y, [(POINT, 1.0)].into_iter());
    [ContactSide { curvature: DMat3::from_diagonal(DVec3::splat(50.0)), ..flat }, round]
}

const POINT: DVec3 = DVec3::new(0.11, 0.18, -0.1);

fn impact(restitution: f64) -> Impact {
    Impact::with_restitution(sides(), POINT, DVec3::Y, 1.3, restitution)
}

/// Velocity of the contact point of A relative to B after the impact, along the normal [m/s].
fn separation(pulse: &ImpactPulse) -> f64 {
    let velocity = |side: usize| {
        let share = pulse.bodies[side].unwrap();
        share.velocity_change + share.angular_velocity_change.cross(POINT - share.pose.position)
    };
    (velocity(0) - velocity(1)).dot(pulse.normal) - pulse.speed
}

/// The only pulse of an impact.
fn one(impact: &Impact, modes: ModesOf<'_>, settings: &ForceSettings) -> ImpactPulse {
    let mut pulses = contact_forces(impact, modes, settings, &mut ImpactSolver::default()).unwrap();
    assert_eq!(pulses.len(), 1);
    pulses.remove(0)
}

#[test]
fn surfaces_part_at_e_times_their_approach() {
    for restitution in [0.0, 0.4, 1.0] {
        let pulse = one(&impact(restitution), &no_modes, &ForceSettings::default());
        // Residual seen: 3e-16.
        assert!((separation(&pulse) - restitution * 1.3).abs() < 1e-13, "{restitution} {pulse:?}");
        let [Some(a), Some(b)] = pulse.bodies else { panic!("both move") };
        assert!((a.impulse + b.impulse).length() < 1e-18 && a.modal_gain == 1.0);
        // What a collision without loss of energy loses is counted as at a restitution of 0.95.
        let loss = 0.5 * pulse.effective_mass * 1.3 * 1.3 * (1.0 - restitution.min(0.95).powi(2));
        let counted = if restitution < 1.0 { loss } else { pulse.energy_lost() };
        // Residual seen: 2e-16.
        assert!((pulse.energy_lost() / counted - 1.0).abs() < 1e-12, "{restitution}");
        assert_eq!(pulse.modal_energy_ratio, 0.0);
    }
}

#[test]
fn the_modes_of_both_bodies_together_get_at_most_the_energy_of_the_approach() {
    // Displacements along the normal [kg^−½] of three modes of each body.
    let frequencies = [300.0, 2_000.0, 9_000.0];
    for (strength, bounded) in [(1.0, false), (30.0, true)] {
        let modes_of = |id: BodyId, points: &[(DVec3, DVec3)]| {
            let to_body = sides()[id.index()].pose.orientation.inverse();
            let along = if id == A { strength } else { 0.5 * strength };
            let motion = to_body * (along * DVec3::Y);
            let motions = points.iter().map(|_| vec![motion; frequencies.len()]).collect();
            let damping_ratios = vec![1e-3; frequencies.len()];
            Some(ModesAtContact { frequencies: frequencies.to_vec(), damping_ratios, motions })
        };
        let given = ForceSettings { model: ImpactModel::Given, ..ForceSettings::default() };
        let rigid = one(&impact(0.5), &modes_of, &given);
        let pulse = one(&impact(0.5), &modes_of, &ForceSettings::default().rigid());
        // E of the forces on the modes, by the definition.
        let energy = |pulse: &ImpactPulse| -> f64 {
            let of_body = |(id, along): (BodyId, f64)| -> f64 {
                let points: Vec<_> = pulse.modal_impulses_on(id).flatten().collect();
                let impulse = points.iter().map(|(_, j)| j.length()).sum::<f64>();
                let mode = |f: &f64| {
                    let spectrum = ForceProfile::Hertz.centred_spectrum(TAU * f, pulse.duration);
                    0.5 * (along * impulse * spectrum).powi(2)
                };
                frequencies.iter().map(mode).sum()
            };
            [(A, strength), (B, 0.5 * strength)].into_iter().map(of_body).sum()
        };
        let available = 0.5 * pulse.effective_mass * 1.3 * 1.3;
        // Residual seen: 2e-16.
        assert!((energy(&rigid) / available / rigid.modal_energy_ratio - 1.0).abs() < 1e-12);
        assert_eq!(rigid.modal_energy_ratio > 1.0, bounded, "{}", rigid.modal_energy_ratio);
        let wanted = if bounded { available } else { energy(&rigid) };
        // Residual seen: 4e-16.
        assert!((energy(&pulse) / wanted - 1.0).abs() < 1e-12, "{strength}");
        // Motion, time profile and reported ratio are those of the rigid bodies.
        assert_eq!(pulse.points, rigid.points);
        assert_eq!((pulse.duration, pulse.modal_energy_ratio), (rigid.duration, rigid.modal_energy_ratio));
        assert_eq!(separation(&pulse), separation(&rigid));
    }
}

#[test]
fn duration_is_that_of_hertz_for_both_sides() {
    let pulse = one(&impact(0.5), &no_modes, &ForceSettings::default());
    let [a, b] = sides();
    let material = [presets::STEEL.material(), presets::GLASS.material()];
    let compliance: f64 = material.iter().map(|m| (1.0 - m.poisson_ratio.powi(2)) / m.youngs_modulus).sum();
    let arm = a.pose.orientation.inverse() * (POINT - a.pose.position);
    let lever = arm.cross(a.pose.orientation.inverse() * DVec3::Y);
    let turning = (lever * lever / (DVec3::new(1.0, 3.0, 2.0) * 2e-5)).element_sum();
    let mass = |density: f64, radius: f64| density * 4.0 / 3.0 * PI * f64::powi(radius, 3);
    // The centre of B is on the line of the normal.
    let inverse_mass =
        1.0 / mass(material[0].density, 0.02) + turning + 1.0 / mass(material[1].density, 0.015);
    // 4/5 B(2/5, 1/2) (15/16)^{2/5}
    let hertz =
        2.868_265_699_195_331 * ((50.0 + 1.0 / 0.015) * (compliance / inverse_mass).powi(2) / 1.3).powf(0.2);
    // Residual seen: 3e-16.
    assert!((pulse.duration / hertz - 1.0).abs() < 1e-12, "{} {hertz}", pulse.duration);
    assert_eq!(b.curvature, DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0) / 0.015));
}

#[test]
fn what_cannot_move_feels_no_force_and_two_such_bodies_have_no_impact() {
    let [a, b] = sides();
    let fixed = ContactSide { inverse_mass: 0.0, inverse_inertia: DMat3::ZERO, ..b };
    let on = |sides| Impact::with_restitution(sides, POINT, DVec3::Y, 1.0, 0.5);
    let pulse = one(&on([a, fixed]), &no_modes, &ForceSettings::default());
    assert!(pulse.bodies[0].is_some() && pulse.bodies[1].is_none());
    let still = ContactSide { inverse_mass: 0.0, inverse_inertia: DMat3::ZERO, ..a };
    for impossible in [
        on([still, fixed]),
        Impact::with_restitution([a, b], POINT, DVec3::Y, 0.0, 0.5),
        Impact::with_restitution([a, b], POINT, DVec3::Y, f64::NAN, 0.5),
        on([ContactSide { compliance: 0.0, ..a }, ContactSide { compliance: 0.0, ..b }]),
    ] {
        let outcome =
            contact_forces(&impossible, &no_modes, &ForceSettings::default(), &mut ImpactSolver::default());
        assert!(matches!(outcome, Err(ContactError::NoDuration { .. })), "{outcome:?}");
    }
}
