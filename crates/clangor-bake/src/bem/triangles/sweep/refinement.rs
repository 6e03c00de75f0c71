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

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
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

/// Directions of the search, and their images by the matrix, which are orthonormal: column after column.
#[derive(Default)]
struct Directions {
    steps: Vec<Complex64>,
    images: Vec<Complex64>,
}

/// The unknowns, one right-hand side after the other; `None` where the neighbour is too far.
pub(super) fn refine(system: &ClassSystem, start: Start<'_>, error: f64) -> Option<Vec<Complex32>> {
    let size = system.size.max(1);
    let mut residual: Vec<Complex64> = system.right.iter().map(|z| widen(*z)).collect();
    let mut solution = vec![Complex64::ZERO; residual.len()];
    let mut directions = Directions::default();
    let mut steps = start.solution.to_vec();
    for _ in 0..MOST {
        // New directions, and what they explain of each residual.
        let images = product(&system.matrix, system.size, &steps);
        let first = directions.images.len();
        directions.extend(&steps, &images, size);
        let (steps_now, images_now) = (&directions.steps[first..], &directions.images[first..]);
        let shares = products(images_now, &residual, size);
        add(&mut residual, -1.0, (images_now, &shares), size);
        add(&mut solution, 1.0, (steps_now, &shares), size);
        // What is left, by the factors of the neighbour.
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

impl Directions {
    /// Adds steps, their images made orthogonal to those before and of length 1; without those of which
    /// nothing is left.
    fn extend(&mut self, steps: &[Complex32], images: &[Complex32], size: usize) {
        let mut steps: Vec<Complex64> = steps.iter().map(|z| widen(*z)).collect();
        let mut images: Vec<Complex64> = images.iter().map(|z| widen(*z)).collect();
        let whole: Vec<f64> = images.chunks_exact(size).map(|image| length(image).sqrt()).collect();
        // All together against the directions before, then each against the others; twice, against rounding.
        let known = self.images.len();
        for _ in 0..2 {
            let shares = products(&self.images[..known], &images, size);
            add(&mut images, -1.0, (&self.images[..known], &shares), size);
            add(&mut steps, -1.0, (&self.steps[..known], &shares), size);
        }
        for (own, whole) in whole.into_iter().enumerate() {
            let place = own * size..(own + 1) * size;
            let (image, step) = (&mut images[place.clone()], &mut steps[place]);
            for _ in 0..2 {
                let shares = products(&self.images[known..], image, size);
                add(image, -1.0, (&self.images[known..], &shares), size);
                add(step, -1.0, (&self.steps[known..], &shares), size);
            }
            let left = length(image).sqrt();
            if left.is_nan() || left <= ABSENT * whole {
                continue;
            }
            self.images.extend(image.iter().map(|z| z / left));
            self.steps.extend(step.iter().map(|z| z / left));
        }
    }
}

/// Products conj(a)·b of all columns a of one matrix, `size` long, with all columns b of another.
fn products(of: &[Complex64], columns: &[Complex64], size: usize) -> Vec<Complex64> {
    let (count, width) = (of.len() / size, columns.len() / size);
    let mut shares = vec![Complex64::ZERO; count * width];
    if count > 0 {
        matmul(
            MatMut::from_column_major_slice_mut(&mut shares, count, width),
            Accum::Replace,
            MatRef::from_column_major_slice(of, size, count).adjoint(),
            MatRef::from_column_major_slice(columns, size, width),
            Complex64::ONE,
            Par::Seq,
        );
    }
    shares
}

/// Adds these shares of the columns of a matrix, times a factor, to each column of another.
fn add(columns: &mut [Complex64], factor: f64, (what, shares): (&[Complex64], &[Complex64]), size: usize) {
    let (count, width) = (what.len() / size, columns.len() / size);
    if count > 0 {
        matmul(
            MatMut::from_column_major_slice_mut(columns, size, width),
            Accum::Add,
            MatRef::from_column_major_slice(what, size, count),
            MatRef::from_column_major_slice(shares, count, width),
            factor.into(),
            Par::Seq,
        );
    }
}

/// Square of the length.
fn length(a: &[Complex64]) -> f64 {
    a.iter().map(Complex64::norm_sqr).sum()
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
