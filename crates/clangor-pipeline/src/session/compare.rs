//! A recording against a model: the tones of one impact beside the modes of a body, and the Young's modulus
//! and the damping that explain them.
//!
//! A mode loses energy to its material and to the air, δ = ω (ξ + η_rad/2). The transfers of a sound model
//! give η_rad, and its law of damping is then that of the material alone; a shape or a mesh has no transfers
//! here, and its law is that of both. Supports count as material either way.
//!
//! ```no_run
//! use clangor_pipeline::session::{Compare, Error, named_body::preset};
//!
//! let found = Compare::new("bowl").material(preset("ceramic")?).sound("bowl.wav")?;
//! println!("E = {:?} Pa", found.youngs_modulus());
//! # Ok::<(), Error>(())
//! ```

use std::f64::consts::{LN_10, TAU};
use std::ffi::OsString;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clangor_bake::acceleration::BakeProgress;
use clangor_bake::modal::ModalBakeOptions;
use clangor_core::material::Material;
use clangor_core::medium::Medium;
use clangor_core::sound_model::files::modal_file::ModalPart;
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel};
use clangor_core::synthesis::modal::source::radiation_ratio;

use super::Stage;
use super::compare_error::CompareError;
use super::error::Error;
use super::named_body::NamedSolid;
use super::progress::Progress;
use crate::analysis::damping_fit::{DampingFit, Decay, fit_damping};
use crate::analysis::decaying_tones::{DecayingTone, decaying_tones};
use crate::analysis::mode_match::{ModeMatch, Tone, match_modes};
use crate::formats::model_cache::ModelCache;
use crate::formats::wav::WavReader;
use crate::stages::sound_models::modal_bake::obtain_modes;
use crate::stages::sound_models::{ModalBake, SoundFile, SoundModelRequest, read_sound_file};

/// Frames of a WAV file read at once.
const FRAMES_AT_ONCE: usize = 1 << 16;
/// Level of a tone that weighs half as much as the loudest \[dB\].
const HALF_WEIGHT: f64 = -40.0;
/// Relative error of a measured decay; of radiation at the frequency of the model; and what it grows by, per
/// relative distance from that. Measured on renders of bars, plates and bowls.
const MEASURED: f64 = 0.02;
const RADIATED: f64 = 0.02;
const MOVED: f64 = 2.0;
/// δ T60.
const DECAY: f64 = 3.0 * LN_10;

/// A model to compare recordings with.
#[derive(Clone, Debug)]
pub struct Compare {
    model: OsString,
    material: Option<Material>,
    scale: f64,
    max_frequency: f64,
    accuracy: f64,
    channel: Option<u16>,
    cache: Option<PathBuf>,
}

/// A mode of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComparedMode {
    /// \[Hz\].
    pub frequency: f64,
    /// Relative error of the frequency by the mesh; NaN if unknown.
    pub mesh_error: f64,
    /// Rate of decay by radiation at the frequency of the recording, ω η_rad/2 [1/s]; 0 without a transfer.
    pub radiated: f64,
    /// Time to decay by 60 dB there, with the material and the radiation \[s\]; `None` without a material.
    pub t60: Option<f64>,
}

/// The tones of a recording and the modes of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Tones, by frequency.
    pub tones: Vec<DecayingTone>,
    /// Modes, by frequency.
    pub modes: Vec<ComparedMode>,
    /// Which tone is which mode; `None` if none is.
    pub matched: Option<ModeMatch>,
    /// Damping laws of the matched tones, less the radiation that is known, the best first.
    pub damping: Vec<DampingFit>,
    /// Young's modulus of the model \[Pa\]; NaN for modes of a glTF file, which have none.
    pub model_youngs_modulus: f64,
    /// What is doubtful.
    pub warnings: Vec<String>,
}

impl Comparison {
    /// Young's modulus that explains the frequencies, and its standard error, with that of the mesh \[Pa\].
    pub fn youngs_modulus(&self) -> Option<(f64, f64)> {
        let matched = self.matched.as_ref()?;
        let errors = matched.pairs.iter().map(|(_, mode)| self.modes[*mode].mesh_error);
        let known: Vec<f64> = errors.filter(|e| e.is_finite()).collect();
        let mesh = known.iter().sum::<f64>() / known.len().max(1) as f64;
        let modulus = self.model_youngs_modulus * matched.ratio * matched.ratio;
        Some((modulus, 2.0 * modulus * matched.error.hypot(mesh)))
    }

    /// The mode of each tone.
    pub fn mode_of(&self, tone: usize) -> Option<usize> {
        let pairs = &self.matched.as_ref()?.pairs;
        pairs.iter().find(|(own, _)| *own == tone).map(|(_, mode)| *mode)
    }
}

impl Compare {
    /// A model by its word: a shape of the library, a mesh file, a glTF file with the sound of its bodies, or
    /// a sound model (`.safetensors`) with modes.
    pub fn new(model: impl Into<OsString>) -> Self {
        Compare {
            model: model.into(),
            material: None,
            scale: 1.0,
            max_frequency: 20_000.0,
            accuracy: 0.01,
            channel: None,
            cache: None,
        }
    }

    /// The material, which shapes and mesh files need; of a sound model only its damping is compared.
    #[must_use]
    pub fn material(self, material: Material) -> Self {
        Compare { material: Some(material), ..self }
    }

    /// The unit of a mesh file \[m\]. Default: 1.
    #[must_use]
    pub fn scale(self, scale: f64) -> Self {
        Compare { scale, ..self }
    }

    /// Highest frequency of tones and modes \[Hz\]. Default: 20 kHz.
    #[must_use]
    pub fn max_frequency(self, hz: f64) -> Self {
        Compare { max_frequency: hz, ..self }
    }

    /// Relative error of the frequencies of the model by its mesh. Default: 0.01.
    #[must_use]
    pub fn accuracy(self, accuracy: f64) -> Self {
        Compare { accuracy, ..self }
    }

    /// The channel of the recording, from 1. Default: the only one.
    #[must_use]
    pub fn channel(self, channel: u16) -> Self {
        Compare { channel: Some(channel), ..self }
    }

    /// Folder of baked sound models. Default: `CLANGOR_CACHE`, or the system's folder for caches.
    #[must_use]
    pub fn cache(self, folder: impl Into<PathBuf>) -> Self {
        Compare { cache: Some(folder.into()), ..self }
    }

    /// Compares a WAV file with the model.
    ///
    /// # Errors
    /// [`Error::Compare`]; [`Error::ModalMaterial`], [`Error::Models`] and those of [`NamedSolid::open`].
    pub fn sound(&self, path: impl AsRef<Path>) -> Result<Comparison, Error> {
        self.sound_with_progress(path, &mut |_| ControlFlow::Continue(()))
    }

    /// As [`sound`](Self::sound); progress goes to `on_progress`, which breaks to stop.
    ///
    /// # Errors
    /// As [`sound`](Self::sound).
    pub fn sound_with_progress(
        &self,
        path: impl AsRef<Path>,
        on_progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<Comparison, Error> {
        let path = path.as_ref();
        let (samples, rate) = self.read(path)?;
        // The recording first: its faults are found in no time, modes may take long.
        let tones = decaying_tones(&samples, rate, self.max_frequency)
            .map_err(|source| CompareError::Tones { path: path.into(), source })?;
        let (model, youngs_modulus, mut warnings) = self.modes(on_progress)?;
        let within: Vec<&ModalMode> =
            model.known_modes().iter().filter(|mode| mode.frequency <= self.max_frequency).collect();
        if within.is_empty() {
            let (name, max_frequency) = (self.model.to_string_lossy().into_owned(), self.max_frequency);
            return Err(CompareError::NoModes { name, max_frequency }.into());
        }
        let weigh = |tone: &DecayingTone| Tone {
            frequency: tone.frequency,
            weight: 1.0 / (1.0 + (tone.level / HALF_WEIGHT).powi(2)),
        };
        let heard: Vec<Tone> = tones.iter().map(weigh).collect();
        let frequencies: Vec<f64> = within.iter().map(|mode| mode.frequency).collect();
        let matched = match_modes(&heard, &frequencies);
        let ratio = matched.as_ref().map_or(1.0, |found| found.ratio);
        let modes: Vec<ComparedMode> = within.iter().map(|mode| self.compared(&model, mode, ratio)).collect();
        let pairs = matched.iter().flat_map(|found| &found.pairs);
        let material = |(tone, mode): &(usize, usize)| {
            let (tone, radiated) = (&tones[*tone], modes[*mode].radiated);
            // What is left of a tone that mostly radiates has the errors of both.
            let whole = DECAY / tone.t60;
            let decay = whole - radiated;
            let error = (MEASURED * whole).hypot((RADIATED + MOVED * ratio.ln().abs()) * radiated);
            let weight = (decay / error).powi(2);
            (decay > 0.0).then_some(Decay { frequency: tone.frequency, t60: DECAY / decay, weight })
        };
        let decays: Vec<Decay> = pairs.filter_map(material).collect();
        warnings.extend(clipped(&samples));
        warnings.extend(matched.as_ref().and_then(doubt));
        Ok(Comparison {
            damping: fit_damping(&decays),
            tones,
            modes,
            matched,
            model_youngs_modulus: youngs_modulus,
            warnings,
        })
    }

    /// A mode of a body whose frequencies are `ratio` times those of the model. The field at its surface
    /// hardly depends on the frequency, and the radiated power follows from the field.
    fn compared(&self, model: &ModalModel, mode: &ModalMode, ratio: f64) -> ComparedMode {
        let ModalMode { frequency, mesh_error, .. } = *mode;
        let sounding = frequency * ratio;
        let moved = ModalMode {
            frequency: sounding,
            mesh_error,
            support_damping: 0.0,
            shape: Vec::new(),
            transfer: mode.transfer.clone(),
        };
        let radiated = TAU * sounding * radiation_ratio(model, &moved);
        let t60 = |material: &Material| DECAY / (DECAY / material.damping.t60(sounding) + radiated);
        ComparedMode { frequency, mesh_error, radiated, t60: self.material.as_ref().map(t60) }
    }

    /// One channel of the recording, and its rate \[Hz\].
    fn read(&self, path: &Path) -> Result<(Vec<f32>, f64), CompareError> {
        let mut reader = WavReader::open(path)?;
        let (count, rate) = (reader.info().channels, f64::from(reader.info().sample_rate));
        let channel = match self.channel {
            Some(channel) if (1..=count).contains(&channel) => channel,
            Some(channel) => return Err(CompareError::Channel { path: path.into(), channel, count }),
            None if count > 1 => return Err(CompareError::Channels { path: path.into(), count }),
            None => 1,
        };
        let mut samples = Vec::new();
        while reader.read(&mut samples, FRAMES_AT_ONCE)? > 0 {}
        let own = samples.chunks_exact(usize::from(count)).map(|frame| frame[usize::from(channel) - 1]);
        Ok((own.collect(), rate))
    }

    /// The modes of the model, its Young's modulus \[Pa\], and what is doubtful about it.
    fn modes(
        &self,
        on_progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<(ModalModel, f64, Vec<String>), Error> {
        let path = Path::new(&self.model);
        if path.extension().is_some_and(|ending| ending == "safetensors") {
            let part: Option<ModalPart> = match read_sound_file(path)? {
                SoundFile::Model(file) => file.modal,
                SoundFile::Modal(file) => Some(file.modal),
                SoundFile::Pan(_) => None,
                SoundFile::Bank(_) | SoundFile::ModalSoundbank(_) => {
                    return Err(Error::Soundbank { path: path.into() });
                }
            };
            let part = part.ok_or_else(|| CompareError::NoModalPart { path: path.into() })?;
            return Ok((part.model, part.origin.youngs_modulus, Vec::new()));
        }
        let solid = NamedSolid::open(&self.model, self.scale, self.material.clone())?;
        if let Some(modes) = solid.modal {
            return Ok((modes, f64::NAN, solid.remarks));
        }
        let material = solid.material.ok_or(Error::ModalMaterial)?;
        let options = ModalBakeOptions {
            max_frequency: self.max_frequency,
            mesh_error: self.accuracy,
            ..ModalBakeOptions::new(Medium::AIR)
        };
        let part = ModalBake::new(&material, options);
        let request = SoundModelRequest::new(&solid.name, &solid.geometry.surface, solid.geometry.mass, part)
            .map_err(|source| Error::Unbakeable { name: solid.name.clone(), source })?;
        let cache = ModelCache::find(self.cache.as_deref());
        let mut reached = |p: &BakeProgress| {
            let (body, step) = (solid.name.as_str(), p.stage);
            on_progress(&Progress { stage: Stage::Modal, done: p.done, body, step })
        };
        let (mut model, _) = obtain_modes(&request, cache.as_ref(), &mut reached)?;
        // The cache may have them or not, and the answer must not depend on it.
        model.modes.iter_mut().for_each(|mode| mode.transfer = None);
        Ok((model, material.youngs_modulus, solid.remarks))
    }
}

/// Level from which equal samples at the peak are clipped ones, and the fewest in a row.
const CLIPPED: f32 = 0.98;
const IN_A_ROW: usize = 3;

/// A warning where a recording is cut off at its peak.
fn clipped(samples: &[f32]) -> Option<String> {
    let peak = samples.iter().fold(0.0_f32, |peak, p| peak.max(p.abs()));
    let at_peak = |a: &f32, b: &f32| a == b && a.abs() > peak * (1.0 - 1e-4);
    let count: usize = samples.chunk_by(at_peak).map(<[f32]>::len).filter(|length| *length >= IN_A_ROW).sum();
    (peak >= CLIPPED && count > 0).then(|| {
        format!(
            "{count} samples in rows of {IN_A_ROW} and more are at the peak of {peak:.3}: a clipped \
             recording has tones that the body has not, and levels and decays that are off"
        )
    })
}

/// Share of the tones, by weight, below which a match may be chance. Seen: 0.19 to 0.26 for recordings of
/// other bodies.
const FEW: f64 = 0.4;

/// What speaks against a match.
fn doubt(found: &ModeMatch) -> Option<String> {
    if found.pairs.len() == 1 {
        return Some("a single tone is matched: which mode it is cannot be told, nor Young's modulus".into());
    }
    if found.share < FEW {
        return Some(format!(
            "the loudest tones have no mode: those matched have {:.0} % of the weight, and Young's modulus \
             may be chance; either the recording is not of this body, or the model is a coarse one",
            100.0 * found.share
        ));
    }
    found.rival.map(|rival| {
        format!(
            "frequencies {rival:.4} times those of the model explain the tones nearly as well as {:.4} times",
            found.ratio
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_loud_recording_with_flat_peaks_is_clipped() {
        let tone = |size: f32| -> Vec<f32> {
            // 1 kHz at 48 kHz, of 16 bits.
            (0..4800).map(|i| (32767.0 * size * (0.1309 * i as f32).sin()).round() / 32767.0).collect()
        };
        let cut = |most: f32, size: f32| -> Vec<f32> {
            tone(size).into_iter().map(|p| p.clamp(-most, most)).collect()
        };
        assert_eq!(clipped(&tone(1.0)), None);
        assert_eq!(clipped(&cut(0.5, 0.8)), None);
        assert_eq!(clipped(&[]), None);
        let warning = clipped(&cut(1.0, 1.3)).expect("a warning");
        assert!(warning.contains("1.000"), "{warning}");
    }
}
