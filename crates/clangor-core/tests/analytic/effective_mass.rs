//! Pulses of links on joints: the mass of Hertz's formula is 1/(nᵀ J M⁻¹ Jᵀ n).

use clangor_core::body::{Body, BodyId};
use clangor_core::contact::{ContactSettings, ImpactPulse, PoseHistory, impact_pulses};
use clangor_core::glam::{DMat3, DVec3};
use clangor_core::timeline::{ContactKind, ContactRow};

use crate::bodies::ball;

const MASS: f64 = 0.2;
const LENGTH: f64 = 0.3;
const RADIUS: f64 = 0.01;
const SPEED: f64 = 1.3;
const MODULUS: f64 = 70e9;
const POISSON: f64 = 0.3;

/// The pulse of the lower of two equal rods that hang straight down, struck across its free end by the world,
/// with the effective mass of the row \[kg\].
fn pulse(effective_mass: Option<f64>) -> ImpactPulse {
    let material = crate::bodies::material("link", 7800.0, MODULUS, POISSON);
    let across = MASS * LENGTH * LENGTH / 12.0;
    let inertia = DMat3::from_diagonal(DVec3::new(across, 1e-5, across));
    let rod = Body { mass: MASS, inertia, ..ball(material, RADIUS, DVec3::new(0.0, -1.5 * LENGTH, 0.0)) };
    let row = ContactRow {
        time: 0.0,
        body_a: BodyId(0),
        body_b: BodyId::WORLD,
        kind: ContactKind::Impact,
        point: DVec3::new(0.0, -2.0 * LENGTH, 0.0),
        normal: DVec3::X,
        impulse_n: 0.05,
        impulse_t: DVec3::ZERO,
        couple: DVec3::ZERO,
        velocity: DVec3::X * -SPEED,
        depth: 0.0,
        impact_id: 1,
        effective_mass,
    };
    let bodies = [rod];
    let poses = PoseHistory::try_new(&bodies, &[]).unwrap();
    let (mut pulses, _) = impact_pulses(&bodies, &[row], &poses, &ContactSettings::default()).unwrap();
    assert_eq!(pulses.len(), 1);
    pulses.remove(0)
}

/// τ = 2.868 (m²/(R E*² V))^{1/5} \[s\] against a rigid plane.
fn hertz_duration(mass: f64) -> f64 {
    let modulus = MODULUS / (1.0 - POISSON * POISSON);
    2.943_275_184_3
        * (15.0_f64 / 16.0).powf(0.4)
        * (mass * mass / (RADIUS * modulus * modulus * SPEED)).powf(0.2)
}

#[test]
fn the_end_of_a_double_pendulum_is_hit_for_the_time_of_its_effective_mass() {
    // Angles a, b of the rods against the vertical: T = m l² (2/3 ȧ² + 1/2 ȧḃ + 1/6 ḃ²), velocity of the end
    // l (ȧ + ḃ), so M = m l² [[4/3, 1/2], [1/2, 1/3]] and J = l [1, 1].
    let (scale, [a, b, c]) = (MASS * LENGTH * LENGTH, [4.0 / 3.0, 0.5, 1.0 / 3.0]);
    let inverse = LENGTH * LENGTH * (a + c - 2.0 * b) / (scale * (a * c - b * b));
    let mass = inverse.recip();
    // 7/24 of the mass of a rod; a rod alone has a quarter. Residual seen: 1e-16.
    assert!((mass / (MASS * 7.0 / 24.0) - 1.0).abs() < 1e-14);
    let (joined, alone) = (pulse(Some(mass)), pulse(None));
    // Residual seen: 8e-12, of the last digit of 2.9432751843, and 4e-16.
    for (pulse, mass) in [(&joined, mass), (&alone, 0.25 * MASS)] {
        assert!((pulse.duration / hertz_duration(mass) - 1.0).abs() < 1e-10, "{}", pulse.duration);
        assert!((pulse.effective_mass / mass - 1.0).abs() < 1e-14, "{}", pulse.effective_mass);
    }
    // The impulse is the recorded one, and moves the rod as it did.
    assert_eq!(joined.points, alone.points);
    let motion = |pulse: &ImpactPulse| {
        pulse.bodies[0].map(|share| (share.impulse, share.velocity_change, share.angular_velocity_change))
    };
    assert!(motion(&joined).is_some() && motion(&joined) == motion(&alone));
}
