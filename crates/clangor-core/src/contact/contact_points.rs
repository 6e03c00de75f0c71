//! The contact points of an impact, from the rows of a timeline.
//!
//! A solver of rigid bodies writes a row for each of its steps and each point of its manifold. Rows of an
//! impact that lie within 0.5 % of the smaller body's size of each other, with the same normal, are one
//! point: its impulse is their sum, and what their distance changes of the torque is kept as a couple.
//!
//! A body that lands almost flat touches with one point after another. A point that is first touched later
//! than the impact begins had a gap, which its motion until then closed. Its velocity at the beginning is
//! that of the bodies before the impact, where the timeline has it.

use glam::DVec3;

use super::impact::ContactPoint;
use super::touching::Spread;
use crate::timeline::ContactRow;

/// Largest distance of rows of one point, over the size of the smaller body.
const ONE_POINT: f64 = 5e-3;
/// Least cosine between normals of one point.
const ONE_NORMAL: f64 = 0.98;

/// How the points of an impact on bodies of this size \[m\] share its contact.
pub(super) fn spread(points: &[ContactPoint], size: f64) -> Spread {
    Spread::of_places(points.iter().map(|point| point.place), size, ONE_POINT * size)
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
                    gap: row.approach_speed() * (row.time - time),
                    impulse,
                    couple: row.couple,
                    ..ContactPoint::approaching(row.point, row.normal, before.unwrap_or(row.velocity))
                });
            }
        }
    }
    points
}
