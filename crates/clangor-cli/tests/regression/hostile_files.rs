//! Files that a stranger may have written to do harm: each ends in a located message or a result, within 10
//! s of processor time and bounded memory, and no character of theirs reaches a terminal that would obey
//! it.
#![cfg(unix)]

use std::fmt::Write as _;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant, SystemTime};

const LISTENER: &str = "version = 1\n[[listener]]\nposition = [0, 1, 0]\n";

/// Runs the program with 10 s of processor time and 2 GB of addresses, of which it uses half at most.
fn limited(folder: &Path, arguments: &[&str]) -> Output {
    Command::new("sh")
        .args(["-c", "ulimit -t 10 -v 2000000; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_clangor")])
        .args(arguments)
        .current_dir(folder)
        .env("CLANGOR_CACHE", folder.join("cache"))
        .output()
        .expect("runs")
}

/// A `[[body]]`: a sphere of 1 cm.
fn ball(index: usize, material: &str, x: f64) -> String {
    format!(
        "[[body]]\nname = \"b{index}\"\nshape = \"sphere:0.01\"\nmaterial = \"{material}\"\n\
         position = [{x}, 0.5, 0]\n"
    )
}

fn repeated(count: usize, part: impl Fn(usize) -> String) -> String {
    (0..count).fold(String::new(), |mut text, index| {
        text.push_str(&part(index));
        text
    })
}

/// Checks a scene that must be refused, with all of `wanted` in a message of bounded length.
fn refused(case: &str, text: &str, wanted: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), text).unwrap();
    let output = limited(folder.path(), &["check", "scene.toml"]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{case}: {:?} {message:.2000}", output.status);
    assert!(message.len() < 60_000, "{case}: {} bytes", message.len());
    for text in wanted {
        assert!(message.contains(text), "{case}: no {text:?} in {message:.2000}");
    }
}

#[test]
fn floods_of_mistakes_are_counted_and_not_printed() {
    let equals = "=\n".repeat(5_000_000);
    refused("no TOML", &equals, &["scene.toml:1:1", "errors, of which the first 50 are shown"]);
    let late = format!("{LISTENER}{}{equals}", repeated(1000, |i| ball(i, "steel", 0.03 * i as f64)));
    refused("no TOML after bodies", &late, &["scene.toml:5004:1"]);
    let unknown =
        format!("{LISTENER}{}{}", ball(0, "steel", 0.0), repeated(20_000, |i| format!("positiom{i} = 1\n")));
    refused("unknown keys", &unknown, &["did you mean `position`?", "20000 errors"]);
    let own = repeated(3000, |i| format!("[material.m{i}]\nbase = \"steel\"\n"));
    let misspelt = repeated(50_000, |i| ball(i, &format!("stele{i}"), 0.03 * i as f64));
    refused("materials", &format!("{LISTENER}{own}{misspelt}"), &["body[0].material", "50000 errors"]);
    let named = repeated(20_000, |i| ball(0, "steel", 0.03 * i as f64));
    refused("names", &format!("{LISTENER}{named}"), &["19999 errors"]);
    let keys = repeated(100_000, |i| format!("{{ time = -{i}, position = [0, 0, 0] }},\n"));
    let moved =
        ball(0, "steel", 0.0).replace("position = [0, 0.5, 0]\n", &format!("keyframes = [\n{keys}]\n"));
    refused("keyframes", &format!("{LISTENER}{moved}"), &["times must increase", "99999 errors"]);
}

#[test]
fn floods_of_bodies_are_refused_at_their_place() {
    let heap = repeated(20_000, |i| ball(i, "steel", 0.0));
    let boxes = heap.replace("sphere:0.01", "box:0.02x0.02x0.02");
    refused("boxes at one place", &format!("{LISTENER}{boxes}"), &["overlap by"]);
    refused("one place", &format!("{LISTENER}{heap}"), &["scene.toml:", "overlap by 2.000e-2 m at t = 0"]);
    let rocks = "version = 1\n[[body]]\nshape = \"rock:{n}x0.01\"\nmaterial = \"steel\"\ncount = 100000\n\
                 placement = { region = [[0, 0, 0], [99, 99, 99]] }\n";
    refused("rocks", rocks, &["scene.toml:3:9", "more than 10000 distinct geometries"]);
}

#[test]
fn many_listeners_far_from_many_bodies_cost_no_more_than_their_number() {
    let folder = tempfile::tempdir().unwrap();
    let bodies = repeated(5_000, |i| ball(i, "steel", 0.03 * i as f64));
    let listener =
        |i: usize| format!("[[listener]]\nname = \"l{i}\"\nposition = [{}, 1000, 0]\n", 0.01 * i as f64);
    fs::write(
        folder.path().join("scene.toml"),
        format!("version = 1\n{bodies}{}", repeated(20_000, listener)),
    )
    .unwrap();
    let output = limited(folder.path(), &["check", "scene.toml"]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message:.2000}");
    assert!(message.contains("warning: and 19950 more warnings") && message.len() < 60_000);
}

#[test]
fn no_character_of_a_file_is_obeyed_by_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let hostile = ball(0, "steel", 0.0).replace("\"b0\"", "\"\\u001b]0;title\\u0007\\u202e\"");
    let bad = format!("{LISTENER}{hostile}colour = \"\x1b[31m\" # \u{9b}\n");
    fs::write(folder.path().join("good.toml"), format!("{LISTENER}{hostile}")).unwrap();
    fs::write(folder.path().join("bad.toml"), bad.replace("colour", "\"colour\\u001b[2J\"")).unwrap();
    for arguments in [["inspect", "good.toml"], ["check", "good.toml"], ["check", "bad.toml"]] {
        let output = crate::program::run(folder.path(), &arguments);
        for text in [&output.stdout, &output.stderr] {
            let text = String::from_utf8_lossy(text);
            let obeyed =
                text.chars().find(|c| c.is_control() && !matches!(c, '\n' | '\t') || *c == '\u{202e}');
            assert_eq!(obeyed, None, "{arguments:?}: {text:?}");
        }
    }
    let shown = crate::program::clangor(folder.path(), &["inspect", "good.toml"]);
    assert!(shown.contains("\\u{1b}]0;title\\u{7}\\u{202e}"), "{shown}");
}

#[test]
fn endless_files_pipes_and_full_disks_end_the_program() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["zero.toml", "zero.stl", "zero.safetensors"] {
        std::os::unix::fs::symlink("/dev/zero", folder.path().join(name)).unwrap();
        let output = limited(folder.path(), &["inspect", name]);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{name}: {message}");
        assert!(message.contains("it has more than"), "{name}: {message}");
    }

    let pipe = folder.path().join("pipe.toml");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let mut child = Command::new(env!("CARGO_BIN_EXE_clangor")).arg("check").arg(&pipe).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(200));
    let asked = Instant::now();
    let _ = Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
    while child.try_wait().unwrap().is_none() && asked.elapsed() < Duration::from_secs(5) {
        std::thread::sleep(Duration::from_millis(10));
    }
    let ended = child.try_wait().unwrap();
    let _ = child.kill();
    assert_eq!(ended.and_then(|status| status.code()), Some(130));

    let mut full = Command::new(env!("CARGO_BIN_EXE_clangor"));
    let device = fs::File::options().write(true).open("/dev/full").unwrap();
    let output = full.args(["inspect", "sphere:0.01"]).stdout(Stdio::from(device)).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("cannot write to standard output"), "{message}");
}

#[test]
fn mistakes_that_a_solver_or_room_finds_have_a_line() {
    let two = format!("{LISTENER}{}{}", ball(0, "steel", 0.0), ball(1, "steel", 0.005));
    refused("overlap", &two, &["scene.toml:9:1", "\"b0\" and \"b1\" overlap"]);
    let boxes = two.replace("sphere:0.01", "box:0.02x0.02x0.02");
    refused("overlapping boxes", &boxes, &["scene.toml:9:1", "\"b0\" and \"b1\" overlap"]);
    let mut room =
        String::from("version = 1\n[room]\nlowest = [-1, 0, -1]\nhighest = [1, 2, 1]\nabsorption = 0\n");
    let _ = write!(room, "[[listener]]\nposition = [0, 1, 0]\n{}", ball(0, "steel", 0.0));
    refused("room", &room, &["scene.toml:5:14", "absorb nothing", "late = false"]);
}

#[test]
fn names_that_are_no_text_and_outputs_that_are_inputs() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let scene = format!("{LISTENER}{}[simulation]\nduration = 0.05\n", ball(0, "steel", 0.0));
    let name = OsStr::from_bytes(b"a\xff.toml");
    fs::write(folder.path().join(name), &scene).unwrap();
    let succeeds = |arguments: &[&OsStr]| {
        let output = Command::new(env!("CARGO_BIN_EXE_clangor"))
            .args(["--cache", "cache"])
            .args(arguments)
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    };
    let word = OsStr::new;
    succeeds(&[word("--json"), word("inspect"), name]);
    // A cube of 2 cm.
    let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { "0.01" } else { "-0.01" }).join(" ");
    let vertices: String = (0..8).map(|k| format!("v {}\n", corner(k))).collect();
    let faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    let mesh = OsStr::from_bytes(b"cube\xff.obj");
    fs::write(folder.path().join(mesh), vertices + faces).unwrap();
    let [model, sound] = ["model.safetensors", "\u{fe}.wav"].map(word);
    succeeds(&[word("inspect"), mesh]);
    let band = ["--parts", "acceleration", "--max-frequency", "2000"].map(word);
    succeeds(&[&[word("bake"), mesh, word("-o"), model], &band[..]].concat());
    let strike =
        "--material steel --point 0.01,0,0 --impulse -0.01,0,0 --listener 1,0,0 --parts acceleration";
    let strike: Vec<&OsStr> = strike.split(' ').map(OsStr::new).collect();
    succeeds(&[&[word("strike"), mesh, word("-o"), sound], &strike[..]].concat());
    assert!(folder.path().join(sound).exists());
    fs::write(folder.path().join("scene.wav"), &scene).unwrap();
    let output = crate::program::run(folder.path(), &["render", "scene.wav"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("would replace what it is made of"));
    assert_eq!(fs::read_to_string(folder.path().join("scene.wav")).unwrap(), scene);
}

/// A clock that was set back finds files from its future, one that was wrong files from 1970.
#[test]
fn a_clock_that_was_set_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let coin = ball(0, "steel", 0.02).replace("sphere:0.01", "coin");
    let floor = "[[plane]]\nmaterial = \"granite\"\n";
    let scene = format!("{LISTENER}{coin}{floor}[simulation]\nduration = 0.4\n");
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let render =
        ["render", "scene.toml", "-o", "out.wav", "--max-frequency", "3000", "--parts", "acceleration"];
    crate::program::clangor(folder.path(), &render);
    let first = fs::read(folder.path().join("out.wav")).unwrap();
    let files = |folder: &Path| -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let mut files: Vec<PathBuf> = entries.filter(|path| path.is_file()).collect();
        files.sort();
        files
    };
    let kept = files(&folder.path().join("cache"));
    assert!(!kept.is_empty());
    let far = SystemTime::now() + Duration::from_secs(10 * 365 * 86_400);
    for time in [far, SystemTime::UNIX_EPOCH] {
        for path in kept.iter().cloned().chain(files(folder.path())) {
            File::options().write(true).open(path).unwrap().set_modified(time).unwrap();
        }
        crate::program::clangor(folder.path(), &render);
        assert!(fs::read(folder.path().join("out.wav")).unwrap() == first);
        assert_eq!(files(&folder.path().join("cache")), kept);
        // Entries of the cache are used, not written again.
        assert!(kept.iter().all(|path| fs::metadata(path).unwrap().modified().unwrap() == time));
    }
}

#[test]
fn a_mesh_outside_the_folder_of_its_scene_is_named() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("scene")).unwrap();
    let tetrahedron = "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    fs::write(folder.path().join("a.obj"), tetrahedron).unwrap();
    let body = ball(0, "steel", 0.0).replace("shape = \"sphere:0.01\"", "mesh = \"../a.obj\"");
    fs::write(folder.path().join("scene/scene.toml"), format!("{LISTENER}{body}")).unwrap();
    let output = crate::program::run(folder.path(), &["check", "scene/scene.toml"]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    assert!(message.contains("../a.obj lies outside the folder of the scene"), "{message}");
}

#[test]
fn leftovers_of_killed_runs_go_and_the_comment_names_no_folder() {
    let folder = tempfile::tempdir().unwrap();
    let scene = format!("{LISTENER}{}[simulation]\nduration = 0.05\n", ball(0, "steel", 0.0));
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let leftovers = ["out.wav.part-0123456789abcdef", "out.wav.part-1-0"];
    leftovers.iter().for_each(|name| fs::write(folder.path().join(name), "half").unwrap());
    let path = folder.path().join("scene.toml");
    crate::program::clangor(folder.path(), &["render", path.to_str().unwrap(), "-o", "out.wav"]);
    assert!(!folder.path().join(leftovers[0]).exists());
    // Not a name of ours.
    assert!(folder.path().join(leftovers[1]).exists());
    let sound = fs::read(folder.path().join("out.wav")).unwrap();
    let has = |text: &str| sound.windows(text.len()).any(|window| window == text.as_bytes());
    assert!(has("scene.toml") && !has(folder.path().to_str().unwrap()));
}
