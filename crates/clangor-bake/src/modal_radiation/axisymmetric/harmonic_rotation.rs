//! Rotation of real spherical harmonics.
//!
//! ```text
//! Y_nm(Qᵀx) = Σ_m' R^n_mm' Y_nm'(x)
//! ```
//!
//! R^1 is Qᵀ itself in the order y, z, x; each R^n comes from R^1 and R^{n−1}. Source: Ivanic and Ruedenberg,
//! J. Phys. Chem. 100 (1996) 6342, with the corrections in A 102 (1998) 9099.

use clangor_core::math::spherical_harmonics::{count, index};
use glam::DMat3;
use num_complex::Complex64;

/// The matrices R^n.
#[derive(Clone, Debug)]
pub(super) struct HarmonicRotation {
    /// R^n, rows of m from −n, one after the other.
    degrees: Vec<Vec<f64>>,
}

impl HarmonicRotation {
    /// For axes that are the columns of `turn`, up to an order.
    pub(super) fn new(turn: DMat3, order: usize) -> Self {
        // y, z, x.
        const PLACES: [usize; 3] = [1, 2, 0];
        let first: Vec<f64> =
            PLACES.iter().flat_map(|i| PLACES.map(|j| turn.col(*i).to_array()[j])).collect();
        let mut degrees = vec![vec![1.0], first];
        for n in 2..=order {
            let next = step(n as isize, &degrees[1], &degrees[n - 1]);
            degrees.push(next);
        }
        HarmonicRotation { degrees }
    }

    /// Coefficients about z from coefficients about the third axis.
    pub(super) fn turn(&self, coefficients: &[Complex64]) -> Vec<Complex64> {
        let mut out = Vec::with_capacity(coefficients.len());
        for (n, matrix) in self.degrees.iter().enumerate() {
            let width = 2 * n + 1;
            let own = n * n..(n + 1) * (n + 1);
            if own.end > coefficients.len() {
                break;
            }
            let here = &coefficients[own];
            out.extend((0..width).map(|column| {
                here.iter()
                    .enumerate()
                    .filter(|(_, c)| **c != Complex64::ZERO)
                    .map(|(row, c)| c * matrix[row * width + column])
                    .sum::<Complex64>()
            }));
        }
        out
    }
}

/// R^n from R^1 and R^{n−1}.
fn step(n: isize, first: &[f64], below: &[f64]) -> Vec<f64> {
    let one = |i: isize, j: isize| first[((i + 1) * 3 + j + 1) as usize];
    let before = |i: isize, j: isize| below[((i + n - 1) * (2 * n - 1) + j + n - 1) as usize];
    // Terms P of the recurrence.
    let product = |i: isize, row: isize, column: isize| {
        if column == n {
            one(i, 1) * before(row, n - 1) - one(i, -1) * before(row, 1 - n)
        } else if column == -n {
            one(i, 1) * before(row, 1 - n) + one(i, -1) * before(row, n - 1)
        } else {
            one(i, 0) * before(row, column)
        }
    };
    let root_two = std::f64::consts::SQRT_2;
    let mut out = Vec::with_capacity(count(n as usize) - count(n as usize - 1));
    for row in -n..=n {
        let size = row.abs();
        // Coefficients u, v, w of the recurrence.
        for column in -n..=n {
            let divisor = if column.abs() == n { 2 * n * (2 * n - 1) } else { (n + column) * (n - column) };
            let part = |square: isize| (square as f64 / divisor as f64).sqrt();
            let mut sum = 0.0;
            if size < n {
                sum += part((n + row) * (n - row)) * product(0, row, column);
            }
            let (v, w) = (part((n + size - 1) * (n + size)), part((n - size - 1) * (n - size)));
            sum += match row {
                0 => -0.5 * root_two * v * (product(1, 1, column) + product(-1, -1, column)),
                1 => 0.5 * root_two * v * product(1, 0, column),
                -1 => 0.5 * root_two * v * product(-1, 0, column),
                _ if row > 0 => 0.5 * v * (product(1, row - 1, column) - product(-1, 1 - row, column)),
                _ => 0.5 * v * (product(1, row + 1, column) + product(-1, -row - 1, column)),
            };
            // w is zero where row ± 1 does not exist.
            if row != 0 && size < n - 1 {
                sum -= 0.5
                    * w
                    * if row > 0 {
                        product(1, row + 1, column) + product(-1, -row - 1, column)
                    } else {
                        product(1, row - 1, column) - product(-1, 1 - row, column)
                    };
            }
            out.push(sum);
        }
    }
    out
}

/// The coefficient of a vector of Σ (order + 1)² numbers.
pub(super) fn place(n: usize, m: usize, is_sine: bool) -> usize {
    index(n, if is_sine { -(m as isize) } else { m as isize })
}

#[cfg(test)]
mod tests {
    use clangor_core::math::spherical_harmonics::solid_harmonics;
    use glam::{DQuat, DVec3};

    use super::*;

    #[test]
    fn a_turned_field_is_the_field_seen_from_turned_axes() {
        let order = 70;
        let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(0.36, 0.48, -0.8), 1.234));
        let rotation = HarmonicRotation::new(turn, order);
        let coefficients: Vec<Complex64> =
            (0..count(order)).map(|i| Complex64::new((i as f64).sin(), (1.3 * i as f64).cos())).collect();
        let rotated = rotation.turn(&coefficients);
        let (mut own, mut body) = (Vec::new(), Vec::new());
        for x in [DVec3::X, DVec3::new(0.6, 0.0, -0.8), DVec3::new(-0.48, 0.64, 0.6)] {
            solid_harmonics(turn.transpose() * x, order, &mut own);
            solid_harmonics(x, order, &mut body);
            for n in 0..=order {
                let of = |c: &[Complex64], y: &[f64]| -> Complex64 {
                    (n * n..(n + 1) * (n + 1)).map(|i| c[i] * y[i]).sum()
                };
                let (expected, found) = (of(&coefficients, &own), of(&rotated, &body));
                // Residual seen: 4e-14.
                let error = (expected - found).norm() / (n + 1) as f64;
                assert!(error < 1e-11, "{n}: {expected} {found}");
            }
        }
        assert_eq!(place(3, 2, true), 10);
    }
}
