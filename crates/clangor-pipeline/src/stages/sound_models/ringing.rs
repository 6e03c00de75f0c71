//! How the bodies of a scene ring: their modes and the sound of each, out of the cache, or baked and put
//! there.

use std::ops::ControlFlow;

use clangor_bake::acceleration::BakeProgress;
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::modal::{ModalBakeError, ModalBakeOptions, ModalEvidence, find_modes, radiate};
use clangor_core::body::{Body, Surface};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::material::Material;
use clangor_core::sound_model::files::modal_file::{ModalFile, ModalOrigin, ModalPart, round_shape};
use clangor_core::sound_model::files::model_file::Solid;
use clangor_core::sound_model::modal::model::ModalModel;

use super::{RequestError, radiating};
use crate::formats::model_cache::{Lookup, ModelCache, given_modes_key, modal_key};

/// Modes that somebody wants.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalRequest {
    /// What vibrates.
    geometry: BakeGeometry,
    /// What the file says it was baked from.
    solid: Solid,
    /// Of what.
    material: Material,
    /// Its modes, if they need not be found.
    given: Option<ModalModel>,
    /// How to bake.
    options: ModalBakeOptions,
    /// Hash of all that but names.
    key: String,
}

impl ModalRequest {
    /// A request for the modes of a solid about its centre of mass; `name` is what the person calls it.
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn new(
        name: &str,
        surface: &Surface,
        mass: MassProperties,
        material: &Material,
        options: ModalBakeOptions,
    ) -> Result<Self, RequestError> {
        let (geometry, mesh) = radiating(surface)?;
        let key = modal_key(&geometry, material, &options);
        let solid = Solid { name: name.into(), mass, surface: mesh };
        Ok(ModalRequest { geometry, solid, material: material.clone(), given: None, options, key })
    }

    /// A request for the sound of modes that somebody else found, in the same frame: those in the band.
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn of_modes(
        name: &str,
        surface: &Surface,
        mass: MassProperties,
        material: &Material,
        mut modes: ModalModel,
        options: ModalBakeOptions,
    ) -> Result<Self, RequestError> {
        let (geometry, mesh) = radiating(surface)?;
        modes.medium = options.medium;
        modes.modes.iter_mut().for_each(|mode| round_shape(&mut mode.shape));
        let key = given_modes_key(&geometry, &modes, &options);
        let solid = Solid { name: name.into(), mass, surface: mesh };
        Ok(ModalRequest { geometry, solid, material: material.clone(), given: Some(modes), options, key })
    }

    /// A request for the modes of a body of a scene or a timeline.
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn of_body(body: &Body, options: ModalBakeOptions) -> Result<Self, RequestError> {
        ModalRequest::new(&body.name, &body.surface, super::unit_mass(body), &body.material, options)
    }

    /// Hash of geometry, elasticity, medium and options: bodies of the same key share their modes.
    pub fn key(&self) -> &str {
        &self.key
    }
}

/// Modes, and what had to be done for them.
#[derive(Clone, Debug, PartialEq)]
pub struct ObtainedModes {
    /// The modes.
    pub file: ModalFile,
    /// Whether they were in the cache.
    pub cached: bool,
    /// An entry that had to be replaced, or that could not be kept.
    pub remarks: Vec<String>,
}

/// The modes of a request: from the cache, or baked and put there. A cache that does not work costs time, not
/// the model. Modes whose sound is not computed yet are kept on the way.
///
/// # Errors
/// [`ModalBakeError`].
pub fn obtain_modes(
    request: &ModalRequest,
    cache: Option<&ModelCache>,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<ObtainedModes, ModalBakeError> {
    let mut remarks = Vec::new();
    match cache.map_or(Lookup::Missing, |cache| cache.read_modal(&request.key)) {
        Lookup::Found(mut file) => {
            // Whoever baked it may have called both by other names.
            file.solid.name.clone_from(&request.solid.name);
            file.modal.origin.material.clone_from(&request.material.name);
            return Ok(ObtainedModes { file: *file, cached: true, remarks });
        }
        Lookup::Missing => {}
        Lookup::Invalid(why) => remarks.push(format!("{why}; it is baked again")),
    }
    let file = bake_modes(request, cache, progress)?;
    if let Some(Err(error)) = cache.map(|cache| cache.write_modal(&file)) {
        remarks.push(format!("the modes of \"{}\" are not kept: {error}", request.solid.name));
    }
    Ok(ObtainedModes { file, cached: false, remarks })
}

/// Computes modes and their sound; goes on from the modes that an earlier call kept.
fn bake_modes(
    request: &ModalRequest,
    cache: Option<&ModelCache>,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<ModalFile, ModalBakeError> {
    let ModalRequest { geometry, material, options, key, given, .. } = request;
    if let Some(given) = given {
        let (mut model, mut evidence) = (given.clone(), evidence_of_given(given));
        model.max_frequency = model.max_frequency.min(options.max_frequency);
        model.modes.retain(|mode| mode.frequency <= options.max_frequency);
        if model.modes.is_empty() {
            evidence.first_frequency = given.modes.first().map(|mode| mode.frequency);
        }
        radiate(geometry, &mut model, &mut evidence, options, progress)?;
        return Ok(request.file(model, evidence));
    }
    let kept = cache.and_then(|cache| cache.read_modes(key));
    let (mut model, mut evidence) = match kept {
        Some(ModalFile { modal, .. }) => (modal.model, evidence_of(modal.origin)),
        None => {
            let mut on_progress = |p: &BakeProgress| progress(&BakeProgress { done: MODES * p.done, ..*p });
            let (model, evidence) = find_modes(geometry, material, options, &mut on_progress)?;
            if let Some(cache) = cache.filter(|_| !model.modes.is_empty()) {
                // Without a folder to keep them in, a bake that is killed begins again.
                let _ = cache.write_modes(&request.file(model.clone(), evidence.clone()));
            }
            (model, evidence)
        }
    };
    let mut on_progress =
        |p: &BakeProgress| progress(&BakeProgress { done: MODES + (1.0 - MODES) * p.done, ..*p });
    radiate(geometry, &mut model, &mut evidence, options, &mut on_progress)?;
    Ok(request.file(model, evidence))
}

/// Share of the work that modes take; a guess.
const MODES: f64 = 0.3;

/// What is known of modes that somebody else found.
fn evidence_of_given(model: &ModalModel) -> ModalEvidence {
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

impl ModalRequest {
    fn file(&self, model: ModalModel, evidence: ModalEvidence) -> ModalFile {
        let origin = ModalOrigin {
            program: format!("clangor {}", env!("CARGO_PKG_VERSION")),
            inputs: self.key.clone(),
            material: self.material.name.clone(),
            youngs_modulus: self.material.youngs_modulus,
            poisson_ratio: self.material.poisson_ratio,
            asked_mesh_error: self.options.mesh_error,
            asked_accuracy: self.options.accuracy,
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
