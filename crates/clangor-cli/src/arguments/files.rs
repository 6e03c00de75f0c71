//! Commands about files: `import`, `export`, `inspect`, `validate`, and the page: `serve`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::models::{DeviceArgument, ModelArguments};
use super::values::{length_unit, positive, time_unit};

#[derive(Args)]
pub(crate) struct Import {
    #[command(subcommand)]
    pub(crate) format: ImportFormat,
}

#[derive(Subcommand)]
pub(crate) enum ImportFormat {
    /// An animated glTF file: its nodes are bodies of the scene by their names, or bodies of their own
    Gltf {
        /// The scene: planes, listeners, and bodies that it describes itself
        scene: PathBuf,
        /// Animated .glb or .gltf files
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
        /// Tables of poses of further bodies
        #[arg(long, value_name = "FILE")]
        poses: Vec<PathBuf>,
        /// Node that is left out with all nodes below it, such as set dressing (repeatable)
        #[arg(long, value_name = "NAME")]
        leave_out: Vec<String>,
        /// Animation that moves the nodes, where the files have several; by default all of them do
        #[arg(long, value_name = "NAME")]
        animation: Option<String>,
        #[command(flatten)]
        common: RecordedMotion,
    },
    /// Tables of poses (.csv, .jsonl or .parquet) of the bodies of a scene
    Poses {
        /// The scene that describes the bodies
        scene: PathBuf,
        /// Tables of poses
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
        #[command(flatten)]
        common: RecordedMotion,
    },
    /// A list of contacts (.jsonl, .csv or .parquet) between the bodies of a scene, which fly between them
    Contacts {
        /// The scene that names the bodies
        scene: PathBuf,
        /// The list
        list: PathBuf,
        /// The timeline folder to write
        #[arg(short, long, value_name = "RUN.timeline")]
        output: PathBuf,
        /// Leave all bodies where the scene starts them
        #[arg(long)]
        at_rest: bool,
        #[command(flatten)]
        axes: FileAxesArguments,
        /// Replace an existing timeline
        #[arg(long)]
        force: bool,
    },
}

/// What imports of motion have in common.
#[derive(Args)]
pub(crate) struct RecordedMotion {
    /// Contact lists of the same motion; without any, impacts are found in the motion
    #[arg(long, value_name = "LIST")]
    pub(crate) contacts: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) axes: FileAxesArguments,
    /// Write a row for each point of lasting contact in each frame, as with `rolling = true` in the scene
    #[arg(long)]
    pub(crate) raw_log: bool,
    /// The timeline folder to write
    #[arg(short, long, value_name = "RUN.timeline")]
    pub(crate) output: PathBuf,
    /// Replace an existing timeline
    #[arg(long)]
    pub(crate) force: bool,
}

/// Axes and units of files of other programs.
#[derive(Args)]
pub(crate) struct FileAxesArguments {
    /// Axis that points up in tables of poses and contact lists; glTF always has y
    #[arg(long, value_enum, default_value = "y")]
    pub(crate) up: UpAxis,
    /// Metres per unit of length in all files: 0.01 for centimetres, 0.001 for millimetres. Impulses and
    /// couples of contact lists stay in N s and N m s
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = length_unit)]
    pub(crate) scale: f64,
    /// Seconds per unit of time in all files: 0.001 for milliseconds, 1/24 for numbers of frames at 24 in a
    /// second. Speeds of contact lists stay per second
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = time_unit)]
    pub(crate) time_scale: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum UpAxis {
    Y,
    Z,
}

#[derive(Args)]
pub(crate) struct Export {
    #[command(subcommand)]
    pub(crate) format: ExportFormat,
}

#[derive(Subcommand)]
pub(crate) enum ExportFormat {
    /// Motion of the bodies as an animated binary glTF file
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
    /// A finished run for the web page, which plays it for a moving listener
    Web {
        /// A timeline folder (.timeline)
        input: PathBuf,
        /// The file to write (default: the timeline's name with .replay)
        #[arg(short, long, value_name = "OUT.replay")]
        output: Option<PathBuf>,
        #[command(flatten)]
        models: ModelArguments,
        #[command(flatten)]
        device: DeviceArgument,
    },
    /// A baked body with its modes, material and mass as binary glTF with KHR_audio_rigid_bodies
    Modal {
        /// A model with a modal part (.safetensors)
        model: PathBuf,
        /// The GLB file to write
        #[arg(short, long, value_name = "OUT.glb")]
        output: PathBuf,
        /// Material preset whose damping gives the decay times (default: the material of the model)
        #[arg(long, value_name = "NAME")]
        material: Option<String>,
    },
}

#[derive(Args)]
pub(crate) struct Inspect {
    /// A timeline folder, a WAV file, a sound model, a soundbank, a mesh, an animated glTF file, a shape or a
    /// scene
    pub(crate) file: PathBuf,
    /// Material preset of a mesh or a shape, for its mass and its modes
    #[arg(long, value_name = "NAME")]
    pub(crate) material: Option<String>,
    /// Scale of a mesh file to metres
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = positive)]
    pub(crate) scale: f64,
}

#[derive(Args)]
pub(crate) struct Validate {
    /// Run only the checks that take less than a minute (the default)
    #[arg(long, conflicts_with = "full")]
    pub(crate) quick: bool,
    /// Run all checks
    #[arg(long)]
    pub(crate) full: bool,
    /// The Markdown table to write
    #[arg(short, long, value_name = "FILE.md")]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Args)]
pub(crate) struct Serve {
    /// Port on this machine; 0 selects a free one
    #[arg(long, value_name = "N", default_value_t = 8440)]
    pub(crate) port: u16,
}
