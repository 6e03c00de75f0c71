//! Commands that compute or play sound: `render`, `play`, `strike`.

use std::ffi::OsString;
use std::path::PathBuf;

use clangor_core::glam::DVec3;
use clangor_pipeline::dataset::Shard;
use clap::{Args, ValueEnum};

use super::models::{DeviceArgument, ModelArguments};
use super::values::{
    body_model, contact_duration, duration, full_scale, instant, level, positive, shard, speed, striker,
    vector,
};

#[derive(Args)]
pub(crate) struct Render {
    /// A scene (.toml) or a timeline folder (.timeline)
    pub(crate) input: PathBuf,
    /// The WAV file to write; with several listeners one file NAME.LISTENER.wav each
    #[arg(short, long, value_name = "OUT.wav")]
    pub(crate) output: Option<PathBuf>,
    /// Position of a listener in metres, instead of the scene's listeners; repeat for several
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) listener: Vec<DVec3>,
    /// Also write the simulated timeline here
    #[arg(long, value_name = "RUN.timeline")]
    pub(crate) timeline: Option<PathBuf>,
    /// Also write the timeline with the forces of its impacts over time here, to render it without a solve; a
    /// scene needs --timeline
    #[arg(long, value_name = "RUN.timeline")]
    pub(crate) save_forces: Option<PathBuf>,
    /// Samples per second, 8000 to 384000
    #[arg(long, value_name = "HZ")]
    pub(crate) sample_rate: Option<u32>,
    #[command(flatten)]
    pub(crate) models: ModelArguments,
    #[command(flatten)]
    pub(crate) device: DeviceArgument,
    /// Acceleration model of all bodies, instead of the scene's
    #[arg(long = "acceleration", value_enum)]
    pub(crate) sound: Option<Sound>,
    /// Parts of the sound to render, instead of the scene's
    #[arg(long, value_enum, value_delimiter = ',', value_name = "PARTS")]
    pub(crate) parts: Vec<RenderedPart>,
    /// Transfer from mode amplitudes to pressure; frac and unit are for comparison
    #[arg(long, value_enum, default_value = "baked")]
    pub(crate) transfer: Transfer,
    /// A sound model (or a .glb with modes) for a body and its copies, instead of the scene's; repeat for
    /// several
    #[arg(long, value_name = "BODY=MODEL.safetensors", value_parser = body_model)]
    pub(crate) model: Vec<(String, PathBuf)>,
    /// Sample format
    #[arg(long, value_enum)]
    pub(crate) bits: Option<Bits>,
    /// Simulated time in seconds, instead of the scene's
    #[arg(long, value_name = "S", value_parser = duration)]
    pub(crate) duration: Option<f64>,
    /// Start of the written sound in seconds
    #[arg(long, value_name = "S", value_parser = instant)]
    pub(crate) from: Option<f64>,
    /// End of the written sound in seconds
    #[arg(long, value_name = "S", value_parser = instant)]
    pub(crate) to: Option<f64>,
    /// Pressure of a full-scale sample in pascals (default: 1 for float, 20 for 24-bit)
    #[arg(long, value_name = "PA", value_parser = full_scale, conflicts_with = "normalize")]
    pub(crate) full_scale: Option<f64>,
    /// Normalise the loudest sample to this level, instead of --full-scale
    #[arg(long, value_name = "DBFS", value_parser = level, allow_hyphen_values = true)]
    pub(crate) normalize: Option<f64>,
    /// Also write one WAV file for each body that sounds
    #[arg(long)]
    pub(crate) stems: bool,
    /// Print the sound energy of each body by part, and why silent bodies are silent
    #[arg(long)]
    pub(crate) explain: bool,
    /// Write a fracture report: energies, crack areas, and the modal models of the pieces
    #[arg(long, value_name = "FILE.json")]
    pub(crate) report: Option<PathBuf>,
    /// Replace an existing timeline
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Args)]
pub(crate) struct Play {
    /// A scene (.toml) or a timeline folder (.timeline)
    #[arg(required_unless_present = "devices")]
    pub(crate) input: Option<PathBuf>,
    /// Position of the listener in metres, instead of the scene's first listener
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) listener: Option<DVec3>,
    #[command(flatten)]
    pub(crate) models: ModelArguments,
    /// Simulated time in seconds, instead of the scene's
    #[arg(long, value_name = "S", value_parser = duration)]
    pub(crate) duration: Option<f64>,
    /// Start of playback in seconds of the scene
    #[arg(long, value_name = "S", value_parser = instant)]
    pub(crate) from: Option<f64>,
    /// End of playback in seconds of the scene
    #[arg(long, value_name = "S", value_parser = instant)]
    pub(crate) to: Option<f64>,
    /// Pressure of a full-scale output sample in pascals (default: twice the peak)
    #[arg(long, value_name = "PA", value_parser = full_scale)]
    pub(crate) full_scale: Option<f64>,
    /// Output device, by name or identifier (default: the system's)
    #[arg(long, value_name = "NAME")]
    pub(crate) device: Option<String>,
    /// List the output devices and exit
    #[arg(long)]
    pub(crate) devices: bool,
}

#[derive(Args)]
pub(crate) struct Strike {
    /// A shape (sphere:0.0075, coin, mug …), a mesh file (of a glTF file with several bodies: FILE.glb#NAME)
    /// or a sound model
    #[arg(required_unless_present = "list")]
    pub(crate) body: Option<OsString>,
    /// A data set instead of one impact: a recipe (.toml) or a table of strikes (.csv, .jsonl, .parquet); see
    /// docs/format/dataset.md
    #[arg(long, value_name = "FILE", conflicts_with_all = ONE_IMPACT)]
    pub(crate) list: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) dataset: DatasetArguments,
    /// Material preset; not needed for a glTF file that gives the material in KHR_audio_rigid_bodies
    #[arg(long, value_name = "NAME")]
    pub(crate) material: Option<String>,
    /// Impulse in N s (default: 0,-0.01,0, or 0.01 N s into the surface where the point is by a pole)
    #[arg(long, value_name = "JX,JY,JZ", value_parser = vector, allow_hyphen_values = true)]
    #[arg(conflicts_with = "striker")]
    pub(crate) impulse: Option<DVec3>,
    /// A ball that hits the body, instead of an impulse: material preset and radius in metres
    #[arg(long, value_name = "MATERIAL:RADIUS", value_parser = striker)]
    pub(crate) striker: Option<(String, f64)>,
    /// Speed of the striker along the normal, in m/s
    #[arg(long, value_name = "V", default_value_t = 1.0, value_parser = speed, requires = "striker")]
    pub(crate) speed: f64,
    /// Outward normal of the body at the point (default: that of its surface)
    #[arg(long, value_name = "X,Y,Z", value_parser = vector)]
    #[arg(allow_hyphen_values = true, requires = "striker")]
    pub(crate) normal: Option<DVec3>,
    /// Steps of the solve of the striker's contact per first duration of the contact, 2 to 256
    #[arg(long, value_name = "N", default_value_t = 16, requires = "striker")]
    #[arg(value_parser = clap::value_parser!(u32).range(2..=256))]
    pub(crate) contact_steps: u32,
    /// Point of impact on the surface in metres from the centre of mass (default: off the middle of the face
    /// that is highest, along y; of domes, bells and other bodies with a pole there, near their edge)
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) point: Option<DVec3>,
    /// Listener in metres from the centre of mass (default: 0.6,0.8,0)
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) listener: Option<DVec3>,
    /// The WAV or CSV file to write, or the folder of a data set
    #[arg(short, long, value_name = "OUT.wav|OUT.csv|FOLDER", required_unless_present = "bake_only")]
    pub(crate) output: Option<PathBuf>,
    /// Duration of the contact in seconds (default: Hertz against a rigid plane at 1 m/s)
    #[arg(long, value_name = "TAU", value_parser = contact_duration, conflicts_with = "striker")]
    pub(crate) duration: Option<f64>,
    /// Samples per second, 8000 to 384000
    #[arg(long, value_name = "HZ", default_value_t = 48_000)]
    pub(crate) sample_rate: u32,
    /// Length of the output in seconds (default: until the ringing has decayed by 60 dB, from 0.1 to 20)
    #[arg(long, value_name = "S", value_parser = duration)]
    pub(crate) seconds: Option<f64>,
    /// Acceleration model of the body
    #[arg(long = "acceleration", value_enum, default_value = "auto")]
    pub(crate) sound: Sound,
    /// Parts of the sound to compute
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        value_name = "PARTS",
        default_value = "acceleration,modal,striker"
    )]
    pub(crate) parts: Vec<StrikePart>,
    #[command(flatten)]
    pub(crate) models: ModelArguments,
    #[command(flatten)]
    pub(crate) device: DeviceArgument,
    /// Scale of a mesh file to metres
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = positive)]
    pub(crate) scale: f64,
}

/// Options of one impact, which a data set takes from its recipe.
const ONE_IMPACT: [&str; 14] = [
    "body",
    "material",
    "impulse",
    "striker",
    "speed",
    "normal",
    "contact_steps",
    "point",
    "listener",
    "duration",
    "sample_rate",
    "seconds",
    "sound",
    "parts",
];

/// Options of a data set.
#[derive(Args, Clone, Debug)]
pub(crate) struct DatasetArguments {
    /// Part of the data set to write, as in 3/16: 16 parts together are the whole, for the jobs of an array
    #[arg(long, value_name = "K/N", value_parser = shard, requires = "list")]
    pub(crate) shard: Option<Shard>,
    /// Number of files (default: one for each 1000 strikes)
    #[arg(long, value_name = "N", requires = "list", conflicts_with = "shard")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=99_999))]
    pub(crate) shards: Option<u32>,
    /// Where the samples go: a column of the Parquet files, or one WAV file for each strike
    #[arg(long, value_enum, default_value = "parquet", requires = "list")]
    pub(crate) files: DatasetFiles,
    /// Bake the sound models into the cache, or those of the part K/N of the bodies, and write nothing
    #[arg(long, requires = "list")]
    pub(crate) bake_only: bool,
}

/// Where the samples of a data set are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum DatasetFiles {
    /// In Parquet files
    Parquet,
    /// In WAV files
    Wav,
}

/// Parts of the sound of a strike.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum StrikePart {
    /// Acceleration noise of the body
    Acceleration,
    /// The sound of its vibration modes
    Modal,
    /// Acceleration noise of the striker, if there is one
    Striker,
}

/// Parts of the sound of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum RenderedPart {
    /// Acceleration noise: the clicks of bodies whose velocity changes; alone, with the forces of bodies that
    /// do not vibrate
    Acceleration,
    /// The sound of their vibration modes
    Modal,
    /// The sound of the ground that is hit
    Ground,
}

/// Acceleration models of bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Sound {
    /// Chosen by size and convexity
    Auto,
    /// A field baked for each form
    Own,
    /// An ellipsoid, interpolated between those of the soundbank
    Proxy,
    /// The nearest ellipsoid of the soundbank
    NearestProxy,
    /// The sphere of equal volume
    Sphere,
}

/// Transfer from mode amplitudes to pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Transfer {
    /// The baked field of each mode, driven by its acceleration
    Baked,
    /// As in FRAC: the magnitude of the field, driven by the amplitude
    Frac,
    /// The same for all modes and directions
    Unit,
}

/// Sample formats of a WAV file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Bits {
    /// 24-bit integers
    #[value(name = "24")]
    Integer24,
    /// 32-bit floating point
    #[value(name = "32f")]
    Float32,
}
