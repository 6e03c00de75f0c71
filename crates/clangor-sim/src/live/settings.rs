//! Settings of a live world.

use crate::solver_choice::Solver;

/// Solver and log of a live world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiveSettings {
    /// Which solver moves the world; `Auto` starts with the exact one where it is suitable and keeps it while
    /// it is fast enough.
    pub solver: Solver,
    /// Impacts slower than this are not returned \[m/s\].
    pub v_min: f64,
    /// Events per second of simulated time that the exact solver may need.
    pub exact_events: f64,
    /// Time step of the stepped solver \[s\].
    pub time_step: f64,
    /// Whether every impulse of the stepped solver is kept for
    /// [`LiveWorld::take_log`](super::LiveWorld::take_log).
    pub log: bool,
}

impl Default for LiveSettings {
    fn default() -> Self {
        LiveSettings {
            solver: Solver::Auto,
            v_min: 0.05,
            exact_events: 60_000.0,
            time_step: 1.0 / 512.0,
            log: false,
        }
    }
}
