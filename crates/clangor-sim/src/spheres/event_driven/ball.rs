//! The state of a ball between two events: x(t) = x₀ + v₀ s + a s²/2, ω(t) = ω₀ + α s, s = t − t₀.
//!
//! Flight, sliding, rolling and rest are all of this form, each with its own constant accelerations. Balls
//! are updated lazily: a record keeps the state at the last event that changed its motion.

use glam::{DQuat, DVec3};

/// Law of motion of a ball's centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum MotionPhase {
    /// Gravity alone: two such balls move uniformly relative to each other.
    Ballistic,
    /// Some other constant acceleration: fixed, resting, sliding, rolling.
    Steady,
    /// The arc of a ball on rods or springs.
    Arc,
    /// In steps, pressed on several others: the record holds the end of the last step.
    Pressed,
}

/// Data of a ball for the search of contacts: two cache lines, of which the first excludes most meetings.
///
/// Aligned to two lines, because processors fetch them in pairs.
#[derive(Clone, Debug)]
#[repr(C, align(128))]
pub(super) struct Ball {
    /// Centre at `time` \[m\].
    pub(super) position: DVec3,
    /// Velocity at `time` \[m/s\].
    pub(super) velocity: DVec3,
    /// Reference time of the state \[s\].
    pub(super) time: f64,
    /// Next ball of the same cell.
    pub(super) next: u32,
    /// Law of motion.
    pub(super) motion_phase: MotionPhase,
    /// Face through which it leaves its cell: 2·axis, plus 1 for the upper face.
    pub(super) exit: u8,
    /// Radius \[m\].
    pub(super) radius: f64,
    /// Acceleration since `time` \[m/s²\].
    pub(super) acceleration: DVec3,
    /// Counts the changes of motion; a prediction made for another generation is invalid.
    pub(super) generation: u32,
    /// Previous ball of the same cell.
    pub(super) previous: u32,
    /// Bucket of its cell, or [`super::grid::NOWHERE`].
    pub(super) bucket: u32,
    /// Its cell.
    pub(super) cell: [i32; 3],
}

/// Rotation of a ball, with the same reference time.
#[derive(Clone, Debug)]
pub(super) struct Spin {
    /// Orientation at the ball's time.
    pub(super) orientation: DQuat,
    /// Angular velocity at the ball's time \[rad/s\].
    pub(super) omega: DVec3,
    /// Angular acceleration since then \[rad/s²\].
    pub(super) alpha: DVec3,
}

/// Data of a ball that only impacts read: one cache line.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Traits {
    /// Index in the world's bodies.
    pub(super) body: u32,
    /// Its material class, see [`PairTable`](crate::spheres::pair_coefficients::PairTable).
    pub(super) material: u32,
    /// Whether contacts move it.
    pub(super) free: bool,
    /// Mass \[kg\].
    pub(super) mass: f64,
    /// 1/m \[1/kg\]; 0 if not free.
    pub(super) inverse_mass: f64,
    /// 1/I \[1/(kg m²)\]; 0 if not free.
    pub(super) inverse_inertia: f64,
    /// Time of the last hit \[s\].
    pub(super) last_hit: f64,
    /// Number of hits in quick succession.
    pub(super) quick_hits: u32,
    /// Its place among the members of the present cluster, or [`super::grid::NONE`].
    pub(super) member: u32,
}

impl Ball {
    /// Centre and velocity at a time, for motion at constant acceleration.
    #[inline]
    pub(super) fn at(&self, time: f64) -> (DVec3, DVec3) {
        let s = time - self.time;
        (
            self.position + (self.velocity + self.acceleration * (0.5 * s)) * s,
            self.velocity + self.acceleration * s,
        )
    }
}

/// Largest rotation in one step of the orientation if the axis itself rotates \[rad\].
const TURN_STEP: f64 = 0.05;

impl Spin {
    /// Orientation and angular velocity `s` seconds after the ball's time.
    ///
    /// Exact for a fixed axis; otherwise the fourth-order Magnus expansion θ = s (ω₀ + ω₁)/2 + s²/12 (ω₁ ×
    /// ω₀), in steps of at most [`TURN_STEP`].
    pub(super) fn after(&self, s: f64) -> (DQuat, DVec3) {
        let last = self.omega + self.alpha * s;
        if self.alpha.cross(self.omega) == DVec3::ZERO {
            let turn = (self.omega + last) * (0.5 * s);
            return (turned(self.orientation, turn), last);
        }
        let angle = self.omega.length().max(last.length()) * s;
        // Limits the work; far above the number of steps between two samples at any pose rate.
        let steps = (angle / TURN_STEP).ceil().clamp(1.0, 1e5);
        let h = s / steps;
        let mut orientation = self.orientation;
        for k in 0..steps as u32 {
            let omega_0 = self.omega + self.alpha * (f64::from(k) * h);
            let omega_1 = omega_0 + self.alpha * h;
            orientation = turned(
                orientation,
                (omega_0 + omega_1) * (0.5 * h) + omega_1.cross(omega_0) * (h * h / 12.0),
            );
        }
        (orientation, last)
    }
}

fn turned(orientation: DQuat, turn: DVec3) -> DQuat {
    if turn == DVec3::ZERO {
        return orientation;
    }
    (DQuat::from_scaled_axis(turn) * orientation).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_fills_two_cache_lines() {
        assert_eq!(size_of::<Ball>(), 128);
        assert_eq!(size_of::<Traits>(), 64);
        assert!(std::mem::offset_of!(Ball, radius) == 64);
    }

    #[test]
    fn the_orientation_follows_a_turning_axis() {
        let spin = Spin {
            orientation: DQuat::IDENTITY,
            omega: DVec3::new(3.0, 0.5, -1.0),
            alpha: DVec3::new(-2.0, 4.0, 1.0),
        };
        // Reference: midpoint rule with 200 000 steps, error about 1e-11.
        let (steps, end) = (200_000, 1.5);
        let mut reference = DQuat::IDENTITY;
        for k in 0..steps {
            let h = end / f64::from(steps);
            let omega = spin.omega + spin.alpha * ((f64::from(k) + 0.5) * h);
            reference = DQuat::from_scaled_axis(omega * h) * reference;
        }
        // Residual seen: 3e-8.
        assert!(spin.after(end).0.angle_between(reference) < 2e-7);
    }
}
