//! All modes of a section up to a frequency, by azimuthal order.
//!
//! The lowest frequency of order m rises with m, at the latest where waves around the rim are shorter than
//! those along the wall. Orders are solved in turn until several have no mode in the band. Within an order
//! the spectrum is complete (Sturm count).

use glam::DVec3;

use super::section_element::{rigid_motions, section_matrices};
use super::section_mesh::SectionMesh;
use crate::cost::work_limit::WorkLimit;
use crate::fem::across_walls::Columns;
use crate::fem::elimination::Elimination;
use crate::fem::{ElasticConstants, ElasticSystem, Elements};
use crate::modal_analysis::eigensolver::{ModalError, solve_in};

/// Consecutive orders without modes in the band, from order 2 on, that end the search.
const EMPTY_ORDERS: u32 = 3;

/// A mode of a section; above order 0 it represents two modes of the body.
#[derive(Clone, Debug)]
pub(crate) struct SectionMode {
    pub(super) frequency: f64,
    /// m.
    pub(super) order: u32,
    /// U, V, W at the nodes of the section [kg^−½].
    pub(super) motion: Vec<DVec3>,
}

/// Modes of all orders.
#[derive(Clone, Debug)]
pub(super) struct SectionSpectrum {
    /// By frequency.
    pub(super) modes: Vec<SectionMode>,
    /// Largest relative residual.
    pub(super) residual: f64,
    /// The lowest frequency, within the band or above it \[Hz\].
    pub(super) first: f64,
}

pub(super) fn spectrum(
    mesh: &SectionMesh,
    constants: &ElasticConstants,
    limit: f64,
    work: &WorkLimit,
) -> Result<SectionSpectrum, ModalError> {
    let mut found = SectionSpectrum { modes: Vec::new(), residual: 0.0, first: f64::INFINITY };
    let (mut order, mut empty) = (0, 0);
    // Solve order by order until several are empty.
    while order < 2 || empty < EMPTY_ORDERS {
        let system = system(mesh, constants, order);
        match solve_in(&Elimination::new(&system)?, &system, limit, work) {
            Ok(modes) => {
                empty = 0;
                found.residual = found.residual.max(modes.residual);
                let own = modes.modes.into_iter();
                found.modes.extend(own.map(|m| SectionMode {
                    frequency: m.frequency,
                    order,
                    motion: m.shape,
                }));
            }
            Err(ModalError::Silent { first, .. }) => {
                empty += u32::from(order >= 2);
                found.first = found.first.min(first);
            }
            Err(error) => return Err(error),
        }
        order += 1;
    }
    // Sort by frequency, then order.
    found.modes.sort_by(|a, b| a.frequency.total_cmp(&b.frequency).then(a.order.cmp(&b.order)));
    found.first = found.modes.first().map_or(found.first, |m| m.frequency);
    Ok(found)
}

fn system(mesh: &SectionMesh, constants: &ElasticConstants, order: u32) -> ElasticSystem {
    let elements = Elements {
        nodes: mesh.nodes.iter().map(|x| x.extend(0.0)).collect(),
        elements: &mesh.elements,
        rigid: rigid_motions(&mesh.nodes, order),
        columns: Columns::default(),
    };
    ElasticSystem::assemble(elements, |e| {
        let matrices = section_matrices(&mesh.positions(e), order, constants);
        move |i: usize, j: usize| (matrices.stiffness[i][j], matrices.mass[i][j])
    })
}
