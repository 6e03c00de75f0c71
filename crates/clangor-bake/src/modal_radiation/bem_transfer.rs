//! Radiation of the modes of any closed surface, by boundary elements on triangles.
//!
//! By reciprocity ([`TriangleSolver::radiate`]) one factorisation serves all modes at its wavenumber. There
//! are three strategies:
//!
//! * *direct*: one system for each mode, at its own wavenumber: for few modes, and for cavities, whose
//!   resonances no ladder of wavenumbers resolves;
//! * *adjoint*: the same for drafts, whose systems are small, by the adjoint pressure of each mode, and by
//!   plane waves where the triangles are too coarse (`bem::triangles::adjoint_multipoles`);
//! * *ladder*: systems at wavenumbers Δκ apart, κ = kR. The multipoles of a mode are interpolated from the
//!   six nearest by a polynomial of degree five. Multipoles normalised on the sphere of radius R, without
//!   e^{−ikR}, are smooth in k: their delays, from any point of the body, are −R/c … R/c and echoes. At
//!   negative κ they are complex conjugates.
//!
//! Each octave has its own mesh, as fine as its waves, the walls and the edges require
//! ([`resolution`](crate::mesh::remesh::resolution)). Bending waves may be shorter than the waves in air;
//! they need only a quadrature ([`NormalVelocityProjection`]), not a mesh. Mirror planes divide the systems;
//! most modes have one parity.
//!
//! Lengths are in bounding radii, and the choice of triangles ignores digits at rounding level. A body of
//! another size has the same triangles, scaled, and with its frequencies in proportion the same transfers.
//!
//! The power is too low by 0.2 % with nine edges per wavelength and by 1.7 % with five; six are used, and
//! fewer for bodies of many unknowns. The error grows with k^3.5 (spheres of 1280 triangles, n ≤ 5;
//! tests/analytic/modal_sphere_flat.rs).

use std::ops::ControlFlow;

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::sound_model::modal::model::ModalTransfer;
use clangor_core::sound_model::modal::surface::ModalSurface;
use glam::{BVec3, DMat3, DVec3};
use num_complex::Complex64;
use rayon::prelude::*;

use super::truncation::last_order;
use super::{ModalMotion, ModalSolver, check};
use crate::acceleration::has_cavities;
use crate::bem::triangles::adjoint_multipoles::LoneMotion;
use crate::bem::triangles::{Equation, MOST_ORDER, TriangleSolver};
use crate::cost::operations::{self, MANY, PER_SECOND};
use crate::effort::Effort;
use crate::geometry_class::mirror_symmetry::mirror_planes_in_mean;
use crate::mesh::draft_surface::{draft_surface, resolved_wavenumber};
use crate::mesh::remesh::resolution::resolution;
use crate::mesh::remesh::{RemeshError, SymmetricMesh, remesh, remesh_symmetric};
use crate::modal_radiation::normal_velocity_projection::NormalVelocityProjection;
use crate::radiation::RadiationError;

/// Spacing in κ of a ladder around bodies without cavities.
const SOLID_SPACING: f64 = 0.75;
/// The same for bodies with cavities.
const CAVITY_SPACING: f64 = 0.3;
/// Systems of a ladder that each mode uses.
const STENCIL: usize = 6;
/// Meshes: for the whole band, for half of it, for a quarter.
const MESHES: usize = 3;
/// Largest unknowns of a coarser mesh, relative to the next finer one, that justify its preparation.
const WORTH: f64 = 0.75;
/// Relative difference of wavenumbers below which modes are solved together.
const TOGETHER: f64 = 1e-4;
/// Share of the error left to tables of what many systems share: ten times as much at the resonances of a
/// cavity.
const SWEEP_SHARE: f64 = 0.01;
/// Memory of tables and of the systems that are solved at the same time [bytes].
const MEMORY: usize = 4 << 30;
/// Fractions of the bounding radius that are significant for the choice of triangles.
const DIGITS: f64 = (1_u64 << 32) as f64;

/// The modes of a closed surface by boundary elements.
#[derive(Clone, Debug)]
pub struct BemModalSolver {
    /// The finest first.
    bands: Vec<Band>,
    spacing: f64,
    /// Unit of length of the bands \[m\].
    unit: f64,
    /// Level error of exact transfers.
    accuracy: f64,
    effort: Effort,
}

/// Level error for given triangles.
const ACCURACY: f64 = 0.01;

/// Unknowns of a draft.
const DRAFT_UNKNOWNS: f64 = 320.0;

/// A mesh and its band.
#[derive(Clone, Debug)]
struct Band {
    mesh: SymmetricMesh,
    /// Highest wavenumber [1/unit].
    highest: f64,
}

/// A system to solve.
#[derive(Clone, Debug, PartialEq)]
struct Rung {
    /// [1/unit].
    wavenumber: f64,
    /// Motions with the weights of the solution and of its conjugate.
    uses: Vec<(usize, [f64; 2])>,
}

impl BemModalSolver {
    /// Prepares the surface of a body whose centre of mass is at the origin, for modes up to `highest` [1/m]
    /// and a level error of `accuracy`.
    ///
    /// # Errors
    /// [`RemeshError`] for a surface that bounds no solid or cannot be remeshed.
    pub fn try_new(surface: &TriMesh, highest: f64, accuracy: f64) -> Result<Self, RemeshError> {
        let unit = surface.bounding_radius(DVec3::ZERO);
        let rounded = |x: f64| (x * DIGITS).round() / DIGITS;
        let vertices =
            surface.vertices.iter().map(|x| DVec3::from_array((*x / unit).to_array().map(rounded)));
        let surface = &TriMesh { vertices: vertices.collect(), triangles: surface.triangles.clone() };
        let highest = rounded(highest * unit);
        let mass = MassProperties::of(surface).map_err(RemeshError::Input)?;
        let spacing = if has_cavities(surface, &mass) { CAVITY_SPACING } else { SOLID_SPACING };
        let margin = 0.5 * STENCIL as f64 * spacing;
        let mut bands: Vec<(Band, usize)> = Vec::new();
        for octave in 0..MESHES {
            let highest = highest * 0.5_f64.powi(octave as i32);
            let fineness = resolution(surface, highest + margin, accuracy)?;
            let useful =
                |(_, unknowns): &(Band, usize)| (fineness.unknowns as f64) < WORTH * *unknowns as f64;
            if bands.last().is_some_and(|finer| !useful(finer)) {
                continue;
            }
            let within = accuracy * fineness.wall;
            let within = [within, within.min(2.0 * accuracy / highest)];
            let planes = centred_mirrors(surface, &mass, within, highest);
            let mesh = match remesh_symmetric(surface, &planes, &fineness.options) {
                Ok((mesh, _)) if !planes.is_empty() => mesh,
                // A mesh that cannot be cut at its planes may work as a whole.
                _ => whole(remesh(surface, &fineness.options)?.0),
            };
            bands.push((Band { mesh, highest }, fineness.unknowns));
        }
        let bands = bands.into_iter().map(|(band, _)| band).collect();
        Ok(BemModalSolver { bands, spacing, unit, accuracy, effort: Effort::Exact })
    }

    /// A draft for a body whose centre of mass is at the origin: one mesh of about 320 unknowns for all
    /// modes. Those above two edges per wavelength send plane waves.
    ///
    /// # Errors
    /// [`RemeshError::Input`] for a surface that bounds no solid.
    pub fn draft(surface: &TriMesh) -> Result<Self, RemeshError> {
        let unit = surface.bounding_radius(DVec3::ZERO);
        let vertices = surface.vertices.iter().map(|x| *x / unit).collect();
        let surface = TriMesh { vertices, triangles: surface.triangles.clone() };
        let mesh = whole(draft_surface(&surface, DRAFT_UNKNOWNS).map_err(RemeshError::Input)?);
        Ok(BemModalSolver {
            bands: vec![Band { mesh, highest: f64::INFINITY }],
            spacing: SOLID_SPACING,
            unit,
            accuracy: ACCURACY,
            effort: Effort::Draft,
        })
    }

    /// With the given triangles, for all modes.
    pub fn on(mesh: SymmetricMesh) -> Self {
        BemModalSolver {
            bands: vec![Band { mesh, highest: f64::INFINITY }],
            spacing: SOLID_SPACING,
            unit: 1.0,
            accuracy: ACCURACY,
            effort: Effort::Exact,
        }
    }

    /// Unknowns of the finest mesh, mirror images included.
    pub fn unknowns(&self) -> usize {
        self.bands.first().map_or(0, |band| band.mesh.whole().0.vertices.len())
    }

    /// The modes that each band solves, by their wavenumbers [1/m].
    fn shares(&self, wavenumbers: &[f64]) -> Vec<Vec<usize>> {
        let mut shares = vec![Vec::new(); self.bands.len()];
        for (i, wavenumber) in wavenumbers.iter().enumerate() {
            let fits = |band: &Band| wavenumber * self.unit <= band.highest * (1.0 + 1e-9);
            shares[self.bands.iter().rposition(fits).unwrap_or(0)].push(i);
        }
        shares
    }
}

impl BemModalSolver {
    /// The transfers of a draft, each by a system of its own. Lengths of the surface in bounding radii.
    fn draft_transfers(
        &self,
        surface: &ModalSurface,
        motions: &[ModalMotion<'_>],
        progress: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Vec<ModalTransfer>, RadiationError> {
        let band = self.bands.first().ok_or(RadiationError::Empty)?;
        let radius = surface.radius();
        let wavenumbers: Vec<f64> = motions.iter().map(|motion| motion.wavenumber * self.unit).collect();
        let end = resolved_wavenumber(&band.mesh.cell);
        let highest = wavenumbers.iter().copied().fold(0.0, f64::max).min(end);
        let solver = TriangleSolver::try_draft(&band.mesh.cell, highest)?;
        let operator =
            NormalVelocityProjection::new(surface, &band.mesh.cell).ok_or(RadiationError::Empty)?;
        let loads: Vec<Vec<f64>> = motions.iter().map(|motion| operator.of(motion.shape)).collect();
        let lone: Vec<LoneMotion<'_>> = wavenumbers
            .iter()
            .zip(&loads)
            .map(|(k, loads)| LoneMotion { wavenumber: *k, order: order(k * radius), loads })
            .collect();
        let count = motions.len() as f64;
        let mut on_progress = |done: f64| progress((done * count) as usize);
        let sums = solver.radiate_each(&lone, (radius, highest), &mut on_progress)?;
        let _ = progress(motions.len());
        Ok(sums
            .into_iter()
            .zip(wavenumbers)
            .map(|(mut sum, wavenumber)| {
                sum.iter_mut().for_each(|c| *c /= radius);
                trimmed(sum, wavenumber * radius)
            })
            .collect())
    }
}

impl ModalSolver for BemModalSolver {
    fn transfers(
        &self,
        surface: &ModalSurface,
        motions: &[ModalMotion<'_>],
        progress: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Vec<ModalTransfer>, RadiationError> {
        check(surface, motions)?;
        // Work in units of the bounding radius.
        let nodes = surface.nodes.iter().map(|x| *x / self.unit).collect();
        let surface = &ModalSurface { nodes, triangles: surface.triangles.clone() };
        let radius = surface.radius();
        let wavenumber = |motion: usize| motions[motion].wavenumber * self.unit;
        if self.effort == Effort::Draft {
            return self.draft_transfers(surface, motions, progress);
        }
        let mut transfers = vec![ModalTransfer { order: 0, coefficients: Vec::new() }; motions.len()];
        let mut before = 0;
        // Each band with its modes: solver, and loads of the normal velocities.
        let all: Vec<f64> = motions.iter().map(|motion| motion.wavenumber).collect();
        for (band, own) in self.bands.iter().zip(self.shares(&all)) {
            if own.is_empty() {
                continue;
            }
            let wavenumbers: Vec<f64> = own.iter().map(|i| wavenumber(*i)).collect();
            let rungs = rungs(&wavenumbers, self.spacing / radius);
            let highest = rungs.iter().map(|rung| rung.wavenumber).fold(0.0, f64::max);
            let solver = TriangleSolver::try_symmetric(&band.mesh, highest, Equation::BurtonMiller)?;
            let error = SWEEP_SHARE * self.accuracy;
            let solver = if rungs.len() >= MANY { solver.for_many_motions(highest, error) } else { solver };
            let mesh = band.mesh.whole().0;
            let operator = NormalVelocityProjection::new(surface, &mesh).ok_or(RadiationError::Empty)?;
            let loads: Vec<Vec<f64>> = own.iter().map(|i| operator.of(motions[*i].shape)).collect();
            let orders: Vec<usize> = wavenumbers.iter().map(|k| order(k * radius)).collect();
            let mut sums: Vec<Vec<Complex64>> =
                orders.iter().map(|n| vec![Complex64::ZERO; (n + 1) * (n + 1)]).collect();
            let most = orders.iter().copied().max().unwrap_or(0);
            let harmonics = solver.surface_harmonics(most, radius);
            let entries = solver.unknowns() * solver.unknowns() * band.mesh.images().len();
            let together = (MEMORY.saturating_sub(solver.table_bytes()) / (entries.max(1) * 8))
                .clamp(1, rayon::current_num_threads().max(1));
            // Assembly, factorisation and reciprocity, as many systems at once as fit in memory.
            for (round, batch) in rungs.chunks(together).enumerate() {
                if progress(before + own.len() * (round * together) / rungs.len()).is_break() {
                    return Err(RadiationError::Interrupted);
                }
                let solved: Result<Vec<_>, _> = batch
                    .par_iter()
                    .map(|rung| {
                        let highest = rung.uses.iter().map(|(i, _)| orders[*i]).max().unwrap_or(0);
                        let used: Vec<Vec<f64>> = rung.uses.iter().map(|(i, _)| loads[*i].clone()).collect();
                        solver.radiate(rung.wavenumber, highest, radius, &used, harmonics.as_ref())
                    })
                    .collect();
                // Interpolation in wavenumber.
                for (rung, solved) in batch.iter().zip(solved?) {
                    for ((i, [own, mirrored]), coefficients) in rung.uses.iter().zip(solved) {
                        for (sum, c) in sums[*i].iter_mut().zip(coefficients) {
                            *sum += own * c + mirrored * c.conj();
                        }
                    }
                }
            }
            before += own.len();
            // Normalise and truncate the multipoles.
            for (i, mut sum) in own.iter().zip(sums) {
                sum.iter_mut().for_each(|c| *c /= radius);
                transfers[*i] = trimmed(sum, wavenumber(*i) * radius);
            }
        }
        let _ = progress(motions.len());
        Ok(transfers)
    }

    fn seconds(&self, wavenumbers: &[f64]) -> f64 {
        let of_band = |(band, own): (&Band, Vec<usize>)| {
            let own: Vec<f64> = own.iter().map(|i| wavenumbers[*i] * self.unit).collect();
            let unknowns = band.mesh.cell.vertices.len();
            let parities = band.mesh.images().len();
            // Modes have few of the parities.
            let systems = [parities.min(4), parities];
            let operations = match self.effort {
                Effort::Exact if own.is_empty() => 0.0,
                Effort::Exact => {
                    operations::motions(unknowns, systems, rungs(&own, self.spacing).len() as f64)
                }
                Effort::Draft => own.len() as f64 * operations::solve(unknowns, systems),
            };
            operations / PER_SECOND
        };
        self.bands.iter().zip(self.shares(wavenumbers)).map(of_band).sum()
    }
}

/// The systems for modes of these wavenumbers: a ladder, or one for each mode if that is fewer.
fn rungs(wavenumbers: &[f64], spacing: f64) -> Vec<Rung> {
    let mut sorted: Vec<usize> = (0..wavenumbers.len()).collect();
    sorted.sort_by(|a, b| wavenumbers[*a].total_cmp(&wavenumbers[*b]));
    let direct: Vec<Rung> = sorted
        .chunk_by(|a, b| wavenumbers[*b] <= wavenumbers[*a] * (1.0 + TOGETHER))
        .map(|same| Rung {
            wavenumber: same.iter().map(|i| wavenumbers[*i]).sum::<f64>() / same.len() as f64,
            uses: same.iter().map(|i| (*i, [1.0, 0.0])).collect(),
        })
        .collect();
    let ladder = ladder(wavenumbers, spacing);
    if direct.len() <= ladder.len() { direct } else { ladder }
}

/// Systems at (j + ½) times the spacing, with Lagrange's weights of each mode in the nearest [`STENCIL`].
fn ladder(wavenumbers: &[f64], spacing: f64) -> Vec<Rung> {
    let mut rungs: Vec<Rung> = Vec::new();
    for (motion, k) in wavenumbers.iter().enumerate() {
        // Lagrange weights of the nearest nodes.
        let x = k / spacing - 0.5;
        let first = x.floor() as i64 - (STENCIL / 2) as i64 + 1;
        let nodes: Vec<i64> = (first..first + STENCIL as i64).collect();
        for node in &nodes {
            let others = nodes.iter().filter(|other| *other != node);
            let weight: f64 = others.map(|other| (x - *other as f64) / (node - other) as f64).product();
            // Negative wavenumbers are conjugates of their mirror image.
            let (place, side) = if *node < 0 { (-1 - node, 1) } else { (*node, 0) };
            let wavenumber = (place as f64 + 0.5) * spacing;
            let rung = match rungs.iter_mut().find(|rung| rung.wavenumber == wavenumber) {
                Some(rung) => rung,
                None => {
                    rungs.push(Rung { wavenumber, uses: Vec::new() });
                    let last = rungs.len() - 1;
                    &mut rungs[last]
                }
            };
            let of_motion = match rung.uses.iter_mut().find(|(i, _)| *i == motion) {
                Some(of_motion) => of_motion,
                None => {
                    rung.uses.push((motion, [0.0; 2]));
                    let last = rung.uses.len() - 1;
                    &mut rung.uses[last]
                }
            };
            of_motion.1[side] += weight;
        }
    }
    rungs.sort_by(|a, b| a.wavenumber.total_cmp(&b.wavenumber));
    rungs
}

/// Multipole order to compute.
pub(super) fn order(kappa: f64) -> usize {
    ((kappa + 4.0).ceil() as usize).clamp(10, MOST_ORDER)
}

/// A transfer without negligible highest orders.
pub(super) fn trimmed(mut coefficients: Vec<Complex64>, kappa: f64) -> ModalTransfer {
    let order = last_order(&[&coefficients], kappa);
    coefficients.truncate((order + 1) * (order + 1));
    ModalTransfer { order, coefficients }
}

/// Normals of the mirror planes of a surface that pass through the origin: an offset δ would shift the phase
/// by kδ. Images lie within a distance, or within another in the mean.
pub(super) fn centred_mirrors(
    surface: &TriMesh,
    mass: &MassProperties,
    [tolerance, mean]: [f64; 2],
    highest: f64,
) -> Vec<DVec3> {
    const SHIFT: f64 = 2e-3;
    if mass.centre_of_mass.length() * highest > SHIFT {
        return Vec::new();
    }
    mirror_planes_in_mean(surface, tolerance, mean).into_iter().map(|plane| plane.normal).collect()
}

/// A mesh without mirror planes.
fn whole(cell: TriMesh) -> SymmetricMesh {
    SymmetricMesh { cell, mirrors: BVec3::FALSE, frame: DMat3::IDENTITY }
}
