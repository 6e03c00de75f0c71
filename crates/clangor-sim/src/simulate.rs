//! Runs of a whole simulation, streamed into a timeline.

use std::ops::ControlFlow;

#[cfg(not(feature = "rigid"))]
use clangor_core::body::Surface;
use clangor_core::body::World;
use clangor_core::contact::modal_energy::{ModesOf, no_modes};
use clangor_core::timeline::TimelineSink;

use crate::error::SimulationError;
use crate::record::Recorder;
use crate::report::SimulationReport;
use crate::settings::SimulationSettings;
use crate::solver_choice::{Solver, choose_solver};
#[cfg(not(feature = "rigid"))]
use crate::spheres;
#[cfg(feature = "rigid")]
use crate::{rigid, spheres};

/// Simulates a world of bodies without modes, and streams contacts and poses into `sink`.
///
/// `progress` is called at intervals with the simulated time \[s\]; `Break` stops the run.
///
/// # Errors
/// [`SimulationError`]; the sink has received all rows up to the failure.
pub fn simulate(
    world: &World,
    settings: &SimulationSettings,
    sink: &mut dyn TimelineSink,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<SimulationReport, SimulationError> {
    simulate_with_modes(world, (settings, &no_modes), sink, progress)
}

/// Simulates a world whose bodies have these modes. Impacts on them are solved with
/// [`ContactModel::Compliant`](crate::ContactModel::Compliant) in the time-stepped solver; see [`simulate`].
///
/// # Errors
/// As [`simulate`].
pub fn simulate_with_modes(
    world: &World,
    (settings, modes): (&SimulationSettings, ModesOf<'_>),
    sink: &mut dyn TimelineSink,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<SimulationReport, SimulationError> {
    let mut recorder = Recorder::new(settings.record, sink);
    let outcome = match choose_solver(world, settings.solver) {
        Solver::Spheres => spheres::simulate(world, settings, &mut recorder, progress),
        #[cfg(feature = "rigid")]
        _ => rigid::run(world, (settings, modes), &mut recorder, None, progress),
        #[cfg(not(feature = "rigid"))]
        _ => {
            let _ = modes;
            let mesh = world.bodies.iter().find(|b| matches!(*b.surface, Surface::Mesh(_)));
            let name = mesh.map_or_else(|| "world".into(), |b| b.name.clone());
            Err(SimulationError::Unsupported { what: "time-stepped solver in this build", name })
        }
    };
    ended(recorder, outcome, settings.duration)
}

/// Closes the open impacts, also after a failed run, and returns the report.
fn ended(
    recorder: Recorder<'_>,
    outcome: Result<(), SimulationError>,
    duration: f64,
) -> Result<SimulationReport, SimulationError> {
    let report = recorder.finish(duration);
    outcome?;
    Ok(report?)
}

/// Simulates a world whose bodies have these modes and may break, always with the time-stepped solver.
/// `breaker` inspects each step; the bodies that it returns are replaced by their pieces at the end of that
/// step.
///
/// # Errors
/// [`SimulationError`], including those of `breaker`; the sink has received all rows up to the failure.
#[cfg(feature = "rigid")]
pub fn simulate_breaking(
    world: &World,
    (settings, modes): (&SimulationSettings, ModesOf<'_>),
    sink: &mut dyn TimelineSink,
    breaker: rigid::Breaker<'_>,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<SimulationReport, SimulationError> {
    let mut recorder = Recorder::new(settings.record, sink);
    let outcome = rigid::run(world, (settings, modes), &mut recorder, Some(breaker), progress);
    ended(recorder, outcome, settings.duration)
}
