//! One row of the boundary equation: all integrals over one eighth of the surface, for one node and its seven
//! mirror images as targets.
//!
//! Three cases, by how far a patch is from the target:
//!
//! * far: the nodes of the patch are the quadrature;
//! * near: the patch is halved along its longer side until every part is far enough for a finer Gauss rule,
//!   and the density is interpolated to its points;
//! * the patch that contains the target: triangles from the target to the four sides in polar coordinates,
//!   whose area element cancels 1/r. The angle is replaced by sinh⁻¹ of the position along the side, so that
//!   close sides need no more points. Distances are those of the tangent plane, so that stretched patches
//!   need no more either.

#![allow(
    clippy::needless_range_loop,
    reason = "loops over lanes, several arrays at one index, that become vector instructions"
)]

use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::{DVec2, DVec3};
use num_complex::Complex64;

use super::chart::Patch;
use super::discretisation::Discretisation;
use super::kernel::{SingleLayer, Sources, Values, Wavenumbers, layers};
use super::lagrange::Nodes;
use super::symmetry::{IMAGES, mirror, sign_of};

/// Halvings after which a part is not divided further.
const MOST_HALVINGS: u32 = 40;

/// Integrals of one row, and scratch storage.
pub(super) struct RowBuilder<const F: usize> {
    /// Double layer of each image and column: index image · unknowns + column.
    pub(super) double: Vec<Values<F>>,
    /// Single layer of each wavenumber and motion, all images together.
    pub(super) right: [[Complex64; RIGID_DOFS]; F],
    scratch: Scratch<F>,
}

struct Scratch<const F: usize> {
    sources: Sources,
    values: Vec<Values<F>>,
    basis: [Vec<f64>; 2],
    lines: Vec<[f64; 2]>,
    partial: Vec<Values<F>>,
    parts: Vec<([f64; 2], [f64; 2], u32)>,
}

impl<const F: usize> RowBuilder<F> {
    pub(super) fn new(unknowns: usize) -> Self {
        RowBuilder {
            double: vec![[[0.0; F]; 2]; IMAGES * unknowns],
            right: [[Complex64::ZERO; RIGID_DOFS]; F],
            scratch: Scratch {
                sources: Sources::default(),
                values: Vec::new(),
                basis: [Vec::new(), Vec::new()],
                lines: Vec::new(),
                partial: Vec::new(),
                parts: Vec::new(),
            },
        }
    }

    /// Computes the integrals seen from a node.
    #[inline(always)]
    pub(super) fn fill(&mut self, of: &Discretisation, row: usize, wavenumbers: &Wavenumbers<F>) {
        self.double.fill([[0.0; F]; 2]);
        self.right = [[Complex64::ZERO; RIGID_DOFS]; F];
        let unknowns = of.nodes.len();
        for image in 0..IMAGES {
            let target = mirror(image, of.nodes[row].position);
            let view = View { of, target, wavenumbers };
            let mut single = SingleLayer::ZERO;
            for (index, patch) in of.patches.iter().enumerate() {
                let columns = image * unknowns + of.first_node[index];
                let out = &mut self.double[columns..columns + patch.count()];
                let extent = &of.extents[index];
                if image == 0 && of.nodes[row].patch == index {
                    view.own(row, &mut self.scratch, &mut single, out);
                } else if target.distance(extent.centre) > of.rules.far * extent.radius {
                    layers(target, &of.sources[index], wavenumbers, &mut self.scratch.values, &mut single);
                    out.copy_from_slice(&self.scratch.values[..patch.count()]);
                } else {
                    view.near(patch, &mut self.scratch, &mut single, out);
                }
            }
            for f in 0..F {
                for degree in 0..RIGID_DOFS {
                    self.right[f][degree] += sign_of(image, degree) * single.sum(f, degree);
                }
            }
        }
    }
}

/// A target and the inputs of its row: the discretisation and the wavenumbers.
struct View<'a, const F: usize> {
    of: &'a Discretisation,
    target: DVec3,
    wavenumbers: &'a Wavenumbers<F>,
}

impl<const F: usize> View<'_, F> {
    /// Integrates a patch close to the target: halves it until every part is far enough.
    #[inline(always)]
    fn near(
        &self,
        patch: &Patch,
        scratch: &mut Scratch<F>,
        single: &mut SingleLayer<F>,
        out: &mut [Values<F>],
    ) {
        scratch.parts.clear();
        scratch.parts.push((patch.u, patch.v, 0));
        while let Some((u, v, depth)) = scratch.parts.pop() {
            let extent = patch.extent(u, v);
            if depth < MOST_HALVINGS
                && self.target.distance(extent.centre) < self.of.rules.near * extent.radius
            {
                if extent.length_u > extent.length_v {
                    let middle = 0.5 * (u[0] + u[1]);
                    scratch.parts.push(([u[0], middle], v, depth + 1));
                    scratch.parts.push(([middle, u[1]], v, depth + 1));
                } else {
                    let middle = 0.5 * (v[0] + v[1]);
                    scratch.parts.push((u, [v[0], middle], depth + 1));
                    scratch.parts.push((u, [middle, v[1]], depth + 1));
                }
                continue;
            }
            self.part(patch, [u, v], scratch, single, out);
        }
    }

    /// Integrates a part of a patch by a Gauss rule: the products with the basis are sums first along u, then
    /// along v.
    #[inline(always)]
    fn part(
        &self,
        patch: &Patch,
        range: [[f64; 2]; 2],
        scratch: &mut Scratch<F>,
        single: &mut SingleLayer<F>,
        out: &mut [Values<F>],
    ) {
        let whole = [patch.u, patch.v];
        // Gauss rule and interpolation basis along u and v.
        let rule: [&Nodes; 2] = std::array::from_fn(|axis| {
            let is_whole = range[axis] == whole[axis];
            self.of.rules.gauss(self.of.rules.points(patch.nodes[axis], is_whole))
        });
        let width: [f64; 2] = range.map(|r| r[1] - r[0]);
        scratch.lines.clear();
        for axis in 0..2 {
            let nodes = self.of.rules.gauss(patch.nodes[axis]);
            let basis = &mut scratch.basis[axis];
            basis.clear();
            basis.resize(rule[axis].at.len() * patch.nodes[axis], 0.0);
            for (t, values) in rule[axis].at.iter().zip(basis.chunks_exact_mut(patch.nodes[axis])) {
                let at = range[axis][0] + t * width[axis];
                nodes.basis((at - whole[axis][0]) / (whole[axis][1] - whole[axis][0]), values);
                scratch.lines.push(if axis == 0 { patch.chart.line_u(at) } else { patch.chart.line_v(at) });
            }
        }
        // Points and weighted areas of the tensor-product rule.
        let (lines_u, lines_v) = scratch.lines.split_at(rule[0].at.len());
        scratch.sources.clear();
        for (line_v, weight_v) in lines_v.iter().zip(&rule[1].weight) {
            for (line_u, weight_u) in lines_u.iter().zip(&rule[0].weight) {
                let (x, area) = patch.chart.point(*line_u, *line_v);
                scratch.sources.push(x, area * (weight_u * weight_v * width[0] * width[1]));
            }
        }
        // Kernels at the points.
        layers(self.target, &scratch.sources, self.wavenumbers, &mut scratch.values, single);
        // Products with the basis: along u to partial sums, then along v to the columns.
        let along_u = patch.nodes[0];
        for (line, basis_v) in scratch.basis[1].chunks_exact(patch.nodes[1]).enumerate() {
            scratch.partial.clear();
            scratch.partial.resize(along_u, [[0.0; F]; 2]);
            let first = line * rule[0].at.len();
            for (value, basis_u) in scratch.values[first..].iter().zip(scratch.basis[0].chunks_exact(along_u))
            {
                for (sum, factor) in scratch.partial.iter_mut().zip(basis_u) {
                    add(sum, value, *factor);
                }
            }
            for (column, factor) in out.chunks_exact_mut(along_u).zip(basis_v) {
                for (sum, value) in column.iter_mut().zip(&scratch.partial) {
                    add(sum, value, *factor);
                }
            }
        }
    }

    /// Integrates the patch that contains the target, in polar coordinates.
    #[inline(always)]
    fn own(&self, row: usize, scratch: &mut Scratch<F>, single: &mut SingleLayer<F>, out: &mut [Values<F>]) {
        let node = &self.of.nodes[row];
        let patch = &self.of.patches[node.patch];
        let [radial, angular] = self.of.rules.own(patch.nodes[0].max(patch.nodes[1]));
        let bases = [self.of.rules.gauss(patch.nodes[0]), self.of.rules.gauss(patch.nodes[1])];
        let size = DVec2::new(patch.u[1] - patch.u[0], patch.v[1] - patch.v[0]);
        // From the unit square of the patch to its tangent plane at the target.
        let (along_u, along_v) = node.tangents;
        let e1 = along_u.normalize_or_zero();
        let e2 = (along_v - along_v.dot(e1) * e1).normalize_or_zero();
        let to_plane = |p: DVec2| {
            let (a, b) = (p.x * size.x, p.y * size.y);
            DVec2::new(a * along_u.length() + b * along_v.dot(e1), b * along_v.dot(e2))
        };
        let here = node.local;
        let corners = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        // One triangle per side of the patch.
        for side in 0..4 {
            let ends = [corners[side] - here, corners[(side + 1) % 4] - here];
            let (a, b) = (to_plane(ends[0]), to_plane(ends[1]));
            let length = (b - a).length();
            let along = (b - a) / length;
            // Foot of the perpendicular: the side is at distance h, its ends at t_a and t_b along it.
            let height = a.perp_dot(along).abs();
            let (from, to) = ((a.dot(along) / height).asinh(), (b.dot(along) / height).asinh());
            // Points in polar coordinates about the target, angle by sinh⁻¹ of the position along the side.
            let double_area = ends[0].perp_dot(ends[1]).abs();
            scratch.sources.clear();
            scratch.basis[0].clear();
            scratch.basis[1].clear();
            for (t, weight_t) in angular.at.iter().zip(&angular.weight) {
                let tau = from + t * (to - from);
                let part = (height * tau.sinh() - a.dot(along)) / length;
                let towards = ends[0] + part * (ends[1] - ends[0]);
                let weight =
                    weight_t * (to - from) * height * tau.cosh() / length * double_area * size.x * size.y;
                // Points along the ray, and the interpolation basis there.
                for (rho, weight_rho) in radial.at.iter().zip(&radial.weight) {
                    let local = here + *rho * towards;
                    let (u, v) = (patch.u[0] + local.x * size.x, patch.v[0] + local.y * size.y);
                    let (x, area) = patch.chart.point(patch.chart.line_u(u), patch.chart.line_v(v));
                    scratch.sources.push(x, area * (weight * weight_rho * rho));
                    for (axis, at) in [local.x, local.y].into_iter().enumerate() {
                        let basis = &mut scratch.basis[axis];
                        let start = basis.len();
                        basis.resize(start + patch.nodes[axis], 0.0);
                        bases[axis].basis(at, &mut basis[start..]);
                    }
                }
            }
            // Kernels at the points.
            layers(self.target, &scratch.sources, self.wavenumbers, &mut scratch.values, single);
            // Products with the basis, point by point.
            let products = scratch.basis[0]
                .chunks_exact(patch.nodes[0])
                .zip(scratch.basis[1].chunks_exact(patch.nodes[1]));
            for (value, (basis_u, basis_v)) in scratch.values.iter().zip(products) {
                for (column, factor_v) in out.chunks_exact_mut(patch.nodes[0]).zip(basis_v) {
                    for (sum, factor_u) in column.iter_mut().zip(basis_u) {
                        add(sum, value, factor_u * factor_v);
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn add<const F: usize>(sum: &mut Values<F>, value: &Values<F>, factor: f64) {
    for part in 0..2 {
        for f in 0..F {
            sum[part][f] = value[part][f].mul_add(factor, sum[part][f]);
        }
    }
}
