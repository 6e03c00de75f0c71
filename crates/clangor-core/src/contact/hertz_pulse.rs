//! The force of two elastic bodies that meet, over time, in closed form: Hertz's pulse.
//!
//! The approach d of Hertz's contact obeys m d̈ = −k d^{3/2}. With s = d/d_m and the largest approach d_m the
//! force is F = F_m s^{3/2}, ṡ² = (V/d_m)² (1 − s^{5/2}), and the contact lasts
//!
//! ```text
//! τ = (4/5) B(2/5, 1/2) d_m/V = 2.943275184 d_m/V
//! ```
//!
//! Every pulse has the same shape. Seen from its middle, and of unit impulse, its spectrum is real and
//! depends on x = ωτ/2 only. S is even about the middle, and its Legendre series gives
//!
//! ```text
//! S(t) τ = Σ_k a_k P_2k(2t/τ − 1)        Ŝ = Σ_k a_k (−1)^k j_2k(x)                    x ≤ 15
//! ```
//!
//! The force begins as s^{3/2} = Θ^{3/2} (1 − (3/14) Θ^{5/2} + …), Θ = V t/d_m, and ends likewise. Far above
//! 1/τ the spectrum is that of these two ends,
//!
//! ```text
//! Ŝ = 2 Re e^{ix} Σ_j c_j Γ(5(j+1)/2) (iΩ)^{−5(j+1)/2}/(8/5)        Ω = ω d_m/V         x > 15
//! ```
//!
//! The errors of both are below 2e-11 of Ŝ(0) = 1, compared with the integral in 30 digits.
//!
//! Source: Hertz 1881; series by the moments of P_2k over w with s^{5/2} = 1 − w², where F dt ∝ dw.
//!
//! Not covered: losses, which make the pulse lopsided, and bodies that vibrate during the contact.

use std::sync::LazyLock;

use num_complex::Complex64;

use crate::math::radial::regular;

/// τ V/d_m = (4/5) B(2/5, 1/2) of Hertz's contact.
pub const DURATION_OVER_APPROACH_TIME: f64 = 2.943_275_184_324_704_7;

/// a_k: (4k + 1) ∫ P_2k over the pulse.
const LEGENDRE: [f64; 14] = [
    1.0,
    -1.370_050_020_246_9,
    0.385_214_621_583_49,
    -0.026_514_325_195_551,
    0.007_442_741_288_782_1,
    0.001_588_058_011_918,
    0.000_895_970_187_849_22,
    0.000_483_629_386_133_09,
    0.000_287_256_126_591_79,
    0.000_181_060_997_057_95,
    0.000_119_760_101_705_28,
    8.235_941_820_014_7e-5,
    5.849_290_739_396_5e-5,
    4.268_309_078_528_9e-5,
];

/// c_j: the series of s^{3/2} in Θ^{5/2}, over Θ^{3/2}.
const ENDS: [f64; 6] =
    [1.0, -3.0 / 14.0, 33.0 / 1568.0, -65.0 / 46_648.0, 67_545.0 / 919_525_376.0, -2_659.0 / 804_584_704.0];

/// Γ(5/2), Γ(5), …
const GAMMAS: [f64; 6] = [
    1.329_340_388_179_137,
    24.0,
    1_871.254_305_797_788_5,
    362_880.0,
    136_843_383.354_454_7,
    87_178_291_200.0,
];

/// x from which the series of the ends is used.
const FAR: f64 = 15.0;
/// Intervals of the table per unit of x.
const DENSITY: f64 = 32.0;
/// Entries of the table.
const ENTRIES: usize = 482;

/// Ŝ and its slope at x = 0, 1/32, …
static TABLE: LazyLock<[[f64; 2]; ENTRIES]> =
    LazyLock::new(|| std::array::from_fn(|i| series(i as f64 / DENSITY)));

/// Builds the table, so that no later call has to.
pub fn prepare() {
    LazyLock::force(&TABLE);
}

/// S(t) τ at t = `part` τ, by the Legendre series. Between 0 and 1 it is within 4e-4 of the peak, the worst
/// of it at the ends.
pub fn value(part: f64) -> f64 {
    if !(0.0..=1.0).contains(&part) {
        return 0.0;
    }
    let u = 2.0 * part - 1.0;
    let (mut before, mut here) = (1.0, u);
    let mut sum = LEGENDRE[0];
    for l in 2..2 * LEGENDRE.len() - 1 {
        let next = ((2 * l - 1) as f64 * u * here - (l - 1) as f64 * before) / l as f64;
        (before, here) = (here, next);
        if l % 2 == 0 {
            sum += LEGENDRE[l / 2] * here;
        }
    }
    sum
}

/// Ŝ seen from the middle at x = ωτ/2.
pub fn centred_spectrum(x: f64) -> f64 {
    let x = x.abs();
    if x > FAR {
        let (sin, cos) = x.sin_cos();
        return far(x, cos, sin);
    }
    // Cubic Hermite interpolation; its error is below 1e-9.
    let place = x * DENSITY;
    let index = (place as usize).min(ENTRIES - 2);
    let [[from, slope], [to, end_slope]] = [TABLE[index], TABLE[index + 1]];
    let (p, q) = (place - index as f64, 1.0 - place + index as f64);
    let bend = q * slope - p * end_slope;
    q * q * (1.0 + 2.0 * p) * from + p * p * (1.0 + 2.0 * q) * to + p * q * bend / DENSITY
}

/// ∫ S(t) e^{−λt} dt from the onset, at λτ = `pole`.
pub fn at_pole(pole: Complex64) -> Complex64 {
    let half = 0.5 * pole;
    if half.norm() > FAR {
        let rate = pole / DURATION_OVER_APPROACH_TIME;
        return end_series(rate) + (-pole).exp() * end_series(-rate);
    }
    // j_l(−i a) = (−i a)^l u_l(−a²).
    let mut bessel = Vec::with_capacity(2 * LEGENDRE.len());
    regular(-half * half, 2 * LEGENDRE.len() - 2, &mut bessel);
    let mut power = Complex64::ONE;
    let mut sum = Complex64::ZERO;
    for (k, coefficient) in LEGENDRE.iter().enumerate() {
        sum += coefficient * power * bessel[2 * k];
        power *= half * half;
    }
    (-half).exp() * sum
}

/// Ŝ and its slope by spherical Bessel functions.
fn series(x: f64) -> [f64; 2] {
    let mut bessel = Vec::new();
    regular(Complex64::new(x * x, 0.0), 2 * LEGENDRE.len() - 1, &mut bessel);
    let order = |l: usize| x.powi(l as i32) * bessel[l].re;
    let (mut sum, mut slope) = (0.0, 0.0);
    for (k, coefficient) in LEGENDRE.iter().enumerate() {
        let l = 2 * k;
        let signed = if k % 2 == 0 { *coefficient } else { -coefficient };
        sum += signed * order(l);
        // (2l + 1) j_l' = l j_{l−1} − (l + 1) j_{l+1}.
        let below = if l == 0 { 0.0 } else { l as f64 * order(l - 1) };
        slope += signed * (below - (l + 1) as f64 * order(l + 1)) / (2 * l + 1) as f64;
    }
    [sum, slope]
}

/// Ŝ by the ends of the pulse.
fn far(x: f64, cos: f64, sin: f64) -> f64 {
    let omega = 2.0 * x / DURATION_OVER_APPROACH_TIME;
    let power = 1.0 / (omega * omega * omega.sqrt());
    let mut sum = 0.0;
    let mut factor = 1.25;
    for j in 0..ENDS.len() {
        factor *= power;
        let (turn_sin, turn_cos) = TURNS[j];
        sum += factor * ENDS[j] * GAMMAS[j] * (cos * turn_cos + sin * turn_sin);
    }
    sum
}

/// Sine and cosine of (5π/4)(j + 1).
const TURNS: [(f64, f64); 6] = {
    const H: f64 = std::f64::consts::FRAC_1_SQRT_2;
    [(-H, -H), (1.0, 0.0), (-H, H), (0.0, -1.0), (H, H), (-1.0, 0.0)]
};

/// Laplace transform of the beginning of a pulse of unit impulse at a rate s d_m/V.
fn end_series(rate: Complex64) -> Complex64 {
    let power = rate.powf(-2.5);
    let mut factor = Complex64::new(0.625, 0.0);
    let mut sum = Complex64::ZERO;
    for (coefficient, gamma) in ENDS.iter().zip(GAMMAS) {
        factor *= power;
        sum += factor * (coefficient * gamma);
    }
    sum
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// ∫ cos(x u) over the pulse, with w as the variable: F dt ∝ dw, and time from the middle
    /// (4/5) ∫ (1 − z²)^{−3/5} dz.
    fn integral(x: f64) -> f64 {
        // 1 − w = v^5 removes the weak singularity at the end.
        let n = 400_000;
        let h = 1.0 / n as f64;
        let (mut time, mut sum) = (0.0, 0.0);
        for i in (0..n).rev() {
            // 1 − w² = v⁵ (2 − v⁵).
            let v = (i as f64 + 0.5) * h;
            let dw = 5.0 * v.powi(4) * h;
            let below = v.powi(5) * (2.0 - v.powi(5));
            let rate = 0.8 * below.powf(-0.6) * dw;
            sum += (2.0 * x * (time + 0.5 * rate) / DURATION_OVER_APPROACH_TIME).cos() * dw;
            time += rate;
        }
        sum
    }

    #[test]
    fn the_spectrum_is_that_of_the_integral() {
        assert!((centred_spectrum(0.0) - 1.0).abs() < 1e-15);
        // Twelve digits of the integral at fτ = 1/2, 1, 2, 3, 4, 6, 8, 20, in multiple precision.
        let exact = [
            (0.5, 0.827_106_954_402),
            (1.0, 0.441_511_345_714),
            (2.0, -0.029_464_716_093_5),
            (3.0, 0.011_283_421_433_8),
            (4.0, -0.005_510_608_129_34),
            (6.0, -0.002_000_976_951_2),
            (8.0, -0.000_974_820_732_251),
            (20.0, -9.864_694_406e-5),
        ];
        for (part, value) in exact {
            let error = centred_spectrum(PI * part) - value;
            // Residual seen: 5e-10, of the interpolation.
            assert!(error.abs() < 2e-9, "fτ = {part}: {error:e}");
        }
        for x in [0.3, 2.7, 9.1] {
            let error = centred_spectrum(x) - integral(x);
            assert!(error.abs() < 1e-7, "x = {x}: {error:e}");
        }
    }

    #[test]
    fn both_series_meet() {
        let beyond = centred_spectrum(FAR * (1.0 + 1e-12));
        let [below, _] = series(FAR);
        assert!((beyond - below).abs() < 5e-11, "{beyond:e} {below:e}");
        for damping in [0.0, -0.3, -2.0] {
            for x in [0.4, 8.0, 14.99, 15.01, 40.0] {
                // Along the axis the transform at a pole is the spectrum; beside it, it is smooth.
                let at = |x: f64| at_pole(Complex64::new(damping, 2.0 * x));
                if damping == 0.0 {
                    let turned = Complex64::cis(-x) * centred_spectrum(x);
                    assert!((at(x) - turned).norm() < 2e-9, "{x}: {} {turned}", at(x));
                }
            }
            let step = (at_pole(Complex64::new(damping, 29.9999))
                - at_pole(Complex64::new(damping, 30.0001)))
            .norm();
            assert!(step < 1e-5, "{damping}: {step:e}");
        }
    }

    #[test]
    fn the_pulse_has_unit_area_and_is_even() {
        let n = 20_000;
        let mean: f64 = (0..n).map(|i| value((i as f64 + 0.5) / n as f64)).sum::<f64>() / n as f64;
        assert!((mean - 1.0).abs() < 1e-8, "{mean}");
        assert!((value(0.2) - value(0.8)).abs() < 1e-12 && value(-0.1) == 0.0);
        // F_m τ/j = τ V/(d_m 8/5) at the middle.
        let peak = DURATION_OVER_APPROACH_TIME / 1.6;
        assert!((value(0.5) / peak - 1.0).abs() < 3e-5, "{} {peak}", value(0.5));
    }
}
