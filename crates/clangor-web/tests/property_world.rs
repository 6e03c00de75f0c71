//! The world of the module under nonsense and under a flood of changes: refused with a message, and on it
//! goes.

#[path = "../../clangor-core/tests/fuzzing/mod.rs"]
#[allow(dead_code)]
mod fuzzing;

use clangor_web::layout::EVENT_STRIDE;
use clangor_web::synth::{
    synth_gain, synth_listener, synth_load, synth_push, synth_render, synth_report, synth_silence,
    synth_start, with_output,
};
use clangor_web::wasm_buffer::{last_message, write};
use clangor_web::world::{
    SPHERE_NUMBERS, world_add_sphere, world_advance, world_body_count, world_energy, world_events_count,
    world_gravity, world_load, world_materials, world_remove, world_set_velocity, world_solver, world_time,
};
use fuzzing::{Target, fuzz};

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

/// Numbers that a caller may pass.
const PASSED: [f64; 16] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.01,
    0.5,
    5.0,
    40.0,
    1e-4,
    1e-9,
    1e9,
    1e300,
    -1e300,
    f64::NAN,
    f64::INFINITY,
    5e-324,
];

/// Takes bytes one after the other, as choices; 0 after the last.
struct Choices<'a>(&'a [u8]);

impl Choices<'_> {
    fn byte(&mut self) -> u8 {
        let (first, rest) = self.0.split_first().map_or((0, self.0), |(first, rest)| (*first, rest));
        self.0 = rest;
        first
    }

    fn number(&mut self) -> f64 {
        let byte = self.byte();
        // Half of them in the range that a page passes.
        if byte & 1 == 0 {
            f64::from(byte) / 256.0 - 0.5
        } else {
            PASSED[usize::from(byte >> 1) % PASSED.len()]
        }
    }
}

/// Calls of the world in any order with any numbers, and time that passes.
#[test]
fn fuzz_world_calls() {
    let seeds =
        vec![(0..=255).collect(), b"0123456789".repeat(9), vec![6; 40], vec![0, 8, 16, 24, 32, 40, 6, 6]];
    let target = Target { runs: true, ..Target::parser("world-calls", "calls", seeds, &[]) };
    fuzz(&target, &|_, bytes| {
        load(BOX);
        let (mut choices, mut clock) = (Choices(bytes), 0.0);
        for _ in 0..bytes.len().min(200) {
            let body = u32::from(choices.byte()) % 50;
            let [x, y, z] = [choices.number(), choices.number(), choices.number()];
            match choices.byte() % 6 {
                0 => {
                    let _ = world_set_velocity(body, x, y, z);
                }
                1 => {
                    let radius = choices.number().abs() * 0.05;
                    let _ = add_sphere(body % 9, [radius, x, y + 1.0, z, 0.0, 0.0, choices.number()]);
                }
                2 => {
                    let _ = world_remove(body);
                }
                3 => {
                    let _ = world_gravity(x, y, z);
                }
                _ => {
                    clock += 1e-3;
                    let _ = world_advance(clock, 0.0);
                }
            }
        }
        assert!(world_energy().is_finite() && world_time().is_finite());
        last_message()
    });
}

/// Scenes for the page, and the first instants of them.
#[test]
fn fuzz_page_scenes() {
    let words =
        ["[[body]]\n", "[[hang]]\n", "[[spring]]\n", "stiffness = 1e12\n", "count = 9\n", "radius = 0\n"];
    let springs = "[[spring]]\nbody = \"marble-2\"\nto = \"marble-3\"\nstiffness = 30.0\n[[hang]]\n\
                   body = \"marble-4\"\nanchor = [0, 1, 0]\n";
    let seeds = vec![BOX.as_bytes().to_vec(), format!("{BOX}{springs}").into_bytes()];
    let target = Target { runs: true, ..Target::parser("page-scenes", "toml", seeds, &words) };
    fuzz(&target, &|_, bytes| {
        if world_load(write(bytes)) == 0 {
            let advanced = world_advance(0.01, 1e-3);
            assert!(world_energy().is_finite());
            return format!("advanced {advanced}");
        }
        last_message()
    });
}

/// Events of any numbers at the synthesiser: samples stay finite and within full scale.
#[test]
fn fuzz_synthesiser_calls() {
    let seeds = vec![(0..=255).collect(), vec![2; 400], b"0a1b2c3d4e".repeat(30)];
    let target = Target { runs: true, ..Target::parser("synthesiser", "calls", seeds, &[]) };
    fuzz(&target, &|_, bytes| {
        let mut choices = Choices(bytes);
        assert_eq!(synth_start(48_000.0, 128, write(BOX.as_bytes())), 0, "{}", last_message());
        for _ in 0..bytes.len().min(100) {
            match choices.byte() % 6 {
                0 => {
                    let _ = synth_gain(choices.number());
                }
                1 => {
                    let at: [f64; 6] = std::array::from_fn(|_| choices.number());
                    let _ = synth_listener(at[0], at[1], at[2], at[3], at[4], at[5]);
                }
                2 | 3 => {
                    // A kind that exists, more often than not.
                    let mut row: [f64; EVENT_STRIDE] = std::array::from_fn(|_| choices.number());
                    row[0] = f64::from(choices.byte() % 8);
                    let _ = synth_push(write(&row.map(f64::to_le_bytes).concat()) / 8 / EVENT_STRIDE as u32);
                    let _ = synth_push(1);
                }
                4 => {
                    let _ = synth_load(u32::from(choices.byte()), write(bytes), 0);
                }
                _ => {
                    let _ = synth_silence();
                }
            }
            let _ = synth_render(128);
            with_output(|samples| {
                let (heard, _) = samples.split_at(samples.len() / 2);
                assert!(samples.iter().all(|sample| sample.is_finite()), "{samples:?}");
                assert!(heard.iter().all(|sample| sample.abs() <= 1.0), "{heard:?}");
            });
        }
        let _ = synth_report();
        last_message()
    });
}
