//! The modes of a box on a part of it, by [`mirror_parities`](super::mirror_parities).

use glam::DVec3;

use super::Spectrum;
use super::mirror_parities::{MirrorParities, PartMode, PartNodes};
use crate::cost::work_limit::WorkLimit;
use crate::fem::ElasticConstants;
use crate::fem::across_walls::Unknowns;
use crate::fem::bricks::box_of_bricks;
use crate::mesh::tetrahedra::block::block;
use crate::mesh::tetrahedra::{TetMesh, TetMeshError};
use crate::modal_analysis::eigensolver::{ModalError, Mode};

/// Distance from a plane within which a node lies on it, in the edge of the part.
const ON_PLANE: f64 = 1e-9;

/// A box and its grid.
pub(super) struct MirroredBox<'a> {
    /// Full edges \[m\].
    pub(super) edges: DVec3,
    /// Cells along each axis. Along axes with a multiple of four, half of the box is solved.
    pub(super) cells: [usize; 3],
    pub(super) constants: &'a ElasticConstants,
}

impl MirroredBox<'_> {
    fn mirrors(&self) -> MirrorParities {
        MirrorParities(self.cells.map(|count| count.is_multiple_of(4)))
    }

    fn part_cells(&self) -> [usize; 3] {
        let MirrorParities(mirrored) = self.mirrors();
        [0, 1, 2].map(|a| if mirrored[a] { self.cells[a] / 2 } else { self.cells[a] })
    }

    fn part_edges(&self) -> DVec3 {
        let MirrorParities(mirrored) = self.mirrors();
        DVec3::from_array([0, 1, 2].map(|a| if mirrored[a] { 0.5 * self.edges[a] } else { self.edges[a] }))
    }

    /// The mesh of the solved part, about its own centre.
    pub(super) fn part(&self) -> Result<TetMesh, TetMeshError> {
        block(self.part_edges(), self.part_cells())
    }

    /// All modes up to a limit \[Hz\], on the nodes of `whole`, which is the [`block`] of this box.
    pub(super) fn solve(
        &self,
        whole: &TetMesh,
        part: &TetMesh,
        (limit, work): (f64, &WorkLimit),
    ) -> Result<Spectrum<Vec<Mode>>, ModalError> {
        let (mirrors, part_edges, part_cells) = (self.mirrors(), self.part_edges(), self.part_cells());
        let system = box_of_bricks(part, part_edges, part_cells, self.constants, Unknowns::AcrossWalls);
        let MirrorParities(mirrored) = mirrors;
        let offset =
            DVec3::from_array([0, 1, 2].map(|a| if mirrored[a] { 0.5 * part_edges[a] } else { 0.0 }));
        let places: Vec<DVec3> = system.nodes().iter().map(|p| *p + offset).collect();
        let on = |p: &DVec3| [0, 1, 2].map(|a| mirrored[a] && p[a] < ON_PLANE * part_edges[a]);
        let on_planes: Vec<[bool; 3]> = places.iter().map(on).collect();
        let nodes = PartNodes { places: &places, on_planes: &on_planes };
        let Spectrum { frequencies, first, residual, modes } =
            mirrors.spectrum(&system, nodes, limit, work)?;
        let images = self.images(whole, part, part_edges, part_cells);
        let unfolded = |PartMode { parity, mode }: &PartMode| {
            let motion =
                |(p, image): (&DVec3, &u32)| mirrors.unfolded(*parity, *p, mode.shape[*image as usize]);
            Mode { frequency: mode.frequency, shape: whole.nodes.iter().zip(&images).map(motion).collect() }
        };
        let modes = modes.iter().map(unfolded).collect();
        Ok(Spectrum { frequencies, first, residual, modes })
    }

    /// Node of the part for each node of the whole.
    fn images(&self, whole: &TetMesh, part: &TetMesh, part_edges: DVec3, part_cells: [usize; 3]) -> Vec<u32> {
        let mirrors = self.mirrors();
        let counts = part_cells.map(|n| 2 * n + 1);
        // From the lower face of the part, in half cells.
        let number = |from: [f64; 3]| {
            let at = [0, 1, 2].map(|a| (from[a] / part_edges[a] * (counts[a] - 1) as f64).round() as usize);
            (at[2] * counts[1] + at[1]) * counts[0] + at[0]
        };
        let mut lattice = vec![0_u32; counts.iter().product()];
        for (n, p) in part.nodes.iter().enumerate() {
            lattice[number([0, 1, 2].map(|a| p[a] + 0.5 * part_edges[a]))] = n as u32;
        }
        let image = |p: &DVec3| {
            let folded = mirrors.folded(*p);
            lattice[number(
                [0, 1, 2].map(|a| if mirrors.0[a] { folded[a] } else { folded[a] + 0.5 * part_edges[a] }),
            )]
        };
        whole.nodes.iter().map(image).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use clangor_core::material::presets::GLASS;

    use super::*;
    use crate::modal_analysis::eigensolver::solve;

    /// Frequencies are those of the whole box, and shapes satisfy its equations, orthonormal.
    #[test]
    fn mirrors_change_nothing() {
        let constants = ElasticConstants::of(&GLASS.material()).expect("glass");
        for (edges, cells, limit) in
            [(DVec3::new(0.2, 0.01, 0.15), [8, 1, 4], 8e3), (DVec3::new(0.05, 0.04, 0.03), [4, 4, 4], 9e4)]
        {
            let mesh = block(edges, cells).expect("a box");
            let system = box_of_bricks(&mesh, edges, cells, &constants, Unknowns::AcrossWalls);
            let whole = solve(&system, limit).expect("modes");
            let mirrored = MirroredBox { edges, cells, constants: &constants };
            let part = mirrored.part().expect("a box");
            assert!(8 * part.elements.len() <= 2 * mesh.elements.len());
            let mirrored = mirrored.solve(&mesh, &part, (limit, &WorkLimit::none())).expect("modes");
            assert_eq!(mirrored.modes.len(), whole.modes.len());
            assert!(whole.modes.len() > 10 && mirrored.residual < 1e-6, "{}", whole.modes.len());
            let size = 3 * system.node_count();
            let (mut stiff, mut heavy) = (vec![0.0; size], vec![0.0; size]);
            for (mode, reference) in mirrored.modes.iter().zip(&whole.modes) {
                assert!((mode.frequency / reference.frequency - 1.0).abs() < 1e-8, "{}", mode.frequency);
                let flat = system.unknowns_of(&mode.shape);
                system.multiply_stiffness(&flat, 1, &mut stiff);
                system.multiply_mass(&flat, 1, &mut heavy);
                let square = (TAU * mode.frequency).powi(2);
                let error: f64 = stiff.iter().zip(&heavy).map(|(k, m)| (k - square * m).powi(2)).sum();
                let scale: f64 = heavy.iter().map(|m| (square * m).powi(2)).sum();
                assert!(
                    (error / scale).sqrt() < 1e-5,
                    "{} Hz: {:.1e}",
                    mode.frequency,
                    (error / scale).sqrt()
                );
                let norm: f64 = flat.iter().zip(&heavy).map(|(u, m)| u * m).sum();
                assert!((norm - 1.0).abs() < 1e-8, "{norm}");
            }
        }
    }
}
