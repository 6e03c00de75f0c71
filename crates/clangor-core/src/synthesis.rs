//! From impacts to sound pressure at listeners, offline and exact below the band limit.
//!
//! Each body that changes its velocity is an [`AccelerationPulse`], or click. The spectrum of a click at a
//! receiver has a closed form: the spectrum of the force times the transfer function of the source times a
//! delay. It is band-limited by [`lowpass`] and added to the spectrum of its time block. One inverse FFT per
//! block gives the samples, which overlap-add to the signal:
//!
//! ```text
//! clicks ─► Renderer::push ─► Renderer::take_ready ─► BlockJob::render ─► OverlapAdd::add ─► samples \[Pa\]
//!           delays, blocks     whole spans of time    pure: any thread    in order
//! ```
//!
//! Band limitation precedes sampling, so there is no aliasing, and onsets between two samples are exact.
//! Blocks depend on nothing but their clicks and are added in a fixed order: the samples have the same bits
//! for any number of threads and any segmentation in time.
//!
//! The [`source`] of a body is its own field, that of an ellipsoid, or a sphere. During a click the body
//! stays where it was at the onset, and the listener where it was at the arrival.

pub mod acceleration_pulse;
mod band_end_fade;
pub(crate) mod body_interior;
pub mod body_model;
mod field_interpolation;
pub mod field_source;
mod field_spectrum;
pub mod ground;
mod history_spectra;
pub mod listener;
pub mod live_pulses;
pub mod lowpass;
pub mod modal;
pub mod object_file;
pub mod offline;
mod received_wave;
pub mod render_settings;
pub mod sample_rate;
pub(crate) mod sampled_sound;
pub mod source;
pub mod source_rule;
pub(crate) mod spectrum;
mod sphere_spectrum;
pub mod strike;
pub mod strike_error;
pub mod striker;
pub mod struck_sources;
pub mod synthesis_error;
mod wave;

pub use acceleration_pulse::{AccelerationPulse, clicks_of};
pub use body_model::{AccelerationPart, BodyModes, NoModes, SoundModel, SoundPart};
pub use field_source::FieldSource;
pub use listener::Listener;
pub use offline::{BlockJob, BlockMemory, OverlapAdd, RenderReport, RenderedBlock, Renderer};
pub use render_settings::RenderSettings;
pub use sample_rate::SampleRate;
pub use source::SoundSource;
pub use synthesis_error::SynthesisError;
