//! A body to be struck: its surface, its material, and the parts of its sound that are known already.

use std::ffi::OsStr;
use std::path::Path;

use clangor_core::body::Body;
use clangor_core::material::Material;
use clangor_core::reference::pan_file::PanFile;
use clangor_core::sound_model::files::modal_file::ModalFile;
use clangor_core::sound_model::files::model_file::ModelFile;
use clangor_core::sound_model::modal::model::ModalModel;

use super::error::Error;
use super::named_body::{GltfBody, geometry_remarks, preset, shape_or_mesh};
use crate::stages::sound_models::{SoundFile, read_sound_file};

/// A body to be struck, at rest at the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct StruckBody {
    pub(super) body: Body,
    pub(super) known: KnownSound,
    remarks: Vec<String>,
}

/// The parts of the sound of a body that are known before anything is baked.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum KnownSound {
    Nothing,
    /// Modes without their transfers.
    Modes(Box<ModalModel>),
    /// A sound model; without a modal part the body does not ring.
    Model(Box<ModelFile>),
    /// The modal part alone.
    Modal(Box<ModalFile>),
    /// The acceleration part alone, in the representation of \[PAN\].
    Pan(Box<PanFile>),
}

impl StruckBody {
    /// A body from a shape of the library (`"bowl"`, `"box:0.3x0.03x0.01"`) or a mesh file in metres, of a
    /// material preset.
    ///
    /// # Errors
    /// [`Error::Geometry`] and [`Error::Material`].
    pub fn shape(shape: &str, material: &str) -> Result<Self, Error> {
        StruckBody::solid(shape, 1.0, preset(material)?)
    }

    /// A body from a shape of the library, or a mesh file whose unit is `scale` metres.
    ///
    /// # Errors
    /// [`Error::Geometry`].
    pub fn solid(shape: impl AsRef<OsStr>, scale: f64, material: Material) -> Result<Self, Error> {
        let loaded = shape_or_mesh(shape.as_ref(), scale)?;
        let name = shape.as_ref().to_string_lossy();
        let remarks = geometry_remarks(&name, &loaded);
        let body = Body::solid(name, material, loaded.surface, &loaded.mass);
        Ok(StruckBody { remarks, ..body.into() })
    }

    /// The solid that a sound model (`.safetensors`) was baked from, which sounds by that model.
    ///
    /// # Errors
    /// [`Error::SoundFile`], [`Error::Soundbank`] and [`Error::ModelSurface`].
    pub fn model(path: impl AsRef<Path>, material: Material) -> Result<Self, Error> {
        let path = path.as_ref();
        let name = path.to_string_lossy();
        let (solid, radius, known) = match read_sound_file(path)? {
            SoundFile::Model(file) => (file.solid.clone(), file.acceleration.radius, KnownSound::Model(file)),
            SoundFile::Modal(file) => (file.solid.clone(), file.modal.model.radius, KnownSound::Modal(file)),
            SoundFile::Pan(file) => (file.solid.clone(), file.model.radius(), KnownSound::Pan(file)),
            SoundFile::Bank(_) | SoundFile::ModalSoundbank(_) => {
                return Err(Error::Soundbank { path: path.into() });
            }
        };
        let surface = solid
            .body_surface(radius)
            .map_err(|source| Error::ModelSurface { name: name.to_string(), source })?;
        let body = Body::solid(name, material, surface, &solid.mass);
        Ok(StruckBody { body, known, remarks: Vec::new() })
    }

    /// A body named by a word: a shape of the library, a mesh file whose unit is `scale` metres, a sound
    /// model (`.safetensors`), a node of a glTF file (`FILE.glb#NAME`), or a glTF file with the sound of its
    /// bodies (`FILE.glb`, `FILE.glb#NAME`).
    /// Only the last may be without a material.
    ///
    /// # Errors
    /// [`Error::NoMaterial`], and those of [`solid`](Self::solid), [`model`](Self::model) and
    /// [`GltfBody::read`].
    pub fn open(word: impl AsRef<OsStr>, scale: f64, material: Option<Material>) -> Result<Self, Error> {
        let word = word.as_ref();
        let name = word.to_string_lossy();
        if let Some(file) = GltfBody::read(word, scale, material.as_ref())? {
            let GltfBody { geometry, material, modal, remarks } = file;
            let known = modal.map_or(KnownSound::Nothing, |modes| KnownSound::Modes(Box::new(modes)));
            let body = Body::solid(name, material, geometry.surface, &geometry.mass);
            return Ok(StruckBody { body, known, remarks });
        }
        let material = material.ok_or_else(|| Error::NoMaterial { name: name.into() })?;
        match Path::new(word).extension().is_some_and(|ending| ending == "safetensors") {
            true => StruckBody::model(word, material),
            false => StruckBody::solid(word, scale, material),
        }
    }

    /// The body.
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// Mends of its mesh, and properties of a glTF file that are not used, or replaced.
    pub fn remarks(&self) -> &[String] {
        &self.remarks
    }
}

impl From<Body> for StruckBody {
    fn from(body: Body) -> Self {
        StruckBody { body, known: KnownSound::Nothing, remarks: Vec::new() }
    }
}
