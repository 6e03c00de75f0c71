//! The real-time engine, block by block.
//!
//! [`Engine`] joins both ends of the engine of `clangor::realtime`: any thread sends events, one thread at a
//! time renders. Bodies have the sound models and the forces of `strike` (`LiveBody`).

mod block;
mod events;
mod numbers;
mod settings;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

use clangor::body::{Body, Surface};
use clangor::glam::DVec3;
use clangor::pose::Pose;
use clangor::realtime::{self, Controller, EngineSettings, Event, HORIZON, ImpactEvent, ImpactTarget, Part};
use clangor::session::{LiveBody, StruckBody};
use clangor::{Progress, Strike};
use numpy::PyArray2;
use pyo3::exceptions::{PyOverflowError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use self::block::{Block, frames_of};
use self::events::{Collision, Met, Motion, StrikeCall};
use self::numbers::{Slot, number, points};
use self::settings::settings;
use crate::errors::raised;
use crate::progress::Watch;
use crate::session::Session;
use crate::settings::{MaterialOrName, check_keywords, keyword, model_options, named};

const BODY_KEYWORDS: &[&str] = &["scale", "quality", "cache", "position", "orientation", "progress"];
const SCENE_KEYWORDS: &[&str] = &["quality", "cache", "progress"];

/// Renders the pressure at one or two listeners block by block, while impacts happen.
#[pyclass(frozen, module = "clangor")]
pub(crate) struct Engine {
    settings: EngineSettings,
    latency: f64,
    audio: Mutex<realtime::Engine>,
    control: Mutex<Control>,
}

/// The end that sends events, and what is in the slots.
struct Control {
    controller: Controller,
    slots: Vec<Option<Held>>,
}

/// A body in a slot.
#[derive(Clone)]
pub(crate) struct Held {
    pub(crate) live: Arc<LiveBody>,
    /// Where it was said to be last.
    pub(crate) pose: Pose,
}

#[pymethods]
impl Engine {
    /// An engine for listeners at one or two positions [m], with the acoustics of a scene, if one is given.
    #[new]
    #[pyo3(
        signature = (listeners, **options),
        text_signature = "(listeners, *, sample_rate=48000, block=128, objects=64, reach=40.0, \
                          max_frequency=None, scene=None)"
    )]
    fn new(listeners: &Bound<'_, PyAny>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let listeners = points("listeners", listeners)?;
        if !(1..=2).contains(&listeners.len()) {
            let message = format!("listeners: there are {}; it must be one or two", listeners.len());
            return Err(PyValueError::new_err(message));
        }
        let settings = settings(listeners.len(), options)?;
        let (controller, engine) = realtime::engine(&settings).map_err(raised)?;
        let slots = (0..settings.objects).map(|_| None).collect();
        let made = Engine {
            latency: engine.latency(),
            audio: Mutex::new(engine),
            control: Mutex::new(Control { controller, slots }),
            settings,
        };
        made.place(&listeners)?;
        Ok(made)
    }

    /// Samples per second [Hz].
    #[getter]
    fn sample_rate(&self) -> u32 {
        self.settings.sample_rate.hz()
    }

    /// Number of listeners, the columns of a block.
    #[getter]
    fn listeners(&self) -> usize {
        self.settings.receivers
    }

    /// Delay from the time of an event to its sound at a listener that touches the body [s].
    #[getter]
    fn latency(&self) -> f64 {
        self.latency
    }

    /// Time of the sample that is rendered next [s].
    #[getter]
    fn time(&self) -> f64 {
        self.control().controller.report().time
    }

    /// Counts of what the engine took and left out, by name.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let report = self.control().controller.report();
        let row = PyDict::new(py);
        let counts = [
            ("taken", report.taken),
            ("lost", report.lost),
            ("refused", report.refused),
            ("late", report.late),
            ("simplified", report.simplified),
            ("waves", report.waves),
            ("distant", report.distant),
            ("shed", report.shed),
            ("masked", report.masked),
            ("inside", report.inside),
            ("shed_voices", report.shed_voices),
            ("voices", report.voices),
            ("modes", report.modes),
        ];
        counts.into_iter().try_for_each(|(name, count)| row.set_item(name, count))?;
        row.set_item("peak", report.peak)?;
        row.set_item("time", report.time)?;
        Ok(row)
    }

    /// Puts a body into a free slot and returns the slot: a shape of the library, a mesh file or a sound
    /// model, of a material. Bakes its sound model if the cache lacks it.
    #[pyo3(
        signature = (object, material, **options),
        text_signature = "($self, object, material, *, scale=1.0, quality='normal', cache=None, \
                          position=(0.0, 0.0, 0.0), orientation=(0.0, 0.0, 0.0, 1.0), progress=None)"
    )]
    fn add(
        &self,
        py: Python<'_>,
        object: &str,
        material: MaterialOrName,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<usize> {
        let options = options.cloned().unwrap_or_else(|| PyDict::new(py));
        check_keywords(&options, BODY_KEYWORDS)?;
        let scale = number(&options, "scale")?.unwrap_or(1.0);
        let pose = events::pose(&options, Pose::IDENTITY)?;
        let material = material.material()?;
        let body = py.detach(|| StruckBody::open(object, scale, Some(material)).map_err(raised))?;
        self.add_body(py, body, pose, &options)
    }

    /// Puts all solid bodies of a scene into free slots, where the scene has them at its start; returns the
    /// slots by name.
    #[pyo3(
        signature = (session, **options),
        text_signature = "($self, session, *, quality='normal', cache=None, progress=None)"
    )]
    fn add_scene<'py>(
        &self,
        py: Python<'py>,
        session: &Session,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let options = options.cloned().unwrap_or_else(|| PyDict::new(py));
        check_keywords(&options, SCENE_KEYWORDS)?;
        let is_solid = |body: &&Body| matches!(*body.surface, Surface::Mesh(_) | Surface::Sphere { .. });
        let bodies: Vec<Body> = session.lock()?.bodies().iter().filter(is_solid).cloned().collect();
        let slots = PyDict::new(py);
        for body in bodies {
            let (name, pose) = (body.name.clone(), body.pose);
            slots.set_item(name, self.add_body(py, body.into(), pose, &options)?)?;
        }
        Ok(slots)
    }

    /// Takes a body out of its slot; it fades out within a block.
    fn remove(&self, slot: Slot) -> PyResult<()> {
        let Slot(slot) = slot;
        self.held(slot)?;
        let mut control = self.control();
        control.controller.put(slot, None).map_err(raised)?;
        control.slots[slot] = None;
        Ok(())
    }

    /// Number of modes of the body in a slot.
    fn modes(&self, slot: Slot) -> PyResult<usize> {
        let Slot(slot) = slot;
        Ok(self.held(slot)?.live.modes())
    }

    /// Defects of the sound model of the body in a slot.
    fn remarks(&self, slot: Slot) -> PyResult<Vec<String>> {
        let Slot(slot) = slot;
        Ok(self.held(slot)?.live.remarks().iter().map(ToString::to_string).collect())
    }

    /// Strikes the body in a slot where it is, as `clangor.strike` does.
    #[pyo3(
        signature = (slot, **options),
        text_signature = "($self, slot, *, impulse=None, striker=None, point=None, time=None)"
    )]
    fn strike(&self, py: Python<'_>, slot: Slot, options: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
        let Slot(slot) = slot;
        let options = options.cloned().unwrap_or_else(|| PyDict::new(py));
        let struck = StrikeCall::of(&options)?;
        let held = self.held(slot)?;
        let events = py.detach(|| struck.events(slot, &held))?;
        // The engine may have gone on meanwhile.
        self.send_at(self.time_of(&options)?, events)
    }

    /// A contact of the body in a slot with the body in another one, or with flat ground of a material.
    #[pyo3(
        signature = (slot, partner, **options),
        text_signature = "($self, slot, partner, *, point, normal, speed, time=None)"
    )]
    fn collide(
        &self,
        py: Python<'_>,
        slot: Slot,
        partner: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let Slot(slot) = slot;
        let options = options.cloned().unwrap_or_else(|| PyDict::new(py));
        let collision = Collision::of(&options)?;
        let held = self.held(slot)?;
        let met = match partner.extract::<usize>() {
            Ok(other) if other == slot => {
                let message = format!("partner is {other}, the slot of the body itself");
                return Err(PyValueError::new_err(message));
            }
            Ok(other) => Met::Body(other, self.held(other)?),
            Err(error) if error.is_instance_of::<PyOverflowError>(py) => return Err(named("partner", error)),
            Err(_) => Met::ground(partner)?,
        };
        let events = py.detach(|| collision.events((slot, &held), &met))?;
        self.send_at(self.time_of(&options)?, events)
    }

    /// An impact as the engine takes it: on the body in a slot, or on a sphere without modes of a radius [m].
    #[pyo3(
        signature = (**options),
        text_signature = "($self, *, slot=None, radius=None, duration, time=None, position=None, \
                          orientation=None, \
                          velocity_change=(0.0, 0.0, 0.0), angular_velocity_change=(0.0, 0.0, 0.0), \
                          point=None, impulse=(0.0, 0.0, 0.0), force=None)"
    )]
    fn impact(&self, py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
        let options = options.cloned().unwrap_or_else(|| PyDict::new(py));
        let target = events::target(&options)?;
        let place = match target {
            ImpactTarget::Object { slot } => self.held(slot)?.pose,
            ImpactTarget::Sphere { .. } => Pose::IDENTITY,
        };
        let time = self.time_of(&options)?;
        self.send_at(time, vec![events::impact(&options, target, place)?])
    }

    /// Says where the body in a slot is from a time on, and how it moves.
    #[pyo3(
        signature = (slot, position, **options),
        text_signature = "($self, slot, position, *, orientation=(0.0, 0.0, 0.0, 1.0), \
                          velocity=(0.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, 0.0), time=None)"
    )]
    fn move_to(
        &self,
        slot: Slot,
        position: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let Slot(slot) = slot;
        let options = options.cloned().unwrap_or_else(|| PyDict::new(position.py()));
        let Motion { pose, velocity, angular_velocity } = Motion::of(position, &options)?;
        let time = self.time_of(&options)?;
        self.held(slot)?;
        let mut control = self.control();
        let event = Event::Pose { slot, time, pose, velocity, angular_velocity };
        control.controller.send(event).map_err(raised)?;
        if let Some(held) = &mut control.slots[slot] {
            held.pose = pose;
        }
        Ok(())
    }

    /// Fades out the body in a slot at a time [s]; the body stays there.
    #[pyo3(signature = (slot, *, time=None))]
    fn end(&self, slot: Slot, time: Option<f64>) -> PyResult<()> {
        let Slot(slot) = slot;
        self.held(slot)?;
        let time = self.checked_time(time)?;
        self.control().controller.send(Event::End { slot, time }).map_err(raised)
    }

    /// New positions of the listeners [m], which approach them within a few hundredths of a second.
    fn listen(&self, listeners: &Bound<'_, PyAny>) -> PyResult<()> {
        let listeners = points("listeners", listeners)?;
        if listeners.len() != self.settings.receivers {
            let (given, have) = (listeners.len(), self.settings.receivers);
            let message = format!("listeners: there are {given}; the engine was made for {have}");
            return Err(PyValueError::new_err(message));
        }
        self.place(&listeners)
    }

    /// Switches a part of the sound on or off: `"acceleration"`, `"modal"` or `"reflections"`.
    fn switch(&self, part: &str, on: bool) -> PyResult<()> {
        let part = match part {
            "acceleration" => Part::Acceleration,
            "modal" => Part::Modal,
            "reflections" => Part::Reflections,
            other => {
                return Err(PyValueError::new_err(format!(
                    "part is \"{other}\"; it can be \"acceleration\", \"modal\" or \"reflections\""
                )));
            }
        };
        self.control().controller.send(Event::Switch(part, on)).map_err(raised)
    }

    /// Falls silent within a millisecond, and drops all impacts to come.
    fn silence(&self) -> PyResult<()> {
        self.control().controller.send(Event::Silence).map_err(raised)
    }

    /// Renders the next samples: pressure [Pa], one row per frame and one column per listener. With `out`,
    /// writes them into that array and returns it.
    #[pyo3(signature = (frames=None, *, out=None))]
    fn render<'py>(
        &self,
        py: Python<'py>,
        frames: Option<&Bound<'py, PyAny>>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let frames = frames.map(frames_of).transpose()?;
        let columns = self.settings.receivers;
        let array = match (frames, out) {
            (None, None) => return Err(PyValueError::new_err("give either `frames` or `out`")),
            (_, Some(out)) => out.clone(),
            (Some(frames), None) => PyArray2::<f64>::zeros(py, [frames, columns], false).into_any(),
        };
        let mut block = Block::of(&array, (frames, columns))?;
        block.fill(py, || self.audio())?;
        drop(block);
        Ok(array)
    }

    fn __repr__(&self) -> String {
        let held = self.control().slots.iter().flatten().count();
        let (rate, time) = (self.sample_rate(), self.time());
        format!("Engine({held} bodies, {} listeners, {rate} Hz, at {time:.3} s)", self.settings.receivers)
    }
}

impl Engine {
    /// The end that renders, unless another thread renders.
    fn audio(&self) -> PyResult<MutexGuard<'_, realtime::Engine>> {
        match self.audio.try_lock() {
            Ok(audio) => Ok(audio),
            Err(TryLockError::WouldBlock) => Err(PyRuntimeError::new_err(
                "Engine.render: another thread renders with this engine; events may come from any thread",
            )),
            Err(TryLockError::Poisoned(_)) => {
                Err(PyRuntimeError::new_err("Engine.render: this engine failed before; make another one"))
            }
        }
    }

    /// The end that sends. Its holders never wait, neither for the interpreter nor for the engine.
    fn control(&self) -> MutexGuard<'_, Control> {
        self.control.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The body in a slot.
    fn held(&self, slot: usize) -> PyResult<Held> {
        let control = self.control();
        control.slots.get(slot).cloned().flatten().ok_or_else(|| {
            let count = control.slots.len();
            PyValueError::new_err(format!("slot: there is no body in slot {slot}, of {count} from 0 on"))
        })
    }

    /// The time that options give, or that of the next sample \[s\].
    fn time_of(&self, options: &Bound<'_, PyDict>) -> PyResult<f64> {
        self.checked_time(number(options, "time")?)
    }

    fn checked_time(&self, time: Option<f64>) -> PyResult<f64> {
        let now = self.time();
        let time = time.unwrap_or(now);
        match time.is_finite() && time - now <= HORIZON {
            true => Ok(time),
            false => Err(PyValueError::new_err(format!(
                "time is {time} s; the engine is at {now} s and takes events up to {HORIZON} s ahead"
            ))),
        }
    }

    fn place(&self, listeners: &[DVec3]) -> PyResult<()> {
        let places = [listeners[0], listeners[listeners.len() - 1]];
        self.control().controller.send(Event::Receivers(places)).map_err(raised)
    }

    fn send_at(&self, time: f64, events: Vec<ImpactEvent>) -> PyResult<()> {
        let mut control = self.control();
        for event in events {
            let time = time + event.time;
            control.controller.send(ImpactEvent { time, ..event }).map_err(raised)?;
        }
        Ok(())
    }

    /// Obtains the sound model of a body and puts it into a free slot, at a pose.
    fn add_body(
        &self,
        py: Python<'_>,
        body: StruckBody,
        pose: Pose,
        options: &Bound<'_, PyDict>,
    ) -> PyResult<usize> {
        let quality: Option<String> = keyword(options, "quality")?;
        let models = model_options(quality.as_deref().unwrap_or("normal"), None)?;
        let cache: Option<std::path::PathBuf> = keyword(options, "cache")?;
        let watch = Watch::new(keyword(options, "progress")?);
        let full = || {
            let message =
                format!("all {} slots have a body; make the engine with more", self.settings.objects);
            PyValueError::new_err(format!("objects: {message}"))
        };
        if self.control().slots.iter().all(Option::is_some) {
            return Err(full());
        }
        let live = py.detach(|| {
            let mut strike = Strike::new(body).models(models);
            if let Some(folder) = cache {
                strike = strike.cache(folder);
            }
            let mut reached = |progress: &Progress<'_>| watch.reached(progress);
            strike.live_body(&self.settings, &mut reached).map_err(|error| watch.cause(raised(error)))
        })?;
        let object = py.detach(|| live.object(&self.settings));
        let mut control = self.control();
        let slot = control.slots.iter().position(Option::is_none).ok_or_else(full)?;
        control.controller.put(slot, Some(object)).map_err(raised)?;
        let (time, still) = (control.controller.report().time, DVec3::ZERO);
        let stands = Event::Pose { slot, time, pose, velocity: still, angular_velocity: still };
        control.controller.send(stands).map_err(raised)?;
        control.slots[slot] = Some(Held { live: Arc::new(live), pose });
        Ok(slot)
    }
}
