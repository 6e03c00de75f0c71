//! Quadrature over pairs of touching or nearly touching triangles.
//!
//! Touching pairs share a corner, an edge or the whole triangle: the coordinates of Sauter and Schwab,
//! *Boundary Element Methods*, §5.2, in which the integrand 1/r is smooth, with Gauss points. Close pairs are
//! divided into four until the pieces are as far apart as their size, with six points on each, or three in a
//! draft.

use super::panels::Panels;
use crate::effort::Effort;
use crate::quadrature::gauss_legendre;

/// Shares of the corners at a point.
pub(super) type Shares = [f64; 3];

/// A point of a rule on one triangle: shares of the corners and fraction of the area.
pub(super) type TrianglePoint = (Shares, f64);

/// A point of a rule on a pair, on which the shared corners come first in both; weight per product of areas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PairPoint {
    pub(super) test: Shares,
    pub(super) source: Shares,
    pub(super) weight: f64,
}

/// Three points inside, exact for quadratics.
pub(super) const THREE_POINTS: [TrianglePoint; 3] = [
    ([2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0], 1.0 / 3.0),
    ([1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0], 1.0 / 3.0),
    ([1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0], 1.0 / 3.0),
];

/// Six points, exact for quartics (Strang and Fix).
pub(super) fn six_points() -> [TrianglePoint; 6] {
    let orbit = |a: f64, w: f64| {
        let b = 1.0 - 2.0 * a;
        [([b, a, a], w), ([a, b, a], w), ([a, a, b], w)]
    };
    let [a, b, c] = orbit(0.445_948_490_915_965, 0.223_381_589_678_011);
    let [d, e, f] = orbit(0.091_576_213_509_771, 0.109_951_743_655_322);
    [a, b, c, d, e, f]
}

/// Rules for pairs that share one corner, two, or all three, and how far others are divided.
#[derive(Clone, Debug)]
pub(super) struct TouchingRules {
    sharing: [Vec<PairPoint>; 3],
    /// Of each piece of a close pair.
    close: Vec<TrianglePoint>,
    /// Most halvings of one close pair, both triangles together.
    deepest: u32,
    /// Distance of their centres from which on pieces count as separate, in the sum of their radii.
    separation: f64,
}

impl TouchingRules {
    /// Rules with the given Gauss points in each of the four directions.
    pub(super) fn new(corner: usize, edge: usize, same: usize) -> Self {
        Self {
            sharing: [touching(1, corner), touching(2, edge), touching(3, same)],
            close: six_points().to_vec(),
            deepest: DEEPEST,
            separation: SEPARATION,
        }
    }

    /// As precise as a solve of this effort needs.
    pub(super) fn of(effort: Effort) -> Self {
        match effort {
            Effort::Exact => Self::new(2, 3, 3),
            Effort::Draft => Self {
                close: THREE_POINTS.to_vec(),
                deepest: DEEPEST_OF_DRAFTS,
                separation: SEPARATION_OF_DRAFTS,
                ..Self::new(2, 2, 2)
            },
        }
    }

    /// Distance of the centres of near triangles, in the sum of their radii.
    pub(super) fn separation(&self) -> f64 {
        self.separation
    }

    /// The rule for a pair that shares so many corners, 1 to 3.
    pub(super) fn sharing(&self, corners: usize) -> &[PairPoint] {
        &self.sharing[corners - 1]
    }
}

fn touching(shared: usize, order: usize) -> Vec<PairPoint> {
    let gauss = gauss_legendre(order);
    let mut points = Vec::new();
    for &(x, wx) in &gauss {
        for &(a, wa) in &gauss {
            for &(b, wb) in &gauss {
                for &(c, wc) in &gauss {
                    let weight = 4.0 * wx * wa * wb * wc * x * x * x;
                    let mut add = |u: [f64; 2], v: [f64; 2], factor: f64| {
                        // (u₁, u₂) with 0 ≤ u₂ ≤ u₁ ≤ 1 runs from the first corner to the opposite edge.
                        let shares = |p: [f64; 2]| [1.0 - p[0], p[0] - p[1], p[1]];
                        points.push(PairPoint {
                            test: shares(u),
                            source: shares(v),
                            weight: weight * factor,
                        });
                    };
                    // Relative coordinates for a shared vertex (2 regions), edge (5) or face (6).
                    match shared {
                        1 => {
                            add([x, x * a], [x * b, x * b * c], b);
                            add([x * b, x * b * c], [x, x * a], b);
                        }
                        2 => {
                            let whole = [x, x * a];
                            let (f, g) = (a * a, a * a * b);
                            add([x, x * a * c], [x * (1.0 - a * b), x * a * (1.0 - b)], f);
                            add(whole, [x * (1.0 - a * b * c), x * a * b * (1.0 - c)], g);
                            add([x * (1.0 - a * b * c), x * a * b * (1.0 - c)], whole, g);
                            add([x * (1.0 - a * b), x * a * (1.0 - b)], [x, x * a * b * c], g);
                            add([x * (1.0 - a * b * c), x * a * (1.0 - b * c)], [x, x * a * b], g);
                        }
                        _ => {
                            let f = a * a * b;
                            let mut both = |u: [f64; 2], v: [f64; 2]| {
                                add(u, v, f);
                                add(v, u, f);
                            };
                            both([x, x * (1.0 - a + a * b)], [x * (1.0 - a * b * c), x * (1.0 - a)]);
                            both([x, x * a * (1.0 - b + b * c)], [x * (1.0 - a * b), x * a * (1.0 - b)]);
                            both([x * (1.0 - a * b * c), x * a * (1.0 - b * c)], [x, x * a * (1.0 - b)]);
                        }
                    }
                }
            }
        }
    }
    points
}

/// Pieces are integrated when their centres are farther apart than this times the sum of their radii.
const SEPARATION: f64 = 1.3;
/// The same for drafts.
const SEPARATION_OF_DRAFTS: f64 = 1.0;

/// Most halvings of one pair, both triangles together.
const DEEPEST: u32 = 8;
/// The same for drafts, whose triangles may be much larger than a wall.
const DEEPEST_OF_DRAFTS: u32 = 3;

/// Calls `add` with the points of a close pair that does not touch.
pub(super) fn close_pair(
    test: &Panels,
    source: &Panels,
    (pair, rules): ((usize, usize), &TouchingRules),
    add: &mut impl FnMut(Shares, Shares, f64),
) {
    let whole = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let TouchingRules { close: rule, deepest, separation, .. } = rules;
    let mut pending = vec![(whole, 0_u32, whole, 0_u32)];
    while let Some((u, depth_u, v, depth_v)) = pending.pop() {
        let half = |depth: u32| 0.5_f64.powi(depth as i32);
        let (radius_u, radius_v) = (test.radii[pair.0] * half(depth_u), source.radii[pair.1] * half(depth_v));
        let (x, y) = (test.point(pair.0, centre(&u)), source.point(pair.1, centre(&v)));
        if x.distance(y) < separation * (radius_u + radius_v) && depth_u + depth_v < *deepest {
            if radius_u >= radius_v {
                pending.extend(quarters(&u).map(|u| (u, depth_u + 1, v, depth_v)));
            } else {
                pending.extend(quarters(&v).map(|v| (u, depth_u, v, depth_v + 1)));
            }
            continue;
        }
        let weight = half(2 * (depth_u + depth_v));
        for (p, wp) in rule {
            for (q, wq) in rule {
                add(inside(&u, *p), inside(&v, *q), weight * wp * wq);
            }
        }
    }
}

/// Corners of a piece of a triangle, as shares of the corners of the whole.
pub(super) type Piece = [Shares; 3];

/// Shares in the whole triangle of a point given by its shares in a piece.
pub(super) fn inside(piece: &Piece, shares: Shares) -> Shares {
    std::array::from_fn(|i| (0..3).map(|c| piece[c][i] * shares[c]).sum())
}

pub(super) fn centre(piece: &Piece) -> Shares {
    inside(piece, [1.0 / 3.0; 3])
}

/// The four pieces between the midpoints of the edges.
pub(super) fn quarters(piece: &Piece) -> [Piece; 4] {
    let middle = |a: Shares, b: Shares| -> Shares { std::array::from_fn(|i| 0.5 * (a[i] + b[i])) };
    let [a, b, c] = *piece;
    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

/// Corner numbers of a triangle with those in `first` leading, in that order.
pub(super) fn leading(triangle: [u32; 3], first: &[u32]) -> [usize; 3] {
    let mut order = [0; 3];
    let mut filled = 0;
    for v in first {
        if let Some(i) = triangle.iter().position(|c| c == v) {
            order[filled] = i;
            filled += 1;
        }
    }
    for i in 0..3 {
        if filled < 3 && !order[..filled].contains(&i) {
            order[filled] = i;
            filled += 1;
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// ∫∫ 1/r over a pair, by a rule for touching pairs.
    fn potential(order: usize, shared: usize, a: [DVec3; 3], b: [DVec3; 3]) -> f64 {
        let at = |t: &[DVec3; 3], s: Shares| t[0] * s[0] + t[1] * s[1] + t[2] * s[2];
        let area = |t: &[DVec3; 3]| 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).length();
        let sum: f64 = touching(shared, order)
            .iter()
            .map(|p| p.weight / at(&a, p.test).distance(at(&b, p.source)))
            .sum();
        sum * area(&a) * area(&b)
    }

    #[test]
    fn weights_of_touching_rules_sum_to_one() {
        for shared in 1..=3 {
            let sum: f64 = touching(shared, 4).iter().map(|p| p.weight).sum();
            // Residual seen: 2e-15.
            assert!((sum - 1.0).abs() < 1e-13, "{shared}: {sum}");
        }
    }

    #[test]
    fn touching_rules_converge_to_one_value() {
        let p = [DVec3::ZERO, DVec3::X, DVec3::new(0.3, 0.9, 0.0)];
        let edge = [DVec3::ZERO, DVec3::X, DVec3::new(0.4, -0.5, 0.6)];
        let corner = [DVec3::ZERO, DVec3::new(-0.7, -0.4, 0.2), DVec3::new(-0.2, -0.9, -0.3)];
        for (shared, other) in [(3, p), (2, edge), (1, corner)] {
            let fine = potential(10, shared, p, other);
            let seen = [3, 5].map(|order| (potential(order, shared, p, other) / fine - 1.0).abs());
            // Residuals seen: 4e-4 and 4e-6 at most.
            assert!(seen[0] < 2e-3 && seen[1] < 2e-5, "{shared}: {seen:?}");
        }
        // ∫∫ 1/r of a triangle with itself is (4A²/3) Σ ln(P/(P − 2lᵢ))/lᵢ, P its perimeter.
        let side = [DVec3::ZERO, DVec3::X, DVec3::new(0.5, 0.75_f64.sqrt(), 0.0)];
        let exact = 0.75 * 3.0_f64.ln();
        // Residual seen: 1e-9.
        assert!((potential(12, 3, side, side) / exact - 1.0).abs() < 1e-6, "{exact}");
    }
}
