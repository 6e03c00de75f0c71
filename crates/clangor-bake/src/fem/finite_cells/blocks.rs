//! Stiffness and mass of the elements of a grid of cells: the parts of the body in cells, and the ties
//! between them. Of a part with hanging nodes, they are those of the nodes that it depends on:
//!
//! ```text
//! K' = Tᵀ K T,    u = T U,    u: at the nodes of the cell, U: at those of the system
//! ```

use glam::{DMat3, DVec3};

use super::levels::Level;
use super::matrices::CellMatrices;
use super::{FILLED, FiniteCells};
use crate::fem::across_walls::Columns;
use crate::fem::rigid_motions::rigid_motions;
use crate::fem::{ElasticConstants, ElasticSystem, Elements};

/// α: stiffness of the part of a cut cell outside the body, relative to that of the body.
///
/// Larger values stiffen thin walls (1e-6: 1 % at a wall of a twentieth of a cell), smaller ones lose digits.
const OUTSIDE: f64 = 1e-10;
/// β in E/t.
const TIE: f64 = 100.0;

/// Blocks of one element.
enum Blocks<'a> {
    /// Of a part, and of its whole cell, whose stiffness counts a little.
    Part { own: Box<CellMatrices>, whole: &'a CellMatrices, outside: f64 },
    /// Of a part with hanging nodes, by pairs of the nodes it depends on.
    Hanging(Vec<(DMat3, f64)>, usize),
    /// Stiffness of a tie along each axis, by pairs of its nodes.
    Tie(Vec<f64>, usize),
}

impl FiniteCells {
    /// Stiffness and mass.
    pub(crate) fn system(&self, constants: &ElasticConstants) -> ElasticSystem {
        let elements = Elements {
            nodes: self.nodes.clone(),
            elements: &self.elements,
            rigid: rigid_motions(&self.nodes).into(),
            columns: Columns::default(),
        };
        let parts = self.part_count();
        let whole = |level: &Level| {
            let edge = level.grid.edge;
            CellMatrices::new(&self.basis, edge, &self.whole_weights(edge))
        };
        let whole: Vec<CellMatrices> = self.levels.iter().map(whole).collect();
        ElasticSystem::assemble(elements, |e| {
            let own =
                if e < parts { self.part(e, &whole, constants) } else { self.tie(e - parts, constants) };
            move |i: usize, j: usize| own.at(i, j, constants)
        })
    }

    /// The matrices of a part.
    fn part<'a>(&self, e: usize, whole: &'a [CellMatrices], constants: &ElasticConstants) -> Blocks<'a> {
        let level = self.levels.partition_point(|level| level.first <= e) - 1;
        let Level { grid, body, first, .. } = &self.levels[level];
        let part = &body.parts[e - first];
        let outside = if part.filled < 1.0 - FILLED { OUTSIDE } else { 0.0 };
        let own = CellMatrices::new(&self.basis, grid.edge, &part.weights);
        let plain = Blocks::Part { own: Box::new(own), whole: &whole[level], outside };
        let element = &self.elements[e];
        let Some(hanging) = &element.hanging else { return plain };
        // K' = Tᵀ K T, first Tᵀ K.
        let (local, count) = (hanging.len(), element.nodes.len());
        let mut half = vec![(DMat3::ZERO, 0.0); count * local];
        for (i, terms) in hanging.iter().enumerate() {
            for j in 0..local {
                let (block, mass) = plain.at(i, j, constants);
                for (row, weight) in terms {
                    let sum = &mut half[row * local + j];
                    *sum = (sum.0 + block * *weight, sum.1 + mass * weight);
                }
            }
        }
        let mut all = vec![(DMat3::ZERO, 0.0); count * count];
        for (j, terms) in hanging.iter().enumerate() {
            for row in 0..count {
                let (block, mass) = half[row * local + j];
                for (column, weight) in terms {
                    let sum = &mut all[row * count + column];
                    *sum = (sum.0 + block * *weight, sum.1 + mass * weight);
                }
            }
        }
        Blocks::Hanging(all, count)
    }

    /// The stiffness of a tie on the nodes of both parts. Where they share a node, nothing is left to tie.
    fn tie(&self, k: usize, constants: &ElasticConstants) -> Blocks<'_> {
        let level = &self.levels[self.levels.partition_point(|level| level.first_tie <= k) - 1];
        let tie = &level.body.ties[k - level.first_tie];
        let section = CellMatrices::new(&self.basis, level.grid.edge, &tie.weights);
        let nodes = &self.elements[self.part_count() + k].nodes;
        let count = nodes.len();
        let mut values = vec![0.0; count * count];
        // Terms of both parts by their place in the cell, with the sign of their displacement.
        let mut both: Vec<(usize, usize, f64)> = Vec::new();
        for (part, sign) in tie.parts.iter().zip([1.0, -1.0]) {
            let element = &self.elements[level.first + part];
            for i in 0..(self.basis.degree() + 1).pow(3) {
                let place = |of: usize| nodes.partition_point(|other| *other < element.nodes[of]);
                both.extend(element.terms(i).map(|(of, weight)| (i, place(of), sign * weight)));
            }
        }
        let stiffness = TIE * constants.youngs_modulus() / self.wall;
        for (i, row, first) in &both {
            for (j, column, second) in &both {
                values[row * count + column] += first * second * stiffness * section.mass(*i, *j);
            }
        }
        Blocks::Tie(values, count)
    }

    /// Weights of a cell that is wholly inside.
    fn whole_weights(&self, edge: f64) -> Vec<f64> {
        let axis = self.basis.points();
        let volume = edge.powi(3);
        let along = |k: usize| axis[k].1;
        let count = axis.len();
        (0..count.pow(3))
            .map(|k| volume * along(k / (count * count)) * along(k / count % count) * along(k % count))
            .collect()
    }
}

impl Blocks<'_> {
    /// Block of the stiffness and factor of the mass.
    fn at(&self, i: usize, j: usize, constants: &ElasticConstants) -> (DMat3, f64) {
        match self {
            Blocks::Part { own, whole, outside } => {
                let block = own.stiffness(i, j, constants) + whole.stiffness(i, j, constants) * *outside;
                (block, constants.density * own.mass(i, j))
            }
            Blocks::Hanging(blocks, count) => blocks[i * count + j],
            Blocks::Tie(values, count) => (DMat3::from_diagonal(DVec3::splat(values[i * count + j])), 0.0),
        }
    }
}
