//! Radiation of any closed body: Galerkin boundary elements on flat triangles, by the equation of Burton and
//! Miller.
//!
//! Pressure p linear on each triangle, G = e^{−ikr}/(4πr), K and K' its double layer and the adjoint, H the
//! normal derivative of K, a_n the normal acceleration (ρ = 1):
//!
//! ```text
//! (½ − K − γH) p = S a_n + γ (½ + K') a_n,   γ = −i / max(k, 1/R)
//! ```
//!
//! tested with the functions that span p. Without H (γ = 0) the equation fails at the resonances of the
//! *interior* with p = 0 on its surface; with H it has a unique solution. H is integrated by parts, so that
//! only G and its first derivatives are evaluated:
//!
//! ```text
//! −⟨φ_i, Hφ_j⟩ = ⟨curl φ_i, G curl φ_j⟩ − k² ⟨φ_i n, G φ_j n⟩
//! ```
//!
//! Triangles that touch or almost touch are integrated accurately, once for all wavenumbers; all others by
//! three points on each, in single precision. The dense system is factorised in single precision, whose error
//! is below that of the triangles. Error of order h² where the triangles follow the surface with its volume
//! kept: 1e-3 at 600 vertices on a sphere. Sources: A. J. Burton and G. F. Miller, Proc. R. Soc. A 323
//! (1971); A.-W. Maue, Z. Physik 126 (1949); S. Sauter and C. Schwab, *Boundary Element Methods* (2011),
//! §5.2.
//!
//! A body with mirror planes is one cell and its images. The pressure of a motion that is even or odd about
//! each plane has the same parity. Each combination that occurs among the six motions, a parity class, is a
//! system over the cell alone.
//!
//! Solves at many wavenumbers of a band share their systems (`sweep`).
//!
//! Not for open sheets, nor for bodies that need more than [`MOST_UNKNOWNS`] in a class.

use std::borrow::Cow;
use std::sync::OnceLock;

use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::math::spherical_harmonics::count;
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::{BVec3, DMat3, DVec3};
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

use crate::effort::Effort;
use crate::mesh::remesh::SymmetricMesh;
use crate::radiation::{RadiationError, RadiationSample, RadiationSolver};

pub(crate) mod adjoint_multipoles;
mod dense_system;
mod far;
mod few_columns;
pub mod field;
mod incident_waves;
pub(crate) mod lanes;
mod motion_multipoles;
mod near;
mod pair_integrals;
mod pair_rules;
mod panels;
mod parity_classes;
mod reception;
mod rotation;
mod surface_pressure;
pub(crate) mod sweep;

use dense_system::ClassSystem;
use far::{ClassMatrix, FarSystem};
use near::NearSystem;
pub(crate) use pair_integrals::parity;
use panels::{Panels, along_curve};
use parity_classes::ParityClass;
use rotation::MultipoleRotation;
use sweep::Sweep;

pub use dense_system::DenseSystem;
pub use incident_waves::SurfaceHarmonics;
pub use reception::MOST_ORDER;

/// Most unknowns of a dense system, one for each parity class.
pub const MOST_UNKNOWNS: usize = 8000;

/// Memory of the systems that are solved at the same time [bytes].
const MEMORY: usize = 4 << 30;

/// Choice of the surface integral equation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Equation {
    /// With the normal derivative of the field: unique at every wavenumber.
    #[default]
    BurtonMiller,
    /// Without it: slightly cheaper, and wrong near wavenumbers at which the interior resonates with p = 0 on
    /// its surface. None of these is below π/D, D the diameter of the largest inscribed ball, and none below
    /// π/2D for a convex body.
    Conventional,
}

/// The six motions of a body by Galerkin boundary elements.
#[derive(Clone, Debug)]
pub struct TriangleSolver {
    mesh: TriMesh,
    radius: f64,
    equation: Equation,
    effort: Effort,
    /// Triangles of the cell.
    panels: Panels,
    /// Signs of the images of the cell, the cell itself first.
    images: Vec<DVec3>,
    /// Rotation from the frame of the cell to that of the body.
    frame: DMat3,
    classes: Vec<ParityClass>,
    /// Vertex of the panels that each vertex of `mesh` is an image of, and the signs of that image.
    origin: Vec<(u32, DVec3)>,
    near: NearSystem,
    far: FarSystem,
    /// Harmonics up to the order of the first solve, for all later ones.
    harmonics: OnceLock<Option<SurfaceHarmonics>>,
    /// Rotation of the multipoles, for the order of the first solve.
    rotation: OnceLock<MultipoleRotation>,
    /// What many wavenumbers share.
    sweep: Option<Sweep>,
}

impl TriangleSolver {
    /// Prepares a closed surface, its triangles counter-clockwise seen from outside, in the frame of the
    /// centre of mass of the body. `highest` is the largest wavenumber [1/m] of later solves.
    ///
    /// # Errors
    /// [`RadiationError::TooLarge`].
    pub fn try_new(mesh: &TriMesh, highest: f64, equation: Equation) -> Result<Self, RadiationError> {
        let whole = SymmetricMesh { cell: mesh.clone(), mirrors: BVec3::FALSE, frame: DMat3::IDENTITY };
        Self::try_symmetric(&whole, highest, equation)
    }

    /// Prepares a surface with mirror planes through the centre of mass of the body, which is the origin. The
    /// solution is that of the whole surface.
    ///
    /// # Errors
    /// [`RadiationError::TooLarge`].
    pub fn try_symmetric(
        symmetric: &SymmetricMesh,
        highest: f64,
        equation: Equation,
    ) -> Result<Self, RadiationError> {
        Self::with_effort(symmetric, highest, (equation, Effort::Exact))
    }

    /// Prepares a surface like [`try_new`](Self::try_new), with close pairs of triangles integrated to a per
    /// cent.
    ///
    /// # Errors
    /// [`RadiationError::TooLarge`].
    pub fn try_draft(mesh: &TriMesh, highest: f64) -> Result<Self, RadiationError> {
        let whole = SymmetricMesh { cell: mesh.clone(), mirrors: BVec3::FALSE, frame: DMat3::IDENTITY };
        Self::with_effort(&whole, highest, (Equation::BurtonMiller, Effort::Draft))
    }

    fn with_effort(
        symmetric: &SymmetricMesh,
        highest: f64,
        (equation, effort): (Equation, Effort),
    ) -> Result<Self, RadiationError> {
        let cell = &symmetric.cell;
        let images = symmetric.images();
        let radius = cell.bounding_radius(DVec3::ZERO);
        let unknowns = most_unknowns(&ParityClass::all(&cell.vertices, &images));
        if unknowns > MOST_UNKNOWNS {
            return Err(RadiationError::TooLarge { unknowns, most: MOST_UNKNOWNS, wavenumber: highest });
        }
        // Spatial neighbours adjacent in memory: triangles along a space-filling curve, vertices renumbered.
        let centroids: Vec<DVec3> = (0..cell.triangles.len()).map(|t| cell.centroid(t)).collect();
        let mut renumbered = vec![u32::MAX; cell.vertices.len()];
        let mut vertices = Vec::new();
        let triangles = along_curve(&centroids, radius)
            .into_iter()
            .map(|t| {
                cell.triangles[t as usize].map(|v| {
                    let new = &mut renumbered[v as usize];
                    if *new == u32::MAX {
                        *new = vertices.len() as u32;
                        vertices.push(cell.vertices[v as usize] / radius);
                    }
                    *new
                })
            })
            .collect();
        // Parity classes, and the vertex map from the whole surface to the cell.
        let classes = ParityClass::all(&vertices, &images);
        let (mesh, from) = symmetric.whole();
        let origin = from.iter().map(|v| (renumbered[v.original as usize], v.signs)).collect();
        // Wavenumber-independent geometry of near and far pairs.
        let panels = Panels::new(vertices, triangles);
        let near = NearSystem::new(&panels, &images, highest * radius, effort);
        let far = FarSystem::new(&panels, &images, near.images.iter().map(|image| &image.pairs[..]));
        let frame = symmetric.frame;
        let (harmonics, rotation) = (OnceLock::new(), OnceLock::new());
        Ok(Self {
            mesh,
            radius,
            equation,
            effort,
            panels,
            images,
            frame,
            classes,
            origin,
            near,
            far,
            harmonics,
            rotation,
            sweep: None,
        })
    }

    /// Unknowns of the largest system of a solve.
    pub fn unknowns(&self) -> usize {
        most_unknowns(&self.classes)
    }

    /// Systems of a solve, one for each parity, and mirror images.
    pub(crate) fn systems(&self) -> [usize; 2] {
        [self.classes.len(), self.images.len()]
    }

    fn solve_one(
        &self,
        wavenumber: f64,
        order: usize,
        harmonics: Option<&SurfaceHarmonics>,
    ) -> Result<RadiationSample, RadiationError> {
        let of_cell = self.cell_pressures(wavenumber)?;
        // Multipoles of motions along and about the axes of the cell, in units of R.
        let about_cell = self.multipoles_of_cell(wavenumber, order, &of_cell, harmonics);
        // Motions of the body's axes, in metres; then multipoles about the body's axes.
        let mut coefficients = std::array::from_fn(|degree| {
            let shares = self.shares(degree);
            (0..count(order))
                .map(|c| shares.map(|(d, share)| about_cell[d][c] * share).into_iter().sum::<Complex64>())
                .map(|c| c * self.length(degree))
                .collect()
        });
        if self.frame != DMat3::IDENTITY {
            self.rotation(order).apply(&mut coefficients);
        }
        let surface_pressure = self.whole_pressures(&of_cell);
        Ok(RadiationSample { wavenumber: Complex64::new(wavenumber, 0.0), coefficients, surface_pressure })
    }

    /// Motions along or about the axes of the cell that make up one of the body, and their shares.
    fn shares(&self, degree: usize) -> [(usize, f64); 3] {
        let first = degree / 3 * 3;
        std::array::from_fn(|axis| (first + axis, self.frame.col(axis)[degree - first]))
    }

    /// Factor of length of the pressure of a motion: R of a translation, R² of a rotation.
    fn length(&self, degree: usize) -> f64 {
        if degree < RIGID_DOFS / 2 { self.radius } else { self.radius * self.radius }
    }

    /// The equations of the six motions at a wavenumber [1/m].
    pub fn assemble(&self, wavenumber: f64) -> DenseSystem {
        let k = wavenumber * self.radius;
        let coupling = self.coupling(k);
        let near = self.near_system(k);
        let mut matrices: Vec<ClassMatrix> = self.classes.iter().map(empty_matrix).collect();
        let mut loads = near.loads(k, coupling);
        self.far.assemble(k, coupling, &mut matrices, &mut loads);
        near.for_each(k, coupling, |image, row, column, value| {
            matrices.iter_mut().for_each(|class| class.add_entry(image, row, column, value));
        });
        let classes = self.classes.iter().zip(matrices);
        let systems = classes.map(|(class, matrix)| ClassSystem {
            size: class.size,
            matrix: matrix.matrix,
            right: class
                .motions
                .iter()
                .flat_map(|d| class.vertices().map(|v| narrow(loads[v][*d])))
                .collect(),
        });
        DenseSystem { wavenumber, systems: systems.collect() }
    }

    /// The matrices of some classes, column by column, at a wavenumber [1/m].
    fn matrices(&self, wavenumber: f64, classes: &[ParityClass]) -> Vec<Vec<Complex32>> {
        let mut matrices: Vec<ClassMatrix> = classes.iter().map(empty_matrix).collect();
        self.assemble_matrices(wavenumber * self.radius, &mut matrices);
        matrices.into_iter().map(|class| class.matrix).collect()
    }

    /// Adds all entries at a wavenumber [1/R] to matrices.
    fn assemble_matrices(&self, k: f64, matrices: &mut [ClassMatrix<'_>]) {
        let coupling = self.coupling(k);
        self.far.assemble_matrices(k, coupling, matrices);
        self.near_system(k).for_each(k, coupling, |image, row, column, value| {
            matrices.iter_mut().for_each(|class| class.add_entry(image, row, column, value));
        });
    }

    /// Loads of all vertices at a wavenumber [1/R], of motions along and about the axes of the cell.
    fn loads(&self, k: f64) -> Vec<[Complex64; RIGID_DOFS]> {
        let coupling = self.coupling(k);
        let mut loads = self.near_system(k).loads(k, coupling);
        self.far.assemble_loads(k, coupling, &mut loads);
        loads
    }

    /// The harmonics of the projection up to an order, computed by the first call.
    fn kept_harmonics(&self, order: usize) -> Option<&SurfaceHarmonics> {
        self.harmonics.get_or_init(|| self.surface_harmonics(order, self.radius)).as_ref()
    }

    /// The rotation of multipoles up to an order to the body's frame, kept for the order of the first call.
    /// Its last digits depend on the order: others are computed anew.
    fn rotation(&self, order: usize) -> Cow<'_, MultipoleRotation> {
        let kept = self.rotation.get_or_init(|| MultipoleRotation::new(self.frame, order));
        if order == kept.order() {
            Cow::Borrowed(kept)
        } else {
            Cow::Owned(MultipoleRotation::new(self.frame, order))
        }
    }

    /// iγ at a wavenumber [1/R].
    fn coupling(&self, k: f64) -> f64 {
        match self.equation {
            Equation::BurtonMiller => 1.0 / k.max(1.0),
            Equation::Conventional => 0.0,
        }
    }

    /// The near part at a wavenumber [1/R].
    fn near_system(&self, k: f64) -> Cow<'_, NearSystem> {
        if self.near.covers(k) {
            Cow::Borrowed(&self.near)
        } else {
            Cow::Owned(NearSystem::new(&self.panels, &self.images, k, self.effort))
        }
    }

    /// Pressures at the vertices of the cell, of motions along and about its axes, in units of R.
    fn cell_pressures(&self, wavenumber: f64) -> Result<Vec<[Complex64; RIGID_DOFS]>, RadiationError> {
        // Assembly and factorisation of each parity class.
        let k = wavenumber * self.radius;
        let swept =
            self.sweep.as_ref().filter(|sweep| sweep.covers(k)).and_then(|sweep| sweep.solve(self, k));
        let solutions = swept.unwrap_or_else(|| self.assemble(wavenumber).solve());
        let mut of_cell = vec![[Complex64::ZERO; RIGID_DOFS]; self.panels.vertices.len()];
        for (class, solution) in self.classes.iter().zip(&solutions) {
            for (d, column) in class.motions.iter().zip(solution.chunks_exact(class.size.max(1))) {
                for (v, p) in class.vertices().zip(column) {
                    of_cell[v][*d] = widen(*p);
                }
            }
        }
        if of_cell.iter().flatten().all(|p| p.is_finite()) {
            Ok(of_cell)
        } else {
            Err(RadiationError::NotFinite { wavenumber })
        }
    }

    /// Pressures at the vertices of the mesh, of motions along and about the axes of the body: signs of the
    /// image, and rotation to the body's frame.
    fn whole_pressures(&self, of_cell: &[[Complex64; RIGID_DOFS]]) -> Vec<[Complex64; RIGID_DOFS]> {
        let shares: [[(usize, f64); 3]; RIGID_DOFS] = std::array::from_fn(|degree| self.shares(degree));
        let at = |(vertex, signs): &(u32, DVec3)| {
            // A vertex without triangles does not occur in the panels.
            let p = of_cell.get(*vertex as usize).unwrap_or(&[Complex64::ZERO; RIGID_DOFS]);
            std::array::from_fn(|degree| {
                let parts = shares[degree].map(|(d, share)| p[d] * (share * parity(*signs, d)));
                parts.into_iter().sum::<Complex64>() * self.length(degree)
            })
        };
        self.origin.iter().map(at).collect()
    }
}

/// A matrix to be assembled.
fn empty_matrix(class: &ParityClass) -> ClassMatrix<'_> {
    let ParityClass { unknowns, signs, size, .. } = class;
    ClassMatrix { unknowns, signs, matrix: vec![Complex32::ZERO; size * size], size: *size }
}

/// Unknowns of the largest class.
fn most_unknowns(classes: &[ParityClass]) -> usize {
    classes.iter().map(|class| class.size).max().unwrap_or(0)
}

impl RadiationSolver for TriangleSolver {
    fn solve(&self, wavenumbers: &[f64], order: usize) -> Result<Vec<RadiationSample>, RadiationError> {
        let entries: usize = self.classes.iter().map(|class| class.size * class.size).sum();
        let together = (MEMORY / (entries.max(1) * size_of::<Complex32>())).max(1);
        let harmonics = self.kept_harmonics(order);
        let mut samples = Vec::with_capacity(wavenumbers.len());
        for batch in wavenumbers.chunks(together) {
            if let Some(sweep) = &self.sweep {
                sweep.prepare(self, &batch.iter().map(|k| k * self.radius).collect::<Vec<_>>());
            }
            let solved: Result<Vec<_>, _> =
                batch.par_iter().map(|k| self.solve_one(*k, order, harmonics)).collect();
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

fn narrow(z: Complex64) -> Complex32 {
    Complex32::new(z.re as f32, z.im as f32)
}

fn widen(z: Complex32) -> Complex64 {
    Complex64::new(f64::from(z.re), f64::from(z.im))
}
