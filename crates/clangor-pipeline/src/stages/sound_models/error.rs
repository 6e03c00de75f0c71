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

impl SoundModelError {
    /// Estimated CPU time \[s\] of a part that would take longer than allowed; the least, for modes.
    pub fn too_long(&self) -> Option<f64> {
        match self {
            SoundModelError::Acceleration(BakeError::TooLong { seconds, .. })
            | SoundModelError::Modal(ModalBakeError::Surface(BakeError::TooLong { seconds, .. })) => {
                Some(*seconds)
            }
            SoundModelError::Modal(ModalBakeError::ModalAnalysis(error)) => error.too_long(),
            _ => None,
        }
    }
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
