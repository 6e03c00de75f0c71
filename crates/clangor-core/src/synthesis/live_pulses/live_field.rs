//! A field for real-time clicks, with all memory allocated in advance.

use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::{Playing, grids};
use crate::body::BodyId;
use crate::contact::ForceProfile;
use crate::synthesis::acceleration_pulse::AccelerationPulse;
use crate::synthesis::field_interpolation::Interpolation;
use crate::synthesis::field_source::FieldSource;
use crate::synthesis::field_spectrum::{FieldPlayer, FieldTransfer};
use crate::synthesis::history_spectra::HistorySpectra;
use crate::synthesis::render_settings::RenderSettings;
use crate::synthesis::source::SoundSource;
use crate::synthesis::spectrum::Spectrum;
use crate::synthesis::wave::{Transfer, WaveMemory};

/// See the module.
pub struct LiveField {
    /// The field without its near field, which takes too long.
    source: Arc<FieldSource>,
    /// Interpolation from its nodes to the bins of each length.
    tables: Vec<Arc<Interpolation>>,
    player: FieldPlayer,
}

impl LiveField {
    /// Prepares a field for clicks of these settings; takes milliseconds.
    pub fn new(source: &FieldSource, settings: &RenderSettings) -> Self {
        let mut source = source.clone();
        source.near = None;
        let crossing = source.radius / settings.acoustics.medium.sound_speed;
        let tables =
            grids(settings).map(|(_, grid)| Arc::new(Interpolation::of(&source, crossing, &grid))).collect();
        let mut field = LiveField { source: Arc::new(source), tables, player: FieldPlayer::default() };
        field.warm(settings);
        field
    }

    /// Lets the memory grow to what a click needs.
    fn warm(&mut self, settings: &RenderSettings) {
        let click = AccelerationPulse {
            body: BodyId(0),
            time: settings.start,
            duration: 1e-4,
            shape: ForceProfile::Hertz.into(),
            centre: DVec3::ZERO,
            orientation: DQuat::IDENTITY,
            velocity_change: DVec3::X,
            angular_velocity_change: DVec3::ZERO,
            source: self.source(),
        };
        let (mut spectrum, mut spectra) = (Spectrum::default(), HistorySpectra::default());
        for (place, (_, grid)) in grids(settings).enumerate() {
            let Some(mut heard) = settings.wave(&click, DVec3::X * (2.0 * self.source.radius)) else {
                return;
            };
            let Transfer::Field(transfer) = &mut heard.wave.transfer else { return };
            let player = self.prepare(transfer, place);
            pulp::Arch::new().dispatch(Playing {
                grid: &grid,
                losses: None,
                heard: &heard,
                origin: settings.start,
                memory: WaveMemory { player, spectra: &mut spectra },
                spectrum: &mut spectrum,
            });
        }
    }

    /// The source that clicks refer to.
    pub fn source(&self) -> SoundSource {
        SoundSource::Field(Arc::clone(&self.source))
    }

    /// Whether a click refers to it.
    pub(super) fn is_of(&self, source: &Arc<FieldSource>) -> bool {
        Arc::ptr_eq(&self.source, source)
    }

    /// Puts the interpolation for the block length at this place into use.
    pub(super) fn prepare(&mut self, transfer: &mut FieldTransfer, length: usize) -> &mut FieldPlayer {
        transfer.table = Some(Arc::clone(&self.tables[length]));
        &mut self.player
    }
}
