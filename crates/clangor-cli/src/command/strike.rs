//! `clangor strike`: one impact to one body, heard by one listener.

use clangor_core::body::Surface;
use clangor_core::glam::DVec3;
use clangor_core::scene::render_description::Parts;
use clangor_core::synthesis::BodyModes;
use clangor_core::synthesis::strike::Striker;
use clangor_pipeline::analysis::levels::db_spl;
use clangor_pipeline::session::named_body::preset;
use clangor_pipeline::session::{Strike as Impact, StruckBody, check_sound_file};
use serde_json::json;

use super::dataset;
use super::session::StageBars;
use crate::arguments::{Global, Strike, StrikePart};
use crate::console::{Console, four_digits};
use crate::failure::Failure;

pub(crate) fn run(options: &Strike, global: &Global, console: &Console) -> Result<(), Failure> {
    if let Some(list) = &options.list {
        return dataset::run(list, options, global, console);
    }
    let Strike { body: Some(word), output: Some(output), .. } = options else {
        return Err(Failure::new("one impact needs a body and --output"));
    };
    // A long computation is not begun for a file that cannot be written.
    check_sound_file(output)?;
    let name = word.to_string_lossy();
    let material = options.material.as_deref().map(preset).transpose()?;
    let body = StruckBody::open(word, options.scale, material)?;
    body.remarks().iter().for_each(|remark| console.warn(remark));
    let is_sphere = matches!(*body.body().surface, Surface::Sphere { .. });
    let bars = StageBars::new(console);
    let sound = impact(body, options, global)?.render_with_progress(&mut |progress| bars.show(progress))?;
    bars.clear();
    sound.remarks.iter().for_each(|remark| console.warn(remark));
    if let Some(other @ (BodyModes::Proxy(_) | BodyModes::None(_))) = &sound.modal {
        console.say(format_args!("\"{name}\": {other}"));
    }
    if let Some(kind) = sound.acceleration.filter(|_| !is_sphere) {
        console.say(format_args!("\"{name}\" sounds as: {kind}"));
    }
    sound.write(output)?;
    let peak = sound.peak();
    if peak == 0.0 {
        let (file, travel) = (output.display(), sound.travel_time);
        if sound.times.last().is_none_or(|last| *last <= travel) {
            console.warn(format_args!(
                "{file} is silent: sound needs {travel:.4} s to the listener, so raise --seconds"
            ));
        } else {
            console.warn(format_args!(
                "{file} is silent: this impact has no sound in the direction of the listener, as across the \
                 push on a ball; give another --listener"
            ));
        }
    }
    if options.point.is_none() {
        // To 10 µm, without negative zeros.
        let DVec3 { x, y, z } = (1e5 * sound.point).round() / 1e5 + DVec3::ZERO;
        console.say(format_args!("struck at [{x:.5}, {y:.5}, {z:.5}] m from the centre of mass"));
    }
    console.say(format_args!(
        "{}: contact {:.2} µs, velocity change {:.4} m/s, peak {} Pa ({} dB SPL)",
        output.display(),
        sound.contact_duration * 1e6,
        sound.velocity_change.length(),
        four_digits(peak),
        db_spl(peak).map_or("−∞".into(), |db| format!("{db:.1}")),
    ));
    if sound.modal_energy_ratio > 1.0 {
        console.say(format_args!(
            "forces of rigid bodies would give the modes {:.1} times the energy of the approach; the contact \
             is solved",
            sound.modal_energy_ratio,
        ));
    }
    console.json(&json!({
        "point_m": sound.point.to_array(),
        "listener_m": sound.listener.to_array(),
        "impulse_n_s": sound.impulse.to_array(),
        "peak_force_n": sound.peak_force,
        "modal_energy_ratio": sound.modal_energy_ratio,
        "contact_duration_s": sound.contact_duration,
        "velocity_change_m_per_s": sound.velocity_change.to_array(),
        "equal_volume_radius_m": sound.radius,
        "peak_pa": peak,
        "modes": sound.modes,
        "samples": sound.pressures.len(),
    }));
    Ok(())
}

/// The impact that the command line describes.
fn impact(body: StruckBody, options: &Strike, global: &Global) -> Result<Impact, Failure> {
    let wants = |part| options.parts.contains(&part);
    let mut impact = Impact::new(body)
        .contact_steps(options.contact_steps)
        .sample_rate(options.sample_rate)
        .parts(Parts {
            acceleration: wants(StrikePart::Acceleration),
            modal: wants(StrikePart::Modal),
            ground: false,
        })
        .acceleration(options.sound.into())
        .models(options.models.on(options.device.device));
    if let Some(point) = options.point {
        impact = impact.at(point);
    }
    if let Some(listener) = options.listener {
        impact = impact.listener(listener);
    }
    if let Some(impulse) = options.impulse {
        impact = impact.impulse(impulse);
    }
    if let Some((material, radius)) = &options.striker {
        let ball = Striker::new(preset(material)?, *radius, options.speed);
        impact =
            impact.striker(Striker { normal: options.normal, heard: wants(StrikePart::Striker), ..ball });
    }
    if let Some(duration) = options.duration {
        impact = impact.contact_duration(duration);
    }
    if let Some(seconds) = options.seconds {
        impact = impact.seconds(seconds);
    }
    Ok(match &global.cache {
        Some(folder) => impact.cache(folder),
        None => impact,
    })
}
