//! Boundary elements on the meridian: the field of an axisymmetric body.
//!
//! Around the axis the pressure of a rigid motion is p₀(s) or p₁(s) cos φ. That of a mode is a sum of p_m(s)
//! cos mφ and p_m(s) sin mφ. The integral equation for the pressure on the surface,
//!
//! ```text
//! ½ p(x) − ∫ p ∂G/∂n' dS' = ∫ a_n G dS',    G = e^{−ikρ}/(4πρ)
//! ```
//!
//! then separates into one equation over the meridian for each order m: m = 0 for translation along the axis;
//! m = 1 for translation across it and rotation about an axis across it (here); any m for modes
//! ([`azimuthal`]). Rotation about the axis itself moves no fluid. The directions cos mφ and sin mφ share one
//! solution.
//!
//! Collocation at the Gauss–Legendre nodes of panels graded towards edges (`panels`). Kernels are integrated
//! around the axis to ten digits at any distance (`ring`), singular and nearly singular integrals by graded
//! rules (`rows`). Solving order by order with kernels from elliptic integrals follows Young, Hao and
//! Martinsson, J. Comput. Phys. 231 (2012); product weights that hold for all frequencies replace their
//! convolutions.
//!
//! The equation has no unique solution at the resonances of the interior with p = 0 on its surface. The
//! lowest is no lower than about π/2 over the largest inscribed radius ρ (exactly so for convex bodies:
//! Hersch, Z. Angew. Math. Phys. 11, 1960). Bands that stay below are solved on the real axis. Others are
//! solved at k − 0.05i/R, where the equation is well-conditioned, and the sample records that. A mode is
//! solved at its real frequency, with additional points inside the body where the pressure must vanish.

mod axisymmetric_surface;
pub mod azimuthal;
mod inside;
mod lanes;
mod multipoles;
mod panels;
mod ring;
mod rows;

use std::f64::consts::TAU;
use std::ops::Range;

use clangor_core::geometry::meridian::Meridian;
use clangor_core::geometry::tri_mesh::TriMesh;
use faer::Mat;
use faer::linalg::solvers::Solve;
use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;

use self::inside::inscribed_radius;
use self::multipoles::{AxisProjection, AxisTurn, MOTIONS, motion};
use self::panels::Panels;
use self::ring::MidpointLadder;
use self::rows::{Observer, Row, RowContext, Wave};
use crate::radiation::{RadiationError, RadiationSample, RadiationSolver};
use axisymmetric_surface::AxisymmetricSurface;

/// Imaginary part of −kR for bands that contain resonances of the interior.
const DAMPING: f64 = 0.05;

/// Longest edge of the surface mesh, in bounding radii.
const COARSEST_SURFACE: f64 = 0.12;

/// Most unknowns of one order.
pub(crate) const MOST_UNKNOWNS: usize = 6000;

/// Most memory \[byte\] of the matrices of one batch of frequencies.
const BATCH_MEMORY: usize = 300 << 20;

/// Resolution of the solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisymmetricOptions {
    /// Highest requested wavenumber [1/m].
    pub max_wavenumber: f64,
    /// Nodes on a panel: a multiple of 8.
    pub nodes_per_panel: usize,
    /// Nodes on the shortest wave.
    pub nodes_per_wavelength: f64,
    /// Number of times a panel at an edge is halved.
    pub edge_levels: u32,
}

impl AxisymmetricOptions {
    /// Settings for an accuracy of about 1e-5 or better, up to this wavenumber [1/m].
    pub fn new(max_wavenumber: f64) -> Self {
        AxisymmetricOptions { max_wavenumber, nodes_per_panel: 8, nodes_per_wavelength: 8.0, edge_levels: 4 }
    }
}

/// The solver of one axisymmetric body.
#[derive(Debug)]
pub struct AxisymmetricSolver {
    meridian: Meridian,
    axis: DVec3,
    radius: f64,
    options: AxisymmetricOptions,
    /// Imaginary part of k [1/m], zero or negative.
    damping: f64,
    surface: Option<AxisymmetricSurface>,
}

impl AxisymmetricSolver {
    /// For a meridian about the centre of mass (y = 0), rotated about `axis` through the origin.
    pub fn new(meridian: &Meridian, axis: DVec3, options: AxisymmetricOptions) -> Self {
        let radius = meridian.bounding_radius();
        let resonance = inside::first_resonance(inscribed_radius(meridian));
        let damping = if options.max_wavenumber < resonance { 0.0 } else { -DAMPING / radius };
        let axis = axis.normalize();
        AxisymmetricSolver { meridian: meridian.clone(), axis, radius, options, damping, surface: None }
    }

    /// The same, with surface pressures on a mesh of `per_wavelength` edges on the shortest wave.
    pub fn with_surface(mut self, per_wavelength: f64) -> Self {
        let wave = TAU / self.options.max_wavenumber;
        let edge = (wave / per_wavelength).min(COARSEST_SURFACE * self.radius);
        self.surface = Some(AxisymmetricSurface::new(&self.meridian, self.axis, edge));
        self
    }

    /// Unknowns of each order at the highest wavenumber.
    pub fn unknowns(&self) -> usize {
        Panels::new(&self.meridian, self.options.max_wavenumber, &self.options).nodes.len()
    }

    /// Whether wavenumbers are shifted off the real axis.
    pub fn is_damped(&self) -> bool {
        self.damping != 0.0
    }

    /// Solves wavenumbers in ascending order on panels that resolve the last of them.
    fn solve_batch(
        &self,
        panels: &Panels,
        wavenumbers: &[f64],
        order: usize,
    ) -> Result<Vec<RadiationSample>, RadiationError> {
        // One wave per frequency: orders 0 and 1, with the right-hand sides of the three motions.
        let waves: Vec<Wave<2>> = wavenumbers
            .iter()
            .map(|k| Wave {
                wavenumber: Complex64::new(*k, self.damping),
                orders: [0, 1],
                sources: [vec![0], vec![1, 2]],
            })
            .collect();
        let accelerations: Vec<Vec<f64>> = (0..MOTIONS)
            .map(|i| panels.nodes.iter().map(|n| motion(n.position, n.normal.normalize())[i]).collect())
            .collect();
        // Quadrature around the axis, shared by all rows.
        let highest = wavenumbers.last().copied().unwrap_or(0.0);
        let ladder = MidpointLadder::new(highest * panels.widest(), 1);
        let context = RowContext::new(panels, &ladder, &waves, &accelerations);
        // Assembly, one row per collocation point.
        let rows: Vec<Row> = panels.nodes.par_iter().map(|node| context.row(Observer::node(node))).collect();
        // Projection onto multipoles about the body's axis, and rotation to the body's frame.
        let projections = [0, 1].map(|m| AxisProjection::new(panels, self.radius, m, order));
        let turn = AxisTurn::new(self.axis, order);
        (0..waves.len())
            .into_par_iter()
            .map(|f| {
                let wavenumber = waves[f].wavenumber;
                // Dense solve of both orders.
                let (along, across) =
                    (solve_system::<2>(&rows, f, 0, 0..1), solve_system::<2>(&rows, f, 1, 1..3));
                let pressure: [Vec<Complex64>; MOTIONS] =
                    std::array::from_fn(|i| if i == 0 { along[0].clone() } else { across[i - 1].clone() });
                // Multipoles of the six motions.
                let about_axis = std::array::from_fn(|i| {
                    projections[i.min(1)].coefficients(&pressure[i], &accelerations[i], wavenumber)
                });
                let coefficients = turn.coefficients(&about_axis);
                // Surface pressures for listeners in the near field.
                let surface_pressure = self
                    .surface
                    .as_ref()
                    .map_or_else(Vec::new, |s| s.pressures(panels, self.axis, &pressure));
                let finite = coefficients.iter().flatten().all(|c| c.is_finite());
                if !finite {
                    return Err(RadiationError::NotFinite { wavenumber: wavenumbers[f] });
                }
                Ok(RadiationSample { wavenumber, coefficients, surface_pressure })
            })
            .collect()
    }
}

impl RadiationSolver for AxisymmetricSolver {
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

/// The equations of one order (by index) of a wave of a batch, as assembled for nodes: ½ p on the diagonal.
fn system_matrix<const M: usize>(rows: &[Row], wave: usize, order: usize) -> Mat<Complex64> {
    let nodes = rows.len();
    let start = (M * wave + order) * nodes;
    Mat::from_fn(nodes, nodes, |i, j| {
        let diagonal = if i == j { 0.5 } else { 0.0 };
        Complex64::new(diagonal - rows[i].real[start + j], -rows[i].imaginary[start + j])
    })
}

/// Pressures at the nodes for the right-hand sides `range` of one order of a wave of a batch.
fn solve_system<const M: usize>(
    rows: &[Row],
    wave: usize,
    order: usize,
    sources: Range<usize>,
) -> Vec<Vec<Complex64>> {
    let rhs = Mat::from_fn(rows.len(), sources.len(), |i, j| rows[i].rhs[wave][sources.start + j]);
    let solution = system_matrix::<M>(rows, wave, order).partial_piv_lu().solve(&rhs);
    (0..sources.len()).map(|j| (0..rows.len()).map(|i| solution[(i, j)]).collect()).collect()
}
