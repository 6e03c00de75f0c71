//! Impulses of lasting contacts that explain given changes of motion, shared by all points that touch.
//!
//! ```text
//! minimise  Σ_b ½ m |Δv − Σ j / m|² + ½ (Δω − I⁻¹ (Σ r × j + Σ c))ᵀ I (…)
//!           j·n ≥ 0,  |j_t| ≤ μ j·n,  |c| ≤ b Σ j·n
//! ```
//!
//! with a rolling couple c of each pair. Many sets of impulses explain a body on four corners. That of least
//! Σ |j|²/m_j, m_j the mass that a point feels along its normal, is a continuous function of the motion, so
//! that a steady load stays where it is, without friction that the motion does not show: each pass adds
//! ε/2 Σ |j − j′|²/m_j with j′ of the pass before, from zero on (proximal point iteration, Rockafellar 1976).
//! A pass leaves ε/(ε + λ) of a motion, λ the curvature of the energy along it: about one for each point that
//! holds a body, and little where a heavy body lies on a light one, or where many lie on each other. The
//! passes end where the energy that is left hardly falls; then steps within the limits that the impulses have
//! reached carry the load on through such a pile ([`cone_faces`](super)), with a pass after each for the
//! limits. A pass is solved by projected gradients with momentum (Nesterov, *Introductory Lectures
//! on Convex Optimization* (2004), §2.2.4), which treat all points alike: forty points of a rim that lands
//! flat have the same share, in whatever order they come.
//!
//! It is not the distribution of the real pressure, which poses do not tell.

use std::ops::Range;

use glam::{DMat3, DVec3};

use super::cone_faces::{Face, SHARES, change_within};
use super::impulse_fit::{FitBody, FitContact, energy, inverse_mass_at, relative_velocity, within_cone};

/// ε.
const WEIGHT: f64 = 0.1;
/// Most passes, and the share of what the pass before left from which another one is not worth it.
const PASSES: usize = 40;
const HARDLY: f64 = 0.9;
/// Most steps within limits, and the change of the impulses in one, relative to the largest, at which they
/// end.
const CARRIES: usize = 10;
const CARRIED: f64 = 1e-6;
/// Most steps in a pass.
const STEPS: usize = 300;
/// Change of the impulses in a step, relative to the largest, at which a pass ends.
const CONVERGED: f64 = 1e-7;

/// Two bodies, by their places in the list, with their contacts and the lever of their rolling couple \[m\].
#[derive(Clone, Debug)]
pub(super) struct FitPair {
    pub(super) bodies: [usize; 2],
    pub(super) contacts: Range<usize>,
    pub(super) lever: f64,
}

/// Impulses on the first body of each contact [N s], couples on that of each pair [N m s], and the share of
/// the energy of the jumps that they leave unexplained.
#[derive(Clone, Debug)]
pub(super) struct SharedLoad {
    pub(super) impulses: Vec<DVec3>,
    pub(super) couples: Vec<DVec3>,
    pub(super) residual: f64,
}

/// Energy of the jumps that may be left of a load that lasts, and of an impact, over all of it.
pub(super) const EXPLAINED: f64 = 1e-14;
pub(super) const EXPLAINED_OF_IMPACT: f64 = 1e-18;

/// Shares the load among all points until this part of the energy of the jumps is left. Each point has m_j
/// times its share w, at most 1; 1 beyond the end of `shares`.
pub(super) fn share_load(
    bodies: &[FitBody],
    (contacts, shares): (&[FitContact], &[f64]),
    pairs: &[FitPair],
    explained: f64,
) -> SharedLoad {
    let whole: f64 = bodies.iter().map(energy).sum();
    let fit = Fit::new(bodies, (contacts, shares), pairs);
    let mut load = vec![DVec3::ZERO; contacts.len() + pairs.len()];
    let mut rest = whole;
    for _ in 0..PASSES {
        load = fit.pass(&load);
        let before = std::mem::replace(&mut rest, fit.rest(&load));
        if rest <= explained * whole || rest > HARDLY * before {
            break;
        }
    }
    for _ in 0..CARRIES {
        if rest <= explained * whole {
            break;
        }
        let Some(next) = fit.carried(&load) else { break };
        let largest = next.iter().map(|next| next.length()).fold(0.0, f64::max);
        let change = next.iter().zip(&load).map(|(next, own)| next.distance(*own)).fold(0.0, f64::max);
        load = fit.pass(&next);
        rest = fit.rest(&load);
        if change <= CARRIED * largest {
            break;
        }
    }
    let residual = if whole > 0.0 { rest / whole } else { 0.0 };
    let couples = load.split_off(contacts.len());
    SharedLoad { impulses: load, couples, residual }
}

/// The jumps, and what may explain them. A load is a list of the impulses of all contacts and then of the
/// couples of all pairs.
struct Fit<'a> {
    bodies: &'a [FitBody],
    contacts: &'a [FitContact],
    pairs: &'a [FitPair],
    /// The mass that each impulse feels along its normal [kg], the inertia that a couple feels [kg m²], times
    /// its share; zero where nothing moves.
    weights: Vec<f64>,
    /// Length of a step, in units of the weights.
    step: f64,
}

impl<'a> Fit<'a> {
    fn new(
        bodies: &'a [FitBody],
        (contacts, shares): (&'a [FitContact], &[f64]),
        pairs: &'a [FitPair],
    ) -> Self {
        // What a unit of each load does to either body.
        let of_contact =
            |c: &FitContact| (c.bodies, c.bodies.map(|place| inverse_mass_at(&bodies[place], c.point)));
        let of_pair = |pair: &FitPair| {
            let inverse = pair.bodies.map(|place| bodies[place].inverse_inertia);
            (pair.bodies, if pair.lever > 0.0 { inverse } else { [DMat3::ZERO; 2] })
        };
        let effects: Vec<([usize; 2], [DMat3; 2])> =
            contacts.iter().map(of_contact).chain(pairs.iter().map(of_pair)).collect();
        let inverse = |load: usize| {
            let [a, b] = effects[load].1;
            contacts.get(load).map_or_else(|| trace(a + b) / 3.0, |c| c.normal.dot((a + b) * c.normal))
        };
        let weight = |load: usize| {
            let share = shares.get(load).copied().unwrap_or(1.0);
            if inverse(load) > 0.0 { share / inverse(load) } else { 0.0 }
        };
        let weights: Vec<f64> = (0..effects.len()).map(weight).collect();
        // Bound of the curvature: with s_ib² the norm of the effect of load i on body b, over that of its
        // weight, the largest of Σ_b s_ib Σ_k s_kb over i.
        let norm = |load: usize, side: usize| (weights[load] * trace(effects[load].1[side])).sqrt();
        let mut sums = vec![0.0; bodies.len()];
        for (load, (places, _)) in effects.iter().enumerate() {
            (0..2).for_each(|side| sums[places[side]] += norm(load, side));
        }
        let bound = |(load, (places, _)): (usize, &([usize; 2], [DMat3; 2]))| -> f64 {
            (0..2).map(|side| norm(load, side) * sums[places[side]]).sum()
        };
        let curvature = effects.iter().enumerate().map(bound).fold(0.0, f64::max);
        Self { bodies, contacts, pairs, weights, step: (curvature + WEIGHT).recip() }
    }

    /// The load that explains the jumps best and is near that of the pass before.
    fn pass(&self, before: &[DVec3]) -> Vec<DVec3> {
        // Momentum of a strongly convex function of this condition.
        let root = (WEIGHT * self.step).sqrt();
        let momentum = (1.0 - root) / (1.0 + root);
        let (mut load, mut ahead) = (before.to_vec(), before.to_vec());
        for _ in 0..STEPS {
            let next = self.stepped(&ahead, before);
            let moves = || next.iter().zip(&load);
            let change = moves().map(|(next, own)| next.distance(*own)).fold(0.0, f64::max);
            let largest = next.iter().map(|next| next.length()).fold(0.0, f64::max);
            // No momentum against the gradient.
            let against: f64 =
                moves().zip(&ahead).map(|((next, own), ahead)| (*ahead - *next).dot(*next - *own)).sum();
            let momentum = if against > 0.0 { 0.0 } else { momentum };
            ahead = moves().map(|(next, own)| *next + (*next - *own) * momentum).collect();
            load = next;
            if change <= CONVERGED * largest {
                break;
            }
        }
        load
    }

    /// A load changed within the limits that it has reached, so that it explains more.
    fn carried(&self, load: &[DVec3]) -> Option<Vec<DVec3>> {
        let of_contact = |(impulse, contact): (&DVec3, &FitContact)| {
            Face::of_impulse(*impulse, contact.normal, contact.friction)
        };
        let (impulses, couples) = load.split_at(self.contacts.len());
        let of_pair = |(couple, pair): (&DVec3, &FitPair)| {
            let is_free = couple.length() < self.largest_couple(pair, impulses);
            if is_free { Face::Free } else { Face::Fixed }
        };
        let faces: Vec<Face> = impulses
            .iter()
            .zip(self.contacts)
            .map(of_contact)
            .chain(couples.iter().zip(self.pairs).map(of_pair))
            .collect();
        let gradient = self.slips(&self.left(load));
        let still = self.slips(&self.left(&vec![DVec3::ZERO; load.len()]));
        let apply = |change: &[DVec3]| {
            let moved = self.slips(&self.left(change));
            still.iter().zip(moved).map(|(still, moved)| *still - moved).collect()
        };
        let change = change_within(&faces, gradient, |k, slip| slip * self.weights[k], apply);
        let before = self.rest(load);
        let shared = |share: f64| {
            let moved = load.iter().zip(&change).map(|(own, change)| *own + *change * share);
            self.allowed(moved.collect())
        };
        SHARES.into_iter().map(shared).find(|next| self.rest(next) < before)
    }

    /// A step against the gradient from a load, into what friction and levers allow.
    fn stepped(&self, from: &[DVec3], before: &[DVec3]) -> Vec<DVec3> {
        let slips = self.slips(&self.left(from));
        let moved = |load: usize| {
            let pull = (from[load] - before[load]) * WEIGHT;
            from[load] + (slips[load] * self.weights[load] - pull) * self.step
        };
        self.allowed((0..from.len()).map(moved).collect())
    }

    /// The load that friction and levers allow, near one that they may not.
    fn allowed(&self, mut load: Vec<DVec3>) -> Vec<DVec3> {
        let (impulses, couples) = load.split_at_mut(self.contacts.len());
        for (impulse, contact) in impulses.iter_mut().zip(self.contacts) {
            *impulse = within_cone(*impulse, contact.normal, contact.friction);
        }
        for (couple, pair) in couples.iter_mut().zip(self.pairs) {
            *couple = couple.clamp_length_max(self.largest_couple(pair, impulses));
        }
        load
    }

    /// Largest couple of a pair with these impulses.
    fn largest_couple(&self, pair: &FitPair, impulses: &[DVec3]) -> f64 {
        let pressing: f64 = pair.contacts.clone().map(|k| impulses[k].dot(self.contacts[k].normal)).sum();
        pair.lever * pressing.max(0.0)
    }

    /// What is left of the jumps at each contact [m/s] and between the bodies of each pair [rad/s].
    fn slips(&self, left: &[FitBody]) -> Vec<DVec3> {
        let spin = |place: usize| {
            let body = &left[place];
            if body.inverse_mass > 0.0 { body.angular_velocity } else { DVec3::ZERO }
        };
        let of_pair = |pair: &FitPair| spin(pair.bodies[0]) - spin(pair.bodies[1]);
        let of_contacts = self.contacts.iter().map(|contact| relative_velocity(left, contact));
        of_contacts.chain(self.pairs.iter().map(of_pair)).collect()
    }

    /// Energy of the jumps that a load does not explain \[J\].
    fn rest(&self, load: &[DVec3]) -> f64 {
        self.left(load).iter().map(energy).sum()
    }

    /// The jumps that a load does not explain.
    fn left(&self, load: &[DVec3]) -> Vec<FitBody> {
        let mut left = self.bodies.to_vec();
        for (impulse, contact) in load.iter().zip(self.contacts) {
            for (place, sign) in contact.bodies.into_iter().zip([1.0, -1.0]) {
                let body = &mut left[place];
                let arm = contact.point - body.centre;
                body.velocity -= *impulse * (sign * body.inverse_mass);
                body.angular_velocity -= body.inverse_inertia * arm.cross(*impulse) * sign;
            }
        }
        for (couple, pair) in load[self.contacts.len()..].iter().zip(self.pairs) {
            for (place, sign) in pair.bodies.into_iter().zip([1.0, -1.0]) {
                let body = &mut left[place];
                body.angular_velocity -= body.inverse_inertia * *couple * sign;
            }
        }
        left
    }
}

fn trace(matrix: DMat3) -> f64 {
    matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z
}

#[cfg(test)]
mod tests {
    use super::*;

    fn floor() -> FitBody {
        FitBody {
            inverse_mass: 0.0,
            inverse_inertia: DMat3::ZERO,
            centre: DVec3::ZERO,
            velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
        }
    }

    /// A block of 2 kg on four corners, pushed along x by friction: the front corners carry more.
    #[test]
    fn four_corners_share_a_load_by_its_moment() {
        let (mass, height, half) = (2.0, 0.02, 0.05);
        let block = FitBody {
            inverse_mass: 1.0 / mass,
            inverse_inertia: DMat3::from_diagonal(DVec3::splat(1.0 / (mass * 1e-3))),
            centre: DVec3::Y * height,
            velocity: DVec3::new(-0.003, 0.01, 0.0),
            angular_velocity: DVec3::ZERO,
        };
        let corner = |x: f64, z: f64| FitContact {
            bodies: [0, 1],
            point: DVec3::new(x, 0.0, z),
            normal: DVec3::Y,
            friction: 0.5,
        };
        let contacts =
            [[half, half], [half, -half], [-half, half], [-half, -half]].map(|[x, z]| corner(x, z));
        let pairs = [FitPair { bodies: [0, 1], contacts: 0..4, lever: 0.0 }];
        let load = share_load(&[block, floor()], (&contacts, &[]), &pairs, EXPLAINED);
        let sum: DVec3 = load.impulses.iter().sum();
        // Seen: 2e-6 of the impulse.
        assert!(sum.distance(block.velocity * mass) < 1e-4 * sum.length(), "{sum}");
        // Moments about the centre: half (front − back) = height × friction, per kilogram.
        let [front, back] = [[0, 1], [2, 3]].map(|pair| pair.map(|k: usize| load.impulses[k].y));
        let difference = front[0] + front[1] - back[0] - back[1];
        // Seen: 4e-6 of the load.
        assert!((difference - mass * 0.003 * height / half).abs() < 1e-4 * sum.y, "{difference}");
        assert!((front[0] - front[1]).abs() < 1e-4 * sum.y, "{front:?}");
        assert!(load.residual < 1e-6, "{}", load.residual);
    }

    /// A cup of 0.3 kg that lands flat on its foot: each point of the rim has the same share.
    #[test]
    fn a_rim_that_lands_flat_shares_evenly() {
        let cup = FitBody {
            inverse_mass: 1.0 / 0.3,
            inverse_inertia: DMat3::from_diagonal(DVec3::splat(1.0 / 4e-4)),
            centre: DVec3::Y * 0.04,
            velocity: DVec3::Y * 0.06,
            angular_velocity: DVec3::ZERO,
        };
        let point = |k: u32| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 32.0).sin_cos();
            FitContact {
                bodies: [0, 1],
                point: DVec3::new(cos, 0.0, sin) * 0.042,
                normal: DVec3::Y,
                friction: 0.4,
            }
        };
        let contacts: Vec<FitContact> = (0..32).map(point).collect();
        let pairs = [FitPair { bodies: [0, 1], contacts: 0..32, lever: 0.0 }];
        let load = share_load(&[cup, floor()], (&contacts, &[]), &pairs, EXPLAINED);
        let share = 0.06 * 0.3 / 32.0;
        let off = load.impulses.iter().map(|j| j.distance(DVec3::Y * share) / share).fold(0.0, f64::max);
        // Seen: 5e-7; sweeps over the points, each in turn, gave 0.92.
        println!("largest difference {off:.1e}");
        assert!(off < 1e-4, "{off}");
    }

    #[test]
    fn a_rolling_ball_is_braked_by_a_couple_within_its_lever() {
        let (mass, radius) = (0.1, 0.01);
        let ball = FitBody {
            inverse_mass: 1.0 / mass,
            inverse_inertia: DMat3::from_diagonal(DVec3::splat(1.0 / (0.4 * mass * radius * radius))),
            centre: DVec3::Y * radius,
            velocity: DVec3::new(-1e-5, 0.01, 0.0),
            angular_velocity: DVec3::new(0.0, 0.0, 1e-5 / radius),
        };
        let contact = FitContact { bodies: [0, 1], point: DVec3::ZERO, normal: DVec3::Y, friction: 0.3 };
        let load = |lever: f64| {
            let pairs = [FitPair { bodies: [0, 1], contacts: 0..1, lever }];
            share_load(&[ball, floor()], (&[contact], &[]), &pairs, EXPLAINED)
        };
        // The point of contact stays at rest: without a couple nothing brakes it.
        assert!(load(0.0).impulses[0].x.abs() < 1e-9 * mass);
        // 7/5 m Δv R is the couple that explains all of it: 1.4e-8 N m s, a lever of 1.4e-5 m. Seen: 0.3 %.
        let braked = load(1e-4);
        assert!((braked.impulses[0].x / (-1e-5 * mass) - 1.0).abs() < 0.02, "{}", braked.impulses[0]);
        assert!((braked.couples[0].z / 1.4e-8 - 1.0).abs() < 0.02, "{}", braked.couples[0]);
        let short = load(1e-6).couples[0].length();
        assert!((short / 1e-9 - 1.0).abs() < 0.01, "{short}");
    }

    #[test]
    fn points_without_mass_or_load_take_nothing() {
        let contact = FitContact { bodies: [0, 1], point: DVec3::ZERO, normal: DVec3::Y, friction: 0.3 };
        let pairs = [FitPair { bodies: [0, 1], contacts: 0..1, lever: 1.0 }];
        let load = share_load(&[floor(), floor()], (&[contact], &[]), &pairs, EXPLAINED);
        assert_eq!((load.impulses[0], load.couples[0], load.residual), (DVec3::ZERO, DVec3::ZERO, 0.0));
    }
}
