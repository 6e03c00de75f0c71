//! Which points of two surfaces stand for the area where they touch: its corners.
//!
//! A body that lies on a face, an edge or a rim is held at the corners of the area that touches, seen along
//! its normal. A point within the area takes load only where the surfaces bulge there, so that it is the
//! deepest; of an area that is level, an impulse in its middle would strike the soft place of a plate.

use glam::DVec3;

use super::touch::Touch;

/// Points that are kept; a power of two spreads them evenly on a rim.
const KEPT: usize = 16;
/// Share of the extent of an area that its corners stand out by.
const STANDS_OUT: f64 = 1e-4;
/// Share of the extent of an area that gaps differ by where it is level: rounding.
const LEVEL: f64 = 1e-6;

/// Points of an area: the deepest, and those of its corners that are farthest from the ones before.
pub(super) fn spread(found: Vec<Touch>) -> Vec<Touch> {
    let deepest = |of: &[Touch]| of.iter().min_by(|a, b| a.gap.total_cmp(&b.gap)).copied();
    let Some(first) = deepest(&found) else { return found };
    let extent = found.iter().map(|touch| touch.point.distance(first.point)).fold(0.0, f64::max);
    let corners = outermost(found, STANDS_OUT * extent);
    // A point within the area only if it is truly deeper: all points of a foot that stands are.
    let level = deepest(&corners).filter(|corner| corner.gap <= first.gap + LEVEL * extent);
    let mut kept = vec![level.unwrap_or(first)];
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

/// The corners of an area of points, seen along their mean normal, that stand out by `least` \[m\].
fn outermost(mut found: Vec<Touch>, least: f64) -> Vec<Touch> {
    let normal = found.iter().map(|touch| touch.normal).sum::<DVec3>();
    let Some(normal) = normal.try_normalize() else { return found };
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
    fn an_edge_keeps_its_ends_and_nothing_stays_nothing() {
        let edge = spread((0..9).map(|k| touch(0.001 * f64::from(k), 0.002, 1e-5)).collect());
        assert_eq!(edge.iter().map(|t| t.point.x).fold(0.0, f64::max), 0.008);
        assert_eq!(edge.len(), 2, "{edge:?}");
        assert_eq!(spread(vec![touch(1.0, 2.0, 3.0)]).len(), 1);
        assert!(spread(Vec::new()).is_empty());
    }
}
