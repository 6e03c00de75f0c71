//! Cylinders and tori: a square grid mapped to a disc, extruded or swept around.
//!
//! The map takes concentric squares to circles: Shirley and Chiu (1997), "A low distortion map between disk
//! and square". The corners of the square lie on the rim, where the diagonals of the grid split them.

use std::f64::consts::{FRAC_PI_4, TAU};

use glam::{DVec2, DVec3};

use super::block::grid;
use super::{TetMesh, TetMeshError};

/// A cylinder about y with `across` elements along the diameter and `along` along the height; sizes \[m\].
///
/// # Errors
/// [`TetMeshError`] for sizes that are not positive and finite, or no elements.
pub fn cylinder(radius: f64, height: f64, across: usize, along: usize) -> Result<TetMesh, TetMeshError> {
    check(&[radius, height], &[across, along])?;
    let cells = [across, across, along];
    let (points, tetrahedra) = grid(cells, |at| {
        let disc = radius * disc(at);
        DVec3::new(disc.x, height * (at.z - 0.5), disc.y)
    });
    let on_side = |p: DVec3| DVec2::new(p.x, p.z).length() > radius * (1.0 - 1e-9);
    TetMesh::curved(points, &tetrahedra, |middle, from, to| {
        if !(on_side(from) && on_side(to)) {
            return middle;
        }
        let out = DVec2::new(middle.x, middle.z).normalize_or_zero() * radius;
        DVec3::new(out.x, middle.y, out.y)
    })
}

/// A torus about y with `across` elements along the diameter of the tube and `around` along its circle; radii
/// \[m\].
///
/// # Errors
/// [`TetMeshError`] for radii that are not positive and finite, a tube wider than its circle, or fewer than
/// three elements around.
pub fn torus(major: f64, minor: f64, across: usize, around: usize) -> Result<TetMesh, TetMeshError> {
    check(&[major, minor, major - minor], &[across, around / 3])?;
    let (mut points, mut tetrahedra) = grid([across, across, around], |at| {
        let disc = minor * disc(at);
        let (sin, cos) = (TAU * at.z).sin_cos();
        DVec3::new((major + disc.x) * cos, disc.y, -(major + disc.x) * sin)
    });
    // The last layer coincides with the first.
    points.truncate(points.len() / (around + 1) * around);
    let count = points.len() as u32;
    tetrahedra.iter_mut().flatten().for_each(|n| *n %= count);
    TetMesh::curved(points, &tetrahedra, |middle, _, _| {
        let circle = DVec3::new(middle.x, 0.0, middle.z).normalize_or_zero() * major;
        circle + (middle - circle).normalize_or_zero() * minor
    })
}

fn check(sizes: &[f64], counts: &[usize]) -> Result<(), TetMeshError> {
    let sound = sizes.iter().all(|s| *s > 0.0 && s.is_finite()) && counts.iter().all(|n| *n > 0);
    if sound { Ok(()) } else { Err(TetMeshError::Empty) }
}

/// Map of the unit square, x and y of `at`, to the unit disc.
pub(super) fn disc(at: DVec3) -> DVec2 {
    let (u, v) = (2.0 * at.x - 1.0, 2.0 * at.y - 1.0);
    if u == 0.0 && v == 0.0 {
        DVec2::ZERO
    } else if u.abs() >= v.abs() {
        DVec2::from_angle(FRAC_PI_4 * v / u) * u
    } else {
        let (sin, cos) = (FRAC_PI_4 * u / v).sin_cos();
        DVec2::new(sin, cos) * v
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn round_bodies_have_their_volume() {
        for n in [2, 4, 8] {
            let error = |mesh: TetMesh, exact: f64| {
                let quality = mesh.quality();
                assert!(quality.least_jacobian > 0.2, "{quality:?}");
                (quality.volume / exact - 1.0).abs()
            };
            let coin = error(cylinder(0.5, 0.3, n, 2).expect("a cylinder"), 0.075 * PI);
            let ring = error(torus(0.4, 0.1, n, 6 * n).expect("a torus"), 0.008 * PI * PI);
            // Seen: 1.9e-2, 9.6e-4, 5.6e-5; 1.4e-2, 1.2e-3, 8.0e-5.
            let bound = 0.4 * (n as f64).powi(-4);
            assert!(coin < bound && ring < bound, "{n}: {coin:.2e} {ring:.2e}");
        }
    }
}
