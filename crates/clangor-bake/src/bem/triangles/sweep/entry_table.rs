//! Entries of the matrices at the Chebyshev nodes of a band, without the phase of the distance of their
//! vertices, for each mirror image of the sources.

use num_complex::Complex32;
use rayon::prelude::*;

use super::Band;
use super::chebyshev::{count, nodes, weights};
use super::phased_column::{PhasedColumn, Points, stride};
use super::spares::Spares;
use crate::bem::triangles::TriangleSolver;
use crate::bem::triangles::far::ClassMatrix;
use crate::bem::triangles::parity_classes::ParityClass;
use glam::DVec3;

/// The table.
#[derive(Clone, Debug)]
pub(super) struct EntryTable {
    /// [1/R].
    nodes: Vec<f64>,
    vertices: Vec<DVec3>,
    points: Points,
    images: Vec<DVec3>,
    /// By node and image: column by column, real and then imaginary parts of the rows.
    values: Vec<Vec<Vec<f32>>>,
}

impl EntryTable {
    /// Bytes of the table of a body in a band.
    pub(super) fn bytes(solver: &TriangleSolver, band: &Band) -> usize {
        let rows = solver.panels.vertices.len();
        let of_node = 2 * stride(rows) * rows * solver.images.len() * size_of::<f32>();
        of_node * node_count(solver, band)
    }

    pub(super) fn new(solver: &TriangleSolver, band: &Band) -> Self {
        let nodes = nodes([band.lowest, band.highest], node_count(solver, band));
        let vertices = solver.panels.vertices.clone();
        let points = Points::new(&vertices);
        let images = solver.images.clone();
        let values = nodes.par_iter().map(|k| without_phase(solver, *k, &points)).collect();
        Self { nodes, vertices, points, images, values }
    }

    /// The matrices of some classes, column by column, at a wavenumber [1/R], in memory of `spares`.
    pub(super) fn matrices(&self, classes: &[ParityClass], k: f64, spares: &Spares) -> Vec<Vec<Complex32>> {
        let weights = weights(&self.nodes, k);
        let weights: Vec<f32> =
            weights.iter().zip(&self.nodes).map(|(w, node)| (w * node / k) as f32).collect();
        let rows = self.vertices.len();
        let stride = stride(rows);
        let mut matrices: Vec<Vec<Complex32>> =
            classes.iter().map(|class| spares.take(class.size * class.size)).collect();
        let mut column = vec![0.0_f32; 2 * stride];
        let mut terms = Vec::with_capacity(weights.len());
        for (j, vertex) in self.vertices.iter().enumerate() {
            for (g, image) in self.images.iter().enumerate() {
                terms.clear();
                let place = 2 * stride * j..2 * stride * (j + 1);
                terms.extend(weights.iter().zip(&self.values).map(|(w, v)| (*w, &v[g][place.clone()])));
                let from = *image * *vertex;
                let out = &mut column[..];
                PhasedColumn { k: k as f32, from, points: &self.points, terms: &terms, out }.compute();
                let (re, im) = column.split_at(stride);
                for (class, matrix) in classes.iter().zip(&mut matrices) {
                    let (at, sign) = (class.unknowns[j] as usize, class.signs[g] as f32);
                    if at >= class.size {
                        continue;
                    }
                    let matrix = &mut matrix[at * class.size..][..class.size];
                    for ((row, re), im) in class.unknowns.iter().zip(re).zip(im) {
                        if let Some(entry) = matrix.get_mut(*row as usize) {
                            let value = Complex32::new(sign * re, sign * im);
                            // The memory has old values: the first image replaces all of them.
                            *entry = if g == 0 { value } else { *entry + value };
                        }
                    }
                }
            }
        }
        matrices
    }
}

/// Nodes that the phase across the triangles of an entry needs.
fn node_count(solver: &TriangleSolver, band: &Band) -> usize {
    let reach = 2.0 * solver.panels.radii.iter().copied().fold(0.0, f64::max);
    count(0.5 * (band.highest - band.lowest) * reach, band.error)
}

/// The entries of each image at a wavenumber, without their phase.
fn without_phase(solver: &TriangleSolver, k: f64, points: &Points) -> Vec<Vec<f32>> {
    let rows = solver.panels.vertices.len();
    let stride = stride(rows);
    let own: Vec<u32> = (0..rows as u32).collect();
    let signs: Vec<Vec<f64>> = (0..solver.images.len())
        .map(|g| (0..solver.images.len()).map(|h| if g == h { 1.0 } else { 0.0 }).collect())
        .collect();
    let mut matrices: Vec<ClassMatrix<'_>> = signs
        .iter()
        .map(|signs| {
            let matrix = vec![Complex32::ZERO; rows * rows];
            ClassMatrix { unknowns: &own, signs, matrix, size: rows }
        })
        .collect();
    solver.assemble_matrices(k, &mut matrices);
    let mut raw = vec![0.0; 2 * stride];
    let of_image = |(image, matrix): (&DVec3, ClassMatrix<'_>)| {
        let mut values = vec![0.0; 2 * stride * rows];
        for (j, out) in values.chunks_exact_mut(2 * stride).enumerate() {
            let (re, im) = raw.split_at_mut(stride);
            let column = &matrix.matrix[j * rows..][..rows];
            for ((entry, re), im) in column.iter().zip(re).zip(im) {
                (*re, *im) = (entry.re, entry.im);
            }
            let from = *image * solver.panels.vertices[j];
            PhasedColumn { k: -k as f32, from, points, terms: &[(1.0, &raw)], out }.compute();
        }
        values
    };
    solver.images.iter().zip(matrices).map(of_image).collect()
}
