//! Ringing: the modes of bodies, driven by contact forces, and their pressure at the receivers.
//!
//! ```text
//! ImpactPulse ─► ModalVoice::push_pulses ─► Q = Σ U(x)·j g(t) ─► ResonatorBank: ẇ = λw + Q, A = c (λw + Q)
//!                                           ─► Σ Re{H A} on the emission grid ─► delay r/c ─► samples \[Pa\]
//! ```
//!
//! Each mode of a [`ModalModel`](crate::sound_model::modal::model::ModalModel) obeys q̈ + 2ξω q̇ + ω² q = Q
//! and sounds as Re{H A}, with the transfer H = ρR ×
//! [`undelayed`](crate::sound_model::modal::model::ModalTransfer::undelayed) for the direction and distance
//! of the receiver in the frame of the body, and A the complex modal acceleration ([`resonator_bank`]).
//! Pressure follows acceleration, so a constant force is silent. The sound emitted at t has the pose of that
//! time and arrives at t + r/c, with r the distance from the centre of mass: moving bodies and receivers
//! produce a Doppler shift. A rigid floor adds the mirrored source, as for clicks. The motion is slow against
//! sound: factors 1 + O(v/c) in the level are neglected. A receiver in the bounding sphere of the body gets
//! the pressure on the sphere in its direction, also inside the body.
//!
//! # Use
//!
//! ```text
//! let source = Arc::new(ModalSource::new(model, &body.material.damping, &modal_settings)?);   // per model
//! let mut voice = ModalVoice::new(source, body_id, &poses, &listener, &render_settings)?; // per listener
//! voice.push_pulses(&pulses)?;                 // any order, pulses of other bodies are skipped
//! voice.push_stream(&forces, time_step)?;      // optional: contact::force_stream, for rolling
//! voice.inherit_state(&state)?;                // of a piece: vibration of the body that broke
//! let mut channels = vec![vec![0.0; count]; receivers];
//! voice.render_block(first_sample, &mut channels)?;   // ADDS [Pa]; blocks ascend
//! ```
//!
//! Sample 0 is at `RenderSettings::start`.
//!
//! Voices are independent of each other: render them on any threads and add up in a fixed order. The samples
//! have the same bits for any lengths of blocks. [`ModalVoice::first_sample`] and [`ModalVoice::is_finished`]
//! tell when there is nothing to add.
//!
//! Differs from \[FRAC\] eq. (8), |p| q, which depends on how the modes of a degenerate pair are chosen and
//! is too loud under soft contacts.

mod delay;
mod drive;
mod live_delay;
pub mod live_forces;
pub mod live_pose;
mod live_trail;
pub mod live_voice;
pub mod modal_settings;
pub mod modal_state_transfer;
pub mod resonator_bank;
pub mod source;
pub mod transfer;
pub mod voice;

pub use modal_settings::{ModalPressure, ModalSettings, TransferOrder};
pub use modal_state_transfer::ModalState;
pub use resonator_bank::{Resonance, ResonatorBank};
pub use source::{ModalError, ModalSource, StrikeMemory};
pub use transfer::{TransferEvaluator, TransferMemory};
pub use voice::ModalVoice;
