//! Stiffness and mass of a whole mesh, sparse and symmetric.
//!
//! The mesh is one of a volume or of a section. Elements have any number of nodes, and nodes three unknowns
//! each. Both matrices have one entry per pair of nodes that share an element: a 3 × 3 block of the stiffness
//! and one number of the mass, which is the same along x, y and z. Only pairs with row ≥ column are stored.

use glam::{DMat3, DVec3};

use super::ElasticConstants;
use super::across_walls::Columns;
use super::element::{ElementMatrices, element_matrices};
use super::products::{LANES, Matrix, Product};
use super::rigid_motions::{orthonormal_in_mass, rigid_motions};
use super::supports::Holding;
use crate::mesh::tetrahedra::TetMesh;

/// K and M of a free body. Unknown 3n + c is the displacement of node n along axis c, or that of
/// [`across_walls`](super::across_walls).
#[derive(Clone, Debug)]
pub struct ElasticSystem {
    /// Node positions \[m\].
    nodes: Vec<DVec3>,
    /// Where the column of each node starts, and the end.
    starts: Vec<usize>,
    /// Row of each entry, ascending in a column, the diagonal first.
    rows: Vec<u32>,
    /// Blocks of K [N/m].
    stiffness: Vec<DMat3>,
    /// Factors of M \[kg\].
    mass: Vec<f64>,
    /// Motions without energy, in the unknowns.
    rigid: Vec<Vec<DVec3>>,
    /// Nodes whose unknowns are not their displacements.
    columns: Columns,
    /// Unknowns that stay zero; empty if all are free.
    held: Vec<bool>,
    /// By entry: the axes along which held unknowns leave no mass; empty if all are free.
    massless: Vec<[bool; 3]>,
}

/// A mesh, as a system sees it.
pub(crate) struct Elements<'a, E> {
    /// Node positions \[m\].
    pub(crate) nodes: Vec<DVec3>,
    /// Nodes of each element.
    pub(crate) elements: &'a [E],
    /// Independent motions without energy, at the nodes.
    pub(crate) rigid: Vec<Vec<DVec3>>,
    /// Nodes whose unknowns are not their displacements.
    pub(crate) columns: Columns,
}

impl ElasticSystem {
    /// Assembles the matrices of a mesh.
    pub fn new(mesh: &TetMesh, constants: &ElasticConstants) -> Self {
        let elements = Elements {
            nodes: mesh.nodes.clone(),
            elements: &mesh.elements,
            rigid: rigid_motions(&mesh.nodes).into(),
            columns: Columns::default(),
        };
        Self::assemble(elements, |e| {
            let ElementMatrices { stiffness, mass } = element_matrices(&mesh.positions(e), constants);
            move |i: usize, j: usize| (stiffness[i][j], mass[i][j])
        })
    }

    /// Assembles elements. `matrices(e)` returns a function of two nodes of element `e`, the first not before
    /// the second, to their block of the stiffness and factor of the mass.
    pub(crate) fn assemble<E: AsRef<[u32]>, F: Fn(usize, usize) -> (DMat3, f64)>(
        mesh: Elements<'_, E>,
        matrices: impl Fn(usize) -> F,
    ) -> Self {
        let (starts, rows) = pattern(mesh.nodes.len(), mesh.elements);
        let mut stiffness = vec![DMat3::ZERO; rows.len()];
        let mut mass = vec![0.0; rows.len()];
        for (e, element) in mesh.elements.iter().enumerate() {
            let (element, matrices) = (element.as_ref(), matrices(e));
            for i in 0..element.len() {
                for j in 0..=i {
                    let (a, b) = (element[i], element[j]);
                    let (row, column) = (a.max(b), a.min(b) as usize);
                    let found = rows[starts[column]..starts[column + 1]].partition_point(|r| *r < row);
                    let entry = starts[column] + found;
                    let (block, factor) = matrices(i, j);
                    stiffness[entry] += if a >= b { block } else { block.transpose() };
                    mass[entry] += factor;
                }
            }
        }
        let (held, massless) = (Vec::new(), Vec::new());
        let Elements { nodes, mut rigid, columns, .. } = mesh;
        rigid.iter_mut().for_each(|motion| columns.take_displacements(motion));
        ElasticSystem { nodes, starts, rows, stiffness, mass, rigid, columns, held, massless }
    }

    /// The unknowns of displacements of the nodes.
    pub fn unknowns_of(&self, motion: &[DVec3]) -> Vec<f64> {
        let mut unknowns = motion.to_vec();
        self.columns.take_displacements(&mut unknowns);
        unknowns.iter().flat_map(|u| u.to_array()).collect()
    }

    /// The displacements of the nodes that unknowns stand for.
    pub fn displacements(&self, unknowns: &[f64]) -> Vec<DVec3> {
        let mut motion: Vec<DVec3> = unknowns.chunks_exact(3).map(DVec3::from_slice).collect();
        self.columns.to_displacements(&mut motion);
        motion
    }

    /// The same body with unknowns held at zero, and the remaining zero-energy motions at the nodes. Held
    /// unknowns keep the diagonal of the stiffness and no mass, so that they take no part in any mode. All
    /// nodes of a wall's column are held alike.
    pub(crate) fn holding(mut self, held: Vec<bool>, mut rigid: Vec<Vec<DVec3>>) -> Self {
        rigid.iter_mut().for_each(|motion| self.columns.take_displacements(motion));
        self.massless = vec![[false; 3]; self.rows.len()];
        for column in 0..self.nodes.len() {
            for entry in self.starts[column]..self.starts[column + 1] {
                let row = self.rows[entry] as usize;
                for c in 0..3 {
                    for r in 0..3 {
                        let diagonal = row == column && r == c;
                        if !diagonal && (held[3 * row + r] || held[3 * column + c]) {
                            self.stiffness[entry].col_mut(c)[r] = 0.0;
                        }
                    }
                    self.massless[entry][c] = held[3 * row + c] || held[3 * column + c];
                }
            }
        }
        ElasticSystem { held, rigid, ..self }
    }

    /// The same body with supports, which leave no motion without energy.
    #[must_use]
    pub fn held_by(mut self, holding: &Holding) -> Self {
        for spring in &holding.springs {
            for &(a, first) in &spring.weights {
                for &(b, second) in spring.weights.iter().filter(|(b, _)| *b <= a) {
                    // The nodes of a spring share an element, so the pair is in the pattern.
                    let own = self.starts[b as usize]..self.starts[b as usize + 1];
                    if let Ok(found) = self.rows[own.clone()].binary_search(&a) {
                        self.stiffness[own.start + found] += spring.block(first * second);
                    }
                }
            }
        }
        let held: Vec<bool> = holding.clamped.iter().flat_map(|held| [*held; 3]).collect();
        match held.contains(&true) {
            true => self.holding(held, Vec::new()),
            false => ElasticSystem { rigid: Vec::new(), ..self },
        }
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// Node positions \[m\].
    pub fn nodes(&self) -> &[DVec3] {
        &self.nodes
    }

    /// Column starts and rows of the pairs of nodes that are coupled, row ≥ column.
    pub fn pattern(&self) -> (&[usize], &[u32]) {
        (&self.starts, &self.rows)
    }

    /// Row, column, entry of K [N/m] and entry of M \[kg\] for the lower half of both, by unknowns.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize, f64, f64)> {
        let pairs = (0..self.nodes.len()).flat_map(|column| {
            (self.starts[column]..self.starts[column + 1]).map(move |entry| (column, entry))
        });
        pairs.flat_map(|(column, entry)| {
            let row = self.rows[entry] as usize;
            let (block, mass) = (self.stiffness[entry], self.mass[entry]);
            (0..9).map(|k| (k % 3, k / 3)).filter(move |(r, c)| row != column || r >= c).map(move |(r, c)| {
                (3 * row + r, 3 * column + c, block.col(c)[r], if r == c { mass } else { 0.0 })
            })
        })
    }

    /// The zero-energy motions, orthonormal in the mass: six of a volume.
    pub fn rigid_motions(&self) -> Vec<Vec<f64>> {
        orthonormal_in_mass(&self.rigid, |x, y| self.multiply_mass(x, 1, y))
    }

    /// Number of zero-energy motions.
    pub fn rigid_count(&self) -> usize {
        self.rigid.len()
    }

    /// Number of unknowns that are not held.
    pub(crate) fn free_count(&self) -> usize {
        3 * self.nodes.len() - self.held.iter().filter(|held| **held).count()
    }

    /// The block of K − σ M at an entry of the pattern.
    pub(crate) fn shifted_block(&self, entry: usize, shift: f64) -> DMat3 {
        let mut mass = DVec3::splat(shift * self.mass[entry]);
        if let Some(massless) = self.massless.get(entry) {
            (0..3).filter(|a| massless[*a]).for_each(|a| mass[a] = 0.0);
        }
        self.stiffness[entry] - DMat3::from_diagonal(mass)
    }

    /// M x for `width` vectors at once, stored with unknown 3n + c of vector k at `x[(3n + c) · width + k]`;
    /// fastest for eight.
    pub fn multiply_mass(&self, x: &[f64], width: usize, y: &mut [f64]) {
        if width == LANES {
            self.multiply_lanes(Matrix::Scalars(&self.mass), x, y);
        } else {
            self.multiply_mass_plainly(x, width, y);
        }
        self.hold(y, width);
    }

    /// Sets held unknowns to zero. Vectors are stored as in [`multiply_mass`](Self::multiply_mass), which
    /// expects and preserves these zeros.
    pub(crate) fn hold(&self, x: &mut [f64], width: usize) {
        let held = x.chunks_exact_mut(width).zip(&self.held).filter(|(_, held)| **held);
        held.for_each(|(x, _)| x.fill(0.0));
    }

    fn multiply_mass_plainly(&self, x: &[f64], width: usize, y: &mut [f64]) {
        y.fill(0.0);
        let span = 3 * width;
        for column in 0..self.nodes.len() {
            let own = column * span..(column + 1) * span;
            for entry in self.starts[column]..self.starts[column + 1] {
                let m = self.mass[entry];
                let row = self.rows[entry] as usize;
                let there = row * span..(row + 1) * span;
                add_scaled(&mut y[there.clone()], &x[own.clone()], m);
                if row != column {
                    add_scaled(&mut y[own.clone()], &x[there], m);
                }
            }
        }
    }

    /// K x, stored as in [`multiply_mass`](Self::multiply_mass).
    pub fn multiply_stiffness(&self, x: &[f64], width: usize, y: &mut [f64]) {
        if width == LANES {
            return self.multiply_lanes(Matrix::Blocks(&self.stiffness), x, y);
        }
        y.fill(0.0);
        for column in 0..self.nodes.len() {
            for entry in self.starts[column]..self.starts[column + 1] {
                let block = &self.stiffness[entry];
                let row = self.rows[entry] as usize;
                add_block(y, x, row, column, width, |r, c| block.col(c)[r]);
                if row != column {
                    add_block(y, x, column, row, width, |r, c| block.col(r)[c]);
                }
            }
        }
    }

    /// y += |K| |x|, entry by entry: the size of the forces whose sum is K x.
    pub(crate) fn add_force_magnitudes(&self, x: &[f64], y: &mut [f64]) {
        for (row, column, stiffness, _) in self.entries() {
            y[row] += stiffness.abs() * x[column].abs();
            if row != column {
                y[column] += stiffness.abs() * x[row].abs();
            }
        }
    }

    fn multiply_lanes(&self, matrix: Matrix<'_>, x: &[f64], y: &mut [f64]) {
        let (starts, rows) = (&self.starts, &self.rows);
        pulp::Arch::new().dispatch(Product { starts, rows, matrix, x, y });
    }
}

fn add_scaled(y: &mut [f64], x: &[f64], factor: f64) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}

fn add_block(
    y: &mut [f64],
    x: &[f64],
    row: usize,
    column: usize,
    width: usize,
    block: impl Fn(usize, usize) -> f64,
) {
    for r in 0..3 {
        for c in 0..3 {
            let (to, from) = ((3 * row + r) * width, (3 * column + c) * width);
            add_scaled(&mut y[to..to + width], &x[from..from + width], block(r, c));
        }
    }
}

/// The pairs of nodes that share an element, by columns.
fn pattern<E: AsRef<[u32]>>(count: usize, elements: &[E]) -> (Vec<usize>, Vec<u32>) {
    // Upper bound of the entries of each column, with duplicates.
    let mut filled = vec![0_usize; count + 1];
    for element in elements.iter().map(AsRef::as_ref) {
        for i in element {
            filled[*i as usize + 1] += element.iter().filter(|j| *j >= i).count();
        }
    }
    for n in 0..count {
        filled[n + 1] += filled[n];
    }
    // Rows of each column, with duplicates.
    let mut all = vec![0_u32; filled[count]];
    let mut next = filled.clone();
    for element in elements.iter().map(AsRef::as_ref) {
        for i in element {
            for j in element.iter().filter(|j| *j >= i) {
                all[next[*i as usize]] = *j;
                next[*i as usize] += 1;
            }
        }
    }
    // Sort each column and drop duplicates.
    let mut starts = vec![0];
    let mut rows = Vec::with_capacity(all.len() / 3);
    for n in 0..count {
        let column = &mut all[filled[n]..filled[n + 1]];
        column.sort_unstable();
        let begin = rows.len();
        for row in column {
            if rows.len() == begin || rows[rows.len() - 1] != *row {
                rows.push(*row);
            }
        }
        starts.push(rows.len());
    }
    (starts, rows)
}
