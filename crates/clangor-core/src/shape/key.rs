//! A key: a round bow with a hole to hang it by, and a blade with cuts along one side. It lies in the plane
//! of x and z, the hole about y at the origin, the blade towards +x.
//!
//! 53 mm long, 1.8 mm thick; its volume, 0.97 cm³, is what the pulse time scale in \[PAN\] Table 1 implies.

use std::f64::consts::TAU;

use glam::DVec2;

use super::planar::{place, slab, thicken};
use crate::geometry::convex::ConvexPart;
use crate::geometry::tri_mesh::TriMesh;

const THICKNESS: f64 = 0.0018;
const BOW: f64 = 0.011;
const HOLE: f64 = 0.004;
const BLADE_HALF_WIDTH: f64 = 0.00375;

/// The blade beyond the bow: x, lower edge, upper edge \[mm\].
const BLADE: [[f64; 3]; 12] = [
    [13.0, -3.75, 3.75],
    [15.0, -2.4, 3.75],
    [17.5, -3.75, 3.75],
    [20.0, -1.6, 3.75],
    [23.0, -3.4, 3.75],
    [25.5, -2.0, 3.75],
    [28.0, -3.75, 3.75],
    [30.5, -1.8, 3.75],
    [33.0, -3.2, 3.75],
    [36.0, -2.2, 3.75],
    [39.0, -3.2, 3.75],
    [42.0, -1.5, 1.5],
];

/// Where the blade is cut into convex parts: the valleys.
const CUTS: [f64; 5] = [15.0, 20.0, 25.5, 30.5, 36.0];

pub(super) fn key_mesh(edge: f64) -> TriMesh {
    thicken(&outline_mesh(edge), THICKNESS, edge)
}

/// Rings around the hole, and columns along the blade that begin at the points of the outermost ring.
fn outline_mesh(edge: f64) -> TriMesh {
    let rows = (2.0 * BLADE_HALF_WIDTH / edge).ceil().max(2.0) as usize;
    let root = (BLADE_HALF_WIDTH / BOW).asin();
    // Angles: first the root of the blade, in equal steps across it, then the rest of the circle.
    let across = |j: usize| -1.0 + 2.0 * j as f64 / rows as f64;
    let mut angles: Vec<f64> = (0..=rows).map(|j| (across(j) * BLADE_HALF_WIDTH / BOW).asin()).collect();
    let rest = ((TAU - 2.0 * root) * BOW / edge).ceil().max(16.0) as usize;
    angles.extend((1..rest).map(|k| root + (TAU - 2.0 * root) * k as f64 / rest as f64));
    let rings = ((BOW - HOLE) / edge).ceil().max(1.0) as usize;
    let mut mesh = TriMesh::default();
    let count = angles.len() as u32;
    // The outermost ring comes first: its first rows + 1 points are the root of the blade.
    for ring in (0..=rings).rev() {
        let radius = HOLE + (BOW - HOLE) * ring as f64 / rings as f64;
        mesh.vertices.extend(angles.iter().map(|a| place(DVec2::from_angle(*a) * radius, 0.0)));
    }
    for ring in 0..rings as u32 {
        for k in 0..count {
            let (a, b) = (ring * count + k, ring * count + (k + 1) % count);
            mesh.triangles.extend([[a, b, b + count], [a, b + count, a + count]]);
        }
    }
    let mut previous = 0;
    let mut x = BOW * 1e3;
    for (k, station) in BLADE.iter().enumerate() {
        let columns = ((station[0] - x) * 1e-3 / edge).ceil().max(1.0) as usize;
        let before = if k == 0 { [x, -BLADE_HALF_WIDTH * 1e3, BLADE_HALF_WIDTH * 1e3] } else { BLADE[k - 1] };
        for column in 1..=columns {
            let s = column as f64 / columns as f64;
            let [x, low, high] = [0, 1, 2].map(|i| before[i] + (station[i] - before[i]) * s);
            let start = mesh.vertices.len() as u32;
            mesh.vertices.extend(
                (0..=rows)
                    .map(|j| place(DVec2::new(x, low + (high - low) * j as f64 / rows as f64) * 1e-3, 0.0)),
            );
            for j in 0..rows as u32 {
                let (a, b, c, d) = (previous + j, start + j, start + j + 1, previous + j + 1);
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
            previous = start;
        }
        x = station[0];
    }
    mesh
}

/// Ten wedges around the hole and six pieces of the blade.
pub(super) fn key_parts() -> Vec<ConvexPart> {
    const SECTORS: usize = 10;
    let step = TAU / SECTORS as f64;
    let hole = HOLE * crate::shape::axisymmetric::balance(0.5 * step);
    let mut parts: Vec<ConvexPart> = (0..SECTORS)
        .map(|k| {
            let at = |s: f64, radius: f64| DVec2::from_angle((k as f64 + s) * step) * radius;
            let mut outline: Vec<DVec2> = [0.0, 0.25, 0.5, 0.75, 1.0].map(|s| at(s, BOW)).to_vec();
            outline.extend([at(0.0, hole), at(1.0, hole)]);
            slab(&outline, THICKNESS)
        })
        .collect();
    let root = (BOW * BOW - BLADE_HALF_WIDTH * BLADE_HALF_WIDTH).sqrt() * 1e3;
    let mut from = root;
    for to in CUTS.into_iter().chain([f64::INFINITY]) {
        let mut outline: Vec<DVec2> = BLADE
            .iter()
            .filter(|[x, ..]| (from..=to).contains(x))
            .flat_map(|[x, low, high]| [DVec2::new(*x, *low) * 1e-3, DVec2::new(*x, *high) * 1e-3])
            .collect();
        if from == root {
            outline.extend([-1.0, 1.0].map(|s| DVec2::new(root * 1e-3, s * BLADE_HALF_WIDTH)));
        }
        parts.push(slab(&outline, THICKNESS));
        from = to;
    }
    parts
}
