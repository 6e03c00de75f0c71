//! Impulses at given points that explain given jumps of velocity.
//!
//! ```text
//! minimise  Σ_b ½ m |Δv − Σ j / m|² + ½ (Δω − I⁻¹ Σ r × j)ᵀ I (…)        j·n ≥ 0,  |j_t| ≤ μ j·n
//! ```
//!
//! The gradient at a point is the relative velocity that is not yet explained there, the second derivative
//! its 3 × 3 inverse mass K: block coordinate descent, which is the sequential impulses of a solver with the
//! jumps as its right side (Catto 2005), with steps within the limits that impulses have reached
//! ([`cone_faces`](super)), which carry loads through stacks. Points join one by one, each that explains most
//! of what is left, and with it those of other bodies that explain about as much, until none explains more
//! than half a percent of what its own two bodies had to be explained: an impact at one place has one point,
//! however many samples of the surfaces lie near it, and however many other bodies touch. Then each of them
//! is exchanged for another point of the same two bodies, as long as that explains more: a point that was the
//! best before the others joined need not be it afterwards. Bodies that nothing moves take impulses and
//! explain nothing.
//!
//! Opposite impulses that squeeze a body change nothing of it. Its partners would show them, but not where
//! nothing moves these, or where others hold them in turn, as in a wall. With a small lever between them they
//! even explain a turn, at a hundred times the true impulses. Calm impulses are therefore sought too, in
//! passes that each add
//!
//! ```text
//! ε/2 Σ (j − j′)ᵀ K (j − j′)        j′ of the pass before, zero in the first
//! ```
//!
//! (proximal point iteration, Rockafellar 1976; the same in [`lasting_fit`](super)). Of a motion with the
//! curvature λ, about one for what bodies show and far less for what squeezes them, n passes leave
//! (ε/(ε + λ))ⁿ. They are taken where Σ jᵀ K j is less and hardly more stays unexplained: a load
//! on a stack of N bodies, whose λ is about 1/N², may need the others.

use clangor_core::pose::Pose;
use glam::{DMat3, DVec3};

use super::cone_faces::{Face, SHARES, change_within};
use super::kinematics::Inertia;

/// Most sweeps over all points between two steps within limits, and most of those steps; fewer while more
/// than so many points have joined, of which the last one changes little.
const SWEEPS: usize = 30;
const ROUNDS: usize = 10;
const FEW_ROUNDS: usize = 2;
const MANY: usize = 60;
/// Share of the energy of the jumps of its two bodies that another point must explain, and of that of all:
/// less is the noise of the motion, which many points would share.
const LEAST_GAIN: f64 = 0.005;
const LEAST_OF_ALL: f64 = 1e-6;
/// Moved bodies up to which that holds; among more, whose errors add up along a pile, this part of it does.
const FEW_BODIES: usize = 5;
const PART_IN_PILE: f64 = 0.1;
/// Share of what the best point explains from which points of other bodies join with it.
const AS_GOOD: f64 = 0.5;
/// Unexplained share from which points are exchanged, most rounds in which each point is, and most points.
const WORTH_EXCHANGE: f64 = 0.005;
const EXCHANGES: usize = 3;
const MOST_EXCHANGED: usize = 20;
/// Change of the impulses in a sweep, relative to the largest, at which the fit ends.
const CONVERGED: f64 = 1e-7;
/// Σ jᵀ K j, over that of independent impulses, from which calm impulses are sought.
const SQUEEZES: f64 = 1.2;
/// ε of calm impulses, least and most passes after the one in which points join, and the share of what the
/// pass before left from which more are not worth it.
const WEIGHT: f64 = 0.03;
const LEAST_PASSES: usize = 2;
const MOST_PASSES: usize = 12;
const HARDLY: f64 = 0.7;
/// Most of Σ jᵀ K j of the others that calm impulses have, and of what the others leave unexplained; where
/// they are far calmer, and what of the whole they may leave beyond that of the others.
const CALMER: f64 = 0.7;
const MORE_UNEXPLAINED: f64 = 1.5;
const FAR_CALMER: f64 = 0.05;
const MORE_OF_WHOLE: f64 = 0.3;

/// A body and its jump; its inverse mass is zero if nothing moves it.
#[derive(Clone, Copy, Debug)]
pub(super) struct FitBody {
    /// 1/m [1/kg].
    pub(super) inverse_mass: f64,
    /// I⁻¹, world [1/(kg m²)].
    pub(super) inverse_inertia: DMat3,
    /// Centre of mass [m, world].
    pub(super) centre: DVec3,
    /// Δv [m/s].
    pub(super) velocity: DVec3,
    /// Δω [rad/s].
    pub(super) angular_velocity: DVec3,
}

impl FitBody {
    /// What nothing moves.
    pub(super) const IMMOVABLE: Self = FitBody {
        inverse_mass: 0.0,
        inverse_inertia: DMat3::ZERO,
        centre: DVec3::ZERO,
        velocity: DVec3::ZERO,
        angular_velocity: DVec3::ZERO,
    };

    /// The same body with an unexplained jump that costs only a share of its energy: that of a body of more
    /// mass with the same jump of its momentum.
    pub(super) fn weighted(self, weight: f64) -> Self {
        FitBody {
            inverse_mass: weight * self.inverse_mass,
            inverse_inertia: self.inverse_inertia * weight,
            velocity: self.velocity * weight,
            angular_velocity: self.angular_velocity * weight,
            ..self
        }
    }

    /// A body in a pose with its jumps of velocity [m/s] and of angular momentum [kg m²/s].
    pub(super) fn moved(inertia: &Inertia, pose: Pose, (velocity, angular_momentum): (DVec3, DVec3)) -> Self {
        let inverse_inertia = inertia.inverse_at(pose.orientation);
        FitBody {
            inverse_mass: inertia.mass.recip(),
            inverse_inertia,
            centre: pose.position,
            velocity,
            angular_velocity: inverse_inertia * angular_momentum,
        }
    }
}

/// A point where two bodies, by their places in the list, may push each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct FitContact {
    pub(super) bodies: [usize; 2],
    /// [m, world].
    pub(super) point: DVec3,
    /// Unit, from the second body to the first.
    pub(super) normal: DVec3,
    /// μ.
    pub(super) friction: f64,
}

/// Impulses on the first body of each contact [N s], and the share of the energy of the jumps that they leave
/// unexplained.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    pub(super) impulses: Vec<DVec3>,
    pub(super) residual: f64,
}

/// Fits impulses at as few of the points as explain the jumps.
pub(super) fn fit_impulses(bodies: &[FitBody], contacts: &[FitContact]) -> Fit {
    let whole = sum_of_energies(bodies);
    let points = Points::new(bodies, contacts);
    let mut state = points.explain(bodies, 0.0);
    // What explains the jumps alone squeezes nothing.
    if points.squares(&state) > SQUEEZES * 2.0 * whole {
        let calm = points.explain(bodies, WEIGHT);
        let (squares, energy) = (points.squares(&calm) / points.squares(&state), state.energy());
        let is_calmer = squares < CALMER && calm.energy() <= MORE_UNEXPLAINED * energy;
        let is_far_calmer = squares < FAR_CALMER && calm.energy() <= energy + MORE_OF_WHOLE * whole;
        if is_calmer || is_far_calmer {
            state = calm;
        }
    }
    let residual = if whole > 0.0 { state.energy() / whole } else { 0.0 };
    Fit { impulses: state.impulses, residual }
}

/// How far a fit has come.
#[derive(Clone)]
struct State {
    /// What is left of the jumps.
    left: Vec<FitBody>,
    /// Impulses of all points, and those of the pass before.
    impulses: Vec<DVec3>,
    before: Vec<DVec3>,
    /// The points that have them.
    chosen: Vec<usize>,
}

impl State {
    /// Energy of what is left \[J\].
    fn energy(&self) -> f64 {
        sum_of_energies(&self.left)
    }
}

/// All points, with K⁻¹ and K of each; zero where nothing moves.
struct Points<'a> {
    contacts: &'a [FitContact],
    masses: Vec<DMat3>,
    compliances: Vec<DMat3>,
}

impl<'a> Points<'a> {
    fn new(bodies: &[FitBody], contacts: &'a [FitContact]) -> Self {
        let masses: Vec<DMat3> = contacts.iter().map(|contact| effective_mass(bodies, contact)).collect();
        let compliance = |mass: &DMat3| if *mass == DMat3::ZERO { DMat3::ZERO } else { mass.inverse() };
        let compliances = masses.iter().map(compliance).collect();
        Self { contacts, masses, compliances }
    }

    /// Explains the jumps of bodies by as few points as do, in passes with a weight ε.
    fn explain(&self, bodies: &[FitBody], weight: f64) -> State {
        let whole = sum_of_energies(bodies);
        let none = || vec![DVec3::ZERO; self.contacts.len()];
        let mut state = State { left: bodies.to_vec(), impulses: none(), before: none(), chosen: Vec::new() };
        // What each body has had to be explained: of one that passes an impulse on, what the others gave it.
        let mut most: Vec<f64> = bodies.iter().map(energy).collect();
        let moved = bodies.iter().filter(|body| body.inverse_mass > 0.0).count();
        let least_gain = if moved > FEW_BODIES { PART_IN_PILE * LEAST_GAIN } else { LEAST_GAIN };
        loop {
            let least = |k: usize| {
                let own: f64 = self.contacts[k].bodies.iter().map(|place| most[*place]).sum();
                (least_gain * own).max(LEAST_OF_ALL * whole)
            };
            let next = self.best_next(&state.left, &state.chosen, &least);
            if next.is_empty() {
                break;
            }
            // The points that explain most of what is left join, and all that have joined are fitted again.
            state.chosen.extend(next);
            let rounds = if state.chosen.len() > MANY { FEW_ROUNDS } else { ROUNDS };
            self.fit(&mut state, weight, rounds);
            most.iter_mut().zip(&state.left).for_each(|(most, body)| *most = most.max(energy(body)));
        }
        if state.chosen.len() > MANY {
            self.fit(&mut state, weight, ROUNDS);
        }
        for _ in 0..EXCHANGES {
            let is_worth = state.energy() > WORTH_EXCHANGE * whole && state.chosen.len() <= MOST_EXCHANGED;
            if !is_worth || !self.exchange(&mut state, weight) {
                break;
            }
        }
        let passes = if weight > 0.0 { MOST_PASSES } else { 0 };
        for pass in 1..=passes {
            let unexplained = state.energy();
            state.before.clone_from(&state.impulses);
            self.fit(&mut state, weight, ROUNDS);
            if pass >= LEAST_PASSES && state.energy() > HARDLY * unexplained {
                break;
            }
        }
        state
    }

    /// Exchanges each chosen point for the one of the same bodies that leaves least; whether any was.
    fn exchange(&self, state: &mut State, weight: f64) -> bool {
        let mut is_changed = false;
        for place in 0..state.chosen.len() {
            let pair = self.contacts[state.chosen[place]].bodies;
            for other in 0..self.contacts.len() {
                let is_same = self.contacts[other].bodies == pair;
                if !is_same || self.masses[other] == DMat3::ZERO || state.chosen.contains(&other) {
                    continue;
                }
                let mut next = state.clone();
                let one = state.chosen[place];
                let known = std::mem::replace(&mut next.impulses[one], DVec3::ZERO);
                take(&mut next.left, &self.contacts[one], -known);
                next.chosen[place] = other;
                self.fit(&mut next, weight, ROUNDS);
                if next.energy() < (1.0 - LEAST_GAIN) * state.energy() {
                    *state = next;
                    is_changed = true;
                }
            }
        }
        is_changed
    }

    /// The point not yet chosen whose impulse takes most of the energy of the jumps that are left, if it
    /// takes more than its `least` \[J\], and the best ones of other moved bodies that take about as much.
    fn best_next(&self, left: &[FitBody], chosen: &[usize], least: &dyn Fn(usize) -> f64) -> Vec<usize> {
        let gain = |k: usize| {
            let (contact, velocity) = (&self.contacts[k], relative_velocity(left, &self.contacts[k]));
            let impulse = within_cone(self.masses[k] * velocity, contact.normal, contact.friction);
            impulse.dot(velocity) - 0.5 * impulse.dot(self.compliances[k] * impulse)
        };
        let mut is_free: Vec<bool> = self.masses.iter().map(|mass| *mass != DMat3::ZERO).collect();
        chosen.iter().for_each(|k| is_free[*k] = false);
        let free = (0..self.contacts.len()).filter(|k| is_free[*k]);
        let mut gains: Vec<(usize, f64)> =
            free.map(|k| (k, gain(k))).filter(|(k, gain)| *gain > least(*k)).collect();
        gains.sort_by(|a, b| b.1.total_cmp(&a.1));
        let best = gains.first().map_or(0.0, |(_, gain)| *gain);
        let (mut next, mut is_taken) = (Vec::new(), vec![false; left.len()]);
        for (k, _) in gains.into_iter().take_while(|(_, gain)| *gain >= AS_GOOD * best) {
            let moved = || self.contacts[k].bodies.into_iter().filter(|b| left[*b].inverse_mass > 0.0);
            if !moved().any(|body| is_taken[body]) {
                moved().for_each(|body| is_taken[body] = true);
                next.push(k);
            }
        }
        next
    }

    /// Σ jᵀ K j \[J\].
    fn squares(&self, state: &State) -> f64 {
        state.chosen.iter().map(|k| state.impulses[*k].dot(self.compliances[*k] * state.impulses[*k])).sum()
    }

    /// Changes the impulses of the chosen points until the sum of a pass with a weight ε is least.
    fn fit(&self, state: &mut State, weight: f64, rounds: usize) {
        for _ in 0..rounds {
            if self.sweep(state, weight) {
                break;
            }
            self.step(state, weight);
        }
    }

    /// Changes each in turns; whether they have converged.
    fn sweep(&self, State { left, impulses, before, chosen }: &mut State, weight: f64) -> bool {
        for _ in 0..SWEEPS {
            let (mut change, mut largest) = (0.0_f64, 0.0_f64);
            for &k in &*chosen {
                let contact = &self.contacts[k];
                let alone = impulses[k] + self.masses[k] * relative_velocity(left, contact);
                let target = (alone + before[k] * weight) / (1.0 + weight);
                let next = within_cone(target, contact.normal, contact.friction);
                let step = next - impulses[k];
                take(left, contact, step);
                impulses[k] = next;
                change = change.max(step.length());
                largest = largest.max(next.length());
            }
            if change <= CONVERGED * largest {
                return true;
            }
        }
        false
    }

    /// Changes all within the limits that they have reached, if that makes the sum of the pass less.
    fn step(&self, state: &mut State, weight: f64) {
        let State { left, impulses, before, chosen } = &*state;
        let contacts: Vec<FitContact> = chosen.iter().map(|k| self.contacts[*k]).collect();
        let face = |(contact, k): (&FitContact, &usize)| {
            Face::of_impulse(impulses[*k], contact.normal, contact.friction)
        };
        let faces: Vec<Face> = contacts.iter().zip(chosen).map(face).collect();
        let weighted = |k: usize, change: DVec3| self.compliances[k] * change * weight;
        let each = || contacts.iter().zip(chosen);
        let gradient = each()
            .map(|(contact, k)| relative_velocity(left, contact) - weighted(*k, impulses[*k] - before[*k]));
        let still =
            |body: &FitBody| FitBody { velocity: DVec3::ZERO, angular_velocity: DVec3::ZERO, ..*body };
        let still: Vec<FitBody> = left.iter().map(still).collect();
        let apply = |change: &[DVec3]| {
            let mut moved = still.clone();
            contacts.iter().zip(change).for_each(|(contact, change)| take(&mut moved, contact, *change));
            let effect = |((contact, k), change): ((&FitContact, &usize), &DVec3)| {
                weighted(*k, *change) - relative_velocity(&moved, contact)
            };
            each().zip(change).map(effect).collect()
        };
        let change =
            change_within(&faces, gradient.collect(), |i, left| self.masses[chosen[i]] * left, apply);
        let sum = |state: &State| {
            let off = |k: &usize| state.impulses[*k] - before[*k];
            let added = |k: &usize| 0.5 * off(k).dot(weighted(*k, off(k)));
            state.energy() + chosen.iter().map(added).sum::<f64>()
        };
        let known = sum(state);
        for share in SHARES {
            let mut next = state.clone();
            for ((contact, k), change) in each().zip(&change) {
                let impulse = within_cone(impulses[*k] + *change * share, contact.normal, contact.friction);
                take(&mut next.left, contact, impulse - impulses[*k]);
                next.impulses[*k] = impulse;
            }
            if sum(&next) < known {
                *state = next;
                return;
            }
        }
    }
}

/// Takes an impulse of a contact from what is left of the jumps.
fn take(left: &mut [FitBody], contact: &FitContact, impulse: DVec3) {
    for (place, sign) in contact.bodies.into_iter().zip([1.0, -1.0]) {
        let body = &mut left[place];
        let arm = contact.point - body.centre;
        body.velocity -= impulse * (sign * body.inverse_mass);
        body.angular_velocity -= body.inverse_inertia * arm.cross(impulse) * sign;
    }
}

/// Jump of the relative velocity at a contact that is left [m/s].
pub(super) fn relative_velocity(left: &[FitBody], contact: &FitContact) -> DVec3 {
    let [a, b] = contact.bodies.map(|place| {
        let body = &left[place];
        let turning = body.angular_velocity.cross(contact.point - body.centre);
        if body.inverse_mass > 0.0 { body.velocity + turning } else { DVec3::ZERO }
    });
    a - b
}

/// K⁻¹ of a contact [kg].
pub(super) fn effective_mass(bodies: &[FitBody], contact: &FitContact) -> DMat3 {
    let [a, b] = contact.bodies.map(|place| inverse_mass_at(&bodies[place], contact.point));
    let sum = a + b;
    if sum.determinant() > 0.0 { sum.inverse() } else { DMat3::ZERO }
}

/// Velocity of a point of a body for a unit of impulse there [1/kg].
pub(super) fn inverse_mass_at(body: &FitBody, point: DVec3) -> DMat3 {
    let cross = skew(point - body.centre);
    DMat3::from_diagonal(DVec3::splat(body.inverse_mass)) - cross * body.inverse_inertia * cross
}

/// The matrix of a cross product from the left.
fn skew(v: DVec3) -> DMat3 {
    DMat3::from_cols(DVec3::new(0.0, v.z, -v.y), DVec3::new(-v.z, 0.0, v.x), DVec3::new(v.y, -v.x, 0.0))
}

/// The impulse of a contact that is nearest to one that friction or the normal forbid.
pub(super) fn within_cone(impulse: DVec3, normal: DVec3, friction: f64) -> DVec3 {
    let along = impulse.dot(normal);
    if along <= 0.0 {
        return DVec3::ZERO;
    }
    normal * along + (impulse - normal * along).clamp_length_max(friction * along)
}

/// Energy of a jump \[J\]; none for a body that nothing moves.
pub(super) fn energy(body: &FitBody) -> f64 {
    if body.inverse_mass <= 0.0 {
        return 0.0;
    }
    let spin = body.angular_velocity;
    0.5 * body.velocity.length_squared() / body.inverse_mass
        + 0.5 * spin.dot(body.inverse_inertia.inverse() * spin)
}

/// Energy of the jumps of all bodies \[J\].
fn sum_of_energies(bodies: &[FitBody]) -> f64 {
    bodies.iter().map(energy).sum()
}

#[cfg(test)]
mod tests;
