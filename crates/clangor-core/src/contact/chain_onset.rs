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
//! An impact whose points have forces of several shapes has a pulse for each. They begin together, and what
//! the strongest gives is passed on.
//!
//! The delay thus varies continuously with the gap between the bodies. Two balls that are struck at the same
//! time have the same onset. Delays do not extend beyond the chain.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::ops::Range;

use glam::DVec3;

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

/// The pulses of each impact of one instant.
fn impacts_of(pulses: &[ImpactPulse], instant: &Range<usize>) -> Vec<Range<usize>> {
    let is_one = |a: &ImpactPulse, b: &ImpactPulse| {
        a.impact_id == b.impact_id && a.pair == b.pair && a.point == b.point
    };
    let mut first = instant.start;
    let of_one = |own: &[ImpactPulse]| {
        let range = first..first + own.len();
        first = range.end;
        range
    };
    pulses[instant.clone()].chunk_by(is_one).map(of_one).collect()
}

/// The strongest of the pulses of an impact.
fn strongest<'a>(pulses: &'a [ImpactPulse], impact: &Range<usize>) -> &'a ImpactPulse {
    let strength = |pulse: &ImpactPulse| pulse.points.iter().map(|(_, j)| *j).sum::<DVec3>().length();
    let stronger = |best: usize, k: usize| {
        if strength(&pulses[k]) > strength(&pulses[best]) { k } else { best }
    };
    &pulses[impact.clone().fold(impact.start, stronger)]
}

/// Sets the onsets of the impacts of one instant, given the pulses that still push each body.
fn order_instant(pulses: &mut [ImpactPulse], instant: Range<usize>, recent: &BTreeMap<BodyId, Vec<usize>>) {
    let impacts = impacts_of(pulses, &instant);
    let mut touching: BTreeMap<BodyId, Vec<usize>> = BTreeMap::new();
    for (i, impact) in impacts.iter().enumerate() {
        for body in bodies_of(&pulses[impact.start]) {
            touching.entry(body).or_default().push(i);
        }
    }
    let set_onset = |pulses: &mut [ImpactPulse], impact: &Range<usize>, onset: f64| {
        pulses[impact.clone()].iter_mut().for_each(|pulse| pulse.onset = onset);
    };
    let mut reached = vec![false; impacts.len()];
    let mut front = VecDeque::new();
    for (i, impact) in impacts.iter().enumerate() {
        let pulse = &pulses[impact.start];
        let pushing = bodies_of(pulse).filter_map(|body| recent.get(&body)).flatten();
        let earlier: BTreeSet<usize> = pushing.copied().collect();
        let given: Vec<(f64, usize)> =
            earlier.iter().map(|j| (approach_given(pulse, &pulses[*j]), *j)).collect();
        let before = pulse.velocity_before.map(|velocity| -velocity.dot(pulse.normal));
        // A single impact has the approach speed of its row. One of several may result from another at that
        // instant.
        let before = before.or((impacts.len() == 1).then_some(pulse.speed));
        let own = before.map(|speed| speed - given.iter().map(|(speed, _)| speed).sum::<f64>());
        if own.is_none_or(|own| own < OWN_APPROACH * pulse.speed) {
            let cause = given.iter().max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(speed, _)| *speed > 0.0);
            let Some((_, cause)) = cause else { continue };
            let onset = passed_on(&pulses[*cause]);
            set_onset(pulses, impact, onset);
        }
        reached[i] = true;
        front.push_back(i);
    }
    let mut by_speed: Vec<usize> = (0..impacts.len()).collect();
    let speed = |i: usize| pulses[impacts[i].start].speed;
    by_speed.sort_by(|a, b| speed(*b).total_cmp(&speed(*a)));
    for fastest in by_speed {
        while let Some(i) = front.pop_front() {
            let onset = passed_on(strongest(pulses, &impacts[i]));
            for next in bodies_of(&pulses[impacts[i].start]).filter_map(|body| touching.get(&body)).flatten()
            {
                if !std::mem::replace(&mut reached[*next], true) {
                    set_onset(pulses, &impacts[*next], onset);
                    front.push_back(*next);
                }
            }
        }
        if !std::mem::replace(&mut reached[fastest], true) {
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
