//! A struck disc rings at the frequencies of its modes, in `strike` and in `render`, which are two ways to the same sound.

use std::f64::consts::TAU;
use std::fs;
use std::path::Path;
use std::process::Command;

use clangor_pipeline::wav::WavReader;

/// A disc of steel, whose lowest modes lie at 2.9 and 4.9 kHz.
const DISC: &str = "coin:0.03x0.002@0.003";

fn clangor(folder: &Path, arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_clangor"))
        .args(arguments)
        .current_dir(folder)
        .env("CLANGOR_CACHE", folder.join("cache"))
        .output()
        .expect("runs");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn samples(path: &Path) -> (Vec<f32>, f64) {
    let mut reader = WavReader::open(path).unwrap();
    let rate = f64::from(reader.info().sample_rate);
    let mut samples = Vec::new();
    while reader.read(&mut samples, 1 << 16).unwrap() > 0 {}
    (samples, rate)
}

/// |∫ p w e^{−iωt} dt| with Hann's window w.
fn level(samples: &[f32], rate: f64, hz: f64) -> f64 {
    let (mut re, mut im) = (0.0, 0.0);
    for (n, p) in samples.iter().enumerate() {
        let window = 0.5 - 0.5 * (TAU * n as f64 / samples.len() as f64).cos();
        let (sin, cos) = (TAU * hz * n as f64 / rate).sin_cos();
        re += window * f64::from(*p) * cos;
        im += window * f64::from(*p) * sin;
    }
    re.hypot(im) / rate
}

/// Where the spectrum is highest within 1 % of a frequency, and how high.
fn peak_near(samples: &[f32], rate: f64, hz: f64) -> (f64, f64) {
    let search = |middle: f64, reach: f64| {
        let steps = (-20..=20).map(|k| middle + reach * f64::from(k) / 20.0);
        let best = steps.map(|f| (f, level(samples, rate, f))).max_by(|a, b| a.1.total_cmp(&b.1));
        best.expect("forty-one of them")
    };
    let (coarse, _) = search(hz, 0.01 * hz);
    search(coarse, 0.001 * hz)
}

#[test]
fn a_struck_disc_rings_at_its_modes() {
    let folder = tempfile::tempdir().unwrap();
    let disc = ["bake", DISC, "--material", "steel", "--parts", "modal", "--max-frequency", "6500"];
    clangor(folder.path(), &[&disc[..], &["--accuracy", "0.03", "-o", "disc.safetensors"]].concat());
    let told: serde_json::Value =
        serde_json::from_str(&clangor(folder.path(), &["--json", "inspect", "disc.safetensors"])).unwrap();
    let frequencies: Vec<f64> =
        told["modal"]["frequencies_hz"].as_array().unwrap().iter().map(|f| f.as_f64().unwrap()).collect();
    // f = λ² √(E h² / (12 ρ (1 − ν²))) / (2π a²) with λ² = 5.26 for two nodal diameters of a free disc of ν = 0.29
    // (Leissa, Vibration of plates, 1969): 2832 Hz for one that is thin. Seen: 2902.
    assert!((frequencies[0] / 2832.0 - 1.0).abs() < 0.04, "{frequencies:?}");

    let blow = ["--impulse", "0,-0.002,0", "--point", "0.022,0.001,0", "--listener", "0.1,0.3,0.15"];
    let strike = ["strike", "disc.safetensors", "--material", "steel", "--sample-rate", "16000"];
    let end = ["--seconds", "1", "--parts", "modal", "-o", "strike.wav"];
    clangor(folder.path(), &[&strike[..], &blow, &end].concat());
    let (sound, rate) = samples(&folder.path().join("strike.wav"));
    let peaks: Vec<(f64, (f64, f64))> =
        frequencies.iter().map(|f| (*f, peak_near(&sound, rate, *f))).collect();
    let loudest = peaks.iter().map(|(_, (_, level))| *level).fold(0.0, f64::max);
    let heard: Vec<_> = peaks.iter().filter(|(_, (_, level))| *level > 1e-2 * loudest).collect();
    assert!(heard.len() >= 3, "{peaks:?}");
    for (f, (at, _)) in &heard {
        // Residual seen: 0.2 Hz.
        assert!((at - f).abs() <= (2e-3 * f).max(2.0), "{f} Hz is heard at {at}");
    }
}

#[test]
fn a_rendered_disc_rings_at_its_modes_with_the_same_bits_on_any_threads() {
    let folder = tempfile::tempdir().unwrap();
    let scene = format!(
        "version = 1\ngravity = [0.0, 0.0, 0.0]\n[simulation]\nduration = 1.0\n[render]\nsample_rate = 16000\n\
         [[body]]\nname = \"disc\"\nshape = \"{DISC}\"\nmaterial = \"steel\"\nposition = [0.0, 0.0, 0.0]\n\
         [[body]]\nname = \"ball\"\nshape = \"sphere:0.003\"\nmaterial = \"steel\"\n\
         position = [0.022, 0.05, 0.0]\nvelocity = [0.0, -1.0, 0.0]\n\
         [[listener]]\nposition = [0.1, 0.3, 0.15]\nspacing = 0.17\n"
    );
    fs::write(folder.path().join("disc.toml"), scene).unwrap();
    let render = ["--json", "render", "disc.toml", "--quality", "draft"];
    let told = clangor(folder.path(), &[&render[..], &["--stems", "-o", "mix.wav"]].concat());
    let told: serde_json::Value = serde_json::from_str(&told).unwrap();
    let body = |name: &str| {
        let bodies = told["bodies"].as_array().unwrap();
        bodies.iter().find(|body| body["name"] == name).unwrap().clone()
    };
    let modes = body("disc")["modes"].as_u64().unwrap();
    assert!(modes >= 3, "{modes}");
    assert_eq!(body("ball")["modes"], 0);
    assert!(body("ball")["rings"].as_str().unwrap().contains("no audible modes: first at"), "{told}");
    let energy = |part: &str| body("disc")[part].as_f64().unwrap();
    assert!(energy("modal_energy_pa2_s") > energy("acceleration_energy_pa2_s"), "{told}");

    let (mix, rate) = samples(&folder.path().join("mix.wav"));
    let stems = ["disc.acceleration", "disc.modal", "ball.acceleration"];
    let stems = stems.map(|stem| samples(&folder.path().join(format!("mix.{stem}.wav"))).0);
    let peak = mix.iter().fold(0.0f32, |m, p| m.max(p.abs()));
    for (n, p) in mix.iter().enumerate() {
        let sum: f32 = stems.iter().map(|stem| stem[n]).sum();
        // Rounding to 32 bits. Residual seen: 1e-7.
        assert!((p - sum).abs() < 1e-5 * peak, "{n}: {p} {sum}");
    }

    clangor(folder.path(), &["--threads", "1", "render", "disc.toml", "--quality", "draft", "-o", "one.wav"]);
    let bytes = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("mix.wav") == bytes("one.wav"));

    // The disc moves at 0.05 m/s: Doppler's shift is 1e-4.
    let left: Vec<f32> = stems[1].iter().step_by(2).copied().collect();
    let model = fs::read_dir(folder.path().join("cache")).unwrap().map(|e| e.unwrap().path());
    let model = model.filter(|p| p.to_string_lossy().contains("modal-"));
    let frequencies: Vec<f64> = model
        .flat_map(|p| {
            let told = clangor(folder.path(), &["--json", "inspect", &p.to_string_lossy()]);
            let told: serde_json::Value = serde_json::from_str(&told).unwrap();
            told["modal"]["frequencies_hz"].as_array().unwrap().clone()
        })
        .map(|f| f.as_f64().unwrap())
        .collect();
    assert_eq!(frequencies.len() as u64, modes);
    let peaks: Vec<(f64, (f64, f64))> =
        frequencies.iter().map(|f| (*f, peak_near(&left, rate, *f))).collect();
    let loudest = peaks.iter().map(|(_, (_, level))| *level).fold(0.0, f64::max);
    for (f, (at, level)) in &peaks {
        // Residual seen: 0.4 Hz.
        assert!(*level < 1e-2 * loudest || (at - f).abs() <= (2e-3 * f).max(2.0), "{f} Hz is heard at {at}");
    }
}

#[test]
fn what_cannot_ring_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_clangor"))
            .args(arguments)
            .current_dir(folder.path())
            .env("CLANGOR_CACHE", folder.path().join("cache"))
            .output()
            .expect("runs");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, message) = run(&["bake", "die:0.016", "--parts", "modal", "-o", "die.safetensors"]);
    assert!(code == Some(1) && message.contains("--material NAME"), "{message}");
    let die = ["bake", "die:0.016", "--parts", "modal", "--material", "plastic", "-o", "die.safetensors"];
    let (code, message) = run(&die);
    assert!(code == Some(1) && message.contains("no audible modes: first at"), "{message}");
    assert!(!folder.path().join("die.safetensors").exists());
    // Without modes there is nothing to draw.
    let (code, message) = run(&["plot", "modes", "die.safetensors", "-o", "die.png"]);
    assert!(code == Some(1) && message.contains("cannot read"), "{message}");
}
