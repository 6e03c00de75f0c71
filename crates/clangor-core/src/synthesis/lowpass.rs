//! The band limit of the output: a zero-phase low-pass with a compact transition, evaluated in the frequency
//! domain.
//!
//! The gain is exactly 1 below 5/12 of the sample rate (20 kHz at 48 kHz), ½ at 0.45 of it, exactly 0 above
//! 29/60 of it (23.2 kHz). Between, it is the integral of a Kaiser window, L(f) = ∫_x¹ I₀(β√(1−s²)) ds · β /
//! (2 sinh β), with x = (f − 0.45 rate) / (rate/30). So its impulse response is the sinc of the 0.45-rate
//! low-pass times the spectrum of that window: below 3e-10 of its peak from [`REACH`] samples (1.8 ms at 48
//! kHz) on, and falling.
//!
//! A lower band limit moves the same transition down.
//!
//! A window in time, the usual design, bounds the length of the response exactly but not the stop band. Here
//! it is the other way round: spectra live on an FFT grid, where a stop band that is not zero would alias.

use crate::math::bessel::bessel_i0;

/// Half-amplitude frequency over the sample rate.
pub(super) const CENTRE: f64 = 0.45;
/// Half the width of the transition over the sample rate.
pub(super) const HALF_WIDTH: f64 = 1.0 / 30.0;
/// Kaiser's β: the window's spectrum has side lobes of −138 dB.
const BETA: f64 = 18.0;

/// Half-length of the impulse response \[samples\]: √(β² + π²) / (2π · half-width) = 87.2.
pub const REACH: usize = 88;

/// Gains at the frequencies k · rate / `fft_length`, from k = 0 up to the last one that is not zero.
///
/// `centre`: half-amplitude frequency over the sample rate, [`CENTRE`] or less.
pub(super) fn gains(fft_length: usize, centre: f64) -> Vec<f64> {
    transition(|k| (k as f64 / fft_length as f64 - centre) / HALF_WIDTH)
}

/// Gains from bin 0 up to the last one that is not zero, for a transition in which bin k has this place, from
/// −1 where it begins to 1 where it ends.
pub(super) fn transition(place: impl Fn(usize) -> f64) -> Vec<f64> {
    let first_zero = (0..).find(|k| place(*k) >= 1.0).unwrap_or(0);
    let mut gains = vec![1.0; first_zero];
    let total = 2.0 * BETA.sinh() / BETA;
    let (mut integral, mut upper) = (0.0, 1.0);
    for k in (0..first_zero).rev() {
        let lower = place(k);
        if lower <= -1.0 {
            break;
        }
        integral += integrated_window(lower, upper);
        upper = lower;
        // Quadrature may overshoot 1 by its rounding.
        gains[k] = (integral / total).min(1.0);
    }
    gains
}

/// The gain at one place of the transition.
pub(super) fn gain(place: f64) -> f64 {
    match place {
        place if place >= 1.0 => 0.0,
        place if place <= -1.0 => 1.0,
        place => (integrated_window(place, 1.0) * BETA / (2.0 * BETA.sinh())).min(1.0),
    }
}

/// ∫ I₀(β√(1−s²)) ds by three-point Gauss quadrature on panels of at most 1/64.
fn integrated_window(lower: f64, upper: f64) -> f64 {
    let window = |s: f64| bessel_i0(BETA * (1.0 - s * s).max(0.0).sqrt());
    let panels = ((upper - lower) * 64.0).ceil().max(1.0);
    let half = 0.5 * (upper - lower) / panels;
    let node = half * 0.6f64.sqrt();
    (0..panels as usize)
        .map(|i| {
            let middle = lower + half * (2.0 * i as f64 + 1.0);
            half / 9.0 * (5.0 * (window(middle - node) + window(middle + node)) + 8.0 * window(middle))
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_the_audio_band_and_stops_before_nyquist() {
        for n in [256, 480, 4096] {
            let gains = gains(n, CENTRE);
            let rate = 48_000.0;
            let frequency = |k: usize| k as f64 * rate / n as f64;
            assert!(gains.windows(2).all(|w| w[0] >= w[1]));
            assert!(frequency(gains.len()) >= 23_200.0 && frequency(gains.len() - 1) <= 23_200.0);
            for (k, gain) in gains.iter().enumerate() {
                if frequency(k) <= 20_000.0 {
                    assert_eq!(*gain, 1.0);
                }
            }
            // The window is even, so the gain is odd about its centre: L(centre + d) + L(centre − d) = 1.
            if (0.45 * n as f64).fract() == 0.0 {
                let centre = (0.45 * n as f64) as usize;
                for d in 0..gains.len() - centre {
                    // Residual seen: 4e-15.
                    assert!((gains[centre + d] + gains[centre - d] - 1.0).abs() < 1e-13);
                }
            }
        }
    }

    #[test]
    fn impulse_response_is_short() {
        let n = 4096;
        let gains = gains(n, CENTRE);
        let response = |sample: usize| {
            let angle = std::f64::consts::TAU * sample as f64 / n as f64;
            let sum: f64 =
                gains.iter().enumerate().skip(1).map(|(k, g)| 2.0 * g * (angle * k as f64).cos()).sum();
            (gains[0] + sum) / n as f64
        };
        let peak = response(0);
        let beyond = (REACH..n / 2).map(|i| response(i).abs()).fold(0.0, f64::max);
        // Seen: 2.4e-10.
        assert!(beyond < 3e-10 * peak, "{:e}", beyond / peak);
    }
}
