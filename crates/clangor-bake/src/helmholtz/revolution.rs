//! Boundary elements on the meridian: the field of a body of revolution.
//!
//! Around the axis the pressure of a rigid motion is p₀(s) or p₁(s) cos φ, so that the integral equation for the pressure
//! on the surface
//!
//! ```text
//! ½ p(x) − ∫ p ∂G/∂n' dS' = ∫ a_n G dS',    G = e^{−ikρ}/(4πρ)
//! ```
//!
//! is one over the meridian for each of the orders 0 (moving along the axis) and 1 (moving across it, turning about an
//! axis across it). Turning about the axis itself moves no fluid. The two directions across are one solution.
//!
//! Collocation at the Gauss–Legendre nodes of panels graded towards edges (`panels`), kernels integrated around the axis
//! to ten digits at any distance (`ring`), singular and nearly singular integrals by graded rules (`rows`). The idea of
//! solving order by order with kernels from elliptic integrals is in Young, Hao and Martinsson, J. Comput. Phys. 231
//! (2012); product weights that hold for all frequencies stand here in place of their convolutions.
//!
//! The equation has no unique solution at the resonances of an interior with p = 0 on its surface. The lowest is no
//! lower than about π/2 over the largest inscribed radius ρ (exactly so for convex bodies: Hersch, Z. Angew. Math. Phys.
//! 11, 1960). Bands that stay below are solved on the real axis. Others at k − 0.05i/R, where the equation
//! is well-conditioned, and the sample says so.

mod lanes;
mod multipoles;
mod panels;
mod ring;
mod rows;
mod turned;

use std::f64::consts::{FRAC_PI_2, TAU};

use clangor::geometry::meridian::Meridian;
use clangor::geometry::tri_mesh::TriMesh;
use faer::Mat;
use faer::linalg::solvers::Solve;
use glam::{DVec2, DVec3};
use num_complex::Complex64;
use rayon::prelude::*;

use self::multipoles::{AxisProjection, AxisTurn};
use self::panels::Panels;
use self::ring::MidpointLadder;
use self::rows::{MOTIONS, Row, RowContext};
use self::turned::TurnedSurface;
use crate::radiation::{RadiationError, RadiationSample, RadiationSolver};

/// Imaginary part of −kR where the band holds resonances of the interior.
const DAMPING: f64 = 0.05;

/// Part of π/(2ρ) below which there are none.
const RESONANCE_MARGIN: f64 = 0.9;

/// Longest edge of the surface mesh, in bounding radii.
const COARSEST_SURFACE: f64 = 0.12;

/// Most unknowns of one order.
const MOST_UNKNOWNS: usize = 6000;

/// Most memory \[byte\] of the matrices of one batch of frequencies.
const BATCH_MEMORY: usize = 300 << 20;

/// How fine to solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RevolutionOptions {
    /// Highest wavenumber [1/m] that will be asked for.
    pub max_wavenumber: f64,
    /// Nodes on a panel: a multiple of 8.
    pub nodes_per_panel: usize,
    /// Nodes on the shortest wave.
    pub nodes_per_wavelength: f64,
    /// How often a panel at an edge is halved.
    pub edge_levels: u32,
}

impl RevolutionOptions {
    /// Fit for an accuracy of about 1e-5 and better, up to this wavenumber [1/m].
    pub fn new(max_wavenumber: f64) -> Self {
        RevolutionOptions { max_wavenumber, nodes_per_panel: 8, nodes_per_wavelength: 8.0, edge_levels: 4 }
    }
}

/// The solver of one body of revolution.
#[derive(Debug)]
pub struct RevolutionSolver {
    meridian: Meridian,
    axis: DVec3,
    radius: f64,
    options: RevolutionOptions,
    /// Imaginary part of k [1/m], zero or negative.
    damping: f64,
    surface: Option<TurnedSurface>,
}

impl RevolutionSolver {
    /// For a meridian whose y = 0 is the centre of mass, turned about `axis` through the origin.
    pub fn new(meridian: &Meridian, axis: DVec3, options: RevolutionOptions) -> Self {
        let radius = meridian.bounding_radius();
        let resonance = RESONANCE_MARGIN * FRAC_PI_2 / inscribed_radius(meridian);
        let damping = if options.max_wavenumber < resonance { 0.0 } else { -DAMPING / radius };
        let axis = axis.normalize();
        RevolutionSolver { meridian: meridian.clone(), axis, radius, options, damping, surface: None }
    }

    /// The same, with surface pressures on a mesh of `per_wavelength` edges on the shortest wave.
    pub fn with_surface(mut self, per_wavelength: f64) -> Self {
        let wave = TAU / self.options.max_wavenumber;
        let edge = (wave / per_wavelength).min(COARSEST_SURFACE * self.radius);
        self.surface = Some(TurnedSurface::new(&self.meridian, self.axis, edge));
        self
    }

    /// Unknowns of each order at the highest wavenumber.
    pub fn unknowns(&self) -> usize {
        Panels::new(&self.meridian, self.options.max_wavenumber, &self.options).nodes.len()
    }

    /// Whether wavenumbers are moved off the real axis.
    pub fn is_damped(&self) -> bool {
        self.damping != 0.0
    }

    /// Solves wavenumbers in ascending order on panels fit for the last of them.
    fn solve_batch(
        &self,
        panels: &Panels,
        wavenumbers: &[f64],
        order: usize,
    ) -> Result<Vec<RadiationSample>, RadiationError> {
        let nodes = panels.nodes.len();
        let complex: Vec<Complex64> = wavenumbers.iter().map(|k| Complex64::new(*k, self.damping)).collect();
        let highest = wavenumbers.last().copied().unwrap_or(0.0);
        let widest = panels.nodes.iter().map(|n| n.position.x).fold(0.0, f64::max);
        let ladder = MidpointLadder::new(highest * widest);
        let context = RowContext::new(panels, &ladder, &complex);
        let rows: Vec<Row> = (0..nodes).into_par_iter().map(|i| context.row(i)).collect();
        let projection = AxisProjection::new(panels, self.radius, order);
        let turn = AxisTurn::new(self.axis, order);
        (0..complex.len())
            .into_par_iter()
            .map(|f| {
                let pressure = solve_system(&rows, f);
                let coefficients = turn.coefficients(&projection.coefficients(&pressure, complex[f]));
                let surface_pressure = self
                    .surface
                    .as_ref()
                    .map_or_else(Vec::new, |s| s.pressures(panels, self.axis, &pressure));
                let finite = coefficients.iter().flatten().all(|c| c.is_finite());
                if !finite {
                    return Err(RadiationError::NotFinite { wavenumber: wavenumbers[f] });
                }
                Ok(RadiationSample { wavenumber: complex[f], coefficients, surface_pressure })
            })
            .collect()
    }
}

impl RadiationSolver for RevolutionSolver {
    fn solve(&self, wavenumbers: &[f64], order: usize) -> Result<Vec<RadiationSample>, RadiationError> {
        let mut ascending: Vec<usize> = (0..wavenumbers.len()).collect();
        ascending.sort_by(|a, b| wavenumbers[*a].total_cmp(&wavenumbers[*b]));
        let mut samples: Vec<Option<RadiationSample>> = vec![None; wavenumbers.len()];
        let mut rest = ascending.as_slice();
        while let Some(last) = rest.last() {
            let highest = wavenumbers[*last];
            let panels = Panels::new(&self.meridian, highest, &self.options);
            let unknowns = panels.nodes.len();
            if unknowns > MOST_UNKNOWNS {
                return Err(RadiationError::TooLarge { unknowns, most: MOST_UNKNOWNS, wavenumber: highest });
            }
            let matrix = 2 * unknowns * unknowns * size_of::<Complex64>();
            let batch = (BATCH_MEMORY / matrix).clamp(1, 16).min(rest.len());
            let (before, chosen) = rest.split_at(rest.len() - batch);
            let chosen_wavenumbers: Vec<f64> = chosen.iter().map(|i| wavenumbers[*i]).collect();
            for (i, sample) in chosen.iter().zip(self.solve_batch(&panels, &chosen_wavenumbers, order)?) {
                samples[*i] = Some(sample);
            }
            rest = before;
        }
        Ok(samples.into_iter().flatten().collect())
    }

    fn reference_radius(&self) -> f64 {
        self.radius
    }

    fn surface(&self) -> Option<&TriMesh> {
        self.surface.as_ref().map(|s| &s.mesh)
    }
}

/// Pressures of the three motions at the nodes, for one wavenumber of a batch.
fn solve_system(rows: &[Row], f: usize) -> [Vec<Complex64>; MOTIONS] {
    let nodes = rows.len();
    let solve = |m: usize, motions: &[usize]| {
        let start = (2 * f + m) * nodes;
        let matrix = Mat::from_fn(nodes, nodes, |i, j| {
            let diagonal = if i == j { 0.5 } else { 0.0 };
            Complex64::new(diagonal - rows[i].real[start + j], -rows[i].imaginary[start + j])
        });
        let rhs = Mat::from_fn(nodes, motions.len(), |i, j| rows[i].rhs[f][motions[j]]);
        let solution = matrix.partial_piv_lu().solve(&rhs);
        move |j: usize| (0..nodes).map(|i| solution[(i, j)]).collect::<Vec<_>>()
    };
    let (along, across) = (solve(0, &[0]), solve(1, &[1, 2]));
    [along(0), across(0), across(1)]
}

/// Radius \[m\] of the largest ball inside that touches the surface at one of many points.
///
/// The ball that touches at x with outward normal n and passes through q has the radius |q − x|²/(2 n·(x − q)).
fn inscribed_radius(meridian: &Meridian) -> f64 {
    const PARTS: usize = 96;
    let mut points: Vec<(DVec2, DVec2)> = Vec::new();
    for piece in meridian.pieces() {
        points.extend((0..PARTS).map(|k| {
            let t = (k as f64 + 0.5) / PARTS as f64;
            let v = piece.velocity(t).normalize();
            (piece.point(t), DVec2::new(v.y, -v.x))
        }));
    }
    let radius_at = |(x, n): (DVec2, DVec2)| {
        points
            .iter()
            .flat_map(|(q, _)| [*q, DVec2::new(-q.x, q.y)])
            .map(|q| (q - x, n.dot(x - q)))
            .filter(|(gap, depth)| *depth > 1e-9 * gap.length())
            .map(|(gap, depth)| 0.5 * gap.length_squared() / depth)
            .fold(f64::INFINITY, f64::min)
    };
    points.iter().map(|p| radius_at(*p)).filter(|r| r.is_finite()).fold(0.0, f64::max)
}
