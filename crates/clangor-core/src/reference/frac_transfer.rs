//! \[FRAC\]'s modal sound: pressure from the magnitude of a transfer, transfers of reduced order, and the
//! unit transfers with which it compares.
//!
//! ```text
//! p(t) = |p| q(t),   |p| = ω² |H|                    [FRAC] eq. (8): q the modal amplitude
//! n̄ = max(kL/4, 4),   L = 2R                         [FRAC] §4: highest order that is rendered
//! |H| = C/ω² for all modes                           [FRAC] §6: unit transfers
//! ```
//!
//! Eq. (8) depends on how the modes of a degenerate pair are chosen, and is too loud under soft contacts. The
//! main path is Re{H A} with the complex modal acceleration A ([`modal`](crate::synthesis::modal)).

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::sound_model::modal::model::{ModalModel, ModalTransfer};
use crate::synthesis::modal::{ModalPressure, ModalSettings};

/// G of pressure Re{G w} by eq. (8), for the state w of a mode with q = Im w / ω_d: −i ω² |H| / ω_d.
pub(crate) fn frac_coupling(omega: f64, damped: f64, transfer: Complex64) -> Complex64 {
    Complex64::new(0.0, -omega.powi(2) * transfer.norm() / damped)
}

/// n̄ for κ = kR. A level of detail, for speed: bodies of higher order lose sound.
pub(crate) fn frac_order(wavenumber: f64) -> usize {
    (0.5 * wavenumber).max(4.0).ceil() as usize
}

/// Settings for eq. (8) with the transfers as they were baked.
pub fn magnitude_settings() -> ModalSettings {
    ModalSettings { pressure: ModalPressure::Reference, ..ModalSettings::default() }
}

/// Settings for [unit transfers](unit_model), which damp nothing.
pub fn unit_settings() -> ModalSettings {
    ModalSettings { pressure: ModalPressure::Reference, radiation_damping: false, ..ModalSettings::default() }
}

/// Transfers with |p| the same for all modes of these frequencies \[Hz\] and in all directions: |H| = C/ω²,
/// with the C that gives all of them together the power that they have. `crossing` is κ per hertz.
pub fn unit_transfers(modes: &[(f64, Option<ModalTransfer>)], crossing: f64) -> Vec<ModalTransfer> {
    let square = |frequency: f64| (TAU * frequency).powi(2);
    let power = |(frequency, transfer): &(f64, Option<ModalTransfer>)| {
        square(*frequency).powi(2) * transfer.as_ref().map_or(0.0, |t| t.power(crossing * frequency))
    };
    let count = modes.len().max(1) as f64;
    // A monopole of coefficient 1 has the power ½.
    let level = (2.0 * modes.iter().map(power).sum::<f64>() / count).sqrt();
    let unit = |(frequency, _): &(f64, Option<ModalTransfer>)| ModalTransfer {
        order: 0,
        coefficients: vec![Complex64::new(level / square(*frequency), 0.0)],
    };
    modes.iter().map(unit).collect()
}

/// The model with [`unit_transfers`] in place of its own.
pub fn unit_model(model: &ModalModel) -> ModalModel {
    let crossing = TAU * model.radius / model.medium.sound_speed;
    let modes: Vec<_> = model.modes.iter().map(|mode| (mode.frequency, mode.transfer.clone())).collect();
    let mut unit = model.clone();
    for (mode, transfer) in unit.modes.iter_mut().zip(unit_transfers(&modes, crossing)) {
        mode.transfer = Some(transfer);
    }
    unit
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::Medium;

    #[test]
    fn unit_transfers_share_the_same_power_equally() {
        let transfer = |order: usize| ModalTransfer {
            order,
            coefficients: (0..(order + 1).pow(2))
                .map(|i| Complex64::cis(i as f64) * (1.0 + i as f64))
                .collect(),
        };
        let crossing = TAU * 0.1 / Medium::AIR.sound_speed;
        let modes = [(700.0, Some(transfer(2))), (1900.0, Some(transfer(3))), (2600.0, Some(transfer(0)))];
        let powers = |transfers: &mut dyn Iterator<Item = ModalTransfer>| -> Vec<f64> {
            let power = |(t, f): (ModalTransfer, &f64)| (TAU * f).powi(4) * t.power(crossing * f);
            transfers.zip(&[700.0, 1900.0, 2600.0]).map(power).collect()
        };
        let given = powers(&mut modes.iter().filter_map(|(_, t)| t.clone()));
        let unit = powers(&mut unit_transfers(&modes, crossing).into_iter());
        // Residual seen: 2e-16.
        assert!((given.iter().sum::<f64>() / unit.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(unit.iter().all(|p| (p / unit[0] - 1.0).abs() < 1e-12), "{unit:?}");
    }
}
