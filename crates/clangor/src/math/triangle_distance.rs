//! Distance of a point from a triangle: the face, an edge or a corner, whichever is nearest.

use glam::DVec3;

/// Distance [m] of `point` from the triangle with these corners, which may be degenerate.
pub(crate) fn triangle_distance(point: DVec3, corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    let inside = |from: DVec3, to: DVec3| normal.cross(to - from).dot(point - from) >= 0.0;
    if normal != DVec3::ZERO && inside(a, b) && inside(b, c) && inside(c, a) {
        return (point - a).dot(normal.normalize()).abs();
    }
    let to_edge = |from: DVec3, to: DVec3| {
        let edge = to - from;
        let place = (point - from).dot(edge) / edge.length_squared();
        let place = if place.is_finite() { place.clamp(0.0, 1.0) } else { 0.0 };
        (point - from - edge * place).length()
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_is_face_edge_or_corner() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let at = |x, y, z| triangle_distance(DVec3::new(x, y, z), corners);
        assert_eq!(at(0.25, 0.25, -2.0), 2.0);
        assert_eq!(at(0.5, -3.0, 4.0), 5.0);
        assert_eq!(at(-3.0, -4.0, 0.0), 5.0);
        // Seen: equal to the last bit or one off it.
        assert!((at(1.0, 1.0, 0.0) - 0.5f64.sqrt()).abs() < 1e-15);
        assert_eq!(triangle_distance(DVec3::Z, [DVec3::ZERO; 3]), 1.0);
    }
}
