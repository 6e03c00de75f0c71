//! Mass properties against closed forms, and their invariances.

use std::f64::consts::PI;

use clangor_core::body::Surface;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::principal_axes::principal_axes;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::{DMat3, DQuat, DVec3};
use clangor_core::shape::Shape;
use proptest::prelude::*;

fn mesh(text: &str) -> TriMesh {
    Shape::parse(text).unwrap().mesh()
}

fn mass(mesh: &TriMesh) -> MassProperties {
    MassProperties::of(mesh).unwrap()
}

/// Prints a residual and holds it below a limit.
fn below(what: &str, residual: f64, limit: f64) {
    println!("{what}: {residual:.1e} (limit {limit:.0e})");
    assert!(residual < limit, "{what}: {residual:e}, limit {limit:e}");
}

/// Largest entry of a matrix.
fn norm(m: DMat3) -> f64 {
    m.to_cols_array().iter().fold(0.0, |most, x| most.max(x.abs()))
}

#[test]
fn a_box_is_exact() {
    let (x, y, z) = (0.1, 0.05, 0.2);
    let found = mass(&mesh("box:0.1x0.05x0.2@0.02"));
    let volume = x * y * z;
    let moments = DVec3::new(y * y + z * z, x * x + z * z, x * x + y * y) * volume / 12.0;
    // Residuals seen: 4e-15, 2e-15, 1e-18 m.
    let inertia = norm(found.inertia - DMat3::from_diagonal(moments)) / moments.max_element();
    below("box volume", (found.volume / volume - 1.0).abs(), 1e-14);
    below("box inertia", inertia, 1e-14);
    below("box centre", found.centre_of_mass.length(), 1e-16);
}

#[test]
fn a_tetrahedron_off_the_origin_is_exact() {
    // The corner tetrahedron of edge a: V = a³/6, centre a/4 (1, 1, 1); about the centre I_xx = a⁵/80, I_xy =
    // a⁵/480.
    let a = 0.3;
    let far = DVec3::new(1.0, -2.0, 3.0);
    let vertices = vec![far, far + DVec3::X * a, far + DVec3::Y * a, far + DVec3::Z * a];
    let solid = TriMesh { vertices, triangles: vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]] };
    let found = mass(&solid);
    let fifth = a.powi(5);
    let exact = DMat3::from_diagonal(DVec3::splat(fifth / 80.0 - fifth / 480.0)) + ones() * (fifth / 480.0);
    // Residuals seen: 2e-16, 3e-16 m, 6e-16.
    below("tetrahedron volume", (found.volume / (a.powi(3) / 6.0) - 1.0).abs(), 5e-15);
    below("tetrahedron centre", (found.centre_of_mass - far - DVec3::splat(a / 4.0)).length(), 5e-15);
    below("tetrahedron inertia", norm(found.inertia - exact) / norm(exact), 1e-14);
}

fn ones() -> DMat3 {
    DMat3::from_cols(DVec3::ONE, DVec3::ONE, DVec3::ONE)
}

#[test]
fn a_body_far_away_keeps_its_inertia() {
    // A bowl at 1 km: coordinates keep 1e-13 m, a share of 1e-12 of the bowl.
    let near = mesh("bowl");
    let far = near.relative_to(DVec3::new(-600.0, 500.0, 700.0));
    let (a, b) = (mass(&near), mass(&far));
    // Residuals seen: 6e-13 and 7e-13.
    below("far volume", (b.volume / a.volume - 1.0).abs(), 5e-12);
    below("far inertia", norm(b.inertia - a.inertia) / norm(a.inertia), 5e-12);
}

#[test]
fn closed_forms_of_shapes_agree_with_their_meshes() {
    // Every tolerance is about twice the residual seen; the mesh is inscribed, so it is always lighter.
    for (text, tolerance) in [
        ("ellipsoid:0.02x0.01x0.015@0.0004", 3e-4),
        ("cylinder:0.02x0.05@0.0005", 2e-4),
        ("coin@0.0003", 2e-4),
        ("torus:0.03x0.01@0.0006", 1.2e-3),
    ] {
        let shape = Shape::parse(text).unwrap();
        let (Surface::Mesh(_), exact) = shape.surface().unwrap() else { panic!("{text} is no mesh") };
        let found = mass(&shape.mesh());
        let lacking = 1.0 - found.volume / exact.volume;
        let inertia = norm(found.inertia - exact.inertia) / norm(exact.inertia);
        assert!(lacking > 0.0, "{text}: {lacking}");
        below(&format!("{text} volume"), lacking, tolerance);
        below(&format!("{text} inertia"), inertia, 2.0 * tolerance);
    }
}

#[test]
fn a_bowl_has_the_volume_of_its_profile() {
    // By hand from the sizes in the documentation (Pappus: spherical zones, cones, cylinders, half-round
    // rims).
    let zone = |r: f64, from: f64, to: f64| 2.0 * PI * r.powi(3) / 3.0 * (from.cos() - to.cos());
    // Bowl: the shell between two spheres down to its base, with a floor and a foot. Its solid is the outer
    // sphere's segment minus the inner one's, both from the foot to the rim's angle.
    let (centre, inner, outer, base, floor, rim) =
        (0.0735_f64, 0.068_f64, 0.0735_f64, 0.030_f64, 0.024_f64, 1.40_f64);
    let segment = |r: f64, low: f64| {
        // The sphere's part between the cone of the rim and the plane that cuts it at radius `low`.
        let angle = (low / r).asin();
        zone(r, angle, rim) + PI * low * low * (r * angle.cos()) / 3.0
    };
    let below_outer = PI * base * base * (centre - (outer * outer - base * base).sqrt());
    let half_round = 0.5 * (outer - inner);
    // Pappus: a half disc of radius s, its centroid 4s/3π beyond the middle of the rim, along the rim's
    // direction.
    let reach = 0.5 * (outer + inner) * rim.sin() + 4.0 * half_round / (3.0 * PI) * rim.cos();
    let round = 0.5 * PI * half_round * half_round * 2.0 * PI * reach;
    let exact = segment(outer, base) + below_outer - segment(inner, floor) + round;
    let found = mass(&mesh("bowl@0.0012")).volume;
    // Chords of 1.2 mm lack 9e-4 of the volume.
    below("bowl volume", (1.0 - found / exact).abs(), 1.5e-3);
}

#[test]
fn principal_axes_of_a_tilted_box_are_its_edges() {
    let turn = DQuat::from_scaled_axis(DVec3::new(0.4, -1.1, 0.7));
    let mut tilted = mesh("box:0.1x0.05x0.2");
    tilted.vertices.iter_mut().for_each(|v| *v = turn * *v + DVec3::new(3.0, 1.0, -2.0));
    let (moments, axes) = principal_axes(mass(&tilted).inertia);
    assert!(moments.x < moments.y && moments.y < moments.z);
    // Smallest moment about the longest edge. Residuals seen: 6e-16.
    for (axis, edge) in [(axes.x_axis, DVec3::Z), (axes.y_axis, DVec3::X), (axes.z_axis, DVec3::Y)] {
        below("axis", axis.cross(turn * edge).length(), 1e-14);
    }
    assert!((axes.determinant() - 1.0).abs() < 1e-14);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_moved_body_moves_its_centre_and_turns_its_inertia(
        axis in prop::array::uniform3(-3.0_f64..3.0),
        shift in prop::array::uniform3(-10.0_f64..10.0),
        seed in 0_u64..50,
    ) {
        let still = mesh(&format!("rock:{seed}x0.05@0.05"));
        let turn = DQuat::from_scaled_axis(DVec3::from_array(axis));
        let shift = DVec3::from_array(shift);
        let mut moved = still.clone();
        moved.vertices.iter_mut().for_each(|v| *v = turn * *v + shift);
        let (a, b) = (mass(&still), mass(&moved));
        let matrix = DMat3::from_quat(turn);
        // Coordinates near 10 round by 2e-15, a share of 4e-14 of the stone's radius.
        prop_assert!((b.volume / a.volume - 1.0).abs() < 1e-11);
        prop_assert!((b.centre_of_mass - (turn * a.centre_of_mass + shift)).length() < 1e-13);
        prop_assert!(norm(b.inertia - matrix * a.inertia * matrix.transpose()) < 1e-11 * norm(a.inertia));
    }
}
