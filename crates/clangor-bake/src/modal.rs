//! Modal sound of one body: its modes, and the radiation of each at its own frequency.
//!
//! ```text
//! geometry, material ─► modal analysis ─► modes ─► ModalSolver ─► transfers ─► ModalModel
//! ```
//!
//! A body whose lowest mode lies above the band is not an error: its model has no modes, and the evidence
//! gives the lowest frequency.

pub(crate) mod audible_modes;
pub mod held_body;

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use clangor_core::material::Material;
use clangor_core::medium::Medium;
use clangor_core::sound_model::files::modal_file::round_shape;
use clangor_core::sound_model::modal::model::ModalModel;
use clangor_core::sound_model::modal::surface::ModalSurface;

use crate::acceleration::{BakeError, BakeProgress, meridian_options, suits_meridian};
pub use crate::effort::Effort;
use crate::fem::{ElasticConstants, ElasticError};
use crate::geometry_class::bake_geometry::{Axisymmetry, BakeGeometry};
use crate::geometry_class::outside::{outer_surface, used_quarters};
use crate::geometry_class::solver_choice::BoundaryChoice;
use crate::mesh::tetrahedra::isosurface_stuffing::StuffingError;
use crate::modal_analysis::eigensolver::ModalError;
use crate::modal_analysis::{ModalAnalysis, ModalAnalysisError, ModalAnalysisOptions, ModalAnalysisProgress};
use crate::modal_radiation::axisymmetric::AxisymmetricModalSolver;
use crate::modal_radiation::surface_modes::SurfaceModes;
use crate::modal_radiation::{ModalMotion, ModalSolver};
use crate::radiation::RadiationError;
use crate::statistical::add_synthetic_modes;
use audible_modes::{audible_modes, statistical_remark};
use held_body::Held;

/// Settings of a modal bake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModalBakeOptions {
    /// Medium of the radiated sound.
    pub medium: Medium,
    /// Upper limit of the band \[Hz\]; all modes below it are found.
    pub max_frequency: f64,
    /// Largest relative change of a frequency by a finer mesh.
    pub mesh_error: f64,
    /// Most nodes of a volume mesh.
    pub most_nodes: usize,
    /// Level error of the transfers.
    pub accuracy: f64,
    /// How much work the bake may be.
    pub effort: Effort,
    /// CPU time \[s\], estimated, that finding the modes may take, and that their transfers may. It is
    /// estimated where meshes are known; the model does not depend on it.
    pub patience: f64,
}

impl ModalBakeOptions {
    /// Up to 20 kHz, within 1 %.
    pub fn new(medium: Medium) -> Self {
        ModalBakeOptions {
            medium,
            max_frequency: 20_000.0,
            mesh_error: 0.01,
            most_nodes: ModalAnalysisOptions::MOST_NODES,
            accuracy: 0.01,
            effort: Effort::Exact,
            patience: f64::INFINITY,
        }
    }

    /// The draft of the same band: without the wish for an accuracy.
    #[must_use]
    pub fn draft(self) -> Self {
        let Self { medium, max_frequency, .. } = self;
        ModalBakeOptions {
            max_frequency,
            mesh_error: DRAFT_MESH_ERROR,
            accuracy: DRAFT_TRANSFER_ERROR,
            effort: Effort::Draft,
            ..Self::new(medium)
        }
    }
}

/// Relative error of the lowest frequency by the mesh that drafts aim at.
const DRAFT_MESH_ERROR: f64 = 0.03;
/// Level error of a transfer that drafts aim at.
const DRAFT_TRANSFER_ERROR: f64 = 0.05;

/// Quality of a model, and the evidence for it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModalEvidence {
    /// Description of the volume mesh.
    pub mesh: String,
    /// Its number of nodes.
    pub nodes: usize,
    /// Largest ‖K u − ω² M u‖ / ‖ω² M u‖.
    pub residual: f64,
    /// The lowest mode \[Hz\] of a body without modes in the band.
    pub first_frequency: Option<f64>,
    /// Solver of the transfers; empty without transfers.
    pub method: String,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

/// Reasons why a modal bake fails.
#[derive(Debug, thiserror::Error)]
pub enum ModalBakeError {
    /// Invalid elastic constants.
    #[error(transparent)]
    Elastic(#[from] ElasticError),
    /// The modal analysis failed.
    #[error(transparent)]
    ModalAnalysis(ModalAnalysisError),
    /// The surface does not suit the radiation solver.
    #[error(transparent)]
    Surface(BakeError),
    /// The radiation solver failed.
    #[error(transparent)]
    Radiation(RadiationError),
    /// Stopped by the caller.
    #[error("interrupted")]
    Interrupted,
}

impl From<RadiationError> for ModalBakeError {
    fn from(error: RadiationError) -> Self {
        match error {
            RadiationError::Interrupted => ModalBakeError::Interrupted,
            error => ModalBakeError::Radiation(error),
        }
    }
}

impl From<BakeError> for ModalBakeError {
    fn from(error: BakeError) -> Self {
        match error {
            BakeError::Interrupted => ModalBakeError::Interrupted,
            BakeError::Radiation(error) => error.into(),
            error => ModalBakeError::Surface(error),
        }
    }
}

impl From<ModalAnalysisError> for ModalBakeError {
    fn from(error: ModalAnalysisError) -> Self {
        match error {
            ModalAnalysisError::Interrupted => ModalBakeError::Interrupted,
            error => ModalBakeError::ModalAnalysis(error),
        }
    }
}

/// Finds the modes of a body about its centre of mass, without transfers, and synthetic ones above the band
/// in which they can be found. Shapes are rounded to file precision, so that a resumed bake gives the same
/// result.
///
/// # Errors
/// [`ModalBakeError`].
pub fn find_modes(
    geometry: &BakeGeometry,
    material: &Material,
    options: &ModalBakeOptions,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<(ModalModel, ModalEvidence), ModalBakeError> {
    find_held_modes(geometry, Held::default(), material, options, progress)
}

/// Like [`find_modes`], of a body with what holds it.
///
/// # Errors
/// [`ModalBakeError`].
pub fn find_held_modes(
    geometry: &BakeGeometry,
    held: Held<'_>,
    material: &Material,
    options: &ModalBakeOptions,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<(ModalModel, ModalEvidence), ModalBakeError> {
    // Modal analysis.
    let constants = ElasticConstants::of(material)?;
    let mut on_progress =
        |p: &ModalAnalysisProgress| progress(&BakeProgress { done: p.done, stage: "finding modes" });
    let body = (geometry, held);
    let found = match audible_modes(body, (material, &constants), options, &mut on_progress) {
        // No mode in the band: an empty model with the lowest frequency.
        Err(ModalAnalysisError::Modes(ModalError::Silent { first, .. })) => {
            return Ok(silent(geometry, material, options, first));
        }
        found => found?,
    };
    let ModalAnalysis { mut modes, surface, density, max_frequency, method, nodes, residual, mut warnings } =
        found;
    // Round the shapes and assemble the model.
    modes.iter_mut().for_each(|mode| round_shape(&mut mode.shape));
    let (radius, medium) = (surface.radius(), options.medium);
    let mut model =
        ModalModel { radius, medium, density, max_frequency, statistical_above: None, surface, modes };
    // Above the modes that were found: statistical ringing.
    let volume =
        geometry.mass_properties().map_err(|e| ModalAnalysisError::Mesh(StuffingError::Input(e)))?.volume;
    if let Some(band) = add_synthetic_modes(&mut model, volume, material, options.max_frequency) {
        warnings.push(statistical_remark(&model, &band, options));
    }
    let evidence = ModalEvidence {
        mesh: method,
        nodes,
        residual,
        first_frequency: None,
        method: String::new(),
        warnings,
    };
    Ok((model, evidence))
}

/// Computes the transfers of the modes, without those of synthetic ones
/// ([`radiate_synthetic_modes`](crate::statistical::radiate_synthetic_modes)).
///
/// # Errors
/// [`ModalBakeError`]; the model is then unchanged.
pub fn radiate(
    geometry: &BakeGeometry,
    model: &mut ModalModel,
    evidence: &mut ModalEvidence,
    options: &ModalBakeOptions,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<(), ModalBakeError> {
    if model.modes.is_empty() {
        return Ok(());
    }
    let known = model.known_modes();
    let count = known.len() as f64;
    let mut on_progress =
        |done: f64| progress(&BakeProgress { done: (done / count).min(1.0), stage: "radiating modes" });
    if on_progress(0.0).is_break() {
        return Err(ModalBakeError::Interrupted);
    }
    // Air in closed cavities is not heard.
    let surface = outer_surface(&model.surface);
    if geometry.encloses_air() && surface.triangles.len() == model.surface.triangles.len() {
        let remark = "the surface of its modes is not closed: the walls of its cavities are heard too";
        evidence.warnings.push(remark.into());
    }
    let (solver, method) = solver(&geometry.outside(), (model, &surface), options, &mut evidence.warnings)?;
    let motions: Vec<ModalMotion<'_>> = known
        .iter()
        .map(|m| ModalMotion { wavenumber: wavenumber(m.frequency, options), shape: &m.shape })
        .collect();
    let wavenumbers: Vec<f64> = motions.iter().map(|motion| motion.wavenumber).collect();
    let (seconds, patience) = (solver.seconds(&wavenumbers), options.patience);
    if seconds > patience {
        return Err(BakeError::TooLong { seconds, patience }.into());
    }
    let transfers = solver.transfers(&surface, &motions, &mut |done| on_progress(done as f64))?;
    for (mode, transfer) in model.modes.iter_mut().zip(transfers) {
        mode.transfer = Some(transfer);
    }
    evidence.method = method.into();
    Ok(())
}

/// The radiation solver for a geometry and its surface that vibrates.
fn solver(
    geometry: &BakeGeometry,
    (model, surface): (&ModalModel, &ModalSurface),
    options: &ModalBakeOptions,
    warnings: &mut Vec<String>,
) -> Result<(Box<dyn ModalSolver>, &'static str), ModalBakeError> {
    let highest = model.known_modes().last().map_or(0.0, |mode| wavenumber(mode.frequency, options));
    let is_draft = options.effort == Effort::Draft;
    let modes = model.known_modes().len();
    let form = geometry.axisymmetry().filter(|form| !is_draft || suits_meridian(form, highest, modes));
    if let Some(Axisymmetry { meridian, axis }) = form {
        let solver = AxisymmetricModalSolver::new(&meridian, axis);
        let solver = if is_draft { solver.with_options(meridian_options(0.0)) } else { solver };
        return Ok((Box::new(solver), "boundary elements on the meridian"));
    }
    let quarters;
    let triangles = match geometry.boundary_choice() {
        BoundaryChoice::Triangles(mesh) => mesh,
        _ => {
            quarters = used_quarters(surface);
            &quarters
        }
    };
    let solver = match options.effort {
        Effort::Exact => {
            let count = model.known_modes().len();
            match SurfaceModes::try_new(triangles, highest, count, options.accuracy) {
                Ok(exact) => exact,
                // A body too large or too thin for the accuracy rings by a draft of its sound.
                Err(error) => {
                    warnings.push(format!("the sound of its modes is a draft: {error}"));
                    let method = "boundary elements on few triangles, as a draft";
                    return Ok((Box::new(SurfaceModes::draft(triangles)?), method));
                }
            }
        }
        Effort::Draft => SurfaceModes::draft(triangles)?,
    };
    let method = solver.method();
    Ok((Box::new(solver), method))
}

/// k of a mode [1/m].
fn wavenumber(frequency: f64, options: &ModalBakeOptions) -> f64 {
    TAU * frequency / options.medium.sound_speed
}

/// Model and evidence of a body without modes in the band.
fn silent(
    geometry: &BakeGeometry,
    material: &Material,
    options: &ModalBakeOptions,
    first: f64,
) -> (ModalModel, ModalEvidence) {
    let model = ModalModel {
        radius: geometry.bounding_radius(),
        medium: options.medium,
        density: material.density,
        max_frequency: options.max_frequency,
        statistical_above: None,
        surface: ModalSurface::default(),
        modes: Vec::new(),
    };
    (model, ModalEvidence { first_frequency: Some(first), ..ModalEvidence::default() })
}
