//! The forces of all contacts over one step: Gauss–Seidel over contacts.
//!
//! Each contact's normal force and friction are solved exactly for given forces of the others. Without
//! friction this is descent on a convex function and converges always; with friction it converges where the
//! normal is stiffer through its law than through its coupling to the tangents, as it is for short steps.
//! Where it stalls, the step is made without friction, which costs no energy, and counted.
//!
//! What all forces move is kept, and changed with every force that changes: contacts that are apart, or whose
//! force stays, cost nothing. Mobility is symmetric, so its rows are its columns.

use super::contact_law::StepLaw;
use super::contact_system::ContactSystem;
use super::friction::TangentMobility;

/// Sweeps after which the forces of friction are averaged with those before.
const PLAIN_SWEEPS: usize = 40;
/// Sweeps after which a step is made without friction, and at most.
const MOST_SWEEPS: usize = 200;
/// Relative change at which the sweeps end, and at which they have stalled.
const CONVERGED: f64 = 1e-14;
const STALLED: f64 = 1e-11;

/// State of the contacts in a step.
#[derive(Clone, Debug, Default)]
pub(super) struct StepForces {
    pub(super) laws: Vec<StepLaw>,
    /// Separation after a step per force, over all pairs of rows [m/N].
    pub(super) mobility: Vec<f64>,
    /// The part of it along the two tangents of each contact.
    pub(super) tangents: Vec<TangentMobility>,
    /// Approach of each contact before the step \[m\].
    pub(super) before: Vec<f64>,
    /// Separation of normals after the step, and slip along tangents, without any force \[m\].
    pub(super) free: Vec<f64>,
    /// Force of each row \[N\].
    pub(super) forces: Vec<f64>,
    /// Separation that all forces add to each row \[m\].
    pub(super) moved: Vec<f64>,
    /// η of each contact's friction [m/N].
    pub(super) slip_rates: Vec<f64>,
    /// Steps that stalled.
    pub(super) stalls: usize,
}

/// Largest change of a force in a sweep, and largest force \[N\].
#[derive(Clone, Copy, Default)]
struct Change {
    change: f64,
    size: f64,
}

impl Change {
    fn note(&mut self, before: f64, after: f64) {
        self.change = self.change.max((after - before).abs());
        self.size = self.size.max(after.abs());
    }
}

impl StepForces {
    pub(super) fn clear(&mut self, system: &ContactSystem) {
        let (contacts, rows) = (system.contacts.len(), system.rows.len());
        self.laws.clear();
        self.stalls = 0;
        for (values, count) in [
            (&mut self.mobility, rows * rows),
            (&mut self.before, contacts),
            (&mut self.free, rows),
            (&mut self.forces, rows),
            (&mut self.moved, rows),
            (&mut self.slip_rates, contacts),
        ] {
            values.clear();
            values.resize(count, 0.0);
        }
    }

    /// Solves for `forces`, and what they move.
    pub(super) fn solve(&mut self, system: &ContactSystem) {
        if self.forces.len() == 1 {
            let pressed = self.laws[0].press(self.before[0], -self.free[0], self.mobility[0]);
            self.forces[0] = pressed.force;
            self.moved[0] = self.mobility[0] * pressed.force;
            return;
        }
        let mut converged = self.sweeps(system, true);
        if !converged {
            self.stalls += 1;
            for contact in system.contacts.iter().filter(|contact| contact.rows.len() == 3) {
                self.forces[contact.rows.start + 1..contact.rows.end].fill(0.0);
            }
            self.slip_rates.fill(0.0);
            self.sum_moved();
            converged = self.sweeps(system, false);
        }
        debug_assert!(converged || self.forces.iter().any(|f| !f.is_finite()), "convex problem");
        // Changes of forces leave rounding behind.
        self.sum_moved();
    }

    /// What all forces move.
    fn sum_moved(&mut self) {
        self.moved.fill(0.0);
        add_columns(&self.mobility, &self.forces, &mut self.moved);
    }

    /// Sets the force of a row.
    fn set(&mut self, row: usize, force: f64, change: &mut Change) {
        let before = std::mem::replace(&mut self.forces[row], force);
        change.note(before, force);
        if force != before {
            let count = self.forces.len();
            add_column(&self.mobility[row * count..(row + 1) * count], force - before, &mut self.moved);
        }
    }

    /// The tangential mobility of every contact, once `mobility` is known.
    pub(super) fn prepare_tangents(&mut self, system: &ContactSystem) {
        let count = self.forces.len();
        self.tangents.clear();
        self.tangents.extend(system.contacts.iter().map(|contact| {
            let [t, u] = [contact.rows.start + 1, contact.rows.start + 2];
            match contact.rows.len() {
                3 => {
                    TangentMobility::new([(t, t), (t, u), (u, u)].map(|(i, j)| self.mobility[i * count + j]))
                }
                _ => TangentMobility::default(),
            }
        }));
    }

    /// Sweeps until the forces stay; whether they do.
    fn sweeps(&mut self, system: &ContactSystem, friction: bool) -> bool {
        let mut last = Change::default();
        for sweep in 0..MOST_SWEEPS {
            let weight = if sweep < PLAIN_SWEEPS { 1.0 } else { 0.5 };
            last = Change::default();
            for contact in 0..system.contacts.len() {
                self.update(system, contact, if friction { weight } else { 0.0 }, &mut last);
            }
            if last.change <= CONVERGED * last.size {
                return true;
            }
        }
        last.change <= STALLED * last.size
    }

    /// Solves one contact for given forces of the others; friction moves by `weight` towards its solution.
    fn update(&mut self, system: &ContactSystem, contact: usize, weight: f64, change: &mut Change) {
        let rows = system.contacts[contact].rows.clone();
        let (n, count) = (rows.start, self.forces.len());
        let own = self.mobility[n * (count + 1)];
        let free = -(self.free[n] + (self.moved[n] - own * self.forces[n]));
        let law = &self.laws[contact];
        let force = match law.stays_open(self.before[contact], free) {
            true => 0.0,
            false => law.press(self.before[contact], free, own).force,
        };
        self.set(n, force, change);
        if rows.len() == 1 || weight == 0.0 {
            return;
        }
        let [t, u] = [n + 1, n + 2];
        if force == 0.0 && self.forces[t] == 0.0 && self.forces[u] == 0.0 {
            self.slip_rates[contact] = 0.0;
            return;
        }
        let a = |i: usize, j: usize| self.mobility[i * count + j];
        let slip = [t, u].map(|row| {
            let by_own = a(row, t) * self.forces[t] + a(row, u) * self.forces[u];
            self.free[row] + (self.moved[row] - by_own)
        });
        let found = self.tangents[contact].friction(slip, system.contacts[contact].friction * force);
        for (row, force) in [t, u].into_iter().zip(found.force) {
            let next = self.forces[row] + weight * (force - self.forces[row]);
            self.set(row, next, change);
        }
        self.slip_rates[contact] = found.slip_rate;
    }
}

/// Adds the product of a symmetric matrix with `factors` to `sums`.
pub(super) fn add_columns(matrix: &[f64], factors: &[f64], sums: &mut [f64]) {
    for (column, factor) in matrix.chunks_exact(factors.len().max(1)).zip(factors) {
        if *factor != 0.0 {
            add_column(column, *factor, sums);
        }
    }
}

fn add_column(column: &[f64], factor: f64, sums: &mut [f64]) {
    sums.iter_mut().zip(column).for_each(|(sum, value)| *sum += value * factor);
}
