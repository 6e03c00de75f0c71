//! Wave of a click at a receiver in closed form, and its time span.

use std::sync::Arc;

use glam::DVec3;

use super::band_end_fade::fade_reach;
use super::field_source::FieldSource;
use super::field_spectrum::FieldTransfer;
use super::ground::Ground;
use super::ground::plate::PlateTransfer;
use super::ground::spectrum::GroundTransfer;
use super::render_settings::RenderSettings;
use super::source::SoundSource;
use super::wave::{Transfer, Wave};
use crate::acoustics::Acoustics;
use crate::medium::Medium;
use crate::reference::SlabTransfer;
use crate::sound_model::acceleration::sphere_radiation::SphereTransfer;
use crate::synthesis::acceleration_pulse::AccelerationPulse;

/// A wave, and the first and last time of its sound \[s\].
pub(super) struct ReceivedWave {
    pub(super) wave: Wave,
    /// From the centre of the click \[m\].
    pub(super) distance: f64,
    /// When the middle of the force arrives \[s\].
    pub(super) middle: f64,
    pub(super) from: f64,
    pub(super) until: f64,
}

impl RenderSettings {
    /// The wave of a click that runs `towards` a receiver \[m\], from the centre of the click; `None` if the
    /// wave has no closed form.
    pub(super) fn wave(&self, click: &AccelerationPulse, towards: DVec3) -> Option<ReceivedWave> {
        let RenderSettings { acoustics: Acoustics { medium, .. }, sphere_model, .. } = *self;
        let place = click.orientation.inverse() * towards;
        let distance = towards.length();
        let ringing = click.source.ring_time(&medium);
        let (begin, end) = click.shape.extent(click.duration);
        let heard = |transfer, delay: f64, first: f64, last: f64| {
            let middle = click.time + delay + 0.5 * click.duration;
            let shape = click.shape.clone();
            let wave = Wave { transfer, shape, duration: click.duration, middle };
            let (from, until) = (click.time + first + begin, click.time + last + end);
            let middle = match &wave.transfer {
                // The transfer of the ground has the delays.
                Transfer::Ground(_) | Transfer::Plate(_) => middle + distance / medium.sound_speed,
                _ => middle,
            };
            Some(ReceivedWave { wave, distance, middle, from, until })
        };
        match &click.source {
            SoundSource::Sphere { radius } => {
                // cosθ times the velocity change: the transfer of this wave is for a unit acceleration pulse.
                let along = click.velocity_change.dot(towards) / distance;
                let transfer = SphereTransfer::new(sphere_model, &medium, *radius, distance, along);
                let delay = transfer.delay;
                heard(Transfer::Sphere(transfer), delay, delay, delay + ringing)
            }
            SoundSource::Field(source) => {
                let transfer = field_transfer(click, source, place, &medium);
                let delay = transfer.position.length() * transfer.crossing;
                // The wave from the near side arrives before that from the centre, but never before the
                // force.
                let first = (delay - transfer.crossing).max(0.0);
                let blur = self.blur(source);
                heard(Transfer::Field(transfer), delay, first - blur, delay + ringing + blur)
            }
            SoundSource::Ground { ground: Ground::Reference(slab), impulse } => {
                let transfer = SlabTransfer::new(slab, *impulse, distance);
                let delay = distance / medium.sound_speed;
                heard(Transfer::Reference(transfer), delay, delay, delay + slab.ring_time())
            }
            SoundSource::Ground { ground: Ground::HalfSpace(ground), impulse } => {
                let (first, last) = ground.heard_between(place);
                let source = Arc::clone(ground);
                let transfer = GroundTransfer { source, impulse: *impulse, place };
                heard(Transfer::Ground(transfer), 0.0, first, last)
            }
            SoundSource::Ground { ground: Ground::Plate(plate), impulse } => {
                let (first, last) = plate.heard_between(place);
                let transfer = PlateTransfer { source: Arc::clone(plate), impulse: *impulse, place };
                heard(Transfer::Plate(transfer), 0.0, first, last)
            }
            // No wave in closed form: the renderer takes the samples of the source.
            SoundSource::Reference(_) => None,
        }
    }

    /// Time \[s\] by which the fade at the end of a field's band blurs it.
    fn blur(&self, source: &FieldSource) -> f64 {
        let band_end = source.max_frequency(self.acoustics.medium.sound_speed);
        if band_end < self.band().1 { fade_reach(band_end) } else { 0.0 }
    }
}

/// The field of a click at a `place` \[m\] of the body frame.
fn field_transfer(
    click: &AccelerationPulse,
    source: &Arc<FieldSource>,
    place: DVec3,
    medium: &Medium,
) -> FieldTransfer {
    let radius = source.radius;
    let field_from_body = source.body_from_field.inverse();
    let to_field = field_from_body * click.orientation.inverse();
    let [linear, angular] =
        [click.velocity_change, radius * click.angular_velocity_change].map(|v| (to_field * v).to_array());
    let position = field_from_body * place / radius;
    // Without a near field, a receiver inside the bounding sphere gets the field on the sphere in its
    // direction.
    let distance = position.length();
    let on_sphere = distance < 1.0 && source.near.is_none();
    let position = if on_sphere { position.try_normalize().unwrap_or(DVec3::X) } else { position };
    FieldTransfer {
        source: Arc::clone(source),
        motion: std::array::from_fn(|i| if i < 3 { linear[i] } else { angular[i - 3] }),
        position,
        scale: medium.density * radius,
        crossing: radius / medium.sound_speed,
        table: None,
    }
}
