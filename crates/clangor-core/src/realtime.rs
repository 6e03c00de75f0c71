//! Sound in real time: events go in through a wait-free ring, blocks of samples come out.
//!
//! ```text
//! any thread: Controller::send ─► ring ─► Engine::render, on the audio thread
//!    Scheduler: events in the order of their times, within the Budget
//!    ObjectTable: slots; voices of modal objects ────────────────────────────┐
//!    BlockRenderer: impact ─► waves of the acceleration pulse by each path ──┼─► pressure \[Pa\]
//!                   first reflections of the walls ─► late reverberation ────┘
//! ```
//!
//! The sources, forces and fields are those of the offline renderer. On the audio thread nothing is
//! allocated, freed or waited for, and the [`Budget`] bounds the waves and modes computed in a block. Beyond
//! the budget, the weakest sounds are left out and counted; a modal object that is left out fades within a
//! block. An event of time t is heard [`Engine::latency`] after t, plus its propagation delay. A late event
//! is heard as soon as possible.
//!
//! # Use
//!
//! Two steel spheres of 2 cm and 3 cm radius collide at 1 m/s:
//!
//! ```
//! use clangor_core::glam::DVec3;
//! use clangor_core::realtime::*;
//!
//! let settings = EngineSettings::default();
//! let (mut controller, mut engine) = engine(&settings)?; // the engine moves to the audio thread
//! controller.put(0, Some(SoundingObject::sphere(0.02, &settings)))?; // or from_file, or with modes
//! controller.put(1, Some(SoundingObject::sphere(0.03, &settings)))?;
//! controller.place_listener(DVec3::new(0.0, 0.2, 0.5), DVec3::X)?;
//! for (slot, centre, velocity_change) in [(0, -0.02, -1.5), (1, 0.03, 0.45)] {
//!     let impact = ImpactEvent::new(ImpactTarget::Object { slot }, 0.001, 90e-6)
//!         .at(centre * DVec3::X)
//!         .with_velocity_change(velocity_change * DVec3::X);
//!     controller.send(impact)?;
//! }
//! let (level, mut loudest) = (PlaybackLevel { full_scale: 20.0 }, 0.0_f32);
//! for _block in 0..8 {
//!     let channels = engine.render(128); // pressure [Pa] at the left and the right ear
//!     loudest = channels.iter().flatten().map(|p| level.sample(*p).abs()).fold(loudest, f32::max);
//! }
//! assert!(loudest > 0.01);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Differs from the offline renderer: see [`live_pulses`](crate::synthesis::live_pulses) and
//! [`live_voice`](crate::synthesis::modal::live_voice). The first receiver alone feeds the late
//! reverberation, with the reflections that it receives: none from beyond the reach or while it is inside the
//! body. An acceleration pulse is heard at the positions of the receivers at the time of the impact. In
//! blocks of fewer than 32 samples, fades are as short as the block.

mod block_renderer;
mod budget;
pub mod controller;
pub mod engine;
pub mod engine_settings;
pub mod event;
pub mod event_row;
mod kept_histories;
mod object_table;
pub mod playback_level;
mod receivers;
pub mod report;
mod schedule;
mod scheduler;
pub mod sounding_object;
mod wave_queue;

pub use budget::Budget;
pub use controller::{Controller, EAR_DISTANCE, SendError};
pub use engine::{Engine, engine};
pub use engine_settings::EngineSettings;
pub use event::{Event, ImpactEvent, ImpactTarget, Part};
pub use playback_level::PlaybackLevel;
pub use report::Report;
pub use scheduler::HORIZON;
pub use sounding_object::SoundingObject;
