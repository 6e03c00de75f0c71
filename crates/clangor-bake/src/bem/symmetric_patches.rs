//! Boundary elements of high order for bodies symmetric about the three coordinate planes: spheres,
//! ellipsoids, boxes and dice.
//!
//! The exterior Neumann problem as the direct boundary integral equation, n pointing into the fluid, ρ = 1,
//!
//! ```text
//! p(x)/2 − ∫ p ∂G/∂n_y dS = ∫ G a_n dS,    G = e^{−ikr}/(4πr)
//! ```
//!
//! collocated at the Gauss–Legendre nodes of curved patches; the density is the polynomial through the nodes.
//! The body is one octant and its images. Each of the six rigid motions is one parity class, an eighth as
//! large as the whole. Eight wavenumbers share the geometry of a pass.
//!
//! The equation alone is singular at the resonances of the interior. They lie on the real axis. The solver
//! stays off it, at Im k < 0: this is the field of a motion that grows as e^{σt}, and a smooth function of k.
//! The remaining error near a resonance is that of the quadrature times the distance over which the resonance
//! acts, which is negligible for patches of high order. A combined equation would double the work.
//!
//! Errors fall with a high power of the number of nodes where the surface is smooth. At sharp edges they fall
//! with that of the layers of patches that shrink towards the edge.

mod chart;
mod discretisation;
mod kernel;
mod lagrange;
mod layout;
mod row;
mod surface;
mod symmetry;

use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::math::spherical_harmonics::index;
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use faer::prelude::Solve;
use faer::{Mat, MatRef};
use glam::DVec3;
use num_complex::Complex64;
use pulp::{Simd, WithSimd};
use rayon::prelude::*;

use self::chart::Patch;
use self::discretisation::{Discretisation, Rules};
use self::kernel::Wavenumbers;
use self::layout::Resolution;
use self::row::RowBuilder;
use self::surface::Surface;
use self::symmetry::{IMAGES, allows, sums_by_motion};
use crate::fitting::multipole_projection::project;
use crate::radiation::{RadiationError, RadiationSample, RadiationSolver};

/// Most unknowns of a class.
pub(crate) const MOST_UNKNOWNS: usize = 1600;
/// Distance −Im kR from the real axis at which resonances of the interior are negligible.
const GROWTH: f64 = 0.25;
/// No resonance of the interior is below kR = π, that of a ball of the bounding radius. Towards k = 0 the
/// real axis is safe.
const FIRST_RESONANCE: f64 = 2.5;

/// Solver for a body of three mirror planes.
pub struct SymmetricPatchSolver {
    /// Bounding radius R \[m\]; all else is in units of R.
    radius: f64,
    body: Discretisation,
    surface: Option<Surface>,
}

impl SymmetricPatchSolver {
    /// An ellipsoid with these semi-axes \[m\], up to a wavenumber [1/m], for errors of the order of
    /// `accuracy`.
    ///
    /// # Errors
    /// [`RadiationError::TooLarge`] for more unknowns than fit.
    pub fn ellipsoid(semi_axes: DVec3, max_wavenumber: f64, accuracy: f64) -> Result<Self, RadiationError> {
        let radius = semi_axes.max_element();
        let resolution = resolution(max_wavenumber * radius, accuracy, false);
        Self::try_new(radius, layout::ellipsoid(semi_axes / radius, &resolution), max_wavenumber, accuracy)
    }

    /// A box with full `edges` \[m\], edges and corners rounded by `round` \[m\]; 0 for sharp edges.
    ///
    /// # Errors
    /// [`RadiationError::TooLarge`] for more unknowns than fit.
    pub fn rounded_box(
        edges: DVec3,
        round: f64,
        max_wavenumber: f64,
        accuracy: f64,
    ) -> Result<Self, RadiationError> {
        let round = round.min(0.5 * edges.min_element());
        let radius = (0.5 * edges - round).length() + round;
        let resolution = resolution(max_wavenumber * radius, accuracy, true);
        let patches = layout::rounded_box(edges / radius, round / radius, &resolution);
        Self::try_new(radius, patches, max_wavenumber, accuracy)
    }

    /// Unknowns of [`ellipsoid`](Self::ellipsoid).
    pub(crate) fn ellipsoid_unknowns(semi_axes: DVec3, max_wavenumber: f64, accuracy: f64) -> usize {
        let radius = semi_axes.max_element();
        let resolution = resolution(max_wavenumber * radius, accuracy, false);
        unknowns(&layout::ellipsoid(semi_axes / radius, &resolution))
    }

    /// Unknowns of [`rounded_box`](Self::rounded_box).
    pub(crate) fn rounded_box_unknowns(
        edges: DVec3,
        round: f64,
        max_wavenumber: f64,
        accuracy: f64,
    ) -> usize {
        let round = round.min(0.5 * edges.min_element());
        let radius = (0.5 * edges - round).length() + round;
        let resolution = resolution(max_wavenumber * radius, accuracy, true);
        unknowns(&layout::rounded_box(edges / radius, round / radius, &resolution))
    }

    fn try_new(
        radius: f64,
        patches: Vec<Patch>,
        max_wavenumber: f64,
        accuracy: f64,
    ) -> Result<Self, RadiationError> {
        let unknowns = unknowns(&patches);
        if unknowns > MOST_UNKNOWNS {
            return Err(RadiationError::TooLarge {
                unknowns,
                most: MOST_UNKNOWNS,
                wavenumber: max_wavenumber,
            });
        }
        let surface = Some(Surface::new(&patches, radius));
        Ok(SymmetricPatchSolver { radius, body: Discretisation::new(patches, Rules::new(accuracy)), surface })
    }

    /// Unknowns of each of the six systems.
    pub fn unknowns(&self) -> usize {
        self.body.nodes.len()
    }

    /// Pressures of the six motions at the nodes of the octant, for each of at most F values of s = ik.
    fn pass<const F: usize>(
        &self,
        s: &[Complex64],
    ) -> Result<Vec<Vec<[Complex64; RIGID_DOFS]>>, RadiationError> {
        let unknowns = self.unknowns();
        let at = |f: usize| s[f.min(s.len() - 1)];
        let wavenumbers = Wavenumbers {
            growth: std::array::from_fn(|f| at(f).re),
            wave: std::array::from_fn(|f| at(f).im),
        };
        // Assembly: one row per node, for all wavenumbers and motions.
        let arch = pulp::Arch::new();
        let rows: Vec<Row> = (0..unknowns)
            .into_par_iter()
            .map_init(
                || RowBuilder::<F>::new(unknowns),
                |builder, row| {
                    arch.dispatch(RowTask {
                        builder,
                        body: &self.body,
                        row,
                        wavenumbers: &wavenumbers,
                        used: s.len(),
                    })
                },
            )
            .collect();
        // Dense LU solve of each wavenumber and motion.
        let solutions: Vec<Vec<Complex64>> = (0..s.len() * RIGID_DOFS)
            .into_par_iter()
            .map(|system| {
                let matrix = Mat::from_fn(unknowns, unknowns, |i, j| rows[i].matrix[system * unknowns + j]);
                let right: Vec<Complex64> = rows.iter().map(|row| row.right[system]).collect();
                let right = MatRef::from_column_major_slice(&right, unknowns, 1);
                let solution = matrix.partial_piv_lu().solve(right);
                solution.col(0).iter().copied().collect()
            })
            .collect();
        // Pressures by frequency, node and motion.
        let samples = (0..s.len()).map(|f| {
            let pressure: Vec<[Complex64; RIGID_DOFS]> = (0..unknowns)
                .map(|node| std::array::from_fn(|degree| solutions[f * RIGID_DOFS + degree][node]))
                .collect();
            if pressure.iter().flatten().all(|p| p.is_finite()) {
                Ok(pressure)
            } else {
                Err(RadiationError::NotFinite { wavenumber: s[f].im / self.radius })
            }
        });
        samples.collect()
    }

    /// A sample from the pressures at the nodes.
    fn sample(&self, s: Complex64, pressure: &[[Complex64; RIGID_DOFS]], order: usize) -> RadiationSample {
        let wavenumber = -Complex64::I * s;
        let mut coefficients = project(&self.body.quadrature(), pressure, wavenumber, 1.0, order);
        let unit = |degree: usize| if degree < 3 { self.radius } else { self.radius * self.radius };
        for (degree, coefficients) in coefficients.iter_mut().enumerate() {
            for n in 0..=order {
                for m in -(n as isize)..=n as isize {
                    let factor = if allows(degree, n, m) { unit(degree) } else { 0.0 };
                    coefficients[index(n, m)] *= factor;
                }
            }
        }
        let mut surface_pressure =
            self.surface.as_ref().map_or_else(Vec::new, |s| s.pressure(&self.body, pressure));
        for vertex in &mut surface_pressure {
            for (degree, p) in vertex.iter_mut().enumerate() {
                *p *= unit(degree);
            }
        }
        RadiationSample { wavenumber: wavenumber / self.radius, coefficients, surface_pressure }
    }
}

impl RadiationSolver for SymmetricPatchSolver {
    fn solve(&self, wavenumbers: &[f64], order: usize) -> Result<Vec<RadiationSample>, RadiationError> {
        let s: Vec<Complex64> = wavenumbers
            .iter()
            .map(|k| {
                let kappa = k * self.radius;
                Complex64::new(GROWTH * (kappa / FIRST_RESONANCE).min(1.0), kappa)
            })
            .collect();
        // Rows of a pass take 6 F N² numbers. Larger bodies share the geometry among fewer wavenumbers.
        let share = if self.unknowns() > 800 { 4 } else { 8 };
        let mut pressures = Vec::new();
        for pass in s.chunks(share) {
            pressures.extend(match pass.len() {
                1..=2 => self.pass::<2>(pass)?,
                3..=4 => self.pass::<4>(pass)?,
                _ => self.pass::<8>(pass)?,
            });
        }
        Ok(s.par_iter().zip(&pressures).map(|(s, p)| self.sample(*s, p, order)).collect())
    }

    fn reference_radius(&self) -> f64 {
        self.radius
    }

    fn surface(&self) -> Option<&TriMesh> {
        self.surface.as_ref().map(|s| &s.mesh)
    }
}

fn unknowns(patches: &[Patch]) -> usize {
    patches.iter().map(Patch::count).sum()
}

/// Patch resolution for an accuracy, in units of R. Measured: `tests/converge/symmetric_patches.rs`.
///
/// A patch of an ellipsoid bends by 45° and stretches; those of a box are flat or small.
fn resolution(kappa: f64, accuracy: f64, is_box: bool) -> Resolution {
    let (per_wavelength, ellipsoid, flat) = match accuracy {
        a if a < 1e-5 => (6.5, 8, 7),
        a if a < 5e-4 => (5.6, 7, 5),
        a if a < 2e-3 => (4.8, 6, 4),
        _ => (4.6, 5, 3),
    };
    Resolution { per_wavelength, wavenumber: kappa, least: if is_box { flat } else { ellipsoid } }
}

/// The work on one row, compiled for each width of vector instructions.
struct RowTask<'a, const F: usize> {
    builder: &'a mut RowBuilder<F>,
    body: &'a Discretisation,
    row: usize,
    wavenumbers: &'a Wavenumbers<F>,
    /// Number of wavenumbers in use.
    used: usize,
}

impl<const F: usize> WithSimd for RowTask<'_, F> {
    type Output = Row;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Row {
        self.builder.fill(self.body, self.row, self.wavenumbers);
        row_of_systems(self.builder, self.row, self.body.nodes.len(), self.used)
    }
}

/// One row of all systems of a pass: system = wavenumber · 6 + motion.
struct Row {
    matrix: Vec<Complex64>,
    right: Vec<Complex64>,
}

/// ½ p − the double layer, by motion.
#[inline(always)]
fn row_of_systems<const F: usize>(
    builder: &RowBuilder<F>,
    row: usize,
    unknowns: usize,
    wavenumbers: usize,
) -> Row {
    let mut matrix = vec![Complex64::ZERO; wavenumbers * RIGID_DOFS * unknowns];
    for column in 0..unknowns {
        let sums = sums_by_motion(std::array::from_fn::<_, IMAGES, _>(|image| {
            builder.double[image * unknowns + column]
        }));
        for f in 0..wavenumbers {
            for (degree, sum) in sums.iter().enumerate() {
                let here = if column == row { 0.5 } else { 0.0 };
                matrix[(f * RIGID_DOFS + degree) * unknowns + column] =
                    Complex64::new(here - sum[0][f], -sum[1][f]);
            }
        }
    }
    let right = builder.right[..wavenumbers].iter().flatten().copied().collect();
    Row { matrix, right }
}
