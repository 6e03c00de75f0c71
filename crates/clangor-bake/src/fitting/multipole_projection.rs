//! Projection of pressure and acceleration on a surface onto the multipoles of the exterior field.
//!
//! With G = e^{−ikr}/(4πr) = −ik Σ hₙ⁽²⁾(kr_x) jₙ(kr_y) Y_nm Y_nm and the representation p = ∫ (p ∂G/∂n + ρ
//! a_n G) dS, n pointing into the fluid, the coefficient of
//! [`RadiationSample`](crate::radiation::RadiationSample) is
//!
//! ```text
//! c_nm = θₙ(ikR) / R^{n+1} · ∫ [ p ∂/∂n (u_n(kr) rⁿ Y_nm) + ρ a_n u_n(kr) rⁿ Y_nm ] dS,   u_n(z) = jₙ(z)/zⁿ
//! ```
//!
//! which is finite at k = 0. Valid outside the smallest ball about the origin that contains the surface.

use clangor_core::math::radial::{regular, reverse_bessel};
use clangor_core::math::spherical_harmonics::{count, index, solid_harmonics_with_gradient};
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;
use num_complex::Complex64;

use crate::radiation::rigid_motions;

/// A point of a quadrature over the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Position \[m\].
    pub position: DVec3,
    /// Normal into the fluid times the weight \[m²\].
    pub area: DVec3,
}

/// Coefficients of the six motions on the sphere of `radius` R \[m\], from their pressures at the points (ρ =
/// 1).
pub fn project(
    points: &[SurfacePoint],
    pressure: &[[Complex64; RIGID_DOFS]],
    wavenumber: Complex64,
    radius: f64,
    order: usize,
) -> [Vec<Complex64>; RIGID_DOFS] {
    let mut sums = if wavenumber.im == 0.0 {
        real_sums(points, pressure, wavenumber.re, radius, order)
    } else {
        complex_sums(points, pressure, wavenumber, radius, order)
    };
    // Normalisation θₙ(ikR)/R.
    let mut scale = Vec::new();
    reverse_bessel(Complex64::I * wavenumber * radius, order, &mut scale);
    for sum in &mut sums {
        for n in 0..=order {
            sum[n * n..(n + 1) * (n + 1)].iter_mut().for_each(|c| *c *= scale[n] / radius);
        }
    }
    sums
}

/// The integrals in units of R, of a complex wavenumber.
fn complex_sums(
    points: &[SurfacePoint],
    pressure: &[[Complex64; RIGID_DOFS]],
    wavenumber: Complex64,
    radius: f64,
    order: usize,
) -> [Vec<Complex64>; RIGID_DOFS] {
    let mut sums: [Vec<Complex64>; RIGID_DOFS] = std::array::from_fn(|_| vec![Complex64::ZERO; count(order)]);
    let (mut harmonics, mut gradients, mut radial) = (Vec::new(), Vec::new(), Vec::new());
    let square = wavenumber * wavenumber * (radius * radius);
    for (point, pressure) in points.iter().zip(pressure) {
        let x = point.position / radius;
        let motions = rigid_motions(point.position, point.area);
        let distance_square = x.length_squared();
        // u'_n(z) = −z u_{n+1}(z) needs one order more than the result.
        regular(square * distance_square, order + 1, &mut radial);
        solid_harmonics_with_gradient(x, order, &mut harmonics, &mut gradients);
        let along = x.dot(point.area);
        // Quadrature of p ∂/∂n (u_n rⁿ Y_nm) + a_n u_n rⁿ Y_nm.
        for n in 0..=order {
            let slope = -square * radial[n + 1] * along;
            for m in -(n as isize)..=n as isize {
                let i = index(n, m);
                // Lengths in R: the derivative and the coefficient have one factor 1/R each.
                let normal = (radial[n] * gradients[i].dot(point.area) + slope * harmonics[i]) / radius;
                let value = radial[n] * harmonics[i];
                for degree in 0..RIGID_DOFS {
                    sums[degree][i] += pressure[degree] * normal + value * motions[degree];
                }
            }
        }
    }
    sums
}

/// The same of a real wavenumber, whose regular waves are real: a fifth of the work.
fn real_sums(
    points: &[SurfacePoint],
    pressure: &[[Complex64; RIGID_DOFS]],
    wavenumber: f64,
    radius: f64,
    order: usize,
) -> [Vec<Complex64>; RIGID_DOFS] {
    // Of each harmonic: real and imaginary parts by the pressures, and parts by the accelerations.
    let mut by_pressure = vec![[0.0; 2 * RIGID_DOFS]; count(order)];
    let mut by_motion = vec![[0.0; RIGID_DOFS]; count(order)];
    let (mut harmonics, mut gradients, mut radial) = (Vec::new(), Vec::new(), Vec::new());
    let square = (wavenumber * radius).powi(2);
    for (point, pressure) in points.iter().zip(pressure) {
        let x = point.position / radius;
        let motions = rigid_motions(point.position, point.area);
        let parts: [f64; 2 * RIGID_DOFS] = std::array::from_fn(|q| {
            let p = pressure[q / 2];
            if q % 2 == 0 { p.re } else { p.im }
        });
        regular(Complex64::from(square * x.length_squared()), order + 1, &mut radial);
        solid_harmonics_with_gradient(x, order, &mut harmonics, &mut gradients);
        let along = x.dot(point.area);
        for n in 0..=order {
            let (here, slope) = (radial[n].re, -square * radial[n + 1].re * along);
            for i in n * n..(n + 1) * (n + 1) {
                let normal = (here * gradients[i].dot(point.area) + slope * harmonics[i]) / radius;
                let value = here * harmonics[i];
                by_pressure[i].iter_mut().zip(&parts).for_each(|(sum, p)| *sum += normal * p);
                by_motion[i].iter_mut().zip(&motions).for_each(|(sum, a)| *sum += value * a);
            }
        }
    }
    let part = |i: usize, d: usize| {
        Complex64::new(by_pressure[i][2 * d] + by_motion[i][d], by_pressure[i][2 * d + 1])
    };
    std::array::from_fn(|d| (0..count(order)).map(|i| part(i, d)).collect())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use clangor_core::medium::Medium;
    use clangor_core::sound_model::acceleration::sphere_radiation::{SphereModel, SphereTransfer};

    use super::*;
    use crate::quadrature::gauss_legendre;

    #[test]
    fn a_sphere_is_a_dipole_of_the_right_strength() {
        let (a, reference) = (0.8, 1.3);
        let mut points = Vec::new();
        for (u, w) in gauss_legendre(24) {
            for k in 0..48 {
                let (z, phi) = (2.0 * u - 1.0, TAU * k as f64 / 48.0);
                let n = DVec3::new((1.0 - z * z).sqrt() * phi.cos(), (1.0 - z * z).sqrt() * phi.sin(), z);
                points.push(SurfacePoint { position: a * n, area: n * (4.0 * PI * a * a * w / 48.0) });
            }
        }
        let air = Medium { density: 1.0, sound_speed: 1.0 };
        for k in [0.0, 0.01, 1.0, 6.0] {
            let at = |r: f64, cosine: f64| {
                let (re, im) = SphereTransfer::new(SphereModel::Exact, &air, a, r, cosine).at(k);
                // The transfer counts time from the centre's acceleration, e^{−ik(r−a)} its delay.
                Complex64::new(re, im)
            };
            let pressure: Vec<[Complex64; RIGID_DOFS]> = points
                .iter()
                .map(|p| {
                    let d = p.position / a;
                    let along = |c: f64| at(a, c);
                    [along(d.x), along(d.y), along(d.z), Complex64::ZERO, Complex64::ZERO, Complex64::ZERO]
                })
                .collect();
            let c = project(&points, &pressure, Complex64::new(k, 0.0), reference, 6);
            let y10 = (0.75 / PI).sqrt();
            let expected = at(reference, 1.0) * Complex64::new(0.0, k * reference).exp() / y10;
            // Residual seen: 3e-15.
            assert!(
                (c[2][index(1, 0)] - expected).norm() < 1e-12 * expected.norm(),
                "{k}: {} {expected}",
                c[2][2]
            );
            let others: f64 = (0..6)
                .flat_map(|d| (0..count(6)).map(move |i| (d, i)))
                .filter(|(d, i)| !matches!((d, i), (0, 3) | (1, 1) | (2, 2)))
                .map(|(d, i)| c[d][i].norm())
                .fold(0.0, f64::max);
            // Residual seen: 2e-15.
            assert!(others < 1e-12, "{k}: {others}");
        }
    }

    #[test]
    fn a_real_wavenumber_has_the_sums_of_a_complex_one() {
        let at = |i: usize| {
            let t = i as f64;
            SurfacePoint {
                position: DVec3::new(t.sin(), (1.7 * t).cos(), (0.3 * t).sin()) * 0.4,
                area: DVec3::new((2.0 * t).cos(), t.cos(), (0.9 * t).sin()) * 0.01,
            }
        };
        let points: Vec<SurfacePoint> = (0..50).map(at).collect();
        let pressure: Vec<[Complex64; RIGID_DOFS]> =
            (0..50).map(|i| std::array::from_fn(|d| Complex64::cis((i * (d + 3)) as f64))).collect();
        let real = real_sums(&points, &pressure, 7.0, 0.9, 9);
        let complex = complex_sums(&points, &pressure, 7.0.into(), 0.9, 9);
        for (a, b) in real.iter().flatten().zip(complex.iter().flatten()) {
            // The same sums in double precision.
            assert!((a - b).norm() < 1e-14, "{a} {b}");
        }
    }
}
