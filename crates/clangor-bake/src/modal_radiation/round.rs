//! Ringing bodies of revolution: each mode by its orders around the axis.
//!
//! The normal motion of the surface is sampled on rings of the meridian and split:
//!
//! ```text
//! U·n (s, φ) = Σ_m C_m(s) cos mφ + S_m(s) sin mφ
//! ```
//!
//! A mode of a perfect body has one m, and comes in pairs, C and S, but for m = 0. Modes of a mesh have a little of other
//! orders, which the body has not; what is less than [`LEAST_SHARE`] of the power is left out, else a little of m = 0
//! would outshout a high m that hardly radiates. Each C_m and S_m is a field of
//! [`azimuthal`](crate::helmholtz::revolution::azimuthal) waves; modes of the same frequency and order share the matrix.
//!
//! Panels are fit for the air's waves and for those of the surface, whose mean square wavenumber is ∫ a'² r ds / ∫ a² r ds.
//! The part of order 0 is given the volume flux of the whole surface back (see [`surface_motion`](super::surface_motion)).

mod harmonic_rotation;

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use clangor::geometry::meridian::Meridian;
use clangor::model::modal_model::ModalTransfer;
use clangor::model::modal_surface::ModalSurface;
use clangor::model::spherical_harmonics::count;
use glam::{DMat3, DVec3};
use num_complex::Complex64;
use rayon::prelude::*;

use self::harmonic_rotation::{HarmonicRotation, place};
use super::surface_motion::{MotionSampler, balance, volume_flux};
use super::{ModalMotion, ModalSolver};
use crate::helmholtz::revolution::RevolutionOptions;
use crate::helmholtz::revolution::azimuthal::{AzimuthalSolver, MeridianMesh, MeridianNode, RingWave};
use crate::radiation::RadiationError;

/// Share of ∫ (U·n)² dS below which an order is taken for an accident of the mesh.
const LEAST_SHARE: f64 = 1e-3;

/// ∫ (U·n)² dS over ∫ |U|² dS below which nothing pushes the air.
const LEAST_PUSH: f64 = 1e-16;

/// Relative distance of wavenumbers that are the same.
const SAME: f64 = 1e-6;

/// Radiated power that may be dropped with the highest multipoles, as a part of all: an error of 1e-3 of the pressure. Two
/// orders more than 1e-4 takes.
const DROPPED_POWER: f64 = 1e-6;

/// Samples around the axis per edge of the surface on the widest ring, and their limits.
const SAMPLES_PER_EDGE: f64 = 4.0;
const SAMPLES: [usize; 2] = [64, 512];

/// The solver of one body of revolution.
#[derive(Clone, Debug)]
pub struct RoundSolver {
    meridian: Meridian,
    /// Directions e₁, e₂ across the axis, from which φ is counted, and the axis.
    frame: DMat3,
    options: RevolutionOptions,
}

impl RoundSolver {
    /// For a meridian whose y = 0 is the centre of mass, turned about `axis` through the origin.
    pub fn new(meridian: &Meridian, axis: DVec3) -> Self {
        let axis = axis.normalize();
        let first = axis.any_orthonormal_vector();
        let frame = DMat3::from_cols(first, axis.cross(first), axis);
        RoundSolver { meridian: meridian.clone(), frame, options: RevolutionOptions::new(0.0) }
    }

    /// With panels of another fineness; the highest wavenumber of the options is not used.
    pub fn with_options(mut self, options: RevolutionOptions) -> Self {
        self.options = options;
        self
    }
}

/// Normal motions of all modes, order by order.
struct OrderSamples {
    mesh: MeridianMesh,
    /// ∫ dS share of each node, without the angle: 2π r ds \[m²\].
    areas: Vec<f64>,
    /// C_m and S_m at the nodes for each mode and order.
    parts: Vec<Vec<[Vec<f64>; 2]>>,
    /// ∫ |U|² dS of each mode.
    squares: Vec<f64>,
}

/// Waves to be solved, and whose they are.
struct Job {
    /// k [1/m] of the body's motion, and what the panels are to resolve.
    wavenumber: f64,
    fineness: f64,
    order: usize,
    /// Mode and whether it is its sine part.
    parts: Vec<(usize, bool)>,
}

/// Modes of the same frequency.
struct Cluster {
    wavenumber: f64,
    modes: Vec<usize>,
}

impl ModalSolver for RoundSolver {
    fn transfers(
        &self,
        surface: &ModalSurface,
        motions: &[ModalMotion<'_>],
        progress: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Vec<ModalTransfer>, RadiationError> {
        let silent = || ModalTransfer { order: 0, coefficients: vec![Complex64::ZERO] };
        if motions.is_empty() || surface.triangles.is_empty() {
            return Ok(motions.iter().map(|_| silent()).collect());
        }
        let radius = surface.radius();
        let solver = AzimuthalSolver::new(&self.meridian, radius, self.options);
        let samples = self.samples(&solver, surface, motions)?;
        let clusters = clusters(motions);
        let mut jobs = jobs(&samples, &clusters);
        jobs.sort_by(|a, b| b.fineness.total_cmp(&a.fineness));
        let mut waiting = vec![0_usize; motions.len()];
        for (mode, _) in jobs.iter().flat_map(|job| &job.parts) {
            waiting[*mode] += 1;
        }
        let fluxes: Vec<f64> = motions.par_iter().map(|motion| volume_flux(surface, motion.shape)).collect();
        // About the axis of the body, with as many orders as each mode got.
        let mut about_axis: Vec<Vec<Complex64>> = motions.iter().map(|_| vec![Complex64::ZERO]).collect();
        let mut rest = jobs.as_slice();
        while let Some(finest) = rest.first() {
            let done = waiting.iter().filter(|left| **left == 0).count();
            if progress(done).is_break() {
                return Err(RadiationError::Interrupted);
            }
            let mesh = solver.mesh(finest.fineness)?;
            let (batch, later) = rest.split_at(solver.batch(&mesh).min(rest.len()));
            rest = later;
            let areas: Vec<f64> = mesh.nodes().map(area).collect();
            let waves: Vec<RingWave> = batch
                .par_iter()
                .map(|job| {
                    let acceleration = |(mode, is_sine): &(usize, bool)| {
                        let own = &samples.parts[*mode][job.order][usize::from(*is_sine)];
                        let mut values = samples.mesh.interpolate(own, &mesh);
                        if job.order == 0 {
                            balance(&mut values, &areas, fluxes[*mode]);
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
            for (job, fields) in batch.iter().zip(solver.solve(&mesh, &waves)?) {
                for ((mode, is_sine), field) in job.parts.iter().zip(fields) {
                    let own = &mut about_axis[*mode];
                    if own.len() < count(field.coefficients.len() - 1) {
                        own.resize(count(field.coefficients.len() - 1), Complex64::ZERO);
                    }
                    for (n, c) in field.coefficients.iter().enumerate().skip(job.order) {
                        own[place(n, job.order, *is_sine)] += c / radius;
                    }
                    waiting[*mode] -= 1;
                }
            }
        }
        let transfers = self.turned(about_axis, &clusters, radius);
        match progress(motions.len()) {
            ControlFlow::Continue(()) => Ok(transfers),
            ControlFlow::Break(()) => Err(RadiationError::Interrupted),
        }
    }
}

impl RoundSolver {
    /// Samples the motions on the finest panels that any mode may need, and splits them.
    fn samples(
        &self,
        solver: &AzimuthalSolver,
        surface: &ModalSurface,
        motions: &[ModalMotion<'_>],
    ) -> Result<OrderSamples, RadiationError> {
        let highest = motions.iter().map(|m| m.wavenumber).fold(0.0, f64::max);
        let edge = mean_edge(surface);
        // Two elements span half a wave or more.
        let mesh = solver.mesh(highest.max(TAU / (4.0 * edge)))?;
        let nodes: Vec<MeridianNode> = mesh.nodes().collect();
        let widest = nodes.iter().map(|n| n.position.x).fold(0.0, f64::max);
        let angles = ((SAMPLES_PER_EDGE * TAU * widest / edge) as usize)
            .clamp(SAMPLES[0], SAMPLES[1])
            .next_multiple_of(8);
        let turns: Vec<(f64, f64)> =
            (0..angles).map(|k| (TAU * k as f64 / angles as f64).sin_cos()).collect();
        let at = |p: glam::DVec2, (sin, cos): (f64, f64)| self.frame * DVec3::new(p.x * cos, p.x * sin, p.y);
        let on_rings = |of: &dyn Fn(&MeridianNode) -> glam::DVec2| -> Vec<DVec3> {
            nodes.iter().flat_map(|node| turns.iter().map(|turn| at(of(node), *turn))).collect()
        };
        let points = on_rings(&|node| node.position);
        let normals = on_rings(&|node| node.normal);
        let Some(sampler) = MotionSampler::new(surface, &points) else {
            return Err(RadiationError::NotFinite { wavenumber: highest });
        };
        let areas: Vec<f64> = nodes.iter().map(|node| area(*node)).collect();
        let orders = angles / 4;
        let share = |i: usize| areas[i / angles] / angles as f64;
        let split: Vec<(f64, Vec<[Vec<f64>; 2]>)> = motions
            .par_iter()
            .map(|motion| {
                let moved = sampler.motions(motion.shape);
                let square = moved.iter().enumerate().map(|(i, u)| u.length_squared() * share(i)).sum();
                let values: Vec<f64> = moved.iter().zip(&normals).map(|(u, n)| u.dot(*n)).collect();
                (square, split_orders(&values, &turns, orders))
            })
            .collect();
        let (squares, parts) = split.into_iter().unzip();
        Ok(OrderSamples { mesh, areas, parts, squares })
    }

    /// The coefficients in the axes of the body, with as many orders as radiate.
    fn turned(
        &self,
        about_axis: Vec<Vec<Complex64>>,
        clusters: &[Cluster],
        radius: f64,
    ) -> Vec<ModalTransfer> {
        let mut orders = vec![0; about_axis.len()];
        for cluster in clusters {
            let of: Vec<&[Complex64]> =
                cluster.modes.iter().map(|mode| about_axis[*mode].as_slice()).collect();
            let order = loudest_order(&of, cluster.wavenumber * radius);
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

/// C_m and S_m, m below `orders`, at each node from values at equal angles, which run fastest.
fn split_orders(values: &[f64], turns: &[(f64, f64)], orders: usize) -> Vec<[Vec<f64>; 2]> {
    let angles = turns.len();
    (0..orders)
        .map(|m| {
            let factor = if m == 0 { 1.0 } else { 2.0 } / angles as f64;
            let rings = values.chunks_exact(angles);
            rings
                .map(|ring| {
                    let sums = ring.iter().enumerate().fold((0.0, 0.0), |(c, s), (k, u)| {
                        let (sin, cos) = turns[(m * k) % angles];
                        (c + u * cos, s + u * sin)
                    });
                    (factor * sums.0, factor * sums.1)
                })
                .unzip()
        })
        .map(|(cosine, sine): (Vec<f64>, Vec<f64>)| [cosine, sine])
        .collect()
}

/// Modes of the same frequency together.
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

/// What has to be solved.
///
/// Orders are chosen for all modes of a frequency together, so that it does not matter which of a degenerate pair's many
/// bases it is.
fn jobs(samples: &OrderSamples, clusters: &[Cluster]) -> Vec<Job> {
    let widest = samples.mesh.nodes().map(|node| node.position.x).fold(0.0, f64::max);
    let of_cluster = |cluster: &Cluster| -> Vec<Job> {
        let orders = samples.parts[cluster.modes[0]].len();
        let power = |m: usize| -> f64 {
            let turn = if m == 0 { 1.0 } else { 0.5 };
            let own = cluster.modes.iter().flat_map(|mode| &samples.parts[*mode][m]);
            own.map(|values| {
                values.iter().zip(&samples.areas).map(|(u, area)| turn * u * u * area).sum::<f64>()
            })
            .sum()
        };
        let powers: Vec<f64> = (0..orders).map(power).collect();
        let moved: f64 = cluster.modes.iter().map(|mode| samples.squares[*mode]).sum();
        let least = (LEAST_SHARE * powers.iter().sum::<f64>()).max(LEAST_PUSH * moved);
        (0..orders)
            .filter(|m| powers[*m] > least)
            .map(|order| {
                let is_sine: &[bool] = if order == 0 { &[false] } else { &[false, true] };
                let parts: Vec<(usize, bool)> =
                    cluster.modes.iter().flat_map(|mode| is_sine.iter().map(|s| (*mode, *s))).collect();
                let own = |(mode, is_sine): &(usize, bool)| {
                    samples.parts[*mode][order][usize::from(*is_sine)].as_slice()
                };
                let slopes: f64 = parts.iter().map(|part| samples.mesh.slope_square(own(part))).sum();
                let squares: f64 = parts
                    .iter()
                    .flat_map(|part| own(part).iter().zip(&samples.areas))
                    .map(|(u, area)| u * u * area / TAU)
                    .sum();
                let bending = (slopes / squares).sqrt();
                let wavenumber = cluster.wavenumber;
                let fineness = wavenumber.max(bending).max(order as f64 / widest);
                Job { wavenumber, fineness, order, parts }
            })
            .collect()
    };
    clusters.par_iter().flat_map_iter(of_cluster).collect()
}

/// The smallest order above which next to no power is radiated, by all of some modes together.
fn loudest_order(modes: &[&[Complex64]], wavenumber: f64) -> usize {
    let order = modes.iter().map(|c| (c.len() as f64).sqrt().round() as usize - 1).max().unwrap_or(0);
    // The power of one n: that of a transfer that has no other.
    let power = |n: usize| -> f64 {
        let of_mode = |mode: &&[Complex64]| {
            let mut coefficients = vec![Complex64::ZERO; count(n)];
            let own = n * n..count(n).min(mode.len());
            if own.start < own.end {
                coefficients[own.clone()].copy_from_slice(&mode[own]);
            }
            ModalTransfer { order: n, coefficients }.power(wavenumber)
        };
        modes.iter().map(of_mode).sum()
    };
    let powers: Vec<f64> = (0..=order).map(power).collect();
    let most = DROPPED_POWER * powers.iter().sum::<f64>();
    let mut dropped = 0.0;
    let is_dropped = |power: &&f64| {
        dropped += **power;
        dropped < most || (most == 0.0 && dropped == 0.0)
    };
    order.saturating_sub(powers.iter().rev().take_while(is_dropped).count())
}
