//! The loop over the steps of an impact.

use glam::DVec3;
use pulp::Arch;

use super::compliant_error::CompliantContactError;
use super::contact_law::{Pressed, StepLaw};
use super::contact_system::ContactSystem;
use super::end_rule::{Parting, has_parted, must_part};
use super::member::StepSettings;
use super::modal_propagator::ModalPropagator;
use super::solution::{ContactEnd, ContactSolution};
use super::step_forces::{StepForces, add_columns};
use super::validation::check_settings;

/// Steps without force between looks at whether the bodies have parted for good.
const LOOK_EVERY: usize = 16;

/// Working memory of a solve, reusable for the next one without new memory.
#[derive(Clone, Debug, Default)]
pub struct SolverMemory {
    modes: ModalPropagator,
    forces: StepForces,
    rows: RowStates,
    /// Forces and displacements of the rows that drive modes.
    driven: [Vec<f64>; 2],
    /// Contacts that keep the solve from ending.
    awaited: Vec<bool>,
    /// Contacts that touched in the step before.
    touching: Vec<bool>,
    solution: ContactSolution,
}

/// State of each row.
#[derive(Clone, Debug, Default)]
struct RowStates {
    /// Separation without vibration \[m\], its rate [m/s], and the acceleration by gravity [m/s²].
    separation: Vec<f64>,
    speed: Vec<f64>,
    gravity: Vec<f64>,
    /// Acceleration by the forces of the step [m/s²].
    acceleration: Vec<f64>,
    /// Σφq now, and after the next step without force \[m\].
    vibration: Vec<f64>,
    ahead: Vec<f64>,
    /// ∫F [N s] and ∬F [N s²] since the beginning.
    impulse: Vec<f64>,
    moment: Vec<f64>,
}

impl ContactSystem {
    /// Solves the impact, from its beginning until the bodies have parted or the limit of steps.
    ///
    /// Standing contacts do not keep it from ending: what they carry then is in
    /// [`approaches`](ContactSolution::approaches), and [`carry_over`](ContactSolution::carry_over) goes
    /// on.
    /// If all contacts stand, those of Hertz are awaited; springs alone end at the limit. There is no limit
    /// in seconds.
    ///
    /// # Errors
    ///
    /// With settings out of range, without a step where none follows from the impact, and if forces exceed
    /// what `f64` holds.
    pub fn solve<'m>(
        &self,
        settings: &StepSettings,
        memory: &'m mut SolverMemory,
    ) -> Result<&'m ContactSolution, CompliantContactError> {
        check_settings(settings)?;
        if self.contacts.is_empty() {
            return Err(CompliantContactError::NoContacts);
        }
        let first = self.first_duration();
        let step = match (settings.step, first) {
            (Some(step), _) => step,
            (None, Some(duration)) => duration / settings.steps_per_duration,
            (None, None) => return Err(CompliantContactError::NoDuration),
        };
        let pause = settings.return_durations * first.unwrap_or(step * settings.steps_per_duration);
        memory.begin(self, step, settings.modal_loss);
        if settings.stored_energy {
            memory.record_stored(self);
        }
        let arch = Arch::new();
        let (mut idle, mut end) = (0_usize, None);
        while end.is_none() && memory.solution.steps < settings.max_steps {
            memory.forces.solve(self);
            if !memory.forces.forces.iter().all(|f| f.is_finite()) {
                return Err(CompliantContactError::NotFinite { step: memory.solution.steps, seconds: step });
            }
            let touching = memory.record(self);
            if settings.modal_loss {
                memory.record_modal_loss(self);
            }
            memory.advance(self, arch);
            if settings.stored_energy {
                memory.record_stored(self);
            }
            idle = if touching { 0 } else { idle + 1 };
            let is_far = idle as f64 * step > settings.longest_flight;
            if settings.end_when_parted
                && (is_far || idle % LOOK_EVERY == 1 && memory.has_parted(self, pause))
            {
                end = Some(ContactEnd::Parted);
            }
        }
        let limit = if idle == 0 { ContactEnd::StillTouching } else { ContactEnd::StepLimit };
        memory.finish(self, end.unwrap_or(limit));
        Ok(&memory.solution)
    }
}

impl SolverMemory {
    /// What became of the impact solved last.
    pub fn solution(&self) -> &ContactSolution {
        &self.solution
    }

    /// The state at t₀, and what depends on the step only.
    fn begin(&mut self, system: &ContactSystem, step: f64, losses: bool) {
        let count = system.rows.len();
        self.modes.prepare(&system.poles, &system.states, step, losses);
        self.forces.clear(system);
        let contacts = system.contacts.iter();
        self.forces.laws.extend(contacts.map(|contact| StepLaw::new(&contact.law, contact.mass, step)));
        self.rows.begin(system);
        for values in &mut self.driven {
            values.clear();
            values.resize(system.driven.len(), 0.0);
        }
        // Mobility over a step: rigid motion, modes of shared members, plates.
        for (mobility, rigid) in self.forces.mobility.iter_mut().zip(&system.rigid) {
            *mobility = 0.5 * step * step * rigid;
        }
        for modes in &system.modes {
            let shapes = &system.shapes[modes.shapes.clone()];
            let shapes =
                || shapes.chunks_exact(modes.own.len().max(1)).zip(&system.driven[modes.driven.clone()]);
            for (i, (shape, row)) in shapes().enumerate() {
                let [now, ahead] = self.modes.displacements(modes.own.clone(), shape);
                self.rows.vibration[*row] += now;
                self.rows.ahead[*row] += ahead;
                for (other, column) in shapes().skip(i) {
                    let response = self.modes.response(modes.own.clone(), [shape, other]);
                    self.forces.mobility[row * count + column] += response;
                    if column != row {
                        self.forces.mobility[column * count + row] += response;
                    }
                }
            }
        }
        self.awaited.clear();
        self.touching.clear();
        for (index, contact) in system.contacts.iter().enumerate() {
            let row = contact.rows.start;
            if !contact.standing {
                self.forces.laws[index].sharpen(self.forces.mobility[row * (count + 1)]);
            }
            self.forces.mobility[row * (count + 1)] += step * self.forces.laws[index].plate_mobility();
            self.rows.separation[row] = contact.gap;
            self.forces.before[index] = -contact.gap - self.rows.vibration[row];
            self.awaited.push(must_part(system, index));
            self.touching.push(self.forces.before[index] > 0.0);
        }
        self.forces.prepare_tangents(system);
        self.solution.begin(system, step);
        let stored = self.forces.stored();
        self.solution.energies.stored_gained = -stored;
        self.solution.energies.modes_gained = -self.modes.energy();
        self.free(system, step);
    }

    /// Separation of normals and slip along tangents after the next step without force.
    fn free(&mut self, system: &ContactSystem, step: f64) {
        let rows = &self.rows;
        for contact in &system.contacts {
            for row in contact.rows.clone() {
                let from =
                    if row == contact.rows.start { rows.separation[row] } else { -rows.vibration[row] };
                let motion = step * (rows.speed[row] + 0.5 * step * rows.gravity[row]);
                self.forces.free[row] = from + motion + rows.ahead[row];
            }
        }
    }

    /// Keeps forces, losses and touches of a step; whether an awaited contact touches.
    fn record(&mut self, system: &ContactSystem) -> bool {
        let (forces, solution) = (&mut self.forces, &mut self.solution);
        let (count, step) = (forces.forces.len(), solution.step);
        let mut awaited = false;
        for (index, contact) in system.contacts.iter().enumerate() {
            let row = contact.rows.start;
            let force = forces.forces[row];
            let after = -(forces.free[row] + forces.moved[row]);
            let mut along = [force, 0.0, 0.0];
            if contact.rows.len() == 3 {
                along[1..].copy_from_slice(&forces.forces[row + 1..row + 3]);
                solution.energies.friction_loss += forces.friction_loss(row, index);
            }
            solution.forces.push(along);
            // What the contact would have met without its own force.
            let free = after + forces.mobility[row * (count + 1)] * force;
            let law = &forces.laws[index];
            solution.energies.contact_loss +=
                law.loss(forces.before[index], free, Pressed { approach: after, force });
            solution.energies.plate_loss += step * law.plate_mobility() * force * force;
            let touches = force != 0.0;
            if touches {
                solution.touch_durations[index] += step;
                solution.hits[index] += usize::from(!self.touching[index]);
            }
            self.touching[index] = touches;
            awaited |= touches && self.awaited[index];
            forces.before[index] = after;
        }
        solution.steps += 1;
        awaited
    }

    /// Forces of the rows that drive modes.
    fn gather(&mut self, system: &ContactSystem) {
        for (force, row) in self.driven[0].iter_mut().zip(&system.driven) {
            *force = self.forces.forces[*row];
        }
    }

    fn record_modal_loss(&mut self, system: &ContactSystem) {
        self.gather(system);
        for modes in &system.modes {
            let shapes = &system.shapes[modes.shapes.clone()];
            let forces = &self.driven[0][modes.driven.clone()];
            self.solution.energies.modal_loss += self.modes.loss(modes.own.clone(), shapes, forces);
        }
    }

    /// Keeps what contacts and modes store now.
    fn record_stored(&mut self, system: &ContactSystem) {
        let stored = &mut self.solution.stored;
        stored.extend(self.forces.laws.iter().zip(&self.forces.before).map(|(law, at)| law.stored(*at)));
        stored.extend(system.modes.iter().map(|modes| self.modes.energy_of(modes.own.clone())));
    }

    /// Moves bodies and modes through a step of the forces found.
    fn advance(&mut self, system: &ContactSystem, arch: Arch) {
        let step = self.solution.step;
        self.rows.advance(system, &self.forces, step);
        self.gather(system);
        let [forces, sums] = &mut self.driven;
        for modes in &system.modes {
            let own = modes.own.start..modes.own.start + modes.count;
            let (forces, sums) = (&forces[modes.driven.clone()], &mut sums[modes.driven.clone()]);
            if modes.across.is_empty() {
                let shapes = &system.shapes[modes.shapes.clone()];
                self.modes.advance(arch, modes.own.clone(), shapes, forces, sums);
            } else {
                self.modes.advance_few(arch, own, &system.across[modes.across.clone()], forces, sums);
            }
        }
        self.rows.ahead.fill(0.0);
        for (sum, row) in sums.iter().zip(&system.driven) {
            self.rows.ahead[*row] += sum;
        }
        self.free(system, step);
    }

    fn has_parted(&self, system: &ContactSystem, pause: f64) -> bool {
        let awaits = self.awaited.contains(&true);
        awaits
            && (0..system.contacts.len()).filter(|contact| self.awaited[*contact]).all(|contact| {
                let row = system.contacts[contact].rows.start;
                let parting = Parting { gap: self.rows.separation[row], speed: self.rows.speed[row] };
                self.forces.before[contact] < 0.0 && has_parted(system, &self.modes, contact, parting, pause)
            })
    }

    /// Motion, vibration and energies at the end.
    fn finish(&mut self, system: &ContactSystem, end: ContactEnd) {
        let solution = &mut self.solution;
        solution.end = end;
        solution.stalled_steps = self.forces.stalls;
        solution.energies.stored_gained += self.forces.stored();
        solution.energies.modes_gained += self.modes.energy();
        solution.finish_motion(system, &self.rows.impulse, &self.rows.moment);
        for modes in &system.modes {
            let from = solution.states.len();
            let own = modes.own.clone().take(modes.count);
            solution.states.extend(own.map(|i| self.modes.state(i)));
            solution.modes.push(from..solution.states.len());
        }
        let normals = system.contacts.iter().map(|contact| contact.rows.start);
        solution.gaps.extend(normals.map(|row| self.rows.separation[row]));
        solution.approaches.extend_from_slice(&self.forces.before);
    }
}

impl RowStates {
    fn begin(&mut self, system: &ContactSystem) {
        for values in [
            &mut self.separation,
            &mut self.acceleration,
            &mut self.vibration,
            &mut self.ahead,
            &mut self.impulse,
            &mut self.moment,
        ] {
            values.clear();
            values.resize(system.rows.len(), 0.0);
        }
        self.speed.clear();
        self.speed.extend(system.rows.iter().map(|row| row.velocity(&system.members)));
        self.gravity.clear();
        self.gravity.extend(system.rows.iter().map(|row| row.acceleration(&system.members)));
    }

    /// Rigid motion over a step, exact for constant forces.
    fn advance(&mut self, system: &ContactSystem, forces: &StepForces, step: f64) {
        self.acceleration.fill(0.0);
        add_columns(&system.rigid, &forces.forces, &mut self.acceleration);
        for row in 0..system.rows.len() {
            let (force, by_force) = (forces.forces[row], self.acceleration[row]);
            // Of what the forces moved, the rest is vibration (and, for normals, the plate's yielding).
            self.vibration[row] = self.ahead[row] + forces.moved[row] - 0.5 * step * step * by_force;
            let acceleration = by_force + self.gravity[row];
            self.separation[row] += step * (self.speed[row] + 0.5 * step * acceleration);
            self.speed[row] += step * acceleration;
            self.moment[row] += step * (self.impulse[row] + 0.5 * step * force);
            self.impulse[row] += step * force;
        }
        for (contact, law) in system.contacts.iter().zip(&forces.laws) {
            let row = contact.rows.start;
            self.separation[row] += step * law.plate_mobility() * forces.forces[row];
        }
    }
}

impl StepForces {
    /// What friction takes in a step, Tᵀ(A + ηI)T \[J\].
    fn friction_loss(&self, normal: usize, contact: usize) -> f64 {
        let count = self.forces.len();
        let [t, u] = [normal + 1, normal + 2];
        let (first, second) = (self.forces[t], self.forces[u]);
        let a = |row: usize, column: usize| self.mobility[row * count + column];
        let squares = first * first + second * second;
        let quadratic = a(t, t) * first * first + 2.0 * a(t, u) * first * second + a(u, u) * second * second;
        quadratic + self.slip_rates[contact] * squares
    }

    /// Energy stored in all contacts \[J\].
    fn stored(&self) -> f64 {
        self.laws.iter().zip(&self.before).map(|(law, before)| law.stored(*before)).sum()
    }
}

impl ContactSolution {
    fn begin(&mut self, system: &ContactSystem, step: f64) {
        self.step = step;
        self.steps = 0;
        self.energies = Default::default();
        self.forces.clear();
        self.stored.clear();
        self.axes.clear();
        self.axes.extend(system.contacts.iter().map(|contact| contact.axes));
        self.touch_durations.clear();
        self.touch_durations.resize(system.contacts.len(), 0.0);
        self.hits.clear();
        self.hits.resize(system.contacts.len(), 0);
        self.gaps.clear();
        self.approaches.clear();
        self.states.clear();
        self.modes.clear();
    }

    /// Velocities and displacements from ∫F and ∬F of each row, and the energies of the motion.
    fn finish_motion(&mut self, system: &ContactSystem, impulse: &[f64], moment: &[f64]) {
        let time = self.duration();
        for values in
            [&mut self.velocities, &mut self.angular_velocities, &mut self.displacements, &mut self.rotations]
        {
            values.clear();
        }
        for (index, member) in system.members.iter().enumerate() {
            // Impulse and moment of impulse of all rows, and their integrals over time.
            let mut sums = [DVec3::ZERO; 4];
            for (row, (impulse, moment)) in system.rows.iter().zip(impulse.iter().zip(moment)) {
                for side in row.sides.iter().flatten().filter(|side| side.member == index) {
                    sums[0] += side.push * *impulse;
                    sums[1] += side.torque * *impulse;
                    sums[2] += side.push * *moment;
                    sums[3] += side.torque * *moment;
                }
            }
            let [push, torque, push_moment, torque_moment] = sums;
            let gravity = member.acceleration;
            let velocity = member.velocity + gravity * time + push * member.inverse_mass;
            let spin = member.angular_velocity + member.inverse_inertia * torque;
            let displacement =
                (member.velocity + 0.5 * gravity * time) * time + push_moment * member.inverse_mass;
            let rotation = member.angular_velocity * time + member.inverse_inertia * torque_moment;
            // ½m(v₁² − v₀²) is the change of momentum times the mean velocity.
            let mut gained =
                0.5 * (push.dot(member.velocity + velocity) + torque.dot(member.angular_velocity + spin));
            if gravity != DVec3::ZERO {
                let weight = gravity / member.inverse_mass;
                gained += 0.5 * time * weight.dot(member.velocity + velocity);
                self.energies.gravity_work += weight.dot(displacement);
            }
            self.energies.motion_lost -= gained;
            self.velocities.push(velocity);
            self.angular_velocities.push(spin);
            self.displacements.push(displacement);
            self.rotations.push(rotation);
        }
    }
}
