//! The fade at the end of a field's band.
//!
//! A field is known up to a frequency f_b. Beyond, its interpolation is an extrapolation, which is faded out
//! between f_b and 6/5 f_b, or over 200 Hz where that is more, by the curve of the band limit
//! ([`lowpass::transition`]). The fade blurs a click in time, by [`fade_reach`].

use super::lowpass;

/// Least half-width of the fade at the end of a field's band \[Hz\].
const LEAST_FADE: f64 = 100.0;

/// Centre and half-width \[Hz\] of the fade at the end of a field's band that ends at this frequency \[Hz\].
pub(super) fn fade(band_end: f64) -> (f64, f64) {
    let half_width = (0.1 * band_end).max(LEAST_FADE);
    (band_end + half_width, half_width)
}

/// Time \[s\] by which the fade blurs a click to both sides.
pub(super) fn fade_reach(band_end: f64) -> f64 {
    lowpass::REACH as f64 * lowpass::HALF_WIDTH / fade(band_end).1
}

/// Longest [`fade_reach`] \[s\].
pub(super) const LONGEST_FADE_REACH: f64 = lowpass::REACH as f64 * lowpass::HALF_WIDTH / LEAST_FADE;
