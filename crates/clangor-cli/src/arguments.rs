//! The command line.

mod values;

use std::path::{Path, PathBuf};

use clangor_core::glam::DVec3;
use clap::{Args, Parser, Subcommand, ValueEnum};

pub(crate) use self::values::{accuracy, band, finite, positive};
use self::values::{body_model, contact_duration, duration, full_scale, instant, level, vector, wavenumber};

/// Physically based sound of rigid bodies: a scene goes in, the pressure at a listener comes out, in pascals.
#[derive(Parser)]
#[command(name = "clangor", version, propagate_version = true)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(crate) global: Global,
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// Options of every command.
#[derive(Args)]
pub(crate) struct Global {
    /// Threads to use (default: one per core); the result does not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Print nothing but errors
    #[arg(long, global = true)]
    pub(crate) quiet: bool,
    /// Print the result as one JSON object
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Folder of baked sound models (default: CLANGOR_CACHE, or the system's folder for caches)
    #[arg(long, global = true, value_name = "DIR")]
    pub(crate) cache: Option<PathBuf>,
    /// Replace the scene's seed for random placement
    #[arg(long, global = true, value_name = "N")]
    pub(crate) seed: Option<u64>,
}

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Simulate a scene (or read a timeline) and write its sound as WAV
    Render(Render),
    /// Play a scene or a timeline through the loudspeaker, by the real-time engine
    Play(Play),
    /// Check a scene and print every error at once
    Check(Check),
    /// Simulate a scene and write what happened as a timeline
    Simulate(Simulate),
    /// Compute how a body sounds: one model, or what a scene needs
    Bake(Bake),
    /// Find how a free body vibrates: frequencies, how sure they are, damping
    Modes(crate::command::modes::Modes),
    /// One impact to one body, heard by one listener
    Strike(Strike),
    /// The banks of ellipsoids that stand for small bodies
    Bank(Bank),
    /// Turn what another tool or a person wrote into a timeline
    Import(Import),
    /// Turn a scene or a timeline into another tool's file
    Export(Export),
    /// Draw a picture of a sound model
    Plot(Plot),
    /// Say what is in a timeline, a sound model, a mesh, a scene or a WAV file
    Inspect(Inspect),
    /// Compare with closed forms and published numbers, and write the table
    Validate(Validate),
    /// Open the page on this machine: bodies to throw, drop, strike and hear as it happens
    Serve(Serve),
}

#[derive(Args)]
pub(crate) struct Render {
    /// A scene (.toml) or a timeline folder (.timeline)
    pub(crate) input: PathBuf,
    /// The WAV file to write; several listeners make NAME.LISTENER.wav each
    #[arg(short, long, value_name = "OUT.wav")]
    pub(crate) output: Option<PathBuf>,
    /// A listener instead of the scene's, in metres; repeat for several
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) listener: Vec<DVec3>,
    /// Keep the simulated timeline here
    #[arg(long, value_name = "RUN.timeline")]
    pub(crate) timeline: Option<PathBuf>,
    /// Samples per second, 8000 to 384000
    #[arg(long, value_name = "HZ")]
    pub(crate) sample_rate: Option<u32>,
    /// Highest frequency to compute, 100 Hz to half the sample rate
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub(crate) max_frequency: Option<f64>,
    /// Effort for the sound fields of bodies
    #[arg(long, value_enum, default_value = "normal")]
    pub(crate) quality: Quality,
    /// What bodies sound as, instead of what the scene says
    #[arg(long, value_enum)]
    pub(crate) sound: Option<Sound>,
    /// What of the sound to render, instead of what the scene says
    #[arg(long, value_enum, value_delimiter = ',', value_name = "PARTS")]
    pub(crate) parts: Vec<RenderedPart>,
    /// How modes become pressure: to compare by ear
    #[arg(long, value_enum, default_value = "baked")]
    pub(crate) transfer: Transfer,
    /// A baked model, of either representation, or modes (.glb), for a body and its copies, whatever the
    /// scene says; repeat for several
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
    /// Pressure that a sample of 1 means, in pascals (default 1 for float, 20 for 24-bit)
    #[arg(long, value_name = "PA", value_parser = full_scale, conflicts_with = "normalize")]
    pub(crate) full_scale: Option<f64>,
    /// Choose the full scale so that the loudest sample has this level
    #[arg(long, value_name = "DBFS", value_parser = level, allow_hyphen_values = true)]
    pub(crate) normalize: Option<f64>,
    /// Write one more WAV file per body that sounds
    #[arg(long)]
    pub(crate) stems: bool,
    /// Say for each body how much it sounds, by part, and why it is silent
    #[arg(long)]
    pub(crate) explain: bool,
    /// Write what broke, at what cost, and as which ellipsoids the pieces ring
    #[arg(long, value_name = "FILE.json")]
    pub(crate) report: Option<PathBuf>,
    /// Replace an existing timeline
    #[arg(long)]
    pub(crate) force: bool,
}

impl Render {
    /// What `render` is asked when only the input is named.
    pub(crate) fn of(input: &Path) -> Self {
        Render {
            input: input.into(),
            output: None,
            listener: Vec::new(),
            timeline: None,
            sample_rate: None,
            max_frequency: None,
            quality: Quality::Normal,
            sound: None,
            parts: Vec::new(),
            transfer: Transfer::Baked,
            model: Vec::new(),
            bits: None,
            duration: None,
            from: None,
            to: None,
            full_scale: None,
            normalize: None,
            stems: false,
            explain: false,
            report: None,
            force: false,
        }
    }
}

#[derive(Args)]
pub(crate) struct Play {
    /// A scene (.toml) or a timeline folder (.timeline)
    #[arg(required_unless_present = "devices")]
    pub(crate) input: Option<PathBuf>,
    /// A listener instead of the scene's first, in metres
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) listener: Option<DVec3>,
    /// Effort for the sound fields of bodies
    #[arg(long, value_enum, default_value = "normal")]
    pub(crate) quality: Quality,
    /// Simulated time in seconds, instead of the scene's
    #[arg(long, value_name = "S", value_parser = duration)]
    pub(crate) duration: Option<f64>,
    /// Where in the scene to begin, in seconds
    #[arg(long, value_name = "S", value_parser = instant)]
    pub(crate) from: Option<f64>,
    /// Where to end
    #[arg(long, value_name = "S", value_parser = instant)]
    pub(crate) to: Option<f64>,
    /// Pressure that is as loud as the device can, in pascals (default: twice the loudest)
    #[arg(long, value_name = "PA", value_parser = full_scale)]
    pub(crate) full_scale: Option<f64>,
    /// Device to play on, by its name or identifier (default: the system's)
    #[arg(long, value_name = "NAME")]
    pub(crate) device: Option<String>,
    /// List the devices instead
    #[arg(long)]
    pub(crate) devices: bool,
}

#[derive(Args)]
pub(crate) struct Check {
    /// The scene
    pub(crate) scene: PathBuf,
}

#[derive(Args)]
pub(crate) struct Simulate {
    /// The scene
    pub(crate) scene: PathBuf,
    /// The timeline folder to write (default: the scene's name with .timeline)
    #[arg(short, long, value_name = "RUN.timeline")]
    pub(crate) output: Option<PathBuf>,
    /// Write every impulse of the solver, not only impacts faster than v_min
    #[arg(long)]
    pub(crate) raw_log: bool,
    /// Simulated time in seconds, instead of the scene's
    #[arg(long, value_name = "S", value_parser = duration)]
    pub(crate) duration: Option<f64>,
    /// Write what broke, and at what cost
    #[arg(long, value_name = "FILE.json")]
    pub(crate) report: Option<PathBuf>,
    /// Replace an existing timeline
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Args)]
pub(crate) struct Bake {
    /// A shape (coin, die:0.016x0.002 …), a mesh file (FILE.glb#BODY: one of several), or a scene, whose
    /// models go to the cache
    pub(crate) input: String,
    /// The model to write, of a shape or a mesh file
    #[arg(short, long, value_name = "MODEL.safetensors")]
    pub(crate) output: Option<PathBuf>,
    /// Material preset, for ringing, unless a glTF file tells; the sound of acceleration is the same for all
    /// of them
    #[arg(long, value_name = "NAME")]
    pub(crate) material: Option<String>,
    /// What to compute (default: both, of a body without --material acceleration)
    #[arg(long, value_enum, value_delimiter = ',', value_name = "PARTS")]
    pub(crate) parts: Vec<Part>,
    /// Solver
    #[arg(long, value_enum, default_value = "auto")]
    pub(crate) method: Solver,
    /// Where finite differences in time run
    #[arg(long, value_enum, default_value = "cpu")]
    pub(crate) device: Device,
    /// Error to reach, over the loudest motion of the body
    #[arg(long, value_name = "E", default_value_t = 0.01, value_parser = accuracy)]
    pub(crate) accuracy: f64,
    /// Highest frequency to compute (default: 20000, or what the scene's sample rate needs)
    #[arg(long, value_name = "HZ", value_parser = band)]
    pub(crate) max_frequency: Option<f64>,
    /// How the field is stored: ours, or as the papers do, to be compared with
    #[arg(long, value_enum, default_value = "multipoles")]
    pub(crate) representation: Representation,
    /// Directions of the published representation
    #[arg(long, value_enum, default_value = "5x10")]
    pub(crate) grid: Grid,
    /// Leave out what only listeners inside the bounding sphere need
    #[arg(long)]
    pub(crate) no_near_field: bool,
    /// Scale of a mesh file to metres
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = positive)]
    pub(crate) scale: f64,
}

/// Parts of a sound model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Part {
    /// The click of a body whose velocity changes
    Acceleration,
    /// The ringing of its vibration
    Modal,
}

/// Parts of the sound of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum RenderedPart {
    /// The clicks of bodies whose velocity changes
    Acceleration,
    /// The ringing of their vibration
    Modal,
    /// The ground that is hit
    Ground,
}

/// Ways to compute a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Solver {
    /// The cheapest that is right for the shape
    Auto,
    /// Boundary elements
    Bem,
    /// Finite differences in time
    Fdtd,
}

/// Where to compute.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Device {
    /// This machine's processor
    Cpu,
    /// Its graphics processor, in a build with the feature gpu; WGPU_ADAPTER_NAME picks one of several
    Gpu,
}

/// How a field is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Representation {
    /// Multipoles with poles in common
    Multipoles,
    /// Signals along directions, as a series in 1/r
    #[value(alias = "published")]
    Pan,
}

/// Directions of the published representation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Grid {
    /// PAN: 5 polar by 10 azimuthal angles
    #[value(name = "5x10")]
    Coarse,
    /// PAN: 40 by 80; about 200 MB
    #[value(name = "40x80")]
    Fine,
    /// PROXY: one octant and wavelets above 1 %, for bodies with three planes of symmetry
    #[value(name = "octant")]
    Octant,
}

#[derive(Args)]
pub(crate) struct Bank {
    #[command(subcommand)]
    pub(crate) action: BankAction,
}

#[derive(Subcommand)]
pub(crate) enum BankAction {
    /// Bake the ellipsoids of the bank from nothing
    Build {
        /// The bank to write; with --modal into the cache unless it is given
        #[arg(short, long, value_name = "BANK.safetensors")]
        output: Option<PathBuf>,
        /// Build the bank of ringing ellipsoids instead
        #[arg(long, requires = "material")]
        modal: bool,
        /// Material preset of the ringing ellipsoids
        #[arg(long, value_name = "NAME", requires = "modal")]
        material: Option<String>,
        /// Error to reach, over the loudest motion of an ellipsoid [default: 0.001; 0.03 with --modal]
        #[arg(long, value_name = "E", value_parser = accuracy)]
        accuracy: Option<f64>,
        /// Highest wavenumber times the longest semi-axis
        #[arg(long, value_name = "KA", default_value_t = 20.0, value_parser = wavenumber, conflicts_with = "modal")]
        max_wavenumber: f64,
    },
    /// Say what is in a bank
    Info {
        /// The bank
        file: PathBuf,
    },
}

#[derive(Args)]
pub(crate) struct Plot {
    #[command(subcommand)]
    pub(crate) picture: Picture,
}

#[derive(Subcommand)]
pub(crate) enum Picture {
    /// How a body vibrates: the shapes of its modes
    Modes {
        /// The model, with a modal part
        model: PathBuf,
        /// The picture to write
        #[arg(short, long, value_name = "FILE.png|FILE.svg")]
        output: PathBuf,
        /// Number of the first mode to draw; twelve fit
        #[arg(long, value_name = "N", default_value_t = 1)]
        first: usize,
    },
    /// The spectrum of a sound, with the modes of a body beside it
    Spectrum {
        /// A WAV file
        sound: PathBuf,
        /// The picture to write
        #[arg(short, long, value_name = "FILE.png|FILE.svg")]
        output: PathBuf,
        /// A model whose modes are drawn as lines
        #[arg(long, value_name = "MODEL")]
        modes: Option<PathBuf>,
        /// Where the picture ends (default: half the sample rate, or 20000)
        #[arg(long, value_name = "HZ", value_parser = positive)]
        max_frequency: Option<f64>,
        /// Channel of the sound, from 1
        #[arg(long, value_name = "N", default_value_t = 1)]
        channel: usize,
    },
    /// How the spectrum of a sound changes, with births and deaths of bodies above it
    Spectrogram {
        /// A WAV file
        sound: PathBuf,
        /// The picture to write
        #[arg(short, long, value_name = "FILE.png|FILE.svg")]
        output: PathBuf,
        /// The timeline that the sound was made from
        #[arg(long, value_name = "RUN.timeline")]
        timeline: Option<PathBuf>,
        /// Where the picture ends (default: half the sample rate, or 20000)
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
    /// Which ellipsoids of the bank stand for how many pieces
    BankUse {
        /// What `render --report` wrote
        report: PathBuf,
        /// The picture to write
        #[arg(short, long, value_name = "FILE.png|FILE.svg")]
        output: PathBuf,
        /// The bank (default: the one that comes with the program)
        #[arg(long, value_name = "BANK")]
        bank: Option<PathBuf>,
    },
    /// How a model radiates: its directivity, and the pressure around the body after a sudden acceleration
    Field {
        /// The model
        model: PathBuf,
        /// The picture to write
        #[arg(short, long, value_name = "FILE.png|FILE.svg")]
        output: PathBuf,
        /// Motion: acceleration along an axis, or angular acceleration about it
        #[arg(long, value_enum, default_value = "ty")]
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

#[derive(Args)]
pub(crate) struct Strike {
    /// A shape (sphere:0.0075, coin, mug …), a mesh file (of a glTF file with several bodies: FILE.glb#BODY)
    /// or a sound model
    pub(crate) body: String,
    /// Material preset; a glTF file with KHR_audio_rigid_bodies may tell the material itself
    #[arg(long, value_name = "NAME")]
    pub(crate) material: Option<String>,
    /// Impulse in newton seconds
    #[arg(long, value_name = "JX,JY,JZ", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) impulse: DVec3,
    /// Struck point on the surface in metres from the centre of mass
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) point: DVec3,
    /// Listener in metres from the centre of mass
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) listener: DVec3,
    /// The WAV or CSV file to write
    #[arg(short, long, value_name = "OUT.wav|OUT.csv")]
    pub(crate) output: PathBuf,
    /// Duration of the contact in seconds (default: Hertz against a rigid plane at 1 m/s)
    #[arg(long, value_name = "TAU", value_parser = contact_duration)]
    pub(crate) duration: Option<f64>,
    /// Samples per second, 8000 to 384000
    #[arg(long, value_name = "HZ", default_value_t = 48_000)]
    pub(crate) sample_rate: u32,
    /// Length of the output in seconds (default: 0.1, or until what rings has fallen by 60 dB)
    #[arg(long, value_name = "S", value_parser = duration)]
    pub(crate) seconds: Option<f64>,
    /// What the body sounds as
    #[arg(long, value_enum, default_value = "auto")]
    pub(crate) sound: Sound,
    /// What of its sound to compute
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        value_name = "PARTS",
        default_value = "acceleration,modal"
    )]
    pub(crate) parts: Vec<Part>,
    /// Effort for its field
    #[arg(long, value_enum, default_value = "normal")]
    pub(crate) quality: Quality,
    /// Scale of a mesh file to metres
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = positive)]
    pub(crate) scale: f64,
}

#[derive(Args)]
pub(crate) struct Import {
    #[command(subcommand)]
    pub(crate) format: ImportFormat,
}

#[derive(Subcommand)]
pub(crate) enum ImportFormat {
    /// A hand-written list of contacts (.jsonl or .csv) between the bodies of a scene
    Contacts {
        /// The scene that names the bodies
        scene: PathBuf,
        /// The list
        list: PathBuf,
        /// The timeline folder to write
        #[arg(short, long, value_name = "RUN.timeline")]
        output: PathBuf,
        /// Replace an existing timeline
        #[arg(long)]
        force: bool,
    },
}

#[derive(Args)]
pub(crate) struct Export {
    #[command(subcommand)]
    pub(crate) format: ExportFormat,
}

#[derive(Subcommand)]
pub(crate) enum ExportFormat {
    /// The moving bodies as an animated binary glTF file
    Gltf {
        /// A scene (.toml) or a timeline folder (.timeline)
        input: PathBuf,
        /// The GLB file to write
        #[arg(short, long, value_name = "OUT.glb")]
        output: PathBuf,
        /// Animation keys per second
        #[arg(long, value_name = "HZ", default_value_t = 120.0, value_parser = positive)]
        rate: f64,
    },
    /// A finished run for the page: drop the file on it, and listen from anywhere
    Web {
        /// A timeline folder (.timeline)
        input: PathBuf,
        /// The file to write (default: the timeline's name with .replay)
        #[arg(short, long, value_name = "OUT.replay")]
        output: Option<PathBuf>,
        /// Effort for the sound fields of bodies
        #[arg(long, value_enum, default_value = "normal")]
        quality: Quality,
        /// Highest frequency to bake, 100 Hz to 24 kHz
        #[arg(long, value_name = "HZ", value_parser = positive)]
        max_frequency: Option<f64>,
    },
    /// A baked body with its modes, material and mass, as binary glTF with KHR_audio_rigid_bodies
    Modal {
        /// A model with a modal part (.safetensors)
        model: PathBuf,
        /// The GLB file to write
        #[arg(short, long, value_name = "OUT.glb")]
        output: PathBuf,
        /// Material preset whose damping gives the decays (default: what the model was baked of)
        #[arg(long, value_name = "NAME")]
        material: Option<String>,
    },
}

#[derive(Args)]
pub(crate) struct Inspect {
    /// A timeline folder, a WAV file, a sound model, a soundbank, a mesh, a shape or a scene
    pub(crate) file: String,
}

#[derive(Args)]
pub(crate) struct Validate {
    /// Only what takes less than a minute (the default)
    #[arg(long, conflicts_with = "full")]
    pub(crate) quick: bool,
    /// Everything
    #[arg(long)]
    pub(crate) full: bool,
    /// The Markdown table to write
    #[arg(short, long, value_name = "FILE.md")]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Args)]
pub(crate) struct Serve {
    /// Port on this machine; 0 picks a free one
    #[arg(long, value_name = "N", default_value_t = 8440)]
    pub(crate) port: u16,
}

/// Effort for the fields and the modes of bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Quality {
    /// Bake no fields: what is not in the cache clicks as an ellipsoid or a sphere; modes within 3 %
    Draft,
    /// Fields and modes within 1 %
    Normal,
    /// Fields within 0.2 %, modes within 0.5 %
    High,
}

/// What bodies sound as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Sound {
    /// By size and convexity
    Auto,
    /// Fields of their own
    Own,
    /// Ellipsoids, each the mean of those of the bank around it
    Proxy,
    /// The nearest ellipsoid of the bank
    NearestProxy,
    /// Spheres of equal volume
    Sphere,
}

/// How modes become pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Transfer {
    /// By the field of each, on its acceleration
    Baked,
    /// As FRAC does: by the magnitude of the field, on its amplitude
    #[value(alias = "published")]
    Frac,
    /// All alike, equally in all directions
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
