//! Commands that compute sound models: `bake`, `modes`, `bank`.

use std::ffi::OsString;
use std::path::PathBuf;

use clangor_bake::modal_analysis::ModalAnalysisOptions;
use clap::{Args, Subcommand, ValueEnum};

use super::models::{DeviceArgument, ModelArguments};
use super::values::{accuracy, band, finite, positive, wavenumber};

#[derive(Args)]
pub(crate) struct Bake {
    /// A shape (coin, die:0.016x0.002 …), a mesh file (FILE.glb#NAME for one of several bodies), or a
    /// scene, whose models are written to the cache
    pub(crate) input: OsString,
    /// The model file to write, for a shape or a mesh file
    #[arg(short, long, value_name = "MODEL.safetensors")]
    pub(crate) output: Option<PathBuf>,
    /// Material preset of the modal part, unless a glTF file gives the material; the acceleration part
    /// does not depend on it
    #[arg(long, value_name = "NAME")]
    pub(crate) material: Option<String>,
    /// Parts to compute (default: both; acceleration alone without a material)
    #[arg(long, value_enum, value_delimiter = ',', value_name = "PARTS")]
    pub(crate) parts: Vec<Part>,
    #[command(flatten)]
    pub(crate) models: ModelArguments,
    #[command(flatten)]
    pub(crate) device: DeviceArgument,
    /// Representation of the acceleration field; pan is for comparison
    #[arg(long, value_enum, default_value = "multipoles")]
    pub(crate) representation: Representation,
    /// Directions of the PAN representation
    #[arg(long, value_enum, default_value = "5x10")]
    pub(crate) grid: Grid,
    /// Omit the near field, which only listeners inside the bounding sphere need
    #[arg(long)]
    pub(crate) no_near_field: bool,
    /// Scale of a mesh file to metres
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = positive)]
    pub(crate) scale: f64,
}

/// Parts of a sound model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Part {
    /// Acceleration noise: the click of a body whose velocity changes
    Acceleration,
    /// The sound of its vibration modes
    Modal,
}

#[derive(Args)]
pub(crate) struct Modes {
    /// A shape (bowl, coin, box:0.3x0.03x0.01 …) or a mesh file
    pub(crate) body: OsString,
    /// Material preset
    #[arg(long, value_name = "NAME")]
    pub(crate) material: String,
    /// Highest frequency
    #[arg(long, value_name = "HZ", default_value_t = 20_000.0, value_parser = band)]
    pub(crate) max_frequency: f64,
    /// Relative error of a frequency due to the mesh
    #[arg(long, value_name = "E", default_value_t = 0.01, value_parser = accuracy)]
    pub(crate) accuracy: f64,
    /// Largest number of mesh nodes
    #[arg(long, value_name = "N", default_value_t = ModalAnalysisOptions::MOST_NODES)]
    pub(crate) max_nodes: usize,
    /// Scale of a mesh file to metres
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = positive)]
    pub(crate) scale: f64,
    /// Density instead of the material's, in kg/m³
    #[arg(long, value_name = "RHO", value_parser = finite)]
    pub(crate) density: Option<f64>,
    /// Young's modulus instead of the material's, in Pa
    #[arg(long, value_name = "E", value_parser = finite)]
    pub(crate) youngs_modulus: Option<f64>,
    /// Poisson's ratio instead of the material's
    #[arg(long, value_name = "NU", value_parser = finite, allow_hyphen_values = true)]
    pub(crate) poisson_ratio: Option<f64>,
    /// Folder to write the stiffness and mass matrices to: stiffness.mtx and mass.mtx, Matrix Market format;
    /// the whole body is solved then, without its mirror planes
    #[arg(long, value_name = "DIR")]
    pub(crate) export: Option<PathBuf>,
}

#[derive(Args)]
pub(crate) struct Compare {
    /// The recording of one impact (.wav)
    pub(crate) sound: PathBuf,
    /// A shape (bowl, box:0.3x0.03x0.01 …), a mesh file (FILE.glb#NAME for one of several bodies), or a sound
    /// model with modes (.safetensors)
    pub(crate) model: OsString,
    /// Material preset of a shape or a mesh file; its damping is listed beside that of the recording
    #[arg(long, value_name = "NAME")]
    pub(crate) material: Option<String>,
    /// Highest frequency of tones and modes
    #[arg(long, value_name = "HZ", default_value_t = 20_000.0, value_parser = band)]
    pub(crate) max_frequency: f64,
    /// Relative error of a frequency of the model due to its mesh
    #[arg(long, value_name = "E", default_value_t = 0.01, value_parser = accuracy)]
    pub(crate) accuracy: f64,
    /// Channel of a recording of several, from 1
    #[arg(long, value_name = "N")]
    pub(crate) channel: Option<u16>,
    /// Scale of a mesh file to metres
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = positive)]
    pub(crate) scale: f64,
    /// Density instead of the material's, in kg/m³
    #[arg(long, value_name = "RHO", value_parser = positive)]
    pub(crate) density: Option<f64>,
    /// Young's modulus instead of the material's, in Pa
    #[arg(long, value_name = "E", value_parser = positive)]
    pub(crate) youngs_modulus: Option<f64>,
    /// Poisson's ratio instead of the material's
    #[arg(long, value_name = "NU", value_parser = finite, allow_hyphen_values = true)]
    pub(crate) poisson_ratio: Option<f64>,
}

/// Representation of an acceleration field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Representation {
    /// Multipoles with common poles
    Multipoles,
    /// Signals along directions, as a series in 1/r (PAN, PROXY)
    Pan,
}

/// Directions of the PAN representation.
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
    /// Bake all ellipsoids of a soundbank
    Build {
        /// The soundbank file to write (default with --modal: the cache)
        #[arg(short, long, value_name = "BANK.safetensors")]
        output: Option<PathBuf>,
        /// Bake a modal soundbank: ellipsoids with their modes
        #[arg(long, requires = "material")]
        modal: bool,
        /// Material preset of the modal soundbank
        #[arg(long, value_name = "NAME", requires = "modal")]
        material: Option<String>,
        /// Error to reach, relative to the loudest motion of an ellipsoid [default: 0.001; 0.03 with --modal]
        #[arg(long, value_name = "E", value_parser = accuracy)]
        accuracy: Option<f64>,
        /// Highest wavenumber times the longest semi-axis
        #[arg(
            long,
            value_name = "KA",
            default_value_t = 20.0,
            value_parser = wavenumber,
            conflicts_with = "modal"
        )]
        max_wavenumber: f64,
    },
    /// Print what a soundbank contains
    Info {
        /// The soundbank
        file: PathBuf,
    },
}
