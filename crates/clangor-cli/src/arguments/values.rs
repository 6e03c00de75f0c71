//! Values on the command line: what they may be, and what is said of others.

use std::path::PathBuf;

use clangor_core::glam::DVec3;
use clangor_core::medium::Medium;
use clangor_pipeline::dataset::Shard;
use clangor_pipeline::stages::sound_models::model_options::{
    ACCURACIES, HIGHEST_BAND_LIMIT, LOWEST_BAND_LIMIT,
};

pub(super) fn vector(text: &str) -> Result<DVec3, String> {
    let component = |n: &str| between(n.trim(), -1e5, 1e5, "");
    let numbers = text.split(',').map(component).collect::<Result<Vec<f64>, String>>()?;
    match numbers[..] {
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        _ => Err(format!("expected three numbers like 1.0,1.8,1.0, found {}", numbers.len())),
    }
}

pub(super) fn body_model(text: &str) -> Result<(String, PathBuf), String> {
    match text.split_once('=') {
        Some((body, file)) if !body.is_empty() && !file.is_empty() => Ok((body.into(), file.into())),
        _ => Err("expected BODY=MODEL.safetensors".into()),
    }
}

/// A ball: the name of a material and a radius \[m\].
pub(super) fn striker(text: &str) -> Result<(String, f64), String> {
    match text.rsplit_once(':') {
        Some((material, radius)) if !material.is_empty() => {
            Ok((material.into(), between(radius.trim(), 1e-5, 10.0, "m")?))
        }
        _ => Err("expected MATERIAL:RADIUS like steel:0.006".into()),
    }
}

/// A part of a data set: K/N.
pub(super) fn shard(text: &str) -> Result<Shard, String> {
    text.parse::<Shard>().map_err(|error| error.to_string())
}

pub(super) fn finite(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| format!("\"{text}\" is not a number"))?;
    if number.is_finite() { Ok(number) } else { Err(format!("{text} is not a finite number")) }
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    finite(text).and_then(|n| if n > 0.0 { Ok(n) } else { Err("must be greater than 0".into()) })
}

/// Speed of what strikes a body \[m/s\]: as in a scene, below that of sound in air.
pub(super) fn speed(text: &str) -> Result<f64, String> {
    let speed = positive(text)?;
    let fastest = Medium::AIR.sound_speed;
    if speed < fastest { Ok(speed) } else { Err(format!("must be below the speed of sound, {fastest} m/s")) }
}

/// Metres per unit of length.
pub(super) fn length_unit(text: &str) -> Result<f64, String> {
    between(text, 1e-6, 1e6, "m")
}

/// Seconds per unit of time, as a number or a fraction like 1/24.
pub(super) fn time_unit(text: &str) -> Result<f64, String> {
    let (above, below) = text.split_once('/').unwrap_or((text, "1"));
    let fraction = positive(above.trim())? / positive(below.trim())?;
    let is_within = (1e-9..=1e3).contains(&fraction);
    if is_within { Ok(fraction) } else { Err("must be from 1e-9 to 1e3 s".into()) }
}

/// The bounds of the scene format hold on the command line too.
fn between(text: &str, low: f64, high: f64, unit: &str) -> Result<f64, String> {
    finite(text).and_then(|n| match (low..=high).contains(&n) {
        true => Ok(n),
        false => Err(format!("must be from {low} to {high} {unit}").trim_end().into()),
    })
}

pub(super) fn duration(text: &str) -> Result<f64, String> {
    between(text, 0.001, 3600.0, "s")
}

pub(super) fn full_scale(text: &str) -> Result<f64, String> {
    between(text, 1e-9, 1e9, "Pa")
}

pub(super) fn level(text: &str) -> Result<f64, String> {
    between(text, -120.0, 0.0, "dBFS")
}

pub(super) fn instant(text: &str) -> Result<f64, String> {
    between(text, 0.0, 3600.0, "s")
}

pub(super) fn contact_duration(text: &str) -> Result<f64, String> {
    between(text, 1e-9, 1.0, "s")
}

pub(super) fn accuracy(text: &str) -> Result<f64, String> {
    between(text, *ACCURACIES.start(), *ACCURACIES.end(), "")
}

/// Seconds of CPU time; 0 for none, infinity for all.
pub(super) fn patience(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds >= 0.0 => Ok(seconds),
        _ => Err("must be a number of seconds from 0, or inf".into()),
    }
}

pub(super) fn band(text: &str) -> Result<f64, String> {
    between(text, LOWEST_BAND_LIMIT, HIGHEST_BAND_LIMIT, "Hz")
}

pub(super) fn wavenumber(text: &str) -> Result<f64, String> {
    between(text, 0.1, 100.0, "")
}
