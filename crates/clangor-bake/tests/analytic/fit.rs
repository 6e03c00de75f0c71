//! The fit over frequency for a body with a known field: the sphere.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use clangor_bake::acceleration::{BakeOptions, bake_with};
use clangor_bake::radiation::{RadiationError, RadiationSample, RadiationSolver};
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::math::spherical_harmonics::{count, index};
use clangor_core::medium::Medium;
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use clangor_core::sound_model::acceleration::sphere_radiation::{SphereModel, SphereTransfer};
use glam::DVec3;
use num_complex::Complex64;

/// Density and speed of sound 1.
const UNIT: Medium = Medium { density: 1.0, sound_speed: 1.0 };

/// A sphere of this radius \[m\], its field in closed form.
struct ExactSphere(f64);

impl RadiationSolver for ExactSphere {
    fn solve(&self, wavenumbers: &[f64], order: usize) -> Result<Vec<RadiationSample>, RadiationError> {
        let a = self.0;
        let sample = |&k: &f64| {
            let mut coefficients: [Vec<Complex64>; RIGID_DOFS] =
                std::array::from_fn(|_| vec![Complex64::ZERO; count(order)]);
            let (re, im) = SphereTransfer::new(SphereModel::Exact, &UNIT, a, a, 1.0).at(k);
            let c = Complex64::new(re, im) * Complex64::new(0.0, k * a).exp() / (0.75 / PI).sqrt();
            for (degree, m) in [(0, 1), (1, -1), (2, 0)] {
                coefficients[degree][index(1, m)] = c;
            }
            RadiationSample { wavenumber: Complex64::new(k, 0.0), coefficients, surface_pressure: Vec::new() }
        };
        Ok(wavenumbers.iter().map(sample).collect())
    }

    fn reference_radius(&self) -> f64 {
        self.0
    }

    fn surface(&self) -> Option<&TriMesh> {
        None
    }
}

#[test]
fn a_sphere_is_fitted_by_its_two_poles() {
    let a = 0.0075;
    let options = BakeOptions::new(366.0, 1e-4);
    let (model, evidence) =
        bake_with(&ExactSphere(a), 0.8, &options, &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(model.field.terms.len(), 3);
    assert!(evidence.solves <= 12, "{} solves", evidence.solves);
    // 100 dB of e^{−ct/a} are 11.5 a/c. Seen: 12.5.
    assert!((model.field.ring_time - 12.5).abs() < 0.1, "{}", model.field.ring_time);
    let mut worst = 0.0_f64;
    for k in [0.5, 2.0, 30.0, 111.0, 200.0, 366.0] {
        for r in [1.2, 2.0, 8.0, 100.0] {
            let x = r * DVec3::new(0.48, -0.6, 0.64);
            let acceleration = DVec3::new(0.3, -0.2, 0.9);
            let along = acceleration.dot(x) / r;
            let (re, im) = SphereTransfer::new(SphereModel::Exact, &UNIT, a, a * r, along).at(k);
            let exact = Complex64::new(re, im);
            let z = [acceleration.x, acceleration.y, acceleration.z, 0.0, 0.0, 0.0];
            let p = model.radius * model.field.pressure(&z, x, k * a);
            worst = worst.max((p - exact).norm() / exact.norm());
        }
    }
    // Residual seen: 3.6e-7, of the 32-bit coefficients.
    assert!(worst < 1e-5, "{worst:e}");
}
