//! Impacts of faces, rims and edges that land flat: all points that the contact closes share the impulse.
//!
//! A fit takes as few points as explain the jumps, and for a cup that lands on its foot that is one. While
//! the surfaces give way by Hertz's largest approach d, other points come into contact, the later and the
//! less the wider their gap is: parallel springs that are shortened by δ(t) − g have, of the impulse of the
//! first, about the share
//!
//! ```text
//! w = (1 − (g − g₀)/(β d))²        g₀ smallest gap, g − g₀ < β d, β = ¼
//! ```
//!
//! and 0.001 at least; a point of the fit with a wider gap keeps w = 1. The impulses are those of least
//! Σ |j|²/(m_j w) that explain as much as the fit ([`lasting_fit`](crate::motion)), which excite other modes
//! than a single one.
//!
//! Frames below 600 Hz are too long to tell gaps of micrometres, and have in one jump what the slaps of a
//! body that lands almost flat give one after the other. There the gap closes by the approach V in a short
//! time: g − g₀ < V T. Where the centre of the pressure is an edge or a corner, the least Σ |j|² leaves the
//! impulse there whatever lies around it. Impacts of several pairs at once keep the fewest points there.
//!
//! It is not the distribution of the real pressure, which poses do not tell; the renderer solves the contact
//! at these points.

use std::collections::BTreeSet;
use std::ops::Range;

use clangor_core::contact::touching::{Spread, Touch as Touching, touching};
use clangor_core::contact::{ContactSide, Impact};
use glam::DVec3;

use super::{Event, Scene, Search, fit_bodies};
use crate::motion::impulse_fit::FitContact;
use crate::motion::lasting_fit::{EXPLAINED_OF_IMPACT, FitPair, share_load};

/// β. The points that simulations of coins and dice write fit ⅔: several are stiffer than the one whose
/// approach is d. On meshes with a vertex per millimetre of a rim, whose gaps are known less well, ¼ gives
/// the sound that is nearest to theirs.
const CLOSED: f64 = 0.25;
/// Longest frame that shows such gaps \[s\]: 600 Hz.
const LONGEST: f64 = 1.0 / 600.0;
/// T: slaps within it count as one impact in longer frames \[s\].
const SLAPS: f64 = 3e-4;
/// Difference of gaps that is rounding of the poses, over their coordinates: two digits of a 32-bit number.
const ROUNDING: f64 = 2.0 * f32::EPSILON as f64;
/// Least w of a point that takes part.
const LEAST_SHARE: f64 = 1e-3;
/// Share of the energy of the jumps that may be explained less; in long frames, where the fit has several
/// impacts as one, less than that.
const AS_MUCH: f64 = 0.005;
const AS_MUCH_IN_LONG: f64 = 1e-4;

impl Event {
    /// Shares the impulses of each pair of bodies among the points that the contact closes.
    pub(super) fn share(&mut self, scene: &Scene<'_>, search: Search) {
        // What several pairs give each other within a long frame, fewest points say best.
        if self.is_coarse() && self.pushing_pairs() > 1 {
            return;
        }
        let mut kept: Vec<(usize, f64)> = Vec::new();
        let mut pairs: Vec<FitPair> = Vec::new();
        let mut from = 0;
        while from < self.points.len() {
            let bodies = self.points[from].0.bodies;
            let count =
                self.points[from..].iter().take_while(|(contact, _)| contact.bodies == bodies).count();
            let first = kept.len();
            kept.extend(self.together(scene, from..from + count));
            pairs.push(FitPair { bodies, contacts: first..kept.len(), lever: 0.0 });
            from += count;
        }
        let pushing = self.impulses.iter().filter(|impulse| impulse.length_squared() > 0.0).count();
        if kept.len() <= pushing {
            return;
        }
        let contacts: Vec<FitContact> = kept.iter().map(|(index, _)| self.points[*index].0).collect();
        let shares: Vec<f64> = kept.iter().map(|(_, share)| *share).collect();
        let bodies = fit_bodies(&self.members, search);
        let shared = share_load(&bodies, (&contacts, &shares), &pairs, EXPLAINED_OF_IMPACT);
        let as_much = if self.is_coarse() { AS_MUCH_IN_LONG } else { AS_MUCH };
        if shared.residual <= self.residual + as_much {
            self.impulses.fill(DVec3::ZERO);
            for ((index, _), impulse) in kept.into_iter().zip(shared.impulses) {
                self.impulses[index] = impulse;
            }
            self.residual = shared.residual;
        }
    }

    /// The points of a pair that push, and those that the contact closes with them, with w.
    fn together(&self, scene: &Scene<'_>, points: Range<usize>) -> Vec<(usize, f64)> {
        let is_pushing = |index: &usize| self.impulses[*index].length_squared() > 0.0;
        let pushing = || points.clone().filter(is_pushing);
        let strongest = pushing()
            .max_by(|a, b| self.impulses[*a].length_squared().total_cmp(&self.impulses[*b].length_squared()));
        let Some(strongest) = strongest else { return Vec::new() };
        let gap = |index: usize| self.points[index].1.gap;
        let nearest = pushing().map(gap).fold(f64::INFINITY, f64::min);
        let closed = self.closed_gap(scene, strongest) + self.slapped_gap(strongest);
        let share = |index: usize| {
            let open = ((gap(index) - nearest) / closed).max(0.0);
            match (open < 1.0, is_pushing(&index)) {
                (true, _) => Some((index, (1.0 - open).powi(2).max(LEAST_SHARE))),
                (false, true) => Some((index, 1.0)),
                (false, false) => None,
            }
        };
        points.clone().filter_map(share).collect()
    }

    /// How much wider than the smallest gap those are that a contact with this strongest point closes \[m\].
    pub(super) fn closed_gap(&self, scene: &Scene<'_>, strongest: usize) -> f64 {
        let rounding = ROUNDING * self.points[strongest].0.point.abs().max_element();
        match self.is_coarse() {
            true => rounding,
            false => CLOSED * self.largest_approach(scene, strongest) + rounding,
        }
    }

    /// How much wider the gaps are that slaps of the same impact close in long frames \[m\].
    fn slapped_gap(&self, strongest: usize) -> f64 {
        if self.is_coarse() { SLAPS * self.approach_at(strongest).max(0.0) } else { 0.0 }
    }

    /// Number of pairs of bodies that push each other.
    fn pushing_pairs(&self) -> usize {
        let pushing = self.points.iter().zip(&self.impulses);
        let pushing = pushing.filter(|(_, impulse)| impulse.length_squared() > 0.0);
        pushing.map(|((contact, _), _)| contact.bodies).collect::<BTreeSet<_>>().len()
    }

    /// Whether the frames are too long to tell which points the contact closes.
    pub(super) fn is_coarse(&self) -> bool {
        let spans = self.members.iter().filter_map(|member| member.window).map(|window| window.span);
        spans.fold(0.0, f64::max) > LONGEST
    }

    /// Speed at which the surfaces approach at a point [m/s].
    fn approach_at(&self, index: usize) -> f64 {
        let FitContact { bodies, point, normal, .. } = self.points[index].0;
        let [a, b] = bodies.map(|place| self.members[place].state.velocity_at(point));
        -(a - b).dot(normal)
    }

    /// Hertz's largest approach at a point \[m\]; 0 where the surfaces do not approach there.
    fn largest_approach(&self, scene: &Scene<'_>, index: usize) -> f64 {
        let FitContact { bodies, point, normal, .. } = self.points[index].0;
        let members = bodies.map(|place| &self.members[place]);
        let body = |i: usize| &scene.world.bodies[members[i].body.index()];
        let speed = self.approach_at(index);
        if speed <= 0.0 {
            return 0.0;
        }
        let size = body(0).surface.bounding_radius().min(body(1).surface.bounding_radius());
        let surfaces = [0, 1].map(|i| Some(&*body(i).surface));
        let touch = Touching { surfaces, normal, place: point, speed, spread: Spread::single(size) };
        let side = |i: usize| ContactSide::of_body(members[i].body, body(i), members[i].state.pose);
        let sides = touching([side(0), side(1)], &touch);
        let approach =
            Impact::with_restitution(sides, point, normal, speed, 0.0).hertz().0.largest_approach();
        if approach.is_finite() { approach } else { 0.0 }
    }
}
