//! Sound files, read whole.

use std::path::Path;

use clangor_pipeline::formats::wav::WavReader;

/// Samples, and how many there are in a second.
pub(crate) fn samples(path: &Path) -> (Vec<f32>, f64) {
    let mut reader = WavReader::open(path).expect("a sound file");
    let rate = f64::from(reader.info().sample_rate);
    let mut samples = Vec::new();
    while reader.read(&mut samples, 1 << 16).expect("samples") > 0 {}
    (samples, rate)
}
