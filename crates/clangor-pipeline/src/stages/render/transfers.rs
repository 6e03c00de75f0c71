//! How modes become pressure: by their transfers, or as in \[FRAC\] for comparison by ear.

use std::f64::consts::TAU;

use clangor_core::material::Damping;
use clangor_core::reference::frac_transfer;
use clangor_core::sound_model::modal::model::ModalTransfer;
use clangor_core::sound_model::soundbank::modal_soundbank::{ContactMapping, ModalProxy};
use clangor_core::synthesis::modal::{ModalError, ModalSettings, ModalSource};

/// How modes become pressure, for comparison by ear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Transfers {
    /// As they were baked, on the acceleration of the mode.
    #[default]
    Baked,
    /// \[FRAC\] eq. (8): their magnitude, on the amplitude of the mode.
    Frac,
    /// The same without any: every mode sounds alike, equally in all directions, and all together radiate as
    /// much from equal amplitudes as they should. \[FRAC\] §6 compares with this.
    Unit,
}

impl Transfers {
    pub(super) fn settings(self) -> ModalSettings {
        match self {
            Transfers::Baked => ModalSettings::default(),
            Transfers::Frac => frac_transfer::magnitude_settings(),
            Transfers::Unit => frac_transfer::unit_settings(),
        }
    }
}

/// An ellipsoid in place of a body of this damping.
pub(super) fn proxy_source(
    proxy: &ModalProxy,
    transfers: Transfers,
    damping: &Damping,
    settings: &ModalSettings,
) -> Result<ModalSource, ModalError> {
    let mut own: Vec<ModalTransfer> = (0..proxy.mode_count()).map(|mode| proxy.transfer(mode)).collect();
    if transfers == Transfers::Unit {
        let crossing = TAU * proxy.radius() / proxy.material().medium.sound_speed;
        let modes: Vec<_> =
            own.into_iter().enumerate().map(|(mode, t)| (proxy.frequency(mode), Some(t))).collect();
        own = frac_transfer::unit_transfers(&modes, crossing);
    }
    ModalSource::of_proxy(proxy.clone(), ContactMapping::default(), &own, damping, settings)
}
