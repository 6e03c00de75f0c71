//! Modes of a free body of any shape up to a frequency, with the discretisation error of each.
//!
//! Frequencies fall as a mesh is refined, and the spectra of both meshes are complete, so that the k-th mode
//! of one corresponds to the k-th of the other. With edges h and r h, the remaining error is
//!
//! ```text
//! f(h) − f(0) ≈ (f(r h) − f(h)) / (r^p − 1),    p = 4 for quadratic elements; less where they are cut
//! ```
//!
//! Meshes are refined until this is below the requested accuracy for all modes, or to the node limit.

pub(crate) mod axisymmetric;
pub mod eigensolver;
mod immersed_body;
mod mesh_errors;
mod mirror_parities;
mod mirrored_box;
pub mod modal_density;
mod plate_mesh;
mod plate_sizes;
mod supported;
mod volume_fem;

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use clangor_core::sound_model::modal::model::ModalMode;
use clangor_core::sound_model::modal::surface::ModalSurface;
use glam::DVec3;

use crate::cost::work_limit::{TooMuchWork, WorkLimit};
use crate::fem::finite_cells::{CellGrid, WrongCell};
use crate::fem::supports::SupportError;
use crate::fem::{ElasticConstants, ElasticSystem};
use crate::geometry_class::bake_geometry::BakeGeometry;
use crate::geometry_class::solver_choice::ModalChoice;
use crate::mesh::tetrahedra::isosurface_stuffing::StuffingError;
use crate::modal_analysis::axisymmetric::AxisymmetricBody;
use crate::modal_analysis::eigensolver::ModalError;
use immersed_body::{CellEffort, ImmersedBody};
use mesh_errors::mesh_errors;
pub use supported::{draft_supported_modal_analysis, supported_modal_analysis};
pub(crate) use volume_fem::plate_nodes;
use volume_fem::{Filling, VolumeFem};

/// Settings of a modal analysis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModalAnalysisOptions {
    /// Upper limit of the band \[Hz\]; all modes below it are found.
    pub max_frequency: f64,
    /// Largest relative change of a frequency by a finer mesh.
    pub accuracy: f64,
    /// Most nodes of a mesh.
    pub most_nodes: usize,
    /// CPU time \[s\], by the operations of the solves, that all meshes together may take.
    pub patience: f64,
}

impl ModalAnalysisOptions {
    /// Default node limit: two gigabytes of factors of tetrahedra, five of cells.
    pub const MOST_NODES: usize = 80_000;

    /// Within 1 %.
    pub fn to(max_frequency: f64) -> Self {
        let (most_nodes, patience) = (Self::MOST_NODES, f64::INFINITY);
        ModalAnalysisOptions { max_frequency, accuracy: 0.01, most_nodes, patience }
    }
}

/// Result of a modal analysis.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalAnalysis {
    /// The modes by frequency, without transfers. Shapes are given at the nodes of the surface.
    pub modes: Vec<ModalMode>,
    /// The surface, in the frame of the geometry.
    pub surface: ModalSurface,
    /// Density of the body [kg/m³].
    pub density: f64,
    /// Upper limit of the band \[Hz\]: the spectrum is complete below it.
    pub max_frequency: f64,
    /// Description of the mesh.
    pub method: String,
    /// Nodes of the finest mesh.
    pub nodes: usize,
    /// Largest ‖K u − ω² M u‖ / ‖ω² M u‖.
    pub residual: f64,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

/// Progress of a modal analysis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModalAnalysisProgress {
    /// Estimated fraction of the work that is done, 0 to 1; less again where a finer mesh is needed.
    pub done: f64,
    /// Nodes of the current mesh.
    pub nodes: usize,
}

/// Reasons why a modal analysis fails.
#[derive(Debug, thiserror::Error)]
pub enum ModalAnalysisError {
    /// Invalid accuracy.
    #[error("the accuracy is {0}, but must be between 0 and 1")]
    Accuracy(f64),
    /// The surface bounds no solid, or cannot be filled with elements.
    #[error(transparent)]
    Mesh(#[from] StuffingError),
    /// The generating curve of an axisymmetric body intersects itself.
    #[error("the section of the body crosses itself")]
    Section,
    /// More than one connected body.
    #[error("the body falls into {0} parts that do not hang together; give each a body of its own")]
    LooseParts(usize),
    /// Even the coarsest mesh that resolves the body is too large.
    #[error("a mesh that resolves the body has {nodes} nodes, more than the {most} allowed")]
    TooLarge {
        /// Nodes needed.
        nodes: usize,
        /// Nodes allowed.
        most: usize,
    },
    /// Waves or walls are too short for the size of the body.
    #[error(
        "walls {wall:.3e} m thick want elements of {edge:.3e} m, {elements:.1e} of them on {nodes:.1e} \
         nodes, more than the {most} allowed; ask for a lower band, or thicken the walls"
    )]
    TooFine {
        /// Thickness \[m\].
        wall: f64,
        /// Edge of the elements \[m\].
        edge: f64,
        /// Number of elements.
        elements: f64,
        /// Number of nodes.
        nodes: f64,
        /// Nodes allowed.
        most: usize,
    },
    /// The supports do not hold the body.
    #[error(transparent)]
    Supports(#[from] SupportError),
    /// The surface crosses itself.
    #[error(transparent)]
    Cell(#[from] WrongCell),
    /// The eigensolver failed.
    #[error(transparent)]
    Modes(#[from] ModalError),
    /// Stopped by the caller.
    #[error("interrupted")]
    Interrupted,
}

impl ModalAnalysisError {
    /// The least CPU time \[s\] of an analysis that would take longer than allowed.
    pub fn too_long(&self) -> Option<f64> {
        match self {
            ModalAnalysisError::Modes(ModalError::TooLong(TooMuchWork { seconds, .. })) => Some(*seconds),
            _ => None,
        }
    }

    /// Whether the factors of a mesh do not fit.
    fn is_memory(&self) -> bool {
        matches!(self, ModalAnalysisError::Modes(ModalError::Memory { .. }))
    }
}

/// Largest number of meshes.
const MOST_MESHES: usize = 7;
/// Factor on the limit for the coarsest spectrum, whose frequencies are too high.
const COARSE_MARGIN: f64 = 1.1;
/// Safety factor on the estimated refinement.
const SAFETY: f64 = 0.85;

/// Finds all modes of a free body, about its centre of mass, up to a frequency.
///
/// # Errors
/// [`ModalAnalysisError`]; [`ModalError::Silent`] if there are none.
pub fn modal_analysis(
    geometry: &BakeGeometry,
    constants: &ElasticConstants,
    options: &ModalAnalysisOptions,
    progress: &mut dyn FnMut(&ModalAnalysisProgress) -> ControlFlow<()>,
) -> Result<ModalAnalysis, ModalAnalysisError> {
    modal_analysis_by(geometry.modal_choice().map_err(StuffingError::Input)?, constants, options, progress)
}

/// Like [`modal_analysis()`], with the matrices of the finest mesh of the whole body, whose mirror planes are
/// not made use of in cells; `None` for an axisymmetric body, which is solved on its section.
///
/// # Errors
/// As [`modal_analysis()`].
pub fn modal_analysis_and_system(
    geometry: &BakeGeometry,
    constants: &ElasticConstants,
    options: &ModalAnalysisOptions,
    progress: &mut dyn FnMut(&ModalAnalysisProgress) -> ControlFlow<()>,
) -> Result<(ModalAnalysis, Option<ElasticSystem>), ModalAnalysisError> {
    let choice = geometry.modal_choice().map_err(StuffingError::Input)?;
    analysed(choice, constants, options, Solved::Whole, progress)
}

/// Like [`modal_analysis()`], with a given discretization.
///
/// # Errors
/// As [`modal_analysis()`].
pub fn modal_analysis_by(
    choice: ModalChoice<'_>,
    constants: &ElasticConstants,
    options: &ModalAnalysisOptions,
    progress: &mut dyn FnMut(&ModalAnalysisProgress) -> ControlFlow<()>,
) -> Result<ModalAnalysis, ModalAnalysisError> {
    analysed(choice, constants, options, Solved::Part, progress).map(|(analysis, _)| analysis)
}

/// What of a body in cells is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Solved {
    /// The part that mirror planes leave.
    Part,
    /// All of it; its matrices are returned.
    Whole,
}

fn analysed(
    choice: ModalChoice<'_>,
    constants: &ElasticConstants,
    options: &ModalAnalysisOptions,
    solved: Solved,
    progress: &mut dyn FnMut(&ModalAnalysisProgress) -> ControlFlow<()>,
) -> Result<(ModalAnalysis, Option<ElasticSystem>), ModalAnalysisError> {
    fn found<B: RefinableDiscretization>(
        body: &B,
        solved: Solved,
        (analysis, mesh): (ModalAnalysis, B::Mesh),
    ) -> (ModalAnalysis, Option<ElasticSystem>) {
        (analysis, (solved == Solved::Whole).then(|| body.system(&mesh)).flatten())
    }
    check(options)?;
    let in_cells = |surface, progress: &mut dyn FnMut(&ModalAnalysisProgress) -> ControlFlow<()>| {
        let body = ImmersedBody::new(surface, constants, options.most_nodes, CellEffort::Accurate)?;
        let body = if solved == Solved::Part { body.by_mirrors(options.accuracy) } else { body };
        refined(&body, constants, options, progress).map(|pair| found(&body, solved, pair))
    };
    let in_elements = |filling, progress: &mut dyn FnMut(&ModalAnalysisProgress) -> ControlFlow<()>| {
        let body = VolumeFem::new(filling, constants, options.most_nodes);
        refined(&body, constants, options, progress).map(|pair| found(&body, solved, pair))
    };
    match choice {
        ModalChoice::Section(axisymmetry) => {
            let body = AxisymmetricBody::new(axisymmetry, constants);
            refined(&body, constants, options, progress).map(|pair| found(&body, solved, pair))
        }
        ModalChoice::Cells(surface) => in_cells(surface, progress),
        ModalChoice::Ball(semi_axes) => in_elements(Filling::Ellipsoid(semi_axes), progress),
        ModalChoice::Hexahedra(edges) => in_elements(Filling::Block(edges), progress),
        ModalChoice::Prisms(plate) => in_elements(Filling::Plate(plate), progress),
    }
}

/// A draft of [`modal_analysis()`]: closed surfaces that are neither flat plates nor of revolution in a few
/// large cells, whatever their walls and creases; the error of each mode says how far off it may be.
///
/// # Errors
/// As [`modal_analysis()`].
pub fn draft_modal_analysis(
    geometry: &BakeGeometry,
    constants: &ElasticConstants,
    options: &ModalAnalysisOptions,
    progress: &mut dyn FnMut(&ModalAnalysisProgress) -> ControlFlow<()>,
) -> Result<ModalAnalysis, ModalAnalysisError> {
    check(options)?;
    let choice = geometry.modal_choice().map_err(StuffingError::Input)?;
    match choice {
        ModalChoice::Cells(surface) => {
            // Without a search for mirror planes, which takes longer than a few cells.
            let body = ImmersedBody::draft(&surface, constants, options.most_nodes)?;
            refined(&body, constants, options, progress).map(|(analysis, _)| analysis)
        }
        other => modal_analysis_by(other, constants, options, progress),
    }
}

fn check(options: &ModalAnalysisOptions) -> Result<(), ModalAnalysisError> {
    if !(options.accuracy > 0.0 && options.accuracy < 1.0) {
        return Err(ModalAnalysisError::Accuracy(options.accuracy));
    }
    if !(options.max_frequency > 0.0 && options.max_frequency.is_finite()) {
        return Err(ModalError::Frequency(options.max_frequency).into());
    }
    Ok(())
}

/// A body that can be meshed at any element size.
pub(crate) trait RefinableDiscretization {
    /// A mesh.
    type Mesh;
    /// Modes of a mesh.
    type Modes;

    /// Description of the elements.
    fn method(&self) -> &'static str;
    /// Order p at which frequencies converge.
    fn convergence(&self) -> f64;
    /// Edge of the first, coarse mesh over that of the second.
    fn first_ratio(&self) -> f64;
    /// A coarse mesh, whose frequencies up to a limit \[Hz\] may have several times the requested error.
    fn coarse(&self, limit: f64, accuracy: f64) -> Result<Self::Mesh, ModalAnalysisError>;
    /// A finer mesh.
    fn finer(
        &self,
        than: &Self::Mesh,
        wanted: &Finer<'_, Self::Modes>,
    ) -> Result<Self::Mesh, ModalAnalysisError>;
    /// Expected error of a mode in that on the mesh before, where this mesh is finer in some places only.
    fn error_share(&self, _mesh: &Self::Mesh, _mode: usize) -> Option<f64> {
        None
    }
    /// Whether a finer mesh must follow, since few nodes may not show errors of this accuracy.
    fn is_to_confirm(&self, _mesh: &Self::Mesh, _accuracy: f64) -> bool {
        false
    }
    /// Number of nodes, and length of edges in any unit.
    fn size(&self, mesh: &Self::Mesh) -> (usize, f64);
    /// All modes up to a limit \[Hz\].
    ///
    /// # Errors
    /// [`ModalError::TooLong`] beyond the limit of work.
    fn solve(
        &self,
        mesh: &Self::Mesh,
        limit: f64,
        work: &WorkLimit,
    ) -> Result<Spectrum<Self::Modes>, ModalAnalysisError>;
    /// 2ξω [1/s] of the first `count` modes by the dampers of supports.
    ///
    /// # Errors
    /// [`SupportError`].
    fn support_damping(
        &self,
        _mesh: &Self::Mesh,
        _modes: &Self::Modes,
        count: usize,
    ) -> Result<Vec<f64>, SupportError> {
        Ok(vec![0.0; count])
    }
    /// The matrices of a mesh, if there is one system of the whole body.
    fn system(&self, mesh: &Self::Mesh) -> Option<ElasticSystem>;
    /// The surface and the first `count` shapes.
    fn shapes(&self, mesh: &Self::Mesh, modes: &Self::Modes, count: usize)
    -> (ModalSurface, Vec<Vec<DVec3>>);
}

/// What a finer mesh is for.
pub(crate) struct Finer<'a, M> {
    /// By how much it is finer, about, in all directions that are not yet fine enough.
    pub(crate) ratio: f64,
    /// Modes of the mesh before.
    pub(crate) modes: &'a M,
    /// Their relative errors; none after the first mesh.
    pub(crate) errors: &'a [f64],
    /// Relative error that is wanted.
    pub(crate) accuracy: f64,
}

/// The modes of one mesh.
pub(crate) struct Spectrum<M> {
    /// Ascending \[Hz\].
    pub(crate) frequencies: Vec<f64>,
    /// The lowest frequency, below or above the limit \[Hz\].
    pub(crate) first: f64,
    /// Largest relative residual.
    pub(crate) residual: f64,
    /// The modes themselves.
    pub(crate) modes: M,
}

/// The modes of a body, and its finest mesh.
fn refined<B: RefinableDiscretization>(
    body: &B,
    constants: &ElasticConstants,
    options: &ModalAnalysisOptions,
    progress: &mut dyn FnMut(&ModalAnalysisProgress) -> ControlFlow<()>,
) -> Result<(ModalAnalysis, B::Mesh), ModalAnalysisError> {
    let mut tell = |done: f64, nodes: usize| match progress(&ModalAnalysisProgress { done, nodes }) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(ModalAnalysisError::Interrupted),
    };
    // Spectrum of the coarse mesh.
    let (limit, work) = (options.max_frequency, WorkLimit::of_seconds(options.patience));
    let mut mesh = body.coarse(limit, options.accuracy)?;
    let (nodes, mut edge) = body.size(&mesh);
    let mut spent = CellGrid::work_of(nodes);
    if nodes > options.most_nodes {
        return Err(ModalAnalysisError::TooLarge { nodes, most: options.most_nodes });
    }
    tell(0.0, nodes)?;
    let mut spectrum = body.solve(&mesh, limit * COARSE_MARGIN, &work)?;
    let mut errors: Vec<f64> = Vec::new();
    let mut ratio = body.first_ratio();
    // Refine until the estimated error meets the accuracy.
    for _ in 1..MOST_MESHES {
        let (modes, accuracy) = (&spectrum.modes, options.accuracy);
        let finer = match body.finer(&mesh, &Finer { ratio, modes, errors: &errors, accuracy }) {
            Err(ModalAnalysisError::TooFine { .. }) => break,
            Err(ModalAnalysisError::Cell(_)) if !errors.is_empty() => break,
            finer => finer?,
        };
        let (nodes, fine_edge) = body.size(&finer);
        if nodes > options.most_nodes {
            break;
        }
        // Of this mesh and those before; whether others follow is not known.
        tell(spent / (spent + CellGrid::work_of(nodes)), nodes)?;
        spent += CellGrid::work_of(nodes);
        let fine = match body.solve(&finer, limit, &work) {
            // The mesh before serves where this one does not fit.
            Err(error) if error.is_memory() && !errors.is_empty() => break,
            fine => fine?,
        };
        // Richardson estimate of the error of each frequency.
        let by_edges = (edge / fine_edge).powf(body.convergence()).recip();
        let share = |mode| body.error_share(&finer, mode);
        errors = mesh_errors(&spectrum.frequencies, &fine.frequencies, (&errors, by_edges), share);
        (mesh, edge, spectrum) = (finer, fine_edge, fine);
        let worst = largest(&errors);
        if worst <= options.accuracy && !body.is_to_confirm(&mesh, options.accuracy) {
            break;
        }
        // Next ratio, from the order of convergence.
        ratio = ((worst / options.accuracy).powf(body.convergence().recip()) / SAFETY).clamp(1.2, 2.5);
    }
    // Modes in the band, and their shapes on the surface.
    let count = spectrum.frequencies.partition_point(|f| *f < limit);
    if count == 0 {
        return Err(ModalError::Silent { first: spectrum.first, limit }.into());
    }
    errors.truncate(count);
    let (surface, shapes) = body.shapes(&mesh, &spectrum.modes, count);
    let damping = body.support_damping(&mesh, &spectrum.modes, count)?;
    let (nodes, _) = body.size(&mesh);
    tell(1.0, nodes)?;
    let analysis = ModalAnalysis {
        modes: modes_of(&spectrum.frequencies, &errors, &damping, shapes),
        surface,
        density: constants.density,
        max_frequency: limit,
        method: body.method().into(),
        nodes,
        residual: spectrum.residual,
        warnings: warnings(&errors, nodes, options),
    };
    Ok((analysis, mesh))
}

fn modes_of(frequencies: &[f64], errors: &[f64], damping: &[f64], shapes: Vec<Vec<DVec3>>) -> Vec<ModalMode> {
    let mode = |(k, shape): (usize, Vec<DVec3>)| ModalMode {
        frequency: frequencies[k],
        mesh_error: errors.get(k).copied().unwrap_or(f64::NAN),
        support_damping: damping[k],
        shape,
        transfer: None,
    };
    shapes.into_iter().enumerate().map(mode).collect()
}

fn largest(errors: &[f64]) -> f64 {
    errors.iter().copied().fold(0.0, f64::max)
}

fn warnings(errors: &[f64], nodes: usize, options: &ModalAnalysisOptions) -> Vec<String> {
    let (worst, asked) = (100.0 * largest(errors), 100.0 * options.accuracy);
    if errors.is_empty() {
        let most = options.most_nodes;
        return vec![format!(
            "how accurate frequencies are is not known: a finer mesh than this of {nodes} nodes would have \
             more than {most}"
        )];
    }
    if worst > asked {
        return vec![format!(
            "frequencies may be off by {worst:.1} % on {nodes} nodes; {asked:.1} % was asked for"
        )];
    }
    Vec::new()
}

/// The shortest wavelength up to a frequency \[m\]: of bending in walls of a thickness \[m\], or along a
/// surface.
///
/// ```text
/// λ = min(√(2π c_p t / (√12 f)), 0.92 c_s / f),    c_p² = E/(ρ (1 − ν²)),    c_s² = μ/ρ
/// ```
pub(crate) fn shortest_wave(constants: &ElasticConstants, wall: f64, limit: f64) -> f64 {
    let ElasticConstants { lame_lambda: lambda, shear_modulus: mu, density } = *constants;
    let plate_speed = (4.0 * mu * (lambda + mu) / (lambda + 2.0 * mu) / density).sqrt();
    let bending = (TAU * plate_speed * wall / (12.0_f64.sqrt() * limit)).sqrt();
    bending.min(0.92 * (mu / density).sqrt() / limit)
}
