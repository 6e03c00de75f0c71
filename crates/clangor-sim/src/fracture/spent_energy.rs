//! What cracks have taken of the energy that impacts lose: two bodies that break in one impact share it.

use super::contact_loads::ContactLoad;

/// The energy that cracks have taken from each impact whose loads may still act.
#[derive(Default)]
pub(super) struct SpentEnergy {
    impacts: Vec<Spent>,
}

struct Spent {
    impact: u64,
    end: f64,
    energy: f64,
}

impl SpentEnergy {
    /// Energy of the heat of an impact that is left for cracks \[J\].
    fn left_of(&self, load: &ContactLoad) -> f64 {
        let spent = self.impacts.iter().find(|spent| spent.impact == load.impact);
        (load.heat - spent.map_or(0.0, |spent| spent.energy)).max(0.0)
    }

    /// Energy that cracks of a body with these loads may take \[J\]: heat of their impacts, and the vibration
    /// that the last of them left in the body.
    pub(super) fn available(&self, loads: &[ContactLoad]) -> f64 {
        loads.iter().map(|load| self.left_of(load)).sum::<f64>() + ringing(loads)
    }

    /// Cracks of a body with these loads have taken an energy \[J\]; vibration is taken first.
    pub(super) fn take(&mut self, energy: f64, loads: &[ContactLoad]) {
        let mut rest = energy - ringing(loads);
        for load in loads.iter().filter(|load| load.heat > 0.0) {
            let part = rest.min(self.left_of(load));
            if part > 0.0 {
                rest -= part;
                match self.impacts.iter_mut().find(|spent| spent.impact == load.impact) {
                    Some(spent) => spent.energy += part,
                    None => self.impacts.push(Spent { impact: load.impact, end: load.end, energy: part }),
                }
            }
        }
    }

    /// Forgets impacts that ended before a time \[s\].
    pub(super) fn forget_before(&mut self, time: f64) {
        self.impacts.retain(|spent| spent.end >= time);
    }
}

/// Energy of the modes after the last solved impact \[J\].
fn ringing(loads: &[ContactLoad]) -> f64 {
    loads.iter().rev().map(|load| load.ringing).find(|energy| *energy > 0.0).unwrap_or(0.0)
}
