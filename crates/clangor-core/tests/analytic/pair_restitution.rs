//! Restitution of pairs against approach speed: closed forms, an integration of the equation of motion, and
//! bounds.

use std::f64::consts::PI;

use crate::compliant_bodies::{ball, contact, hertz};
use clangor_core::contact::compliant::{ContactSystem, HertzLaw, SolverMemory, StepSettings, viscosity};
use clangor_core::glam::DVec3;
use clangor_core::material::pair_restitution::{plastic_speed, viscoelastic_rate, viscoelastic_restitution};
use clangor_core::material::{Material, PairCoefficients, PairRestitution, presets};
use clangor_core::math::random::SplitMix;

fn pair(a: &Material, b: &Material) -> PairRestitution {
    PairCoefficients::of(a, b).restitution
}

#[test]
fn a_constant_restitution_is_the_same_bits_at_every_speed() {
    let [glass, granite] = [&presets::GLASS, &presets::GRANITE].map(|preset| preset.material());
    for speed in [0.0, 1e-9, 0.05, 1.0, 1e3] {
        assert_eq!(pair(&glass, &glass).at(speed), glass.restitution);
        let mean = (glass.restitution * granite.restitution).sqrt();
        assert_eq!(pair(&glass, &granite).at(speed), mean);
        assert_eq!(PairRestitution::LOSSLESS.at(speed), 1.0);
    }
}

/// The inverse of the polynomial, and the series of weak damping: e = 1 − 1.15344 x + 0.79826 x² …
/// \[SchwagerPoeschel1998\].
#[test]
fn a_viscous_contact_loses_as_the_fifth_root_of_the_speed() {
    for restitution in [0.02, 0.1, 0.5, 0.9, 0.99, 1.0] {
        let again = viscoelastic_restitution(viscoelastic_rate(restitution));
        // Residual seen 2e-15, of the halvings.
        assert!((again - restitution).abs() < 1e-14, "{restitution}: {again}");
    }
    let steel = presets::STEEL.material();
    let viscous = Material { restitution: 0.99, restitution_speed: Some(0.5), ..steel };
    let law = pair(&viscous, &viscous);
    // The stated restitution at the stated speed: residual seen 6e-16.
    assert!((law.at(0.5) - 0.99).abs() < 1e-14);
    let x = viscoelastic_rate(0.99);
    for speed in [1e-4, 1e-2, 1.0, 30.0] {
        let y = x * (speed / 0.5_f64).powf(0.2);
        let series = 1.0 - 1.153_44 * y + 0.798_26 * y * y;
        // y is at most 0.02, and the next term of the series below 4e-6. Residual seen 1.1e-5, of the fit.
        assert!((law.at(speed) - series).abs() < 4e-5, "{speed}: {} of {series}", law.at(speed));
    }
}

/// The solver of contacts with its viscoelastic law, calibrated at one speed, bounces as e(V) at others.
#[test]
fn a_solved_viscous_contact_bounces_as_the_pair_says() {
    let steel = Material { restitution: 0.8, restitution_speed: Some(1.0), ..presets::STEEL.material() };
    let law = pair(&steel, &steel);
    let radius = 0.01;
    let at_rest = ball(radius, radius * DVec3::Y, DVec3::ZERO);
    let stiffness = hertz(1e9).stiffness;
    let law_of_contact =
        HertzLaw { viscosity: viscosity(0.8, stiffness, at_rest.inverse_mass, 1.0), ..hertz(1e9) };
    for speed in [0.01, 0.3, 1.0, 10.0] {
        let striker = ball(radius, radius * DVec3::Y, -speed * DVec3::Y);
        let momentum = speed / striker.inverse_mass;
        let hit = contact([Some(0), None], DVec3::ZERO, DVec3::Y, law_of_contact);
        let system = ContactSystem::new(&[striker], &[hit]).unwrap();
        let settings = StepSettings { steps_per_duration: 256.0, ..StepSettings::default() };
        let mut memory = SolverMemory::default();
        let bounce = system.solve(&settings, &mut memory).unwrap().impulse(0).y / momentum - 1.0;
        println!("{speed} m/s: {bounce:.5}, {:.5}", law.at(speed));
        // Residual seen 3e-5, of the steps.
        assert!((bounce - law.at(speed)).abs() < 1e-4, "{speed}: {bounce} of {}", law.at(speed));
    }
}

/// Energies of loading and unloading under a constant pressure, by quadrature.
#[test]
fn a_plastic_contact_gives_back_what_its_pressure_stores() {
    let (strength, density, compliance) = (2.5e8, 7850.0, 1.0 / 1.09e11);
    let (radius, pressure) = (0.011_f64, 3.0 * strength);
    let limit = plastic_speed(strength, density, compliance);
    let steel =
        Material { yield_strength: Some(strength), ..presets::STEEL.material().with_restitution(1.0) };
    for speed in [2.0, 8.0, 30.0] {
        // Loading with F = π a² p over dδ = (a/R) da, until the energy of the ball is used up.
        let energy = 0.5 * density * 4.0 / 3.0 * PI * radius.powi(3) * speed * speed;
        let (mut width, mut work, step) = (0.0_f64, 0.0, 1e-9);
        while work < energy {
            let middle = width + 0.5 * step;
            work += PI * middle * middle * pressure * middle / radius * step;
            width += step;
        }
        // Unloading as Hertz from a contact of that width: 3F²/(10 a E*).
        let force = PI * width * width * pressure;
        let back = 0.3 * force * force * compliance / width;
        let bounce = (back / energy).sqrt();
        // At most 1.5 steps of the width: 4e-6.
        let closed = (limit / speed).powf(0.25);
        assert!((bounce / closed - 1.0).abs() < 5e-6, "{speed}: {bounce} of {closed}");
        // A pair of this material has its own E*; e falls as the fourth root.
        let law = pair(&steel, &steel);
        assert!((law.at(16.0 * speed) / law.at(speed) - 0.5).abs() < 1e-12);
    }
    // Structural steel: 0.13 m/s, far above the first yield at (26 Y/ρ)^½ (Y/E*)² [Johnson1985].
    let first = (26.0 * strength / density).sqrt() * (strength * compliance).powi(2);
    assert!(limit > 0.12 && limit < 0.14 && first < 0.1 * limit, "{limit}, {first}");
    assert_eq!(pair(&steel, &steel).at(0.5 * limit), 1.0);
}

#[test]
fn the_softer_material_yields() {
    let hard = presets::STEEL.material().with_restitution(0.9);
    let soft = Material { yield_strength: Some(1e6), ..presets::SOIL.material() };
    let tough = Material { yield_strength: Some(1e9), ..hard.clone() };
    for speed in [0.1, 1.0, 10.0] {
        let both = pair(&tough, &soft).at(speed);
        assert_eq!(both, pair(&soft, &tough).at(speed));
        assert_eq!(both, pair(&hard, &soft).at(speed));
    }
}

/// 0 ≤ e ≤ 1, and e never rises with the speed, for random materials.
#[test]
fn restitution_stays_within_bounds_and_never_rises() {
    let mut random = SplitMix::new(18);
    for _ in 0..300 {
        let mut draw = || {
            let speed = 10f64.powf(random.uniform(-6.0, 3.0));
            let strength = 10f64.powf(random.uniform(3.0, 10.0));
            Material {
                restitution: random.uniform(0.0, 1.0),
                restitution_speed: (random.uniform(0.0, 1.0) < 0.5).then_some(speed),
                yield_strength: (random.uniform(0.0, 1.0) < 0.5).then_some(strength),
                density: 10f64.powf(random.uniform(1.0, 4.0)),
                youngs_modulus: 10f64.powf(random.uniform(5.0, 12.0)),
                ..presets::STEEL.material()
            }
        };
        let law = pair(&draw(), &draw());
        let mut last = 1.0;
        for exponent in -40..=16 {
            let now = law.at(10f64.powf(f64::from(exponent) / 4.0));
            assert!((0.0..=last).contains(&now), "{now} after {last}: {law:?}");
            last = now;
        }
        assert!(law.at(0.0) >= last && law.at(f64::NAN) <= 1.0 && law.at(f64::NAN) >= 0.0);
    }
}
