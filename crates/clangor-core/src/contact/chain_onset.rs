//! How long an impact takes to travel along a chain of touching or nearly touching bodies.
//!
//! Dynamics passes an impact along a touching chain in no time. Sounded so, the two equal and opposite
//! impulses on each middle body would cancel and only the ends would click. In a real chain the force of
//! contact k peaks about τ/2 after that of contact k − 1, because each body must be pushed before it can push
//! on. Here
//!
//! * an impact that owes more than half of its approach speed to others that began less than τ/2 before it on
//!   one of its bodies begins τ/2 after the one to which it owes most;
//! * impacts of the same instant that did not approach yet follow breadth-first, each τ/2 of its predecessor
//!   later. Where the timeline does not tell who approached, the fastest comes first, the earliest recorded
//!   of equals.
//!
//! So a gap between the bodies goes over smoothly from none to one that is wider than the pulse, two balls
//! struck at the same time sound at the same time, and delays never outlast the chain.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use super::impact_pulse::ImpactPulse;
use crate::body::BodyId;

/// An impact that would approach at less than this share of its speed without those before it owes it to
/// them.
const OWN_APPROACH: f64 = 0.5;

/// Delays onsets along chains; `pulses` are in order of time. Returns how many were delayed.
pub fn delay_chains(pulses: &mut [ImpactPulse]) -> u64 {
    delay_chains_after(pulses, 0)
}

/// As [`delay_chains`], where the onsets of the first `known` pulses are settled: later ones may follow from
/// them.
pub fn delay_chains_after(pulses: &mut [ImpactPulse], known: usize) -> u64 {
    let mut recent: BTreeMap<BodyId, Vec<usize>> = BTreeMap::new();
    let mut first = 0;
    while first < pulses.len() {
        let time = pulses[first].time;
        let count = pulses[first..].iter().take_while(|pulse| pulse.time == time).count();
        let instant = first..first + count;
        recent.values_mut().for_each(|earlier| earlier.retain(|j| passed_on(&pulses[*j]) > time));
        recent.retain(|_, earlier| !earlier.is_empty());
        if first >= known {
            order_instant(pulses, instant.clone(), &recent);
        }
        for index in instant {
            for body in bodies_of(&pulses[index]) {
                recent.entry(body).or_default().push(index);
            }
        }
        first += count;
    }
    pulses.iter().skip(known).filter(|pulse| pulse.onset > pulse.time).count() as u64
}

/// When an impact has pushed its bodies far enough for them to push on \[s\].
fn passed_on(pulse: &ImpactPulse) -> f64 {
    pulse.onset + 0.5 * pulse.duration
}

/// The movable bodies of an impact.
fn bodies_of(pulse: &ImpactPulse) -> impl Iterator<Item = BodyId> + use<> {
    pulse.bodies.map(|share| share.map(|share| share.body)).into_iter().flatten()
}

/// Sets the onsets of the impacts of one instant, given the impacts that still push each body.
fn order_instant(
    pulses: &mut [ImpactPulse],
    instant: std::ops::Range<usize>,
    recent: &BTreeMap<BodyId, Vec<usize>>,
) {
    let mut touching: BTreeMap<BodyId, Vec<usize>> = BTreeMap::new();
    for index in instant.clone() {
        for body in bodies_of(&pulses[index]) {
            touching.entry(body).or_default().push(index);
        }
    }
    let mut reached = vec![false; instant.len()];
    let mut front = VecDeque::new();
    for index in instant.clone() {
        let pushing = bodies_of(&pulses[index]).filter_map(|body| recent.get(&body)).flatten();
        let earlier: BTreeSet<usize> = pushing.copied().collect();
        let pulse = &pulses[index];
        let given: Vec<(f64, usize)> =
            earlier.iter().map(|j| (approach_given(pulse, &pulses[*j]), *j)).collect();
        let before = pulse.velocity_before.map(|velocity| -velocity.dot(pulse.normal));
        // A lone impact approached as its row says; one of several may have been pushed at the same instant.
        let before = before.or((instant.len() == 1).then_some(pulse.speed));
        let own = before.map(|speed| speed - given.iter().map(|(speed, _)| speed).sum::<f64>());
        if own.is_none_or(|own| own < OWN_APPROACH * pulse.speed) {
            let strongest = given.iter().max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(speed, _)| *speed > 0.0);
            let Some((_, cause)) = strongest else { continue };
            pulses[index].onset = passed_on(&pulses[*cause]);
        }
        reached[index - instant.start] = true;
        front.push_back(index);
    }
    let mut by_speed: Vec<usize> = instant.clone().collect();
    by_speed.sort_by(|a, b| pulses[*b].speed.total_cmp(&pulses[*a].speed));
    for fastest in by_speed {
        while let Some(index) = front.pop_front() {
            let onset = passed_on(&pulses[index]);
            for next in bodies_of(&pulses[index]).filter_map(|body| touching.get(&body)).flatten() {
                if !std::mem::replace(&mut reached[next - instant.start], true) {
                    pulses[*next].onset = onset;
                    front.push_back(*next);
                }
            }
        }
        if !std::mem::replace(&mut reached[fastest - instant.start], true) {
            front.push_back(fastest);
        }
    }
}

/// What an earlier impact added to the approach speed of a later one [m/s].
fn approach_given(pulse: &ImpactPulse, earlier: &ImpactPulse) -> f64 {
    let mut given = 0.0;
    for (share, sign) in pulse.bodies.iter().zip([1.0, -1.0]) {
        let Some(share) = share else { continue };
        let arm = pulse.point - share.pose.position;
        for push in earlier.bodies.iter().flatten().filter(|push| push.body == share.body) {
            let velocity = push.velocity_change + push.angular_velocity_change.cross(arm);
            given -= sign * velocity.dot(pulse.normal);
        }
    }
    given
}
