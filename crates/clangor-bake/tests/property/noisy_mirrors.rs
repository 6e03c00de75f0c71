//! Mirror planes of meshes with noise, as scans have them.

use clangor_bake::geometry_class::mirror_symmetry::{mirror_planes, mirror_planes_in_mean};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::shape::Shape;
use glam::{DQuat, DVec3};

/// A turned mug whose vertices are off by up to `noise` \[m\] along each axis.
fn noisy_mug(noise: f64) -> TriMesh {
    let mut mesh = Shape::parse("mug").expect("a shape").mesh();
    let turn = DQuat::from_scaled_axis(DVec3::new(0.3, -0.8, 0.5));
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    mesh.vertices.iter_mut().for_each(|v| *v = turn * *v + DVec3::new(random(), random(), random()) * noise);
    mesh.relative_to(MassProperties::of(&mesh).expect("a solid").centre_of_mass)
}

#[test]
fn noise_hides_no_mirror_plane_and_a_different_side_does() {
    let (noise, tolerance) = (4e-5, 5e-5);
    let mug = noisy_mug(noise);
    assert_eq!(mirror_planes(&mug, tolerance).len(), 0);
    let planes = mirror_planes_in_mean(&mug, tolerance, tolerance);
    assert_eq!(planes.len(), 1);
    // Through the axis and the handle, which is towards +x: along z before it was turned.
    let turn = DQuat::from_scaled_axis(DVec3::new(0.3, -0.8, 0.5));
    assert!((turn.inverse() * planes[0].normal).z.abs() > 1.0 - 1e-5, "{planes:?}");
    assert!(planes[0].residual > tolerance && planes[0].residual < 10.0 * tolerance, "{planes:?}");
    // One side is wider by a millimetre.
    let mut wider = mug.clone();
    let normal = planes[0].normal;
    for v in &mut wider.vertices {
        *v += normal * 0.03 * v.dot(normal).max(0.0);
    }
    let wider = wider.relative_to(MassProperties::of(&wider).expect("a solid").centre_of_mass);
    assert_eq!(mirror_planes_in_mean(&wider, tolerance, tolerance).len(), 0);
}

#[test]
fn noise_above_the_tolerance_hides_no_plane_and_a_dent_of_its_size_does() {
    let (noise, tolerance) = (1.2e-4, 5e-5);
    let mug = noisy_mug(noise);
    let planes = mirror_planes_in_mean(&mug, tolerance, tolerance);
    assert_eq!(planes.len(), 1);
    // Distances without a mean are twice as large; the largest seen is 4.1e-4 m.
    assert!(planes[0].residual > 2.0 * tolerance, "{planes:?}");
    // A dent of 0.8 mm, 30 mm wide, on one side.
    let normal = planes[0].normal;
    let side =
        mug.vertices.iter().copied().max_by(|a, b| a.dot(normal).total_cmp(&b.dot(normal))).expect("one");
    let mut dented = mug.clone();
    for v in dented.vertices.iter_mut().filter(|v| v.distance(side) < 0.015) {
        *v -= 8e-4 * normal;
    }
    let dented = dented.relative_to(MassProperties::of(&dented).expect("a solid").centre_of_mass);
    assert_eq!(mirror_planes_in_mean(&dented, tolerance, tolerance).len(), 0);
}
