//! Fast estimate of the lowest frequency of a free body.
//!
//! Lanczos iteration with one vector on (K + s M)⁻¹ M, orthogonal to the rigid motions. θ, the largest
//! eigenvalue of its tridiagonal matrix, gives ω² = 1/θ − s from above. It needs one factorisation, at s > 0,
//! where the matrix is positive definite, and a dozen solves. There is no proof that no lower mode exists;
//! missing it would need a start vector without any component of it.
//!
//! With V the volume, L the longest extent and c_s the speed of shear waves, s = ¼ (c_s V/L³)² is below the
//! square of the lowest frequency of plates and blocks. For a slender bar it is above, by too little to lose
//! digits.

use faer::Mat;

use super::factor::factor;
use super::{ModalError, frequency, lanczos, random};
use crate::fem::elimination::Elimination;
use crate::fem::{ElasticConstants, ElasticSystem};

/// Most steps.
const MOST_STEPS: usize = 40;
/// Relative change of ω² over two steps that counts as converged.
const STILL: f64 = 2e-3;

/// The lowest frequency \[Hz\] of a free body of this material, within 0.2 % of that of its mesh.
///
/// # Errors
/// [`ModalError`].
pub fn lowest_frequency(system: &ElasticSystem, constants: &ElasticConstants) -> Result<f64, ModalError> {
    let size = 3 * system.node_count();
    let shift = shift(system, constants);
    if !(shift > 0.0 && shift.is_finite()) {
        return Err(ModalError::Singular { shift });
    }
    // Factorisation; K + s M must be positive definite.
    let structure = Elimination::new(system)?;
    let factor = factor(&structure, system, -shift)?;
    if factor.below > 0 {
        return Err(ModalError::Singular { shift: -shift });
    }
    // Rigid motions and the random start vector.
    let rigid = system.rigid_motions();
    let mut heavy_rigid = vec![vec![0.0; size]; rigid.len()];
    rigid.iter().zip(&mut heavy_rigid).for_each(|(r, h)| system.multiply_mass(r, 1, h));
    let mut seed = 3;
    let mut next: Vec<f64> = (0..size).map(|_| random(&mut seed)).collect();
    let mut heavy = vec![0.0; size];
    let (mut basis, mut heavy_basis): (Vec<Vec<f64>>, Vec<Vec<f64>>) = (Vec::new(), Vec::new());
    let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
    let mut before = [f64::INFINITY; 2];
    for step in 0..MOST_STEPS.min(size - rigid.len()) {
        // Orthogonalise, twice, against rigid motions and the basis.
        for _ in 0..2 {
            let known = rigid.iter().zip(&heavy_rigid).chain(basis.iter().zip(&heavy_basis));
            for (vector, heavy) in known {
                let share = dot(heavy, &next);
                next.iter_mut().zip(vector).for_each(|(x, v)| *x -= share * v);
            }
        }
        // Normalise in the mass.
        system.multiply_mass(&next, 1, &mut heavy);
        let norm = dot(&next, &heavy).sqrt();
        if norm.is_nan() || norm == 0.0 {
            break;
        }
        next.iter_mut().chain(&mut heavy).for_each(|x| *x /= norm);
        if step > 0 {
            beside.push(norm);
        }
        // Apply the operator: one forward and back substitution.
        let mut image = Mat::from_fn(size, 1, |i, _| heavy[i]);
        factor.solve(image.as_mut());
        let image: Vec<f64> = image.col(0).iter().copied().collect();
        diagonal.push(dot(&heavy, &image));
        basis.push(std::mem::replace(&mut next, image));
        heavy_basis.push(heavy.clone());
        // Largest Ritz value; stop once it is stationary.
        let square = 1.0 / largest(&diagonal, &beside) - shift;
        if (before[0] - square).abs() <= STILL * square {
            return Ok(frequency(square));
        }
        before = [before[1], square];
    }
    match before[1] > 0.0 && before[1].is_finite() {
        true => Ok(frequency(before[1])),
        false => Err(ModalError::LooseParts),
    }
}

/// s [1/s²].
fn shift(system: &ElasticSystem, constants: &ElasticConstants) -> f64 {
    let start = (glam::DVec3::INFINITY, glam::DVec3::NEG_INFINITY);
    let (low, high) = system.nodes().iter().fold(start, |(low, high), x| (low.min(*x), high.max(*x)));
    let length = (high - low).max_element();
    let ones = system.unknowns_of(&vec![glam::DVec3::X; system.node_count()]);
    let mut along = ones.clone();
    system.multiply_mass(&ones, 1, &mut along);
    let volume = dot(&ones, &along) / constants.density;
    let shear = constants.shear_modulus / constants.density;
    0.25 * shear * (volume / length.powi(3) / length).powi(2)
}

/// The largest eigenvalue of a symmetric matrix of these diagonals.
fn largest(diagonal: &[f64], beside: &[f64]) -> f64 {
    let size = diagonal.len();
    let matrix = Mat::from_fn(size, size, |i, j| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => beside[i.min(j)],
        _ => 0.0,
    });
    let vectors = lanczos::eigenvectors(matrix.as_ref());
    let images = &matrix * &vectors;
    (0..size).map(|k| vectors.col(k).transpose() * images.col(k)).fold(0.0, f64::max)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
