//! The world of the module under nonsense and under a flood of changes: refused with a message, and on it
//! goes.

use clangor_web::wasm_buffer::{last_message, write};
use clangor_web::world::{
    SPHERE_NUMBERS, world_add_sphere, world_advance, world_body_count, world_energy, world_events_count,
    world_gravity, world_load, world_materials, world_remove, world_set_velocity, world_solver, world_time,
};

const BOX: &str = r#"
version = 1
[[body]]
name = "marble"
shape = "sphere:0.01"
material = "glass"
count = 40
placement = { region = [[-0.1, 0.05, -0.1], [0.1, 0.4, 0.1]], seed = 3 }
[[plane]]
material = "wood"
thin = true
"#;

fn load(text: &str) {
    assert_eq!(world_load(write(text.as_bytes())), 0, "{}", last_message());
}

/// Adds a ball with these numbers.
fn add_sphere(material: u32, numbers: [f64; SPHERE_NUMBERS]) -> i32 {
    write(&numbers.map(f64::to_le_bytes).concat());
    world_add_sphere(material)
}

fn refused(status: i32) {
    assert!(status < 0 && !last_message().is_empty());
}

#[test]
fn nonsense_is_refused_with_a_message() {
    refused(world_advance(1.0, 0.0));
    refused(world_load(write(&[0xff, 0xfe, 0x00])));
    refused(world_load(write(b"version = 1\n[[body]]\nshape = \"coin:0.01x0.002\"\nmaterial = \"steel\"")));
    load(BOX);
    assert_eq!((world_advance(0.1, f64::NAN), world_body_count()), (0, 41));
    // A scene that is refused leaves the one that is there.
    refused(world_load(write(b"version = 2")));
    assert_eq!(world_body_count(), 41);
    for time in [f64::NAN, -1.0, 1e9, f64::NEG_INFINITY] {
        refused(world_advance(time, 0.0));
    }
    for bad in [f64::NAN, f64::INFINITY, 1e300] {
        refused(world_set_velocity(0, bad, 0.0, 0.0));
        refused(world_gravity(0.0, bad, 0.0));
        refused(add_sphere(0, [bad, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0]));
        refused(add_sphere(0, [0.01, 0.0, bad, 0.0, 0.0, 0.0, 0.0]));
        refused(add_sphere(0, [0.01, 0.0, 5.0, 0.0, 0.0, bad, 0.0]));
    }
    refused(add_sphere(9999, [0.01, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0]));
    refused(world_remove(40));
    refused(world_remove(u32::MAX));
    refused(world_set_velocity(1234, 0.0, 0.0, 0.0));
    assert_eq!(world_advance(0.2, 0.0), 0);
    assert!(world_time() >= 0.2 && world_energy().is_finite());
}

#[test]
fn a_million_changes_are_taken() {
    load(BOX);
    assert!(world_materials() > 3);
    for k in 0..1_000_000_u32 {
        match k % 4 {
            0 => assert_eq!(world_set_velocity(k % 40, 0.1, 0.5, 0.0), 0),
            1 => assert_eq!(add_sphere(0, [0.01, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0]), 41),
            2 => assert_eq!(world_remove(41), 0),
            _ => refused(world_set_velocity(k, f64::NAN, 0.0, 0.0)),
        }
    }
    while world_advance(1.0, 0.0) == 1 {}
    assert!(world_events_count() > 10 && world_solver() == 1);
}
