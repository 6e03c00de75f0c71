//! The contact points of an impact, from the rows of a timeline.
//!
//! A solver of rigid bodies writes a row for each of its steps and each point of its manifold. Rows of an
//! impact that lie within 0.5 % of the smaller body's size of each other, with the same normal, are one
//! point: its impulse is their sum, and what their distance changes of the torque is kept as a couple.
//!
//! Places of one elastic contact are one point too ([`joined`]): a solver of rigid bodies has several points
//! along the rim of a coin, all within the ellipse that the coin presses into the floor.
//!
//! A body that lands almost flat touches with one point after another. A point that is first touched later
//! than the impact begins had a gap, which its motion until then closed. Its velocity at the beginning is
//! that of the bodies before the impact, where the timeline has it.

use glam::DVec3;

use super::contact_side::ContactSide;
use super::impact::ContactPoint;
use super::touching::Spread;
use crate::timeline::ContactRow;

/// Largest distance of rows of one point, over the size of the smaller body.
const ONE_POINT: f64 = 5e-3;
/// Fall of the paraboloid, over the largest approach, up to which a point of that gap is the same contact,
/// and the largest deviation of the gap, over the fall.
const NEAR: f64 = 4.0;
const SAME_GAP: f64 = 0.3;
/// Least cosine between normals of one point.
const ONE_NORMAL: f64 = 0.98;

/// A point, and how much farther from the other surface it lies at the first instant than the nearest one
/// \[m\].
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedPoint {
    pub(super) point: ContactPoint,
    pub(super) fall: f64,
}

/// The points of an impact on bodies of this size \[m\]. `velocity_before` gives the velocity of A relative
/// to B at a place before the impact [m/s], if it is known.
pub(super) fn contact_points(
    rows: &[ContactRow],
    size: f64,
    velocity_before: impl Fn(DVec3) -> Option<DVec3>,
) -> Vec<PlacedPoint> {
    let mut ordered: Vec<&ContactRow> = rows.iter().collect();
    ordered.sort_by(|a, b| a.time.total_cmp(&b.time));
    let time = ordered.first().map_or(0.0, |row| row.time);
    let mut points: Vec<PlacedPoint> = Vec::new();
    for row in ordered {
        let impulse = row.impulse();
        let same = |PlacedPoint { point, .. }: &&mut PlacedPoint| {
            point.place.distance(row.point) <= ONE_POINT * size && point.normal.dot(row.normal) > ONE_NORMAL
        };
        match points.iter_mut().find(same) {
            Some(PlacedPoint { point, .. }) => {
                point.impulse += impulse;
                point.couple += row.couple + (row.point - point.place).cross(impulse);
            }
            None => {
                let before = velocity_before(row.point).filter(|_| row.time > time);
                let point = ContactPoint {
                    gap: row.approach_speed() * (row.time - time),
                    impulse,
                    couple: row.couple,
                    ..ContactPoint::approaching(row.point, row.normal, before.unwrap_or(row.velocity))
                };
                points.push(PlacedPoint { point, fall: point.gap + (-row.depth).max(0.0) });
            }
        }
    }
    let nearest = points.iter().map(|point| point.fall).fold(f64::INFINITY, f64::min);
    points.iter_mut().for_each(|point| point.fall -= nearest);
    points
}

/// The points with those in one that are places of the same contact as a stronger one, either within Hertz's
/// ellipse under its largest `approach` d \[m\], xᵀ (T_A + T_B) x ≤ d, or near it with the gap of its
/// paraboloid, ½ xᵀ (T_A + T_B) x: what such a place takes, the ellipse has already.
pub(super) fn joined(
    mut points: Vec<PlacedPoint>,
    sides: &[ContactSide; 2],
    approach: f64,
) -> Vec<PlacedPoint> {
    let tensor = sides[0].curvature + sides[1].curvature;
    let least = sides[0].least_curvature.max(sides[1].least_curvature);
    let strength = |placed: &PlacedPoint| placed.point.impulse.length_squared();
    points.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
    let mut kept: Vec<PlacedPoint> = Vec::with_capacity(points.len());
    for PlacedPoint { point, fall } in points {
        let within = |PlacedPoint { point: other, fall: other_fall }: &&mut PlacedPoint| {
            let apart = point.place - other.place;
            let fallen = 0.5 * apart.dot(tensor * apart).max(least * apart.length_squared());
            let gap = (fall - *other_fall).abs();
            let within = fallen <= 0.5 * approach && gap <= 0.5 * approach;
            let of_paraboloid = fallen <= NEAR * approach && (gap / fallen - 1.0).abs() < SAME_GAP;
            (within || of_paraboloid) && point.normal.dot(other.normal) > ONE_NORMAL
        };
        match kept.iter_mut().find(within) {
            Some(PlacedPoint { point: other, .. }) => {
                other.couple += point.couple + (point.place - other.place).cross(point.impulse);
                other.impulse += point.impulse;
                other.gap = other.gap.min(point.gap);
            }
            None => kept.push(PlacedPoint { point, fall }),
        }
    }
    kept
}

/// How the points of an impact on bodies of this size \[m\] share its contact: those with a gap that the
/// largest `approach` \[m\] closes, which is half of it (Hertz's ellipse ends where the gap is d/2).
pub(super) fn spread(points: &[PlacedPoint], size: f64, approach: f64) -> Spread {
    let pressed = points.iter().filter(|placed| placed.fall <= 0.5 * approach);
    Spread::of_places(pressed.map(|placed| placed.point.place), size, ONE_POINT * size)
}
