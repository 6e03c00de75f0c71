//! The eight mirror images of an octant, and the parity of the six rigid motions in them.
//!
//! A body symmetric about the three coordinate planes has six parity classes, one for each rigid motion: a
//! translation along x is odd in x and even in y and z; a rotation about x is even in x and odd in y and z
//! (\[PROXY\] eqs. (16)–(21)). The pressure has the parity of the motion, so that each motion is a problem on
//! one octant.

#![allow(
    clippy::needless_range_loop,
    reason = "loops over lanes, several arrays at one index, that become vector instructions"
)]

use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;

/// Mirror images of an octant; bit 0 mirrors x, bit 1 y, bit 2 z.
pub(super) const IMAGES: usize = 8;

/// Coordinates in which the pressure of each motion is odd, as the bits of an image.
const ODD: [usize; RIGID_DOFS] = [0b001, 0b010, 0b100, 0b110, 0b101, 0b011];

/// An image of a point.
pub(super) fn mirror(image: usize, x: DVec3) -> DVec3 {
    let side = |bit: usize| if image >> bit & 1 == 1 { -1.0 } else { 1.0 };
    x * DVec3::new(side(0), side(1), side(2))
}

/// +1 or −1: the pressure of a motion at an image over that at the original.
pub(super) fn sign_of(image: usize, degree: usize) -> f64 {
    if (image & ODD[degree]).count_ones() % 2 == 1 { -1.0 } else { 1.0 }
}

/// Transforms values at the eight images into the signed sums of the six motions, in three rounds of sums and
/// differences.
#[inline(always)]
pub(super) fn sums_by_motion<const F: usize>(
    mut values: [[[f64; F]; 2]; IMAGES],
) -> [[[f64; F]; 2]; RIGID_DOFS] {
    for bit in 0..3 {
        for image in 0..IMAGES {
            let other = image | 1 << bit;
            if other == image {
                continue;
            }
            for part in 0..2 {
                for f in 0..F {
                    let (a, b) = (values[image][part][f], values[other][part][f]);
                    values[image][part][f] = a + b;
                    values[other][part][f] = a - b;
                }
            }
        }
    }
    ODD.map(|odd| values[odd])
}

/// Whether Y_nm has the parity of a motion. Other harmonics do not occur in its field.
pub(super) fn allows(degree: usize, n: usize, m: isize) -> bool {
    // Under x → −x, φ → π − φ: cos mφ takes (−1)^m, sin mφ (−1)^{m+1}. Under z → −z: P_n^m takes (−1)^{n+m}.
    let sine = usize::from(m < 0);
    let order = m.unsigned_abs();
    ODD[degree] == ((order + sine) % 2) | (sine << 1) | (((n + order) % 2) << 2)
}

#[cfg(test)]
mod tests {
    use clangor_core::math::spherical_harmonics::{count, index, solid_harmonics};

    use super::*;
    use crate::radiation::rigid_motions;

    #[test]
    fn motions_and_harmonics_have_their_parity() {
        let (x, n) = (DVec3::new(0.3, -0.4, 0.7), DVec3::new(0.5, 0.2, -0.9));
        let (mut here, mut there) = (Vec::new(), Vec::new());
        solid_harmonics(x, 7, &mut here);
        for image in 0..IMAGES {
            let mirrored = rigid_motions(mirror(image, x), mirror(image, n));
            solid_harmonics(mirror(image, x), 7, &mut there);
            for (degree, motion) in rigid_motions(x, n).into_iter().enumerate() {
                assert!((mirrored[degree] - sign_of(image, degree) * motion).abs() < 1e-15);
                for n in 0..=7 {
                    for m in -(n as isize)..=n as isize {
                        if allows(degree, n, m) {
                            let i = index(n, m);
                            assert!((there[i] - sign_of(image, degree) * here[i]).abs() < 1e-14);
                        }
                    }
                }
            }
        }
        // Each harmonic belongs to one of the eight parities; n = 0 and n = 3, m = −2 to none of the motions.
        let motions = |n, m| (0..RIGID_DOFS).filter(|&d| allows(d, n, m)).count();
        assert_eq!((motions(0, 0), motions(3, -2), motions(1, 1), motions(2, 1)), (0, 0, 1, 1));
        let all: usize = (0..=7).flat_map(|n| (-(n as isize)..=n as isize).map(move |m| motions(n, m))).sum();
        assert!(all < count(7));
    }

    #[test]
    fn sums_are_the_signed_sums() {
        let values: [[[f64; 1]; 2]; IMAGES] =
            std::array::from_fn(|image| [[(image * image + 1) as f64], [(3 * image) as f64 - 7.5]]);
        for (degree, sum) in sums_by_motion(values).into_iter().enumerate() {
            for part in 0..2 {
                let expected: f64 =
                    (0..IMAGES).map(|image| sign_of(image, degree) * values[image][part][0]).sum();
                assert_eq!(sum[part][0], expected);
            }
        }
    }
}
