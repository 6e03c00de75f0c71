//! Sound models of bodies: from the cache, or baked and kept there.
//!
//! ```text
//! rules ─► SoundModelPlan ─► requests, one per part and form ─► cache or bake ─► SoundModels
//! ```
//!
//! A [`SoundModel`](clangor_core::synthesis::SoundModel) has two parts, the field of a body's acceleration
//! and the modes of its vibration. Each has one kind of request, one kind of cache entry and one way through
//! [`obtain`](obtain()).

pub mod acceleration_bake;
pub mod acceleration_plan;
mod crowd;
pub mod error;
pub mod modal_bake;
pub mod modal_plan;
pub mod model_options;
pub mod obtain;
pub mod other_material;
pub mod pan_representation;
pub mod patience;
mod piece_proxies;
pub mod plan;
pub mod progress;
pub mod quality;
pub mod report;
pub mod request;
pub mod sound_file;
pub mod store;

pub use acceleration_bake::{AccelerationBake, bake_and_keep, bake_model};
pub use acceleration_plan::AccelerationSettings;
pub use error::SoundModelError;
pub use modal_bake::ModalBake;
pub use modal_plan::ModalPlanSettings;
pub use model_options::{ModelOptions, ModelOptionsError};
pub use obtain::{Obtained, obtain};
pub use other_material::OtherMaterial;
pub use pan_representation::pan_representation;
pub use plan::{SoundModelPlan, SoundModelSettings};
pub use progress::SoundModelProgress;
pub use quality::Quality;
pub use report::{ObtainedModel, SoundModels};
pub use request::{RequestError, SoundModelRequest};
pub use sound_file::{SoundFile, SoundFileError, read_model, read_sound_file};
pub use store::SoundModelStore;
