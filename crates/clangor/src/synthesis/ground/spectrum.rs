//! Spectra of blows on the ground, on the grid of a block.

use std::sync::Arc;

use glam::DVec3;

use super::source::{GroundSource, Heard};
use crate::synthesis::spectrum::{Grid, LANES, Rotation, Spectrum, Wave};

/// A ground struck at a point, as it is heard at another.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::synthesis) struct GroundTransfer {
    /// The ground.
    pub(in crate::synthesis) source: Arc<GroundSource>,
    /// Impulse into it [N s].
    pub(in crate::synthesis) impulse: f64,
    /// The listener, from the point that is struck, y up \[m\].
    pub(in crate::synthesis) place: DVec3,
}

/// Adds a blow, with times counted from `origin` \[s\]; `wave.middle` is that of the force, before any delay.
pub(in crate::synthesis) fn add(
    spectrum: &mut Spectrum,
    grid: &Grid,
    wave: &Wave,
    transfer: &GroundTransfer,
    origin: f64,
) {
    let GroundTransfer { source, impulse, place } = transfer;
    let (Some(heard), Some(last)) = (Heard::at(source, *place), grid.bins.checked_sub(1)) else { return };
    if last == 0 {
        return;
    }
    let direction = heard.direction(source, grid.omega[1], grid.omega[last]);
    let step = std::f64::consts::TAU * grid.spacing_hz;
    let late = wave.middle - origin;
    let mut turns: Vec<Rotation<LANES>> = direction
        .trains
        .iter()
        .map(|train| Rotation::new(-step * (late + train.arrival * heard.delay)))
        .collect();
    let scale = impulse * source.scale();
    for first in (0..grid.bins).step_by(LANES) {
        for lane in 0..LANES.min(grid.bins - first) {
            let bin = first + lane;
            let omega = grid.omega[bin];
            if bin == 0 {
                continue;
            }
            let force = scale * omega * omega * wave.profile.centred_spectrum(omega, wave.duration);
            let (mut re, mut im) = (0.0, 0.0);
            for (amplitude, turn) in direction.amplitudes(omega * heard.delay).zip(&turns) {
                let (cos, sin) = (turn.cos[lane], turn.sin[lane]);
                re += amplitude.re * cos - amplitude.im * sin;
                im += amplitude.re * sin + amplitude.im * cos;
            }
            spectrum.re[bin] += force * re;
            spectrum.im[bin] += force * im;
        }
        turns.iter_mut().for_each(Rotation::advance);
    }
}
