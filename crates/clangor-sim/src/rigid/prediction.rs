//! Predicted impacts of a step, in the order of their times.
//!
//! For every contact point the first root t* of its gap is predicted from the flight of the two bodies. The
//! prediction is then refined by Newton steps on the exact distance of the shapes at the predicted poses.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::collision_scene::Scene;
use super::impact_threshold::{MAX_HITS, bend, rest_speed};
use super::pair::{Pair, Step};

/// A predicted time is exact when a refinement moves it by less \[s\].
const EXACT: f64 = 1e-11;
/// Refinements of one prediction at most.
const MAX_REFINEMENTS: u32 = 30;
/// An overlap at the middle of the step beyond this means that the bodies passed each other \[m\].
const PASSED: f64 = 1e-5;

/// A predicted impact.
#[derive(PartialEq)]
pub(super) struct Candidate {
    pub(super) time: f64,
    pub(super) speed: f64,
    pub(super) pair: usize,
    pub(super) stamp: u32,
    pub(super) exact: bool,
}

impl Eq for Candidate {}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Candidate {
    /// The earliest is the greatest; then the fastest, then the first pair.
    fn cmp(&self, other: &Self) -> Ordering {
        (other.time.total_cmp(&self.time))
            .then(self.speed.total_cmp(&other.speed))
            .then(other.pair.cmp(&self.pair))
            .then(self.stamp.cmp(&other.stamp))
            .then(self.exact.cmp(&other.exact))
    }
}

/// The predicted impacts of a step; the earliest comes first.
#[derive(Default)]
pub(super) struct Predictions {
    heap: BinaryHeap<Candidate>,
}

impl Predictions {
    /// Forgets all predictions.
    pub(super) fn clear(&mut self) {
        self.heap.clear();
    }

    /// Removes the earliest prediction.
    pub(super) fn pop(&mut self) -> Option<Candidate> {
        self.heap.pop()
    }

    /// The earliest prediction.
    pub(super) fn peek(&self) -> Option<&Candidate> {
        self.heap.peek()
    }

    /// Predicts the first impact of a pair, slightly early where rotation bends the paths of its points.
    pub(super) fn predict(&mut self, scene: &Scene<'_>, index: usize) {
        let (pair, step) = (&scene.pairs[index], &scene.step);
        if pair.hits > MAX_HITS {
            return;
        }
        let (a, b) = pair.bodies(scene.bodies);
        if !a.is_awake() && !b.is_awake() {
            return;
        }
        let start = a.last_hit.max(b.last_hit);
        let fall = (a.gravity(step.gravity) - b.gravity(step.gravity)).dot(pair.normal);
        let rest = rest_speed(&pair.coefficients.restitution, step);
        let away = pair.reference.max(step.length - pair.reference);
        let bend = bend(a, b);
        let (early, faster) = (bend * away * away, bend * away);
        let mut first: Option<(f64, f64)> = None;
        // Earliest root over the points; simultaneous roots are ordered by approach speed.
        for point in &pair.points {
            let speed = (a.velocity + a.angular_velocity.cross(point.arm_a)
                - b.velocity
                - b.angular_velocity.cross(point.arm_b))
            .dot(pair.normal);
            if speed > (fall * step.length).abs() + faster - rest {
                continue;
            }
            let gap = point.gap - early;
            // gap(t) = gap + speed (t − reference) + fall t²/2
            let passed = pair.stamp == 0 && gap < -PASSED;
            let at_start = gap + speed * (start - pair.reference) + 0.5 * fall * start * start;
            let time = if at_start <= 0.0 || passed {
                start
            } else {
                match first_root(0.5 * fall, speed, gap - speed * pair.reference) {
                    Some(root) => root.max(start),
                    None => continue,
                }
            };
            let approach = faster - (speed + fall * time);
            if time >= step.length || approach <= rest {
                continue;
            }
            if first.is_none_or(|(t, s)| time < t || (time == t && approach > s)) {
                first = Some((time, approach));
            }
        }
        if let Some((time, speed)) = first {
            self.heap.push(Candidate { time, speed, pair: index, stamp: pair.stamp, exact: false });
        } else if pair.rolls_on_rim {
            self.probe_end(index, pair, step);
        }
    }

    /// Starts a search from the end of the step. The lowest point of a tilting cylinder moves along its rim,
    /// so the present points do not predict it. Its height is concave in time: the height at the end of the
    /// step decides whether there is a root, and Newton's method finds the root from there.
    fn probe_end(&mut self, index: usize, pair: &Pair, step: &Step) {
        let end = Candidate { time: step.length, speed: 0.0, pair: index, stamp: pair.stamp, exact: false };
        self.heap.push(end);
    }

    /// Computes the manifold at the predicted instant and predicts again from there.
    pub(super) fn refine(&mut self, scene: &mut Scene<'_>, candidate: &Candidate) {
        let step = scene.step;
        let pair = &mut scene.pairs[candidate.pair];
        pair.find_exactly(scene.bodies, scene.shapes, &step, candidate.time, scene.scratch);
        pair.refinements += 1;
        let (a, b) = pair.bodies(scene.bodies);
        let start = a.last_hit.max(b.last_hit);
        let normal = pair.exact.normal;
        let fall = (a.gravity(step.gravity) - b.gravity(step.gravity)).dot(normal);
        let rest = rest_speed(&pair.coefficients.restitution, &step);
        let now_a = a.at(step.time, step.length, candidate.time, a.gravity(step.gravity));
        let now_b = b.at(step.time, step.length, candidate.time, b.gravity(step.gravity));
        let mut first: Option<(f64, f64)> = None;
        // On a rim only the first point, the lowest, is on the curve whose root is sought.
        let relevant = if pair.rolls_on_rim { 1 } else { usize::MAX };
        for point in pair.exact.points.iter().take(relevant) {
            let middle = (point.on_a + point.on_b) * 0.5;
            let speed = (now_a.velocity_at(middle - now_a.position)
                - now_b.velocity_at(middle - now_b.position))
            .dot(normal);
            let back = start - candidate.time;
            let at_start = point.gap + speed * back + 0.5 * fall * back * back;
            let delay = if at_start <= 0.0 {
                back
            } else {
                match first_root(0.5 * fall, speed, point.gap) {
                    Some(delay) => delay.max(back),
                    None => continue,
                }
            };
            let approach = -(speed + fall * delay);
            if approach <= rest {
                continue;
            }
            if first.is_none_or(|(d, s)| delay < d || (delay == d && approach > s)) {
                first = Some((delay, approach));
            }
        }
        let Some((delay, speed)) = first else {
            if pair.rolls_on_rim && candidate.time < step.length {
                let pair = &scene.pairs[candidate.pair];
                self.probe_end(candidate.pair, pair, &step);
            }
            return;
        };
        let exact = delay.abs() <= EXACT || pair.refinements >= MAX_REFINEMENTS;
        let time = if exact { candidate.time } else { candidate.time + delay };
        if time < step.length {
            self.heap.push(Candidate { time, speed, pair: candidate.pair, stamp: pair.stamp, exact });
        }
    }
}

/// The root of `a t² + b t + c` that a gap c > 0 closing at speed −b > 0 reaches first (for c < 0, the last
/// root passed).
fn first_root(a: f64, b: f64, c: f64) -> Option<f64> {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return None;
    }
    let denominator = -b + discriminant.sqrt();
    (denominator > 0.0).then(|| 2.0 * c / denominator)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_of_a_closing_gap() {
        // A fall of 1 m at 9.81 m/s² from rest, and a gap that closes at 2 m/s.
        let root = first_root(-0.5 * 9.81, 0.0, 1.0).unwrap();
        assert!((root - (2.0_f64 / 9.81).sqrt()).abs() < 1e-15);
        assert_eq!(first_root(0.0, -2.0, 1.0), Some(0.5));
        assert_eq!(first_root(0.0, -2.0, -1.0), Some(-0.5));
        assert_eq!(first_root(0.0, 2.0, 1.0), None);
        assert_eq!(first_root(10.0, -1.0, 1.0), None);
    }
}
