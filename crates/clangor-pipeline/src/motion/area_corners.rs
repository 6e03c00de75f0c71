//! Which points of two surfaces stand for the areas where they touch: the corners of these areas.
//!
//! A body that lies on a face, an edge or a rim is held at the corners of the area that touches, seen along
//! its normal. A point within the area takes load only where the surfaces bulge there, so that it is the
//! deepest. Of an area that is level, an impulse in its middle would strike the soft place of a plate.
//!
//! Points whose normals lie within 26° of that of the deepest are one area; the rest are others, as the floor
//! and the walls of a tray are.

use glam::DVec3;

use super::touch::Touch;

/// Points that are kept; a power of two spreads them evenly on a rim.
const KEPT: usize = 16;
/// Least cosine between the normals of an area and that of its deepest point.
const ONE_AREA: f64 = 0.9;
/// Share of the extent of all areas that corners stand out by.
const STANDS_OUT: f64 = 1e-4;
/// Share of that extent by which gaps differ where an area is level: rounding.
const LEVEL: f64 = 1e-6;

/// The deepest point of each area, and those of their corners that are farthest from the ones before.
pub(super) fn spread(mut found: Vec<Touch>) -> Vec<Touch> {
    found.sort_by(|a, b| a.gap.total_cmp(&b.gap));
    let Some(first) = found.first().copied() else { return found };
    let extent = found.iter().map(|touch| touch.point.distance(first.point)).fold(0.0, f64::max);
    let (mut kept, mut corners) = (Vec::new(), Vec::new());
    while let Some(deepest) = found.first().copied() {
        let (area, rest) = found.into_iter().partition(|t| t.normal.dot(deepest.normal) > ONE_AREA);
        found = rest;
        let own = outermost(area, deepest.normal, STANDS_OUT * extent);
        // A point within the area only if it is truly deeper: all points of a foot that stands are.
        let level = own.iter().min_by(|a, b| a.gap.total_cmp(&b.gap));
        let level = level.filter(|corner| corner.gap <= deepest.gap + LEVEL * extent);
        kept.push(level.copied().unwrap_or(deepest));
        corners.extend(own);
    }
    kept.truncate(KEPT);
    while kept.len() < KEPT {
        let far =
            |touch: &Touch| kept.iter().map(|k| k.point.distance(touch.point)).fold(f64::INFINITY, f64::min);
        let Some(next) = corners.iter().max_by(|a, b| far(a).total_cmp(&far(b))).copied() else { break };
        if far(&next) <= 0.0 {
            break;
        }
        kept.push(next);
    }
    kept
}

/// The corners of an area of points, seen along a normal, that stand out by `least` \[m\].
fn outermost(mut found: Vec<Touch>, normal: DVec3, least: f64) -> Vec<Touch> {
    let (along, aside) = normal.any_orthonormal_pair();
    let place = |touch: &Touch| [touch.point.dot(along), touch.point.dot(aside)];
    found.sort_by(|a, b| {
        let ([a, c], [b, d]) = (place(a), place(b));
        a.total_cmp(&b).then(c.total_cmp(&d))
    });
    // How far b lies to the right of the line from a to c.
    let right = |a: &Touch, b: &Touch, c: &Touch| {
        let ([ax, ay], [bx, by], [cx, cy]) = (place(a), place(b), place(c));
        let (dx, dy) = (cx - ax, cy - ay);
        (dy * (bx - ax) - dx * (by - ay)) / dx.hypot(dy).max(f64::MIN_POSITIVE)
    };
    let half = |points: &mut dyn Iterator<Item = &Touch>| {
        let mut chain: Vec<Touch> = Vec::new();
        for touch in points {
            while let [.., a, b] = chain[..]
                && right(&a, &b, touch) <= least
            {
                chain.pop();
            }
            chain.push(*touch);
        }
        chain
    };
    let mut hull = half(&mut found.iter());
    hull.pop();
    hull.extend(half(&mut found.iter().rev()));
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touch(x: f64, z: f64, gap: f64) -> Touch {
        Touch { point: DVec3::new(x, 0.0, z), normal: DVec3::Y, gap }
    }

    #[test]
    fn a_level_square_has_four_corners_and_a_bulge_its_middle() {
        let square = |bulge: f64| {
            let at = |k: i32| f64::from(k) * 0.01;
            let place =
                |k: i32| touch(at(k % 5 - 2), at(k / 5 - 2), 1e-5 - if k == 12 { bulge } else { 0.0 });
            spread((0..25).map(place).collect())
        };
        let level = square(1e-9);
        assert_eq!(level.len(), 4, "{level:?}");
        assert!(level.iter().all(|t| t.point.x.abs() == 0.02 && t.point.z.abs() == 0.02), "{level:?}");
        let bulged = square(1e-6);
        assert_eq!((bulged.len(), bulged[0].point), (5, DVec3::ZERO), "{bulged:?}");
    }

    #[test]
    fn a_rim_of_many_points_keeps_some_evenly() {
        let place = |k: u32| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 128.0).sin_cos();
            touch(0.042 * cos, 0.042 * sin, 0.0)
        };
        let kept = spread((0..128).map(place).collect());
        let sum: DVec3 = kept.iter().map(|t| t.point).sum();
        assert_eq!(kept.len(), KEPT);
        // Seen: 1e-18 m.
        assert!(sum.length() < 1e-12, "{sum}");
    }

    #[test]
    fn the_floor_and_the_walls_of_a_tray_keep_their_own_corners() {
        // A cube in the corner of a tray: nine points of its bottom at gap 0, six on each wall at 0.2 mm.
        let mut found: Vec<Touch> =
            (0..9).map(|k| touch(0.05 * f64::from(k % 3), 0.05 * f64::from(k / 3), 0.0)).collect();
        let on_wall = |k: i32, along: DVec3, normal: DVec3| {
            let point = along * (0.05 * f64::from(k % 3)) + DVec3::Y * (0.1 * f64::from(k / 3));
            Touch { point: point - normal * 1e-4, normal, gap: 2e-4 }
        };
        found.extend((0..6).map(|k| on_wall(k, DVec3::Z, DVec3::X)));
        found.extend((0..6).map(|k| on_wall(k, DVec3::X, DVec3::Z)));
        let kept = spread(found);
        let of = |normal: DVec3| kept.iter().filter(|t| t.normal == normal).count();
        assert_eq!([DVec3::Y, DVec3::X, DVec3::Z].map(of), [4, 4, 4], "{kept:?}");
    }

    #[test]
    fn a_peg_in_a_hole_is_held_all_around() {
        let on_rim = |k: u32| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 100.0).sin_cos();
            Touch { point: DVec3::new(cos, 0.0, sin) * 0.01, normal: DVec3::new(-cos, 0.0, -sin), gap: 1e-5 }
        };
        let kept = spread((0..100).map(on_rim).collect());
        let sum: DVec3 = kept.iter().map(|t| t.normal).sum();
        assert!(kept.len() > 8 && sum.length() < 2.0, "{} {sum}", kept.len());
    }

    #[test]
    fn an_edge_keeps_its_ends_and_nothing_stays_nothing() {
        let edge = spread((0..9).map(|k| touch(0.001 * f64::from(k), 0.002, 1e-5)).collect());
        assert_eq!(edge.iter().map(|t| t.point.x).fold(0.0, f64::max), 0.008);
        assert_eq!(edge.len(), 2, "{edge:?}");
        assert_eq!(spread(vec![touch(1.0, 2.0, 3.0)]).len(), 1);
        assert!(spread(Vec::new()).is_empty());
    }
}
