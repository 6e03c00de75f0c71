//! Factors of the stiffness of a free body.
//!
//! ```text
//! K u = f,    P K_h Pᵀ = L Lᵀ
//! ```
//!
//! K does not resist the six rigid motions. Six unknowns are fixed such that no rigid motion remains: K_h is
//! K with their rows and columns decoupled. Where the forces balance, the supports carry no load, and u is
//! exact up to a rigid motion.
//!
//! Source: \[FRAC\] App. B. Differs: the paper fixes three points along chosen directions, by a sparse change
//! of basis. Here plain unknowns are fixed, chosen by pivoting on the rows of the rigid motions, which cannot
//! fail for collinear points.
//!
//! A force on few nodes fills only a part of L⁻¹ f: the path from their columns to the root of the
//! elimination tree. The forward substitution visits only that. The reaction, which loads all nodes, is a
//! combination of six precomputed loads.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::sparse::linalg::cholesky::supernodal::SupernodalLltRef;
use faer::{Accum, MatMut, MatRef, Par, Side, Spec};
use glam::DVec3;

use super::ElastostaticsError;
use super::balance::{Balance, Motion};
use crate::fem::ElasticSystem;
use crate::fem::elimination::Elimination;

/// Largest acceptable relative error of the displacement: a thousandth of the error of a fine mesh.
const WORST_SOLVE: f64 = 1e-5;

pub(super) struct AnchoredFactor {
    structure: Elimination,
    values: Vec<f64>,
    held: [usize; 6],
    /// Parent of each supernode in the elimination tree, itself for a root.
    parents: Vec<u32>,
    /// Supernode of each column.
    supernode_of: Vec<u32>,
    /// Displacements under the forces of unit motions.
    under_motions: [Vec<f64>; 6],
}

impl AnchoredFactor {
    pub(super) fn new(system: &ElasticSystem, balance: &Balance) -> Result<Self, ElastostaticsError> {
        // Assembly, with the fixed unknowns decoupled.
        let structure = Elimination::new(system)?;
        let held = held_unknowns(system.nodes());
        let mut entries = structure.gather(system, |entry| system.shifted_block(entry, 0.0));
        structure.detach(&mut entries, &held);
        // Numeric Cholesky factorisation.
        let mut values = structure.room()?;
        let scratch = structure.cholesky().factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default());
        let mut buffer = MemBuffer::try_new(scratch).map_err(|_| structure.out_of_memory())?;
        structure
            .cholesky()
            .factorize_numeric_llt(
                &mut values,
                structure.matrix(&entries),
                Side::Lower,
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut buffer),
                Spec::default(),
            )
            .map_err(|_| ElastostaticsError::Singular { error: f64::INFINITY })?;
        // Elimination tree of the supernodes.
        let mut supernode_of = vec![0_u32; structure.size()];
        let mut parents = Vec::new();
        let supernodes = structure.supernodes();
        for s in 0..supernodes.n_supernodes() {
            let [start, end] = [supernodes.supernode_begin()[s], supernodes.supernode_end()[s]];
            supernode_of[start as usize..end as usize].fill(s as u32);
        }
        for s in 0..supernodes.n_supernodes() {
            let first = supernodes.supernode(s).pattern().iter().min();
            parents.push(first.map_or(s as u32, |column| supernode_of[*column as usize]));
        }
        let under_motions = std::array::from_fn(|_| Vec::new());
        let mut factor = AnchoredFactor { structure, values, held, parents, supernode_of, under_motions };
        // Displacements under the reactions of unit motions.
        let units = Motion::units();
        let mut all: Vec<f64> =
            units.iter().flat_map(|m| balance.forces_of(*m)).flat_map(|f| f.to_array()).collect();
        factor.substitute(&mut all, 6);
        let size = factor.structure.size();
        factor.under_motions = std::array::from_fn(|k| all[k * size..(k + 1) * size].to_vec());
        // Residual of a known solution.
        let error = factor.solve_error(system, balance);
        // This comparison is false for NaN.
        if error <= WORST_SOLVE { Ok(factor) } else { Err(ElastostaticsError::Singular { error }) }
    }

    /// Numbers in the factor.
    pub(super) fn entries(&self) -> usize {
        self.values.len()
    }

    /// Displacements \[m\], up to a rigid motion, under loads, one after the other, whose reaction is that of
    /// the given motions; in place.
    pub(super) fn solve(&self, loads: &mut [f64], motions: &[Motion]) {
        self.substitute(loads, motions.len());
        for (u, motion) in loads.chunks_exact_mut(self.structure.size()).zip(motions) {
            for (under, part) in self.under_motions.iter().zip(motion.to_array()) {
                u.iter_mut().zip(under).for_each(|(u, under)| *u -= part * under);
            }
        }
    }

    /// Solves K_h u = f in place for `width` loads, one after the other.
    fn substitute(&self, loads: &mut [f64], width: usize) {
        let size = self.structure.size();
        let order = self.structure.order();
        // Apply the supports and permute.
        for load in loads.chunks_exact_mut(size) {
            self.held.iter().for_each(|k| load[*k] = 0.0);
        }
        let mut x: Vec<f64> = loads
            .chunks_exact(size)
            .flat_map(|load| order.iter().map(|unknown| load[*unknown as usize]))
            .collect();
        let symbolic = self.structure.supernodes();
        let factor = SupernodalLltRef::new(symbolic, &self.values);
        let count = symbolic.n_supernodes();
        let longest = (0..count).map(|s| symbolic.supernode(s).pattern().len()).max().unwrap_or(0);
        let mut buffer = vec![0.0; longest * width];
        // Forward substitution, on the reached supernodes only.
        for s in self.reached(&x, width) {
            let block = factor.supernode(s);
            let (columns, rows) = (block.val().ncols(), block.pattern());
            let (diagonal, below) = block.val().split_at_row(columns);
            let below_part = &mut buffer[..rows.len() * width];
            let mut x_all = MatMut::from_column_major_slice_mut(&mut x, size, width);
            let mut own = x_all.rb_mut().subrows_mut(block.start(), columns);
            solve_lower_triangular_in_place(diagonal, own.rb_mut(), Par::Seq);
            let product = MatMut::from_column_major_slice_mut(below_part, rows.len(), width);
            matmul(product, Accum::Replace, below, own.rb(), 1.0, Par::Seq);
            for (x, below_part) in x.chunks_exact_mut(size).zip(buffer.chunks_exact(rows.len().max(1))) {
                rows.iter().zip(below_part).for_each(|(row, part)| x[*row as usize] -= part);
            }
        }
        // Back substitution.
        for s in (0..count).rev() {
            let block = factor.supernode(s);
            let (columns, rows) = (block.val().ncols(), block.pattern());
            let (diagonal, below) = block.val().split_at_row(columns);
            for (x, below_part) in x.chunks_exact(size).zip(buffer.chunks_exact_mut(rows.len().max(1))) {
                rows.iter().zip(below_part).for_each(|(row, part)| *part = x[*row as usize]);
            }
            let below_part =
                MatRef::from_column_major_slice(&buffer[..rows.len() * width], rows.len(), width);
            let mut x_all = MatMut::from_column_major_slice_mut(&mut x, size, width);
            let mut own = x_all.rb_mut().subrows_mut(block.start(), columns);
            matmul(own.rb_mut(), Accum::Add, below.transpose(), below_part, -1.0, Par::Seq);
            solve_upper_triangular_in_place(diagonal.transpose(), own.rb_mut(), Par::Seq);
        }
        // Permute back.
        for (load, x) in loads.chunks_exact_mut(size).zip(x.chunks_exact(size)) {
            order.iter().zip(x).for_each(|(unknown, x)| load[*unknown as usize] = *x);
        }
    }

    /// Supernodes in which L⁻¹ f is non-zero, ascending.
    fn reached(&self, x: &[f64], width: usize) -> Vec<usize> {
        let size = self.structure.size();
        let mut reached = vec![false; self.parents.len()];
        for column in (0..size).filter(|c| (0..width).any(|k| x[k * size + c] != 0.0)) {
            let mut s = self.supernode_of[column] as usize;
            while !reached[s] {
                reached[s] = true;
                s = self.parents[s] as usize;
            }
        }
        (0..reached.len()).filter(|s| reached[*s]).collect()
    }

    /// Relative error of the solution for the forces of a known displacement.
    fn solve_error(&self, system: &ElasticSystem, balance: &Balance) -> f64 {
        let nodes = system.nodes();
        let size = nodes.iter().fold(f64::MIN_POSITIVE, |size, x| size.max(x.length()));
        // Bending of the whole body: rounding affects soft motions most.
        let bend = |x: &DVec3| {
            let y = *x / size;
            DVec3::new(y.y * y.z, y.z * y.x, y.x * y.y)
        };
        let mut known: Vec<DVec3> = nodes.iter().map(bend).collect();
        let flat: Vec<f64> = known.iter().flat_map(|u| u.to_array()).collect();
        let mut found = vec![0.0; flat.len()];
        system.multiply_stiffness(&flat, 1, &mut found);
        self.substitute(&mut found, 1);
        let mut found: Vec<DVec3> = found.chunks_exact(3).map(DVec3::from_slice).collect();
        balance.remove_rigid_motion(&mut known);
        balance.remove_rigid_motion(&mut found);
        let square: f64 = known.iter().map(|u| u.length_squared()).sum();
        let error: f64 = known.iter().zip(&found).map(|(u, v)| u.distance_squared(*v)).sum();
        (error / square).sqrt()
    }
}

/// Six unknowns that together exclude rigid motions: at each step the one that the remaining motions move
/// most.
fn held_unknowns(nodes: &[DVec3]) -> [usize; 6] {
    let middle = nodes.iter().sum::<DVec3>() / nodes.len().max(1) as f64;
    let size = nodes.iter().fold(f64::MIN_POSITIVE, |size, x| size.max(x.distance(middle)));
    let row = |unknown: usize| -> [f64; 6] {
        let x = (nodes[unknown / 3] - middle) / size;
        let axis = unknown % 3;
        let turns = [DVec3::X, DVec3::Y, DVec3::Z].map(|a| a.cross(x)[axis]);
        std::array::from_fn(|k| if k < 3 { if k == axis { 1.0 } else { 0.0 } } else { turns[k - 3] })
    };
    let dot = |a: &[f64; 6], b: &[f64; 6]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut rows: Vec<[f64; 6]> = (0..3 * nodes.len()).map(row).collect();
    std::array::from_fn(|_| {
        let squares = rows.iter().map(|r| dot(r, r)).enumerate();
        let (best, square) = squares.fold((0, 0.0), |best, here| if here.1 > best.1 { here } else { best });
        let pivot = rows[best];
        for r in &mut rows {
            let share = dot(r, &pivot) / square;
            r.iter_mut().zip(&pivot).for_each(|(r, p)| *r -= share * p);
        }
        best
    })
}
