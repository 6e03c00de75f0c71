//! Contact lists that contradict themselves, the scene or the recorded motion are refused or named, and so
//! are poses whose noise hides impacts.

use std::fs;

use crate::imported_motion::{folder, import, scene};
use clangor_core::math::random::SplitMix;
use clangor_pipeline::interchange::body_files::{ListedMotion, import_contacts};
use clangor_pipeline::stages::load::load_scene;

const SCENE: &str = scene!();
const G: f64 = 9.80665;
const CONTACTS: &str = "t,body_a,point_x,point_y,point_z,normal_x,normal_y,normal_z,impulse_n,speed\n";

/// Imports a list without poses: what is refused, or all warnings and notices.
fn alone(rows: &str) -> Result<String, String> {
    let folder = folder(SCENE, &[("list.csv", &format!("{CONTACTS}{rows}"))]);
    let loaded = load_scene(&folder.path().join("scene.toml"), &|_| ()).unwrap();
    let (list, out) = (folder.path().join("list.csv"), folder.path().join("out.timeline"));
    let imported = import_contacts(&loaded, &list, ListedMotion::Flights, &out, true);
    let imported = imported.map_err(|error| error.to_string())?;
    Ok([imported.warnings, imported.notices].concat().join("\n"))
}

#[test]
fn property_a_normal_into_the_floor_is_refused_without_poses_too() {
    assert!(alone("0.3,ball,0,0,0,0,1,0,0.1,3.1\n").is_ok());
    let message = alone("0.3,ball,0,0,0,0,-1,0,0.1,3.1\n").unwrap_err();
    assert!(message.contains("row 2") && message.contains("points into the plane floor"), "{message}");
}

#[test]
fn property_an_impact_without_speed_is_refused() {
    let message = alone("0.3,ball,0,0,0,0,1,0,0.1,0\n").unwrap_err();
    assert!(message.contains("row 2: ball does not approach what it hits"), "{message}");
}

#[test]
fn property_a_list_without_contacts_is_named() {
    let said = alone("").unwrap();
    assert!(said.contains("list.csv has no contacts"), "{said}");
}

#[test]
fn property_impulses_that_are_not_those_of_the_motion_are_named() {
    // A ball of 1 cm that falls from 0.5 m and bounces with half of its speed.
    let impact = (2.0 * 0.49 / G).sqrt();
    let speed = G * impact;
    let height = |t: f64| match t < impact {
        true => 0.5 - 0.5 * G * t * t,
        false => 0.01 + 0.5 * speed * (t - impact) - 0.5 * G * (t - impact).powi(2),
    };
    let line = |k: u32| format!("{0},ball,0,{1},0\n", f64::from(k) / 240.0, height(f64::from(k) / 240.0));
    let poses =
        "t,body,position_x,position_y,position_z\n".to_string() + &(0..120).map(line).collect::<String>();
    let files = folder(SCENE, &[("a.csv", &poses)]);
    let mass = load_scene(&files.path().join("scene.toml"), &|_| ()).unwrap().world.bodies[0].mass;
    let right = 1.5 * mass * speed;
    for (factor, is_named) in [(1.0, false), (1.2, false), (0.9, false), (4.0, true), (0.1, true)] {
        let row = format!("{impact},ball,0,0,0,0,1,0,{},{speed}\n", factor * right);
        fs::write(files.path().join("list.csv"), format!("{CONTACTS}{row}")).unwrap();
        let said = import(files.path(), &["a.csv"], &["list.csv"], false).unwrap().notices.join("\n");
        // What the poses say is the true impulse within rounding.
        let named = said.contains("the impulse of an impact is not that of its motion")
            && said.contains(&format!("the poses {right:.3} N s"));
        assert_eq!(named, is_named, "{factor}: {said}");
    }
}

#[test]
fn property_noise_that_hides_impacts_is_named() {
    // A ball that lies on the floor, at 1000 Hz with a noise of half a millimetre.
    let mut random = SplitMix::new(11);
    let mut line = |k: u32, noise: f64| {
        let mut about = |x: f64| x + 3.0_f64.sqrt() * noise * random.uniform(-1.0, 1.0);
        format!("{},ball,{},{},{}\n", f64::from(k) / 1000.0, about(0.0), about(0.01), about(0.0))
    };
    for (noise, is_named) in [(0.0, false), (1e-5, false), (5e-4, true)] {
        let rows: String = (0..500).map(|k| line(k, noise)).collect();
        let files = folder(SCENE, &[("a.csv", &format!("t,body,position_x,position_y,position_z\n{rows}"))]);
        let said = import(files.path(), &["a.csv"], &[], false).unwrap().notices.join("\n");
        println!("{noise}: {said}");
        assert_eq!(said.contains("hides impacts below"), is_named, "{noise}: {said}");
        // Seen: 0.463 mm for half a millimetre, 5.67 m/s.
        assert_eq!(said.contains("with one frame of 8 alone"), is_named, "{noise}: {said}");
    }
}
