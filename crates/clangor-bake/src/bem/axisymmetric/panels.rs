//! The meridian divided into panels with Gauss–Legendre nodes.
//!
//! A panel is halved until it bends by less than a radian, is short relative to the wavelength, and, where
//! two pieces meet at an angle, is 2^−levels as long as the shorter piece; then until it is at most twice as
//! long as its neighbours. This grades the panels geometrically towards edges and towards small features such
//! as a thin rim.

use clangor_core::geometry::meridian::{Meridian, Piece};
use glam::DVec2;

use super::AxisymmetricOptions;
use crate::quadrature::gauss_legendre;

/// Angle \[rad\] between two pieces above which their joint is an edge. At a joint of an angle θ the pressure
/// has a part of the order θ² r ln r. Panels without grading follow it to 8e-8 on a ball of lines with joints
/// of 0.1 rad (tests/converge/axisymmetric.rs). Sections fitted to meshes have many such joints.
const EDGE: f64 = 0.1;

/// Largest bending angle \[rad\] of a panel.
const BEND: f64 = 1.0;

/// An interval of a piece with `count` nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Panel {
    /// Index of the piece.
    pub(super) piece: usize,
    /// Parameter of the piece at the start.
    pub(super) start: f64,
    /// Parameter at the end.
    pub(super) end: f64,
    /// Length \[m\].
    pub(super) length: f64,
    /// Start \[m\].
    pub(super) from: DVec2,
    /// End \[m\].
    pub(super) to: DVec2,
}

/// A collocation point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// Its panel.
    pub(super) panel: usize,
    /// Parameter of the piece.
    pub(super) t: f64,
    /// (r, y) \[m\].
    pub(super) position: DVec2,
    /// Outward normal times the speed of the parameter \[m\].
    pub(super) normal: DVec2,
    /// Weight in the parameter of the piece.
    pub(super) weight: f64,
}

/// The meridian as panels.
#[derive(Clone, Debug)]
pub(super) struct Panels {
    pub(super) pieces: Vec<Piece>,
    pub(super) panels: Vec<Panel>,
    /// Nodes of each panel in turn.
    pub(super) nodes: Vec<Node>,
    /// The rule on [0, 1] whose nodes a panel has.
    pub(super) rule: Vec<(f64, f64)>,
    /// Weights of barycentric interpolation between them.
    barycentric: Vec<f64>,
}

impl Panels {
    /// Panels that resolve waves up to `wavenumber` [1/m].
    pub(super) fn new(meridian: &Meridian, wavenumber: f64, options: &AxisymmetricOptions) -> Self {
        let pieces = meridian.pieces().to_vec();
        let rule = gauss_legendre(options.nodes_per_panel);
        // Longest panel for the wavelength.
        let wave = std::f64::consts::TAU / wavenumber.max(1e-300);
        let longest = wave * options.nodes_per_panel as f64 / options.nodes_per_wavelength;
        let mut panels = Vec::new();
        let is_loop = meridian.is_loop();
        let length: Vec<f64> = pieces.iter().map(|p| p.length(0.0, 1.0)).collect();
        for (i, piece) in pieces.iter().enumerate() {
            // Longest panel at a geometric edge: shrinks by half per level.
            let near_edge = |other: Option<usize>, at: f64| {
                let here = piece.velocity(at).normalize();
                let (angle, shorter) = match other {
                    Some(k) => {
                        let there = pieces[k].velocity(1.0 - at).normalize();
                        (here.angle_to(there).abs(), length[i].min(length[k]))
                    }
                    // On the axis a piece that is not perpendicular to it meets its own mirror image.
                    None => (2.0 * here.y.abs().asin(), length[i]),
                };
                if angle > EDGE {
                    shorter.min(longest) * 0.5_f64.powi(options.edge_levels as i32)
                } else {
                    f64::INFINITY
                }
            };
            let before = if i > 0 { Some(i - 1) } else { is_loop.then(|| pieces.len() - 1) };
            let after = if i + 1 < pieces.len() { Some(i + 1) } else { is_loop.then_some(0) };
            let (at_start, at_end) = (near_edge(before, 0.0), near_edge(after, 1.0));
            // Bisect until each panel meets the wave, curvature and edge limits.
            let mut stack = vec![(0.0, 1.0)];
            while let Some((start, end)) = stack.pop() {
                let panel = Panel::new(i, piece, start, end);
                let curvature = (0..=4)
                    .map(|k| piece.curvature_radius(start + (end - start) * f64::from(k) / 4.0))
                    .fold(f64::INFINITY, f64::min);
                let mut most = longest.min(BEND * curvature);
                if start == 0.0 {
                    most = most.min(at_start);
                }
                if end == 1.0 {
                    most = most.min(at_end);
                }
                if panel.length > most && end - start > 1e-6 {
                    let middle = 0.5 * (start + end);
                    stack.push((middle, end));
                    stack.push((start, middle));
                } else {
                    panels.push(panel);
                }
            }
        }
        // Limit the ratio of neighbouring lengths to 2.
        balance(&mut panels, &pieces, is_loop);
        let nodes = collocation_points(&panels, &pieces, &rule);
        // Barycentric weights of the interpolation.
        let barycentric = (0..rule.len())
            .map(|i| {
                let product: f64 =
                    (0..rule.len()).filter(|j| *j != i).map(|j| 4.0 * (rule[i].0 - rule[j].0)).product();
                1.0 / product
            })
            .collect();
        Panels { pieces, panels, nodes, rule, barycentric }
    }

    /// Largest r of a node \[m\].
    pub(super) fn widest(&self) -> f64 {
        self.nodes.iter().map(|n| n.position.x).fold(0.0, f64::max)
    }

    /// Values at x in [0, 1] of the polynomials that are 1 at one node of the rule and 0 at the others.
    #[inline(always)]
    pub(super) fn cardinal(&self, x: f64, values: &mut [f64]) {
        let mut sum = 0.0;
        for (value, ((node, _), weight)) in values.iter_mut().zip(self.rule.iter().zip(&self.barycentric)) {
            let gap = x - node;
            // A point on a node: its term dominates the others to rounding.
            *value = weight / if gap.abs() > 1e-18 { gap } else { 1e-18 };
            sum += *value;
        }
        let inverse = 1.0 / sum;
        values.iter_mut().for_each(|v| *v *= inverse);
    }

    /// Slopes at each node of the rule on [0, 1], node after node, of the polynomials of
    /// [`cardinal`](Self::cardinal).
    pub(super) fn slopes(&self) -> Vec<f64> {
        let count = self.rule.len();
        let mut out = vec![0.0; count * count];
        for i in 0..count {
            for j in (0..count).filter(|j| *j != i) {
                let gap = self.rule[i].0 - self.rule[j].0;
                let slope = self.barycentric[j] / self.barycentric[i] / gap;
                out[i * count + j] = slope;
                out[i * count + i] -= slope;
            }
        }
        out
    }

    /// The panel of a parameter of a piece, and the position on it in [0, 1].
    pub(super) fn locate(&self, piece: usize, t: f64) -> (usize, f64) {
        let panel = self
            .panels
            .iter()
            .position(|p| p.piece == piece && t <= p.end)
            .or_else(|| self.panels.iter().rposition(|p| p.piece == piece))
            .unwrap_or(0);
        let Panel { start, end, .. } = self.panels[panel];
        (panel, (t - start) / (end - start))
    }
}

impl Panel {
    fn new(index: usize, piece: &Piece, start: f64, end: f64) -> Self {
        Panel {
            piece: index,
            start,
            end,
            length: piece.length(start, end),
            from: piece.point(start),
            to: piece.point(end),
        }
    }
}

/// Collocation points: the Gauss–Legendre nodes of each panel.
fn collocation_points(panels: &[Panel], pieces: &[Piece], rule: &[(f64, f64)]) -> Vec<Node> {
    let of_panel = |(k, panel): (usize, &Panel)| {
        let piece = pieces[panel.piece];
        let (start, span) = (panel.start, panel.end - panel.start);
        rule.iter().map(move |(x, w)| {
            let t = start + span * x;
            let v = piece.velocity(t);
            let normal = DVec2::new(v.y, -v.x);
            Node { panel: k, t, position: piece.point(t), normal, weight: span * w }
        })
    };
    panels.iter().enumerate().flat_map(of_panel).collect()
}

/// Halves panels that are more than twice as long as a neighbour, until none remain.
fn balance(panels: &mut Vec<Panel>, pieces: &[Piece], is_loop: bool) {
    loop {
        let count = panels.len();
        let too_long = |k: usize| {
            let before = if k > 0 { Some(k - 1) } else { is_loop.then_some(count - 1) };
            let after = if k + 1 < count { Some(k + 1) } else { is_loop.then_some(0) };
            [before, after].into_iter().flatten().any(|j| panels[k].length > 2.05 * panels[j].length)
        };
        let marked: Vec<bool> = (0..count).map(too_long).collect();
        if marked.iter().all(|m| !m) {
            return;
        }
        *panels = panels
            .iter()
            .zip(&marked)
            .flat_map(|(panel, marked)| {
                let Panel { piece, start, end, .. } = *panel;
                let middle = 0.5 * (start + end);
                if *marked {
                    let half = |a, b| Panel::new(piece, &pieces[piece], a, b);
                    vec![half(start, middle), half(middle, end)]
                } else {
                    vec![*panel]
                }
            })
            .collect();
    }
}
