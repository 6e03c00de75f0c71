//! Restitution of a contact as a function of the approach speed V: the loss of the contact alone.
//!
//! ```text
//! viscous   e_i(V) with x(e_i(V)) = x(e_i) (V/V_i)^{1/5}                        1 − e ∝ V^{1/5} at first
//! plastic   p(V) = min(1, (V₁/V)^{1/4})
//!           V₁ = (c p_d/E*)² √(3 p_d/(2πρ)),  c = 3 π^{5/4} 4^{3/4}/10,  p_d = 3Y
//! pair      e(V) = √(e_A(V) e_B(V)) p(V)
//! ```
//!
//! x is the damping of a viscoelastic contact, s̈ + s^{3/2} + x s^{1/2} ṡ = 0 with a force that never pulls
//! (\[KuwabaraKono1987\], \[SchwagerPoeschel1998\]). A material with a restitution but no speed V_i of it has
//! that restitution at every speed. p(V) is a contact under the constant pressure p_d of fully plastic
//! indentation: loading takes π p_d a⁴/(4R), unloading gives back 3F²/(10aE*) with F = π a² p_d
//! (\[Johnson1985\] §11.5). R drops out for a ball of density ρ on a thick block: ½mV²/R³ = (2π/3) ρV².
//!
//! Differs: of two equal balls m/R³ is four times as large, which lowers p by 16 %; the pair has the
//! geometric mean of the densities, whichever of the two moves. Between the first yield, 27 times below V₁,
//! and V₁ the true loss sets in slowly. A viscous contact loses more the smaller the bodies are; here the
//! restitution of a material holds for any size.
//!
//! A restitution of whole bodies contains their vibration. Where either material has no other, both count
//! with that of whole bodies, because such numbers were estimated for pairs of equals.
//!
//! Not here: vibration of the bodies and waves into half-spaces, which the solve of a contact has. The loss
//! to an endless plate is here for solvers that have only a restitution
//! ([`plate_restitution`]).

use std::f64::consts::PI;

use super::{Material, plate_restitution};

/// Least restitution that has a damping of its own: below, the damping is that of 0.01.
const LEAST: f64 = 0.01;
/// x as a polynomial in L = −ln e, L¹ …: e within 2e-5. Fitted to a DOP853 integration (tolerance 1e-12) at
/// sixty e from 0.995 to 0.01.
const VISCOELASTIC: [f64; 9] = [
    8.655_734_75e-1,
    1.349_890_29e-1,
    1.283_351_80e-1,
    -6.223_942_32e-2,
    3.763_905_44e-2,
    -1.254_013_15e-2,
    2.617_957_60e-3,
    -2.968_956_49e-4,
    1.432_528_05e-5,
];
/// Halvings of the interval of L: 4.6/2⁵⁰ = 4e-15.
const HALVINGS: usize = 50;
/// Pressure of fully plastic indentation over the yield strength \[Johnson1985\].
const INDENTATION: f64 = 3.0;

fn rate_of_logarithm(logarithm: f64) -> f64 {
    VISCOELASTIC.iter().rev().fold(0.0, |sum, c| (sum + c) * logarithm)
}

/// Damping x of a viscoelastic contact of a restitution.
///
/// Restitutions above 1 count as 1, those below 0.01 as 0.01.
pub fn viscoelastic_rate(restitution: f64) -> f64 {
    rate_of_logarithm(-restitution.clamp(LEAST, 1.0).ln())
}

/// Restitution of a viscoelastic contact of damping x, at least 0.01: the inverse of [`viscoelastic_rate`].
pub fn viscoelastic_restitution(rate: f64) -> f64 {
    let (mut low, mut high) = (0.0, -LEAST.ln());
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if rate_of_logarithm(middle) < rate {
            low = middle;
        } else {
            high = middle;
        }
    }
    (-0.5 * (low + high)).exp()
}

/// V₁ [m/s] of a yield strength Y \[Pa\], a density ρ [kg/m³] and the sum 1/E* of the compliances [1/Pa]: the
/// speed above which a contact loses energy by plastic flow.
///
/// # Source
///
/// \[Johnson1985\] §11.5, with ½mV²/R³ = (2π/3) ρV² of a ball on a thick block.
pub fn plastic_speed(yield_strength: f64, density: f64, compliance: f64) -> f64 {
    let pressure = INDENTATION * yield_strength;
    let constant = 0.3 * PI.powf(1.25) * 4.0_f64.powf(0.75);
    (constant * pressure * compliance).powi(2) * (1.5 * pressure / (PI * density)).sqrt()
}

/// Loss of one material of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ViscousLoss {
    /// e, at the speed below.
    restitution: f64,
    /// x at 1 m/s; 0 where e is the same at all speeds.
    rate: f64,
}

impl ViscousLoss {
    const NONE: ViscousLoss = ViscousLoss { restitution: 1.0, rate: 0.0 };

    fn of(material: &Material, whole: bool) -> Self {
        if let Some(restitution) = material.rigid_restitution.filter(|_| whole) {
            return ViscousLoss { restitution, rate: 0.0 };
        }
        let restitution = material.restitution;
        let rate = material.restitution_speed.map_or(0.0, |v| viscoelastic_rate(restitution) / v.powf(0.2));
        ViscousLoss { restitution, rate }
    }

    fn at(&self, speed: f64) -> f64 {
        if self.rate == 0.0 {
            return self.restitution;
        }
        viscoelastic_restitution(self.rate * speed.max(0.0).powf(0.2))
    }
}

/// Coefficient of restitution of a pair of materials at any approach speed; see the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairRestitution {
    /// Geometric mean of the restitutions that the materials state.
    stated: f64,
    materials: [ViscousLoss; 2],
    /// V₁ [m/s]; infinite for materials without a yield strength.
    plastic_speed: f64,
    /// Zener's λ at 1 m/s of an endless plate behind the contact; 0 for none.
    inelasticity: f64,
}

/// √(xy); equal values stay bit-equal, because the square root of a square is not always exact.
pub(super) fn geometric_mean(x: f64, y: f64) -> f64 {
    if x == y { x } else { (x * y).sqrt() }
}

impl PairRestitution {
    /// No loss at any speed.
    pub const LOSSLESS: PairRestitution = PairRestitution {
        stated: 1.0,
        materials: [ViscousLoss::NONE; 2],
        plastic_speed: f64::INFINITY,
        inelasticity: 0.0,
    };

    pub(super) fn of(a: &Material, b: &Material) -> Self {
        let whole = [a, b].iter().any(|m| m.rigid_restitution == Some(m.restitution));
        PairRestitution::of_bodies([a, b], whole)
    }

    /// The pair of whole bodies: vibration, which nothing solves, is in the restitution
    /// ([`Material::rigid_restitution`]).
    pub fn of_whole_bodies(a: &Material, b: &Material) -> Self {
        PairRestitution::of_bodies([a, b], true)
    }

    fn of_bodies([a, b]: [&Material; 2], whole: bool) -> Self {
        let losses = [ViscousLoss::of(a, whole), ViscousLoss::of(b, whole)];
        let least = |x: f64, y: f64| x.min(y);
        let strength = [a, b].iter().filter_map(|m| m.yield_strength).reduce(least);
        let density = geometric_mean(a.density, b.density);
        let compliance = a.contact_compliance() + b.contact_compliance();
        PairRestitution {
            stated: geometric_mean(losses[0].restitution, losses[1].restitution),
            materials: losses,
            plastic_speed: strength.map_or(f64::INFINITY, |y| plastic_speed(y, density, compliance)),
            inelasticity: 0.0,
        }
    }

    /// e at an approach speed V [m/s], 0 to 1; it never rises with V.
    pub fn at(&self, speed: f64) -> f64 {
        let [a, b] = &self.materials;
        let viscous = match a.rate == 0.0 && b.rate == 0.0 {
            true => self.stated,
            false => geometric_mean(a.at(speed), b.at(speed)),
        };
        let plastic = speed > self.plastic_speed;
        let own = if plastic { viscous * (self.plastic_speed / speed).powf(0.25) } else { viscous };
        if self.inelasticity == 0.0 {
            return own;
        }
        let lambda = self.inelasticity * speed.max(0.0).powf(0.2);
        plate_restitution(lambda, viscoelastic_rate(own)).min(own)
    }

    /// The same pair where an endless plate is behind the contact, of this Zener parameter at 1 m/s
    /// ([`inelasticity`](super::thin_plate::inelasticity)): for solvers that do not solve the contact.
    #[must_use]
    pub fn on_plate(self, inelasticity: f64) -> Self {
        PairRestitution { inelasticity, ..self }
    }

    /// Whether slow impacts lose nothing, so that bodies never come to rest.
    pub fn is_lossless(&self) -> bool {
        self.stated >= 1.0 && self.inelasticity == 0.0
    }
}
