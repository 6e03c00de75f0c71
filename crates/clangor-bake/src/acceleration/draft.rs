//! A draft of a field: bounded work for a body of any form and size.
//!
//! ```text
//! exact form, cheap ─► its own solver, with fewer nodes                        ┐
//! any other body    ─► a few hundred vertices ─► boundary elements on triangles ┴─► band ─► above it, 1/f
//! ```
//!
//! The band ends where two edges are a wave, or where frequencies would be too many. Above
//! it the pattern is that of its last frequency, and falls as 1/f: a surface in motion has then the pressure
//! ρc v of a plane wave, so that an acceleration gives p ∝ 1/ω. Third octaves against exact fields:
//! tests/cross/draft.rs.
//!
//! Not within any accuracy: creases and rounded edges are as coarse as the triangles.

use std::f64::consts::TAU;
use std::sync::OnceLock;

use clangor_core::geometry::tri_mesh::TriMesh;
use num_complex::Complex64;

use super::plan::surface_of;
use super::prepared::Prepared;
use super::{BakeError, BakeOptions};
use crate::bem::axisymmetric::{AxisymmetricOptions, AxisymmetricSolver};
use crate::bem::symmetric_patches::SymmetricPatchSolver;
use crate::bem::triangles::TriangleSolver;
use crate::geometry_class::bake_geometry::{Axisymmetry, BakeGeometry};
use crate::geometry_class::solver_choice::BoundaryChoice;
use crate::mesh::draft_surface::{draft_surface, resolved_wavenumber};
use crate::radiation::{RadiationError, RadiationSample, RadiationSolver};

/// Error that the fit of a draft aims at.
pub const DRAFT_ACCURACY: f64 = 0.1;
/// Spacing in κ of the first solves, and highest κ for which it is kept.
const SPACING: f64 = 1.4;
const HIGHEST: f64 = 24.0;
/// Solves after the first ones.
const MORE_SOLVES: usize = 4;
/// Fewest and most vertices.
const VERTICES: [f64; 2] = [220.0, MOST_VERTICES];
pub(crate) const MOST_VERTICES: f64 = 340.0;
/// Edges to a wave that the vertices aim at.
const WANTED_EDGES: f64 = 4.0;
/// Highest κ of curved patches, and of bodies of revolution on their meridian.
const HIGHEST_ON_PATCHES: f64 = 6.0;
/// Most unknowns on a meridian.
const MERIDIAN_UNKNOWNS: usize = 240;
/// Solves of a draft with so many.
const MERIDIAN_SOLVES: usize = 24;
/// κ above the band where the fall is sampled: the first in its end, and the ratio of one to the next.
const ABOVE: f64 = 1.1;
const ABOVE_RATIO: f64 = 1.4;

/// A solver of bounded work, and the band that it solves.
pub(super) fn prepare_draft(geometry: &BakeGeometry, options: &BakeOptions) -> Result<Prepared, BakeError> {
    let radius = geometry.bounding_radius();
    let highest = options.max_wavenumber.min(HIGHEST / radius);
    if let Some(prepared) = on_exact_form(geometry, options, highest) {
        return Ok(prepared);
    }
    let surface =
        surface_of(&geometry.boundary_choice(), &BakeOptions { max_wavenumber: highest, ..*options })?;
    let (mesh, end) = resolved(&surface, highest)?;
    let solver = TriangleSolver::try_draft(&mesh, end)?;
    let unknowns = solver.unknowns();
    Ok(prepared(Box::new(solver), options, end, unknowns, "a draft by boundary elements on few triangles"))
}

/// A solver of high order, where the form has one and it is cheap.
fn on_exact_form(geometry: &BakeGeometry, options: &BakeOptions, highest: f64) -> Option<Prepared> {
    if let Some(form) = geometry.axisymmetry() {
        let solver = AxisymmetricSolver::new(&form.meridian, form.axis, meridian_options(highest));
        let unknowns = solver.unknowns();
        let method = "a draft by boundary elements on the meridian";
        return (unknowns <= MERIDIAN_UNKNOWNS)
            .then(|| prepared(Box::new(solver), options, highest, unknowns, method));
    }
    if options.max_wavenumber * geometry.bounding_radius() > HIGHEST_ON_PATCHES {
        return None;
    }
    let solver = match geometry.boundary_choice() {
        BoundaryChoice::Ellipsoid(semi_axes) => {
            SymmetricPatchSolver::ellipsoid(semi_axes, highest, DRAFT_ACCURACY)
        }
        BoundaryChoice::RoundedBox(edges, round) => {
            SymmetricPatchSolver::rounded_box(edges, round, highest, DRAFT_ACCURACY)
        }
        _ => return None,
    };
    let solver = solver.ok().filter(|solver| solver.unknowns() <= MERIDIAN_UNKNOWNS)?;
    let unknowns = solver.unknowns();
    Some(prepared(Box::new(solver), options, highest, unknowns, "a draft by boundary elements on one octant"))
}

/// Nodes on the meridian of a draft, up to a wavenumber [1/m].
pub(crate) fn meridian_options(highest: f64) -> AxisymmetricOptions {
    AxisymmetricOptions {
        nodes_per_wavelength: WANTED_EDGES,
        edge_levels: 2,
        ..AxisymmetricOptions::new(highest)
    }
}

/// Whether so many solves on the meridian of a body of revolution, up to a wavenumber [1/m], are the work
/// of a draft.
pub(crate) fn suits_meridian(form: &Axisymmetry<'_>, highest: f64, solves: usize) -> bool {
    let solver = AxisymmetricSolver::new(&form.meridian, form.axis, meridian_options(highest));
    solver.unknowns().pow(2) * solves <= MERIDIAN_UNKNOWNS.pow(2) * MERIDIAN_SOLVES
}

/// The triangles of a draft up to a wavenumber [1/m], and the wavenumber up to which they are short enough.
fn resolved(mesh: &TriMesh, highest: f64) -> Result<(TriMesh, f64), BakeError> {
    let area = mesh.area();
    let vertices_for = |edge: f64| 2.0 / 3.0_f64.sqrt() * area / (edge * edge);
    let vertices = vertices_for(TAU / highest / WANTED_EDGES).clamp(VERTICES[0], VERTICES[1]);
    let coarse = draft_surface(mesh, vertices)?;
    let end = resolved_wavenumber(&coarse);
    Ok((coarse, highest.min(end)))
}

fn prepared(
    solver: Box<dyn RadiationSolver>,
    options: &BakeOptions,
    end: f64,
    unknowns: usize,
    method: &'static str,
) -> Prepared {
    let asked = options.max_wavenumber;
    let ends_early = end < 0.99 * asked;
    let mut warnings = Vec::new();
    if ends_early {
        warnings.push(format!(
            "the draft solves its clicks up to {:.0} % of the band; above, they fall as 1/f",
            100.0 * end / asked
        ));
    }
    let spacing = SPACING;
    let steps = (end * solver.reference_radius() / spacing).ceil().max(3.0) as usize;
    let band = DraftBand { solver, end, last: OnceLock::new() };
    let above: Vec<f64> = if ends_early { falling(end, asked) } else { Vec::new() };
    Prepared {
        solver: Box::new(band),
        spacing,
        method,
        unknowns,
        warnings,
        highest: end,
        most_solves: Some(steps + above.len() + 2 + MORE_SOLVES),
        above,
    }
}

/// Wavenumbers above the end of a band, up to that asked for.
fn falling(end: f64, asked: f64) -> Vec<f64> {
    let steps = std::iter::successors(Some(ABOVE * end), |k| Some(ABOVE_RATIO * k));
    steps.take_while(|k| *k < asked / ABOVE).chain([asked]).collect()
}

/// A solver up to the end of its band, and the fall above it.
struct DraftBand {
    solver: Box<dyn RadiationSolver>,
    /// \[1/m\]
    end: f64,
    /// The last frequency of the band.
    last: OnceLock<RadiationSample>,
}

impl DraftBand {
    /// The sample above the band at a wavenumber [1/m].
    fn above(&self, wavenumber: f64, order: usize) -> Result<RadiationSample, RadiationError> {
        if self.last.get().is_none() {
            let solved = self.solver.solve(&[self.end], order)?.pop().ok_or(RadiationError::Empty)?;
            let _ = self.last.set(solved);
        }
        let last = self.last.get().ok_or(RadiationError::Empty)?;
        let fall = self.end / wavenumber;
        let mut sample = last.clone();
        sample.wavenumber = Complex64::new(wavenumber, last.wavenumber.im);
        sample.coefficients.iter_mut().flatten().for_each(|c| *c *= fall);
        sample.surface_pressure.iter_mut().flatten().for_each(|p| *p *= fall);
        Ok(sample)
    }
}

impl RadiationSolver for DraftBand {
    fn solve(&self, wavenumbers: &[f64], order: usize) -> Result<Vec<RadiationSample>, RadiationError> {
        let within: Vec<f64> = wavenumbers.iter().copied().filter(|k| *k <= self.end).collect();
        let mut solved =
            if within.is_empty() { Vec::new() } else { self.solver.solve(&within, order)? }.into_iter();
        wavenumbers
            .iter()
            .map(|k| match *k <= self.end {
                true => solved.next().ok_or(RadiationError::Empty),
                false => self.above(*k, order),
            })
            .collect()
    }

    fn reference_radius(&self) -> f64 {
        self.solver.reference_radius()
    }

    fn surface(&self) -> Option<&TriMesh> {
        self.solver.surface()
    }
}
