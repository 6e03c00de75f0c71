//! Synthetic modes: bounded in number, the same for the same body, of the energy that a plate takes, never
//! radiating more than they got, and kept by a file.

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::modal::{ModalBakeOptions, find_modes, radiate};
use clangor_bake::statistical::{
    PER_THIRD_OCTAVE, StatisticalBand, add_synthetic_modes, radiate_synthetic_modes,
};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::glam::DVec3;
use clangor_core::material::presets::{self, Preset};
use clangor_core::material::{Material, ThinPlate};
use clangor_core::medium::Medium;
use clangor_core::shape::Shape;
use clangor_core::sound_model::modal::model::ModalModel;
use clangor_core::synthesis::modal::source::radiation_ratio;

/// A body with its modes to `limit` \[Hz\] and synthetic ones to `highest`.
fn ringing(name: &str, preset: Preset, limit: f64, highest: f64) -> (ModalModel, Material, StatisticalBand) {
    let mesh = Shape::parse(name).expect("a shape").mesh();
    let mass = MassProperties::of(&mesh).expect("a solid");
    let geometry = BakeGeometry::of_mesh(&mesh.relative_to(mass.centre_of_mass));
    let material = preset.material();
    let options = ModalBakeOptions {
        max_frequency: limit,
        mesh_error: 0.05,
        accuracy: 0.1,
        ..ModalBakeOptions::new(Medium::AIR)
    };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let (mut model, mut evidence) = find_modes(&geometry, &material, &options, go_on).expect("modes");
    radiate(&geometry, &mut model, &mut evidence, &options, go_on).expect("transfers");
    let band = add_synthetic_modes(&mut model, mass.volume, &material, highest).expect("a band");
    radiate_synthetic_modes(&mut model, mass.volume, &material);
    (model, material, band)
}

/// ⟨(U·n)²⟩ over the surface.
fn mean_square(model: &ModalModel, shape: &[DVec3]) -> f64 {
    let mesh = model.surface.quarters();
    let part = |t: usize| {
        let area = mesh.area_vector(t);
        let mean = mesh.triangles[t].iter().map(|i| shape[*i as usize]).sum::<DVec3>() / 3.0;
        mean.dot(area.normalize_or_zero()).powi(2) * area.length()
    };
    let area: f64 = (0..mesh.triangles.len()).map(|t| mesh.area_vector(t).length()).sum();
    (0..mesh.triangles.len()).map(part).sum::<f64>() / area
}

#[test]
fn synthetic_modes_are_few_and_the_same_and_in_order() {
    let body = || ringing("cylinder:0.15x0.25", presets::GRANITE, 12_000.0, 90_000.0);
    let ((model, _, band), (again, ..)) = (body(), body());
    // Synthetic modes have no mesh error, which is NaN.
    let parts = |of: &ModalModel| -> Vec<_> {
        of.modes.iter().map(|m| (m.frequency, m.shape.clone(), m.transfer.clone())).collect()
    };
    assert!(parts(&model) == parts(&again));
    let thirds = 3.0 * (90_000.0_f64 / band.from).log2();
    println!("{band:?}: {:.1} in a third of an octave", band.modes as f64 / thirds);
    assert!(band.modes as f64 <= PER_THIRD_OCTAVE * (thirds + 1.0));
    assert!(band.stands_for > 2.0 * band.modes as f64);
    assert!(model.modes.is_sorted_by(|a, b| a.frequency <= b.frequency));
    assert_eq!(model.known_modes().len() + band.modes, model.modes.len());
    assert!(model.modes.iter().all(|mode| mode.transfer.is_some()));
    let known = model.clone().without_synthetic_modes();
    assert_eq!((known.max_frequency, known.statistical_above), (band.from, None));
    assert_eq!(known.modes.len(), model.known_modes().len());
}

#[test]
fn a_plate_takes_the_energy_of_its_mobility_and_radiates_less() {
    // Up to where the bending wave is ten thicknesses long.
    let (model, material, band) = ringing("cylinder:0.1x0.001", presets::STEEL, 4_000.0, 30_000.0);
    let synthetic = &model.modes[model.known_modes().len()..];
    // ½ Σ (U·n)² for a unit impulse, and (1/π) Re Y Δω.
    let taken: f64 = synthetic.iter().map(|mode| 0.5 * mean_square(&model, &mode.shape)).sum();
    let mobility = ThinPlate::new(&material, 0.001).point_mobility();
    let expected = mobility * TAU * (30_000.0 - band.from) / PI;
    println!("energy over that of an endless plate: {:.3}", taken / expected);
    // An edge has up to four times the mobility. Seen: 1.03.
    assert!((1.0..1.2).contains(&(taken / expected)), "{}", taken / expected);
    let share = |mode: &_| {
        let radiated = radiation_ratio(&model, mode);
        radiated / (radiated + material.damping.damping_ratio(mode.frequency))
    };
    let radiated: f64 =
        synthetic.iter().map(|mode| 0.5 * mean_square(&model, &mode.shape) * share(mode)).sum();
    println!("radiated: {:.3}", radiated / taken);
    assert!(radiated > 0.0 && radiated < taken);
}
