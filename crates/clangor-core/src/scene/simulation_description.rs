//! What a scene asks of the dynamics.

/// The `\[simulation\]` section.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulationDescription {
    /// Which solver.
    pub solver: SolverChoice,
    /// Simulated time \[s\].
    pub duration: f64,
    /// Step of the time-stepped solver \[s\].
    pub time_step: f64,
    /// Impacts slower than this relative normal speed are dropped \[m/s\]; \[PAN\] §4.3 uses 5 cm/s.
    pub v_min: f64,
    /// Poses per second and body in the timeline \[Hz\].
    pub pose_rate: f64,
    /// Seed of every random choice that has none of its own.
    pub seed: u64,
    /// Whether bodies at rest may sleep.
    pub sleep: bool,
}

impl Default for SimulationDescription {
    fn default() -> Self {
        SimulationDescription {
            solver: SolverChoice::Auto,
            duration: 2.0,
            time_step: 0.000_25,
            v_min: 0.05,
            pose_rate: 1000.0,
            seed: 0,
            sleep: true,
        }
    }
}

/// Which solver moves the bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SolverChoice {
    /// The solver that suits: see `clangor_sim::choose_solver`.
    #[default]
    Auto,
    /// Exact event-driven spheres.
    Spheres,
    /// Time-stepped impulses, any shape.
    Rigid,
}
