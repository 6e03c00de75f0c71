//! What became of an impact.

use std::ops::Range;

use glam::DVec3;
use num_complex::Complex64;

use super::energy_balance::EnergyBalance;
use super::member::{Member, MemberContact};

/// Why a solve ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ContactEnd {
    /// The bodies have parted: no contact but standing ones can close again by motion or vibration.
    #[default]
    Parted,
    /// The limit of steps was reached while a contact that does not stand had a force.
    StillTouching,
    /// The limit of steps was reached before the bodies had parted for good, without such a force.
    StepLimit,
}

/// Forces, motion, vibration and energies of an impact, from its beginning to `steps` steps later.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactSolution {
    /// Length of a step \[s\].
    pub step: f64,
    /// Number of steps.
    pub steps: usize,
    /// Forces on A of each contact along its axes \[N\], constant in each step: all contacts of the first
    /// step, then those of the next.
    pub forces: Vec<[f64; 3]>,
    /// Normal from B to A and two tangents of each contact.
    pub axes: Vec<[DVec3; 3]>,
    /// Velocity of each member [m/s].
    pub velocities: Vec<DVec3>,
    /// Angular velocity of each member [rad/s].
    pub angular_velocities: Vec<DVec3>,
    /// How far each centre of mass moved \[m\].
    pub displacements: Vec<DVec3>,
    /// How far each member turned \[rad\].
    pub rotations: Vec<DVec3>,
    /// Gap of each contact without vibration \[m\].
    pub gaps: Vec<f64>,
    /// Approach of each contact with vibration \[m\], positive where the surfaces overlap.
    pub approaches: Vec<f64>,
    /// How long each contact had a force \[s\].
    pub touch_durations: Vec<f64>,
    /// How often each contact closed; one closed at the beginning already does not count.
    pub hits: Vec<usize>,
    /// Energies.
    pub energies: EnergyBalance,
    /// Why it ended.
    pub end: ContactEnd,
    /// Energy stored at the beginning and after each step \[J\], in every contact and then in the modes of
    /// every member; empty unless [`stored_energy`](super::StepSettings::stored_energy) is set.
    pub stored: Vec<f64>,
    /// Steps made without friction because the forces did not converge with it.
    pub stalled_steps: usize,
    pub(super) states: Vec<Complex64>,
    pub(super) modes: Vec<Range<usize>>,
}

impl ContactSolution {
    /// Time from the beginning to the end \[s\].
    pub fn duration(&self) -> f64 {
        self.steps as f64 * self.step
    }

    /// Force on A of a contact in a step, along its axes \[N\].
    pub fn force(&self, step: usize, contact: usize) -> [f64; 3] {
        self.forces[step * self.axes.len() + contact]
    }

    /// Energies stored after so many steps \[J\]: in every contact, and in the modes of every member.
    pub fn stored_after(&self, steps: usize) -> Option<(&[f64], &[f64])> {
        let (contacts, members) = (self.axes.len(), self.modes.len());
        let from = steps * (contacts + members);
        self.stored.get(from..from + contacts + members).map(|all| all.split_at(contacts))
    }

    /// Impulse on A of a contact, in world axes [N s].
    pub fn impulse(&self, contact: usize) -> DVec3 {
        let mut sum = [0.0; 3];
        for force in self.forces.iter().skip(contact).step_by(self.axes.len()) {
            for (sum, force) in sum.iter_mut().zip(force) {
                *sum += force;
            }
        }
        self.axes[contact].iter().zip(sum).map(|(axis, sum)| *axis * (sum * self.step)).sum()
    }

    /// States w of a member's modes at the end.
    pub fn modal_state(&self, member: usize) -> &[Complex64] {
        &self.states[self.modes[member].clone()]
    }

    /// Makes the end the beginning of what follows: velocities, states and gaps of the members and contacts
    /// of this solution, in their order. More may come after them. Points and centres stay, as they do within
    /// a solve, so that going on gives what one longer solve gives.
    pub fn carry_over(&self, members: &mut [Member], contacts: &mut [MemberContact]) {
        for (index, member) in members.iter_mut().enumerate().take(self.velocities.len()) {
            member.velocity = self.velocities[index];
            member.angular_velocity = self.angular_velocities[index];
            member.state.clear();
            member.state.extend_from_slice(self.modal_state(index));
        }
        for (contact, gap) in contacts.iter_mut().zip(&self.gaps) {
            contact.gap = *gap;
        }
    }
}
