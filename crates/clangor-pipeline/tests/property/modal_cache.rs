//! The cache keeps modes as it keeps fields: whole or not at all, under a name that everything they depend on
//! is in; what is killed between the modes and their sound goes on from the modes.

use std::fs;
use std::ops::ControlFlow;

use clangor_bake::acceleration::BakeProgress;
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::modal::ModalBakeOptions;
use clangor_bake::modal::held_body::Held;
use clangor_core::body::Surface;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::glam::DVec3;
use clangor_core::material::{Material, presets};
use clangor_core::medium::Medium;
use clangor_core::sound_model::files::modal_file::ModalFile;
use clangor_pipeline::formats::model_cache::{Lookup, ModelCache, modal_key};
use clangor_pipeline::stages::sound_models::{ModalBake, SoundModelError, SoundModelRequest, obtain};

/// A ball of steel with a few modes in the band, on a coarse mesh.
fn request(max_frequency: f64) -> SoundModelRequest<ModalBake> {
    let options = ModalBakeOptions {
        max_frequency,
        mesh_error: 0.1,
        accuracy: 0.1,
        ..ModalBakeOptions::new(Medium::AIR)
    };
    let surface = Surface::Sphere { radius: 0.1 };
    let steel = presets::preset("steel").unwrap();
    let part = ModalBake::new(&steel, options);
    SoundModelRequest::new("ball", &surface, MassProperties::of_sphere(0.1), part).unwrap()
}

fn go_on(_: &BakeProgress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

#[test]
fn modes_are_baked_once_and_go_on_after_an_interruption() {
    let folder = tempfile::tempdir().unwrap();
    let cache = ModelCache::new(folder.path());
    let request = request(13_500.0);
    let mut until_radiation = |p: &BakeProgress| match p.stage {
        "radiating modes" => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    };
    let stopped = obtain(&request, Some(&cache), &mut until_radiation).unwrap_err();
    assert!(matches!(stopped, SoundModelError::Interrupted));
    let kept = cache.read_modes(request.key()).expect("the modes are kept");
    assert!(kept.modal.model.modes.len() >= 5 && kept.modal.model.modes.iter().all(|m| m.transfer.is_none()));
    assert!(matches!(cache.read::<ModalFile>(request.key()), Lookup::Missing));

    let mut finds_no_modes = |p: &BakeProgress| {
        assert_ne!(p.stage, "finding modes");
        ControlFlow::Continue(())
    };
    let resumed = obtain(&request, Some(&cache), &mut finds_no_modes).unwrap();
    assert!(!resumed.cached && resumed.remarks.is_empty(), "{:?}", resumed.remarks);
    assert!(cache.read_modes(request.key()).is_none());
    let whole = obtain(&request, None, &mut go_on).unwrap();
    assert!(whole.file == resumed.file);
    let again = obtain(&request, Some(&cache), &mut go_on).unwrap();
    assert!(again.cached && again.file == whole.file);

    // A damaged entry is told and baked again.
    let path = cache.path::<ModalFile>(request.key());
    let mut bytes = fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&path, bytes).unwrap();
    let mended = obtain(&request, Some(&cache), &mut go_on).unwrap();
    assert!(!mended.cached && mended.file == whole.file);
    assert!(mended.remarks[0].contains("it is baked again"), "{:?}", mended.remarks);
}

#[test]
fn a_body_without_modes_in_the_band_is_remembered_with_where_they_begin() {
    let folder = tempfile::tempdir().unwrap();
    let cache = ModelCache::new(folder.path());
    let request = request(9000.0);
    let silent = obtain(&request, Some(&cache), &mut go_on).unwrap();
    assert!(silent.file.modal.model.modes.is_empty());
    // The lowest of a ball is 2.501 c_s/(2πa), here 12 507 Hz.
    let first = silent.file.modal.origin.first_frequency.unwrap();
    assert!((first / 12_507.0 - 1.0).abs() < 0.1, "{first}");
    assert!(obtain(&request, Some(&cache), &mut go_on).unwrap().cached);
}

#[test]
fn keys_follow_whatever_modes_depend_on() {
    let options = ModalBakeOptions::new(Medium::AIR);
    let steel = presets::preset("steel").unwrap();
    let ball = |radius| BakeGeometry::Ellipsoid { semi_axes: DVec3::splat(radius) };
    let key = modal_key(&ball(0.01), Held::default(), &steel, &options);
    // Damping, friction and the name are none of it.
    let mut other_damping = presets::preset("brass").unwrap();
    other_damping.density = steel.density;
    other_damping.youngs_modulus = steel.youngs_modulus;
    other_damping.poisson_ratio = steel.poisson_ratio;
    assert_eq!(key, modal_key(&ball(0.01), Held::default(), &other_damping, &options));
    let heavier = Material { density: 8000.0, ..steel.clone() };
    let others = [
        modal_key(&ball(0.011), Held::default(), &steel, &options),
        modal_key(&ball(0.01), Held::default(), &heavier, &options),
        modal_key(&ball(0.01), Held::default(), &presets::preset("brass").unwrap(), &options),
        modal_key(&ball(0.01), Held::default(), &steel, &ModalBakeOptions { max_frequency: 1e4, ..options }),
        modal_key(&ball(0.01), Held::default(), &steel, &ModalBakeOptions { mesh_error: 0.02, ..options }),
        modal_key(&ball(0.01), Held::default(), &steel, &ModalBakeOptions { accuracy: 0.02, ..options }),
        modal_key(
            &ball(0.01),
            Held::default(),
            &steel,
            &ModalBakeOptions { medium: Medium::dry_air(0.0), ..options },
        ),
    ];
    for (at, other) in others.iter().enumerate() {
        assert_ne!(*other, key, "{at}");
        assert!(!others[..at].contains(other), "{at}");
    }
}
