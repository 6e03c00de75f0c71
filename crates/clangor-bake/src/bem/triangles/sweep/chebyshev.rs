//! Interpolation at the Chebyshev points of an interval.

use std::f64::consts::PI;

/// Most points.
const MOST: usize = 80;

/// Points that interpolate e^{iθx} on [−1, 1] to an error: of n points 2 (θ/2)ⁿ/n!.
pub(super) fn count(phase: f64, error: f64) -> usize {
    let mut bound = 2.0;
    (1..MOST)
        .find(|n| {
            bound *= 0.5 * phase / *n as f64;
            bound <= error
        })
        .unwrap_or(MOST)
        .max(2)
}

/// The points.
pub(super) fn nodes([low, high]: [f64; 2], count: usize) -> Vec<f64> {
    let at = |q: usize| (PI * (q as f64 + 0.5) / count as f64).cos();
    (0..count).map(|q| 0.5 * (low + high) - 0.5 * (high - low) * at(q)).collect()
}

/// Weight of each of the points in the value at `x`.
pub(super) fn weights(nodes: &[f64], x: f64) -> Vec<f64> {
    if let Some(hit) = nodes.iter().position(|node| *node == x) {
        return (0..nodes.len()).map(|q| if q == hit { 1.0 } else { 0.0 }).collect();
    }
    let count = nodes.len() as f64;
    let parts: Vec<f64> = nodes
        .iter()
        .enumerate()
        .map(|(q, node)| {
            let sign = if q % 2 == 0 { 1.0 } else { -1.0 };
            sign * (PI * (q as f64 + 0.5) / count).sin() / (x - node)
        })
        .collect();
    let total: f64 = parts.iter().sum();
    parts.into_iter().map(|part| part / total).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wave_is_interpolated_to_its_bound() {
        for (phase, error) in [(0.7, 1e-4), (3.0, 1e-4), (13.0, 1e-4)] {
            let nodes = nodes([1.0, 5.0], count(phase, error));
            let wave = |x: f64| (0.5 * phase * (x - 3.0)).cos();
            let worst = (0..100)
                .map(|i| 1.0 + 0.04 * f64::from(i))
                .map(|x| {
                    let value: f64 = weights(&nodes, x).iter().zip(&nodes).map(|(w, k)| w * wave(*k)).sum();
                    (value - wave(x)).abs()
                })
                .fold(0.0, f64::max);
            assert!(worst < 1.2 * error, "{phase}: {worst}");
        }
    }
}
