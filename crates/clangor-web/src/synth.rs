//! The synthesiser of a page: events go in, blocks of two channels come out.
//!
//! An [`Engine`] and its [`Controller`] on one thread, the audio worklet's. Until [`synth_start`] it is
//! silent.

use std::cell::RefCell;
use std::collections::BTreeMap;

use clangor_core::glam::{DQuat, DVec3};
use clangor_core::material::Damping;
use clangor_core::pose::Pose;
use clangor_core::realtime::{
    Controller, Engine, EngineSettings, Event, ImpactEvent, ImpactTarget, ObjectError, Part, PlaybackLevel,
    SendError, SoundingObject, engine,
};
use clangor_core::scene::Scene;
use clangor_core::synthesis::{SampleRate, SynthesisError};

use crate::event::{CLICK, END, IMPACT, POSE, STRIDE};
use crate::wasm_buffer::{self, status};

/// Slots for objects.
pub const SLOTS: u32 = 1024;
/// Numbers of [`synth_report`].
pub const REPORT: usize = 12;
/// Reflections of a room that are images of their own: more would cost more than they tell.
const IMAGE_ORDER: u32 = 1;
/// Most samples rendered at once.
const MOST_FRAMES: u32 = 4096;

thread_local! {
    static STATE: RefCell<State> = RefCell::default();
}

#[derive(Default)]
struct State {
    playing: Option<Playing>,
    /// The files of the slots, for the next start.
    files: BTreeMap<u32, File>,
    level: Level,
    output: Vec<f32>,
    report: [f64; REPORT],
    /// Largest pressure since it was asked for \[Pa\].
    peak: f64,
}

/// A sound model, and how fast it dies away.
struct File {
    model: Vec<u8>,
    damping: Option<Damping>,
}

impl File {
    fn try_new(model: Vec<u8>, damping: &[u8]) -> Result<Self, SynthError> {
        let table = (!damping.is_empty()).then(|| serde_json::from_slice(damping)).transpose()?;
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
    /// Events of no known kind.
    unknown: u64,
}

struct Level(PlaybackLevel);

impl Default for Level {
    fn default() -> Self {
        Level(PlaybackLevel { full_scale: 1.0 })
    }
}

/// Why the synthesiser refuses.
#[derive(Debug, thiserror::Error)]
enum SynthError {
    #[error("the scene is not UTF-8 text")]
    NotText,
    #[error("{0}")]
    Scene(String),
    #[error("a sample rate of {0} Hz is none")]
    Rate(f64),
    #[error(transparent)]
    Synthesis(#[from] SynthesisError),
    #[error(transparent)]
    Object(#[from] ObjectError),
    #[error("the damping is no list of frequencies and times: {0}")]
    Damping(#[from] serde_json::Error),
    #[error(transparent)]
    Send(#[from] SendError),
    #[error("slot {0} is none of the {SLOTS} there are")]
    Slot(u32),
    #[error("nothing has been started")]
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
        let mut settings = EngineSettings::from_scene(&scene);
        settings.sample_rate = SampleRate::try_new(hz as u32)?;
        settings.block = block as usize;
        settings.receivers = 2;
        settings.objects = SLOTS as usize;
        if let Some(room) = &mut settings.room {
            room.image_order = room.image_order.min(IMAGE_ORDER);
        }
        let (controller, engine) = engine(&settings)?;
        self.playing = Some(Playing { controller, engine, settings, unknown: 0 });
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
            // Only whether it can be read.
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

/// Starts anew, silent, at sample 0: samples a second, the length of the blocks that will be asked for, and
/// the scene in the buffer, as TOML of so many bytes, for its medium, floor, room and air. Objects stay in
/// their slots.
pub fn synth_start(sample_rate: f64, block: u32, scene_bytes: u32) -> i32 {
    let text = wasm_buffer::bytes(scene_bytes);
    STATE.with_borrow_mut(|state| status(state.start(sample_rate, block, &text)))
}

/// Puts the sound model that lies in the buffer, a file of so many bytes as `clangor bake` writes it, into a
/// slot. Behind it in the buffer may be how fast it dies away, as JSON of so many bytes: pairs of a frequency
/// \[Hz\] and a T60 \[s\], between which it is interpolated. Without, it is that of the library's material
/// that the model names.
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

/// Where the left and the right receiver are \[m\].
pub fn synth_listener(lx: f64, ly: f64, lz: f64, rx: f64, ry: f64, rz: f64) -> i32 {
    send(Event::Receivers([DVec3::new(lx, ly, lz), DVec3::new(rx, ry, rz)]))
}

/// Takes so many events out of the buffer; returns how many were taken. The rest was of unknown kinds, or too
/// much.
pub fn synth_push(count: u32) -> u32 {
    STATE.with_borrow_mut(|state| {
        let Some(playing) = &mut state.playing else { return 0 };
        wasm_buffer::with_words(|words| {
            let rows = words.as_chunks::<STRIDE>().0.iter().take(count as usize);
            let mut taken = 0;
            for row in rows {
                match event(&row.map(f64::from_bits)) {
                    Some(event) => taken += u32::from(playing.controller.send(event).is_ok()),
                    None => playing.unknown += 1,
                }
            }
            taken
        })
    })
}

/// The event that a row of numbers is; `None` of an unknown kind.
fn event(row: &[f64; STRIDE]) -> Option<Event> {
    let vector = |at: usize| DVec3::new(row[at], row[at + 1], row[at + 2]);
    let (kind, time) = (row[0], row[1]);
    // Of a slot that is none the engine says so.
    let slot = if row[3] >= 0.0 { row[3] as usize } else { usize::MAX };
    let orientation = DQuat::from_xyzw(row[7], row[8], row[9], row[10]);
    let pose = Pose { position: vector(4), orientation };
    let impact = |target| {
        Event::Impact(ImpactEvent {
            target,
            time,
            duration: row[2],
            pose,
            velocity_change: vector(11),
            angular_velocity_change: vector(14),
            point: vector(17),
            impulse: vector(20),
        })
    };
    match kind {
        CLICK => Some(impact(ImpactTarget::Sphere { radius: row[3] })),
        IMPACT => Some(impact(ImpactTarget::Object { slot })),
        POSE => {
            let (velocity, angular_velocity) = (vector(11), vector(14));
            Some(Event::Pose { slot, time, pose, velocity, angular_velocity })
        }
        END => Some(Event::End { slot, time }),
        _ => None,
    }
}

/// The pressure that is a sample of 1 \[Pa\]; louder is bent below 1.
pub fn synth_gain(pascal_at_full_scale: f64) -> i32 {
    if !(pascal_at_full_scale > 0.0 && pascal_at_full_scale.is_finite()) {
        return status(Err(SynthError::FullScale(pascal_at_full_scale)));
    }
    STATE.with_borrow_mut(|state| state.level = Level(PlaybackLevel { full_scale: pascal_at_full_scale }));
    0
}

/// Whether ringing is heard.
pub fn synth_ringing(on: u32) -> i32 {
    send(Event::Switch(Part::Modal, on != 0))
}

/// Whether reflections are heard.
pub fn synth_room(on: u32) -> i32 {
    send(Event::Switch(Part::Reflections, on != 0))
}

/// Whether clicks are heard.
pub fn synth_clicks(on: u32) -> i32 {
    send(Event::Switch(Part::Acceleration, on != 0))
}

/// Stops all that sounds or is to sound, within a millisecond.
pub fn synth_silence() -> i32 {
    send(Event::Silence)
}

/// The next samples, 4096 at most: all of the left channel, then all of the right, as they are to be played;
/// then the same two as pressure \[Pa\], for recording and measuring.
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

/// From the time of an event until it is heard by a receiver that it touches \[s\].
pub fn synth_latency() -> f64 {
    STATE.with_borrow(|state| state.playing.as_ref().map_or(0.0, |playing| playing.engine.latency()))
}

/// Time of the sample that is rendered next \[s\].
pub fn synth_time() -> f64 {
    STATE.with_borrow(|state| state.playing.as_ref().map_or(0.0, |playing| playing.engine.time()))
}

/// [`REPORT`] numbers: events taken, waves, late, distant, refused and lost, shed waves and impacts, shed
/// objects, objects that ring, modes that ring, largest pressure since this was asked last \[Pa\], masked
/// waves, waves with the receiver inside.
pub fn synth_report() -> *const f64 {
    STATE.with_borrow_mut(|state| {
        if let Some(Playing { controller, unknown, .. }) = &state.playing {
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
            ];
            state.peak = 0.0;
        }
        state.report.as_ptr()
    })
}

/// Calls `read` with the samples that were rendered last.
pub fn with_output<T>(read: impl FnOnce(&[f32]) -> T) -> T {
    STATE.with_borrow(|state| read(&state.output))
}
