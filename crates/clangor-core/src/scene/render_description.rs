//! What a scene asks of the rendering: format of the file, reflection of the floor, sound model of a click.

use crate::contact::ForceProfile;
use crate::sound_model::acceleration::sphere_radiation::SphereModel;
use crate::sound_model::rule::AccelerationRule;

/// All pieces ring as ellipsoids. \[FRAC\] Table 2 has thresholds from 0 to 4000 Hz.
pub const PROXY_FREQUENCY: f64 = 0.0;

/// The `[render]` section.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderDescription {
    /// Sample rate \[Hz\], 8000 to 384 000.
    pub sample_rate: u32,
    /// Format of a sample.
    pub bits: SampleFormat,
    /// What full scale means.
    pub level: Level,
    /// Time profile of a contact force.
    pub pulse: ForceProfile,
    /// What of the sound is rendered.
    pub parts: Parts,
    /// How planes sound that are hit.
    pub ground: GroundSound,
    /// Pieces of broken bodies ring as ellipsoids if their lowest frequency is above this \[Hz\].
    pub proxy_frequency: f64,
    /// Whether impacts put no more energy into modes than the motion lost.
    pub limit_energy: bool,
    /// Whether pieces go on with the vibration of what they were part of.
    pub inherit_vibration: bool,
    /// Whether forces too gentle to be impacts make bodies ring too: rolling, sliding, rattling to rest.
    pub rolling: bool,
    /// What bodies sound as that do not say it themselves.
    pub sound: AccelerationRule,
    /// Sound field of an accelerated sphere.
    pub radiation: SphereModel,
    /// Impulses that one instant sends through a chain of touching bodies sound one after the other.
    pub chain_onset: bool,
    /// Dynamic range compression, after which the file is no longer pressure.
    pub compressor: Option<Compressor>,
}

impl Default for RenderDescription {
    fn default() -> Self {
        RenderDescription {
            sample_rate: 48_000,
            bits: SampleFormat::Float32,
            level: Level::Default,
            pulse: ForceProfile::HalfSine,
            parts: Parts::default(),
            ground: GroundSound::default(),
            proxy_frequency: PROXY_FREQUENCY,
            limit_energy: true,
            inherit_vibration: true,
            rolling: false,
            sound: AccelerationRule::Auto,
            radiation: SphereModel::Exact,
            chain_onset: true,
            compressor: None,
        }
    }
}

/// Parts of the sound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parts {
    /// Clicks: the sound of sudden acceleration.
    pub acceleration: bool,
    /// Ringing: the sound of vibration.
    pub modal: bool,
    /// The ground that is hit.
    pub ground: bool,
}

impl Default for Parts {
    fn default() -> Self {
        Parts { acceleration: true, modal: true, ground: true }
    }
}

/// How planes that face up sound when they are hit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GroundSound {
    /// Not at all.
    None,
    /// As an elastic half-space of their material ([`ground`](crate::synthesis::ground)).
    #[default]
    HalfSpace,
    /// As the slab of concrete of \[FRAC\] ([`slab`](crate::reference::slab)).
    Slab,
}

/// Format of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleFormat {
    /// 32-bit float.
    Float32,
    /// 24-bit integer.
    Int24,
}

/// How pressure maps to samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Level {
    /// The program's default of the sample format: 1 Pa for float, 20 Pa for integers.
    Default,
    /// This pressure is full scale \[Pa\].
    FullScale(f64),
    /// The peak is brought to this level \[dBFS\], 0 or less.
    Normalize(f64),
}

/// A compressor: above the threshold, `ratio` decibels in give one decibel out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compressor {
    /// Threshold \[dB re full scale\], 0 or less.
    pub threshold_db: f64,
    /// Ratio \[-\], 1 or more.
    pub ratio: f64,
    /// Attack time \[s\].
    pub attack: f64,
    /// Release time \[s\].
    pub release: f64,
    /// Gain after compression \[dB\].
    pub makeup_db: f64,
}

impl Default for Compressor {
    fn default() -> Self {
        Compressor { threshold_db: -20.0, ratio: 4.0, attack: 0.002, release: 0.1, makeup_db: 0.0 }
    }
}
