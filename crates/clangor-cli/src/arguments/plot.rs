//! The command `plot`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::values::{instant, positive};

#[derive(Args)]
pub(crate) struct Plot {
    #[command(subcommand)]
    pub(crate) picture: Picture,
}

#[derive(Subcommand)]
pub(crate) enum Picture {
    /// Mode shapes of a body
    Modes {
        /// The model, with a modal part
        model: PathBuf,
        /// The picture to write
        #[arg(short, long, value_name = "FILE.png|FILE.svg")]
        output: PathBuf,
        /// Number of the first mode to draw; up to twelve are drawn
        #[arg(long, value_name = "N", default_value_t = 1)]
        first: usize,
    },
    /// Spectrum of a sound, with the mode frequencies of a body
    Spectrum {
        /// A WAV file
        sound: PathBuf,
        /// The picture to write
        #[arg(short, long, value_name = "FILE.png|FILE.svg")]
        output: PathBuf,
        /// A model whose mode frequencies are drawn as lines
        #[arg(long, value_name = "MODEL")]
        modes: Option<PathBuf>,
        /// Highest frequency of the picture (default: half the sample rate, at most 20000)
        #[arg(long, value_name = "HZ", value_parser = positive)]
        max_frequency: Option<f64>,
        /// Channel of the sound, from 1
        #[arg(long, value_name = "N", default_value_t = 1)]
        channel: usize,
    },
    /// Spectrogram of a sound, with births and deaths of bodies
    Spectrogram {
        /// A WAV file
        sound: PathBuf,
        /// The picture to write
        #[arg(short, long, value_name = "FILE.png|FILE.svg")]
        output: PathBuf,
        /// The timeline of the sound
        #[arg(long, value_name = "RUN.timeline")]
        timeline: Option<PathBuf>,
        /// Highest frequency of the picture (default: half the sample rate, at most 20000)
        #[arg(long, value_name = "HZ", value_parser = positive)]
        max_frequency: Option<f64>,
        /// Start of the picture in seconds of the sound
        #[arg(long, value_name = "S", value_parser = instant)]
        from: Option<f64>,
        /// End of the picture in seconds of the sound
        #[arg(long, value_name = "S", value_parser = instant)]
        to: Option<f64>,
        /// Length of the window in seconds
        #[arg(long, value_name = "S", value_parser = positive, default_value_t = 0.02)]
        window: f64,
        /// Time in the timeline at which the sound begins, as in `render --from`
        #[arg(long, value_name = "S", value_parser = instant, default_value_t = 0.0)]
        start: f64,
        /// Channel of the sound, from 1
        #[arg(long, value_name = "N", default_value_t = 1)]
        channel: usize,
    },
    /// Number of pieces that each ellipsoid of a modal soundbank replaces
    BankUse {
        /// A report of `render --report`
        report: PathBuf,
        /// The picture to write
        #[arg(short, long, value_name = "FILE.png|FILE.svg")]
        output: PathBuf,
        /// The soundbank (default: the built-in one)
        #[arg(long, value_name = "BANK")]
        bank: Option<PathBuf>,
    },
    /// Radiation of a model: its directivity, and the pressure around the body after a sudden acceleration
    Field {
        /// The model
        model: PathBuf,
        /// The picture to write
        #[arg(short, long, value_name = "FILE.png|FILE.svg")]
        output: PathBuf,
        /// Rigid degree of freedom: acceleration along an axis, or angular acceleration about it
        #[arg(long = "dof", value_enum, default_value = "ty")]
        degree: Degree,
        /// Frequency of the directivity (default: half the model's highest)
        #[arg(long, value_name = "HZ", value_parser = positive)]
        frequency: Option<f64>,
    },
}

/// Degrees of freedom of a rigid body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Degree {
    /// Translation along x
    Tx,
    /// Translation along y
    Ty,
    /// Translation along z
    Tz,
    /// Rotation about x
    Rx,
    /// Rotation about y
    Ry,
    /// Rotation about z
    Rz,
}
