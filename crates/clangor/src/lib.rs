//! Physically based sound for rigid bodies: a scene goes in, the pressure at a listener comes out, in
//! pascals.
//!
//! This crate is the public face of Clangor: it re-exports the runtime (`clangor_core`) at its root, and the
//! offline parts as the modules [`pipeline`], [`bake`] and [`sim`]. Units are SI everywhere.
//!
//! | feature | brings |
//! |---|---|
//! | `offline` (default) | scenes, simulation, baking of sound models, rendering, files |
//! | `realtime` | the engine of an audio thread and live worlds of spheres; no files, no threads |
//! | `gpu` | baking by finite differences in time on a graphics processor |
//! | `playback` | sound through the loudspeaker |
//!
//! # From a scene to a WAV file
//!
//! ```no_run
//! fn main() -> Result<(), clangor::Error> {
//!     let mut session = clangor::Session::open("scenes/ball-drop.toml")?;
//!     let sound = session.render("ball-drop.wav")?;
//!     println!("{} samples, peak {:.2} Pa", sound.frames, sound.peak);
//!     Ok(())
//! }
//! ```
//!
//! # A struck bowl, as samples
//!
//! ```no_run
//! fn main() -> Result<(), clangor::Error> {
//!     let bowl = clangor::StruckBody::shape("bowl", "ceramic")?;
//!     let sound = clangor::Strike::new(bowl) // on top, which is the rim
//!         .impulse([0.0, -0.01, 0.0]) // N s
//!         .listener([0.5, 0.3, 0.5]) // m from the centre of mass
//!         .render()?;
//!     let peak = sound.pressures.iter().fold(0.0_f64, |peak, p| peak.max(p.abs()));
//!     println!("{} samples, peak {peak:.2} Pa", sound.pressures.len());
//!     Ok(())
//! }
//! ```
//!
//! # Two objects and a listener in real time
//!
//! ```
//! use clangor::realtime::{EngineSettings, ImpactEvent, ImpactTarget, SoundingObject, engine};
//!
//! fn main() -> Result<(), Box<dyn std::error::Error>> {
//!     let settings = EngineSettings::default();
//!     let (mut controller, mut engine) = engine(&settings)?; // the engine moves to the audio thread
//!     controller.put(0, Some(SoundingObject::sphere(0.02, &settings)))?;
//!     controller.put(1, Some(SoundingObject::sphere(0.03, &settings)))?;
//!     controller.place_listener([0.0, 0.2, 0.5].into(), [1.0, 0.0, 0.0].into())?;
//!     for (slot, centre, velocity_change) in [(0, -0.02, -1.5), (1, 0.03, 0.45)] {
//!         let impact = ImpactEvent::new(ImpactTarget::Object { slot }, 0.001, 90e-6)
//!             .at([centre, 0.0, 0.0].into())
//!             .with_velocity_change([velocity_change, 0.0, 0.0].into());
//!         controller.send(impact)?;
//!     }
//!     let mut peak = 0.0_f64;
//!     for _block in 0..8 {
//!         let channels = engine.render(128); // pressure [Pa] at the left and the right ear
//!         peak = channels.iter().flatten().fold(peak, |peak, p| peak.max(p.abs()));
//!     }
//!     println!("peak {peak:.2} Pa");
//!     Ok(())
//! }
//! ```

#[cfg(feature = "offline")]
pub use clangor_bake as bake;
pub use clangor_core::*;
#[cfg(feature = "offline")]
pub use clangor_pipeline as pipeline;
#[cfg(feature = "offline")]
pub use clangor_pipeline::session::{
    self, Error, Progress, RenderedSound, Session, SessionBuilder, Stage, Strike, StruckBody,
};
#[cfg(feature = "playback")]
pub use clangor_playback as playback;
#[cfg(feature = "realtime")]
pub use clangor_sim as sim;
