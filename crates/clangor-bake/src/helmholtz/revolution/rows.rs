//! A row of the system: the integral equation at one node.
//!
//! ```text
//! ½ p_m(x) − Σ_panels ∫ D_m p_m r' ds' = ∫ S_m a_m r' ds'
//! ```
//!
//! A panel far from the target is integrated at its own nodes. One that is near is halved towards the target
//! until each part is far, with the pressure interpolated; far means that the target and its image behind the axis lie
//! outside the ellipse around the part on which Gauss' rule has converged. On the panel of the target itself the kernels
//! are singular like ln|s − s'|: each side has a Gauss rule in the cube root of the distance, which makes of
//! it a function of four derivatives.

use num_complex::Complex64;

use super::lanes::{LANES, Lanes};
use super::panels::{Node, Panels};
use super::ring::{MidpointLadder, RingKernels, RingRule, Sources};

/// Right-hand sides: moving along the axis (m = 0), across it, and turning about an axis across it (m = 1).
pub(super) const MOTIONS: usize = 3;

/// Accuracy of the rule on a panel far away, and on a part of one that is near.
const FAR: f64 = 1e-13;
const NEAR: f64 = 1e-10;

/// What all rows share.
pub(super) struct RowContext<'a> {
    pub(super) panels: &'a Panels,
    pub(super) ladder: &'a MidpointLadder,
    /// k [1/m] of the batch; the real parts in ascending order.
    pub(super) wavenumbers: &'a [Complex64],
    /// Points and weights on [0, 1] of the rule for ln x, on each side of the target.
    singular: Vec<(f64, f64)>,
    /// (d₁ + d₂)/length beyond which a panel is far.
    far: f64,
    /// The same for a part of a panel.
    near: f64,
}

/// One row for every wavenumber.
pub(super) struct Row {
    /// Real parts of ∫ D_m: wavenumber, m, column.
    pub(super) real: Vec<f64>,
    /// Imaginary parts.
    pub(super) imaginary: Vec<f64>,
    /// Right-hand sides of each wavenumber.
    pub(super) rhs: Vec<[Complex64; MOTIONS]>,
}

/// a_n of the motions times the speed of the parameter.
pub(super) fn motion(r: f64, y: f64, normal_r: f64, normal_y: f64) -> [f64; MOTIONS] {
    [normal_y, normal_r, r * normal_y - y * normal_r]
}

impl<'a> RowContext<'a> {
    pub(super) fn new(panels: &'a Panels, ladder: &'a MidpointLadder, wavenumbers: &'a [Complex64]) -> Self {
        let order = panels.rule.len();
        // Gauss' rule with n points errs by ρ^{−2n} if the integrand is analytic within the ellipse of parameter ρ around
        // the panel; a point is on it if its distances from the ends are (ρ + 1/ρ)/2 lengths together.
        let ratio = |accuracy: f64| {
            let rho = accuracy.powf(-0.5 / order as f64);
            0.5 * (rho + 1.0 / rho)
        };
        let singular = crate::quadrature::gauss_legendre(order + 8)
            .into_iter()
            .map(|(x, w)| (x * x * x, 3.0 * x * x * w))
            .collect();
        RowContext { panels, ladder, wavenumbers, singular, far: ratio(FAR), near: ratio(NEAR) }
    }

    /// The row of a node.
    pub(super) fn row(&self, target: usize) -> Row {
        pulp::Arch::new().dispatch(RowTask { context: self, target })
    }

    #[inline(always)]
    fn row_inlined<const DAMPED: bool>(&self, target: usize) -> Row {
        let panels = self.panels;
        let count = panels.rule.len();
        let node = &panels.nodes[target];
        let width = panels.nodes.len() * 2 * self.wavenumbers.len();
        let mut row = RowBuilder {
            row: Row {
                real: vec![0.0; width],
                imaginary: vec![0.0; width],
                rhs: vec![[Complex64::ZERO; MOTIONS]; self.wavenumbers.len()],
            },
            rule: RingRule::default(),
            cardinal: vec![0.0; LANES * count],
            column: 0,
        };
        let mut points: Vec<(f64, f64)> = Vec::new();
        for (index, panel) in panels.panels.iter().enumerate() {
            row.column = index * count;
            let same_piece = panel.piece == panels.panels[node.panel].piece;
            if index != node.panel && separated(node, panel.from, panel.to, panel.length, self.far) {
                for first in (0..count).step_by(LANES) {
                    let group = &panels.nodes[row.column + first..row.column + first + LANES];
                    let ring = Group::of(|l| {
                        let n = &group[l];
                        let chord = n.position - node.position;
                        Point {
                            position: n.position,
                            normal: n.normal,
                            weight: n.weight,
                            gap_square: chord.length_squared(),
                            across: chord.dot(n.normal),
                        }
                    });
                    row.add::<DAMPED>(self, node, &ring, Target::Columns(first));
                }
                continue;
            }
            // Offsets of the parameter from the target's if on its piece, else the parameter itself.
            let origin = if same_piece { node.t } else { 0.0 };
            points.clear();
            if index == node.panel {
                for reach in [panel.start - node.t, panel.end - node.t] {
                    points.extend(self.singular.iter().map(|(x, w)| (reach * x, (reach * w).abs())));
                }
            } else {
                self.near_points(node, index, origin, &mut points);
            }
            let piece = panels.pieces[panel.piece];
            let span = panel.end - panel.start;
            for group in points.chunks_exact(LANES) {
                let ring = Group::of(|l| {
                    let (step, weight) = group[l];
                    let t = origin + step;
                    let v = piece.velocity(t);
                    let normal = glam::DVec2::new(v.y, -v.x);
                    let position = piece.point(t);
                    let (chord, across) = if same_piece {
                        piece.chord(node.t, step)
                    } else {
                        let chord = position - node.position;
                        (chord, chord.dot(normal))
                    };
                    Point { position, normal, weight, gap_square: chord.length_squared(), across }
                });
                for (l, (step, _)) in group.iter().enumerate() {
                    let x = (origin - panel.start + step) / span;
                    panels.cardinal(x, &mut row.cardinal[l * count..(l + 1) * count]);
                }
                row.add::<DAMPED>(self, node, &ring, Target::Interpolated);
            }
        }
        row.row
    }

    /// Points of a panel near a target, halved towards it; parameters less `origin`.
    #[inline(always)]
    fn near_points(&self, node: &Node, index: usize, origin: f64, points: &mut Vec<(f64, f64)>) {
        let panel = &self.panels.panels[index];
        let piece = &self.panels.pieces[panel.piece];
        let mut stack = vec![(panel.start, panel.end, 0)];
        while let Some((start, end, depth)) = stack.pop() {
            let middle = 0.5 * (start + end);
            let (from, centre, to) = (piece.point(start), piece.point(middle), piece.point(end));
            let length = from.distance(centre) + centre.distance(to);
            // A node is at least 1/200 of the smallest panel beside it away: the depth never gets there.
            if depth < 40 && !separated(node, from, to, length, self.near) {
                stack.push((middle, end, depth + 1));
                stack.push((start, middle, depth + 1));
                continue;
            }
            let span = end - start;
            points.extend(self.panels.rule.iter().map(|(x, w)| (start - origin + span * x, span * w)));
        }
    }
}

/// Whether a target and its image behind the axis are outside the ellipse around a stretch of the meridian.
#[inline(always)]
fn separated(node: &Node, from: glam::DVec2, to: glam::DVec2, length: f64, ratio: f64) -> bool {
    let image = glam::DVec2::new(-node.position.x, node.position.y);
    [node.position, image].iter().all(|p| p.distance(from) + p.distance(to) >= ratio * length)
}

/// A row as `pulp` wants it, to be compiled for each instruction set.
struct RowTask<'a> {
    context: &'a RowContext<'a>,
    target: usize,
}

impl pulp::WithSimd for RowTask<'_> {
    type Output = Row;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Row {
        if self.context.wavenumbers.iter().all(|k| k.im == 0.0) {
            self.context.row_inlined::<false>(self.target)
        } else {
            self.context.row_inlined::<true>(self.target)
        }
    }
}

/// Where the kernels of eight points go.
enum Target {
    /// To the columns of eight nodes, from this one of the panel.
    Columns(usize),
    /// To all nodes of the panel, by the cardinal polynomials.
    Interpolated,
}

/// A point of a quadrature on the meridian.
struct Point {
    position: glam::DVec2,
    normal: glam::DVec2,
    weight: f64,
    gap_square: f64,
    across: f64,
}

/// Eight points in lanes.
struct Group {
    sources: Sources,
    /// a_m of the three motions.
    motions: [Lanes; MOTIONS],
    widest: f64,
}

impl Group {
    #[inline(always)]
    fn of(point: impl Fn(usize) -> Point) -> Self {
        let mut group =
            Group { sources: Sources::default(), motions: [Lanes::default(); MOTIONS], widest: 0.0 };
        for l in 0..LANES {
            let p = point(l);
            group.sources.radius.0[l] = p.position.x;
            group.sources.gap_square.0[l] = p.gap_square;
            group.sources.normal_r.0[l] = p.normal.x;
            group.sources.across.0[l] = p.across;
            group.sources.weight.0[l] = p.weight;
            let motions = motion(p.position.x, p.position.y, p.normal.x, p.normal.y);
            for (lanes, value) in group.motions.iter_mut().zip(motions) {
                lanes.0[l] = value;
            }
            group.widest = group.widest.max(p.position.x);
        }
        group
    }
}

/// A row that is being summed.
struct RowBuilder {
    row: Row,
    rule: RingRule,
    /// Cardinal polynomials at eight points.
    cardinal: Vec<f64>,
    /// First column of the panel.
    column: usize,
}

impl RowBuilder {
    #[inline(always)]
    fn add<const DAMPED: bool>(&mut self, context: &RowContext, node: &Node, group: &Group, target: Target) {
        let r = node.position.x;
        let highest = context.wavenumbers.last().map_or(0.0, |k| k.re);
        let midpoints = context.ladder.rule(highest * r.min(group.widest));
        self.rule.prepare(r, &group.sources, midpoints);
        let nodes = context.panels.nodes.len();
        let count = context.panels.rule.len();
        for (f, k) in context.wavenumbers.iter().enumerate() {
            let RingKernels { single, double } = self.rule.kernels::<DAMPED>(*k, midpoints);
            for (i, sum) in self.row.rhs[f].iter_mut().enumerate() {
                let m = usize::from(i > 0);
                for l in 0..LANES {
                    *sum += Complex64::new(single[m][0].0[l], single[m][1].0[l]) * group.motions[i].0[l];
                }
            }
            for (m, [re, im]) in double.iter().enumerate() {
                let start = (2 * f + m) * nodes + self.column;
                match target {
                    Target::Columns(first) => {
                        for l in 0..LANES {
                            self.row.real[start + first + l] += re.0[l];
                            self.row.imaginary[start + first + l] += im.0[l];
                        }
                    }
                    Target::Interpolated => {
                        let real = &mut self.row.real[start..start + count];
                        let imaginary = &mut self.row.imaginary[start..start + count];
                        for l in 0..LANES {
                            let cardinal = &self.cardinal[l * count..(l + 1) * count];
                            for ((real, imaginary), c) in
                                real.iter_mut().zip(imaginary.iter_mut()).zip(cardinal)
                            {
                                *real = c.mul_add(re.0[l], *real);
                                *imaginary = c.mul_add(im.0[l], *imaginary);
                            }
                        }
                    }
                }
            }
        }
    }
}
