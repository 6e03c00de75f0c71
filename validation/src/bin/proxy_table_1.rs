//! \[PROXY\] Table 1: size and time of synthesis of the published representations and of ours, on the papers'
//! models.
//!
//! `cargo run --release -p clangor-validation --bin proxy_table_1 [-- NAME …]`
//!
//! The published representation is fitted to our field of the same body, baked to where the spectrum of the
//! pulse of \[PAN\] Table 1 ends, 0.8/h: 40 × 80 directions, two terms, ε = 0.04. Its time is that of one
//! contact times the number of sounding bodies in the scene of \[PAN\] Table 2; ours is that of the whole
//! rendering (`pan_table_2`). All times are CPU time.

use std::ops::ControlFlow;

use clangor_bake::acceleration::BakeOptions;
use clangor_bake::reference::{FieldSampler, Fit, PanOptions, fit};
use clangor_core::medium::Medium;
use clangor_core::reference::pan_representation::directions::Directions;
use clangor_core::reference::pan_representation::{HeardContact, PanModel};
use clangor_core::shape::Shape;
use clangor_core::sound_model::AccelerationRule;
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use clangor_pipeline::formats::soundbank::default_bank;
use clangor_pipeline::stages::sound_models::{AccelerationBake, SoundModelRequest, obtain};

use clangor_validation::cpu_time::cpu_time;
use clangor_validation::paper_scene::{Group, Stage, Uniform, cache};

/// A model of the table.
struct Model {
    name: &'static str,
    shape: &'static str,
    material: &'static str,
    /// h \[s\], duration \[s\] and number of samples of a signal; none for a body that is not baked to 0.8/h.
    pulse: Option<(f64, f64, usize)>,
    /// Band of our field in the scene \[Hz\].
    band: f64,
    /// The scene: seconds, impulses, with or without a table.
    scene: Option<(f64, usize, bool)>,
    /// Megabytes and seconds, \[PAN\] and \[PROXY\].
    printed: &'static str,
}

const MODELS: [Model; 5] = [
    Model {
        name: "plate",
        shape: "plate",
        material: "ceramic",
        pulse: Some((27.358e-6, 5e-3, 512)),
        band: 20e3,
        scene: Some((5.0, 1_303, false)),
        printed: "108 → 12 MB, 3.72 → 2.02 s",
    },
    Model {
        name: "mug",
        shape: "mug",
        material: "ceramic",
        pulse: None,
        band: 6e3,
        scene: Some((5.0, 319, false)),
        printed: "1131 → 76 MB, 10.33 → 3.42 s",
    },
    Model {
        name: "dice",
        shape: "die:0.015x0.0005",
        material: "plastic",
        pulse: Some((14.898e-6, 1e-3, 256)),
        band: 20e3,
        scene: Some((5.0, 683, true)),
        printed: "35 → 6.9 MB, 0.40 → 0.19 s",
    },
    Model {
        name: "rounded dice",
        shape: "die",
        material: "plastic",
        pulse: Some((17.469e-6, 1e-3, 256)),
        band: 20e3,
        scene: None,
        printed: "35 → 6.1 MB",
    },
    Model {
        name: "coin",
        shape: "coin",
        material: "copper",
        pulse: Some((4.8333e-6, 2e-3, 1024)),
        band: 20e3,
        scene: Some((8.0, 22_959, false)),
        printed: "35 → 9.3 MB, 16.00 → 7.70 s",
    },
];

fn request(model: &Model, frequency: f64) -> SoundModelRequest<AccelerationBake> {
    let (surface, mass) = Shape::parse(model.shape).expect("a shape").surface().expect("a solid");
    let options = BakeOptions::new(std::f64::consts::TAU * frequency / Medium::AIR.sound_speed, 1e-2);
    SoundModelRequest::new(model.shape, &surface, mass, AccelerationBake(options)).expect("a body that moves")
}

/// Bytes of the published representation, and CPU time of a contact \[s\].
fn published(model: &Model, (pulse, lasting, length): (f64, f64, usize)) -> (usize, f64) {
    // Baked field, and the published representation fitted to it.
    let wanted = request(model, 0.8 / pulse);
    let baked = obtain(&wanted, Some(&cache()), &mut |_| ControlFlow::Continue(())).expect("a field").file;
    let unit = baked.acceleration.radius / Medium::AIR.sound_speed;
    let options = PanOptions {
        pulse: pulse / unit,
        step: lasting / length as f64 / unit,
        length,
        terms: 2,
        radii: 5,
        directions: Directions::Angles { rows: 40, columns: 80 },
        fit: Fit::Wavelets { tolerance: 0.04 },
    };
    let sampler = FieldSampler::new(&baked.acceleration.field, &options.wavenumbers());
    let field = fit(&options, &|x| sampler.spectra(x)).expect("options that make sense");
    let bytes = field.bytes();
    let playable = PanModel::new(baked.acceleration.radius, vec![field]).expect("a field");
    // Time of random contacts.
    let mut uniform = Uniform(5);
    let contacts = 400;
    let begin = cpu_time();
    for i in 0..contacts {
        let contact = HeardContact {
            peak: std::array::from_fn::<_, RIGID_DOFS, _>(|_| uniform.sample() - 0.5),
            onset: 1e-3 * f64::from(i),
            duration: 5.0 * pulse,
            listener: uniform.direction() * 1.5,
        };
        std::hint::black_box(playable.render(&contact, &Medium::AIR, 48_000.0).is_ok());
    }
    (bytes, (cpu_time() - begin) / f64::from(contacts))
}

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bank = default_bank();
    println!("| model | printed, PAN → PROXY | ours, published form | its time | ours | its time |");
    println!("|---|---|---|---|---|---|");
    for model in MODELS.iter().filter(|m| wanted.is_empty() || wanted.iter().any(|w| w == m.name)) {
        // Size of the multipole model, and time of the scene.
        let ours = obtain(&request(model, model.band), Some(&cache()), &mut |_| ControlFlow::Continue(()));
        let size = ours.expect("a field").file.encode().expect("a sound model").len();
        let rendered = model.scene.map(|(seconds, impulses, table)| {
            let count = if table { 10 } else { 50 };
            let rule = AccelerationRule::Own;
            let stage =
                Stage::new(&[Group { shape: model.shape, material: model.material, count, rule }], table);
            let models = stage.models(model.band, &cache(), bank.as_ref());
            let timeline = stage.timeline(impulses, seconds);
            stage.render(&models, &timeline, seconds, &folder.path().join("scene.wav"))
        });
        let (bytes, time) = match model.pulse.map(|pulse| published(model, pulse)) {
            Some((bytes, each)) => {
                let time = rendered.as_ref().map(|r| format!("{:.2} s", each * r.clicks as f64));
                (format!("{:.2} MB", 1e-6 * bytes as f64), time.unwrap_or_default())
            }
            None => (String::new(), String::new()),
        };
        println!(
            "| {} | {} | {bytes} | {time} | {:.0} kB | {} |",
            model.name,
            model.printed,
            1e-3 * size as f64,
            rendered.map(|r| format!("{:.2} s", r.seconds)).unwrap_or_default()
        );
    }
}
