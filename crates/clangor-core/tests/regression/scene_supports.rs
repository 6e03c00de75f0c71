//! What holds a body of a scene: keys, defaults, the frame of the coordinates; and every mistake with its
//! place and remedy, of the text alone and of text and shape together.

use std::f64::consts::TAU;

use clangor_core::body::support::{Support, SupportKind, SupportRegion};
use clangor_core::glam::DVec3;
use clangor_core::scene::diagnostic::SceneErrors;
use clangor_core::scene::instantiate::{instantiate, load_shape};
use clangor_core::scene::{Scene, support_description::POINT_RADIUS};

/// A fixed board of 40 × 2 × 10 cm with these lines in one support each.
fn board(motion: &str, supports: &[&str]) -> String {
    let mut text = format!(
        "version = 1\n[[body]]\nname = \"board\"\nshape = \"box:0.4x0.02x0.1\"\nmaterial = \"steel\"\n\
         motion = \"{motion}\"\n"
    );
    for support in supports {
        text += "[[body.support]]\n";
        text += support;
        text += "\n";
    }
    text
}

fn supports(text: &str) -> Result<(f64, Vec<Support>), SceneErrors> {
    let scene = Scene::from_toml(text)?;
    let body = instantiate(&scene, &mut load_shape)?.world.bodies.remove(0);
    Ok((body.mass, body.supports))
}

#[track_caller]
fn refuse(text: &str, place: &str, message: &str, remedy: &str) {
    let SceneErrors(errors) = supports(text).expect_err(text);
    let found: Vec<String> = errors.iter().map(ToString::to_string).collect();
    assert_eq!(errors.len(), 1, "\n{text}\n{}", found.join("\n"));
    let error = &errors[0];
    let at = format!("{}:{}: {}", error.place.line, error.place.column, error.place.field);
    assert_eq!(at, place, "{found:?}");
    assert!(error.problem.to_string().contains(message), "{found:?}");
    assert!(error.problem.remedy().contains(remedy), "{found:?}");
}

const ENDS: [&str; 2] = [
    "kind = \"clamped\"\nlow = [-1, -1, -1]\nhigh = [-0.15, 1, 1]",
    "kind = \"clamped\"\nlow = [0.15, -1, -1]\nhigh = [1, 1, 1]",
];

#[test]
fn regions_and_springs() {
    let (_, found) = supports(&board("fixed", &ENDS)).unwrap();
    let region = SupportRegion::Box { low: -DVec3::ONE, high: DVec3::new(-0.15, 1.0, 1.0) };
    assert_eq!(found[0], Support { region, kind: SupportKind::Clamped });
    let bed = "kind = \"sprung\"\nat = [0, 0, 0]\nradius = 1\nstiffness = [1e3, 2e3, 3e3]\ndamping = 4";
    let (_, found) = supports(&board("fixed", &[bed])).unwrap();
    let kind = SupportKind::Sprung { stiffness: DVec3::new(1e3, 2e3, 3e3), damping: DVec3::splat(4.0) };
    assert_eq!(found, [Support { region: SupportRegion::Ball { centre: DVec3::ZERO, radius: 1.0 }, kind }]);
}

#[test]
fn feet_carry_the_body_at_a_frequency() {
    let feet = "kind = \"feet\"\npoints = [[-0.19, -0.01, -0.04], [0.19, -0.01, -0.04], [0, -0.01, 0.04]]";
    for (lines, frequency, ratio) in [("", 15.0, 0.1), ("\nfrequency = 30\ndamping_ratio = 0.05", 30.0, 0.05)]
    {
        for motion in ["fixed", "free"] {
            let (mass, found) = supports(&board(motion, &[&format!("{feet}{lines}")])).unwrap();
            assert_eq!(found.len(), 3);
            let (mut stiffness, mut damping) = (0.0, 0.0);
            for support in &found {
                let SupportKind::Sprung { stiffness: k, damping: c } = support.kind else { panic!() };
                let SupportRegion::Ball { radius, .. } = support.region else { panic!() };
                assert!((radius / DVec3::new(0.2, 0.01, 0.05).length() / POINT_RADIUS - 1.0).abs() < 1e-12);
                (stiffness, damping) = (stiffness + k.y, damping + c.y);
            }
            let omega = TAU * frequency;
            assert!((stiffness / (mass * omega * omega) - 1.0).abs() < 1e-12, "{stiffness}");
            assert!((damping / (2.0 * ratio * mass * omega) - 1.0).abs() < 1e-12, "{damping}");
        }
    }
}

#[test]
fn coordinates_are_those_of_the_shape() {
    // The centre of mass of a bowl is above its origin.
    let text = "version = 1\n[[body]]\nshape = \"bowl\"\nmaterial = \"glass\"\nmotion = \"fixed\"\n\
                scale = 2.0\n[[body.support]]\nkind = \"clamped\"\nat = [0, 0, 0]\nradius = 0.03\n";
    let (_, found) = supports(text).unwrap();
    let (_, mass) = clangor_core::shape::Shape::parse("bowl").unwrap().surface().unwrap();
    let SupportRegion::Ball { centre, radius } = found[0].region else { panic!() };
    assert!(centre.distance(-2.0 * mass.centre_of_mass) < 1e-12 && radius == 0.03, "{centre}");
    assert!(mass.centre_of_mass.length() > 0.01);
}

#[test]
fn mistakes_of_the_text() {
    let one = |lines: &str| board("fixed", &[lines]);
    let place = |line: usize, column: usize, key: &str| format!("{line}:{column}: body[0].support[0].{key}");
    let refuse_one = |lines: &str, at: (usize, usize, &str), message: &str, remedy: &str| {
        refuse(&one(lines), &place(at.0, at.1, at.2), message, remedy);
    };
    let ball = "at = [0, 0, 0]\nradius = 1";
    refuse_one(
        &format!("{ball}\nkind = \"clampd\""),
        (10, 8, "kind"),
        "there is no",
        "did you mean `clamped`?",
    );
    refuse_one(
        &format!("kind = \"sprung\"\n{ball}\nstiffness = -1"),
        (11, 13, "stiffness"),
        "-1 is out of range",
        "from 0 to",
    );
    refuse_one(
        &format!("kind = \"sprung\"\n{ball}\nstiffness = [0, 0, 0]"),
        (11, 13, "stiffness"),
        "no stiffness along any axis",
        "above 0",
    );
    refuse_one(
        &format!("kind = \"clamped\"\n{ball}\nstiffness = 10"),
        (11, 13, "stiffness"),
        "cannot be combined",
        "keep either",
    );
    refuse_one(
        "kind = \"clamped\"\nat = [0, 0, 0]\nradius = -0.01",
        (10, 10, "radius"),
        "-0.01 is out of range",
        "above 0",
    );
    refuse_one(
        "kind = \"clamped\"\nlow = [0, 0, 0]\nhigh = [0.1, -0.1, 0.1]",
        (10, 8, "high"),
        "along y the box ends at -0.1 m",
        "lowest corner",
    );
    let text = board("free", &[&format!("kind = \"clamped\"\n{ball}")]);
    refuse(&text, "8:8: body[0].support[0].kind", "moves freely cannot be clamped", "motion = \"fixed\"");
}

#[test]
fn mistakes_that_need_the_shape() {
    let off = "kind = \"clamped\"\nat = [0, 0.2, 0]\nradius = 0.01";
    refuse(
        &board("fixed", &[off]),
        "7:1: body[0].support[0]",
        "does not touch the body `board`: its region is 1.800e-1 m from it",
        "move or widen it",
    );
    let overlapping = "kind = \"clamped\"\nlow = [-0.16, -1, -1]\nhigh = [0, 1, 1]";
    refuse(&board("fixed", &[ENDS[0], overlapping]), "11:1: body[0].support[1]", "line 7", "make them one");
    let whole = "kind = \"clamped\"\nat = [0, 0, 0]\nradius = 1";
    refuse(&board("fixed", &[whole]), "7:1: body[0].support[0]", "holds all of the body `board`", "smaller");
    let vertical = "kind = \"sprung\"\nat = [0, 0, 0]\nradius = 1\nstiffness = [0, 1e3, 0]";
    refuse(
        &board("fixed", &[vertical]),
        "7:1: body[0].support[0]",
        "leave 3 of the six motions",
        "along all three axes",
    );
    let text = "version = 1\n[[body]]\nshape = \"sphere:0.01\"\nmaterial = \"steel\"\nmotion = \"fixed\"\n\
                [[body.support]]\nkind = \"clamped\"\nat = [0, 0, 0]\nradius = 1\n";
    refuse(text, "6:1: body[0].support[0]", "is a sphere, which is rigid", "another shape");
}
