//! The whole path, from the text of a scene to a WAV file, against free fall, Hertz and the exact field.

use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::path::Path;

use clangor_core::contact::ContactSettings;
use clangor_core::contact::hertz_pulse::DURATION_OVER_APPROACH_TIME;
use clangor_core::glam::DVec3;
use clangor_core::scene::render_description::{GroundSound, Parts};
use clangor_core::synthesis::SoundModel;
use clangor_core::synthesis::{Listener, RenderSettings, SoundSource};

use super::compliant_contact::zener_course;
use super::radiation::exact_spectrum;
use super::{Check, Extent, Fault, Outcome, Validation};
use crate::formats::wav::{SampleFormat, WavReader};
use crate::stages::load::scene_from_text;
use crate::stages::render::{FullScale, RenderOptions, Transfers, render};
use crate::stages::simulate::simulate_impacts;

const SCENE: &str = r#"
version = 1
gravity = [0.0, -9.81, 0.0]
[material.hard]
density = 7850.0
youngs_modulus = 200e9
poisson_ratio = 0.29
restitution = 0.7
friction = 0.0
rolling_loss = 0.0
loss_factor = 0.001
[[body]]
name = "ball"
shape = "sphere:0.0075"
material = "hard"
position = [0.0, 1.0075, 0.0]
[[plane]]
name = "floor"
material = "hard"
[[listener]]
name = "ear"
position = [0.3, 0.4, 0.2]
[simulation]
duration = 0.6
"#;

pub(super) fn run(_extent: Extent, table: &mut Validation) -> Outcome {
    let samples = first_click()?;
    let (radius, density, modulus, poisson) = (0.0075_f64, 7850.0_f64, 200e9_f64, 0.29_f64);
    let speed = (2.0_f64 * 9.81).sqrt();
    let mass = density * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let stiffness = 0.5 * modulus / (1.0 - poisson * poisson);
    // Hertz: 4/5 B(2/5, 1/2) (15/16)^{2/5}.
    let duration = 2.868_265_699_2 * (mass * mass / (radius * stiffness * stiffness * speed)).powf(0.2);
    let listener = DVec3::new(0.3, 0.4 - radius, 0.2);
    // Hertz's force without loss, in steps of the contact; it changes the velocity by twice its unit.
    let unit_step = 1e-3;
    let (_, forces) = zener_course(0.0, unit_step);
    let step = duration / (1.25_f64.powf(0.4) * DURATION_OVER_APPROACH_TIME) * unit_step;
    let (mut error, mut norm) = (0.0, 0.0);
    for k in 0..200 {
        let omega = TAU * (100.0 + 19_900.0 * f64::from(k) / 199.0);
        let (mut re, mut im) = (0.0, 0.0);
        for (i, pressure) in samples.iter().enumerate() {
            let (sin, cos) = (omega * i as f64 / 48_000.0).sin_cos();
            re += f64::from(*pressure) * cos / 48_000.0;
            im -= f64::from(*pressure) * sin / 48_000.0;
        }
        let mut pulse = (0.0, 0.0);
        for (i, force) in forces.iter().enumerate() {
            let (sin, cos) = (omega * step * i as f64).sin_cos();
            pulse.0 += 0.5 * unit_step * force * cos;
            pulse.1 -= 0.5 * unit_step * force * sin;
        }
        let (a, b) = exact_spectrum(omega, radius, pulse, listener);
        // The impact comes when free fall ends, and turns v into −0.7 v.
        let (sin, cos) = (omega * speed / 9.81).sin_cos();
        let exact = ((a * cos + b * sin) * 1.7 * speed, (b * cos - a * sin) * 1.7 * speed);
        error += (re - exact.0).powi(2) + (im - exact.1).powi(2);
        norm += exact.0.powi(2) + exact.1.powi(2);
    }
    table.checks.push(Check {
        section: "From scene to WAV",
        quantity: "steel ball dropped 1 m, e = 0.7: spectrum of the first click in the file, 100 Hz–20 kHz"
            .into(),
        reference: "free fall, Hertz, h₁⁽²⁾ (relative L2)",
        error: f64::sqrt(error / norm),
        bar: 1e-4,
        unit: "",
    });
    Ok(())
}

/// Samples [Pa] of the file that holds the first click.
fn first_click() -> Result<Vec<f32>, Fault> {
    let loaded = scene_from_text(Path::new("validation.toml"), SCENE.into(), &|_| ())?;
    let go_on = |_: f64| ControlFlow::Continue(());
    let (timeline, _) = simulate_impacts(&loaded, &BTreeSet::new(), &mut { go_on })?;
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("drop.wav");
    let options = RenderOptions {
        listeners: vec![Listener::fixed("ear", DVec3::new(0.3, 0.4, 0.2))],
        contact: ContactSettings::default(),
        synthesis: RenderSettings::default(),
        parts: Parts { acceleration: true, modal: false, ground: false },
        transfers: Transfers::Baked,
        rolling: None,
        ground: GroundSound::None,
        inherit_vibration: true,
        to: 0.6,
        format: SampleFormat::Float32,
        full_scale: FullScale::Pascals(1.0),
        compressor: None,
        stems: false,
        note: String::new(),
    };
    let sources = SoundSource::spheres(&loaded.world.bodies);
    let bodies = &loaded.world.bodies;
    let models: Vec<SoundModel> = sources.into_iter().map(SoundModel::without_modes).collect();
    render(bodies, &models, &timeline, &options, &file, &mut { go_on })?;
    let mut reader = WavReader::open(&file)?;
    let mut samples = Vec::new();
    while reader.read(&mut samples, 1 << 16)? > 0 {}
    Ok(samples)
}
