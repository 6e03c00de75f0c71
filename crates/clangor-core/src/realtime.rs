//! Sound as it happens: events go in through a wait-free ring, blocks of samples come out.
//!
//! ```text
//! any thread: Controller::send ─► ring ─► Engine::render, on the audio thread
//!    impact ─► waves: direct and reflected, earliest first, as many as the budget allows ─► LivePulses ─┐
//!        └─► force ─► LiveVoice of the object that is struck: modes, transfers, delays ───────────────┼─► pressure \[Pa\]
//!    reflections in one wall ─► LateReverberation ────────────────────────────────────────────────────┘
//! ```
//!
//! The same sources, forces and fields as offline. On the audio thread nothing is allocated, freed or waited
//! for, and a block takes bounded time: the [`Budget`] says how many waves and modes it may compute. What
//! goes beyond is left out, weakest first, and counted; a ringing body that is left out is faded within a
//! block. An event of time t is heard, besides its way through the air, [`Engine::latency`] after t; one that
//! comes too late is heard as soon as it can be.
//!
//! # Use
//!
//! ```text
//! let (mut controller, mut engine) = engine(&settings)?;
//! controller.put(0, Some(SoundingObject::from_file(&bytes, None, &settings)?))?;       // a bowl, say
//! controller.send(Event::ImpactEvent(impact))?;                                                 // from the physics
//! let channels = engine.render(128);                                                   // in the audio callback
//! ```
//!
//! Differs from the offline renderer: see [`live_clicks`](crate::synthesis::live_pulses),
//! [`live_voice`](crate::synthesis::modal::live_voice). What late reverberation hears is what the first
//! receiver hears of each wall, and nothing of what that one does not hear, being inside a body or out of
//! reach; a click is heard where the receivers are when it happens. Asked for fewer than 32 samples at a
//! time, what fades does so within them.

mod budget;
pub mod engine;
pub mod event;
pub mod event_ring;
pub mod playback_level;
mod schedule;
pub mod sounding_object;
mod wave_queue;

pub use budget::Budget;
pub use engine::{Engine, EngineSettings};
pub use event::{Event, ImpactEvent, ImpactTarget, Part};
pub use event_ring::{Controller, Report, SendError, engine};
pub use playback_level::PlaybackLevel;
pub use sounding_object::{ObjectError, SoundingObject};
