//! How the command line asks to bake sound models.

use clangor_bake::acceleration::Method;
use clangor_bake::fdtd::WaveDevice;
use clangor_pipeline::stages::sound_models::{ModelOptions, Quality};

use crate::arguments::{self, Device, ModelArguments, Solver};

impl ModelArguments {
    /// The options of the library, with the processor of finite differences in time.
    pub(super) fn on(&self, device: Device) -> ModelOptions {
        let ModelArguments { quality, accuracy, max_frequency, method, patience } = self.clone();
        ModelOptions {
            quality: match quality {
                arguments::Quality::Draft => Quality::Draft,
                arguments::Quality::Normal => Quality::Normal,
                arguments::Quality::High => Quality::High,
            },
            accuracy,
            max_frequency,
            method: match method {
                Solver::Auto => Method::Auto,
                Solver::Bem => Method::Bem,
                Solver::Fdtd => Method::Fdtd,
            },
            device: match device {
                Device::Cpu => WaveDevice::Cpu,
                Device::Gpu => WaveDevice::Gpu,
            },
            patience: Some(patience),
        }
    }
}
