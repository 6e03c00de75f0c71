//! Sampling of ellipsoid proportions: denser where frequencies vary fast, towards discs and needles.
//!
//! The patch of the unit sphere with t c ≤ a ≤ b ≤ c is one triangle: disc (t, 1, 1), needle (t, t, 1) and
//! ball (1, 1, 1). An edge between two samples is halved, with the triangles on both sides, while any of the
//! lowest log frequencies differs by more than the spacing. \[FRAC\] §5.3 uses the lowest frequency alone,
//! which hardly varies along the edge from disc to needle.

use std::collections::BTreeMap;

use glam::DVec3;

use super::{ModalSoundbankBakeError, ModalSoundbankOptions};
use crate::soundbank::modal::ellipsoid_modes::BallPolynomials;

/// Number of frequencies compared between neighbours.
const COMPARED: usize = 4;
/// Largest number of samples.
const MOST_SAMPLES: usize = 400;

/// The normalised semi-axes of the ellipsoids, from the thinnest to the thickest.
///
/// # Errors
/// [`ModalSoundbankBakeError::Options`] for an invalid spacing or thickness.
pub fn samples(
    polynomials: &BallPolynomials,
    options: &ModalSoundbankOptions,
) -> Result<Vec<DVec3>, ModalSoundbankBakeError> {
    let (t, spacing) = (options.thinnest, options.spacing);
    if !(1e-3..0.9).contains(&t) {
        return Err(ModalSoundbankBakeError::Options { what: "the least a/c", value: t });
    }
    if !(0.05..10.0).contains(&spacing) {
        return Err(ModalSoundbankBakeError::Options { what: "the spacing of the bank", value: spacing });
    }
    let nu = options.material.poisson_ratio;
    // Logarithms of the lowest frequencies of a sample.
    let lowest = |axes: DVec3| -> Vec<f64> {
        let all = polynomials.modes(axes, nu, f64::INFINITY);
        all.iter().take(COMPARED).map(|mode| mode.angular_frequency.ln()).collect()
    };
    // Initial triangle: disc, needle, ball.
    let mut points: Vec<DVec3> =
        [DVec3::new(t, 1.0, 1.0), DVec3::new(t, t, 1.0), DVec3::ONE].map(DVec3::normalize).to_vec();
    let mut frequencies: Vec<Vec<f64>> = points.iter().map(|p| lowest(*p)).collect();
    let mut triangles = vec![[0, 1, 2]];
    loop {
        // Edge with the largest difference of log frequencies.
        let difference = |a: usize, b: usize| {
            let pairs = frequencies[a].iter().zip(&frequencies[b]);
            pairs.map(|(p, q)| (p - q).abs()).fold(0.0, f64::max)
        };
        let mut edges: BTreeMap<(usize, usize), f64> = BTreeMap::new();
        for [a, b, c] in &triangles {
            for (p, q) in [(*a, *b), (*b, *c), (*c, *a)] {
                edges.entry((p.min(q), p.max(q))).or_insert_with(|| difference(p, q));
            }
        }
        let widest = edges.iter().max_by(|p, q| p.1.total_cmp(q.1).then(q.0.cmp(p.0)));
        let Some(((a, b), _)) = widest.filter(|(_, d)| **d > spacing) else { break };
        if points.len() == MOST_SAMPLES {
            return Err(ModalSoundbankBakeError::Options { what: "the spacing of the bank", value: spacing });
        }
        // Halve it, and the triangles on both sides.
        let (a, b, middle) = (*a, *b, points.len());
        points.push((points[a] + points[b]).normalize());
        frequencies.push(lowest(points[middle]));
        let mut halves = Vec::new();
        for triangle in &triangles {
            if !(triangle.contains(&a) && triangle.contains(&b)) {
                halves.push(*triangle);
                continue;
            }
            for old in [a, b] {
                halves.push(triangle.map(|corner| if corner == old { middle } else { corner }));
            }
        }
        triangles = halves;
    }
    points.sort_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));
    Ok(points)
}
