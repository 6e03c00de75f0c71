//! What a timeline is about: bodies, medium, and how its rows came about.

use clangor_core::body::{BodyId, World};
use clangor_core::medium::Medium;
use clangor_sim::record::MERGE_WINDOW;
use clangor_sim::{SimulationSettings, Solver};

/// Version of the format that is written.
pub const FORMAT_VERSION: u32 = 2;
/// Oldest version that is read; it differs in the names of columns.
pub(super) const OLDEST_VERSION: u32 = 1;

/// What a timeline is about: everything but its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct TimelineHeader {
    /// The bodies that are there from the beginning, links and gravity. When read, meshes have no convex
    /// parts, and bodies that broke know when.
    pub world: World,
    /// The fluid around them.
    pub medium: Medium,
    /// How the rows came about.
    pub origin: Origin,
    /// Text of the scene that was simulated, if there was one: its listeners and render settings are defaults
    /// for rendering the timeline.
    pub scene: Option<String>,
}

/// How the rows of a timeline came about.
#[derive(Clone, Debug, PartialEq)]
pub struct Origin {
    /// `spheres` or `rigid`; an importer names its source.
    pub solver: String,
    /// Step of the solver \[s\]; 0 for one without steps.
    pub time_step: f64,
    /// Simulated time \[s\].
    pub duration: f64,
    /// Impacts slower than this relative normal speed were dropped [m/s].
    pub v_min: f64,
    /// Poses per second and body \[Hz\].
    pub pose_rate: f64,
    /// Whether every contact row was kept, not only those of impacts.
    pub raw_log: bool,
    /// Whether bodies at rest could sleep.
    pub sleep: bool,
    /// Seed of everything random in the scene.
    pub seed: u64,
    /// Bodies that gave way in impacts, and the hashes of their modal models.
    pub impact_modes: Vec<(BodyId, String)>,
}

impl Origin {
    /// The origin of a simulation; `solver` is the one that was chosen.
    pub fn of_simulation(settings: &SimulationSettings, solver: Solver, seed: u64) -> Self {
        let name = match solver {
            Solver::Auto => "auto",
            Solver::Spheres => "spheres",
            Solver::Rigid => "rigid",
        };
        Origin {
            solver: name.into(),
            time_step: settings.time_step,
            duration: settings.duration,
            v_min: settings.record.v_min,
            pose_rate: settings.record.pose_rate,
            raw_log: settings.record.raw,
            sleep: settings.sleep,
            seed,
            impact_modes: Vec::new(),
        }
    }

    /// How far a row's time may lie before that of an earlier row \[s\]: an impact is written when it is
    /// over.
    pub(super) fn order_slack(&self) -> f64 {
        // The end of the window is noticed one step late; the rest is rounding.
        (MERGE_WINDOW + self.time_step) * (1.0 + 1e-9)
    }
}
