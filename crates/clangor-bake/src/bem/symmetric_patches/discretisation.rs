//! Patches, their nodes, and the quadrature rules for an accuracy.

use glam::{DVec2, DVec3};

use super::chart::{Extent, Patch};
use super::kernel::Sources;
use super::lagrange::Nodes;
use crate::fitting::multipole_projection::SurfacePoint;

/// Longest Gauss rule.
const MOST_POINTS: usize = 24;

/// Quadrature rules.
#[derive(Clone, Debug)]
pub(super) struct Rules {
    /// Distance over radius above which a patch is integrated at its own nodes.
    pub(super) far: f64,
    /// Distance over radius above which a part of a patch is not divided further.
    pub(super) near: f64,
    /// Least points along a side of a part.
    least: usize,
    gauss: Vec<Nodes>,
}

impl Rules {
    /// Rules for errors of the order of `accuracy`.
    ///
    /// Gauss's n-point rule on a square loses (d + √(d² + 1))^{−2n} for a singularity at d half sides, d ≥ √2
    /// `near`.
    pub(super) fn new(accuracy: f64) -> Self {
        let (far, near, least) = match accuracy {
            a if a < 1e-5 => (4.0, 1.5, 8),
            a if a < 5e-4 => (3.0, 1.3, 6),
            _ => (2.5, 1.2, 5),
        };
        Rules { far, near, least, gauss: (0..=MOST_POINTS).map(Nodes::new).collect() }
    }

    /// The n-point rule.
    #[inline(always)]
    pub(super) fn gauss(&self, n: usize) -> &Nodes {
        &self.gauss[n.min(MOST_POINTS)]
    }

    /// Points along a side of a part of a patch with so many nodes along that side. On the whole side the
    /// density has its full degree; on a half it is smoother.
    #[inline(always)]
    pub(super) fn points(&self, nodes: usize, is_whole: bool) -> usize {
        if is_whole { self.least.max(nodes + 1) } else { self.least.max(nodes / 2 + 2) }
    }

    /// Radial and angular rule of a patch around the target.
    #[inline(always)]
    pub(super) fn own(&self, nodes: usize) -> [&Nodes; 2] {
        [self.gauss(nodes + self.least - 4), self.gauss(nodes + 2 * self.least - 4)]
    }
}

/// A node of a patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Collocation {
    /// Position.
    pub(super) position: DVec3,
    /// Normal times area of the quadrature.
    pub(super) area: DVec3,
    /// Which patch.
    pub(super) patch: usize,
    /// Position in the unit square of the patch.
    pub(super) local: DVec2,
    /// ∂x/∂u and ∂x/∂v of the chart.
    pub(super) tangents: (DVec3, DVec3),
}

/// The octant, cut into patches with nodes.
#[derive(Clone, Debug)]
pub(super) struct Discretisation {
    pub(super) patches: Vec<Patch>,
    /// Bounds of each patch.
    pub(super) extents: Vec<Extent>,
    /// Number of the first node of each patch.
    pub(super) first_node: Vec<usize>,
    /// Nodes of each patch as a quadrature.
    pub(super) sources: Vec<Sources>,
    pub(super) nodes: Vec<Collocation>,
    pub(super) rules: Rules,
}

impl Discretisation {
    pub(super) fn new(patches: Vec<Patch>, rules: Rules) -> Self {
        let mut it = Discretisation {
            extents: patches.iter().map(|p| p.extent(p.u, p.v)).collect(),
            first_node: Vec::new(),
            sources: Vec::new(),
            nodes: Vec::new(),
            patches,
            rules,
        };
        for (index, patch) in it.patches.iter().enumerate() {
            it.first_node.push(it.nodes.len());
            let mut sources = Sources::default();
            let [along_u, along_v] = patch.nodes.map(|n| it.rules.gauss(n));
            let (width, height) = (patch.u[1] - patch.u[0], patch.v[1] - patch.v[0]);
            for (v, weight_v) in along_v.at.iter().zip(&along_v.weight) {
                for (u, weight_u) in along_u.at.iter().zip(&along_u.weight) {
                    let node =
                        collocation(patch, index, DVec2::new(*u, *v), weight_u * weight_v * width * height);
                    sources.push(node.position, node.area);
                    it.nodes.push(node);
                }
            }
            it.sources.push(sources);
        }
        it
    }

    /// The nodes as a quadrature over the whole surface, for functions of the parity of the octant's: eight
    /// times each.
    pub(super) fn quadrature(&self) -> Vec<SurfacePoint> {
        self.nodes.iter().map(|n| SurfacePoint { position: n.position, area: 8.0 * n.area }).collect()
    }
}

fn collocation(patch: &Patch, index: usize, local: DVec2, weight: f64) -> Collocation {
    let chart = &patch.chart;
    let (u, v) =
        (patch.u[0] + local.x * (patch.u[1] - patch.u[0]), patch.v[0] + local.y * (patch.v[1] - patch.v[0]));
    let (position, area) = chart.point(chart.line_u(u), chart.line_v(v));
    // They only choose coordinates for a quadrature, so differences are accurate enough.
    let h = 1e-4;
    let tangents = (
        (chart.position(u + h, v) - chart.position(u - h, v)) / (2.0 * h),
        (chart.position(u, v + h) - chart.position(u, v - h)) / (2.0 * h),
    );
    Collocation { position, area: area * weight, patch: index, local, tangents }
}
