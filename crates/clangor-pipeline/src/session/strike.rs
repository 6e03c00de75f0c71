//! One impact on one body, heard by one listener in free space.
//!
//! The body rests with its centre of mass at the origin. The force begins at t = 0 and the sound 2 ms before,
//! because a band-limited onset rings before it arrives; the travel time to the listener is in it.

use std::f64::consts::{LN_10, TAU};
use std::ops::ControlFlow;
use std::path::PathBuf;

use clangor_core::contact::contact_forces::OFFLINE_STEPS;
use clangor_core::contact::force_profile::ForceProfile;
use clangor_core::glam::DVec3;
use clangor_core::medium::Medium;
use clangor_core::propagation::Room;
use clangor_core::scene::render_description::Parts;
use clangor_core::sound_model::AccelerationRule;
use clangor_core::sound_model::acceleration::sphere_radiation::SphereModel;
use clangor_core::synthesis::SampleRate;
use clangor_core::synthesis::modal::Resonance;
use clangor_core::synthesis::strike::{self, LEAD, StrikeForce, Striker};

use super::error::Error;
use super::progress::Progress;
use super::sounding_body::{SoundingBody, point_source};
use super::struck_body::StruckBody;
use super::struck_model::ModelChoice;
use super::struck_sound::StruckSound;
use super::top_point::{TopPoint, top_point};
use crate::stages::sound_models::ModelOptions;

/// Shortest sound, unless another length is asked for \[s\].
pub const SHORTEST: f64 = 0.1;
/// Longest sound, unless another length is asked for \[s\].
pub const LONGEST: f64 = 20.0;
/// Impulse on the body where neither an impulse nor a striker is given [N s].
pub const DEFAULT_IMPULSE: DVec3 = DVec3::new(0.0, -0.01, 0.0);

/// Listener where none is given \[m from the centre of mass\]: 1 m away, off the axes, in whose directions
/// and planes clicks have nulls.
pub const DEFAULT_LISTENER: DVec3 = DVec3::new(0.6, 0.8, 0.0);

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
    pub(super) body: StruckBody,
    pub(super) impact: strike::Strike,
    impulse: Option<DVec3>,
    /// Impulse where none is given [N s].
    usual_impulse: DVec3,
    duration: Option<f64>,
    striker: Option<Striker>,
    seconds: Option<f64>,
    sample_rate: u32,
    pub(super) parts: Parts,
    pub(super) model: ModelChoice,
}

impl Strike {
    /// An impulse of 0.01 N s downwards on top of the body, off the middle of its highest face, heard 1 m
    /// away, at 48 kHz. Domes, bells and other bodies whose highest place is a pole above the centre of mass
    /// are struck near their edge as seen from above, at a right angle to their surface.
    pub fn new(body: impl Into<StruckBody>) -> Self {
        let body = body.into();
        let TopPoint { point, inwards } = top_point(&body.body);
        Strike {
            body,
            impact: usual_impact(point),
            impulse: None,
            usual_impulse: DEFAULT_IMPULSE.length() * inwards,
            duration: None,
            striker: None,
            seconds: None,
            sample_rate: 48_000,
            parts: Parts::default(),
            model: ModelChoice::default(),
        }
    }

    /// Strikes at a point of the surface \[m from the centre of mass\], by default with an impulse downwards.
    #[must_use]
    pub fn at(mut self, point: impl Into<DVec3>) -> Self {
        self.impact.point = point.into();
        self.usual_impulse = DEFAULT_IMPULSE;
        self
    }

    /// Impulse on the body [N s].
    #[must_use]
    pub fn impulse(self, impulse: impl Into<DVec3>) -> Self {
        Strike { impulse: Some(impulse.into()), ..self }
    }

    /// A ball that hits the body, instead of an impulse. Impulse and duration follow from both bodies.
    #[must_use]
    pub fn striker(self, striker: Striker) -> Self {
        Strike { striker: Some(striker), ..self }
    }

    /// Steps of the solve of a striker's contact per first duration of the contact.
    #[must_use]
    pub fn contact_steps(mut self, steps: u32) -> Self {
        self.impact.steps = f64::from(steps.clamp(2, 256));
        self
    }

    /// Position of the listener \[m from the centre of mass\].
    #[must_use]
    pub fn listener(mut self, position: impl Into<DVec3>) -> Self {
        self.impact.listener = position.into();
        self
    }

    /// A room, whose corners are relative to the centre of mass. Default: free space.
    #[must_use]
    pub fn room(mut self, room: Room) -> Self {
        self.impact.room = Some(room);
        self
    }

    /// Duration of the contact of a given impulse \[s\]. Default: that of a collision with a rigid plane at
    /// 1 m/s.
    #[must_use]
    pub fn contact_duration(self, seconds: f64) -> Self {
        Strike { duration: Some(seconds), ..self }
    }

    /// End of the sound \[s\]. Default: when its ringing has fallen by 60 dB or is 100 dB below the peak,
    /// after 20 s at most.
    #[must_use]
    pub fn seconds(self, seconds: f64) -> Self {
        Strike { seconds: Some(seconds), ..self }
    }

    /// Samples per second \[Hz\], 8000 to 384 000.
    #[must_use]
    pub fn sample_rate(self, hz: u32) -> Self {
        Strike { sample_rate: hz, ..self }
    }

    /// Parts of the sound of the body. Default: acceleration and modal. A striker is heard as it says itself.
    #[must_use]
    pub fn parts(self, parts: Parts) -> Self {
        Strike { parts, ..self }
    }

    /// Rule for the acceleration field of the body. Default: chosen by size and convexity.
    #[must_use]
    pub fn acceleration(self, rule: AccelerationRule) -> Self {
        Strike { model: ModelChoice { acceleration_rule: Some(rule), ..self.model }, ..self }
    }

    /// How the sound model is baked, and the highest frequency that is rendered in full.
    #[must_use]
    pub fn models(self, options: ModelOptions) -> Self {
        Strike { model: ModelChoice { options, ..self.model }, ..self }
    }

    /// Folder of baked sound models. Default: `CLANGOR_CACHE`, or the system's folder for caches.
    #[must_use]
    pub fn cache(self, folder: impl Into<PathBuf>) -> Self {
        Strike { model: ModelChoice { cache: Some(folder.into()), ..self.model }, ..self }
    }

    /// The sound: pressures \[Pa\] at times \[s\]. Bakes the sound model of the body if it is not in the
    /// cache.
    ///
    /// # Errors
    /// [`Error::Strike`] for an impact off the surface or without impulse, [`Error::TwoForces`] for a striker
    /// together with an impulse or a duration, [`Error::ModelOptions`],
    /// [`Error::Models`], [`Error::Modes`], [`Error::ModelField`], [`Error::Synthesis`].
    pub fn render(self) -> Result<StruckSound, Error> {
        self.render_with_progress(&mut |_| ControlFlow::Continue(()))
    }

    /// As [`render`](Self::render), and sends the progress of baking to `on_progress`, which breaks to stop.
    ///
    /// # Errors
    /// As [`render`](Self::render); after a break an error of which [`Error::is_interruption`] is true.
    pub fn render_with_progress(
        self,
        on_progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<StruckSound, Error> {
        let body = &self.body.body;
        let sample_rate = SampleRate::try_new(self.sample_rate)?;
        self.model.options.check(sample_rate.as_f64())?;
        let impact = strike::Strike {
            force: self.force()?,
            sample_rate,
            max_frequency: self.model.options.max_frequency,
            seconds: self.seconds.or(self.impact.seconds),
            ..self.impact.clone()
        };
        // A mistaken impact is reported before anything is baked.
        strike::strike(body, &point_source(body), None, &impact)?;
        let sounding = SoundingBody::obtain(&self.body, &self.model, &self.parts, &impact, on_progress)?;
        let ring_time = decay_time(sounding.resonances(), &impact);
        let seconds = self.seconds.or(ring_time).or(impact.seconds).unwrap_or(SHORTEST);
        let (mut sound, _) = sounding.sound(&impact, seconds)?;
        if self.seconds.is_none() && sound.modes > 0 {
            cut_silence(&mut sound);
        }
        Ok(sound)
    }
}

impl Strike {
    /// What strikes the body.
    fn force(&self) -> Result<StrikeForce, Error> {
        let Strike { impulse, usual_impulse, duration, striker, .. } = self;
        match striker {
            None => {
                Ok(StrikeForce::Impulse { impulse: impulse.unwrap_or(*usual_impulse), duration: *duration })
            }
            Some(_) if impulse.is_some() || duration.is_some() => Err(Error::TwoForces),
            Some(striker) => Ok(StrikeForce::Striker(striker.clone())),
        }
    }
}

/// The impact where nothing else is asked for, at a point \[m\].
pub(crate) fn usual_impact(point: DVec3) -> strike::Strike {
    strike::Strike {
        force: StrikeForce::Impulse { impulse: DEFAULT_IMPULSE, duration: None },
        point,
        listener: DEFAULT_LISTENER,
        profile: ForceProfile::default(),
        steps: OFFLINE_STEPS,
        sample_rate: SampleRate::HZ_48000,
        max_frequency: None,
        seconds: Some(SHORTEST),
        medium: Medium::AIR,
        room: None,
        sphere_model: SphereModel::Exact,
    }
}

/// Time in which the longest mode has fallen by 60 dB and reached the listener \[s\], between [`SHORTEST`]
/// and [`LONGEST`]; `None` without modes.
fn decay_time(modes: &[Resonance], impact: &strike::Strike) -> Option<f64> {
    let longest = modes.iter().map(t60).reduce(f64::max)?;
    let travel = impact.listener.length() / impact.medium.sound_speed;
    Some((longest + travel).clamp(SHORTEST, LONGEST))
}

/// Time in which a mode falls by 60 dB \[s\].
pub(crate) fn t60(mode: &Resonance) -> f64 {
    3.0 * LN_10 / (TAU * mode.frequency * mode.damping_ratio)
}

/// Time after the peak in which the click of an impact is over \[s\].
const CLICK: f64 = 0.02;
/// Level at which ringing ends, over its own peak, and over that of all \[dB\].
const ENDS: f64 = 1e-3;
const UNHEARD: f64 = 1e-5;

/// Cuts the end of a sound where its ringing has fallen by 60 dB, or is 100 dB below the peak.
fn cut_silence(sound: &mut StruckSound) {
    let peak = sound.peak();
    let rate = sound.sample_rate.as_f64();
    let loudest = sound.pressures.iter().position(|p| p.abs() >= peak).unwrap_or(0);
    let ringing = sound.pressures.iter().skip(loudest + (CLICK * rate) as usize);
    let ringing = ringing.fold(0.0_f64, |most, p| most.max(p.abs()));
    let least = (ENDS * ringing).max(UNHEARD * peak);
    let heard = sound.pressures.iter().rposition(|p| p.abs() > least).map_or(0, |last| last + 1);
    let shortest = ((SHORTEST + LEAD) * rate).ceil() as usize;
    sound.pressures.truncate(heard.max(shortest));
    sound.times.truncate(heard.max(shortest));
}
