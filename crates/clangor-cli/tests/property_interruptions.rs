//! Runs that are killed at any instant, and runs on full, bounded or read-only disks and in bare
//! surroundings: every file is the old one or the new one, the next run gives the same bits, and nothing is
//! left over.
#![cfg(target_os = "linux")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

const SCENE: &str = "version = 1\n[simulation]\nduration = 0.4\n[[body]]\nname = \"die\"\n\
                     shape = \"box:0.016x0.016x0.016\"\nmaterial = \"steel\"\nposition = [0, 0.1, 0]\n\
                     [[plane]]\nmaterial = \"wood\"\n[[listener]]\nposition = [0, 0.5, 0.5]\n";

/// Commands that write, the file or folder that each writes, and how to write an older one before.
const WRITERS: [(&str, &str, &str); 4] = [
    (
        "bake coin --max-frequency 4000 -o m.safetensors",
        "m.safetensors",
        "bake coin --max-frequency 3000 -o m.safetensors",
    ),
    (
        "simulate drop.toml --force -o d.timeline",
        "d.timeline",
        "simulate drop.toml --force --duration 0.2 -o d.timeline",
    ),
    (
        "render drop.toml --quality draft -o d.wav",
        "d.wav",
        "render drop.toml --quality draft --duration 0.2 -o d.wav",
    ),
    ("export gltf source.timeline -o d.glb", "d.glb", "export gltf short.timeline -o d.glb"),
];

/// Every file below a folder, with its bytes.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        if next.is_file() {
            found.insert(next.strip_prefix(folder).unwrap().to_owned(), fs::read(&next).unwrap());
        } else if let Ok(entries) = fs::read_dir(&next) {
            open.extend(entries.map(|entry| entry.unwrap().path()));
        }
    }
    found
}

/// Files that no finished run leaves: temporary ones, and parts of a bake.
fn leftovers(folder: &Path) -> Vec<PathBuf> {
    let temporary = |path: &PathBuf| {
        let name = path.to_string_lossy();
        name.contains(".part-") || name.ends_with(".partial")
    };
    files(folder).into_keys().filter(temporary).collect()
}

fn command(folder: &Path, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_clangor"));
    command.args(line.split(' ')).current_dir(folder).env("CLANGOR_CACHE", folder.join("cache"));
    command
}

fn run(folder: &Path, line: &str) {
    let output = command(folder, line).output().unwrap();
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
}

/// The same in a process namespace of its own, as in a container.
fn contained(folder: &Path, line: &str) -> Child {
    Command::new("unshare")
        .args(["--pid", "--fork", "--kill-child", env!("CARGO_BIN_EXE_clangor")])
        .args(line.split(' '))
        .current_dir(folder)
        .env("CLANGOR_CACHE", folder.join("cache"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

fn namespaces_are_permitted() -> bool {
    let tried = Command::new("unshare").args(["--pid", "--fork", "true"]).stderr(Stdio::null()).status();
    tried.is_ok_and(|status| status.success())
}

fn prepared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("drop.toml"), SCENE).unwrap();
    run(folder.path(), "simulate drop.toml -o source.timeline");
    run(folder.path(), "simulate drop.toml --duration 0.2 -o short.timeline");
    folder
}

/// What a command writes, by file.
fn written(folder: &Path, name: &str) -> BTreeMap<PathBuf, Vec<u8>> {
    let path = folder.join(name);
    if path.is_file() { [(PathBuf::from(name), fs::read(&path).unwrap())].into() } else { files(&path) }
}

/// Two containers write to one cache and one output, and both are killed. `CLANGOR_KILLS` is the number of
/// instants, over the four commands, and `CLANGOR_KILLS_SEED` chooses others.
#[test]
#[ignore = "seconds for each instant"]
fn kills_at_any_instant_leave_the_old_file_or_the_new_one() {
    if !namespaces_are_permitted() {
        println!("left out: process namespaces are not permitted here");
        return;
    }
    let number = |name: &str, default: u32| std::env::var(name).map_or(default, |text| text.parse().unwrap());
    let (kills, seed) = (number("CLANGOR_KILLS", 8), number("CLANGOR_KILLS_SEED", 1));
    let folder = prepared();
    let folder = folder.path();
    let mut random = u64::from(seed).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mut fraction = || {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        (random >> 11) as f64 / (1_u64 << 53) as f64
    };
    let (mut old_files, mut new_files, mut absent) = (0, 0, 0);
    for (line, name, older) in WRITERS {
        let cold = || drop(fs::remove_dir_all(folder.join("cache")));
        cold();
        run(folder, older);
        let old = written(folder, name);
        cold();
        let start = Instant::now();
        run(folder, line);
        let whole = start.elapsed();
        let (new, cache) = (written(folder, name), files(&folder.join("cache")));
        assert!(old != new, "{line}");
        for kill in 0..kills.div_ceil(WRITERS.len() as u32) {
            // A cold cache every other time; a warm one ends sooner.
            if kill % 2 == 0 {
                cold();
            }
            run(folder, older);
            if kill % 2 == 0 {
                cold();
            }
            let mut both = [contained(folder, line), contained(folder, line)];
            for child in &mut both {
                thread::sleep(Duration::from_secs_f64(whole.as_secs_f64() * 0.7 * fraction()));
                let _ = child.kill();
            }
            for child in &mut both {
                child.wait().unwrap();
            }
            // The children of the killed namespaces die a moment later.
            thread::sleep(Duration::from_millis(50));
            let found = written(folder, name);
            match found {
                found if found == old => old_files += 1,
                found if found == new => new_files += 1,
                found if found.is_empty() && name.ends_with(".timeline") => absent += 1,
                found => panic!("{line}, kill {kill}: neither the old nor the new: {:?}", found.keys()),
            }
            run(folder, line);
            assert!(written(folder, name) == new, "{line}, kill {kill}: other bits after it");
            if kill % 2 == 0 {
                let after = files(&folder.join("cache"));
                let names = || (after.keys(), cache.keys());
                assert!(after == cache, "{line}, kill {kill}: another cache after it: {:?}", names());
            }
            assert_eq!(leftovers(folder), Vec::<PathBuf>::new(), "{line}, kill {kill}");
        }
    }
    println!("{old_files} old, {new_files} new, {absent} between the two names of a folder");
}

/// A run in a shell, after `limits`, in which `$0` is the program.
fn in_shell(folder: &Path, before: &str, line: &str) -> Output {
    Command::new("sh")
        .args(["-c", &format!("{before} exec \"$0\" \"$@\""), env!("CARGO_BIN_EXE_clangor")])
        .args(line.split(' '))
        .current_dir(folder)
        .env("CLANGOR_CACHE", folder.join("cache"))
        .output()
        .unwrap()
}

/// A result, or a message and what was there before.
fn whole_or_said(
    folder: &Path,
    case: &str,
    line: &str,
    (name, old): (&str, &BTreeMap<PathBuf, Vec<u8>>),
    output: &Output,
) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(!message.contains("panicked"), "{case}: {line}: {message}");
    if !output.status.success() {
        assert!(message.contains("error"), "{case}: {line}: {:?} {message}", output.status);
        assert!(&written(folder, name) == old, "{case}: {line}: half-written");
        assert_eq!(leftovers(folder), Vec::<PathBuf>::new(), "{case}: {line}");
    }
}

#[test]
fn a_bound_on_the_size_of_files_leaves_what_was_there() {
    let folder = prepared();
    let mut refused = 0;
    for (line, name, older) in WRITERS {
        run(folder.path(), older);
        let old = written(folder.path(), name);
        // Blocks of 512 bytes: less than any of the outputs.
        let output = in_shell(folder.path(), "trap '' XFSZ; ulimit -f 8;", line);
        whole_or_said(folder.path(), "ulimit -f", line, (name, &old), &output);
        refused += u32::from(!output.status.success());
    }
    assert!(refused >= 3, "{refused}");
}

#[test]
fn a_folder_that_cannot_be_written_leaves_what_was_there() {
    let folder = prepared();
    let path = folder.path();
    // Root writes anywhere, so the output lies where no folder can be.
    for (line, name, _) in WRITERS {
        let line = line.replace(&format!("-o {name}"), &format!("-o /proc/{name}"));
        let output = in_shell(path, "", &line);
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && message.contains(name), "{line}: {message}");
    }
    // A cache that cannot be written costs time, and no result.
    let output = in_shell(path, "CLANGOR_CACHE=/proc/none; export CLANGOR_CACHE;", WRITERS[2].0);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(path.join("d.wav").is_file());
}

#[test]
fn a_full_disk_leaves_what_was_there() {
    let folder = prepared();
    let mount = folder.path().join("small");
    fs::create_dir(&mount).unwrap();
    let script = "mount -t tmpfs -o size=96k none small 2>/dev/null || exit 99; cd small || exit 98;";
    for (line, name, older) in WRITERS {
        let older = older.replace("drop.toml", "../drop.toml").replace("short.timeline", "../short.timeline");
        let line = line.replace("drop.toml", "../drop.toml").replace("source.timeline", "../source.timeline");
        // The mount lives as long as the shell's namespace; the listing is taken in it.
        let shell = format!(
            "{script} \"$0\" {older} >/dev/null 2>&1; cksum {name} {name}/* 2>/dev/null >../before; \
             head -c 100000 /dev/zero >filler 2>/dev/null; \
             \"$0\" {line} >/dev/null 2>../message; echo $? >../status; \
             rm -f filler; cksum {name} {name}/* 2>/dev/null >../after; ls -A >../list"
        );
        let output = Command::new("unshare")
            .args(["--mount", "sh", "-c", &shell, env!("CARGO_BIN_EXE_clangor")])
            .current_dir(folder.path())
            .env("CLANGOR_CACHE", folder.path().join("cache"))
            .output();
        if !output.is_ok_and(|output| output.status.success()) {
            println!("left out: mounting is not permitted here");
            return;
        }
        let read = |file: &str| fs::read_to_string(folder.path().join(file)).unwrap();
        let (status, message) = (read("status"), read("message"));
        assert!(!message.contains("panicked"), "{line}: {message}");
        if status.trim() != "0" {
            assert!(message.contains("error"), "{line}: {message}");
            assert_eq!(read("before"), read("after"), "{line}: half-written");
        }
        assert!(!read("list").contains(".part-"), "{line}: {}", read("list"));
    }
}

#[test]
fn bare_surroundings_give_a_result_or_a_message() {
    let folder = prepared();
    for (line, name, _) in WRITERS {
        let output = Command::new(env!("CARGO_BIN_EXE_clangor"))
            .args(line.split(' '))
            .current_dir(folder.path())
            .env_clear()
            .output()
            .unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{line}: {message}");
        assert!(!written(folder.path(), name).is_empty());
    }
}
