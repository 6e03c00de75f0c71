//! The contact points of an impact, from the rows of a timeline.
//!
//! A solver of rigid bodies writes a row for each of its steps and each point of its manifold. Rows of an
//! impact that lie within 0.5 % of the smaller body's size of each other, with the same normal, are one
//! point: its impulse is their sum, and what their distance changes of the torque is kept as a couple.
//!
//! A body that lands almost flat touches with one point after another. A point had a gap when the impact began:
//! that of its row, and what its motion closed until then if it is first touched later. Its velocity at the beginning is
//! that of the bodies before the impact, where the timeline has it.

use glam::DVec3;

use super::contact_side::ContactSide;
use super::impact::ContactPoint;
use super::touching::Spread;
use crate::timeline::ContactRow;

/// Largest distance of rows of one point, over the size of the smaller body.
const ONE_POINT: f64 = 5e-3;
/// Fall of the paraboloid, over the largest approach, up to which a point of that gap is the same contact, and
/// the largest deviation of the gap, over the fall.
const NEAR: f64 = 4.0;
const SAME_GAP: f64 = 0.3;
/// Least cosine between normals of one point.
const ONE_NORMAL: f64 = 0.98;

/// The points with those in one that are places of the same contact as a stronger one, either within Hertz's
/// ellipse under its largest `approach` d \[m\], xᵀ (T_A + T_B) x ≤ d, or near it with the gap of its
/// paraboloid, ½ xᵀ (T_A + T_B) x: what such a place takes, the ellipse has already.
pub(super) fn joined(
    mut points: Vec<ContactPoint>,
    sides: &[ContactSide; 2],
    approach: f64,
) -> Vec<ContactPoint> {
    let tensor = sides[0].curvature + sides[1].curvature;
    let least = sides[0].least_curvature.max(sides[1].least_curvature);
    points.sort_by(|a, b| b.impulse.length_squared().total_cmp(&a.impulse.length_squared()));
    let mut kept: Vec<ContactPoint> = Vec::with_capacity(points.len());
    for point in points {
        let within = |other: &&mut ContactPoint| {
            let apart = point.place - other.place;
            let fallen = 0.5 * apart.dot(tensor * apart).max(least * apart.length_squared());
            let gap = (point.gap - other.gap).abs();
            let within = fallen <= 0.5 * approach && gap <= 0.5 * approach;
            let of_paraboloid = fallen <= NEAR * approach && (gap / fallen - 1.0).abs() < SAME_GAP;
            (within || of_paraboloid) && point.normal.dot(other.normal) > ONE_NORMAL
        };
        match kept.iter_mut().find(within) {
            Some(other) => {
                other.couple += point.couple + (point.place - other.place).cross(point.impulse);
                other.impulse += point.impulse;
                other.gap = other.gap.min(point.gap);
            }
            None => kept.push(point),
        }
    }
    kept
}

/// How the points of an impact on bodies of this size \[m\] share its contact: those with a gap that the
/// largest `approach` \[m\] closes, which is half of it (Hertz's ellipse ends where the gap is d/2).
pub(super) fn spread(points: &[ContactPoint], size: f64, approach: f64) -> Spread {
    let pressed = points.iter().filter(|point| point.gap <= 0.5 * approach);
    Spread::of_places(pressed.map(|point| point.place), size, ONE_POINT * size)
}

/// The points of an impact on bodies of this size \[m\], whose first row is at `time` \[s\].
/// `velocity_before` gives the velocity of A relative to B at a place before the impact [m/s], if it is
/// known.
pub(super) fn contact_points(
    rows: &[ContactRow],
    time: f64,
    size: f64,
    velocity_before: impl Fn(DVec3) -> Option<DVec3>,
) -> Vec<ContactPoint> {
    let mut ordered: Vec<&ContactRow> = rows.iter().collect();
    ordered.sort_by(|a, b| a.time.total_cmp(&b.time));
    let mut points: Vec<ContactPoint> = Vec::new();
    for row in ordered {
        let impulse = row.impulse();
        let same = |point: &&mut ContactPoint| {
            point.place.distance(row.point) <= ONE_POINT * size && point.normal.dot(row.normal) > ONE_NORMAL
        };
        match points.iter_mut().find(same) {
            Some(point) => {
                point.impulse += impulse;
                point.couple += row.couple + (row.point - point.place).cross(impulse);
            }
            None => {
                let before = velocity_before(row.point).filter(|_| row.time > time);
                points.push(ContactPoint {
                    gap: (-row.depth).max(0.0) + row.approach_speed() * (row.time - time),
                    impulse,
                    couple: row.couple,
                    ..ContactPoint::approaching(row.point, row.normal, before.unwrap_or(row.velocity))
                });
            }
        }
    }
    let nearest = points.iter().map(|point| point.gap).fold(f64::INFINITY, f64::min);
    points.iter_mut().for_each(|point| point.gap -= nearest);
    points
}
