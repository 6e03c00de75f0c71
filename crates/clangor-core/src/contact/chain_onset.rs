//! Delay of impacts along a chain of touching or nearly touching bodies.
//!
//! The dynamics transmit an impact through a touching chain instantaneously. With equal onsets, the two
//! opposite impulses on each inner body would cancel, and only the ends would radiate. In a real chain, the
//! force at contact k peaks about τ/2 after that at contact k − 1, because each body must move before it
//! pushes the next. Therefore:
//!
//! * If more than half of the approach speed of an impact comes from impacts that began less than τ/2 before
//!   it on one of its bodies, it begins τ/2 after the one that contributes most.
//! * Simultaneous impacts whose bodies did not approach yet follow breadth-first, each τ/2 after its
//!   predecessor. Without velocities in the timeline, the fastest impact is first; of equal ones, the one
//!   recorded first.
//!
//! The delay thus varies continuously with the gap between the bodies. Two balls that are struck at the same
//! time have the same onset. Delays do not extend beyond the chain.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use super::impact_pulse::{BodyPulse, ImpactPulse};
use crate::body::BodyId;

/// Share of the approach speed. An impact whose speed falls below it without the impacts before it is caused
/// by them.
const OWN_APPROACH: f64 = 0.5;

/// Delays onsets along chains; `pulses` are in order of time. Returns how many were delayed.
pub fn delay_chains(pulses: &mut [ImpactPulse]) -> u64 {
    delay_chains_after(pulses, 0)
}

/// As [`delay_chains`], with the onsets of the first `known` pulses already settled. Later pulses may follow
/// from them.
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

/// Time at which an impact has moved its bodies enough for them to push on \[s\].
fn passed_on(pulse: &ImpactPulse) -> f64 {
    pulse.onset + 0.5 * pulse.duration
}

/// The movable bodies of an impact.
fn bodies_of(pulse: &ImpactPulse) -> impl Iterator<Item = BodyId> + use<> {
    pulse.bodies.map(|share| share.filter(BodyPulse::moves).map(|share| share.body)).into_iter().flatten()
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
        // A single impact has the approach speed of its row. One of several may result from another at that
        // instant.
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

/// Contribution of an earlier impact to the approach speed of a later one [m/s].
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
