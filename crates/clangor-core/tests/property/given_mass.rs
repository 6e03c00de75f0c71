//! Bodies whose mass, centre of mass and inertia are given: they lie where the geometry says, and turn
//! about the given point.

use clangor_core::body::{Body, Surface};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::glam::{DMat3, DVec3};
use clangor_core::scene::diagnostic::SceneErrors;
use clangor_core::scene::instantiate::load_shape;
use clangor_core::scene::{Scene, instantiate};

/// The body of a scene of one.
fn body(lines: &str) -> Body {
    let scene = Scene::from_toml(&format!("version = 1\n[[body]]\nmaterial = \"steel\"\n{lines}\n"));
    let scene = scene.unwrap_or_else(|e| panic!("{lines}\n{e}"));
    instantiate(&scene, &mut load_shape).unwrap().world.bodies.remove(0)
}

/// The only error of such a scene.
#[track_caller]
fn refusal(lines: &str) -> String {
    let text = format!("version = 1\n[[body]]\nmaterial = \"glass\"\n{lines}\n");
    let SceneErrors(errors) = Scene::from_toml(&text).expect_err(&text);
    assert_eq!(errors.len(), 1, "{}", SceneErrors(errors));
    errors[0].to_string()
}

const BOX: &str = "shape = \"box:0.1x0.04x0.06\"";

#[test]
fn a_given_mass_scales_the_inertia_and_a_given_inertia_replaces_it() {
    let solid = body(BOX);
    let heavy = body(&format!("{BOX}\nmass = 10"));
    assert_eq!(heavy.mass, 10.0);
    let ratio = heavy.mass / solid.mass;
    assert!(heavy.inertia.abs_diff_eq(solid.inertia * ratio, 1e-15));
    assert_eq!(heavy.surface, solid.surface);

    let turned =
        body(&format!("{BOX}\ninertia = [[4e-3, 1e-3, 0], [1e-3, 5e-3, 0], [0, 0, 6e-3]]\nmass = 2"));
    let expected = DMat3::from_cols_array_2d(&[[4e-3, 1e-3, 0.0], [1e-3, 5e-3, 0.0], [0.0, 0.0, 6e-3]]);
    assert_eq!((turned.mass, turned.inertia), (2.0, expected));
}

#[test]
fn the_surface_stays_where_the_origin_of_the_geometry_is() {
    let lines = "orientation = { axis = [0, 0, 1], degrees = 90 }\norigin = [1, 2, 3]";
    let centred = body(&format!("{BOX}\n{lines}"));
    let loaded = body(&format!("{BOX}\n{lines}\ncentre_of_mass = [0.03, 0.01, -0.02]"));
    // The quarter turn takes x to y and y to −x.
    assert!(loaded.pose.position.distance(DVec3::new(1.0 - 0.01, 2.03, 3.0 - 0.02)) < 1e-15);
    let (Surface::Mesh(a), Surface::Mesh(b)) = (&*centred.surface, &*loaded.surface) else { panic!("boxes") };
    for (a, b) in a.mesh.vertices.iter().zip(&b.mesh.vertices) {
        let apart = centred.pose.world_from_body(*a).distance(loaded.pose.world_from_body(*b));
        assert!(apart < 1e-15, "{apart:.1e}");
    }
    // What radiates is the same solid, off the origin of the body.
    let form = loaded.homogeneous();
    assert!(form.centre_of_mass.distance(DVec3::new(-0.03, -0.01, 0.02)) < 1e-15);
    assert!((form.volume / centred.homogeneous().volume - 1.0).abs() < 1e-12);
    assert!(centred.form_of_uneven().is_none() && loaded.form_of_uneven().is_some());
    // The scale of a file counts before: metres are metres.
    let scaled = body("shape = \"box:100x40x60\"\nscale = 0.001\ncentre_of_mass = [0.03, 0.01, -0.02]");
    let shift = scaled.homogeneous().centre_of_mass;
    assert!(shift.distance(DVec3::new(-0.03, -0.01, 0.02)) < 1e-15, "{shift}");
}

#[test]
fn a_ball_with_a_weight_collides_as_a_ball() {
    let ball = body("shape = \"sphere:0.05\"\ncentre_of_mass = [0, -0.02, 0]\nmass = 1");
    let Surface::Mesh(surface) = &*ball.surface else { panic!("a mesh about the centre of mass") };
    assert_eq!(surface.parts.len(), 1);
    for direction in [DVec3::X, DVec3::Y, DVec3::new(1.0, 2.0, -3.0).normalize()] {
        let touched = DVec3::new(0.0, 0.02, 0.0) + 0.05 * direction;
        let curvature = ball.surface.curvature_at(touched);
        assert!((curvature.mean() * 0.05 - 1.0).abs() < 1e-9, "{curvature:?}");
    }
    // The form is that of the facets, which enclose less than the ball.
    let volume = MassProperties::of_sphere(0.05).volume;
    assert!((ball.homogeneous().volume / volume - 1.0).abs() < 0.01);
    // 40 % of the inertia of a homogeneous ball of 1 kg; no inertia was given.
    assert!((ball.inertia.x_axis.x / (0.4 * 0.05 * 0.05) - 1.0).abs() < 1e-12);
}

#[test]
fn copies_share_what_is_given() {
    let text = format!("{BOX}\nmass = 3\ncentre_of_mass = [0.01, 0, 0]\npositions = [[0, 0, 0], [0, 1, 0]]");
    let scene = Scene::from_toml(&format!("version = 1\n[[body]]\nmaterial = \"steel\"\n{text}")).unwrap();
    let bodies = instantiate(&scene, &mut load_shape).unwrap().world.bodies;
    assert!(bodies.iter().all(|body| body.mass == 3.0));
    assert!(std::sync::Arc::ptr_eq(&bodies[0].surface, &bodies[1].surface));
}

#[test]
fn regression_impossible_mass_properties_are_refused_at_their_place() {
    for (lines, wanted) in [
        ("mass = 0", "body[0].mass"),
        ("mass = -1", "body[0].mass"),
        ("mass = inf", "body[0].mass"),
        ("centre_of_mass = [0, 1]", "body[0].centre_of_mass"),
        ("centre_of_mass = [0, nan, 0]", "body[0].centre_of_mass[1]"),
        ("inertia = [1, 1, 1]", "body[0].inertia[0]"),
        ("inertia = [[1, 0, 0], [0, 1, 0]]", "three rows"),
        ("inertia = [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]", "a symmetric matrix"),
        ("inertia = [[1, 2, 0], [2, 1, 0], [0, 0, 1]]", "principal moments above 0"),
        ("inertia = [[0, 0, 0], [0, 0, 0], [0, 0, 0]]", "principal moments above 0"),
        ("mass = 1\nfracture = {}", "whose pieces are homogeneous"),
        ("mass = 1\nscale = [1, 2]\npositions = [[0, 0, 0], [1, 0, 0]]", "a range of scales"),
    ] {
        let found = match lines {
            // Three numbers are three faults of one kind.
            "inertia = [1, 1, 1]" => {
                let text = format!("version = 1\n[[body]]\nmaterial = \"glass\"\n{BOX}\n{lines}\n");
                Scene::from_toml(&text).expect_err(&text).to_string()
            }
            _ => refusal(&format!("{BOX}\n{lines}")),
        };
        assert!(found.contains(wanted), "{lines}: {found}");
    }
    // So far off that the body has no size of this world.
    let scene = format!(
        "version = 1\n[[body]]\nmaterial = \"steel\"\n{BOX}\ncentre_of_mass = [9e4, 0, 0]\nmass = 1\n"
    );
    let refused = instantiate(&Scene::from_toml(&scene).unwrap(), &mut load_shape).expect_err("too large");
    assert!(refused.to_string().contains("bounding radius"), "{refused}");
}
