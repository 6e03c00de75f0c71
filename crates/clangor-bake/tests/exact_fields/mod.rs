//! Fields known in closed form at every wavenumber, for fits and comparisons.

use clangor_core::medium::Medium;
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use clangor_core::sound_model::acceleration::sphere_radiation::{SphereModel, SphereTransfer};
use glam::DVec3;
use num_complex::Complex64;

/// A rigid ball of a body: lengths over the bounding radius of the body.
#[derive(Clone, Copy)]
pub(crate) struct Ball {
    /// Its centre.
    pub(crate) centre: DVec3,
    /// Its radius.
    pub(crate) radius: f64,
}

/// p e^{iκ|x|}/(ρR) of the six motions of rigidly connected balls that do not scatter each other's sound.
pub(crate) fn spectra(balls: &[Ball], x: DVec3, wavenumbers: &[f64]) -> [Vec<Complex64>; RIGID_DOFS] {
    let unit = Medium { density: 1.0, sound_speed: 1.0 };
    let mut sums = std::array::from_fn(|_| vec![Complex64::ZERO; wavenumbers.len()]);
    for ball in balls {
        let towards = x - ball.centre;
        let distance = towards.length();
        let u = towards / distance;
        let transfer = SphereTransfer::new(SphereModel::Exact, &unit, ball.radius, distance, 1.0);
        let arm = ball.centre.cross(u);
        // a·u and (α × d)·u = α·(d × u).
        let shares = [u.x, u.y, u.z, arm.x, arm.y, arm.z];
        for (m, &k) in wavenumbers.iter().enumerate() {
            let (re, im) = transfer.at(k);
            let p = Complex64::new(re, im) * Complex64::from_polar(1.0, k * x.length());
            for (sum, share) in sums.iter_mut().zip(shares) {
                sum[m] += share * p;
            }
        }
    }
    sums
}

/// One ball.
pub(crate) fn ball() -> Vec<Ball> {
    vec![Ball { centre: DVec3::ZERO, radius: 1.0 }]
}

/// Balls on three axes, of three sizes: three planes of symmetry, and all six motions radiate.
pub(crate) fn cross() -> Vec<Ball> {
    [(DVec3::X, 0.7, 0.3), (DVec3::Y, 0.5, 0.25), (DVec3::Z, 0.4, 0.2)]
        .into_iter()
        .flat_map(|(axis, place, radius)| {
            [1.0, -1.0].map(|side| Ball { centre: axis * (side * place), radius })
        })
        .collect()
}
