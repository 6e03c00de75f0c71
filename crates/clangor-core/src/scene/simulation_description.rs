//! Settings of a scene for the dynamics.

/// The `[simulation]` section. `docs/format/scene.md` describes its keys.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulationDescription {
    /// Solver of the motion. Default: automatic.
    pub solver: SolverChoice,
    /// How an impact becomes impulses. Default: compliant.
    pub contact: ContactModel,
    /// Simulated time \[s\], 0.001 to 3600. Default: 2.
    pub duration: f64,
    /// Step of the time-stepped solver \[s\], 1e-6 to 0.01. Default: 0.00025.
    pub time_step: f64,
    /// Least approach speed of an impact [m/s], 0 to 1000; slower impacts make no click. Default: 0.05, as in
    /// \[PAN\] §4.3.
    pub v_min: f64,
    /// Poses per second and body in the timeline \[Hz\], 1 to 1e5. Default: 1000.
    pub pose_rate: f64,
    /// Seed of all random choices without a seed in the scene, 0 to 2⁶³ − 1. Default: 0.
    pub seed: u64,
    /// Whether the solver may stop computing bodies at rest. Default: true.
    pub sleep: bool,
}

impl Default for SimulationDescription {
    fn default() -> Self {
        SimulationDescription {
            solver: SolverChoice::Auto,
            contact: ContactModel::Compliant,
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
    /// Chosen from the bodies of the scene by `clangor_sim::choose_solver`.
    #[default]
    Auto,
    /// Event-driven, exact for spheres.
    Spheres,
    /// Time-stepped with impulses, for any shape.
    Rigid,
}

/// How an impact becomes impulses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ContactModel {
    /// By a solve of the contact: the bodies give way and vibrate. The restitution of the materials is the
    /// loss of the contact alone.
    #[default]
    Compliant,
    /// By the law of rigid bodies: restitution and friction at an instant.
    Rigid,
}
