//! A world is set in motion; what happens goes to memory, to a timeline folder, or to both.

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clangor_core::body::{Body, BodyId, Link};
use clangor_core::glam::DVec3;
use clangor_core::scene::Scene;
use clangor_core::scene::diagnostic::Place;
use clangor_core::scene::simulation_description::SolverChoice;
use clangor_core::timeline::{ContactRow, FractureRow, PoseRow, Timeline, TimelineSink};
use clangor_sim::fracture::BreakingBodies;
use clangor_sim::record::RecordSettings;
use clangor_sim::rigid::{RigidWorld, StepLog};
use clangor_sim::{SimulationError, SimulationReport, SimulationSettings, choose_solver};

use crate::formats::timeline_file::{Origin, TimelineError, TimelineHeader, TimelineSummary, TimelineWriter};
use crate::stages::load::LoadedScene;
use crate::stages::resting_poses::RestingPoses;
use crate::stages::start_overlaps::refuse_heaps;

/// Why a simulation gave no timeline.
#[derive(Debug, thiserror::Error)]
pub enum SimulateError {
    /// The motion could not be computed.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The motion cannot begin, because of a body whose place in the scene is known.
    #[error("{}:{place}: {source}", path.display())]
    Start {
        /// The scene.
        path: PathBuf,
        /// Its text.
        text: String,
        /// Where the body is described.
        place: Box<Place>,
        /// Why.
        source: Box<SimulationError>,
    },
    /// The timeline could not be written.
    #[error(transparent)]
    Timeline(#[from] TimelineError),
    /// The motion ended before its time, and what there was of it has been kept.
    #[error("{source}; what happened until {time:.6} s is in {}", path.display())]
    Kept {
        /// Why it ended.
        source: SimulationError,
        /// The timeline so far.
        path: PathBuf,
        /// How long it is \[s\].
        time: f64,
    },
    /// The motion ended before its time, and what there was of it could not be kept.
    #[error("{source}; what happened until then cannot be kept: {lost}")]
    Lost {
        /// Why it ended.
        source: SimulationError,
        /// Why there is no timeline of it.
        lost: Box<TimelineError>,
    },
}

impl SimulateError {
    /// Whether the caller asked to stop.
    pub fn is_interruption(&self) -> bool {
        use SimulateError::{Kept, Lost, Simulation, Start, Timeline};
        match self {
            Simulation(source) | Kept { source, .. } | Lost { source, .. } => {
                matches!(source, SimulationError::Interrupted)
            }
            Timeline(_) | Start { .. } => false,
        }
    }
}

/// What a scene asks of the dynamics, for the solver.
pub fn simulation_settings(scene: &Scene, raw_log: bool) -> SimulationSettings {
    let simulation = &scene.simulation;
    SimulationSettings {
        solver: simulation.solver,
        contact: simulation.contact,
        duration: simulation.duration,
        time_step: simulation.time_step,
        record: RecordSettings { v_min: simulation.v_min, pose_rate: simulation.pose_rate, raw: raw_log },
        sleep: simulation.sleep,
    }
}

/// Whether the solver takes the scene: it is set up, and stopped where it first asks.
///
/// # Errors
/// [`SimulateError`] for bodies, links and overlaps that it refuses.
pub fn check_motion(loaded: &LoadedScene) -> Result<(), SimulateError> {
    let settings = simulation_settings(&loaded.scene, false);
    let mut stop = |_: f64| ControlFlow::Break(());
    match run(loaded, &settings, &mut ImpactLog::default(), &mut stop) {
        Ok(_) => Ok(()),
        Err(error) if error.is_interruption() => Ok(()),
        Err(error) => Err(error),
    }
}

/// Simulates a scene for its sound: the impacts, and where their bodies were; of those that are `followed`,
/// also where they were between, and, if the scene wants rolling, what touched them gently.
///
/// # Errors
/// [`SimulateError`].
pub fn simulate_impacts(
    loaded: &LoadedScene,
    followed: &BTreeSet<BodyId>,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<(Timeline, SimulationReport), SimulateError> {
    let mut settings = simulation_settings(&loaded.scene, hears_rolling(loaded, followed));
    if followed.is_empty() {
        settings.record.pose_rate = 0.0;
    }
    let mut impacts = ImpactLog::of(followed);
    let report = run(loaded, &settings, &mut impacts, progress)?;
    Ok((impacts.timeline, report))
}

/// Simulates a scene; in time steps, whatever its solver, if a body of it may break.
fn run(
    loaded: &LoadedScene,
    settings: &SimulationSettings,
    sink: &mut dyn TimelineSink,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<SimulationReport, SimulateError> {
    let world = &loaded.world;
    refuse_heaps(world).map_err(|error| at_start(loaded, error))?;
    let modes = |body: BodyId, points: &[(DVec3, DVec3)]| loaded.modes.at(body, points);
    if loaded.breakables.is_empty() {
        let report = clangor_sim::simulate_with_modes(world, (settings, &modes), sink, progress);
        return report.map_err(|error| at_start(loaded, error));
    }
    let mut breaking = BreakingBodies::new(world, loaded.breakables.clone(), settings)?;
    let mut breaker = |rigid: &mut RigidWorld, log: &mut StepLog| breaking.look(rigid, log);
    let report = clangor_sim::simulate_breaking(world, (settings, &modes), sink, &mut breaker, progress)
        .map_err(|error| at_start(loaded, error))?;
    Ok(SimulationReport { breaking: breaking.report().clone(), ..report })
}

/// An error about a body at the start, with its place in the scene; other errors as they are.
fn at_start(loaded: &LoadedScene, error: SimulationError) -> SimulateError {
    let name = match &error {
        // The second body is the one that was written later.
        SimulationError::StartOverlap { b, time: 0.0, .. } => b,
        SimulationError::NotASphere { body, .. }
        | SimulationError::BadBody { body, .. }
        | SimulationError::OpenJoint { body, .. } => body,
        SimulationError::PushedTooFar(push) => &push.body,
        _ => return SimulateError::Simulation(error),
    };
    match loaded.scene.place_of(name) {
        Some(place) if place.line > 0 => SimulateError::Start {
            path: loaded.path.clone(),
            text: loaded.text.clone(),
            place: Box::new(place.clone()),
            source: Box::new(error),
        },
        _ => SimulateError::Simulation(error),
    }
}

/// The solver of a scene: one in which bodies may break is stepped in time.
pub fn solver(loaded: &LoadedScene) -> SolverChoice {
    match loaded.breakables.is_empty() {
        true => choose_solver(&loaded.world, loaded.scene.simulation.solver),
        false => SolverChoice::Rigid,
    }
}

/// Whether gentle forces are wanted, and there is somebody to hear them on.
fn hears_rolling(loaded: &LoadedScene, followed: &BTreeSet<BodyId>) -> bool {
    loaded.scene.render.rolling && solver(loaded) == SolverChoice::Rigid && !followed.is_empty()
}

/// Simulates a scene into a timeline folder; memory does not grow with the rows.
///
/// # Errors
/// [`SimulateError`]; there is no such folder then, but one of what happened until then, if anything did
/// ([`TimelineWriter::keep`]).
pub fn simulate_to_folder(
    loaded: &LoadedScene,
    raw_log: bool,
    path: &Path,
    replace: bool,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<(SimulationReport, TimelineSummary), SimulateError> {
    let settings = simulation_settings(&loaded.scene, raw_log);
    let mut folder = timeline_folder(loaded, &settings, path, replace)?;
    let mut reached = 0.0;
    let outcome = run(loaded, &settings, &mut folder, &mut watched(&mut reached, progress));
    match outcome {
        Ok(report) => Ok((report, folder.finish()?)),
        Err(error) => Err(kept(folder, error, reached)),
    }
}

/// A timeline folder; the rigid solver gives contacts of bodies on links an effective mass.
fn timeline_folder(
    loaded: &LoadedScene,
    settings: &SimulationSettings,
    path: &Path,
    replace: bool,
) -> Result<TimelineWriter, TimelineError> {
    let is_rigid = solver(loaded) == SolverChoice::Rigid;
    let linked = is_rigid && loaded.world.links.iter().any(|link| !matches!(link, Link::Load { .. }));
    TimelineWriter::create_for_contacts(path, &header(loaded, settings), replace, linked)
}

/// Progress that is also noted.
fn watched<'a>(
    reached: &'a mut f64,
    progress: &'a mut dyn FnMut(f64) -> ControlFlow<()>,
) -> impl FnMut(f64) -> ControlFlow<()> + 'a {
    move |time| {
        *reached = time;
        progress(time)
    }
}

/// Keeps what there is of a run that failed at a time \[s\].
fn kept(folder: TimelineWriter, error: SimulateError, reached: f64) -> SimulateError {
    let SimulateError::Simulation(source) = error else { return error };
    match folder.keep(reached) {
        Ok(Some((path, time))) => SimulateError::Kept { source, path, time },
        Ok(None) => SimulateError::Simulation(source),
        Err(lost) => SimulateError::Lost { source, lost: Box::new(lost) },
    }
}

/// Simulates a scene into a timeline folder, and keeps its impacts in memory for rendering, as
/// [`simulate_impacts`] does.
///
/// # Errors
/// As [`simulate_to_folder`].
pub fn simulate_and_keep(
    loaded: &LoadedScene,
    followed: &BTreeSet<BodyId>,
    path: &Path,
    replace: bool,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<(Timeline, SimulationReport), SimulateError> {
    let settings = simulation_settings(&loaded.scene, hears_rolling(loaded, followed));
    let folder = timeline_folder(loaded, &settings, path, replace)?;
    let mut both = Both { folder, impacts: ImpactLog::of(followed) };
    let mut reached = 0.0;
    let outcome = run(loaded, &settings, &mut both, &mut watched(&mut reached, progress));
    match outcome {
        Ok(report) => {
            both.folder.finish()?;
            Ok((both.impacts.timeline, report))
        }
        Err(error) => Err(kept(both.folder, error, reached)),
    }
}

/// What a timeline folder says of a simulated scene.
fn header(loaded: &LoadedScene, settings: &SimulationSettings) -> TimelineHeader {
    TimelineHeader {
        world: loaded.world.clone(),
        medium: loaded.scene.acoustics.medium,
        origin: Origin {
            impact_modes: loaded.modes.models(),
            ..Origin::of_simulation(settings, solver(loaded), loaded.scene.simulation.seed)
        },
        scene: Some(loaded.text.clone()),
    }
}

/// Keeps impacts and the poses at them, so that memory follows what is heard and not what moves; of bodies
/// that may ring, which are heard between impacts, all poses but those of rest.
#[derive(Default)]
struct ImpactLog {
    timeline: Timeline,
    followed: BTreeSet<BodyId>,
    resting: RestingPoses,
    /// Poses since the last impact; those of the next one are among them.
    recent: Vec<PoseRow>,
}

impl ImpactLog {
    fn of(followed: &BTreeSet<BodyId>) -> Self {
        ImpactLog { followed: followed.clone(), ..ImpactLog::default() }
    }
}

impl TimelineSink for ImpactLog {
    fn contact(&mut self, row: &ContactRow) -> std::io::Result<()> {
        if row.impact_id != 0 {
            let takes_part = |p: &PoseRow| p.time <= row.time && [row.body_a, row.body_b].contains(&p.body);
            // The recorder gives an impact's poses right before its rows.
            let poses: Vec<PoseRow> = latest_of_each(self.recent.drain(..).filter(takes_part));
            self.timeline.poses.extend(poses);
            // A body that was hit at rest.
            let hit = [row.body_a, row.body_b].into_iter();
            self.timeline.poses.extend(hit.filter_map(|body| self.resting.needed(body)));
        }
        let gentle =
            row.impact_id == 0 && [row.body_a, row.body_b].iter().any(|id| self.followed.contains(id));
        if row.impact_id != 0 || gentle {
            self.timeline.contacts.push(*row);
        }
        Ok(())
    }

    fn pose(&mut self, row: &PoseRow) -> std::io::Result<()> {
        if self.followed.contains(&row.body) {
            self.timeline.poses.extend(self.resting.kept(row));
            return Ok(());
        }
        // Poses at the pose rate that no impact follows are of no use.
        if self.recent.len() >= RECENT_POSES {
            self.recent.drain(..RECENT_POSES / 2);
        }
        self.recent.push(*row);
        Ok(())
    }

    fn fracture(&mut self, row: &FractureRow, children: &[Body]) -> std::io::Result<()> {
        // Pieces of what may ring may ring.
        if self.followed.contains(&row.parent) {
            self.followed.extend(row.pieces());
        }
        self.timeline.fracture(row, children)
    }
}

/// Poses that wait for their impact: more than an impact has bodies.
const RECENT_POSES: usize = 64;

/// The last row of each body.
fn latest_of_each(rows: impl Iterator<Item = PoseRow>) -> Vec<PoseRow> {
    let mut latest: Vec<PoseRow> = Vec::new();
    for row in rows {
        match latest.iter_mut().find(|r: &&mut PoseRow| r.body == row.body) {
            Some(older) => *older = row,
            None => latest.push(row),
        }
    }
    latest
}

/// A timeline folder and the impacts in memory.
struct Both {
    folder: TimelineWriter,
    impacts: ImpactLog,
}

impl TimelineSink for Both {
    fn contact(&mut self, row: &ContactRow) -> std::io::Result<()> {
        self.folder.contact(row)?;
        self.impacts.contact(row)
    }

    fn pose(&mut self, row: &PoseRow) -> std::io::Result<()> {
        self.folder.pose(row)?;
        self.impacts.pose(row)
    }

    fn fracture(&mut self, row: &FractureRow, children: &[Body]) -> std::io::Result<()> {
        self.folder.fracture(row, children)?;
        self.impacts.fracture(row, children)
    }
}
