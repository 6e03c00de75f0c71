//! The order of modules in ARCHITECTURE.md, and what the runtime library must not touch, hold in the sources.

use std::fs;
use std::path::{Path, PathBuf};

/// Each module of `clangor` and the modules it may import.
const MAY_IMPORT: &[(&str, &[&str])] = &[
    ("medium", &[]),
    ("material", &[]),
    ("pose", &[]),
    ("math", &[]),
    ("room", &[]),
    ("geometry", &["math"]),
    ("body", &["geometry", "material", "pose"]),
    ("shape", &["body", "geometry", "math"]),
    ("timeline", &["body"]),
    ("model", &["geometry", "math", "medium"]),
    ("contact", &["body", "geometry", "material", "math", "pose", "timeline"]),
    ("synthesis", &["body", "contact", "material", "math", "medium", "model", "pose", "room", "timeline"]),
    (
        "scene",
        &[
            "body",
            "contact",
            "geometry",
            "material",
            "math",
            "medium",
            "model",
            "pose",
            "room",
            "shape",
            "synthesis",
        ],
    ),
    ("output", &["math", "scene"]),
    ("realtime", &["body", "contact", "material", "medium", "model", "pose", "room", "scene", "synthesis"]),
];

/// What only the pipeline and the program may use.
const FOREIGN: &[&str] =
    &["std::fs", "std::thread", "std::time", "std::net", "std::process", "rayon", "println!"];

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a source folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Lines of code: comments are free to name anything.
fn code(path: &Path) -> Vec<String> {
    let text = fs::read_to_string(path).expect("a source file");
    text.lines().map(|l| l.split("//").next().unwrap_or("").to_string()).collect()
}

fn modules_in(line: &str) -> impl Iterator<Item = &str> {
    line.split("crate::")
        .skip(1)
        .map(|rest| rest.split(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or(""))
}

#[test]
fn modules_import_only_what_comes_before_them() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut imports = 0;
    for path in sources(&root) {
        let relative = path.strip_prefix(&root).unwrap();
        let first = relative.components().next().unwrap().as_os_str().to_string_lossy().into_owned();
        let module = first.trim_end_matches(".rs");
        if module == "lib" {
            continue;
        }
        let (_, allowed) = MAY_IMPORT.iter().find(|(name, _)| *name == module).unwrap_or_else(|| {
            panic!("module {module} has no place in the order: add it here and in ARCHITECTURE.md")
        });
        for (number, line) in code(&path).iter().enumerate() {
            for import in modules_in(line) {
                imports += 1;
                assert!(
                    import == module || allowed.contains(&import),
                    "{}:{}: {module} must not import {import}",
                    relative.display(),
                    number + 1
                );
            }
        }
    }
    assert!(imports > 100, "only {imports} imports were found: does the scan still work?");
}

#[test]
fn the_runtime_library_has_no_files_threads_or_clock() {
    for path in sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src")) {
        for (number, line) in code(&path).iter().enumerate() {
            for word in FOREIGN {
                assert!(!line.contains(word), "{}:{}: {word}", path.display(), number + 1);
            }
        }
    }
}

#[test]
fn dynamics_knows_nothing_of_sound() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../clangor-sim/src");
    for path in sources(&root) {
        let breaks = path.components().any(|c| c.as_os_str() == "fracture" || c.as_os_str() == "fracture.rs");
        let lives = path.components().any(|c| c.as_os_str() == "live" || c.as_os_str() == "live.rs");
        for (number, line) in code(&path).iter().enumerate() {
            for module in [
                "clangor_core::synthesis",
                "clangor_core::contact",
                "clangor_core::sound_model",
                "clangor_core::output",
            ] {
                // How hard an impact presses, and for how long, decides what breaks as well as how it sounds;
                // a live world hands its impacts out as such.
                let pressed = module == "clangor_core::contact" && (breaks || lives);
                assert!(pressed || !line.contains(module), "{}:{}: {module}", path.display(), number + 1);
            }
            let foreign =
                if path.components().any(|c| c.as_os_str() == "rigid") { "spheres::" } else { "rigid::" };
            // What breaks moves in steps of time.
            let above = path.ends_with("src/lib.rs") || breaks;
            assert!(above || !line.contains(&format!("crate::{foreign}")), "{}: solvers mix", path.display());
        }
    }
}
