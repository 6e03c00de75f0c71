//! Connection between the thread that knows the events and the audio thread: a wait-free ring of events to
//! the engine, a ring of retired objects back, and counts that any thread may read.

use std::sync::Arc;

use glam::DVec3;

use super::event::Event;
use super::kept_histories::KeptHistories;
use super::report::{Report, SharedReport};
use super::sounding_object::SoundingObject;

/// Capacity of the ring of events.
const EVENTS: usize = 8192;

/// Distance between the two receivers of [`Controller::place_listener`] \[m\].
pub const EAR_DISTANCE: f64 = 0.17;

/// Error of a rejected event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SendError {
    /// More than the engine takes in the time of a block; it is counted.
    #[error("{EVENTS} events wait to be played, and there is no room for another")]
    Full,
    /// The engine is gone.
    #[error("the engine is gone")]
    Gone,
}

/// The audio thread's end of the rings.
pub(super) struct EngineChannels {
    pub(super) events: rtrb::Consumer<Event>,
    pub(super) returned: rtrb::Producer<Box<SoundingObject>>,
    pub(super) report: Arc<SharedReport>,
    /// Not used: the histories must exist as long as the engine.
    _histories: KeptHistories,
}

/// Sends events to an engine from another thread.
pub struct Controller {
    events: rtrb::Producer<Event>,
    returned: rtrb::Consumer<Box<SoundingObject>>,
    report: Arc<SharedReport>,
    histories: KeptHistories,
    lost: u64,
    simplified: u64,
}

/// Both ends of the rings, for an engine that holds up to `held` objects outside its slots.
pub(super) fn channels(held: usize) -> (Controller, EngineChannels) {
    let (events, taken) = rtrb::RingBuffer::new(EVENTS);
    // Room for every object that can have been sent.
    let (given_back, returned) = rtrb::RingBuffer::new(EVENTS + held + 2);
    let report = Arc::<SharedReport>::default();
    let histories = KeptHistories::default();
    let engine = EngineChannels {
        events: taken,
        returned: given_back,
        report: Arc::clone(&report),
        _histories: histories.clone(),
    };
    (Controller { events, returned, report, histories, lost: 0, simplified: 0 }, engine)
}

impl EngineChannels {
    /// Sends an object back to the controller, which frees it.
    pub(super) fn return_object(&mut self, object: Box<SoundingObject>) {
        // The ring has room for every object that can have been sent.
        let _ = self.returned.push(object);
    }
}

impl Controller {
    /// Sends an event: an [`Event`], or an [`ImpactEvent`](super::ImpactEvent).
    ///
    /// # Errors
    /// [`SendError`]; the event is dropped.
    pub fn send(&mut self, event: impl Into<Event>) -> Result<(), SendError> {
        // Returned objects are freed on this thread, which need not meet deadlines.
        while self.returned.pop().is_ok() {}
        if self.events.is_abandoned() {
            return Err(SendError::Gone);
        }
        let mut event = event.into();
        if let Event::Impact(impact) = &mut event
            && let Some(force) = &impact.force
        {
            impact.force = self.histories.sent(force);
            self.simplified += u64::from(impact.force.is_none());
        }
        self.events.push(event).map_err(|_| {
            self.lost += 1;
            SendError::Full
        })
    }

    /// Puts an object into a slot, or empties the slot.
    ///
    /// # Errors
    /// [`SendError`].
    pub fn put(&mut self, slot: usize, object: Option<SoundingObject>) -> Result<(), SendError> {
        self.send(Event::Put { slot, object: object.map(Box::new) })
    }

    /// Places two receivers [`EAR_DISTANCE`] apart around `centre` \[m\]; `right` is the unit vector from the
    /// left one to the right one. An engine with one receiver takes the left one.
    ///
    /// # Errors
    /// [`SendError`].
    pub fn place_listener(&mut self, centre: DVec3, right: DVec3) -> Result<(), SendError> {
        let right = right * (0.5 * EAR_DISTANCE);
        self.send(Event::Receivers([centre - right, centre + right]))
    }

    /// Counts of the events.
    pub fn report(&self) -> Report {
        let report = self.report.read();
        Report { lost: self.lost, simplified: self.simplified + report.simplified, ..report }
    }
}
