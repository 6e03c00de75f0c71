//! Normal numbers and rotations at random, reproducible from a seed.

use std::f64::consts::TAU;

use clangor_core::math::random::SplitMix;

/// Two independent numbers of the normal distribution of variance 1 (Box and Muller).
pub(super) fn normal_pair(random: &mut SplitMix) -> [f64; 2] {
    let radius = (-2.0 * (1.0 - random.uniform(0.0, 1.0)).ln()).sqrt();
    let (sine, cosine) = random.uniform(0.0, TAU).sin_cos();
    [radius * cosine, radius * sine]
}

/// A rotation or reflection of `count` dimensions, even over all: rows of orthonormal numbers.
pub(super) fn orthogonal(count: usize, random: &mut SplitMix) -> Vec<Vec<f64>> {
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(count);
    while rows.len() < count {
        let mut row: Vec<f64> =
            (0..count.div_ceil(2)).flat_map(|_| normal_pair(random)).take(count).collect();
        // Twice, against rounding.
        for _ in 0..2 {
            for other in &rows {
                let along: f64 = row.iter().zip(other).map(|(a, b)| a * b).sum();
                row.iter_mut().zip(other).for_each(|(a, b)| *a -= along * b);
            }
        }
        let length = row.iter().map(|a| a * a).sum::<f64>().sqrt();
        if length > 1e-9 {
            row.iter_mut().for_each(|a| *a /= length);
            rows.push(row);
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_orthonormal() {
        for count in [1, 2, 7, 64] {
            let rows = orthogonal(count, &mut SplitMix::new(3));
            for (i, a) in rows.iter().enumerate() {
                for (j, b) in rows.iter().enumerate() {
                    let product: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                    let expected = if i == j { 1.0 } else { 0.0 };
                    // Residual seen: 7e-16.
                    assert!((product - expected).abs() < 1e-13, "{count}: {i} {j} {product}");
                }
            }
        }
    }
}
