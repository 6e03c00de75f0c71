//! The modes of a body that supports hold, in the discretization of the free body: boxes in hexahedra, plates
//! in prisms, ellipsoids in tetrahedra, all other surfaces in cells. A body of revolution is solved as the
//! surface that it has, since its supports break the symmetry.

use std::ops::ControlFlow;

use super::immersed_body::{CellEffort, ImmersedBody};
use super::volume_fem::{Filling, VolumeFem};
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
    let most = options.most_nodes;
    let filling = match choice {
        ModalChoice::Cells(surface) => {
            let body = ImmersedBody::new(surface, constants, most, effort)?.held_by(supports);
            return refined(&body, constants, options, progress).map(|(analysis, _)| analysis);
        }
        ModalChoice::Ball(semi_axes) => Filling::Ellipsoid(semi_axes),
        ModalChoice::Hexahedra(edges) => Filling::Block(edges),
        ModalChoice::Prisms(plate) => Filling::Plate(plate),
        ModalChoice::Section(_) => return Err(ModalAnalysisError::Section),
    };
    let body = VolumeFem::new(filling, constants, most).held_by(supports);
    refined(&body, constants, options, progress).map(|(analysis, _)| analysis)
}
