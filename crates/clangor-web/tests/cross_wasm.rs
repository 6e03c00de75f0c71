//! The WebAssembly module in Node against the same code compiled for this machine: the impacts of a cradle,
//! and the sound of the same events.
//!
//! Skipped, with the reason, where `web/build-wasm` has not been run or there is no Node.

mod struck_objects;

use std::path::{Path, PathBuf};
use std::process::Command;

use clangor_core::realtime::event_row::{FIELDS, KINDS};
use clangor_web::layout::{CONTACT_STRIDE, EVENT_STRIDE};
use clangor_web::wasm_buffer::{last_message, write};
use clangor_web::{strike, synth, world};
use struck_objects::{SIZE, ball, cube, write_numbers};

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");

/// The module, or why there is nothing to compare.
fn module() -> Result<PathBuf, &'static str> {
    let module = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../web/public/clangor.wasm");
    if !module.exists() {
        return Err("there is no web/public/clangor.wasm; web/build-wasm builds it");
    }
    match Command::new("node").arg("--version").output() {
        Ok(version) if version.status.success() => Ok(module),
        _ => Err("there is no node to run the module"),
    }
}

/// Runs the module; what it wrote.
fn drive(module: &Path, arguments: &[&str], output: &Path) -> Vec<u8> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cross_wasm/drive.mjs");
    let run = Command::new("node").arg(script).arg(module).args(arguments).arg(output).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    std::fs::read(output).unwrap()
}

fn numbers(bytes: &[u8]) -> Vec<f64> {
    bytes.as_chunks::<8>().0.iter().map(|eight| f64::from_le_bytes(*eight)).collect()
}

/// A fresh folder for the files of a test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Events and impacts of a scene until `end` \[s\].
fn play(scene: &str, end: f64) -> (Vec<f64>, Vec<f64>) {
    assert_eq!(world::world_load(write(scene.as_bytes())), 0, "{}", last_message());
    let (mut events, mut impacts) = (Vec::new(), Vec::new());
    for k in 1..=(50.0 * end).round() as u32 {
        while world::world_advance(f64::from(k) / 50.0, 0.0) == 1 {}
        world::with_events(|new_events, new_impacts| {
            events.extend_from_slice(new_events);
            impacts.extend_from_slice(new_impacts);
        });
        world::world_clear();
    }
    (events, impacts)
}

#[test]
fn the_world_moves_alike() {
    let module = match module() {
        Ok(module) => module,
        Err(reason) => return println!("skipped: {reason}"),
    };
    for (name, end) in [("newtons-cradle", 2), ("ball-drop", 4)] {
        let path = format!("{SCENES}/{name}.toml");
        let (_, native) = play(&std::fs::read_to_string(&path).unwrap(), f64::from(end));
        let output = folder("world").join(name);
        let wasm = numbers(&drive(&module, &["world", &path, &end.to_string()], &output));
        assert!(native.len() >= 5 * CONTACT_STRIDE && native.len() == wasm.len(), "{name}");
        let mut worst = [0.0_f64; CONTACT_STRIDE];
        let rows = native.chunks(CONTACT_STRIDE).zip(wasm.chunks(CONTACT_STRIDE));
        for (row, other) in rows {
            for ((worst, x), y) in worst.iter_mut().zip(row).zip(other) {
                *worst = worst.max((x - y).abs());
            }
        }
        println!("{name}: {} impacts, differences {worst:?}", native.len() / CONTACT_STRIDE);
        // Times, speeds, durations, points. Residual seen: 1e-15.
        assert!(worst.iter().all(|difference| *difference < 1e-9));
    }
}

#[test]
fn the_same_events_sound_alike() {
    let module = match module() {
        Ok(module) => module,
        Err(reason) => return println!("skipped: {reason}"),
    };
    let (frames, block) = (48_000, 128);
    let path = format!("{SCENES}/ball-drop.toml");
    let scene = std::fs::read_to_string(&path).unwrap();
    let (mut events, _) =
        play(&std::fs::read_to_string(format!("{SCENES}/newtons-cradle.toml")).unwrap(), 0.9);
    let (dropped, _) = play(&scene, 0.9);
    events.extend(dropped);
    let count = events.len() / EVENT_STRIDE;
    let mut order: Vec<&[f64]> = events.chunks(EVENT_STRIDE).collect();
    order.sort_by(|a, b| a[1].total_cmp(&b[1]));
    let bytes: Vec<u8> = order.concat().iter().flat_map(|x| x.to_le_bytes()).collect();
    let folder = folder("synth");
    let events_file = folder.join("events");
    std::fs::write(&events_file, &bytes).unwrap();

    assert_eq!(synth::synth_start(48_000.0, block, write(scene.as_bytes())), 0, "{}", last_message());
    assert_eq!(synth::synth_listener(-0.1, 0.2, 0.5, 0.1, 0.2, 0.5), 0);
    write(&bytes);
    assert_eq!(synth::synth_push(count as u32), count as u32);
    let mut native: Vec<f32> = Vec::new();
    for _ in 0..frames / block {
        synth::synth_render(block);
        // Behind the samples of the loudspeaker are the pressures.
        synth::with_output(|samples| native.extend_from_slice(&samples[2 * block as usize..]));
    }

    let frames = frames.to_string();
    let wasm =
        drive(&module, &["synth", &path, events_file.to_str().unwrap(), &frames], &folder.join("sound"));
    let wasm: Vec<f32> = wasm.as_chunks::<4>().0.iter().map(|four| f32::from_le_bytes(*four)).collect();
    assert_eq!(native.len(), wasm.len());
    let peak = native.iter().fold(0.0_f32, |peak, x| peak.max(x.abs()));
    let worst = native.iter().zip(&wasm).fold(0.0_f32, |worst, (x, y)| worst.max((x - y).abs()));
    println!("{count} events, peak {peak:.3} Pa, difference {:.1e} of it", worst / peak);
    assert!(count > 10 && peak > 1e-3);
    // Residual seen: 8.5e-16.
    assert!(worst < 1e-5 * peak);
}

/// Largest relative difference of the numbers of strikes; of samples of force histories, relative to the
/// largest one. Numbers of histories follow from their last bits.
fn apart(native: &[f64], wasm: &[f64]) -> f64 {
    let offset = |name: &str| FIELDS.iter().find(|(field, ..)| *field == name).unwrap().1;
    let [kind, samples, body, history] = ["kind", "samples", "body", "history"].map(offset);
    let part = KINDS.iter().find(|(name, ..)| *name == "forceHistory").unwrap().1;
    let events = native.len() - CONTACT_STRIDE;
    let is_sample = |at: usize| {
        let column = at % EVENT_STRIDE;
        at < events && native[at - column + kind] == part && (samples..body).contains(&column)
    };
    let peak = (0..events).filter(|at| is_sample(*at)).fold(0.0, |peak: f64, at| peak.max(native[at].abs()));
    let difference = |at: usize| match (native[at], wasm[at]) {
        (x, y) if x == y || at < events && at % EVENT_STRIDE == history => 0.0,
        (x, y) => (x - y).abs() / if is_sample(at) { peak } else { x.abs() },
    };
    (0..native.len()).map(difference).fold(0.0, f64::max)
}

#[test]
fn the_same_strike_has_the_same_forces() {
    let module = match module() {
        Ok(module) => module,
        Err(reason) => return println!("skipped: {reason}"),
    };
    let folder = folder("strike");
    let [model_file, numbers_file] = ["cube.safetensors", "numbers"].map(|name| folder.join(name));
    // Radius and speed of the mallet, centre of the object, point of the impact.
    let cube_point = [0.312, -0.2 + SIZE, 1.505];
    let ball_point = [0.3 + 0.6 * SIZE, -0.2, 1.5 + 0.8 * SIZE];
    let mut worst = 0.0_f64;
    for (model, [x, y, z]) in [(cube("ceramic", 64.0), cube_point), (ball("glass", 2.0), ball_point)] {
        let strike_numbers = [0.01, 0.7, 0.3, -0.2, 1.5, x, y, z];
        std::fs::write(&model_file, &model).unwrap();
        std::fs::write(&numbers_file, strike_numbers.map(f64::to_le_bytes).concat()).unwrap();
        assert_eq!(strike::strike_load(0, write(&model)), 0, "{}", last_message());
        for material in (0..strike::strike_materials() as u32).step_by(4) {
            write_numbers(&strike_numbers);
            let rows = strike::strike_impact(0, material);
            assert!(rows >= 2, "{}", last_message());
            let native = strike::with_impact(|events, contact| [events, contact].concat());
            let [model, numbers_file] = [&model_file, &numbers_file].map(|file| file.to_str().unwrap());
            let arguments = ["strike", model, &material.to_string(), numbers_file];
            let wasm = numbers(&drive(&module, &arguments, &folder.join("impact")));
            let length = rows as usize * EVENT_STRIDE + CONTACT_STRIDE;
            assert_eq!((native.len(), wasm.len()), (length, length));
            worst = worst.max(apart(&native, &wasm));
        }
    }
    println!("strikes: largest relative difference {worst:.1e}");
    // Residual seen: 1.9e-16.
    assert!(worst < 1e-12);
}
