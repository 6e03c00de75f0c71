//! The order in which a touching chain feels a blow.
//!
//! Dynamics solves the impacts of a touching chain at one instant. Sounded at one instant, the two equal and opposite
//! impulses on each middle body would cancel and only the ends would click. In a real chain the force of contact k
//! peaks about τ/2 after that of contact k − 1, because each ball must be compressed before it pushes on.
//!
//! Impacts of exactly equal time that share movable bodies are one chain. The one that approached fastest comes first,
//! the earliest recorded of equals; the others follow breadth-first, each half a duration of its predecessor later.

use std::collections::{BTreeMap, VecDeque};

use super::pulses::ImpactPulse;
use crate::body::BodyId;

/// Delays onsets along chains; `pulses` are in order of time. Returns how many were delayed.
pub fn delay_chains(pulses: &mut [ImpactPulse]) -> u64 {
    pulses.chunk_by_mut(|a, b| a.time == b.time).map(delay_instant).sum()
}

/// Delays the chains of one instant.
fn delay_instant(pulses: &mut [ImpactPulse]) -> u64 {
    if pulses.len() < 2 {
        return 0;
    }
    let mut touching: BTreeMap<BodyId, Vec<usize>> = BTreeMap::new();
    for (index, pulse) in pulses.iter().enumerate() {
        for body in pulse.bodies.iter().flatten() {
            touching.entry(body.body).or_default().push(index);
        }
    }
    let mut by_speed: Vec<usize> = (0..pulses.len()).collect();
    by_speed.sort_by(|a, b| pulses[*b].speed.total_cmp(&pulses[*a].speed));
    let mut reached = vec![false; pulses.len()];
    let mut delayed = 0;
    for first in by_speed {
        if std::mem::replace(&mut reached[first], true) {
            continue;
        }
        let mut front = VecDeque::from([first]);
        while let Some(index) = front.pop_front() {
            let onset = pulses[index].onset + 0.5 * pulses[index].duration;
            for body in pulses[index].bodies.clone().iter().flatten() {
                for &next in &touching[&body.body] {
                    if !std::mem::replace(&mut reached[next], true) {
                        pulses[next].onset = onset;
                        delayed += 1;
                        front.push_back(next);
                    }
                }
            }
        }
    }
    delayed
}
