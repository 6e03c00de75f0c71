//! Radiation of any surface motion, by reciprocity: from the pressure on a rigid body in incident regular
//! waves.
//!
//! Let u = jₙ(kr) Yₙₘ be incident on the rigid body, and p̂ the total pressure on its surface, incident and
//! scattered:
//!
//! ```text
//! (½ − K − γH) p̂ = u + γ ∂u/∂n,      cₙₘ ∝ ∮ p̂ₙₘ a_n dS
//! ```
//!
//! where cₙₘ is the multipole that the normal acceleration a_n radiates (Green's theorem with p, radiated,
//! and p̂, whose normal derivative vanishes). One factorisation and (n + 1)² right-hand sides give the
//! multipoles of any number of motions, each by a sum over the vertices. S a_n and K' a_n are never formed.
//! Only p̂ is approximated, which is as smooth as the wave in air. a_n may have any number of waves on a
//! triangle, as bending waves below coincidence do, if ∫ φᵢ a_n dS is integrated accurately. At k = 0, p̂ is
//! constant and the flux is exact.
//!
//! Not for pressures on the surface: see [`TriangleSolver::surface_pressure`].

use clangor_core::math::spherical_harmonics::{count, solid_harmonics};
use glam::{DMat3, DVec3};
use num_complex::Complex64;

use super::dense_system::{ClassSystem, paired_sums};
use super::incident_waves::SurfaceHarmonics;
use super::parity_classes::ParityClass;
use super::{TriangleSolver, narrow, widen};
use crate::radiation::RadiationError;

/// Fraction of a motion in a parity class below which the asymmetry comes from the mesh of the elements, not
/// from the body: in power, 4e-4.
const ABSENT: f64 = 0.02;

/// Highest order of the multipoles. Above it (2n − 1)!! overflows.
pub const MOST_ORDER: usize = 120;

/// One motion in one parity class.
struct Folded {
    motion: usize,
    /// Load of each unknown.
    loads: Vec<f64>,
}

impl TriangleSolver {
    /// Outgoing multipoles up to `order`, at most [`MOST_ORDER`], about the origin and of size 1 on the
    /// sphere of `radius` \[m\], as [`crate::radiation::RadiationSample`] has them, of motions given by their
    /// `loads` ∫ φᵢ a_n dS [m² times the unit of a_n] at the vertices of the surface; in metres times the
    /// unit of a_n. `harmonics` are those of [`surface_harmonics`](Self::surface_harmonics), for the same
    /// radius, if they are known.
    ///
    /// # Errors
    /// [`RadiationError::NotFinite`].
    pub fn radiate(
        &self,
        wavenumber: f64,
        order: usize,
        radius: f64,
        loads: &[Vec<f64>],
        harmonics: Option<&SurfaceHarmonics>,
    ) -> Result<Vec<Vec<Complex64>>, RadiationError> {
        let order = order.min(MOST_ORDER);
        let classes = self.all_classes();
        // Loads folded into the parity classes; classes without load are dropped.
        let folded: Vec<Vec<Folded>> = classes.iter().map(|class| self.folded(class, loads)).collect();
        let (classes, folded): (Vec<_>, Vec<_>) =
            classes.into_iter().zip(folded).filter(|(_, folded)| !folded.is_empty()).unzip();
        let mut coefficients = vec![vec![Complex64::ZERO; count(order)]; loads.len()];
        let members: Vec<Vec<usize>> = classes.iter().map(|class| self.members(class, order)).collect();
        // Assembly: incident waves on the right-hand side, matrices of the classes.
        let right = self.incident((wavenumber, order, radius), &classes, &members, harmonics);
        let swept = self.sweep.as_ref().and_then(|sweep| sweep.matrices(&classes, wavenumber * self.radius));
        let matrices = swept.unwrap_or_else(|| self.matrices(wavenumber, &classes));
        let systems = classes.iter().zip(matrices).zip(right);
        for ((((class, matrix), right), harmonics), folded) in systems.zip(&members).zip(&folded) {
            // Dense solve for the fewer of harmonics and motions, then reciprocity: coefficients are
            // products of the incident waves with the loads about the inverse.
            let motions = folded.iter().map(|f| f.motion);
            let loads = folded.iter().flat_map(|f| f.loads.iter().map(|w| Complex64::from(*w)));
            let sums = if folded.len() < harmonics.len() {
                let right_of_motions = loads.map(narrow).collect();
                let system = ClassSystem { size: class.size, matrix, right: right_of_motions };
                let solution: Vec<_> = system.solve_transposed().into_iter().map(widen).collect();
                paired_sums(&right, &solution, class.size)
            } else {
                let solution = ClassSystem { size: class.size, matrix, right }.solve();
                paired_sums(&solution, &loads.collect::<Vec<_>>(), class.size)
            };
            for (harmonic, sums) in harmonics.iter().zip(sums.chunks_exact(folded.len())) {
                for (motion, sum) in motions.clone().zip(sums) {
                    coefficients[motion][*harmonic] = sum / radius;
                }
            }
        }
        // Rotation from the cell's frame to the body's.
        if self.frame != DMat3::IDENTITY {
            self.rotation(order).apply(&mut coefficients);
        }
        if coefficients.iter().flatten().all(|c| c.is_finite()) {
            Ok(coefficients)
        } else {
            Err(RadiationError::NotFinite { wavenumber })
        }
    }

    /// All combinations of parities about the mirror planes.
    pub(super) fn all_classes(&self) -> Vec<ParityClass> {
        let mirrored: Vec<DVec3> = DVec3::AXES
            .into_iter()
            .filter(|axis| self.images.iter().any(|image| image.dot(*axis) < 0.0))
            .collect();
        (0..1_u32 << mirrored.len())
            .map(|odd| {
                let sign = |image: &DVec3| -> f64 {
                    let odd = mirrored.iter().enumerate().filter(|(k, _)| odd >> k & 1 == 1);
                    odd.map(|(_, axis)| image.dot(*axis)).product()
                };
                ParityClass::new(self.images.iter().map(sign).collect(), &self.panels.vertices, &self.images)
            })
            .collect()
    }

    /// The parts of motions in a class, without negligible ones.
    fn folded(&self, class: &ParityClass, loads: &[Vec<f64>]) -> Vec<Folded> {
        let sign = |signs: DVec3| {
            let image = self.images.iter().position(|image| *image == signs);
            image.map_or(0.0, |image| class.signs[image])
        };
        let fold = |(motion, whole): (usize, &Vec<f64>)| {
            let mut loads = vec![0.0; class.size];
            let mut scale = 0.0;
            for ((vertex, signs), load) in self.origin.iter().zip(whole) {
                scale += load.abs();
                // A vertex without triangles does not occur in the panels.
                let unknown = class.unknowns.get(*vertex as usize).map_or(usize::MAX, |u| *u as usize);
                if let Some(sum) = loads.get_mut(unknown) {
                    *sum += sign(*signs) * load;
                }
            }
            let size: f64 = loads.iter().map(|w| w.abs()).sum();
            (size > ABSENT * scale).then_some(Folded { motion, loads })
        };
        loads.iter().enumerate().filter_map(fold).collect()
    }

    /// The harmonics of a class: at a point of general position the reflections must give them the signs of
    /// the class.
    pub(super) fn members(&self, class: &ParityClass, order: usize) -> Vec<usize> {
        let x = DVec3::new(0.48, 0.6, 0.64);
        let (mut here, mut there) = (Vec::new(), Vec::new());
        solid_harmonics(x, order, &mut here);
        let mut is_member = vec![true; count(order)];
        for (image, sign) in self.images.iter().zip(&class.signs) {
            solid_harmonics(*image * x, order, &mut there);
            for (harmonic, member) in is_member.iter_mut().enumerate() {
                *member &= there[harmonic] * sign * here[harmonic] >= 0.0;
            }
        }
        (0..count(order)).filter(|harmonic| is_member[*harmonic]).collect()
    }
}
