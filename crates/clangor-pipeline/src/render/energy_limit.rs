//! Blows put no more energy into the modes of a body than they have.
//!
//! A blow of impulse j and duration τ, whose force has the spectrum Ŝ (Ŝ(0) = 1), leaves a body at rest with
//!
//! ```text
//! E = ½ Σ (U_i(x)·j)² Ŝ(ω_i)²
//! ```
//!
//! in its modes. Impulse and duration are those of rigid bodies, and do not know that the body gives way: at the rim of a
//! thin plate E may be a hundred times the energy ½ m V² with which the two come together. There the force on the modes is
//! scaled so that E is that energy. It is an upper bound, as the click of such a blow is: what the rebound keeps is in it too.

use std::f64::consts::TAU;

use clangor::body::BodyId;
use clangor::contact::ImpactPulse;
use clangor::synthesis::modal::{ModalSource, Resonance};

/// What became of the blows on a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyLimits {
    /// Blows.
    pub blows: u64,
    /// Those of which the force on the modes was scaled.
    pub limited: u64,
    /// Largest E over ½ m V².
    pub largest: f64,
}

/// The blows on a body, with the impulses that its modes get; unscaled without `limit`.
pub(super) fn blows_on(
    body: BodyId,
    source: &ModalSource,
    pulses: &[ImpactPulse],
    limit: bool,
) -> (Vec<ImpactPulse>, EnergyLimits) {
    let mut limits = EnergyLimits::default();
    let mut amplitudes = Vec::new();
    let mut own = Vec::new();
    for pulse in pulses {
        let Some(share) = pulse.bodies.iter().flatten().find(|share| share.body == body) else { continue };
        let to_body = share.pose.orientation.inverse();
        let points: Vec<_> =
            pulse.points.iter().map(|(x, j)| (share.pose.body_from_world(*x), to_body * *j)).collect();
        source.amplitudes(&points, &mut amplitudes);
        let energy = |(amplitude, resonance): (&f64, &Resonance)| {
            let spectrum = pulse.profile.centred_spectrum(TAU * resonance.frequency, pulse.duration);
            0.5 * (amplitude * spectrum).powi(2)
        };
        let gained: f64 = amplitudes.iter().zip(source.resonances()).map(energy).sum();
        let had = 0.5 * pulse.effective_mass * pulse.speed * pulse.speed;
        let ratio = gained / had;
        limits.blows += 1;
        limits.largest = limits.largest.max(ratio);
        let mut pulse = pulse.clone();
        if ratio > 1.0 && ratio.is_finite() {
            limits.limited += 1;
            if limit {
                pulse.points.iter_mut().for_each(|(_, j)| *j *= ratio.sqrt().recip());
            }
        }
        own.push(pulse);
    }
    (own, limits)
}
