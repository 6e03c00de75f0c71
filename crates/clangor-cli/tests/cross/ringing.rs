//! A struck disc rings at the frequencies of its modes, in `strike` and in `render`, which are two ways to
//! the same sound.

use std::f64::consts::TAU;
use std::fs;
use std::process::Command;

use crate::program::clangor;
use crate::sound_file::samples;

/// A disc of steel, whose lowest modes lie at 2.9 and 4.9 kHz.
const DISC: &str = "coin:0.03x0.002@0.003";

/// |∫ p w e^{−iωt} dt| with Hann's window w.
fn level(windowed: &[f64], rate: f64, hz: f64) -> f64 {
    let (sin, cos) = (TAU * hz / rate).sin_cos();
    // By Horner, from the last sample to the first.
    let step = |(re, im): (f64, f64), p: &f64| (re * cos + im * sin + p, im * cos - re * sin);
    let (re, im) = windowed.iter().rev().fold((0.0, 0.0), step);
    re.hypot(im) / rate
}

/// Frequencies at which the spectrum has maxima, from 1 kHz to 6.5, that are within 30 dB of the highest.
fn peaks(samples: &[f32], rate: f64) -> Vec<f64> {
    let window = |n: usize| 0.5 - 0.5 * (TAU * n as f64 / samples.len() as f64).cos();
    let windowed: Vec<f64> = samples.iter().enumerate().map(|(n, p)| window(n) * f64::from(*p)).collect();
    let frequencies: Vec<f64> = (0..11_000).map(|k| 1000.0 + 0.5 * f64::from(k)).collect();
    let levels: Vec<f64> = frequencies.iter().map(|f| level(&windowed, rate, *f)).collect();
    let loudest = levels.iter().copied().fold(0.0, f64::max);
    let is_peak =
        |k: &usize| levels[*k] > levels[k - 1] && levels[*k] >= levels[k + 1] && levels[*k] > 0.03 * loudest;
    (1..levels.len() - 1).filter(is_peak).map(|k| frequencies[k]).collect()
}

/// Asserts that every peak is at a mode, and that there are some.
fn assert_at_modes(peaks: &[f64], frequencies: &[f64]) {
    assert!(peaks.len() >= 2, "{peaks:?}");
    for peak in peaks {
        let nearest = frequencies.iter().min_by(|a, b| (*a - peak).abs().total_cmp(&(*b - peak).abs()));
        let nearest = nearest.expect("there are modes");
        // Residual seen: 0.5 Hz.
        assert!((peak - nearest).abs() <= (2e-3 * nearest).max(2.0), "{peak} Hz is none of {frequencies:?}");
    }
}

#[test]
fn a_struck_disc_rings_at_its_modes() {
    let folder = tempfile::tempdir().unwrap();
    let disc = ["bake", DISC, "--material", "steel", "--parts", "modal", "--max-frequency", "6500"];
    clangor(folder.path(), &[&disc[..], &["--accuracy", "0.03", "-o", "disc.safetensors"]].concat());
    let report: serde_json::Value =
        serde_json::from_str(&clangor(folder.path(), &["--json", "inspect", "disc.safetensors"])).unwrap();
    let frequencies: Vec<f64> =
        report["modal"]["frequencies_hz"].as_array().unwrap().iter().map(|f| f.as_f64().unwrap()).collect();
    // f = λ² √(E h² / (12 ρ (1 − ν²))) / (2π a²) with λ² = 5.26 for two nodal diameters of a free disc of ν =
    // 0.29 (Leissa, ModalAnalysis of plates, 1969): 2832 Hz for one that is thin. Seen: 2902.
    assert!((frequencies[0] / 2832.0 - 1.0).abs() < 0.04, "{frequencies:?}");

    let impact = ["--impulse", "0,-0.002,0", "--point", "0.022,0.001,0", "--listener", "0.1,0.3,0.15"];
    let strike = ["strike", "disc.safetensors", "--material", "steel", "--sample-rate", "16000"];
    let end = ["--seconds", "1", "--parts", "modal", "-o", "strike.wav"];
    clangor(folder.path(), &[&strike[..], &impact, &end].concat());
    let (sound, rate) = samples(&folder.path().join("strike.wav"));
    assert_at_modes(&peaks(&sound, rate), &frequencies);

    // What the program itself says of the spectrum.
    let plot = ["--json", "plot", "spectrum", "strike.wav", "--modes", "disc.safetensors"];
    let report = clangor(folder.path(), &[&plot[..], &["--max-frequency", "6500", "-o", "s.svg"]].concat());
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let report: Vec<f64> =
        report["peaks"].as_array().unwrap().iter().map(|p| p["frequency_hz"].as_f64().unwrap()).collect();
    assert_at_modes(&report, &frequencies);
    let picture = fs::read_to_string(folder.path().join("s.svg")).unwrap();
    // The curve, its frame, and two lines at least where modes are.
    assert!(picture.matches("<polyline").count() > frequencies.len() && picture.contains("strike.wav"));
}

#[test]
fn a_rendered_disc_rings_at_its_modes_with_the_same_bits_on_any_threads() {
    let folder = tempfile::tempdir().unwrap();
    let scene = format!(
        "version = 1\ngravity = [0.0, 0.0, 0.0]\n[simulation]\nduration = 1.0\n[render]\n\
         sample_rate = 16000\n\
         [[body]]\nname = \"disc\"\nshape = \"{DISC}\"\nmaterial = \"steel\"\nposition = [0.0, 0.0, 0.0]\n\
         [[body]]\nname = \"ball\"\nshape = \"sphere:0.003\"\nmaterial = \"steel\"\n\
         position = [0.022, 0.05, 0.0]\nvelocity = [0.0, -1.0, 0.0]\n\
         [[listener]]\nposition = [0.1, 0.3, 0.15]\nspacing = 0.17\n"
    );
    fs::write(folder.path().join("disc.toml"), scene).unwrap();
    let render = ["--json", "render", "disc.toml", "--quality", "draft"];
    let report = clangor(folder.path(), &[&render[..], &["--stems", "-o", "mix.wav"]].concat());
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let body = |name: &str| {
        let bodies = report["bodies"].as_array().unwrap();
        bodies.iter().find(|body| body["name"] == name).unwrap().clone()
    };
    let modes = body("disc")["modes"].as_u64().unwrap();
    assert!(modes >= 3, "{modes}");
    assert_eq!(body("ball")["modes"], 0);
    assert!(body("ball")["modal"].as_str().unwrap().contains("no audible modes: first at"), "{report}");
    let energy = |part: &str| body("disc")[part].as_f64().unwrap();
    assert!(energy("modal_energy_pa2_s") > energy("acceleration_energy_pa2_s"), "{report}");

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
    let model = model.filter(|p| {
        p.to_string_lossy().contains("modal-") && p.extension().is_some_and(|e| e == "safetensors")
    });
    let frequencies: Vec<f64> = model
        .flat_map(|p| {
            let report = clangor(folder.path(), &["--json", "inspect", &p.to_string_lossy()]);
            let report: serde_json::Value = serde_json::from_str(&report).unwrap();
            report["modal"]["frequencies_hz"].as_array().unwrap().clone()
        })
        .map(|f| f.as_f64().unwrap())
        .collect();
    assert_eq!(frequencies.len() as u64, modes);
    assert_at_modes(&peaks(&left, rate), &frequencies);
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
    let (code, message) = run(&["bake", "die:0.016x0.002", "--parts", "modal", "-o", "die.safetensors"]);
    assert!(code == Some(1) && message.contains("--material NAME"), "{message}");
    let die =
        ["bake", "die:0.016x0.002", "--parts", "modal", "--material", "plastic", "-o", "die.safetensors"];
    let (code, message) = run(&die);
    assert!(code == Some(1) && message.contains("no audible modes: first at"), "{message}");
    assert!(!folder.path().join("die.safetensors").exists());
    // Without modes there is nothing to draw.
    let (code, message) = run(&["plot", "modes", "die.safetensors", "-o", "die.png"]);
    assert!(code == Some(1) && message.contains("cannot read"), "{message}");
    // Nor has a sound a spectrum beyond its own, or a channel that it lacks.
    let mono =
        ["strike", "sphere:0.01", "--material", "steel", "--impulse", "0,0.01,0", "--point", "0,-0.01,0"];
    let (code, message) = run(&[&mono[..], &["--listener", "0,0.3,0", "-o", "click.wav"]].concat());
    assert_eq!(code, Some(0), "{message}");
    for (option, value, wanted) in
        [("--channel", "2", "no channel 2"), ("--max-frequency", "1e6", "is beyond")]
    {
        let (code, message) = run(&["plot", "spectrum", "click.wav", option, value, "-o", "click.svg"]);
        assert!(code == Some(1) && message.contains(wanted), "{message}");
    }
    assert!(!folder.path().join("click.svg").exists());
}
