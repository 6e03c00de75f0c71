//! The sound model of a body: out of the cache, or baked and put there.

mod recognise;
pub mod sources;

use std::collections::BTreeMap;
use std::io;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clangor::body::{Body, BodyId, Motion, Surface};
use clangor::geometry::mass_properties::MassProperties;
use clangor::glam::DVec3;
use clangor::model::bank_file::{self, BankFile};
use clangor::model::model_file::{self, ModelFile, Origin, Solid};
use clangor::model::tensor_file::TensorFileError;
use clangor_bake::acceleration_noise::{BakeError, BakeGeometry, BakeOptions, BakeProgress, bake};

use crate::model_cache::{Lookup, ModelCache, model_key};

/// A model that somebody wants.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelRequest {
    /// What radiates.
    geometry: BakeGeometry,
    /// What the file says it was baked from.
    solid: Solid,
    /// How to bake.
    options: BakeOptions,
    /// Hash of geometry and options.
    key: String,
}

/// Why a body has no field of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RequestError {
    /// It is the ground.
    #[error("a half-space does not move, and has no sound of its own")]
    HalfSpace,
}

impl ModelRequest {
    /// A request for the field of a surface about its centre of mass; `name` is what the person calls it.
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn new(
        name: &str,
        surface: &Surface,
        mass: MassProperties,
        options: BakeOptions,
    ) -> Result<Self, RequestError> {
        let (geometry, mesh) = match surface {
            Surface::HalfSpace => return Err(RequestError::HalfSpace),
            Surface::Sphere { radius } => {
                (BakeGeometry::Ellipsoid { semi_axes: DVec3::splat(*radius) }, None)
            }
            Surface::Mesh(surface) => {
                let mesh = &surface.mesh;
                let exact = recognise::exact_form(mesh);
                (exact.unwrap_or_else(|| BakeGeometry::Mesh(mesh.clone())), Some(mesh.clone()))
            }
        };
        let key = model_key(&geometry, &options);
        Ok(ModelRequest { geometry, solid: Solid { name: name.into(), mass, surface: mesh }, options, key })
    }

    /// A request for the field of a body of a scene or a timeline.
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn of_body(body: &Body, options: BakeOptions) -> Result<Self, RequestError> {
        let density = body.material.density;
        let volume = body.mass / density;
        let mass =
            MassProperties { volume, centre_of_mass: DVec3::ZERO, inertia: body.inertia * density.recip() };
        ModelRequest::new(&body.name, &body.surface, mass, options)
    }

    /// What radiates.
    pub fn geometry(&self) -> &BakeGeometry {
        &self.geometry
    }

    /// Hash of geometry and options: bodies of the same key share a model.
    pub fn key(&self) -> &str {
        &self.key
    }
}

/// Computes the model.
///
/// # Errors
/// [`BakeError`].
pub fn bake_model(
    request: &ModelRequest,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<ModelFile, BakeError> {
    let (acceleration, evidence) = bake(&request.geometry, &request.options, progress)?;
    Ok(ModelFile {
        acceleration,
        solid: request.solid.clone(),
        origin: Origin {
            program: format!("clangor {}", env!("CARGO_PKG_VERSION")),
            inputs: request.key.clone(),
            asked_accuracy: request.options.accuracy,
            method: evidence.method,
            unknowns: evidence.unknowns as u64,
            solves: evidence.solves as u64,
            held_out_error: evidence.held_out_error,
            warnings: evidence.warnings,
        },
    })
}

/// A model, and what had to be done for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Obtained {
    /// The model.
    pub model: ModelFile,
    /// Whether it was in the cache.
    pub cached: bool,
    /// An entry that had to be replaced, or that could not be kept.
    pub remarks: Vec<String>,
}

/// The model of a request: from the cache, or baked and put there. A cache that does not work costs time, not the model.
///
/// # Errors
/// [`BakeError`].
pub fn obtain(
    request: &ModelRequest,
    cache: Option<&ModelCache>,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<Obtained, BakeError> {
    let mut remarks = Vec::new();
    match cache.map_or(Lookup::Missing, |cache| cache.read(&request.key)) {
        Lookup::Found(mut model) => {
            // Whoever baked it may have called it by another name.
            model.solid.name.clone_from(&request.solid.name);
            return Ok(Obtained { model: *model, cached: true, remarks });
        }
        Lookup::Missing => {}
        Lookup::Invalid(why) => remarks.push(format!("{why}; it is baked again")),
    }
    let model = bake_model(request, progress)?;
    if let Some(Err(error)) = cache.map(|cache| cache.write(&model)) {
        remarks.push(format!("the model of \"{}\" is not kept: {error}", request.solid.name));
    }
    Ok(Obtained { model, cached: false, remarks })
}

/// A model that bodies of a scene share.
#[derive(Clone, Debug, PartialEq)]
pub struct SharedRequest {
    /// What is wanted.
    pub request: ModelRequest,
    /// Who shares it, ascending.
    pub bodies: Vec<BodyId>,
}

/// What would have to be baked for every moving body that `wants` a field of its own; equal bodies share, in the order of
/// their first.
pub fn shared_requests(
    bodies: &[Body],
    options: BakeOptions,
    wants: &dyn Fn(BodyId) -> bool,
) -> Vec<SharedRequest> {
    let mut shared: Vec<SharedRequest> = Vec::new();
    let mut known: BTreeMap<String, usize> = BTreeMap::new();
    for (index, body) in bodies.iter().enumerate() {
        let id = BodyId(index as u32);
        if body.motion == Motion::Fixed || !wants(id) {
            continue;
        }
        let Ok(request) = ModelRequest::of_body(body, options) else { continue };
        match known.get(&request.key) {
            Some(at) => shared[*at].bodies.push(id),
            None => {
                known.insert(request.key.clone(), shared.len());
                shared.push(SharedRequest { request, bodies: vec![id] });
            }
        }
    }
    shared
}

/// A model or a soundbank that somebody wrote.
#[derive(Clone, Debug, PartialEq)]
pub enum SoundFile {
    /// A sound model.
    Model(Box<ModelFile>),
    /// A bank of ellipsoids.
    Bank(BankFile),
}

/// Why a file is no model and no bank.
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
    let bytes = std::fs::read(path).map_err(|source| SoundFileError::Read { path: path.into(), source })?;
    let content = |source| SoundFileError::Content { path: path.into(), source };
    match ModelFile::decode(&bytes) {
        Err(TensorFileError::Kind { found, .. }) if found == bank_file::KIND => {
            BankFile::decode(&bytes).map(SoundFile::Bank).map_err(content)
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
        SoundFile::Bank(_) => {
            let found = bank_file::KIND.into();
            let source = TensorFileError::Kind { found, expected: model_file::KIND };
            Err(SoundFileError::Content { path: path.into(), source })
        }
    }
}
