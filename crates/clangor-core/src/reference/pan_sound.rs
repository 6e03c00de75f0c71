//! The click of a body that is played by the published representation.
//!
//! Its sound is made in time, as \[PAN\] and \[PROXY\] do, and added to the samples of a block; the band
//! limit is that of [`resampling`](crate::reference::pan_representation::resampling), not of
//! [`lowpass`](crate::synthesis::lowpass). Inside the bounding sphere, where the series in 1/r means nothing,
//! a listener hears what is on the sphere in this direction.

use std::sync::Arc;

use glam::DVec3;

use crate::body::Surface;
use crate::medium::Medium;
use crate::reference::pan_representation::{ForceWindow, HeardContact, OUTPUT_BAND, PanModel};
use crate::synthesis::SynthesisError;
use crate::synthesis::acceleration_pulse::AccelerationPulse;
use crate::synthesis::render_settings::RenderSettings;
use crate::synthesis::source::inside;

/// A published model as a body uses it.
#[derive(Clone, Debug, PartialEq)]
pub struct PanSource {
    /// The signals; bodies of the same shape share them.
    pub model: Arc<PanModel>,
    /// The body, where no listener hears anything.
    pub surface: Arc<Surface>,
    /// Bounding radius of the body \[m\].
    bounding_radius: f64,
}

/// Samples of a sound: the first has this index.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Samples {
    pub(crate) first: i64,
    /// Pressures \[Pa\].
    pub(crate) pressures: Vec<f64>,
}

impl PanSource {
    /// A model for a body with this surface.
    pub fn new(model: Arc<PanModel>, surface: Arc<Surface>) -> Self {
        let bounding_radius = surface.bounding_radius();
        PanSource { model, surface, bounding_radius }
    }

    /// Time \[s\] for which the longest signal goes on after a wave from the centre of mass passes.
    pub(crate) fn ring_time(&self, medium: &Medium) -> f64 {
        let ends = self.model.fields().iter().map(|f| f.start + f.step * f.length as f64);
        ends.fold(0.0, f64::max) * self.model.radius() / medium.sound_speed
    }

    pub(crate) fn contains(&self, point_body: DVec3) -> bool {
        inside(&self.surface, self.bounding_radius, point_body)
    }

    /// What a receiver at a `place` \[m\] of the body frame hears of a click.
    pub(crate) fn samples(
        &self,
        click: &AccelerationPulse,
        place: DVec3,
        settings: &RenderSettings,
    ) -> Result<Samples, SynthesisError> {
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
        let (from, to) = click.profile.extent(click.duration);
        let window = ForceWindow { from, to, shape: &|time| click.profile.value(time, click.duration) };
        let highest = (OUTPUT_BAND * rate).min(settings.max_frequency.unwrap_or(f64::INFINITY));
        let sound = self.model.render_course(&contact, &window, &settings.medium, rate, highest)?;
        Ok(Samples { first: sound.first, pressures: sound.samples })
    }
}

impl Samples {
    /// Adds another sound.
    pub(crate) fn add(&mut self, other: &Samples) {
        if other.pressures.is_empty() {
            return;
        }
        if self.pressures.is_empty() {
            *self = other.clone();
            return;
        }
        let first = self.first.min(other.first);
        let end = (self.first + self.pressures.len() as i64).max(other.first + other.pressures.len() as i64);
        let mut sum = vec![0.0; (end - first) as usize];
        for part in [&*self, other] {
            let at = (part.first - first) as usize;
            sum[at..].iter_mut().zip(&part.pressures).for_each(|(sum, p)| *sum += p);
        }
        *self = Samples { first, pressures: sum };
    }

    /// Adds the part that lies in `block`, whose first sample has this index.
    pub(crate) fn add_to(&self, block: &mut [f64], first: i64) {
        let skip = (first - self.first).clamp(0, self.pressures.len() as i64) as usize;
        let at = (self.first - first).clamp(0, block.len() as i64) as usize;
        block[at..].iter_mut().zip(&self.pressures[skip..]).for_each(|(sum, p)| *sum += p);
    }

    /// ∫ p² dt [Pa² s].
    pub(crate) fn energy(&self, rate: f64) -> f64 {
        self.pressures.iter().map(|p| p * p).sum::<f64>() / rate
    }
}
