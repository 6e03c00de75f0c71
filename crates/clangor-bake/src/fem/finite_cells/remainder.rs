//! In which cells the displacements of modes are resolved least.
//!
//! ```text
//! η_c = (u − Π u)ᵀ K_c (u − Π u)
//!
//! Π: interpolation of one order less,    K_c: stiffness of the body in cell c
//! ```
//!
//! the elastic energy of the highest order in each cell. Where it is large, smaller cells lower the frequency
//! most. It says where the error of a mode is, not how large it is.
//!
//! Source: Mavriplis (1994), "Adaptive mesh strategies for the spectral element method", CMAME 116.
//! `Differs`: the energy of the elastic strain, where that uses the decay of the coefficients.

use std::iter;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::basis::{Basis, gauss_lobatto};
use super::levels::Level;
use super::matrices::CellMatrices;
use super::{FiniteCells, LevelPlace};
use crate::fem::ElasticConstants;

/// What some modes have in a cell.
pub(crate) struct Remainder {
    pub(crate) cell: LevelPlace,
    /// Energy of the highest order, by mode [N m].
    pub(crate) energies: Vec<f64>,
}

impl FiniteCells {
    /// The remainders of modes, given at the nodes, in all cells.
    pub(crate) fn remainders(&self, shapes: &[&[DVec3]], constants: &ElasticConstants) -> Vec<Remainder> {
        let highest = highest_order(&self.basis);
        let cells = self.levels.iter().enumerate().flat_map(|(number, level)| {
            level.body.cells.iter().map(move |cell| ((number, cell.place), level, cell.distinct_parts()))
        });
        let cells: Vec<_> = cells.collect();
        cells
            .into_par_iter()
            .map(|(cell, level, parts)| {
                let mut energies = vec![0.0; shapes.len()];
                for part in parts {
                    let stiffness = self.stiffness_of(level, part, constants);
                    for (energy, shape) in energies.iter_mut().zip(shapes) {
                        let motion = self.elements[level.first + part].motion(shape);
                        *energy += energy_of(&stiffness, &remainder(&highest, motion));
                    }
                }
                Remainder { cell, energies }
            })
            .collect()
    }

    /// Blocks of the stiffness of a part, row after row up to the diagonal.
    fn stiffness_of(&self, level: &Level, part: usize, constants: &ElasticConstants) -> Vec<DMat3> {
        let own = CellMatrices::new(&self.basis, level.grid.edge, &level.body.parts[part].weights);
        let rows = (0..(self.basis.degree() + 1).pow(3)).flat_map(|i| (0..=i).map(move |j| (i, j)));
        rows.map(|(i, j)| own.stiffness(i, j, constants)).collect()
    }
}

/// Values at the nodes of an axis of what interpolation of one order less leaves out, by node and cause.
fn highest_order(basis: &Basis) -> Vec<Vec<f64>> {
    let lower = gauss_lobatto(basis.degree() - 1);
    let at_lower: Vec<Vec<f64>> = lower.iter().map(|x| basis.values(*x)).collect();
    let lower = Basis::of_nodes(lower);
    let nodes = basis.lobatto();
    let row = |i: usize| {
        let back = lower.values(nodes[i]);
        let left = |j: usize| {
            let kept: f64 = back.iter().zip(&at_lower).map(|(weight, values)| weight * values[j]).sum();
            if i == j { 1.0 - kept } else { -kept }
        };
        (0..nodes.len()).map(left).collect()
    };
    (0..nodes.len()).map(row).collect()
}

/// u − Π u, where Π interpolates along all three axes.
fn remainder(highest: &[Vec<f64>], motion: Vec<DVec3>) -> Vec<DVec3> {
    let local = highest.len();
    let mut kept = motion.clone();
    for step in [local * local, local, 1] {
        let before = kept.clone();
        for (k, value) in kept.iter_mut().enumerate() {
            let at = k / step % local;
            let line = (0..local).map(|j| before[k + j * step - at * step] * highest[at][j]);
            *value -= line.sum::<DVec3>();
        }
    }
    iter::zip(motion, kept).map(|(whole, kept)| whole - kept).collect()
}

/// uᵀ K u from the blocks up to the diagonal.
fn energy_of(stiffness: &[DMat3], motion: &[DVec3]) -> f64 {
    let mut blocks = stiffness.iter();
    let mut energy = 0.0;
    for (i, own) in motion.iter().enumerate() {
        let row = motion[..=i].iter().zip(&mut blocks);
        let sum = |sum: DVec3, (j, (other, block)): (usize, (&DVec3, &DMat3))| {
            sum + *block * *other * if i == j { 1.0 } else { 2.0 }
        };
        energy += own.dot(row.enumerate().fold(DVec3::ZERO, sum));
    }
    energy
}

#[cfg(test)]
mod tests {
    use clangor_core::material::presets::GLASS;
    use clangor_core::shape::Shape;

    use super::super::{CellGrid, Order, Refinement};
    use super::*;

    /// What a lower order has too leaves nothing, and x⁴ the energy of its fourth order.
    #[test]
    fn remainders_are_what_the_highest_order_adds() {
        let mesh = Shape::parse("box:0.2x0.1x0.1").expect("a shape").mesh();
        let constants = ElasticConstants::of(&GLASS.material()).expect("glass");
        let origin = DVec3::new(-0.1, -0.05, -0.05);
        let grid = CellGrid { origin, edge: 0.1, counts: [2, 1, 1], images: [0; 3] };
        let refinement = Refinement::default();
        let cells = FiniteCells::new(&mesh, (grid, &refinement), Order::Fourth, 0.1).expect("cells");
        let shape = |power: i32| -> Vec<DVec3> {
            let place = |x: &DVec3| DVec3::X * ((x.x - grid.origin.x) / grid.edge).powi(power);
            cells.nodes().iter().map(place).collect()
        };
        let [third, fourth] = [3, 4].map(shape);
        let found = cells.remainders(&[&third, &fourth], &constants);
        // x⁴ − Π x⁴ = Π (x − x_k) over the four Lobatto points 0, 1/2 ± 1/√20, 1; its slope squared is 1/175.
        let modulus = constants.lame_lambda + 2.0 * constants.shear_modulus;
        let expected = modulus * grid.edge / 175.0;
        assert_eq!(found.len(), 2);
        for own in found {
            assert!(own.energies[0].abs() < 1e-12 * expected, "{:?}", own.energies);
            assert!((own.energies[1] / expected - 1.0).abs() < 1e-9, "{:?} {expected}", own.energies);
        }
    }
}
