//! The vibration of a free body of any form: its modes up to a frequency, and how far each is from a finer mesh.
//!
//! The frequency of mode k falls as the mesh is refined, and the spectra of two meshes are complete, so that the k-th
//! of one belongs to the k-th of the other. From the edges h and r h of their elements follows what is still missing:
//!
//! ```text
//! f(h) − f(0) ≈ (f(r h) − f(h)) / (r^p − 1),    p = 4 for quadratic elements; less where layers are few or the surface is cut anew
//! ```
//!
//! Meshes are refined until that is less than the part asked for, in all modes, or until the nodes run out.

mod mesh_family;

use std::ops::ControlFlow;

use clangor::model::modal_model::ModalMode;
use clangor::model::modal_surface::ModalSurface;
use glam::DVec3;

use crate::acceleration_noise::BakeGeometry;
use crate::elasticity::{ElasticConstants, ElasticSystem};
use crate::modes::{ModalError, Mode, Modes, solve};
use crate::tetrahedra::TetMesh;
use crate::tetrahedra::stuffing::StuffingError;
use mesh_family::MeshFamily;

/// How to find modes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VibrationOptions {
    /// All modes below this are found \[Hz\].
    pub max_frequency: f64,
    /// Part of itself by which a finer mesh may change a frequency.
    pub accuracy: f64,
    /// Most nodes of a mesh.
    pub most_nodes: usize,
}

impl VibrationOptions {
    /// Within 1 %, on at most 40 000 nodes.
    pub fn to(max_frequency: f64) -> Self {
        VibrationOptions { max_frequency, accuracy: 0.01, most_nodes: 40_000 }
    }
}

/// How a body vibrates.
#[derive(Clone, Debug, PartialEq)]
pub struct Vibration {
    /// The modes by frequency, without transfers; shapes are given at the nodes of the surface.
    pub modes: Vec<ModalMode>,
    /// The surface, in the frame of the geometry.
    pub surface: ModalSurface,
    /// Density of the body [kg/m³].
    pub density: f64,
    /// All modes below this are there \[Hz\].
    pub max_frequency: f64,
    /// What meshes were used, in words.
    pub method: String,
    /// Nodes of the finest mesh.
    pub nodes: usize,
    /// Largest ‖K u − ω² M u‖ / ‖ω² M u‖.
    pub residual: f64,
    /// What a user should know.
    pub warnings: Vec<String>,
}

/// How far a computation is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VibrationProgress {
    /// Part of the work that is done, 0 to 1; a guess.
    pub done: f64,
    /// Nodes of the mesh that is solved now.
    pub nodes: usize,
}

/// Why there are no modes.
#[derive(Debug, thiserror::Error)]
pub enum VibrationError {
    /// The accuracy makes no sense.
    #[error("the accuracy is {0}, but must be between 0 and 1")]
    Accuracy(f64),
    /// The body cannot be filled with tetrahedra.
    #[error(transparent)]
    Mesh(#[from] StuffingError),
    /// Even the coarsest mesh that resolves the body is too large.
    #[error("a mesh that resolves the body has {nodes} nodes, more than the {most} allowed")]
    TooLarge {
        /// Nodes needed.
        nodes: usize,
        /// Nodes allowed.
        most: usize,
    },
    /// The modes of a mesh could not be found.
    #[error(transparent)]
    Modes(#[from] ModalError),
    /// Stopped by the caller.
    #[error("interrupted")]
    Interrupted,
}

/// Edge of the first, coarser mesh over that of the second.
const FIRST_RATIO: f64 = 1.5;
/// Meshes at most.
const MOST_MESHES: usize = 5;
/// The coarser spectrum is sought a little further, because its frequencies are higher.
const COARSE_MARGIN: f64 = 1.1;
/// A mesh is made a little finer than the estimate says.
const SAFETY: f64 = 0.85;

/// Finds all modes of a free body, about its centre of mass, up to a frequency.
///
/// # Errors
/// [`VibrationError`]; [`ModalError::Silent`] if there are none.
pub fn vibration(
    geometry: &BakeGeometry,
    constants: &ElasticConstants,
    options: &VibrationOptions,
    progress: &mut dyn FnMut(&VibrationProgress) -> ControlFlow<()>,
) -> Result<Vibration, VibrationError> {
    if !(options.accuracy > 0.0 && options.accuracy < 1.0) {
        return Err(VibrationError::Accuracy(options.accuracy));
    }
    if !(options.max_frequency > 0.0 && options.max_frequency.is_finite()) {
        return Err(ModalError::Frequency(options.max_frequency).into());
    }
    let family = MeshFamily::of(geometry)?;
    let mut tell = |done: f64, nodes: usize| match progress(&VibrationProgress { done, nodes }) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(VibrationError::Interrupted),
    };
    let limit = options.max_frequency;
    let first = FIRST_RATIO * family.first_edge(constants, limit, options.accuracy);
    let mut sized = family.coarse(first)?;
    let nodes = sized.mesh.nodes.len();
    if nodes > options.most_nodes {
        return Err(VibrationError::TooLarge { nodes, most: options.most_nodes });
    }
    tell(0.0, nodes)?;
    let mut solution = Solution::of(&sized.mesh, constants, limit * COARSE_MARGIN)?;
    let mut ratio = FIRST_RATIO;
    for meshes in 2..=MOST_MESHES {
        let finer = family.finer(&sized, ratio)?;
        if finer.mesh.nodes.len() > options.most_nodes {
            break;
        }
        tell(1.0 - 0.5_f64.powi(meshes as i32 - 1), finer.mesh.nodes.len())?;
        let times = (sized.edge / finer.edge).powf(family.order());
        sized = finer;
        solution = Solution::of(&sized.mesh, constants, limit)?.compared_with(&solution, times);
        let worst = solution.worst_error();
        if worst <= options.accuracy {
            break;
        }
        ratio = ((worst / options.accuracy).powf(family.order().recip()) / SAFETY).clamp(1.2, 2.5);
    }
    let vibration = solution.finished(&sized.mesh, &family, constants, options)?;
    tell(1.0, vibration.nodes)?;
    Ok(vibration)
}

/// The modes of one mesh.
struct Solution {
    modes: Result<Modes, Silence>,
    errors: Vec<f64>,
}

/// There are no modes in the band; the frequency of the first \[Hz\].
#[derive(Clone, Copy, Debug)]
struct Silence(f64);

impl Solution {
    fn of(mesh: &TetMesh, constants: &ElasticConstants, limit: f64) -> Result<Self, ModalError> {
        let modes = match solve(&ElasticSystem::new(mesh, constants), limit) {
            Ok(modes) => Ok(modes),
            // A finer mesh may have some.
            Err(ModalError::Silent { first, .. }) => Err(Silence(first)),
            Err(error) => return Err(error),
        };
        Ok(Solution { modes, errors: Vec::new() })
    }

    fn modes(&self) -> &[Mode] {
        self.modes.as_ref().map_or(&[], |modes| &modes.modes)
    }

    /// With errors by a coarser solution whose errors are `times` as large.
    fn compared_with(mut self, coarser: &Solution, times: f64) -> Self {
        let share = 1.0 / (times - 1.0);
        let pairs = coarser.modes().iter().zip(self.modes());
        let mut errors: Vec<f64> =
            pairs.map(|(b, m)| (b.frequency / m.frequency - 1.0).abs() * share).collect();
        // A mode that the coarser mesh moved beyond the band has the error of the worst that it did not.
        let worst = errors.iter().copied().reduce(f64::max).unwrap_or((COARSE_MARGIN - 1.0) * share);
        errors.resize(self.modes().len(), worst);
        self.errors = errors;
        self
    }

    fn worst_error(&self) -> f64 {
        self.errors.iter().copied().fold(0.0, f64::max)
    }

    /// What is below the limit.
    fn finished(
        self,
        mesh: &TetMesh,
        family: &MeshFamily<'_>,
        constants: &ElasticConstants,
        options: &VibrationOptions,
    ) -> Result<Vibration, VibrationError> {
        let limit = options.max_frequency;
        let silent = |first: f64| VibrationError::from(ModalError::Silent { first, limit });
        let modes = self.modes.as_ref().map_err(|first| silent(first.0))?;
        let count = modes.modes.partition_point(|m| m.frequency < limit);
        if count == 0 {
            return Err(silent(modes.modes[0].frequency));
        }
        let mut warnings = Vec::new();
        let (nodes, asked) = (mesh.nodes.len(), 100.0 * options.accuracy);
        let worst = self.errors.iter().take(count).copied().fold(0.0, f64::max);
        if self.errors.is_empty() {
            warnings.push(format!(
                "how accurate frequencies are is not known: a finer mesh than this of {nodes} nodes would have more \
                 than {}",
                options.most_nodes
            ));
        } else if worst > options.accuracy {
            let worst = 100.0 * worst;
            warnings.push(format!(
                "frequencies may be off by {worst:.1} % on {nodes} nodes; {asked:.1} % was asked for"
            ));
        }
        let (surface, kept) = modal_surface(mesh);
        let error = |k: usize| self.errors.get(k).copied().unwrap_or(f64::NAN);
        let mode = |(k, mode): (usize, &Mode)| ModalMode {
            frequency: mode.frequency,
            mesh_error: error(k),
            shape: kept.iter().map(|n| mode.shape[*n as usize]).collect(),
            transfer: None,
        };
        Ok(Vibration {
            modes: modes.modes.iter().take(count).enumerate().map(mode).collect(),
            surface,
            density: constants.density,
            max_frequency: limit,
            method: family.name().into(),
            nodes,
            residual: modes.residual,
            warnings,
        })
    }
}

/// The surface of a mesh, and which of its nodes are those of the surface.
fn modal_surface(mesh: &TetMesh) -> (ModalSurface, Vec<u32>) {
    let mut triangles = mesh.surface();
    let mut kept: Vec<u32> = triangles.iter().flatten().copied().collect();
    kept.sort_unstable();
    kept.dedup();
    for node in triangles.iter_mut().flatten() {
        *node = kept.partition_point(|k| *k < *node) as u32;
    }
    let nodes: Vec<DVec3> = kept.iter().map(|n| mesh.nodes[*n as usize]).collect();
    (ModalSurface { nodes, triangles }, kept)
}
