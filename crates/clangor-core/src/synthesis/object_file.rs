//! The file of a sound model as an object of a program in real time: what sounds, and the body that is
//! struck.

use std::sync::Arc;

use crate::body::{Body, MeshError};
use crate::material::{Damping, Material, presets};
use crate::sound_model::acceleration::field_evaluator::FieldError;
use crate::sound_model::acceleration::model::AccelerationModel;
use crate::sound_model::files::modal_file::{ModalFile, ModalPart};
use crate::sound_model::files::model_file::{ModelFile, Solid};
use crate::sound_model::files::tensor_file::TensorFileError;
use crate::synthesis::modal::{ModalError, ModalSettings, ModalSource};

/// Error in the bytes of a sound model.
#[derive(Debug, thiserror::Error)]
pub enum ObjectError {
    /// The bytes are neither a sound model nor a modal model.
    #[error("the sound model cannot be read: {0}")]
    File(#[from] TensorFileError),
    /// The field is inconsistent.
    #[error("the field of the sound model cannot be played: {0}")]
    Field(#[from] FieldError),
    /// The modes are inconsistent.
    #[error("the modes of the sound model cannot be played: {0}")]
    Modes(#[from] ModalError),
    /// The damping of the material is not known.
    #[error(
        "the model rings as \"{material}\", which is no material of the library: its damping must be given"
    )]
    UnknownDamping {
        /// Name of the material.
        material: String,
    },
    /// The model names no material, because it has no modal part.
    #[error("the sound model has no modes, and so names no material: it cannot be struck")]
    NoMaterial,
    /// The surface of the solid does not bound a body.
    #[error("the solid of the sound model cannot be struck: {0}")]
    Surface(#[from] MeshError),
}

/// A file of `clangor bake` or `clangor modes`.
#[derive(Clone, Debug)]
pub struct ObjectFile {
    /// The acceleration part, if there is one.
    pub acceleration: Option<AccelerationModel>,
    /// The modal part, if there is one.
    pub modal: Option<ModalPart>,
    /// The solid that was baked.
    pub solid: Solid,
}

impl ObjectFile {
    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// [`ObjectError::File`].
    pub fn decode(bytes: &[u8]) -> Result<Self, ObjectError> {
        match ModelFile::decode(bytes) {
            Ok(ModelFile { acceleration, modal, solid, .. }) => {
                Ok(ObjectFile { acceleration: Some(acceleration), modal, solid })
            }
            Err(error) => match ModalFile::decode(bytes) {
                Ok(ModalFile { modal, solid }) => {
                    Ok(ObjectFile { acceleration: None, modal: Some(modal), solid })
                }
                Err(_) => Err(error.into()),
            },
        }
    }

    /// The modes; without `damping` with that of the library's material that the file names. `None` without a
    /// modal part.
    ///
    /// # Errors
    /// [`ObjectError::UnknownDamping`] and [`ObjectError::Modes`].
    pub fn modal_source(&self, damping: Option<&Damping>) -> Result<Option<Arc<ModalSource>>, ObjectError> {
        let Some(ModalPart { model, origin }) = &self.modal else { return Ok(None) };
        let known = || presets::preset(&origin.material).map(|material| material.damping);
        let Some(damping) = damping.cloned().or_else(known) else {
            return Err(ObjectError::UnknownDamping { material: origin.material.clone() });
        };
        let model = Arc::new(model.clone());
        Ok(Some(Arc::new(ModalSource::new(model, &damping, &ModalSettings::default())?)))
    }

    /// The body that is struck, free and at rest at the origin, of the library's material that the file
    /// names.
    ///
    /// # Errors
    /// [`ObjectError::NoMaterial`], [`ObjectError::UnknownDamping`] for a material that is not in the
    /// library, and [`ObjectError::Surface`].
    pub fn body(&self) -> Result<Body, ObjectError> {
        let modal = self.modal.as_ref().ok_or(ObjectError::NoMaterial)?;
        let name = &modal.origin.material;
        let preset =
            presets::preset(name).ok_or_else(|| ObjectError::UnknownDamping { material: name.clone() })?;
        // The modes were found for these numbers.
        let material = Material {
            density: modal.model.density,
            youngs_modulus: modal.origin.youngs_modulus,
            poisson_ratio: modal.origin.poisson_ratio,
            ..preset
        };
        let radius = self.acceleration.as_ref().map_or(modal.model.radius, |part| part.radius);
        let surface = self.solid.body_surface(radius)?;
        Ok(Body::solid(self.solid.name.clone(), material, surface, &self.solid.mass))
    }
}
