//! The table of material presets in the documentation agrees with the program.

use clangor_core::material::presets::{ALIASES, PRESETS, names, preset};
use clangor_core::material::{Damping, PairCoefficients};
use clangor_core::medium::Medium;

#[test]
fn the_documented_table_is_true() {
    let document = include_str!("../../../../docs/format/materials.md");
    let rows: Vec<Vec<&str>> = document
        .lines()
        .filter(|line| line.starts_with("| `"))
        .map(|line| line.trim_matches('|').split('|').map(|cell| cell.trim().trim_matches('`')).collect())
        .collect();
    assert_eq!(rows.len(), PRESETS.len());
    for (row, preset) in rows.iter().zip(PRESETS) {
        assert_eq!(row[0], preset.name);
        let numbers: Vec<f64> = row[1..].iter().map(|cell| cell.parse().unwrap()).collect();
        let program = [
            preset.density,
            preset.youngs_modulus / 1e9,
            preset.poisson_ratio,
            preset.restitution,
            preset.rigid_restitution,
            preset.friction,
            preset.rolling_loss * 1e3,
            preset.loss_factor,
            preset.tensile_strength / 1e6,
            preset.fracture_energy,
        ];
        for (written, actual) in numbers.iter().zip(program) {
            // Decimal fractions of powers of ten: residual seen 2e-16.
            assert!((written / actual - 1.0).abs() < 1e-12, "{}: {written} is not {actual}", preset.name);
        }
    }
}

#[test]
fn names_and_aliases_resolve() {
    for name in names() {
        let material = preset(name).unwrap();
        assert_eq!(material.name, name);
        assert!(!material.source.is_empty());
        assert!(matches!(material.damping, Damping::LossFactor(eta) if eta > 0.0));
        // Two bodies of one material keep its numbers.
        assert_eq!(PairCoefficients::of(&material, &material).friction, material.friction);
    }
    assert!(ALIASES.contains(&("pan-steel", "copper")));
    assert_eq!(preset("pan-steel").unwrap().youngs_modulus, 123.4e9);
    assert!(preset("unobtainium").is_none());
}

#[test]
fn dry_air_at_20_degrees_is_the_default() {
    let air = Medium::dry_air(20.0);
    // The printed values are rounded: residuals seen 1e-5 kg/m³ and 0.03 m/s.
    assert!((air.density - Medium::AIR.density).abs() < 5e-5, "{}", air.density);
    assert!((air.sound_speed - Medium::AIR.sound_speed).abs() < 0.05, "{}", air.sound_speed);
    // 0 °C: 331.3 m/s and 1.293 kg/m³, as in standard tables.
    let cold = Medium::dry_air(0.0);
    assert!((cold.sound_speed - 331.3).abs() < 0.1 && (cold.density - 1.293).abs() < 0.001);
}
