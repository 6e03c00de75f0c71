//! `clangor strike`: one blow to one body, heard by one listener.

use std::path::Path;
use std::sync::Arc;

use clangor::body::{Body, Motion, Surface};
use clangor::contact::force_profile::ForceProfile;
use clangor::geometry::mass_properties::MassProperties;
use clangor::glam::DVec3;
use clangor::material::presets;
use clangor::medium::Medium;
use clangor::model::sphere_radiation::SphereModel;
use clangor::pose::Pose;
use clangor::scene::body_description::EDGE_RADIUS_RATIO;
use clangor::scene::instantiate::LoadedGeometry;
use clangor::synthesis::strike::{LEAD, Strike as Blow, strike};
use clangor::synthesis::{SampleRate, SoundSource};
use clangor_pipeline::atomic_file::write_atomically;
use clangor_pipeline::levels::db_spl;
use clangor_pipeline::load::{geometry_reference, load_geometry};
use clangor_pipeline::wav::{Meaning, SampleFormat, WavSpec, WavWriter};
use serde_json::json;

use crate::arguments::Strike;
use crate::console::{Console, four_digits};
use crate::failure::Failure;

pub(crate) fn run(options: &Strike, console: &Console) -> Result<(), Failure> {
    let body = body(options)?;
    let blow = Blow {
        impulse: options.impulse,
        point: options.point,
        listener: options.listener,
        duration: options.duration,
        profile: ForceProfile::HalfSine,
        sample_rate: SampleRate::try_new(options.sample_rate).map_err(Failure::new)?,
        seconds: Some(options.seconds),
        medium: Medium::AIR,
        sphere_model: SphereModel::Exact,
    };
    let source = SoundSource::equal_volume_sphere(&body.surface);
    let sound = strike(&body, &source, &blow).map_err(Failure::new)?;
    let peak = sound.pressures.iter().fold(0.0f64, |m, p| m.max(p.abs()));
    match options.output.extension().and_then(|e| e.to_str()) {
        Some("csv") => {
            let mut text = String::from("time_s,pressure_pa\n");
            for (time, pressure) in sound.times.iter().zip(&sound.pressures) {
                text.push_str(&format!("{time:.9e},{pressure:.9e}\n"));
            }
            write_atomically(&options.output, text.as_bytes()).map_err(Failure::new)?;
        }
        Some("wav") => {
            let spec = WavSpec {
                sample_rate: options.sample_rate,
                channels: 1,
                format: SampleFormat::Float32,
                full_scale: WavSpec::default_full_scale(SampleFormat::Float32),
                meaning: Meaning::Pressure,
                note: format!("{} of {}, begins {LEAD} s before the contact", options.body, options.material),
            };
            let samples: Vec<f32> = sound.pressures.iter().map(|p| *p as f32).collect();
            let mut file = WavWriter::create(&options.output, spec).map_err(Failure::new)?;
            file.write(&samples).map_err(Failure::new)?;
            file.finish().map_err(Failure::new)?;
        }
        _ => return Err(Failure::new("the output must end in .wav or .csv")),
    }
    if !matches!(*body.surface, Surface::Sphere { .. }) {
        console.warn(format_args!(
            "\"{}\" sounds as the sphere of equal volume, radius {:.4} mm",
            options.body,
            sound.radius * 1e3
        ));
    }
    if peak == 0.0 {
        console.warn(format_args!(
            "{} is silent: sound needs {:.4} s to the listener, so raise --seconds",
            options.output.display(),
            options.listener.length() / Medium::AIR.sound_speed
        ));
    }
    console.say(format_args!(
        "{}: contact {:.2} µs, velocity change {:.4} m/s, peak {} Pa ({} dB SPL)",
        options.output.display(),
        sound.duration * 1e6,
        sound.velocity_change.length(),
        four_digits(peak),
        db_spl(peak).map_or("−∞".into(), |db| format!("{db:.1}")),
    ));
    console.json(&json!({
        "contact_duration_s": sound.duration,
        "velocity_change_m_per_s": sound.velocity_change.to_array(),
        "radius_m": sound.radius,
        "peak_pa": peak,
        "samples": sound.pressures.len(),
    }));
    Ok(())
}

/// The struck body: a shape or a mesh file, at rest at the origin.
fn body(options: &Strike) -> Result<Body, Failure> {
    let material = presets::preset(&options.material).ok_or_else(|| {
        let known = presets::names().collect::<Vec<_>>().join(", ");
        Failure::new(format_args!("there is no material \"{}\"; known: {known}", options.material))
    })?;
    let reference = geometry_reference(&options.body, options.scale);
    let LoadedGeometry { surface, mass, .. } = load_geometry(Path::new(""), &reference)
        .map_err(|e| Failure::new(format_args!("\"{}\" cannot be used: {e}", options.body)))?;
    let MassProperties { volume, inertia, .. } = mass;
    Ok(Body {
        name: options.body.clone(),
        mass: material.density * volume,
        inertia: inertia * material.density,
        edge_radius: EDGE_RADIUS_RATIO * surface.bounding_radius(),
        material,
        surface: Arc::clone(&surface),
        pose: Pose::IDENTITY,
        velocity: DVec3::ZERO,
        angular_velocity: DVec3::ZERO,
        motion: Motion::Free,
    })
}
