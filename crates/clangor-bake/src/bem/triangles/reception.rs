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

use clangor_core::math::radial::{regular, reverse_bessel};
use clangor_core::math::spherical_harmonics::{count, solid_harmonics, solid_harmonics_with_gradient};
use glam::{DMat3, DVec3};
use num_complex::{Complex32, Complex64};

use super::pair_rules::six_points;
use super::parity_classes::ParityClass;
use super::{ClassSystem, TriangleSolver, narrow, widen};
use crate::quadrature::gauss_legendre;
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
    /// unit of a_n.
    ///
    /// # Errors
    /// [`RadiationError::NotFinite`].
    pub fn radiate(
        &self,
        wavenumber: f64,
        order: usize,
        radius: f64,
        loads: &[Vec<f64>],
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
        let right = self.incident(wavenumber, order, radius, &classes, &members);
        let matrices = self.matrices(wavenumber, &classes);
        let systems = classes.iter().zip(matrices).zip(right);
        for ((((class, matrix), right), harmonics), folded) in systems.zip(&members).zip(&folded) {
            // Dense solve, then reciprocity: coefficients are products of the pressure with the loads.
            let solution = ClassSystem { size: class.size, matrix, right }.solve();
            for (harmonic, pressure) in harmonics.iter().zip(solution.chunks_exact(class.size.max(1))) {
                for Folded { motion, loads } in folded {
                    let sum: Complex64 = pressure.iter().zip(loads).map(|(p, w)| widen(*p) * *w).sum();
                    coefficients[*motion][*harmonic] = sum / radius;
                }
            }
        }
        // Rotation from the cell's frame to the body's.
        if self.frame != DMat3::IDENTITY {
            turn(self.frame, order, &mut coefficients);
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
    fn members(&self, class: &ParityClass, order: usize) -> Vec<usize> {
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

    /// ⟨φᵢ, u + γ ∂u/∂n⟩ times θₙ(ikR), for the harmonics of each class, column after column.
    fn incident(
        &self,
        wavenumber: f64,
        order: usize,
        radius: f64,
        classes: &[ParityClass],
        members: &[Vec<usize>],
    ) -> Vec<Vec<Complex32>> {
        let panels = &self.panels;
        let scale = self.radius / radius;
        let kappa = wavenumber * radius;
        let square = Complex64::from(kappa * kappa);
        let coupling = self.coupling(wavenumber * self.radius) * scale;
        let (mut harmonics, mut gradients, mut radial, mut theta) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        // Frequency-dependent factors of the orders.
        reverse_bessel(Complex64::new(0.0, kappa), order, &mut theta);
        let mut right: Vec<Vec<Complex32>> =
            classes.iter().zip(members).map(|(c, m)| vec![Complex32::ZERO; c.size * m.len()]).collect();
        let degrees: Vec<usize> = (0..count(order)).map(usize::isqrt).collect();
        let mut values = vec![[0.0; 2]; count(order)];
        let rule = six_points();
        for t in 0..panels.triangles.len() {
            let normal = panels.normals[t];
            let mut sums = vec![[[0.0_f64; 2]; 3]; count(order)];
            // Quadrature: u + γ ∂u/∂n against the three shape functions.
            for (shares, weight) in &rule {
                let x = panels.point(t, *shares) * scale;
                regular(square * x.length_squared(), order + 1, &mut radial);
                solid_harmonics_with_gradient(x, order, &mut harmonics, &mut gradients);
                let along = x.dot(normal);
                for (i, value) in values.iter_mut().enumerate() {
                    let n = degrees[i];
                    let slope = radial[n].re * gradients[i].dot(normal)
                        - square.re * radial[n + 1].re * along * harmonics[i];
                    *value = [radial[n].re * harmonics[i], -coupling * slope];
                }
                for (sum, value) in sums.iter_mut().zip(&values) {
                    for (sum, share) in sum.iter_mut().zip(shares) {
                        sum[0] += weight * share * value[0];
                        sum[1] += weight * share * value[1];
                    }
                }
            }
            // Scatter to the unknowns of each class.
            for ((class, harmonics), right) in classes.iter().zip(members).zip(&mut right) {
                for (column, harmonic) in harmonics.iter().enumerate() {
                    let factor = theta[degrees[*harmonic]] * panels.areas[t];
                    for (corner, vertex) in panels.triangles[t].iter().enumerate() {
                        let unknown = class.unknowns[*vertex as usize] as usize;
                        if unknown < class.size {
                            let [re, im] = sums[*harmonic][corner];
                            right[column * class.size + unknown] += narrow(Complex64::new(re, im) * factor);
                        }
                    }
                }
            }
        }
        right
    }
}

/// Rotates multipoles from the cell's frame to the body's: cₙₘ = Σ c'ₙₘ' ∫ Yₙₘ(d) Yₙₘ'(Fᵀd) dΩ.
fn turn(frame: DMat3, order: usize, coefficients: &mut [Vec<Complex64>]) {
    let (mut there, mut here) = (Vec::new(), Vec::new());
    let rotated: Vec<Vec<Complex64>> = coefficients
        .iter()
        .map(|of_cell| {
            let mut sums = vec![Complex64::ZERO; of_cell.len()];
            // Exact quadrature over the sphere: Gauss–Legendre in z, trapezoid in φ.
            let around = 2 * order + 2;
            for (u, weight) in gauss_legendre(order + 1) {
                for k in 0..around {
                    let phi = std::f64::consts::TAU * k as f64 / around as f64;
                    let z = 2.0 * u - 1.0;
                    let across = (1.0 - z * z).sqrt();
                    let direction = DVec3::new(across * phi.cos(), across * phi.sin(), z);
                    solid_harmonics(direction, order, &mut here);
                    solid_harmonics(frame.transpose() * direction, order, &mut there);
                    let weight = 4.0 * std::f64::consts::PI * weight / around as f64;
                    // Evaluate each order in the cell's frame and project it onto the body's frame.
                    for n in 0..=order {
                        let own = n * n..(n + 1) * (n + 1);
                        let value: Complex64 =
                            of_cell[own.clone()].iter().zip(&there[own.clone()]).map(|(c, y)| c * y).sum();
                        for i in own {
                            sums[i] += value * (weight * here[i]);
                        }
                    }
                }
            }
            sums
        })
        .collect();
    coefficients.clone_from_slice(&rotated);
}
