//! One impact sounds the same, whatever computes it: `render`, `strike --striker`, the real-time engine as
//! `play` feeds it, and the page's strike and synthesis.
//!
//! A steel ball of 6 mm radius hits the rim of a ceramic plate at 1 m/s. The plate stays where it is; its
//! acceleration and modes come from one model file. The ball is heard too. In Bevy:
//! `integrations/bevy/tests/cross_one_impact.rs`.

use std::fs;
use std::path::Path;

use clangor_core::acoustics::Acoustics;
use clangor_core::body::{Body, Surface};
use clangor_core::contact::{ContactSettings, ForceSettings};
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::material::{PairCoefficients, presets};
use clangor_core::pose::Pose;
use clangor_core::realtime::{Event, event_row};
use clangor_core::scene::render_description::{GroundSound, Parts};
use clangor_core::sound_model::acceleration::model_evaluator::ModelEvaluator;
use clangor_core::sound_model::files::model_file::ModelFile;
use clangor_core::synthesis::source_rule::{Decision, Reason, SourceKind, source_of};
use clangor_core::synthesis::{
    AccelerationPart, BodyModes, Listener, NoModes, RenderSettings, SampleRate, SoundModel, SoundSource,
};
use clangor_pipeline::formats::timeline_file::TimelineReader;
use clangor_pipeline::formats::wav::SampleFormat;
use clangor_pipeline::stages::event_schedule::event_feeder::EventFeeder;
use clangor_pipeline::stages::event_schedule::scheduled_engine::ScheduledEngine;
use clangor_pipeline::stages::render::{FullScale, RenderOptions, Transfers};
use clangor_web::wasm_buffer::{last_message, write};
use clangor_web::{layout, strike, synth};
use serde_json::Value;

const RATE: usize = 48_000;
/// Highest frequency of the comparison \[Hz\].
const BAND: &str = "16000";
const BALL: f64 = 0.006;
const SPEED: f64 = 1.0;
const EAR: DVec3 = DVec3::new(0.5, 0.6, 0.4);
/// Time of the impact in the timeline and on the page \[s\], a whole number of samples.
const IMPACT: f64 = 0.05;
/// Duration compared \[s\].
const COMPARED: f64 = 0.1;

/// The highest point of the plate's rim, and the outward normal there.
fn rim(plate: &Body) -> (DVec3, DVec3) {
    let Surface::Mesh(surface) = &*plate.surface else { panic!("a mesh") };
    let vertices = surface.mesh.vertices.iter().copied();
    let point = vertices.max_by(|a, b| a.y.total_cmp(&b.y)).unwrap();
    (point, plate.surface.normal_at(point).unwrap())
}

/// (1 + e) m V [N s] of the ball on the plate, with 1/m = Σ 1/M + (r × n)·I⁻¹(r × n).
fn impulse(plate: &Body, point: DVec3, normal: DVec3) -> f64 {
    let steel = presets::STEEL.material();
    let lever = point.cross(normal);
    let ball_mass = steel.density * 4.0 / 3.0 * std::f64::consts::PI * BALL.powi(3);
    let inverse_mass = 1.0 / plate.mass + 1.0 / ball_mass + lever.dot(plate.inertia.inverse() * lever);
    (1.0 + PairCoefficients::of(&plate.material, &steel).restitution.at(SPEED)) * SPEED / inverse_mass
}

fn scene(ball: DVec3) -> String {
    format!(
        "version = 1\ngravity = [0.0, 0.0, 0.0]\n[simulation]\nduration = 0.3\n[render]\nground = \"none\"\n\
         contact_steps = 8\n\
         max_frequency = {BAND}\n\
         [[body]]\nname = \"plate\"\nshape = \"plate\"\nmaterial = \"ceramic\"\nposition = [0.0, 0.0, 0.0]\n\
         [[body]]\nname = \"ball\"\nshape = \"sphere:{BALL}\"\nmaterial = \"steel\"\n\
         position = [{}, {}, {}]\n\
         [[listener]]\nname = \"ear\"\nposition = [{}, {}, {}]\n",
        ball.x, ball.y, ball.z, EAR.x, EAR.y, EAR.z
    )
}

/// The samples from the impact on.
fn from_impact(samples: &[f64], impact: f64) -> Vec<f64> {
    let first = (impact * RATE as f64).round() as usize;
    samples[first..first + (COMPARED * RATE as f64) as usize].to_vec()
}

/// Largest difference, over the peak of the first.
fn apart(one: &[f64], other: &[f64]) -> f64 {
    let peak = one.iter().fold(0.0, |m: f64, p| m.max(p.abs()));
    one.iter().zip(other).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / peak
}

/// The run as `play` gives it to the real-time engine.
fn live(timeline: &Path, file: &ModelFile) -> Vec<f64> {
    let reader = TimelineReader::open(timeline).unwrap();
    let bodies = reader.bodies();
    let own = ModelEvaluator::try_new(&file.acceleration).unwrap();
    let decision = Decision { kind: SourceKind::Own, reason: Reason::Asked };
    let (source, kind) = source_of(&bodies[0], &decision, None, Some(&own));
    let modal = BodyModes::Own(file.modal.as_ref().unwrap().model.clone().into());
    let plate = SoundModel { acceleration: AccelerationPart { source, kind, decision }, modal };
    let mut ball = SoundModel::without_modes(SoundSource::Sphere { radius: BALL });
    ball.modal = BodyModes::None(NoModes::Unstruck);
    let acoustics = Acoustics { max_frequency: BAND.parse().ok(), ..Acoustics::default() };
    let options = RenderOptions {
        listeners: vec![Listener::fixed("ear", EAR)],
        contact: ContactSettings { forces: ForceSettings::default().live(), ..ContactSettings::default() },
        synthesis: RenderSettings { acoustics, ..RenderSettings::default() },
        parts: Parts::default(),
        transfers: Transfers::Baked,
        ground: GroundSound::None,
        inherit_vibration: true,
        rolling: None,
        to: 0.3,
        format: SampleFormat::Float32,
        full_scale: FullScale::Pascals(1.0),
        compressor: None,
        stems: false,
        note: String::new(),
    };
    let run = reader.read_all().unwrap();
    let rate = SampleRate::HZ_48000;
    let played = ScheduledEngine::new(&bodies, &[plate, ball], &run, &options, rate).unwrap();
    let ScheduledEngine { schedule, listener, mut controller, mut engine, .. } = played;
    // Its objects were put in while it rendered single samples.
    let begin = engine.time();
    let mut feeder = EventFeeder::new(&schedule, &listener, 0.0, begin);
    let latency = (engine.latency() * RATE as f64).round() as usize;
    let mut sound = Vec::new();
    while sound.len() < RATE / 4 + latency {
        feeder.feed(&mut controller, engine.time()).unwrap();
        sound.extend_from_slice(&engine.render(128)[0]);
    }
    assert_eq!(engine.report().late, 0, "{:?}", engine.report());
    sound.split_off(latency)
}

/// The page: the strike of its main thread, played by its synthesis.
fn page(model: &[u8], text: &str, point: DVec3) -> (Vec<f64>, Vec<f64>) {
    assert_eq!(strike::strike_load(0, write(model)), 0, "{}", last_message());
    strike::strike_materials();
    let materials: Vec<String> = serde_json::from_str(&last_message()).unwrap();
    let steel = materials.iter().position(|name| name == "steel").unwrap();
    let numbers = [BALL, SPEED, 0.0, 0.0, 0.0, point.x, point.y, point.z];
    write(&numbers.map(f64::to_le_bytes).concat());
    let count = strike::strike_impact(0, steel as u32);
    assert!(count >= 2, "the plate and the ball: {}", last_message());
    let (mut events, contact) = strike::with_impact(|events, contact| (events.to_vec(), contact.to_vec()));
    let time = event_row::FIELDS.iter().find(|(name, ..)| *name == "time").unwrap().1;
    events.chunks_mut(layout::EVENT_STRIDE).for_each(|row| row[time] = IMPACT);

    assert_eq!(synth::synth_start(RATE as f64, 128, write(text.as_bytes())), 0, "{}", last_message());
    assert_eq!(synth::synth_load(0, write(model), 0), 0, "{}", last_message());
    assert_eq!(synth::synth_listener(EAR.x, EAR.y, EAR.z, EAR.x, EAR.y, EAR.z), 0);
    let pose = Pose { position: DVec3::ZERO, orientation: DQuat::IDENTITY };
    let (velocity, angular_velocity) = (DVec3::ZERO, DVec3::ZERO);
    let rests = Event::Pose { slot: 0, time: 0.0, pose, velocity, angular_velocity };
    let rows = [event_row::RowEncoder::default().encode(&rests, 0).concat(), events].concat();
    write(&rows.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>());
    assert_eq!(synth::synth_push(count as u32 + 1), count as u32 + 1);
    let latency = (synth::synth_latency() * RATE as f64).round() as usize;
    let mut sound = Vec::new();
    while sound.len() < RATE / 4 + latency {
        synth::synth_render(128);
        // Behind the samples for playback are the pressures, left and right.
        synth::with_output(|samples| sound.extend(samples[256..384].iter().map(|p| f64::from(*p))));
    }
    (sound.split_off(latency), contact)
}

#[test]
fn one_impact_sounds_the_same_everywhere() {
    let folder = tempfile::tempdir().unwrap();
    let clangor = |arguments: &[&str]| crate::program::clangor(folder.path(), arguments);
    let wav = |name: &str| -> Vec<f64> {
        let (samples, rate) = crate::sound_file::samples(&folder.path().join(name));
        assert_eq!(rate, RATE as f64);
        samples.into_iter().map(f64::from).collect()
    };
    let bake = ["bake", "plate", "--material", "ceramic", "--accuracy", "0.03", "--max-frequency", BAND];
    clangor(&[&bake[..], &["-o", "plate.safetensors"]].concat());
    let bytes = fs::read(folder.path().join("plate.safetensors")).unwrap();
    let file = ModelFile::decode(&bytes).unwrap();
    let surface = file.solid.body_surface(file.acceleration.radius).unwrap();
    let plate = Body::solid("plate", presets::CERAMIC.material(), surface, &file.solid.mass);
    let (point, normal) = rim(&plate);
    let triple = |v: DVec3| format!("{},{},{}", v.x, v.y, v.z);

    // The strike, which begins 2 ms before the impact.
    let strike = [
        "strike",
        "plate.safetensors",
        "--material",
        "ceramic",
        "--striker",
        "steel:0.006",
        "--contact-steps",
        "8",
    ];
    let (place, ear) = (triple(point), triple(EAR));
    let how = ["--speed", "1", "--point", &place, "--listener", &ear, "--seconds", "0.2"];
    let report = ["--max-frequency", BAND, "-o", "strike.wav", "--json"];
    let report: Value = serde_json::from_str(&clangor(&[&strike[..], &how, &report].concat())).unwrap();
    let struck = from_impact(&wav("strike.wav"), 2e-3);
    let exchanged = impulse(&plate, point, normal);
    let reported: DVec3 = DVec3::from_array(serde_json::from_value(report["impulse_n_s"].clone()).unwrap());
    // Residual seen: 1e-16 N s.
    assert!(reported.distance(-exchanged * normal) < 1e-12 * exchanged, "{reported} {exchanged}");
    let ratio = report["modal_energy_ratio"].as_f64().unwrap();
    assert!(ratio > 1.0, "the bound of the energy is to act: {ratio}");

    // The same contact in a timeline whose bodies do not move.
    fs::write(folder.path().join("one.toml"), scene(point + BALL * normal)).unwrap();
    let row = serde_json::json!({
        "t": IMPACT, "body_a": "plate", "body_b": "ball", "point": point.to_array(),
        "normal": (-normal).to_array(), "impulse_n": exchanged, "speed": SPEED,
    });
    fs::write(folder.path().join("one.jsonl"), format!("{row}\n")).unwrap();
    clangor(&["import", "contacts", "one.toml", "one.jsonl", "--at-rest", "-o", "one.timeline"]);
    let model = ["render", "one.timeline", "--model", "plate=plate.safetensors", "--to", "0.3"];
    clangor(&[&model[..], &["--bits", "32f", "-o", "render.wav"]].concat());
    let rendered = from_impact(&wav("render.wav"), IMPACT);

    let played = from_impact(&live(&folder.path().join("one.timeline"), &file), IMPACT);
    let (page_sound, contact) = page(&bytes, &scene(point + BALL * normal), point);
    let page_sound = from_impact(&page_sound, IMPACT);
    let impulse_at = layout::CONTACT_FIELDS.iter().find(|(name, ..)| *name == "impulse").unwrap().1;
    assert!((contact[impulse_at] / exchanged - 1.0).abs() < 1e-12, "{contact:?}");

    let peak = struck.iter().fold(0.0, |m: f64, p| m.max(p.abs()));
    let [by_render, by_engine, by_page] =
        [&rendered, &played, &page_sound].map(|sound| apart(&struck, sound));
    println!(
        "peak {peak:.3} Pa, E/E₀ {ratio:.2}: \
         render {by_render:.1e}, engine {by_engine:.1e}, page {by_page:.1e}"
    );
    assert!(peak > 0.1);
    // Residual seen: 2e-7, of the samples of the file; 4.8e-5 and 4.8e-5, of the delays of the engine.
    assert!(by_render < 1e-3 && by_engine < 1e-3 && by_page < 1e-3);
}
