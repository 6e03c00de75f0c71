//! From scene to world: masses, poses, names, links; and errors that depend on the geometry.

use std::f64::consts::PI;

use clangor_core::body::{BodyId, JointKind, Link, LinkEnd, Motion, Surface, World};
use clangor_core::glam::DVec3;
use clangor_core::material::Damping;
use clangor_core::pose::{Pose, Track};
use clangor_core::scene::body_description::{Geometry, GeometryReference};
use clangor_core::scene::diagnostic::{Doubt, Place, SceneErrors};
use clangor_core::scene::instantiate::{GeometryError, LoadedGeometry, load_shape, references};
use clangor_core::scene::listener::ListenerDescription;
use clangor_core::scene::{Scene, instantiate};

fn decode(text: &str) -> Scene {
    Scene::from_toml(&format!("version = 1\n{text}")).unwrap_or_else(|e| panic!("{text}\n{e}"))
}

fn world(text: &str) -> World {
    instantiate(&decode(text), &mut load_shape).unwrap_or_else(|e| panic!("{text}\n{e}")).world
}

/// The only error of a scene, as printed.
#[track_caller]
fn refusal(text: &str) -> String {
    let SceneErrors(errors) = instantiate(&decode(text), &mut load_shape).expect_err(text);
    assert_eq!(errors.len(), 1, "{}", SceneErrors(errors));
    errors[0].to_string()
}

const BALL: &str = "[[body]]\nname = \"ball\"\nshape = \"sphere:0.01\"\nmaterial = \"steel\"\n";

#[test]
fn a_body_has_the_mass_of_its_material_and_its_origin_where_asked() {
    let world = world(
        "[[body]]\nname = \"box\"\nshape = \"box:0.1x0.2x0.3\"\nmaterial = \"brass\"\nposition = [1, 2, 3]\n\
         orientation = { axis = [0, 0, 2], degrees = 90 }\nvelocity = [1, 0, 0]\nangular_velocity = [0, 1, \
         0]\n\
         [[body]]\nshape = \"mug\"\nmaterial = \"ceramic\"\norigin = [0, 0.5, 0]\nedge_radius = 0.002\n\
         orientation = { axis = [1, 0, 0], degrees = 180 }\n\
         [[plane]]\npoint = [0, -1, 0]\nnormal = [0, 3, 4]\nmaterial = \"wood\"",
    );
    let [cuboid, mug, plane] = world.bodies.as_slice() else { panic!("three bodies") };
    let mass = 8500.0 * 0.006;
    // Residuals seen here: at most 2.2e-16.
    assert!((cuboid.mass / mass - 1.0).abs() < 1e-14);
    let about_x = mass / 12.0 * (0.04 + 0.09);
    assert!((cuboid.inertia.x_axis.x / about_x - 1.0).abs() < 1e-14);
    assert_eq!(cuboid.pose.position, DVec3::new(1.0, 2.0, 3.0));
    assert!((cuboid.pose.orientation * DVec3::X - DVec3::Y).length() < 1e-15);
    assert_eq!((cuboid.velocity, cuboid.angular_velocity), (DVec3::X, DVec3::Y));
    assert!((cuboid.edge_radius / (0.02 * cuboid.surface.bounding_radius()) - 1.0).abs() < 1e-14);

    // Upside down: the foot is at the requested origin, the centre of mass 4 cm below it.
    assert_eq!(mug.edge_radius, 0.002);
    // A mug's centre of mass is 39.95 mm above its foot.
    assert!((mug.pose.position.y - (0.5 - 0.04)).abs() < 1e-4, "{}", mug.pose.position);
    let Surface::Mesh(surface) = &*mug.surface else { panic!("a mug is a mesh") };
    let top = surface.mesh.vertices.iter().map(|v| mug.pose.world_from_body(*v).y).fold(f64::MIN, f64::max);
    assert!((top - 0.5).abs() < 1e-12, "{top}");

    assert_eq!(
        (plane.mass, &*plane.surface, &plane.motion),
        (f64::INFINITY, &Surface::HalfSpace, &Motion::Fixed)
    );
    assert!((plane.pose.orientation * DVec3::Y - DVec3::new(0.0, 0.6, 0.8)).length() < 1e-15);
}

#[test]
fn scale_multiplies_lengths() {
    for (shape, volume) in
        [("sphere:2", 4.0 / 3.0 * PI * 8.0), ("box:1x2x3", 6.0), ("rock:5x2", 4.0 / 3.0 * PI * 8.0)]
    {
        let at = |scale: f64| {
            let reference =
                GeometryReference { geometry: Geometry::Shape(shape.into()), scale, centre_of_mass: None };
            load_shape(&reference).unwrap()
        };
        let (full, small) = (at(1.0), at(0.01));
        // Residuals seen: 2e-16 for sphere and box, 1.3e-14 for the rock.
        assert!((full.mass.volume / volume - 1.0).abs() < 1e-12, "{shape}");
        assert!((small.mass.volume / (1e-6 * volume) - 1.0).abs() < 1e-12, "{shape}");
        assert!(
            (small.surface.bounding_radius() / (0.01 * full.surface.bounding_radius()) - 1.0).abs() < 1e-12
        );
        let inertia = small.mass.inertia.z_axis.z / (1e-10 * full.mass.inertia.z_axis.z);
        assert!((inertia - 1.0).abs() < 1e-12, "{shape}: {inertia}");
    }
}

#[test]
fn copies_have_names_places_and_seeds_of_their_own() {
    let text = "[[body]]\nname = \"rock\"\nshape = \"rock:{n}x0.01@0.01\"\nscale = [0.5, 2.0]\nmaterial = \
        \"granite\"\n\
                count = 6\nplacement = { region = [[-0.1, 0.1, -0.1], [0.1, 0.4, 0.1]], orientation = \
                \"random\" }\n\
                [[body]]\nname = \"pin\"\nshape = \"sphere:0.01\"\nmaterial = \"wood\"\npositions = [[1, 1, \
                0], [1, 2, 0]]";
    let scene = decode(text);
    let world = world(text);
    let names: Vec<&str> = world.bodies.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names, ["rock-1", "rock-2", "rock-3", "rock-4", "rock-5", "rock-6", "pin-1", "pin-2"]);
    assert_eq!(world.bodies[7].pose.position, DVec3::new(1.0, 2.0, 0.0));
    let asked = references(&scene);
    // Six rocks, and one sphere for both pins.
    assert_eq!(asked.len(), 7);
    assert_eq!(asked[3].geometry, Geometry::Shape("rock:4x0.01@0.01".into()));
    assert!(asked[..6].iter().all(|r| (0.5..2.0).contains(&r.scale)));
    assert!(asked.windows(2).all(|pair| pair[0].scale != pair[1].scale));
    let mut requests = Vec::new();
    let instance = instantiate(&scene, &mut |reference: &GeometryReference| {
        requests.push(reference.clone());
        load_shape(reference)
    });
    assert_eq!(requests, asked);
    assert_eq!(instance.unwrap().world, world, "the same scene, the same world");
}

#[test]
fn a_seed_changes_the_placement_and_the_scene_supplies_it() {
    let text = |seed: &str, simulation: u64| {
        format!(
            "[simulation]\nseed = {simulation}\n{BALL}count = 3\n\
             placement = {{ region = [[0, 0, 0], [1, 1, 1]], max_spin = 5.0 {seed} }}"
        )
    };
    let positions = |text: &str| world(text).bodies.iter().map(|b| b.pose.position).collect::<Vec<_>>();
    assert_eq!(positions(&text("", 7)), positions(&text(", seed = 7", 1)));
    assert_ne!(positions(&text("", 7)), positions(&text("", 8)));
    let bodies = world(&text("", 7)).bodies;
    assert!(bodies.iter().all(|b| b.angular_velocity.length() <= 5.0));
    assert_ne!(bodies[0].angular_velocity, bodies[1].angular_velocity);
}

#[test]
fn copies_keep_clear_of_the_true_surface_of_what_stands_there() {
    // The balls fit inside the mug: its wall is avoided, not its bounding ball.
    let world = world(
        "[[body]]\nname = \"mug\"\nshape = \"mug\"\nmaterial = \"ceramic\"\norigin = [0, 0, 0]\n\
         [[body]]\nshape = \"sphere:0.005\"\nmaterial = \"steel\"\ncount = 20\n\
         placement = { region = [[-0.04, 0, -0.04], [0.04, 0.09, 0.04]] }\n[[plane]]\nmaterial = \"wood\"",
    );
    let mug = &world.bodies[0];
    let Surface::Mesh(surface) = &*mug.surface else { panic!("a mug is a mesh") };
    for ball in &world.bodies[1..21] {
        let clearance = surface.signed_distance(mug.pose.body_from_world(ball.pose.position));
        assert!(clearance >= 0.005 && ball.pose.position.y >= 0.005, "{}: {clearance}", ball.name);
    }
}

#[test]
fn links_find_their_bodies() {
    let world = world(
        "[[body]]\nname = \"bob\"\nshape = \"sphere:0.01\"\nmaterial = \"steel\"\npositions = [[0, 0, 0], \
         [1, 0, 0]]\n\
         [[body]]\nname = \"drawn\"\nshape = \"sphere:0.01\"\nmaterial = \"steel\"\nposition = [2, 0, 0]\n\
         [[hang]]\nbody = \"bob\"\noffset = [0, 1, 0]\n[[hang]]\nbody = \"drawn\"\nanchor = [3, 1, 0]\n\
         [[spring]]\nbody = \"bob-2\"\nto = \"drawn\"\nstiffness = 5\n\
         [[spring]]\nbody = \"drawn\"\nto = [2, 0, 3]\nstiffness = 6\nrest_length = 1\ndamping = 0.5",
    );
    let spring = |body, to, rest_length, stiffness, damping| Link::Spring {
        body,
        at: DVec3::ZERO,
        to,
        rest_length,
        stiffness,
        damping,
    };
    let expected = [
        Link::Hang { body: BodyId(0), anchor: DVec3::new(0.0, 1.0, 0.0) },
        Link::Hang { body: BodyId(1), anchor: DVec3::new(1.0, 1.0, 0.0) },
        Link::Hang { body: BodyId(2), anchor: DVec3::new(3.0, 1.0, 0.0) },
        spring(BodyId(1), LinkEnd::centre(BodyId(2)), 1.0, 5.0, 0.0),
        spring(BodyId(2), LinkEnd::Point(DVec3::new(2.0, 0.0, 3.0)), 1.0, 6.0, 0.5),
    ];
    assert_eq!(world.links, expected);
}

#[test]
fn joints_and_forces_find_their_points() {
    let world = world(
        "[[body]]\nname = \"bell\"\nshape = \"mug\"\nmaterial = \"brass\"\nposition = [0, 1, 0]\n\
         orientation = { axis = [0, 0, 1], degrees = 90 }\n\
         [[body]]\nname = \"clapper\"\nshape = \"sphere:0.01\"\nmaterial = \"steel\"\n\
         position = [0, 0.5, 0]\n\
         [[hinge]]\nbody = \"bell\"\npoint = [0, 1.1, 0]\naxis = [0, 3, 0]\n\
         [[ball_joint]]\nbody = \"clapper\"\nto = \"bell\"\npoint = [0, 1, 0]\ncollide = true\n\
         [[rod]]\nbody = \"clapper\"\nto = [0, 0.9, 0]\n\
         [[rope]]\nbody = \"clapper\"\nto = \"bell\"\nlength = 0.6\n\
         [[spring]]\nbody = \"clapper\"\npoint = [0, 0.51, 0]\nto = [0, 2, 0]\nstiffness = 5\n\
         [[force]]\nbody = \"clapper\"\nforce = [1, 0, 0]\nstart = 0.5\nend = 0.75\n\
         [[force]]\nbody = \"bell\"\ntorque = [[0, 1, 0, 0], [2, 0, 0, 0]]",
    );
    let Link::Joint { body: BodyId(0), at, kind: JointKind::Hinge { axis, .. }, collide: false, .. } =
        &world.links[1]
    else {
        panic!("{:?}", world.links)
    };
    // A quarter turn about z takes the body's x axis to y.
    assert!(at.distance(DVec3::X * 0.1) < 1e-12 && axis.distance(DVec3::X) < 1e-12);
    let Link::Joint { to: LinkEnd::Body { body: BodyId(0), at }, collide: true, .. } = &world.links[2] else {
        panic!("{:?}", world.links)
    };
    assert!(at.length() < 1e-12);
    let kinds: Vec<JointKind> = world.links[3..5]
        .iter()
        .map(|link| if let Link::Joint { kind, .. } = link { *kind } else { panic!("{link:?}") })
        .collect();
    assert!(matches!(kinds[0], JointKind::Rod { length } if (length - 0.4).abs() < 1e-12), "{kinds:?}");
    assert_eq!(kinds[1], JointKind::Rope { length: 0.6 });
    let Link::Spring { at, rest_length, .. } = &world.links[0] else { panic!("{:?}", world.links) };
    assert!(at.distance(DVec3::Y * 0.01) < 1e-12 && (rest_length - 1.49).abs() < 1e-12);
    let Link::Load { force, torque, .. } = &world.links[5] else { panic!("{:?}", world.links) };
    assert_eq!((force.integral(0.0, 9.0), torque.points().len()), (DVec3::X * 0.25, 0));
    let Link::Load { torque, .. } = &world.links[6] else { panic!("{:?}", world.links) };
    assert_eq!(torque.integral(0.0, 9.0), DVec3::X);
}

#[test]
fn hands_lead_bodies() {
    let keys = "keyframes = [{ time = 0, position = [0, 1, 0] }]";
    let led = |lines: &str| world(&format!("{BALL}{keys}\n{lines}")).bodies[0].motion.clone();
    assert!(matches!(led(""), Motion::Keyframed(_)));
    let Motion::Guided(guide) = led("press = 3\nlet_go = 0.5") else { panic!("not guided") };
    assert_eq!((guide.press, guide.let_go), (Some(3.0), Some(0.5)));
    assert!(led("let_go = 0.5").is_movable());
}

#[test]
fn impossible_links_are_refused() {
    let refusal = |lines: &str| refusal(&format!("{BALL}{lines}"));
    assert_eq!(
        refusal("[[hang]]\nbody = \"ball\"\noffset = [0, 0, 0]"),
        "6:1: hang[0]: the body `ball` has its centre at the anchor; move the anchor away from the centre"
    );
    assert!(
        refusal("motion = \"fixed\"\n[[hang]]\nbody = \"ball\"\noffset = [0, 1, 0]")
            .contains("not free to swing")
    );
    assert!(refusal("[[spring]]\nbody = \"ball\"\nto = \"ball\"\nstiffness = 1").contains("both ends"));
    let die = refusal(
        "[[body]]\nname = \"die\"\nshape = \"die\"\nmaterial = \"plastic\"\n[[hang]]\nbody = \"die\"\nanchor \
         = [0, 1, 0]",
    );
    assert!(die.contains("is not a sphere"), "{die}");
    let place = "position = [0, 1, 0]\n";
    for (lines, reason) in [
        ("[[rod]]\nbody = \"ball\"\nto = [0, 1, 0]", "lies at both ends"),
        ("[[rope]]\nbody = \"ball\"\nto = [0, 2, 0]\nlength = 0.9", "farther from the other end"),
        ("[[ball_joint]]\nbody = \"ball\"\nto = \"ball\"\npoint = [0, 1, 0]", "both ends of the link"),
        ("motion = \"fixed\"\n[[rope]]\nbody = \"ball\"\nto = [0, 2, 0]", "do not move"),
        ("motion = \"fixed\"\n[[force]]\nbody = \"ball\"\nforce = [1, 0, 0]", "no force moves it"),
    ] {
        let found = refusal(&format!("{place}{lines}"));
        assert!(found.contains(reason), "{lines}: {found}");
    }
}

#[test]
fn a_listener_inside_a_body_is_refused() {
    let at = |position: &str| {
        format!(
            "{BALL}position = [0, 1, 0]\n[[plane]]\nmaterial = \"wood\"\n[[listener]]\nposition = {position}"
        )
    };
    assert_eq!(
        refusal(&at("[0, 1.008, 0]")),
        "9:1: listener[0]: the listener is inside the body `ball` by 2.000e-3 m; \
         move the listener outside, or the body away from it"
    );
    assert!(refusal(&at("[5, -1, 0]")).contains("inside the body `plane-1` by 1.000e0 m"));
    // Behind a thin wall a listener is valid, inside a ball it is not.
    let thin = |position: &str| at(position).replace("\"wood\"", "\"wood\"\nthin = true");
    assert!(instantiate(&decode(&thin("[5, -1, 0]")), &mut load_shape).is_ok());
    assert!(refusal(&thin("[0, 1.008, 0]")).contains("inside the body `ball`"));
    // Under an endless plate it is valid, within its thickness it is not.
    let plate = |position: &str| at(position).replace("\"wood\"", "\"wood\"\nthickness = 0.02");
    assert!(instantiate(&decode(&plate("[5, -1, 0]")), &mut load_shape).is_ok());
    assert!(refusal(&plate("[5, -0.005, 0]")).contains("inside the body `plane-1` by 5.000e-3 m"));
    // One receiver of a pair, 8 cm to the right of a midpoint outside.
    assert!(refusal(&at("[-0.08, 1, 0]\nspacing = 0.16")).contains("inside the body `ball`"));
    let moving = "[0, 1, 0] }, { time = 1, position = [1, 1, 0] }]";
    let text = format!(
        "{BALL}[[listener]]\nkeyframes = [{{ time = 0, position = [0, 0, 0.1] }}, {{ time = 0.5, position = \
         {moving}"
    );
    assert!(instantiate(&decode(&text), &mut load_shape).is_ok());
    let mug =
        "[[body]]\nshape = \"mug\"\nmaterial = \"ceramic\"\norigin = [0, 0, 0]\n[[listener]]\nposition = ";
    // In the cavity a listener is valid, in the wall it is not.
    assert!(instantiate(&decode(&format!("{mug}[0, 0.05, 0]")), &mut load_shape).is_ok());
    assert!(refusal(&format!("{mug}[-0.0395, 0.05, 0]")).contains("inside the body `body-1`"));
}

#[test]
fn loader_errors_stand_at_the_key() {
    let text = format!(
        "{BALL}[[body]]\nmesh = \"lost.obj\"\nmaterial = \"wood\"\n[[body]]\nmesh = \"lost.obj\"\nmaterial = \
         \"wood\"\n\
         [[body]]\nmesh = \"torn.stl\"\nscale = 0.001\nmaterial = \"wood\""
    );
    let mut asked = Vec::new();
    let SceneErrors(errors) = instantiate(&decode(&text), &mut |reference: &GeometryReference| {
        asked.push(reference.to_string());
        match &reference.geometry {
            Geometry::File(path) if path == "lost.obj" => {
                Err(GeometryError { reason: "no such file".into(), remedy: "correct the path".into() })
            }
            Geometry::File(_) => {
                Err(GeometryError { reason: "the mesh is open".into(), remedy: "close its holes".into() })
            }
            Geometry::Shape(_) => load_shape(reference),
        }
    })
    .unwrap_err();
    let printed: Vec<String> = errors.iter().map(ToString::to_string).collect();
    // A file shared by two bodies is read, and reported, once.
    let expected = [
        "7:8: body[1].mesh: `lost.obj` cannot be used: no such file; correct the path",
        "13:8: body[3].mesh: `torn.stl (scale 0.001)` cannot be used: the mesh is open; close its holes",
    ];
    assert_eq!(printed, expected);
    assert_eq!(asked, ["sphere:0.01", "lost.obj", "torn.stl (scale 0.001)"]);
    assert!(
        refusal("[[body]]\nmesh = \"a.obj\"\nmaterial = \"wood\"").contains("no mesh files can be read here")
    );
}

#[test]
fn bad_files_are_reported_beside_the_errors_of_the_text() {
    let text = format!(
        "version = 1\n{BALL}velocty = 1\n[[body]]\nmesh = \"lost.obj\"\nmaterial = \"wood\"\nscale = -1\n\
                        [[body]]\nmesh = \"lost.obj\"\nmaterial = \"wood\""
    );
    let SceneErrors(errors) = Scene::from_toml_with_files(&text, &mut load_shape).unwrap_err();
    let fields: Vec<&str> = errors.iter().map(|e| e.place.field.as_str()).collect();
    // A body with errors is not loaded.
    assert_eq!(fields, ["body[0].velocty", "body[1].scale", "body[2].mesh"]);
}

#[test]
fn a_listener_that_is_added_later_is_checked_too() {
    let mut scene = decode(&format!("[render]\nfloor = \"rigid\"\n{BALL}position = [0, 1, 0]"));
    scene.listeners.push(ListenerDescription {
        name: "added".into(),
        track: Track::fixed(Pose::at(DVec3::new(0.0, -1.0, 0.0))),
        spacing: None,
        place: Place { field: "--listener".into(), ..Place::default() },
    });
    let SceneErrors(errors) = instantiate(&scene, &mut load_shape).unwrap_err();
    assert!(
        errors[0].to_string().starts_with("--listener: the listener at height -1 m is below"),
        "{}",
        errors[0]
    );
}

#[test]
fn sizes_are_judged() {
    let giant = |reference: &GeometryReference| -> Result<LoadedGeometry, GeometryError> {
        let shape =
            GeometryReference { geometry: Geometry::Shape("box:80x90x100".into()), ..reference.clone() };
        let mut loaded = load_shape(&shape)?;
        loaded.warnings.push("the mesh has no normals".into());
        Ok(loaded)
    };
    let body = "[[body]]\nmesh = \"mug.obj\"\nmaterial = \"ceramic\"\n";
    // 100 mm taken for 100 m: doubted; taken for 10 km: rejected.
    let mut load = giant;
    let warnings = instantiate(&decode(body), &mut load).unwrap().warnings;
    assert_eq!(warnings.len(), 2);
    assert_eq!(warnings[0].doubt, Doubt::Geometry { message: "the mesh has no normals".into() });
    assert!(
        warnings[1].to_string().starts_with("3:8: body[0].mesh: a bounding radius of 78"),
        "{}",
        warnings[1]
    );
    assert!(warnings[1].to_string().contains("scale = 0.001"));
    let SceneErrors(errors) = instantiate(&decode(&format!("{body}scale = 100")), &mut load).unwrap_err();
    assert!(errors[0].to_string().contains("is absurd"), "{}", errors[0]);
    let SceneErrors(errors) = instantiate(&decode(&format!("{body}scale = 1e-9")), &mut load).unwrap_err();
    assert!(errors[0].to_string().contains("is absurd"), "{}", errors[0]);
}

#[test]
fn copies_that_do_not_fit_are_refused() {
    let text = format!("{BALL}count = 50\nplacement = {{ region = [[0, 0, 0], [0.04, 0.04, 0.04]] }}");
    let error = refusal(&text);
    assert!(error.starts_with("7:13: body[0].placement: only "), "{error}");
    assert!(error.ends_with(
        "of 50 copies fit in the region without touching; enlarge the region, or lower `count` or `scale`"
    ));
}

#[test]
fn doubtful_scenes_are_accepted_with_a_warning() {
    let doubts = |text: &str| -> Vec<String> {
        let scene = decode(text);
        let instance = instantiate(&scene, &mut load_shape).unwrap();
        scene.warnings.iter().chain(&instance.warnings).map(ToString::to_string).collect()
    };
    let heard = "[[plane]]\nmaterial = \"wood\"\n[[listener]]\nposition = [0, 0.5, 0.5]\n";
    let drop = format!("{BALL}position = [0, 0.2, 0]\n{heard}");
    assert_eq!(doubts(&drop), Vec::<String>::new());
    assert!(doubts("")[0].contains("no listener"));
    assert!(doubts("")[1].contains("nothing moves"));
    assert!(doubts(&format!("gravity = [0, 0, 0]\n{drop}"))[0].contains("nothing moves"));
    assert!(
        doubts(&format!("{BALL}[[listener]]\nposition = [0, 0.5, 0.5]"))[0]
            .contains("nothing that it could hit")
    );
    assert_eq!(
        doubts(&format!(
            "{BALL}position = [0, 1, 0]\n[[plane]]\nmaterial = \"wood\"\n[[listener]]\nposition = [1000, 1, \
             0]"
        )),
        ["9:1: listener[0]: the nearest body is 1000 m away, so next to nothing is heard; move the \
             listener closer"]
    );
    assert!(
        doubts(&format!("[render]\nsample_rate = 22050\n{drop}"))[0]
            .starts_with("3:15: render.sample_rate: this sample rate cuts the band at 11025 Hz")
    );
    assert!(
        doubts(&format!("[simulation]\ntime_step = 0.005\n{drop}"))[0]
            .contains("a time step of 0.005 s is unusual")
    );
    assert!(
        doubts(
            &format!("{BALL}velocity = [0, 200, 0]\n{heard}")
                .replace("velocity", "position = [0, 1, 0]\nvelocity")
        )[0]
        .contains("a speed of 200 m/s")
    );
    // Gigapascals written as pascals.
    let soft = "[material.m]\nbase = \"steel\"\nyoungs_modulus = 200.0\n";
    assert!(doubts(&format!("{soft}{drop}"))[0].contains("a Young's modulus of 200 Pa is unusual"));
}

#[test]
fn damping_is_a_number_a_table_or_a_law_and_single_modes_go_first() {
    let damping = |keys: &str| {
        let text = format!("[material.m]\nbase = \"ceramic\"\n{keys}\n{}", BALL.replace("steel", "m"));
        world(&text).bodies[0].material.damping.clone()
    };
    let rows = vec![[100.0, 0.01], [2000.0, 0.002]];
    assert_eq!(damping("loss_factor = [[100, 0.01], [2000, 0.002]]"), Damping::LossFactorTable(rows.clone()));
    assert_eq!(damping("t60 = [[100, 0.01], [2000, 0.002]]"), Damping::T60Table(rows.clone()));
    let law = Damping::Rayleigh { alpha: 6.0, beta: 1e-7, g: 0.0 };
    assert_eq!(damping("rayleigh = { alpha = 6, beta = 1e-7 }"), law);
    let modes = |otherwise| Damping::Modes { t60: rows.clone(), otherwise: Box::new(otherwise) };
    let keys = "mode_t60 = [[100, 0.01], [2000, 0.002]]";
    assert_eq!(damping(keys), modes(Damping::LossFactor(0.002)));
    assert_eq!(damping(&format!("{keys}\nrayleigh = {{ alpha = 6, beta = 1e-7 }}")), modes(law));
}

#[test]
fn presets_of_the_papers() {
    let text = "[[body]]\npreset = \"pan-table\"\n[[body]]\nshape = \"sphere\"\nmaterial = \
        \"pan-steel\"\nposition = [0, 1, 0]\n\
                [[listener]]\npreset = \"pan-microphone\"\nspacing = 0.2\nfacing = [-1, 0, 0]";
    let scene = decode(text);
    let listener = &scene.listeners[0];
    let pose = listener.track.sample(0.0).0;
    assert_eq!(pose.position, DVec3::new(1.0, 1.8, 1.0));
    let receivers: Vec<DVec3> = listener.receivers().iter().map(|r| pose.world_from_body(*r)).collect();
    // Looking along −x with y up, −z is on the right. Residuals seen: 0.
    assert!((receivers[0] - DVec3::new(1.0, 1.8, 1.1)).length() < 1e-14, "{receivers:?}");
    assert!((receivers[1] - DVec3::new(1.0, 1.8, 0.9)).length() < 1e-14);
    let world = world(text);
    let table = &world.bodies[0];
    assert_eq!((&table.motion, table.material.name.as_str()), (&Motion::Fixed, "wood"));
    let Surface::Mesh(surface) = &*table.surface else { panic!("a table is a mesh") };
    let (low, high) = surface.mesh.bounds();
    assert!((high + table.pose.position - DVec3::new(0.9, 0.4, 0.4)).length() < 1e-12);
    assert!((low + table.pose.position - DVec3::new(-0.9, 0.37, -0.4)).length() < 1e-12);
    assert_eq!(
        (world.bodies[1].material.density, world.bodies[1].material.name.as_str()),
        (8940.0, "pan-steel")
    );
}
