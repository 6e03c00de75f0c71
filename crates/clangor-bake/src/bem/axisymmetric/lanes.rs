//! Eight numbers side by side, which the compiler keeps in vector registers inside `pulp`'s dispatch.
//!
//! Every function is inlined into the caller, so that it is compiled with the caller's instruction set.

use std::f64::consts::FRAC_2_PI;
use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// Lanes of a [`Lanes`].
pub(super) const LANES: usize = 8;

/// Eight numbers.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(super) struct Lanes(pub(super) [f64; LANES]);

impl Lanes {
    /// The same number in every lane.
    #[inline(always)]
    pub(super) fn splat(x: f64) -> Self {
        Lanes([x; LANES])
    }

    #[inline(always)]
    pub(super) fn from_fn(f: impl Fn(usize) -> f64) -> Self {
        let mut out = [0.0; LANES];
        for (l, o) in out.iter_mut().enumerate() {
            *o = f(l);
        }
        Lanes(out)
    }

    /// self · a + b.
    #[inline(always)]
    pub(super) fn mul_add(self, a: Self, b: Self) -> Self {
        Self::from_fn(|l| self.0[l].mul_add(a.0[l], b.0[l]))
    }

    #[inline(always)]
    pub(super) fn sqrt(self) -> Self {
        Self::from_fn(|l| self.0[l].sqrt())
    }

    #[inline(always)]
    pub(super) fn recip(self) -> Self {
        Self::from_fn(|l| 1.0 / self.0[l])
    }

    #[inline(always)]
    pub(super) fn max(self, least: f64) -> Self {
        Self::from_fn(|l| if self.0[l] > least { self.0[l] } else { least })
    }

    /// In each lane `yes` where self < limit, otherwise `no`.
    #[inline(always)]
    pub(super) fn below(self, limit: f64, yes: Self, no: Self) -> Self {
        Self::from_fn(|l| if self.0[l] < limit { yes.0[l] } else { no.0[l] })
    }

    /// Largest and smallest lane.
    #[inline(always)]
    pub(super) fn range(self) -> (f64, f64) {
        (
            self.0.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            self.0.iter().copied().fold(f64::INFINITY, f64::min),
        )
    }

    /// Sine and cosine of numbers up to some 10⁵ in size, to 1e-15.
    ///
    /// Reduced by π/2 in two parts; the quadrant is in the low bits of a sum that rounds to an integer.
    #[inline(always)]
    pub(super) fn sin_cos(self) -> (Self, Self) {
        const ROUND: f64 = 6755399441055744.0;
        const HIGH: f64 = 1.5707963267341256;
        const LOW: f64 = 6.077100506506192e-11;
        let (mut sine, mut cosine) = ([0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            let shifted = self.0[l].mul_add(FRAC_2_PI, ROUND);
            let quadrant = shifted.to_bits();
            let n = shifted - ROUND;
            let y = n.mul_add(-LOW, n.mul_add(-HIGH, self.0[l]));
            let z = y * y;
            let s = z.mul_add(1.58969099521155e-10, -2.5050760253406863e-08);
            let s = z.mul_add(s, 2.7557313707070068e-06);
            let s = z.mul_add(s, -0.0001984126982985795);
            let s = z.mul_add(s, 0.00833333333332249);
            let s = z.mul_add(s, -0.16666666666666632);
            let s = (z * y).mul_add(s, y);
            let c = z.mul_add(-1.1359647557788195e-11, 2.087572321298175e-09);
            let c = z.mul_add(c, -2.7557314351390663e-07);
            let c = z.mul_add(c, 2.480158728947673e-05);
            let c = z.mul_add(c, -0.001388888888887411);
            let c = z.mul_add(c, 0.0416666666666666);
            let c = (z * z).mul_add(c, z.mul_add(-0.5, 1.0));
            let odd = quadrant & 1 != 0;
            let (a, b) = if odd { (c, s) } else { (s, c) };
            sine[l] = f64::from_bits(a.to_bits() ^ ((quadrant & 2) << 62));
            cosine[l] = f64::from_bits(b.to_bits() ^ (((quadrant + 1) & 2) << 62));
        }
        (Lanes(sine), Lanes(cosine))
    }

    /// Hyperbolic sine and cosine of numbers up to 0.6 in size, to 1e-15.
    #[inline(always)]
    pub(super) fn small_sinh_cosh(self) -> (Self, Self) {
        let z = self * self;
        let series = |first: f64| {
            // Terms z^k/(first + 2k)! from the seventh down.
            let mut sum = Lanes::splat(1.0);
            for k in (1..=7).rev() {
                let d = first + 2.0 * f64::from(k);
                sum = (z * Lanes::splat(1.0 / (d * (d - 1.0)))).mul_add(sum, Lanes::splat(1.0));
            }
            sum
        };
        (self * series(1.0), series(0.0))
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::from_fn(|l| self.0[l] + other.0[l])
    }
}

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::from_fn(|l| self.0[l] - other.0[l])
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self::from_fn(|l| self.0[l] * other.0[l])
    }
}

impl Mul<f64> for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        Self::from_fn(|l| self.0[l] * other)
    }
}

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::from_fn(|l| -self.0[l])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trigonometry_is_that_of_the_library() {
        for k in -4000..4000 {
            let x = 0.037 * f64::from(k);
            let (s, c) = Lanes::splat(x).sin_cos();
            // Residual seen: 1.2e-16.
            assert!((s.0[3] - x.sin()).abs() < 1e-15 && (c.0[5] - x.cos()).abs() < 1e-15, "{x}");
            let y = x / 300.0;
            let (s, c) = Lanes::splat(y).small_sinh_cosh();
            // Residual seen: 3e-16.
            assert!((s.0[0] - y.sinh()).abs() < 2e-15 && (c.0[0] - y.cosh()).abs() < 2e-15, "{y}");
        }
    }
}
