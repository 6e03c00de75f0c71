//! One impact on one body, heard by one listener in free space.
//!
//! The body rests with its centre of mass at the origin. The force begins at t = 0 and the sound 2 ms before,
//! because a band-limited onset rings before it arrives; the travel time to the listener is in it.

use std::collections::BTreeSet;
use std::f64::consts::{LN_10, TAU};
use std::path::{Path, PathBuf};
use std::slice;
use std::sync::Arc;

use clangor_core::acoustics::Acoustics;
use clangor_core::body::{Body, BodyId};
use clangor_core::contact::force_profile::ForceProfile;
use clangor_core::glam::DVec3;
use clangor_core::material::presets;
use clangor_core::medium::Medium;
use clangor_core::scene::render_description::PROXY_FREQUENCY;
use clangor_core::sound_model::acceleration::sphere_radiation::SphereModel;
use clangor_core::sound_model::{BodyModes, SoundModel};
use clangor_core::synthesis::modal::{ModalSettings, ModalSource, Resonance};
pub use clangor_core::synthesis::strike::StrikeSound;
use clangor_core::synthesis::strike::{self, LEAD, struck_ringing};
use clangor_core::synthesis::{RenderSettings, SampleRate};

use super::error::Error;
use crate::formats::model_cache::ModelCache;
use crate::formats::soundbank::default_bank;
use crate::stages::load::{geometry_reference, load_geometry};
use crate::stages::sound_models::{
    AccelerationSettings, ModalPlanSettings, Quality, SoundModelPlan, SoundModelSettings, SoundModelStore,
};

/// Shortest sound, unless another length is asked for \[s\].
pub const SHORTEST: f64 = 0.1;
/// Longest sound, unless another length is asked for \[s\].
pub const LONGEST: f64 = 20.0;

/// A body to be struck, at rest at the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct StruckBody {
    body: Body,
}

impl StruckBody {
    /// A body from a shape of the library (`"bowl"`, `"box:0.3x0.03x0.01"`) or a mesh file in metres, of a
    /// material preset.
    ///
    /// # Errors
    /// [`Error::Geometry`] and [`Error::Material`].
    pub fn shape(shape: &str, material: &str) -> Result<Self, Error> {
        let material = presets::preset(material).ok_or_else(|| Error::Material {
            name: material.into(),
            known: presets::names().collect::<Vec<_>>().join(", "),
        })?;
        let loaded = load_geometry(Path::new(""), &geometry_reference(shape, 1.0))
            .map_err(|source| Error::Geometry { name: shape.into(), source })?;
        Ok(StruckBody { body: Body::solid(shape, material, loaded.surface, &loaded.mass) })
    }

    /// The body.
    pub fn body(&self) -> &Body {
        &self.body
    }
}

impl From<Body> for StruckBody {
    fn from(body: Body) -> Self {
        StruckBody { body }
    }
}

/// An impact on a body, and how it is heard.
///
/// ```no_run
/// use clangor_pipeline::session::{Strike, StruckBody};
///
/// let bowl = StruckBody::shape("bowl", "ceramic")?;
/// let sound = Strike::new(bowl).at([0.0, 0.03, 0.06]).impulse([0.0, 0.0, -0.01]).listener([0.0, 0.3, 1.0]);
/// let pressures: Vec<f64> = sound.render()?.pressures;
/// # Ok::<(), clangor_pipeline::session::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Strike {
    body: StruckBody,
    impact: strike::Strike,
    seconds: Option<f64>,
    sample_rate: u32,
    quality: Quality,
    cache: Option<PathBuf>,
}

impl Strike {
    /// An impulse of 0.01 N s downwards at the highest point of the body, heard 1 m away along x, at 48 kHz.
    pub fn new(body: impl Into<StruckBody>) -> Self {
        let body = body.into();
        let impact = strike::Strike {
            impulse: DVec3::NEG_Y * 0.01,
            point: highest_point(&body.body),
            listener: DVec3::X,
            duration: None,
            profile: ForceProfile::HalfSine,
            sample_rate: SampleRate::HZ_48000,
            seconds: Some(SHORTEST),
            medium: Medium::AIR,
            sphere_model: SphereModel::Exact,
        };
        let quality = Quality::Normal;
        Strike { body, impact, seconds: None, sample_rate: 48_000, quality, cache: None }
    }

    /// Strikes at a point of the surface \[m from the centre of mass\].
    #[must_use]
    pub fn at(mut self, point: impl Into<DVec3>) -> Self {
        self.impact.point = point.into();
        self
    }

    /// Impulse on the body [N s].
    #[must_use]
    pub fn impulse(mut self, impulse: impl Into<DVec3>) -> Self {
        self.impact.impulse = impulse.into();
        self
    }

    /// Position of the listener \[m from the centre of mass\].
    #[must_use]
    pub fn listener(mut self, position: impl Into<DVec3>) -> Self {
        self.impact.listener = position.into();
        self
    }

    /// Duration of the contact \[s\]. Default: that of a collision with a rigid plane at 1 m/s.
    #[must_use]
    pub fn contact_duration(mut self, seconds: f64) -> Self {
        self.impact.duration = Some(seconds);
        self
    }

    /// End of the sound \[s\]. Default: when it has fallen by 60 dB.
    #[must_use]
    pub fn seconds(self, seconds: f64) -> Self {
        Strike { seconds: Some(seconds), ..self }
    }

    /// Samples per second \[Hz\], 8000 to 384 000.
    #[must_use]
    pub fn sample_rate(self, hz: u32) -> Self {
        Strike { sample_rate: hz, ..self }
    }

    /// Effort for the sound model.
    #[must_use]
    pub fn quality(self, quality: Quality) -> Self {
        Strike { quality, ..self }
    }

    /// Folder of baked sound models. Default: `CLANGOR_CACHE`, or the system's folder for caches.
    #[must_use]
    pub fn cache(self, folder: impl Into<PathBuf>) -> Self {
        Strike { cache: Some(folder.into()), ..self }
    }

    /// The sound: pressures \[Pa\] at times \[s\]. Bakes the sound model of the body if it is not in the
    /// cache.
    ///
    /// # Errors
    /// [`Error::Strike`] for an impact off the surface or without impulse, [`Error::Models`],
    /// [`Error::Synthesis`].
    pub fn render(self) -> Result<StrikeSound, Error> {
        let body = &self.body.body;
        let impact = strike::Strike {
            sample_rate: SampleRate::try_new(self.sample_rate)?,
            seconds: self.seconds.or(self.impact.seconds),
            ..self.impact
        };
        // A mistaken impact is reported before anything is baked.
        let point =
            clangor_core::synthesis::SoundSource::Sphere { radius: 1e-6 * body.surface.bounding_radius() };
        strike::strike(body, &point, &impact)?;
        let SoundModel { acceleration, modal } = self.model(&impact)?;
        let BodyModes::Own(modes) = modal else {
            return Ok(strike::strike(body, &acceleration.source, &impact)?);
        };
        let source = ModalSource::new(modes, &body.material.damping, &ModalSettings::default())?;
        let seconds = self.seconds.or(Some(decay_time(&source, &impact)));
        let impact = strike::Strike { seconds, ..impact };
        let mut sound = strike::strike(body, &acceleration.source, &impact)?;
        let ringing = struck_ringing(body, Arc::new(source), &impact, &sound)?;
        sound.pressures.iter_mut().zip(ringing).for_each(|(sum, p)| *sum += p);
        if self.seconds.is_none() {
            cut_silence(&mut sound, impact.sample_rate.hz());
        }
        Ok(sound)
    }

    /// The sound model of the body, found or baked.
    fn model(&self, impact: &strike::Strike) -> Result<SoundModel, Error> {
        let render = RenderSettings {
            sample_rate: impact.sample_rate,
            acoustics: Acoustics { medium: impact.medium, ..Acoustics::default() },
            sphere_model: impact.sphere_model,
            ..RenderSettings::default()
        };
        let (accuracy, bake) = (self.quality.accuracy(), self.quality.bakes_fields());
        let options = self.quality.modal_options(render.acoustics.medium, render.band().0);
        let settings = SoundModelSettings {
            acceleration: AccelerationSettings::new(render.max_wavenumber(), accuracy, bake),
            wants_acceleration: true,
            modal: Some(ModalPlanSettings { options, proxy_frequency: PROXY_FREQUENCY }),
        };
        let bodies = slice::from_ref(&self.body.body);
        let (cache, bank) = (ModelCache::find(self.cache.as_deref()), default_bank());
        let store = SoundModelStore { cache: cache.as_ref(), bank: bank.as_ref() };
        let plan = SoundModelPlan::new(bodies, &[], settings);
        let struck = BTreeSet::from([BodyId(0)]);
        let mut found = plan.find(bodies, &struck, store, &mut |_| std::ops::ControlFlow::Continue(()))?;
        Ok(found.bodies.swap_remove(0))
    }
}

/// Time in which the longest mode has fallen by 60 dB and reached the listener \[s\], between [`SHORTEST`]
/// and
/// [`LONGEST`].
pub fn decay_time(source: &ModalSource, impact: &strike::Strike) -> f64 {
    let t60 = |r: &Resonance| 3.0 * LN_10 / (TAU * r.frequency * r.damping_ratio);
    let longest = source.resonances().iter().map(t60).fold(0.0, f64::max);
    let travel = impact.listener.length() / impact.medium.sound_speed;
    (longest + travel).clamp(SHORTEST, LONGEST)
}

/// Cuts the end of a sound where it is quieter than the peak by 60 dB.
pub fn cut_silence(sound: &mut StrikeSound, sample_rate: u32) {
    let peak = sound.pressures.iter().fold(0.0f64, |m, p| m.max(p.abs()));
    let heard = sound.pressures.iter().rposition(|p| p.abs() > 1e-3 * peak).map_or(0, |last| last + 1);
    let shortest = ((SHORTEST + LEAD) * f64::from(sample_rate)).ceil() as usize;
    sound.pressures.truncate(heard.max(shortest));
    sound.times.truncate(heard.max(shortest));
}

/// The highest point of the surface about the centre of mass \[m\].
fn highest_point(body: &Body) -> DVec3 {
    match &*body.surface {
        clangor_core::body::Surface::Mesh(surface) => {
            let vertices = surface.mesh.vertices.iter().copied();
            vertices.max_by(|a, b| a.y.total_cmp(&b.y)).unwrap_or(DVec3::ZERO)
        }
        surface => DVec3::Y * surface.bounding_radius(),
    }
}
