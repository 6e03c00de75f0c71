//! The rigid motion of one body against another that comes nearest to the velocities of their contact points.
//!
//! ```text
//! Σ |V + Ω × (pᵢ − p̄) − vᵢ|² → least:    V = v̄,   Σ (|r|² − r rᵀ) Ω = Σ r × (v − V),   r = p − p̄
//! ```
//!
//! A timeline may hold points of one impact that were met at slightly different instants. Their velocities
//! are then no rigid motion: forces between rigid bodies could never bring all of them to rest.

use glam::{DMat3, DVec3};

use super::impact::ContactPoint;

/// Part of the speeds by which velocities of a rigid motion may be off.
const ROUNDING: f64 = 1e-6;
/// Part of the trace added to the matrix of Ω: points on a line do not turn about it.
const ON_A_LINE: f64 = 1e-12;

/// Velocities of A against B at the points \[m/s\]: their own, or those of the nearest rigid motion.
pub(super) fn rigid_velocities(points: &[ContactPoint]) -> Vec<DVec3> {
    let own: Vec<DVec3> = points.iter().map(|point| point.velocity).collect();
    let count = points.len().max(1) as f64;
    let centre = points.iter().map(|point| point.place).sum::<DVec3>() / count;
    let mean = own.iter().sum::<DVec3>() / count;
    let arms = || points.iter().map(|point| point.place - centre);
    let outer = |a: DVec3| DMat3::from_cols(a * a.x, a * a.y, a * a.z);
    let matrix =
        arms().map(|r| DMat3::from_diagonal(DVec3::splat(r.length_squared())) - outer(r)).sum::<DMat3>();
    let trace = matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z;
    let moment = arms().zip(&own).map(|(r, v)| r.cross(*v - mean)).sum::<DVec3>();
    if trace <= 0.0 {
        // All points at one place.
        return vec![mean; points.len()];
    }
    let turn = (matrix + DMat3::from_diagonal(DVec3::splat(ON_A_LINE * trace))).inverse() * moment;
    let rigid: Vec<DVec3> = arms().map(|r| mean + turn.cross(r)).collect();
    let squares = |of: &mut dyn Iterator<Item = DVec3>| of.map(|v| v.length_squared()).sum::<f64>();
    let off = squares(&mut rigid.iter().zip(&own).map(|(a, b)| *a - *b));
    let all = squares(&mut own.iter().copied());
    if off <= ROUNDING * ROUNDING * all { own } else { rigid }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(velocity: impl Fn(DVec3) -> DVec3, places: &[DVec3]) -> Vec<ContactPoint> {
        places.iter().map(|place| ContactPoint::approaching(*place, DVec3::Y, velocity(*place))).collect()
    }

    #[test]
    fn a_rigid_motion_stays_and_others_become_one() {
        let line = [0.0, 0.01, 0.03].map(|x| DVec3::new(x, 1.0, 2.0));
        let corners =
            [[0.0, 0.0], [0.02, 0.0], [0.02, 0.03], [0.0, 0.03]].map(|[x, z]| DVec3::new(x, 0.5, z));
        let turn = DVec3::new(1.0, -2.0, 3.0);
        for places in [&line[..], &corners[..], &corners[..1], &corners[..2]] {
            let given = points(|p| DVec3::new(0.1, -0.4, 0.2) + turn.cross(p), places);
            let own: Vec<DVec3> = given.iter().map(|point| point.velocity).collect();
            assert_eq!(rigid_velocities(&given), own);
        }
        // Corners that come down one after the other: all with their mean, turned as far as a plane can.
        let given = points(|p| DVec3::Y * (-1.0 + 400.0 * p.x * p.z), &corners);
        let rigid = rigid_velocities(&given);
        let flat = rigid[0] - rigid[1] + rigid[2] - rigid[3];
        assert!(flat.length() < 1e-14, "{rigid:?}");
        let (mean, own) = (rigid.iter().sum::<DVec3>(), given.iter().map(|p| p.velocity).sum::<DVec3>());
        assert!((mean - own).length() < 1e-14);
    }
}
