//! Contacts with what lies behind a thin body, which that body keeps apart.
//!
//! Frames leave the instant of an impact uncertain, and gaps of several millimetres count as touching. A cup
//! on a tray that falls on a floor is then near the floor too, by the thickness of the tray, or as deep in it
//! as the tray is. But whatever pushes the cup up from there is the tray. Along the normal through a point
//! where A and C touch, each body fills an interval, and B keeps them apart where
//!
//! ```text
//! middle of C < middle of B < middle of A,     B fills the point, or one of the two surfaces there
//! ```
//!
//! Middles keep their order as long as bodies do not overlap by half of their thickness. Bodies that lie
//! beside each other, as two planks below one ball, fill no interval of one line.
//!
//! Limits: a thin body that an earlier impact has stopped within the same frame stands at its mean place
//! there, and may seem to lie above what lands on it.

use glam::DVec3;

use super::{FitContact, Member, Scene};
use crate::motion::touch::Touch;
use crate::motion::touching::Placed;

/// Steps to the end of an interval, and the shortest one, as a share of the radius of the body.
const STEPS: usize = 40;
const SHORTEST: f64 = 1e-3;
/// Least difference of the middles, as a share of the thinner interval.
const APART: f64 = 0.25;

/// What a body fills of a line: from and to \[m\].
type Interval = [f64; 2];

impl Scene<'_> {
    /// Removes the points of two bodies between which another member of their event lies.
    pub(super) fn drop_points_behind(&self, members: &[Member], points: &mut Vec<(FitContact, Touch)>) {
        if members.len() < 3 {
            return;
        }
        let mut partners: Vec<Vec<usize>> = vec![Vec::new(); members.len()];
        for [a, b] in points.iter().map(|(contact, _)| contact.bodies) {
            for (one, other) in [(a, b), (b, a)] {
                if !partners[one].contains(&other) {
                    partners[one].push(other);
                }
            }
        }
        let is_behind = |(contact, touch): &(FitContact, Touch)| {
            let [a, c] = contact.bodies;
            let mut between = partners[a].iter().chain(&partners[c]).filter(|b| ![a, c].contains(b));
            let placed = |place: usize| {
                let Member { body, state, .. } = members[place];
                self.placed(body, state.pose)
            };
            between.any(|b| is_between(placed(*b), [a, c].map(placed), touch))
        };
        points.retain(|point| !is_behind(point));
    }
}

/// Whether a body keeps two others apart at a point where they touch.
fn is_between(between: Placed<'_>, [a, c]: [Placed<'_>; 2], touch: &Touch) -> bool {
    let line = Line { origin: touch.point, direction: touch.normal };
    let (face, reach) = (0.5 * touch.gap, 0.5 * touch.gap.abs());
    if line.origin.distance(between.pose.position) > between.sampled.radius + reach {
        return false;
    }
    let Some(own) = [0.0, face, -face].into_iter().find_map(|place| line.filled(between, place)) else {
        return false;
    };
    let inside = |body: Placed<'_>, side: f64| {
        let least = SHORTEST * body.sampled.radius.min(between.sampled.radius);
        line.filled(body, side * (face + least))
    };
    // A corner fills nothing of the line: the body lies on its side.
    let (above, below) = (inside(a, 1.0), inside(c, -1.0));
    let length = |interval: Interval| interval[1] - interval[0];
    let middle = |interval: Interval| 0.5 * (interval[0] + interval[1]);
    let centre = |body: Placed<'_>| (body.pose.position - line.origin).dot(line.direction);
    let apart = |interval: Option<Interval>| {
        APART * interval.map_or(length(own), |interval| length(interval).min(length(own)))
    };
    let middle_of =
        |body: Placed<'_>, interval: Option<Interval>| interval.map_or_else(|| centre(body), middle);
    middle(own) + apart(above) < middle_of(a, above) && middle_of(c, below) + apart(below) < middle(own)
}

/// A line through a point.
struct Line {
    origin: DVec3,
    direction: DVec3,
}

impl Line {
    /// What a body fills of the line around a place on it; `None` where that place is outside.
    fn filled(&self, body: Placed<'_>, place: f64) -> Option<Interval> {
        let depth = |place: f64| -body.signed_distance(self.origin + self.direction * place);
        let shortest = SHORTEST * if body.sampled.radius.is_finite() { body.sampled.radius } else { 1.0 };
        if depth(place) <= 0.0 {
            return None;
        }
        // The depth is a step that stays inside.
        let end = |side: f64| {
            let mut end = place;
            for _ in 0..STEPS {
                let depth = depth(end);
                if depth <= 0.0 {
                    break;
                }
                end += side * depth.max(shortest);
            }
            end
        };
        Some([end(-1.0), end(1.0)])
    }
}
