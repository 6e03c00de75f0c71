//! Bodies of revolution against closed forms: the sphere at any frequency, spheroids at low frequency.

use std::f64::consts::PI;

use clangor::geometry::meridian::Meridian;
use clangor::medium::Medium;
use clangor::model::sphere_radiation::{SphereModel, SphereTransfer};
use clangor::model::spherical_harmonics::index;
use clangor_bake::helmholtz::revolution::{RevolutionOptions, RevolutionSolver};
use clangor_bake::radiation::RadiationSolver;
use glam::DVec3;
use num_complex::Complex64;

#[test]
fn a_sphere_radiates_its_exact_dipole() {
    let a = 0.8;
    let meridian = Meridian::spheroid(a, a).expect("a ball");
    let axis = DVec3::new(0.3, -0.5, 0.8).normalize();
    let air = Medium { density: 1.0, sound_speed: 1.0 };
    let solver = RevolutionSolver::new(&meridian, axis, RevolutionOptions::new(1.5));
    let wavenumbers = [0.0, 0.01, 1.0, 1.5];
    let mut worst = 0.0_f64;
    for (sample, k) in solver.solve(&wavenumbers, 5).expect("fields").iter().zip(wavenumbers) {
        assert_eq!(sample.wavenumber, Complex64::new(k, 0.0));
        let (re, im) = SphereTransfer::new(SphereModel::Exact, &air, a, a, 1.0).at(k);
        let expected = Complex64::new(re, im) * Complex64::new(0.0, k * a).exp() / (0.75 / PI).sqrt();
        for degree in 0..6 {
            for n in 0..=5 {
                for m in -(n as isize)..=n as isize {
                    let own = n == 1 && degree == [1, 2, 0][(m + 1) as usize];
                    let expected = if own { expected } else { Complex64::ZERO };
                    let error = (sample.coefficients[degree][index(n, m)] - expected).norm() / a;
                    worst = worst.max(error);
                }
            }
        }
    }
    println!("{worst:e} with {} unknowns", solver.unknowns());
    assert!(worst < 1e-7, "{worst:e}");
}
