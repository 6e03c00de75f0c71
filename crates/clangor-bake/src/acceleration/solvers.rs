//! The solver of a body: the first that the [plan](super::plan) names and that does not fail.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;

use super::cavities::has_narrow_mouth;
use super::draft::prepare_draft;
use super::plan::{Candidate, FieldPlan, fine, large_cells, less_accurate, longest, mirrors, wave_options};
use super::prepared::Prepared;
use super::sampling::{CAVITY_SPACING, SOLID_SPACING, density};
use super::{BakeError, BakeOptions, BakeProgress, LEAST_SOLVES};
use crate::bem::axisymmetric::{AxisymmetricOptions, AxisymmetricSolver};
use crate::bem::symmetric_patches::SymmetricPatchSolver;
use crate::bem::triangles::{Equation, TriangleSolver};
use crate::cost::operations::{self, PER_SECOND};
use crate::effort::Effort;
use crate::fdtd::{WaveDevice, WaveSolver};
use crate::geometry_class::bake_geometry::{Axisymmetry, BakeGeometry};
use crate::geometry_class::solver_choice::BoundaryChoice;
use crate::mesh::remesh::resolution::Resolution;
use crate::mesh::remesh::{RemeshOptions, remesh, remesh_symmetric};

/// Picks and prepares a solver: the first of the [plan](FieldPlan) that does not fail.
pub(super) fn prepare(
    geometry: &BakeGeometry,
    options: &BakeOptions,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<Prepared, BakeError> {
    if options.effort == Effort::Draft {
        return prepare_draft(geometry, options);
    }
    let plan = FieldPlan::new(geometry, options)?;
    let options = BakeOptions { max_wavenumber: plan.max_wavenumber, ..*options };
    let mut failure = None;
    for (candidate, cost) in &plan.candidates {
        let (seconds, patience) = (cost.operations / PER_SECOND, options.patience);
        if seconds > patience {
            return Err(BakeError::TooLong { seconds, patience });
        }
        match solver_of(geometry, candidate, &plan, &options, progress) {
            Ok(mut prepared) => {
                let less = less_accurate(options.accuracy, candidate);
                prepared.warnings.splice(0..0, plan.warnings.iter().cloned().chain(less));
                if let Some(error) = failure {
                    prepared.warnings.push(format!("solved by {}, since {error}", prepared.method));
                }
                return Ok(prepared);
            }
            Err(error @ (BakeError::Interrupted | BakeError::TooLong { .. })) => return Err(error),
            Err(error) => failure = failure.or(Some(error)),
        }
    }
    Err(failure.unwrap_or(BakeError::NoBand {
        radius: geometry.bounding_radius(),
        wavenumber: options.max_wavenumber,
    }))
}

fn solver_of(
    geometry: &BakeGeometry,
    candidate: &Candidate,
    plan: &FieldPlan<'_>,
    options: &BakeOptions,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<Prepared, BakeError> {
    let k = options.max_wavenumber;
    match (candidate, geometry.boundary_choice(), plan.surface.as_deref()) {
        (Candidate::Patches, BoundaryChoice::Ellipsoid(semi_axes), _) => {
            Ok(symmetric_patches(SymmetricPatchSolver::ellipsoid(semi_axes, k, fine(options.accuracy))?, k))
        }
        (Candidate::Patches, BoundaryChoice::RoundedBox(edges, round), _) => {
            let solver = SymmetricPatchSolver::rounded_box(edges, round, k, fine(options.accuracy))?;
            Ok(symmetric_patches(solver, k))
        }
        (Candidate::Meridian, BoundaryChoice::Meridian(body), _) => Ok(meridian(&body, options)),
        (Candidate::Triangles(fineness), _, Some(mesh)) => {
            triangles(geometry, (mesh, fineness), plan.spacing, options, progress)
        }
        (Candidate::TimeDomain { spacing, wall }, _, Some(mesh)) => {
            let planes = match options.device {
                WaveDevice::Cpu => mirrors(geometry, [options.accuracy, *wall], k),
                WaveDevice::Gpu => Vec::new(),
            };
            time_stepping((mesh, &planes), [*spacing, *wall], plan.spacing, options, progress)
        }
        _ => Err(BakeError::NoBand { radius: geometry.bounding_radius(), wavenumber: k }),
    }
}

/// Edges of the surface-pressure mesh per shortest wavelength.
const NEAR_FIELD_EDGES: f64 = 5.0;

fn symmetric_patches(solver: SymmetricPatchSolver, highest: f64) -> Prepared {
    let unknowns = solver.unknowns();
    Prepared {
        solver: Box::new(solver),
        highest,
        spacing: SOLID_SPACING,
        method: "boundary elements on one octant",
        unknowns,
        warnings: Vec::new(),
        above: Vec::new(),
        most_solves: None,
    }
}

/// Most solves for each unit of κ of a body with cavities, and of the meridian of a vessel with a narrow
/// mouth: a sphere 110 mm wide with a mouth of 19 mm takes 7 for 1 %, and 11.7 as uneven triangles.
const SOLVES_OF_VESSEL: f64 = 12.0;

/// Most solves of such a body up to κ.
fn solves_of_vessel(kappa: f64) -> usize {
    ((SOLVES_OF_VESSEL * kappa) as usize).max(LEAST_SOLVES)
}

/// Boundary elements on the meridian.
fn meridian(Axisymmetry { meridian, axis }: &Axisymmetry<'_>, options: &BakeOptions) -> Prepared {
    let settings = AxisymmetricOptions::new(options.max_wavenumber);
    let mut solver = AxisymmetricSolver::new(meridian, *axis, settings);
    let unknowns = solver.unknowns();
    let kappa = options.max_wavenumber * meridian.bounding_radius();
    if options.near_field {
        solver = solver.with_surface(NEAR_FIELD_EDGES);
    }
    Prepared {
        solver: Box::new(solver),
        highest: options.max_wavenumber,
        spacing: SOLID_SPACING,
        method: "boundary elements on the meridian",
        unknowns,
        warnings: Vec::new(),
        above: Vec::new(),
        most_solves: has_narrow_mouth(meridian).then(|| solves_of_vessel(kappa)),
    }
}

/// Share of the error left to what the wavenumbers of a band share: ten times as much at the resonances of a
/// cavity.
const SWEEP_SHARE: f64 = 0.01;

/// Boundary elements on triangles.
fn triangles(
    geometry: &BakeGeometry,
    (mesh, fineness): (&TriMesh, &Resolution),
    spacing: f64,
    options: &BakeOptions,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<Prepared, BakeError> {
    if progress(&BakeProgress { done: 0.0, stage: "remeshing" }).is_break() {
        return Err(BakeError::Interrupted);
    }
    let planes = mirrors(geometry, [fineness.accuracy, fineness.wall], options.max_wavenumber);
    // A mesh that cannot be cut at its planes may work as a whole.
    let (solver, used) = match remesh_symmetric(mesh, &planes, &fineness.options) {
        Ok((symmetric, report)) if !planes.is_empty() => {
            let solver =
                TriangleSolver::try_symmetric(&symmetric, options.max_wavenumber, Equation::BurtonMiller)?;
            (solver, report.options)
        }
        _ => {
            let (remeshed, report) = remesh(mesh, &fineness.options)?;
            let solver = TriangleSolver::try_new(&remeshed, options.max_wavenumber, Equation::BurtonMiller)?;
            (solver, report.options)
        }
    };
    // The mesh may have more vertices than were planned.
    let unknowns = solver.unknowns();
    let kappa = options.max_wavenumber * geometry.bounding_radius();
    let density = density(spacing == CAVITY_SPACING);
    let seconds = operations::triangles(unknowns, solver.systems(), kappa, density) / PER_SECOND;
    if seconds > options.patience {
        return Err(BakeError::TooLong { seconds, patience: options.patience });
    }
    let solver = solver.for_many_wavenumbers(options.max_wavenumber, SWEEP_SHARE * options.accuracy);
    Ok(Prepared {
        solver: Box::new(solver),
        highest: options.max_wavenumber,
        spacing,
        method: "boundary elements on triangles",
        unknowns,
        warnings: thin_walls(mesh, fineness, &used),
        above: Vec::new(),
        most_solves: (spacing == CAVITY_SPACING).then(|| solves_of_vessel(kappa)),
    })
}

/// 2V/A in thicknesses above which a body has walls: 1 for a plate, ½ for a round bar. The motions of tori of
/// 428 to 1072 unknowns are within 1 % of themselves, although edges are half as long as their wire is thick.
const WALLS: f64 = 0.75;

/// Warnings about walls that the mesh resolves badly.
fn thin_walls(mesh: &TriMesh, fineness: &Resolution, used: &RemeshOptions) -> Vec<String> {
    let mean = MassProperties::of(mesh).map_or(f64::INFINITY, |mass| 2.0 * mass.volume / mesh.area());
    if 2.0 * used.min_edge <= fineness.wall || mean < WALLS * fineness.wall {
        return Vec::new();
    }
    let DVec3 { x, y, z } = fineness.thinnest;
    vec![format!(
        "walls of {:.2e} m, thinnest at ({x:.4}, {y:.4}, {z:.4}) m, have edges of {:.2e} m: thin motions \
         may be off by several per cent; ask for a finer accuracy",
        fineness.wall, used.min_edge
    )]
}

/// Finite differences in time on cells of a size, around walls of a thickness \[m\], of a body with mirror
/// planes of these normals.
fn time_stepping(
    (mesh, planes): (&TriMesh, &[DVec3]),
    [cell, wall]: [f64; 2],
    spacing: f64,
    options: &BakeOptions,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<Prepared, BakeError> {
    let highest = options.max_wavenumber * mesh.bounding_radius(DVec3::ZERO);
    let waves = wave_options(options, mesh.bounding_radius(DVec3::ZERO), cell, longest(spacing));
    let solver = WaveSolver::try_symmetric(mesh, planes, waves)?;
    let unknowns = solver.cells();
    // Time stepping.
    let field = watched(progress, |report| solver.run_on(options.device, report))?;
    Ok(Prepared {
        solver: Box::new(field),
        highest: options.max_wavenumber,
        spacing,
        method: match options.device {
            WaveDevice::Cpu => "finite differences in time",
            WaveDevice::Gpu => "finite differences in time on a graphics processor",
        },
        unknowns,
        warnings: large_cells(cell, wall).into_iter().collect(),
        above: Vec::new(),
        most_solves: (spacing == CAVITY_SPACING).then(|| solves_of_vessel(highest)),
    })
}

/// Runs work that reports from any thread, and forwards the reports from this thread.
pub(crate) fn watched<T: Send>(
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
    work: impl FnOnce(&(dyn Fn(f64) -> ControlFlow<()> + Sync)) -> T + Send,
) -> T {
    // Completed fraction of the work, in billionths.
    const WHOLE: f64 = 1e9;
    let (done, stop) = (AtomicU64::new(0), AtomicBool::new(false));
    let report = |part: f64| {
        done.fetch_max((part * WHOLE) as u64, Ordering::Relaxed);
        if stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    std::thread::scope(|scope| {
        let worker = scope.spawn(|| work(&report));
        while !worker.is_finished() {
            std::thread::park_timeout(POLL);
            let done = done.load(Ordering::Relaxed) as f64 / WHOLE;
            if progress(&BakeProgress { done, stage: "stepping the waves" }).is_break() {
                stop.store(true, Ordering::Relaxed);
            }
        }
        worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

/// Interval between two reports of progress.
const POLL: Duration = Duration::from_millis(50);
