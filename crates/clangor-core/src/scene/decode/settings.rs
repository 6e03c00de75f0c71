//! The sections `[medium]`, `[simulation]` and `[render]`.

use super::reader::{Decoder, Quantity, Section};
use super::room::room;
use crate::acoustics::Acoustics;
use crate::contact::ForceProfile;
use crate::medium::Medium;
use crate::propagation::{Air, Floor, ReflectingPlanes};
use crate::quantity;
use crate::scene::diagnostic::{Doubt, Problem};
use crate::scene::render_description::{
    Compressor, GroundSound, Level, Parts, RenderDescription, SampleFormat,
};
use crate::scene::simulation_description::{ContactModel, SimulationDescription, SolverChoice};
use crate::sound_model::acceleration::sphere_radiation::SphereModel;
use crate::sound_model::rule::AccelerationRule;
use crate::sound_model::rule::ModalRule;

pub(super) const MEDIUM_KEYS: &[&str] = &["density", "sound_speed", "temperature", "humidity"];

/// The fluid, and the state of the air if the fluid is air.
pub(super) fn medium(d: &mut Decoder<'_>, top: &Section<'_>) -> (Medium, Air) {
    let Some(section) = top.get("medium").and_then(|node| node.section(d, MEDIUM_KEYS)) else {
        return (Medium::AIR, Air::default());
    };
    let density = section.number(d, "density", quantity::MEDIUM_DENSITY);
    let sound_speed = section.number(d, "sound_speed", quantity::SOUND_SPEED);
    let temperature = section.number(d, "temperature", Quantity::between(-100.0, 200.0, "°C"));
    let humidity = section.number(d, "humidity", Quantity::between(0.0, 1.0, ""));
    let air = Air {
        celsius: temperature.unwrap_or(Air::default().celsius),
        humidity: humidity.unwrap_or(Air::default().humidity),
        ..Air::default()
    };
    let exclusive = "`density` and `sound_speed`, which it sets";
    if section.has("density") {
        section.exclude(d, "temperature", "density", exclusive);
    } else {
        section.exclude(d, "temperature", "sound_speed", exclusive);
    }
    if let Some(temperature) = temperature {
        return (Medium::dry_air(temperature), air);
    }
    let medium = Medium {
        density: density.unwrap_or(Medium::AIR.density),
        sound_speed: sound_speed.unwrap_or(Medium::AIR.sound_speed),
    };
    (medium, air)
}

pub(super) const SIMULATION_KEYS: &[&str] =
    &["solver", "contact", "duration", "time_step", "v_min", "pose_rate", "seed", "sleep"];

pub(super) fn simulation(d: &mut Decoder<'_>, top: &Section<'_>) -> SimulationDescription {
    let default = SimulationDescription::default();
    let Some(section) = top.get("simulation").and_then(|node| node.section(d, SIMULATION_KEYS)) else {
        return default;
    };
    let solvers =
        [("auto", SolverChoice::Auto), ("spheres", SolverChoice::Spheres), ("rigid", SolverChoice::Rigid)];
    let contacts = [("compliant", ContactModel::Compliant), ("rigid", ContactModel::Rigid)];
    let settings = SimulationDescription {
        solver: section.choice(d, "solver", &solvers).unwrap_or(default.solver),
        contact: section.choice(d, "contact", &contacts).unwrap_or(default.contact),
        duration: section.number(d, "duration", quantity::DURATION).unwrap_or(default.duration),
        time_step: section.number(d, "time_step", quantity::TIME_STEP).unwrap_or(default.time_step),
        v_min: section.number(d, "v_min", quantity::V_MIN).unwrap_or(default.v_min),
        pose_rate: section.number(d, "pose_rate", quantity::POSE_RATE).unwrap_or(default.pose_rate),
        seed: section.integer(d, "seed", 0, i64::MAX).map_or(default.seed, |seed| seed as u64),
        sleep: section.boolean(d, "sleep").unwrap_or(default.sleep),
    };
    // Above a millisecond, a falling body moves by its own thickness in a step.
    if settings.time_step > 1e-3
        && let Some(node) = section.get("time_step")
    {
        let value = settings.time_step;
        d.warn(
            node.place(d),
            Doubt::Unusual { what: "a time step", value, unit: "s", usual: "0.000025 to 0.001" },
        );
    }
    settings
}

pub(super) const RENDER_KEYS: &[&str] = &[
    "sample_rate",
    "bits",
    "full_scale",
    "normalize",
    "floor",
    "floor_height",
    "reflection_order",
    "air_absorption",
    "pulse",
    "contact_steps",
    "parts",
    "ground",
    "proxy_frequency",
    "limit_energy",
    "inherit_vibration",
    "rolling",
    "acceleration",
    "radiation",
    "chain_onset",
    "max_frequency",
    "compressor",
];
/// Names of the acceleration models of a body.
pub(super) const SOUNDS: &[(&str, AccelerationRule)] = &[
    ("auto", AccelerationRule::Auto),
    ("own", AccelerationRule::Own),
    ("proxy", AccelerationRule::Proxy),
    ("nearest-proxy", AccelerationRule::NearestProxy),
    ("sphere", AccelerationRule::Sphere),
];
/// Names of the modal models of a body.
pub(super) const RINGING: &[(&str, ModalRule)] = &[
    ("auto", ModalRule::Auto),
    ("own", ModalRule::Own),
    ("proxy", ModalRule::Proxy),
    ("none", ModalRule::Never),
];
pub(super) const COMPRESSOR_KEYS: &[&str] = &["threshold_db", "ratio", "attack", "release", "makeup_db"];

/// The section `[render]`, and the acoustics described by it and `[room]`; [`planes`](super::plane) adds
/// those that reflect.
pub(super) fn render(
    d: &mut Decoder<'_>,
    top: &Section<'_>,
    (medium, air): (Medium, Air),
) -> (RenderDescription, Acoustics) {
    let default = RenderDescription::default();
    let room = room(d, top);
    let Some(section) = top.get("render").and_then(|node| node.section(d, RENDER_KEYS)) else {
        return (default, Acoustics { medium, room, ..Acoustics::default() });
    };
    let sample_rate =
        section.integer(d, "sample_rate", 8000, 384_000).map_or(default.sample_rate, |rate| rate as u32);
    let nyquist = f64::from(sample_rate) / 2.0;
    if sample_rate < 44_100
        && let Some(node) = section.get("sample_rate")
    {
        d.warn(node.place(d), Doubt::CutBand { nyquist });
    }
    let formats = [("32f", SampleFormat::Float32), ("24", SampleFormat::Int24)];
    let pulses = [
        ("hertz", ForceProfile::Hertz),
        ("half-sine", ForceProfile::HalfSine),
        ("gaussian", ForceProfile::Gaussian),
    ];
    let radiations = [("exact", SphereModel::Exact), ("compact", SphereModel::CompactDipole)];
    let grounds =
        [("half-space", GroundSound::HalfSpace), ("slab", GroundSound::Slab), ("none", GroundSound::None)];
    let acoustics = Acoustics {
        medium,
        air: section.boolean(d, "air_absorption").unwrap_or(false).then_some(air),
        room,
        floor: floor(d, &section, room.is_some()),
        planes: ReflectingPlanes::default(),
        max_frequency: section.number(d, "max_frequency", Quantity::between(100.0, nyquist, "Hz")),
    };
    if let Some(node) = section.get("limit_energy") {
        let _ = section.boolean(d, "limit_energy");
        d.warn(node.place(d), Doubt::WithoutEffect { key: "limit_energy" });
    }
    let render = RenderDescription {
        sample_rate,
        bits: section.choice(d, "bits", &formats).unwrap_or(default.bits),
        level: level(d, &section),
        pulse: section.choice(d, "pulse", &pulses).unwrap_or(default.pulse),
        contact_steps: section
            .integer(d, "contact_steps", 2, 256)
            .map_or(default.contact_steps, |steps| steps as u32),
        parts: parts(d, &section).unwrap_or(default.parts),
        ground: section.choice(d, "ground", &grounds).unwrap_or(default.ground),
        proxy_frequency: section
            .number(d, "proxy_frequency", Quantity::between(0.0, 1e6, "Hz"))
            .unwrap_or(default.proxy_frequency),
        inherit_vibration: section.boolean(d, "inherit_vibration").unwrap_or(default.inherit_vibration),
        rolling: section.boolean(d, "rolling").unwrap_or(default.rolling),
        sound: section.choice(d, "acceleration", SOUNDS).unwrap_or(default.sound),
        radiation: section.choice(d, "radiation", &radiations).unwrap_or(default.radiation),
        chain_onset: section.boolean(d, "chain_onset").unwrap_or(default.chain_onset),
        compressor: compressor(d, &section),
    };
    (render, acoustics)
}

fn parts(d: &mut Decoder<'_>, section: &Section<'_>) -> Option<Parts> {
    let only = |acceleration, modal, ground| Parts { acceleration, modal, ground };
    let words = [
        ("acceleration", only(true, false, false)),
        ("modal", only(false, true, false)),
        ("ground", only(false, false, true)),
    ];
    let node = section.get("parts")?;
    let expected = "a list of parts, such as [\"acceleration\", \"modal\"]";
    let elements = node.elements(d, expected)?;
    if elements.is_empty() {
        d.error(node.place(d), Problem::WrongLength { found: 0, expected: expected.into() });
        return None;
    }
    let mut parts = only(false, false, false);
    for element in elements {
        let named = element.choice(d, "part", &words)?;
        parts.acceleration |= named.acceleration;
        parts.modal |= named.modal;
        parts.ground |= named.ground;
    }
    Some(parts)
}

fn level(d: &mut Decoder<'_>, section: &Section<'_>) -> Level {
    section.exclude(d, "normalize", "full_scale", "`full_scale`");
    let full_scale = section.number(d, "full_scale", Quantity::between(1e-9, 1e9, "Pa"));
    let normalize = section.number(d, "normalize", Quantity::between(-120.0, 0.0, "dBFS"));
    full_scale.map(Level::FullScale).or(normalize.map(Level::Normalize)).unwrap_or(Level::Default)
}

fn floor(d: &mut Decoder<'_>, section: &Section<'_>, has_room: bool) -> Floor {
    let rigid = section.choice(d, "floor", &[("rigid", true), ("none", false)]);
    if let (Some(true), true, Some(node)) = (rigid, has_room, section.get("floor")) {
        d.error(node.place(d), Problem::Conflict { key: "floor", other: "[room], which has a floor" });
    }
    let height = section.number(d, "floor_height", Quantity::coordinate("m"));
    if let Some(node) = section.get("floor_height")
        && (rigid == Some(false) || !section.has("floor"))
    {
        d.error(node.place(d), Problem::Needs { key: "floor_height", other: "floor = \"rigid\"" });
    }
    match rigid {
        Some(true) => Floor::Rigid { height: height.unwrap_or(0.0) },
        _ => Floor::None,
    }
}

fn compressor(d: &mut Decoder<'_>, section: &Section<'_>) -> Option<Compressor> {
    let section = section.get("compressor")?.section(d, COMPRESSOR_KEYS)?;
    let default = Compressor::default();
    let time = Quantity::between(0.0, 10.0, "s");
    Some(Compressor {
        threshold_db: section
            .number(d, "threshold_db", Quantity::between(-120.0, 0.0, "dB"))
            .unwrap_or(default.threshold_db),
        ratio: section.number(d, "ratio", Quantity::between(1.0, 100.0, "")).unwrap_or(default.ratio),
        attack: section.number(d, "attack", time).unwrap_or(default.attack),
        release: section.number(d, "release", time).unwrap_or(default.release),
        makeup_db: section
            .number(d, "makeup_db", Quantity::between(-60.0, 60.0, "dB"))
            .unwrap_or(default.makeup_db),
    })
}
