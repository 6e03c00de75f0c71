//! Convex polygons, clipped by planes across the axes.

use glam::DVec3;

/// Most corners of a clipped triangle.
const CORNERS: usize = 9;

/// A convex polygon.
#[derive(Clone, Copy)]
pub(super) struct Polygon {
    corners: [DVec3; CORNERS],
    count: usize,
}

impl Polygon {
    pub(super) fn triangle([a, b, c]: [DVec3; 3]) -> Self {
        let mut corners = [DVec3::ZERO; CORNERS];
        corners[..3].copy_from_slice(&[a, b, c]);
        Polygon { corners, count: 3 }
    }

    pub(super) fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    pub(super) fn is_empty(&self) -> bool {
        self.count < 3
    }

    /// The part from `low` to `low` + 1 along an axis.
    pub(super) fn between(&self, axis: usize, low: f64) -> Self {
        self.clipped(axis, low, 1.0).clipped(axis, low + 1.0, -1.0)
    }

    /// The part above a plane for side 1, below it for side −1.
    pub(super) fn clipped(&self, axis: usize, plane: f64, side: f64) -> Self {
        let mut part = Polygon { corners: [DVec3::ZERO; CORNERS], count: 0 };
        let mut push = |corner: DVec3| {
            part.corners[part.count] = corner;
            part.count += 1;
        };
        let corners = self.corners();
        for (n, here) in corners.iter().enumerate() {
            let next = corners[(n + 1) % corners.len()];
            let (a, b) = (side * (here[axis] - plane), side * (next[axis] - plane));
            if a >= 0.0 {
                push(*here);
            }
            if (a >= 0.0) != (b >= 0.0) {
                let mut cut = *here + a / (a - b) * (next - *here);
                cut[axis] = plane;
                push(cut);
            }
        }
        part
    }

    /// Lowest and highest coordinates; those of no polygon are infinite.
    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        self.corners().iter().fold(none, |(low, high), x| (low.min(*x), high.max(*x)))
    }

    /// Centre of area, and area.
    pub(super) fn middle_and_area(&self) -> (DVec3, f64) {
        let corners = self.corners();
        let (mut moment, mut total) = (DVec3::ZERO, 0.0);
        for k in 1..corners.len().max(2) - 1 {
            let [a, b, c] = [corners[0], corners[k], corners[k + 1]];
            let area = 0.5 * (b - a).cross(c - a).length();
            moment += area / 3.0 * (a + b + c);
            total += area;
        }
        let middle = if total > 0.0 { moment / total } else { corners.first().copied().unwrap_or_default() };
        (middle, total)
    }
}
