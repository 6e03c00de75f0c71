//! Dynamics: a [`World`] goes in, every contact impulse and the poses come out, as a timeline.
//!
//! Two solvers share one log ([`record`]):
//! * [`spheres`]: exact event-driven motion of spheres, planes, springs and hung spheres;
//! * [`rigid`]: time-stepped impulses for bodies of any shape (feature `rigid`).
//!
//! [`live`] moves worlds of spheres as long as one likes and lets them be changed on the way. [`decompose`]
//! (feature `rigid`) finds the convex parts of a mesh from a file; [`fracture`] (feature `fracture`) breaks a
//! body into pieces.

#[cfg(feature = "rigid")]
pub mod decompose;
#[cfg(feature = "fracture")]
pub mod fracture;
pub mod live;
pub mod record;
#[cfg(feature = "rigid")]
pub mod rigid;
pub mod spheres;

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use clangor_core::body::{Body, Link, Motion, Surface, World};
use clangor_core::glam::DVec3;
pub use clangor_core::scene::simulation_settings::SolverChoice as Solver;
use clangor_core::timeline::TimelineSink;

use record::{RecordSettings, Recorder};

/// How to simulate.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulationSettings {
    /// Which solver.
    pub solver: Solver,
    /// Simulated time \[s\].
    pub duration: f64,
    /// Step of the time-stepped solver \[s\]. The sphere solver uses it only to sample lasting contacts for
    /// the log.
    pub time_step: f64,
    /// What is logged.
    pub record: RecordSettings,
    /// Whether bodies at rest may sleep (time-stepped solver).
    pub sleep: bool,
}

/// What a simulation did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SimulationReport {
    /// Impacts that were kept.
    pub impacts: u64,
    /// Impacts dropped because they were slower than `v_min`.
    pub dropped_impacts: u64,
    /// The same for each body, as far as one of them was dropped.
    pub dropped_by_body: Vec<u64>,
    /// Contact rows written.
    pub rows: u64,
    /// Bodies that broke.
    pub fractures: u64,
    /// Pieces that were born.
    pub births: u64,
    /// What became of the impacts on bodies that may break.
    pub breaking: BreakingReport,
    /// Events of the sphere solver: impacts, cells left, phases ended, searches renewed; 0 where time is
    /// stepped.
    pub events: u64,
    /// Largest overlap seen \[m\].
    pub deepest_overlap: f64,
    /// Time simulated \[s\].
    pub time: f64,
}

/// What became of the impacts on bodies that may break.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BreakingReport {
    /// Impacts too weak for any stress to reach the strength.
    pub screened: u64,
    /// Impacts for which stress was computed.
    pub solved: u64,
    /// Impacts beyond the strength that paid for no crack.
    pub withstood: u64,
    /// Impacts beyond the strength that found as many pieces as are allowed.
    pub capped: u64,
    /// Bodies that should have broken and could not, and why; each once.
    pub refused: BTreeMap<String, String>,
}

/// Why a simulation failed.
#[derive(Debug, thiserror::Error)]
pub enum SimulationError {
    /// The log could not be written.
    #[error("the timeline cannot be written: {0}")]
    Sink(#[from] std::io::Error),
    /// The sphere solver met a body that it cannot move.
    #[error(
        "solver = \"spheres\" cannot move body \"{body}\": {reason}; use solver = \"rigid\", which moves all bodies but \
         has no hung spheres"
    )]
    NotASphere {
        /// The body.
        body: String,
        /// What it is.
        reason: &'static str,
    },
    /// The time-stepped solver met something that it has not.
    #[error(
        "solver = \"rigid\" has no {what} (\"{name}\"); solver = \"spheres\" has, if all other bodies are spheres and \
         planes too"
    )]
    Unsupported {
        /// The feature.
        what: &'static str,
        /// The body or link.
        name: String,
    },
    /// A body cannot be simulated.
    #[error("body \"{body}\" {reason}")]
    BadBody {
        /// The body.
        body: String,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// A number of the settings makes no sense.
    #[error("{setting} = {value:e} is not possible")]
    BadSetting {
        /// Which number.
        setting: &'static str,
        /// Its value.
        value: f64,
    },
    /// Two bodies overlap at the start.
    #[error("\"{a}\" and \"{b}\" overlap by {depth:.3e} m at t = 0; move them apart")]
    StartOverlap {
        /// First body.
        a: String,
        /// Second body.
        b: String,
        /// Overlap \[m\].
        depth: f64,
    },
    /// A body cannot be replaced by pieces.
    #[error("\"{body}\" breaks at t = {time:.6} s, but it {reason}")]
    CannotBreak {
        /// The body.
        body: String,
        /// Why not.
        reason: &'static str,
        /// When \[s\].
        time: f64,
    },
    /// A body that may break cannot.
    #[cfg(feature = "fracture")]
    #[error("\"{body}\" cannot break: {source}")]
    Fracture {
        /// The body.
        body: String,
        /// Why.
        source: fracture::FractureError,
    },
    /// The state is no longer finite.
    #[error("the motion of \"{body}\" diverged at t = {time:.6} s")]
    Diverged {
        /// The body.
        body: String,
        /// When \[s\].
        time: f64,
    },
    /// Stopped by the caller.
    #[error("interrupted")]
    Interrupted,
}

/// More inelastic balls than this that fall freely may pile up, which the sphere solver can follow but
/// slowly.
const FEW_FALLING: usize = 8;

/// The solver that `Auto` stands for in a world: `Spheres` where all bodies are spheres and planes that
/// forces alone move, unless so many inelastic balls fall that they may come to lie on each other; else
/// `Rigid`.
pub fn choose_solver(world: &World, solver: Solver) -> Solver {
    let suits_spheres = |b: &Body| {
        let prescribed = matches!(&b.motion, Motion::Keyframed(track) if !track.is_fixed());
        !matches!(*b.surface, Surface::Mesh(_)) && !prescribed
    };
    match solver {
        Solver::Auto if world.links.iter().any(|l| matches!(l, Link::Hang { .. })) => Solver::Spheres,
        Solver::Auto if world.bodies.iter().all(suits_spheres) && falling(world) <= FEW_FALLING => {
            Solver::Spheres
        }
        Solver::Auto => Solver::Rigid,
        chosen => chosen,
    }
}

/// Free inelastic balls that start above every plane, under gravity.
fn falling(world: &World) -> usize {
    let planes: Vec<&Body> =
        world.bodies.iter().filter(|b| matches!(*b.surface, Surface::HalfSpace)).collect();
    let falls = |b: &&Body| {
        let Surface::Sphere { radius } = *b.surface else { return false };
        let height = |plane: &&Body| plane.pose.body_from_world(b.pose.position).y - radius;
        let in_the_air = planes.iter().all(|plane| height(plane) > 0.1 * radius);
        b.motion == Motion::Free && b.material.restitution < 1.0 && in_the_air
    };
    if world.gravity == DVec3::ZERO { 0 } else { world.bodies.iter().filter(falls).count() }
}

/// Simulates a world and streams what happens into `sink`.
///
/// `progress` is told the simulated time \[s\] now and then; `Break` stops the run.
///
/// # Errors
/// [`SimulationError`]; the sink has all rows until then.
pub fn simulate(
    world: &World,
    settings: &SimulationSettings,
    sink: &mut dyn TimelineSink,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<SimulationReport, SimulationError> {
    let mut recorder = Recorder::new(settings.record, sink);
    let outcome = match choose_solver(world, settings.solver) {
        Solver::Spheres => spheres::simulate(world, settings, &mut recorder, progress),
        #[cfg(feature = "rigid")]
        _ => rigid::run(world, settings, &mut recorder, &mut |_, _| Ok(Vec::new()), progress),
        #[cfg(not(feature = "rigid"))]
        _ => {
            let mesh = world.bodies.iter().find(|b| matches!(*b.surface, Surface::Mesh(_)));
            let name = mesh.map_or_else(|| "world".into(), |b| b.name.clone());
            Err(SimulationError::Unsupported { what: "time-stepped solver in this build", name })
        }
    };
    ended(recorder, outcome, settings.duration)
}

/// Closes the impacts that are open, also those of a run that failed.
fn ended(
    recorder: Recorder<'_>,
    outcome: Result<(), SimulationError>,
    duration: f64,
) -> Result<SimulationReport, SimulationError> {
    let report = recorder.finish(duration);
    outcome?;
    Ok(report?)
}

/// Simulates a world whose bodies may break, in steps of time whatever the settings choose: `breaker` looks
/// at each step, and the bodies that it names are replaced by its pieces at the end of that step.
///
/// # Errors
/// [`SimulationError`], also those of `breaker`; the sink has all rows until then.
#[cfg(feature = "rigid")]
pub fn simulate_breaking(
    world: &World,
    settings: &SimulationSettings,
    sink: &mut dyn TimelineSink,
    breaker: rigid::Breaker<'_>,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<SimulationReport, SimulationError> {
    let mut recorder = Recorder::new(settings.record, sink);
    let outcome = rigid::run(world, settings, &mut recorder, breaker, progress);
    ended(recorder, outcome, settings.duration)
}
