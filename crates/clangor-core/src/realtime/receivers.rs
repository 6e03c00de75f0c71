//! Positions of the receivers, which follow their targets smoothly. The first targets are taken at once,
//! however much has been rendered before.

use glam::DVec3;

/// Time constant with which receivers follow \[s\].
const FOLLOWING: f64 = 0.02;
/// Receivers farther from their targets jump \[m\].
const JUMP: f64 = 1.0;
/// Receivers nearer to their targets are at them \[m\].
const NEAR: f64 = 1e-6;

/// See the module.
pub(super) struct Receivers {
    positions: Vec<DVec3>,
    targets: Vec<DVec3>,
    /// Whether targets have been set.
    targeted: bool,
    /// Whether they have been at set targets once.
    placed: bool,
}

impl Receivers {
    /// So many receivers at the origin.
    pub(super) fn new(count: usize) -> Self {
        Receivers {
            positions: vec![DVec3::ZERO; count],
            targets: vec![DVec3::ZERO; count],
            targeted: false,
            placed: false,
        }
    }

    /// Positions now [m, world].
    pub(super) fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Positions that they approach [m, world].
    pub(super) fn targets(&self) -> &[DVec3] {
        &self.targets
    }

    /// Sets the targets [m, world].
    pub(super) fn set_targets(&mut self, places: impl IntoIterator<Item = DVec3>) {
        self.targets.iter_mut().zip(places).for_each(|(target, place)| *target = place);
        self.targeted = true;
    }

    /// Moves the receivers on by so many samples at this rate \[Hz\].
    pub(super) fn follow(&mut self, frames: usize, sample_rate: f64) {
        let share = 1.0 - (-(frames as f64) / (FOLLOWING * sample_rate)).exp();
        for (place, target) in self.positions.iter_mut().zip(&self.targets) {
            let path = *target - *place;
            let jumps = !self.placed || path.length() > JUMP || path.length() < NEAR;
            *place = if jumps { *target } else { *place + path * share };
        }
        self.placed = self.targeted;
    }
}
