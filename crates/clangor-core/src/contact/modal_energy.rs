//! Energy of the modes of two bodies after an impact, and the gain that bounds it.
//!
//! An impulse j at a point x, with the duration τ and the spectrum Ŝ of its force (Ŝ(0) = 1), leaves a body
//! at rest with
//!
//! ```text
//! E = ½ Σ_i (U_i(x)·j)² Ŝ(ω_i τ)²
//! ```
//!
//! in its modes of displacement U_i [kg^−½]. Impulse and duration are those of rigid bodies. They ignore that
//! the bodies give way: at the rim of a thin plate E may be a hundred times the energy ½ m V² of the approach
//! at speed V with the effective mass m. Energy allows E ≤ ½ m V² for the modes of both bodies together.
//! Where E is larger, the forces on the modes are multiplied by
//!
//! ```text
//! g = √(½ m V²/E)
//! ```
//!
//! The gain keeps the time profile, because a contact that gives way still begins as sharply as with a small
//! mass, and so keeps the treble. It is a bound and no solution of the contact: the motion, the acceleration
//! noise and the ground keep the impulse of rigid bodies, of which a part acts slowly where g is small
//! ([`contact_forces`](fn@super::contact_forces)), and a body that is struck again while it rings may gain
//! more. Lasting contact forces are not bounded. For the release of a crack, ½ m V² is the energy that its
//! impulse and couple alone would give to pieces at rest.

use std::f64::consts::TAU;

use glam::DVec3;

use super::impact_pulse::ImpactPulse;
use crate::body::BodyId;

/// The modes of a body at the points of a contact.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModesAtContact {
    /// Frequency of each mode \[Hz\].
    pub frequencies: Vec<f64>,
    /// Damping ratio ξ of each mode.
    pub damping_ratios: Vec<f64>,
    /// U [kg^−½] of each mode at each point, in the axes of the body: one list of modes per point.
    pub motions: Vec<Vec<DVec3>>,
}

/// The modes of a body at points \[m\] with impulses [N s], both in the frame of the body; `None` for a body
/// without modes.
pub type ModesOf<'a> = &'a dyn Fn(BodyId, &[(DVec3, DVec3)]) -> Option<ModesAtContact>;

/// [`ModesOf`] bodies that do not vibrate.
pub fn no_modes(_: BodyId, _: &[(DVec3, DVec3)]) -> Option<ModesAtContact> {
    None
}

impl ModesAtContact {
    /// E \[J\] of impulses [N s, axes of the body], one per point, whose force has the real spectrum Ŝ(ω).
    pub fn energy(&self, impulses: &[DVec3], spectrum: impl Fn(f64) -> f64) -> f64 {
        let energy = |(mode, frequency): (usize, &f64)| {
            let amplitude: f64 =
                self.motions.iter().zip(impulses).map(|(motions, impulse)| motions[mode].dot(*impulse)).sum();
            0.5 * (amplitude * spectrum(TAU * frequency)).powi(2)
        };
        self.frequencies.iter().enumerate().map(energy).sum()
    }
}

/// E of the pulse over the energy of the approach, with the modes of A and B at its points.
pub(super) fn modal_energy_ratio(pulse: &ImpactPulse, modes: [Option<&ModesAtContact>; 2]) -> f64 {
    let mut energy = 0.0;
    for ((share, modes), sign) in pulse.bodies.iter().zip(modes).zip([1.0, -1.0]) {
        let (Some(share), Some(modes)) = (share, modes) else { continue };
        let impulses: Vec<DVec3> =
            share.local(&pulse.points, sign).into_iter().map(|(_, impulse)| impulse).collect();
        energy += modes.energy(&impulses, |omega| pulse.shape.centred_spectrum(omega, pulse.duration).norm());
    }
    energy / pulse.approach_energy()
}

/// Scales the forces on the modes if they would give them more energy than the approach has.
pub(super) fn bound_modal_energy(pulse: &mut ImpactPulse) {
    let ratio = pulse.modal_energy_ratio;
    if ratio > 1.0 {
        pulse.bodies.iter_mut().flatten().for_each(|share| share.modal_gain = ratio.sqrt().recip());
    }
}
