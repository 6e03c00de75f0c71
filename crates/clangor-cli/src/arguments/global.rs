//! Options of every command.

use std::path::PathBuf;

use clap::Args;

/// Options of every command.
#[derive(Args)]
pub(crate) struct Global {
    /// Number of threads (default: one per core); results do not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Print errors only
    #[arg(long, global = true)]
    pub(crate) quiet: bool,
    /// Print the result as one JSON object
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Folder of baked sound models (default: CLANGOR_CACHE, or the system's cache folder)
    #[arg(long, global = true, value_name = "DIR")]
    pub(crate) cache: Option<PathBuf>,
    /// Seed of random placement and crack patterns, instead of the scene's
    #[arg(long, global = true, value_name = "N")]
    pub(crate) seed: Option<u64>,
}
