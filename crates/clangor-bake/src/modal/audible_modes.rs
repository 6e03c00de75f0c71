//! The modes of a body as far up as they can be found: a band that is too wide for a body is narrowed, and
//! the modes left out are said.
//!
//! ```text
//! limit ─► all modes below it ─► found
//!   ▲            │ the mesh or its factors are too large
//!   └── × 0.7 ◄──┘                └► a few large cells, if a lower limit makes nothing smaller
//! ```
//!
//! A draft begins with the limit below which the body has about [`DRAFT_MODES`] modes
//! (`modal_analysis::modal_density`). Neither radiates beyond the highest multipole order.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use clangor_core::material::Material;

use super::held_body::Held;
use super::{Effort, ModalBakeOptions};
use crate::bem::triangles::MOST_ORDER;
use crate::fem::ElasticConstants;
use crate::geometry_class::bake_geometry::BakeGeometry;
use crate::mesh::tetrahedra::isosurface_stuffing::StuffingError;
use crate::modal_analysis::eigensolver::ModalError;
use crate::modal_analysis::modal_density::{frequency_of_mode, modes_below};
use crate::modal_analysis::{ModalAnalysis, ModalAnalysisError, ModalAnalysisOptions, ModalAnalysisProgress};

/// Modes of a draft, by their average density, and nodes of its meshes.
const DRAFT_MODES: f64 = 100.0;
const DRAFT_NODES: usize = 4000;
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
    let area = geometry.area();
    let radiating =
        (MOST_ORDER as f64 - ORDERS_ABOVE) * options.medium.sound_speed / (TAU * geometry.bounding_radius());
    let mut limit = options.max_frequency.min(radiating);
    let mut effort = options.effort;
    if effort == Effort::Draft {
        limit = frequency_of_mode(DRAFT_MODES, volume, area, limit, material);
    }
    let mut needed = None;
    loop {
        let settings = ModalAnalysisOptions {
            max_frequency: limit,
            accuracy: options.mesh_error,
            most_nodes: match effort {
                Effort::Exact => options.most_nodes,
                Effort::Draft => DRAFT_NODES.min(options.most_nodes),
            },
        };
        match held.modes(geometry, (constants, effort), &settings, progress) {
            Ok(mut found) => {
                if limit < options.max_frequency {
                    found.warnings.push(left_out(found.modes.len(), limit, options, |frequency| {
                        modes_below(volume, area, frequency, material).0
                    }));
                }
                return Ok(found);
            }
            // The estimate put the limit below the lowest mode.
            Err(ModalAnalysisError::Modes(ModalError::Silent { first, .. }))
                if limit < options.max_frequency.min(radiating)
                    && first < options.max_frequency
                    && needed.is_none() =>
            {
                limit = (ABOVE_FIRST * first).min(options.max_frequency).min(radiating);
                needed = Some(f64::INFINITY);
            }
            Err(error) => match size_of(&error) {
                Some(size) if limit * NARROWER > LOWEST && needed.is_none_or(|last| size < last) => {
                    limit *= NARROWER;
                    needed = Some(size);
                }
                Some(_) if effort == Effort::Exact => {
                    effort = Effort::Draft;
                    limit = frequency_of_mode(
                        DRAFT_MODES,
                        volume,
                        area,
                        options.max_frequency.min(radiating),
                        material,
                    );
                    needed = None;
                }
                _ => return Err(error),
            },
        }
    }
}

/// What a lower limit would have to make smaller; `None` for errors that it does not mend.
fn size_of(error: &ModalAnalysisError) -> Option<f64> {
    match error {
        ModalAnalysisError::TooLarge { nodes, .. } => Some(*nodes as f64),
        ModalAnalysisError::TooFine { nodes, .. } => Some(*nodes),
        ModalAnalysisError::Modes(ModalError::Memory { unknowns }) => Some(*unknowns as f64),
        ModalAnalysisError::Mesh(StuffingError::TooFine { .. } | StuffingError::Unresolved { .. }) => {
            Some(f64::INFINITY)
        }
        ModalAnalysisError::Modes(ModalError::Inaccurate { residual }) => Some(*residual),
        _ => None,
    }
}

/// The warning on a narrowed band.
fn left_out(found: usize, limit: f64, options: &ModalBakeOptions, below: impl Fn(f64) -> f64) -> String {
    let highest = options.max_frequency;
    // The estimate, as if it had counted those that were found.
    let more = found as f64 * (below(highest) / below(limit).max(1.0) - 1.0).max(0.0);
    let remedy = match options.effort {
        Effort::Draft => "a draft ends there; a bake of normal quality goes on",
        Effort::Exact => "more would not fit into memory",
    };
    format!(
        "it rings with the {found} modes below {:.2} kHz; about {more:.0} up to {:.2} kHz are left out: \
         {remedy}",
        limit * 1e-3,
        highest * 1e-3
    )
}
