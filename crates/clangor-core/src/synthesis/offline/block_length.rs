//! Lengths of time blocks: 256 samples times a power of two.

use crate::synthesis::lowpass::REACH;

/// Blocks are handed out in whole spans of this many samples, so that their order does not depend on when
/// clicks are pushed.
pub(super) const SPAN: i64 = 1 << 16;
/// Shortest block \[samples\].
pub(in crate::synthesis) const MIN_LENGTH: usize = 256;
/// Longest block \[samples\]: 11 s at 384 kHz.
const MAX_LENGTH: usize = 1 << 22;

/// Samples between the starts of neighbouring blocks.
pub(super) fn hop(length: usize) -> i64 {
    (length as i64 / 8).min(SPAN)
}

/// Shortest block that holds a click of this length \[samples\] wherever it begins.
pub(super) fn block_length(samples: f64) -> Option<usize> {
    let fits = |length: &usize| (*length as i64 - hop(*length)) as f64 - 2.0 * REACH as f64 >= samples;
    std::iter::successors(Some(MIN_LENGTH), |length| Some(2 * length))
        .take_while(|length| *length <= MAX_LENGTH)
        .find(fits)
}
