//! Where the energy of an impact went.

/// Energies of an impact \[J\].
///
/// All losses are computed on their own, so that [`EnergyBalance::residual`] tests them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyBalance {
    /// Kinetic energy of the rigid motions, before less after.
    pub motion_lost: f64,
    /// Work of gravity.
    pub gravity_work: f64,
    /// Energy of all modes, after less before.
    pub modes_gained: f64,
    /// Energy stored in contacts, after less before.
    pub stored_gained: f64,
    /// Lost in the damping of contacts and springs.
    pub contact_loss: f64,
    /// Lost to endless plates.
    pub plate_loss: f64,
    /// Lost by friction.
    pub friction_loss: f64,
    /// Lost in the damping of modes; zero unless [`modal_loss`](super::StepSettings::modal_loss) is set.
    pub modal_loss: f64,
}

impl EnergyBalance {
    /// What came in less what went out, zero but for rounding \[J\].
    pub fn residual(&self) -> f64 {
        let lost = self.contact_loss + self.plate_loss + self.friction_loss + self.modal_loss;
        self.motion_lost + self.gravity_work - self.modes_gained - self.stored_gained - lost
    }
}
