//! The impacts of a timeline, by the bodies that they act on.

use std::collections::BTreeMap;

use clangor_core::body::BodyId;
use clangor_core::contact::ImpactPulse;

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
