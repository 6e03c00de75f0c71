//! Division of a shape into patches.
//!
//! Patches are as large as the wavelength and the shape allow. A side has nodes for the wavelength at the
//! highest wavenumber and a least number for the shape, and is halved above [`MOST_NODES`]. Where the
//! curvature of the surface jumps, as between a face and a rounded edge, patches shrink towards the joint.
//! Towards a sharp edge, where the pressure behaves as d^{2/3}, they shrink geometrically.

use std::f64::consts::TAU;

use glam::DVec3;

use super::chart::{Chart, Patch};

/// Most nodes along a side of a patch.
const MOST_NODES: usize = 10;

/// Resolution of the patches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Resolution {
    /// Nodes per wavelength.
    pub(super) per_wavelength: f64,
    /// Highest wavenumber [1/m].
    pub(super) wavenumber: f64,
    /// Least number of nodes along a side of a patch.
    pub(super) least: usize,
}

/// An ellipsoid about the origin.
pub(super) fn ellipsoid(semi_axes: DVec3, resolution: &Resolution) -> Vec<Patch> {
    let charts = (0..3).map(|face| Chart::Ellipsoid { centre: DVec3::ZERO, semi_axes, face });
    charts.flat_map(|chart| cut(chart, &[0.0, 1.0], &[0.0, 1.0], resolution)).collect()
}

/// A box with full `edges` about the origin, its edges and corners rounded by a ball of radius `round`.
pub(super) fn rounded_box(edges: DVec3, round: f64, resolution: &Resolution) -> Vec<Patch> {
    let core = (0.5 * edges - round).max(DVec3::ZERO);
    let unit = [DVec3::X, DVec3::Y, DVec3::Z];
    let breaks = core.to_array().map(|length| {
        if round > 0.0 { towards_a_bend(length, round) } else { towards_an_edge(resolution.least) }
    });
    let mut patches = Vec::new();
    // For each axis: the flat face, the rounded edge and a third of the corner.
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        if core[j] > 0.0 && core[k] > 0.0 {
            let flat = Chart::Flat {
                corner: unit[i] * (core[i] + round),
                first: core[j] * unit[j],
                second: core[k] * unit[k],
            };
            patches.extend(cut(flat, &breaks[j], &breaks[k], resolution));
        }
        if round > 0.0 && core[i] > 0.0 {
            // u turns from j to k, v runs along i: outwards as j × k = i.
            let bend = Chart::Bend {
                start: core - core[i] * unit[i],
                along: core[i] * unit[i],
                radius: round,
                from: unit[j],
                to: unit[k],
            };
            patches.extend(cut(bend, &[0.0, 1.0], &breaks[i], resolution));
        }
        if round > 0.0 {
            let corner = Chart::Ellipsoid { centre: core, semi_axes: DVec3::splat(round), face: i };
            patches.extend(cut(corner, &[0.0, 1.0], &[0.0, 1.0], resolution));
        }
    }
    patches
}

/// Parts of a length from the middle of a face, 0, to the joint with a rounding, 1. The last is as long as
/// the rounding is wide, and each is four times its neighbour.
fn towards_a_bend(length: f64, round: f64) -> Vec<f64> {
    let mut breaks = vec![1.0];
    let (mut left, mut part) = (1.0, 1.5 * round / length);
    while left > 1.8 * part {
        left -= part;
        breaks.push(left);
        part *= 4.0;
    }
    breaks.push(0.0);
    breaks.reverse();
    breaks
}

/// Parts of a length from the middle of a face, 0, to a sharp edge, 1. With the part at the edge a fraction
/// q^L of the length, the error of its polynomials is of the order q^{4L/3} of the pressure: one layer for
/// each node.
fn towards_an_edge(least: usize) -> Vec<f64> {
    let levels = least as i32;
    let mut breaks: Vec<f64> =
        std::iter::once(0.0).chain((1..=levels).map(|l| 1.0 - 0.2_f64.powi(l))).collect();
    breaks.push(1.0);
    breaks
}

/// Cuts a chart at these values of u and v, and further where the wave needs it.
fn cut(chart: Chart, at_u: &[f64], at_v: &[f64], resolution: &Resolution) -> Vec<Patch> {
    let mut patches = Vec::new();
    for v in at_v.windows(2) {
        for u in at_u.windows(2) {
            patches.extend(fitted(
                &Patch { chart, u: [u[0], u[1]], v: [v[0], v[1]], nodes: [0, 0] },
                resolution,
            ));
        }
    }
    patches
}

/// The patch with its nodes, or its halves if it needs too many.
fn fitted(patch: &Patch, resolution: &Resolution) -> Vec<Patch> {
    // The longest of three lines across the patch in each direction.
    let across = |fixed: [f64; 2], moving: [f64; 2], along_u: bool| {
        let line = |t: f64| {
            let fixed = fixed[0] + t * (fixed[1] - fixed[0]);
            let at = |s: f64| {
                let moving = moving[0] + s * (moving[1] - moving[0]);
                if along_u {
                    patch.chart.position(moving, fixed)
                } else {
                    patch.chart.position(fixed, moving)
                }
            };
            (0..4).map(|k| at(0.25 * k as f64).distance(at(0.25 * (k + 1) as f64))).sum::<f64>()
        };
        [0.0, 0.5, 1.0].map(line).into_iter().fold(0.0, f64::max)
    };
    // Nodes along each direction, for the wavelength.
    let nodes = |length: f64| {
        let wave = resolution.per_wavelength * resolution.wavenumber * length / TAU;
        resolution.least.max(wave.ceil() as usize)
    };
    let along_u = nodes(across(patch.v, patch.u, true));
    let along_v = nodes(across(patch.u, patch.v, false));
    // Halve the direction with too many nodes, the longer first.
    let half = |range: [f64; 2]| {
        let middle = 0.5 * (range[0] + range[1]);
        [[range[0], middle], [middle, range[1]]]
    };
    if along_u > MOST_NODES && along_u >= along_v {
        half(patch.u).iter().flat_map(|&u| fitted(&Patch { u, ..*patch }, resolution)).collect()
    } else if along_v > MOST_NODES {
        half(patch.v).iter().flat_map(|&v| fitted(&Patch { v, ..*patch }, resolution)).collect()
    } else {
        vec![Patch { nodes: [along_u, along_v], ..*patch }]
    }
}
