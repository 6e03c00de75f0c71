//! Which solvers can take a body, the most accurate first, and the band up to which one of them can.
//!
//! | class | solvers |
//! |---|---|
//! | ellipsoids, rounded boxes | curved patches, those of other surfaces |
//! | axisymmetric | meridian, those of other surfaces |
//! | other surfaces | triangles, time domain, triangles longer than the walls, cells larger than the walls |
//!
//! Triangles that take ten minutes, and several times as long as cells that resolve the walls, come after
//! them, for accuracies of 1 % and more; so do patches that take minutes after triangles: those of a beam of
//! 300 mm take 155 s of CPU time to 20 kHz.
//!
//! Where triangles for an accuracy below 1 % are too much, those for the finest of the [`coarser`] ones that
//! fit come before the time domain: cells do not follow the accuracy, and sharp thin bodies are off by up to
//! 5 % on them.
//!
//! A solver can take a body if its unknowns or cells fit in memory and, unless the caller named the method,
//! if its [operations](crate::cost) are at most [`MOST_OPERATIONS`]. If none can, the band is narrowed until
//! one can: a limit costs the highest frequencies, and a warning says which.

use std::borrow::Cow;
use std::f64::consts::TAU;

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::medium::Medium;
use clangor_core::shape::{Form, Shape};
use glam::DVec3;

use super::cavities::{has_cavities, has_narrow_mouth};
use super::sampling::{CAVITY_SPACING, LONGEST, SOLID_SPACING, density};
use super::{BakeError, BakeOptions, MOST_ORDER, Method, multipole_order};
use crate::bem::axisymmetric::{self, AxisymmetricOptions, AxisymmetricSolver};
use crate::bem::symmetric_patches::{self, SymmetricPatchSolver};
use crate::bem::triangles::MOST_UNKNOWNS;
use crate::cost::operations::{self, CHEAP, FieldCost, MOST_OPERATIONS};
use crate::fdtd::{self, Boundary, WaveDevice, WaveOptions};
use crate::geometry_class::bake_geometry::{Axisymmetry, BakeGeometry};
use crate::geometry_class::solver_choice::{BoundaryChoice, rounded_box_hull};
use crate::mesh::remesh::resolution::{Resolution, resolution};
use crate::radiation::RadiationSolver;

/// Largest and smallest step of the band when it is narrowed, and most steps.
const NARROWER: [f64; 2] = [1.1, 2.0];
const MOST_STEPS: usize = 24;
/// Share of the error left to the discretisation of exact shapes.
const FINE: f64 = 0.3;
/// κ whose waves the triangles of an axisymmetric body resolve, at most.
const FINEST: f64 = 30.0;
/// Triangles that are `MOST_UNKNOWNS` by estimate may be a quarter more.
const ESTIMATE: f64 = 1.25;
/// The coarsest accuracy of triangles in place of those for a finer one, and the ratio of each to the next.
pub(crate) const COARSEST_ACCURACY: f64 = 0.01;
const COARSER: f64 = 1.5;
/// What cells reach.
const CELLS_WITHIN: f64 = 0.05;

/// The accuracies that may stand for one that triangles cannot reach, the finest first; none for 1 % or more.
pub(crate) fn coarser(accuracy: f64) -> impl Iterator<Item = f64> {
    let next = |a: &f64| (*a < COARSEST_ACCURACY).then_some((COARSER * a).min(COARSEST_ACCURACY));
    std::iter::successors(next(&accuracy), next)
}

/// A solver with its resolution.
#[derive(Clone, Debug)]
pub(super) enum Candidate {
    /// Curved patches on an octant.
    Patches,
    /// The meridian.
    Meridian,
    /// Triangles.
    Triangles(Resolution),
    /// Finite differences in time.
    TimeDomain {
        /// Edge of a cell \[m\].
        spacing: f64,
        /// Thickness of the walls \[m\].
        wall: f64,
    },
}

/// What a solver takes.
#[derive(Clone, Copy, Debug)]
struct Need {
    cost: FieldCost,
    /// Unknowns or cells over the most that fit.
    fill: f64,
    /// Power of the wavenumber with which they grow.
    growth: i32,
}

impl Need {
    /// By which factor in the wavenumber it is too much; at most 1 where it is not. Who names the method
    /// waits for any work.
    fn over(&self, named: bool) -> f64 {
        let work = if named { 0.0 } else { (self.cost.operations / MOST_OPERATIONS).cbrt() };
        work.max(self.fill.powf(f64::from(self.growth).recip()))
    }
}

/// The solvers that can take a body in a band.
pub(super) struct FieldPlan<'a> {
    /// The highest wavenumber that they reach [1/m].
    pub(super) max_wavenumber: f64,
    /// The most accurate first, each with its work; at least one.
    pub(super) candidates: Vec<(Candidate, FieldCost)>,
    /// The body as triangles, where a candidate needs it.
    pub(super) surface: Option<Cow<'a, TriMesh>>,
    /// Spacing in κ of the first solves.
    pub(super) spacing: f64,
    /// Warnings for the user.
    pub(super) warnings: Vec<String>,
}

/// The work of [`bake`](super::bake) for a body, by the sizes of triangles that its surface needs: within a
/// factor of three, where [`field_cost`](crate::cost::field_cost) guesses them.
///
/// # Errors
/// As [`bake`](super::bake), for a body that no solver can take.
pub fn planned_cost(geometry: &BakeGeometry, options: &BakeOptions) -> Result<FieldCost, BakeError> {
    let outside = geometry.outside();
    let plan = FieldPlan::new(&outside, options)?;
    Ok(plan.candidates.first().map_or(FieldCost::default(), |(_, cost)| *cost))
}

impl<'a> FieldPlan<'a> {
    /// # Errors
    /// [`BakeError`] of a surface that encloses no solid, or of a body that no band is low enough for.
    pub(super) fn new(geometry: &'a BakeGeometry, options: &BakeOptions) -> Result<Self, BakeError> {
        let radius = geometry.bounding_radius();
        let choice = geometry.boundary_choice();
        let named = options.method != Method::Auto;
        // Multipoles that a model can hold.
        let asked = options.max_wavenumber;
        let mut k = asked;
        while multipole_order(k * radius, options.accuracy) > MOST_ORDER {
            k = (k / NARROWER[0]).min((MOST_ORDER as f64 - 6.0) / radius);
        }
        let mut body = Body {
            geometry,
            choice,
            options: *options,
            surface: None,
            cavities: None,
            fineness: None,
            planes: None,
        };
        for _ in 0..MOST_STEPS {
            // The solvers that can take this band.
            let (mut able, mut excess) = (Vec::new(), f64::INFINITY);
            for kind in body.kinds() {
                let asked = options.accuracy;
                let accuracies: Vec<f64> = match kind {
                    Kind::Triangles => std::iter::once(asked).chain(coarser(asked)).collect(),
                    _ => vec![asked],
                };
                let mut found = None;
                for accuracy in accuracies {
                    let Some((candidate, need)) = body.candidate(kind, k, accuracy)? else { continue };
                    let over = need.over(named);
                    excess = excess.min(over);
                    if over <= 1.0 {
                        found = Some((candidate, need.cost));
                        break;
                    }
                }
                if let Some(candidate) = found {
                    // A surface may resist its remeshing: then another solver serves.
                    let may_fail = matches!(kind, Kind::Triangles | Kind::LongTriangles);
                    let takes_long = kind == Kind::Exact && candidate.1.operations >= CHEAP;
                    able.push(candidate);
                    if able.len() == 2 || !(may_fail || takes_long) {
                        break;
                    }
                }
            }
            if !able.is_empty() {
                if !named && options.accuracy >= COARSEST_ACCURACY {
                    cheaper_first(&mut able);
                }
                let spacing = body.spacing()?;
                let warnings = if k < asked { vec![narrowed(k, asked)] } else { Vec::new() };
                return Ok(Self {
                    max_wavenumber: k,
                    candidates: able,
                    surface: body.surface,
                    spacing,
                    warnings,
                });
            }
            k /= excess.clamp(NARROWER[0], NARROWER[1]);
        }
        Err(BakeError::NoBand { radius, wavenumber: k })
    }
}

/// Puts time steps on cells that resolve the walls before triangles that take much longer, and triangles
/// before patches.
fn cheaper_first(able: &mut [(Candidate, FieldCost)]) {
    let [(first, long), (second, short)] = able else { return };
    let (long, short) = (long.operations, short.operations);
    let is_cheaper = match (first, second) {
        (Candidate::Triangles(_), Candidate::TimeDomain { spacing, wall }) => {
            large_cells(*spacing, *wall).is_none() && operations::field_in_time(long, short)
        }
        (Candidate::Patches, Candidate::Triangles(_)) => operations::much_longer(long, short),
        _ => false,
    };
    if is_cheaper {
        able.swap(0, 1);
    }
}

/// Says which part of the band is missing.
fn narrowed(k: f64, asked: f64) -> String {
    let kilohertz = |k: f64| k * Medium::AIR.sound_speed / TAU / 1e3;
    format!(
        "it clicks up to {:.1} kHz in air and not above: its field up to {:.1} kHz exceeds the limit of \
         work or of memory; a coarser --accuracy takes it further, and --method bem or --method fdtd lifts \
         the limit of work",
        kilohertz(k),
        kilohertz(asked)
    )
}

/// Kinds of candidates.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Exact,
    Triangles,
    TimeDomain,
    LongTriangles,
    LargeCells,
}

/// What is known about a body, as far as a candidate needed it.
struct Body<'a> {
    geometry: &'a BakeGeometry,
    choice: BoundaryChoice<'a>,
    options: BakeOptions,
    surface: Option<Cow<'a, TriMesh>>,
    cavities: Option<bool>,
    /// At the wavenumber asked about last.
    fineness: Option<(f64, Resolution)>,
    /// Normals of the mirror planes at the wavenumber and accuracy asked about last.
    planes: Option<([f64; 2], Vec<DVec3>)>,
}

impl<'a> Body<'a> {
    /// The kinds of solvers for the class and the method, the most accurate first.
    fn kinds(&self) -> Vec<Kind> {
        let exact = !matches!(self.choice, BoundaryChoice::Triangles(_));
        let boundary = [Kind::Triangles, Kind::LongTriangles];
        let time = [Kind::TimeDomain, Kind::LargeCells];
        let kinds = [Kind::Exact, boundary[0], time[0], boundary[1], time[1]];
        let wanted = |kind: &Kind| match kind {
            Kind::Exact => exact && self.options.method != Method::Fdtd,
            kind if boundary.contains(kind) => self.options.method != Method::Fdtd,
            _ => self.options.method != Method::Bem,
        };
        kinds.into_iter().filter(wanted).collect()
    }

    /// The resolution that triangles need, and their number of mirror planes.
    fn fineness(&mut self, k: f64, accuracy: f64) -> Result<(Resolution, usize, f64), BakeError> {
        if self.surface.is_none() {
            self.surface = Some(surface_of(&self.choice, &self.options)?);
        }
        let surface: &TriMesh = self.surface.get_or_insert_default();
        let fineness = match self.fineness {
            Some((at, known)) if at == k && known.accuracy == accuracy => known,
            _ => resolution(surface, k, accuracy)?,
        };
        self.fineness = Some((k, fineness));
        let area = surface.area();
        let normals = match self.planes.take() {
            Some((at, known)) if at == [k, accuracy] => known,
            _ => mirrors(self.geometry, [accuracy, fineness.wall], k),
        };
        let planes = normals.len();
        self.planes = Some(([k, accuracy], normals));
        Ok((fineness, planes, area))
    }

    /// Spacing in κ of the first solves.
    fn spacing(&mut self) -> Result<f64, BakeError> {
        Ok(if self.cavities()? { CAVITY_SPACING } else { SOLID_SPACING })
    }

    /// Whether the body has cavities. Exact forms are taken as solid: boundary elements on them cost little.
    fn cavities(&mut self) -> Result<bool, BakeError> {
        if let Some(known) = self.cavities {
            return Ok(known);
        }
        let found = match &self.choice {
            BoundaryChoice::Triangles(mesh) => has_cavities(mesh, &MassProperties::of(mesh)?),
            _ => false,
        };
        self.cavities = Some(found);
        Ok(found)
    }

    /// A solver for a band, and what it takes; `None` where it makes no difference to an earlier one.
    fn candidate(
        &mut self,
        kind: Kind,
        k: f64,
        accuracy: f64,
    ) -> Result<Option<(Candidate, Need)>, BakeError> {
        let radius = self.geometry.bounding_radius();
        let kappa = k * radius;
        let density = density(self.cavities()?);
        if kind == Kind::Exact {
            return Ok(exact(&self.choice, accuracy, k, kappa));
        }
        let longest = LONGEST[usize::from(self.cavities()?)];
        let (fineness, planes, area) = self.fineness(k, accuracy)?;
        // Triangles as long as the waves allow, whatever the walls are.
        let long = fineness.with_long_edges(area);
        let wave = TAU / k;
        let coarse = (wave / 10.0).min(radius / 8.0);
        Ok(match kind {
            Kind::Exact => None,
            Kind::LongTriangles if 4 * long.unknowns > 3 * fineness.unknowns => None,
            Kind::Triangles | Kind::LongTriangles => {
                let used = if kind == Kind::Triangles { fineness } else { long };
                let unknowns = used.unknowns >> planes;
                let systems = [[1, 2, 4, 6][planes.min(3)], 1 << planes];
                let operations = operations::triangles(unknowns, systems, kappa, density);
                let need = Need {
                    cost: FieldCost { operations, unknowns: unknowns as f64 },
                    fill: unknowns as f64 / (ESTIMATE * MOST_UNKNOWNS as f64),
                    growth: 2,
                };
                Some((Candidate::Triangles(used), need))
            }
            Kind::LargeCells if coarse < 0.75 * fineness.wall => None,
            Kind::TimeDomain | Kind::LargeCells => {
                // Two cells across a wall; at least ten on the shortest wave, eight on the radius.
                let fine = coarse.min(0.5 * fineness.wall);
                let spacing = if kind == Kind::TimeDomain { fine } else { coarse };
                let normals = match &self.planes {
                    Some((_, normals)) if self.options.device == WaveDevice::Cpu => normals.as_slice(),
                    _ => &[],
                };
                let options = BakeOptions { max_wavenumber: k, ..self.options };
                let waves = wave_options(&options, radius, spacing, longest);
                let [cells, steps] = waves.extent(radius, normals.len());
                let cut = self.surface.as_deref().map_or(0.0, |mesh| fdtd::cut_cells(mesh, normals, spacing));
                let fill = (cells / fdtd::MOST_CELLS as f64).max(cut / fdtd::MOST_CUT_CELLS as f64);
                let operations = operations::time_domain(cells, steps);
                let cost = FieldCost { operations, unknowns: cells };
                let need = Need { cost, fill, growth: 3 };
                Some((Candidate::TimeDomain { spacing, wall: fineness.wall }, need))
            }
        })
    }
}

/// Settings of time steps on cells of edge `spacing` \[m\] around a body of bounding radius `radius` \[m\],
/// for `longest` R/c after the pulse.
pub(crate) fn wave_options(options: &BakeOptions, radius: f64, spacing: f64, longest: f64) -> WaveOptions {
    WaveOptions {
        max_wavenumber: options.max_wavenumber,
        spacing,
        order: multipole_order(options.max_wavenumber * radius, options.accuracy),
        boundary: Boundary::CutCells,
        longest,
    }
}

/// Normals of the mirror planes to within an accuracy, in a phase and in a wall of this thickness \[m\].
pub(crate) fn mirrors(geometry: &BakeGeometry, [accuracy, wall]: [f64; 2], k: f64) -> Vec<DVec3> {
    let tolerance = accuracy * wall;
    geometry.mirror_normals_in_mean(tolerance, tolerance.min(2.0 * accuracy / k))
}

/// The solver of an exact form.
fn exact(choice: &BoundaryChoice<'_>, accuracy: f64, k: f64, kappa: f64) -> Option<(Candidate, Need)> {
    let fine = FINE * accuracy;
    let of_patches = |unknowns: usize| {
        let operations = operations::patches(unknowns, kappa, SOLID_SPACING);
        let fill = unknowns as f64 / symmetric_patches::MOST_UNKNOWNS as f64;
        let cost = FieldCost { operations, unknowns: unknowns as f64 };
        (Candidate::Patches, Need { cost, fill, growth: 2 })
    };
    match choice {
        BoundaryChoice::Ellipsoid(semi_axes) => {
            Some(of_patches(SymmetricPatchSolver::ellipsoid_unknowns(*semi_axes, k, fine)))
        }
        BoundaryChoice::RoundedBox(edges, round) => {
            Some(of_patches(SymmetricPatchSolver::rounded_box_unknowns(*edges, *round, k, fine)))
        }
        BoundaryChoice::Meridian(Axisymmetry { meridian, axis }) => {
            let settings = AxisymmetricOptions::new(k);
            let unknowns = AxisymmetricSolver::new(meridian, *axis, settings).unknowns();
            let operations = operations::meridian(unknowns, kappa, has_narrow_mouth(meridian));
            let fill = unknowns as f64 / axisymmetric::MOST_UNKNOWNS as f64;
            let cost = FieldCost { operations, unknowns: unknowns as f64 };
            Some((Candidate::Meridian, Need { cost, fill, growth: 1 }))
        }
        BoundaryChoice::Triangles(_) => None,
    }
}

/// An exact shape as triangles.
pub(super) fn surface_of<'a>(
    choice: &BoundaryChoice<'a>,
    options: &BakeOptions,
) -> Result<Cow<'a, TriMesh>, BakeError> {
    Ok(match choice {
        BoundaryChoice::Ellipsoid(semi_axes) => {
            let form = Form::Ellipsoid { semi_axes: *semi_axes };
            Cow::Owned(Shape::try_new(form, Some(semi_axes.max_element() / 40.0))?.mesh())
        }
        BoundaryChoice::RoundedBox(edges, round) => Cow::Owned(rounded_box_hull(*edges, *round)?),
        BoundaryChoice::Meridian(Axisymmetry { meridian, axis }) => {
            let k = options.max_wavenumber.min(FINEST / meridian.bounding_radius());
            let settings = AxisymmetricOptions::new(k);
            let solver = AxisymmetricSolver::new(meridian, *axis, settings).with_surface(24.0);
            Cow::Owned(solver.surface().cloned().unwrap_or_default())
        }
        BoundaryChoice::Triangles(mesh) => Cow::Borrowed(*mesh),
    })
}

/// Longest time simulated after the pulse, in R/c.
pub(super) fn longest(spacing: f64) -> f64 {
    LONGEST[usize::from(spacing == CAVITY_SPACING)]
}

/// Discretisation error of exact forms.
pub(super) fn fine(accuracy: f64) -> f64 {
    FINE * accuracy
}

/// Warning about a solver that is less accurate than asked.
pub(super) fn less_accurate(asked: f64, candidate: &Candidate) -> Option<String> {
    match candidate {
        Candidate::Triangles(Resolution { accuracy, .. }) if *accuracy > asked => Some(format!(
            "its clicks are within about {:.2} % and not {:.2} %: more exceeds the limit of work or of \
             memory, which a lower --max-frequency meets",
            100.0 * accuracy,
            100.0 * asked
        )),
        Candidate::TimeDomain { .. } if asked < CELLS_WITHIN => Some(format!(
            "its clicks are simulated in time, within about 1 % where it is rounded and 5 % where it is thin \
             and sharp or near the resonances of a cavity: cells do not follow an accuracy of {:.2} %",
            100.0 * asked
        )),
        _ => None,
    }
}

/// Warning about walls that cells do not resolve.
pub(super) fn large_cells(spacing: f64, wall: f64) -> Option<String> {
    (spacing > 0.75 * wall).then(|| {
        format!(
            "walls of {wall:.2e} m are thinner than the cells of {spacing:.2e} m: their motions may be off \
             by several per cent, and their thickness by up to a cell"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan_of(geometry: &BakeGeometry, frequency: f64) -> (Vec<Candidate>, f64, f64) {
        let options = BakeOptions::new(TAU * frequency / Medium::AIR.sound_speed, 0.01);
        let plan = FieldPlan::new(geometry, &options).expect("a plan");
        assert_eq!(plan.warnings.is_empty(), plan.max_wavenumber == options.max_wavenumber);
        let said = "it clicks up to ";
        assert!(plan.warnings.iter().all(|warning| warning.starts_with(said)), "{:?}", plan.warnings);
        let operations = plan.candidates[0].1.operations;
        (plan.candidates.into_iter().map(|c| c.0).collect(), plan.max_wavenumber, operations)
    }

    #[test]
    fn a_block_too_large_for_patches_has_triangles_and_a_door_a_narrower_band() {
        let block = |x, y, z| BakeGeometry::RoundedBox { edges: DVec3::new(x, y, z), round: 0.0 };
        let (small, _, cheap) = plan_of(&block(0.04, 0.03, 0.02), 20e3);
        assert!(matches!(small[0], Candidate::Patches));
        let (large, k, dear) = plan_of(&block(0.12, 0.3, 0.12), 20e3);
        assert!(
            matches!(large[0], Candidate::Triangles(_)) && k == TAU * 20e3 / Medium::AIR.sound_speed,
            "{large:?}"
        );
        assert!(dear > 10.0 * cheap && dear <= MOST_OPERATIONS, "{dear:e} {cheap:e}");
        let (_, k, operations) = plan_of(&block(2.0, 0.8, 0.04), 20e3);
        assert!(
            k < TAU * 10e3 / Medium::AIR.sound_speed
                && k > TAU * 1e3 / Medium::AIR.sound_speed
                && operations <= MOST_OPERATIONS,
            "{k}"
        );
        // What triangles cannot reach, they come close to; cells would not.
        let field = |accuracy: f64| {
            let options = BakeOptions::new(TAU * 20e3 / Medium::AIR.sound_speed, accuracy);
            let block = block(0.12, 0.3, 0.12);
            let plan = FieldPlan::new(&block, &options).expect("a plan");
            let candidate = plan.candidates[0].0.clone();
            (less_accurate(accuracy, &candidate), candidate)
        };
        let (warning, candidate) = field(0.002);
        let Candidate::Triangles(Resolution { accuracy, .. }) = candidate else { panic!("{candidate:?}") };
        assert!(accuracy > 0.002 && accuracy <= 0.01, "{accuracy}");
        assert!(warning.is_some_and(|text| text.contains("and not 0.20 %")));
        assert_eq!(field(0.01).0, None);
        // No body is too large for some band.
        let (_, k, _) = plan_of(&block(40.0, 30.0, 0.01), 20e3);
        assert!(k > 0.0);
    }
}
