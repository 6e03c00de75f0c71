//! One set of options for sound models: what a bake has put into the cache, a session and a strike by
//! the same options find there. Options that no model can be baked with are refused alike.

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;

use clangor_bake::acceleration::{BakeOptions, Method};
use clangor_bake::fdtd::WaveDevice;
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::modal::ModalBakeOptions;
use clangor_bake::modal::held_body::Held;
use clangor_core::glam::DVec3;
use clangor_core::material::presets;
use clangor_core::medium::Medium;
use clangor_core::scene::Scene;
use clangor_core::scene::render_description::Parts;
use clangor_core::sound_model::AccelerationRule;
use clangor_core::synthesis::{RenderSettings, SoundPart};
use clangor_pipeline::formats::model_cache::{modal_key, model_key};
use clangor_pipeline::session::{
    Bake, Error, NamedSolid, Progress, Session, Strike, StrikeRemark, StruckBody, StruckSound,
};
use clangor_pipeline::stages::load::scene_in_memory;
use clangor_pipeline::stages::sound_models::model_options::ModelOptionsError;
use clangor_pipeline::stages::sound_models::{ModelOptions, Quality};

/// A coin, whose field is exact, and a rod that is asked for a field of its own; both are struck.
const SCENE: &str = r#"version = 1
[simulation]
duration = 0.08
[[body]]
name = "coin"
shape = "coin"
material = "steel"
position = [0.0, 0.02, 0.0]
[[body]]
name = "rod"
shape = "box:0.12x0.012x0.008"
material = "aluminium"
acceleration = "own"
position = [0.4, 0.02, 0.0]
[[plane]]
name = "floor"
material = "granite"
[[listener]]
name = "ear"
position = [0.0, 0.5, 0.5]
"#;

fn go_on(_: &Progress<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn files(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Coarse, so that each is baked in a moment.
fn coarse() -> [ModelOptions; 4] {
    let plain = ModelOptions { max_frequency: Some(3000.1), accuracy: Some(0.05), ..ModelOptions::default() };
    [
        plain,
        ModelOptions { method: Method::Bem, ..plain },
        ModelOptions { accuracy: None, quality: Quality::Draft, ..plain },
        // Above the band of the sample rate, by which it is cut.
        ModelOptions { max_frequency: Some(3900.0), ..plain },
    ]
}

#[test]
fn property_a_session_finds_every_model_that_a_bake_of_its_scene_has_left() {
    for options in coarse() {
        let folder = tempfile::tempdir().unwrap();
        let mut scene = Scene::from_toml(SCENE).unwrap();
        scene.render.sample_rate = 8000;
        let loaded = scene_in_memory(scene.clone()).unwrap();
        let bake = Bake::new().models(options).cache(folder.path());
        let ahead = bake.scene(&loaded).unwrap();
        for field in ahead.fields() {
            assert!(!ahead.bake_field(field, &mut go_on).unwrap().cached);
        }
        let modes = ahead.bake_modes(&mut go_on).unwrap().unwrap();
        assert!(modes.remarks.is_empty(), "{:?}", modes.remarks);
        let left = files(folder.path());
        // Without patience the coin clicks as an ellipsoid.
        let drafted = options.quality == Quality::Draft;
        // The modes for the impacts of rod and coin, in a band of their own.
        let impacts = left.iter().filter(|name| name.ends_with(".partial")).count();
        let counts = (ahead.fields().len(), left.len() - impacts, impacts);
        assert_eq!(counts, if drafted { (1, 3, 2) } else { (2, 4, 2) });

        let session = Session::builder().models(options).cache(folder.path());
        let mut session = session.from_scene(scene).unwrap();
        let found = session.obtain_models().unwrap();
        assert!(found.remarks.is_empty(), "{:?}", found.remarks);
        let parts = |part| found.obtained.iter().filter(move |model| model.part == part && model.cached);
        assert_eq!(parts(SoundPart::Acceleration).count(), ahead.fields().len(), "{options:?}");
        assert_eq!(parts(SoundPart::Modal).count(), 2, "{options:?}");
        assert_eq!(found.obtained.len(), left.len() - impacts, "{options:?}");
        assert_eq!(files(folder.path()), left, "{options:?}");
    }
}

fn strike(options: ModelOptions, cache: &Path) -> Strike {
    let rod = StruckBody::shape("box:0.12x0.012x0.008", "aluminium").unwrap();
    // In no plane of symmetry of the field.
    let strike = Strike::new(rod).at([0.05, 0.006, 0.0]).listener([0.3, 0.8, 0.2]).seconds(0.05);
    strike.models(options).cache(cache).acceleration(AccelerationRule::Own)
}

#[test]
fn property_a_strike_finds_the_model_that_a_bake_of_its_body_has_left() {
    for options in coarse() {
        let folder = tempfile::tempdir().unwrap();
        let material = presets::preset("aluminium").unwrap();
        let rod = NamedSolid::open("box:0.12x0.012x0.008", 1.0, Some(material)).unwrap();
        let bake = Bake::new().models(options).cache(folder.path());
        assert!(!bake.body(&rod, &mut go_on).unwrap().cached);
        let left = files(folder.path());
        assert_eq!(left.len(), 2, "{left:?}");
        let sound = strike(options, folder.path()).render().unwrap();
        // Drafts are said, from the cache as well.
        let is_draft = |remark: &StrikeRemark| matches!(remark, StrikeRemark::Draft { .. });
        let drafts = if options.quality == Quality::Draft { 2 } else { 0 };
        assert_eq!(sound.remarks.len(), drafts, "{:?}", sound.remarks);
        assert!(sound.remarks.iter().all(is_draft), "{:?}", sound.remarks);
        assert_eq!(files(folder.path()), left, "{options:?}");
    }
}

/// Largest magnitude of the spectrum of a sound at a few frequencies \[Pa s\].
fn spectrum(sound: &StruckSound, frequencies: &[f64]) -> f64 {
    let magnitude = |hz: &f64| {
        let turned = |f: fn(f64) -> f64| -> f64 {
            let wave = |(p, t): (&f64, &f64)| p * f(std::f64::consts::TAU * hz * t);
            sound.pressures.iter().zip(&sound.times).map(wave).sum()
        };
        turned(f64::cos).hypot(turned(f64::sin)) / sound.sample_rate.as_f64()
    };
    frequencies.iter().map(magnitude).fold(0.0, f64::max)
}

#[test]
fn property_the_band_of_a_strike_is_that_of_its_model() {
    let folder = tempfile::tempdir().unwrap();
    let wide = ModelOptions { max_frequency: Some(8000.0), accuracy: Some(0.05), ..ModelOptions::default() };
    // Modes above the band are left out with what they add below it.
    let parts = Parts { modal: false, ..Parts::default() };
    let clicks = |options| strike(options, folder.path()).parts(parts).render().unwrap();
    let (wide, narrow) = (clicks(wide), clicks(coarse()[0]));
    // The band limit falls from 3 kHz to nothing at 6.2 kHz.
    let beyond: Vec<f64> = (66..80).map(|n| 100.0 * f64::from(n)).collect();
    let (kept, cut) = (spectrum(&wide, &beyond), spectrum(&narrow, &beyond));
    // Residual seen: 1.9e-4.
    assert!(kept > 0.0 && cut < 1e-3 * kept, "{cut:.1e} of {kept:.1e} Pa s");
    let within: Vec<f64> = (5..25).map(|n| 100.0 * f64::from(n)).collect();
    let ratio = spectrum(&narrow, &within) / spectrum(&wide, &within);
    // Residual seen: 8e-4; both are within 5 %.
    assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
}

#[test]
fn property_an_explicit_accuracy_replaces_the_errors_of_any_quality() {
    for quality in [Quality::Draft, Quality::Normal, Quality::High] {
        let options = ModelOptions { quality, accuracy: Some(0.07), ..ModelOptions::default() };
        let (fields, modes) = (options.acceleration(10.0), options.modal(Medium::AIR, 3000.0));
        let errors = [fields.options.accuracy, modes.mesh_error, modes.accuracy];
        assert_eq!(errors, [0.07; 3], "{quality:?}");
        // Drafts are what no exact model has patience for.
        assert_eq!(fields.patience == 0.0, quality == Quality::Draft);
    }
}

/// The keys of models that were baked before these options were shared.
#[test]
fn regression_default_options_find_the_models_of_older_caches() {
    let die = BakeGeometry::RoundedBox { edges: DVec3::new(0.03, 0.02, 0.01), round: 0.001 };
    let steel = presets::preset("steel").unwrap();
    let rendered = RenderSettings::default();
    let keys = |quality| {
        let options = ModelOptions { quality, ..ModelOptions::default() };
        [
            model_key(&die, &options.acceleration(rendered.max_wavenumber()).options),
            modal_key(&die, Held::default(), &steel, &options.modal(Medium::AIR, rendered.band().0)),
        ]
    };
    let before = |(field, mesh_error, transfer)| {
        let fields = BakeOptions { near_field: true, ..BakeOptions::new(rendered.max_wavenumber(), field) };
        let modes = ModalBakeOptions { mesh_error, accuracy: transfer, ..ModalBakeOptions::new(Medium::AIR) };
        [model_key(&die, &fields), modal_key(&die, Held::default(), &steel, &modes)]
    };
    assert_eq!(keys(Quality::Draft), before((0.01, 0.01, 0.01)));
    assert_eq!(keys(Quality::Normal), before((0.01, 0.01, 0.01)));
    assert_eq!(keys(Quality::High), before((0.002, 0.005, 0.002)));
    assert_eq!(keys(Quality::Normal), GOLDEN);
}

const GOLDEN: [&str; 2] = ["eca42364e36254e9281ed2c40ad55e30", "0d61c1f434595330197126e90be6cb00"];

#[test]
fn property_keys_follow_the_options_that_change_a_model() {
    let ball = BakeGeometry::Ellipsoid { semi_axes: DVec3::splat(0.01) };
    let key = |options: ModelOptions| model_key(&ball, &options.acceleration(100.0).options);
    let plain = ModelOptions::default();
    let others = [
        key(ModelOptions { method: Method::Bem, ..plain }),
        key(ModelOptions { method: Method::Fdtd, ..plain }),
        key(ModelOptions { accuracy: Some(0.02), ..plain }),
        key(ModelOptions { quality: Quality::High, ..plain }),
    ];
    for (at, other) in others.iter().enumerate() {
        assert!(*other != key(plain) && !others[..at].contains(other), "{at}");
    }
    // The same model, asked for in another way or computed elsewhere.
    assert_eq!(key(ModelOptions { accuracy: Some(0.01), ..plain }), key(plain));
    assert_eq!(key(ModelOptions { accuracy: Some(0.002), ..plain }), others[3]);
    assert_eq!(key(ModelOptions { device: WaveDevice::Gpu, ..plain }), key(plain));
}

#[test]
fn property_impossible_options_are_refused_alike_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Scene::from_toml(SCENE).unwrap();
    let loaded = scene_in_memory(scene.clone()).unwrap();
    let rod = NamedSolid::open("box:0.12x0.012x0.008", 1.0, None).unwrap();
    let refuse = |options: ModelOptions, wanted: &str, also_of_a_body: bool| {
        let bake = Bake::new().models(options).cache(folder.path());
        let mut refused = vec![
            Session::builder().models(options).from_scene(scene.clone()).err(),
            strike(options, folder.path()).render().err(),
            bake.scene(&loaded).err(),
        ];
        if also_of_a_body {
            refused.push(bake.body(&rod, &mut go_on).err());
        }
        for error in refused {
            let Some(Error::ModelOptions(error)) = error else { panic!("{error:?}") };
            assert_eq!(error.to_string(), wanted);
        }
    };
    let plain = ModelOptions::default();
    for accuracy in [0.0, -0.1, 0.6, f64::NAN, f64::INFINITY] {
        let wanted = format!("the accuracy {accuracy} is outside 0.000001 to 0.5");
        refuse(ModelOptions { accuracy: Some(accuracy), ..plain }, &wanted, true);
    }
    for hz in [99.0, 24_001.0, f64::NAN] {
        let wanted =
            format!("the highest frequency {hz} Hz is outside 100 Hz to half the sample rate, 24000 Hz");
        refuse(ModelOptions { max_frequency: Some(hz), ..plain }, &wanted, false);
    }
    // A body by itself has no sample rate: half of the highest there is bounds its band.
    let beyond = ModelOptions { max_frequency: Some(192_001.0), ..plain };
    let error = Bake::new().models(beyond).body(&rod, &mut go_on).unwrap_err();
    assert!(
        matches!(error, Error::ModelOptions(ModelOptionsError::MaxFrequency { nyquist: 192_000.0, .. })),
        "{error}"
    );
    assert_eq!(files(folder.path()), [""; 0]);
}
