//! The force of a contact point over time, as a timeline carries it.
//!
//! ```text
//! F(t) = j S(t − t₀)        S at s + k h is v_k, ∫ S dt = h Σ v_k = 1
//! ```
//!
//! j is the impulse on A, t₀ the onset of the impact, s the start and h the step. Rows of one point add up:
//! normal force and friction have rows of their own where their shapes differ.

use std::sync::Arc;

use glam::DVec3;

/// How far from the onset a force may act \[s\]: impacts on soft ground last 11 ms.
pub const FORCE_REACH: f64 = 1.0;
/// Shortest and longest step of a force \[s\].
pub const FORCE_STEPS: [f64; 2] = [1e-7, 1e-3];
/// How far the area of a shape may be from 1.
const AREA_TOLERANCE: f64 = 1e-3;

/// Force at a point of an impact over time, along one direction: see the module.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceRow {
    /// First instant of the impact \[s\], from which its force acts unless a chain delays it.
    pub time: f64,
    /// The impact, as in [`ContactRow::impact_id`](super::ContactRow::impact_id).
    pub impact_id: u64,
    /// Contact point [m, world].
    pub point: DVec3,
    /// Impulse j on A with this shape [N s, world].
    pub impulse: DVec3,
    /// How long the bodies touch \[s\].
    pub duration: f64,
    /// Factor of this force on the modes, at most 1.
    pub modal_gain: f64,
    /// Time s of the first sample after the onset \[s\], usually a little negative.
    pub start: f64,
    /// Distance h of the samples \[s\].
    pub step: f64,
    /// Samples v of S [1/s].
    pub values: Arc<[f32]>,
}

/// What is wrong with a force.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ForceProblem {
    /// A number that is not finite.
    #[error("holds a number that is not finite")]
    NotFinite,
    /// A step out of bounds.
    #[error("has a step of {step} s, not {} to {} s", FORCE_STEPS[0], FORCE_STEPS[1])]
    Step {
        /// The step \[s\].
        step: f64,
    },
    /// A force too far from its impact.
    #[error("acts from {from} s to {to} s after the onset, not within {FORCE_REACH} s of it")]
    Extent {
        /// First time \[s\].
        from: f64,
        /// Last time \[s\].
        to: f64,
    },
    /// A duration that is not positive, or too long.
    #[error("lasts {duration} s, not between 0 and {FORCE_REACH} s")]
    Duration {
        /// The duration \[s\].
        duration: f64,
    },
    /// A factor below 0 or above 1.
    #[error("has a factor of {gain} on the modes, not 0 to 1")]
    Gain {
        /// The factor.
        gain: f64,
    },
    /// A shape that is not of unit impulse.
    #[error("has a shape of area {area}, not 1")]
    Area {
        /// ∫ S dt.
        area: f64,
    },
}

impl ForceRow {
    /// ∫ S dt.
    pub fn area(&self) -> f64 {
        self.step * self.values.iter().map(|value| f64::from(*value)).sum::<f64>()
    }

    /// Checks all numbers.
    ///
    /// # Errors
    /// [`ForceProblem`].
    pub fn check(&self) -> Result<(), ForceProblem> {
        let ForceRow { time, point, impulse, duration, modal_gain: gain, start, step, .. } = self;
        let numbers = [*time, *duration, *gain, *start, *step];
        let finite = numbers.iter().all(|number| number.is_finite())
            && point.is_finite()
            && impulse.is_finite()
            && self.values.iter().all(|value| value.is_finite());
        if !finite {
            return Err(ForceProblem::NotFinite);
        }
        if !(FORCE_STEPS[0]..=FORCE_STEPS[1]).contains(step) {
            return Err(ForceProblem::Step { step: *step });
        }
        let to = start + step * self.values.len() as f64;
        if *start < -FORCE_REACH || to > FORCE_REACH {
            return Err(ForceProblem::Extent { from: *start, to });
        }
        if !(*duration > 0.0 && *duration <= FORCE_REACH) {
            return Err(ForceProblem::Duration { duration: *duration });
        }
        if !(0.0..=1.0).contains(gain) {
            return Err(ForceProblem::Gain { gain: *gain });
        }
        let area = self.area();
        if (area - 1.0).abs() > AREA_TOLERANCE {
            return Err(ForceProblem::Area { area });
        }
        Ok(())
    }
}
