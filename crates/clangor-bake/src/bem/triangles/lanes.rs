//! Single-precision numbers in the lanes of a vector register, and the two functions that G = e^{−ikr}/(4πr)
//! needs.
//!
//! Written against `pulp`, so that the instruction set is chosen at run time from safe code. The functions
//! are polynomials without tables or branches: all lanes take the same time.

use std::f32::consts::PI;
use std::ops::{Add, Mul, Neg, Sub};

use pulp::Simd;

/// One number per lane.
#[derive(Clone, Copy)]
pub(crate) struct Lanes<S: Simd> {
    simd: S,
    value: S::f32s,
}

impl<S: Simd> Lanes<S> {
    /// The same number in every lane.
    #[inline(always)]
    pub(crate) fn splat(simd: S, value: f32) -> Self {
        Self { simd, value: simd.splat_f32s(value) }
    }

    /// Register of a list made by [`Simd::as_simd_f32s`].
    #[inline(always)]
    pub(crate) fn of(simd: S, value: S::f32s) -> Self {
        Self { simd, value }
    }

    /// The register.
    #[inline(always)]
    pub(crate) fn register(self) -> S::f32s {
        self.value
    }

    /// self · a + b.
    #[inline(always)]
    pub(super) fn times_plus(self, a: Self, b: Self) -> Self {
        Self { value: self.simd.mul_add_e_f32s(self.value, a.value, b.value), ..self }
    }

    /// The larger of two.
    #[inline(always)]
    pub(super) fn max(self, other: Self) -> Self {
        Self { value: self.simd.max_f32s(self.value, other.value), ..self }
    }

    /// 1/√x for 0 < x < 10³⁸, to 1.5e-7: the exponent halved as an integer, then a step of third and a step
    /// of second order.
    ///
    /// The quotient and the root of the hardware take five times as long.
    #[inline(always)]
    pub(super) fn inverse_root(self) -> Self {
        let simd = self.simd;
        let halved = simd.wrapping_dyn_shr_u32s(simd.transmute_u32s_f32s(self.value), simd.splat_u32s(1));
        let guess = simd.sub_u32s(simd.splat_u32s(0x5f37_5a86), halved);
        let guess = Self { value: simd.transmute_f32s_u32s(guess), ..self };
        let one = Self::splat(simd, 1.0);
        let half = Self::splat(simd, 0.5);
        let error = one.less(self * guess, guess);
        let better = (guess * error).times_plus(error.times_plus(Self::splat(simd, 0.375), half), guess);
        let error = one.less(self * better, better);
        (better * error).times_plus(half, better)
    }

    /// (sin 2πx, cos 2πx) for |x| < 10⁵, to 3e-7 and the rounding of x.
    ///
    /// x minus its nearest integer is at most half a turn. Half of that angle lies in the range of short
    /// polynomials, and the double-angle formulas restore it without a case for each quadrant.
    #[inline(always)]
    pub(super) fn turn(self) -> (Self, Self) {
        // Adding 1.5·2²³ leaves no bits for a fraction.
        let magic = Self::splat(self.simd, 12_582_912.0);
        let fraction = self - ((self + magic) - magic);
        let z = fraction * fraction;
        let (mut sine, mut cosine) = (Self::splat(self.simd, SINE[0]), Self::splat(self.simd, COSINE[0]));
        for m in 1..SINE.len() {
            sine = sine.times_plus(z, Self::splat(self.simd, SINE[m]));
            cosine = cosine.times_plus(z, Self::splat(self.simd, COSINE[m]));
        }
        let sine = sine * fraction;
        let double = sine + sine;
        (double * cosine, Self::splat(self.simd, 1.0).less(double, sine))
    }

    /// self − a · b.
    #[inline(always)]
    pub(super) fn less(self, a: Self, b: Self) -> Self {
        Self { value: self.simd.negate_mul_add_e_f32s(a.value, b.value, self.value), ..self }
    }
}

/// sin πx / x in powers of x², highest first: interpolated at Chebyshev points of |x| ≤ 1/2, to 5e-8.
const SINE: [f32; 5] = [0.078_539_714, -0.598_704_9, 2.550_136, -5.167_712_7, PI];
/// cos πx likewise, to 2e-7.
const COSINE: [f32; 5] = [0.222_753_57, -1.333_313_2, 4.058_614_7, -4.934_801_6, 1.0];

impl<S: Simd> Add for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { value: self.simd.add_f32s(self.value, other.value), ..self }
    }
}

impl<S: Simd> Sub for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { value: self.simd.sub_f32s(self.value, other.value), ..self }
    }
}

impl<S: Simd> Mul for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { value: self.simd.mul_f32s(self.value, other.value), ..self }
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { value: self.simd.neg_f32s(self.value), ..self }
    }
}
