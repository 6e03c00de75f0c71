//! Directions of one ground on a grid of angles, each computed when first needed.
//!
//! A direction costs some milliseconds. An impact between two grid angles blends their amplitudes with its
//! own arrivals, which costs microseconds. The grid is even except near the horizon, where waves that decay
//! with height change fast: the index of a direction at the elevation ε is v(ε) = ε/h + ln(1 + ε/ε₀)/κ. The
//! error of blending is measured in `tests/cross/ground.rs`.

use std::f64::consts::FRAC_PI_2;
use std::sync::OnceLock;

use num_complex::Complex64;

use super::direction::{Direction, Octaves};
use super::poles::Pole;

/// h: widest step [rad].
const WIDEST: f64 = 5e-3;
/// κ: step over the elevation, near the horizon.
const NEAR: f64 = 0.02;
/// ε₀ [rad].
const HORIZON: f64 = 3e-3;
/// Highest x = ωR/c of the grid; beyond it, a direction is computed for each impact.
const RANGE: [f64; 2] = [1e-2, 4e4];

/// See the module.
#[derive(Clone, Debug)]
pub(super) struct Directions {
    slots: Vec<OnceLock<Direction>>,
}

impl Directions {
    /// An empty grid.
    pub(super) fn new() -> Self {
        // Straight above, surface waves are points: the last direction is half a step or more beside it.
        let count = (number(FRAC_PI_2) - 0.5).floor() as usize + 1;
        Directions { slots: vec![OnceLock::new(); count] }
    }

    /// The waves at the angle θ from the normal, for x up to `greatest`; `None` if that is beyond the grid.
    ///
    /// `squares`: of the slownesses of Rayleigh's, pressure, shear and leaking waves.
    pub(super) fn towards(
        &self,
        poles: &[Pole],
        (cos, sin): (f64, f64),
        squares: [Complex64; 4],
        greatest: f64,
    ) -> Option<Direction> {
        if greatest > RANGE[1] {
            return None;
        }
        let slot = |index: usize| {
            self.slots[index].get_or_init(|| {
                let elevation = elevation(index as f64).max(1e-6);
                let angles = (elevation.sin(), elevation.cos());
                Direction::new(poles, angles, squares, Octaves::spanning(RANGE[0], RANGE[1]))
            })
        };
        let place = number(cos.atan2(sin)).min((self.slots.len() - 1) as f64);
        let low = (place.floor() as usize).min(self.slots.len() - 2);
        Some(Direction::between((slot(low), slot(low + 1)), place - low as f64, (cos, sin), squares))
    }
}

/// v(ε).
fn number(elevation: f64) -> f64 {
    elevation / WIDEST + (1.0 + elevation / HORIZON).ln() / NEAR
}

/// ε of a v.
fn elevation(number_wanted: f64) -> f64 {
    let (mut low, mut high) = (0.0, FRAC_PI_2);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if number(middle) < number_wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
