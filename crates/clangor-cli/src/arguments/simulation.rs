//! Commands that simulate: `check`, `simulate`.

use std::path::PathBuf;

use clap::Args;

use super::values::duration;

#[derive(Args)]
pub(crate) struct Check {
    /// The scene
    pub(crate) scene: PathBuf,
    /// Show what it will cost: bodies, triangles, pairs, steps, rows, and the CPU time of its models
    #[arg(long)]
    pub(crate) cost: bool,
}

#[derive(Args)]
pub(crate) struct Simulate {
    /// The scene
    pub(crate) scene: PathBuf,
    /// The timeline folder to write (default: the scene's name with .timeline)
    #[arg(short, long, value_name = "RUN.timeline")]
    pub(crate) output: Option<PathBuf>,
    /// Write every contact impulse of the solver, not only impacts faster than v_min
    #[arg(long)]
    pub(crate) raw_log: bool,
    /// Simulated time in seconds, instead of the scene's
    #[arg(long, value_name = "S", value_parser = duration)]
    pub(crate) duration: Option<f64>,
    /// Write a fracture report: energies and crack areas
    #[arg(long, value_name = "FILE.json")]
    pub(crate) report: Option<PathBuf>,
    /// Replace an existing timeline
    #[arg(long)]
    pub(crate) force: bool,
}
