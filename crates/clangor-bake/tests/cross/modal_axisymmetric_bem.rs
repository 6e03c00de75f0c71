//! Modes of axisymmetric bodies by azimuthal order against triangles that ignore the symmetry.

use std::ops::ControlFlow;

use clangor_bake::mesh::tetrahedra::shape_mesh;
use clangor_bake::modal_radiation::axisymmetric::AxisymmetricModalSolver;
use clangor_bake::modal_radiation::bem_transfer::BemModalSolver;
use clangor_bake::modal_radiation::{ModalMotion, ModalSolver};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::shape::Shape;
use clangor_core::sound_model::modal::surface::ModalSurface;
use glam::DVec3;

/// Worst errors of the field at 2 R and of the power, over bending of orders 0, 2 and 3 at wavenumbers up to
/// `highest` [1/m].
fn compare(name: &str, edge: f64, highest: f64, accuracy: f64) -> (f64, f64) {
    let shape = Shape::parse(name).expect("a shape");
    let meridian = shape.meridian().expect("an axisymmetric body");
    let tetrahedra = shape_mesh(&shape, edge).expect("a mesh");
    let centre = DVec3::Y * meridian.centre_of_mass();
    let nodes = tetrahedra.nodes.iter().map(|x| *x - centre).collect();
    let surface = ModalSurface { nodes, triangles: tetrahedra.surface() };
    let mesh = shape.mesh();
    let mesh = mesh.relative_to(MassProperties::of(&mesh).expect("a solid").centre_of_mass);
    let radius = surface.radius();
    let bend = |order: f64| -> Vec<DVec3> {
        let at = |x: &DVec3| {
            let (r, phi) = (x.x.hypot(x.z) / radius, x.z.atan2(x.x));
            let outwards = DVec3::new(x.x, 0.0, x.z) / radius;
            let height = if order == 0.0 { r * r - 0.4 } else { r.powf(order) };
            (DVec3::Y * height + 0.3 * r * outwards) * (order * phi - 0.4).cos()
        };
        surface.nodes.iter().map(at).collect()
    };
    let shapes = [0.0, 2.0, 3.0].map(bend);
    let motions: Vec<ModalMotion<'_>> = shapes
        .iter()
        .zip([0.5, 0.8, 1.0])
        .map(|(shape, part)| ModalMotion { wavenumber: part * highest, shape })
        .collect();
    let solve = |solver: &dyn ModalSolver| {
        solver.transfers(&surface, &motions, &mut |_| ControlFlow::Continue(())).expect("a solution")
    };
    let axisymmetric = solve(&AxisymmetricModalSolver::new(&meridian.about_centre_of_mass(), DVec3::Y));
    let triangles = solve(&BemModalSolver::try_new(&mesh, highest, accuracy).expect("a mesh"));
    let mut worst = (0.0_f64, 0.0_f64);
    for ((a, b), motion) in axisymmetric.iter().zip(&triangles).zip(&motions) {
        let kappa = motion.wavenumber * radius;
        let (mut wrong, mut size) = (0.0, 0.0);
        for k in 0..80 {
            let z = 1.0 - (2.0 * f64::from(k) + 1.0) / 80.0;
            let (sin, cos) = (2.4 * f64::from(k)).sin_cos();
            let x = 2.0 * DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
            wrong += (a.undelayed(x, kappa) - b.undelayed(x, kappa)).norm_sqr();
            size += a.undelayed(x, kappa).norm_sqr();
        }
        let (field, power) = (f64::sqrt(wrong / size), b.power(kappa) / a.power(kappa) - 1.0);
        worst = (worst.0.max(field), worst.1.max(power.abs()));
    }
    worst
}

#[test]
fn a_coin_rings_alike() {
    let (field, power) = compare("coin", 2e-3, 350.0, 5e-3);
    // Residuals seen: 2.6 % of m = 0, whose middle and rim cancel, 1.1 % of the others; 2.1 %, too low at the
    // shortest wave.
    assert!(field < 0.04 && power < 0.03, "{field} {power}");
}

#[test]
fn a_bowl_rings_alike() {
    let (field, power) = compare("bowl", 6e-3, 60.0, 0.02);
    // Residuals seen: 1.0 % and 1.9 %.
    assert!(field < 0.02 && power < 0.03, "{field} {power}");
}
