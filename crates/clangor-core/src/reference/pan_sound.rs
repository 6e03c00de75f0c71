//! Evaluates the click of a body in the [`pan_representation`](super::pan_representation).
//!
//! The sound is computed in the time domain, as in \[PAN\] and \[PROXY\], and added to the samples of a
//! block. The band limit is that of [`resampling`](super::pan_representation::resampling), not of
//! [`lowpass`](crate::synthesis::lowpass). Inside the bounding sphere, where the series in 1/r diverges, a
//! receiver gets the sound on the sphere in its direction.

use glam::DVec3;

use super::pan_source::PanSource;
use crate::reference::pan_representation::{ForceWindow, HeardContact, OUTPUT_BAND};
use crate::synthesis::acceleration_pulse::AccelerationPulse;
use crate::synthesis::render_settings::RenderSettings;
use crate::synthesis::sampled_sound::SampledSound;
use crate::synthesis::synthesis_error::SynthesisError;

impl PanSource {
    /// The sound of a click at a `place` \[m\] of the body frame.
    pub(crate) fn samples(
        &self,
        click: &AccelerationPulse,
        place: DVec3,
        settings: &RenderSettings,
    ) -> Result<SampledSound, SynthesisError> {
        let radius = self.model.radius();
        let rate = settings.sample_rate.as_f64();
        let to_body = click.orientation.inverse();
        let linear = (to_body * click.velocity_change).to_array();
        let angular = (to_body * click.angular_velocity_change).to_array();
        let outside = place.length() >= radius;
        let listener = if outside { place } else { radius * place.try_normalize().unwrap_or(DVec3::X) };
        let contact = HeardContact {
            peak: std::array::from_fn(|i| if i < 3 { linear[i] } else { angular[i - 3] }),
            onset: click.time - settings.start,
            duration: click.duration,
            // Not below the sphere by rounding.
            listener: listener * (1.0 + f64::EPSILON * 4.0),
        };
        let (from, to) = click.shape.extent(click.duration);
        let window = ForceWindow { from, to, shape: &|time| click.shape.value(time, click.duration) };
        let highest = (OUTPUT_BAND * rate).min(settings.acoustics.max_frequency.unwrap_or(f64::INFINITY));
        let sound = self.model.render_course(&contact, &window, &settings.acoustics.medium, rate, highest)?;
        Ok(SampledSound { first: sound.first, pressures: sound.samples })
    }
}
