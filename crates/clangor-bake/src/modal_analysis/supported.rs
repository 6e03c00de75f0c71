//! The modes of a body that supports hold, in the discretization of the free body: boxes in hexahedra, plates
//! in prisms, ellipsoids and compact surfaces in tetrahedra, thin ones in cells. A body of revolution is
//! solved as the surface that it has, since its supports break the symmetry.

use std::borrow::Cow;
use std::ops::ControlFlow;

use super::immersed_body::{CellEffort, ImmersedBody};
use super::volume_fem::VolumeFem;
use super::{
    ModalAnalysis, ModalAnalysisError, ModalAnalysisOptions, ModalAnalysisProgress, check, modal_analysis,
    refined,
};
use crate::fem::ElasticConstants;
use crate::fem::supports::{Support, check_supports};
use crate::geometry_class::bake_geometry::BakeGeometry;
use crate::geometry_class::solver_choice::ModalChoice;
use crate::mesh::axisymmetric_surface::axisymmetric_surface;
use crate::mesh::tetrahedra::isosurface_stuffing::StuffingError;

/// Finds all modes of a body that supports hold, up to a frequency: like [`modal_analysis()`], with the
/// motions that were rigid among them, and the damping of each mode by the dampers.
///
/// # Errors
/// [`ModalAnalysisError`].
pub fn supported_modal_analysis(
    geometry: &BakeGeometry,
    constants: &ElasticConstants,
    supports: &[Support],
    options: &ModalAnalysisOptions,
    progress: &mut dyn FnMut(&ModalAnalysisProgress) -> ControlFlow<()>,
) -> Result<ModalAnalysis, ModalAnalysisError> {
    if supports.is_empty() {
        return modal_analysis(geometry, constants, options, progress);
    }
    supported_modal_analysis_by(geometry, (constants, CellEffort::Accurate), supports, options, progress)
}

/// A draft of [`supported_modal_analysis()`], as
/// [`draft_modal_analysis()`](super::draft_modal_analysis) is one of [`modal_analysis()`].
///
/// # Errors
/// As [`supported_modal_analysis()`].
pub fn draft_supported_modal_analysis(
    geometry: &BakeGeometry,
    constants: &ElasticConstants,
    supports: &[Support],
    options: &ModalAnalysisOptions,
    progress: &mut dyn FnMut(&ModalAnalysisProgress) -> ControlFlow<()>,
) -> Result<ModalAnalysis, ModalAnalysisError> {
    supported_modal_analysis_by(geometry, (constants, CellEffort::Draft), supports, options, progress)
}

fn supported_modal_analysis_by(
    geometry: &BakeGeometry,
    (constants, effort): (&ElasticConstants, CellEffort),
    supports: &[Support],
    options: &ModalAnalysisOptions,
    progress: &mut dyn FnMut(&ModalAnalysisProgress) -> ControlFlow<()>,
) -> Result<ModalAnalysis, ModalAnalysisError> {
    check(options)?;
    check_supports(supports)?;
    // A body of revolution that something holds is none: its surface is solved as any other.
    let surface;
    let choice = match (geometry.modal_choice().map_err(StuffingError::Input)?, geometry) {
        (ModalChoice::Section(_), BakeGeometry::Ellipsoid { semi_axes }) => ModalChoice::Ball(*semi_axes),
        (ModalChoice::Section(axisymmetry), _) => {
            let mesh = axisymmetric_surface(&axisymmetry.meridian, axisymmetry.rotation());
            surface = BakeGeometry::Mesh(mesh);
            surface.modal_choice().map_err(StuffingError::Input)?
        }
        (other, _) => other,
    };
    let in_cells = |surface| {
        let body = ImmersedBody::new(surface, constants, options.most_nodes, effort)?.held_by(supports);
        Ok(body)
    };
    let most = options.most_nodes;
    let cells: Result<ImmersedBody<'_>, ModalAnalysisError> = match (choice, effort) {
        (ModalChoice::Cells(surface), _) | (ModalChoice::Tetrahedra(surface), CellEffort::Draft) => {
            in_cells(surface)
        }
        (ModalChoice::Tetrahedra(surface), CellEffort::Accurate) => {
            let choice = ModalChoice::Tetrahedra(Cow::Borrowed(&*surface));
            let filled = VolumeFem::of(choice, constants, most)
                .and_then(|body| refined(&body.held_by(supports), constants, options, progress));
            match filled {
                Err(error) if error.is_unfillable() => in_cells(surface),
                other => return other.map(|(analysis, _)| analysis),
            }
        }
        (other, _) => {
            let body = VolumeFem::of(other, constants, most)?.held_by(supports);
            return refined(&body, constants, options, progress).map(|(analysis, _)| analysis);
        }
    };
    refined(&cells?, constants, options, progress).map(|(analysis, _)| analysis)
}
