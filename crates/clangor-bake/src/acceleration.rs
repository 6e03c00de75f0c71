//! Acceleration noise of one body: picks a solver, solves at the frequencies that the band needs, and fits.

mod cavities;
mod draft;
mod frequencies;
mod motion_fits;
pub(crate) mod plan;
mod prepared;
pub(crate) mod sampling;
mod sketch;
mod solvers;

use std::ops::ControlFlow;

use clangor_core::geometry::solid::MeshError;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::math::spherical_harmonics::index;
use clangor_core::shape::ShapeError;
use clangor_core::sound_model::acceleration::field::{AccelerationField, RIGID_DOFS, Term};
use clangor_core::sound_model::acceleration::model::AccelerationModel;
use clangor_core::sound_model::acceleration::near_field::NearField;
use num_complex::{Complex32, Complex64};

pub(crate) use self::cavities::{has_cavities, has_narrow_mouth};
pub use self::draft::DRAFT_ACCURACY;
pub(crate) use self::draft::{MOST_VERTICES, meridian_options, suits_meridian};
use self::frequencies::{Band, FittedBand, solve_band};
pub(crate) use self::plan::coarser;
pub use self::plan::planned_cost;
use self::solvers::prepare;
pub(crate) use self::solvers::watched;
use crate::effort::Effort;
use crate::fdtd::{WaveDevice, WaveError};
use crate::geometry_class::bake_geometry::BakeGeometry;
use crate::mesh::remesh::RemeshError;
use crate::radiation::{RadiationError, RadiationSample, RadiationSolver};

/// Solver to use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// The cheapest accurate solver for the shape.
    #[default]
    Auto,
    /// Boundary elements.
    Bem,
    /// Finite differences in time.
    Fdtd,
}

/// Settings of a bake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeOptions {
    /// Highest wavenumber k = 2πf/c [1/m].
    pub max_wavenumber: f64,
    /// Requested level error: of each motion against the loudest of the body, rotations at equal surface
    /// speed.
    pub accuracy: f64,
    /// Which solver.
    pub method: Method,
    /// Where finite differences in time run; the other solvers run on the processor only.
    pub device: WaveDevice,
    /// Whether to keep the surface pressure for listeners inside the bounding sphere.
    pub near_field: bool,
    /// How much work the bake may be. A draft has no near field.
    pub effort: Effort,
    /// CPU time \[s\], estimated, that the bake may take. The estimate is made where the mesh is known; the
    /// model does not depend on it.
    pub patience: f64,
}

impl BakeOptions {
    /// The solver that suits the body, on the processor, without a near field.
    pub fn new(max_wavenumber: f64, accuracy: f64) -> Self {
        let (method, device) = (Method::Auto, WaveDevice::Cpu);
        let (effort, patience) = (Effort::Exact, f64::INFINITY);
        BakeOptions { max_wavenumber, accuracy, method, device, near_field: false, effort, patience }
    }

    /// The draft of the same field: without the wish for an accuracy, a solver, or a near field, so that all
    /// options of one band have the same draft.
    #[must_use]
    pub fn draft(self) -> Self {
        let effort = Effort::Draft;
        BakeOptions { effort, ..BakeOptions::new(self.max_wavenumber, DRAFT_ACCURACY) }
    }
}

/// Progress of a bake.
#[derive(Clone, Debug, PartialEq)]
pub struct BakeProgress {
    /// Completed fraction of the work, 0 to 1.
    pub done: f64,
    /// Current stage of the work.
    pub stage: &'static str,
}

/// Quality of the model, and the evidence for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Evidence {
    /// Name of the solver.
    pub method: String,
    /// Unknowns of the largest system, or cells.
    pub unknowns: usize,
    /// Frequencies solved.
    pub solves: usize,
    /// Largest level error of the rational fit at held-out frequencies.
    pub held_out_error: f64,
    /// Warnings for the user: thin walls, lost volume, dropped band.
    pub warnings: Vec<String>,
}

/// Reasons why a bake fails.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// The boundary-element solver failed.
    #[error(transparent)]
    Radiation(#[from] RadiationError),
    /// The surface does not enclose a solid.
    #[error("the surface bounds no solid: {0}")]
    Solid(#[from] MeshError),
    /// The surface cannot be remeshed for the solver.
    #[error(transparent)]
    Remesh(#[from] RemeshError),
    /// The time-domain solver failed.
    #[error(transparent)]
    Wave(WaveError),
    /// The shape cannot be triangulated.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// No band is low enough for any solver.
    #[error("no solver can take a body of {radius:.3} m even up to {wavenumber:.2e} 1/m")]
    NoBand {
        /// Bounding radius R \[m\].
        radius: f64,
        /// Lowest limit tried, k [1/m].
        wavenumber: f64,
    },
    /// The band needs more multipoles than a model can hold.
    #[error(
        "a body of {radius:.3} m needs multipoles to order {order} at {wavenumber:.4e} 1/m, more than the \
         {most} that are kept; use a lower band"
    )]
    Multipoles {
        /// Bounding radius R \[m\].
        radius: f64,
        /// Highest wavenumber k [1/m].
        wavenumber: f64,
        /// Order needed, about kR.
        order: usize,
        /// Highest order.
        most: usize,
    },
    /// It would take longer than the patience.
    #[error("it takes about {seconds:.0} s of CPU time, more than the {patience:.0} s allowed")]
    TooLong {
        /// Estimated CPU time \[s\].
        seconds: f64,
        /// CPU time allowed \[s\].
        patience: f64,
    },
    /// Stopped by the caller.
    #[error("interrupted")]
    Interrupted,
}

/// Highest order of the multipoles. Above it a model takes a hundred megabytes and a bake takes hours.
const MOST_ORDER: usize = 150;

impl From<WaveError> for BakeError {
    fn from(error: WaveError) -> Self {
        match error {
            WaveError::Interrupted => BakeError::Interrupted,
            error => BakeError::Wave(error),
        }
    }
}

/// A solved frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct SolvedFrequency {
    /// Requested wavenumber k [1/m].
    pub asked: f64,
    /// The solution.
    pub sample: RadiationSample,
}

/// Start of a resumed computation, and the store of its results.
pub struct Resumption<'a> {
    /// Samples of an earlier call with the same geometry and options.
    pub solved: Vec<SolvedFrequency>,
    /// Receives all samples solved so far, after each batch.
    pub keep: &'a mut dyn FnMut(&[SolvedFrequency]),
}

/// Computes the field of a body's six rigid motions, which is that of its
/// [outer surface](BakeGeometry::outside).
///
/// `progress` receives the completed part of the work, and may stop it.
///
/// # Errors
/// [`BakeError`].
pub fn bake(
    geometry: &BakeGeometry,
    options: &BakeOptions,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<(AccelerationModel, Evidence), BakeError> {
    resume_bake(geometry, options, Resumption { solved: Vec::new(), keep: &mut |_| () }, progress)
}

/// Like [`bake`], but resumes an interrupted call. The result has the same bits.
///
/// Differs for finite differences in time, which have no separate frequencies and start again.
///
/// # Errors
/// [`BakeError`].
pub fn resume_bake(
    geometry: &BakeGeometry,
    options: &BakeOptions,
    resumption: Resumption<'_>,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<(AccelerationModel, Evidence), BakeError> {
    let prepared = prepare(&geometry.outside(), options, progress)?;
    let options = BakeOptions { max_wavenumber: prepared.highest, ..*options };
    let radius = prepared.solver.reference_radius();
    let plan = SolvePlan {
        spacing: prepared.spacing,
        above: prepared.above.iter().map(|k| k * radius).collect(),
        most_solves: prepared.most_solves,
    };
    let (mut model, mut evidence) = fitted_model(&*prepared.solver, &plan, &options, resumption, progress)?;
    if let Some(last) = plan.above.last() {
        model.field.max_wavenumber = *last;
    }
    evidence.method = prepared.method.into();
    evidence.unknowns = prepared.unknowns;
    evidence.warnings.extend(prepared.warnings);
    Ok((model, evidence))
}

/// Fits the field that a solver computes.
///
/// # Errors
/// [`BakeError`].
pub fn bake_with(
    solver: &dyn RadiationSolver,
    spacing: f64,
    options: &BakeOptions,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<(AccelerationModel, Evidence), BakeError> {
    let resumption = Resumption { solved: Vec::new(), keep: &mut |_| () };
    fitted_model(solver, &SolvePlan::uniform(spacing), options, resumption, progress)
}

/// Solves that any band may need.
const LEAST_SOLVES: usize = 24;

/// Which frequencies are solved.
struct SolvePlan {
    /// Of the first ones, in κ.
    spacing: f64,
    /// κ beyond the band, of a solver that knows them.
    above: Vec<f64>,
    /// Most of them; as many as the band may need without.
    most_solves: Option<usize>,
}

impl SolvePlan {
    fn uniform(spacing: f64) -> Self {
        SolvePlan { spacing, above: Vec::new(), most_solves: None }
    }
}

fn fitted_model(
    solver: &dyn RadiationSolver,
    plan: &SolvePlan,
    options: &BakeOptions,
    resumption: Resumption<'_>,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<(AccelerationModel, Evidence), BakeError> {
    // Multipole order that the accuracy needs at the highest κ = kR.
    let radius = solver.reference_radius();
    let highest = options.max_wavenumber * radius;
    let order = multipole_order(highest, options.accuracy);
    if order > MOST_ORDER {
        let wavenumber = options.max_wavenumber;
        return Err(BakeError::Multipoles { radius, wavenumber, order, most: MOST_ORDER });
    }
    // Adaptive choice of frequencies and rational fit.
    let band = Band {
        highest,
        spacing: plan.spacing,
        above: plan.above.clone(),
        order,
        tolerance: 0.5 * options.accuracy,
        most_solves: plan.most_solves.unwrap_or(((3.0 * highest / plan.spacing) as usize).max(LEAST_SOLVES)),
    };
    let fitted = solve_band(solver, &band, resumption, progress)?;
    let mut warnings = Vec::new();
    if fitted.held_out > options.accuracy && options.effort == Effort::Exact {
        warnings.push(format!(
            "frequencies between those solved are off by {:.1e}, more than the {:.1e} asked for",
            fitted.held_out, options.accuracy
        ));
    }
    // Multipoles and surface pressures at the support points of the fit.
    let field = field_of(&fitted, radius, highest, options.accuracy);
    let near = match solver.surface() {
        Some(surface) if options.near_field => Some(near_field_of(&fitted, surface, radius)),
        _ => None,
    };
    let evidence = Evidence {
        method: String::new(),
        unknowns: 0,
        solves: fitted.solves,
        held_out_error: fitted.held_out,
        warnings,
    };
    Ok((AccelerationModel { radius, field, near }, evidence))
}

/// Order of the multipoles for an error at 2 R and beyond: κ + 2 gives about 1e-3, κ + 4 about 1e-4; flat
/// bodies of any size need the first ten for their near field.
fn multipole_order(highest: f64, accuracy: f64) -> usize {
    let extra = if accuracy < 5e-4 { 5.0 } else { 3.0 };
    ((highest + extra).ceil() as usize).max(if accuracy < 5e-4 { 12 } else { 10 })
}

/// Multipole coefficients at the nodes, without negligible terms.
fn field_of(fitted: &FittedBand, radius: f64, highest: f64, accuracy: f64) -> AccelerationField {
    // Level of the strongest motion at each node, for the relative threshold.
    let at_nodes: Vec<&RadiationSample> = fitted.fit.support.iter().map(|&i| &fitted.samples[i]).collect();
    let order = (at_nodes[0].coefficients[0].len() as f64).sqrt() as usize - 1;
    let unit = |degree: usize| if degree < 3 { radius } else { radius * radius };
    let loudest: Vec<f64> = at_nodes
        .iter()
        .map(|sample| {
            let square = |d: usize| sample.coefficients[d].iter().map(Complex64::norm_sqr).sum::<f64>();
            (0..RIGID_DOFS).map(|d| square(d).sqrt() / unit(d)).fold(0.0, f64::max)
        })
        .collect();
    let mut field = AccelerationField {
        max_wavenumber: highest,
        ring_time: fitted.ring_time,
        nodes: fitted.fit.nodes.clone(),
        terms: Vec::new(),
        real: Vec::new(),
        imaginary: Vec::new(),
    };
    // Keep each (order, motion) whose level exceeds the threshold at some node.
    for n in 0..=order {
        for m in -(n as isize)..=n as isize {
            for degree in 0..RIGID_DOFS {
                let value =
                    |sample: &RadiationSample| sample.coefficients[degree][index(n, m)] / unit(degree);
                let level =
                    at_nodes.iter().zip(&loudest).map(|(s, l)| value(s).norm() / l).fold(0.0, f64::max);
                // Low orders decay least with distance: a dipole that is faint near the body dominates far
                // away.
                let least = if n <= 2 { 1e-4 * accuracy } else { 1e-2 * accuracy };
                if level <= least {
                    continue;
                }
                field.terms.push(Term { n: n as u8, m: m as i8, degree: degree as u8 });
                // Monopoles are divided by s², which keeps them finite at s = 0.
                for sample in &at_nodes {
                    let s = Complex64::I * sample.wavenumber * radius;
                    let q = if n == 0 { value(sample) / (s * s) } else { value(sample) };
                    field.real.push(q.re as f32);
                    field.imaginary.push(q.im as f32);
                }
            }
        }
    }
    field
}

/// Surface pressures at the nodes, in the units of the field.
fn near_field_of(fitted: &FittedBand, surface: &TriMesh, radius: f64) -> NearField {
    let mut scaled = surface.clone();
    scaled.vertices.iter_mut().for_each(|v| *v /= radius);
    let support = &fitted.fit.support;
    let mut pressures = Vec::with_capacity(surface.vertices.len() * RIGID_DOFS * support.len());
    for vertex in 0..surface.vertices.len() {
        for degree in 0..RIGID_DOFS {
            let unit = if degree < 3 { radius } else { radius * radius };
            let at = |i: &usize| fitted.samples[*i].surface_pressure[vertex][degree] / unit;
            pressures.extend(support.iter().map(at).map(|p| Complex32::new(p.re as f32, p.im as f32)));
        }
    }
    NearField::from_pressures(scaled, support.len(), &pressures)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use glam::DVec3;

    use super::*;
    use crate::bem::symmetric_patches::SymmetricPatchSolver;

    /// A solver that counts its solves.
    struct Counting {
        solver: SymmetricPatchSolver,
        solved: AtomicUsize,
    }

    impl RadiationSolver for Counting {
        fn solve(&self, wavenumbers: &[f64], order: usize) -> Result<Vec<RadiationSample>, RadiationError> {
            self.solved.fetch_add(wavenumbers.len(), Ordering::Relaxed);
            self.solver.solve(wavenumbers, order)
        }

        fn reference_radius(&self) -> f64 {
            self.solver.reference_radius()
        }

        fn surface(&self) -> Option<&TriMesh> {
            self.solver.surface()
        }
    }

    #[test]
    fn a_bake_goes_on_where_it_was_interrupted() {
        let options = BakeOptions { method: Method::Bem, near_field: true, ..BakeOptions::new(4.0, 3e-2) };
        let solver = SymmetricPatchSolver::ellipsoid(DVec3::new(1.0, 0.8, 0.6), 4.0, 1e-2).unwrap();
        let counting = Counting { solver, solved: AtomicUsize::new(0) };
        let mut go_on = |_: &BakeProgress| ControlFlow::Continue(());
        let mut kept: Vec<Vec<SolvedFrequency>> = Vec::new();
        let mut keep = |solved: &[SolvedFrequency]| kept.push(solved.to_vec());
        let whole = Resumption { solved: Vec::new(), keep: &mut keep };
        let (model, evidence) =
            fitted_model(&counting, &SolvePlan::uniform(0.8), &options, whole, &mut go_on).unwrap();
        let all = counting.solved.swap(0, Ordering::Relaxed);
        assert_eq!((all, kept.last().map(Vec::len)), (evidence.solves, Some(evidence.solves)));
        for solved in kept {
            let left = all - solved.len();
            let resumption = Resumption { solved, keep: &mut |_| () };
            let (again, _) =
                fitted_model(&counting, &SolvePlan::uniform(0.8), &options, resumption, &mut go_on).unwrap();
            assert!(again == model);
            assert_eq!(counting.solved.swap(0, Ordering::Relaxed), left);
        }
        // The result of a different order is ignored.
        let other = SolvedFrequency { asked: 4.0, sample: counting.solve(&[4.0], 3).unwrap().swap_remove(0) };
        let resumption = Resumption { solved: vec![other], keep: &mut |_| () };
        let (again, _) =
            fitted_model(&counting, &SolvePlan::uniform(0.8), &options, resumption, &mut go_on).unwrap();
        assert!(again == model);
    }
}
