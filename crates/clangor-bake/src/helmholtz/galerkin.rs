//! Radiation of any closed body: Galerkin boundary elements on flat triangles, by the equation of Burton and Miller.
//!
//! Pressure p linear on each triangle, G = e^{−ikr}/(4πr), K and K' its double layer and the adjoint, H the normal
//! derivative of K, a_n the normal acceleration (ρ = 1):
//!
//! ```text
//! (½ − K − γH) p = S a_n + γ (½ + K') a_n,   γ = −i / max(k, 1/R)
//! ```
//!
//! tested with the same functions that hold p. Without H (γ = 0) the equation fails at the resonances of the *solid*
//! with p = 0 on its surface; with it there are none. H is integrated by parts, so that only G and its first derivatives
//! are evaluated:
//!
//! ```text
//! −⟨φ_i, Hφ_j⟩ = ⟨curl φ_i, G curl φ_j⟩ − k² ⟨φ_i n, G φ_j n⟩
//! ```
//!
//! Triangles that touch or almost touch are integrated accurately, once for all wavenumbers; all others by three points
//! on each, in single precision. The dense system is factorised in single precision, whose error is below that of the
//! triangles. Error of order h² where the triangles follow the surface with its volume kept: 1e-3 at 600 vertices on a
//! sphere. Sources: A. J. Burton and G. F. Miller, Proc. R. Soc. A 323 (1971); A.-W. Maue, Z. Physik 126 (1949); S. Sauter
//! and C. Schwab, *Boundary Element Methods* (2011), §5.2.
//!
//! Not for open sheets, nor for bodies that need more than [`MOST_UNKNOWNS`].

use clangor::geometry::tri_mesh::TriMesh;
use clangor::model::acceleration_field::DEGREES;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::{MatMut, Par};
use glam::DVec3;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

use crate::multipole_projection::{SurfacePoint, project};
use crate::radiation::{RadiationError, RadiationSample, RadiationSolver};

mod far;
pub mod field;
mod lanes;
mod near;
mod pair_integrals;
mod pair_rules;
mod panels;

use far::{ClassMatrix, FarSystem};
use near::NearSystem;
use pair_rules::THREE_POINTS;
use panels::{Panels, along_curve};

/// Most unknowns of a dense system.
pub const MOST_UNKNOWNS: usize = 8000;

/// Memory of the systems that are solved at the same time [bytes].
const MEMORY: usize = 4 << 30;

/// Which equation on the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Equation {
    /// With the normal derivative of the field: one solution at every wavenumber.
    #[default]
    BurtonMiller,
    /// Without: cheaper by little, and wrong near wavenumbers at which the solid resonates with p = 0 on its surface; none
    /// of these is below π/D, D the diameter of the largest ball inside, and none below π/2D for a convex body.
    Conventional,
}

/// The six motions of a body by Galerkin boundary elements.
#[derive(Clone, Debug)]
pub struct GalerkinSolver {
    mesh: TriMesh,
    radius: f64,
    equation: Equation,
    panels: Panels,
    /// Number in `mesh` of each vertex of the panels.
    original: Vec<u32>,
    near: NearSystem,
    far: FarSystem,
}

impl GalerkinSolver {
    /// Prepares a closed surface, its triangles counter-clockwise seen from outside, in the frame of the centre of mass of
    /// the body; `highest` is the largest wavenumber [1/m] that will be asked for.
    ///
    /// # Errors
    /// [`RadiationError::TooLarge`].
    pub fn try_new(mesh: &TriMesh, highest: f64, equation: Equation) -> Result<Self, RadiationError> {
        if mesh.vertices.len() > MOST_UNKNOWNS {
            return Err(RadiationError::TooLarge {
                unknowns: mesh.vertices.len(),
                most: MOST_UNKNOWNS,
                wavenumber: highest,
            });
        }
        let radius = mesh.bounding_radius(DVec3::ZERO);
        // Neighbours in space next to each other in memory.
        let centroids: Vec<DVec3> = (0..mesh.triangles.len()).map(|t| mesh.centroid(t)).collect();
        let mut renumbered = vec![u32::MAX; mesh.vertices.len()];
        let mut original = Vec::new();
        let triangles = along_curve(&centroids, radius)
            .into_iter()
            .map(|t| {
                mesh.triangles[t as usize].map(|v| {
                    let new = &mut renumbered[v as usize];
                    if *new == u32::MAX {
                        *new = original.len() as u32;
                        original.push(v);
                    }
                    *new
                })
            })
            .collect();
        let vertices = original.iter().map(|v| mesh.vertices[*v as usize] / radius).collect();
        let panels = Panels::new(vertices, triangles);
        let images = [DVec3::ONE];
        let near = NearSystem::new(&panels, &images, highest * radius);
        let far = FarSystem::new(&panels, &images, near.images.iter().map(|image| &image.pairs[..]));
        Ok(Self { mesh: mesh.clone(), radius, equation, panels, original, near, far })
    }

    fn solve_one(&self, wavenumber: f64, order: usize) -> Result<RadiationSample, RadiationError> {
        let surface_pressure = self.pressures(wavenumber)?;
        let (points, pressure): (Vec<_>, Vec<_>) = (0..self.mesh.triangles.len())
            .flat_map(|t| THREE_POINTS.map(|(shares, weight)| (t, shares, weight)))
            .map(|(t, shares, weight)| {
                let corners = self.mesh.corners(t);
                let position = corners[0] * shares[0] + corners[1] * shares[1] + corners[2] * shares[2];
                let at = self.mesh.triangles[t].map(|v| &surface_pressure[v as usize]);
                let pressure: [Complex64; DEGREES] = std::array::from_fn(|d| {
                    at[0][d] * shares[0] + at[1][d] * shares[1] + at[2][d] * shares[2]
                });
                (SurfacePoint { position, area: self.mesh.area_vector(t) * weight }, pressure)
            })
            .unzip();
        let wavenumber = Complex64::new(wavenumber, 0.0);
        let coefficients = project(&points, &pressure, wavenumber, self.radius, order);
        Ok(RadiationSample { wavenumber, coefficients, surface_pressure })
    }

    /// The equations of the six motions at a wavenumber [1/m].
    pub fn assemble(&self, wavenumber: f64) -> DenseSystem {
        let k = wavenumber * self.radius;
        let coupling = match self.equation {
            Equation::BurtonMiller => 1.0 / k.max(1.0),
            Equation::Conventional => 0.0,
        };
        let recomputed;
        let near = if self.near.covers(k) {
            &self.near
        } else {
            recomputed = NearSystem::new(&self.panels, &[DVec3::ONE], k);
            &recomputed
        };
        let size = self.panels.vertices.len();
        let unknowns: Vec<u32> = (0..size as u32).collect();
        let mut class = ClassMatrix {
            unknowns: &unknowns,
            signs: &[1.0],
            matrix: vec![Complex32::ZERO; size * size],
            size,
        };
        let mut loads = near.loads(k, coupling);
        self.far.assemble(k, coupling, std::slice::from_mut(&mut class), &mut loads);
        near.for_each(k, coupling, |_, row, column, value| {
            class.matrix[column as usize * size + row as usize] += narrow(value);
        });
        let right = (0..DEGREES).flat_map(|d| loads.iter().map(move |load| narrow(load[d]))).collect();
        DenseSystem { wavenumber, size, matrix: class.matrix, right }
    }

    /// Pressures at the vertices of the mesh.
    fn pressures(&self, wavenumber: f64) -> Result<Vec<[Complex64; DEGREES]>, RadiationError> {
        let solution = self.assemble(wavenumber).solve();
        // Lengths were in R: a translation's pressure is one length, a rotation's two.
        let scale = |d: usize| if d < DEGREES / 2 { self.radius } else { self.radius * self.radius };
        let size = self.original.len();
        let mut pressures = vec![[Complex64::ZERO; DEGREES]; size];
        for (i, v) in self.original.iter().enumerate() {
            pressures[*v as usize] = std::array::from_fn(|d| widen(solution[d * size + i]) * scale(d));
        }
        if pressures.iter().flatten().all(|p| p.is_finite()) {
            Ok(pressures)
        } else {
            Err(RadiationError::NotFinite { wavenumber })
        }
    }
}

/// Equations of the six motions at one wavenumber, lengths in R.
#[derive(Clone, Debug)]
pub struct DenseSystem {
    wavenumber: f64,
    size: usize,
    /// Column by column.
    matrix: Vec<Complex32>,
    right: Vec<Complex32>,
}

impl RadiationSolver for GalerkinSolver {
    fn solve(&self, wavenumbers: &[f64], order: usize) -> Result<Vec<RadiationSample>, RadiationError> {
        let size = self.panels.vertices.len().max(1);
        let together = (MEMORY / (size * size * size_of::<Complex32>())).max(1);
        let mut samples = Vec::with_capacity(wavenumbers.len());
        for batch in wavenumbers.chunks(together) {
            let solved: Result<Vec<_>, _> = batch.par_iter().map(|k| self.solve_one(*k, order)).collect();
            samples.extend(solved?);
        }
        Ok(samples)
    }

    fn reference_radius(&self) -> f64 {
        self.radius
    }

    fn surface(&self) -> Option<&TriMesh> {
        Some(&self.mesh)
    }
}

impl DenseSystem {
    /// Wavenumber [1/m].
    pub fn wavenumber(&self) -> f64 {
        self.wavenumber
    }

    /// The unknowns of each motion, one motion after the other.
    pub fn solve(self) -> Vec<Complex32> {
        let Self { size, mut matrix, mut right, .. } = self;
        let columns = right.len() / size.max(1);
        let mut factors = MatMut::from_column_major_slice_mut(&mut matrix, size, size);
        let unknowns = MatMut::from_column_major_slice_mut(&mut right, size, columns);
        let (mut forward, mut backward) = (vec![0_usize; size], vec![0_usize; size]);
        let need = factor::lu_in_place_scratch::<usize, Complex32>(size, size, Par::Seq, Default::default())
            .or(solve::solve_in_place_scratch::<usize, Complex32>(size, columns, Par::Seq));
        let mut buffer = MemBuffer::new(need);
        let (_, permutation) = factor::lu_in_place(
            factors.as_mut(),
            &mut forward,
            &mut backward,
            Par::Seq,
            MemStack::new(&mut buffer),
            Default::default(),
        );
        let factors = factors.as_ref();
        solve::solve_in_place(factors, factors, permutation, unknowns, Par::Seq, MemStack::new(&mut buffer));
        right
    }
}

fn narrow(z: Complex64) -> Complex32 {
    Complex32::new(z.re as f32, z.im as f32)
}

fn widen(z: Complex32) -> Complex64 {
    Complex64::new(f64::from(z.re), f64::from(z.im))
}
