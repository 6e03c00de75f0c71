//! Smooth pieces of a surface, and the patches they are cut into.
//!
//! A chart maps the unit square onto a piece of one octant of the body; both the point and the normal times
//! the element of area come in closed form. A patch is a rectangle of a chart with a grid of Gauss–Legendre
//! nodes.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::DVec3;

/// A piece of the surface in the octant x, y, z ≥ 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Chart {
    /// A third of an octant of an ellipsoid, whose corners are the ends of semi-axis `face`, of the two
    /// planes of symmetry through it, and the middle: x = centre + S d/|d|, d = (1, tan πu/4, tan πv/4) in
    /// cyclic order.
    Ellipsoid {
        /// Centre \[m\].
        centre: DVec3,
        /// Diagonal of S \[m\].
        semi_axes: DVec3,
        /// 0, 1, 2 for x, y, z.
        face: usize,
    },
    /// A rectangle: x = corner + u `first` + v `second`.
    Flat {
        /// Corner at u = v = 0 \[m\].
        corner: DVec3,
        /// Edge along u \[m\].
        first: DVec3,
        /// Edge along v \[m\]; first × second points outwards.
        second: DVec3,
    },
    /// A quarter of a cylinder: x = start + v `along` + `radius` (cos πu/2 `from` + sin πu/2 `to`).
    Bend {
        /// Centre of the circle at v = 0 \[m\].
        start: DVec3,
        /// Axis \[m\].
        along: DVec3,
        /// Radius \[m\].
        radius: f64,
        /// Unit normal at u = 0.
        from: DVec3,
        /// Unit normal at u = 1.
        to: DVec3,
    },
}

/// Functions of one coordinate, u or v, computed once per line of a grid.
pub(super) type Line = [f64; 2];

impl Chart {
    /// What depends on u.
    pub(super) fn line_u(&self, u: f64) -> Line {
        match self {
            Chart::Ellipsoid { .. } => tangent(u),
            Chart::Flat { .. } => [u, 0.0],
            Chart::Bend { .. } => (FRAC_PI_2 * u).sin_cos().into(),
        }
    }

    /// What depends on v.
    pub(super) fn line_v(&self, v: f64) -> Line {
        match self {
            Chart::Ellipsoid { .. } => tangent(v),
            Chart::Flat { .. } | Chart::Bend { .. } => [v, 0.0],
        }
    }

    /// Position \[m\] and normal times dA/du dv \[m²\].
    #[inline(always)]
    pub(super) fn point(&self, u: Line, v: Line) -> (DVec3, DVec3) {
        match *self {
            Chart::Ellipsoid { centre, semi_axes, face } => {
                let d = match face {
                    0 => DVec3::new(1.0, u[0], v[0]),
                    1 => DVec3::new(v[0], 1.0, u[0]),
                    _ => DVec3::new(u[0], v[0], 1.0),
                };
                let inverse = 1.0 / d.length_squared();
                let cofactors = semi_axes.element_product() / semi_axes;
                let area = u[1] * v[1] * inverse * inverse;
                (centre + semi_axes * d * inverse.sqrt(), cofactors * d * area)
            }
            Chart::Flat { corner, first, second } => {
                (corner + u[0] * first + v[0] * second, first.cross(second))
            }
            Chart::Bend { start, along, radius, from, to } => {
                let normal = u[1] * from + u[0] * to;
                (start + v[0] * along + radius * normal, normal * (FRAC_PI_2 * radius * along.length()))
            }
        }
    }

    /// Position \[m\] at (u, v).
    pub(super) fn position(&self, u: f64, v: f64) -> DVec3 {
        self.point(self.line_u(u), self.line_v(v)).0
    }
}

/// tan πu/4 and its derivative.
fn tangent(u: f64) -> Line {
    let t = (FRAC_PI_4 * u).tan();
    [t, FRAC_PI_4 * (1.0 + t * t)]
}

/// A rectangle of a chart, with its nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Patch {
    /// The chart.
    pub(super) chart: Chart,
    /// Range of u.
    pub(super) u: [f64; 2],
    /// Range of v.
    pub(super) v: [f64; 2],
    /// Nodes along u and along v.
    pub(super) nodes: [usize; 2],
}

/// A rectangle of parameters with its centre and its size in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent {
    /// The middle \[m\].
    pub(super) centre: DVec3,
    /// Distance of the farthest corner from it \[m\].
    pub(super) radius: f64,
    /// Length along u, through the middle \[m\].
    pub(super) length_u: f64,
    /// Length along v, through the middle \[m\].
    pub(super) length_v: f64,
}

impl Patch {
    /// Number of nodes.
    pub(super) fn count(&self) -> usize {
        self.nodes[0] * self.nodes[1]
    }

    /// Position and size of a rectangle of the chart.
    pub(super) fn extent(&self, u: [f64; 2], v: [f64; 2]) -> Extent {
        let chart = &self.chart;
        let lines_u = [u[0], 0.5 * (u[0] + u[1]), u[1]].map(|u| chart.line_u(u));
        let lines_v = [v[0], 0.5 * (v[0] + v[1]), v[1]].map(|v| chart.line_v(v));
        let at = |i: usize, j: usize| chart.point(lines_u[i], lines_v[j]).0;
        let centre = at(1, 1);
        let radius = [(0, 0), (2, 0), (0, 2), (2, 2)]
            .map(|(i, j)| at(i, j).distance(centre))
            .into_iter()
            .fold(0.0, f64::max);
        Extent {
            centre,
            radius,
            length_u: at(0, 1).distance(centre) + at(2, 1).distance(centre),
            length_v: at(1, 0).distance(centre) + at(1, 2).distance(centre),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_are_the_cross_products_of_the_tangents() {
        let charts = [
            Chart::Ellipsoid {
                centre: DVec3::new(0.1, 0.2, 0.3),
                semi_axes: DVec3::new(1.0, 0.6, 0.3),
                face: 0,
            },
            Chart::Ellipsoid { centre: DVec3::ZERO, semi_axes: DVec3::new(1.0, 0.6, 0.3), face: 1 },
            Chart::Ellipsoid { centre: DVec3::ZERO, semi_axes: DVec3::new(1.0, 0.6, 0.3), face: 2 },
            Chart::Flat { corner: DVec3::Z, first: 0.4 * DVec3::X, second: 0.7 * DVec3::Y },
            Chart::Bend {
                start: DVec3::ONE,
                along: 2.0 * DVec3::Z,
                radius: 0.3,
                from: DVec3::X,
                to: DVec3::Y,
            },
        ];
        for chart in charts {
            for (u, v) in [(0.1, 0.8), (0.5, 0.4), (0.9, 0.95)] {
                let h = 1e-5;
                let along_u = (chart.position(u + h, v) - chart.position(u - h, v)) / (2.0 * h);
                let along_v = (chart.position(u, v + h) - chart.position(u, v - h)) / (2.0 * h);
                let (_, area) = chart.point(chart.line_u(u), chart.line_v(v));
                // Residual seen: 2e-11, of the differences.
                assert!((area - along_u.cross(along_v)).length() < 1e-8, "{chart:?} {area}");
            }
        }
    }
}
