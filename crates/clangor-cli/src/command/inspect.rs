//! `clangor inspect`: what is in a file.

mod animation;

use std::fmt::Display;
use std::path::Path;
use std::sync::Arc;

use clangor_bake::modal_analysis::modal_density::ModalDensity;
use clangor_core::body::{Motion, Surface};
use clangor_core::geometry::principal_axes::principal_axes;
use clangor_core::material::Material;
use clangor_core::scene::body_description::Geometry;
use clangor_pipeline::analysis::levels::{LevelMeter, db_spl};
use clangor_pipeline::formats::model_cache::ModelCache;
use clangor_pipeline::formats::timeline_file::TimelineReader;
use clangor_pipeline::formats::wav::{WavEncoding, WavReader};
use clangor_pipeline::session::named_body::preset;
use clangor_pipeline::stages::bake_costs::{Estimate, bake_costs};
use clangor_pipeline::stages::body_facts::{AUDIBLE, BodyFacts};
use clangor_pipeline::stages::load::{geometry_reference, load_geometry, load_mesh, size_warning};
use clangor_pipeline::stages::sound_models::{SoundFile, read_sound_file};
use clangor_sim::choose_solver;
use serde_json::{Value, json};

use super::bake::{modal_report, model_report, pan_report};
use super::cost::{FEW, cost_json, say_costs};
use super::{bank, is_timeline, load};
use crate::arguments::{Global, Inspect};
use crate::console::{Console, counted, four_digits};
use crate::failure::Failure;

pub(crate) fn run(options: &Inspect, global: &Global, console: &Console) -> Result<(), Failure> {
    let path = options.file.as_path();
    match path.extension().and_then(|e| e.to_str()) {
        Some("wav") => wav(path, console),
        Some("toml") => scene(path, global, console),
        Some("safetensors") => sound_file(path, console),
        _ if is_timeline(path) => timeline(path, console),
        // With a material, the file is one body of it.
        _ if options.material.is_some() => geometry(options, global, console),
        _ => match animation::read(path, options.scale) {
            Some(motion) => animation::report(path, &motion, console),
            None => geometry(options, global, console),
        },
    }
}

/// A sound model or a soundbank.
fn sound_file(path: &Path, console: &Console) -> Result<(), Failure> {
    match read_sound_file(path).map_err(Failure::new)? {
        SoundFile::Model(file) => {
            let bytes = std::fs::metadata(path).map_or(0, |m| m.len());
            model_report::say(console, path, &file, bytes);
            let mut result = model_report::json(path, &file, bytes);
            if let Some(part) = &file.modal {
                modal_report::say(console, part, true);
                result["modal"] = modal_report::json(part);
            }
            console.json(&result);
        }
        SoundFile::Modal(file) => {
            console.say(format_args!("{}: ringing of \"{}\"", path.display(), file.solid.name));
            modal_report::say(console, &file.modal, true);
            console.json(&json!({ "name": file.solid.name, "modal": modal_report::json(&file.modal) }));
        }
        SoundFile::Pan(file) => {
            pan_report::say(console, path, &file, std::fs::metadata(path).map_or(0, |m| m.len()));
        }
        SoundFile::Bank(file) => bank::report(console, path, &file),
        SoundFile::ModalSoundbank(file) => bank::report_modal(console, path, &file),
    }
    Ok(())
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
        "{}: {}, {} Hz, {seconds:.3} s, {}",
        path.display(),
        counted(info.channels.into(), "channel", "channels"),
        info.sample_rate,
        encoding(info.encoding)
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
            "channel {}: peak {} {unit}{} at {:.4} s, RMS {} {unit}{}",
            index + 1,
            four_digits(channel.peak),
            spl(channel.peak),
            channel.peak_frame as f64 / f64::from(info.sample_rate),
            four_digits(channel.rms),
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

fn encoding(encoding: WavEncoding) -> &'static str {
    match encoding {
        WavEncoding::Pcm16 => "16-bit PCM",
        WavEncoding::Pcm24 => "24-bit PCM",
        WavEncoding::Pcm32 => "32-bit PCM",
        WavEncoding::Float32 => "32-bit float",
        WavEncoding::Float64 => "64-bit float",
    }
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
        "{}, {} s, from {}{}, v_min {} m/s{}",
        counted(header.world.bodies.len(), "body", "bodies"),
        origin.duration,
        origin.solver,
        if origin.solver == "rigid" { format!(" (step {} s)", origin.time_step) } else { String::new() },
        origin.v_min,
        if origin.raw_log { ", raw log" } else { "" }
    ));
    console.say(format_args!(
        "{}, {}, fastest {loudest:.3} m/s; {}",
        counted(rows.contacts as usize, "contact row", "contact rows"),
        counted(impacts.len(), "impact", "impacts"),
        counted(rows.poses as usize, "pose row", "pose rows")
    ));
    if rows.forces > 0 {
        let forces = reader.forces_of(&impacts).map_err(Failure::new)?;
        let solved: std::collections::BTreeSet<u64> = forces.iter().map(|force| force.impact_id).collect();
        console.say(format_args!(
            "{} over time, of {}",
            counted(forces.len(), "force", "forces"),
            counted(solved.len(), "impact", "impacts")
        ));
    }
    if rows.fractures > 0 {
        let cracks: f64 = reader.fractures().iter().map(|fracture| fracture.crack_area).sum();
        console.say(format_args!(
            "{} into {}, along {:.3} cm² of cracks",
            counted(rows.fractures as usize, "fracture", "fractures"),
            counted(rows.births as usize, "piece", "pieces"),
            1e4 * cracks
        ));
    }
    console.json(&json!({
        "program": reader.program(),
        "bodies": reader.bodies().into_iter().map(|b| b.name).collect::<Vec<_>>(),
        "fractures": rows.fractures,
        "births": rows.births,
        "forces": rows.forces,
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

/// Bodies and listeners of a scene.
fn scene(path: &Path, global: &Global, console: &Console) -> Result<(), Failure> {
    let loaded = load(path, global, &|_| (), console)?;
    let (world, scene) = (&loaded.world, &loaded.scene);
    let solver = format!("{:?}", choose_solver(world, scene.simulation.solver)).to_lowercase();
    console.say(format_args!(
        "{}: {}, {}, {}, {} s, solver {solver}",
        path.display(),
        counted(world.bodies.len(), "body", "bodies"),
        counted(world.links.len(), "link", "links"),
        counted(scene.listeners.len(), "listener", "listeners"),
        scene.simulation.duration
    ));
    let mut said = Vec::new();
    for body in &world.bodies {
        let size = match *body.surface {
            Surface::HalfSpace => "plane".into(),
            Surface::Plate { thickness } => format!("endless plate, {} mm thick", 1e3 * thickness),
            Surface::Sphere { radius } => format!("sphere of radius {radius:.6} m"),
            Surface::Mesh(ref surface) => format!(
                "{} triangles, bounding radius {:.6} m",
                surface.mesh.triangles.len(),
                body.surface.bounding_radius()
            ),
        };
        let motion = match body.motion {
            Motion::Free => format!("{:.6e} kg", body.mass),
            Motion::Fixed => "fixed".into(),
            Motion::Keyframed(_) => "keyframed".into(),
            Motion::Guided(_) => format!("{:.6e} kg, guided by keyframes", body.mass),
        };
        let p = body.pose.position;
        console.say(format_args!(
            "body \"{}\": {size}, {}, {motion}, at [{:.4}, {:.4}, {:.4}] m",
            body.name, body.material.name, p.x, p.y, p.z
        ));
        // Copies of one form say the same.
        let described = said.contains(&(Arc::as_ptr(&body.surface).addr(), body.material.name.as_str()));
        if let Some(facts) = BodyFacts::of(&body.surface).filter(|_| !described) {
            console.say(format_args!("  {}, {}", sizes(&facts), modes(&facts, &body.material)));
            if body.motion.is_movable() {
                say_costs(&bake_costs(&body.surface, Some(&body.material), Estimate::Quick), console);
            }
            said.push((Arc::as_ptr(&body.surface).addr(), body.material.name.as_str()));
        }
    }
    for listener in &scene.listeners {
        let p = listener.track.sample(0.0).0.position;
        console.say(format_args!(
            "listener \"{}\": {}{}, at [{:.4}, {:.4}, {:.4}] m",
            listener.name,
            counted(listener.receivers().len(), "receiver", "receivers"),
            if listener.track.is_fixed() { "" } else { ", moving" },
            p.x,
            p.y,
            p.z
        ));
    }
    let bodies = world.bodies.iter().map(|body| {
        json!({
            "name": body.name,
            "material": body.material.name,
            "mass_kg": body.mass.is_finite().then_some(body.mass),
            "bounding_radius_m": Some(body.surface.bounding_radius()).filter(|r| r.is_finite()),
            "position_m": body.pose.position.to_array(),
            "moves_freely": body.motion.is_movable(),
            "body": BodyFacts::of(&body.surface).map(|facts| facts_json(&facts, Some(&body.material))),
        })
    });
    console.json(&json!({
        "bodies": bodies.collect::<Vec<_>>(),
        "links": world.links.len(),
        "listeners": scene.listeners.iter().map(|l| l.name.clone()).collect::<Vec<_>>(),
        "duration_s": scene.simulation.duration,
        "solver": solver,
    }));
    Ok(())
}

/// Size, mass properties and collision parts of a shape or a mesh file.
fn geometry(options: &Inspect, global: &Global, console: &Console) -> Result<(), Failure> {
    // A shape is text; the name of a mesh file need not be.
    let text = &*options.file.to_string_lossy();
    let material = options.material.as_deref().map(preset).transpose()?;
    let reference = geometry_reference(text, options.scale);
    if matches!(reference.geometry, Geometry::Shape(_)) {
        refuse_files_as_shapes(text)?;
    }
    let refuse = |e: &dyn Display| Failure::new(format_args!("\"{text}\" cannot be inspected: {e}"));
    let (loaded, parts) = match &reference.geometry {
        Geometry::Shape(_) => (load_geometry(Path::new(""), &reference).map_err(|e| refuse(&e))?, None),
        Geometry::File(_) => {
            let (loaded, mesh) = load_mesh(&options.file, reference.scale).map_err(|e| refuse(&e))?;
            let warnings = loaded.warnings.iter().cloned().chain(size_warning(&loaded.surface));
            warnings.for_each(|warning| console.warn(format_args!("\"{text}\": {warning}")));
            let cache = ModelCache::find(global.cache.as_deref());
            let found = mesh.parts(None, cache.as_ref()).map_err(|e| refuse(&e))?;
            found.remarks.iter().for_each(|remark| console.warn(remark));
            let error = mesh.surface_error(&found.decomposition);
            (loaded, Some((found.decomposition.parts.len(), error)))
        }
    };
    let triangles = match &*loaded.surface {
        Surface::Mesh(surface) => surface.mesh.triangles.len(),
        _ => 0,
    };
    let parts_error = parts.map(|(_, error)| error);
    let parts = match (&*loaded.surface, parts) {
        (_, Some((count, _))) => count,
        (Surface::Mesh(surface), None) => surface.parts.len(),
        _ => 1,
    };
    let (moments, _) = principal_axes(loaded.mass.inertia);
    let centre = loaded.mass.centre_of_mass;
    console.say(format_args!(
        "{text}: {}, {}{}, bounding radius {:.6} m",
        counted(triangles, "triangle", "triangles"),
        counted(parts, "convex part", "convex parts"),
        parts_error.map_or(String::new(), |error| format!(" within {error:.2e} m of the surface")),
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
    let facts = BodyFacts::of(&loaded.surface);
    if let Some(facts) = &facts {
        console.say(format_args!("{}", sizes(facts)));
        if let Some(material) = &material {
            let mass = material.density * loaded.mass.volume;
            console.say(format_args!("in {}: {mass:.6e} kg, {}", material.name, modes(facts, material)));
        }
    }
    let costs = bake_costs(&loaded.surface, material.as_ref(), Estimate::Planned);
    say_costs(&costs, console);
    console.json(&json!({
        "body": facts.map(|facts| facts_json(&facts, material.as_ref())),
        "bake_costs": costs.iter().map(cost_json).collect::<Vec<_>>(),
        "mass_kg": material.as_ref().map(|material| material.density * loaded.mass.volume),
        "triangles": triangles,
        "convex_parts": parts,
        "convex_parts_error_m": parts_error,
        "bounding_radius_m": loaded.surface.bounding_radius(),
        "equal_volume_radius_m": loaded.surface.equal_volume_radius(),
        "volume_m3": loaded.mass.volume,
        "centre_of_mass_m": centre.to_array(),
        "principal_moments_per_density_m5": moments.to_array(),
    }));
    Ok(())
}

/// A name with a separator or an ending is meant as a file; a shape has numbers there.
fn refuse_files_as_shapes(text: &str) -> Result<(), Failure> {
    let path = Path::new(text);
    let is_named_like_a_file =
        path.extension().is_some_and(|e| e.to_string_lossy().starts_with(char::is_alphabetic));
    if !path.exists() && !is_named_like_a_file {
        return Ok(());
    }
    let fault = if path.exists() { "is of no known kind" } else { "does not exist" };
    Err(Failure::new(format_args!(
        "{text} {fault}; inspect reads .toml, .timeline, .wav, .safetensors, .obj, .ply, .stl, .gltf, .glb, \
         and shapes such as mug"
    )))
}

/// Bounding box and wall of a body.
fn sizes(facts: &BodyFacts) -> String {
    let edges = facts.edges();
    format!(
        "{} × {} × {} m, surface {} m², mean wall 2V/A {} m",
        four_digits(edges.x),
        four_digits(edges.y),
        four_digits(edges.z),
        four_digits(facts.area),
        four_digits(facts.wall())
    )
}

/// Estimated number of modes that can be heard.
fn modes(facts: &BodyFacts, material: &Material) -> String {
    let (count, density) = facts.modes_below(AUDIBLE, material);
    let density = match density {
        ModalDensity::Plate => "a plate",
        ModalDensity::Solid => "a solid",
    };
    match count < FEW {
        true => format!(
            "few modes to 20 kHz: fewer than {FEW} by the density of {density}, which counts bars too low"
        ),
        false => format!("about {count:.0} modes to 20 kHz by the density of {density}"),
    }
}

fn facts_json(facts: &BodyFacts, material: Option<&Material>) -> Value {
    let estimate = material.map(|material| facts.modes_below(AUDIBLE, material));
    let density = estimate.map(|(_, density)| match density {
        ModalDensity::Plate => "plate",
        ModalDensity::Solid => "solid",
    });
    json!({
        "bounds_m": facts.bounds.map(|corner| corner.to_array()),
        "surface_m2": facts.area,
        "volume_m3": facts.volume,
        "mean_wall_m": facts.wall(),
        "estimated_modes_to_20_khz": estimate.map(|(count, _)| count),
        "modal_density": density,
    })
}
