//! The order of modules in ARCHITECTURE.md, and what the runtime library must not touch, hold in the sources.

use std::fs;
use std::path::{Path, PathBuf};

/// Each module of `clangor-core` and the modules it may import.
const MAY_IMPORT: &[(&str, &[&str])] = &[
    ("medium", &[]),
    ("material", &[]),
    ("pose", &[]),
    ("math", &[]),
    ("propagation", &[]),
    ("acoustics", &["medium", "propagation"]),
    ("geometry", &["math"]),
    ("quantity", &[]),
    ("body", &["geometry", "material", "pose"]),
    ("shape", &["body", "geometry", "math"]),
    ("timeline", &["body"]),
    ("sound_model", &["body", "geometry", "math", "medium", "quantity"]),
    ("contact", &["body", "geometry", "material", "math", "pose", "quantity", "timeline"]),
    (
        "synthesis",
        &[
            "acoustics",
            "body",
            "contact",
            "material",
            "math",
            "medium",
            "pose",
            "propagation",
            "quantity",
            "reference",
            "sound_model",
            "timeline",
        ],
    ),
    ("reference", &["body", "geometry", "material", "math", "medium", "sound_model", "synthesis"]),
    (
        "scene",
        &[
            "acoustics",
            "body",
            "contact",
            "geometry",
            "material",
            "math",
            "medium",
            "pose",
            "propagation",
            "quantity",
            "shape",
            "sound_model",
            "synthesis",
        ],
    ),
    ("output", &["math", "scene"]),
    (
        "realtime",
        &[
            "acoustics",
            "body",
            "contact",
            "material",
            "medium",
            "pose",
            "propagation",
            "scene",
            "sound_model",
            "synthesis",
        ],
    ),
];

/// The files of the main path that name the papers' forms, each for one variant or its evaluation.
const AT_THE_DOOR: &[&str] = &[
    "synthesis/ground/model.rs",
    "synthesis/modal/resonator_bank.rs",
    "synthesis/modal/transfer.rs",
    "synthesis/offline/renderer.rs",
    "synthesis/received_wave.rs",
    "synthesis/source.rs",
    "synthesis/synthesis_error.rs",
    "synthesis/wave.rs",
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
fn the_main_path_reaches_the_forms_of_the_papers_through_the_door_only() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let door = fs::read_to_string(root.join("reference.rs")).expect("the door");
    let inside: Vec<&str> = door
        .lines()
        .filter_map(|line| line.trim_start_matches("pub ").strip_prefix("mod ")?.strip_suffix(';'))
        .collect();
    assert!(inside.len() > 3, "only {inside:?} are behind the door: does the scan still work?");
    let mut named = Vec::new();
    for path in sources(&root) {
        let relative = path.strip_prefix(&root).unwrap().display().to_string().replace('\\', "/");
        if relative.starts_with("reference") {
            continue;
        }
        for (number, line) in code(&path).iter().enumerate() {
            let Some((_, rest)) = line.split_once("crate::reference::") else { continue };
            let passes = !inside.iter().any(|module| rest.starts_with(&format!("{module}::")));
            assert!(passes, "{relative}:{}: name what reference.rs exports, not where it is", number + 1);
            named.push(relative.clone());
        }
    }
    assert_eq!(named, AT_THE_DOOR);
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
fn dynamics_does_not_depend_on_sound() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../clangor-sim/src");
    for path in sources(&root) {
        let breaks = path.components().any(|c| c.as_os_str() == "fracture" || c.as_os_str() == "fracture.rs");
        for (number, line) in code(&path).iter().enumerate() {
            // The force of a contact moves bodies; what it sounds like is not known here.
            for module in ["clangor_core::synthesis", "clangor_core::sound_model", "clangor_core::output"] {
                assert!(!line.contains(module), "{}:{}: {module}", path.display(), number + 1);
            }
            let foreign =
                if path.components().any(|c| c.as_os_str() == "rigid") { "spheres::" } else { "rigid::" };
            // What breaks moves in steps of time.
            let above = path.ends_with("src/lib.rs") || breaks;
            assert!(above || !line.contains(&format!("crate::{foreign}")), "{}: solvers mix", path.display());
        }
    }
}
