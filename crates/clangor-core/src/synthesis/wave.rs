//! A wave that reaches a receiver, in closed form: the transfer of what radiates, times the spectrum of the
//! force, times a delay.

use pulp::Simd;

use super::field_spectrum::{FieldPlayer, FieldTransfer};
use super::ground::plate::PlateTransfer;
use super::ground::spectrum::GroundTransfer;
use super::history_spectra::HistorySpectra;
use super::spectrum::{Grid, Spectrum};
use super::{ground, sphere_spectrum};
use crate::contact::ForceShape;
use crate::reference::SlabTransfer;
use crate::sound_model::acceleration::sphere_radiation::SphereTransfer;

/// One wave that reaches a receiver: direct, or from the mirrored source.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wave {
    /// From the force to the pressure.
    pub(crate) transfer: Transfer,
    /// Force over time, of unit impulse.
    pub(crate) shape: ForceShape,
    /// Duration τ of the force \[s\].
    pub(crate) duration: f64,
    /// When the middle of the force arrives \[s\]; of the ground, whose transfer has the delays, when it
    /// acts.
    pub(crate) middle: f64,
}

/// From the profile of the force to the pressure, but for the delay.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Transfer {
    /// Of a sphere, times the velocity change; its delay is not used.
    Sphere(SphereTransfer),
    /// Of a field.
    Field(FieldTransfer),
    /// Of the ground, with its delays.
    Ground(GroundTransfer),
    /// Of a plate, with its delays.
    Plate(PlateTransfer),
    /// As a paper has it.
    Reference(SlabTransfer),
}

/// Working memory of waves.
pub(crate) struct WaveMemory<'a> {
    /// Of waves of fields.
    pub(crate) player: &'a mut FieldPlayer,
    /// Of forces with a history.
    pub(crate) spectra: &'a mut HistorySpectra,
}

impl Wave {
    /// Adds the wave to the spectrum of a block whose first sample is at `origin` \[s\].
    #[inline(always)]
    pub(super) fn add_to<S: Simd>(
        &self,
        simd: S,
        spectrum: &mut Spectrum,
        grid: &Grid,
        origin: f64,
        WaveMemory { player, spectra }: &mut WaveMemory<'_>,
    ) {
        let force = &spectra.arriving(&self.shape, (self.duration, self.middle - origin), grid);
        match &self.transfer {
            Transfer::Sphere(transfer) => sphere_spectrum::add(spectrum, grid, force, transfer),
            Transfer::Field(transfer) => player.add(simd, spectrum, grid, force, transfer),
            Transfer::Ground(transfer) => ground::spectrum::add(spectrum, grid, force, transfer),
            Transfer::Plate(transfer) => transfer.add(spectrum, grid, force),
            Transfer::Reference(transfer) => transfer.add(spectrum, grid, force),
        }
    }
}
