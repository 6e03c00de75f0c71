//! How sound models are baked: the same options for every command that needs models.

use clap::{Args, ValueEnum};

use clangor_pipeline::stages::sound_models::patience::PATIENCE;

use super::values::{accuracy, band, patience};

/// Options of every command that finds or bakes sound models.
#[derive(Args, Clone, Debug)]
pub(crate) struct ModelArguments {
    /// Errors of sound models
    #[arg(long, value_enum, default_value = "normal")]
    pub(crate) quality: Quality,
    /// Error of all parts, instead of those of --quality: of a field relative to the loudest motion of the
    /// body, and of the modes
    #[arg(long, value_name = "E", value_parser = accuracy)]
    pub(crate) accuracy: Option<f64>,
    /// Highest frequency to compute, 100 Hz to half the sample rate (default: as high as the scene and its
    /// sample rate allow; 20000 for a body without a scene)
    #[arg(long, value_name = "HZ", value_parser = band)]
    pub(crate) max_frequency: Option<f64>,
    /// Solver of the acceleration part
    #[arg(long, value_enum, default_value = "auto")]
    pub(crate) method: Solver,
    /// CPU time in seconds, estimated, that the exact models of a scene or a body may take; the costlier ones
    /// are drafts. Without effect on bake and strike --list, which compute
    /// all
    #[arg(long, value_name = "S", default_value_t = PATIENCE, value_parser = patience)]
    pub(crate) patience: f64,
}

/// Processor of the commands that do not play on an audio device.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct DeviceArgument {
    /// Processor for finite differences in time (FDTD)
    #[arg(long, value_enum, default_value = "cpu")]
    pub(crate) device: Device,
}

/// Errors of acceleration fields and of modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Quality {
    /// Seconds for each body: third octaves of clicks within about 3 dB in the median, about a hundred modes,
    /// the error of whose frequencies is printed. Models within 1 % that are in the cache are used
    Draft,
    /// Fields and modes within 1 %
    Normal,
    /// Fields within 0.2 %, modes within 0.5 %
    High,
}

/// Ways to compute a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Solver {
    /// The cheapest solver that suits the shape
    Auto,
    /// Boundary element method
    Bem,
    /// Finite differences in time
    Fdtd,
}

/// Where to compute.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Device {
    /// The CPU
    Cpu,
    /// The GPU, in a build with the feature gpu; WGPU_ADAPTER_NAME selects one of several
    Gpu,
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::arguments::{Arguments, Command, ExportFormat};

    /// The commands that find or bake models, as short as they can be.
    const COMMANDS: [&str; 5] = [
        "bake coin -o coin.safetensors",
        "render scene.toml",
        "play scene.toml",
        "strike coin --impulse 0,1,0 --point 0,0,0 --listener 0,1,0 -o coin.wav",
        "export web run.timeline",
    ];

    fn parse(line: &str) -> Result<(ModelArguments, Option<Device>), clap::Error> {
        let parsed = Arguments::try_parse_from(["clangor"].into_iter().chain(line.split_whitespace()))?;
        Ok(match parsed.command {
            Command::Bake(options) => (options.models, Some(options.device.device)),
            Command::Render(options) => (options.models, Some(options.device.device)),
            Command::Play(options) => (options.models, None),
            Command::Strike(options) => (options.models, Some(options.device.device)),
            Command::Export(options) => match options.format {
                ExportFormat::Web { models, device, .. } => (models, Some(device.device)),
                _ => panic!("{line}"),
            },
            _ => panic!("{line}"),
        })
    }

    #[test]
    fn property_commands_with_models_take_the_same_options_with_the_same_defaults() {
        for command in COMMANDS {
            let (models, device) = parse(command).unwrap();
            let ModelArguments { quality, accuracy, max_frequency, method, patience } = models;
            assert_eq!(patience, PATIENCE, "{command}");
            assert_eq!((quality, accuracy), (Quality::Normal, None), "{command}");
            assert_eq!((max_frequency, method), (None, Solver::Auto), "{command}");
            // That of `play` is the loudspeaker.
            assert_eq!(device.is_none(), command.starts_with("play"), "{command}");
            assert!(device.is_none_or(|device| device == Device::Cpu), "{command}");

            let given = "--quality draft --accuracy 0.02 --max-frequency 4000 --method bem --patience 5";
            let (models, _) = parse(&format!("{command} {given}")).unwrap();
            let ModelArguments { quality, accuracy, max_frequency, method, patience } = models;
            assert_eq!(patience, 5.0, "{command}");
            assert_eq!((quality, accuracy), (Quality::Draft, Some(0.02)), "{command}");
            assert_eq!((max_frequency, method), (Some(4000.0), Solver::Bem), "{command}");
        }
    }

    #[test]
    fn property_commands_with_models_refuse_the_same_values_in_the_same_words() {
        for wrong in [
            "--patience nan",
            "--accuracy 0",
            "--accuracy nan",
            "--accuracy 0.6",
            "--max-frequency 99",
            "--method magic",
        ] {
            let message = |command: &str| {
                let error = parse(&format!("{command} {wrong}")).unwrap_err().to_string();
                error.lines().next().unwrap_or_default().to_owned()
            };
            assert!(message(COMMANDS[0]).contains("invalid value"), "{}", message(COMMANDS[0]));
            for command in COMMANDS {
                assert_eq!(message(command), message(COMMANDS[0]), "{command}");
            }
        }
    }
}
