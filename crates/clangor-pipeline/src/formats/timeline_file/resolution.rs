//! How finely the rows of lasting contacts are stored.
//!
//! A raw log holds thousands of resting contacts in every step, and below its tolerance a solver produces
//! noise that no compressor can shrink: 37 bytes a row for the log of 1000 rocks that fall and settle. Rows
//! of [`ContactKind::Contact`] that belong to no impact are therefore rounded to steps that neither sound nor
//! inspection can tell: points to half a micrometre, speeds to a ten-thousandth of the slowest audible
//! impact, impulses to 1/16384 of the row's impulse, couples to what half a micrometre of lever makes. That
//! leaves 11 bytes. Rounding is to nearest, so sums over many rows stay true. Impacts and all other rows keep
//! every bit of an `f32`.

use clangor_core::timeline::{ContactKind, ContactRow};
use glam::DVec3;

/// Step of points [m]: 0.48 µm.
const POINT: f64 = 1.0 / (1 << 21) as f64;
/// Step of the components of normals: 3.8e-6.
const NORMAL: f64 = 1.0 / (1 << 18) as f64;
/// Step of velocities [m/s]: 3.8 µm/s.
const VELOCITY: f64 = 1.0 / (1 << 18) as f64;
/// Step of overlaps [m]: 7.5 nm.
const DEPTH: f64 = 1.0 / (1 << 27) as f64;
/// Step of impulses, by the power of two under the row's impulse.
const IMPULSE: f64 = 1.0 / (1 << 14) as f64;
/// Step of couple impulses, by the power of two under the row's impulse [m].
const LEVER: f64 = POINT;

/// The row as it is stored.
pub(super) fn stored(row: &ContactRow) -> ContactRow {
    if row.kind != ContactKind::Contact || row.impact_id != 0 {
        return *row;
    }
    let scale = power_of_two_under(row.impulse().length());
    ContactRow {
        point: to_multiple(row.point, POINT),
        normal: to_multiple(row.normal, NORMAL),
        impulse_n: multiple(row.impulse_n, scale * IMPULSE),
        impulse_t: to_multiple(row.impulse_t, scale * IMPULSE),
        couple: to_multiple(row.couple, scale * LEVER),
        velocity: to_multiple(row.velocity, VELOCITY),
        depth: multiple(row.depth, DEPTH),
        ..*row
    }
}

/// The power of two in (x/2, x]; 0 for 0 and for numbers too small for one.
fn power_of_two_under(x: f64) -> f64 {
    const EXPONENT: u64 = 0x7FF << 52;
    f64::from_bits(x.to_bits() & EXPONENT)
}

fn to_multiple(v: DVec3, step: f64) -> DVec3 {
    DVec3::new(multiple(v.x, step), multiple(v.y, step), multiple(v.z, step))
}

/// The multiple of a power of two nearest to `x`; `x` itself for a step of 0.
fn multiple(x: f64, step: f64) -> f64 {
    // Adding zero turns −0 into +0, a sign that would be noise too.
    if step > 0.0 { (x / step).round_ties_even() * step + 0.0 } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_of_two_is_the_largest_not_above() {
        for (x, expected) in [(1.0, 1.0), (1.999, 1.0), (2.0, 2.0), (0.3, 0.25), (0.0, 0.0), (1e-310, 0.0)] {
            assert_eq!(power_of_two_under(x), expected);
        }
        assert_eq!(multiple(-1e-9, POINT).to_bits(), 0);
        assert_eq!(multiple(0.3, 0.0), 0.3);
        assert_eq!(multiple(0.75, 0.5), 1.0);
    }
}
