//! Impulses of lasting contacts that explain given changes of motion, shared by all points that touch.
//!
//! ```text
//! minimise  Σ_b ½ m |Δv − Σ j / m|² + ½ (Δω − I⁻¹ (Σ r × j + Σ c))ᵀ I (…)
//!           j·n ≥ 0,  |j_t| ≤ μ j·n,  |c| ≤ b Σ j·n
//! ```
//!
//! with a rolling couple c of each pair. Many sets of impulses explain a body on four corners. That of least
//! Σ jᵀ K j is a continuous function of the motion, so that a steady load stays where it is: each pass adds
//! ε/2 (j − j′)ᵀ K (j − j′) with j′ of the pass before, from zero on (proximal point iteration, Rockafellar
//! 1976). What the first passes leave of a body's motion falls by the factor ε in each.
//!
//! It is not the distribution of the real pressure, which poses do not tell.

use std::ops::Range;

use glam::{DMat3, DVec3};

use super::impulse_fit::{FitBody, FitContact, effective_mass, energy, relative_velocity, within_cone};

/// ε.
const WEIGHT: f64 = 0.1;
/// Passes, which leave ε⁶ of the motion.
const PASSES: usize = 6;
/// Most sweeps over all points in a pass.
const SWEEPS: usize = 60;
/// Change of the impulses in a sweep, relative to the largest, at which a pass ends.
const CONVERGED: f64 = 1e-6;

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

/// Shares the load among all points.
pub(super) fn share_load(bodies: &[FitBody], contacts: &[FitContact], pairs: &[FitPair]) -> SharedLoad {
    let whole: f64 = bodies.iter().map(energy).sum();
    let mass: Vec<DMat3> = contacts.iter().map(|contact| effective_mass(bodies, contact)).collect();
    let inertia: Vec<DMat3> = pairs.iter().map(|pair| effective_inertia(bodies, pair)).collect();
    let mut fit = Fit {
        left: bodies.to_vec(),
        impulses: vec![DVec3::ZERO; contacts.len()],
        couples: vec![DVec3::ZERO; pairs.len()],
    };
    for _ in 0..PASSES {
        let (impulses, couples) = (fit.impulses.clone(), fit.couples.clone());
        for _ in 0..SWEEPS {
            let mut change = 0.0_f64;
            for (k, contact) in contacts.iter().enumerate() {
                change = change.max(fit.push(k, contact, mass[k], impulses[k]));
            }
            for (k, pair) in pairs.iter().enumerate().filter(|(_, pair)| pair.lever > 0.0) {
                let limit = pair.contacts.clone().map(|k| fit.impulses[k].dot(contacts[k].normal)).sum();
                fit.turn(k, (pair, limit), inertia[k], couples[k]);
            }
            let largest = fit.impulses.iter().map(|impulse| impulse.length()).fold(0.0, f64::max);
            if change <= CONVERGED * largest {
                break;
            }
        }
    }
    let rest: f64 = fit.left.iter().map(energy).sum();
    let residual = if whole > 0.0 { rest / whole } else { 0.0 };
    SharedLoad { impulses: fit.impulses, couples: fit.couples, residual }
}

/// What is left of the jumps, and what explains the rest.
struct Fit {
    left: Vec<FitBody>,
    impulses: Vec<DVec3>,
    couples: Vec<DVec3>,
}

impl Fit {
    /// Changes the impulse of one contact towards the best, from that of the pass before. Returns by how
    /// much.
    fn push(&mut self, k: usize, contact: &FitContact, mass: DMat3, before: DVec3) -> f64 {
        let own = self.impulses[k];
        let target = mass * relative_velocity(&self.left, contact) - (own - before) * WEIGHT;
        let next = within_cone(own + target / (1.0 + WEIGHT), contact.normal, contact.friction);
        let step = next - own;
        for (place, sign) in contact.bodies.into_iter().zip([1.0, -1.0]) {
            let body = &mut self.left[place];
            let arm = contact.point - body.centre;
            body.velocity -= step * (sign * body.inverse_mass);
            body.angular_velocity -= body.inverse_inertia * arm.cross(step) * sign;
        }
        self.impulses[k] = next;
        step.length()
    }

    /// The same for the couple of a pair with this sum of normal impulses.
    fn turn(&mut self, k: usize, (pair, load): (&FitPair, f64), inertia: DMat3, before: DVec3) {
        let spin = |place: usize| {
            let body = &self.left[place];
            if body.inverse_mass > 0.0 { body.angular_velocity } else { DVec3::ZERO }
        };
        let own = self.couples[k];
        let target = inertia * (spin(pair.bodies[0]) - spin(pair.bodies[1])) - (own - before) * WEIGHT;
        let next = (own + target / (1.0 + WEIGHT)).clamp_length_max(pair.lever * load.max(0.0));
        for (place, sign) in pair.bodies.into_iter().zip([1.0, -1.0]) {
            let body = &mut self.left[place];
            body.angular_velocity -= body.inverse_inertia * (next - own) * sign;
        }
        self.couples[k] = next;
    }
}

/// (I_a⁻¹ + I_b⁻¹)⁻¹ of a pair [kg m²].
fn effective_inertia(bodies: &[FitBody], pair: &FitPair) -> DMat3 {
    let sum = bodies[pair.bodies[0]].inverse_inertia + bodies[pair.bodies[1]].inverse_inertia;
    if sum.determinant() > 0.0 { sum.inverse() } else { DMat3::ZERO }
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
        let load = share_load(&[block, floor()], &contacts, &pairs);
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
            share_load(&[ball, floor()], &[contact], &pairs)
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
        let load = share_load(&[floor(), floor()], &[contact], &pairs);
        assert_eq!((load.impulses[0], load.couples[0], load.residual), (DVec3::ZERO, DVec3::ZERO, 0.0));
    }
}
