//! Files of sound models and soundbanks.

use std::io;
use std::path::{Path, PathBuf};

use clangor_core::reference::pan_file::{self, PanFile};
use clangor_core::sound_model::files::ellipsoid_bank_file::{self, BankFile};
use clangor_core::sound_model::files::modal_file::{self, ModalFile};
use clangor_core::sound_model::files::modal_soundbank_file::{self, ModalSoundbankFile};
use clangor_core::sound_model::files::model_file::{self, ModelFile};
use clangor_core::sound_model::files::tensor_file::TensorFileError;

use crate::formats::input_file::read_bounded;

/// Largest model that is read \[bytes\].
const MOST_BYTES: u64 = 1 << 32;

/// The content of a file of a sound model or a soundbank.
#[derive(Clone, Debug, PartialEq)]
pub enum SoundFile {
    /// A sound model.
    Model(Box<ModelFile>),
    /// The modes of a body alone.
    Modal(Box<ModalFile>),
    /// A sound model in the representation of \[PAN\].
    Pan(Box<PanFile>),
    /// A bank of ellipsoids.
    Bank(BankFile),
    /// A bank of ringing ellipsoids.
    ModalSoundbank(Box<ModalSoundbankFile>),
}

/// Why a file is neither a model nor a bank.
#[derive(Debug, thiserror::Error)]
pub enum SoundFileError {
    /// It cannot be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// What is in it cannot be used.
    #[error("{path} cannot be used: {source}")]
    Content {
        /// The file.
        path: PathBuf,
        /// Why.
        source: TensorFileError,
    },
}

/// Reads a sound model or a soundbank, and verifies it.
///
/// # Errors
/// [`SoundFileError`].
pub fn read_sound_file(path: &Path) -> Result<SoundFile, SoundFileError> {
    let bytes = read_bounded(path, MOST_BYTES)
        .map_err(|source| SoundFileError::Read { path: path.into(), source })?;
    let content = |source| SoundFileError::Content { path: path.into(), source };
    match ModelFile::decode(&bytes) {
        Err(TensorFileError::Kind { found, .. }) if found == ellipsoid_bank_file::KIND => {
            BankFile::decode(&bytes).map(SoundFile::Bank).map_err(content)
        }
        Err(TensorFileError::Kind { found, .. }) if found == modal_soundbank_file::KIND => {
            ModalSoundbankFile::decode(&bytes).map(Box::new).map(SoundFile::ModalSoundbank).map_err(content)
        }
        Err(TensorFileError::Kind { found, .. }) if found == modal_file::KIND => {
            ModalFile::decode(&bytes).map(Box::new).map(SoundFile::Modal).map_err(content)
        }
        Err(TensorFileError::Kind { found, .. }) if pan_file::is_kind(&found) => {
            PanFile::decode(&bytes).map(Box::new).map(SoundFile::Pan).map_err(content)
        }
        decoded => decoded.map(Box::new).map(SoundFile::Model).map_err(content),
    }
}

/// Reads a sound model.
///
/// # Errors
/// [`SoundFileError`].
pub fn read_model(path: &Path) -> Result<ModelFile, SoundFileError> {
    match read_sound_file(path)? {
        SoundFile::Model(model) => Ok(*model),
        other => {
            let found = match other {
                SoundFile::Pan(_) => pan_file::KIND.into(),
                SoundFile::Modal(_) => modal_file::KIND.into(),
                SoundFile::ModalSoundbank(_) => modal_soundbank_file::KIND.into(),
                _ => ellipsoid_bank_file::KIND.into(),
            };
            let source = TensorFileError::Kind { found, expected: model_file::KIND };
            Err(SoundFileError::Content { path: path.into(), source })
        }
    }
}
