//! The command line: one file for the options of each group of commands.

mod bake;
mod files;
pub(crate) mod former_names;
mod global;
mod models;
mod plot;
mod simulation;
mod sound;
mod values;

use clap::{Parser, Subcommand};

pub(crate) use self::bake::{Bake, Bank, BankAction, Compare, Grid, Modes, Part, Representation};
pub(crate) use self::files::{
    Export, ExportFormat, FileAxesArguments, Import, ImportFormat, Inspect, RecordedMotion, Serve, UpAxis,
    Validate,
};
pub(crate) use self::global::Global;
pub(crate) use self::models::{Device, ModelArguments, Quality, Solver};
pub(crate) use self::plot::{Degree, Picture, Plot};
pub(crate) use self::simulation::{Check, Simulate};
pub(crate) use self::sound::{
    Bits, DatasetFiles, Play, Render, RenderedPart, Sound, Strike, StrikePart, Transfer,
};

/// Physically based sound of rigid bodies: a scene goes in, the pressure at a listener comes out, in pascals.
#[derive(Parser)]
#[command(name = "clangor", version, propagate_version = true)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(crate) global: Global,
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Simulate a scene (or read a timeline) and write its sound as WAV
    Render(Render),
    /// Play a scene or a timeline on an audio device, with the real-time engine
    Play(Play),
    /// Check a scene and print all its errors
    Check(Check),
    /// Simulate a scene and write a timeline
    Simulate(Simulate),
    /// Compute sound models: of one body, or all that a scene needs
    Bake(Bake),
    /// Compute the modes of a free body: frequencies, their errors, damping
    Modes(Modes),
    /// Compare a recording with the modes of a body, and fit Young's modulus and damping
    Compare(Compare),
    /// Compute the sound of one impact on one body at one listener
    Strike(Strike),
    /// Build or inspect soundbanks: ellipsoids that replace small bodies
    Bank(Bank),
    /// Convert another program's file to a timeline
    Import(Import),
    /// Convert a scene, a timeline or a sound model to another program's file
    Export(Export),
    /// Plot a sound model, a sound or a fracture report
    Plot(Plot),
    /// Print what a timeline, a sound model, a mesh, a scene or a WAV file contains
    Inspect(Inspect),
    /// Compare with closed forms and published results, and write a table
    Validate(Validate),
    /// Serve the web page on this machine: throw, drop and strike bodies in real time
    Serve(Serve),
}
