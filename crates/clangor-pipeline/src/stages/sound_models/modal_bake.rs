//! The modes of a body and the sound of each, baked.

use std::ops::ControlFlow;

use clangor_bake::acceleration::BakeProgress;
use clangor_bake::cost;
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::modal::held_body::Held;
use clangor_bake::modal::{ModalBakeError, ModalBakeOptions, ModalEvidence, find_held_modes, radiate};
use clangor_bake::statistical::radiate_synthetic_modes;
use clangor_core::body::Body;
use clangor_core::body::support::Support;
use clangor_core::material::Material;
use clangor_core::sound_model::files::modal_file::{ModalFile, ModalOrigin, ModalPart, round_shape};
use clangor_core::sound_model::modal::model::ModalModel;

use super::error::SoundModelError;
use super::obtain::BakedPart;
use super::request::{RequestedPart, SoundModelRequest};
use crate::formats::model_cache::{CacheError, Lookup, ModelCache, given_modes_key, modal_key};

/// How the modes of a body are baked.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalBake {
    /// What the body is made of.
    material: Material,
    /// Its modes, if they are known.
    known: Option<ModalModel>,
    /// What holds it.
    supports: Vec<Support>,
    /// Whether it moves freely with its supports; true without any.
    moves_freely: bool,
    /// Mesh error, accuracy and band.
    options: ModalBakeOptions,
}

impl ModalBake {
    /// Modes of a body of this material, and their transfers.
    pub fn new(material: &Material, options: ModalBakeOptions) -> Self {
        ModalBake {
            material: material.clone(),
            known: None,
            supports: Vec::new(),
            moves_freely: true,
            options,
        }
    }

    /// Modes of a body of a scene or a timeline as its supports hold it, and their transfers.
    pub fn of_body(body: &Body, options: ModalBakeOptions) -> Self {
        let moves_freely = body.supports.is_empty() || body.motion.is_movable();
        ModalBake { supports: body.supports.clone(), moves_freely, ..ModalBake::new(&body.material, options) }
    }

    /// The same bake with another error of frequencies due to the mesh.
    pub(crate) fn with_mesh_error(&self, mesh_error: f64) -> Self {
        ModalBake { options: ModalBakeOptions { mesh_error, ..self.options }, ..self.clone() }
    }

    fn held(&self) -> Held<'_> {
        Held { supports: &self.supports, moves_freely: self.moves_freely }
    }

    /// Operations that finding the modes takes, without their transfers.
    pub(crate) fn operations_of_modes(&self, geometry: &BakeGeometry) -> f64 {
        match self.supports.is_empty() {
            true => cost::of_finding_modes(geometry, &self.material, &self.options),
            false => cost::of_finding_held_modes(geometry, &self.material, &self.options),
        }
    }

    /// Transfers of known modes in the frame of the solid: of those in the band.
    pub fn of_known_modes(material: &Material, mut modes: ModalModel, options: ModalBakeOptions) -> Self {
        modes.medium = options.medium;
        modes.modes.iter_mut().for_each(|mode| round_shape(&mut mode.shape));
        ModalBake { known: Some(modes), ..ModalBake::new(material, options) }
    }
}

/// Whether bodies of the same surface have the same modes.
pub(crate) fn vibrates_alike(body: &Body, other: &Body) -> bool {
    body.material == other.material
        && body.supports == other.supports
        && (body.supports.is_empty() || body.motion.is_movable() == other.motion.is_movable())
}

impl RequestedPart for ModalBake {
    fn key(&self, geometry: &BakeGeometry) -> String {
        match &self.known {
            Some(modes) => given_modes_key(geometry, modes, &self.options),
            None => modal_key(geometry, self.held(), &self.material, &self.options),
        }
    }

    fn draft(&self) -> Self {
        ModalBake { options: self.options.draft(), ..self.clone() }
    }

    fn within(&self, seconds: f64) -> Self {
        ModalBake { options: ModalBakeOptions { patience: seconds, ..self.options }, ..self.clone() }
    }

    fn operations(&self, geometry: &BakeGeometry) -> f64 {
        let free = cost::of_modes(geometry, &self.material, &self.options);
        if self.supports.is_empty() {
            return free;
        }
        let found_free = cost::of_finding_modes(geometry, &self.material, &self.options);
        free + self.operations_of_modes(geometry) - found_free
    }
}

impl BakedPart for ModalBake {
    type File = ModalFile;

    fn bake(
        request: &SoundModelRequest<Self>,
        cache: Option<&ModelCache>,
        progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
    ) -> Result<ModalFile, SoundModelError> {
        Ok(match &request.part.known {
            Some(known) => bake_transfers(request, known, progress)?,
            None => bake_modes(request, cache, progress)?,
        })
    }

    fn rename(request: &SoundModelRequest<Self>, file: &mut ModalFile) {
        file.solid.name.clone_from(&request.solid.name);
        file.modal.origin.material.clone_from(&request.part.material.name);
    }

    fn not_kept(name: &str, error: &CacheError) -> String {
        format!("the modes of \"{name}\" are not kept: {error}")
    }
}

/// Computes the transfers of known modes.
fn bake_transfers(
    request: &SoundModelRequest<ModalBake>,
    known: &ModalModel,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<ModalFile, ModalBakeError> {
    let options = &request.part.options;
    let (mut model, mut evidence) = (known.clone(), evidence_of_known(known));
    model.max_frequency = model.max_frequency.min(options.max_frequency);
    model.modes.retain(|mode| mode.frequency <= options.max_frequency);
    if model.modes.is_empty() {
        evidence.first_frequency = known.modes.first().map(|mode| mode.frequency);
    }
    radiate(&request.geometry, &mut model, &mut evidence, options, progress)?;
    Ok(request.file(model, evidence))
}

/// Computes modes and their transfers; resumes from the modes that an earlier call kept.
fn bake_modes(
    request: &SoundModelRequest<ModalBake>,
    cache: Option<&ModelCache>,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<ModalFile, ModalBakeError> {
    let SoundModelRequest { geometry, part: ModalBake { material, options, .. }, key, .. } = request;
    let kept = cache.and_then(|cache| cache.read_modes(key));
    let (mut model, mut evidence) = match kept {
        Some(ModalFile { modal, .. }) => (modal.model, evidence_of(modal.origin)),
        None => {
            let mut on_progress = |p: &BakeProgress| progress(&BakeProgress { done: MODES * p.done, ..*p });
            let found = find_and_keep(request, cache, &mut on_progress)?.modal;
            (found.model, evidence_of(found.origin))
        }
    };
    let mut on_progress =
        |p: &BakeProgress| progress(&BakeProgress { done: MODES + (1.0 - MODES) * p.done, ..*p });
    radiate(geometry, &mut model, &mut evidence, options, &mut on_progress)?;
    radiate_synthetic_modes(&mut model, request.solid.mass.volume, material);
    Ok(request.file(model, evidence))
}

/// Finds modes without their transfers, and keeps them for a bake that goes on from them.
fn find_and_keep(
    request: &SoundModelRequest<ModalBake>,
    cache: Option<&ModelCache>,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<ModalFile, ModalBakeError> {
    let ModalBake { material, options, .. } = &request.part;
    let held = request.part.held();
    let (model, evidence) = find_held_modes(&request.geometry, held, material, options, progress)?;
    let file = request.file(model, evidence);
    if let Some(cache) = cache.filter(|_| !file.modal.model.modes.is_empty()) {
        // Without a folder to keep them in, a bake that is killed begins again.
        let _ = cache.write_modes(&file);
    }
    Ok(file)
}

/// The modes of a request, with or without their transfers, rounded as in a file: from the cache, or found
/// and kept there. Also returns whether they were in the cache.
///
/// # Errors
/// [`SoundModelError`].
pub(crate) fn obtain_modes(
    request: &SoundModelRequest<ModalBake>,
    cache: Option<&ModelCache>,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<(ModalModel, bool), SoundModelError> {
    let baked = cache.map(|cache| cache.read::<ModalFile>(request.key()));
    if let Some(Lookup::Found(file)) = baked {
        return Ok((file.modal.model, true));
    }
    if let Some(file) = cache.and_then(|cache| cache.read_modes(request.key())) {
        return Ok((file.modal.model, true));
    }
    Ok((find_and_keep(request, cache, progress)?.modal.model, false))
}

/// Share of the work that modes take; estimated.
const MODES: f64 = 0.3;

/// Evidence for modes that were not found here.
fn evidence_of_known(model: &ModalModel) -> ModalEvidence {
    ModalEvidence {
        mesh: "modes from a glTF file".into(),
        nodes: model.surface.nodes.len(),
        ..ModalEvidence::default()
    }
}

/// The evidence in a file.
fn evidence_of(origin: ModalOrigin) -> ModalEvidence {
    ModalEvidence {
        mesh: origin.mesh,
        nodes: origin.nodes as usize,
        residual: origin.residual,
        first_frequency: origin.first_frequency,
        method: origin.method,
        warnings: origin.warnings,
    }
}

impl SoundModelRequest<ModalBake> {
    fn file(&self, model: ModalModel, evidence: ModalEvidence) -> ModalFile {
        let ModalBake { material, options, .. } = &self.part;
        let origin = ModalOrigin {
            program: format!("clangor {}", env!("CARGO_PKG_VERSION")),
            inputs: self.key.clone(),
            material: material.name.clone(),
            youngs_modulus: material.youngs_modulus,
            poisson_ratio: material.poisson_ratio,
            asked_mesh_error: options.mesh_error,
            asked_accuracy: options.accuracy,
            mesh: evidence.mesh,
            nodes: evidence.nodes as u64,
            residual: evidence.residual,
            first_frequency: evidence.first_frequency,
            method: evidence.method,
            warnings: evidence.warnings,
        };
        ModalFile { modal: ModalPart { model, origin }.rounded(), solid: self.solid.clone() }
    }
}
