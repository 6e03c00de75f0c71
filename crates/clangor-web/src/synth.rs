//! The synthesis of a page: events go in, blocks of two channels come out.
//!
//! An [`Engine`] and its [`Controller`] on one thread, that of the audio worklet. Silent until
//! [`synth_start`].

use std::cell::RefCell;
use std::collections::BTreeMap;

use clangor_core::glam::DVec3;
use clangor_core::material::Damping;
use clangor_core::realtime::event_row::{DecodedRow, RowDecoder};
use clangor_core::realtime::{
    Controller, Engine, EngineSettings, Event, Part, PlaybackLevel, SendError, SoundingObject, engine,
};
use clangor_core::scene::Scene;
use clangor_core::synthesis::object_file::ObjectError;
use clangor_core::synthesis::{SampleRate, SynthesisError};

use crate::layout::{EVENT_STRIDE, REPORT_STRIDE};
use crate::wasm_buffer::{self, status};

/// Slots for objects.
pub const SLOTS: u32 = 1024;
/// Highest order of image sources, in a room or in planes: higher orders cost more than they contribute.
const IMAGE_ORDER: u32 = 1;
/// Most samples rendered at once.
const MOST_FRAMES: u32 = 4096;

thread_local! {
    static STATE: RefCell<State> = RefCell::default();
}

#[derive(Default)]
struct State {
    playing: Option<Playing>,
    /// Files of the slots, kept for the next start.
    files: BTreeMap<u32, File>,
    level: Level,
    output: Vec<f32>,
    report: [f64; REPORT_STRIDE],
    /// Largest pressure since the last report \[Pa\].
    peak: f64,
}

/// The file of a sound model, and its damping.
struct File {
    model: Vec<u8>,
    damping: Option<Damping>,
}

impl File {
    fn try_new(model: Vec<u8>, damping: &[u8]) -> Result<Self, SynthError> {
        let table = (!damping.is_empty()).then(|| serde_json::from_slice(damping)).transpose();
        let table = table.map_err(SynthError::Damping)?;
        Ok(File { model, damping: table.map(Damping::T60Table) })
    }

    fn object(&self, settings: &EngineSettings) -> Result<SoundingObject, ObjectError> {
        SoundingObject::from_file(&self.model, self.damping.as_ref(), settings)
    }
}

struct Playing {
    controller: Controller,
    engine: Engine,
    settings: EngineSettings,
    decoder: RowDecoder,
    /// Number of events of an unknown kind.
    unknown: u64,
}

struct Level(PlaybackLevel);

impl Default for Level {
    fn default() -> Self {
        Level(PlaybackLevel { full_scale: 1.0 })
    }
}

/// Reasons for the synthesis's refusals.
#[derive(Debug, thiserror::Error)]
enum SynthError {
    #[error("the scene is not UTF-8 text")]
    NotText,
    #[error("{0}")]
    Scene(String),
    #[error("a sample rate of {0} Hz is not supported: it must be a whole number below 1 MHz")]
    Rate(f64),
    #[error(transparent)]
    Synthesis(#[from] SynthesisError),
    #[error(transparent)]
    Object(#[from] ObjectError),
    #[error("the damping must be a list of pairs of frequency and time")]
    Damping(#[source] serde_json::Error),
    #[error(transparent)]
    Send(#[from] SendError),
    #[error("there is no slot {0}; there are {SLOTS}, from slot 0")]
    Slot(u32),
    #[error("no scene has been started")]
    Silent,
    #[error("{0} Pa cannot be full scale")]
    FullScale(f64),
}

impl State {
    fn start(&mut self, sample_rate: f64, block: u32, text: &[u8]) -> Result<i32, SynthError> {
        let text = str::from_utf8(text).map_err(|_| SynthError::NotText)?;
        let scene = Scene::from_toml(text).map_err(|errors| SynthError::Scene(errors.to_string()))?;
        let hz = sample_rate.round();
        if hz != sample_rate || !(0.0..1e6).contains(&hz) {
            return Err(SynthError::Rate(sample_rate));
        }
        let mut settings = EngineSettings::from_scene(&scene)
            .with_sample_rate(SampleRate::try_new(hz as u32)?)
            .with_block(block as usize)
            .with_objects(SLOTS as usize);
        if let Some(room) = &mut settings.acoustics.room {
            room.image_order = room.image_order.min(IMAGE_ORDER);
        }
        settings.acoustics.planes = settings.acoustics.planes.up_to_order(IMAGE_ORDER);
        let (controller, engine) = engine(&settings)?;
        self.playing =
            Some(Playing { controller, engine, settings, decoder: RowDecoder::default(), unknown: 0 });
        for (slot, file) in &self.files {
            put(self.playing.as_mut(), *slot, file)?;
        }
        Ok(0)
    }

    fn load(&mut self, slot: u32, file: File) -> Result<i32, SynthError> {
        if slot >= SLOTS {
            return Err(SynthError::Slot(slot));
        }
        match &mut self.playing {
            Some(playing) => put(Some(playing), slot, &file)?,
            // Not started yet: only checks that the file is readable.
            None => drop(file.object(&EngineSettings::default())?),
        }
        self.files.insert(slot, file);
        Ok(0)
    }

    fn send(&mut self, event: Event) -> Result<i32, SynthError> {
        self.playing.as_mut().ok_or(SynthError::Silent)?.controller.send(event)?;
        Ok(0)
    }
}

fn put(playing: Option<&mut Playing>, slot: u32, file: &File) -> Result<(), SynthError> {
    let Playing { controller, settings, .. } = playing.ok_or(SynthError::Silent)?;
    let object = file.object(settings)?;
    Ok(controller.put(slot as usize, Some(object))?)
}

/// Starts at sample 0, with this sample rate \[Hz\], blocks of this length \[samples\], and the
/// acoustics of the scene in the buffer, TOML of so many bytes. Objects stay in their slots.
pub fn synth_start(sample_rate: f64, block: u32, scene_bytes: u32) -> i32 {
    let text = wasm_buffer::bytes(scene_bytes);
    STATE.with_borrow_mut(|state| status(state.start(sample_rate, block, &text)))
}

/// Loads the sound model in the buffer, a file of `clangor bake` of so many bytes, into a slot. Behind it in
/// the buffer may follow the damping, JSON of so many bytes: pairs of frequency \[Hz\] and T60 \[s\], between
/// which it is interpolated. Without it, the damping is that of the library's material that the model names.
pub fn synth_load(slot: u32, bytes: u32, damping_bytes: u32) -> i32 {
    let mut model = wasm_buffer::bytes(bytes.saturating_add(damping_bytes));
    let damping = model.split_off(model.len().min(bytes as usize));
    STATE.with_borrow_mut(|state| {
        let file = File::try_new(model, &damping);
        status(file.and_then(|file| state.load(slot, file)))
    })
}

fn send(event: Event) -> i32 {
    STATE.with_borrow_mut(|state| status(state.send(event)))
}

/// Sets the positions of the left and the right receiver \[m\].
pub fn synth_listener(lx: f64, ly: f64, lz: f64, rx: f64, ry: f64, rz: f64) -> i32 {
    send(Event::Receivers([DVec3::new(lx, ly, lz), DVec3::new(rx, ry, rz)]))
}

/// Takes so many rows from the buffer; returns how many were taken. The others have an unknown kind, or the
/// ring is full. Rows of force histories may come long before their impacts, which the audio thread then
/// only looks up.
pub fn synth_push(count: u32) -> u32 {
    STATE.with_borrow_mut(|state| {
        let Some(playing) = &mut state.playing else { return 0 };
        wasm_buffer::with_words(|words| {
            let rows = words.as_chunks::<EVENT_STRIDE>().0.iter().take(count as usize);
            let mut taken = 0;
            for row in rows {
                match playing.decoder.decode(&row.map(f64::from_bits)) {
                    DecodedRow::Event(event) => taken += u32::from(playing.controller.send(event).is_ok()),
                    DecodedRow::ForceHistory => taken += 1,
                    DecodedRow::Unknown => playing.unknown += 1,
                }
            }
            taken
        })
    })
}

/// Sets the pressure of a sample of 1 \[Pa\]; louder samples are compressed below 1.
pub fn synth_gain(pascal_at_full_scale: f64) -> i32 {
    if !(pascal_at_full_scale > 0.0 && pascal_at_full_scale.is_finite()) {
        return status(Err(SynthError::FullScale(pascal_at_full_scale)));
    }
    STATE.with_borrow_mut(|state| state.level = Level(PlaybackLevel { full_scale: pascal_at_full_scale }));
    0
}

/// Switches acceleration noise on or off.
pub fn synth_acceleration(on: u32) -> i32 {
    send(Event::Switch(Part::Acceleration, on != 0))
}

/// Switches the sound of modes on or off.
pub fn synth_modal(on: u32) -> i32 {
    send(Event::Switch(Part::Modal, on != 0))
}

/// Switches reflections on or off.
pub fn synth_reflections(on: u32) -> i32 {
    send(Event::Switch(Part::Reflections, on != 0))
}

/// Silences the engine within a millisecond, and drops all impacts to come.
pub fn synth_silence() -> i32 {
    send(Event::Silence)
}

/// Renders the next samples, 4096 at most: the left channel, then the right one, for playback; then both as
/// pressure \[Pa\], for recordings and meters.
pub fn synth_render(frames: u32) -> *const f32 {
    let frames = frames.clamp(1, MOST_FRAMES) as usize;
    STATE.with_borrow_mut(|state| {
        state.output.clear();
        match &mut state.playing {
            Some(Playing { engine, .. }) => {
                let Level(level) = &state.level;
                let channels = engine.render(frames);
                state.output.extend(channels.iter().flatten().map(|p| level.sample(*p)));
                state.output.extend(channels.iter().flatten().map(|p| *p as f32));
                state.peak = state.peak.max(engine.report().peak);
            }
            None => state.output.resize(4 * frames, 0.0),
        }
        state.output.as_ptr()
    })
}

/// Delay from the time of an event to its sound at a receiver that touches the body \[s\].
pub fn synth_latency() -> f64 {
    STATE.with_borrow(|state| state.playing.as_ref().map_or(0.0, |playing| playing.engine.latency()))
}

/// Time of the sample rendered next \[s\].
pub fn synth_time() -> f64 {
    STATE.with_borrow(|state| state.playing.as_ref().map_or(0.0, |playing| playing.engine.time()))
}

/// [`REPORT_STRIDE`] numbers: events taken, waves, late impacts, distant waves, events refused or lost, waves
/// and impacts shed, objects shed, audible objects, vibrating modes, largest pressure since the last report
/// \[Pa\], masked waves, waves with the receiver inside the body, impacts without their force history.
pub fn synth_report() -> *const f64 {
    STATE.with_borrow_mut(|state| {
        if let Some(Playing { controller, unknown, decoder, .. }) = &state.playing {
            let report = controller.report();
            let count = |n: u64| n as f64;
            state.report = [
                count(report.taken),
                count(report.waves),
                count(report.late),
                count(report.distant),
                count(report.refused + report.lost + unknown),
                count(report.shed),
                count(report.shed_voices),
                count(report.voices),
                count(report.modes),
                state.peak,
                count(report.masked),
                count(report.inside),
                count(report.simplified + decoder.missing),
            ];
            state.peak = 0.0;
        }
        state.report.as_ptr()
    })
}

/// Calls `read` with the samples rendered last.
pub fn with_output<T>(read: impl FnOnce(&[f32]) -> T) -> T {
    STATE.with_borrow(|state| read(&state.output))
}
