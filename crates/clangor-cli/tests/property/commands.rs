//! What the commands promise besides sound: contact lists that click when and as loud as they say, files in
//! the written formats, results as JSON, options that refuse what they cannot honour.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::program::{clangor, run};
use clangor_pipeline::formats::wav::WavReader;
use serde_json::Value;

const BALL: &str = r#"version = 1
[simulation]
duration = 0.05
[[body]]
name = "ball"
shape = "sphere:0.01"
material = "steel"
position = [0.0, 0.011, 0.0]
[[plane]]
name = "floor"
material = "granite"
[[listener]]
name = "ear"
position = [0.0, 0.061, 0.0]
"#;

/// Standard error of a command that must be refused.
fn refused(folder: &Path, arguments: &[&str], code: i32) -> String {
    let output = run(folder, arguments);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
    message
}

fn folder_with(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), text).unwrap();
    folder
}

fn samples(path: &Path) -> Vec<f64> {
    let mut reader = WavReader::open(path).unwrap();
    let mut samples = Vec::new();
    while reader.read(&mut samples, 1 << 16).unwrap() > 0 {}
    samples.into_iter().map(f64::from).collect()
}

/// ∫ p dt and the mean time ∫ t p dt / ∫ p dt.
fn moments(samples: &[f64], rate: f64) -> (f64, f64) {
    let sum: f64 = samples.iter().sum();
    let first: f64 = samples.iter().enumerate().map(|(i, p)| i as f64 / rate * p).sum();
    (sum / rate, first / sum)
}

/// The field of a sphere of radius R whose velocity jumps by Δv, at distance r on its axis, is P(s) = ρ R³ Δv
/// (1 + s r/c) e^(−s (r − R)/c) / (2 r² (1 + s R/c + s² R²/2c²)) × the spectrum of the force. So ∫ p dt = ρ
/// R³ Δv / 2r², and the mean time of p is that of the force: distance and delay cancel in first order.
#[test]
fn a_contact_list_clicks_when_and_as_loud_as_it_says() {
    let folder = folder_with(BALL);
    let path = folder.path();
    let csv = "# one \
     impact\nt,body_a,body_b,point_x,point_y,point_z,normal_x,normal_y,normal_z,impulse_n,speed\n\
               0.01,ball,world,0,0.001,0,0,2,0,0.02,1.0\n";
    let jsonl = concat!(
        r#"{"t": 0.01, "body_a": "ball", "body_b": "world", "point": [0, 0.001, 0], "normal": [0, 1, 0], "#,
        r#""impulse_n": 0.02, "speed": 1.0}"#
    );
    fs::write(path.join("list.csv"), csv).unwrap();
    fs::write(path.join("list.jsonl"), jsonl).unwrap();
    for format in ["csv", "jsonl"] {
        let (list, timeline) = (format!("list.{format}"), format!("{format}.timeline"));
        clangor(path, &["import", "contacts", "scene.toml", &list, "--at-rest", "-o", &timeline]);
        clangor(path, &["render", &timeline, "--sample-rate", "192000"]);
    }
    let sound = samples(&path.join("csv.wav"));
    assert_eq!(sound, samples(&path.join("jsonl.wav")));

    let strike = [
        "strike",
        "sphere:0.01",
        "--material",
        "steel",
        "--impulse",
        "0,0.02,0",
        "--point",
        "0,-0.01,0",
        "--listener",
        "0,0.05,0",
        "-o",
        "strike.csv",
        "--json",
    ];
    let struck: Value = serde_json::from_str(&clangor(path, &strike)).unwrap();
    let duration = struck["contact_duration_s"].as_f64().unwrap();
    let mass = 7850.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-6;
    let expected = 1.2041 * 1e-6 * (0.02 / mass) / (2.0 * 0.05 * 0.05);
    let (integral, mean_time) = moments(&sound, 192_000.0);
    // Residuals seen: 4e-8, the rounding of the file to f32, and 2e-12 s.
    assert!((integral / expected - 1.0).abs() < 1e-6, "{integral} against {expected}");
    assert!((mean_time - (0.01 + 0.5 * duration)).abs() < 1e-10, "{mean_time}");
}

#[test]
fn strike_needs_no_more_than_a_body() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let strike = |more: &str| {
        let line = format!("strike sphere:0.01 --material steel --json {more}");
        let printed = clangor(path, &line.split_whitespace().collect::<Vec<_>>());
        serde_json::from_str::<Value>(&printed).unwrap()
    };
    let usual = strike("-o usual.csv");
    let same = strike("-o same.csv --impulse 0,-0.01,0 --point 0,0.01,0 --listener 0.6,0.8,0");
    assert_eq!(usual, same);
    assert_eq!(usual["point_m"], serde_json::json!([0.0, 0.01, 0.0]));
    assert_eq!(usual["listener_m"], serde_json::json!([0.6, 0.8, 0.0]));
    // Across its push a ball has no click, and no length of the sound helps.
    let silent = "strike sphere:0.01 --material steel --listener 1,0,0 -o silent.csv";
    let output = run(path, &silent.split_whitespace().collect::<Vec<_>>());
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("no sound in the direction of the listener"), "{message}");
    let [usual, same] = ["usual.csv", "same.csv"].map(|name| fs::read(path.join(name)).unwrap());
    assert_eq!(usual, same);
}

#[test]
fn strike_writes_the_format_of_the_documentation() {
    let folder = tempfile::tempdir().unwrap();
    let strike = |output| {
        [
            "strike",
            "sphere:0.0075",
            "--material",
            "steel",
            "--impulse",
            "0,-0.01,0",
            "--point",
            "0,0.0075,0",
            "--listener",
            "0.5,0.5,0",
            "--sample-rate",
            "96000",
            "--seconds",
            "0.01",
            "-o",
            output,
        ]
    };
    clangor(folder.path(), &strike("click.csv"));
    clangor(folder.path(), &strike("click.wav"));
    let text = fs::read_to_string(folder.path().join("click.csv")).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("time_s,pressure_pa"));
    let rows: Vec<(f64, f64)> = lines
        .map(|line| {
            let (time, pressure) = line.split_once(',').unwrap();
            (time.parse().unwrap(), pressure.parse().unwrap())
        })
        .collect();
    // 2 ms before the impact and 10 ms after it.
    assert_eq!(rows.len(), 1152);
    for (index, (time, _)) in rows.iter().enumerate() {
        // Ten digits are written. Residual seen: 5e-13.
        assert!((time - (index as f64 / 96_000.0 - 0.002)).abs() < 1e-11, "{time}");
    }
    let wav = samples(&folder.path().join("click.wav"));
    assert_eq!(wav.len(), rows.len());
    let peak = wav.iter().fold(0.0f64, |m, p| m.max(p.abs()));
    let worst = wav.iter().zip(&rows).map(|(a, (_, b))| (a - b).abs()).fold(0.0, f64::max);
    // Rounding to f32. Residual seen: 2.2e-8 of the peak.
    assert!(peak > 0.0 && worst < 1e-7 * peak, "{worst} of {peak}");
}

#[test]
fn every_result_is_one_json_object() {
    let folder = folder_with(BALL);
    fs::write(
        folder.path().join("list.csv"),
        "t,body_a,point_x,point_y,point_z,normal_x,normal_y,normal_z,impulse_n,speed\n",
    )
    .unwrap();
    let commands: &[(&[&str], &str)] = &[
        (&["check", "scene.toml"], "bodies"),
        (&["simulate", "scene.toml", "-o", "run.timeline"], "contact_rows"),
        (&["render", "run.timeline", "-o", "out.wav", "--stems", "--explain"], "files"),
        (&["render", "scene.toml", "--normalize", "-1", "--bits", "24"], "files"),
        (&["inspect", "scene.toml"], "bodies"),
        (&["inspect", "run.timeline"], "impacts"),
        (&["inspect", "out.wav"], "full_scale_pa"),
        (&["inspect", "coin"], "volume_m3"),
        (&["import", "contacts", "scene.toml", "list.csv", "-o", "list.timeline"], "contact_rows"),
        (&["export", "gltf", "scene.toml", "-o", "scene.glb"], "nodes"),
        (&["export", "gltf", "run.timeline", "-o", "run.glb"], "nodes"),
        (&["inspect", "run.glb"], "nodes"),
    ];
    for (arguments, key) in commands {
        let text = clangor(folder.path(), &[arguments, ["--json"].as_slice()].concat());
        let value: Value =
            serde_json::from_str(&text).unwrap_or_else(|e| panic!("{arguments:?}: {e}: {text}"));
        assert!(value.get(key).is_some(), "{arguments:?}: no {key} in {text}");
    }
    let inspected = clangor(folder.path(), &["inspect", "run.glb"]);
    let node = "node \"ball\": ";
    assert!(
        inspected.contains(node) && inspected.contains("material steel, 7 frames, 120.0 per second"),
        "{inspected}"
    );
    for name in ["scene.glb", "run.glb"] {
        let bytes = fs::read(folder.path().join(name)).unwrap();
        assert_eq!(bytes[..4], *b"glTF");
        let length = u32::from_le_bytes([bytes[8], bytes[9], bytes[10], bytes[11]]);
        assert_eq!(length as usize, bytes.len());
    }
}

#[test]
fn a_check_tells_what_is_doubtful() {
    let folder = folder_with(&BALL.replace("[simulation]", "[render]\nsample_rate = 22050\n[simulation]"));
    let output = run(folder.path(), &["check", "scene.toml"]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{message}");
    assert!(
        message.contains("warning: render.sample_rate") && message.contains("scene.toml:3:"),
        "{message}"
    );
    assert!(String::from_utf8_lossy(&output.stdout).contains("no errors"));

    // A listener of the command line is one.
    let unheard = BALL.split("[[listener]]").next().unwrap();
    fs::write(folder.path().join("scene.toml"), unheard).unwrap();
    for (arguments, warns) in [
        (["check", "scene.toml"].as_slice(), true),
        (&["render", "scene.toml", "--listener", "-1,1,1"], false),
    ] {
        let output = run(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(0));
        assert_eq!(String::from_utf8_lossy(&output.stderr).contains("no listener"), warns, "{arguments:?}");
    }

    // What only the solver knows is told too.
    let coin = BALL.replace("sphere:0.01", "coin").replace("duration", "solver = \"spheres\"\nduration");
    fs::write(folder.path().join("scene.toml"), coin).unwrap();
    let message = refused(folder.path(), &["check", "scene.toml"], 1);
    assert!(message.contains("cannot move body \"ball\""), "{message}");
}

#[test]
fn errors_are_json_too() {
    let folder = folder_with(&BALL.replace("sphere:0.01", "sphere:-1"));
    let errors = |arguments: &[&str]| -> serde_json::Value {
        let output = run(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        assert!(!output.stderr.is_empty(), "{arguments:?}");
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one object");
        json["errors"].clone()
    };
    let line = BALL.lines().position(|line| line.contains("sphere:0.01")).unwrap() + 1;
    for command in ["check", "simulate", "render", "bake"] {
        let error = &errors(&[command, "scene.toml", "--json"])[0];
        assert_eq!(error["field"], "body[0].shape", "{command}");
        assert_eq!(error["line"], line);
        assert!(error["problem"].as_str().unwrap().contains("-1"), "{error}");
        assert!(error["remedy"].as_str().unwrap().contains("metres"), "{error}");
    }
    // What has no place in a scene.
    let missing = errors(&["inspect", "missing.obj", "--json"]);
    assert_eq!(missing.as_array().unwrap().len(), 1);
    assert!(missing[0]["problem"].as_str().unwrap().contains("missing.obj"), "{missing}");
    assert!(missing[0]["line"].is_null() && missing[0]["field"].is_null(), "{missing}");
}

#[test]
fn a_band_limit_silences_what_is_above_it() {
    let folder = folder_with(BALL);
    clangor(folder.path(), &["render", "scene.toml", "-o", "full.wav"]);
    clangor(folder.path(), &["render", "scene.toml", "-o", "cut.wav", "--max-frequency", "4000"]);
    let spectrum = |name: &str, hz: f64| {
        let step = std::f64::consts::TAU * hz / 48_000.0;
        let (re, im) =
            samples(&folder.path().join(name)).iter().enumerate().fold((0.0, 0.0), |(re, im), (i, p)| {
                (re + p * (step * i as f64).cos(), im + p * (step * i as f64).sin())
            });
        re.hypot(im)
    };
    let (low, high) = (
        spectrum("cut.wav", 3000.0) / spectrum("full.wav", 3000.0),
        spectrum("cut.wav", 12_000.0) / spectrum("full.wav", 12_000.0),
    );
    // Residuals seen: 9e-9 and 5e-9.
    assert!((low - 1.0).abs() < 1e-6, "{low}");
    assert!(high < 1e-6, "{high}");
    let message = refused(folder.path(), &["render", "scene.toml", "--max-frequency", "30000"], 1);
    assert!(message.contains("30000") && message.contains("24000 Hz"), "{message}");
}

#[test]
fn options_that_cannot_be_honoured_are_refused() {
    let folder = folder_with(BALL);
    let path = folder.path();
    let render = ["render", "scene.toml", "-o", "out.wav"].as_slice();
    let inside = refused(path, &[render, &["--listener", "0,0.011,0"]].concat(), 1);
    assert!(inside.contains("--listener 0,0.011,0") && inside.contains("`ball`"), "{inside}");
    let folderless = refused(path, &["render", "scene.toml", "-o", "no/out.wav"], 1);
    assert!(folderless.contains("no folder no"), "{folderless}");
    for (option, value) in [("--duration", "1e9"), ("--normalize", "-1000"), ("--full-scale", "1e300")] {
        let message = refused(path, &[render, &[option, value]].concat(), 2);
        assert!(message.contains("must be from"), "{message}");
    }

    let twins = BALL.replace("name = \"ear\"", "name = \"a/b\"")
        + "[[listener]]\nname = \"a_b\"\nposition = [1, 1, 1]\n";
    fs::write(path.join("twins.toml"), twins).unwrap();
    let message = refused(path, &["render", "twins.toml", "-o", "out.wav"], 1);
    assert!(message.contains("a/b") && message.contains("out.a_b.wav"), "{message}");

    clangor(path, &["simulate", "scene.toml", "-o", "run.timeline"]);
    for output in ["run.wav", "run"] {
        let message = refused(path, &["simulate", "scene.toml", "-o", output], 1);
        assert!(message.contains("must end in .timeline"), "{message}");
    }
    for option in [["--seed", "3"], ["--timeline", "again.timeline"], ["--duration", "1"]] {
        let message = refused(path, &[["render", "run.timeline"].as_slice(), &option].concat(), 1);
        assert!(message.contains("simulated already") && message.contains(option[0]), "{message}");
    }
    assert!(!path.join("out.wav").exists());
}

#[test]
fn contacts_that_cannot_be_are_refused() {
    let folder = folder_with(BALL);
    let path = folder.path();
    let row = |t: &str, impulse: &str, speed: &str| {
        let place = r#""body_a": "ball", "point": [0, 0.001, 0], "normal": [0, 1, 0]"#;
        format!(r#"{{"t": {t}, {place}, "impulse_n": {impulse}, "speed": {speed}}}"#)
    };
    let cases = [
        (row("-1", "1", "1"), "t = -1 s"),
        (row("1e300", "1", "1"), "from 0 to 3600 s"),
        (row("0", "-0.5", "1"), "line 1: impulse_n is -0.5"),
        (row("0", "1", "-2"), "line 1: speed is -2"),
        (row("0", "1", "1, \"velocity\": [0, -1, 0]"), "line 1: velocity and speed"),
    ];
    for (text, wanted) in cases {
        fs::write(path.join("list.jsonl"), text).unwrap();
        let message =
            refused(path, &["import", "contacts", "scene.toml", "list.jsonl", "-o", "run.timeline"], 1);
        assert!(message.contains(wanted), "{message}");
        assert!(!path.join("run.timeline").exists());
    }
}

#[test]
#[cfg(unix)]
fn a_reader_may_stop_reading() {
    let folder = folder_with(BALL);
    let mut child = Command::new(env!("CARGO_BIN_EXE_clangor"))
        .args(["inspect", "scene.toml"])
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("runs");
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(
        output.status.success() && output.stderr.is_empty(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn former_names_give_the_same_sound_and_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let scene = |key: &str| {
        format!(
            "version = 1\n[simulation]\nduration = 0.05\n[[body]]\nname = \"die\"\nshape = \"die\"\n\
             material = \"steel\"\nposition = [0, 0.01, 0]\nvelocity = [0, -1, 0]\n{key}\n\
             [[plane]]\nmaterial = \"granite\"\n[[listener]]\nposition = [0.3, 0.3, 0]\n"
        )
    };
    // The file names the scene, so that both have the same name.
    let render = |keys: &str, option: &str| {
        std::fs::write(path.join("die.toml"), scene(keys)).unwrap();
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_clangor"))
            .current_dir(path)
            .args(["render", "die.toml", option, "sphere", "-o", "die.wav"])
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{said}");
        (std::fs::read(path.join("die.wav")).unwrap(), said)
    };
    let (new, quiet) = render("acceleration = \"proxy\"\nmodal = \"none\"", "--acceleration");
    let (former, warned) = render("sound = \"proxy\"\nringing = \"none\"", "--sound");
    assert_eq!(new, former);
    assert!(!quiet.contains("former name"), "{quiet}");
    for name in ["`--acceleration`", "`acceleration`", "`modal`"] {
        assert!(warned.contains(name), "{warned}");
    }
}
