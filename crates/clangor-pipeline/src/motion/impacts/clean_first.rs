//! Impacts of bodies that have one alone, before those of bodies with several at a time.
//!
//! The jump of a body that has one impact within its frames is its impulse exactly. Where the other body has
//! several, its jumps are a sum; what the first impact gives to it is taken from them,
//!
//! ```text
//! Δₖ ← Δₖ − (1 − f) J / m,    Δₖ₊₁ ← Δₖ₊₁ − f J / m
//! ```
//!
//! which leaves the others: it may then have one alone, and so on, round by round.

use super::{Event, Member, Scene, Search};
use crate::motion::recording::RecordedBody;

/// Most rounds. Each may leave one impact alone where there were several.
const ROUNDS: usize = 4;
/// Unexplained share above which an impact waits for the others.
const EXPLAINED: f64 = 0.05;

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
            for index in 0..windows.len() {
                if done[index] || !windows[index].is_clean || self.is_at_end(&windows[index]) {
                    continue;
                }
                // A window whose event is not explained stays in those of the others, or they would have its
                // body at the mean velocity of its frame, without an impact.
                let event = self.event(&windows, index, &done, Search::Clean);
                if let Some((event, used)) = event.filter(|(event, _)| self.is_explained(event)) {
                    done[index] = true;
                    // What is left of the others is another impact.
                    let is_clean = |index: &usize| windows[*index].is_clean;
                    used.into_iter().filter(is_clean).for_each(|index| done[index] = true);
                    self.explain(&event);
                    events.push(event);
                }
            }
            if events.len() == before {
                break;
            }
        }
        events
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
