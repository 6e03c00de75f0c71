//! The eigenvalues near one shift, by block Lanczos on the inverse.
//!
//! ```text
//! (K − σ M)⁻¹ M u = θ u,    ω² = σ + 1/θ
//! ```
//!
//! The operator is symmetric in the inner product of the mass. Its extreme eigenvalues are those nearest the
//! shift, on both sides, and converge first in a block Krylov space. Blocks read a factor once for all their
//! columns and resolve degenerate pairs. Every new block is made orthogonal to all previous ones and to the
//! known vectors, rigid motions first, so no eigenvalue is found twice. When the basis is full, its best half
//! starts a new one (thick restart: Wu and Simon 2000, "Thick-restart Lanczos method for large symmetric
//! eigenvalue problems").
//!
//! A Ritz vector with ‖OP u − θ u‖ = ρ gets one more application of the operator, after which
//!
//! ```text
//! K u − ω² M u = −M r / θ²,    relative to ω² M u: (ρ/|θ|) |ω² − σ| / ω²
//! ```
//!
//! Otherwise errors of high frequency, which K amplifies by up to 10⁸, would leave residuals of 1e-3 at
//! frequencies that are correct to ten digits. This bound is the convergence criterion.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{
    ComputeEigenvectors, SelfAdjointEvdParams, self_adjoint_evd, self_adjoint_evd_scratch,
};
use faer::linalg::matmul::matmul;
use faer::{Accum, Auto, Mat, MatMut, MatRef, Par, Spec};

use super::factor::Factor;
use super::{ModalError, random};
use crate::fem::ElasticSystem;

/// Bound of the relative residual at which a Ritz vector has converged.
const CONVERGED: f64 = 1e-8;
/// Upper limit of the last factor of the bound. Modes so low that it is larger have residuals at rounding
/// level; they need a lower shift.
const MOST_AMPLIFIED: f64 = 100.0;
/// Columns of a block.
pub(super) const BLOCK: usize = 8;
/// Restarts before giving up.
const MOST_RESTARTS: usize = 30;

/// Input of a search.
pub(super) struct Search<'a> {
    pub(super) system: &'a ElasticSystem,
    pub(super) factor: &'a Factor<'a>,
    /// σ [1/s²].
    pub(super) shift: f64,
    /// Orthonormal vectors to exclude: rigid motions and known modes.
    pub(super) known: MatRef<'a, f64>,
    /// ω² of interest [1/s²].
    pub(super) range: [f64; 2],
    /// Number of eigenvalues in the range below the shift; all are required.
    pub(super) below: usize,
    /// Number of eigenvalues above the shift that are required.
    pub(super) above: usize,
}

/// Eigenvalues ω² [1/s²], ascending, and vectors, orthonormal in the mass.
pub(super) struct Found {
    pub(super) values: Vec<f64>,
    pub(super) vectors: Mat<f64>,
    /// Applications of the operator to a vector.
    pub(super) solves: usize,
}

/// Ritz pairs of the basis.
struct Ritz {
    theta: Vec<f64>,
    /// Weights of the basis, a column each.
    weights: Mat<f64>,
    /// ρ of each.
    residual: Vec<f64>,
}

struct Basis<'a> {
    search: &'a Search<'a>,
    /// Known vectors, then the basis.
    vectors: Mat<f64>,
    /// Columns of the basis.
    used: usize,
    /// Projection of the operator on the basis.
    projected: Mat<f64>,
    /// M times the last block and the one before.
    heavy: [Mat<f64>; 2],
    /// The last block has coefficients with all of the basis.
    restarted: bool,
    solves: usize,
}

impl Search<'_> {
    fn size(&self) -> usize {
        3 * self.system.node_count()
    }

    /// Iterates until all required eigenvalues have converged.
    ///
    /// # Errors
    /// [`ModalError::Incomplete`] if it does not.
    pub(super) fn run(&self) -> Result<Found, ModalError> {
        // Basis size, and the first convergence check.
        let wanted = self.below + self.above;
        let free = self.system.free_count() - self.known.ncols();
        let cap = (5 * wanted + 12 * BLOCK).min(free / BLOCK * BLOCK);
        let mut basis = Basis::new(self, cap);
        let mut next_check = (2 * wanted).max(4 * BLOCK).min(cap);
        let mut restarts = 0;
        loop {
            // Lanczos step: apply the operator and orthogonalise.
            let coupling = basis.extend();
            if basis.used < next_check && basis.used + BLOCK <= cap {
                basis.append(coupling);
                continue;
            }
            // Rayleigh–Ritz, and convergence on either side of the shift.
            let ritz = basis.ritz(&coupling);
            let converged = self.converged(&ritz);
            let count = |low: f64, high: f64| {
                converged
                    .iter()
                    .filter(|k| {
                        let value = self.shift + 1.0 / ritz.theta[**k];
                        value > low && value < high
                    })
                    .count()
            };
            let below = count(self.range[0], self.shift);
            let above = count(self.shift, self.range[1]);
            if below >= self.below && above >= self.above {
                return Ok(basis.found(&ritz, &converged));
            }
            // Extend the basis, or restart it from the best Ritz vectors when full.
            if basis.used + BLOCK <= cap {
                basis.append(coupling);
            } else {
                restarts += 1;
                if restarts > MOST_RESTARTS {
                    return Err(ModalError::Incomplete {
                        found: below + above,
                        expected: wanted,
                        frequency: super::frequency(self.shift),
                    });
                }
                basis.restart(&ritz, &coupling, wanted);
            }
            next_check = basis.used + (wanted / 6).next_multiple_of(BLOCK).max(2 * BLOCK);
        }
    }

    /// Ritz pairs of the range that are good enough, by eigenvalue.
    fn converged(&self, ritz: &Ritz) -> Vec<usize> {
        let value = |k: usize| self.shift + 1.0 / ritz.theta[k];
        let good = |k: &usize| {
            let value = value(*k);
            let bound = ritz.residual[*k] / ritz.theta[*k].abs()
                * ((value - self.shift) / value).abs().clamp(1e-3, MOST_AMPLIFIED);
            value > self.range[0] && value < self.range[1] && bound <= CONVERGED
        };
        let mut converged: Vec<usize> = (0..ritz.theta.len()).filter(good).collect();
        converged.sort_unstable_by(|a, b| value(*a).total_cmp(&value(*b)));
        converged
    }

    /// M times a block.
    fn heavy(&self, block: MatRef<'_, f64>) -> Mat<f64> {
        let mut heavy = Mat::zeros(block.nrows(), block.ncols());
        let (mut rows, mut products) = (vec![0.0; block.nrows() * BLOCK], vec![0.0; block.nrows() * BLOCK]);
        for from in (0..block.ncols()).step_by(BLOCK) {
            let width = BLOCK.min(block.ncols() - from);
            pack(block.subcols(from, width), &mut rows);
            self.system.multiply_mass(&rows, BLOCK, &mut products);
            for k in 0..width {
                let column = heavy.col_mut(from + k).iter_mut();
                column.zip(products.iter().skip(k).step_by(BLOCK)).for_each(|(to, value)| *to = *value);
            }
        }
        heavy
    }
}

/// Interleaves up to [`BLOCK`] columns row by row; the remaining lanes are unchanged.
pub(super) fn pack(columns: MatRef<'_, f64>, rows: &mut [f64]) {
    for k in 0..columns.ncols() {
        let lane = rows.iter_mut().skip(k).step_by(BLOCK);
        lane.zip(columns.col(k).iter()).for_each(|(to, value)| *to = *value);
    }
}

impl<'a> Basis<'a> {
    fn new(search: &'a Search<'a>, cap: usize) -> Self {
        let (size, known) = (search.size(), search.known.ncols());
        let mut vectors = Mat::zeros(size, known + cap + BLOCK);
        vectors.subcols_mut(0, known).copy_from(search.known);
        let mut seed = 7;
        let mut block = Mat::from_fn(size, BLOCK, |_, _| random(&mut seed));
        let mut basis = Basis {
            search,
            vectors,
            used: 0,
            projected: Mat::zeros(cap + BLOCK, cap + BLOCK),
            heavy: [Mat::zeros(size, 0), Mat::zeros(size, 0)],
            restarted: false,
            solves: 0,
        };
        // One application of the operator suppresses high frequencies in the start block.
        block = search.heavy(block.as_ref());
        search.factor.solve(block.as_mut());
        let (block, heavy, _) = basis.orthonormal(block);
        basis.place(&block);
        basis.heavy[1] = heavy;
        basis.used = BLOCK;
        basis
    }

    fn known(&self) -> usize {
        self.search.known.ncols()
    }

    fn place(&mut self, block: &Mat<f64>) {
        let at = self.known() + self.used;
        self.vectors.subcols_mut(at, BLOCK).copy_from(block);
    }

    /// Applies the operator to the last block and orthogonalises the result: the next block, M times it, and
    /// its coefficients in the result.
    fn extend(&mut self) -> (Mat<f64>, Mat<f64>, Mat<f64>) {
        let (known, last) = (self.known(), self.used - BLOCK);
        let mut image = self.heavy[1].clone();
        self.search.factor.solve(image.as_mut());
        self.solves += BLOCK;
        // In exact arithmetic only the last two blocks couple, or all of a restarted basis.
        let recent = if self.restarted { 0 } else { self.used - BLOCK - self.heavy[0].ncols() };
        let count = self.used - recent;
        let mut share = Mat::<f64>::zeros(count, BLOCK);
        if self.restarted {
            let heavy = self.search.heavy(image.as_ref());
            multiply(share.as_mut(), self.vectors.subcols(known, self.used).transpose(), heavy.as_ref(), 1.0);
        } else {
            let before = self.heavy[0].ncols();
            let (top, bottom) = share.as_mut().split_at_row_mut(before);
            multiply(top, self.heavy[0].transpose(), image.as_ref(), 1.0);
            multiply(bottom, self.heavy[1].transpose(), image.as_ref(), 1.0);
        }
        multiply(image.as_mut(), self.vectors.subcols(known + recent, count), share.as_ref(), -1.0);
        for i in 0..BLOCK {
            for j in 0..BLOCK {
                let here = self.used - BLOCK - recent;
                self.projected[(last + i, last + j)] = 0.5 * (share[(here + i, j)] + share[(here + j, i)]);
            }
        }
        let (block, heavy, coefficients) = self.orthonormal(image);
        self.restarted = false;
        (block, heavy, coefficients)
    }

    /// Appends the next block to the basis.
    fn append(&mut self, (block, heavy, coefficients): (Mat<f64>, Mat<f64>, Mat<f64>)) {
        self.place(&block);
        let last = self.used - BLOCK;
        for i in 0..BLOCK {
            for j in 0..BLOCK {
                self.projected[(self.used + i, last + j)] = coefficients[(i, j)];
                self.projected[(last + j, self.used + i)] = coefficients[(i, j)];
            }
        }
        let [_, before] = std::mem::replace(&mut self.heavy, [Mat::zeros(0, 0), heavy]);
        self.heavy[0] = before;
        self.used += BLOCK;
    }

    /// A block made orthogonal to everything and orthonormal; M times it; and R, with block = result × R.
    fn orthonormal(&self, mut block: Mat<f64>) -> (Mat<f64>, Mat<f64>, Mat<f64>) {
        let all = self.vectors.subcols(0, self.known() + self.used);
        let mut total = Mat::<f64>::identity(BLOCK, BLOCK);
        let mut heavy = self.search.heavy(block.as_ref());
        let mut seed = 11 + self.solves as u64;
        for pass in 0.. {
            let mut share = Mat::<f64>::zeros(all.ncols(), BLOCK);
            multiply(share.as_mut(), all.transpose(), heavy.as_ref(), 1.0);
            multiply(block.as_mut(), all, share.as_ref(), -1.0);
            heavy = self.search.heavy(block.as_ref());
            let (factors, replaced) = gram_schmidt(&mut block, &mut heavy, &mut seed);
            total = &factors * &total;
            // A random replacement column needs another orthogonalisation.
            if !replaced || pass > 3 {
                break;
            }
            heavy = self.search.heavy(block.as_ref());
        }
        (block, heavy, total)
    }

    fn ritz(&self, (_, _, coupling): &(Mat<f64>, Mat<f64>, Mat<f64>)) -> Ritz {
        let projected = self.projected.submatrix(0, 0, self.used, self.used);
        let weights = eigenvectors(projected);
        let mut images = projected * &weights;
        let theta: Vec<f64> = (0..self.used).map(|k| weights.col(k).transpose() * images.col(k)).collect();
        let last = coupling * weights.subrows(self.used - BLOCK, BLOCK);
        let mut residual = Vec::with_capacity(self.used);
        for (k, theta) in theta.iter().enumerate() {
            let inside = images.col_mut(k);
            inside.iter_mut().zip(weights.col(k).iter()).for_each(|(x, w)| *x -= theta * w);
            residual.push(images.col(k).norm_l2().hypot(last.col(k).norm_l2()));
        }
        Ritz { theta, weights, residual }
    }

    /// Keeps the Ritz vectors nearest the shift.
    fn restart(&mut self, ritz: &Ritz, coupling: &(Mat<f64>, Mat<f64>, Mat<f64>), wanted: usize) {
        let mut order: Vec<usize> = (0..ritz.theta.len()).collect();
        order.sort_unstable_by(|a, b| ritz.theta[*b].abs().total_cmp(&ritz.theta[*a].abs()));
        let keep = (self.used / 2).max((wanted + 2 * BLOCK).min(self.used - 2 * BLOCK)) / BLOCK * BLOCK;
        order.truncate(keep);
        let weights = Mat::from_fn(self.used, keep, |i, k| ritz.weights[(i, order[k])]);
        let known = self.known();
        let vectors = self.vectors.subcols(known, self.used) * &weights;
        self.vectors.subcols_mut(known, keep).copy_from(&vectors);
        let link = &coupling.2 * weights.subrows(self.used - BLOCK, BLOCK);
        self.projected.fill(0.0);
        for k in 0..keep {
            self.projected[(k, k)] = ritz.theta[order[k]];
            for i in 0..BLOCK {
                self.projected[(keep + i, k)] = link[(i, k)];
                self.projected[(k, keep + i)] = link[(i, k)];
            }
        }
        self.used = keep;
        self.place(&coupling.0);
        self.heavy = [Mat::zeros(coupling.1.nrows(), 0), coupling.1.clone()];
        self.used += BLOCK;
        self.restarted = true;
    }

    /// The converged vectors, with one more application of the operator.
    fn found(mut self, ritz: &Ritz, converged: &[usize]) -> Found {
        let weights = Mat::from_fn(self.used, converged.len(), |i, k| ritz.weights[(i, converged[k])]);
        let mut vectors = self.vectors.subcols(self.known(), self.used) * &weights;
        vectors = self.search.heavy(vectors.as_ref());
        self.search.factor.solve(vectors.as_mut());
        self.solves += converged.len();
        let heavy = self.search.heavy(vectors.as_ref());
        for k in 0..converged.len() {
            let norm = (vectors.col(k).transpose() * heavy.col(k)).sqrt();
            vectors.col_mut(k).iter_mut().for_each(|x| *x /= norm);
        }
        let values = converged.iter().map(|k| self.search.shift + 1.0 / ritz.theta[*k]).collect();
        Found { values, vectors, solves: self.solves }
    }
}

/// Eigenvectors of a small symmetric matrix. The residual measures their error.
///
/// By QR iteration: faer 0.24's divide and conquer, which it takes for sizes from 128, mixes up eigenvalues
/// that nearly coincide (seen: values off by 1e-5 in the spectrum of a ball).
pub(crate) fn eigenvectors(matrix: MatRef<'_, f64>) -> Mat<f64> {
    let size = matrix.nrows();
    let mut parameters = <SelfAdjointEvdParams as Auto<f64>>::auto();
    parameters.recursion_threshold = usize::MAX;
    let parameters = Spec::new(parameters);
    let scratch = self_adjoint_evd_scratch::<f64>(size, ComputeEigenvectors::Yes, Par::Seq, parameters);
    let mut buffer = MemBuffer::new(scratch);
    let (mut values, mut vectors) = (Diag::zeros(size), Mat::zeros(size, size));
    let (into, stack) = (Some(vectors.as_mut()), MemStack::new(&mut buffer));
    match self_adjoint_evd(matrix, values.as_mut(), into, Par::Seq, stack, parameters) {
        Ok(()) => vectors,
        Err(_) => Mat::identity(size, size),
    }
}

/// result += factor × a × b.
fn multiply(result: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>, factor: f64) {
    matmul(result, Accum::Add, a, b, factor, Par::Seq);
}

/// Makes the columns of a block orthonormal; `heavy` is M times the block before and after. Returns R with
/// before = after × R, and whether a dependent column was replaced by a random one.
fn gram_schmidt(block: &mut Mat<f64>, heavy: &mut Mat<f64>, seed: &mut u64) -> (Mat<f64>, bool) {
    let width = block.ncols();
    let mut factors = Mat::<f64>::zeros(width, width);
    let mut replaced = false;
    for k in 0..width {
        let dot = |a: &Mat<f64>, i: usize, b: &Mat<f64>, j: usize| a.col(i).transpose() * b.col(j);
        let before = dot(block, k, heavy, k).max(0.0).sqrt();
        // Modified Gram–Schmidt, twice for orthogonality to rounding.
        for _ in 0..2 {
            for i in 0..k {
                let share = dot(heavy, i, block, k);
                factors[(i, k)] += share;
                for m in [&mut *block, &mut *heavy] {
                    let (done, rest) = m.as_mut().split_at_col_mut(k);
                    rest.col_mut(0).iter_mut().zip(done.col(i).iter()).for_each(|(x, y)| *x -= share * y);
                }
            }
        }
        // A dependent column is replaced by a random one.
        let norm = dot(block, k, heavy, k).max(0.0).sqrt();
        if norm <= 1e-12 * before || norm.is_nan() || norm == 0.0 {
            replaced = true;
            block.col_mut(k).iter_mut().for_each(|x| *x = random(seed));
            heavy.col_mut(k).fill(0.0);
            continue;
        }
        // Normalise.
        factors[(k, k)] = norm;
        for m in [&mut *block, &mut *heavy] {
            m.col_mut(k).iter_mut().for_each(|x| *x /= norm);
        }
    }
    (factors, replaced)
}
