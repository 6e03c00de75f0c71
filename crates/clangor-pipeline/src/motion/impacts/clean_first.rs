//! Impacts of bodies that have one alone, before those of bodies with several at a time.
//!
//! The jump of a body that has one impact within its frames is its impulse exactly. Where the other body has
//! several, its jumps are a sum; what the first impact gives to it is taken from them,
//!
//! ```text
//! Δₖ ← Δₖ − (1 − f) J / m,    Δₖ₊₁ ← Δₖ₊₁ − f J / m
//! ```
//!
//! which leaves the others: it may then have one alone, and so on, round by round. Bodies that touch each
//! other and have all their impacts at one instant are one event at once, if it explains their jumps.

use std::collections::BTreeSet;

use clangor_core::body::BodyId;

use super::{Event, Member, Scene, Search};
use crate::motion::jump_windows::JumpWindow;
use crate::motion::recording::RecordedBody;

/// Most rounds. Each may leave one impact alone where there were several.
const ROUNDS: usize = 4;
/// Unexplained share above which an impact waits for the others.
const EXPLAINED: f64 = 0.05;
/// The same of bodies that touch and have all their impacts at one instant.
const AT_ONE_INSTANT: f64 = 0.01;

impl Scene<'_> {
    /// The events of bodies that have one alone; they are no part of what is left of the jumps.
    pub(super) fn clean_events(
        &mut self,
        recorded: &[RecordedBody],
        v_min: f64,
        noise: &[f64],
    ) -> Vec<Event> {
        let mut events = Vec::new();
        for _ in 0..ROUNDS {
            let windows = self.windows_in_order(recorded, v_min, noise);
            let mut done = vec![false; windows.len()];
            let before = events.len();
            // Whose jumps are others by now than those of their windows.
            let mut changed: BTreeSet<BodyId> = BTreeSet::new();
            for index in 0..windows.len() {
                if done[index] || !windows[index].is_clean || self.is_at_end(&windows[index]) {
                    continue;
                }
                // A window whose event is not explained stays in those of the others, or they would have its
                // body at the mean velocity of its frame, without an impact.
                let event = self.event(&windows, index, &done, Search::Clean);
                if let Some((event, used)) = event.filter(|(event, _)| self.is_explained(event)) {
                    done[index] = true;
                    let whole = self.whole_event(&windows, index, &done, &event);
                    let is_unchanged = |member: &Member| !changed.contains(&member.body);
                    let whole = whole.filter(|(event, _)| event.members.iter().all(is_unchanged));
                    let is_whole = whole.is_some();
                    let (event, used) = whole.unwrap_or((event, used));
                    // What is left of the others is another impact.
                    let is_over = |index: &usize| is_whole || windows[*index].is_clean;
                    used.into_iter().filter(is_over).for_each(|index| done[index] = true);
                    self.explain(&event);
                    let moving = event.members.iter().filter(|member| member.fit.inverse_mass > 0.0);
                    changed.extend(moving.map(|member| member.body));
                    events.push(event);
                }
            }
            if events.len() == before {
                break;
            }
        }
        events
    }

    /// The event through all bodies that touch, if it goes farther than the one that ends at bodies with
    /// several impacts, and if all happen at one instant: those of balls that touch each other.
    fn whole_event(
        &self,
        windows: &[JumpWindow],
        index: usize,
        done: &[bool],
        clean: &Event,
    ) -> Option<(Event, Vec<usize>)> {
        if !clean.members.iter().any(Member::is_mixed) {
            return None;
        }
        let (event, used) = self.event(windows, index, done, Search::All)?;
        (event.residual < AT_ONE_INSTANT && self.is_explained(&event)).then_some((event, used))
    }

    /// Whether an event explains its jumps, and what is left of them can be told. That of a part is shared by
    /// the whole.
    fn is_explained(&self, event: &Event) -> bool {
        let is_part = |member: &Member| {
            let group = self.groups[member.body.index()];
            group.is_some() && self.groups.iter().filter(|other| **other == group).count() > 1
        };
        let is_shared = event.members.iter().any(|member| member.window.is_some() && is_part(member));
        event.residual < EXPLAINED && !is_shared
    }

    /// Takes the impulses of an event from what is left of the jumps of its bodies.
    fn explain(&mut self, event: &Event) {
        for (place, member) in event.members.iter().enumerate() {
            let Some(kinematics) = &mut self.kinematics[member.body.index()] else { continue };
            let (impulse, moment) = event.given_to(place);
            match member.window.filter(|window| window.is_clean || member.is_led) {
                // What the fit leaves of it is no other impact, or what a hand gives.
                Some(window) => (window.first..=window.last).for_each(|frame| kinematics.clear(frame)),
                None if member.is_led => {}
                None => kinematics.explain(event.time, (impulse / kinematics.inertia.mass, moment)),
            }
        }
    }
}
