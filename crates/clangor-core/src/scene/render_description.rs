//! Settings of a scene for rendering: file format, level, parts of the sound, sound models.

use crate::contact::ForceProfile;
use crate::contact::contact_forces::OFFLINE_STEPS;
use crate::sound_model::acceleration::sphere_radiation::SphereModel;
use crate::sound_model::rule::AccelerationRule;

/// Default of [`RenderDescription::proxy_frequency`] \[Hz\]: all pieces ring as ellipsoids. \[FRAC\] Table 2
/// has thresholds from 0 to 4000 Hz.
pub const PROXY_FREQUENCY: f64 = 0.0;

/// The `[render]` section. `docs/format/scene.md` describes its keys.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderDescription {
    /// Sample rate \[Hz\], 8000 to 384 000. Default: 48 000.
    pub sample_rate: u32,
    /// Sample format of the file: 32-bit float or 24-bit integer. Default: 32-bit float.
    pub bits: SampleFormat,
    /// Pressure \[Pa\] or peak level \[dBFS\] that sets full scale. Default: 1 Pa for float, 20 Pa for
    /// integers.
    pub level: Level,
    /// Time profile of a contact force. Default: Hertz's pulse.
    pub pulse: ForceProfile,
    /// Parts of the sound that are rendered. Default: all.
    pub parts: Parts,
    /// Model of the ground that impacts excite. Default: elastic half-space.
    pub ground: GroundSound,
    /// Lowest natural frequency \[Hz\] above which pieces of broken bodies ring as ellipsoids, 0 to 1e6.
    /// Default: [`PROXY_FREQUENCY`].
    pub proxy_frequency: f64,
    /// Steps of the solve of an impact per first duration of the contact, 2 to 256. Default:
    /// [`OFFLINE_STEPS`].
    pub contact_steps: u32,
    /// Whether pieces of a broken body inherit its vibration. Default: true.
    pub inherit_vibration: bool,
    /// Whether contact forces too weak to be impacts excite modes: rolling, sliding, settling. Default:
    /// false.
    pub rolling: bool,
    /// Acceleration model of bodies without one of their own in the scene. Default: automatic.
    pub sound: AccelerationRule,
    /// Sound field of an accelerated sphere. Default: exact.
    pub radiation: SphereModel,
    /// Whether simultaneous impulses along a chain of touching bodies get successive onsets
    /// ([`chain_onset`](crate::contact::chain_onset)). Default: true.
    pub chain_onset: bool,
    /// Compressor of the dynamic range; with it, samples are no longer proportional to pressure. Default:
    /// none.
    pub compressor: Option<Compressor>,
}

impl Default for RenderDescription {
    fn default() -> Self {
        RenderDescription {
            sample_rate: 48_000,
            bits: SampleFormat::Float32,
            level: Level::Default,
            pulse: ForceProfile::default(),
            parts: Parts::default(),
            ground: GroundSound::default(),
            proxy_frequency: PROXY_FREQUENCY,
            contact_steps: OFFLINE_STEPS as u32,
            inherit_vibration: true,
            rolling: false,
            sound: AccelerationRule::Auto,
            radiation: SphereModel::Exact,
            chain_onset: true,
            compressor: None,
        }
    }
}

/// Parts of the sound. All are on by default.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parts {
    /// Clicks: the pressure of rigid-body acceleration.
    pub acceleration: bool,
    /// Ringing: the pressure of vibration modes.
    pub modal: bool,
    /// The pressure of the ground under an impact.
    pub ground: bool,
}

impl Default for Parts {
    fn default() -> Self {
        Parts { acceleration: true, modal: true, ground: true }
    }
}

/// Sound model of upward-facing planes under an impact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GroundSound {
    /// No sound.
    None,
    /// Elastic half-space of the plane's material ([`ground`](crate::synthesis::ground)).
    #[default]
    HalfSpace,
    /// Concrete slab of \[FRAC\] ([`slab`](crate::reference::slab)).
    Slab,
}

/// Sample format of an audio file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleFormat {
    /// 32-bit float.
    Float32,
    /// 24-bit integer.
    Int24,
}

/// Mapping from pressure to samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Level {
    /// Full scale of the sample format: 1 Pa for float, 20 Pa for integers.
    Default,
    /// This pressure is full scale \[Pa\], 1e-9 to 1e9.
    FullScale(f64),
    /// The peak is scaled to this level \[dBFS\], −120 to 0.
    Normalize(f64),
}

/// A compressor of the dynamic range. Above the threshold, a level rise of `ratio` dB at the input gives 1 dB
/// at the output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compressor {
    /// Threshold \[dB re full scale\], −120 to 0. Default: −20.
    pub threshold_db: f64,
    /// Ratio \[-\], 1 to 100. Default: 4.
    pub ratio: f64,
    /// Attack time \[s\], 0 to 10. Default: 0.002.
    pub attack: f64,
    /// Release time \[s\], 0 to 10. Default: 0.1.
    pub release: f64,
    /// Gain after compression \[dB\], −60 to 60. Default: 0.
    pub makeup_db: f64,
}

impl Default for Compressor {
    fn default() -> Self {
        Compressor { threshold_db: -20.0, ratio: 4.0, attack: 0.002, release: 0.1, makeup_db: 0.0 }
    }
}
