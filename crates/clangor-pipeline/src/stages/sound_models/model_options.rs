//! How sound models are baked: errors, solver, band and processor.
//!
//! A scene that is rendered, a scene whose models are baked ahead, a single impact and a single body share
//! these options and their defaults. Equal options give equal keys, so each finds in the cache what another
//! has put there.

use std::ops::RangeInclusive;

use clangor_bake::acceleration::{BakeOptions, Method};
use clangor_bake::fdtd::WaveDevice;
use clangor_bake::modal::ModalBakeOptions;
use clangor_core::medium::Medium;

use super::acceleration_plan::AccelerationSettings;
use super::patience::PATIENCE;
use super::quality::Quality;

/// How sound models are baked. Default: [`Quality::Normal`], the solver that suits the body, the band of the
/// sound, on the CPU.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModelOptions {
    /// Errors of the parts, or drafts of what is not in the cache.
    pub quality: Quality,
    /// One error for all parts \[-\], in place of those of `quality`: of a field relative to the loudest
    /// motion of the body, of the frequencies of modes and of their transfers. In [`ACCURACIES`].
    pub accuracy: Option<f64>,
    /// Highest frequency of the models and of the sound that is made with them \[Hz\]. Default: as high as
    /// the scene and the sample rate allow; 20 kHz for a body without either.
    pub max_frequency: Option<f64>,
    /// Solver of the field of acceleration.
    pub method: Method,
    /// Processor of finite differences in time. Results do not depend on it.
    pub device: WaveDevice,
    /// CPU time \[s\], estimated, that the exact models of a scene may take together; the costlier ones are
    /// drafts. Default: [`PATIENCE`].
    pub patience: Option<f64>,
}

/// Errors that can be asked for \[-\].
pub const ACCURACIES: RangeInclusive<f64> = 1e-6..=0.5;
/// Least highest frequency, as in a scene \[Hz\].
pub const LOWEST_BAND_LIMIT: f64 = 100.0;
/// Half the highest sample rate \[Hz\].
pub const HIGHEST_BAND_LIMIT: f64 = 192_000.0;

/// Options that no model can be baked with.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ModelOptionsError {
    /// An error out of range.
    #[error("the accuracy {accuracy} is outside {least} to {most}")]
    Accuracy {
        /// Asked for \[-\].
        accuracy: f64,
        /// Least \[-\].
        least: f64,
        /// Greatest \[-\].
        most: f64,
    },
    /// A highest frequency out of range.
    #[error("the highest frequency {hz} Hz is outside {lowest} Hz to half the sample rate, {nyquist} Hz")]
    MaxFrequency {
        /// Asked for \[Hz\].
        hz: f64,
        /// Least \[Hz\].
        lowest: f64,
        /// Half the sample rate \[Hz\].
        nyquist: f64,
    },
}

impl ModelOptions {
    /// Rejects an accuracy out of range, and a highest frequency above half of the sample rate \[Hz\].
    ///
    /// # Errors
    /// [`ModelOptionsError`].
    pub fn check(&self, sample_rate: f64) -> Result<(), ModelOptionsError> {
        if let Some(accuracy) = self.accuracy.filter(|accuracy| !ACCURACIES.contains(accuracy)) {
            let (least, most) = (*ACCURACIES.start(), *ACCURACIES.end());
            return Err(ModelOptionsError::Accuracy { accuracy, least, most });
        }
        let (lowest, nyquist) = (LOWEST_BAND_LIMIT, 0.5 * sample_rate);
        match self.max_frequency.filter(|hz| !(lowest..=nyquist).contains(hz)) {
            Some(hz) => Err(ModelOptionsError::MaxFrequency { hz, lowest, nyquist }),
            None => Ok(()),
        }
    }

    /// How fields are chosen and baked up to a wavenumber k = 2πf/c [1/m].
    pub fn acceleration(&self, max_wavenumber: f64) -> AccelerationSettings {
        let accuracy = self.accuracy.unwrap_or(self.quality.field_error());
        let options = BakeOptions {
            method: self.method,
            device: self.device,
            near_field: true,
            ..BakeOptions::new(max_wavenumber, accuracy)
        };
        AccelerationSettings { options, patience: self.patience() }
    }

    /// CPU time \[s\], estimated, that the exact models of a scene may take: none where drafts are asked for.
    pub fn patience(&self) -> f64 {
        match self.quality {
            Quality::Draft => 0.0,
            _ => self.patience.unwrap_or(PATIENCE),
        }
    }

    /// How one field is baked that is asked for by itself.
    pub fn of_field(&self, exact: BakeOptions) -> BakeOptions {
        if self.quality == Quality::Draft { exact.draft() } else { exact }
    }

    /// How modes are baked that are asked for by themselves.
    pub fn of_modes(&self, exact: ModalBakeOptions) -> ModalBakeOptions {
        if self.quality == Quality::Draft { exact.draft() } else { exact }
    }

    /// How modes are baked that radiate into `medium`, up to the end of the band \[Hz\] or of what is heard.
    pub fn modal(&self, medium: Medium, band: f64) -> ModalBakeOptions {
        let audible = ModalBakeOptions::new(medium);
        ModalBakeOptions {
            max_frequency: audible.max_frequency.min(band),
            mesh_error: self.accuracy.unwrap_or(self.quality.mesh_error()),
            accuracy: self.accuracy.unwrap_or(self.quality.transfer_error()),
            ..audible
        }
    }
}
