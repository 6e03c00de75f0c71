//! Neighbour lists: pairs of balls and planes within a margin, kept until a ball leaves its margin.
//!
//! The margin of a ball is a part of its radius plus its travel in [`LOOK_AHEAD`] steps. A ball that leaves
//! its margin is compared with all others. When that has happened often, all lists are rebuilt with a grid
//! whose cells are as wide as the widest ordinary ball with its margin; the few wider balls are compared with
//! all.

use std::collections::BTreeMap;

use clangor_core::material::PairCoefficients;
use glam::{DVec3, IVec3};

use super::{Ball, PLANE, Stepped};

/// Margin as a part of the radius.
const MARGIN: f64 = 0.25;
/// Number of steps that the margin of a moving ball covers.
const LOOK_AHEAD: f64 = 2.0;
/// Balls this much wider than the median one are kept out of the grid.
const WIDE: f64 = 3.0;
/// Number of searches for single balls, plus one per so many balls, after which all lists are rebuilt.
const FEW: usize = 8;
/// The end of a list.
const NONE: u32 = u32::MAX;

/// Impulses of a lasting contact in one step; they start the solution of the next.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Hold {
    /// Along the normal \[N s\].
    pub(super) normal: f64,
    /// Friction \[N s\].
    pub(super) tangential: DVec3,
    /// Couple of rolling and spinning loss \[N m s\].
    pub(super) couple: DVec3,
}

/// Two bodies that may meet; A is the ball of the lower body, a plane is always B.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    /// A ball.
    pub(super) a: u32,
    /// Another, or a plane with [`PLANE`].
    pub(super) b: u32,
    /// e, μ, ρ of the pair.
    pub(super) coefficients: PairCoefficients,
    /// Impulses of their lasting contact.
    pub(super) hold: Hold,
}

/// Neighbour lists of all balls.
#[derive(Default)]
pub(super) struct Neighbours {
    /// The pairs, ordered bottom-up when the lists are rebuilt.
    pub(super) pairs: Vec<Pair>,
    of: Vec<Vec<u32>>,
    current: bool,
    extended: usize,
}

impl Neighbours {
    /// The pairs of a ball.
    pub(super) fn of(&self, ball: usize) -> &[u32] {
        self.of.get(ball).map_or(&[], Vec::as_slice)
    }

    /// Marks all lists for rebuilding before the next step.
    pub(super) fn invalidate(&mut self) {
        self.current = false;
    }

    fn add(&mut self, pair: Pair) {
        let at = self.pairs.len() as u32;
        for ball in [pair.a, pair.b].into_iter().filter(|ball| ball & PLANE == 0) {
            self.of[ball as usize].push(at);
        }
        self.pairs.push(pair);
    }
}

impl Ball {
    /// Whether the ball stays within its margin for the rest of a step.
    pub(super) fn stays(&self, step: f64, gravity: f64) -> bool {
        let way = (self.velocity.length() + gravity * step) * step;
        self.position.distance(self.origin) + way <= self.margin
    }

    /// Chooses a margin for the coming steps.
    fn choose_margin(&mut self, step: f64, gravity: f64) {
        let speed = if self.moves() { self.velocity.length() + LOOK_AHEAD * gravity * step } else { 0.0 };
        self.origin = self.position;
        self.margin = MARGIN * self.radius + LOOK_AHEAD * speed * step;
    }
}

impl Stepped {
    /// Updates the lists so that they contain all pairs that may meet in this step.
    pub(super) fn refresh_neighbours(&mut self) {
        let (step, gravity) = (self.step, self.gravity.length());
        for ball in 0..self.balls.len() {
            if self.balls[ball].moves() && !self.balls[ball].stays(step, gravity) {
                if !self.neighbours.current || self.neighbours.extended > FEW + self.balls.len() / FEW {
                    break;
                }
                self.search_neighbours(ball);
            }
        }
        if !self.neighbours.current || self.neighbours.extended > FEW + self.balls.len() / FEW {
            self.find_neighbours();
        }
    }

    /// Searches the neighbours of a ball that leaves its margin, at its present position.
    pub(super) fn search_neighbours(&mut self, ball: usize) {
        self.balls[ball].choose_margin(self.step, self.gravity.length());
        self.neighbours.extended += 1;
        for other in (0..self.balls.len()).filter(|other| *other != ball) {
            let (lower, upper) = self.ordered(ball, other);
            let known = |at: &u32| {
                let pair = &self.neighbours.pairs[*at as usize];
                (pair.a, pair.b) == (lower, upper)
            };
            if self.is_near(ball, other) && !self.neighbours.of(ball).iter().any(known) {
                let pair = self.pair(lower, upper);
                self.neighbours.add(pair);
            }
        }
        for plane in 0..self.planes.len() as u32 {
            let known = |at: &u32| self.neighbours.pairs[*at as usize].b == plane | PLANE;
            if self.is_near_plane(ball, plane) && !self.neighbours.of(ball).iter().any(known) {
                let pair = self.pair(ball as u32, plane | PLANE);
                self.neighbours.add(pair);
            }
        }
    }

    /// Rebuilds all pairs; lasting contacts keep their impulses.
    fn find_neighbours(&mut self) {
        let (step, gravity) = (self.step, self.gravity.length());
        let held = |pair: &Pair| pair.hold.normal > 0.0;
        let old = std::mem::take(&mut self.neighbours.pairs);
        let holds: BTreeMap<(u32, u32), Hold> =
            old.iter().filter(|pair| held(pair)).map(|pair| ((pair.a, pair.b), pair.hold)).collect();
        self.balls.iter_mut().for_each(|ball| ball.choose_margin(step, gravity));
        let mut found: Vec<(u32, u32)> = Vec::with_capacity(old.len());
        self.find_balls(&mut found);
        for ball in (0..self.balls.len()).filter(|ball| self.balls[*ball].free && self.balls[*ball].there) {
            for plane in 0..self.planes.len() as u32 {
                if self.is_near_plane(ball, plane) {
                    found.push((ball as u32, plane | PLANE));
                }
            }
        }
        let down = self.gravity.normalize_or_zero();
        let height = |&(a, b): &(u32, u32)| {
            let own = down.dot(self.balls[a as usize].position);
            let other = self.balls.get(b as usize).map_or(own, |ball| down.dot(ball.position));
            -(own + other)
        };
        found.sort_by(|one, two| height(one).total_cmp(&height(two)).then(one.cmp(two)));
        self.neighbours.of.iter_mut().for_each(Vec::clear);
        self.neighbours.of.resize(self.balls.len(), Vec::new());
        for (a, b) in found {
            let hold = holds.get(&(a, b)).copied().unwrap_or_default();
            let pair = Pair { hold, ..self.pair(a, b) };
            self.neighbours.add(pair);
        }
        (self.neighbours.current, self.neighbours.extended) = (true, 0);
    }

    /// Finds all pairs of near balls with at least one free ball.
    fn find_balls(&self, found: &mut Vec<(u32, u32)>) {
        let reach = |ball: &Ball| ball.radius + ball.margin;
        let mut reaches: Vec<f64> = self.balls.iter().filter(|ball| ball.there).map(reach).collect();
        if reaches.len() < 2 {
            return;
        }
        let middle = reaches.len() / 2;
        let widest = WIDE * *reaches.select_nth_unstable_by(middle, f64::total_cmp).1;
        let edge = 2.0 * reaches.iter().copied().filter(|reach| *reach <= widest).fold(0.0, f64::max);
        let mask = (2 * self.balls.len()).next_power_of_two() - 1;
        let mut heads = vec![NONE; mask + 1];
        let mut next = vec![NONE; self.balls.len()];
        let mut cells = vec![IVec3::ZERO; self.balls.len()];
        let (mut narrow, mut wide): (Vec<usize>, Vec<usize>) = (Vec::new(), Vec::new());
        let mut meet = |one: usize, two: usize| {
            if self.is_near(one, two) {
                found.push(self.ordered(one, two));
            }
        };
        for (at, ball) in self.balls.iter().enumerate().filter(|(_, ball)| ball.there) {
            if reach(ball) > widest {
                narrow.iter().chain(&wide).for_each(|&other| meet(at, other));
                wide.push(at);
                continue;
            }
            wide.iter().for_each(|&other| meet(at, other));
            narrow.push(at);
            let cell = (ball.position / edge).floor().as_ivec3();
            for k in 0..27 {
                let near = cell.wrapping_add(IVec3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
                let mut other = heads[bucket(near) & mask];
                while other != NONE {
                    // Distant cells may share a bucket.
                    if cells[other as usize] == near {
                        meet(at, other as usize);
                    }
                    other = next[other as usize];
                }
            }
            cells[at] = cell;
            next[at] = std::mem::replace(&mut heads[bucket(cell) & mask], at as u32);
        }
    }

    fn is_near(&self, one: usize, two: usize) -> bool {
        let (one, two) = (&self.balls[one], &self.balls[two]);
        let reach = one.radius + one.margin + two.radius + two.margin;
        let there = one.there && two.there && (one.free || two.free);
        // The margin of a ball counts from its position at the last search.
        there && one.origin.distance_squared(two.origin) <= reach * reach
    }

    fn is_near_plane(&self, ball: usize, plane: u32) -> bool {
        let (ball, plane) = (&self.balls[ball], &self.planes[plane as usize]);
        plane.normal.dot(ball.origin) - plane.offset - ball.radius <= ball.margin
    }

    /// Two balls, that of the lower body first.
    fn ordered(&self, one: usize, two: usize) -> (u32, u32) {
        let (first, second) = (one as u32, two as u32);
        if self.balls[one].body < self.balls[two].body { (first, second) } else { (second, first) }
    }

    fn pair(&self, a: u32, b: u32) -> Pair {
        let ball = &self.balls[a as usize];
        let coefficients = match b & PLANE {
            0 => self.classes.of(ball.material, self.balls[b as usize].material),
            _ => {
                let plane = &self.planes[(b & !PLANE) as usize];
                let compliance = self.classes.compliance(ball.material);
                let own = (ball.radius, ball.inverse_mass, compliance);
                plane.met_by(self.classes.of(ball.material, plane.material), own)
            }
        };
        Pair { a, b, coefficients, hold: Hold::default() }
    }
}

/// Hash of a cell.
fn bucket(cell: IVec3) -> usize {
    let [x, y, z] = cell.to_array().map(|k| k as u32);
    let mixed = x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791);
    (mixed ^ mixed >> 15) as usize
}
