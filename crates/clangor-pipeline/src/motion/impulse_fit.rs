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
    let mut state: State = (bodies.to_vec(), vec![DVec3::ZERO; contacts.len()], Vec::new());
    // What each body has had to be explained: of one that passes an impulse on, what the others gave it.
    let mut most: Vec<f64> = bodies.iter().map(energy).collect();
    let moved = bodies.iter().filter(|body| body.inverse_mass > 0.0).count();
    let least_gain = if moved > FEW_BODIES { PART_IN_PILE * LEAST_GAIN } else { LEAST_GAIN };
    loop {
        let (left, _, chosen) = &state;
        let least = |k: usize| {
            let own: f64 = contacts[k].bodies.iter().map(|place| most[*place]).sum();
            (least_gain * own).max(LEAST_OF_ALL * whole)
        };
        let next = points.best_next(left, chosen, &least);
        if next.is_empty() {
            break;
        }
        // The points that explain most of what is left join, and all that have joined are fitted again.
        state.2.extend(next);
        let rounds = if state.2.len() > MANY { FEW_ROUNDS } else { ROUNDS };
        points.fit(&mut state, rounds);
        most.iter_mut().zip(&state.0).for_each(|(most, body)| *most = most.max(energy(body)));
    }
    if state.2.len() > MANY {
        points.fit(&mut state, ROUNDS);
    }
    for _ in 0..EXCHANGES {
        let is_worth = sum_of_energies(&state.0) > WORTH_EXCHANGE * whole && state.2.len() <= MOST_EXCHANGED;
        if !is_worth || !points.exchange(&mut state) {
            break;
        }
    }
    let (left, impulses, _) = state;
    Fit { impulses, residual: if whole > 0.0 { sum_of_energies(&left) / whole } else { 0.0 } }
}

/// What is left, the impulses, and the points that have them.
type State = (Vec<FitBody>, Vec<DVec3>, Vec<usize>);

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

    /// Exchanges each chosen point for the one of the same bodies that leaves least; whether any was.
    fn exchange(&self, state: &mut State) -> bool {
        let mut is_changed = false;
        for place in 0..state.2.len() {
            let pair = self.contacts[state.2[place]].bodies;
            for other in 0..self.contacts.len() {
                let is_same = self.contacts[other].bodies == pair;
                if !is_same || self.masses[other] == DMat3::ZERO || state.2.contains(&other) {
                    continue;
                }
                let mut next = state.clone();
                let known = std::mem::replace(&mut next.1[state.2[place]], DVec3::ZERO);
                take(&mut next.0, &self.contacts[state.2[place]], -known);
                next.2[place] = other;
                self.fit(&mut next, ROUNDS);
                if sum_of_energies(&next.0) < (1.0 - LEAST_GAIN) * sum_of_energies(&state.0) {
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

    /// Changes the impulses of the chosen points until what is left of the jumps is least.
    fn fit(&self, state: &mut State, rounds: usize) {
        for _ in 0..rounds {
            if self.sweep(state) {
                break;
            }
            self.step(state);
        }
    }

    /// Changes each in turns; whether they have converged.
    fn sweep(&self, (left, impulses, chosen): &mut State) -> bool {
        for _ in 0..SWEEPS {
            let (mut change, mut largest) = (0.0_f64, 0.0_f64);
            for &k in &*chosen {
                let contact = &self.contacts[k];
                let target = impulses[k] + self.masses[k] * relative_velocity(left, contact);
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

    /// Changes all within the limits that they have reached, if that leaves less of the jumps.
    fn step(&self, state: &mut State) {
        let (left, impulses, chosen) = &*state;
        let contacts: Vec<FitContact> = chosen.iter().map(|k| self.contacts[*k]).collect();
        let face = |(contact, k): (&FitContact, &usize)| {
            Face::of_impulse(impulses[*k], contact.normal, contact.friction)
        };
        let faces: Vec<Face> = contacts.iter().zip(chosen).map(face).collect();
        let gradient = contacts.iter().map(|contact| relative_velocity(left, contact)).collect();
        let still =
            |body: &FitBody| FitBody { velocity: DVec3::ZERO, angular_velocity: DVec3::ZERO, ..*body };
        let still: Vec<FitBody> = left.iter().map(still).collect();
        let apply = |change: &[DVec3]| {
            let mut moved = still.clone();
            contacts.iter().zip(change).for_each(|(contact, change)| take(&mut moved, contact, *change));
            contacts.iter().map(|contact| -relative_velocity(&moved, contact)).collect()
        };
        let change = change_within(&faces, gradient, |i, left| self.masses[chosen[i]] * left, apply);
        let before = sum_of_energies(left);
        for share in SHARES {
            let mut next = state.clone();
            for ((contact, k), change) in contacts.iter().zip(chosen).zip(&change) {
                let impulse = within_cone(impulses[*k] + *change * share, contact.normal, contact.friction);
                take(&mut next.0, contact, impulse - impulses[*k]);
                next.1[*k] = impulse;
            }
            if sum_of_energies(&next.0) < before {
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
mod tests {
    use super::*;

    fn ball(inverse_mass: f64, centre: DVec3) -> FitBody {
        let inverse_inertia = DMat3::from_diagonal(DVec3::splat(inverse_mass / (0.4 * 0.01 * 0.01)));
        FitBody {
            inverse_mass,
            inverse_inertia,
            centre,
            velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
        }
    }

    #[test]
    fn impulses_at_two_points_of_two_bodies_are_recovered_from_their_jumps() {
        let mut bodies =
            [ball(4.0, DVec3::Y * 0.01), ball(2.0, DVec3::new(0.02, 0.01, 0.0)), ball(0.0, DVec3::ZERO)];
        bodies[2].inverse_inertia = DMat3::ZERO;
        let contact = |a, b, point, normal| FitContact { bodies: [a, b], point, normal, friction: 0.5 };
        let contacts =
            [contact(0, 2, DVec3::ZERO, DVec3::Y), contact(0, 1, DVec3::new(0.01, 0.01, 0.0), DVec3::NEG_X)];
        let impulses = [DVec3::new(0.03, 0.2, -0.05), DVec3::new(-0.4, 0.1, 0.02)];
        for (contact, impulse) in contacts.iter().zip(impulses) {
            for (i, sign) in [(0, 1.0), (1, -1.0)] {
                let body = &mut bodies[contact.bodies[i]];
                body.velocity += impulse * (sign * body.inverse_mass);
                body.angular_velocity +=
                    body.inverse_inertia * (contact.point - body.centre).cross(impulse) * sign;
            }
        }
        let fit = fit_impulses(&bodies, &contacts);
        // Seen: 8e-8 N s, and 1e-14 of the energy unexplained.
        for (found, true_impulse) in fit.impulses.iter().zip(impulses) {
            assert!((*found - true_impulse).length() < 1e-6, "{found} for {true_impulse}");
        }
        assert!(fit.residual < 1e-9, "{}", fit.residual);
    }

    #[test]
    fn a_surface_cannot_pull() {
        let mut bodies =
            [ball(1.0, DVec3::Y * 0.01), FitBody { inverse_inertia: DMat3::ZERO, ..ball(0.0, DVec3::ZERO) }];
        bodies[0].velocity = DVec3::NEG_Y;
        let contact = FitContact { bodies: [0, 1], point: DVec3::ZERO, normal: DVec3::Y, friction: 0.3 };
        let fit = fit_impulses(&bodies, &[contact]);
        assert_eq!(fit.impulses, [DVec3::ZERO]);
        assert_eq!(fit.residual, 1.0);
    }
}
