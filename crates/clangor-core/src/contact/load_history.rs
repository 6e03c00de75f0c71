//! What an impact does to one body over time: the forces on it, and the energy stored behind them.
//!
//! ```text
//! F(t_n) = (F_n + F_{n+1})/2        U(t_n) = Σ_c (2/5) k d^{5/2} + Σᵢ ½ (q̇ᵢ² + |λᵢ|² qᵢ²)
//! ```
//!
//! The solve of the contacts has the mean force F_n of every step and the state at its end t_n. U sums the
//! contacts of the body and the modes of the body; the elastic energy of a contact is in both bodies, and all
//! of it can flow into either. Between the t_n everything is linear. Without modes this is Hertz's contact
//! with the loss of the material.
//!
//! Not covered: what happens after the body breaks; the solve goes on as if it did not.

use glam::DVec3;

use super::compliant::ContactSolution;

/// Forces on a body, and the energy stored in its contacts and modes, at equally spaced instants.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadHistory {
    /// Distance of the instants \[s\]; the first is the onset.
    pub step: f64,
    /// Where the forces act [m, world].
    pub points: Vec<DVec3>,
    /// Forces on the body [N, world]: at all points at the onset, then at the next instant.
    pub forces: Vec<DVec3>,
    /// Energy stored in the contacts of the body and in its modes at each instant \[J\].
    pub stored: Vec<f64>,
    /// Largest energy that the whole impact stored, of all bodies \[J\].
    pub energy: f64,
    /// Energy that all contacts of the impact turned into heat \[J\].
    pub heat: f64,
    /// Energy of the modes of the body at the end \[J\].
    pub ringing: f64,
}

impl LoadHistory {
    /// The part of a member in a solution that kept its stored energies; its `contacts` have a sign of 1
    /// where it is A and −1 where it is B.
    pub(super) fn of_solution(
        solution: &ContactSolution,
        member: usize,
        contacts: &[(usize, f64)],
        points: Vec<DVec3>,
    ) -> Option<Self> {
        let steps = solution.steps;
        let (_, modes) = solution.stored_after(steps)?;
        let force = |step: usize, contact: usize| -> DVec3 {
            let axes = solution.axes[contact].iter().zip(solution.force(step, contact));
            axes.map(|(axis, along)| *axis * along).sum()
        };
        let mut forces = Vec::with_capacity((steps + 1) * contacts.len());
        let mut stored = Vec::with_capacity(steps + 1);
        let mut energy = 0.0_f64;
        for n in 0..=steps {
            for (contact, sign) in contacts {
                // The force begins and ends at zero.
                let mean = |n: usize| force(n, *contact) * (0.5 * sign);
                forces.push(if n == 0 || n == steps { DVec3::ZERO } else { mean(n - 1) + mean(n) });
            }
            let (in_contacts, in_modes) = solution.stored_after(n)?;
            let own: f64 = contacts.iter().map(|(contact, _)| in_contacts[*contact]).sum();
            stored.push(own + in_modes.get(member)?);
            energy = energy.max(in_contacts.iter().chain(in_modes).sum());
        }
        let energies = &solution.energies;
        Some(LoadHistory {
            step: solution.step,
            points,
            forces,
            stored,
            energy,
            heat: energies.contact_loss + energies.plate_loss + energies.friction_loss,
            ringing: *modes.get(member)?,
        })
    }

    /// Time from the onset to the end \[s\].
    pub fn duration(&self) -> f64 {
        self.step * self.stored.len().saturating_sub(1) as f64
    }

    /// The share of the impulse at each point that acts after a time after the onset \[s\], along the whole
    /// impulse there.
    pub fn shares_after(&self, time: f64) -> Vec<f64> {
        let count = self.points.len();
        let whole = self.impulses(0.0);
        let rest = self.impulses(time.max(0.0));
        (0..count)
            .map(|k| {
                let square = whole[k].length_squared();
                if square > 0.0 { (rest[k].dot(whole[k]) / square).clamp(0.0, 1.0) } else { 0.0 }
            })
            .collect()
    }

    /// Impulse at each point from a time after the onset \[s\] on [N s, world].
    fn impulses(&self, from: f64) -> Vec<DVec3> {
        let count = self.points.len();
        let mut sums = vec![DVec3::ZERO; count];
        // Forces are linear between the instants.
        let (mut before, mut forces) = (from, self.forces_at(from).collect::<Vec<DVec3>>());
        for n in 0..self.stored.len() {
            let time = n as f64 * self.step;
            if time <= before {
                continue;
            }
            let next = &self.forces[n * count..(n + 1) * count];
            for k in 0..count {
                sums[k] += (forces[k] + next[k]) * (0.5 * (time - before));
            }
            before = time;
            forces.copy_from_slice(next);
        }
        sums
    }

    /// Ends the forces at a time after the onset \[s\].
    pub fn end_at(&mut self, time: f64) {
        let kept = ((time / self.step).ceil().max(0.0) as usize + 1).min(self.stored.len());
        self.stored.truncate(kept);
        self.forces.truncate(kept * self.points.len());
        for force in self.forces.iter_mut().skip((kept - 1) * self.points.len()) {
            *force = DVec3::ZERO;
        }
        if let Some(last) = self.stored.last_mut() {
            *last = 0.0;
        }
    }

    /// Forces at all points [N, world] at a time after the onset \[s\]; zero outside.
    pub fn forces_at(&self, time: f64) -> impl Iterator<Item = DVec3> {
        let (count, place) = (self.points.len(), self.place(time));
        (0..count).map(move |point| match place {
            Some((from, part)) => {
                let [a, b] = [from, from + 1].map(|n| self.forces[n * count + point]);
                a + (b - a) * part
            }
            None => DVec3::ZERO,
        })
    }

    /// Stored energy \[J\] at a time after the onset \[s\]; zero outside.
    pub fn stored_at(&self, time: f64) -> f64 {
        let between = |(from, part): (usize, f64)| {
            self.stored[from] + (self.stored[from + 1] - self.stored[from]) * part
        };
        self.place(time).map_or(0.0, between)
    }

    /// The instant before a time after the onset \[s\], and the part of a step that is over since; `None`
    /// outside.
    fn place(&self, time: f64) -> Option<(usize, f64)> {
        let (place, last) = (time / self.step, self.stored.len().saturating_sub(1));
        if !(place >= 0.0 && place <= last as f64) || last == 0 {
            return None;
        }
        let from = (place as usize).min(last - 1);
        Some((from, place - from as f64))
    }
}
