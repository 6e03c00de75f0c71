//! Impacts put no more energy into the modes of a body than the motion lost.
//!
//! An impact of impulse j and duration τ, whose force has the spectrum Ŝ (Ŝ(0) = 1), leaves a body at rest
//! with
//!
//! ```text
//! E(τ) = ½ Σ (U_i(x)·j)² Ŝ(ω_i τ)²
//! ```
//!
//! in its modes. Impulse and duration are those of rigid bodies, and do not know that the body gives way: at
//! the rim of a thin plate E may be a hundred times what the motion of the two lost, which for an approach at
//! speed V with effective mass m, pushed apart by the normal impulse j_n, is
//!
//! ```text
//! E₀ = j_n V − j_n²/(2 m) = ½ j_n V (1 − e),   e = j_n/(m V) − 1
//! ```
//!
//! There the contact is soft, and lasts longer: the force on the modes is given the shortest duration τ' ≥ τ
//! with E(τ') ≤ E₀, and keeps its impulse, which is what the bodies exchanged. It is an upper bound still:
//! the ground, crushing and cracks take their part of E₀ as well, and a body struck again while it rings may
//! gain more. Rolling is not limited, and neither are clicks, which are those of rigid bodies. For the
//! release of a crack E₀ is ½ m V², the energy that its impulse and couple alone would give to pieces at
//! rest.

use std::f64::consts::TAU;

use clangor_core::body::BodyId;
use clangor_core::contact::ImpactPulse;
use clangor_core::synthesis::modal::{ModalSource, Resonance, StrikeMemory};
use glam::DVec3;

/// Two solid bodies lose a little even where a scene says that they do not: at least what they lose at this
/// restitution.
const MOST_ELASTIC: f64 = 0.95;

/// τ' is found to this part of itself.
const DURATION_TOLERANCE: f64 = 1e-3;

/// What became of the impacts on a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyLimits {
    /// Impacts.
    pub impacts: u64,
    /// Those that were lengthened for the modes.
    pub limited: u64,
    /// Largest E(τ)/E₀.
    pub largest: f64,
    /// Largest τ'/τ; 1 where none was lengthened.
    pub longest: f64,
}

/// The impacts on a body, with the durations that its modes feel; their own without `limit`.
pub(crate) fn impacts_on(
    body: BodyId,
    source: &ModalSource,
    pulses: &[ImpactPulse],
    limit: bool,
) -> (Vec<ImpactPulse>, EnergyLimits) {
    let mut limits = EnergyLimits { longest: 1.0, ..Default::default() };
    let (mut amplitudes, mut striking) = (Vec::new(), StrikeMemory::default());
    let mut own = Vec::new();
    for pulse in pulses {
        let Some(share) = pulse.bodies.iter().flatten().find(|share| share.body == body) else { continue };
        let to_body = share.pose.orientation.inverse();
        let points: Vec<_> =
            pulse.points.iter().map(|(x, j)| (share.pose.body_from_world(*x), to_body * *j)).collect();
        source.amplitudes(&points, &mut striking, &mut amplitudes);
        let gained = |duration: f64| {
            let of_mode = |(amplitude, resonance): (&f64, &Resonance)| {
                let spectrum = pulse.profile.centred_spectrum(TAU * resonance.frequency, duration);
                0.5 * (amplitude * spectrum).powi(2)
            };
            amplitudes.iter().zip(source.resonances()).map(of_mode).sum::<f64>()
        };
        let lost = energy_lost(pulse);
        let ratio = gained(pulse.duration) / lost;
        limits.impacts += 1;
        limits.largest = limits.largest.max(ratio);
        let mut pulse = pulse.clone();
        if ratio > 1.0 && ratio.is_finite() {
            limits.limited += 1;
            let duration = shortest_duration(gained, lost, pulse.duration);
            limits.longest = limits.longest.max(duration / pulse.duration);
            if limit {
                pulse.duration = duration;
            }
        }
        own.push(pulse);
    }
    (own, limits)
}

/// E₀ \[J\].
pub(super) fn energy_lost(pulse: &ImpactPulse) -> f64 {
    if pulse.is_crack() {
        return 0.5 * pulse.effective_mass * pulse.speed * pulse.speed;
    }
    let impulse = pulse.points.iter().map(|(_, j)| *j).sum::<DVec3>().dot(pulse.normal).abs();
    let restitution = impulse / (pulse.effective_mass * pulse.speed) - 1.0;
    0.5 * impulse * pulse.speed * (1.0 - restitution.min(MOST_ELASTIC))
}

/// The shortest duration from `duration` on with which `gained` is at most `lost`, which a long one always
/// reaches: a force that rises and falls slowly leaves nothing in a mode.
fn shortest_duration(gained: impl Fn(f64) -> f64, lost: f64, duration: f64) -> f64 {
    let (mut short, mut long) = (duration, 1.25 * duration);
    while gained(long) > lost {
        (short, long) = (long, 1.25 * long);
    }
    while long - short > DURATION_TOLERANCE * short {
        let middle = 0.5 * (short + long);
        if gained(middle) > lost { short = middle } else { long = middle }
    }
    long
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use clangor_core::contact::{BodyPulse, ForceProfile};
    use clangor_core::material::Damping;
    use clangor_core::medium::Medium;
    use clangor_core::pose::Pose;
    use clangor_core::sound_model::modal::model::{ModalMode, ModalModel, ModalTransfer};
    use clangor_core::sound_model::modal::surface::ModalSurface;
    use clangor_core::synthesis::modal::ModalSettings;
    use glam::DVec3;
    use num_complex::Complex64;

    use super::*;

    /// A triangle that moves along y as a whole, with U = 10.
    fn source() -> ModalSource {
        let nodes = [[1.0, 0.0], [-1.0, 1.0], [-1.0, -1.0], [0.0, 0.5], [-1.0, 0.0], [0.0, -0.5]];
        let nodes = nodes.map(|[x, z]| DVec3::new(x, 0.0, z)).to_vec();
        let mode = ModalMode {
            frequency: 100.0,
            mesh_error: 0.0,
            shape: vec![10.0 * DVec3::Y; 6],
            transfer: Some(ModalTransfer { order: 0, coefficients: vec![Complex64::ONE] }),
        };
        let model = ModalModel {
            radius: 1.5,
            medium: Medium::AIR,
            density: 1000.0,
            max_frequency: 200.0,
            surface: ModalSurface { nodes, triangles: vec![[0, 1, 2, 3, 4, 5]] },
            modes: vec![mode],
        };
        ModalSource::new(Arc::new(model), &Damping::LossFactor(1e-3), &ModalSettings::default())
            .expect("modes")
    }

    fn impact(speed: f64) -> ImpactPulse {
        let share = BodyPulse {
            body: BodyId(0),
            pose: Pose::IDENTITY,
            impulse: DVec3::Y,
            velocity_change: DVec3::Y,
            angular_impulse: DVec3::ZERO,
            angular_velocity_change: DVec3::ZERO,
            transit_ratio: 1.0,
        };
        ImpactPulse {
            impact_id: 0,
            time: 0.0,
            onset: 0.0,
            duration: 1e-6,
            profile: ForceProfile::HalfSine,
            speed,
            effective_mass: 1.0,
            radius: 0.1,
            point: DVec3::ZERO,
            normal: DVec3::Y,
            velocity_before: None,
            pair: [BodyId(0), BodyId::WORLD],
            bodies: [Some(share), None],
            points: vec![(DVec3::ZERO, DVec3::Y)],
        }
    }

    #[test]
    fn modes_get_no_more_than_the_motion_lost() {
        // E = ½ (10 N s kg^−½)² = 50 J. A unit impulse on 1 kg stops 1 m/s, which loses ½ J, and turns half
        // of 0.5 m/s around: nothing is lost, so e = 0.95 is taken. At 200 m/s it takes 199.5 J of the
        // motion.
        let pulses = [impact(1.0), impact(0.5), impact(200.0)];
        let (impacts, limits) = impacts_on(BodyId(0), &source(), &pulses, true);
        let gained = |i: usize| {
            let spectrum = ForceProfile::HalfSine.centred_spectrum(TAU * 100.0, impacts[i].duration);
            50.0 * spectrum * spectrum
        };
        assert!(gained(0) <= 0.5 && gained(0) > 0.49, "{}", gained(0));
        assert!(gained(1) <= 0.0125 && gained(1) > 0.012, "{}", gained(1));
        assert_eq!(impacts[2], pulses[2]);
        // The impulse stays.
        assert_eq!(impacts[0].points, pulses[0].points);
        // Residual seen: 2e-8, the spectrum of 1 µs at 100 Hz.
        assert!((limits.largest / 4000.0 - 1.0).abs() < 1e-6, "{limits:?}");
        assert_eq!((limits.impacts, limits.limited), (3, 2));
        assert!(
            (limits.longest * pulses[1].duration / impacts[1].duration - 1.0).abs() < 1e-12,
            "{limits:?}"
        );
        let (impacts, reported) = impacts_on(BodyId(0), &source(), &pulses, false);
        assert_eq!((impacts, reported), (pulses.to_vec(), limits));
        assert!(impacts_on(BodyId(1), &source(), &pulses, true).0.is_empty());
    }
}
