//! Choice of the solver for a shape, and of its resolution.
//!
//! - Ellipsoids and rounded boxes: curved patches on an octant.
//! - Axisymmetric bodies: the meridian alone.
//! - Other surfaces: Galerkin boundary elements on triangles, on a mesh fine enough for the accuracy. Finite
//!   differences in time where that needs too many unknowns.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use clangor_core::geometry::hull::extreme_hull;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::shape::{Form, Shape};
use glam::DVec3;

use super::{BakeError, BakeOptions, BakeProgress, Method, multipole_order};
use crate::bem::axisymmetric::{AxisymmetricOptions, AxisymmetricSolver};
use crate::bem::symmetric_patches::SymmetricPatchSolver;
use crate::bem::triangles::{Equation, MOST_UNKNOWNS, TriangleSolver};
use crate::fdtd::{Boundary, WaveDevice, WaveOptions, WaveSolver};
use crate::geometry_class::bake_geometry::{Axisymmetry, BakeGeometry};
use crate::geometry_class::solver_choice::{BoundaryChoice, rounded_box_hull};
use crate::mesh::remesh::resolution::{Resolution, resolution};
use crate::mesh::remesh::{RemeshOptions, remesh, remesh_symmetric};
use crate::radiation::{RadiationError, RadiationSolver};

/// Spacing in κ of the first solves for bodies without cavities.
const SOLID_SPACING: f64 = 0.8;
/// The same for bodies with cavities, whose resonances put poles near the real axis.
const CAVITY_SPACING: f64 = 0.45;
/// A body that fills less than this fraction of its hull has cavities, or is a bent plate.
const CONVEX: f64 = 0.7;
/// Most unknowns of triangles in a parity class; beyond, time stepping is cheaper.
const MOST_TRIANGLE_UNKNOWNS: usize = 4200;

/// A solver with its description.
pub(super) struct Prepared {
    /// The solver.
    pub(super) solver: Box<dyn RadiationSolver>,
    /// Spacing in κ of the first solves.
    pub(super) spacing: f64,
    /// Name of the method.
    pub(super) method: &'static str,
    /// Unknowns, or cells.
    pub(super) unknowns: usize,
    /// Warnings for the user.
    pub(super) warnings: Vec<String>,
}

/// Picks and prepares a solver.
pub(super) fn prepare(
    geometry: &BakeGeometry,
    options: &BakeOptions,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<Prepared, BakeError> {
    let BakeOptions { max_wavenumber, accuracy, .. } = *options;
    // The share of the error left to the discretisation.
    let fine = 0.3 * accuracy;
    if options.method == Method::Fdtd {
        let surface = surface_of(geometry, options)?;
        let fineness = resolution(&surface, options.max_wavenumber, options.accuracy)?;
        return time_stepping(&surface, fineness.wall, options, progress);
    }
    match geometry.boundary_choice() {
        BoundaryChoice::Ellipsoid(semi_axes) => {
            let solver = SymmetricPatchSolver::ellipsoid(semi_axes, max_wavenumber, fine)?;
            Ok(symmetric_patches(solver))
        }
        BoundaryChoice::RoundedBox(edges, round) => {
            let solver = SymmetricPatchSolver::rounded_box(edges, round, max_wavenumber, fine)?;
            Ok(symmetric_patches(solver))
        }
        BoundaryChoice::Meridian(Axisymmetry { meridian, axis }) => {
            let settings = AxisymmetricOptions::new(max_wavenumber);
            let mut solver = AxisymmetricSolver::new(&meridian, axis, settings);
            let unknowns = solver.unknowns();
            if options.near_field {
                solver = solver.with_surface(NEAR_FIELD_EDGES);
            }
            Ok(Prepared {
                solver: Box::new(solver),
                spacing: SOLID_SPACING,
                method: "boundary elements on the meridian",
                unknowns,
                warnings: Vec::new(),
            })
        }
        BoundaryChoice::Triangles(mesh) => triangles(geometry, mesh, options, progress),
    }
}

/// Edges of the surface-pressure mesh per shortest wavelength.
const NEAR_FIELD_EDGES: f64 = 5.0;

fn symmetric_patches(solver: SymmetricPatchSolver) -> Prepared {
    let unknowns = solver.unknowns();
    Prepared {
        solver: Box::new(solver),
        spacing: SOLID_SPACING,
        method: "boundary elements on one octant",
        unknowns,
        warnings: Vec::new(),
    }
}

/// Boundary elements on triangles, or time stepping above [`MOST_TRIANGLE_UNKNOWNS`].
fn triangles(
    geometry: &BakeGeometry,
    mesh: &TriMesh,
    options: &BakeOptions,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<Prepared, BakeError> {
    // Mesh resolution and mirror planes.
    let mass = MassProperties::of(mesh)?;
    let fineness = resolution(mesh, options.max_wavenumber, options.accuracy)?;
    let planes = geometry.mirror_normals(options.accuracy * fineness.wall);
    let unknowns = fineness.unknowns >> planes.len();
    if options.method == Method::Auto && unknowns > MOST_TRIANGLE_UNKNOWNS {
        return time_stepping(mesh, fineness.wall, options, progress);
    }
    // The estimate is good to a quarter; the solver counts exactly.
    if unknowns > MOST_UNKNOWNS + MOST_UNKNOWNS / 4 {
        let wavenumber = options.max_wavenumber;
        return Err(RadiationError::TooLarge { unknowns, most: MOST_UNKNOWNS, wavenumber }.into());
    }
    if progress(&BakeProgress { done: 0.0, stage: "remeshing" }).is_break() {
        return Err(BakeError::Interrupted);
    }
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
    let unknowns = solver.unknowns();
    Ok(Prepared {
        solver: Box::new(solver),
        spacing: if has_cavities(mesh, &mass) { CAVITY_SPACING } else { SOLID_SPACING },
        method: "boundary elements on triangles",
        unknowns,
        warnings: thin_walls(&fineness, &used),
    })
}

/// Directions that sample the hull: its volume to one or two per cent.
const HULL_DIRECTIONS: usize = 300;

/// Whether a body leaves a large part of its convex hull empty.
pub(crate) fn has_cavities(mesh: &TriMesh, mass: &MassProperties) -> bool {
    let hull = extreme_hull(mesh, HULL_DIRECTIONS).and_then(|hull| MassProperties::of(&hull));
    hull.is_ok_and(|hull| mass.volume < CONVEX * hull.volume)
}

/// Warnings about walls that the mesh resolves badly.
fn thin_walls(fineness: &Resolution, used: &RemeshOptions) -> Vec<String> {
    if 2.0 * used.min_edge <= fineness.wall {
        return Vec::new();
    }
    let DVec3 { x, y, z } = fineness.thinnest;
    vec![format!(
        "walls of {:.2e} m, thinnest at ({x:.4}, {y:.4}, {z:.4}) m, have edges of {:.2e} m: thin motions \
         may be off by several per cent; ask for a finer accuracy",
        fineness.wall, used.min_edge
    )]
}

/// An exact shape as triangles, for the time-domain solver.
fn surface_of(exact: &BakeGeometry, options: &BakeOptions) -> Result<TriMesh, BakeError> {
    Ok(match exact.boundary_choice() {
        BoundaryChoice::Ellipsoid(semi_axes) => {
            let form = Form::Ellipsoid { semi_axes };
            Shape::try_new(form, Some(semi_axes.max_element() / 40.0))?.mesh()
        }
        BoundaryChoice::RoundedBox(edges, round) => rounded_box_hull(edges, round)?,
        BoundaryChoice::Meridian(Axisymmetry { meridian, axis }) => {
            let settings = AxisymmetricOptions::new(options.max_wavenumber);
            let solver = AxisymmetricSolver::new(&meridian, axis, settings).with_surface(24.0);
            solver.surface().cloned().unwrap_or_default()
        }
        BoundaryChoice::Triangles(mesh) => mesh.clone(),
    })
}

/// Finite differences in time on a surface with walls of this thickness \[m\].
fn time_stepping(
    mesh: &TriMesh,
    wall: f64,
    options: &BakeOptions,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<Prepared, BakeError> {
    let mass = MassProperties::of(mesh)?;
    let radius = mesh.bounding_radius(DVec3::ZERO);
    let wave = std::f64::consts::TAU / options.max_wavenumber;
    let cavity = has_cavities(mesh, &mass);
    // Two cells across a wall; at least ten on the shortest wave, eight on the radius.
    let spacing = (0.5 * wall).min(wave / 10.0).min(radius / 8.0);
    let highest = options.max_wavenumber * radius;
    let solver = WaveSolver::try_new(
        mesh,
        WaveOptions {
            max_wavenumber: options.max_wavenumber,
            spacing,
            order: multipole_order(highest, options.accuracy),
            boundary: Boundary::CutCells,
            longest: if cavity { 30.0 } else { 12.0 },
        },
    )?;
    let unknowns = solver.cells();
    // Time stepping.
    let field = watched(progress, |report| solver.run_on(options.device, report))?;
    Ok(Prepared {
        solver: Box::new(field),
        spacing: if cavity { CAVITY_SPACING } else { SOLID_SPACING },
        method: match options.device {
            WaveDevice::Cpu => "finite differences in time",
            WaveDevice::Gpu => "finite differences in time on a graphics processor",
        },
        unknowns,
        warnings: Vec::new(),
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
