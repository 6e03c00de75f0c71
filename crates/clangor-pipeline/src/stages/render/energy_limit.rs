//! Counts of the impacts whose forces on modes are bounded by the energy of the approach
//! ([`clangor_core::contact::modal_energy`]).

use std::collections::BTreeMap;

use clangor_core::body::BodyId;
use clangor_core::contact::ImpactPulse;

/// The impacts on a body, and those of them that are bounded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyLimits {
    /// Impacts.
    pub impacts: u64,
    /// Those whose rigid-body forces would give more energy to modes than the approach has.
    pub limited: u64,
    /// Largest ratio of these energies.
    pub largest: f64,
}

impl EnergyLimits {
    /// Counts the impacts on one body.
    pub(super) fn count(impacts: &[ImpactPulse]) -> Self {
        EnergyLimits {
            impacts: impacts.len() as u64,
            limited: impacts.iter().filter(|pulse| pulse.modal_energy_ratio > 1.0).count() as u64,
            largest: impacts.iter().map(|pulse| pulse.modal_energy_ratio).fold(0.0, f64::max),
        }
    }
}

/// The pulses by body, each once for each body that it acts on, in their order.
pub(super) fn impacts_by_body(pulses: &[ImpactPulse]) -> BTreeMap<BodyId, Vec<ImpactPulse>> {
    let mut impacts: BTreeMap<BodyId, Vec<ImpactPulse>> = BTreeMap::new();
    for pulse in pulses {
        let mut bodies: Vec<BodyId> = pulse.bodies.iter().flatten().map(|share| share.body).collect();
        bodies.dedup();
        for body in bodies {
            impacts.entry(body).or_default().push(pulse.clone());
        }
    }
    impacts
}
