//! The sound model of a body: out of the cache, or baked and put there.

mod piece_proxies;
mod recognise;
pub mod ringers;
pub mod ringing;
pub mod sources;

use std::collections::BTreeMap;
use std::io;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clangor_bake::acceleration::{
    BakeError, BakeOptions, BakeProgress, Resumption, SolvedFrequency, resume_bake,
};
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::reference::{PanForm, PanModelError, pan_model};
use clangor_core::body::{Body, BodyId, Motion, Surface};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::DVec3;
use clangor_core::reference::pan_file::{self, PanFile};
use clangor_core::sound_model::files::ellipsoid_bank_file::{self, BankFile};
use clangor_core::sound_model::files::modal_file::{self, ModalFile};
use clangor_core::sound_model::files::modal_soundbank_file::{self, ModalSoundbankFile};
use clangor_core::sound_model::files::model_file::{self, ModelFile, Origin, Solid};
use clangor_core::sound_model::files::tensor_file::TensorFileError;

use crate::formats::model_cache::{Lookup, ModelCache, model_key};

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
        let (geometry, mesh) = radiating(surface)?;
        let key = model_key(&geometry, &options);
        Ok(ModelRequest { geometry, solid: Solid { name: name.into(), mass, surface: mesh }, options, key })
    }

    /// A request for the field of a body of a scene or a timeline.
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn of_body(body: &Body, options: BakeOptions) -> Result<Self, RequestError> {
        ModelRequest::new(&body.name, &body.surface, unit_mass(body), options)
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

/// What radiates, and its mesh if it has one.
pub(crate) fn radiating(surface: &Surface) -> Result<(BakeGeometry, Option<TriMesh>), RequestError> {
    match surface {
        Surface::HalfSpace => Err(RequestError::HalfSpace),
        Surface::Sphere { radius } => {
            Ok((BakeGeometry::Ellipsoid { semi_axes: DVec3::splat(*radius) }, None))
        }
        Surface::Mesh(surface) => {
            let mesh = &surface.mesh;
            let form = recognise::form(mesh);
            Ok((form.unwrap_or_else(|| BakeGeometry::Mesh(mesh.clone())), Some(mesh.clone())))
        }
    }
}

/// Mass properties of a body if its density were 1.
fn unit_mass(body: &Body) -> MassProperties {
    let density = body.material.density;
    let volume = body.mass / density;
    MassProperties { volume, centre_of_mass: DVec3::ZERO, inertia: body.inertia * density.recip() }
}

/// Computes the model.
///
/// # Errors
/// [`BakeError`].
pub fn bake_model(
    request: &ModelRequest,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<ModelFile, BakeError> {
    bake_model_from(request, Resumption { solved: Vec::new(), keep: &mut |_| () }, progress)
}

fn bake_model_from(
    request: &ModelRequest,
    resumption: Resumption<'_>,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<ModelFile, BakeError> {
    let (acceleration, evidence) = resume_bake(&request.geometry, &request.options, resumption, progress)?;
    Ok(ModelFile {
        acceleration,
        modal: None,
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

/// Time for which a bake that is killed may lose its work: what takes less is not kept on the way.
pub const KEEP_EVERY: Duration = Duration::from_secs(5);

/// The model of a request: from the cache, or baked and put there. A cache that does not work costs time, not
/// the model. What a long bake has solved is kept on the way, so that it goes on from there if it is killed.
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
    let model = match cache {
        Some(cache) => bake_and_keep(request, cache, KEEP_EVERY, progress)?,
        None => bake_model(request, progress)?,
    };
    match cache.map(|cache| cache.write(&model)) {
        Some(Ok(_)) => cache.into_iter().for_each(|cache| cache.remove_partial(&request.key)),
        Some(Err(error)) => {
            remarks.push(format!("the model of \"{}\" is not kept: {error}", request.solid.name));
        }
        None => {}
    }
    Ok(Obtained { model, cached: false, remarks })
}

/// Computes the model, and keeps what is solved in the cache whenever so much time has passed; goes on from
/// what an earlier call kept.
///
/// # Errors
/// [`BakeError`].
pub fn bake_and_keep(
    request: &ModelRequest,
    cache: &ModelCache,
    every: Duration,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<ModelFile, BakeError> {
    let key = request.key.as_str();
    let mut kept_at = Instant::now();
    let mut keep = |solved: &[SolvedFrequency]| {
        // Without a folder to keep it in, a bake that is killed begins again.
        if kept_at.elapsed() >= every && cache.write_partial(key, solved).is_ok() {
            kept_at = Instant::now();
        }
    };
    let resumption = Resumption { solved: cache.read_partial(key), keep: &mut keep };
    bake_model_from(request, resumption, progress)
}

/// A model that bodies of a scene share.
#[derive(Clone, Debug, PartialEq)]
pub struct SharedRequest {
    /// What is wanted.
    pub request: ModelRequest,
    /// Who shares it, ascending.
    pub bodies: Vec<BodyId>,
}

/// What would have to be baked for every moving body that `wants` a field of its own; equal bodies share, in
/// the order of their first.
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

/// A model in the published representation.
///
/// # Errors
/// [`PanModelError`].
pub fn publish(file: &ModelFile, form: PanForm) -> Result<PanFile, PanModelError> {
    let mut origin = file.origin.clone();
    origin.warnings.push(match form {
        PanForm::Angles { rows, columns } => {
            format!("the published representation on {rows} by {columns} directions: compare, do not trust")
        }
        PanForm::Octant { tolerance } => {
            format!("the published representation on an octant, tolerance {tolerance}: compare, do not trust")
        }
    });
    Ok(PanFile { model: pan_model(&file.acceleration, form)?, solid: file.solid.clone(), origin })
}

/// A model or a soundbank that somebody wrote.
#[derive(Clone, Debug, PartialEq)]
pub enum SoundFile {
    /// A sound model.
    Model(Box<ModelFile>),
    /// How a body rings, and nothing else.
    Modal(Box<ModalFile>),
    /// A sound model in the published representation.
    Pan(Box<PanFile>),
    /// A bank of ellipsoids.
    Bank(BankFile),
    /// A bank of ringing ellipsoids.
    ModalSoundbank(Box<ModalSoundbankFile>),
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
