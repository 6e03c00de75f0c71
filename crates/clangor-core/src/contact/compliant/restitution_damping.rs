//! Damping of a contact that gives a wanted restitution.
//!
//! ```text
//! s̈ + s^{3/2} + α s^{1/4} ṡ = 0     any speed: e depends on α alone
//! s̈ + s^{3/2} + x s^{1/2} ṡ = 0     viscoelastic: x = (3/2) A (k/m)^{2/5} V^{1/5}
//! ```
//!
//! with s = 0, ṡ = 1 at first and e = −ṡ where the force returns to 0: a contact does not pull. Both inverses
//! are polynomials in L = −ln e, fitted to a DOP853 integration (tolerance 1e-12) at sixty e from 0.995 to
//! 0.01; that of x is [`viscoelastic_rate`]. The usual α = −√5 ln e/√(ln² e + π²) forgets the cut of the
//! force and gives 0.55 for 0.5.

use crate::material::pair_restitution::viscoelastic_rate;

/// Least restitution that has a damping of its own: below, the damping is that of 0.01.
const LEAST: f64 = 0.01;
/// α of L¹ …: e within 3e-9.
const CONSTANT: [f64; 9] = [
    7.117_625_84e-1,
    1.442_326_93e-1,
    2.239_949_03e-2,
    2.817_610_80e-3,
    2.980_854_30e-4,
    2.295_859_18e-5,
    2.573_721_28e-6,
    -5.108_185_57e-8,
    1.935_564_10e-8,
];
/// α of [`HertzLaw`](super::HertzLaw) for a restitution of the contact, independent of speed.
///
/// Restitutions above 1 count as 1, those below 0.01 as 0.01.
pub fn restitution_damping(restitution: f64) -> f64 {
    let logarithm = -restitution.clamp(LEAST, 1.0).ln();
    CONSTANT.iter().rev().fold(0.0, |sum, c| (sum + c) * logarithm)
}

/// A of [`HertzLaw`](super::HertzLaw) \[s\] for a restitution at a speed [m/s].
///
/// `stiffness` [N/m^1.5] and `inverse_mass` [1/kg] are those that meet at the contact.
///
/// Restitutions above 1 count as 1, those below 0.01 as 0.01.
pub fn viscosity(restitution: f64, stiffness: f64, inverse_mass: f64, speed: f64) -> f64 {
    let rate = (stiffness * inverse_mass).powf(0.4) * speed.powf(0.2);
    viscoelastic_rate(restitution) / (1.5 * rate)
}
