//! The few cells of a draft.
//!
//! The surface has fewer triangles, and the cells are about ninety of order 2 and then of order 3. Where
//! these would have too many nodes, cells are a little longer: walls that bend are far too stiff in order 2.

use std::borrow::Cow;

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;

use super::{CellEffort, Immersed, ImmersedBody};
use crate::fem::ElasticConstants;
use crate::fem::finite_cells::{Order, edge_of_cells};
use crate::mesh::decimate::decimate;
use crate::mesh::tetrahedra::isosurface_stuffing::StuffingError;
use crate::modal_analysis::ModalAnalysisError;

/// Cells of a draft, and the distance of its surface from the input, in mean walls.
const CELLS: f64 = 90.0;
const SURFACE: f64 = 0.02;
/// Nodes of order 3 in those of order 2, and by how much longer edges may be for it: longer ones tie parts
/// together.
const NODES_OF_THIRD: f64 = 3.0;
const RATIO: f64 = 1.4;
/// Power of the nodes with which edges become longer, between those of walls (½) and of rods (1), and a
/// margin.
const FALL: f64 = 0.75;
const MARGIN: f64 = 1.05;

/// Edge of the cells of a draft \[m\], of a body of this area \[m²\] and volume \[m³\].
pub(super) fn draft_edge(area: f64, volume: f64) -> f64 {
    edge_of_cells(area, volume, CELLS)
}

impl<'a> ImmersedBody<'a> {
    /// For a draft: on fewer triangles where the surface has more than its walls need.
    pub(in crate::modal_analysis) fn draft(
        surface: &TriMesh,
        constants: &'a ElasticConstants,
        most_nodes: usize,
    ) -> Result<Self, ModalAnalysisError> {
        let mass = MassProperties::of(surface).map_err(StuffingError::Input)?;
        let area = surface.area();
        let longest = draft_edge(area, mass.volume);
        let coarse = decimate(surface, longest, SURFACE * 2.0 * mass.volume / area);
        ImmersedBody::new(Cow::Owned(coarse), constants, most_nodes, CellEffort::Draft)
    }
}

impl ImmersedBody<'_> {
    /// Cells of order 2 of an edge, or of one that is little longer and makes order 3 not too much.
    pub(super) fn draft_cells(&self, edge: f64) -> Result<Immersed, ModalAnalysisError> {
        let first = self.with(edge, Order::Second)?;
        let excess =
            |cells: &Immersed| NODES_OF_THIRD * cells.cells.node_count() as f64 / self.most_nodes as f64;
        let (mut longer, mut now) = (edge, excess(&first));
        while now > 1.0 {
            longer *= (MARGIN * now).powf(FALL);
            if longer > RATIO * edge {
                return Ok(first);
            }
            let cells = self.with(longer, Order::Second)?;
            now = excess(&cells);
            if now <= 1.0 {
                return Ok(cells);
            }
        }
        Ok(first)
    }
}
