//! `clangor inspect`: what is in a file.

use std::path::Path;

use clangor::body::Surface;
use clangor::geometry::principal_axes::principal_axes;
use clangor_pipeline::levels::{LevelMeter, db_spl};
use clangor_pipeline::load::{geometry_reference, load_geometry};
use clangor_pipeline::timeline_file::TimelineReader;
use clangor_pipeline::wav::WavReader;
use serde_json::json;

use super::is_timeline;
use crate::arguments::Inspect;
use crate::console::Console;
use crate::failure::Failure;

pub(crate) fn run(options: &Inspect, console: &Console) -> Result<(), Failure> {
    let path = Path::new(&options.file);
    match path.extension().and_then(|e| e.to_str()) {
        Some("wav") => wav(path, console),
        Some("toml") => Err(Failure::new(format_args!("{} is a scene: use `clangor check`", path.display()))),
        _ if is_timeline(path) => timeline(path, console),
        _ => geometry(&options.file, console),
    }
}

/// Frames of a WAV file read at once.
const FRAMES_AT_ONCE: usize = 1 << 16;

/// Format and levels of a WAV file.
fn wav(path: &Path, console: &Console) -> Result<(), Failure> {
    let mut reader = WavReader::open(path).map_err(Failure::new)?;
    let info = reader.info().clone();
    // A foreign file does not say what its samples mean: they are then told as fractions of full scale.
    let full_scale = info.full_scale.unwrap_or(1.0);
    let mut meter = LevelMeter::new(info.channels, info.sample_rate, full_scale);
    let mut samples = Vec::new();
    while reader.read(&mut samples, FRAMES_AT_ONCE).map_err(Failure::new)? > 0 {
        samples.iter_mut().for_each(|s| *s = (f64::from(*s) * full_scale) as f32);
        meter.add(&samples);
        samples.clear();
    }
    let levels = meter.levels();
    let seconds = info.duration();
    let unit = if info.full_scale.is_some() { "Pa" } else { "of full scale" };
    console.say(format_args!(
        "{}: {} channels, {} Hz, {seconds:.3} s, {:?}",
        path.display(),
        info.channels,
        info.sample_rate,
        info.encoding
    ));
    if let Some(comment) = &info.comment {
        console.say(format_args!("comment: {comment}"));
    }
    for (index, channel) in levels.channels.iter().enumerate() {
        let spl = |p: f64| match (info.full_scale, db_spl(p)) {
            (Some(_), Some(db)) => format!(" ({db:.1} dB SPL)"),
            _ => String::new(),
        };
        console.say(format_args!(
            "channel {}: peak {:.4e} {unit}{} at {:.4} s, RMS {:.4e} {unit}{}",
            index + 1,
            channel.peak,
            spl(channel.peak),
            channel.peak_frame as f64 / f64::from(info.sample_rate),
            channel.rms,
            spl(channel.rms)
        ));
    }
    if let Some(loudness) = levels.loudness {
        console.say(format_args!("loudness {loudness:.1} LUFS"));
    }
    console.json(&json!({
        "channels": info.channels,
        "sample_rate_hz": info.sample_rate,
        "frames": info.frames,
        "full_scale_pa": info.full_scale,
        "comment": info.comment,
        "peak": levels.channels.iter().map(|c| c.peak).collect::<Vec<_>>(),
        "rms": levels.channels.iter().map(|c| c.rms).collect::<Vec<_>>(),
        "loudness_lufs": levels.loudness,
    }));
    Ok(())
}

/// Bodies and rows of a timeline.
fn timeline(path: &Path, console: &Console) -> Result<(), Failure> {
    let reader = TimelineReader::open(path).map_err(Failure::new)?;
    let (header, rows, origin) = (reader.header(), reader.rows(), &reader.header().origin);
    // Reads every row once: a truncated or damaged table is found here.
    let mut impacts = std::collections::BTreeSet::new();
    let mut loudest = 0.0f64;
    for row in reader.contacts().map_err(Failure::new)? {
        let row = row.map_err(Failure::new)?;
        if row.impact_id != 0 {
            impacts.insert(row.impact_id);
            loudest = loudest.max(row.approach_speed());
        }
    }
    for row in reader.poses().map_err(Failure::new)? {
        row.map_err(Failure::new)?;
    }
    console.say(format_args!("{}: written by {}", path.display(), reader.program()));
    console.say(format_args!(
        "{} bodies, {} s, solver {} (step {} s), v_min {} m/s{}",
        header.world.bodies.len(),
        origin.duration,
        origin.solver,
        origin.time_step,
        origin.v_min,
        if origin.raw_log { ", raw log" } else { "" }
    ));
    console.say(format_args!(
        "{} contact rows, {} impacts, fastest {loudest:.3} m/s; {} pose rows",
        rows.contacts,
        impacts.len(),
        rows.poses
    ));
    console.json(&json!({
        "program": reader.program(),
        "bodies": header.world.bodies.iter().map(|b| b.name.clone()).collect::<Vec<_>>(),
        "duration_s": origin.duration,
        "solver": origin.solver,
        "time_step_s": origin.time_step,
        "v_min_m_per_s": origin.v_min,
        "contact_rows": rows.contacts,
        "impacts": impacts.len(),
        "pose_rows": rows.poses,
        "fastest_impact_m_per_s": loudest,
    }));
    Ok(())
}

/// Size, mass properties and collision parts of a shape or a mesh file.
fn geometry(text: &str, console: &Console) -> Result<(), Failure> {
    let loaded = load_geometry(Path::new(""), &geometry_reference(text, 1.0))
        .map_err(|e| Failure::new(format_args!("\"{text}\" cannot be inspected: {e}")))?;
    loaded.warnings.iter().for_each(|w| console.warn(w));
    let (triangles, parts) = match &*loaded.surface {
        Surface::Mesh(surface) => (surface.mesh.triangles.len(), surface.parts.len()),
        _ => (0, 1),
    };
    let (moments, _) = principal_axes(loaded.mass.inertia);
    let centre = loaded.mass.centre_of_mass;
    console.say(format_args!(
        "{text}: {triangles} triangles, {parts} convex parts, bounding radius {:.6} m",
        loaded.surface.bounding_radius()
    ));
    console.say(format_args!(
        "volume {:.6e} m³ (sphere of equal volume: radius {:.6} m), centre of mass [{:.6}, {:.6}, {:.6}] m",
        loaded.mass.volume,
        loaded.surface.equal_volume_radius(),
        centre.x,
        centre.y,
        centre.z
    ));
    console.say(format_args!(
        "principal moments of inertia per density [{:.6e}, {:.6e}, {:.6e}] m⁵",
        moments.x, moments.y, moments.z
    ));
    console.json(&json!({
        "triangles": triangles,
        "convex_parts": parts,
        "bounding_radius_m": loaded.surface.bounding_radius(),
        "equal_volume_radius_m": loaded.surface.equal_volume_radius(),
        "volume_m3": loaded.mass.volume,
        "centre_of_mass_m": centre.to_array(),
        "principal_moments_per_density_m5": moments.to_array(),
    }));
    Ok(())
}
