//! Torque-free rotation: how a body turns between impulses.
//!
//! The angular momentum L about the centre of mass is constant in the world frame, and
//!
//! `q̇ = ½ ω q`,  `ω = R J⁻¹ Rᵀ L`,
//!
//! with J the inertia in the body frame and R the rotation of the unit quaternion q. A body whose J is a
//! multiple of the identity turns at constant ω in closed form; the others take classical Runge-Kutta steps
//! of fourth order, whose error, about (ω Δt)⁵/120, is 1e-12 rad for 100 rad/s and half a step of 0.1 ms. L
//! itself is never integrated, so its balance stays exact.

use glam::{DMat3, DQuat, DVec3};

/// Below this angle \[rad\] the second-order rule is accurate to 1e-13.
const SMALL_ANGLE: f64 = 1e-4;

/// A larger angle \[rad\] is integrated in parts, so that the energy of a thin body does not drift.
const LARGE_ANGLE: f64 = 0.1;
const MOST_PARTS: f64 = 1000.0;

/// Angular velocity \[rad/s\], world, of a body with angular momentum `momentum`.
pub(super) fn angular_velocity(orientation: DQuat, momentum: DVec3, inverse_inertia: &DMat3) -> DVec3 {
    orientation * (*inverse_inertia * (orientation.inverse() * momentum))
}

/// Orientation after `duration` seconds (which may be negative) of torque-free rotation.
///
/// `momentum` is L in the world frame, `inverse_inertia` J⁻¹ in the body frame; `isotropic` says that J is a
/// multiple of the identity.
pub(super) fn turn(
    orientation: DQuat,
    momentum: DVec3,
    inverse_inertia: &DMat3,
    isotropic: bool,
    duration: f64,
) -> DQuat {
    let omega = angular_velocity(orientation, momentum, inverse_inertia);
    let angle = omega.length() * duration.abs();
    if angle == 0.0 {
        return orientation;
    }
    if isotropic {
        return rotated(orientation, omega * duration);
    }
    if angle < SMALL_ANGLE {
        let middle = rotated(orientation, omega * (0.5 * duration));
        return rotated(orientation, angular_velocity(middle, momentum, inverse_inertia) * duration);
    }
    if angle > LARGE_ANGLE * MOST_PARTS {
        // Hundreds of radians cannot be resolved, and Runge-Kutta stages would overflow.
        return rotated(orientation, omega * duration);
    }
    let parts = (angle / LARGE_ANGLE).ceil().max(1.0);
    (0..parts as u32).fold(orientation, |q, _| runge_kutta(q, momentum, inverse_inertia, duration / parts))
}

fn runge_kutta(orientation: DQuat, momentum: DVec3, inverse_inertia: &DMat3, duration: f64) -> DQuat {
    let rate = |q: DQuat| {
        let w = angular_velocity(q, momentum, inverse_inertia) * 0.5;
        DQuat::from_xyzw(w.x, w.y, w.z, 0.0) * q
    };
    let k1 = rate(orientation);
    let k2 = rate(orientation + k1 * (0.5 * duration));
    let k3 = rate(orientation + k2 * (0.5 * duration));
    let k4 = rate(orientation + k3 * duration);
    (orientation + (k1 + (k2 + k3) * 2.0 + k4) * (duration / 6.0)).normalize()
}

fn rotated(orientation: DQuat, rotation: DVec3) -> DQuat {
    (DQuat::from_scaled_axis(rotation) * orientation).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(inertia: DVec3, momentum: DVec3, step: f64, steps: usize) -> DQuat {
        let inverse = DMat3::from_diagonal(inertia.recip());
        let isotropic = inertia.x == inertia.y && inertia.y == inertia.z;
        (0..steps).fold(DQuat::IDENTITY, |q, _| turn(q, momentum, &inverse, isotropic, step))
    }

    /// A symmetric top turns by exp(L t / I₁) after a turn of (1/I₃ − 1/I₁) L₃ t about its own axis.
    #[test]
    fn symmetric_top_follows_the_closed_form() {
        let (i1, i3) = (2.0e-6, 3.5e-6);
        let momentum = DVec3::new(1.2e-4, -0.3e-4, 2.0e-4);
        let (step, steps) = (1.25e-4, 800);
        let time = step * steps as f64;
        let exact = DQuat::from_scaled_axis(momentum / i1 * time)
            * DQuat::from_rotation_z((1.0 / i3 - 1.0 / i1) * momentum.z * time);
        let got = run(DVec3::new(i1, i1, i3), momentum, step, steps);
        // Residual seen: 4e-8 rad after 0.1 s at 118 rad/s.
        assert!(got.angle_between(exact) < 1e-6, "{:e}", got.angle_between(exact));
        assert!((got.dot(exact).abs() - 1.0).abs() < 1e-14);
    }

    #[test]
    fn a_needle_that_spins_fast_stays_a_rotation() {
        let inverse = DMat3::from_diagonal(DVec3::new(1.0e-6, 3.0e-10, 1.1e-6).recip());
        for rate in [1e3, 1e5, 1e9] {
            let momentum = DVec3::new(1e-7, 3.0e-10 * rate, 0.0);
            let end = turn(DQuat::IDENTITY, momentum, &inverse, false, 1e-3);
            assert!((end.length() - 1.0).abs() < 1e-14, "{rate}: {end:?}");
        }
    }

    #[test]
    fn asymmetric_top_keeps_its_energy() {
        let inertia = DVec3::new(1.0e-6, 1.7e-6, 2.4e-6);
        let momentum = DVec3::new(1.0e-4, 1.0e-4, -0.5e-4);
        let inverse = DMat3::from_diagonal(inertia.recip());
        let energy = |q: DQuat| 0.5 * momentum.dot(angular_velocity(q, momentum, &inverse));
        let end = run(inertia, momentum, 1.25e-4, 16_000);
        let change = energy(end) / energy(DQuat::IDENTITY) - 1.0;
        // Residual seen: 1e-10 after 2 s at 130 rad/s.
        assert!(change.abs() < 1e-8, "{change:e}");
    }
}
