//! What a run promises whatever happens: the same bits for any number of threads, the same sound from a
//! timeline as from its scene, stems that add up, and after Ctrl-C no half file but a timeline as far as it
//! went.

use std::fs;
use std::io::Read;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use clangor_pipeline::formats::timeline_file::TimelineReader;

use crate::program::clangor;
use crate::sound_file::samples;

const BALLS: &str = r#"version = 1
[simulation]
duration = 0.4
[render]
floor = "rigid"
[[body]]
name = "ball"
shape = "sphere:0.01"
material = "steel"
count = 20
placement = { region = [[-0.1, 0.03, -0.1], [0.1, 0.3, 0.1]], seed = 5 }
[[plane]]
name = "floor"
material = "granite"
[[listener]]
name = "near"
position = [0.3, 0.4, 0.2]
[[listener]]
name = "far"
position = [1.0, 1.8, 1.0]
spacing = 0.17
"#;

#[test]
fn threads_do_not_change_a_bit() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("balls.toml"), BALLS).unwrap();
    for threads in ["1", "2", "5"] {
        clangor(
            folder.path(),
            &["render", "balls.toml", "-o", &format!("out{threads}.wav"), "--threads", threads],
        );
    }
    for listener in ["near", "far"] {
        let bytes =
            |threads: u32| fs::read(folder.path().join(format!("out{threads}.{listener}.wav"))).unwrap();
        let one = bytes(1);
        assert!(one.len() > 50_000);
        assert_eq!(one, bytes(2));
        assert_eq!(one, bytes(5));
    }
}

#[test]
fn a_timeline_sounds_like_its_scene() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("balls.toml"), BALLS).unwrap();
    clangor(folder.path(), &["simulate", "balls.toml", "-o", "balls.timeline"]);
    clangor(folder.path(), &["render", "balls.toml", "-o", "scene.wav"]);
    clangor(folder.path(), &["render", "balls.timeline", "-o", "timeline.wav"]);
    let (a, b) =
        (samples(&folder.path().join("scene.far.wav")).0, samples(&folder.path().join("timeline.far.wav")).0);
    assert_eq!(a.len(), b.len());
    let square = |x: f32| f64::from(x) * f64::from(x);
    let error: f64 = a.iter().zip(&b).map(|(x, y)| square(x - y)).sum();
    let norm: f64 = a.iter().map(|x| square(*x)).sum();
    // A timeline rounds to f32: a relative error of 1e-7 in impulses, 60 nm in positions. Residual seen:
    // 2e-7.
    assert!(norm > 0.0 && (error / norm).sqrt() < 1e-5, "{}", (error / norm).sqrt());
}

#[test]
fn stems_add_up_to_the_mix_and_a_cut_is_a_part() {
    let folder = tempfile::tempdir().unwrap();
    let one_listener = BALLS.split("[[listener]]\nname = \"far\"").next().unwrap();
    fs::write(folder.path().join("balls.toml"), one_listener).unwrap();
    clangor(folder.path(), &["render", "balls.toml", "-o", "mix.wav", "--stems"]);
    let mix = samples(&folder.path().join("mix.wav")).0;
    let mut sum = vec![0.0f64; mix.len()];
    let mut stems = 0;
    for entry in fs::read_dir(folder.path()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.to_string_lossy();
        if name.ends_with(".acceleration.wav") || name.ends_with(".ground.wav") {
            stems += 1;
            sum.iter_mut().zip(samples(&path).0).for_each(|(s, x)| *s += f64::from(x));
        }
    }
    assert!(stems > 5, "{stems} stems");
    let peak = mix.iter().fold(0.0f32, |m, x| m.max(x.abs()));
    let worst = mix.iter().zip(&sum).map(|(x, s)| (f64::from(*x) - s).abs()).fold(0.0, f64::max);
    // Rounding to f32 of up to 20 stems. Residual seen: 2e-7 of the peak.
    assert!(worst < 1e-5 * f64::from(peak), "{worst} of {peak}");

    clangor(folder.path(), &["render", "balls.toml", "-o", "cut.wav", "--from", "0.1", "--to", "0.3"]);
    let cut = samples(&folder.path().join("cut.wav")).0;
    assert_eq!(cut.len(), 9600);
    let worst = cut.iter().zip(&mix[4800..]).map(|(x, y)| f64::from((x - y).abs())).fold(0.0, f64::max);
    // Blocks lie elsewhere, so that rounding differs. Residual seen: 6e-8 of the peak.
    assert!(worst < 1e-5 * f64::from(peak), "{worst} of {peak}");
}

#[test]
#[cfg(unix)]
fn what_is_stopped_keeps_the_timeline_so_far_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    // Elastic balls bounce for ever.
    let endless = BALLS
        .replace("duration = 0.4", "duration = 3600.0")
        .replace("version = 1", "version = 1\n[material.ideal]\nbase = \"steel\"\nrestitution = 1.0")
        .replace("\"steel\"\ncount = 20", "\"ideal\"\ncount = 500")
        .replace("[[-0.1, 0.03, -0.1], [0.1, 0.3, 0.1]]", "[[-1.0, 0.03, -1.0], [1.0, 0.3, 1.0]]")
        .replace("\"granite\"", "\"ideal\"");
    fs::write(folder.path().join("endless.toml"), endless).unwrap();
    for (signal, arguments) in [
        ("-INT", ["render", "endless.toml", "-o", "out.wav", "--timeline", "out.timeline"].as_slice()),
        ("-TERM", ["simulate", "endless.toml", "-o", "out.timeline", "--raw-log"].as_slice()),
    ] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_clangor"))
            .args(arguments)
            .current_dir(folder.path())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("runs");
        std::thread::sleep(Duration::from_millis(500));
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().expect("kill runs");
        assert!(sent.success());
        let begin = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().unwrap() {
                break status;
            }
            if begin.elapsed() > Duration::from_secs(30) {
                child.kill().unwrap();
                panic!("Ctrl-C was not heeded in 30 s");
            }
            std::thread::sleep(Duration::from_millis(20));
        };
        assert_eq!(status.code(), Some(130));
        let mut report = String::new();
        child.stderr.take().unwrap().read_to_string(&mut report).unwrap();
        assert!(
            report.contains("interrupted; what happened until ") && report.contains("out.partial.timeline"),
            "{report}"
        );
        let mut left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
        left.sort();
        assert_eq!(left, ["endless.toml", "out.partial.timeline"]);
        let kept = TimelineReader::open(&folder.path().join("out.partial.timeline")).unwrap();
        let duration = kept.header().origin.duration;
        assert!(duration > 0.0 && duration < 3600.0 && kept.rows().contacts > 0, "{duration} s");
        assert!(kept.contacts().unwrap().all(|row| row.unwrap().time <= duration));
    }
}
