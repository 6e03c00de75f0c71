//! A pair of parts that may touch, and its contact points, which persist from step to step.
//!
//! A manifold is computed once and then carried: its points are anchors in both bodies, measured again in
//! every step. It is recomputed after [`DRIFT`] of relative travel (in every step for curved surfaces, whose
//! contact point moves). Impulses of the last step are inherited by the nearest new anchors, which
//! warm-starts the contact phase. A pair farther apart than its possible travel is skipped until it has
//! travelled that far.
//!
//! A piece of a broken body starts in contact with its siblings, and its convex parts may overlap theirs or
//! those of other bodies. That initial overlap counts as touching: it is not pushed out and adds no energy.
//! The allowance shrinks as the bodies part and never grows again. Pieces therefore start without impulses
//! between them and stay so while they part or rest; if they approach each other, they are stopped where they
//! are.

use clangor_core::material::PairCoefficients;
use glam::{DQuat, DVec3};

use super::manifold::{ManifoldPoint, ManifoldQuery, ManifoldScratch, Placed, Separation, manifold};
use super::shape::Shape;
use super::state::BodyState;

/// Relative travel after which a manifold is recomputed \[m\].
const DRIFT: f64 = 5e-6;
/// Angle by which the lowest rim point of a cylinder may move in a step before more rim points are kept
/// \[rad\].
const SWING: f64 = 0.025;
/// Largest such angle used for rolling \[rad\].
const MOST_SWING: f64 = 0.5;
/// Overlap that is not corrected \[m\].
pub(super) const SLOP: f64 = 2e-6;
/// Search distance of a manifold over the largest travel of the pair in a step.
const FORESIGHT: f64 = 1.5;
/// An anchor inherits the impulse of an old one within this fraction of the smaller radius.
const INHERIT: f64 = 0.05;

/// Which parts of which bodies; orders the pairs.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct PairKey {
    pub(super) a: u32,
    pub(super) b: u32,
    pub(super) part_a: u16,
    pub(super) part_b: u16,
}

/// One carried contact point.
#[derive(Clone, Copy, Default)]
pub(super) struct ContactPoint {
    anchor_a: DVec3,
    anchor_b: DVec3,
    /// Arms from the centres of mass \[m\], world, and the gap \[m\], at the pair's reference time, gravity
    /// left out.
    pub(super) arm_a: DVec3,
    pub(super) arm_b: DVec3,
    pub(super) gap: f64,
    /// Impulse on A in the contact phase of the last step \[N s\].
    pub(super) impulse_n: f64,
    pub(super) impulse_t: DVec3,
}

/// Two parts that may touch.
pub(super) struct Pair {
    pub(super) key: PairKey,
    pub(super) coefficients: PairCoefficients,
    /// From B to A.
    pub(super) normal: DVec3,
    pub(super) points: Vec<ContactPoint>,
    /// When in the step the points were measured \[s\].
    pub(super) reference: f64,
    /// Whether there are points.
    pub(super) live: bool,
    /// Impacts in this step.
    pub(super) hits: u32,
    /// Counts the changes of its bodies' motion; predictions with an older stamp are invalid.
    pub(super) stamp: u32,
    /// Refinements of the predicted impact since then.
    pub(super) refinements: u32,
    /// The exact manifold at the predicted impact.
    pub(super) exact: ExactManifold,
    /// Whether the lowest point moves along a rim: a cylinder on a half-space, whose gap is concave in time.
    pub(super) rolls_on_rim: bool,
    /// Normal velocity \[m/s\] of the lowest rim point that keeps the height of the lowest point over a step.
    pub(super) rim_lift: f64,
    curved: bool,
    axis: DVec3,
    normal_in_owner: DVec3,
    normal_of_a: bool,
    /// Overlap that counts as touching \[m\]: the part of the overlap at birth that has not opened since;
    /// infinite until measured.
    allowance: f64,
    /// Known distance of the pair beyond its foresight \[m\].
    slack: f64,
    /// Travel since the manifold was found \[m\].
    travel: f64,
}

/// A manifold at one instant of the step.
#[derive(Default)]
pub(super) struct ExactManifold {
    pub(super) time: f64,
    pub(super) normal: DVec3,
    pub(super) points: Vec<ManifoldPoint>,
}

/// Time, length and gravity of a step.
#[derive(Clone, Copy)]
pub(super) struct Step {
    /// Start \[s\].
    pub(super) time: f64,
    /// Length \[s\].
    pub(super) length: f64,
    /// Gravity \[m/s²\].
    pub(super) gravity: DVec3,
}

impl Pair {
    /// A pair without contact points; `newborn`: one of the bodies is in its first step.
    pub(super) fn new(
        key: PairKey,
        coefficients: PairCoefficients,
        (a, b): (&BodyState, &BodyState),
        shapes: &[Shape],
        newborn: bool,
    ) -> Self {
        let part_a = &shapes[a.shape].parts[usize::from(key.part_a)];
        let part_b = &shapes[b.shape].parts[usize::from(key.part_b)];
        Pair {
            key,
            coefficients,
            normal: DVec3::Y,
            points: Vec::new(),
            reference: 0.0,
            live: false,
            hits: 0,
            stamp: 0,
            refinements: 0,
            exact: ExactManifold::default(),
            rim_lift: 0.0,
            rolls_on_rim: part_a.cylinder_radius() > 0.0 && shapes[b.shape].half_space,
            allowance: if newborn { f64::INFINITY } else { 0.0 },
            curved: part_a.is_curved() || part_b.is_curved(),
            axis: DVec3::ZERO,
            normal_in_owner: DVec3::Y,
            normal_of_a: false,
            slack: -1.0,
            travel: f64::INFINITY,
        }
    }

    /// Indices of its bodies.
    pub(super) fn ends(&self) -> [usize; 2] {
        [self.key.a as usize, self.key.b as usize]
    }

    /// Bodies of the pair.
    pub(super) fn bodies<'a>(&self, bodies: &'a [BodyState]) -> (&'a BodyState, &'a BodyState) {
        (&bodies[self.key.a as usize], &bodies[self.key.b as usize])
    }

    /// Bound on the distance \[m\] by which the gap can change in a step.
    fn reach(&self, a: &BodyState, b: &BodyState, step: &Step) -> f64 {
        ((a.velocity - b.velocity).length() + a.spin_speed() + b.spin_speed()) * step.length
    }

    /// Search distance of a manifold \[m\].
    fn foresight(&self, reach: f64, step: &Step) -> f64 {
        FORESIGHT * (reach + 2.0 * step.gravity.length() * step.length * step.length) + SLOP
    }

    /// Updates the points to the middle of a new step.
    pub(super) fn begin_step(
        &mut self,
        bodies: &[BodyState],
        shapes: &[Shape],
        step: &Step,
        scratch: &mut PairScratch,
    ) {
        let (a, b) = self.bodies(bodies);
        if !a.is_moving() && !b.is_moving() {
            return;
        }
        self.hits = 0;
        self.stamp = 0;
        self.refinements = 0;
        let reach = self.reach(a, b, step);
        self.travel += reach;
        if self.slack > reach {
            self.slack -= reach;
            return;
        }
        if self.allowance > 0.0 && (!self.live || self.travel > DRIFT) {
            self.forget_opened(bodies, shapes, step, scratch);
        }
        self.update(bodies, shapes, step, 0.5 * step.length, reach, scratch);
    }

    /// Updates the points to time `t` of the step after an impulse on one of its bodies.
    pub(super) fn after_impulse(
        &mut self,
        bodies: &[BodyState],
        shapes: &[Shape],
        step: &Step,
        t: f64,
        scratch: &mut PairScratch,
    ) {
        let (a, b) = self.bodies(bodies);
        self.stamp += 1;
        self.refinements = 0;
        let reach = self.reach(a, b, step);
        self.travel += reach;
        if !self.live && self.slack > reach {
            self.slack -= reach;
            return;
        }
        self.update(bodies, shapes, step, t, reach, scratch);
    }

    /// Reduces the overlap that counts as touching to the present overlap at the start of the step.
    fn forget_opened(
        &mut self,
        bodies: &[BodyState],
        shapes: &[Shape],
        step: &Step,
        scratch: &mut PairScratch,
    ) {
        let (a, b) = self.bodies(bodies);
        let (xa, qa) = a.weightless_pose(step.time, step.length, 0.0);
        let (xb, qb) = b.weightless_pose(step.time, step.length, 0.0);
        let (placed_a, placed_b) = self.placed(shapes, (a, xa, qa), (b, xb, qb));
        let PairScratch { found, manifold: buffers, .. } = scratch;
        let query = ManifoldQuery { prediction: SLOP, fast: true, axis: self.axis };
        let Separation { gap, normal, .. } = manifold(&placed_a, &placed_b, query, found, buffers);
        if normal != DVec3::ZERO {
            self.allowance = self.allowance.min(-gap).max(0.0);
        }
    }

    fn update(
        &mut self,
        bodies: &[BodyState],
        shapes: &[Shape],
        step: &Step,
        t: f64,
        reach: f64,
        scratch: &mut PairScratch,
    ) {
        if self.allowance == f64::INFINITY {
            self.live = false;
            return;
        }
        if !self.live || self.curved || self.travel > DRIFT {
            self.find(bodies, shapes, step, t, reach, scratch);
        }
        if self.live {
            self.measure(bodies, step, t);
        }
    }

    /// Measures arms and gaps of the carried points at time `t` of the step, gravity left out.
    pub(super) fn measure(&mut self, bodies: &[BodyState], step: &Step, t: f64) {
        let (a, b) = self.bodies(bodies);
        let (xa, qa) = a.weightless_pose(step.time, step.length, t);
        let (xb, qb) = b.weightless_pose(step.time, step.length, t);
        self.reference = t;
        self.normal = if self.normal_of_a { qa } else { qb } * self.normal_in_owner;
        for point in &mut self.points {
            let (on_a, on_b) = (xa + qa * point.anchor_a, xb + qb * point.anchor_b);
            point.gap = (on_a - on_b).dot(self.normal) + self.allowance;
            let middle = (on_a + on_b) * 0.5;
            point.arm_a = middle - xa;
            point.arm_b = middle - xb;
        }
    }

    fn find(
        &mut self,
        bodies: &[BodyState],
        shapes: &[Shape],
        step: &Step,
        t: f64,
        reach: f64,
        scratch: &mut PairScratch,
    ) {
        let (a, b) = self.bodies(bodies);
        let (xa, qa) = a.weightless_pose(step.time, step.length, t);
        let (xb, qb) = b.weightless_pose(step.time, step.length, t);
        let foresight = self.foresight(reach, step);
        let (placed_a, placed_b) = self.placed(shapes, (a, xa, qa), (b, xb, qb));
        let fast = if self.rolls_on_rim {
            let (swing, slope) = rim_swing(a, &placed_a, qb * DVec3::Y, step.length);
            let swing_taken = swing.min(MOST_SWING);
            let radius = placed_a.part.cylinder_radius();
            self.rim_lift = 0.5 * radius * slope * swing_taken * swing_taken / step.length;
            swing > SWING
        } else {
            reach > DRIFT
        };
        let found = &mut scratch.found;
        let query = ManifoldQuery { prediction: foresight + 4.0 * DRIFT, fast, axis: self.axis };
        let Separation { gap, normal, normal_of_a } =
            manifold(&placed_a, &placed_b, query, found, &mut scratch.manifold);
        self.axis = normal;
        self.travel = 0.0;
        if found.is_empty() {
            self.slack = (gap - foresight).max(0.0);
            self.points.clear();
            self.live = false;
            return;
        }
        self.live = true;
        // An old slack would keep the old gaps.
        self.slack = -1.0;
        self.normal_of_a = normal_of_a;
        self.normal_in_owner = if normal_of_a { qa } else { qb }.inverse() * normal;
        let size = match (a.radius.is_finite(), b.radius.is_finite()) {
            (true, true) => a.radius.min(b.radius),
            (true, false) => a.radius,
            _ => b.radius,
        };
        // New anchors inherit the impulses of the nearest old ones.
        std::mem::swap(&mut self.points, &mut scratch.old);
        self.points.clear();
        let old = &scratch.old;
        let used = &mut scratch.used;
        used.clear();
        used.resize(old.len(), false);
        for point in found.iter() {
            let (anchor_a, anchor_b) = (qa.inverse() * (point.on_a - xa), qb.inverse() * (point.on_b - xb));
            let mut carried = ContactPoint { anchor_a, anchor_b, ..ContactPoint::default() };
            let mut nearest = (INHERIT * size).powi(2);
            let mut heir = None;
            for (i, o) in old.iter().enumerate().filter(|(i, _)| !used[*i]) {
                let distance =
                    (o.anchor_a - anchor_a).length_squared().min((o.anchor_b - anchor_b).length_squared());
                if distance < nearest {
                    (nearest, heir) = (distance, Some(i));
                }
            }
            // A rolling point stays the same contact, however far its anchors moved: a single point, and the
            // first (lowest) point of a rim.
            let lone = old.len() == 1 && found.len() == 1;
            if lone || (self.rolls_on_rim && fast && self.points.is_empty() && !old.is_empty()) {
                heir = Some(0);
            }
            if let Some(i) = heir {
                used[i] = true;
                carried.impulse_n = old[i].impulse_n;
                carried.impulse_t = old[i].impulse_t;
            }
            self.points.push(carried);
        }
    }

    /// Finds the manifold at `t` of the step exactly, gravity included, into [`Pair::exact`].
    pub(super) fn find_exactly(
        &mut self,
        bodies: &[BodyState],
        shapes: &[Shape],
        step: &Step,
        t: f64,
        scratch: &mut PairScratch,
    ) {
        let (a, b) = self.bodies(bodies);
        let foresight = self.foresight(self.reach(a, b, step), step);
        self.find_within(bodies, shapes, step, (t, foresight), scratch);
    }

    /// Computes the points no farther apart than a distance \[m\] at a time `t` of the step \[s\].
    pub(super) fn find_within(
        &mut self,
        bodies: &[BodyState],
        shapes: &[Shape],
        step: &Step,
        (t, distance): (f64, f64),
        scratch: &mut PairScratch,
    ) {
        let (a, b) = self.bodies(bodies);
        let fall = 0.5 * t * t;
        let (xa, qa) = a.weightless_pose(step.time, step.length, t);
        let (xb, qb) = b.weightless_pose(step.time, step.length, t);
        let (xa, xb) = (xa + a.gravity(step.gravity) * fall, xb + b.gravity(step.gravity) * fall);
        let (placed_a, placed_b) = self.placed(shapes, (a, xa, qa), (b, xb, qb));
        let query = ManifoldQuery { prediction: distance, fast: true, axis: self.axis };
        let found = manifold(&placed_a, &placed_b, query, &mut scratch.found, &mut scratch.manifold);
        self.exact.time = t;
        self.exact.normal = found.normal;
        self.exact.points.clone_from(&scratch.found);
        self.exact.points.iter_mut().for_each(|point| point.gap += self.allowance);
    }

    fn placed<'a>(
        &self,
        shapes: &'a [Shape],
        (a, xa, qa): (&BodyState, DVec3, DQuat),
        (b, xb, qb): (&BodyState, DVec3, DQuat),
    ) -> (Placed<'a>, Placed<'a>) {
        let part_a = &shapes[a.shape].parts[usize::from(self.key.part_a)];
        let part_b = &shapes[b.shape].parts[usize::from(self.key.part_b)];
        (Placed::new(part_a, xa, qa), Placed::new(part_b, xb, qb))
    }
}

/// Angle by which the lowest rim point of a cylinder on a half-space moves along the rim in a step \[rad\],
/// and the sine of the angle between the cylinder's axis and the normal.
fn rim_swing(body: &BodyState, cylinder: &Placed<'_>, normal: DVec3, step: f64) -> (f64, f64) {
    let axis = cylinder.orientation * DVec3::Z;
    let across = axis.cross(normal);
    let slope = across.length();
    // The rate of the normal, seen from the body, across the plane of axis and normal.
    let rate = body.angular_velocity.cross(normal).dot(across) / slope.max(1e-9);
    (rate.abs() / slope.max(1e-9) * step, slope)
}

/// Buffers of the pairs.
#[derive(Default)]
pub(super) struct PairScratch {
    found: Vec<ManifoldPoint>,
    old: Vec<ContactPoint>,
    used: Vec<bool>,
    manifold: ManifoldScratch,
}
