//! The gap between two surfaces: angles, rotations, bounds, and where Hertz's theory ends.

use clangor_core::body::{Body, BodyId, Surface};
use clangor_core::contact::hertz::HertzContact;
use clangor_core::contact::relative_curvature::RelativeCurvature;
use clangor_core::contact::{
    ContactSide, ForceSettings, HertzRange, Impact, ImpactSolver, contact_forces, no_modes,
};
use clangor_core::geometry::principal_curvature::Curvature;
use clangor_core::glam::{DMat3, DQuat, DVec3};
use clangor_core::material::presets;
use clangor_core::pose::Pose;
use clangor_core::shape::Shape;
use proptest::prelude::*;

/// A side with these principal curvatures [1/m], the first along `direction`, under the normal y.
fn side(principal: [f64; 2], direction: DVec3) -> ContactSide {
    let curvature = Curvature { principal, direction }.tensor(DVec3::Y);
    ContactSide { curvature, least_curvature: 2.0, ..ContactSide::SURROUNDINGS }
}

fn between(a: ContactSide, b: ContactSide) -> RelativeCurvature {
    RelativeCurvature::between(&[a, b], DVec3::Y)
}

#[test]
fn crossed_cylinders_of_equal_radius_touch_as_a_ball_of_that_radius_on_a_plane() {
    let crossed = between(side([50.0, 0.0], DVec3::X), side([50.0, 0.0], DVec3::Z));
    let ball = between(side([50.0; 2], DVec3::X), ContactSide::SURROUNDINGS);
    assert_eq!((crossed.range, ball.range), (HertzRange::Within, HertzRange::Within));
    let stiffness = |relative: RelativeCurvature| {
        HertzContact { inverse_mass: 1.0, relative_radii: relative.radii, compliance: 1e-11, speed: 1.0 }
            .stiffness()
    };
    // Residual seen: 4e-16.
    assert!((stiffness(crossed) / stiffness(ball) - 1.0).abs() < 1e-13);
    // Parallel, they touch along a line, whose larger radius is the size.
    let parallel = between(side([50.0, 0.0], DVec3::X), side([50.0, 0.0], DVec3::X));
    assert_eq!((parallel.radii, parallel.range), ([0.5, 0.01], HertzRange::Line));
}

#[test]
fn directions_at_an_angle_add_as_johnson_has_it() {
    for angle in [0.0, 0.3, 1.0, 1.5, 2.4_f64] {
        let (a, b) = ([90.0, 20.0], [60.0, -8.0]);
        let turned = DVec3::new(angle.cos(), 0.0, angle.sin());
        let found = between(side(a, DVec3::X), side(b, turned));
        // 2 (B − A) = √((Δa)² + (Δb)² + 2 Δa Δb cos 2α), Johnson eq. (4.4).
        let (first, second) = (a[0] - a[1], b[0] - b[1]);
        let apart = (first * first + second * second + 2.0 * first * second * (2.0 * angle).cos()).sqrt();
        let sum = a[0] + a[1] + b[0] + b[1];
        for (radius, twice) in found.radii.iter().zip([sum - apart, sum + apart]) {
            // Residual seen: 4e-16.
            assert!((radius * 0.5 * twice - 1.0).abs() < 1e-12, "{angle}: {found:?}");
        }
    }
}

#[test]
fn edges_and_sizes_bound_the_radii_and_say_so() {
    let flat = ContactSide { least_curvature: 5.0, ..ContactSide::SURROUNDINGS };
    let edge = ContactSide { edge_radius: 1e-3, ..side([1e6, 3.0], DVec3::X) };
    let within = |radii: [f64; 2], wanted: [f64; 2]| {
        radii.iter().zip(wanted).all(|(radius, wanted)| (radius / wanted - 1.0).abs() < 1e-9)
    };
    let relative = between(edge, ContactSide { least_curvature: 0.0, ..flat });
    assert!(within(relative.radii, [1.0 / 3.0, 1e-3]) && relative.range == HertzRange::Within);
    let corner = ContactSide { edge_radius: 1e-3, ..side([1e6, 4e3], DVec3::Z) };
    assert!(within(between(corner, flat).radii, [1e-3; 2]));
    // Flat on flat, a ball in a close-fitting bowl, a ball in a groove, and on a saddle.
    let ball = side([100.0; 2], DVec3::X);
    for (a, b, radii, range) in [
        (flat, flat, [0.2; 2], HertzRange::Conforming),
        (ball, side([-99.0; 2], DVec3::X), [0.5; 2], HertzRange::Conforming),
        (ball, side([-300.0; 2], DVec3::X), [0.5; 2], HertzRange::Conforming),
        (ball, side([0.0, -150.0], DVec3::X), [0.5, 0.01], HertzRange::Saddle),
        (ball, side([40.0, -60.0], DVec3::Z), [1.0 / 40.0, 1.0 / 140.0], HertzRange::Within),
        (ball, side([0.0, -99.5], DVec3::Z), [0.5, 0.01], HertzRange::Line),
    ] {
        let found = between(a, b);
        assert!(within(found.radii, radii) && found.range == range, "{found:?}");
    }
}

#[test]
fn soft_balls_that_give_way_too_far_are_counted_as_deep() {
    let outcome = |name: &str, speed: f64| {
        let ball = Body::sphere("ball", presets::preset(name).unwrap().clone(), 0.02);
        let above = Pose::at(DVec3::Y * 0.02);
        let struck = ContactSide::of_body(BodyId(0), &ball, above).touched_at(
            &ball.surface,
            DVec3::Y,
            std::iter::once((DVec3::ZERO, 1.0)),
        );
        let impact =
            Impact::with_restitution([struck, ContactSide::SURROUNDINGS], DVec3::ZERO, DVec3::Y, speed, 0.5);
        let (contact, range) = impact.hertz();
        let solver = &mut ImpactSolver::default();
        let pulses = contact_forces(&impact, &no_modes, &ForceSettings::default(), solver).unwrap();
        assert_eq!(pulses[0].range, range);
        (contact.largest_approach() / 0.02, range)
    };
    for (name, speed) in [("steel", 5.0), ("rubber", 0.5), ("rubber", 20.0)] {
        let (share, range) = outcome(name, speed);
        println!("{name} at {speed} m/s: {share:.4} of the radius");
        assert_eq!(range, if share > 0.2 { HertzRange::Deep } else { HertzRange::Within });
    }
    assert_eq!(outcome("rubber", 20.0).1, HertzRange::Deep);
}

#[test]
fn a_cylinder_on_its_side_and_an_ellipsoid_are_known_by_their_meshes() {
    let touched = |text: &str, point: DVec3| {
        let (surface, mass) = Shape::parse(text).unwrap().surface().unwrap();
        let body = Body::solid("body", presets::STEEL.material(), surface, &mass);
        let pose = Pose {
            position: DVec3::new(0.3, 0.1, -0.2),
            orientation: DQuat::from_scaled_axis(DVec3::new(0.7, -0.2, 1.1)),
        };
        let place = pose.world_from_body(point);
        let outward = body.surface.normal_at(point).unwrap();
        let normal = pose.orientation * outward;
        let side = ContactSide::of_body(BodyId(0), &body, pose);
        let side = side.touched_at(&body.surface, normal, std::iter::once((place, 1.0)));
        RelativeCurvature::between(&[side, ContactSide::SURROUNDINGS], normal)
    };
    let cylinder = touched("cylinder:0.01x0.06@0.001", DVec3::new(0.01, 0.003, 0.0));
    println!("{cylinder:?}");
    let size = 0.03_f64.hypot(0.01);
    // Residuals seen: 0 and 7e-4.
    assert!(cylinder.range == HertzRange::Line && (cylinder.radii[0] / size - 1.0).abs() < 1e-6);
    assert!((cylinder.radii[1] / 0.01 - 1.0).abs() < 3e-3);
    // Half axes 20, 10 and 15 mm: at the end of the 20 mm, R = 15²/20 and 10²/20 mm.
    let ellipsoid = touched("ellipsoid:0.02x0.01x0.015@0.0005", DVec3::X * 0.02);
    println!("{ellipsoid:?}");
    assert_eq!(ellipsoid.range, HertzRange::Within);
    // Residuals seen: 6e-4 and 1.4e-3.
    assert!((ellipsoid.radii[0] / 0.01125 - 1.0).abs() < 5e-3);
    assert!((ellipsoid.radii[1] / 0.005 - 1.0).abs() < 5e-3);
}

fn turns() -> impl Strategy<Value = DQuat> {
    prop::array::uniform3(-3.0..3.0).prop_map(|axis| DQuat::from_scaled_axis(DVec3::from_array(axis)))
}

proptest! {
    #[test]
    fn radii_do_not_depend_on_the_orientation_of_the_whole(
        turn in turns(),
        principal in prop::array::uniform4(-40.0..200.0),
        angle in 0.0..3.0,
        edge_radius in 0.002..0.02,
    ) {
        let sorted = |a: f64, b: f64| [a.max(b), a.min(b)];
        let turned = DVec3::new(f64::cos(angle), 0.0, f64::sin(angle));
        let a = ContactSide { edge_radius, ..side(sorted(principal[0], principal[1]), DVec3::X) };
        let b = side(sorted(principal[2], principal[3]), turned);
        let here = between(a, b);
        let matrix = DMat3::from_quat(turn);
        let there = |side: ContactSide| ContactSide {
            curvature: matrix * side.curvature * matrix.transpose(),
            ..side
        };
        let whole = RelativeCurvature::between(&[there(b), there(a)], turn * -DVec3::Y);
        for (one, other) in here.radii.iter().zip(whole.radii) {
            // Relative to the curvatures, of up to 400/m; the radii themselves cancel.
            prop_assert!((1.0 / one - 1.0 / other).abs() < 1e-10, "{here:?} {whole:?}");
        }
        prop_assert!(here.radii[0] >= here.radii[1]);
    }

    #[test]
    fn a_tensor_has_its_principal_curvatures(turn in turns(), a in -50.0..50.0, b in -50.0..50.0) {
        let principal = [f64::max(a, b), f64::min(a, b)];
        let curvature = Curvature { principal, direction: turn * DVec3::X };
        let found = Curvature::of_tensor(curvature.tensor(turn * DVec3::Y), turn * DVec3::Y);
        for (found, wanted) in found.principal.iter().zip(principal) {
            prop_assert!((found - wanted).abs() < 1e-12);
        }
        // The direction is known where the curvatures differ.
        let along = found.direction.dot(curvature.direction).abs();
        prop_assert!((principal[0] - principal[1]) * (1.0 - along) < 1e-10, "{found:?}");
    }
}

#[test]
fn surfaces_of_closed_form_have_their_curvature() {
    let ball = Surface::Sphere { radius: 0.02 }.curvature_at(DVec3::new(0.01, 0.0, 0.017));
    assert_eq!(ball.principal, [50.0; 2]);
    assert_eq!(Surface::HalfSpace.curvature_at(DVec3::X), Curvature::FLAT);
    let (mesh, _) = Shape::parse("torus:0.03x0.01@0.001").unwrap().surface().unwrap();
    let point = DVec3::new(0.04, 0.0, 0.0);
    let [once, twice] = [mesh.curvature_at(point), mesh.clone().scaled(2.0).curvature_at(point * 2.0)];
    // κ = 1/r around the tube, 1/(R + r) around the axis.
    for (found, exact) in once.principal.iter().zip([100.0, 25.0]) {
        // Residuals seen: 3e-4 and 1.4e-4.
        assert!((found / exact - 1.0).abs() < 0.01);
    }
    assert!(once.direction.y.abs() > 0.999, "{once:?}");
    for (once, twice) in once.principal.iter().zip(twice.principal) {
        assert!((2.0 * twice / once - 1.0).abs() < 1e-9);
    }
}
