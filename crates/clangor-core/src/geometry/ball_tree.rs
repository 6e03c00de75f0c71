//! Balls in a tree, such as the bounding balls of bodies: which is nearest to a point, and which are near it.
//!
//! A balanced k-d tree over the centres, in which every node knows the box of its centres and its largest
//! radius. A query costs the logarithm of the number of balls, as long as few of them are near the point.

use std::ops::ControlFlow;

use glam::DVec3;

/// BallTree below which a node is not divided.
const LEAF: usize = 8;

/// A ball.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    /// Its centre \[m\].
    pub centre: DVec3,
    /// Its radius \[m\].
    pub radius: f64,
    /// What it bounds: the index of a body.
    pub body: usize,
}

#[derive(Debug)]
struct Node {
    low: DVec3,
    high: DVec3,
    max_radius: f64,
    first: usize,
    count: usize,
    /// Nodes of the halves.
    halves: Option<[usize; 2]>,
}

impl Node {
    /// No ball of the node is nearer to a point than this.
    fn least_gap(&self, point: DVec3) -> f64 {
        (point - point.clamp(self.low, self.high)).length() - self.max_radius
    }
}

/// BallTree in a tree.
pub struct BallTree {
    balls: Vec<Ball>,
    nodes: Vec<Node>,
}

impl BallTree {
    /// A tree of balls.
    pub fn new(balls: Vec<Ball>) -> Self {
        let count = balls.len();
        let mut tree = BallTree { balls, nodes: Vec::new() };
        if count > 0 {
            tree.divide(0, count);
        }
        tree
    }

    fn divide(&mut self, first: usize, count: usize) -> usize {
        let balls = &mut self.balls[first..first + count];
        let low = balls.iter().fold(DVec3::INFINITY, |low, ball| low.min(ball.centre));
        let high = balls.iter().fold(DVec3::NEG_INFINITY, |high, ball| high.max(ball.centre));
        let max_radius = balls.iter().fold(0.0, |most: f64, ball| most.max(ball.radius));
        let index = self.nodes.len();
        self.nodes.push(Node { low, high, max_radius, first, count, halves: None });
        if count > LEAF {
            let axis = (high - low).max_position();
            let half = count / 2;
            self.balls[first..first + count]
                .select_nth_unstable_by(half, |a, b| a.centre[axis].total_cmp(&b.centre[axis]));
            let halves = [self.divide(first, half), self.divide(first + half, count - half)];
            self.nodes[index].halves = Some(halves);
        }
        index
    }

    /// Distance of a point from the nearest ball, 0 inside, as far as it is below `most`; else `most`.
    pub fn nearest_gap(&self, point: DVec3, most: f64) -> f64 {
        let mut nearest = most;
        let mut waiting = if self.nodes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(node) = waiting.pop() {
            let node = &self.nodes[node];
            if nearest <= 0.0 || node.least_gap(point) >= nearest {
                continue;
            }
            match node.halves {
                Some([a, b]) => {
                    let a_is_nearer = self.nodes[a].least_gap(point) <= self.nodes[b].least_gap(point);
                    waiting.extend(if a_is_nearer { [b, a] } else { [a, b] });
                }
                None => {
                    for ball in &self.balls[node.first..node.first + node.count] {
                        nearest = nearest.min(((point - ball.centre).length() - ball.radius).max(0.0));
                    }
                }
            }
        }
        nearest
    }

    /// Calls `visit` with the body of each ball whose surface is at most `reach` from a point, until it
    /// breaks.
    pub fn near(&self, point: DVec3, reach: f64, mut visit: impl FnMut(usize) -> ControlFlow<()>) {
        let mut waiting = if self.nodes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(node) = waiting.pop() {
            let node = &self.nodes[node];
            if node.least_gap(point) > reach {
                continue;
            }
            if let Some(halves) = node.halves {
                waiting.extend(halves);
                continue;
            }
            for ball in &self.balls[node.first..node.first + node.count] {
                let is_near = (point - ball.centre).length() - ball.radius <= reach;
                if is_near && visit(ball.body).is_break() {
                    return;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix;

    #[test]
    fn the_tree_finds_what_a_search_of_all_balls_finds() {
        let mut random = SplitMix::new(3);
        let mut point = || DVec3::from_array(std::array::from_fn(|_| random.uniform(-1.0, 1.0)));
        let balls: Vec<Ball> =
            (0..500).map(|body| Ball { centre: point(), radius: 0.1 * point().x.abs(), body }).collect();
        let tree = BallTree::new(balls.clone());
        for _ in 0..500 {
            let at = point() * 1.5;
            let gap = |ball: &Ball| ((at - ball.centre).length() - ball.radius).max(0.0);
            let nearest = balls.iter().map(gap).fold(10.0, f64::min);
            assert_eq!(tree.nearest_gap(at, 10.0), nearest);
            let mut holding = Vec::new();
            tree.near(at, 0.0, |body| {
                holding.push(body);
                ControlFlow::Continue(())
            });
            holding.sort_unstable();
            let expected: Vec<usize> = balls.iter().filter(|b| gap(b) == 0.0).map(|b| b.body).collect();
            assert_eq!(holding, expected);
        }
        assert_eq!(BallTree::new(Vec::new()).nearest_gap(DVec3::ZERO, 7.0), 7.0);
    }
}
