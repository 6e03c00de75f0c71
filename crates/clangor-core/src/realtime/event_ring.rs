//! Between whoever knows what happens and the audio thread: a wait-free ring of events, one of objects that
//! come back, and numbers that anybody may read.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::engine::{Engine, EngineSettings, LEAVING};
use super::event::Event;
use super::sounding_object::SoundingObject;
use crate::synthesis::SynthesisError;

/// Events that wait to be taken, at most.
const EVENTS: usize = 8192;

/// Why an event was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SendError {
    /// More than the engine takes in the time of a block; it is counted.
    #[error("{EVENTS} events wait to be played, and there is no room for another")]
    Full,
    /// The engine is gone.
    #[error("the engine is gone")]
    Gone,
}

/// What became of the events.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Impacts and poses taken.
    pub taken: u64,
    /// Events for which the ring had no room.
    pub lost: u64,
    /// Events of numbers that are not finite, of unknown objects, or of a time too far ahead.
    pub refused: u64,
    /// Impacts that came too late, and were played as soon as they could be.
    pub late: u64,
    /// Waves of clicks that were played.
    pub waves: u64,
    /// Waves from so far away that they are not waited for.
    pub distant: u64,
    /// Waves, and impacts on ringing objects, that the budget had no room for.
    pub shed: u64,
    /// The same, under something 80 dB louder.
    pub masked: u64,
    /// Waves of bodies with the receiver inside.
    pub inside: u64,
    /// Ringing objects that were faded out because too many rang.
    pub shed_voices: u64,
    /// Objects that ring.
    pub voices: u64,
    /// Modes that ring.
    pub modes: u64,
    /// Largest pressure in the last block \[Pa\].
    pub peak: f64,
    /// Time of the sample that is rendered next \[s\].
    pub time: f64,
}

const COUNTS: usize = 14;

impl Report {
    fn to_numbers(self) -> [u64; COUNTS] {
        let Report { taken, lost, refused, late, waves, distant, shed, masked, inside, .. } = self;
        let Report { shed_voices, voices, modes, peak, time, .. } = self;
        let [peak, time] = [peak, time].map(f64::to_bits);
        [
            taken,
            lost,
            refused,
            late,
            waves,
            distant,
            shed,
            masked,
            inside,
            shed_voices,
            voices,
            modes,
            peak,
            time,
        ]
    }

    fn of_numbers(numbers: [u64; COUNTS]) -> Self {
        let [taken, lost, refused, late, waves, distant, shed, masked, inside, rest @ ..] = numbers;
        let [shed_voices, voices, modes, peak, time] = rest;
        let [peak, time] = [peak, time].map(f64::from_bits);
        let counts =
            Report { taken, lost, refused, late, waves, distant, shed, masked, inside, ..Report::default() };
        Report { shed_voices, voices, modes, peak, time, ..counts }
    }
}

/// A report that one thread writes and others read; each number by itself is whole.
#[derive(Debug, Default)]
pub(super) struct SharedReport([AtomicU64; COUNTS]);

impl SharedReport {
    pub(super) fn write(&self, report: Report) {
        self.0.iter().zip(report.to_numbers()).for_each(|(shared, n)| shared.store(n, Ordering::Relaxed));
    }

    fn read(&self) -> Report {
        Report::of_numbers(std::array::from_fn(|i| self.0[i].load(Ordering::Relaxed)))
    }
}

/// The audio thread's end of the rings.
pub(super) struct EngineChannels {
    pub(super) events: rtrb::Consumer<Event>,
    pub(super) returned: rtrb::Producer<Box<SoundingObject>>,
    pub(super) report: Arc<SharedReport>,
}

/// Tells an engine what happens, from another thread.
pub struct Controller {
    events: rtrb::Producer<Event>,
    returned: rtrb::Consumer<Box<SoundingObject>>,
    report: Arc<SharedReport>,
    lost: u64,
}

/// An engine, and what controls it.
///
/// # Errors
/// [`SynthesisError`] for a medium, band or room that cannot be.
pub fn engine(settings: &EngineSettings) -> Result<(Controller, Engine), SynthesisError> {
    let (events, taken) = rtrb::RingBuffer::new(EVENTS);
    let (given_back, returned) = rtrb::RingBuffer::new(EVENTS + LEAVING + 2);
    let report = Arc::<SharedReport>::default();
    let channels = EngineChannels { events: taken, returned: given_back, report: Arc::clone(&report) };
    let engine = Engine::new(settings, channels)?;
    Ok((Controller { events, returned, report, lost: 0 }, engine))
}

impl Controller {
    /// Sends an event.
    ///
    /// # Errors
    /// [`SendError`]; the event is gone.
    pub fn send(&mut self, event: Event) -> Result<(), SendError> {
        // What came back is freed here, where there is time for it.
        while self.returned.pop().is_ok() {}
        if self.events.is_abandoned() {
            return Err(SendError::Gone);
        }
        self.events.push(event).map_err(|_| {
            self.lost += 1;
            SendError::Full
        })
    }

    /// Puts an object into a slot, or nothing.
    ///
    /// # Errors
    /// [`SendError`].
    pub fn put(&mut self, slot: usize, object: Option<SoundingObject>) -> Result<(), SendError> {
        self.send(Event::Put { slot, object: object.map(Box::new) })
    }

    /// What became of the events.
    pub fn report(&self) -> Report {
        Report { lost: self.lost, ..self.report.read() }
    }
}
