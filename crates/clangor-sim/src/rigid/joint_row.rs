//! Rows of joints, and the pseudo-inverse of how they act on each other.
//!
//! `A = J M⁻¹ Jᵀ`: entry ij is the velocity along row i after a unit impulse along row j.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::joint::Blocked;
use super::mover::{Kick, Mover};
use super::stiff_spring::Give;

/// Pivots of the scaled A below this are those of rows that say the same.
const REDUNDANT: f64 = 1e-9;

/// A row of a joint, and the impulse along it so far.
#[derive(Clone, Copy)]
pub(super) struct Row {
    pub(super) joint: usize,
    pub(super) blocked: Blocked,
    /// The two ends among the movers.
    pub(super) ends: [Option<usize>; 2],
    pub(super) impulse: f64,
    /// What it is, if it only pulls.
    pub(super) rope: Option<Rope>,
    /// How it gives way, if it is that of a spring.
    pub(super) give: Option<Give>,
    /// Whether it takes no part in an impact.
    pub(super) released: bool,
}

/// The state of a rope.
#[derive(Clone, Copy)]
pub(super) struct Rope {
    /// Whether it resists an impact.
    pub(super) taut: bool,
    /// Whether it pulls in this step, and reacts like a rod.
    pub(super) pulls: bool,
    /// Velocity of its length that leaves it taut at the middle of the next step [m/s].
    pub(super) limit: f64,
}

impl Row {
    /// Whether it reacts to impulses.
    pub(super) fn reacts(&self) -> bool {
        !self.released && self.rope.is_none_or(|rope| rope.pulls)
    }

    /// Whether it is a rope that pulls.
    pub(super) fn is_tensed(&self) -> bool {
        self.rope.is_some() && self.impulse < 0.0
    }

    /// What its give adds to the diagonal of A \[1/kg\].
    fn softness(&self) -> f64 {
        self.give.map_or(0.0, |give| give.softness)
    }

    /// Velocity along the row.
    pub(super) fn rate(&self, movers: &[Mover]) -> f64 {
        let of = |end: usize, sign: f64| {
            self.ends[end].map_or(0.0, |mover| {
                let Mover { velocity, spin, .. } = movers[mover];
                sign * (self.blocked.along.dot(velocity) + self.blocked.turning[end].dot(spin))
            })
        };
        of(0, 1.0) + of(1, -1.0)
    }

    /// What an impulse along the row does to each end.
    pub(super) fn kicks(&self, impulse: f64) -> impl Iterator<Item = Kick> {
        let kick = move |end: usize, sign: f64| {
            let Blocked { along, turning } = self.blocked;
            self.ends[end].map(|mover| (mover, along * (sign * impulse), turning[end] * (sign * impulse)))
        };
        [kick(0, 1.0), kick(1, -1.0)].into_iter().flatten()
    }

    /// Adds an impulse along the row.
    pub(super) fn push(&mut self, movers: &mut [Mover], impulse: f64) {
        self.impulse += impulse;
        for (mover, linear, angular) in self.kicks(impulse) {
            movers[mover].push(linear, angular);
        }
    }

    /// Velocity along this row after a unit impulse along another one, all bodies free.
    fn after(&self, other: &Row, movers: &[Mover]) -> f64 {
        let change = |(mover, linear, angular): Kick| {
            let Mover { inverse_mass, inverse_inertia, .. } = movers[mover];
            let felt = (linear * inverse_mass, inverse_inertia * angular);
            let of = |end: usize, sign: f64| {
                let Blocked { along, turning } = self.blocked;
                let hit = self.ends[end] == Some(mover);
                if hit { sign * (along.dot(felt.0) + turning[end].dot(felt.1)) } else { 0.0 }
            };
            of(0, 1.0) + of(1, -1.0)
        };
        other.kicks(1.0).map(change).sum()
    }
}

/// A⁺ of the rows that react, by columns, zero elsewhere. Rows are scaled to a diagonal of ones, so that
/// metres and radians compare. Cholesky's factors serve unless rows say the same; then eigenvectors do.
pub(super) fn pseudo_inverse(rows: &[Row], movers: &[Mover]) -> Vec<f64> {
    let chosen: Vec<(usize, f64)> = rows
        .iter()
        .enumerate()
        .filter(|(_, row)| row.reacts())
        .filter_map(|(at, row)| Some((at, row.after(row, movers))).filter(|(_, own)| *own > 0.0))
        .map(|(at, own)| (at, own + rows[at].softness()))
        .map(|(at, own)| (at, own.sqrt().recip()))
        .collect();
    let (count, used) = (rows.len(), chosen.len());
    let scaled = Mat::from_fn(used, used, |i, j| {
        let ((low, a), (high, b)) = (chosen[i.min(j)], chosen[i.max(j)]);
        let softness = if i == j { rows[low].softness() } else { 0.0 };
        (rows[high].after(&rows[low], movers) + softness) * a * b
    });
    let mut inverse = vec![0.0; count * count];
    let mut put = |i: usize, j: usize, value: f64| {
        let ((row, a), (column, b)) = (chosen[i], chosen[j]);
        inverse[column * count + row] += value * a * b;
    };
    if let Ok(factors) = scaled.llt(Side::Lower)
        && (0..used).all(|k| factors.L()[(k, k)].powi(2) > REDUNDANT)
    {
        let solved = factors.solve(&Mat::<f64>::identity(used, used));
        (0..used).for_each(|j| (0..used).for_each(|i| put(i, j, solved[(i, j)])));
        return inverse;
    }
    // A symmetric matrix of finite numbers has eigenvalues.
    let Ok(eigen) = scaled.self_adjoint_eigen(Side::Lower) else { return inverse };
    let (values, vectors) = (eigen.S(), eigen.U());
    for k in (0..used).filter(|&k| values[k] > REDUNDANT) {
        for j in 0..used {
            (0..used).for_each(|i| put(i, j, vectors[(i, k)] * vectors[(j, k)] / values[k]));
        }
    }
    inverse
}
