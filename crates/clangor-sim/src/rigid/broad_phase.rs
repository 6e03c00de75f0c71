//! Candidate pairs of parts: bounding balls with a margin, by sweep and prune along x.
//!
//! The list of pairs stays valid until some body has used up half of its margin, so it is rebuilt rarely. The
//! order of the list, and of everything computed from it, depends on indices alone.

use glam::DVec3;

use super::pair::PairKey;
use super::shape::{Part, Shape};
use super::state::{BodyState, Drive};

/// Margin as a fraction of the radius.
const MARGIN: f64 = 0.15;
/// Least number of steps at the present speed that the margin covers.
const MARGIN_STEPS: f64 = 4.0;

/// Every pair of parts whose balls, grown by the margins, meet.
pub(super) fn pairs(bodies: &mut [BodyState], shapes: &[Shape], step: f64) -> Vec<PairKey> {
    for body in bodies.iter_mut() {
        body.moved = 0.0;
        let stays = matches!(body.drive, Drive::Fixed | Drive::Gone);
        body.margin = if body.radius.is_finite() && !stays {
            MARGIN * body.radius + MARGIN_STEPS * body.surface_speed() * step
        } else {
            0.0
        };
    }
    let bodies = &*bodies;
    let (mut bounded, mut half_spaces) = (Vec::new(), Vec::new());
    for (i, body) in bodies.iter().enumerate().filter(|(_, body)| !body.is_gone()) {
        if shapes[body.shape].half_space { half_spaces.push(i) } else { bounded.push(i) }
    }
    let reach = |i: usize| bodies[i].radius + bodies[i].margin;
    let low = |i: usize| bodies[i].mid_position.x - reach(i);
    bounded.sort_by(|&i, &j| low(i).total_cmp(&low(j)).then(i.cmp(&j)));
    let mut keys = Vec::new();
    for (k, &i) in bounded.iter().enumerate() {
        let end = bodies[i].mid_position.x + reach(i);
        for &j in bounded[k + 1..].iter().take_while(|&&j| low(j) <= end) {
            let distance = reach(i) + reach(j);
            let apart = (bodies[i].mid_position - bodies[j].mid_position).length_squared();
            if apart < distance * distance && (bodies[i].is_free() || bodies[j].is_free()) {
                part_pairs(i.min(j), i.max(j), bodies, shapes, &mut keys);
            }
        }
        for &j in half_spaces.iter().filter(|_| bodies[i].is_free()) {
            if height(&bodies[j], bodies[i].mid_position) < reach(i) {
                part_pairs(i, j, bodies, shapes, &mut keys);
            }
        }
    }
    keys.sort_unstable();
    keys
}

/// Height of a point over a half-space \[m\].
fn height(half_space: &BodyState, point: DVec3) -> f64 {
    (half_space.mid_orientation * DVec3::Y).dot(point - half_space.mid_position)
}

fn part_pairs(i: usize, j: usize, bodies: &[BodyState], shapes: &[Shape], keys: &mut Vec<PairKey>) {
    let (a, b) = (&bodies[i], &bodies[j]);
    let (parts_a, parts_b) = (&shapes[a.shape].parts, &shapes[b.shape].parts);
    let margin = a.margin + b.margin;
    let centre = |body: &BodyState, part: &Part| body.mid_position + body.mid_orientation * part.centre;
    let single = parts_a.len() == 1 && parts_b.len() == 1;
    for (k, p) in parts_a.iter().enumerate() {
        let at = centre(a, p);
        for (l, q) in parts_b.iter().enumerate() {
            let near = single
                || if q.radius.is_finite() {
                    (at - centre(b, q)).length() < p.radius + q.radius + margin
                } else {
                    height(b, at) < p.radius + margin
                };
            if near {
                keys.push(PairKey { a: i as u32, b: j as u32, part_a: k as u16, part_b: l as u16 });
            }
        }
    }
}

/// The pairs of each free body.
#[derive(Default)]
pub(super) struct Neighbours {
    first: Vec<usize>,
    pairs: Vec<u32>,
}

impl Neighbours {
    pub(super) fn new(keys: &[PairKey], bodies: &[BodyState]) -> Self {
        let mut first = vec![0; bodies.len() + 1];
        let ends =
            |key: &PairKey| [key.a as usize, key.b as usize].into_iter().filter(|&i| bodies[i].is_free());
        for key in keys {
            for i in ends(key) {
                first[i + 1] += 1;
            }
        }
        for i in 0..bodies.len() {
            first[i + 1] += first[i];
        }
        let mut next = first.clone();
        let mut pairs = vec![0; first[bodies.len()]];
        for (index, key) in keys.iter().enumerate() {
            for i in ends(key) {
                pairs[next[i]] = index as u32;
                next[i] += 1;
            }
        }
        Neighbours { first, pairs }
    }

    /// Indices of the pairs of a body, in order; empty for a body that is not free.
    pub(super) fn of(&self, body: usize) -> &[u32] {
        &self.pairs[self.first[body]..self.first[body + 1]]
    }
}
