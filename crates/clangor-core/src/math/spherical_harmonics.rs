//! Real spherical harmonics and regular solid harmonics.
//!
//! Y_nm is orthonormal on the unit sphere, ∫ Y_nm Y_n'm' dΩ = δδ, about the polar axis z:
//!
//! ```text
//! Y_n0 = N_n0 P_n(cos θ)
//! Y_nm = √2 N_nm P_n^m(cos θ) cos mφ,   Y_n,−m = √2 N_nm P_n^m(cos θ) sin mφ,   m > 0
//! N_nm = √((2n+1)/4π · (n−m)!/(n+m)!)
//! ```
//!
//! without the Condon–Shortley phase, so that Y_1,1 ∝ x, Y_1,−1 ∝ y, Y_1,0 ∝ z with positive factors.
//! Harmonic (n, m) has the index n² + n + m. The solid harmonic rⁿ Y_nm is a polynomial, smooth at the
//! origin; it is computed by recurrences in x, y, z that divide by nothing.

use glam::DVec3;

/// Number of harmonics up to and including `order`: (order + 1)².
pub const fn count(order: usize) -> usize {
    (order + 1) * (order + 1)
}

/// Place of harmonic (n, m) in every array of harmonics.
pub const fn index(n: usize, m: isize) -> usize {
    (n * n + n).wrapping_add_signed(m)
}

/// rⁿ Y_nm(x/r) for all n up to `order`, at any point x, the origin included; Y_nm itself for a unit vector.
///
/// `values` gets [`count`]`(order)` numbers.
pub fn solid_harmonics(x: DVec3, order: usize, values: &mut Vec<f64>) {
    values.clear();
    values.resize(count(order), 0.0);
    let square = x.length_squared();
    // sectoral: (x + iy)^m times a normalisation; then upwards in n with the three-term recurrence of the
    // fully normalised Legendre functions, each power of r carried along.
    let mut cos = 1.0;
    let mut sin = 0.0;
    let mut sectoral = (0.25 / std::f64::consts::PI).sqrt();
    for m in 0..=order {
        if m > 0 {
            (cos, sin) = (x.x * cos - x.y * sin, x.x * sin + x.y * cos);
            let m = m as f64;
            sectoral *= ((2.0 * m + 1.0) / (2.0 * m)).sqrt();
        }
        let scale = if m == 0 { 1.0 } else { std::f64::consts::SQRT_2 };
        let (mut before, mut here) = (0.0, sectoral);
        for n in m..=order {
            values[index(n, m as isize)] = scale * here * cos;
            if m > 0 {
                values[index(n, -(m as isize))] = scale * here * sin;
            }
            let (a, b) = recurrence(n + 1, m);
            (before, here) = (here, a * (x.z * here) - b * square * before);
        }
    }
}

/// The coefficients of the recurrences up to an order, so that evaluating takes no roots or divisions.
#[derive(Clone, Debug, PartialEq)]
pub struct HarmonicTable {
    order: usize,
    /// Y_mm over the (x + iy)^m part, √2 included.
    sectoral: Vec<f64>,
    /// a and b for n = m + 1 … order, for each m.
    steps: Vec<(f64, f64)>,
}

impl HarmonicTable {
    /// The coefficients up to `order`.
    pub fn new(order: usize) -> Self {
        let mut size = (0.25 / std::f64::consts::PI).sqrt();
        let mut sectoral = vec![size];
        for m in 1..=order {
            size *= ((2 * m + 1) as f64 / (2 * m) as f64).sqrt();
            sectoral.push(std::f64::consts::SQRT_2 * size);
        }
        let steps = (0..=order).flat_map(|m| (m + 1..=order).map(move |n| recurrence(n, m))).collect();
        HarmonicTable { order, sectoral, steps }
    }

    /// Y_nm at a unit vector: what [`solid_harmonics`] gives there.
    #[inline]
    pub fn evaluate(&self, direction: DVec3, values: &mut Vec<f64>) {
        values.clear();
        values.resize(count(self.order), 0.0);
        let DVec3 { x, y, z } = direction;
        let (mut cos, mut sin) = (1.0, 0.0);
        let mut steps = self.steps.as_slice();
        for (m, sectoral) in self.sectoral.iter().enumerate() {
            if m > 0 {
                (cos, sin) = (x * cos - y * sin, x * sin + y * cos);
            }
            let (mut before, mut here) = (0.0, *sectoral);
            let mut at = index(m, m as isize);
            values[at] = here * cos;
            values[at - 2 * m] = if m > 0 { here * sin } else { here };
            let (own, rest) = steps.split_at(self.order - m);
            steps = rest;
            for (n, (a, b)) in (m + 1..).zip(own) {
                (before, here) = (here, a * (z * here) - b * before);
                at += 2 * n;
                values[at] = here * cos;
                values[at - 2 * m] = if m > 0 { here * sin } else { here };
            }
        }
    }
}

/// rⁿ Y_nm and its gradient for all n up to `order`, at any point.
///
/// From ∂(rⁿY) by differentiating the recurrences.
pub fn solid_harmonics_with_gradient(
    x: DVec3,
    order: usize,
    values: &mut Vec<f64>,
    gradients: &mut Vec<DVec3>,
) {
    solid_harmonics(x, order, values);
    gradients.clear();
    gradients.resize(count(order), DVec3::ZERO);
    let square = x.length_squared();
    // (x + iy)^m and its derivative m (x + iy)^(m−1) (dx + i dy).
    let (mut cos, mut sin) = (1.0, 0.0);
    let (mut cos_slope, mut sin_slope) = (DVec3::ZERO, DVec3::ZERO);
    let mut sectoral = (0.25 / std::f64::consts::PI).sqrt();
    for m in 0..=order {
        if m > 0 {
            let k = m as f64;
            cos_slope = DVec3::new(k * cos, -k * sin, 0.0);
            sin_slope = DVec3::new(k * sin, k * cos, 0.0);
            (cos, sin) = (x.x * cos - x.y * sin, x.x * sin + x.y * cos);
            sectoral *= ((2.0 * k + 1.0) / (2.0 * k)).sqrt();
        }
        let scale = if m == 0 { 1.0 } else { std::f64::consts::SQRT_2 };
        let (mut before, mut here) = (0.0, sectoral);
        let (mut before_slope, mut here_slope) = (DVec3::ZERO, DVec3::ZERO);
        for n in m..=order {
            gradients[index(n, m as isize)] = scale * (here_slope * cos + here * cos_slope);
            if m > 0 {
                gradients[index(n, -(m as isize))] = scale * (here_slope * sin + here * sin_slope);
            }
            let (a, b) = recurrence(n + 1, m);
            let next_slope =
                a * (DVec3::Z * here + x.z * here_slope) - b * (2.0 * x * before + square * before_slope);
            (before, here) = (here, a * (x.z * here) - b * square * before);
            (before_slope, here_slope) = (here_slope, next_slope);
        }
    }
}

/// a and b of `P̄_n = a z P̄_{n−1} − b r² P̄_{n−2}` for fully normalised Legendre functions of degree m.
fn recurrence(n: usize, m: usize) -> (f64, f64) {
    let (n, m) = (n as f64, m as f64);
    let below = (n * n - m * m).max(1.0);
    let a = ((4.0 * n * n - 1.0) / below).sqrt();
    let b = if n >= m + 2.0 {
        ((2.0 * n + 1.0) * ((n - 1.0).powi(2) - m * m) / ((2.0 * n - 3.0) * below)).sqrt()
    } else {
        0.0
    };
    (a, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_orders_are_the_known_polynomials() {
        let x = DVec3::new(0.3, -0.5, 0.7);
        let mut y = Vec::new();
        solid_harmonics(x, 2, &mut y);
        let pi = std::f64::consts::PI;
        let one = (0.75 / pi).sqrt();
        let two = (15.0 / (4.0 * pi)).sqrt();
        let expected = [
            (0.25 / pi).sqrt(),
            one * x.y,
            one * x.z,
            one * x.x,
            two * x.x * x.y,
            two * x.y * x.z,
            (5.0 / (16.0 * pi)).sqrt() * (3.0 * x.z * x.z - x.length_squared()),
            two * x.x * x.z,
            0.5 * two * (x.x * x.x - x.y * x.y),
        ];
        // Residual seen: 1.1e-16.
        y.iter().zip(expected).for_each(|(a, b)| assert!((a - b).abs() < 1e-14, "{a} {b}"));
    }

    #[test]
    fn the_table_gives_the_same_harmonics() {
        let (mut y, mut quick) = (Vec::new(), Vec::new());
        for x in [DVec3::Z, DVec3::new(0.48, -0.6, 0.64), -DVec3::X] {
            for order in [0, 1, 2, 30] {
                solid_harmonics(x, order, &mut y);
                HarmonicTable::new(order).evaluate(x, &mut quick);
                assert_eq!(y.len(), quick.len());
                // Residual seen: 2e-14 at order 30.
                y.iter().zip(&quick).for_each(|(a, b)| assert!((a - b).abs() < 1e-12, "{a} {b}"));
            }
        }
    }

    #[test]
    fn gradients_are_differences_and_euler_holds() {
        let x = DVec3::new(-0.4, 0.8, 0.35);
        let (mut y, mut slope, mut plus, mut minus) = (vec![], vec![], vec![], vec![]);
        solid_harmonics_with_gradient(x, 12, &mut y, &mut slope);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            solid_harmonics(x + 1e-5 * axis, 12, &mut plus);
            solid_harmonics(x - 1e-5 * axis, 12, &mut minus);
            for i in 0..y.len() {
                // Residual seen: 2e-9, of the differences.
                assert!((slope[i].dot(axis) - (plus[i] - minus[i]) / 2e-5).abs() < 1e-7);
            }
        }
        for n in 0..=12 {
            for m in -(n as isize)..=n as isize {
                let i = index(n, m);
                // Euler: x·∇(rⁿY) = n rⁿY. Residual seen: 4e-15.
                assert!((x.dot(slope[i]) - n as f64 * y[i]).abs() < 1e-12);
            }
        }
    }
}
