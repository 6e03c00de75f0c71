//! The modes of a body as far up as they can be found: a band that is too wide for a body is narrowed. What
//! is above is statistical (`statistical`).
//!
//! ```text
//! limit ─► all modes below it ─► found
//!   ▲            │ the mesh or its factors are too large
//!   └── × 0.7 ◄──┘                └► a few large cells, if a lower limit makes nothing smaller
//! ```
//!
//! The first limit is that below which the body has about [`MOST_MODES`] modes, in a draft [`DRAFT_MODES`]
//! (`modal_analysis::modal_density`). Neither radiates beyond the highest multipole order.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use clangor_core::material::Material;
use clangor_core::sound_model::modal::model::ModalModel;

use super::held_body::Held;
use super::{Effort, ModalBakeOptions};
use crate::bem::triangles::MOST_ORDER;
use crate::fem::ElasticConstants;
use crate::geometry_class::bake_geometry::BakeGeometry;
use crate::mesh::tetrahedra::isosurface_stuffing::StuffingError;
use crate::modal_analysis::eigensolver::ModalError;
use crate::modal_analysis::modal_density::frequency_of_mode;
use crate::modal_analysis::{ModalAnalysis, ModalAnalysisError, ModalAnalysisOptions, ModalAnalysisProgress};
use crate::statistical::{SPREAD_DB, StatisticalBand};

/// Modes of a draft, by their average density, and nodes of its meshes; more nodes of a body that no narrower
/// band needs fewer for, as a plate of many corners: 7325 of a tuning fork.
const DRAFT_MODES: f64 = 100.0;
const DRAFT_NODES: usize = 4000;
const MOST_DRAFT_NODES: usize = 12_000;
/// Most modes that are found one by one, by their average density: what lies above is statistical.
const MOST_MODES: f64 = 500.0;
/// Factor on the limit after a failure, and the lowest limit \[Hz\].
const NARROWER: f64 = 0.7;
const LOWEST: f64 = 100.0;
/// Factor on the lowest mode, if a narrowed band has none.
const ABOVE_FIRST: f64 = 1.5;
/// Orders that a transfer needs above kR.
const ORDERS_ABOVE: f64 = 4.0;

/// Finds the modes up to the limit of the options, or of a narrower band, which a warning gives.
///
/// # Errors
/// [`ModalAnalysisError`].
pub(super) fn audible_modes(
    (geometry, held): (&BakeGeometry, Held<'_>),
    (material, constants): (&Material, &ElasticConstants),
    options: &ModalBakeOptions,
    progress: &mut dyn FnMut(&ModalAnalysisProgress) -> ControlFlow<()>,
) -> Result<ModalAnalysis, ModalAnalysisError> {
    let volume = geometry.mass_properties().map_err(StuffingError::Input)?.volume;
    let highest = highest_radiating(geometry, options);
    let mut effort = options.effort;
    let mut draft_nodes = DRAFT_NODES;
    let mut limit = first_limit(geometry, volume, material, options);
    let mut needed = None;
    loop {
        let settings = ModalAnalysisOptions {
            max_frequency: limit,
            accuracy: options.mesh_error,
            most_nodes: match effort {
                Effort::Exact => options.most_nodes,
                Effort::Draft => draft_nodes.min(options.most_nodes),
            },
            patience: options.patience,
        };
        match held.modes(geometry, (constants, effort), &settings, progress) {
            Ok(found) => return Ok(found),
            // The estimate put the limit below the lowest mode.
            Err(ModalAnalysisError::Modes(ModalError::Silent { first, .. }))
                if limit < highest && first < options.max_frequency && needed.is_none() =>
            {
                limit = (ABOVE_FIRST * first).min(highest);
                needed = Some((Excess::Elements, f64::INFINITY));
            }
            Err(error) => match excess_of(&error, highest) {
                Some((kind, size))
                    if limit * NARROWER > LOWEST
                        && kind != Excess::Narrow
                        && needed.is_none_or(|(other, last)| kind != other || size < last) =>
                {
                    limit *= NARROWER;
                    needed = Some((kind, size));
                }
                Some(_) if effort == Effort::Exact => {
                    effort = Effort::Draft;
                    limit = first_limit(geometry, volume, material, &ModalBakeOptions { effort, ..*options });
                    needed = None;
                }
                Some((Excess::Nodes, _)) if draft_nodes < MOST_DRAFT_NODES => {
                    draft_nodes = MOST_DRAFT_NODES;
                    limit = first_limit(geometry, volume, material, &ModalBakeOptions { effort, ..*options });
                    needed = None;
                }
                _ => return Err(error),
            },
        }
    }
}

/// The frequency up to which the modes of a body are looked for first \[Hz\]; its volume in m³.
pub(crate) fn first_limit(
    geometry: &BakeGeometry,
    volume: f64,
    material: &Material,
    options: &ModalBakeOptions,
) -> f64 {
    let highest = highest_radiating(geometry, options);
    frequency_of_mode(most_modes(options.effort), volume, geometry.area(), highest, material)
}

fn most_modes(effort: Effort) -> f64 {
    match effort {
        Effort::Exact => MOST_MODES,
        Effort::Draft => DRAFT_MODES,
    }
}

/// The limit of the options, or of the highest multipole order \[Hz\].
fn highest_radiating(geometry: &BakeGeometry, options: &ModalBakeOptions) -> f64 {
    let order = MOST_ORDER as f64 - ORDERS_ABOVE;
    options.max_frequency.min(order * options.medium.sound_speed / (TAU * geometry.bounding_radius()))
}

/// What is too much.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Excess {
    Nodes,
    Unknowns,
    Elements,
    Residual,
    /// The band, once narrowed, has no mode of those that the body has.
    Narrow,
}

/// What a lower limit or a draft would have to make smaller, and its size; `None` for errors that neither
/// mends.
fn excess_of(error: &ModalAnalysisError, highest: f64) -> Option<(Excess, f64)> {
    match error {
        ModalAnalysisError::TooLarge { nodes, .. } => Some((Excess::Nodes, *nodes as f64)),
        ModalAnalysisError::TooFine { nodes, .. } => Some((Excess::Nodes, *nodes)),
        ModalAnalysisError::Modes(ModalError::Memory { unknowns }) => {
            Some((Excess::Unknowns, *unknowns as f64))
        }
        ModalAnalysisError::Mesh(StuffingError::TooFine { .. } | StuffingError::Unresolved { .. }) => {
            Some((Excess::Elements, f64::INFINITY))
        }
        ModalAnalysisError::Modes(ModalError::Inaccurate { residual }) => Some((Excess::Residual, *residual)),
        ModalAnalysisError::Modes(ModalError::Silent { first, .. }) if *first < highest => {
            Some((Excess::Narrow, *first))
        }
        _ => None,
    }
}

/// The remark on a band that is statistical.
pub(super) fn statistical_remark(
    model: &ModalModel,
    band: &StatisticalBand,
    options: &ModalBakeOptions,
) -> String {
    let StatisticalBand { from, modes, stands_for } = *band;
    let reason = match options.effort {
        Effort::Draft => "a draft ends there; a bake of normal quality goes on",
        Effort::Exact => "more modes are too many to be found",
    };
    format!(
        "it rings with its {} modes below {:.2} kHz, and statistically up to {:.2} kHz, where {modes} \
         synthetic modes stand for about {stands_for:.0}, third octaves within about {SPREAD_DB:.0} dB: \
         {reason}",
        model.known_modes().len(),
        from * 1e-3,
        model.max_frequency * 1e-3
    )
}
