//! Why there is no sound model.

use clangor_bake::acceleration::BakeError;
use clangor_bake::modal::ModalBakeError;

/// Why there is no sound model.
#[derive(Debug, thiserror::Error)]
pub enum SoundModelError {
    /// The field of its acceleration cannot be baked.
    #[error(transparent)]
    Acceleration(BakeError),
    /// Its modes or their transfers cannot be baked.
    #[error(transparent)]
    Modal(ModalBakeError),
    /// Stopped by the caller.
    #[error("interrupted")]
    Interrupted,
}

impl From<BakeError> for SoundModelError {
    fn from(error: BakeError) -> Self {
        match error {
            BakeError::Interrupted => SoundModelError::Interrupted,
            error => SoundModelError::Acceleration(error),
        }
    }
}

impl From<ModalBakeError> for SoundModelError {
    fn from(error: ModalBakeError) -> Self {
        match error {
            ModalBakeError::Interrupted => SoundModelError::Interrupted,
            error => SoundModelError::Modal(error),
        }
    }
}
