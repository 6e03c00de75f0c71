//! When the bodies of an impact have parted for good.

use super::contact_law::ContactLaw;
use super::contact_system::ContactSystem;
use super::modal_propagator::ModalPropagator;

/// Motion of a contact that is open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Parting {
    /// Separation without vibration \[m\].
    pub(super) gap: f64,
    /// Its rate [m/s].
    pub(super) speed: f64,
}

/// Whether a contact opens, vibration cannot close it, and gravity closes it only after `pause` \[s\].
pub(super) fn has_parted(
    system: &ContactSystem,
    modes: &ModalPropagator,
    contact: usize,
    Parting { gap, speed }: Parting,
    pause: f64,
) -> bool {
    let row = system.contacts[contact].rows.start;
    if speed < 0.0 || gap <= 0.0 {
        return false;
    }
    let reach: f64 = system.shapes_of(row).map(|(own, shape)| modes.reach(own, shape)).sum();
    let clearance = gap - reach;
    if clearance <= 0.0 {
        return false;
    }
    // Return of a body thrown up with this speed from this height.
    let pull = system.rows[row].greatest_pull(&system.members);
    pull == 0.0 || (speed + (speed * speed + 2.0 * pull * clearance).sqrt()) > pull * pause
}

/// Contacts that keep the solve from ending: those that do not stand, or all but springs if all stand.
pub(super) fn must_part(system: &ContactSystem, contact: usize) -> bool {
    !system.contacts[contact].standing
        || (system.contacts.iter().all(|c| c.standing)
            && matches!(system.contacts[contact].law, ContactLaw::Hertz(_)))
}
