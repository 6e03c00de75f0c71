//! The step of a net of stiff springs that turn by large angles: a minimum of energy.
//!
//! Backward Euler's rule with the springs as they are at the middle of the next step. The velocities u of the
//! bodies of a linkage minimize
//!
//! `φ(u) = ½ (u − u₀)ᵀ M (u − u₀) + Σ ½ k e(u)² + Σ c (e(u) − e₀)² / 2 Δt`,
//!
//! with the extensions e₀ now and e(u) after a flight at u for a step Δt. Its impulses `−Δt k e − c (e − e₀)`
//! act along the lines at the end of that flight, where those of `closing` act along the present ones.
//! With u₀ at rest φ is the energy itself, so that the result has no more than any of the velocities where
//! the search starts, whatever stiffness, strain and step. Newton's method with the stiffness along the
//! springs and, under tension, across them, in coordinates in which M is the identity; steps are halved until
//! φ falls (Gast, Schroeder, Stomakhin, Jiang and Teran 2015).
//!
//! What it is not: a rule that keeps angular momentum. It is used only where that of `closing` would add
//! energy (`spring_balance`).

use clangor_core::pose::Pose;
use faer::{Mat, Side};
use glam::{DMat3, DVec3};

use super::closing::Next;
use super::joint::{Joint, PlacedEnds};
use super::linkage::Linkages;
use super::manifold::tangents;
use super::mover::Mover;
use super::stiff_spring::StiffSpring;

/// Steps of Newton's method at most.
const MOST_STEPS: u32 = 20;
/// Halvings of a step at most.
const MOST_HALVINGS: i32 = 16;
/// The search ends where a step lowers φ by less than this part.
const FLAT: f64 = 1e-10;

/// Velocity and spin of a body.
pub(super) type Motion = (DVec3, DVec3);

/// A linkage of springs alone, about to fly for a step.
pub(super) struct StrainedNet<'a> {
    springs: Vec<(&'a Joint, StiffSpring)>,
    bodies: Vec<usize>,
    /// Lengths now \[m\].
    lengths: Vec<f64>,
    step: f64,
    next: &'a Next<'a>,
}

impl<'a> StrainedNet<'a> {
    /// The net of a linkage whose moving bodies are these, and have these poses now, for a step \[s\], after
    /// which they have the poses of `next`; `None` if it has links other than stiff springs.
    pub(super) fn of(
        (linkages, linkage): (&'a Linkages, usize),
        bodies: Vec<usize>,
        now: &dyn Fn(usize) -> Pose,
        (step, next): (f64, &'a Next<'a>),
    ) -> Option<Self> {
        let joints = linkages.joints_of(linkage).iter().map(|&index| &linkages.joints[index]);
        let springs: Vec<_> = joints.map(|joint| Some((joint, joint.spring?))).collect::<Option<_>>()?;
        let lengths = springs.iter().map(|(joint, _)| joint.placed(now).between().length()).collect();
        Some(StrainedNet { springs, bodies, lengths, step, next })
    }

    /// Gives the bodies the velocities of least φ, where u₀ are those that they have. One search begins with
    /// u₀, another one with the best of `starts`, which may lie in a narrow valley of φ.
    pub(super) fn relax(&self, movers: &mut [Mover], starts: &[Vec<Motion>]) {
        let base = movers.to_vec();
        let roots: Vec<DMat3> = self.bodies.iter().map(|&body| root(&base[body].inverse_inertia)).collect();
        let known = (&base[..], &roots[..]);
        let still = vec![0.0; 6 * self.bodies.len()];
        let mut best = (self.level(&still, known, movers), still.clone());
        for start in starts {
            let at = self.coordinates(start, &base, &roots);
            let level = self.level(&at, known, movers);
            if level < best.0 {
                best = (level, at);
            }
        }
        let (near, far) = (self.descend(still, known, movers), self.descend(best.1, known, movers));
        let at = if near.0 < far.0 { near.1 } else { far.1 };
        self.level(&at, known, movers);
    }

    /// The least φ that Newton's method finds from these coordinates, and where.
    fn descend(
        &self,
        mut at: Vec<f64>,
        known: (&[Mover], &[DMat3]),
        movers: &mut [Mover],
    ) -> (f64, Vec<f64>) {
        let mut level = self.level(&at, known, movers);
        for _ in 0..MOST_STEPS {
            self.level(&at, known, movers);
            let Some(step) = self.newton(&at, movers, known.1) else { break };
            let mut trials = (0..MOST_HALVINGS).map(|halvings| {
                let scale = 0.5_f64.powi(halvings);
                let trial: Vec<f64> = at.iter().zip(&step).map(|(a, d)| a + scale * d).collect();
                (self.level(&trial, known, movers), trial)
            });
            let Some((lower, trial)) = trials.find(|trial| trial.0 < level) else { break };
            let flat = level - lower <= FLAT * level;
            (level, at) = (lower, trial);
            if flat {
                break;
            }
        }
        (level, at)
    }

    /// Coordinates of velocities, in which kinetic energy is half the square.
    fn coordinates(&self, motions: &[Motion], base: &[Mover], roots: &[DMat3]) -> Vec<f64> {
        let of = |((&body, motion), root): ((&usize, &Motion), &DMat3)| {
            let linear = (motion.0 - base[body].velocity) * base[body].inverse_mass.sqrt().recip();
            let turning = root.inverse() * (motion.1 - base[body].spin);
            [linear.x, linear.y, linear.z, turning.x, turning.y, turning.z]
        };
        self.bodies.iter().zip(motions).zip(roots).flat_map(of).collect()
    }

    /// φ at these coordinates, which the movers then have.
    fn level(&self, at: &[f64], (base, roots): (&[Mover], &[DMat3]), movers: &mut [Mover]) -> f64 {
        for ((&body, root), y) in self.bodies.iter().zip(roots).zip(at.chunks_exact(6)) {
            let own = &base[body];
            let velocity = own.velocity + DVec3::from_slice(&y[..3]) * own.inverse_mass.sqrt();
            movers[body] = Mover { velocity, spin: own.spin + *root * DVec3::from_slice(&y[3..]), ..*own };
        }
        let mut level = 0.5 * at.iter().map(|y| y * y).sum::<f64>();
        for ((joint, spring), length) in self.springs.iter().zip(&self.lengths) {
            let now = self.placed(joint, movers).between().length();
            level += spring.energy(now) + 0.5 * spring.damping() * (now - length).powi(2) / self.step;
        }
        if level.is_nan() { f64::INFINITY } else { level }
    }

    fn placed(&self, joint: &Joint, movers: &[Mover]) -> PlacedEnds {
        joint.placed(&|body| (self.next)(body, &movers[body]))
    }

    /// Newton's step from these coordinates, which the movers have.
    fn newton(&self, at: &[f64], movers: &[Mover], roots: &[DMat3]) -> Option<Vec<f64>> {
        let size = at.len();
        let mut slope = Mat::from_fn(size, 1, |i, _| -at[i]);
        let mut curvature = Mat::<f64>::identity(size, size);
        for ((joint, spring), length) in self.springs.iter().zip(&self.lengths) {
            let placed = self.placed(joint, movers);
            let between = placed.between();
            let along = between.normalize_or(DVec3::Y);
            let (one, two) = tangents(along);
            let now = between.length();
            let force = spring.force(now) + spring.damping() * (now - length) / self.step;
            let stiffness = spring.stiffness() + spring.damping() / self.step;
            let across = spring.across(now);
            for (direction, stiffness, force) in
                [(along, stiffness, force), (one, across, 0.0), (two, across, 0.0)]
            {
                let row = self.row(joint, &placed, direction, (movers, roots));
                for (i, a) in &row {
                    slope[(*i, 0)] -= self.step * force * a;
                    for (j, b) in &row {
                        curvature[(*i, *j)] += self.step * self.step * stiffness * a * b;
                    }
                }
            }
        }
        let factors = curvature.llt(Side::Lower).ok()?;
        let step = faer::linalg::solvers::Solve::solve(&factors, &slope);
        let step: Vec<f64> = (0..size).map(|i| step[(i, 0)]).collect();
        step.iter().all(|d| d.is_finite()).then_some(step)
    }

    /// How the rate along a direction depends on the coordinates.
    fn row(
        &self,
        joint: &Joint,
        placed: &PlacedEnds,
        direction: DVec3,
        (movers, roots): (&[Mover], &[DMat3]),
    ) -> Vec<(usize, f64)> {
        let mut row = Vec::with_capacity(12);
        for (end, sign) in [(0, 1.0), (1, -1.0)] {
            let Some(body) = joint.ends[end].body else { continue };
            let Some(slot) = self.bodies.iter().position(|known| *known == body) else { continue };
            let linear = direction * (sign * movers[body].inverse_mass.sqrt());
            let turning = roots[slot].transpose() * placed.arms[end].cross(direction) * sign;
            let values = [linear.x, linear.y, linear.z, turning.x, turning.y, turning.z];
            row.extend(values.into_iter().enumerate().map(|(k, value)| (6 * slot + k, value)));
        }
        row
    }
}

/// Cholesky's factor L of a positive matrix, `A = L Lᵀ`.
fn root(a: &DMat3) -> DMat3 {
    let xx = a.x_axis.x.sqrt();
    let (xy, xz) = (a.x_axis.y / xx, a.x_axis.z / xx);
    let yy = (a.y_axis.y - xy * xy).sqrt();
    let yz = (a.y_axis.z - xy * xz) / yy;
    let zz = (a.z_axis.z - xz * xz - yz * yz).sqrt();
    DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(0.0, yy, yz), DVec3::new(0.0, 0.0, zz))
}
