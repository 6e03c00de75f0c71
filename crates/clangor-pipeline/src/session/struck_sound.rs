//! The sound of one impact on one body: samples, the data of the contact, and what radiated.

use std::fmt;
use std::path::Path;

use clangor_core::glam::DVec3;
use clangor_core::synthesis::BodyModes;
use clangor_core::synthesis::SampleRate;
use clangor_core::synthesis::SoundPart;
use clangor_core::synthesis::source_rule::SourceKind;
use clangor_core::synthesis::strike::LEAD;

use super::error::Error;
use crate::formats::atomic_file::{check_folder, write_atomically};
use crate::formats::wav::{Meaning, SampleFormat, WavSpec, WavWriter};
use crate::stages::sound_models::OtherMaterial;
use crate::stages::sound_models::patience::cpu_time;

/// The sound of an impact on a body.
#[derive(Clone, Debug, PartialEq)]
pub struct StruckSound {
    /// Pressure at the listener \[Pa\].
    pub pressures: Vec<f64>,
    /// Time of each sample after the begin of the contact \[s\].
    pub times: Vec<f64>,
    /// Samples per second.
    pub sample_rate: SampleRate,
    /// Point of the impact \[m from the centre of mass\].
    pub point: DVec3,
    /// The listener \[m from the centre of mass\].
    pub listener: DVec3,
    /// Duration of the contact \[s\].
    pub contact_duration: f64,
    /// Change in velocity of the centre of mass [m/s].
    pub velocity_change: DVec3,
    /// Impulse on the body [N s].
    pub impulse: DVec3,
    /// Largest force on the body, below half the sample rate \[N\].
    pub peak_force: f64,
    /// Energy that the forces of rigid bodies would give to the modes, over that of the striker's approach; 0
    /// without a striker or without modes. Above 1, the force on the modes is scaled to the energy.
    pub modal_energy_ratio: f64,
    /// Radius of the sphere of equal volume \[m\].
    pub radius: f64,
    /// Time in which sound reaches the listener from the centre of mass \[s\].
    pub travel_time: f64,
    /// Number of resonances that are heard.
    pub modes: usize,
    /// The modes, or the reason for none; `None` where the modal part is not asked for, or the given model
    /// lacks it.
    pub modal: Option<BodyModes>,
    /// The model of the acceleration part; `None` where that part is not asked for, or is in the
    /// representation of \[PAN\].
    pub acceleration: Option<SourceKind>,
    /// Defects of the sound models.
    pub remarks: Vec<StrikeRemark>,
    /// Comment of the WAV file.
    pub(super) note: String,
}

/// A defect of the sound models behind a [`StruckSound`].
#[derive(Clone, Debug, PartialEq)]
pub enum StrikeRemark {
    /// A part that could not be baked, an entry of the cache that was replaced, a warning of a solver.
    SoundModel(String),
    /// Modes of another material.
    OtherMaterial(OtherMaterial),
    /// A part that is a draft, as the exact one takes longer than the patience.
    Draft {
        /// The body.
        body: String,
        /// The part.
        part: SoundPart,
        /// Estimated CPU time of the exact part \[s\]; infinite if it cannot be computed.
        seconds: f64,
    },
    /// The acceleration field ends below the band of the sound.
    ShortField {
        /// The body.
        body: String,
        /// Upper end of the field \[Hz\].
        end: f64,
        /// Upper end of the band \[Hz\].
        band: f64,
    },
}

impl fmt::Display for StrikeRemark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StrikeRemark::SoundModel(remark) => f.write_str(remark),
            StrikeRemark::OtherMaterial(remark) => remark.fmt(f),
            StrikeRemark::Draft { body, part, seconds } => {
                let (what, error) = match part {
                    SoundPart::Modal => ("ringing", "about a hundred modes in few elements"),
                    _ => ("click", "third octaves within about 3 dB in the median"),
                };
                write!(f, "the {what} of \"{body}\" is a draft ({error})")?;
                if seconds.is_infinite() {
                    return Ok(());
                }
                write!(
                    f,
                    ": exact takes about {} of CPU time, with --quality normal and enough --patience",
                    cpu_time(*seconds)
                )
            }
            StrikeRemark::ShortField { body, end, band } => {
                write!(f, "the field of \"{body}\" ends at {end:.0} Hz, and the file's band at {band:.0} Hz")
            }
        }
    }
}

/// What the ending of a file says of its content.
enum SoundFormat {
    Csv,
    Wav,
}

impl SoundFormat {
    fn of(path: &Path) -> Result<Self, Error> {
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("csv") => Ok(SoundFormat::Csv),
            Some("wav") => Ok(SoundFormat::Wav),
            _ => Err(Error::OutputEnding),
        }
    }
}

/// Checks that a sound can be [written](StruckSound::write) to a file, before it is computed.
///
/// # Errors
/// [`Error::OutputEnding`], and [`Error::Output`] for a folder that does not exist.
pub fn check_sound_file(path: impl AsRef<Path>) -> Result<(), Error> {
    SoundFormat::of(path.as_ref())?;
    Ok(check_folder(path.as_ref())?)
}

impl StruckSound {
    /// Largest absolute pressure \[Pa\].
    pub fn peak(&self) -> f64 {
        self.pressures.iter().fold(0.0f64, |m, p| m.max(p.abs()))
    }

    /// Writes the sound as a WAV file (`.wav`, 32-bit float), or as a table of times and pressures (`.csv`).
    ///
    /// # Errors
    /// [`Error::OutputEnding`], [`Error::Wav`], [`Error::Output`]; the file appears only once it is complete.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        match SoundFormat::of(path)? {
            SoundFormat::Csv => self.write_csv(path),
            SoundFormat::Wav => self.write_wav(path),
        }
    }

    fn write_csv(&self, path: &Path) -> Result<(), Error> {
        let mut text = String::from("time_s,pressure_pa\n");
        for (time, pressure) in self.times.iter().zip(&self.pressures) {
            text.push_str(&format!("{time:.9e},{pressure:.9e}\n"));
        }
        Ok(write_atomically(path, text.as_bytes())?)
    }

    fn write_wav(&self, path: &Path) -> Result<(), Error> {
        let spec = WavSpec {
            sample_rate: self.sample_rate.hz(),
            channels: 1,
            format: SampleFormat::Float32,
            full_scale: WavSpec::default_full_scale(SampleFormat::Float32),
            meaning: Meaning::Pressure,
            note: format!("{}, begins {LEAD} s before the contact", self.note),
        };
        let samples: Vec<f32> = self.pressures.iter().map(|p| *p as f32).collect();
        let mut file = WavWriter::create(path, spec)?;
        file.write(&samples)?;
        file.finish()?;
        Ok(())
    }
}
