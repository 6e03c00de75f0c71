//! Loads of the six motions at the Chebyshev nodes of a band, without the delay of the centre.

use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use num_complex::Complex64;
use rayon::prelude::*;

use super::Band;
use super::chebyshev::{count, nodes, weights};
use crate::bem::triangles::TriangleSolver;

/// Delays are from 0 to 2 R/c: within 1 of their mean.
const MEAN_DELAY: f64 = 1.0;

/// The table.
#[derive(Clone, Debug)]
pub(super) struct LoadTable {
    /// [1/R].
    nodes: Vec<f64>,
    /// By node and vertex.
    values: Vec<Vec<[Complex64; RIGID_DOFS]>>,
}

impl LoadTable {
    pub(super) fn new(solver: &TriangleSolver, band: &Band) -> Self {
        let phase = 0.5 * (band.highest - band.lowest) * MEAN_DELAY;
        let nodes = nodes([band.lowest, band.highest], count(phase, band.error));
        let values = nodes
            .par_iter()
            .map(|k| {
                let advance = Complex64::cis(k * MEAN_DELAY) * *k;
                let mut loads = solver.loads(*k);
                loads.iter_mut().flatten().for_each(|load| *load *= advance);
                loads
            })
            .collect();
        Self { nodes, values }
    }

    /// The loads of all vertices at a wavenumber [1/R].
    pub(super) fn at(&self, k: f64) -> Vec<[Complex64; RIGID_DOFS]> {
        let delay = Complex64::cis(-k * MEAN_DELAY) / k;
        let weights: Vec<Complex64> = weights(&self.nodes, k).into_iter().map(|w| delay * w).collect();
        let vertices = self.values.first().map_or(0, Vec::len);
        let of_vertex = |v: usize| {
            std::array::from_fn(|d| {
                weights.iter().zip(&self.values).map(|(w, values)| w * values[v][d]).sum()
            })
        };
        (0..vertices).map(of_vertex).collect()
    }
}
