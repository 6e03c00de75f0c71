//! Radiation of the modes of axisymmetric bodies: each mode by its azimuthal orders.
//!
//! The normal motion of the surface is sampled on rings of the meridian and split:
//!
//! ```text
//! U·n (s, φ) = Σ_m C_m(s) cos mφ + S_m(s) sin mφ
//! ```
//!
//! A mode of a perfect body has one order m. For m > 0 it is one of a pair, C and S. Modes of a mesh have
//! small parts of other orders, which the body has not. Parts below a thousandth of the power are dropped;
//! otherwise a spurious m = 0 would radiate more than a high m that hardly radiates. Each C_m and S_m is a
//! field of [`azimuthal`](crate::bem::axisymmetric::azimuthal) waves. Modes of the same frequency and order
//! share the matrix.
//!
//! Panels resolve the waves in the air and those of the surface, whose mean square wavenumber is ∫ a'² r ds /
//! ∫ a² r ds. The part of order 0 is corrected to the volume flux of the whole surface (see
//! [`surface_motion`](super::surface_motion)).

mod harmonic_rotation;

use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::Arc;

use clangor_core::geometry::meridian::Meridian;
use clangor_core::math::spherical_harmonics::count;
use clangor_core::sound_model::modal::model::ModalTransfer;
use clangor_core::sound_model::modal::surface::ModalSurface;
use clangor_fourier::{Planner, RealToComplex};
use glam::{DMat3, DVec2, DVec3};
use num_complex::Complex64;
use rayon::prelude::*;

use self::harmonic_rotation::{HarmonicRotation, place};
use super::surface_motion::{MotionSampler, balance, volume_flux};
use super::truncation::last_order;
use super::{ModalMotion, ModalSolver, check};
use crate::bem::axisymmetric::azimuthal::{AzimuthalSolver, MeridianMesh, MeridianNode, RingWave};
use crate::bem::axisymmetric::{AxisymmetricOptions, AxisymmetricSolver};
use crate::cost::operations::PER_SECOND;
use crate::radiation::RadiationError;

/// Share of ∫ (U·n)² dS below which an order counts as an artefact of the mesh.
const LEAST_SHARE: f64 = 1e-3;

/// Ratio of ∫ (U·n)² dS of an order to ∫ |U|² dS below which it does not radiate: tangential motion acquires
/// a normal part on the flat faces of a mesh.
const LEAST_PUSH: f64 = 1e-7;

/// Relative difference below which wavenumbers count as equal.
const SAME: f64 = 1e-6;

/// Largest distance of the meridian from the surface, in bounding radii; beyond it they belong to different
/// bodies.
const FARTHEST: f64 = 0.05;

/// Samples around the axis per edge of the surface on the widest ring, and their limits.
const SAMPLES_PER_EDGE: f64 = 4.0;
const SAMPLES: [usize; 2] = [64, 512];

/// Operations of an average mode for each square of the unknowns at the highest wavenumber. Seen: 20 s of CPU
/// time for 68 modes of a wine glass with 1192 unknowns.
const EACH: f64 = 2000.0;

/// Operations of so many modes up to a wavenumber [1/m].
pub(crate) fn expected_operations(meridian: &Meridian, modes: f64, highest: f64) -> f64 {
    let settings = AxisymmetricOptions::new(highest);
    let unknowns = AxisymmetricSolver::new(meridian, DVec3::Z, settings).unknowns() as f64;
    EACH * unknowns * unknowns * modes
}

/// The solver of one axisymmetric body.
#[derive(Clone, Debug)]
pub struct AxisymmetricModalSolver {
    meridian: Meridian,
    /// Directions e₁, e₂ across the axis, from which φ is measured, and the axis.
    frame: DMat3,
    options: AxisymmetricOptions,
}

impl AxisymmetricModalSolver {
    /// For a meridian about the centre of mass (y = 0), rotated about `axis` through the origin.
    pub fn new(meridian: &Meridian, axis: DVec3) -> Self {
        let axis = axis.normalize();
        let first = axis.any_orthonormal_vector();
        let frame = DMat3::from_cols(first, axis.cross(first), axis);
        AxisymmetricModalSolver { meridian: meridian.clone(), frame, options: AxisymmetricOptions::new(0.0) }
    }

    /// With panels of different resolution. The highest wavenumber of the options is ignored.
    pub fn with_options(mut self, options: AxisymmetricOptions) -> Self {
        self.options = options;
        self
    }
}

/// Sampling points of normal motions: rings through the nodes of the finest panels that any mode may need.
struct Rings {
    mesh: MeridianMesh,
    /// 2π r ds of each node \[m²\].
    areas: Vec<f64>,
    sampler: MotionSampler,
    /// Outward normals at the samples, ring after ring.
    normals: Vec<DVec3>,
    fourier: Arc<dyn RealToComplex<f64>>,
}

/// C_m and S_m at the nodes, order by order.
type Parts = Vec<[Vec<f64>; 2]>;

/// Waves to solve: one order of the modes of one frequency.
struct Job {
    /// k [1/m] of the body's motion, and the wavenumber that the panels resolve.
    wavenumber: f64,
    fineness: f64,
    order: usize,
    parts: Vec<Part>,
}

/// C_m or S_m of a mode.
struct Part {
    mode: usize,
    is_sine: bool,
    /// At the nodes of the rings.
    motion: Vec<f64>,
}

/// Modes of the same frequency.
struct Cluster {
    wavenumber: f64,
    modes: Vec<usize>,
}

impl ModalSolver for AxisymmetricModalSolver {
    fn seconds(&self, wavenumbers: &[f64]) -> f64 {
        let highest = wavenumbers.iter().copied().fold(0.0, f64::max);
        expected_operations(&self.meridian, wavenumbers.len() as f64, highest) / PER_SECOND
    }

    fn transfers(
        &self,
        surface: &ModalSurface,
        motions: &[ModalMotion<'_>],
        progress: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Vec<ModalTransfer>, RadiationError> {
        check(surface, motions)?;
        if motions.is_empty() {
            return Ok(Vec::new());
        }
        let is_wave = |motion: &ModalMotion<'_>| motion.wavenumber >= 0.0 && motion.wavenumber.is_finite();
        if let Some(ModalMotion { wavenumber, .. }) = motions.iter().find(|motion| !is_wave(motion)) {
            return Err(RadiationError::NotFinite { wavenumber: *wavenumber });
        }
        // Sampling rings, fine enough for the highest wavenumber.
        let radius = surface.radius();
        let solver = AzimuthalSolver::new(&self.meridian, radius, self.options);
        let highest = motions.iter().map(|m| m.wavenumber).fold(0.0, f64::max);
        let rings = self.rings(&solver, surface, highest)?;
        // Azimuthal Fourier decomposition of all modes; finest panels first.
        let clusters = clusters(motions);
        let mut jobs: Vec<Job> =
            clusters.par_iter().flat_map_iter(|cluster| rings.jobs(cluster, motions)).collect();
        jobs.sort_by(|a, b| b.fineness.total_cmp(&a.fineness));
        let mut waiting = vec![0_usize; motions.len()];
        for part in jobs.iter().flat_map(|job| &job.parts) {
            waiting[part.mode] += 1;
        }
        let fluxes: Vec<f64> = motions.par_iter().map(|motion| volume_flux(surface, motion.shape)).collect();
        // Coefficients about the body's axis, up to the order of each mode.
        let mut about_axis: Vec<Vec<Complex64>> = motions.iter().map(|_| vec![Complex64::ZERO]).collect();
        let mut rest = jobs.as_slice();
        while let Some(finest) = rest.first() {
            let done = waiting.iter().filter(|left| **left == 0).count();
            if progress(done).is_break() {
                return Err(RadiationError::Interrupted);
            }
            // Mesh of the batch, and its normal accelerations with the exact volume flux.
            let mesh = solver.mesh(finest.fineness)?;
            let (batch, later) = rest.split_at(solver.batch(&mesh).min(rest.len()));
            rest = later;
            let areas: Vec<f64> = mesh.nodes().map(area).collect();
            let waves: Vec<RingWave> = batch
                .par_iter()
                .map(|job| {
                    let acceleration = |part: &Part| {
                        let mut values = rings.mesh.interpolate(&part.motion, &mesh);
                        if job.order == 0 {
                            balance(&mut values, &areas, fluxes[part.mode]);
                        }
                        values
                    };
                    RingWave {
                        wavenumber: job.wavenumber,
                        order: job.order,
                        accelerations: job.parts.iter().map(acceleration).collect(),
                    }
                })
                .collect();
            // Solve, and collect the coefficients of each mode.
            for (job, fields) in batch.iter().zip(solver.solve(&mesh, &waves)?) {
                for (part, field) in job.parts.iter().zip(fields) {
                    let own = &mut about_axis[part.mode];
                    if own.len() < count(field.coefficients.len() - 1) {
                        own.resize(count(field.coefficients.len() - 1), Complex64::ZERO);
                    }
                    for (n, c) in field.coefficients.iter().enumerate().skip(job.order) {
                        own[place(n, job.order, part.is_sine)] += c / radius;
                    }
                    waiting[part.mode] -= 1;
                }
            }
        }
        // Rotation from the body's axis to its frame.
        let transfers = self.rotated(about_axis, &clusters, radius);
        match progress(motions.len()) {
            ControlFlow::Continue(()) => Ok(transfers),
            ControlFlow::Break(()) => Err(RadiationError::Interrupted),
        }
    }
}

impl AxisymmetricModalSolver {
    /// Sampling rings for motions up to a wavenumber [1/m].
    fn rings(
        &self,
        solver: &AzimuthalSolver,
        surface: &ModalSurface,
        highest: f64,
    ) -> Result<Rings, RadiationError> {
        let edge = mean_edge(surface);
        // Two elements resolve at least half a wave.
        let mesh = solver.mesh(highest.max(TAU / (4.0 * edge)))?;
        let nodes: Vec<MeridianNode> = mesh.nodes().collect();
        // Angles around the axis, for the widest ring.
        let widest = nodes.iter().map(|n| n.position.x).fold(0.0, f64::max);
        let angles = ((SAMPLES_PER_EDGE * TAU * widest / edge) as usize)
            .clamp(SAMPLES[0], SAMPLES[1])
            .next_multiple_of(8);
        let turns: Vec<(f64, f64)> =
            (0..angles).map(|k| (TAU * k as f64 / angles as f64).sin_cos()).collect();
        // Positions on the rings, and the nearest points of the surface.
        let on_rings = |of: fn(&MeridianNode) -> DVec2| -> Vec<DVec3> {
            let at = |p: DVec2, (sin, cos): (f64, f64)| self.frame * DVec3::new(p.x * cos, p.x * sin, p.y);
            nodes.iter().flat_map(|node| turns.iter().map(move |turn| at(of(node), *turn))).collect()
        };
        let points = on_rings(|node| node.position);
        let sampler = MotionSampler::new(surface, &points).ok_or(RadiationError::Empty)?;
        let (distance, radius) = (sampler.farthest(), surface.radius());
        if distance > FARTHEST * radius {
            return Err(RadiationError::OffSurface { distance, radius });
        }
        Ok(Rings {
            areas: nodes.iter().map(|node| area(*node)).collect(),
            normals: on_rings(|node| node.normal),
            fourier: Planner::new().forward(angles),
            mesh,
            sampler,
        })
    }

    /// The coefficients in the frame of the body, up to the significant order.
    fn rotated(
        &self,
        about_axis: Vec<Vec<Complex64>>,
        clusters: &[Cluster],
        radius: f64,
    ) -> Vec<ModalTransfer> {
        let mut orders = vec![0; about_axis.len()];
        for cluster in clusters {
            let of: Vec<&[Complex64]> =
                cluster.modes.iter().map(|mode| about_axis[*mode].as_slice()).collect();
            let order = last_order(&of, cluster.wavenumber * radius);
            cluster.modes.iter().for_each(|mode| orders[*mode] = order);
        }
        let rotation = HarmonicRotation::new(self.frame, orders.iter().copied().max().unwrap_or(0));
        about_axis
            .into_par_iter()
            .zip(orders)
            .map(|(mut coefficients, order)| {
                coefficients.resize(count(order), Complex64::ZERO);
                ModalTransfer { order, coefficients: rotation.turn(&coefficients) }
            })
            .collect()
    }
}

/// 2π r ds.
fn area(node: MeridianNode) -> f64 {
    TAU * node.position.x * node.length
}

/// Mean length of the edges between corners \[m\].
fn mean_edge(surface: &ModalSurface) -> f64 {
    let at = |n: u32| surface.nodes[n as usize];
    let around = |t: &[u32; 6]| (0..3).map(|k| at(t[k]).distance(at(t[(k + 1) % 3]))).sum::<f64>() / 3.0;
    surface.triangles.iter().map(around).sum::<f64>() / surface.triangles.len() as f64
}

/// Groups modes of the same frequency.
fn clusters(motions: &[ModalMotion<'_>]) -> Vec<Cluster> {
    let mut ascending: Vec<usize> = (0..motions.len()).collect();
    ascending.sort_by(|a, b| motions[*a].wavenumber.total_cmp(&motions[*b].wavenumber));
    let near = |a: &usize, b: &usize| {
        motions[*b].wavenumber - motions[*a].wavenumber <= SAME * motions[*b].wavenumber
    };
    ascending
        .chunk_by(near)
        .map(|modes| {
            let sum: f64 = modes.iter().map(|mode| motions[*mode].wavenumber).sum();
            Cluster { wavenumber: sum / modes.len() as f64, modes: modes.to_vec() }
        })
        .collect()
}

impl Rings {
    /// The systems to solve for the modes of one frequency.
    ///
    /// Orders are chosen for all of them together, so that the result does not depend on the basis of a
    /// degenerate pair.
    fn jobs(&self, cluster: &Cluster, motions: &[ModalMotion<'_>]) -> Vec<Job> {
        let (squares, mut modes): (Vec<f64>, Vec<Parts>) =
            cluster.modes.iter().map(|mode| self.split(motions[*mode].shape)).unzip();
        // Power of each order, and the threshold.
        let square = |values: &[f64]| values.iter().zip(&self.areas).map(|(u, a)| u * u * a).sum::<f64>();
        let power = |m: usize| -> f64 {
            let turn = if m == 0 { 1.0 } else { 0.5 };
            modes.iter().flat_map(|parts| &parts[m]).map(|values| turn * square(values)).sum()
        };
        let powers: Vec<f64> = (0..self.orders()).map(power).collect();
        let least = (LEAST_SHARE * powers.iter().sum::<f64>()).max(LEAST_PUSH * squares.iter().sum::<f64>());
        let widest = self.mesh.nodes().map(|node| node.position.x).fold(0.0, f64::max);
        let kept = (0..powers.len()).filter(|m| powers[*m] > least);
        kept.map(|order| {
            let is_sine: &[bool] = if order == 0 { &[false] } else { &[false, true] };
            let mut parts = Vec::new();
            for (mode, own) in cluster.modes.iter().zip(&mut modes) {
                parts.extend(is_sine.iter().map(|is_sine| Part {
                    mode: *mode,
                    is_sine: *is_sine,
                    motion: std::mem::take(&mut own[order][usize::from(*is_sine)]),
                }));
            }
            // Panel resolution: wavenumber of the surface motion, of the air, and of the order.
            let slopes: f64 = parts.iter().map(|part| self.mesh.slope_square(&part.motion)).sum();
            let squares: f64 = parts.iter().map(|part| square(&part.motion)).sum();
            let bending = (TAU * slopes / squares).sqrt();
            let wavenumber = cluster.wavenumber;
            let fineness = wavenumber.max(bending).max(order as f64 / widest);
            Job { wavenumber, fineness, order, parts }
        })
        .collect()
    }

    /// ∫ |U|² dS, and the parts of U·n.
    fn split(&self, shape: &[DVec3]) -> (f64, Parts) {
        let angles = self.fourier.len();
        let (mut ring, mut spectrum) = (self.fourier.make_input_vec(), self.fourier.make_output_vec());
        let mut parts = vec![[vec![0.0; self.areas.len()], vec![0.0; self.areas.len()]]; self.orders()];
        let mut square = 0.0;
        let motions = self.sampler.motions(shape);
        let rings = motions.chunks_exact(angles).zip(self.normals.chunks_exact(angles));
        for (node, (motions, normals)) in rings.enumerate() {
            for ((u, n), value) in motions.iter().zip(normals).zip(&mut ring) {
                square += u.length_squared() * self.areas[node] / angles as f64;
                *value = u.dot(*n);
            }
            // The lengths match those of the plan.
            let done = self.fourier.process(&mut ring, &mut spectrum);
            debug_assert!(done.is_ok());
            for (m, (part, c)) in parts.iter_mut().zip(&spectrum).enumerate() {
                let factor = if m == 0 { 1.0 } else { 2.0 } / angles as f64;
                part[0][node] = factor * c.re;
                part[1][node] = -factor * c.im;
            }
        }
        (square, parts)
    }

    /// Orders from 0 that the samples resolve without aliasing.
    fn orders(&self) -> usize {
        self.fourier.len() / 4
    }
}
