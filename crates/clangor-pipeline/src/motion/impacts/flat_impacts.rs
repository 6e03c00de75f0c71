//! Impacts of faces, rims and edges that land flat: all points that touch at the same time share the impulse.
//!
//! A fit takes as few points as explain the jumps, and for a cup that lands on its foot that is one in the
//! middle. Where others touch at the same time,
//!
//! ```text
//! gap ≤ gap of the fitted points + |v·n| τ + 2 µm        τ = 2 µs
//! ```
//!
//! the impulses are those of least Σ jᵀ K j that explain as much ([`lasting_fit`](crate::motion)), which
//! excite other modes. Frames that are too long to tell which points touch at the same time (below 600 Hz)
//! keep the fewest. It is not the distribution of the real pressure, which poses do not tell.

use std::ops::Range;

use super::{Event, Search, fit_bodies};
use crate::motion::impulse_fit::FitContact;
use crate::motion::lasting_fit::{FitPair, share_load};

/// Time within which points touch together \[s\]. A coin that lands a little tilted has one point.
const BLOW: f64 = 2e-6;
/// Longest frame that shows which points touch at the same time \[s\]: 600 Hz.
const LONGEST: f64 = 1.0 / 600.0;
/// Difference of gaps that is rounding of the poses \[m\].
const ROUNDING: f64 = 2e-6;
/// Share of the energy of the jumps that may be explained less.
const AS_MUCH: f64 = 0.005;

impl Event {
    /// Shares the impulses of each pair of bodies among the points that touch at the same time, if frames of
    /// this length \[s\] show which do.
    pub(super) fn share(&mut self, search: Search, span: f64) {
        if span > LONGEST {
            return;
        }
        let mut kept: Vec<usize> = Vec::new();
        let mut pairs: Vec<FitPair> = Vec::new();
        let mut from = 0;
        while from < self.points.len() {
            let bodies = self.points[from].0.bodies;
            let count =
                self.points[from..].iter().take_while(|(contact, _)| contact.bodies == bodies).count();
            let first = kept.len();
            kept.extend(self.together(from..from + count));
            pairs.push(FitPair { bodies, contacts: first..kept.len(), lever: 0.0 });
            from += count;
        }
        let pushing = self.impulses.iter().filter(|impulse| impulse.length_squared() > 0.0).count();
        if kept.len() <= pushing {
            return;
        }
        let contacts: Vec<FitContact> = kept.iter().map(|index| self.points[*index].0).collect();
        let shared = share_load(&fit_bodies(&self.members, search), &contacts, &pairs);
        if shared.residual <= self.residual + AS_MUCH {
            self.impulses.fill(glam::DVec3::ZERO);
            for (index, impulse) in kept.into_iter().zip(shared.impulses) {
                self.impulses[index] = impulse;
            }
            self.residual = shared.residual;
        }
    }

    /// The points of a pair that push, and those that touch with them.
    fn together(&self, points: Range<usize>) -> Vec<usize> {
        let is_pushing = |index: &usize| self.impulses[*index].length_squared() > 0.0;
        let pushing = points.clone().filter(is_pushing);
        let reach = |index: usize| {
            let (FitContact { bodies, point, normal, .. }, touch) = self.points[index];
            let [a, b] = bodies.map(|place| self.members[place].state.velocity_at(point));
            touch.gap + (a - b).dot(normal).abs() * BLOW + ROUNDING
        };
        let Some(most) = pushing.map(reach).reduce(f64::max) else { return Vec::new() };
        points.filter(|index| is_pushing(index) || self.points[*index].1.gap <= most).collect()
    }
}
