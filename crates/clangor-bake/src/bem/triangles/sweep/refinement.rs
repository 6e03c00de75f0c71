//! Solution of a dense system by iteration with the factors of another near it.
//!
//! Generalised conjugate residuals for all right-hand sides together: with factors M of the neighbour,
//!
//! ```text
//! z = M⁻¹ r,    w = A z,    r ← r − w (w·r)
//! ```
//!
//! where all w are made orthonormal. The residual is the least over all z so far, of all right-hand sides,
//! and over the solutions of the neighbour. M⁻¹r estimates the error. Source: S. C. Eisenstat, H. C. Elman
//! and M. H. Schultz, SIAM J. Numer. Anal. 20 (1983).

use num_complex::{Complex32, Complex64};

use crate::bem::triangles::dense_system::{ClassSystem, Factors, product};
use crate::bem::triangles::{narrow, widen};

/// Most iterations: more take longer than factors of its own.
const MOST: usize = 24;
/// Length of a direction, in that before it is made orthogonal, below which it is none.
const ABSENT: f64 = 1e-5;

/// What is known from the neighbour.
pub(super) struct Start<'a> {
    pub(super) factors: &'a Factors,
    pub(super) solution: &'a [Complex32],
}

/// A direction of the search and its image by the matrix, of length 1.
struct Direction {
    step: Vec<Complex64>,
    image: Vec<Complex64>,
}

/// The unknowns, one right-hand side after the other; `None` where the neighbour is too far.
pub(super) fn refine(system: &ClassSystem, start: Start<'_>, error: f64) -> Option<Vec<Complex32>> {
    let size = system.size.max(1);
    let mut residual: Vec<Complex64> = system.right.iter().map(|z| widen(*z)).collect();
    let mut solution = vec![Complex64::ZERO; residual.len()];
    let mut directions: Vec<Direction> = Vec::new();
    let mut steps = start.solution.to_vec();
    for _ in 0..MOST {
        let images = product(&system.matrix, system.size, &steps);
        for (step, image) in steps.chunks_exact(size).zip(images.chunks_exact(size)) {
            let Some(direction) = Direction::new(step, image, &directions) else { continue };
            let columns = residual.chunks_exact_mut(size).zip(solution.chunks_exact_mut(size));
            for (residual, solution) in columns {
                let share = dot(&direction.image, residual);
                add(residual, &direction.image, -share);
                add(solution, &direction.step, share);
            }
            directions.push(direction);
        }
        steps = residual.iter().map(|z| narrow(*z)).collect();
        start.factors.solve(&mut steps);
        let is_solved = |(step, solution): (&[Complex32], &[Complex64])| {
            let left: f64 = step.iter().map(|z| f64::from(z.norm_sqr())).sum();
            left <= error * error * length(solution)
        };
        if steps.chunks_exact(size).zip(solution.chunks_exact(size)).all(is_solved) {
            return Some(solution.iter().zip(&steps).map(|(x, z)| narrow(x + widen(*z))).collect());
        }
    }
    None
}

impl Direction {
    /// Makes the image orthogonal to those of other directions, and of length 1; `None` if nothing is left.
    fn new(step: &[Complex32], image: &[Complex32], others: &[Direction]) -> Option<Self> {
        let mut own = Direction {
            step: step.iter().map(|z| widen(*z)).collect(),
            image: image.iter().map(|z| widen(*z)).collect(),
        };
        let whole = length(&own.image).sqrt();
        // Twice, against rounding.
        for other in others.iter().chain(others) {
            let share = dot(&other.image, &own.image);
            add(&mut own.image, &other.image, -share);
            add(&mut own.step, &other.step, -share);
        }
        let left = length(&own.image).sqrt();
        if left.is_nan() || left <= ABSENT * whole {
            return None;
        }
        own.image.iter_mut().chain(&mut own.step).for_each(|z| *z /= left);
        Some(own)
    }
}

/// Σ conj(a) b.
fn dot(a: &[Complex64], b: &[Complex64]) -> Complex64 {
    a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
}

/// Square of the length.
fn length(a: &[Complex64]) -> f64 {
    a.iter().map(Complex64::norm_sqr).sum()
}

fn add(to: &mut [Complex64], what: &[Complex64], share: Complex64) {
    to.iter_mut().zip(what).for_each(|(to, what)| *to += share * what);
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: usize = 80;

    /// Points on a helix, coupled by waves, with two right-hand sides.
    fn system(k: f32) -> ClassSystem {
        let at = |i: usize| {
            let angle = 0.3 * i as f32;
            [angle.cos(), angle.sin(), 0.02 * i as f32]
        };
        let entry = |place: usize| {
            let (i, j) = (at(place % SIZE), at(place / SIZE));
            let r = i.iter().zip(j).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt();
            let own = if place % SIZE == place / SIZE { 1.0 } else { 0.0 };
            Complex32::from_polar(0.05 / (0.1 + r), -k * r) + own
        };
        let right = (0..2 * SIZE).map(|i| Complex32::cis(k * at(i % SIZE)[i / SIZE])).collect();
        ClassSystem { size: SIZE, matrix: (0..SIZE * SIZE).map(entry).collect(), right }
    }

    #[test]
    fn cross_a_neighbour_s_factors_solve_a_system_to_the_error() {
        let neighbour = system(2.6);
        let factors = Factors::new(neighbour.matrix, SIZE);
        let mut solution = neighbour.right;
        factors.solve(&mut solution);
        let exact = system(3.0).solve();
        let size = exact.iter().map(Complex32::norm_sqr).sum::<f32>();
        for error in [1e-2, 1e-3, 1e-4] {
            let start = Start { factors: &factors, solution: &solution };
            let found = refine(&system(3.0), start, error).expect("near");
            let off = found.iter().zip(&exact).map(|(a, b)| (a - b).norm_sqr()).sum::<f32>();
            assert!(f64::from((off / size).sqrt()) < error, "{error}: {}", (off / size).sqrt());
        }
    }
}
