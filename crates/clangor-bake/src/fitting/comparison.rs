//! Distance of two fields of the same body.
//!
//! Evaluated at frequencies spread evenly in the band and directions spread evenly over a sphere, with equal
//! weight for each frequency. The *level error* of a motion is relative to the strongest motion at that
//! frequency, rotations at equal surface speed. Its *own error* is relative to itself, which means little for
//! a motion far below the strongest.

use std::f64::consts::PI;

use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use clangor_core::sound_model::acceleration::model::AccelerationModel;
use glam::DVec3;
use num_complex::Complex64;

/// Directions compared.
pub const DIRECTIONS: usize = 40;
/// Frequencies compared.
const FREQUENCIES: usize = 60;
/// Least level, relative to the strongest motion, at which the own error of a motion counts.
const HEARD: f64 = 0.05;

/// Errors of one field relative to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldErrors {
    /// Level error of each motion.
    pub level: [f64; RIGID_DOFS],
    /// Own error of each motion, where it is above 5 % of the strongest; 0 for one that never is.
    pub own: [f64; RIGID_DOFS],
    /// Highest level of each motion relative to the strongest.
    pub loudness: [f64; RIGID_DOFS],
}

impl FieldErrors {
    /// The worst level error.
    pub fn worst_level(&self) -> f64 {
        self.level.iter().copied().fold(0.0, f64::max)
    }

    /// The worst own error of a motion above that level.
    pub fn worst_own(&self) -> f64 {
        self.own.iter().copied().fold(0.0, f64::max)
    }
}

/// Compares `model` with `reference` at `distance` (in bounding radii of the reference) for wavenumbers [1/m]
/// from `lowest` to `highest`.
pub fn compare(
    model: &AccelerationModel,
    reference: &AccelerationModel,
    distance: f64,
    (lowest, highest): (f64, f64),
) -> FieldErrors {
    let surface_speed = reference.radius;
    let mut level = [0.0; RIGID_DOFS];
    let (mut own_error, mut own_size) = ([0.0; RIGID_DOFS], [0.0; RIGID_DOFS]);
    let mut loudness = [0.0_f64; RIGID_DOFS];
    // Mean square over frequencies and directions.
    for step in 0..FREQUENCIES {
        let k = lowest + (highest - lowest) * step as f64 / (FREQUENCIES - 1) as f64;
        let (mut error, mut size) = ([0.0; RIGID_DOFS], [0.0; RIGID_DOFS]);
        for direction in directions(DIRECTIONS) {
            let x = direction * (distance * reference.radius);
            let (a, b) =
                (six_pressures(model, x, k, surface_speed), six_pressures(reference, x, k, surface_speed));
            for degree in 0..RIGID_DOFS {
                error[degree] += (a[degree] - b[degree]).norm_sqr();
                size[degree] += b[degree].norm_sqr();
            }
        }
        // Normalise by the strongest motion, and by the motion itself where it is strong enough.
        let loudest = size.iter().copied().fold(0.0, f64::max);
        for degree in 0..RIGID_DOFS {
            level[degree] += error[degree] / loudest / FREQUENCIES as f64;
            let part = (size[degree] / loudest).sqrt();
            loudness[degree] = loudness[degree].max(part);
            if part > HEARD {
                own_error[degree] += error[degree] / size[degree];
                own_size[degree] += 1.0;
            }
        }
    }
    let root = |x: f64| x.sqrt();
    FieldErrors {
        level: level.map(root),
        own: std::array::from_fn(|d| if own_size[d] > 0.0 { root(own_error[d] / own_size[d]) } else { 0.0 }),
        loudness,
    }
}

/// Pressures (ρ = 1) of the six motions at `x` \[m\]: unit accelerations, rotations such that `arm` α = 1.
pub fn six_pressures(
    model: &AccelerationModel,
    x: DVec3,
    wavenumber: f64,
    arm: f64,
) -> [Complex64; RIGID_DOFS] {
    let radius = model.radius;
    std::array::from_fn(|degree| {
        let mut z = [0.0; RIGID_DOFS];
        // z = (a, R α).
        z[degree] = if degree < 3 { 1.0 } else { radius / arm };
        radius * model.field.pressure(&z, x / radius, wavenumber * radius)
    })
}

/// Directions spread evenly over the sphere (a Fibonacci spiral).
pub fn directions(count: usize) -> impl Iterator<Item = DVec3> {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |k| {
        let z = 1.0 - (2.0 * k as f64 + 1.0) / count as f64;
        let (sin, cos) = (golden * k as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z)
    })
}
