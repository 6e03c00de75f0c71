//! Pairs of balls that overlap, by a sweep along the axis on which their centres are spread farthest.
//!
//! ```text
//! |a − b| < r_a + r_b        only if the intervals [a_x − r_a, a_x + r_a] and [b_x − r_b, b_x + r_b] overlap
//! ```
//!
//! Takes n log n steps, and one for each two balls whose intervals overlap on that axis: few for bodies that
//! lie side by side, all of them for bodies within one large ball.

use std::ops::ControlFlow;

use glam::DVec3;

/// A ball about a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ball {
    /// \[m\].
    pub(super) centre: DVec3,
    /// \[m\].
    pub(super) radius: f64,
}

/// Calls `visit` with the places of every two balls that overlap, the smaller place first, until it breaks.
/// Gives the number of pairs whose distance was measured.
pub(super) fn overlapping(balls: &[Ball], visit: &mut dyn FnMut([usize; 2]) -> ControlFlow<()>) -> u64 {
    let axis = widest_axis(balls);
    let low = |place: usize| balls[place].centre[axis] - balls[place].radius;
    let mut order: Vec<usize> = (0..balls.len()).collect();
    order.sort_by(|a, b| low(*a).total_cmp(&low(*b)).then(a.cmp(b)));
    let mut measured = 0;
    for (at, &one) in order.iter().enumerate() {
        let Ball { centre, radius } = balls[one];
        let high = centre[axis] + radius;
        for &two in order[at + 1..].iter().take_while(|two| low(**two) < high) {
            let other = balls[two];
            measured += 1;
            let reach = radius + other.radius;
            if centre.distance_squared(other.centre) < reach * reach
                && visit([one.min(two), one.max(two)]).is_break()
            {
                return measured;
            }
        }
    }
    measured
}

/// The axis along which the centres have the largest variance.
fn widest_axis(balls: &[Ball]) -> usize {
    let count = balls.len().max(1) as f64;
    let mean = balls.iter().map(|ball| ball.centre).sum::<DVec3>() / count;
    let variance = balls.iter().map(|ball| (ball.centre - mean) * (ball.centre - mean)).sum::<DVec3>();
    variance.max_position()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Balls at places that no two axes share.
    fn scattered(count: u32, size: f64) -> Vec<Ball> {
        let share = |k: u32, ratio: f64| (f64::from(k) * ratio).fract();
        let ball = |k: u32| Ball {
            centre: DVec3::new(share(k, 0.618_034), 2.0 * share(k, 0.414_214), 0.5 * share(k, 0.732_051)),
            radius: size * (0.2 + share(k, 0.302_776)),
        };
        (1..=count).map(ball).collect()
    }

    fn found(balls: &[Ball]) -> (Vec<[usize; 2]>, u64) {
        let mut pairs = Vec::new();
        let measured = overlapping(balls, &mut |pair| {
            pairs.push(pair);
            ControlFlow::Continue(())
        });
        pairs.sort_unstable();
        (pairs, measured)
    }

    #[test]
    fn the_pairs_are_those_of_all_comparisons() {
        for size in [0.01, 0.05, 0.3, 3.0] {
            let balls = scattered(300, size);
            let all = (0..balls.len()).flat_map(|a| (a + 1..balls.len()).map(move |b| [a, b]));
            let overlaps = |[a, b]: &[usize; 2]| {
                balls[*a].centre.distance(balls[*b].centre) < balls[*a].radius + balls[*b].radius
            };
            let expected: Vec<[usize; 2]> = all.filter(overlaps).collect();
            assert!(!expected.is_empty() || size < 0.02);
            assert_eq!(found(&balls).0, expected, "{size}");
        }
    }

    #[test]
    fn ten_thousand_balls_side_by_side_are_not_compared_in_pairs() {
        // On a floor, in a row, and in a tower.
        let radius = 0.009;
        let at = |k: u32, width: u32| DVec3::new(f64::from(k % width), f64::from(k / width), 0.0) * 0.02;
        let floor = |k: u32| at(k, 100);
        let row = |k: u32| at(k, 10_000);
        let tower = |k: u32| at(k, 1);
        // Seen: 495 000 on the floor, none in a row and in a tower.
        let cases: [(&dyn Fn(u32) -> DVec3, u64); 3] = [(&floor, 1_000_000), (&row, 0), (&tower, 0)];
        for (place, most) in cases {
            let balls: Vec<Ball> = (0..10_000).map(|k| Ball { centre: place(k), radius }).collect();
            let (pairs, measured) = found(&balls);
            assert!(pairs.is_empty());
            assert!(measured <= most, "{measured} of 49 995 000 pairs");
        }
    }
}
