//! The modes of a box by its mirror planes.
//!
//! Every mode of a body symmetric about a plane is even or odd under the reflection,
//!
//! ```text
//! u(R x) = ± R u(x),    R the mirror
//! ```
//!
//! so that half of the body is enough: on the plane the normal motion vanishes, or the tangential one. With
//! three planes there are eight problems with an eighth of the unknowns each, which take a fraction of the
//! time. The modes of a degenerate pair are in different ones.

use glam::DVec3;

use super::Spectrum;
use crate::fem::across_walls::Unknowns;
use crate::fem::bricks::box_of_bricks;
use crate::fem::{ElasticConstants, ElasticSystem};
use crate::mesh::tetrahedra::block::block;
use crate::mesh::tetrahedra::{TetMesh, TetMeshError};
use crate::modal_analysis::eigensolver::{ModalError, Mode, solve};

/// A box and its grid.
pub(super) struct MirroredBox<'a> {
    /// Full edges \[m\].
    pub(super) edges: DVec3,
    /// Cells along each axis. Along axes with a multiple of four, half of the box is solved.
    pub(super) cells: [usize; 3],
    pub(super) constants: &'a ElasticConstants,
}

/// Parity for each axis: +1 for motions that equal their mirror image, −1 for their negative.
type Parity = [f64; 3];

impl MirroredBox<'_> {
    fn mirrored(&self, axis: usize) -> bool {
        self.cells[axis].is_multiple_of(4)
    }

    fn part_cells(&self) -> [usize; 3] {
        [0, 1, 2].map(|a| if self.mirrored(a) { self.cells[a] / 2 } else { self.cells[a] })
    }

    fn part_edges(&self) -> DVec3 {
        DVec3::from_array(
            [0, 1, 2].map(|a| if self.mirrored(a) { 0.5 * self.edges[a] } else { self.edges[a] }),
        )
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
        limit: f64,
    ) -> Result<Spectrum<Vec<Mode>>, ModalError> {
        let (part_edges, part_cells) = (self.part_edges(), self.part_cells());
        let system = box_of_bricks(part, part_edges, part_cells, self.constants, Unknowns::AcrossWalls);
        let images = self.images(whole, part, part_edges, part_cells);
        let mut all =
            Spectrum { frequencies: Vec::new(), first: f64::INFINITY, residual: 0.0, modes: Vec::new() };
        for parity in self.parities() {
            match solve(&self.restricted(&system, part_edges, parity), limit) {
                Ok(found) => {
                    all.residual = all.residual.max(found.residual);
                    all.modes
                        .extend(found.modes.iter().map(|mode| self.unfolded(mode, parity, whole, &images)));
                }
                Err(ModalError::Silent { first, .. }) => all.first = all.first.min(first),
                Err(error) => return Err(error),
            }
        }
        all.modes.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        all.frequencies = all.modes.iter().map(|m| m.frequency).collect();
        all.first = all.frequencies.first().map_or(all.first, |f| *f);
        Ok(all)
    }

    fn parities(&self) -> impl Iterator<Item = Parity> {
        let both = (0..8_usize).map(|k| [0, 1, 2].map(|a| if k >> a & 1 == 1 { -1.0 } else { 1.0 }));
        both.filter(|parity| (0..3).all(|a| self.mirrored(a) || parity[a] > 0.0))
    }

    /// The problem of one parity. The part lies on the positive side of the planes.
    fn restricted(&self, system: &ElasticSystem, part_edges: DVec3, parity: Parity) -> ElasticSystem {
        let offset =
            DVec3::from_array([0, 1, 2].map(|a| if self.mirrored(a) { 0.5 * part_edges[a] } else { 0.0 }));
        let places: Vec<DVec3> = system.nodes().iter().map(|p| *p + offset).collect();
        let on_plane = |p: &DVec3, a: usize| self.mirrored(a) && p[a] < 1e-9 * part_edges[a];
        let held = places.iter().flat_map(|p| {
            [0, 1, 2].map(|axis| (0..3).any(|a| on_plane(p, a) && (parity[a] > 0.0) == (axis == a)))
        });
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let fits = |turns: bool, axis: usize| {
            // A translation is odd under reflection along itself, a rotation under reflection across its
            // axis.
            (0..3).filter(|a| self.mirrored(*a)).all(|a| (parity[a] < 0.0) == ((a == axis) != turns))
        };
        let translations = (0..3)
            .filter(|a| fits(false, *a))
            .map(|a| places.iter().map(|_| axes[a]).collect::<Vec<DVec3>>());
        let turns =
            (0..3).filter(|a| fits(true, *a)).map(|a| places.iter().map(|p| axes[a].cross(*p)).collect());
        let rigid = translations.chain(turns).collect();
        system.clone().holding(held.collect(), rigid)
    }

    /// Node of the part for each node of the whole.
    fn images(&self, whole: &TetMesh, part: &TetMesh, part_edges: DVec3, part_cells: [usize; 3]) -> Vec<u32> {
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
            lattice[number(
                [0, 1, 2].map(|a| if self.mirrored(a) { p[a].abs() } else { p[a] + 0.5 * part_edges[a] }),
            )]
        };
        whole.nodes.iter().map(image).collect()
    }

    fn unfolded(&self, mode: &Mode, parity: Parity, whole: &TetMesh, images: &[u32]) -> Mode {
        let parts = (0..3).filter(|a| self.mirrored(*a)).fold(1.0, |parts, _| 2.0 * parts);
        let scale = 1.0 / f64::sqrt(parts);
        let shape = whole.nodes.iter().zip(images).map(|(p, image)| {
            let mut motion = scale * mode.shape[*image as usize];
            for a in (0..3).filter(|a| self.mirrored(*a) && p[*a] < 0.0) {
                motion *= parity[a];
                motion[a] = -motion[a];
            }
            motion
        });
        Mode { frequency: mode.frequency, shape: shape.collect() }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use clangor_core::material::presets::GLASS;

    use super::*;

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
            let mirrored = mirrored.solve(&mesh, &part, limit).expect("modes");
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
