//! Sharp corners of a line of many short segments: the cut through a mesh of a disc, a ring, a cone or a
//! stepped shaft has long straight runs between them.
//!
//! The line is first simplified (Ramer 1972, Douglas and Peucker 1973); a point that is left is a corner if
//! the
//! line turns sharply there, between runs that are long for the wall or few in number.

use std::ops::Range;

use glam::DVec2;

/// Least angle of a corner \[rad\].
const SHARP: f64 = 0.35;
/// Least length of the straight runs on both sides, over the thickness of the wall.
const LONG: f64 = 0.8;
/// Number of straight runs up to which all of them count as long.
const FEW: usize = 12;

/// A line of which the straight runs are known.
pub(super) struct StraightRuns {
    /// Indices of the points where straight runs end, ascending, the ends of the line included.
    ends: Vec<usize>,
    /// Which of these are corners: positions in `ends`.
    corners: Vec<usize>,
}

impl StraightRuns {
    /// Of a line, closed if its last point repeats its first, which must then be one of its extremes. Runs
    /// are
    /// straight to within `tolerance`.
    pub(super) fn of(points: &[DVec2], closed: bool, tolerance: f64, wall: f64) -> Self {
        let last = points.len() - 1;
        let mut ends = vec![0];
        if closed {
            // The two halves of a loop have ends of their own.
            let far = (0..=last).max_by(|a, b| {
                points[*a].distance_squared(points[0]).total_cmp(&points[*b].distance_squared(points[0]))
            });
            let far = far.unwrap_or(last);
            simplify(points, 0..far, tolerance, &mut ends);
            simplify(points, far..last, tolerance, &mut ends);
        } else {
            simplify(points, 0..last, tolerance, &mut ends);
        }
        let mut runs = StraightRuns { ends, corners: Vec::new() };
        runs.corners = runs.find_corners(points, closed, wall);
        runs
    }

    fn find_corners(&self, points: &[DVec2], closed: bool, wall: f64) -> Vec<usize> {
        let count = self.ends.len();
        let along = |k: usize| points[self.ends[k + 1]] - points[self.ends[k]];
        let few = count <= FEW + 1;
        let is_corner = |before: usize, after: usize| {
            let (u, v) = (along(before), along(after));
            let long = few || u.length().min(v.length()) >= LONG * wall;
            long && u.angle_to(v).abs() >= SHARP
        };
        let inner = (1..count - 1).filter(|k| is_corner(k - 1, *k));
        let first = (closed && count > 2 && is_corner(count - 2, 0)).then_some(0);
        first.into_iter().chain(inner).collect()
    }

    /// Indices of the points that are corners, ascending.
    pub(super) fn corners(&self) -> impl Iterator<Item = usize> {
        self.corners.iter().map(|k| self.ends[*k])
    }

    /// The straight run that ends, and the one that starts, at a point where runs meet; around the start of a
    /// loop too.
    pub(super) fn beside(&self, point: usize) -> [Option<Range<usize>>; 2] {
        let count = self.ends.len();
        let Some(k) = self.ends.iter().position(|end| *end == point) else { return [None, None] };
        let run = |k: usize| self.ends.get(k).copied().zip(self.ends.get(k + 1).copied()).map(|(a, b)| a..b);
        [if k == 0 { run(count - 2) } else { run(k - 1) }, if k + 1 == count { run(0) } else { run(k) }]
    }

    /// Whether two ends of runs bound one straight run.
    pub(super) fn is_straight(&self, from: usize, to: usize) -> bool {
        self.ends.windows(2).any(|pair| pair == [from, to])
    }
}

/// Appends the indices in (start, end] at which straight runs end.
fn simplify(points: &[DVec2], range: Range<usize>, tolerance: f64, ends: &mut Vec<usize>) {
    let mut stack = vec![range];
    while let Some(Range { start, end }) = stack.pop() {
        let (from, along) = (points[start], (points[end] - points[start]).normalize_or_zero());
        let off = |k: &usize| along.perp_dot(points[*k] - from).abs();
        match (start + 1..end).max_by(|a, b| off(a).total_cmp(&off(b))) {
            Some(k) if off(&k) > tolerance => stack.extend([k..end, start..k]),
            _ => ends.push(end),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_corners_of_a_flat_ring_are_found_and_those_of_a_circle_are_not() {
        let corners = [[0.2, 0.0], [1.0, 0.0], [1.0, 0.05], [0.2, 0.05], [0.2, 0.0]].map(DVec2::from_array);
        let mut ring: Vec<DVec2> =
            corners.windows(2).flat_map(|w| (0..10).map(|k| w[0].lerp(w[1], f64::from(k) / 10.0))).collect();
        ring.push(ring[0]);
        let runs = StraightRuns::of(&ring, true, 5e-4, 0.05);
        assert_eq!(runs.corners().collect::<Vec<_>>(), [0, 10, 20, 30]);
        assert!(runs.is_straight(10, 20) && !runs.is_straight(0, 20));
        assert_eq!(runs.beside(0), [Some(30..40), Some(0..10)]);
        let circle: Vec<DVec2> = (0..=100).map(|k| DVec2::from_angle(f64::from(k % 100) * 0.0628)).collect();
        assert_eq!(StraightRuns::of(&circle, true, 1e-3, 1.0).corners().count(), 0);
    }
}
